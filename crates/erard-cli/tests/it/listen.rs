//! `erard listen`, as a user has it: recordings of which everything is known, and files that are none.

use std::f64::consts::PI;
use std::io::Cursor;

use crate::common::Folder;
use hound::{SampleFormat, WavSpec, WavWriter};

/// A recording of C4 in stereo, 44.1 kHz, 24 bit: six harmonics that fall in two stages, 30 dB/s down to -27 dB and 4
/// dB/s from there on. `gain`: amplitude of the first; what is beyond full scale is clipped.
pub fn two_stages(gain: f64) -> Vec<u8> {
    let level_db = |t: f64| if t < 0.9 { -30.0 * t } else { -27.0 - 4.0 * (t - 0.9) };
    let sound = |k: usize| {
        let t = k as f64 / 44_100.0 - 0.05;
        let amplitude = if t < 0.0 { 0.0 } else { gain * 10_f64.powf(level_db(t) / 20.0) };
        (1..=6).map(|n| amplitude / f64::from(n) * (2.0 * PI * 261.6256 * f64::from(n) * t + 0.5).sin()).sum()
    };
    wav((0..6 * 44_100).map(sound), 2, 24)
}

/// The same in every channel.
fn wav(sound: impl Iterator<Item = f64>, channels: u16, bits_per_sample: u16) -> Vec<u8> {
    let spec = WavSpec { channels, sample_rate: 44_100, bits_per_sample, sample_format: SampleFormat::Int };
    let mut bytes = Cursor::new(Vec::new());
    let mut writer = WavWriter::new(&mut bytes, spec).unwrap();
    let full = f64::from((1_u32 << (bits_per_sample - 1)) - 1);
    for x in sound {
        for _ in 0..channels {
            writer.write_sample((full * x.clamp(-1.0, 1.0)).round() as i32).unwrap();
        }
    }
    writer.finalize().unwrap();
    bytes.into_inner()
}

/// A cell of a CSV table by the row's number and the column's name.
fn cell<'a>(table: &'a str, row: usize, column: &str) -> &'a str {
    let at = table.lines().next().unwrap().split(',').position(|head| head == column).unwrap();
    table.lines().nth(row + 1).unwrap().split(',').nth(at).unwrap()
}

fn number(table: &str, row: usize, column: &str) -> f64 {
    cell(table, row, column).parse().unwrap_or_else(|_| panic!("{column}: {}", cell(table, row, column)))
}

/// Two loudnesses of a key, one by its name and one by --key: rows have what was put in, and the summary has both.
#[test]
fn recordings_become_rows() {
    let folder = Folder::for_command("listen", "rows");
    std::fs::write(folder.0.join("my C4 soft.wav"), two_stages(0.05)).unwrap();
    std::fs::write(folder.0.join("loud.wav"), two_stages(0.3)).unwrap();
    let said = folder.bad(&["my C4 soft.wav", "loud.wav"]);
    assert!(said.contains("loud.wav: no note in the file's name") && said.contains("--key C4"), "{said}");
    let said = folder.good(&["my C4 soft.wav", "loud.wav", "--key", "40"]);
    assert!(said.contains("2 recordings of 1 key"), "{said}");
    let [recordings, partials, notes] =
        ["recordings", "recordings-partials", "notes"].map(|name| folder.read(&format!("erard-out-listen/{name}.csv")));
    let near = |found: f64, truth: f64, share: f64| (found / truth - 1.0).abs() < share;
    for row in 0..2 {
        assert_eq!((cell(&recordings, row, "note"), cell(&recordings, row, "shape")), ("C4", "two stages"));
        assert!(near(number(&recordings, row, "t10_s"), 1.0 / 3.0, 0.05), "{recordings}");
        assert!(near(number(&recordings, row, "t20_s"), 2.0 / 3.0, 0.05), "{recordings}");
        assert!(near(number(&recordings, row, "early_dB_per_s"), 30.0, 0.05), "{recordings}");
        assert!(near(number(&recordings, row, "late_dB_per_s"), 4.0, 0.05), "{recordings}");
        assert_eq!(cell(&recordings, row, "clipped_samples"), "0");
    }
    // 20 log10(0.3/0.05).
    let levels = [0, 1].map(|row| number(&recordings, row, "level_dB"));
    assert!((levels[1] - levels[0] - 15.563).abs() < 0.02, "{levels:?}");
    assert_eq!(partials.lines().count(), 1 + 2 * 6);
    assert!((0..12).all(|row| near(number(&partials, row, "early_dB_per_s"), 30.0, 0.05)), "{partials}");
    assert_eq!((number(&notes, 0, "recordings"), number(&notes, 0, "two_stages")), (2.0, 2.0));
    assert!(near(number(&notes, 0, "t20_s"), 2.0 / 3.0, 0.05), "{notes}");
}

#[test]
fn a_clipped_recording_is_named() {
    let folder = Folder::for_command("listen", "clipped");
    std::fs::write(folder.0.join("C4.wav"), two_stages(3.0)).unwrap();
    let output = folder.erard(&["C4.wav"]);
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(0));
    assert!(said.contains("warning: C4.wav: clipped, ") && said.contains("samples at full scale"), "{said}");
}

/// One error that names the file, what was found and what is expected; nothing is written, however many other files are
/// good.
#[test]
fn what_is_no_recording_of_a_note_is_refused() {
    let folder = Folder::for_command("listen", "refused");
    let good = two_stages(0.3);
    let files: [(&str, Vec<u8>, &str); 8] = [
        ("C4.txt", b"time_s,force_N\n0,1\n".to_vec(), "C4.txt is no sound file; expected WAV or Ogg Vorbis"),
        ("C4-empty.wav", Vec::new(), "C4-empty.wav is empty; expected WAV or Ogg Vorbis"),
        ("C4-mp3.wav", b"ID3\x04".to_vec(), "C4-mp3.wav is MP3; expected WAV or Ogg Vorbis: convert it"),
        ("C4-cut.wav", good[..100_001].to_vec(), "C4-cut.wav is not a WAV file that can be read"),
        ("C4-none.wav", wav(std::iter::empty(), 2, 16), "C4-none.wav: holds no sound: no samples"),
        ("C4-silent.wav", wav(std::iter::repeat_n(0.0, 44_100), 1, 16), "C4-silent.wav: is silent"),
        (
            "C4-short.wav",
            wav((0..2000).map(|k| (0.1 * f64::from(k)).sin()), 1, 16),
            "C4-short.wav: the sound lasts 0.0",
        ),
        ("D4.wav", good.clone(), "D4.wav: the strongest component, 261.6 Hz, is no partial of D4 (293.7 Hz)"),
    ];
    std::fs::write(folder.0.join("C4.wav"), &good).unwrap();
    for (name, bytes, expected) in files {
        std::fs::write(folder.0.join(name), bytes).unwrap();
        let said = Folder::words(&folder.bad(&["C4.wav", name]));
        assert!(said.starts_with(&format!("error: {expected}")), "{said}");
    }
    let said = folder.bad(&["C4-missing.wav"]);
    assert!(said.contains("C4-missing.wav: cannot be read"), "{said}");
    let said = folder.bad(&["C4.wav", "--key", "89"]);
    assert!(said.contains("a number from 1 to 88, or a note from A0 to C8"), "{said}");
}

/// A modelled note goes the same way: `press --wav`, then `listen`. Its string's own loss, which the file declares, is
/// what is heard of every partial.
#[test]
#[ignore = "ci: a note of three seconds"]
fn a_modelled_note_is_heard() {
    let folder = Folder::new("listen-modelled");
    let text = erard::instrument::Instrument::builtin_text("concert-grand-strings").unwrap();
    // In unison: without beats; on a bridge that stands still.
    let unison: String =
        text.lines().filter(|line| !line.starts_with("detuned_cents")).flat_map(|line| [line, "\n"]).collect();
    let unison = unison.replace("\n[roles]\n", "\n[roles]\nrigid_bridge = true\n");
    folder.file("note.toml", &unison);
    let wav = ["--duration", "3", "--pedal", "10mm", "--wav", "C4.wav"];
    folder.good(&[&["press", "--instrument", "note.toml", "--hammer-speed", "2m/s"], &wav[..]].concat());
    folder.good(&["listen", "erard-out/C4.wav"]);
    let instrument = erard::instrument::InstrumentFile::parse(&unison, "note.toml").map_err(|e| e.to_string()).unwrap();
    let string = &instrument.instrument.strings[0];
    let partials = folder.read("erard-out-listen/recordings-partials.csv");
    for row in 0..6_u32 {
        let declared = string.decay_per_s(row + 1) * 20.0 / 10_f64.ln();
        let found = number(&partials, row as usize, "one_line_dB_per_s");
        println!("partial {}: {found} dB/s, by the file {declared:.3}", row + 1);
        assert!((found / declared - 1.0).abs() < 0.05, "{partials}");
    }
    let recordings = folder.read("erard-out-listen/recordings.csv");
    let found = number(&recordings, 0, "inharmonicity");
    assert!((found / string.inharmonicity() - 1.0).abs() < 0.02, "{found} {}", string.inharmonicity());
}
