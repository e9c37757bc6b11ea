//! The pieces that come with the program are what the example writes.

use erard_midi::Resolution;

#[path = "../../examples/pieces.rs"]
mod pieces;

#[test]
fn the_files_are_those_of_the_example() {
    for (name, piece) in pieces::pieces() {
        let bytes = erard_midi::file::write(&piece, Resolution::SevenBits).unwrap();
        crate::generated::is_current(&format!("crates/erard-piece/pieces/{name}"), bytes, "pieces");
        assert!(piece.notes.len() > 70 && piece.duration_s() < 60.0);
    }
}
