//! What other readers find in the same bytes.

use std::collections::BTreeMap;
use std::path::Path;

use erard_midi::file::{Note, PedalChange, Piece, Remarks, read, write};
use erard_midi::{Resolution, Velocity};
use midly::{MidiMessage, Smf, TrackEventKind};

use crate::not_run::not_run;

fn bits(velocity: Velocity) -> i64 {
    (128.0 * velocity.counts()).round() as i64
}

/// Key, beginning and end, us, velocity and release, as `second_reader.py` has them.
fn line(note: &Note) -> [i64; 5] {
    let us = |s: f64| (1e6 * s).round() as i64;
    [note.key as i64, us(note.start_s), us(note.end_s), bits(note.velocity), note.release.map_or(-1, bits)]
}

/// Files of every kind, and the notes that mido and a pairing of its own find: all agree, to a microsecond. Where two
/// channels let a key go in one tick the release is either's (`?`).
#[test]
fn generated_files_are_read_as_by_another() {
    let table = include_str!("../second-reader/generated.tsv");
    let mut kinds: BTreeMap<&str, [usize; 2]> = BTreeMap::new();
    for (number, row) in table.lines().enumerate().filter(|(_, row)| !row.starts_with('#')) {
        let fields: Vec<&str> = row.split('\t').collect();
        let [kind, hex, expected] = fields[..] else { panic!("line {}", number + 1) };
        let bytes: Vec<u8> =
            (0..hex.len()).step_by(2).map(|i| u8::from_str_radix(&hex[i..i + 2], 16).unwrap()).collect();
        let piece = read(&bytes).unwrap();
        let found: Vec<[i64; 5]> = piece.notes.iter().map(line).collect();
        let expected: Vec<Vec<&str>> = expected.split_terminator(' ').map(|note| note.split(',').collect()).collect();
        assert_eq!(found.len(), expected.len(), "line {} ({kind}): {found:?}", number + 1);
        for (found, expected) in found.iter().zip(&expected) {
            for (i, (found, expected)) in found.iter().zip(expected).enumerate() {
                let is_near = |expected: i64| (found - expected).abs() <= i64::from(i == 1 || i == 2);
                assert!(
                    *expected == "?" || is_near(expected.parse().unwrap()),
                    "line {} ({kind}): {found} {expected}",
                    number + 1
                );
            }
        }
        let count = kinds.entry(kind).or_default();
        *count = [count[0] + 1, count[1] + found.len()];
    }
    println!("{kinds:?}");
    assert!(kinds.len() == 13 && kinds.values().all(|[files, notes]| *files == 15 && *notes > 10), "{kinds:?}");
}

/// The MIDI files that public packages ship, where a folder has them (`ERARD_MIDI_PACKAGES`, with the files of the
/// table under the names that their digests are): as many notes as when the table was made.
#[test]
fn files_of_packages_have_as_many_notes_as_they_had() {
    let Some(folder) = std::env::var_os("ERARD_MIDI_PACKAGES") else {
        not_run("needs the MIDI files of tests/second-reader/packages.tsv in the folder ERARD_MIDI_PACKAGES");
        return;
    };
    let table = include_str!("../second-reader/packages.tsv");
    let mut seen = 0;
    for row in table.lines().skip(1) {
        let fields: Vec<&str> = row.split('\t').collect();
        let [_, name, digest, _, notes, ..] = fields[..] else { panic!("{row}") };
        let Ok(bytes) = std::fs::read(Path::new(&folder).join(digest)) else { continue };
        let found = read(&bytes).map_or(String::new(), |piece| piece.notes.len().to_string());
        assert_eq!(found, notes, "{name}");
        seen += 1;
    }
    assert!(seen > 0, "no file of the table is in ERARD_MIDI_PACKAGES");
}

/// What is written is what midly reads: the tempo, a channel, notes and pedals in ticks of 1/20 ms.
#[test]
fn another_reader_reads_what_is_written() {
    let mut rng = fastrand::Rng::with_seed(61);
    for resolution in [Resolution::SevenBits, Resolution::FourteenBits] {
        let mut now_s = 0.0;
        let notes: Vec<Note> = (0..300)
            .map(|_| {
                // From nothing to a pause of eight minutes: delays of one to four bytes.
                now_s += [0.0, 2e-3, 0.3, 40.0, 500.0][rng.usize(..5)] * rng.f64();
                let velocity = Velocity::new(1.0 + 126.0 * rng.f64());
                Note { key: rng.usize(1..=88), start_s: now_s, end_s: now_s + 1.0, velocity, release: None }
            })
            .collect();
        let pedals = vec![PedalChange { time_s: 1.0, controller: 64, value: 99 }];
        let piece = Piece { notes, pedals, remarks: Remarks::default() };
        let bytes = write(&piece, resolution).unwrap();
        let file = Smf::parse(&bytes).unwrap();
        let (mut tick, mut below, mut ons, mut feet) = (0_u64, 0, Vec::new(), Vec::new());
        for event in &file.tracks[0] {
            tick += u64::from(event.delta.as_int());
            let TrackEventKind::Midi { message, .. } = event.kind else { continue };
            match message {
                MidiMessage::NoteOn { key, vel } => {
                    ons.push((tick, usize::from(key.as_int()) - 20, u16::from(vel.as_int()) << 7 | below));
                    below = 0;
                }
                MidiMessage::NoteOff { .. } => below = 0,
                MidiMessage::Controller { controller, value } if controller == 88 => below = u16::from(value.as_int()),
                MidiMessage::Controller { controller, value } => feet.push((tick, controller.as_int(), value.as_int())),
                _ => {}
            }
        }
        let expected = piece.notes.iter().map(|note| {
            let velocity = match resolution {
                Resolution::SevenBits => u16::from(note.velocity.seven_bits()) << 7,
                Resolution::FourteenBits => note.velocity.fourteen_bits(),
            };
            ((2e4 * note.start_s).round() as u64, note.key, velocity)
        });
        assert_eq!(ons, expected.collect::<Vec<_>>());
        assert_eq!(feet, [(20_000, 64, 99)]);
    }
}
