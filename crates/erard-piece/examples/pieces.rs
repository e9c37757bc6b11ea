//! Writes the pieces that come with the program, `pieces/*.mid`, into a folder: `.ci/regenerate pieces`.
//!
//! Both composers died more than 70 years ago: the pieces are in the public domain. No edition was copied; the notes
//! were written down here, from memory, as numbers.

use erard_midi::file::{Note, PedalChange, Piece, write};
use erard_midi::message::SUSTAIN;
use erard_midi::{Resolution, Velocity, key_of_note};

/// Names of the files, with what they hold.
pub fn pieces() -> [(&'static str, Piece); 2] {
    [("gymnopedie.mid", gymnopedie()), ("hanon.mid", hanon())]
}

/// Appends a note by its MIDI number.
fn add(piece: &mut Piece, note: u8, start_s: f64, end_s: f64, velocity: u8) {
    let key = key_of_note(note).expect("a note of the piano");
    piece.notes.push(Note { key, start_s, end_s, velocity: Velocity::of_seven_bits(velocity), release: None });
}

/// Erik Satie (1866-1925), Gymnopédie no. 1 (1888), bars 1 to 16: lent et douloureux, 72 crotchets a minute, the pedal
/// changed with every bass.
fn gymnopedie() -> Piece {
    let mut piece = Piece::default();
    let beat = 60.0 / 72.0;
    for bar in 0..16_u32 {
        let at = f64::from(3 * bar) * beat;
        let (bass, chord) = if bar % 2 == 0 { (43, [59, 62, 66]) } else { (38, [57, 61, 66]) };
        add(&mut piece, bass, at, at + 2.9 * beat, 44);
        for note in chord {
            add(&mut piece, note, at + beat, at + 2.9 * beat, 34);
        }
        piece.pedals.push(PedalChange { time_s: at + 0.12, controller: SUSTAIN, value: 127 });
        piece.pedals.push(PedalChange { time_s: at + 2.95 * beat, controller: SUSTAIN, value: 0 });
    }
    // Bar, beat, beats, note, velocity. The long F sharp is tied over bars 9 to 12.
    let melody: [(u32, u32, f64, u8, u8); 17] = [
        (4, 1, 1.0, 78, 54),
        (4, 2, 1.0, 81, 57),
        (5, 0, 1.0, 79, 57),
        (5, 1, 1.0, 78, 54),
        (5, 2, 1.0, 73, 50),
        (6, 0, 1.0, 71, 50),
        (6, 1, 1.0, 73, 52),
        (6, 2, 1.0, 74, 54),
        (7, 0, 3.0, 69, 50),
        (8, 0, 11.5, 66, 46),
        (12, 1, 1.0, 78, 54),
        (12, 2, 1.0, 81, 57),
        (13, 0, 1.0, 79, 57),
        (13, 1, 1.0, 78, 54),
        (13, 2, 1.0, 73, 50),
        (14, 0, 3.0, 71, 52),
        (15, 0, 2.9, 69, 46),
    ];
    for (bar, on, beats, note, velocity) in melody {
        let at = f64::from(3 * bar + on) * beat;
        // The left hand has the same F sharp; the melody takes it over.
        piece.notes.retain(|other| {
            key_of_note(note) != Some(other.key) || other.end_s <= at || other.start_s >= at + beats * beat
        });
        add(&mut piece, note, at, at + 0.97 * beats * beat, velocity);
    }
    sort(&mut piece);
    piece
}

/// Exercises after Charles-Louis Hanon (1819-1900), Le Pianiste virtuose (1873): repeated notes in groups of three (no.
/// 44), the trill (no. 46) and thirds (no. 50), the patterns of their beginnings, faster and faster up to what an
/// action can do.
fn hanon() -> Piece {
    let mut piece = Piece::default();
    let mut at = 0.5;
    // Repeated notes: C E F G A G F E, three times each, at 6 to 12 notes a second.
    for rate in [6.0, 8.0, 10.0, 12.0] {
        for note in [60, 64, 65, 67, 69, 67, 65, 64] {
            for again in 0..3_u8 {
                add(&mut piece, note, at, at + 0.5 / rate, 72 - 4 * again);
                at += 1.0 / rate;
            }
        }
        at += 0.4;
    }
    // Trills of whole tones, C D and G A, at 8 to 16 notes a second.
    for (rate, low) in [(8.0, 60), (12.0, 67), (16.0, 72)] {
        for n in 0..24_u8 {
            add(&mut piece, low + 2 * (n % 2), at, at + 0.9 / rate, 58 + n % 5);
            at += 1.0 / rate;
        }
        at += 0.4;
    }
    // Thirds of C major up and down, legato, at 6 to 10 a second.
    let scale = [60, 62, 64, 65, 67, 69, 71, 72, 74, 76];
    for rate in [6.0, 8.0, 10.0] {
        for n in (0..8).chain((1..7).rev()) {
            for note in [scale[n], scale[n + 2]] {
                add(&mut piece, note, at, at + 0.9 / rate, 66);
            }
            at += 1.0 / rate;
        }
        at += 0.4;
    }
    sort(&mut piece);
    piece
}

fn sort(piece: &mut Piece) {
    piece.notes.sort_by(|a, b| a.start_s.total_cmp(&b.start_s).then(a.key.cmp(&b.key)));
}

#[allow(dead_code, reason = "the tests use this file as a module")]
fn main() -> std::io::Result<()> {
    let folder = std::path::PathBuf::from(std::env::args_os().nth(1).expect("a folder as argument"));
    std::fs::create_dir_all(&folder)?;
    for (name, piece) in pieces() {
        let bytes = write(&piece, Resolution::SevenBits).map_err(std::io::Error::other)?;
        std::fs::write(folder.join(name), bytes)?;
    }
    Ok(())
}
