//! Boards of contacts and of sensed hammers: the bytes are those of `erard live`, a refused call changes nothing,
//! nothing is allocated.

use std::fmt::Write as _;
use std::path::Path;
use std::ptr::{null, null_mut};
use std::sync::LazyLock;

use erard::{Action, Input, Instrument};
use erard_c::*;
use erard_live::contact_table::Presses;
use erard_live::contacts::{ContactLaw, Point, SpeedTable};
use erard_live::profile::{Profile, Release, Sensed, Stops};
use erard_live::sensor::Law;

use crate::board::{command, for_chips, live_of, sent};
use crate::last_error;
use crate::programs::{has, library};

const KEYS: usize = 3;
const FIRST: usize = 40;
const ROOM: usize = 88 * ERARD_BOARD_KEY_BYTES;
const DEPTHS_M: [f64; 2] = [3e-3, 6.5e-3];
const PERIOD_US: u32 = 250;

/// Contacts whose tables a simulated key has made.
static CONTACTS: LazyLock<ErardContacts> = LazyLock::new(|| {
    let mut contacts = untimed();
    let status = unsafe { erard_contacts_simulate(&raw mut contacts, null(), 0) };
    assert_eq!(status, ErardStatus::Ok, "{}", last_error());
    contacts
});

fn untimed() -> ErardContacts {
    ErardContacts {
        count: 2,
        depths_m: [DEPTHS_M[0], DEPTHS_M[1], 0.0],
        bounce_s: 2e-3,
        scan_period_s: 1e-6 * f64::from(PERIOD_US),
        ..ErardContacts::default()
    }
}

/// The law that they are.
fn law(contacts: &ErardContacts) -> ContactLaw {
    let table = |upper: usize| {
        let points = &contacts.points[upper][..contacts.point_count[upper] as usize];
        let point = |[between_s, hammer_speed_m_per_s, delay_s, touch_counts]: &[f64; 4]| Point {
            between_s: *between_s,
            hammer_speed_m_per_s: *hammer_speed_m_per_s,
            delay_s: *delay_s,
            touch_counts: *touch_counts,
        };
        SpeedTable::new(&points.iter().map(point).collect::<Vec<_>>()).unwrap()
    };
    ContactLaw {
        depths_m: contacts.depths_m,
        count: contacts.count as usize,
        tables: [table(0); 2],
        period_s: contacts.scan_period_s,
        phases_s: contacts.scan_phases_s,
        bounce_s: contacts.bounce_s,
        off: contacts.off as usize - 1,
    }
}

/// A key's press with a force for 0.3 s, then let go: travel of its front and rise of its hammer, m, every 50 us.
struct Press(Vec<[f64; 2]>);

impl Press {
    fn of(force_n: f64) -> Self {
        let mut action = Action::new(&Instrument::builtin("concert-grand").unwrap()).unwrap();
        let mut step = |n: u32| {
            let reading = action.step(if n < 6000 { Input::Force(force_n) } else { Input::Free });
            [reading.key_m, reading.hammer_rise_m]
        };
        Press((0..12_000).map(&mut step).collect())
    }

    /// Where key and hammer are at an instant after its beginning, us.
    fn at(&self, us: i64) -> [f64; 2] {
        let steps = us.clamp(0, 50 * 11_999) / 50;
        self.0[steps as usize]
    }
}

static PRESSES: LazyLock<[Press; 3]> = LazyLock::new(|| [2.0, 6.0, 20.0].map(Press::of));

/// Who presses what when: key, from 0, press, beginning, us. A chord at three levels, a repetition, and after eleven
/// seconds a key that is held at the end.
const PLAYED: [(usize, usize, u32); 6] =
    [(0, 0, 50_000), (1, 1, 60_000), (2, 2, 75_000), (0, 1, 700_000), (2, 0, 720_000), (1, 2, 12_000_000)];
const ENDS_US: u32 = 12_250_000;

/// Key and hammer of a key, from 0, at an instant, us, m.
fn place(key: usize, us: u32) -> [f64; 2] {
    let own = PLAYED.iter().filter(|(other, ..)| *other == key);
    own.fold([0.0; 2], |[x, y], (_, press, begins)| {
        let [key_m, rise_m] = PRESSES[*press].at(i64::from(us) - i64::from(*begins));
        [x + key_m, y + rise_m]
    })
}

/// An edge: instant, us, key, contact, from 1, and whether it closes.
type Edge = (u32, usize, usize, bool);

/// Edges of three keys with two contacts, which chatter for a scan when they change. Once the upper contact of a key
/// opens for a scan while it is held.
fn edges() -> Vec<Edge> {
    let mut all = Vec::new();
    let mut before = [[false; 2]; KEYS];
    let mut last_us = [[0; 2]; KEYS];
    for us in (0..ENDS_US).step_by(PERIOD_US as usize) {
        for key in 0..KEYS {
            let [key_m, _] = place(key, us);
            for contact in 0..2 {
                let (was, changed_us) = (&mut before[key][contact], &mut last_us[key][contact]);
                let is_made = key_m >= DEPTHS_M[contact];
                if is_made != *was {
                    (*was, *changed_us) = (is_made, us);
                    all.push((us, FIRST + key, contact + 1, is_made));
                } else if *changed_us > 0 && us == *changed_us + PERIOD_US {
                    all.push((us, FIRST + key, contact + 1, !is_made));
                } else if *changed_us > 0 && us == *changed_us + 2 * PERIOD_US {
                    all.push((us, FIRST + key, contact + 1, is_made));
                }
            }
        }
    }
    let glitch_us = 50_000 + 200_000;
    assert!(place(0, glitch_us)[0] > DEPTHS_M[1]);
    all.extend([(glitch_us, FIRST, 1, false), (glitch_us + PERIOD_US, FIRST, 1, true)]);
    all.sort_by_key(|(us, key, contact, _)| (*us, *key, *contact));
    all
}

fn edge_stream(edges: &[Edge]) -> String {
    let mut text = String::from("time_us,key,contact,state\n");
    for (us, key, contact, is_made) in edges {
        writeln!(text, "{us},{key},{contact},{}", if *is_made { "made" } else { "open" }).unwrap();
    }
    text
}

/// A memory for a board, and the board.
struct Board {
    memory: Vec<f64>,
    board: *mut ErardBoard,
}

fn setup() -> ErardBoardSetup {
    ErardBoardSetup { first_key: FIRST as u32, key_count: KEYS as u32, ..ErardBoardSetup::default() }
}

impl Board {
    fn made(
        bytes: usize,
        make: impl FnOnce(*mut std::ffi::c_void, *mut ErardStatus) -> *mut ErardBoard,
    ) -> Result<Self, ErardStatus> {
        let mut memory = vec![0.0_f64; bytes.div_ceil(8).max(1)];
        let mut status = ErardStatus::Internal;
        let board = make(memory.as_mut_ptr().cast(), &raw mut status);
        assert_eq!(board.is_null(), status != ErardStatus::Ok, "{}", last_error());
        if board.is_null() { Err(status) } else { Ok(Board { memory, board }) }
    }

    fn contacts(setup: &ErardBoardSetup, contacts: *const ErardContacts) -> Result<Self, ErardStatus> {
        let bytes = erard_board_contacts_bytes(setup.key_count);
        Board::made(bytes, |memory, status| unsafe { erard_board_contacts_new(memory, bytes, setup, contacts, status) })
    }

    fn hammers(
        setup: &ErardBoardSetup,
        stops: *const ErardStops,
        second: Option<(&ErardRelease, *const ErardStops)>,
    ) -> Result<Self, ErardStatus> {
        let bytes = erard_board_hammers_bytes(setup.key_count);
        let (release, second) = second.map_or((null(), null()), |(release, stops)| (&raw const *release, stops));
        Board::made(bytes, |memory, status| unsafe {
            erard_board_hammers_new(memory, bytes, setup, stops, release, second, status)
        })
    }

    fn heard(&self, call: impl FnOnce(*mut u8, usize, *mut usize) -> ErardStatus) -> Vec<u8> {
        let (mut midi, mut length) = ([0; ROOM], 0);
        assert_eq!(call(midi.as_mut_ptr(), ROOM, &raw mut length), ErardStatus::Ok);
        midi[..length].to_vec()
    }

    fn edge(&self, (us, key, contact, is_made): Edge) -> Vec<u8> {
        let (key, contact) = (key as u32, contact as u32);
        self.heard(|midi, room, length| unsafe {
            let time_s = 1e-6 * f64::from(us);
            erard_board_edge(self.board, time_s, key, contact, u32::from(is_made), midi, room, length)
        })
    }

    fn scan(&self, us: u32, heads: &[f32; KEYS], releases: Option<&[f32; KEYS]>) -> Vec<u8> {
        let second = releases.map_or(null(), |all| all.as_ptr());
        self.heard(|midi, room, length| unsafe {
            erard_board_scan_hammers(self.board, 1e-6 * f64::from(us), heads.as_ptr(), second, KEYS, midi, room, length)
        })
    }

    fn let_go(&self) -> Vec<u8> {
        self.heard(|midi, room, length| unsafe { erard_board_let_go(self.board, midi, room, length) })
    }

    fn read(&self, key: usize) -> ErardBoardKey {
        let mut state = ErardBoardKey::default();
        assert_eq!(unsafe { erard_board_read(self.board, key as u32, &raw mut state) }, ErardStatus::Ok);
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

/// Note-ons and note-offs.
fn counts(bytes: &[u8]) -> [usize; 2] {
    [0x90, 0x80].map(|kind| bytes.chunks(3).filter(|message| message[0] == kind).count())
}

fn example() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/contacts.c")
}

/// A file of edges through Rust's stream, the interface, the example in C and the command: the same bytes.
#[test]
fn edges_are_the_bytes_of_the_command() {
    let (edges, folder) = (edges(), tempfile::tempdir().expect("a folder"));
    let (text, profile) = (edge_stream(&edges), Profile::of_contacts(law(&CONTACTS)).text());
    let expected = live_of(&text, &profile, 1..89);
    assert_eq!(counts(&expected), [6, 6], "{expected:02x?}");
    let board = Board::contacts(&setup(), &raw const *CONTACTS).unwrap();
    let mut bytes: Vec<u8> = edges.iter().flat_map(|edge| board.edge(*edge)).collect();
    bytes.extend(board.let_go());
    assert_eq!(bytes, expected, "the interface");
    let own = board.read(FIRST);
    // Two presses of four changes, each of which is undone and done again; the upper contact that opens within the
    // first closes after the lower one.
    assert_eq!((own.bounces, own.swapped_contacts, own.asleep, own.lost_messages), (17, 1, 1, 0), "{own:?}");

    let file = folder.path().join("edges.csv");
    std::fs::write(&file, &text).unwrap();
    if has("cc") {
        assert_eq!(sent(folder.path(), &example(), &library("liberard_c.a"), &file), expected, "the example");
    }
    if let Some(bytes) = command(folder.path(), &file, &profile) {
        assert_eq!(bytes, expected, "the command");
    }
}

/// The tables that C makes are those of the command, and a profile holds all of their bits.
#[test]
#[ignore = "ci: a simulated key is pressed 240 times"]
fn the_tables_are_those_of_the_command() {
    let own = law(&CONTACTS);
    let instrument = erard::keyboard::Keyboard::builtin("concert-grand").unwrap().key(40).unwrap();
    let presses = Presses::of(&instrument, &mut |_| true).unwrap();
    let made = presses.law(&DEPTHS_M, own.period_s, own.bounce_s).unwrap();
    let read = Profile::parse(&Profile::of_contacts(made).text()).unwrap();
    let Sensed::Contacts(read) = read.sensed else { panic!("{read:?}") };
    for other in [made, *read] {
        assert_eq!((own.tables(), own.off, own.count), (other.tables(), other.off, other.count));
    }
}

/// A contact that stays changed after its bounces: the board goes on to an instant without an edge.
#[test]
fn a_board_goes_on_without_edges() {
    let board = Board::contacts(&setup(), &raw const *CONTACTS).unwrap();
    let press = [(0, 1, true), (9_000, 2, true), (100_000, 2, false), (110_000, 1, false)];
    let edge = |(us, contact, is_made): (u32, usize, bool)| board.edge((us, FIRST + 1, contact, is_made));
    let until = |us: u32| {
        let time_s = 1e-6 * f64::from(us);
        board.heard(|midi, room, length| unsafe { erard_board_until(board.board, time_s, midi, room, length) })
    };
    let all: Vec<u8> = press.into_iter().flat_map(edge).collect();
    assert_eq!((counts(&all), all[1]), ([1, 1], 61), "{all:02x?}");
    // The upper contact closes again within its bounces, and stays so; the lower one follows.
    assert!(edge((110_500, 1, true)).is_empty() && until(111_000).is_empty() && until(113_000).is_empty());
    assert_eq!(counts(&edge((125_000, 2, true))), [1, 0]);
    // It opens within the bounces of its closing: known when they are over.
    assert!(edge((126_000, 2, false)).is_empty() && edge((126_500, 1, false)).len() == 3);
    assert_eq!(board.read(FIRST + 1).bounces, 2);
    assert!(until(200_000).is_empty() && board.read(FIRST + 1).asleep == 1);
}

const REST: f64 = 3500.0;
const AT_STRING: f64 = 500.0;
static RELEASE: ErardRelease = ErardRelease { struct_size: 24, reserved: 0, travel_m: 10e-3, off_m: 4.3e-3 };
const UP: f64 = 200.0;
const DOWN: f64 = 3200.0;

static BLOW_M: LazyLock<f64> =
    LazyLock::new(|| erard_live::blow_m(&Instrument::builtin("concert-grand").unwrap()).unwrap().unwrap());

fn hammer_setup() -> ErardBoardSetup {
    ErardBoardSetup { travel_m: *BLOW_M, ..setup() }
}

fn heads() -> [ErardStops; KEYS] {
    [ErardStops { rest: REST, pressed: AT_STRING, ..ErardStops::default() }; KEYS]
}

/// The second sensors: one key has none.
fn releases() -> [ErardStops; KEYS] {
    let own = ErardStops { rest: UP, pressed: DOWN, ..ErardStops::default() };
    [own, own, ErardStops::default()]
}

/// Scans of three heads and keys, 2 kHz, with noise of a count either way: instant, us, and readings. Eleven seconds in
/// which nobody plays are left out but for their ends, and so is a second and a half while a key is held.
fn scans() -> Vec<(u32, [f32; KEYS], [f32; KEYS])> {
    let mut seed = 1_u32;
    let mut read = |share: f64, rest: f64, pressed: f64| {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let noise = f64::from(seed >> 30).min(2.0) - 1.0;
        (rest + share * (pressed - rest) + noise).round() as f32
    };
    let mut all = Vec::new();
    for us in (0..ENDS_US).step_by(500) {
        if (1_500_000..11_900_000).contains(&us) {
            continue;
        }
        let places: [[f64; 2]; KEYS] = std::array::from_fn(|key| place(key, us));
        let later_us = if us > 200_000 { 1_500_000 } else { 0 };
        let heads = places.map(|[_, rise_m]| read(rise_m / *BLOW_M, REST, AT_STRING));
        let releases = places.map(|[key_m, _]| read(key_m / 10e-3, UP, DOWN));
        all.push((us + later_us, heads, releases));
    }
    all
}

/// Readings of hammers through Rust's stream, the interface and the command: the same bytes, with second sensors and
/// without.
#[test]
fn hammers_are_the_bytes_of_the_command() {
    let (scans, folder) = (scans(), tempfile::tempdir().expect("a folder"));
    for has_release in [false, true] {
        let mut text = String::from("time_us,key,raw\n");
        for (us, heads, releases) in &scans {
            for key in 0..KEYS {
                writeln!(text, "{us},{},{}", FIRST + key, heads[key]).unwrap();
                if has_release && key < 2 {
                    writeln!(text, "{us},{}:release,{}", FIRST + key, releases[key]).unwrap();
                }
            }
        }
        let keys = |of: usize, rest: f64, pressed: f64| {
            (FIRST..FIRST + of).map(|key| (key, Stops { rest, pressed })).collect()
        };
        let second = (Release { travel_m: RELEASE.travel_m, off_m: RELEASE.off_m }, keys(2, UP, DOWN));
        let profile = Profile {
            sensed: Sensed::Hammers(has_release.then_some(second)),
            law: Law::Linear {},
            // As a profile holds it.
            travel_m: 1e-3 * ((1e9 * *BLOW_M).round() / 1e6),
            pressure_is_depth: false,
            keys: keys(KEYS, REST, AT_STRING),
        };
        let setup = ErardBoardSetup { travel_m: profile.travel_m, ..hammer_setup() };
        let expected = live_of(&text, &profile.text(), FIRST..FIRST + KEYS);
        let [ons, offs] = counts(&expected);
        assert!(ons == 6 && offs == 6, "{has_release}: {expected:02x?}");
        let seconds = releases();
        let second = has_release.then_some((&RELEASE, seconds.as_ptr()));
        let board = Board::hammers(&setup, heads().as_ptr(), second).unwrap();
        let of_scan = |(us, heads, releases): &(u32, [f32; KEYS], [f32; KEYS])| {
            board.scan(*us, heads, has_release.then_some(releases))
        };
        let mut bytes: Vec<u8> = scans.iter().flat_map(of_scan).collect();
        bytes.extend(board.let_go());
        assert_eq!(bytes, expected, "the interface, {has_release}");
        let own = board.read(FIRST + 2);
        assert!(own.fastest_hammer_m_per_s > 3.0 && own.nearest_m < 1e-3 && own.lost_messages == 0, "{own:?}");
        let file = folder.path().join("heads.csv");
        std::fs::write(&file, &text).unwrap();
        if let Some(bytes) = command(folder.path(), &file, &profile.text()) {
            assert_eq!(bytes, expected, "the command, {has_release}");
        }
    }
}

/// Whatever is wrong with a call, it is refused, every byte of the board is as it was, and the board plays on as one
/// that was never asked.
#[test]
fn a_refused_edge_changes_nothing() {
    let [asked, other] = [(); 2].map(|()| Board::contacts(&setup(), &raw const *CONTACTS).unwrap());
    let edges = edges();
    let (begin, rest) = edges.split_at(9);
    let plays = |board: &Board, edges: &[Edge]| edges.iter().flat_map(|edge| board.edge(*edge)).collect::<Vec<u8>>();
    assert_eq!(plays(&asked, begin), plays(&other, begin));
    let (before, now_s) = (asked.bits(), 1e-6 * f64::from(begin[8].0));
    let (mut midi, mut length) = ([7_u8; ROOM], 77_usize);
    let (at, long) = (midi.as_mut_ptr(), &raw mut length);
    let key = FIRST as u32;
    let edge = |time_s: f64, key: u32, contact: u32, is_made: u32| unsafe {
        erard_board_edge(asked.board, time_s, key, contact, is_made, at, ROOM, long)
    };
    let readings = [0.0_f32; KEYS];
    let points = [[0.0, 0.0], [1.0, 1.0]];
    let needed = KEYS * ERARD_BOARD_KEY_BYTES;
    let found = unsafe {
        [
            (edge(f64::NAN, key, 1, 1), ErardStatus::NotFinite),
            (edge(f64::INFINITY, key, 1, 1), ErardStatus::NotFinite),
            (edge(now_s - 1e-6, key, 1, 1), ErardStatus::Range),
            (edge(-1.0, key, 1, 1), ErardStatus::Range),
            (edge(1.0, key - 1, 1, 1), ErardStatus::NoSuch),
            (edge(1.0, key + KEYS as u32, 1, 1), ErardStatus::NoSuch),
            (edge(1.0, 0, 1, 1), ErardStatus::NoSuch),
            (edge(1.0, u32::MAX, 1, 1), ErardStatus::NoSuch),
            (edge(1.0, key, 0, 1), ErardStatus::NoSuch),
            (edge(1.0, key, 3, 1), ErardStatus::NoSuch),
            (edge(1.0, key, u32::MAX, 1), ErardStatus::NoSuch),
            (edge(1.0, key, 1, 2), ErardStatus::Argument),
            (erard_board_edge(null_mut(), 1.0, key, 1, 1, at, ROOM, long), ErardStatus::Null),
            (erard_board_edge(asked.board, 1.0, key, 1, 1, null_mut(), ROOM, long), ErardStatus::Null),
            (erard_board_edge(asked.board, 1.0, key, 1, 1, at, ROOM, null_mut()), ErardStatus::Null),
            (erard_board_edge(asked.board, 1.0, key, 1, 1, at, needed - 1, long), ErardStatus::Size),
            (erard_board_until(asked.board, now_s - 1e-6, at, ROOM, long), ErardStatus::Range),
            (erard_board_until(asked.board, f64::NAN, at, ROOM, long), ErardStatus::NotFinite),
            (erard_board_until(null_mut(), 1.0, at, ROOM, long), ErardStatus::Null),
            // Of other boards.
            (erard_board_scan(asked.board, 1.0, readings.as_ptr(), KEYS, at, ROOM, long), ErardStatus::Argument),
            (
                erard_board_scan_hammers(asked.board, 1.0, readings.as_ptr(), null(), KEYS, at, ROOM, long),
                ErardStatus::Argument,
            ),
            (erard_board_sensor_table(asked.board, points.as_ptr(), 2), ErardStatus::Argument),
        ]
    };
    all_refused(&found, (&midi, length), (&asked, &before));
    assert_eq!(plays(&asked, rest), plays(&other, rest));
}

/// Each call ended as expected; neither the bytes of MIDI, their length nor the board changed.
fn all_refused(
    found: &[(ErardStatus, ErardStatus)],
    (midi, length): (&[u8; ROOM], usize),
    (board, before): (&Board, &[u64]),
) {
    for (n, (found, expected)) in found.iter().enumerate() {
        assert_eq!(found, expected, "call {n}");
    }
    assert_eq!((midi, length), (&[7; ROOM], 77), "nothing is written");
    assert_eq!(board.bits(), before, "every byte is as it was");
}

#[test]
fn a_refused_scan_of_hammers_changes_nothing() {
    let seconds = releases();
    let [asked, other] = [(); 2]
        .map(|()| Board::hammers(&hammer_setup(), heads().as_ptr(), Some((&RELEASE, seconds.as_ptr()))).unwrap());
    let scans = scans();
    let (begin, rest) = scans.split_at(260);
    let plays = |board: &Board, scans: &[(u32, [f32; KEYS], [f32; KEYS])]| {
        scans.iter().flat_map(|(us, heads, releases)| board.scan(*us, heads, Some(releases))).collect::<Vec<u8>>()
    };
    assert_eq!(plays(&asked, begin), plays(&other, begin));
    let (before, now_s) = (asked.bits(), 1e-6 * f64::from(begin[259].0));
    let (mut midi, mut length) = ([7_u8; ROOM], 77_usize);
    let (at, long) = (midi.as_mut_ptr(), &raw mut length);
    let (good, bad) = ([3500.0_f32; KEYS], [3500.0, 3500.0, f32::NAN]);
    let scan = |time_s: f64, heads: *const f32, releases: *const f32, count: usize| unsafe {
        erard_board_scan_hammers(asked.board, time_s, heads, releases, count, at, ROOM, long)
    };
    let (own, none) = (good.as_ptr(), null());
    let found = unsafe {
        [
            (scan(f64::NAN, own, none, KEYS), ErardStatus::NotFinite),
            (scan(now_s, own, own, KEYS), ErardStatus::Range),
            (scan(9.0, bad.as_ptr(), none, KEYS), ErardStatus::NotFinite),
            (scan(9.0, own, bad.as_ptr(), KEYS), ErardStatus::NotFinite),
            (scan(9.0, none, own, KEYS), ErardStatus::Null),
            (scan(9.0, own, own, KEYS + 1), ErardStatus::Size),
            (scan(9.0, own, own, 0), ErardStatus::Size),
            (erard_board_scan_hammers(null_mut(), 9.0, own, own, KEYS, at, ROOM, long), ErardStatus::Null),
            (erard_board_scan_hammers(asked.board, 9.0, own, own, KEYS, at, 10, long), ErardStatus::Size),
            (erard_board_edge(asked.board, 9.0, FIRST as u32, 1, 1, at, ROOM, long), ErardStatus::Argument),
            (erard_board_until(asked.board, 9.0, at, ROOM, long), ErardStatus::Argument),
        ]
    };
    all_refused(&found, (&midi, length), (&asked, &before));
    assert_eq!(plays(&asked, rest), plays(&other, rest));
}

/// What no board is made of is refused, with a text that names the field.
#[test]
fn contacts_and_hammers_that_no_board_has() {
    let good = &*CONTACTS;
    type Change = fn(&mut ErardContacts);
    let wrong: [(Change, ErardStatus, &str); 16] = [
        (|c| c.count = 1, ErardStatus::Argument, "count"),
        (|c| c.count = u32::MAX, ErardStatus::Argument, "count"),
        (|c| c.off = 0, ErardStatus::Argument, "found contact 0"),
        (|c| c.off = 2, ErardStatus::Argument, "above the lowest"),
        (|c| c.count = 3, ErardStatus::Range, "depths"),
        (|c| c.depths_m[1] = 2e-3, ErardStatus::Range, "depths"),
        (|c| c.depths_m[0] = f64::NAN, ErardStatus::NotFinite, "depth"),
        (|c| c.scan_period_s = -1e-3, ErardStatus::Range, "expected 0 to 0.1 s"),
        (|c| c.scan_phases_s[1] = 1e-3, ErardStatus::Range, "a phase within the period"),
        (|c| c.bounce_s = f64::INFINITY, ErardStatus::NotFinite, "time"),
        (|c| c.point_count[0] = 1, ErardStatus::Argument, "1 points"),
        (|c| c.point_count[0] = u32::MAX, ErardStatus::Argument, "points"),
        (|c| c.points[0][1][1] = 9.0, ErardStatus::Range, "point 2"),
        (|c| c.points[0][1][0] = f64::NAN, ErardStatus::NotFinite, "a point"),
        (|c| c.struct_size = 8, ErardStatus::Struct, "contacts"),
        (|c| c.struct_size = u32::MAX, ErardStatus::Struct, "contacts"),
    ];
    for (change, status, word) in wrong {
        let mut contacts = *good;
        change(&mut contacts);
        assert_eq!(Board::contacts(&setup(), &raw const contacts).err(), Some(status), "{word}");
        assert!(last_error().contains(word), "{word}: {}", last_error());
    }
    assert_eq!(Board::contacts(&setup(), null()).err(), Some(ErardStatus::Null));
    let travels = ErardBoardSetup { travel_m: 0.01, ..setup() };
    assert_eq!(Board::contacts(&travels, good).err(), Some(ErardStatus::Argument));
    assert!(last_error().contains("travel_m; expected 0 for contacts"), "{}", last_error());
    let many = ErardBoardSetup { key_count: 88, ..setup() };
    assert_eq!(Board::contacts(&many, good).err(), Some(ErardStatus::NoSuch));
    for mut contacts in [untimed(), ErardContacts { depths_m: [6e-3, 6.1e-3, 0.0], ..untimed() }] {
        contacts.depths_m[1] = if contacts.depths_m[0] < 5e-3 { 14e-3 } else { 2e-3 };
        let before = contacts;
        assert_eq!(unsafe { erard_contacts_simulate(&raw mut contacts, null(), 0) }, ErardStatus::Range);
        assert_eq!(contacts, before);
    }
    assert_eq!(unsafe { erard_contacts_simulate(null_mut(), null(), 0) }, ErardStatus::Null);

    let (own, seconds) = (heads(), releases());
    let second =
        |release: ErardRelease| Board::hammers(&hammer_setup(), own.as_ptr(), Some((&release, seconds.as_ptr()))).err();
    for (release, status) in [
        (ErardRelease { travel_m: 1.0, ..RELEASE }, ErardStatus::Range),
        (ErardRelease { off_m: 0.0, ..RELEASE }, ErardStatus::Range),
        (ErardRelease { off_m: 10e-3, ..RELEASE }, ErardStatus::Range),
        (ErardRelease { off_m: f64::NAN, ..RELEASE }, ErardStatus::NotFinite),
        (ErardRelease { struct_size: 4, ..RELEASE }, ErardStatus::Struct),
    ] {
        assert_eq!(second(release), Some(status), "{release:?}");
    }
    let bytes = erard_board_hammers_bytes(KEYS as u32);
    let with =
        |setup: ErardBoardSetup, stops: *const ErardStops, release: *const ErardRelease, second: *const ErardStops| {
            Board::made(bytes, |memory, status| unsafe {
                erard_board_hammers_new(memory, bytes, &raw const setup, stops, release, second, status)
            })
            .err()
        };
    assert_eq!(with(hammer_setup(), own.as_ptr(), null(), seconds.as_ptr()), Some(ErardStatus::Null));
    assert_eq!(with(hammer_setup(), own.as_ptr(), &raw const RELEASE, null()), Some(ErardStatus::Null));
    assert_eq!(with(hammer_setup(), null(), null(), null()), Some(ErardStatus::Null));
    assert_eq!(with(setup(), own.as_ptr(), null(), null()), Some(ErardStatus::Range));
    let stepped = ErardBoardSetup { step_s: 50e-6, ..hammer_setup() };
    assert_eq!(with(stepped, own.as_ptr(), null(), null()), Some(ErardStatus::Argument));
    let mut stuck = own;
    stuck[1].pressed = REST;
    assert_eq!(with(hammer_setup(), stuck.as_ptr(), null(), null()), Some(ErardStatus::Range));
    for bytes in [erard_board_contacts_bytes, erard_board_hammers_bytes] {
        assert_eq!((bytes(0), bytes(89), bytes(88) > 88 * 100), (0, 0, true));
    }
    let short = Board::made(bytes, |memory, status| unsafe {
        erard_board_hammers_new(memory, bytes - 1, &hammer_setup(), own.as_ptr(), null(), null(), status)
    });
    assert_eq!(short.err(), Some(ErardStatus::Size));
}

/// From their making to their end nothing is allocated; a board that was reset is as new; laws and pedals are those of
/// other boards.
#[test]
fn boards_that_simulate_nothing_take_no_heap() {
    let (edges, scans, seconds) = (edges(), scans(), releases());
    let contacts = &*CONTACTS;
    let (own, points, law) = (heads(), [[0.0, 0.0], [0.5, 0.4], [1.0, 1.0]], [[0.1, 1.0], [8.0, 127.0]]);
    let (setup, hammer_setup) = (setup(), hammer_setup());
    let bytes = [erard_board_contacts_bytes(3), erard_board_hammers_bytes(3)];
    let mut memory = bytes.map(|bytes| vec![0.0_f64; bytes.div_ceil(8)]);
    let mut heard = [[[0_u8; 128]; 3]; 2];
    let mut used = [[0; 3]; 2];
    let (mut midi, mut length) = ([0_u8; ROOM], 0);
    let counted = allocation_counter::measure(|| unsafe {
        let places = [memory[0].as_mut_ptr().cast(), memory[1].as_mut_ptr().cast()];
        let boards = [
            erard_board_contacts_new(places[0], bytes[0], &raw const setup, contacts, null_mut()),
            erard_board_hammers_new(
                places[1],
                bytes[1],
                &raw const hammer_setup,
                own.as_ptr(),
                &raw const RELEASE,
                seconds.as_ptr(),
                null_mut(),
            ),
        ];
        for round in 0..3 {
            for (kind, &board) in boards.iter().enumerate() {
                let out = (midi.as_mut_ptr(), ROOM, &raw mut length);
                let mut keep = |midi: &[u8]| {
                    heard[kind][round][used[kind][round]..used[kind][round] + midi.len()].copy_from_slice(midi);
                    used[kind][round] += midi.len();
                };
                if kind == 0 {
                    for (us, key, contact, is_made) in &edges {
                        let (key, contact, is_made) = (*key as u32, *contact as u32, u32::from(*is_made));
                        let at_s = 1e-6 * f64::from(*us);
                        assert_eq!(erard_board_until(board, at_s, out.0, out.1, out.2), ErardStatus::Ok);
                        keep(&midi[..length]);
                        erard_board_edge(board, at_s, key, contact, is_made, out.0, out.1, out.2);
                        keep(&midi[..length]);
                    }
                } else {
                    for (us, heads, releases) in &scans {
                        let (heads, releases) = (heads.as_ptr(), releases.as_ptr());
                        let at_s = 1e-6 * f64::from(*us);
                        erard_board_scan_hammers(board, at_s, heads, releases, KEYS, out.0, out.1, out.2);
                        keep(&midi[..length]);
                    }
                }
                assert_eq!(erard_board_pedal(board, 64, 1.0, out.0, out.1, out.2), ErardStatus::Ok);
                keep(&midi[..length]);
                assert_eq!(erard_board_let_go(board, out.0, out.1, out.2), ErardStatus::Ok);
                keep(&midi[..length]);
                assert_eq!(erard_board_reset(board), ErardStatus::Ok);
                if round == 1 {
                    assert_eq!(erard_board_velocity_table(board, law.as_ptr(), 2), ErardStatus::Ok);
                    let status = erard_board_sensor_table(board, points.as_ptr(), 3);
                    assert_eq!(status == ErardStatus::Ok, kind == 1);
                }
            }
        }
        boards.into_iter().for_each(|board| erard_board_free(board));
    });
    assert_eq!((counted.count_total, counted.bytes_total), (0, 0), "{counted:?}");
    for kind in 0..2 {
        let said = |round: usize| &heard[kind][round][..used[kind][round]];
        assert_eq!(said(0), said(1), "a board that was reset is as new");
        // Six notes and a pedal that goes down and up.
        assert_eq!((counts(said(0)), said(0).len()), ([6, 6], 42), "{:02x?}", said(0));
        assert_eq!(said(2).len(), 42);
        assert!(said(0)[2] != said(2)[2], "another law");
    }
}

mod nightly {
    use super::*;

    /// The same example with its tables as a constant, linked with the library for chips: the same bytes.
    #[test]
    #[ignore = "nightly: compiles the library for chips"]
    fn the_library_for_chips_sends_the_same_bytes() {
        if !has("cc") {
            return;
        }
        let (folder, text) = (tempfile::tempdir().expect("a folder"), edge_stream(&edges()));
        let expected = live_of(&text, &Profile::of_contacts(law(&CONTACTS)).text(), 1..89);
        let rows = CONTACTS.points[0].iter().map(|row| {
            let [a, b, c, d] = row;
            format!("{{{a:e}, {b:e}, {c:e}, {d:e}}}")
        });
        let made = format!(
            "    contacts.off = {}, contacts.point_count[0] = {};\n    static const double points[24][4] = {{{}}};\n    \
             memcpy(contacts.points[0], points, sizeof points);\n",
            CONTACTS.off,
            CONTACTS.point_count[0],
            rows.collect::<Vec<_>>().join(", ")
        );
        let source = std::fs::read_to_string(example()).unwrap();
        let is_simulated = |line: &&str| line.contains("erard_contacts_simulate");
        assert_eq!(source.lines().filter(is_simulated).count(), 1);
        let constant: String =
            source.lines().map(|line| if is_simulated(&line) { made.clone() } else { format!("{line}\n") }).collect();
        let (program, file) = (folder.path().join("constant.c"), folder.path().join("edges.csv"));
        std::fs::write(&program, constant).unwrap();
        std::fs::write(&file, &text).unwrap();
        assert_eq!(sent(folder.path(), &program, &for_chips(folder.path()), &file), expected);
    }
}
