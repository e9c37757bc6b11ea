//! Keys with sensors: the bytes are those of `erard live`, a refused call changes nothing, nothing is allocated.

use std::fmt::Write as _;
use std::path::Path;
use std::process::{Command, Stdio};
use std::ptr::{null, null_mut};

use erard::{Action, Input, Instrument};
use erard_c::*;
use erard_live::profile::Profile;
use erard_live::stream::{Head, Reader};
use erard_live::{Event, Live, Options, SensorKind};
use erard_midi::{Message, Resolution, Velocity, note_of_key};

use crate::last_error;
use crate::not_run::not_run;
use crate::programs::{has, library, run};

const FIRST: usize = 40;
const KEYS: usize = 3;
const ROOM: usize = KEYS * ERARD_BOARD_KEY_BYTES;
const REST: f64 = 3500.0;
const PRESSED: f64 = 700.0;
const PERIOD_S: f64 = 1e-3;

/// A memory for a board of the three keys.
struct Board {
    memory: Vec<f64>,
    board: *mut ErardBoard,
}

fn setup() -> ErardBoardSetup {
    ErardBoardSetup { first_key: FIRST as u32, key_count: KEYS as u32, travel_m: 0.01, ..ErardBoardSetup::default() }
}

fn stops() -> [ErardStops; KEYS] {
    [ErardStops { rest: REST, pressed: PRESSED, ..ErardStops::default() }; KEYS]
}

impl Board {
    fn new(setup: &ErardBoardSetup, stops: &[ErardStops]) -> Result<Self, ErardStatus> {
        let bytes = erard_board_bytes(setup.key_count.clamp(1, 88));
        assert!(bytes > 0 && align_of::<f64>().is_multiple_of(erard_board_alignment()));
        let mut memory = vec![0.0_f64; bytes.div_ceil(8)];
        let mut status = ErardStatus::Internal;
        let (place, stops) = (memory.as_mut_ptr().cast(), stops.as_ptr());
        let board = unsafe { erard_board_new(place, bytes, setup, stops, null(), 0, &raw mut status) };
        assert_eq!(board.is_null(), status != ErardStatus::Ok, "{}", last_error());
        if board.is_null() { Err(status) } else { Ok(Board { memory, board }) }
    }

    fn scan(&self, time_s: f64, readings: &[f32; KEYS]) -> Vec<u8> {
        let (mut midi, mut length) = ([0; ROOM], 0);
        let status = unsafe {
            erard_board_scan(self.board, time_s, readings.as_ptr(), KEYS, midi.as_mut_ptr(), ROOM, &raw mut length)
        };
        assert_eq!(status, ErardStatus::Ok, "{time_s} s");
        midi[..length].to_vec()
    }

    fn let_go(&self) -> Vec<u8> {
        let (mut midi, mut length) = ([0; ROOM], 0);
        let status = unsafe { erard_board_let_go(self.board, midi.as_mut_ptr(), ROOM, &raw mut length) };
        assert_eq!(status, ErardStatus::Ok);
        midi[..length].to_vec()
    }

    fn read(&self, key: u32) -> ErardBoardKey {
        let mut state = ErardBoardKey::default();
        assert_eq!(unsafe { erard_board_read(self.board, key, &raw mut state) }, ErardStatus::Ok);
        state
    }

    fn bits(&self) -> Vec<u64> {
        self.memory.iter().map(|number| number.to_bits()).collect()
    }
}

impl Drop for Board {
    fn drop(&mut self) {
        unsafe { erard_board_free(self.board) };
    }
}

/// Travels of a key that is pressed with a force for 0.3 s and let go, mm, every millisecond.
fn press(force_n: f64) -> Vec<f64> {
    let mut action = Action::new(&Instrument::builtin("concert-grand").unwrap()).unwrap();
    let mut step = |n: u32| action.step(if n < 6000 { Input::Force(force_n) } else { Input::Free }).key_m;
    let all: Vec<f64> = (0..12_000).map(|n| 1e3 * step(n)).collect();
    all.into_iter().step_by(20).collect()
}

/// Scans of three keys: instant, us, and readings of whole counts, with noise of a count either way. A chord at three
/// levels, a repetition, a key that is down at once as no hand puts it there, a gap of 1.5 s while it is held, and a
/// key that is held at the end.
fn scans() -> Vec<(u32, [f32; KEYS])> {
    let presses = [2.0, 6.0, 20.0].map(press);
    let at = |press: &[f64], frame: u32, from: u32| {
        frame.checked_sub(from).and_then(|k| press.get(k as usize)).copied().unwrap_or(0.0).max(0.0)
    };
    let mut seed = 1_u32;
    let mut noise = || {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(seed >> 30).min(2.0) - 1.0
    };
    let mut all = Vec::new();
    for frame in 0..2400_u32 {
        let mm = [
            at(&presses[0], frame, 50) + at(&presses[1], frame, 700),
            at(&presses[1], frame, 60) + if (1400..2000).contains(&frame) { 9.5 } else { 0.0 },
            at(&presses[2], frame, 75) + at(&presses[1], (frame).min(2350), 2200),
        ];
        // The stream stops for 1.5 s while the second key is held.
        let time_us = 1000 * frame + if frame >= 1700 { 1_500_000 } else { 0 };
        all.push((time_us, mm.map(|mm| (REST - 280.0 * mm + noise()).round() as f32)));
    }
    all
}

fn stream(scans: &[(u32, [f32; KEYS])]) -> String {
    let mut text = String::from("time_us,key,raw\n");
    for (time_us, readings) in scans {
        for (k, reading) in readings.iter().enumerate() {
            writeln!(text, "{time_us},{},{reading}", FIRST + k).unwrap();
        }
    }
    text
}

fn profile() -> String {
    let keys =
        (FIRST..FIRST + KEYS).map(|key| format!("\n[[key]]\nnumber = {key}\nrest = {REST}\npressed = {PRESSED}\n"));
    let head = "format = \"erard-sensors/1\"\ntravel_mm = 10\n\n[law]\nkind = \"linear\"\n";
    format!("{head}{}", keys.collect::<String>())
}

/// The bytes that `erard live` sends for a stream: its keys, and its messages.
fn live(stream: &str) -> Vec<u8> {
    live_of(stream, &profile(), FIRST..FIRST + KEYS)
}

/// The bytes that `erard live` sends for a stream with a profile, whose keys are these.
pub(crate) fn live_of(stream: &str, profile: &str, moved: std::ops::Range<usize>) -> Vec<u8> {
    let profile = Profile::parse(profile).unwrap();
    let mut lines = stream.lines();
    let mut reader = Reader::new(Head::parse(lines.next().unwrap()).unwrap());
    let options = Options {
        sensor: SensorKind::Action,
        quantity: reader.quantity(),
        sensor_at_m: None,
        travel_m: None,
        ahead: false,
        moved: Some(moved.collect()),
        threads: 2,
    };
    let instruments = erard::keyboard::Keyboard::builtin("concert-grand").unwrap().instruments().unwrap();
    let mut keys = Live::new(&instruments, Some(&profile), options, &mut |_| true).unwrap();
    let mut bytes = Vec::new();
    let mut send = |event: Event| {
        let message = match event {
            Event::On { key, velocity, .. } => {
                Message::note_on(0, note_of_key(key).unwrap(), velocity, Resolution::SevenBits)
            }
            Event::Off { key, release, .. } => {
                let release = release.unwrap_or(Velocity::of_seven_bits(64));
                Message::note_off(0, note_of_key(key).unwrap(), release, Resolution::SevenBits)
            }
            Event::Pedal { .. } => unreachable!("there is no pedal"),
        };
        bytes.extend_from_slice(message.bytes());
    };
    for line in lines {
        for sample in reader.samples(line).unwrap() {
            keys.take(&sample, &mut send);
        }
    }
    keys.let_go(&mut send);
    bytes
}

/// What a program in C, linked with a library, sends for a file.
pub(crate) fn sent(folder: &Path, source: &Path, library: &Path, input: &Path) -> Vec<u8> {
    let (program, root) = (folder.join("program"), env!("CARGO_MANIFEST_DIR"));
    let mut cc = Command::new("cc");
    cc.args(["-std=c99", "-O1", "-Wall", "-Wextra", "-Werror", "-pedantic"]);
    cc.arg(format!("-I{root}/include")).arg(source).arg(library);
    run(cc.args(["-lpthread", "-ldl", "-lm", "-o"]).arg(&program));
    let stdin = Stdio::from(std::fs::File::open(input).unwrap());
    let output = Command::new(&program).stdin(stdin).output().expect("it runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    output.stdout
}

/// What the example in C, linked with a library, sends for a file.
fn example(folder: &Path, library: &Path, readings: &Path) -> Vec<u8> {
    sent(folder, &Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/board.c"), library, readings)
}

/// What the command sends for a stream with a profile, where it was built beside this test.
pub(crate) fn command(folder: &Path, stream: &Path, profile: &str) -> Option<Vec<u8>> {
    let test = std::env::current_exe().unwrap();
    let command = test.parent().and_then(Path::parent).map(|folder| folder.join("erard")).filter(|path| path.exists());
    let Some(command) = command else {
        not_run("no command `erard` beside this test");
        return None;
    };
    std::fs::write(folder.join("profile.toml"), profile).unwrap();
    let mut live = Command::new(command);
    live.current_dir(folder).arg("live").arg(stream);
    run(live.args(["--calibration", "profile.toml", "-o", "notes.bin", "--force"]));
    Some(std::fs::read(folder.join("notes.bin")).unwrap())
}

/// The example in C sends the bytes of the command, byte for byte: a chord, a repetition, a keystroke that is limited
/// to 8 m/s, a gap in the stream, a key that is held at the end.
#[test]
fn the_example_sends_the_bytes_of_the_command() {
    let (scans, folder) = (scans(), tempfile::tempdir().expect("a folder"));
    let text = stream(&scans);
    let expected = live(&text);
    let [ons, offs] = [0x90, 0x80].map(|kind| expected.chunks(3).filter(|message| message[0] == kind).count());
    assert!(ons >= 6 && ons == offs, "{expected:02x?}");
    let readings = folder.path().join("readings.csv");
    std::fs::write(&readings, &text).unwrap();

    // From Rust, through the same functions.
    let board = Board::new(&setup(), &stops()).unwrap();
    let mut bytes: Vec<u8> =
        scans.iter().flat_map(|(time_us, all)| board.scan(1e-6 * f64::from(*time_us), all)).collect();
    bytes.extend(board.let_go());
    assert_eq!(bytes, expected, "the interface");
    let switched = board.read(41);
    // Down at once, and once more after the gap, through which it was held.
    assert_eq!((switched.limited_strokes, switched.lost_messages), (2, 0), "{switched:?}");
    assert!(switched.fastest_hammer_m_per_s <= 1.001 * 8.0 && switched.asleep == 1, "{switched:?}");

    // From C.
    if has("cc") {
        assert_eq!(example(folder.path(), &library("liberard_c.a"), &readings), expected, "the example");
    }

    // The command itself.
    if let Some(bytes) = command(folder.path(), &readings, &profile()) {
        assert_eq!(bytes, expected, "the command");
    }
}

/// Plays 150 scans of a loud press, from a scan on.
fn plays(board: &Board, from: u32) -> Vec<u8> {
    let press = press(20.0);
    let reading = |k: u32| (REST - 280.0 * press[k as usize % press.len()]).round() as f32;
    let scan = |k: u32| board.scan(PERIOD_S * f64::from(from + k), &[reading(k), REST as f32, REST as f32]);
    (0..150).flat_map(scan).collect()
}

/// Whatever is wrong with a call, it is refused, every byte of the board is as it was, and the board plays on as one
/// that was never asked.
#[test]
fn a_refused_call_changes_nothing() {
    let [asked, other] = [(); 2].map(|()| Board::new(&setup(), &stops()).unwrap());
    assert_eq!(plays(&asked, 0), plays(&other, 0));
    let before = asked.bits();
    let (mut midi, mut length) = ([7_u8; ROOM], 77_usize);
    let readings = [REST as f32; KEYS];
    let scan = |time_s: f64, readings: *const f32, count, midi: *mut u8, room, length: *mut usize| unsafe {
        erard_board_scan(asked.board, time_s, readings, count, midi, room, length)
    };
    let (bytes, at, good) = (midi.as_mut_ptr(), &raw mut length, readings.as_ptr());
    let bad = [REST as f32, f32::NAN, REST as f32];
    let far = [REST as f32, f32::INFINITY, REST as f32];
    let rising = [[0.0, 0.0], [0.6, 0.5], [0.5, 0.9], [1.0, 1.0]];
    let slow = [[1.0, 50.0], [0.5, 60.0]];
    let mut state = ErardBoardKey::default();
    let found = unsafe {
        [
            (scan(PERIOD_S * 149.0, good, KEYS, bytes, ROOM, at), ErardStatus::Range),
            (scan(-1.0, good, KEYS, bytes, ROOM, at), ErardStatus::Range),
            (scan(f64::NAN, good, KEYS, bytes, ROOM, at), ErardStatus::NotFinite),
            (scan(1.0, bad.as_ptr(), KEYS, bytes, ROOM, at), ErardStatus::NotFinite),
            (scan(1.0, far.as_ptr(), KEYS, bytes, ROOM, at), ErardStatus::NotFinite),
            (scan(1.0, good, KEYS - 1, bytes, ROOM, at), ErardStatus::Size),
            (scan(1.0, good, KEYS, bytes, ROOM - 1, at), ErardStatus::Size),
            (scan(1.0, null(), KEYS, bytes, ROOM, at), ErardStatus::Null),
            (scan(1.0, good, KEYS, null_mut(), ROOM, at), ErardStatus::Null),
            (scan(1.0, good, KEYS, bytes, ROOM, null_mut()), ErardStatus::Null),
            (erard_board_let_go(asked.board, bytes, ROOM - 1, at), ErardStatus::Size),
            (erard_board_pedal(asked.board, 65, 1.0, bytes, ROOM, at), ErardStatus::Argument),
            (erard_board_pedal(asked.board, 64, f64::NAN, bytes, ROOM, at), ErardStatus::NotFinite),
            (erard_board_pedal(asked.board, 64, 1.0, bytes, 2, at), ErardStatus::Size),
            (erard_board_sensor_table(asked.board, rising.as_ptr(), 4), ErardStatus::Argument),
            (erard_board_sensor_table(asked.board, rising.as_ptr(), 1), ErardStatus::Argument),
            (erard_board_sensor_table(asked.board, null(), 4), ErardStatus::Null),
            (erard_board_velocity_table(asked.board, slow.as_ptr(), 2), ErardStatus::Argument),
            (erard_board_read(asked.board, 39, &raw mut state), ErardStatus::NoSuch),
            (erard_board_read(asked.board, 43, &raw mut state), ErardStatus::NoSuch),
            (erard_board_read(asked.board, 40, null_mut()), ErardStatus::Null),
            (erard_board_scan(null_mut(), 1.0, good, KEYS, bytes, ROOM, at), ErardStatus::Null),
        ]
    };
    for (n, (found, expected)) in found.into_iter().enumerate() {
        assert_eq!(found, expected, "call {n}");
    }
    assert_eq!((midi, length), ([7; ROOM], 77), "nothing is written");
    assert_eq!(asked.bits(), before, "every byte is as it was");
    assert_eq!(plays(&asked, 200), plays(&other, 200));
}

/// What no board is made of is refused, with a text that names the field.
#[test]
fn setups_that_no_board_has() {
    let good = setup();
    let at = |change: fn(&mut ErardBoardSetup)| {
        let mut setup = good;
        change(&mut setup);
        Board::new(&setup, &stops()).err()
    };
    type Change = fn(&mut ErardBoardSetup);
    let wrong: [(Change, ErardStatus, &str); 17] = [
        (|s| s.first_key = 0, ErardStatus::NoSuch, "first_key"),
        (|s| s.first_key = 87, ErardStatus::NoSuch, "first_key"),
        (|s| s.key_count = 0, ErardStatus::NoSuch, "key_count"),
        (|s| s.key_count = u32::MAX, ErardStatus::NoSuch, "key_count"),
        (|s| s.kind = 2, ErardStatus::Argument, "kind"),
        (|s| s.sensor_law = 3, ErardStatus::Argument, "sensor_law"),
        (|s| s.sensor_law = ERARD_SENSOR_HALL, ErardStatus::Range, "nearest_m"),
        (|s| s.velocity_law = 3, ErardStatus::Argument, "velocity_law"),
        (|s| s.velocity_law = ERARD_VELOCITY_LINEAR, ErardStatus::Range, "velocity_full_m_per_s"),
        (|s| s.velocity_bits = 16, ErardStatus::Argument, "velocity_bits"),
        (|s| s.channel = 16, ErardStatus::Argument, "channel"),
        (|s| s.travel_m = 10.0, ErardStatus::Range, "travel_m"),
        (|s| s.travel_m = f64::NAN, ErardStatus::NotFinite, "travel_m"),
        (|s| s.still = -1.0, ErardStatus::Range, "still"),
        (|s| s.step_s = 2e-3, ErardStatus::Range, "step_s"),
        (|s| s.sensor_at_m = 2.0, ErardStatus::Range, "sensor_at_m"),
        (|s| s.struct_size = 8, ErardStatus::Struct, "setup"),
    ];
    for (change, status, word) in wrong {
        assert_eq!(at(change), Some(status), "{word}");
        assert!(last_error().contains(word), "{word}: {}", last_error());
    }
    for (rest, pressed, status) in
        [(f64::NAN, 1.0, ErardStatus::NotFinite), (5.0, 5.0, ErardStatus::Range), (1e300, 1.0, ErardStatus::Range)]
    {
        let mut stops = stops();
        (stops[2].rest, stops[2].pressed) = (rest, pressed);
        assert_eq!(Board::new(&good, &stops).err(), Some(status), "{rest} {pressed}");
    }
    let mut memory = vec![0.0_f64; erard_board_bytes(3) / 8 + 2];
    let mut status = ErardStatus::Ok;
    let mut new = |offset: usize, bytes: usize| {
        let place = unsafe { memory.as_mut_ptr().byte_add(offset) }.cast();
        let board =
            unsafe { erard_board_new(place, bytes, &raw const good, stops().as_ptr(), null(), 0, &raw mut status) };
        assert!(board.is_null());
        status
    };
    assert_eq!(new(0, erard_board_bytes(3) - 1), ErardStatus::Size);
    assert_eq!(new(4, erard_board_bytes(3)), ErardStatus::Argument);
    assert_eq!((erard_board_bytes(0), erard_board_bytes(89)), (0, 0));
    unsafe { erard_board_free(null_mut()) };
}

/// Pedals, laws, a key without a sensor, reset; and in all of them nothing is allocated.
#[test]
fn a_board_plays_without_a_heap() {
    let mut only = stops();
    (only[1].rest, only[1].pressed) = (0.0, 0.0);
    let board = Board::new(&ErardBoardSetup { channel: 9, velocity_bits: 14, ..setup() }, &only).unwrap();
    let presses = press(20.0);
    let (mut midi, mut length) = ([0_u8; ROOM], 0_usize);
    let points = [[0.5, 1.0], [8.0, 127.0]];
    let sensor = [[0.0, 0.0], [1.0, 1.0]];
    let mut kept = [[0_u8; 64]; 3];
    let mut used = [0; 3];
    let mut state = ErardBoardKey::default();
    let counted = allocation_counter::measure(|| unsafe {
        for round in 0..3 {
            for (k, mm) in presses.iter().enumerate() {
                let readings = [(REST - 280.0 * mm).round() as f32, 12.0, REST as f32];
                let (at, count) = (PERIOD_S * k as f64, readings.len());
                let out = (midi.as_mut_ptr(), ROOM, &raw mut length);
                let status = erard_board_scan(board.board, at, readings.as_ptr(), count, out.0, out.1, out.2);
                assert_eq!(status, ErardStatus::Ok);
                kept[round][used[round]..used[round] + length].copy_from_slice(&midi[..length]);
                used[round] += length;
            }
            for down in [1.0, 1.0] {
                erard_board_pedal(board.board, 64, down, midi.as_mut_ptr(), ROOM, &raw mut length);
                kept[round][used[round]..used[round] + length].copy_from_slice(&midi[..length]);
                used[round] += length;
            }
            erard_board_let_go(board.board, midi.as_mut_ptr(), ROOM, &raw mut length);
            kept[round][used[round]..used[round] + length].copy_from_slice(&midi[..length]);
            used[round] += length;
            erard_board_read(board.board, 40, &raw mut state);
            assert_eq!(erard_board_reset(board.board), ErardStatus::Ok);
            if round == 1 {
                assert_eq!(erard_board_velocity_table(board.board, points.as_ptr(), 2), ErardStatus::Ok);
                assert_eq!(erard_board_sensor_table(board.board, sensor.as_ptr(), 2), ErardStatus::Ok);
            }
        }
    });
    assert_eq!((counted.count_total, counted.bytes_total), (0, 0), "{counted:?}");
    let said = |round: usize| &kept[round][..used[round]];
    // Controller 88, note-on, controller 88, note-off, pedal down, pedal up, all on the tenth channel.
    let heads: Vec<[u8; 2]> = said(0).chunks(3).map(|message| [message[0], message[1]]).collect();
    assert_eq!(heads, [[0xB9, 88], [0x99, 60], [0xB9, 88], [0x89, 60], [0xB9, 64], [0xB9, 64]], "{:02x?}", said(0));
    assert_eq!(said(0), said(1), "a board that was reset is as new");
    // 52 + 25 log2 v against 1 at 0.5 m/s and 127 at 8 m/s, log2 between: 1 + 31.5 (log2 v + 1).
    let counts = |round: usize| f64::from(said(round)[5]) + f64::from(said(round)[2]) / 128.0;
    let log2 = (counts(0) - 52.0) / 25.0;
    assert!((counts(2) - (1.0 + 31.5 * (log2 + 1.0))).abs() < 0.02, "{} {}", counts(0), counts(2));
    let mut none = ErardBoardKey::default();
    assert_eq!(unsafe { erard_board_read(board.board, 41, &raw mut none) }, ErardStatus::NoSuch);
    assert!(state.fastest_hammer_m_per_s > 1.0 && state.limited_strokes == 0, "{state:?}");
}

/// The stops that C finds are those of `erard calibrate`.
#[test]
fn stops_are_those_of_the_command() {
    let mm = press(6.0);
    let rest = std::iter::repeat_n(0.0, 600);
    let all: Vec<f32> = rest
        .clone()
        .chain(mm.iter().copied())
        .chain(rest)
        .enumerate()
        .map(|(n, mm)| (3000.0 - 200.0 * mm + f64::from(n as u32 % 3)).round() as f32)
        .collect();
    let mut stops = ErardStops::default();
    let calibrate = |readings: &[f32], stops: &mut ErardStops| unsafe {
        erard_board_calibrate(40, readings.as_ptr(), readings.len(), PERIOD_S, stops)
    };
    assert_eq!(calibrate(&all, &mut stops), ErardStatus::Ok, "{}", last_error());
    let readings = all.iter().enumerate().map(|(n, reading)| [n as f64 * PERIOD_S, f64::from(*reading)]).collect();
    let readings = erard_live::calibrate::Readings { all: readings };
    let found = erard_live::calibrate::stops(&[(40, readings)].into()).unwrap()[&40];
    let same = [stops.rest, stops.pressed, stops.noise, stops.drift];
    assert_eq!(same, [found.stops.rest, found.stops.pressed, found.noise, found.drift]);
    assert!((stops.rest - 3001.0).abs() < 1.0 && (stops.pressed - 1080.0).abs() < 60.0, "{stops:?}");
    for (readings, word) in [(&all[..10], "10 readings"), (&[7.0; 400][..], "stuck"), (&all[..601], "key 40")] {
        let before = stops;
        assert_eq!(calibrate(readings, &mut stops), ErardStatus::Argument);
        assert!(last_error().contains(word) && stops == before, "{word}: {}", last_error());
    }
}

/// The library for chips, compiled for this machine in a folder.
pub(crate) fn for_chips(folder: &Path) -> std::path::PathBuf {
    let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    cargo.args(["rustc", "--release", "--lib", "--crate-type", "staticlib", "--manifest-path"]);
    cargo.arg(format!("{}/../firmware/Cargo.toml", env!("CARGO_MANIFEST_DIR")));
    run(cargo.arg("--target-dir").arg(folder));
    folder.join("release/liberard_firmware.a")
}

mod nightly {
    use super::*;

    /// The messages of a note: kinds and velocities.
    fn of_note(bytes: &[u8], note: u8) -> Vec<[u8; 2]> {
        bytes.chunks(3).filter(|message| message[1] == note).map(|message| [message[0], message[2]]).collect()
    }

    /// The same example with the same header, linked with the library for chips, which is compiled for this machine: in
    /// single precision and steps of 250 us, without a heap, it sends the same notes; those of a middle C, whose action
    /// is its only one, within one of the velocities.
    #[test]
    #[ignore = "nightly: compiles the library for chips"]
    fn the_library_for_chips_sends_the_same_notes() {
        if !has("cc") {
            return;
        }
        let folder = tempfile::tempdir().expect("a folder");
        let (text, readings) = (stream(&scans()), folder.path().join("readings.csv"));
        std::fs::write(&readings, &text).unwrap();
        let (found, expected) = (example(folder.path(), &for_chips(folder.path()), &readings), live(&text));
        for note in 60..63 {
            let [found, expected] = [&found, &expected].map(|bytes| of_note(bytes, note));
            println!("{note}: {found:02x?} {expected:02x?}");
            let kinds = |all: &[[u8; 2]]| all.iter().map(|[kind, _]| *kind).collect::<Vec<_>>();
            assert_eq!(kinds(&found), kinds(&expected), "note {note}");
            let ons = found.iter().zip(&expected).filter(|(one, _)| one[0] == 0x90);
            let farthest = ons.map(|(one, other)| one[1].abs_diff(other[1])).max();
            assert!(note != 60 || farthest <= Some(1), "note {note}: {found:?} {expected:?}");
        }
    }
}
