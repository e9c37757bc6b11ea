//! The functions for pages that play, beside a control loop: strokes as `erard press` plays them, the instants of a
//! press, where parts touch, dials.

use std::ffi::{CStr, CString};
use std::ptr::{null, null_mut};

use erard::instrument::InstrumentFile;
use erard::level::{DURATION_S, HandKind, MASS_KG, Reference, named};
use erard::mechanism::Halving;
use erard::run::{Setup, press_by_hand};
use erard::stroke::{NUANCES, Touch};
use erard::{Instrument, Run};
use erard_c::*;
use serde_json::{Value, json};

use crate::{Action, last_error, taken};

struct Owned(*mut ErardInstrument);

impl Owned {
    fn grand() -> Self {
        let instrument = unsafe { erard_instrument_new(null(), 0, null_mut()) };
        assert!(!instrument.is_null(), "{}", last_error());
        Owned(instrument)
    }

    fn text(&self) -> String {
        taken(unsafe { erard_instrument_text(self.0, null_mut(), null_mut()) })
    }
}

impl Drop for Owned {
    fn drop(&mut self) {
        unsafe { erard_instrument_free(self.0) };
    }
}

fn pressed(instrument: &Instrument, nuance: &str, touch: Touch) -> Run {
    let kind = HandKind::new(touch, MASS_KG);
    let mut reference = Reference::new(instrument, &mut |_| true).unwrap();
    let found = reference.solve(kind, named(nuance).unwrap(), &mut |_| true).unwrap();
    let setup = Setup { record_every: Some(1), ..Setup::new(DURATION_S) };
    press_by_hand(instrument, &found.whole(), &setup, &mut |_| true).unwrap()
}

/// Ten strokes, every row: angles, key and hammer to the bit, and the instants that a run finds; the forces are those
/// of the last step, which a row centres on its instant by the next step's.
#[test]
fn strokes_are_those_of_press() {
    let (grand, native) = (Owned::grand(), Instrument::builtin("concert-grand").unwrap());
    let detector = unsafe { erard_event_detector_new(grand.0, null_mut()) };
    for nuance in NUANCES {
        for touch in [Touch::Pressed, Touch::Struck] {
            let run = pressed(&native, nuance, touch);
            let action = Action::grand();
            let called = CString::new(nuance).unwrap();
            let struck = u32::from(touch == Touch::Struck);
            let stroke = unsafe { erard_stroke_builtin(grand.0, called.as_ptr(), struck, null_mut()) };
            assert!(!stroke.is_null(), "{}", last_error());
            let mut force_before = 0.0;
            let mut reading = ErardReading::default();
            let mut contacts = vec![0.0; 5 * native.zones.len()];
            unsafe {
                assert_eq!(erard_event_detector_reset(detector), ErardStatus::Ok);
                assert_eq!(erard_action_record_contacts(action.0), ErardStatus::Ok);
                assert_eq!(erard_event_detector_observe(detector, action.0), ErardStatus::Ok);
            }
            for row in 1..run.time_s.len() {
                unsafe {
                    assert!(erard_action_step_stroke(action.0, stroke, &raw mut reading) as i32 >= 0);
                    assert_eq!(erard_event_detector_observe(detector, action.0), ErardStatus::Ok);
                }
                let expected: Vec<u64> = run.bodies.iter().map(|body| body.angle_rad[row].to_bits()).collect();
                assert_eq!(action.angles(), expected, "{nuance} {} row {row}", touch.name());
                assert_eq!(reading.key_m.to_bits(), run.key_m[row].to_bits());
                assert_eq!(reading.hammer_rise_m.to_bits(), run.hammer_rise_m[row].to_bits());
                if row > 1 {
                    let centred = 0.5 * (force_before + reading.finger_force_n);
                    assert!(
                        (centred - run.force_n[row - 1]).abs() < 1e-12 * (1.0 + centred.abs()),
                        "{nuance} row {row}"
                    );
                }
                force_before = reading.finger_force_n;
                // Every hundredth row: where what pushes does.
                if row % 100 == 0 {
                    let status = unsafe { erard_action_contacts(action.0, contacts.as_mut_ptr(), contacts.len()) };
                    assert_eq!(status, ErardStatus::Ok);
                    let mut forces = vec![0.0; native.zones.len()];
                    unsafe { erard_action_contact_forces(action.0, forces.as_mut_ptr(), forces.len()) };
                    for (zone, five) in contacts.chunks(5).enumerate() {
                        assert_eq!(five[0].to_bits(), forces[zone].to_bits());
                        let place = run.zones[zone].contact[row].map(f64::from);
                        if five[0] > 0.0 {
                            assert!(
                                five[1..].iter().zip(place).all(|(a, b)| (a - b).abs() < 1e-6),
                                "{five:?} {place:?}"
                            );
                        }
                    }
                }
            }
            let mut seen = ErardEvents {
                key_start_s: 0.0,
                toe_contact_s: 0.0,
                let_off_s: 0.0,
                hammer_contact_s: 0.0,
                hammer_speed_m_per_s: 0.0,
                key_bottom_s: 0.0,
                check_s: 0.0,
                free_flight_s: 0.0,
                key_bottom_after_impact_s: 0.0,
                ..ErardEvents::default()
            };
            assert_eq!(unsafe { erard_event_detector_read(detector, &raw mut seen) }, ErardStatus::Ok);
            let e = &run.events;
            for (found, expected) in [
                (seen.key_start_s, e.key_start_s),
                (seen.toe_contact_s, e.toe_contact_s),
                (seen.let_off_s, e.let_off_s),
                (seen.hammer_contact_s, e.hammer_contact_s()),
                (seen.hammer_speed_m_per_s, e.hammer_speed_m_per_s()),
                (seen.key_bottom_s, e.key_bottom_s),
                (seen.check_s, e.check_s),
                (seen.free_flight_s, e.free_flight_s()),
                (seen.key_bottom_after_impact_s, e.key_bottom_after_impact_s()),
            ] {
                // The action's clock begins at 0, the stroke's where it says; both are the same sums but for their
                // rounding.
                match expected {
                    Some(expected) => assert!((found - expected).abs() < 1e-12, "{nuance}: {found} {expected}"),
                    None => assert!(found.is_nan(), "{nuance}: {found}"),
                }
            }
            unsafe { erard_stroke_free(stroke) };
        }
    }
    unsafe { erard_event_detector_free(detector) };
}

/// A recording drives by its force; what is wrong with it is said with its line; it can be played again.
#[test]
fn recordings_are_played() {
    let grand = Owned::grand();
    let read = |text: &str, status: &mut ErardStatus| unsafe {
        erard_stroke_new(grand.0, text.as_ptr().cast(), text.len(), &raw mut *status)
    };
    let mut status = ErardStatus::Internal;
    let stroke = read("time_s,force_N\n0,0\n0.01,6\n0.15,6\n0.16,0\n", &mut status);
    assert_eq!(status, ErardStatus::Ok, "{}", last_error());
    assert!((unsafe { erard_stroke_duration(stroke) } - 0.46).abs() < 1e-12);
    let mut speeds = Vec::new();
    for _ in 0..2 {
        let action = Action::grand();
        for _ in 0..4000 {
            assert!(unsafe { erard_action_step_stroke(action.0, stroke, null_mut()) } as i32 >= 0);
        }
        speeds.push(action.read().hammer_speed_m_per_s.to_bits());
        assert_eq!(unsafe { erard_stroke_rewind(stroke) }, ErardStatus::Ok);
    }
    assert!(f64::from_bits(speeds[0]) > 1.0 && speeds[0] == speeds[1]);
    unsafe { erard_stroke_free(stroke) };

    assert!(read("time_s,force_N\n0,0\n0.01,much\n", &mut status).is_null());
    assert_eq!(status, ErardStatus::File);
    assert!(last_error().contains(":3:"), "{}", last_error());
    // More than an action takes, and a stroke that is not built in.
    let wild = read("time_s,position_m\n0,0\n0.00005,0.05\n1,0.05\n", &mut status);
    assert_eq!(status, ErardStatus::Ok, "{}", last_error());
    let action = Action::grand();
    let before = action.save();
    assert_eq!(unsafe { erard_action_step_stroke(action.0, wild, null_mut()) }, ErardStatus::Range);
    assert_eq!(action.save(), before);
    unsafe { erard_stroke_free(wild) };
    let place = &raw mut status;
    assert!(unsafe { erard_stroke_builtin(grand.0, c"mezzo".as_ptr(), 0, place) }.is_null());
    assert!(status == ErardStatus::NoSuch && last_error().contains("mf"), "{}", last_error());
}

fn dials_of(instrument: *const ErardInstrument) -> Vec<Value> {
    let text = taken(unsafe { erard_instrument_dials(instrument, null_mut(), null_mut()) });
    serde_json::from_str(&text).expect("JSON")
}

fn turned(instrument: *const ErardInstrument, turns: &Value) -> Result<Owned, (ErardStatus, String)> {
    let mut status = ErardStatus::Internal;
    let turns = CString::new(turns.to_string()).unwrap();
    let made = unsafe { erard_instrument_with_dials(instrument, turns.as_ptr(), &raw mut status) };
    if made.is_null() { Err((status, last_error())) } else { Ok(Owned(made)) }
}

/// Every dial of every built-in grand changes the instrument, leaves it as it is at its own value, and reads at both
/// ends.
#[test]
fn dials_turn() {
    dials_turn_on(&["concert-grand"]);
}

#[test]
#[ignore = "ci: every dial of four instruments"]
fn dials_turn_on_every_instrument() {
    dials_turn_on(&["concert-grand", "concert-grand-rigid", "heavy-touch", "steinway-o"]);
}

fn dials_turn_on(instruments: &[&str]) {
    for &called in instruments {
        let name = CString::new(called).unwrap();
        let base = Owned(unsafe { erard_instrument_builtin(name.as_ptr(), null_mut()) });
        let native = Instrument::builtin(called).unwrap();
        let dials = dials_of(base.0);
        assert!(dials.len() > native.screws.len() + 6, "{called}: {dials:?}");
        for dial in &dials {
            let name = dial["name"].as_str().unwrap();
            let [value, from, to] = ["value", "from", "to"].map(|key| dial[key].as_f64().unwrap());
            assert!(from <= value && value <= to && from < to, "{called}: {dial}");
            let same = turned(base.0, &json!({ name: value })).unwrap();
            let same = Instrument::parse(&same.text(), "same").unwrap();
            let near = |a: f64, b: f64| (a - b).abs() <= 1e-8 * (1e-6 + a.abs());
            for (a, b) in native.bodies.iter().zip(&same.bodies) {
                assert!(near(a.mass_kg, b.mass_kg) && near(a.inertia_kg_m2, b.inertia_kg_m2), "{called}: {name}");
                assert!((0..2).all(|k| near(a.pivot_m[k], b.pivot_m[k])), "{called}: {name}");
            }
            for end in [from, to] {
                let changed = turned(base.0, &json!({ name: end }))
                    .unwrap_or_else(|error| panic!("{called}: {name} {end}: {error:?}"));
                assert!(end == value || changed.text() != base.text(), "{called}: {name}");
            }
            let (status, said) =
                turned(base.0, &json!({ name: to + 0.1 * (to - from) })).err().expect("beyond its range");
            assert!(status == ErardStatus::Argument && said.contains(name), "{said}");
        }
        // A spring without a screw, and what bends, by a factor.
        let torque = |i: &Instrument| i.springs.iter().find(|spring| spring.name == "jack").unwrap().torque_n_m;
        let stronger = turned(base.0, &json!({ "jack_spring": 1.5 })).unwrap();
        let stronger = torque(&Instrument::parse(&stronger.text(), "stronger").unwrap());
        assert!((stronger / torque(&native) - 1.5).abs() < 1e-9, "{called}: {stronger}");
        let bends = dials.iter().any(|dial| dial["name"] == "shank_bending");
        assert_eq!(bends, native.bodies.iter().any(|body| body.is_bend), "{called}");
        // What they are called for: the spread is the distance of the two centres, a lead weighs what it says.
        let by = |name: &str| dials.iter().find(|dial| dial["name"] == name).unwrap()["value"].as_f64().unwrap();
        let moved = turned(base.0, &json!({ "spread": by("spread") + 1.0, "leads": 10.0 })).unwrap();
        assert!((spread_mm(&Instrument::parse(&moved.text(), "moved").unwrap()) - by("spread") - 1.0).abs() < 1e-6);
        let parts = erard::grand::Parts::of(&native).unwrap();
        let moved = Instrument::parse(&moved.text(), "moved").unwrap();
        let front = |i: &Instrument| erard::grand::front_weight_g(i, &parts, 0.265).unwrap();
        assert!(
            (front(&moved) - front(&native) - 10.0 * 155.0 / 265.0).abs() < 0.01,
            "{}",
            front(&moved) - front(&native)
        );
    }
    let grand = Owned::grand();
    for (turns, part) in
        [(json!({ "let_of": 1.0 }), "let_off"), (json!({ "let_off": "far" }), "a number"), (json!([]), "JSON object")]
    {
        let (status, said) = turned(grand.0, &turns).err().expect("refused");
        assert!(status == ErardStatus::Argument && said.contains(part), "{said}");
    }
}

fn spread_mm(instrument: &Instrument) -> f64 {
    let parts = erard::grand::Parts::of(instrument).unwrap();
    let mut hammer = parts.hammer;
    while let Some(parent) = instrument.bodies[hammer].parent {
        hammer = parent;
    }
    let [a, b] = [hammer, parts.whippen].map(|body| instrument.bodies[body].pivot_m);
    1e3 * (a[0] - b[0]).hypot(a[1] - b[1])
}

/// The picture that moves is the picture of a run; the sheet's lines are those that are measured; an action that does
/// not play says so.
#[test]
fn scenes_sheets_and_trials() {
    let grand = Owned::grand();
    let native = Instrument::builtin("concert-grand").unwrap();
    let scene: Value =
        serde_json::from_str(&taken(unsafe { erard_instrument_drawing_json(grand.0, null_mut(), null_mut()) }))
            .unwrap();
    assert_eq!(scene, erard_figures::page::scene(&native));
    assert_eq!(scene["bodies"].as_array().unwrap().len(), native.bodies.len());
    assert_eq!(scene["zones"].as_array().unwrap().len(), native.zones.len());
    assert!(scene["shapes"].as_str().unwrap().contains("data-body") && scene["labels"].as_array().unwrap().len() > 10);

    let sheet: Value = serde_json::from_str(&taken(erard_sheet_lines(40, null_mut(), null_mut()))).unwrap();
    let keys: Vec<&str> = sheet
        .as_array()
        .unwrap()
        .iter()
        .flat_map(|group| group["lines"].as_array().unwrap().iter().map(|line| line["key"].as_str().unwrap()))
        .collect();
    assert_eq!(keys, erard_workshop::measure::norms::page_lines().map(|line| line.key).collect::<Vec<_>>());
    let mut status = ErardStatus::Ok;
    assert!(erard_sheet_lines(89, null_mut(), &raw mut status).is_null() && status == ErardStatus::NoSuch);

    let tried = |instrument: *const ErardInstrument| -> Value {
        serde_json::from_str(&taken(unsafe { erard_instrument_test_press(instrument, null_mut(), null_mut()) }))
            .unwrap()
    };
    let sound = tried(grand.0);
    assert!(sound["hammer_speed_m_per_s"].as_f64().unwrap() > 1.0 && sound["warnings"] == json!([]), "{sound}");
    let high = turned(grand.0, &json!({ "string_height": 5.0, "let_off": -4.0, "hammer": 13.0 })).unwrap();
    let lame = tried(high.0);
    assert_ne!(lame, sound);
    let file = InstrumentFile::parse(&high.text(), "high").unwrap();
    assert_eq!(file.instrument.bodies.len(), native.bodies.len());
}

/// NULL everywhere, too little room, another instrument's event detector: a status, and nothing happens.
#[test]
fn bad_callers_of_a_player() {
    let (grand, action) = (Owned::grand(), Action::grand());
    let mut status = ErardStatus::Ok;
    let place = &raw mut status;
    unsafe {
        assert!(erard_event_detector_new(null(), place).is_null() && status == ErardStatus::Null);
        for status in [
            erard_event_detector_reset(null_mut()),
            erard_event_detector_observe(null_mut(), action.0),
            erard_event_detector_read(null(), null_mut()),
            erard_action_record_contacts(null_mut()),
            erard_action_contacts(null(), null_mut(), 0),
            erard_action_contacts(action.0, null_mut(), 0),
            erard_stroke_rewind(null_mut()),
            erard_action_step_stroke(null_mut(), null_mut(), null_mut()),
            erard_action_step_stroke(action.0, null_mut(), null_mut()),
        ] {
            assert_eq!(status, ErardStatus::Null);
        }
        let mut small = [0.0; 4];
        assert_eq!(erard_action_contacts(action.0, small.as_mut_ptr(), 4), ErardStatus::Size);
        let rigid = Owned(erard_instrument_builtin(c"concert-grand-rigid".as_ptr(), null_mut()));
        let detector = erard_event_detector_new(rigid.0, null_mut());
        assert_eq!(erard_event_detector_observe(detector, action.0), ErardStatus::Foreign);
        erard_event_detector_free(detector);
        erard_event_detector_free(null_mut());
        erard_stroke_free(null_mut());
        assert_eq!((erard_action_is_asleep(null()), erard_stroke_duration(null())), (0, 0.0));
        assert_eq!(erard_action_is_asleep(action.0), 0);
        for _ in 0..10 {
            erard_action_step_free(action.0, null_mut());
        }
        assert_eq!(erard_action_is_asleep(action.0), 1);
        for call in [erard_instrument_drawing_json, erard_instrument_dials, erard_instrument_test_press] {
            assert!(call(null(), null_mut(), place).is_null() && status == ErardStatus::Null);
        }
        assert!(erard_instrument_with_dials(grand.0, null(), place).is_null() && status == ErardStatus::Null);
        assert!(CStr::from_ptr(erard_last_error()).to_str().is_ok_and(|text| text.contains("NULL")));
    }
}

/// A sensor's offset is no stroke: what stands before the touch is the zero, as `erard press` takes it, and the stroke
/// says so.
#[test]
fn recordings_are_made_ready() {
    let grand = Owned::grand();
    let mut status = ErardStatus::Internal;
    let rows = |offset: f64| {
        let row = |n: u32| {
            let time_ms = f64::from(n);
            let force = if (100.0..250.0).contains(&time_ms) { (0.05 * (time_ms - 100.0)).min(5.0) } else { 0.0 };
            // The noise of a load cell, without a mean: a file with none is a computed one, and keeps its zero.
            let noise = 0.001 * (f64::from(n * 2 % 5) - 2.0);
            format!("{time_ms},{}", 100.0 * (force + offset + noise))
        };
        format!("time (ms),load (cN)\n{}", (0..300).map(row).collect::<Vec<_>>().join("\n"))
    };
    let impact = |text: &str, status: &mut ErardStatus| {
        let place = &raw mut *status;
        let stroke = unsafe { erard_stroke_new(grand.0, text.as_ptr().cast(), text.len(), place) };
        assert_eq!(*status, ErardStatus::Ok, "{}", last_error());
        let told = taken(unsafe { erard_stroke_remarks(stroke, null_mut(), null_mut()) });
        let action = Action::grand();
        for _ in 0..8000 {
            assert!(unsafe { erard_action_step_stroke(action.0, stroke, null_mut()) } as i32 >= 0);
        }
        unsafe { erard_stroke_free(stroke) };
        (action.read().hammer_speed_m_per_s, told)
    };
    let (plain, said) = impact(&rows(0.0), &mut status);
    let (offset, told) = impact(&rows(0.75), &mut status);
    assert!(plain > 1.0 && (plain - offset).abs() < 1e-9 * plain, "{plain} {offset}");
    assert!(!said.contains("zero") || said.contains("0.0000 N"), "{said}");
    assert!(told.contains("force: zero: 0.7500 N subtracted"), "{told}");
    let stroke = unsafe { erard_stroke_builtin(grand.0, c"mf".as_ptr(), 0, null_mut()) };
    assert_eq!(taken(unsafe { erard_stroke_remarks(stroke, null_mut(), null_mut()) }), "");
    unsafe { erard_stroke_free(stroke) };
    assert!(unsafe { erard_stroke_remarks(null(), null_mut(), &raw mut status) }.is_null());
    assert_eq!(status, ErardStatus::Null);
}

/// A fingertip of the caller's own gives what an instrument with that fingertip gives, but for its force, which is of
/// the step's beginning: the difference halves with the step. It only pushes, and leaves the instrument as it was.
#[test]
fn a_fingertip_of_the_callers_own() {
    let (own, softened) = (Owned::grand(), Owned::grand());
    for (path, value) in [(c"finger.stiffness_N_per_m", 3000.0), (c"finger.damping_N_s_per_m", 3.0)] {
        assert_eq!(unsafe { erard_instrument_set(softened.0, path.as_ptr(), 0, value) }, ErardStatus::Ok);
    }
    let played = |step_s: f64, of: &Owned, is_own: bool| -> Vec<f64> {
        let action = Action(unsafe { erard_action_of_instrument(of.0, step_s, null_mut()) });
        assert!(!action.0.is_null(), "{}", last_error());
        let mut reading = ErardReading::default();
        let mut all = Vec::new();
        for n in 0..(0.08 / step_s).round() as usize {
            // 0.1 m/s from rest on, in the middle of the step.
            let at = 0.1 * (n as f64 + 0.5) * step_s;
            let status = unsafe {
                if is_own {
                    erard_action_step_fingertip(action.0, at, 0.1, 3000.0, 3.0, &raw mut reading)
                } else {
                    erard_action_step_motion(action.0, at, 0.1, &raw mut reading)
                }
            };
            assert!(status as i32 >= 0);
            assert!(reading.finger_force_n >= 0.0);
            all.push(reading.key_m);
        }
        all
    };
    let off = |step_s: f64| {
        let [one, other] = [played(step_s, &own, true), played(step_s, &softened, false)];
        one.iter().zip(&other).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    };
    let [whole, half] = [off(50e-6), off(25e-6)];
    assert!(whole > 1e-8 && whole < 2e-5, "{whole}");
    assert!(half < 0.7 * whole, "{half} {whole}");
    // A pointer above the key does not touch it.
    let action = Action::grand();
    let mut reading = ErardReading::default();
    let status = unsafe { erard_action_step_fingertip(action.0, -1e-3, 0.0, 3000.0, 3.0, &raw mut reading) };
    assert_eq!((status, reading.finger_force_n), (ErardStatus::Ok, 0.0));
    let status = unsafe { erard_action_step_fingertip(action.0, 1e-3, 0.0, -1.0, 3.0, &raw mut reading) };
    assert_eq!(status, ErardStatus::Range);
}

/// The text of a stroke's run is that of the run's own table.
#[test]
fn the_run_of_a_stroke_as_text() {
    let (grand, native) = (Owned::grand(), Instrument::builtin("concert-grand").unwrap());
    let stroke = unsafe { erard_stroke_builtin(grand.0, c"mf".as_ptr(), 1, null_mut()) };
    let text = taken(unsafe { erard_stroke_run_csv(grand.0, stroke, 50e-6, null_mut(), null_mut()) });
    unsafe { erard_stroke_free(stroke) };
    let run = pressed(&native, "mf", Touch::Struck);
    let mut lines = text.lines();
    let titles: Vec<&str> = lines.next().unwrap().split(',').collect();
    let columns = run.columns();
    assert_eq!(titles, columns.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>());
    let mut rows = 0;
    for (row, line) in lines.enumerate() {
        let cells = line.split(',').zip(&columns);
        for (cell, (name, values)) in cells {
            assert_eq!(cell.parse::<f64>().unwrap().to_bits(), values[row].to_bits(), "{name}, row {row}");
        }
        rows += 1;
    }
    assert_eq!(rows, run.time_s.len());
    let mut status = ErardStatus::Ok;
    assert!(unsafe { erard_stroke_run_csv(grand.0, null(), 50e-6, null_mut(), &raw mut status) }.is_null());
    assert_eq!(status, ErardStatus::Null);
}

/// A caller that reads a table of another kind learns which of its columns are read, in the words of the reader of
/// text.
#[test]
fn columns_are_found() {
    let mut status = ErardStatus::Internal;
    let titles = cr#"["trial", "Force (gf)", "time / ms", "hammer_rad"]"#;
    let found = taken(unsafe { erard_recording_columns(titles.as_ptr(), null_mut(), &raw mut status) });
    let found: Value = serde_json::from_str(&found).unwrap();
    let expected = json!([
        {"role": "time", "index": 2, "title": "time / ms"}, {"role": "force", "index": 1, "title": "Force (gf)"},
    ]);
    assert_eq!(found, expected);
    let wrong =
        [(c"[\"time_s\"]", "neither a force nor a position"), (c"[\"t\", \"force\"]", "unit"), (c"{", "not a JSON")];
    for (titles, said) in wrong {
        assert!(unsafe { erard_recording_columns(titles.as_ptr(), null_mut(), &raw mut status) }.is_null());
        assert!((status as i32) < 0 && last_error().contains(said), "{}", last_error());
    }
}

/// A hand in C plays as in Rust, alone and on a keyboard; it is placed, read and saved; what is no hand is refused and
/// changes nothing.
#[test]
fn a_hand_plays_as_in_rust() {
    let mut action = erard::Action::new(&erard::Instrument::builtin("concert-grand").unwrap()).unwrap();
    let joints = erard::player::Joints { compliance_m_per_n: 0.3e-3, retardation_s: 4e-3 };
    let hand = erard::player::Hand { mass_kg: 0.15, joints, ..erard::player::Hand::default() };
    let pressed = |force_n: f64| ErardInput {
        kind: ERARD_INPUT_HAND,
        force_n,
        hand_mass_kg: hand.mass_kg,
        joints_m_per_n: joints.compliance_m_per_n,
        joints_s: joints.retardation_s,
        ..ErardInput::default()
    };
    let own = Action::grand();
    let mut reading = ErardReading::default();
    action.place_hand(-1e-3, 0.4);
    assert_eq!(unsafe { erard_action_place_hand(own.0, -1e-3, 0.4) }, ErardStatus::Ok);
    for n in 0..1200 {
        let force_n = if n < 800 { 5.0 } else { -1.0 };
        let there = action.step(hand.input(&erard::Input::Force(force_n)).unwrap());
        assert_eq!(unsafe { erard_action_step_input(own.0, &pressed(force_n), &mut reading) }, ErardStatus::Ok);
        assert_eq!(
            (reading.key_m, reading.hand_m, reading.finger_force_n),
            (there.key_m, there.hand_m, there.finger_force_n),
            "{n}"
        );
    }
    assert!(reading.impact_count == 1 && reading.hand_m_per_s < 0.0, "{reading:?}");
    let before = reading;
    for wrong in [
        pressed(f64::NAN),
        ErardInput { hand_mass_kg: 0.0, ..pressed(1.0) },
        ErardInput { muscle_n_per_m: -1.0, ..pressed(1.0) },
        ErardInput { joints_m_per_n: 1.0, ..pressed(1.0) },
        ErardInput { joints_s: f64::NAN, ..pressed(1.0) },
    ] {
        assert!((unsafe { erard_action_step_input(own.0, &wrong, &mut reading) } as i32) < 0, "{wrong:?}");
    }
    assert!((unsafe { erard_action_place_hand(own.0, f64::INFINITY, 0.0) } as i32) < 0);
    assert_eq!(reading, before);
}

/// A caller chooses whole steps for an action and for a keyboard: to the bit what `Action::halve` does; what is no way
/// to halve is refused, and so is NULL.
#[test]
fn steps_are_whole_where_the_caller_says_so() {
    let text = Instrument::builtin_text("concert-grand-strings").expect("built in");
    let step_s = 1.0 / 24e3;
    let instrument = Instrument::builtin("concert-grand-strings").expect("built in");
    let mut found = Vec::new();
    for (kind, halving) in [
        (ERARD_HALVING_AUTO, Halving::Auto),
        (ERARD_HALVING_FEWER, Halving::Fewer(2)),
        (ERARD_HALVING_NEVER, Halving::Never),
    ] {
        let own = unsafe { erard_action_new(text.as_ptr().cast(), text.len(), step_s, null_mut()) };
        assert!(!own.is_null(), "{}", last_error());
        assert_eq!(unsafe { erard_action_set_halving(own, kind) }, ErardStatus::Ok);
        assert_eq!(unsafe { erard_action_set_halving(own, 7) }, ErardStatus::Argument);
        assert!(last_error().contains("ERARD_HALVING_NEVER"), "{}", last_error());
        let mut action = erard::Action::new(&instrument).expect("it rests");
        action.halve(halving);
        let mut reading = ErardReading::default();
        for _ in 0..2400 {
            assert_eq!(unsafe { erard_action_step_force(own, 8.0, &raw mut reading) }, ErardStatus::Ok);
            action.step(erard::Input::Force(8.0));
        }
        let now = action.reading();
        assert_eq!((reading.key_m, reading.hammer_rise_m, reading.impact_count), (now.key_m, now.hammer_rise_m, 1));
        found.push(reading.hammer_rise_m);
        unsafe { erard_action_free(own) };
    }
    assert!(found[0] != found[1] && found[1] != found[2] && found[0] != found[2], "{found:?}");
    assert_eq!(unsafe { erard_action_set_halving(null_mut(), ERARD_HALVING_NEVER) }, ErardStatus::Null);
    assert_eq!(unsafe { erard_keyboard_set_halving(null_mut(), ERARD_HALVING_NEVER) }, ErardStatus::Null);
}
