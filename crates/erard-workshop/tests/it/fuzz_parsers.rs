//! Tens of thousands of damaged files: nothing panics, every error points into its text, and accepted files are sound.
//!
//! The damage is deterministic, so that a failure repeats; `fuzz/` holds the same targets for a coverage-guided fuzzer.

use std::path::Path;

use erard::instrument::{Curve, FileError, Instrument, InstrumentFile};
use erard::keyboard::Keyboard;
use erard::stroke::{Cursor, MAX_FORCE_N, MAX_POSITION_M, Series, StrokeError};
use erard_kinematics::LinkageFile;
use fastrand::Rng;

use crate::common::generated;

const CLOCK: &str = include_str!("../../../erard-core/tests/instruments/escapement.toml");
const STROKE: &str = "# a short stroke\ntime_s,force_N,position_m,note\n0,0,0,\n0.001,0.5,0.0002,on\n0.0025,1.25,0.001,\n\
                      0.01,3e0,0.004,\"a, b\"\n0.02,5,0.009,\n0.05,0,0.0098,off\n";

/// Random numbers, the same every time.
struct Chance(Rng);

impl Chance {
    fn new(seed: u64) -> Self {
        Chance(Rng::with_seed(seed))
    }

    fn below(&mut self, n: usize) -> usize {
        self.0.usize(..n.max(1))
    }

    fn pick<'a, T: ?Sized>(&mut self, choices: &[&'a T]) -> &'a T {
        choices[self.below(choices.len())]
    }
}

/// Tokens that often break parsers.
const NASTY: [&str; 40] = [
    "nan",
    "inf",
    "-inf",
    "-0.0",
    "0",
    "-1",
    "1e308",
    "1e-308",
    "5e-324",
    "9223372036854775808",
    "[",
    "]",
    "{",
    "}",
    "[[",
    "]]",
    "=",
    "\"",
    "'''",
    "\"\"\"",
    "\\u0000",
    "\u{feff}",
    "\r",
    "\n\n",
    "#",
    ",",
    ".",
    "ground",
    "body",
    "\u{0}",
    "é",
    "\u{1f3b9}",
    "true",
    "1979-05-27T07:32:00Z",
    "0x_",
    "{ value = 1 }",
    "time_s",
    "force_N",
    ";",
    "\t",
];

/// Damages a text in one to eight places: bytes flipped, inserted, deleted; tokens and lines swapped, doubled,
/// replaced.
fn damaged(good: &str, chance: &mut Chance) -> Vec<u8> {
    let mut bytes = good.as_bytes().to_vec();
    for _ in 0..=chance.below(8) {
        let at = chance.below(bytes.len());
        match chance.below(9) {
            0 if !bytes.is_empty() => bytes[at] ^= 1 << chance.below(8),
            1 => bytes.insert(at, chance.below(256) as u8),
            2 => drop(bytes.drain(at..(at + 1 + chance.below(20)).min(bytes.len()))),
            3 => bytes.truncate(at),
            4 => {
                let nasty = chance.pick(&NASTY);
                bytes.splice(at..at, nasty.bytes());
            }
            5 | 6 => {
                // A whole token: up to the next separator.
                let separator = |byte: &u8| b" \n,=[]{}\"".contains(byte);
                let start = bytes[..at].iter().rposition(separator).map_or(0, |i| i + 1);
                let end = bytes[at..].iter().position(separator).map_or(bytes.len(), |i| at + i);
                let token = if chance.below(2) == 0 {
                    chance.pick(&NASTY).as_bytes().to_vec()
                } else {
                    let words: Vec<&str> = good.split_ascii_whitespace().collect();
                    words[chance.below(words.len())].as_bytes().to_vec()
                };
                bytes.splice(start..end.max(start), token);
            }
            _ => {
                let mut lines: Vec<Vec<u8>> = bytes.split(|&byte| byte == b'\n').map(<[u8]>::to_vec).collect();
                let (a, b) = (chance.below(lines.len()), chance.below(lines.len()));
                match chance.below(3) {
                    0 => lines.swap(a, b),
                    1 => lines.insert(a, lines[b].clone()),
                    _ => drop(lines.remove(a)),
                }
                bytes = lines.join(&b'\n');
            }
        }
    }
    bytes
}

/// The guarantees of [`Instrument`].
fn assert_sound(instrument: &Instrument) {
    let finite = |numbers: &[f64]| assert!(numbers.iter().all(|x| x.is_finite()), "{instrument:?}");
    let bodies = instrument.bodies.len();
    assert!((1..=12).contains(&bodies) && instrument.zones.len() <= 32);
    finite(&[instrument.gravity_m_per_s2, instrument.finger.stiffness_n_per_m, instrument.finger.damping_n_s_per_m]);
    for (index, body) in instrument.bodies.iter().enumerate() {
        assert!(body.parent.is_none_or(|parent| parent < index));
        assert!(instrument.bodies[..index].iter().all(|other| other.name != body.name));
        finite(&[body.angle_rad, body.friction_torque_n_m, body.viscous_n_m_s]);
        finite(&body.pivot_m);
        let [x, y] = body.center_of_mass_m;
        assert!(body.mass_kg > 0.0 && body.inertia_kg_m2 >= body.mass_kg * (x * x + y * y) * (1.0 - 1e-8));
        assert!(body.inertia_kg_m2.is_finite() && body.friction_torque_n_m >= 0.0 && body.viscous_n_m_s >= 0.0);
    }
    for spring in &instrument.springs {
        assert!(spring.body < bodies && spring.stiffness_n_m_per_rad >= 0.0);
        finite(&[spring.torque_n_m, spring.stiffness_n_m_per_rad]);
    }
    for zone in &instrument.zones {
        assert!(zone.disc_body != zone.curve_body);
        assert!(zone.disc_body.is_none_or(|body| body < bodies) && zone.curve_body.is_none_or(|body| body < bodies));
        finite(&zone.disc_center_m);
        finite(&[zone.felt.stiffness, zone.felt.exponent]);
        finite(&zone.felt.loss.numbers());
        assert!(zone.felt.loss.numbers().iter().all(|x| *x >= 0.0));
        finite(&[zone.friction_coefficient]);
        assert!(zone.disc_radius_m >= 0.0 && zone.friction_coefficient >= 0.0);
        assert!(zone.felt.stiffness >= 0.0 && zone.felt.exponent >= 1.0);
        match zone.curve {
            Curve::Line { point_m, normal } => {
                finite(&point_m);
                assert!((normal[0].hypot(normal[1]) - 1.0).abs() < 1e-12);
            }
            Curve::Segment { from_m, to_m, rounding_m } => {
                finite(&[from_m, to_m].concat());
                assert!(from_m != to_m && rounding_m >= 0.0);
            }
            Curve::Disc { center_m, radius_m } => {
                finite(&center_m);
                assert!(radius_m + zone.disc_radius_m > 0.0);
            }
        }
    }
    let roles = &instrument.roles;
    assert!(roles.key.is_none_or(|body| body < bodies && instrument.finger.stiffness_n_per_m > 0.0));
    assert!(roles.hammer.is_none_or(|body| body < bodies));
    let single = [roles.key_bottom, roles.string, roles.let_off, roles.check];
    let many = [&roles.knuckle, &roles.transmits, &roles.stops];
    for &zone in single.iter().flatten().chain(many.into_iter().flatten()) {
        assert!(zone < instrument.zones.len());
    }
    let mut turned = instrument.clone();
    for index in 0..instrument.screws.len() {
        let _ = turned.turn(index, 1e-4);
    }
    assert!(instrument.parts.iter().all(|part| part.outline_m.len() >= 3));
}

fn assert_helpful(error: &FileError) {
    assert!(error.text.get(error.span.clone()).is_some(), "the span cuts a character: {error:?}");
    assert!(error.line <= error.text.split('\n').count());
    assert!((error.line == 0) == (error.column == 0));
    assert!(!error.message.is_empty() && !error.to_string().contains('\n'), "{error}");
}

/// Returns how many of the mutants can be read.
fn damage_instrument(good: &str, mutants: usize, seed: u64) -> usize {
    let mut chance = Chance::new(seed);
    (0..mutants)
        .filter(|_| match InstrumentFile::parse_bytes(&damaged(good, &mut chance), "mutant.toml") {
            Ok(file) => {
                assert_sound(&file.instrument);
                assert!(file.provenance.numbers.iter().all(|number| !number.key.is_empty() && number.line > 0));
                true
            }
            Err(error) => {
                assert_helpful(&error);
                false
            }
        })
        .count()
}

#[test]
fn damaged_clocks() {
    damage_clocks(2_000);
}

#[test]
#[ignore = "ci: 30 000 mutants"]
fn many_damaged_clocks() {
    damage_clocks(30_000);
}

fn damage_clocks(mutants: usize) {
    let read = damage_instrument(CLOCK, mutants, 0x9e37_79b9_7f4a_7c15);
    // Both kinds must occur, or the damage is too light or too heavy for a test.
    assert!((mutants / 100..mutants * 29 / 30).contains(&read), "{read} of {mutants} read");
}

#[test]
fn damaged_grands() {
    damage_grands(200);
}

#[test]
#[ignore = "ci: 4 000 mutants"]
fn many_damaged_grands() {
    damage_grands(4_000);
}

fn damage_grands(mutants: usize) {
    let grand = Instrument::builtin_text("concert-grand").expect("a text");
    let read = damage_instrument(grand, mutants, 0x2545_f491_4f6c_dd1d);
    assert!((mutants / 100..mutants * 39 / 40).contains(&read), "{read} of {mutants} read");
}

/// Accepted linkages have finite levers, and either complete their stroke or report where it stops.
#[test]
fn damaged_linkages() {
    damage_linkages(2_000);
}

#[test]
#[ignore = "ci: 20 000 mutants"]
fn many_damaged_linkages() {
    damage_linkages(20_000);
}

fn damage_linkages(mutants: usize) {
    let good = LinkageFile::builtin_text("c7f-like").expect("a text");
    let mut chance = Chance::new(0x0bad_cafe_dead_beef);
    let (mut read, mut moved) = (0, 0);
    for _ in 0..mutants {
        let bytes = damaged(good, &mut chance);
        let file = match LinkageFile::parse_bytes(&bytes, "mutant.toml") {
            Ok(file) => file,
            Err(error) => {
                assert_helpful(&error);
                continue;
            }
        };
        read += 1;
        assert!(file.levers.lengths.to_array().iter().all(|length| length.is_finite()));
        assert!(file.levers.key_front > 0.0 && file.blow_m > file.let_off_m && file.let_off_m >= 0.0);
        let Ok(case) = file.design().and_then(|design| design.case(&[], Default::default())) else { continue };
        moved += 1;
        let stroke = case.stroke(0.0, 0.010, 5);
        assert!(stroke.poses.iter().all(|pose| pose.residual < 1e-12 && pose.leverage.is_finite()));
        assert_eq!(stroke.stop.is_none(), stroke.poses.len() == 6);
        assert!(case.digest().start.leverage.is_finite());
    }
    let fair = mutants / 100..mutants * 19 / 20;
    assert!(fair.contains(&read) && moved > mutants / 200, "{read} of {mutants} read, {moved} moved");
}

/// A keyboard of clocks: every kind of grading, on an instrument that is quick to read.
const KEYBOARD: &str = r#"format = "erard-keyboard/1"
name = "Clocks"
instrument = "escapement.toml"
instrument_key = 40
[sources.mine]
title = "made up"
[[added_mass]]
name = "bob"
body = "pendulum"
at_mm = { value = [0, -190], source = "mine", certainty = "estimate" }
mass_g = [{ key = 1, value = 20, source = "mine", certainty = "estimate" }, { key = 40, value = 0 }, { key = 88, value = -5 }]
[[factor]]
name = "felt"
numbers = ["zone.bench.felt.stiffness_N_per_m_r", "zone.pallet_lever.disc.radius_mm"]
factor = [{ key = 40, value = 1 }, { key = 88, value = 2.5, source = "mine", certainty = "read", note = "so" }]
[[shift]]
name = "bench"
points = ["zone.bench.line.point_mm"]
direction = [0, 1]
by_mm = [{ key = 1, value = -1.5 }, { key = 40, value = 0 }]
"#;

/// Accepted keyboards have curves that are finite at every key, and give sound instruments or report the error.
#[test]
fn damaged_keyboards() {
    damage_keyboards(1_000);
}

#[test]
#[ignore = "ci: 20 000 mutants"]
fn many_damaged_keyboards() {
    damage_keyboards(20_000);
}

fn damage_keyboards(mutants: usize) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../erard-core/tests/instruments");
    assert!(Keyboard::parse(KEYBOARD, "good.toml", &folder).is_ok_and(|k| k.instruments().is_ok()));
    let mut chance = Chance::new(0x0f1e_2d3c_4b5a_6978);
    let (mut read, mut sound) = (0, 0);
    for _ in 0..mutants {
        let bytes = damaged(KEYBOARD, &mut chance);
        match Keyboard::parse_bytes(&bytes, "mutant.toml", &folder) {
            Ok(keyboard) => {
                read += 1;
                for key in [1, keyboard.base_key, 88] {
                    assert!(keyboard.gradings.iter().all(|grading| grading.curve.at(key).is_finite()));
                    match keyboard.key(key) {
                        Ok(instrument) => {
                            assert_sound(&instrument);
                            sound += 1;
                        }
                        Err(error) => assert_helpful(&error),
                    }
                }
            }
            Err(error) => assert_helpful(&error),
        }
    }
    let fair = mutants / 200..mutants * 19 / 20;
    assert!(fair.contains(&read) && sound > mutants / 200, "{read} of {mutants} read, {sound} keys are sound");
}

#[test]
fn damaged_strokes() {
    damage_strokes(5_000);
}

#[test]
#[ignore = "ci: 60 000 mutants"]
fn many_damaged_strokes() {
    damage_strokes(60_000);
}

fn damage_strokes(mutants: usize) {
    let mut chance = Chance::new(0x1234_5678_9abc_def1);
    let mut read = 0;
    for _ in 0..mutants {
        let bytes = damaged(STROKE, &mut chance);
        match Series::read(bytes.as_slice(), "mutant.csv") {
            Ok(series) => {
                assert_stroke_sound(&series);
                read += 1;
            }
            Err(error) => assert_stroke_error_helpful(&error, &bytes),
        }
    }
    assert!((mutants / 100..mutants * 29 / 30).contains(&read), "{read} of {mutants} read");
}

fn assert_stroke_sound(series: &Series) {
    let times = series.times_s();
    assert!(times.len() >= 2 && times.windows(2).all(|pair| pair[0] < pair[1]));
    assert!(series.force.is_some() || series.position.is_some());
    let (start, end) = (series.start_s(), series.end_s());
    let mut cursor = Cursor::default();
    for i in -2..=42 {
        let t = start + (end - start) * f64::from(i) / 40.0;
        if let Some(force) = &series.force {
            assert!(force.at(t, &mut cursor).abs() <= MAX_FORCE_N);
        }
        if let Some(position) = &series.position {
            let (y, v, a) = position.at(t, &mut cursor);
            assert!(y.is_finite() && v.is_finite() && a.is_finite());
            assert!(position.positions_m().iter().all(|y| y.abs() <= MAX_POSITION_M));
        }
    }
}

fn assert_stroke_error_helpful(error: &StrokeError, bytes: &[u8]) {
    assert!(error.line <= bytes.split(|&byte| byte == b'\n').count() as u64);
    assert!(!error.message.is_empty() && !error.to_string().contains('\n'), "{error}");
}

/// Seeds of the fuzzers' corpus: files that were special for each parser, one for every message and a few that can be
/// read. A coverage-guided fuzzer starts with them; here they are ordinary tests. `.ci/regenerate fuzz-seeds`
/// rewrites the folder.
#[test]
fn the_corpus_reads_or_is_refused_with_a_reason() {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let (corpus, instruments) = (here.join("../../fuzz/seeds"), here.join("../erard-core/tests/instruments"));
    let linkage = LinkageFile::builtin_text("c7f-like").expect("a text");
    // The report on an input; `read` if it can be read.
    let told = |target: &str, bytes: &[u8]| -> String {
        let of = |error: Box<FileError>| {
            assert_helpful(&error);
            error.message.clone()
        };
        match target {
            "instrument" => match InstrumentFile::parse_bytes(bytes, "corpus.toml") {
                Ok(file) => {
                    assert_sound(&file.instrument);
                    "read".to_owned()
                }
                Err(error) => of(error),
            },
            "linkage" => LinkageFile::parse_bytes(bytes, "corpus.toml").map_or_else(of, |_| "read".to_owned()),
            "keyboard" => match Keyboard::parse_bytes(bytes, "corpus.toml", &instruments) {
                Ok(keyboard) => keyboard.key(88).map_or_else(of, |key| {
                    assert_sound(&key);
                    "read".to_owned()
                }),
                Err(error) => of(error),
            },
            _ => match Series::read(bytes, "corpus.csv") {
                Ok(series) => {
                    assert_stroke_sound(&series);
                    "read".to_owned()
                }
                Err(error) => {
                    assert_stroke_error_helpful(&error, bytes);
                    error.message.clone()
                }
            },
        }
    };
    for (target, good) in [("instrument", CLOCK), ("linkage", linkage), ("keyboard", KEYBOARD), ("stroke", STROKE)] {
        let folder = corpus.join(target);
        if let Some(root) = generated::rewritten_below() {
            let _ = std::fs::remove_dir_all(root.join("fuzz/seeds").join(target));
            let (mut chance, mut messages) = (Chance::new(0x00c0_ffee), std::collections::BTreeMap::new());
            for _ in 0..20_000 {
                let bytes = damaged(good, &mut chance);
                // Without digits and names, which vary.
                let kind: String = told(target, &bytes).chars().filter(|c| !c.is_ascii_digit()).take(24).collect();
                let kept = messages.entry(kind).or_insert_with(|| bytes.clone());
                if bytes.len() < kept.len() {
                    *kept = bytes;
                }
            }
            let read = messages.remove("read");
            for (n, bytes) in read.iter().chain(messages.values()).take(40).enumerate() {
                generated::write(&root, &format!("fuzz/seeds/{target}/{n:02}"), bytes);
            }
            continue;
        }
        let mut messages = std::collections::BTreeSet::new();
        for entry in std::fs::read_dir(&folder).expect("the corpus is there") {
            let bytes = std::fs::read(entry.expect("an entry").path()).expect("a file");
            messages.insert(told(target, &bytes));
        }
        assert!(messages.len() >= 10 && messages.contains("read"), "{target}: {messages:?}");
    }
}
