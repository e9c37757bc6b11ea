//! The functions for pages: is this text sound, its picture, the technician's sheet, turning screws.

use std::ffi::{CStr, CString, c_char, c_void};
use std::ptr::{null, null_mut};

use erard::Instrument;
use erard::parameter::{ParameterChange, varied};
use erard_c::*;
use erard_workshop::diagnose::{Known, answer, diagnose};
use serde_json::Value;

use crate::{Action, last_error, taken};

struct Owned(*mut ErardInstrument);

impl Drop for Owned {
    fn drop(&mut self) {
        unsafe { erard_instrument_free(self.0) };
    }
}

fn builtin(name: &str) -> Owned {
    let name = CString::new(name).unwrap();
    let instrument = unsafe { erard_instrument_builtin(name.as_ptr(), null_mut()) };
    assert!(!instrument.is_null(), "{}", last_error());
    Owned(instrument)
}

fn check(text: &[u8]) -> Value {
    let mut length = 0;
    let json = unsafe { erard_file_check(text.as_ptr().cast::<c_char>(), text.len(), &raw mut length, null_mut()) };
    let json = taken(json);
    assert_eq!(json.len(), length);
    serde_json::from_str(&json).expect("JSON")
}

#[test]
fn texts_are_checked() {
    let grand = Instrument::builtin_text("concert-grand").unwrap();
    let sound = check(grand.as_bytes());
    assert_eq!((&sound["kind"], &sound["sound"]), (&"instrument".into(), &true.into()), "{sound}");
    assert_eq!(sound["errors"], Value::Array(vec![]));
    let keyboard = check(erard::keyboard::Keyboard::builtin_text("concert-grand").unwrap().as_bytes());
    assert_eq!((&keyboard["kind"], &keyboard["sound"]), (&"keyboard".into(), &true.into()), "{keyboard}");

    // A mass below zero: line and key as the reader itself says them, and the bytes that are to be underlined.
    let line = grand.lines().position(|line| line.starts_with("mass_g")).expect("a mass") + 1;
    let wrong: Vec<String> = grand
        .lines()
        .enumerate()
        .map(|(n, text)| if n + 1 == line { "mass_g = -1".to_owned() } else { text.to_owned() })
        .collect();
    let wrong = wrong.join("\n");
    let found = check(wrong.as_bytes());
    let error = &found["errors"][0];
    assert_eq!((&found["sound"], &error["line"]), (&false.into(), &line.into()), "{found}");
    assert!(error["key"].as_str().is_some_and(|key| key.ends_with(".mass_g")), "{error}");
    let [begin, end] = ["begin", "end"].map(|key| error[key].as_u64().unwrap() as usize);
    assert_eq!(&wrong[begin..end], "-1", "{error}");
    assert!(error["text"].as_str().is_some_and(|text| text.contains(&format!(":{line}:"))), "{error}");
    let no_text = check(b"\xff");
    assert_eq!((&no_text["sound"], &no_text["errors"][0]["line"]), (&false.into(), &1.into()), "{no_text}");

    let known: Value = serde_json::from_str(&taken(erard_builtin_names(null_mut(), null_mut()))).unwrap();
    for name in Instrument::builtin_names() {
        assert!(known["instruments"].as_array().unwrap().contains(&name.into()), "{known}");
    }
}

/// A body's mass takes its inertia along, as the command's `--vary` does: the instrument is the one that is varied
/// natively. What cannot be read or goes too far is refused, and the instrument stays as it was.
#[test]
fn masses_are_varied_with_their_inertias() {
    let grand = builtin("concert-grand");
    let text = |of: &Owned| taken(unsafe { erard_instrument_text(of.0, null_mut(), null_mut()) });
    let vary = |name: &CStr, change: &CStr| unsafe { erard_instrument_vary(grand.0, name.as_ptr(), change.as_ptr()) };
    let hammer = |i: &Instrument| i.bodies.iter().find(|body| body.name == "hammer").cloned().unwrap();
    let drawn = hammer(&Instrument::builtin("concert-grand").unwrap());
    assert_eq!(vary(c"body.hammer.mass", c"+0.8 g"), ErardStatus::Ok, "{}", last_error());
    assert_eq!(vary(c"let_off", c"-0.2 mm"), ErardStatus::Ok, "{}", last_error());
    let found = text(&grand);
    let read = Instrument::parse(&found, "varied").unwrap();
    let changes = [("body.hammer.mass", "+0.8 g"), ("let_off", "-0.2 mm")]
        .map(|(name, change)| (name.to_owned(), ParameterChange::Text(change.to_owned())));
    let native = varied(Instrument::builtin_text("concert-grand").unwrap(), "native", &changes).unwrap().instrument;
    let (here, there) = (hammer(&read), hammer(&native));
    assert!((here.mass_kg - drawn.mass_kg - 0.8e-3).abs() < 1e-12, "{}", here.mass_kg);
    assert!((here.inertia_kg_m2 / there.inertia_kg_m2 - 1.0).abs() < 1e-9, "{}", here.inertia_kg_m2);
    assert!(here.inertia_kg_m2 > 1.05 * drawn.inertia_kg_m2);
    let speed = |instrument: &Instrument| {
        let mut action = erard::Action::new(instrument).unwrap();
        let impact = (0..3000).find_map(|_| {
            action.step(erard::Input::Force(5.0));
            action.impact()
        });
        impact.expect("an impact").hammer_speed_m_per_s
    };
    assert!((speed(&read) / speed(&native) - 1.0).abs() < 1e-6, "{} {}", speed(&read), speed(&native));
    for (name, change, expected, word) in [
        (c"body.drummer.mass", c"*2", ErardStatus::NoSuch, "body.hammer.mass"),
        (c"body.hammer.mass", c"heavy", ErardStatus::Argument, "units: kg, g"),
        (c"body.hammer.mass", c"nan g", ErardStatus::Argument, "units: kg, g"),
        (c"body.hammer.mass", c"-200 g", ErardStatus::Range, "out of range"),
        (c"body.hammer.mass_g", c"= -3 g", ErardStatus::File, "mass_g"),
    ] {
        assert_eq!(vary(name, change), expected, "{name:?} {change:?}");
        assert!(last_error().contains(word), "{}", last_error());
        assert_eq!(text(&grand), found, "{name:?}");
    }
}

/// Numbers by their paths, in the file's own units; what the file may not be is refused, and the instrument stays as it
/// was.
#[test]
fn numbers_are_looked_up_and_changed() {
    let grand = builtin("concert-grand");
    let path = c"body.hammer.mass_g";
    let mut mass_g = 0.0;
    assert_eq!(unsafe { erard_instrument_get(grand.0, path.as_ptr(), 0, &raw mut mass_g) }, ErardStatus::Ok);
    let expected = Instrument::builtin("concert-grand").unwrap();
    let hammer = expected.bodies.iter().find(|body| body.name == "hammer").unwrap();
    assert!((mass_g - 1e3 * hammer.mass_kg).abs() < 1e-9);
    assert_eq!(unsafe { erard_instrument_set(grand.0, path.as_ptr(), 0, mass_g + 0.5) }, ErardStatus::Ok);
    let text = taken(unsafe { erard_instrument_text(grand.0, null_mut(), null_mut()) });
    let read = Instrument::parse(&text, "changed").unwrap();
    let heavier = read.bodies.iter().find(|body| body.name == "hammer").unwrap().mass_kg;
    assert!((heavier - hammer.mass_kg - 0.5e-3).abs() < 1e-12);
    for (bad, expected) in
        [(-1.0, ErardStatus::File), (f64::NAN, ErardStatus::NotFinite), (f64::INFINITY, ErardStatus::NotFinite)]
    {
        assert_eq!(unsafe { erard_instrument_set(grand.0, path.as_ptr(), 0, bad) }, expected, "{bad}");
        assert!(last_error().contains("mass_g"), "{}", last_error());
        assert_eq!(taken(unsafe { erard_instrument_text(grand.0, null_mut(), null_mut()) }), text);
    }
    for (path, which) in [(c"body.drummer.mass_g", 0), (c"body.hammer.mass_g", 1), (c"", 0)] {
        let mut value = 0.0;
        unsafe {
            assert_eq!(erard_instrument_get(grand.0, path.as_ptr(), which, &raw mut value), ErardStatus::NoSuch);
            assert_eq!(erard_instrument_set(grand.0, path.as_ptr(), which, 1.0), ErardStatus::NoSuch);
        }
    }
    // It is the heavier hammer that plays: slower, at the same force.
    let impact = |action: *mut ErardAction| {
        let action = Action(action);
        for _ in 0..3000 {
            action.force(5.0);
        }
        action.read().hammer_speed_m_per_s
    };
    let (light, heavy) = (Action::grand(), unsafe { erard_action_of_instrument(grand.0, 50e-6, null_mut()) });
    for _ in 0..3000 {
        light.force(5.0);
    }
    let heavy = impact(heavy);
    assert!(heavy > 0.0 && heavy < light.read().hammer_speed_m_per_s, "{heavy} {}", light.read().hammer_speed_m_per_s);

    let json: Value =
        serde_json::from_str(&taken(unsafe { erard_instrument_json(grand.0, null_mut(), null_mut()) })).unwrap();
    assert_eq!(json["bodies"].as_array().unwrap().len(), expected.bodies.len());
    assert_eq!(json["screws"].as_array().unwrap().len(), expected.screws.len());
    let number = json["numbers"].as_array().unwrap().iter().find(|n| n["path"] == "body.hammer.mass_g").unwrap();
    assert_eq!(number["values"][0], mass_g + 0.5);
    let key = erard_instrument_of_key(40, null_mut());
    assert!(!key.is_null());
    unsafe { erard_instrument_free(key) };
}

/// The picture is the command's own, of the pose that the action is in.
#[test]
fn the_picture_is_the_commands() {
    use erard_figures::drawing::{PoseOptions, pose_picture};
    let (grand, action) = (builtin("concert-grand"), Action::grand());
    for _ in 0..700 {
        action.force(6.0);
    }
    let angles: Vec<f64> = action.angles().into_iter().map(f64::from_bits).collect();
    let draw = |angles: &[f64], px: f64, labels: u32, status: &mut ErardStatus| unsafe {
        let numbers = if angles.is_empty() { null() } else { angles.as_ptr() };
        erard_instrument_draw(grand.0, numbers, angles.len(), px, labels, null_mut(), &raw mut *status)
    };
    let native = Instrument::builtin("concert-grand").unwrap();
    let mut status = ErardStatus::Ok;
    for (angles, labels) in [(&angles[..], 0), (&[][..], 1)] {
        let options = PoseOptions { size_px: 900.0, labels: labels == 1, ..PoseOptions::default() };
        assert_eq!(taken(draw(angles, 900.0, labels, &mut status)), pose_picture(&native, angles, &options).svg());
    }
    let mut bad = angles.clone();
    bad[1] = f64::NAN;
    for (angles, px, expected) in [
        (&bad[..], 900.0, ErardStatus::NotFinite),
        (&angles[..2], 900.0, ErardStatus::Size),
        (&angles[..], f64::NAN, ErardStatus::Range),
        (&angles[..], 1e9, ErardStatus::Range),
    ] {
        assert!(draw(angles, px, 0, &mut status).is_null());
        assert_eq!(status, expected);
    }
}

unsafe extern "C" fn stop(_: f64, user: *mut c_void) -> i32 {
    unsafe { *user.cast::<u32>() += 1 };
    0
}

/// The sheet's numbers are those of the workshop; names that are none are an error; the caller can end it.
#[test]
fn a_technician_measures() {
    let grand = builtin("concert-grand");
    let wanted = c"dip_mm, down_weight_g,strike_weight_g";
    let measured =
        unsafe { erard_instrument_measure(grand.0, 0, wanted.as_ptr(), None, null_mut(), null_mut(), null_mut()) };
    let measured: Value = serde_json::from_str(&taken(measured)).unwrap();
    let native = Instrument::builtin("concert-grand").unwrap();
    let lines: Vec<_> = erard_workshop::measure::norms::lines()
        .filter(|line| ["dip_mm", "down_weight_g", "strike_weight_g"].contains(&line.key))
        .collect();
    let values = erard_workshop::measure::measure_some(&native, &lines, &mut |_| true).unwrap();
    assert_eq!(lines.len(), 3);
    for (line, value) in lines.iter().zip(values) {
        assert_eq!(measured[line.key].as_f64(), value, "{}", line.key);
    }
    let mut status = ErardStatus::Ok;
    let place = &raw mut status;
    unsafe {
        let unknown = c"dip_mm,dap_mm".as_ptr();
        assert!(erard_instrument_measure(grand.0, 0, unknown, None, null_mut(), null_mut(), place).is_null());
        assert_eq!(status, ErardStatus::NoSuch);
        assert!(last_error().contains("dap_mm") && last_error().contains("let_off_mm"), "{}", last_error());
        let mut asked = 0_u32;
        let user = (&raw mut asked).cast::<c_void>();
        assert!(erard_instrument_measure(grand.0, 0, null(), Some(stop), user, null_mut(), place).is_null());
        assert!(status == ErardStatus::Interrupted && asked > 0, "{status:?}");
    }
}

/// A key's sheet has the norms of that key, which changes of its numbers keep; another key is refused.
#[test]
fn a_sheet_knows_its_key() {
    let mut status = ErardStatus::Ok;
    let place = &raw mut status;
    unsafe {
        let a0 = erard_key_number(c"A0".as_ptr(), place);
        assert_eq!(
            (a0, erard_key_number(c"C#4".as_ptr(), place), erard_key_number(c"88".as_ptr(), place)),
            (1, 41, 88)
        );
        assert_eq!((erard_key_number(c"H4".as_ptr(), place), *place), (0, ErardStatus::NoSuch));
        let lowest = erard_instrument_of_key(a0, place);
        assert_eq!(erard_instrument_set(lowest, c"gravity_m_s2".as_ptr(), 0, 9.8), ErardStatus::Ok);
        let sheet = |key: u32| -> Value {
            serde_json::from_str(&taken(erard_instrument_measure(
                lowest,
                key,
                null(),
                None,
                null_mut(),
                null_mut(),
                null_mut(),
            )))
            .unwrap()
        };
        let own = sheet(0);
        assert_eq!(own["norms_for_key"], 1);
        assert!(erard_instrument_measure(lowest, 40, null(), None, null_mut(), null_mut(), place).is_null());
        assert_eq!(status, ErardStatus::Argument);
        assert!(last_error().contains("that of key 1 (A0)"), "{}", last_error());
        assert!(erard_instrument_measure(lowest, 89, null(), None, null_mut(), null_mut(), place).is_null());
        assert_eq!(status, ErardStatus::NoSuch);
        erard_instrument_free(lowest);
    }
}

/// Regulated to a goal: the goal is met, the new file reads back, and what nobody can do is said.
#[test]
fn screws_are_turned() {
    let heavy = builtin("heavy-touch");
    let mut status = ErardStatus::Internal;
    let goals = CString::new(r#"{"let-off": 2.0}"#).unwrap();
    let text = taken(unsafe {
        erard_instrument_regulate(heavy.0, goals.as_ptr(), None, null_mut(), null_mut(), &raw mut status)
    });
    assert_eq!(status, ErardStatus::Ok);
    let json: Value = serde_json::from_str(&text).unwrap();
    assert_eq!((&json["all_met"], &json["goals"][0]["goal"]), (&true.into(), &"let-off".into()), "{json}");
    assert!((json["goals"][0]["after"].as_f64().unwrap() - 2.0).abs() < 0.05, "{json}");
    let new = Instrument::parse(json["file"].as_str().unwrap(), "regulated").unwrap();
    assert!(new.screws.iter().any(|screw| screw.name == "let_off" && screw.setting != 0.0));
    for (goals, words) in [
        (r#"{"let-off": 200}"#, "mm"),
        (r#"{"repetition_spring": "9mm"}"#, "mm/s"),
        (r#"{"damper start": 200}"#, "%"),
        (r#"{"lets-off": 2}"#, "lets-off"),
        (r#"{"dip": "ten"}"#, "dip"),
        ("[]", "object"),
        ("{", "JSON"),
    ] {
        let goals = CString::new(goals).unwrap();
        let none = unsafe {
            erard_instrument_regulate(heavy.0, goals.as_ptr(), None, null_mut(), null_mut(), &raw mut status)
        };
        assert!(none.is_null() && status == ErardStatus::Argument, "{status:?}");
        assert!(last_error().contains(words), "{}", last_error());
    }
}

/// A page's own memory.
#[test]
fn memory_is_lent() {
    let memory = erard_memory_new(1 << 16);
    let bytes = unsafe { std::slice::from_raw_parts_mut(memory, 1 << 16) };
    assert!(bytes.iter().all(|byte| *byte == 0));
    bytes.fill(1);
    unsafe { erard_memory_free(memory, 1 << 16) };
    assert!(erard_memory_new(usize::MAX).is_null());
}

fn of_readings(
    readings: &str,
    call: unsafe extern "C" fn(*const c_char, *mut usize, *mut ErardStatus) -> *mut c_char,
) -> Value {
    let readings = CString::new(readings).unwrap();
    let text = unsafe { call(readings.as_ptr(), null_mut(), null_mut()) };
    assert!(!text.is_null(), "{}", last_error());
    serde_json::from_str(&taken(text)).unwrap()
}

/// One's own readings: the answer of the workshop for the same numbers, worked out by hand where it can be; everything
/// that is wrong at its own name.
#[test]
fn own_readings_are_diagnosed() {
    let found = of_readings(r#"{"key": "C4", "down_weight_g": 58, "up-weight": "18 g", "drop": 0}"#, erard_diagnose);
    let key = &found["keys"][0];
    let value = |name: &str| {
        let lines = key["readings"].as_array().unwrap();
        lines.iter().find(|line| line["name"] == name).map(|line| line["value"].clone()).unwrap_or_default()
    };
    assert_eq!((value("balance_weight_g"), value("friction_weight_g")), (38.0.into(), 20.0.into()));
    let mut known = Known::default();
    [("down_weight_g", 58.0), ("up_weight_g", 18.0), ("drop_mm", 0.0)]
        .iter()
        .for_each(|(name, value)| known.set(name, Some(*value)));
    assert_eq!(found, answer(&[diagnose(&known, 40)], None, false));
    assert_eq!(of_readings(r#"{"drop_mm": 0}"#, erard_diagnose)["is_key_assumed"], true);

    let swapped = r#"{"down_weight_g": 18, "up_weight_g": 58, "key": 89}"#;
    let faults = of_readings(swapped, erard_diagnose_check);
    let names: Vec<&str> = faults.as_array().unwrap().iter().filter_map(|fault| fault["name"].as_str()).collect();
    assert_eq!(names, ["key", "up_weight_g"]);
    assert_eq!(of_readings(r#"{"drop_mm": 0}"#, erard_diagnose_check), Value::Array(vec![]));
    for (readings, told) in [(swapped, "are they swapped?"), ("{}", "no reading was given"), ("{", "not a JSON object")]
    {
        let (text, mut status) = (CString::new(readings).unwrap(), ErardStatus::Ok);
        assert!(unsafe { erard_diagnose(text.as_ptr(), null_mut(), &raw mut status) }.is_null());
        assert!(status == ErardStatus::Argument && last_error().contains(told), "{status:?}: {}", last_error());
    }

    // Every name of the form is one that is understood, with its own usual range at the key.
    let form = serde_json::from_str::<Value>(&taken(erard_diagnose_quantities(40, null_mut(), null_mut()))).unwrap();
    for line in form.as_array().unwrap() {
        let name = line["name"].as_str().unwrap();
        // Conditions of the weighing are said beside a weight: a place, or yes or no.
        if ["measured_at_mm", "tapped", "dampers_lifted", "stack_on"].contains(&name) {
            let said = if name == "measured_at_mm" { line["limits"][1].clone() } else { "yes".into() };
            let readings = format!("{{\"{name}\": {said}, \"down_weight_g\": 50}}");
            assert_eq!(of_readings(&readings, erard_diagnose_check), Value::Array(vec![]), "{readings}");
            continue;
        }
        let middle = (line["limits"][0].as_f64().unwrap() + line["limits"][1].as_f64().unwrap()) / 2.0;
        // A balance weight or a friction weight alone says neither D nor U.
        let beside = match name {
            "balance_weight_g" => ", \"friction_weight_g\": 11",
            "friction_weight_g" => ", \"balance_weight_g\": 37",
            _ => "",
        };
        let readings = format!("{{\"{name}\": {middle}{beside}}}");
        assert_eq!(of_readings(&readings, erard_diagnose_check), Value::Array(vec![]), "{readings}");
    }
    assert_eq!(form[0]["usual"], serde_json::json!([43.0, 55.2]));
    let mut status = ErardStatus::Ok;
    assert!(erard_diagnose_quantities(0, null_mut(), &raw mut status).is_null() && status == ErardStatus::NoSuch);
}
