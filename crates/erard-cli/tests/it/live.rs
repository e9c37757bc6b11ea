//! `erard live` and `erard calibrate`, as a user has them.

use std::io::Write;
use std::process::{Output, Stdio};

use erard_midi::file::read;
use serde_json::Value;

use crate::common::Folder;

/// Two presses of key 40 and one of key 52, a pedal, 1 kHz; the sensed value runs from `up` to `down`.
pub fn sensed(quantity: &str, up: f64, down: f64) -> String {
    let mut text = format!("time_us,key,{quantity}\n");
    let rise = |t: f64, from: f64, lasts: f64| {
        let s = ((t - from) / lasts).clamp(0.0, 1.0);
        s.powi(3) * (10.0 - 15.0 * s + 6.0 * s * s)
    };
    for ms in 0..1800_u32 {
        let t = 1e-3 * f64::from(ms);
        let mut line = |key: usize, share: f64| {
            text.push_str(&format!("{},{key},{:.3}\n", 1000 * ms, up + share * (down - up)));
        };
        line(40, rise(t, 0.6, 0.08) - rise(t, 0.9, 0.06) + rise(t, 1.1, 0.06) - rise(t, 1.4, 0.06));
        line(52, rise(t, 0.7, 0.05) - rise(t, 1.3, 0.06));
        if ms == 800 {
            text.push_str("800000,sustain,0.5\n");
        }
    }
    text
}

/// The command with a text on standard input.
fn piped(folder: &Folder, arguments: &[&str], text: &str) -> Output {
    let mut command = folder.command(arguments);
    let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut stdin = child.stdin.take().unwrap();
    let text = text.to_owned();
    let writer = std::thread::spawn(move || drop(stdin.write_all(text.as_bytes())));
    let output = child.wait_with_output().unwrap();
    writer.join().unwrap();
    output
}

/// A file becomes a MIDI file; a pipe the same notes as bytes; readings with the profile that `calibrate` finds in them
/// the same again.
#[test]
fn sensed_keys_become_notes() {
    let folder = Folder::new("live-notes");
    let stream = sensed("mm", 0.0, 9.9);
    folder.file("stream.csv", &stream);
    let said = folder.good(&["live", "stream.csv", "--out-file", "take.mid"]);
    assert!(said.contains("3 note-ons, 3 note-offs"), "{said}");
    let piece = read(&std::fs::read(folder.0.join("take.mid")).unwrap()).unwrap();
    let keys: Vec<usize> = piece.notes.iter().map(|note| note.key).collect();
    assert_eq!((&keys[..], piece.pedals.len()), (&[40, 52, 40][..], 2), "{piece:?}");
    let velocities: Vec<u8> = piece.notes.iter().map(|note| note.velocity.seven_bits()).collect();
    assert!(velocities[0] < velocities[2] && velocities[2] < velocities[1], "{velocities:?}");

    folder.file("readings.csv", &sensed("raw", 3000.0, 1000.0));
    let said = folder.good(&["calibrate", "readings.csv", "--travel", "9.9", "--out-file", "profile.toml"]);
    assert!(said.contains("2 keys") && folder.read("profile.toml").contains("rest = 3000"), "{said}");
    let said = folder.good(&["live", "readings.csv", "--calibration", "profile.toml", "--out-file", "bytes"]);
    assert!(said.contains("3 note-ons, 3 note-offs"), "{said}");
    let bytes = std::fs::read(folder.0.join("bytes")).unwrap();
    let ons: Vec<&[u8]> = bytes.chunks(3).filter(|bytes| bytes[0] == 0x90).collect();
    let expected: Vec<[u8; 3]> = keys_and(&keys, &velocities);
    assert_eq!(ons, expected.iter().map(|bytes| &bytes[..]).collect::<Vec<_>>());
}

/// Through a pipe come the bytes that a file gives.
#[test]
#[ignore = "ci: every key is prepared before the first sample"]
fn sensed_keys_become_notes_through_a_pipe() {
    let folder = Folder::new("live-pipe");
    let stream = sensed("mm", 0.0, 9.9);
    folder.file("stream.csv", &stream);
    folder.good(&["live", "stream.csv", "--out-file", "bytes"]);
    let output = piped(&folder, &["live"], &stream);
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success() && said.contains("handed over after the impact"), "{said}");
    assert_eq!(std::fs::read(folder.0.join("bytes")).unwrap(), output.stdout);
}

/// A sender that stops while keys are down, through a pipe that stays open: after `--stall` seconds on the wall's clock
/// their notes are ended. What it sends later is played again; Control-C ends what sounds, and the process with 130.
#[cfg(unix)]
#[test]
#[ignore = "ci: waits by the clock"]
fn a_stall_and_an_interruption_end_what_sounds() {
    use std::io::Read;
    use std::time::{Duration, Instant};
    let folder = Folder::new("live-stall");
    let stall = Duration::from_millis(300);
    let mut child = folder
        .command(&["live", "--stall", "0.3"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let (mut stdin, mut stdout) = (child.stdin.take().unwrap(), child.stdout.take().unwrap());
    // Keys 40 and 52 are down at 0.86 s.
    let pressed = |later_us: u32| -> String {
        let whole = sensed("mm", 0.0, 9.9);
        let sample = |line: &str| {
            let (time_us, rest) = line.split_once(',')?;
            let time_us: u32 = time_us.parse().ok().filter(|us| *us <= 860_000)?;
            (!rest.starts_with("sustain")).then(|| format!("{},{rest}\n", time_us + later_us))
        };
        whole.lines().filter_map(sample).collect()
    };
    let mut message = || {
        let mut bytes = [0; 3];
        stdout.read_exact(&mut bytes).unwrap();
        bytes
    };
    let both = |messages: [[u8; 3]; 2], status: u8| {
        let mut keys = messages.map(|[own, note, _]| (own, note));
        keys.sort_unstable();
        assert_eq!(keys, [(status, 60), (status, 72)], "{messages:?}");
    };
    stdin.write_all(format!("time_us,key,mm\n{}", pressed(0)).as_bytes()).unwrap();
    both([message(), message()], 0x90);
    let sounded = Instant::now();
    both([message(), message()], 0x80);
    assert!(sounded.elapsed() > stall / 2, "{:?}", sounded.elapsed());
    stdin.write_all(pressed(9_000_000).as_bytes()).unwrap();
    both([message(), message()], 0x90);
    let process = rustix::process::Pid::from_child(&child);
    rustix::process::kill_process(process, rustix::process::Signal::INT).unwrap();
    both([message(), message()], 0x80);
    let mut rest = Vec::new();
    stdout.read_to_end(&mut rest).unwrap();
    let output = child.wait_with_output().unwrap();
    drop(stdin);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(rest.is_empty() && output.status.code() == Some(130) && said.contains("interrupted"), "{rest:?} {said}");
}

fn keys_and(keys: &[usize], velocities: &[u8]) -> Vec<[u8; 3]> {
    keys.iter().zip(velocities).map(|(key, velocity)| [0x90, *key as u8 + 20, *velocity]).collect()
}

/// Packets of MIDI 2.0; lines that are none are counted; a coarse, slow sensor is warned of.
#[test]
fn faults_are_told() {
    faults_told("live-faults", |folder, coarse| {
        folder.file("coarse.csv", coarse);
        let output = folder.erard(&["live", "coarse.csv", "--velocity-bits", "16", "--out-file", "packets"]);
        Output { stdout: std::fs::read(folder.0.join("packets")).unwrap(), stderr: both(&output), ..output }
    });
}

#[test]
#[ignore = "ci: a pipe, which may play any key"]
fn faults_of_a_pipe_are_told() {
    faults_told("live-faults-piped", |folder, coarse| piped(folder, &["live", "--velocity-bits", "16"], coarse));
}

fn both(output: &Output) -> Vec<u8> {
    [&output.stdout[..], &output.stderr[..]].concat()
}

/// `play` returns the packets as standard output.
fn faults_told(name: &str, play: impl FnOnce(&Folder, &str) -> Output) {
    let folder = Folder::new(name);
    let coarse: String = sensed("mm", 0.0, 9.9)
        .lines()
        .enumerate()
        .filter(|(n, line)| *n == 0 || (n / 2) % 4 == 0 || line.contains("sustain"))
        .map(|(n, line)| match line.rsplit_once(',') {
            Some((head, value)) if n > 0 && !line.contains("sustain") => {
                format!("{head},{}\n", (value.parse::<f64>().unwrap() / 0.08).round() * 0.08)
            }
            _ => format!("{line}\n"),
        })
        .chain(["\u{1}garbage\n".to_owned(), "1,2,3,4\n".to_owned(), "1900000,89,1\n".to_owned()])
        .collect();
    let output = play(&folder, &coarse);
    let said = Folder::words(&String::from_utf8(output.stderr).unwrap());
    assert!(output.status.success() && said.contains("3 lines left out; the first, line"), "{said}");
    assert!(said.contains("warning: the sensor has") && said.contains("expected error of speed"), "{said}");
    let packets: Vec<u8> = output.stdout.chunks(8).map(|packet| packet[1] >> 4).collect();
    assert_eq!(packets.iter().filter(|opcode| **opcode == 9).count(), 3, "{packets:?}");
}

/// Streams, profiles and options that cannot be end in one error, and nothing is written.
#[test]
fn what_cannot_be_played_is_refused() {
    let folder = Folder::new("live-bad");
    let files = [
        ("empty.csv", ""),
        ("headless.csv", "0.1,40,2\n"),
        ("nothing.csv", "time_s,key,mm\na,b,c\n"),
        ("raw.csv", "time_s,key,raw\n0,40,1\n"),
        ("mm.csv", "time_s,key,mm\n0,40,1\n"),
        ("pressure.csv", "time_s,key,pressure\n0,40,1\n"),
        ("stuck.csv", "time_s,key,raw\n0,40,1\n"),
        (
            "profile.toml",
            "format = \"erard-sensors/1\"\ntravel_mm = 10\n[law]\nkind = \"linear\"\n[[key]]\nnumber = 40\nrest = 0\npressed = 127\n",
        ),
        ("wrong.toml", "format = \"erard-sensors/1\"\ntravel_mm = 10\n[law]\nkind = \"linar\"\n"),
    ];
    files.iter().for_each(|(name, text)| folder.file(name, text));
    let stuck: String = (0..500).map(|n| format!("{},40,7\n", 1e-3 * f64::from(n))).collect();
    folder.file("stuck.csv", &format!("time_s,key,raw\n{stuck}"));
    for (arguments, part) in [
        (&["live", "nowhere.csv", "--out-file", "o.mid"][..], "nowhere.csv: cannot be read"),
        (&["live", "empty.csv", "--out-file", "o.mid"], "it is empty"),
        (&["live", "headless.csv", "--out-file", "o.mid"], "expected a head"),
        (&["live", "nothing.csv", "--out-file", "o.mid"], "line 2: time is `a`"),
        (&["live", "raw.csv", "--out-file", "o.mid"], "--calibration"),
        (&["live", "mm.csv", "--calibration", "profile.toml", "--out-file", "o.mid"], "--calibration converts"),
        (&["live", "pressure.csv", "--calibration", "profile.toml", "--out-file", "o.mid"], "polyphonic pressure"),
        (&["live", "raw.csv", "--calibration", "wrong.toml", "--out-file", "o.mid"], "wrong.toml: line"),
        (&["live", "mm.csv", "--velocity-bits", "16", "--out-file", "o.mid"], "Standard MIDI File"),
        (&["live", "mm.csv", "--travel", "4", "--out-file", "o.mid"], "--travel goes with"),
        (&["live", "mm.csv", "--out-file", "mm.csv"], "is the stream"),
        (&["live", "mm.csv", "--out-file", "raw.csv"], "raw.csv"),
        (&["live", "mm.csv", "--channel", "17", "--out-file", "o.mid"], "17"),
        (&["calibrate", "mm.csv"], "expected a reading"),
        (&["calibrate", "stuck.csv"], "is the sensor stuck?"),
        (&["calibrate", "raw.csv"], "1 readings"),
        (&["calibrate", "raw.csv", "--sensor-law", "nolaw"], "--sensor-law: expected linear, cny70, hall"),
    ] {
        let said = Folder::words(&folder.bad(arguments));
        assert!(said.contains(part), "{arguments:?}: {said}");
    }
    if cfg!(not(feature = "ports")) {
        let said = Folder::words(&folder.bad(&["live", "mm.csv", "--midi-port", "synth"]));
        assert!(said.contains("--features ports") && said.contains("/dev/snd/midiC1D0"), "{said}");
    }
    // With --json the answer is on standard output: the bytes cannot be.
    let output = folder.erard(&["live", "mm.csv", "--json"]);
    let answer: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(answer["error"]["message"].as_str().unwrap().contains("--out-file"), "{answer}");
}

/// A stream's faults are reported: stamps that are wrong, a header that comes again, a sign that is
/// inverted. What was not seen is empty in the table, and 64 among the bytes; velocities are those of the bytes.
#[test]
fn clocks_and_silence_are_told() {
    let folder = Folder::new("live-clocks");
    let stream = sensed("mm", 0.0, 9.9);
    let body = stream.split_once('\n').unwrap().1;
    // It begins anew while both keys are down; a line is ten seconds late.
    let first: String = body.lines().take(2 * 870).map(|line| format!("{line}\n")).collect();
    folder.file("twice.csv", &format!("time_us,key,mm\n{first}10860000,40,9.9\n{stream}"));
    let said = folder.good(&["live", "twice.csv", "--out-file", "notes.csv"]);
    for part in [
        "5 note-ons, 5 note-offs",
        "1 samples skipped: stamps more than 1 s from their neighbours'",
        "1 new clocks, a header or stamps that go back: held notes ended",
        "2 note-offs whose release was not seen: sent as 64",
    ] {
        assert!(said.contains(part), "{part}: {said}");
    }
    let notes = folder.read("notes.csv");
    let rows: Vec<Vec<&str>> = notes.lines().skip(1).map(|line| line.split(',').collect()).collect();
    assert!(rows.len() == 5 && rows[..2].iter().all(|row| row[6].is_empty()), "{notes}");
    assert!(rows[2..].iter().all(|row| row[4].parse::<u8>().is_ok() && row[6].parse::<u8>().is_ok()), "{notes}");
    let decimals = |text: &str| text.split_once('.').map_or(0, |(_, digits)| digits.len());
    assert!(rows.iter().all(|row| decimals(row[2]) <= 6 && decimals(row[3]) <= 4), "{notes}");
    folder.good(&["live", "twice.csv", "--out-file", "bytes"]);
    let bytes = std::fs::read(folder.0.join("bytes")).unwrap();
    let ons: Vec<String> = bytes.chunks(3).filter(|three| three[0] == 0x90).map(|three| three[2].to_string()).collect();
    assert_eq!(ons, rows.iter().map(|row| row[4]).collect::<Vec<_>>());
    let offs: Vec<u8> = bytes.chunks(3).filter(|three| three[0] == 0x80).map(|three| three[2]).collect();
    assert_eq!(offs[..2], [64, 64]);

    folder.file("sign.csv", &sensed("mm", 0.0, -9.9));
    let said = folder.good(&["live", "sign.csv", "--out-file", "none.csv"]);
    assert!(said.contains("no notes: keys move 9.9 mm above their rest: is the sign inverted?"), "{said}");
}

/// A stream that standard input reads from a file is not replaced, whatever the option.
#[cfg(unix)]
#[test]
fn the_file_on_standard_input_is_kept() {
    let folder = Folder::new("live-itself");
    let stream = "time_s,key,mm\n0,40,1\n";
    for (name, of) in [("in.csv", "in.csv"), ("in.mid", "in.mid"), ("in", "in")] {
        folder.file(name, stream);
        let mut command = folder.command(&["live", "--out-file", of, "--force"]);
        let input = std::fs::File::open(folder.0.join(name)).unwrap();
        let output = command.stdin(Stdio::from(input)).output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{name}: {}", String::from_utf8_lossy(&output.stderr));
        assert_eq!(folder.read(name), stream);
    }
}

/// Of three keys one that was pressed half the way is named.
#[test]
fn calibrate_compares_keys() {
    let folder = Folder::new("calibrate-unlike");
    let mut text = String::from("time_s,key,raw\n");
    for ms in 0..900_u32 {
        for (key, pressed) in [(40, 1000.0), (41, 1010.0), (42, 2100.0)] {
            let value = if (300..600).contains(&ms) { pressed } else { 3000.0 };
            text.push_str(&format!("{},{key},{value}\n", 1e-3 * f64::from(ms)));
        }
    }
    folder.file("readings.csv", &text);
    let said = folder.good(&["calibrate", "readings.csv"]);
    assert!(
        said.contains("key 42: its range is 0.45 of the median of all keys") && !said.contains("key 41:"),
        "{said}"
    );
}

/// A ruler's table with a flat start and noise becomes a law; a ruler that goes back is named by line and reading.
#[test]
fn a_rulers_table_is_a_law() {
    let folder = Folder::new("calibrate-ruler");
    let mut text = String::from("time_s,key,raw\n");
    for ms in 0..900_u32 {
        let value = if (300..600).contains(&ms) { 900.0 } else { 500.0 };
        text.push_str(&format!("{},40,{value}\n", 1e-3 * f64::from(ms)));
    }
    folder.file("readings.csv", &text);
    folder.file("ruler.csv", "raw,mm\n500,0\n501,1\n499,2\n# noise\n620,4\n610,6\n900,10\n");
    let said = folder.good_words(&["calibrate", "readings.csv", "--sensor-law", "ruler.csv", "--out-file", "own.toml"]);
    assert!(said.contains("ruler.csv: 5 of 6 readings") && said.contains("were averaged, by up to 5.0000"), "{said}");
    assert!(folder.read("own.toml").contains("kind = \"table\""));
    folder.file("back.csv", "raw,mm\n500,0\n600,4\n# again\n700,3\n900,10\n");
    let said = folder.bad(&["calibrate", "readings.csv", "--sensor-law", "back.csv"]);
    assert!(Folder::words(&said).contains("back.csv, line 5: reading 700 at 3 mm after 4 mm; expected"), "{said}");
    for (cut, told) in [
        ("500,0\n700,x,4\n", "found `700,x,4`"),
        ("500,0\n700\n", "found `700`"),
        ("500,0\n\"700,4\n", "found `\"700,4`"),
    ] {
        folder.file("cut.csv", &format!("raw,mm\n{cut}"));
        let said = Folder::words(&folder.bad(&["calibrate", "readings.csv", "--sensor-law", "cut.csv"]));
        assert!(said.contains(&format!("cut.csv, line 3: {told}; expected two numbers, as in `raw,mm`")), "{said}");
    }
    folder.file("flat.csv", "raw,mm\n500,0\n500,4\n500,10\n");
    let said = folder.bad(&["calibrate", "readings.csv", "--sensor-law", "flat.csv"]);
    assert!(Folder::words(&said).contains("flat.csv: readings from 500 at 0 mm to 500 at 10 mm do not rise"), "{said}");
}

/// Two contacts a key: a profile from the simulated action, edges that bounce, one note each; a maker's own table in
/// its place; what does not fit is refused.
#[test]
fn contacts_become_notes() {
    let folder = Folder::new("live-contacts");
    let said = folder.good_words(&["calibrate", "--contacts", "3,6.5", "--scan-period", "250"]);
    for part in ["contact 1 to 2", "touch, counts", "A note ends as contact 1 opens.", "would err least"] {
        assert!(said.contains(part), "{part}: {said}");
    }
    let edges = "time_us,key,contact,state\n1000000,C4,1,made\n1000250,C4,1,open\n1000500,C4,1,made\n\
                 1016400,C4,2,made\n1300000,C4,2,open\n1320000,C4,1,open\n1400000,sustain,1\n\
                 9000000,52,1,made\n9004000,52,2,made\n9100000,52,2,open\n9120000,52,1,open\n";
    folder.file("edges.csv", edges);
    let said = folder.good(&["live", "edges.csv", "--calibration", "contacts.toml", "--out-file", "notes.csv"]);
    assert!(said.contains("2 note-ons, 2 note-offs") && said.contains("2 changes of contacts that were"), "{said}");
    let notes = |name: &str| -> Vec<Vec<String>> {
        let text = folder.read(name);
        text.lines().skip(1).map(|line| line.split(',').map(str::to_owned).collect()).collect()
    };
    let simulated = notes("notes.csv");
    let speed = |rows: &[Vec<String>], i: usize| rows[i][3].parse::<f64>().unwrap();
    // About what the table says at 16.4 ms, and more than twice as fast.
    assert!((1.5..2.4).contains(&speed(&simulated, 0)) && speed(&simulated, 1) > 4.0, "{simulated:?}");
    folder.file("maker.csv", "between_ms,hammer_speed_m_per_s\n4,5\n16.4,1.25\n80,0.3\n");
    let own = ["calibrate", "--contacts", "3,6.5", "--contact-table", "maker.csv", "--out-file", "maker.toml"];
    folder.good(&own);
    folder.good(&["live", "edges.csv", "--calibration", "maker.toml", "--out-file", "own.csv"]);
    assert!((speed(&notes("own.csv"), 0) - 1.25).abs() < 1e-3 && (speed(&notes("own.csv"), 1) - 5.0).abs() < 1e-3);

    folder.file("falls.csv", "between_ms,hammer_speed_m_per_s\n4,5\n# faster\n16.4,6\n");
    folder.file("raw.csv", "time_us,key,raw\n0,40,1\n");
    for (arguments, part) in [
        (&["calibrate"][..], "READINGS.csv"),
        (&["calibrate", "--out-file", "o.toml", "--contacts", "3"], "--contacts: 1 contacts; expected 2 or 3"),
        (&["calibrate", "--out-file", "o.toml", "--contacts", "6,3"], "found 3 mm; expected depths"),
        (&["calibrate", "--out-file", "o.toml", "--contacts", "3,14"], "within the key's dip"),
        (
            &["calibrate", "--out-file", "o.toml", "--contacts", "3,6", "--scan-phases", "0,2000"],
            "--scan-phases: found 0.002 s",
        ),
        (
            &["calibrate", "--out-file", "o.toml", "--contacts", "3,6", "--scan-phases", "0"],
            "1 phases; expected one for each of 2",
        ),
        (
            &["calibrate", "--out-file", "o.toml", "--contacts", "3,6", "--contact-table", "falls.csv"],
            "falls.csv, line 4: point 2",
        ),
        (&["live", "edges.csv", "--out-file", "o.mid"], "calibrate --contacts"),
        (&["live", "edges.csv", "--calibration", "contacts.toml", "--ahead", "--out-file", "o.mid"], "--ahead"),
        (&["live", "raw.csv", "--calibration", "contacts.toml", "--out-file", "o.mid"], "time_us,key,contact,state"),
    ] {
        let said = Folder::words(&folder.bad(arguments));
        assert!(said.contains(part), "{arguments:?}: {said}");
    }
}

/// Hammers that rise to their strings and fall back, with a sensor at each key: calibrated by being held, played with
/// their releases; the same as rows without times; what does not fit is refused.
#[test]
fn sensed_hammers_become_notes() {
    let folder = Folder::new("live-hammers");
    // A head is brought to its string within 1.5 s and held there, and later thrown at 2 m/s; the key is down for 0.2
    // s.
    let rate = 2000.0;
    let head = |t: f64| match t - 3.0 {
        _ if (0.3..1.8).contains(&t) => (t - 0.3) / 1.5,
        _ if (1.8..2.1).contains(&t) => 1.0,
        t if (0.0..0.023).contains(&t) => t / 0.023,
        t if (0.023..0.05).contains(&t) => 1.0 - (t - 0.023) / 0.046,
        t if (0.05..0.25).contains(&t) => 0.41,
        t if (0.25..0.3).contains(&t) => 0.41 * (0.3 - t) / 0.05,
        _ => 0.0,
    };
    let key = |t: f64| match t - 3.0 {
        _ if (1.8..2.1).contains(&t) => 1.0,
        t if (0.0..0.025).contains(&t) => t / 0.025,
        t if (0.025..0.23).contains(&t) => 1.0,
        t if (0.23..0.28).contains(&t) => (0.28 - t) / 0.05,
        _ => 0.0,
    };
    let [mut timed, mut rows] = ["time_us,key,raw\n", "C4,C4:release\n"].map(str::to_owned);
    for k in 0..8000_u32 {
        let t = f64::from(k) / rate;
        let [head, key] = [3000.0 - 2000.0 * head(t), 100.0 + 800.0 * key(t)];
        timed.push_str(&format!("{},40,{head:.0}\n{},40:release,{key:.0}\n", 500 * k, 500 * k));
        rows.push_str(&format!("{head:.0},{key:.0}\n"));
    }
    folder.file("timed.csv", &timed);
    folder.file("rows.csv", &rows);
    folder.good(&["calibrate", "timed.csv", "--hammers", "--release-travel", "10", "--out-file", "a.toml"]);
    folder.good(&[
        "calibrate",
        "rows.csv",
        "--hammers",
        "--release-travel",
        "10",
        "--rate",
        "2000",
        "--out-file",
        "b.toml",
    ]);
    let profile = folder.read("a.toml");
    assert_eq!(profile, folder.read("b.toml"));
    for part in ["sensed = \"hammers\"", "travel_mm = 46", "rest = 3000", "release_pressed = 900"] {
        assert!(profile.contains(part), "{part}: {profile}");
    }
    let said = folder.good(&["live", "timed.csv", "--calibration", "a.toml", "--out-file", "timed-notes.csv"]);
    // Its own hand holds the head at the string without a speed: one note.
    assert!(said.contains("1 note-ons, 1 note-offs"), "{said}");
    let arguments = ["live", "rows.csv", "--calibration", "a.toml", "--rate", "2000", "--out-file", "rows-notes.csv"];
    folder.good(&arguments);
    let notes = folder.read("timed-notes.csv");
    assert_eq!(notes, folder.read("rows-notes.csv"));
    let row: Vec<&str> = notes.lines().nth(1).unwrap().split(',').collect();
    let number = |i: usize| row[i].parse::<f64>().unwrap();
    // 46 mm in 23 ms, less what gravity takes on the last millimetres.
    assert!((number(2) - 3.023).abs() < 1e-3 && (1.9..2.02).contains(&number(3)) && number(5) < 3.28, "{notes}");
    // The key comes up 10 mm in 50 ms.
    assert!((number(6) - 64.0).abs() < 3.0, "{notes}");

    folder.file("mm.csv", "time_s,key,mm\n0,40,1\n");
    folder.file("two.csv", "40,41\n1,2\n1,2,3\n");
    for (arguments, part) in [
        (&["live", "rows.csv", "--calibration", "a.toml", "--out-file", "o.mid"][..], "--rate HZ"),
        (&["live", "timed.csv", "--calibration", "a.toml", "--rate", "2000", "--out-file", "o.mid"], "no --rate"),
        (&["live", "mm.csv", "--calibration", "a.toml", "--out-file", "o.mid"], "one of hammers"),
        (&["live", "timed.csv", "--calibration", "a.toml", "--ahead", "--out-file", "o.mid"], "not of hammers"),
        (&["calibrate", "timed.csv"], "expected --hammers"),
        (&["calibrate", "timed.csv", "--hammers"], "--release-travel MM"),
        (&["calibrate", "two.csv", "--rate", "1000"], "two.csv, line 3: 3 cells; expected 2, as in the header"),
        (&["calibrate", "two.csv"], "--rate HZ"),
    ] {
        let said = Folder::words(&folder.bad(arguments));
        assert!(said.contains(part), "{arguments:?}: {said}");
    }
    // `check` knows what these commands read.
    let law = "m_per_s,velocity\n0.5,20\n5,110\n";
    for (name, text) in [("ruler.csv", "raw,mm\n1,0\n2,5\n"), ("law.csv", law)] {
        folder.file(name, text);
    }
    folder.file("maker.csv", "between_ms,hammer_speed_m_per_s\n4,5\n80,0.3\n");
    folder.file("faulty.csv", "between_ms,hammer_speed_m_per_s\n4,5\n80,7\n");
    folder.good(&["live", "timed.csv", "--calibration", "a.toml", "--out-file", "take.mid"]);
    for (name, part) in [
        ("timed.csv", "16000 samples of 1 key, 0 to 3.9995 s"),
        ("rows.csv", "16000 samples of 1 key, without times"),
        ("a.toml", "1 hammer, 1 with a sensor of releases"),
        ("ruler.csv", "erard calibrate --sensor-law ruler.csv"),
        ("law.csv", "erard play --law law.csv"),
        ("maker.csv", "erard calibrate --contact-table maker.csv"),
        ("take.mid", "1 note on 1 key,"),
    ] {
        let said = folder.good_words(&["check", name]);
        assert!(said.contains(part), "{name}: {said}");
    }
    assert!(Folder::words(&folder.bad(&["check", "faulty.csv"])).contains("faulty.csv, line 3: point 2"));
    assert!(Folder::words(&folder.bad(&["check", "law.mid"])).contains("law.mid"));
}
