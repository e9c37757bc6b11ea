//! `erard play`, as a user has it.

use std::fs;

use erard_midi::file::{Note, PedalChange, Piece, write};
use erard_midi::message::SOFT;
use erard_midi::{Resolution, Velocity};
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::RowAccessor;
use serde_json::Value;

use crate::common::Folder;

/// A piece as a file: key, beginning, end, s, velocity.
fn midi(notes: &[(usize, f64, f64, u8)]) -> Vec<u8> {
    let note = |&(key, start_s, end_s, velocity): &(usize, f64, f64, u8)| Note {
        key,
        start_s,
        end_s,
        velocity: Velocity::of_seven_bits(velocity),
        release: None,
    };
    let piece = Piece { notes: notes.iter().map(note).collect(), ..Piece::default() };
    write(&piece, Resolution::SevenBits).unwrap()
}

/// One note as it can be played, one on the same key that comes too soon, and one that is too loud.
pub fn two_notes() -> Vec<u8> {
    midi(&[(40, 0.5, 0.6, 66), (40, 0.54, 0.7, 66), (52, 0.6, 0.8, 127)])
}

fn with(test: &str, bytes: &[u8]) -> Folder {
    let folder = Folder::new(&format!("play-{test}"));
    fs::write(folder.0.join("piece.mid"), bytes).unwrap();
    folder
}

const CHEAP: [&str; 4] = ["--keyboard", "concert-grand", "--out", "out"];

/// Tables, rows, a page with a roll, and a page in slow motion for each note that went wrong.
#[test]
fn a_piece_is_played_and_written() {
    let folder = with("written", &two_notes());
    let said = folder.good(&[&["play", "piece.mid"][..], &CHEAP].concat());
    assert!(said.starts_with("piece.mid - 3 notes, 0.8 s") && said.contains("real-time factor"), "{said}");
    assert!(!cfg!(target_os = "linux") || said.contains("\npeak memory "), "{said}");
    let first = Folder::words(&folder.short(&[&["play", "piece.mid"][..], &CHEAP].concat()));
    assert!(
        first.contains("Concert grand: 1 of 3 notes sound as written; ") && first.contains(" Most often: "),
        "{first}"
    );
    assert!(first.contains("note 3, C5 at 0.60 s: soft: louder than a hand can play it"), "{first}");
    assert!(first.contains("More: --full adds") && !first.contains("real-time factor"), "{first}");
    let summary: Value = serde_json::from_str(&folder.read("out/summary.json")).unwrap();
    let own = &summary["keyboards"][0];
    assert_eq!((&summary["notes"], &own["keys"]), (&3.into(), &2.into()));
    let wrong = own["wrong"].as_array().unwrap();
    assert!(wrong.len() == 2 && wrong.iter().all(|note| !note["reasons"].as_array().unwrap().is_empty()), "{own}");
    let notes = folder.read("out/notes.csv");
    assert!(notes.lines().count() == 4 && notes.contains("C4") && notes.contains("C5"), "{notes}");
    let page = folder.read("out/play.html");
    assert!(page.contains("<svg class=\"roll\"") && page.contains("href=\"note-0003.html\""), "{page}");
    assert!(folder.read("out/note-0003.html").contains("louder than a hand can play it: at most 7."));
    let [key, hammer_speed_m_per_s] =
        ["key", "hammer_speed_m_per_s"].map(|name| own["ceilings"][0][name].as_f64().unwrap());
    assert!(key == 52.0 && (7.3..7.8).contains(&hammer_speed_m_per_s) && said.contains("ceiling of a key"), "{said}");
    let within = (2.0 * hammer_speed_m_per_s).floor() / 2.0;
    assert!(said.contains(&format!("--law linear:{within} is within their reach")), "{said}");
    let reasons = &own["reasons"];
    assert_eq!(
        (&reasons["within 40 ms of the last stroke"], &reasons["louder than a hand can play it"]),
        (&1.into(), &1.into())
    );

    let reader = SerializedFileReader::new(fs::File::open(folder.0.join("out/actions.parquet")).unwrap()).unwrap();
    let names: Vec<String> =
        reader.metadata().file_metadata().schema_descr().columns().iter().map(|c| c.name().to_owned()).collect();
    assert_eq!(names[..4], ["key", "time_s", "key_m", "key_m_per_s"]);
    let (mut rows, mut deepest_m) = (0, 0.0_f64);
    for row in reader.get_row_iter(None).unwrap().map(Result::unwrap) {
        assert!([40, 52].contains(&row.get_int(0).unwrap()));
        deepest_m = deepest_m.max(row.get_double(2).unwrap());
        rows += 1;
    }
    assert!((300..4000).contains(&rows) && (8e-3..12e-3).contains(&deepest_m), "{rows} {deepest_m}");
}

/// A passage on two keyboards: which notes are lost on one of them.
#[test]
fn two_keyboards_are_laid_side_by_side() {
    let repeated: Vec<(usize, f64, f64, u8)> =
        (0..5).map(|i| (44, 2.0 + 0.1 * f64::from(i), 2.05 + 0.1 * f64::from(i), 66)).collect();
    let folder = with("pair", &midi(&[&[(20, 0.5, 1.0, 60)], &repeated[..]].concat()));
    let options = ["--from", "1.5", "--to", "2.35", "--against-keyboard", "heavy-touch", "--slow-motion", "2"];
    folder.good(&[&["play", "piece.mid"][..], &CHEAP, &options].concat());
    let summary: Value = serde_json::from_str(&folder.read("out/summary.json")).unwrap();
    assert_eq!(summary["notes"], 4, "{summary}");
    let right = [0, 1].map(|side| summary["keyboards"][side]["right"].as_u64().unwrap());
    assert!(right[0] == 4 && right[1] < 4 && !summary["differ"].as_array().unwrap().is_empty(), "{summary}");
    let page = folder.read("out/play.html");
    assert!(page.matches("<svg class=\"roll\"").count() == 2 && page.contains("on one of the two keyboards"), "{page}");
    for name in ["notes-1.csv", "notes-2.csv", "actions-1.parquet", "actions-2.parquet"] {
        assert!(folder.0.join("out").join(name).exists(), "{name}");
    }
}

/// Of a file with two channels, a chord of two voices on a key and a bad byte, a passage says what is so in it.
#[test]
fn remarks_are_those_of_the_passage() {
    let track = [
        // At 0: two voices on C4, and a channel that is an organ. At 1 s, a byte that is no event. At 2 s, E4 alone.
        &[0, 0xC1, 19, 0, 0x90, 60, 40, 0, 0x90, 60, 90, 0, 0x91, 64, 60][..],
        &[96, 0x80, 60, 0, 0, 0x80, 60, 0, 0, 0x81, 64, 0],
        &[96, 0xF8, 0, 0xB0, 1, 0],
        &[0x81, 0x40, 0x90, 64, 60, 96, 0x80, 64, 0, 0, 0xFF, 0x2F, 0],
    ]
    .concat();
    let head = [b"MThd".as_slice(), &[0, 0, 0, 6, 0, 0, 0, 1, 0, 192], b"MTrk", &[0, 0, 0, track.len() as u8]].concat();
    let folder = with("passage", &[head, track].concat());
    let played = |options: &[&str]| folder.good(&[&["play", "piece.mid", "--force"][..], &CHEAP, options].concat());
    let whole = played(&[]);
    assert!(whole.starts_with("piece.mid - 3 notes, "), "{whole}");
    for remark in [
        "1 note at the instant of another of its key: one strike",
        "channels 1, 2 (program 20) are one piano here",
        "track 1: 1 byte at byte 51 is no event: none of its 4 notes lost",
    ] {
        assert!(whole.contains(remark), "{remark}: {whole}");
    }
    let part = played(&["--from", "1"]);
    let said: Vec<&str> = part.lines().take_while(|line| !line.is_empty()).collect();
    assert!(said.len() == 2 && said[0].starts_with("piece.mid - 1 note, ") && said[1].contains("begins"), "{part}");
}

/// Velocities are speeds by the law that is asked for, and the soft pedal is reported once.
#[test]
fn a_piece_is_played_by_laws() {
    let mut piece = Piece::default();
    for (i, velocity) in [40, 100].into_iter().enumerate() {
        let start_s = 0.5 + i as f64;
        let velocity = Velocity::of_seven_bits(velocity);
        piece.notes.push(Note { key: 40, start_s, end_s: start_s + 0.2, velocity, release: None });
    }
    for (time_s, value) in [(0.9, 50), (1.0, 127), (2.0, 0)] {
        piece.pedals.push(PedalChange { time_s, controller: SOFT, value });
    }
    let folder = with("laws", &write(&piece, Resolution::SevenBits).unwrap());
    fs::write(folder.0.join("own.csv"), "m_per_s,velocity\n0.25,20\n# loud\n4,100\n").unwrap();
    fs::write(folder.0.join("bad.csv"), "m_per_s,velocity\n1,20\n0.5,100\n").unwrap();
    let own_40 = 0.25 * 16_f64.powf(0.25);
    for (law, wanted) in [("linear:6", [6.0 * 40.0 / 127.0, 6.0 * 100.0 / 127.0]), ("own.csv", [own_40, 4.0])] {
        let said = folder.good(&[&["play", "piece.mid", "--law", law, "--force"][..], &CHEAP].concat());
        let soft = "soft pedal ignored (controller 67: 3 changes, down 1 time, 1 note under it)";
        assert_eq!(said.matches(soft).count(), 1, "{said}");
        let notes = folder.read("out/notes.csv");
        let at = notes.lines().next().unwrap().split(',').position(|name| name == "hammer_speed_m_per_s").unwrap();
        for (line, wanted) in notes.lines().skip(1).zip(wanted) {
            let speed: f64 = line.split(',').nth(at).unwrap().parse().unwrap();
            assert!((speed / wanted - 1.0).abs() < 0.01, "{law}: {speed} for {wanted}");
        }
    }
    for (law, expected) in [("linear:0", "linear:0.5"), ("bad.csv", "point 2"), ("goebl", "expected logarithmic")] {
        let said = folder.bad(&["play", "piece.mid", "--law", law]);
        assert!(said.contains(expected), "{said}");
    }
}

/// What is heard is the pressure before the board, as long as the piece.
#[test]
fn a_piece_is_heard() {
    let folder = with("heard", &midi(&[(64, 0.5, 0.7, 80), (69, 1.1, 1.2, 60)]));
    folder.good(&["play", "piece.mid", "--wav", "--wav-peak", "--out", "out", "--slow-motion", "0"]);
    let page = std::fs::read_to_string(folder.0.join("out/play.html")).unwrap();
    assert!(page.contains("<audio controls preload=\"none\" src=\"play.wav\">"), "the page does not play it");
    let mut reader = hound::WavReader::open(folder.0.join("out/play.wav")).unwrap();
    assert_eq!(reader.spec().channels, 2);
    let samples: Vec<[f64; 2]> = {
        let all: Vec<f64> = reader.samples::<i16>().map(|s| f64::from(s.unwrap()) / 32768.0).collect();
        all.chunks_exact(2).map(|pair| [pair[0], pair[1]]).collect()
    };
    let loudest = |from_s: f64, to_s: f64| {
        samples[(48e3 * from_s) as usize..(48e3 * to_s) as usize]
            .iter()
            .flatten()
            .fold(0.0, |peak: f64, s| peak.max(s.abs()))
    };
    assert!(loudest(0.0, 0.49) < 0.05 && (0.85..0.91).contains(&loudest(0.5, 0.7)), "{}", loudest(0.5, 0.7));
    assert!(loudest(1.0, 1.09) < 0.2 * loudest(1.1, 1.15), "the first note is damped");
    let refused = folder.bad(&[&["play", "piece.mid", "--wav"][..], &CHEAP[..2]].concat());
    assert!(refused.contains("strings are rigid") || refused.contains("rigid"), "{refused}");
}

/// Files that hold no piece end in one error, and nothing is written.
#[test]
fn files_that_hold_no_piece_are_refused() {
    let good = two_notes();
    let folder = with("bad", b"not a midi file");
    let mut cut = good.clone();
    cut.truncate(30);
    let percussion: Vec<u8> = {
        // A note-on and its note-off on channel 10.
        let track = [0, 0x99, 36, 64, 96, 0x89, 36, 64, 0, 0xFF, 0x2F, 0];
        let head =
            [b"MThd".as_slice(), &[0, 0, 0, 6, 0, 0, 0, 1, 0, 96], b"MTrk", &[0, 0, 0, track.len() as u8]].concat();
        [head, track.to_vec()].concat()
    };
    let mut zero_ticks = good.clone();
    zero_ticks[12..14].copy_from_slice(&[0, 0]);
    for (name, bytes, expected) in [
        ("empty.mid", Vec::new(), "empty.mid"),
        ("text.mid", b"MThd, or so it says".to_vec(), "text.mid"),
        ("cut.mid", cut, "cut.mid"),
        ("drums.mid", percussion, "percussion"),
        ("zero.mid", zero_ticks, "expected at least 1"),
        ("none.mid", midi(&[]), "no note for a piano"),
    ] {
        fs::write(folder.0.join(name), bytes).unwrap();
        let said = folder.bad(&["play", name]);
        assert!(said.starts_with("error: ") && said.lines().count() <= 2 && said.contains(expected), "{name}: {said}");
    }
    for (options, expected) in [
        (&["play", "nowhere.mid"][..], "nowhere.mid"),
        (&["play", "good.mid", "--keyboard", "nothing"], "nothing"),
        (&["play", "good.mid", "--record-interval", "0"], "0.05"),
        (&["play", "good.mid", "--from", "70"], "no note for a piano there"),
    ] {
        fs::write(folder.0.join("good.mid"), &good).unwrap();
        let said = folder.bad(options);
        assert!(said.contains(expected), "{options:?}: {said}");
    }
}
