//! Prints the notes of a MIDI file, a line each: key, beginning and end, us, velocity and release, 14 bits (-1:
//! unknown). Remarks begin with `#`.
//!
//! ```sh
//! cargo run --release -p erard-midi --example notes -- piece.mid
//! ```

use std::process::ExitCode;

use erard_midi::Velocity;
use erard_midi::file::read;

fn main() -> ExitCode {
    let Some(path) = std::env::args().nth(1) else {
        eprintln!("expected a MIDI file");
        return ExitCode::from(2);
    };
    let piece = match std::fs::read(&path)
        .map_err(|error| error.to_string())
        .and_then(|bytes| read(&bytes).map_err(|error| error.to_string()))
    {
        Ok(piece) => piece,
        Err(what) => {
            eprintln!("{path}: {what}");
            return ExitCode::from(2);
        }
    };
    piece.remarks.lines().iter().for_each(|remark| println!("# {remark}"));
    let bits = |velocity: Velocity| (128.0 * velocity.counts()).round();
    for note in &piece.notes {
        let [start_us, end_us] = [note.start_s, note.end_s].map(|s| (1e6 * s).round());
        let release = note.release.map_or(-1.0, bits);
        println!("{},{start_us},{end_us},{},{release}", note.key, bits(note.velocity));
    }
    ExitCode::SUCCESS
}
