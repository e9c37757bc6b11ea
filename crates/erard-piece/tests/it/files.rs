//! The pieces that come with the program are what the example writes.

use erard_midi::Resolution;

#[path = "../../examples/pieces.rs"]
mod pieces;

#[test]
fn the_files_are_those_of_the_example() {
    for (name, piece) in pieces::pieces() {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("pieces").join(name);
        let bytes = erard_midi::file::write(&piece, Resolution::SevenBits).unwrap();
        assert_eq!(std::fs::read(path).unwrap(), bytes, "{name}: run the example `pieces`");
        assert!(piece.notes.len() > 70 && piece.duration_s() < 60.0);
    }
}
