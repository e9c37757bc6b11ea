//! Files as programs and instruments write them: what right is stands in each test.

use erard_midi::file::{Piece, ReadError, read};

use crate::bytes::{END, METRICAL, smf, track};

/// 500 ticks for a quarter note: a tick is a millisecond at 120 quarter notes a minute.
const MILLISECONDS: [u8; 2] = [0x01, 0xF4];

/// An event: instant, ms, and bytes.
type At<'a> = (u32, &'a [u8]);

/// A number of variable length.
fn length(number: u32) -> Vec<u8> {
    let sevens = [21, 14, 7, 0].map(|bits| (number >> bits & 0x7F) as u8);
    let first = sevens.iter().position(|seven| *seven > 0).unwrap_or(3);
    (first..4).map(|i| if i < 3 { sevens[i] | 0x80 } else { sevens[i] }).collect()
}

/// A track of events, without its end.
fn events(all: &[At<'_>]) -> Vec<u8> {
    let (mut now, mut bytes) = (0, Vec::new());
    for (at, event) in all {
        bytes.extend(length(at - now));
        bytes.extend(*event);
        now = *at;
    }
    bytes
}

fn one_track(all: &[At<'_>]) -> Piece {
    read(&smf(0, MILLISECONDS, &[&track(&events(all))])).unwrap()
}

fn two_tracks(one: &[At<'_>], two: &[At<'_>]) -> Piece {
    read(&smf(1, MILLISECONDS, &[&track(&events(one)), &track(&events(two))])).unwrap()
}

/// Notes: note number, beginning and end, ms, velocity.
fn notes(piece: &Piece) -> Vec<(usize, i64, i64, i64)> {
    let ms = |s: f64| (1e3 * s).round() as i64;
    let one = |note: &erard_midi::file::Note| {
        (note.key + 20, ms(note.start_s), ms(note.end_s), note.velocity.counts().round() as i64)
    };
    piece.notes.iter().map(one).collect()
}

/// Pedals: ms, controller, value.
fn pedals(piece: &Piece) -> Vec<(i64, u8, u8)> {
    piece.pedals.iter().map(|foot| ((1e3 * foot.time_s).round() as i64, foot.controller, foot.value)).collect()
}

fn said(piece: &Piece) -> String {
    piece.remarks.lines().join("\n")
}

/// A chord of two voices on one key: one strike, the louder, until the later voice lets go.
#[test]
fn two_voices_on_one_key_are_one_strike() {
    for loud_first in [true, false] {
        let (a, b): (&[u8], &[u8]) =
            if loud_first { (&[0x90, 60, 100], &[0x90, 60, 40]) } else { (&[0x90, 60, 40], &[0x90, 60, 100]) };
        let piece = two_tracks(&[(0, a), (400, &[0x80, 60, 7])], &[(0, b), (900, &[0x80, 60, 9])]);
        assert_eq!(notes(&piece), [(60, 0, 900, 100)]);
        assert_eq!(piece.notes[0].release.map(|release| release.counts()), Some(9.0), "the last to let go");
        assert!(said(&piece).contains("1 note at the instant of another of its key"), "{}", said(&piece));
        assert!(!said(&piece).contains("end as they begin"), "{}", said(&piece));
    }
    // On two channels, too.
    let piece =
        one_track(&[(0, &[0x90, 60, 40]), (0, &[0x91, 60, 100]), (300, &[0x91, 60, 0]), (500, &[0x80, 60, 64])]);
    assert_eq!(notes(&piece), [(60, 0, 500, 100)]);
}

/// A note-off ends what began before its instant, whether the file has it before or after the next note-on.
#[test]
fn the_order_within_an_instant_does_not_matter() {
    let (on, off): (&[u8], &[u8]) = (&[0x90, 60, 64], &[0x80, 60, 64]);
    for middle in [[(500, on), (500, off)], [(500, off), (500, on)]] {
        let piece = one_track(&[&[(0, on)][..], &middle, &[(1000, off)]].concat());
        assert_eq!(notes(&piece), [(60, 0, 500, 64), (60, 500, 1000, 64)]);
        assert_eq!(said(&piece), "");
    }
}

/// A key that is struck while it is held: a note ends where the next begins, and the last where all have let go.
#[test]
fn note_ons_are_counted_against_note_offs() {
    let (on, off): (&[u8], &[u8]) = (&[0x90, 60, 64], &[0x80, 60, 64]);
    let piece = one_track(&[(0, on), (200, on), (500, off), (900, off)]);
    assert_eq!(notes(&piece), [(60, 0, 200, 64), (60, 200, 900, 64)]);
    // One note-off is missing: the other ends what sounds, and does not leave the key down for ever.
    let piece = one_track(&[(0, on), (200, on), (500, off), (900, on), (1000, off)]);
    assert_eq!(notes(&piece), [(60, 0, 200, 64), (60, 200, 500, 64), (60, 900, 1000, 64)]);
    assert!(said(&piece).contains("1 note without an end"), "{}", said(&piece));
    // A note-off of another channel ends nothing.
    let piece = one_track(&[(0, on), (300, &[0x81, 60, 64]), (700, off)]);
    assert_eq!(notes(&piece), [(60, 0, 700, 64)]);
    // Two channels hold a key: the second strikes again, the last one lets go.
    let piece = one_track(&[(0, on), (200, &[0x91, 60, 80]), (300, off), (700, &[0x81, 60, 64])]);
    assert_eq!(notes(&piece), [(60, 0, 200, 64), (60, 200, 700, 80)]);
    // Its own note-off at its own instant: no note.
    let piece = one_track(&[(0, on), (0, off), (500, on), (700, off)]);
    assert_eq!(notes(&piece), [(60, 500, 700, 64)]);
    assert!(said(&piece).contains("1 note that ends as it begins, left out"), "{}", said(&piece));
}

/// A meta event is as long as it says, whatever it holds: the tempi after an SMPTE offset of 125 frames count, and so
/// do those after a key of 99 sharps or a time signature of one byte.
#[test]
fn events_of_known_length_are_skipped_by_it() {
    let bad: [&[u8]; 4] = [
        &[0xFF, 0x54, 5, 0x60, 0, 3, 125, 0],
        &[0xFF, 0x59, 2, 99, 9],
        &[0xFF, 0x58, 1, 4],
        &[0xF0, 3, 0x43, 0x12, 0xF7],
    ];
    for event in bad {
        // 60 quarter notes a minute: a tick is two milliseconds.
        let piece = two_tracks(
            &[(0, event), (0, &[0xFF, 0x51, 3, 0x0F, 0x42, 0x40])],
            &[(100, &[0x90, 60, 64]), (200, &[0x80, 60, 64])],
        );
        assert_eq!(notes(&piece), [(60, 200, 400, 64)], "{event:02X?}");
        assert_eq!(said(&piece), "");
    }
    // A tempo that no clock keeps is left out, and said.
    let piece = one_track(&[(0, &[0xFF, 0x51, 3, 0, 0, 0]), (100, &[0x90, 60, 64]), (200, &[0x80, 60, 64])]);
    assert_eq!(notes(&piece), [(60, 100, 200, 64)]);
    assert!(said(&piece).contains("tempo"), "{}", said(&piece));
}

/// All notes off, of one channel: its keys come up, and a pedal that is down keeps their dampers up.
#[test]
fn all_notes_off_lets_the_keys_of_a_channel_up() {
    let held: [At<'_>; 3] = [(0, &[0xB0, 64, 127]), (0, &[0x90, 60, 64]), (0, &[0x91, 62, 64])];
    for controller in [123, 124, 125, 126, 127] {
        let piece = one_track(&[&held[..], &[(1000, &[0xB0, controller, 0]), (20_000, &[0x81, 62, 0])]].concat());
        assert_eq!(notes(&piece), [(60, 0, 1000, 64), (62, 0, 20_000, 64)], "{controller}");
        assert_eq!(pedals(&piece), [(0, 64, 127)]);
        assert!(!said(&piece).contains("without an end"), "{}", said(&piece));
    }
    // Its late note-off ends nothing more, and not the next note either.
    let piece =
        one_track(&[(0, &[0x90, 60, 64]), (100, &[0xB0, 123, 0]), (200, &[0x90, 60, 64]), (900, &[0x80, 60, 0])]);
    assert_eq!(notes(&piece), [(60, 0, 100, 64), (60, 200, 900, 64)]);
    // In the instant of a note-on it ends only what began before.
    let piece =
        one_track(&[(0, &[0x90, 60, 64]), (500, &[0x90, 60, 64]), (500, &[0xB0, 123, 0]), (900, &[0x80, 60, 0])]);
    assert_eq!(notes(&piece), [(60, 0, 500, 64), (60, 500, 900, 64)]);
}

/// All sound off is silence at once: keys and pedals of the channel up. Controllers to their beginning: pedals up.
#[test]
fn all_sound_off_is_silence_and_a_reset_lets_the_pedals_up() {
    let begun: [At<'_>; 3] = [(0, &[0xB0, 64, 127]), (0, &[0xB0, 67, 127]), (0, &[0x90, 60, 64])];
    let piece = one_track(&[&begun[..], &[(1000, &[0xB0, 120, 0]), (3000, &[0x80, 60, 0])]].concat());
    assert_eq!(notes(&piece), [(60, 0, 1000, 64)]);
    assert_eq!(pedals(&piece), [(0, 64, 127), (0, 67, 127), (1000, 64, 0)], "the left pedal damps nothing");
    let piece = one_track(&[&begun[..], &[(1000, &[0xB0, 121, 0]), (3000, &[0x80, 60, 0])]].concat());
    assert_eq!(notes(&piece), [(60, 0, 3000, 64)]);
    assert_eq!(pedals(&piece), [(0, 64, 127), (0, 67, 127), (1000, 64, 0), (1000, 67, 0)]);
}

/// One piano has one pedal: it is where the channel is that presses it farthest. One remark names channels and
/// programs; a lone piano has none.
#[test]
fn channels_keep_their_pedals_apart() {
    let piece = one_track(&[
        (0, &[0xC1, 48]),
        (0, &[0x90, 60, 64]),
        (0, &[0x91, 72, 64]),
        (100, &[0xB0, 64, 127]),
        (200, &[0xB1, 64, 60]),
        (300, &[0xB0, 64, 0]),
        (400, &[0xB1, 64, 0]),
        (900, &[0x80, 60, 0]),
        (900, &[0x81, 72, 0]),
    ]);
    assert_eq!(pedals(&piece), [(100, 64, 127), (300, 64, 60), (400, 64, 0)]);
    let lines = piece.remarks.lines();
    assert!(lines.len() == 1, "{lines:?}");
    for part in ["channels 1, 2", "program 49", "one piano", "pedal"] {
        assert!(lines[0].contains(part), "{part}: {lines:?}");
    }
    let alone = one_track(&[(0, &[0xC0, 0]), (0, &[0xB0, 64, 127]), (0, &[0x90, 60, 64]), (9, &[0x80, 60, 0])]);
    assert_eq!(said(&alone), "");
    let organ = one_track(&[(0, &[0xC0, 19]), (0, &[0x90, 60, 64]), (9, &[0x80, 60, 0])]);
    assert!(said(&organ).contains("program 20"), "{}", said(&organ));
}

/// A bad byte costs the event that it is in. The loss is counted in notes, and the place is named.
#[test]
fn tracks_are_resynchronised() {
    let eight = |bad: &dyn Fn(u32) -> Vec<u8>| {
        let mut bytes = Vec::new();
        for i in 0..8_u32 {
            bytes.extend(length(if i == 0 { 0 } else { 50 }));
            bytes.extend(bad(i));
            bytes.extend([50, 0x80, 60 + i as u8, 0]);
        }
        read(&smf(0, MILLISECONDS, &[&track(&bytes)])).unwrap()
    };
    let on = |i: u32| vec![0x90, 60 + i as u8, 64];
    let whole: Vec<_> = (0..8).map(|i| (60 + i, 100 * i as i64, 100 * i as i64 + 50, 64)).collect();
    assert_eq!(notes(&eight(&on)), whole);
    // A real-time byte within an event, before it, or with a time of its own: nothing is lost.
    for within in [vec![0xF8], vec![0xFE], vec![0xF8, 0xF8]] {
        let piece = eight(&|i| if i == 3 { [within.clone(), on(i)].concat() } else { on(i) });
        assert_eq!(notes(&piece), whole, "{within:02X?}");
        assert!(said(&piece).contains("track 1") && said(&piece).contains("none of its 8 notes"), "{}", said(&piece));
    }
    let piece = eight(&|i| if i == 3 { [vec![0xF8, 0], on(i)].concat() } else { on(i) });
    assert_eq!(notes(&piece), whole);
    let piece = eight(&|i| if i == 3 { vec![0x90, 63, 0xF8, 64] } else { on(i) });
    assert_eq!(notes(&piece), whole);
    // A velocity or a key that is none: that note is lost, the others are in time.
    for bad in [vec![0x90, 63, 0xC0], vec![0x90, 0xC0, 64]] {
        let piece = eight(&|i| if i == 3 { bad.clone() } else { on(i) });
        let without: Vec<_> = whole.iter().copied().filter(|note| note.0 != 63).collect();
        assert_eq!(notes(&piece), without, "{bad:02X?}");
        assert!(said(&piece).contains("1 of its 8 notes"), "{bad:02X?}: {}", said(&piece));
    }
    // A status that no file has, with its data: a song position.
    let piece = eight(&|i| if i == 3 { [vec![0xF2, 1, 2, 0], on(i)].concat() } else { on(i) });
    assert_eq!(notes(&piece), whole);
}

/// A running status, one byte bad: the note that it is in is lost.
#[test]
fn a_running_status_is_resynchronised() {
    let mut bytes = vec![0, 0x90, 60, 64];
    for i in 1..40_u8 {
        bytes.extend([10, 60 + i % 12, if i % 2 == 0 { 64 } else { 0 }]);
    }
    let whole = read(&smf(0, MILLISECONDS, &[&track(&bytes)])).unwrap();
    // The velocity of the 20th note-on.
    bytes[3 + 3 * 20] = 0xC0;
    let piece = read(&smf(0, MILLISECONDS, &[&track(&bytes)])).unwrap();
    assert_eq!(piece.notes.len(), whole.notes.len() - 1, "{}", said(&piece));
    let last = |piece: &Piece| *notes(piece).last().unwrap();
    assert_eq!(last(&piece), last(&whole));
}

/// A track whose length is wrong, and one that is cut off.
#[test]
fn lengths_of_tracks_are_claims() {
    let own =
        track(&events(&[(0, &[0x90, 60, 64]), (500, &[0x80, 60, 64]), (600, &[0x90, 62, 64]), (900, &[0x80, 62, 64])]));
    let other = track(&events(&[(0, &[0x90, 72, 64]), (900, &[0x80, 72, 64])]));
    let expected = [(60, 0, 500, 64), (72, 0, 900, 64), (62, 600, 900, 64)];
    for claim in [0_u32, 5, own.len() as u32 + 3, own.len() as u32 + 30, u32::MAX] {
        let mut bytes = smf(1, MILLISECONDS, &[&own, &other]);
        bytes[18..22].copy_from_slice(&claim.to_be_bytes());
        assert_eq!(notes(&read(&bytes).unwrap()), expected, "{claim}");
    }
    let whole = smf(0, MILLISECONDS, &[&own]);
    let piece = read(&whole[..whole.len() - 11]).unwrap();
    assert_eq!(notes(&piece)[0], (60, 0, 500, 64));
    assert!(said(&piece).contains("track 1 breaks off: 1 note read of it"), "{}", said(&piece));
    // Padding after the last track is no loss.
    assert_eq!(said(&read(&[whole, vec![0; 64]].concat()).unwrap()), "");
}

/// A file of format 2 with one track is one piece. A MIDI 2.0 clip is named.
#[test]
fn formats_are_named() {
    let own = track(&events(&[(0, &[0x90, 60, 64]), (500, &[0x80, 60, 64])]));
    assert_eq!(notes(&read(&smf(2, MILLISECONDS, &[&own])).unwrap()), [(60, 0, 500, 64)]);
    assert_eq!(read(&smf(2, MILLISECONDS, &[&own, &own])).unwrap_err(), ReadError::Sequences(2));
    let clip = [b"SMF2CLIP".as_slice(), &[0x00, 0x00, 0x00, 0x00, 0x00, 0x30, 0x00, 0x60]].concat();
    let error = read(&clip).unwrap_err();
    assert_eq!(error, ReadError::Clip);
    assert!(error.to_string().contains("MIDI 2.0 clip"), "{error}");
    assert!(read(&smf(3, MILLISECONDS, &[&own])).unwrap_err().to_string().contains("format 3"));
    // Wrapped in RIFF, as Windows had it.
    let inner = smf(0, METRICAL, &[&END]);
    let riff = [b"RIFF\0\0\0\0RMIDdata".as_slice(), &(inner.len() as u32).to_le_bytes(), &inner].concat();
    assert_eq!(read(&riff).unwrap(), Piece::default());
}

/// Remarks belong to a passage: those of other places are not said of it.
#[test]
fn remarks_belong_to_a_passage() {
    let piece = one_track(&[
        (0, &[0x90, 20, 64]),
        (0, &[0x90, 60, 64]),
        (0, &[0x91, 61, 64]),
        (500, &[0x80, 60, 64]),
        (500, &[0x81, 61, 64]),
        (5000, &[0x90, 60, 64]),
        (5500, &[0x80, 60, 64]),
    ]);
    assert!(piece.remarks.lines().len() == 2, "{}", said(&piece));
    assert_eq!(piece.remarks.within(4.0, 6.0).lines(), Vec::<String>::new());
    assert_eq!(piece.remarks.within(0.0, 1.0).lines(), piece.remarks.lines());
}

/// A header that announces other tracks than there are is reported, whichever way it is wrong.
#[test]
fn a_header_that_announces_other_tracks() {
    let whole = smf(1, MILLISECONDS, &[&track(&events(&[(0, &[0x90, 60, 64]), (500, &[0x80, 60, 0])]))]);
    for announced in [0_u16, 1, 65_535] {
        let mut bytes = whole.clone();
        bytes[10..12].copy_from_slice(&announced.to_be_bytes());
        let piece = read(&bytes).unwrap();
        assert_eq!(piece.notes.len(), 1);
        let told = piece.remarks.lines().iter().any(|line| line.contains(&format!("announces {announced} track")));
        assert_eq!(told, announced != 1, "{announced}: {:?}", piece.remarks.lines());
    }
}
