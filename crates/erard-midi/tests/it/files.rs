//! Files as they are.

use erard_midi::file::{Note, PedalChange, Piece, ReadError, Remarks, WriteError, read, write};
use erard_midi::{Resolution, Velocity};

use crate::bytes::{END, METRICAL, smf, track};

#[test]
fn what_is_written_is_read() {
    let note = |key, start_s, end_s, counts, release: Option<f64>| Note {
        key,
        start_s,
        end_s,
        velocity: Velocity::new(counts),
        release: release.map(Velocity::new),
    };
    let piece = Piece {
        notes: vec![
            note(40, 0.0, 0.5, 77.5, None),
            note(44, 0.0, 0.25, 60.0, Some(100.25)),
            note(1, 0.25, 1.0, 1.0, Some(1.0)),
            note(40, 0.5, 0.75, 127.0, None),
        ],
        pedals: vec![
            PedalChange { time_s: 0.1, controller: 64, value: 127 },
            PedalChange { time_s: 0.4, controller: 67, value: 3 },
        ],
        remarks: Remarks::default(),
    };
    let fine = read(&write(&piece, Resolution::FourteenBits).unwrap()).unwrap();
    assert_eq!((&fine.notes, &fine.pedals, fine.remarks.lines().len()), (&piece.notes, &piece.pedals, 0));
    // Seven bits round.
    let coarse = read(&write(&piece, Resolution::SevenBits).unwrap()).unwrap();
    assert_eq!(coarse.notes[0].velocity.counts(), 78.0);
    assert_eq!(coarse.duration_s(), 1.0);
}

#[test]
fn tempo_changes_and_time_code() {
    // A quarter note at 120 a minute, one at 60, then the note: 0.5 + 1 s.
    let tempo = track(&[0x83, 0x60, 0xFF, 0x51, 3, 0x0F, 0x42, 0x40]);
    let notes = track(&[0x87, 0x40, 0x90, 60, 64, 0x83, 0x60, 0x80, 60, 20]);
    let piece = read(&smf(1, METRICAL, &[&tempo, &notes])).unwrap();
    assert_eq!((piece.notes[0].start_s, piece.notes[0].end_s), (1.5, 2.5));
    assert_eq!(piece.notes[0].release, Some(Velocity::new(20.0)));
    // 25 frames a second of 40 ticks: milliseconds.
    let piece = read(&smf(0, [0xE7, 40], &[&track(&[0x87, 0x68, 0x90, 60, 64, 10, 0x90, 60, 0])])).unwrap();
    assert!((piece.notes[0].start_s - 1.0).abs() < 1e-12 && (piece.notes[0].end_s - 1.01).abs() < 1e-12);
}

#[test]
fn note_offs_of_0_and_64_say_nothing() {
    for (end, release) in [
        ([0x80, 60, 0], None),
        ([0x80, 60, 64], None),
        ([0x90, 60, 0], None),
        ([0x80, 60, 63], Some(Velocity::new(63.0))),
    ] {
        let events = [&[0, 0x90, 60, 64, 10][..], &end].concat();
        assert_eq!(read(&smf(0, METRICAL, &[&track(&events)])).unwrap().notes[0].release, release, "{end:?}");
    }
}

/// A controller 88 belongs to the note right after it on its channel, and to no other.
#[test]
fn the_prefix_belongs_to_one_note() {
    let played = |events: &[u8]| -> Vec<f64> {
        let piece = read(&smf(0, METRICAL, &[&track(events)])).unwrap();
        piece.notes.iter().map(|note| note.velocity.counts()).collect()
    };
    let ends = [10, 0x80, 60, 0, 0, 0x80, 61, 0];
    let with = |events: &[u8]| played(&[events, &ends].concat());
    assert_eq!(with(&[0, 0xB0, 88, 64, 0, 0x90, 60, 77, 0, 0x90, 61, 77]), [77.5, 77.0]);
    assert_eq!(with(&[0, 0xB0, 88, 64, 0, 0xB0, 1, 0, 0, 0x90, 60, 77]), [77.0], "something came between");
    assert_eq!(with(&[0, 0xB1, 88, 64, 0, 0x90, 60, 77]), [77.0], "another channel");
}

/// Two tracks on one key: struck again, and held until the last lets go.
#[test]
fn a_key_of_two_tracks() {
    let one = track(&[0, 0x90, 60, 64, 40, 0x80, 60, 0]);
    let two = track(&[10, 0x90, 60, 80, 10, 0x80, 60, 0]);
    let piece = read(&smf(1, METRICAL, &[&one, &two])).unwrap();
    let tick_s = 0.5 / 480.0;
    let ends: Vec<[f64; 2]> = piece.notes.iter().map(|note| [note.start_s, note.end_s].map(|s| s / tick_s)).collect();
    for (found, expected) in ends.iter().flatten().zip([0.0, 10.0, 10.0, 40.0]) {
        assert!((found - expected).abs() < 1e-9, "{ends:?}");
    }
}

#[test]
fn what_no_piano_plays_is_left_out_and_said() {
    let events = [0, 0x99, 36, 100, 0, 0x90, 20, 64, 0, 0x90, 60, 64, 0, 0x90, 61, 64, 0, 0x80, 61, 0, 48, 0xC0, 3];
    let piece = read(&smf(0, METRICAL, &[&events])).unwrap();
    assert_eq!(piece.notes.len(), 1);
    assert!((piece.notes[0].end_s - 0.05).abs() < 1e-12, "held to the last event");
    let said = piece.remarks.lines().join("; ");
    for what in ["percussion", "beyond the keyboard", "without an end", "ends as it begins", "track 1 breaks off"] {
        assert!(said.contains(what), "{what}: {said}");
    }
}

#[test]
fn what_is_no_piece_is_refused() {
    let said = |bytes: &[u8]| read(bytes).unwrap_err().to_string();
    assert!(said(b"").contains("not a readable Standard MIDI File"));
    assert!(said(b"RIFF....WAVE").contains("not a readable Standard MIDI File"));
    assert_eq!(read(&smf(2, METRICAL, &[&END, &END])).unwrap_err(), ReadError::Sequences(2));
    assert_eq!(read(&smf(0, [0, 0], &[&END])).unwrap_err(), ReadError::NoTime);
    assert_eq!(read(&smf(0, [0xE7, 0], &[&END])).unwrap_err(), ReadError::NoTime);
    assert!(said(&vec![0; (16 << 20) + 1]).contains("at most 16777216 are read"));
    assert_eq!(read(&smf(0, METRICAL, &[&END])).unwrap(), Piece::default());
}

#[test]
fn what_is_no_note_is_not_written() {
    let note = Note { key: 40, start_s: 0.0, end_s: 1.0, velocity: Velocity::new(64.0), release: None };
    let of = |note| write(&Piece { notes: vec![note], ..Piece::default() }, Resolution::SevenBits).map(|_| ());
    assert_eq!(of(Note { key: 0, ..note }), Err(WriteError::Note(0)));
    assert_eq!(of(Note { end_s: 0.0, ..note }), Err(WriteError::Note(0)));
    assert_eq!(of(Note { start_s: f64::NAN, ..note }), Err(WriteError::Note(0)));
    assert_eq!(of(Note { end_s: 20_000.0, ..note }), Err(WriteError::Silence(0.0)));
    let pedals = vec![PedalChange { time_s: -1.0, controller: 64, value: 0 }];
    assert_eq!(write(&Piece { pedals, ..Piece::default() }, Resolution::SevenBits), Err(WriteError::Pedal(0)));
}

/// Whatever the bytes, a reader ends and does not panic; instants are finite and ascend.
#[test]
fn damaged_files_are_read_or_refused() {
    let mut rng = fastrand::Rng::with_seed(88);
    let whole = {
        let mut events = vec![0, 0xFF, 0x51, 3, 0x07, 0xA1, 0x20];
        for note in 40..80 {
            events.extend([0, 0xB0, 88, note, 0, 0x90, note, 64, 20, 0xB0, 64, note, 30, 0x80, note, 30]);
        }
        smf(1, METRICAL, &[&track(&events), &track(&events[7..])])
    };
    let (mut read_well, mut refused) = (0, 0);
    for _ in 0..20_000 {
        let mut bytes = whole.clone();
        for _ in 0..1 + rng.usize(..4) {
            let at = rng.usize(..bytes.len());
            match rng.u8(..4) {
                0 => bytes[at] = rng.u8(..),
                1 => bytes[at] ^= 1 << rng.u8(..8),
                2 => bytes.truncate(at.max(1)),
                _ => bytes.insert(at, rng.u8(..)),
            }
        }
        match read(&bytes) {
            Ok(piece) => {
                read_well += 1;
                assert!(
                    piece.notes.iter().all(|n| n.start_s.is_finite() && n.end_s.is_finite() && n.start_s < n.end_s)
                );
                assert!(piece.notes.is_sorted_by(|a, b| a.start_s <= b.start_s));
                assert!(piece.pedals.is_sorted_by(|a, b| a.time_s <= b.time_s));
            }
            Err(_) => refused += 1,
        }
    }
    println!("{read_well} read, {refused} refused");
    assert!(read_well > 1000 && refused > 10);
}

/// The seeds of the fuzzer: what each is made to hold is found in it.
#[test]
fn the_seeds_of_the_fuzzer() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fuzz/seeds/midi");
    let seed = |name: &str| read(&std::fs::read(format!("{folder}/{name}")).unwrap());
    let counts =
        |name: &str| seed(name).map(|piece| [piece.notes.len(), piece.pedals.len(), piece.remarks.lines().len()]);
    let expected = [
        ("00", Ok([1, 0, 0])),                // running status, a note-off by velocity 0
        ("01", Ok([2, 0, 1])),                // one key on two tracks, two channels
        ("02", Ok([1, 0, 0])),                // time code
        ("03", Ok([2, 1, 1])),                // tempi, a note without end
        ("04", Ok([1, 4, 0])),                // velocity in 14 bits, three pedals
        ("05", Ok([0, 0, 2])),                // percussion, and a note below the keyboard
        ("06", Err(ReadError::Sequences(2))), // format 2
        ("07", Err(ReadError::NoTime)),       // no ticks
        ("08", Ok([1, 1, 2])),                // a track that breaks off, with a note
        ("09", Ok([1, 1, 1])),                // other messages, and the longest delta
    ];
    assert_eq!(expected.each_ref().map(|(name, _)| counts(name)), expected.each_ref().map(|(_, found)| found.clone()));
}

/// The most memory that is held while a file is read grows in proportion to the file.
#[test]
fn memory_is_linear_in_the_file() {
    let file = |notes: u32| {
        let of = |n| [0, 0x90, 21 + (n % 88) as u8, 64, 10, 0x80, 21 + (n % 88) as u8, 0];
        smf(0, METRICAL, &[&track(&(0..notes).flat_map(of).collect::<Vec<u8>>())])
    };
    let [a, b, c] = [10_000, 20_000, 40_000].map(|notes| {
        let bytes = file(notes);
        let held = allocation_counter::measure(|| {
            assert_eq!(read(&bytes).unwrap().notes.len(), notes as usize);
        });
        (bytes.len() as f64, held.bytes_max as f64)
    });
    let each = (c.1 - a.1) / (c.0 - a.0);
    println!("{a:?} {b:?} {c:?}: {each:.1} bytes for one");
    // Vectors grow by doubling: what is held may be twice what is used, and half of that once more while it is copied.
    assert!(each < 60.0, "{each:.1} bytes for one");
    assert!(c.1 - b.1 < 2.5 * (b.1 - a.1), "{a:?} {b:?} {c:?}");
}
