//! Habits of files that other programs write, as their users report them. What is right was written down before each
//! was read for the first time; `first` says what came out then.

use erard_midi::file::{Piece, read};

use crate::bytes::{END, smf, track};

/// 500 ticks for a quarter note: a tick is a millisecond at 120 quarter notes a minute.
const MILLISECONDS: [u8; 2] = [0x01, 0xF4];

/// A note: number, beginning and end, ms, velocity.
type Sounds = (usize, i64, i64, i64);

/// What is right of a file.
enum Right {
    /// These notes, and remarks that contain this; without any if it is empty.
    Notes(Vec<Sounds>, &'static str),
    /// Refused with this in the message.
    Refused(&'static str),
}

struct Case {
    /// Who writes so, or who reports it.
    source: &'static str,
    habit: &'static str,
    bytes: Vec<u8>,
    right: Right,
    /// What came out the first time, where that was not right.
    first: &'static str,
}

fn found(piece: &Piece) -> Vec<Sounds> {
    let ms = |s: f64| (1e3 * s).round() as i64;
    let one = |note: &erard_midi::file::Note| {
        (note.key + 20, ms(note.start_s), ms(note.end_s), note.velocity.counts().round() as i64)
    };
    piece.notes.iter().map(one).collect()
}

fn one_track(events: &[&[u8]]) -> Vec<u8> {
    smf(0, MILLISECONDS, &[&track(&events.concat())])
}

/// A note of 100 ms with velocity 64, 10 ms after what stands before it.
const NOTE: [u8; 8] = [10, 0x90, 60, 64, 100, 0x80, 60, 64];

/// A text event of so many letters.
fn text(kind: u8, letters: usize) -> Vec<u8> {
    let mut bytes = vec![0, 0xFF, kind];
    if letters >= 128 {
        bytes.push(0x80 | (letters >> 7) as u8);
    }
    bytes.push((letters & 0x7F) as u8);
    bytes.extend(vec![b'x'; letters]);
    bytes
}

fn with_chunk(name: &[u8; 4], body: &[u8], file: &[u8]) -> Vec<u8> {
    [&file[..14], name, &(body.len() as u32).to_be_bytes(), body, &file[14..]].concat()
}

/// The number of tracks or the length of the first one, changed.
fn changed(mut bytes: Vec<u8>, at: usize, to: &[u8]) -> Vec<u8> {
    bytes[at..at + to.len()].copy_from_slice(to);
    bytes
}

fn case(source: &'static str, habit: &'static str, bytes: Vec<u8>, right: Right, first: &'static str) -> Case {
    Case { source, habit, bytes, right, first }
}

/// Status bytes.
fn statuses() -> Vec<Case> {
    let notes = |notes: &[Sounds]| Right::Notes(notes.to_vec(), "");
    vec![
        case(
            "gomidi/midi 20, craigsapp/midifile 32",
            "a running status goes on behind a meta event",
            one_track(&[&[0, 0x90, 0x47, 0x5C], &[4, 0xFF, 1, 2, 0x25, 0x2B], &[22, 0x47, 0, 0, 0x43, 0]]),
            notes(&[(0x47, 0, 26, 0x5C)]),
            "",
        ),
        case(
            "pedrolcl/drumstick 23, FluidSynth 1329",
            "a running status goes on behind a system exclusive message",
            one_track(&[&[0, 0x90, 60, 64], &[10, 0xF0, 5, 0x43, 0x12, 0, 7, 0xF7], &[90, 60, 0]]),
            notes(&[(60, 0, 100, 64)]),
            "",
        ),
        case(
            "linux-audio-dev, August 2003 (.kar)",
            "controllers of sixteen channels without a status, behind a text",
            one_track(&[&[0, 0xB1, 0x0A, 0x40, 0, 0x5B, 0x40], &text(1, 12), &[0, 7, 0x7F].repeat(16), &NOTE]),
            notes(&[(60, 10, 110, 64)]),
            "",
        ),
        case(
            "AlexCharlton/midi-msg 27",
            "an empty system exclusive message, and one that is its end alone",
            one_track(&[&[0, 0xF0, 0], &[0, 0xF0, 1, 0xF7], &NOTE]),
            notes(&[(60, 10, 110, 64)]),
            "",
        ),
        case(
            "the format's specification, read by PicoAudio 3",
            "a system exclusive message in packets, and an escape that holds statuses",
            one_track(&[
                &[0, 0xF0, 3, 0x43, 0x12, 0],
                &[50, 0xF7, 3, 0x43, 0x12, 0],
                &[50, 0xF7, 2, 0, 0xF7],
                &[0, 0xF7, 3, 0xF3, 1, 0xF8],
                &NOTE,
            ]),
            notes(&[(60, 110, 210, 64)]),
            "",
        ),
        case(
            "markusschwenk/midieditor 87",
            "a system exclusive message without its length, whose first byte is more than the track has",
            one_track(&[&[0, 0xF0, 0x43, 0x12, 0, 7, 0xF7], &NOTE]),
            Right::Notes(vec![(60, 10, 110, 64)], "none of its 1 note"),
            "no note",
        ),
        case(
            "markusschwenk/midieditor 87",
            "the same in a long track: the byte that is taken for a length leads into the notes",
            one_track(&[&[0, 0xF0, 0x43, 0x12, 0, 7, 0xF7], &NOTE.repeat(20)]),
            Right::Notes((0..20).map(|i| (60, 110 * i + 10, 110 * i + 110, 64)).collect(), "none of its 20 notes"),
            "9 of the 20 notes were lost, the others came late",
        ),
        case(
            "AlexCharlton/midi-msg 27",
            "a controller whose value has its eighth bit set",
            one_track(&[&[0, 0xB0, 7, 0xC8], &NOTE, &NOTE]),
            Right::Notes(vec![(60, 10, 110, 64), (60, 120, 220, 64)], "none of its 2 notes"),
            "",
        ),
    ]
}

/// Lengths, chunks and headers.
fn lengths() -> Vec<Case> {
    let one = || one_track(&[&NOTE]);
    let notes = |said: &'static str| Right::Notes(vec![(60, 10, 110, 64)], said);
    let other = track(&[0, 0x90, 72, 64, 50, 0x80, 72, 64]);
    let two = smf(1, MILLISECONDS, &[&track(&NOTE), &other]);
    let both = vec![(72, 0, 50, 64), (60, 10, 110, 64)];
    let first_end = 22 + NOTE.len() + END.len();
    let riff = |length: u32, data: u32| {
        let head = [b"RIFF".as_slice(), &length.to_le_bytes(), b"RMIDdata", &data.to_le_bytes()].concat();
        [head, one()].concat()
    };
    vec![
        case(
            "mido 480 (XMI2MID)",
            "a length that is some bytes more than the track has",
            changed(two.clone(), 18, &(NOTE.len() as u32 + 4 + 5).to_be_bytes()),
            Right::Notes(both.clone(), ""),
            "",
        ),
        case("swift-midi 177", "a line's end behind the last track", [one(), b"\r\n".to_vec()].concat(), notes(""), ""),
        case(
            "vishnubob/python-midi 88 (Sony Ericsson's MusicDJ)",
            "a chunk of another name between header and track",
            with_chunk(b"SEM1", &[0; 12], &one()),
            notes(""),
            "",
        ),
        case(
            "stuerp/foo_midi 38",
            "a header that announces more tracks than there are",
            changed(one(), 10, &[0, 8]),
            notes("announces 8 tracks"),
            "",
        ),
        case(
            "craigsapp/midifile 31",
            "remains of another track behind the first one, which begin no chunk",
            [&two[..first_end], &[0, 0xFF, 0x51, 3, 7, 0xA1, 0x20, 0, 0xFF, 0x51, 3, 7, 0xA1, 0x20], &two[first_end..]]
                .concat(),
            Right::Notes(both.clone(), ""),
            "",
        ),
        case("kovaxis/midly 4", "wrapped in RIFF", riff(one().len() as u32 + 12, one().len() as u32), notes(""), ""),
        case("Danjb1/open-rival 1", "wrapped in RIFF whose lengths are too short", riff(20, 9), notes(""), ""),
        case(
            "LenShustek/miditones 10, craigsapp/midifile 45",
            "a copyright of 300 letters, and an unknown meta event of 200 bytes",
            one_track(&[&text(2, 300), &text(0x60, 200), &NOTE]),
            notes(""),
            "",
        ),
        case(
            "carter-thaxton/midi-file 4, sequencer64 121",
            "a sequence number of 48 bytes",
            one_track(&[&text(0, 48), &NOTE]),
            notes(""),
            "",
        ),
        case(
            "cwilso/Standard-MIDI-File-reader 1",
            "delays that begin with a byte of no bits",
            one_track(&[&[0x80, 10], &NOTE[1..4], &[0x80, 0x80, 100], &NOTE[5..]]),
            notes(""),
            "",
        ),
        case(
            "zynthian 794",
            "a track that ends while a key is held",
            one_track(&[&NOTE, &[40, 0x90, 64, 80], &[0x87, 0x68, 0xFF, 6, 0]]),
            Right::Notes(vec![(60, 10, 110, 64), (64, 150, 1150, 80)], "1 note without an end"),
            "",
        ),
        case("porres/pd-else 1070", "a track without its end", smf(0, MILLISECONDS, &[&NOTE]), notes("breaks off"), ""),
        case(
            "padding to an even length, as RIFF has it",
            "zeros behind the end of a track, within its length",
            smf(0, MILLISECONDS, &[&[track(&NOTE), vec![0; 7]].concat()]),
            notes(""),
            "",
        ),
        case(
            "a page that says that a file was not found",
            "no file of MIDI",
            b"<!DOCTYPE html>".to_vec(),
            Right::Refused("`MThd`"),
            "",
        ),
    ]
}

/// Tempi, clocks, and notes that begin or end oddly.
fn times() -> Vec<Case> {
    let notes = |notes: &[Sounds], said: &'static str| Right::Notes(notes.to_vec(), said);
    let second: [u8; 7] = [0, 0xFF, 0x51, 3, 0x0F, 0x42, 0x40];
    let long: [u8; 10] = [0, 0x90, 60, 64, 0x87, 0x68, 0x80, 60, 64, 0];
    let tempo_at = |tick: u8| [&[tick], &second[1..]].concat();
    vec![
        case(
            "wyskoj/midis2jam2 163, magenta 512",
            "the first tempo is not at the beginning: 120 quarter notes a minute until then",
            // 100 ms, then ticks of two milliseconds.
            one_track(&[&[0, 0x90, 60, 64], &tempo_at(100), &[100, 0x80, 60, 64]]),
            notes(&[(60, 0, 300, 64)], ""),
            "",
        ),
        case(
            "Yikai-Liao/symusic 44",
            "the tempo stands in the second track",
            smf(1, MILLISECONDS, &[&track(&long[..9]), &track(&second)]),
            notes(&[(60, 0, 2000, 64)], ""),
            "",
        ),
        case(
            "rism-digital/verovio 3777",
            "one tempo ten times",
            smf(1, MILLISECONDS, &[&track(&second.repeat(10)), &track(&long[..9])]),
            notes(&[(60, 0, 2000, 64)], ""),
            "",
        ),
        case(
            "magenta 512",
            "half an hour of tempi behind the last note",
            one_track(&[&long[..9], &[0x87, 0x68, 0xFF, 0x51, 3, 0x0F, 0x42, 0x40].repeat(900)]),
            notes(&[(60, 0, 1000, 64)], ""),
            "",
        ),
        case(
            "jimm/midilib 15 (Mutopia)",
            "the delay before a note stands at the track's name",
            one_track(&[&[0x83, 0x74, 0xFF, 3, 2, b'u', b'p'], &[0], &NOTE[1..]]),
            notes(&[(60, 500, 600, 64)], ""),
            "",
        ),
        case(
            "got-feedBack 805",
            "a quarter note of no ticks",
            smf(0, [0, 0], &[&track(&NOTE)]),
            Right::Refused("0 ticks"),
            "",
        ),
        case(
            "mido 457",
            "a clock of 25 frames a second and 40 ticks: milliseconds",
            smf(0, [0xE7, 40], &[&track(&[&second[..], &NOTE].concat())]),
            notes(&[(60, 10, 110, 64)], ""),
            "",
        ),
        case(
            "Yikai-Liao/symusic 38 (a recording of ASAP)",
            "a note that ends in the tick of its beginning, between others of its key",
            one_track(&[
                &[0, 0x90, 72, 88, 100, 0x80, 72, 64],
                &[100, 0x90, 72, 85, 0, 0x80, 72, 64],
                &[100, 0x90, 72, 90, 100, 0x80, 72, 56],
            ]),
            notes(&[(72, 0, 100, 88), (72, 300, 400, 90)], "1 note that ends as it begins"),
            "",
        ),
        case(
            "rism-digital/verovio 3992",
            "a note that was silenced by velocity 0, within another of its key: that ends there",
            one_track(&[&[0, 0x90, 60, 90], &[100, 0x90, 60, 0], &[100, 0x80, 60, 64], &[100, 0x80, 60, 64]]),
            notes(&[(60, 0, 100, 90)], ""),
            "",
        ),
        case(
            "vishnubob/python-midi 84",
            "no note-off at all: every note ends by velocity 0",
            one_track(&[&[0, 0x90, 64, 72, 0, 60, 46, 100, 64, 0, 0, 60, 0], &[50, 62, 72, 100, 62, 0]]),
            notes(&[(60, 0, 100, 46), (64, 0, 100, 72), (62, 150, 250, 72)], ""),
            "",
        ),
        case(
            "craigsapp/midifile 31",
            "notes in the track of the tempi",
            smf(1, MILLISECONDS, &[&track(&[&second[..], &NOTE].concat()), &track(&[])]),
            notes(&[(60, 20, 220, 64)], ""),
            "",
        ),
        case(
            "MiniDexed 48",
            "note-offs of velocity 127, and after 0",
            one_track(&[&[0, 0x90, 60, 64, 100, 0x80, 60, 127], &[0, 0x90, 60, 64, 100, 0x80, 60, 0]]),
            notes(&[(60, 0, 100, 64), (60, 100, 200, 64)], ""),
            "",
        ),
    ]
}

#[test]
fn files_of_others_are_read_as_was_written_down_before() {
    let all: Vec<Case> = [statuses(), lengths(), times()].into_iter().flatten().collect();
    assert!(all.len() >= 30, "{}", all.len());
    let mut wrong = Vec::new();
    for Case { source, habit, bytes, right, first } in &all {
        let came = match (read(bytes), right) {
            (Ok(piece), Right::Notes(notes, part)) => {
                let said = piece.remarks.lines().join("; ");
                let is_said = if part.is_empty() { said.is_empty() } else { said.contains(part) };
                (found(&piece) != *notes || !is_said).then(|| format!("{:?}, \"{said}\"", found(&piece)))
            }
            (Err(error), Right::Refused(part)) => {
                (!error.to_string().contains(part)).then(|| format!("refused: {error}"))
            }
            (Ok(piece), Right::Refused(_)) => Some(format!("{:?}", found(&piece))),
            (Err(error), Right::Notes(..)) => Some(format!("refused: {error}")),
        };
        println!("{habit} ({source}): {}", if first.is_empty() { "right at once" } else { first });
        wrong.extend(came.map(|came| format!("{habit} ({source}): {came}")));
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
