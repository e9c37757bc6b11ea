//! The C interface accepts and refuses the numbers that the command and the Python interface accept and refuse.

use std::ffi::{CStr, CString};
use std::ptr::{null, null_mut};

use erard_c::*;

use crate::Action;

/// Rows of `quantity, value, accepted`, which every front is held against.
const RANGES: &str = include_str!("../../../../crates/erard-core/tests/ranges.csv");

/// Whether an instrument could be made, which then goes.
fn made(instrument: *mut ErardInstrument) -> bool {
    unsafe { erard_instrument_free(instrument) };
    !instrument.is_null()
}

fn varied(called: &str, change: &str) -> bool {
    let [called, change] = [called, change].map(|text| CString::new(text).unwrap());
    let grand = unsafe { erard_instrument_new(null(), 0, null_mut()) };
    let status = unsafe { erard_instrument_vary(grand, called.as_ptr(), change.as_ptr()) };
    unsafe { erard_instrument_free(grand) };
    status == ErardStatus::Ok
}

#[test]
fn numbers_are_refused_as_by_the_other_fronts() {
    let mut tried = 0;
    for row in RANGES.lines().skip(1) {
        let [quantity, value, accepted] = row.split(',').collect::<Vec<_>>().try_into().expect("three columns");
        let number: f64 = value.parse().unwrap();
        let grand = Action::grand();
        let is_accepted = match quantity {
            "step_s" => {
                let action = unsafe { erard_action_new(null(), 0, number, null_mut()) };
                unsafe { erard_action_free(action) };
                !action.is_null()
            }
            "live_force_n" => unsafe { erard_action_step_force(grand.0, number, null_mut()) == ErardStatus::Ok },
            "live_position_m" => unsafe {
                erard_action_step_motion(grand.0, number, 0.0, null_mut()) == ErardStatus::Ok
            },
            "live_speed_m_per_s" => unsafe {
                erard_action_step_motion(grand.0, 0.0, number, null_mut()) == ErardStatus::Ok
            },
            // What is no whole number its type refuses.
            "key" => value.parse().is_ok_and(|key| made(erard_instrument_of_key(key, null_mut()))),
            "hammer_mass_factor" => varied("body.hammer.mass", &format!("*{value}")),
            "let_off_turned_mm" => varied("let_off", &format!("+{value} mm").replace("+-", "-")),
            // Presses of a duration, recordings, studies, fits and measurements are the command's and Python's.
            _ => continue,
        };
        assert_eq!(is_accepted, accepted == "yes", "{row}: {}", crate::last_error());
        tried += 1;
    }
    assert!(tried > 30, "{tried}");
}

/// Rows of `name, text, command, other`: what C makes of a text.
const TYPED: &str = include_str!("../../../../crates/erard-core/tests/typed.tsv");

/// Texts of changes are read as the table says, which the command and Python are held against, too.
#[test]
fn texts_are_read_as_by_the_other_fronts() {
    use erard::instrument::Instrument;
    use erard::parameter::Parameter;

    let own = Instrument::builtin("concert-grand").unwrap();
    for row in TYPED.lines().skip(1) {
        let [name, text, _, expected] = row.split('\t').collect::<Vec<_>>().try_into().expect("four columns");
        let [called, change] = [name, text].map(|text| CString::new(text).unwrap());
        let grand = unsafe { erard_instrument_new(null(), 0, null_mut()) };
        let status = unsafe { erard_instrument_vary(grand, called.as_ptr(), change.as_ptr()) };
        let said = unsafe { CStr::from_ptr(erard_last_error()) }.to_owned();
        let varied = unsafe {
            let given = erard_instrument_text(grand, null_mut(), null_mut());
            let text = CStr::from_ptr(given).to_str().unwrap().to_owned();
            erard_text_free(given);
            erard_instrument_free(grand);
            text
        };
        let (kind, told) = expected.split_once(' ').expect("two words");
        if kind == "no" {
            assert_ne!(status, ErardStatus::Ok, "{row}");
            let said = said.to_str().unwrap();
            assert!(said.contains(told), "{row}: {said}");
            continue;
        }
        assert_eq!(status, ErardStatus::Ok, "{row}");
        let (_, parameter) = Parameter::named(&own, name).unwrap();
        let (now, by): (f64, f64) = (parameter.value(&own).unwrap(), told.parse().unwrap());
        let wanted = match kind {
            "set" => by,
            "add" => now + by,
            _ => now * by,
        };
        let found = parameter.value(&Instrument::parse(&varied, "varied").unwrap()).unwrap();
        assert!((found - wanted).abs() <= 1e-9 * wanted.abs() + 1e-12, "{row}: {found} {wanted}");
    }
}

/// Rows of `instrument, name, text, command, other, path, file_si`, generated from the register: C takes those of
/// `other`.
const REGISTERED: &str = include_str!("../../../../crates/erard-core/tests/typed-register.tsv");

/// The number at a path of an instrument's file.
fn number(instrument: *const ErardInstrument, path: &str) -> f64 {
    let path = CString::new(path).unwrap();
    let mut value = f64::NAN;
    let status = unsafe { erard_instrument_get(instrument, path.as_ptr(), 0, &raw mut value) };
    assert_eq!(status, ErardStatus::Ok, "{}", crate::last_error());
    value
}

/// Every name, unit and spelling of the register is read as by the other fronts.
#[test]
fn the_register_is_read_as_by_the_other_fronts() {
    let mut tried = 0;
    for row in REGISTERED.lines().skip(1) {
        let [instrument, name, text, _, expected, path, si] =
            row.split('\t').collect::<Vec<_>>().try_into().expect("seven columns");
        let [instrument, called, change] = [instrument, name, text].map(|text| CString::new(text).unwrap());
        let grand = unsafe { erard_instrument_builtin(instrument.as_ptr(), null_mut()) };
        let now = if path.is_empty() { f64::NAN } else { number(grand, path) };
        let status = unsafe { erard_instrument_vary(grand, called.as_ptr(), change.as_ptr()) };
        let said = crate::last_error();
        let (kind, told) = expected.split_once(' ').expect("two words");
        if kind == "no" {
            assert_ne!(status, ErardStatus::Ok, "{row}");
            assert!(said.contains(told), "{row}: {said}");
        } else {
            assert_eq!(status, ErardStatus::Ok, "{row}: {said}");
            let (si, by): (f64, f64) = (si.parse().unwrap(), told.parse().unwrap());
            let wanted = match kind {
                "set" => by,
                "add" => now * si + by,
                _ => now * si * by,
            };
            let found = if path.is_empty() { wanted } else { number(grand, path) * si };
            let is_close = path.is_empty() || (found - wanted).abs() <= 1e-8 * wanted.abs() + 1e-15;
            assert!(is_close, "{row}: {found} {wanted}");
        }
        unsafe { erard_instrument_free(grand) };
        tried += 1;
    }
    assert!(tried > 400, "{tried}");
}

/// A page's field reads a bare number in the trade's unit, as the command does, and a dial's field in the dial's.
#[test]
fn fields_are_read_as_the_command_reads_them() {
    let texts = |text: &str| CString::new(text).unwrap();
    for row in REGISTERED.lines().skip(1).filter(|row| row.starts_with("concert-grand\t")) {
        let [_, name, text, command, other, path, si] =
            row.split('\t').collect::<Vec<_>>().try_into().expect("seven columns");
        if command == other || command.starts_with("no") || command == "-" {
            continue;
        }
        let grand = unsafe { erard_instrument_new(null(), 0, null_mut()) };
        let status = unsafe { erard_instrument_vary_field(grand, texts(name).as_ptr(), texts(text).as_ptr()) };
        assert_eq!(status, ErardStatus::Ok, "{row}: {}", crate::last_error());
        let (wanted, si): (f64, f64) = (command.strip_prefix("set ").unwrap().parse().unwrap(), si.parse().unwrap());
        let found = number(grand, path) * si;
        assert!((found - wanted).abs() <= 1e-8 * wanted.abs(), "{row}: {found} {wanted}");
        unsafe { erard_instrument_free(grand) };
    }
    let grand = unsafe { erard_instrument_new(null(), 0, null_mut()) };
    let read = |dial: &str, text: &str| {
        let mut value = f64::NAN;
        let status =
            unsafe { erard_instrument_dial_typed(grand, texts(dial).as_ptr(), texts(text).as_ptr(), &raw mut value) };
        (status, value)
    };
    let now = number(grand, "screw.let_off.setting_mm");
    for (dial, text, expected) in [
        ("let_off", "0.3", 0.3),
        ("let_off", "1/64in", 25.4 / 64.0),
        ("let_off", "+0.5", now + 0.5),
        ("let_off", "\u{2212}0,2 mm", now - 0.2),
        ("let_off", "x2", 2.0 * now),
        ("hammer", "0.3oz", 8.504_856_937_5),
        ("hammer_felt", "1.5", 1.5),
        ("hammer_felt", "x1.5", 1.5),
    ] {
        let (status, value) = read(dial, text);
        assert_eq!(status, ErardStatus::Ok, "{dial} {text}: {}", crate::last_error());
        assert!((value - expected).abs() < 1e-7, "{dial} {text}: {value}");
    }
    for (dial, text, status, told) in [
        ("let_off", "1 g", ErardStatus::Argument, "`let_off`: found `1 g`: `g` is not one of its units"),
        ("let_off", "1,500", ErardStatus::Argument, "may be 1.500 or 1500"),
        ("let_off", "50", ErardStatus::Range, "`let_off` is 50 mm; expected a number from"),
        ("hammer_felt", "2 mm", ErardStatus::Argument, "expected a number"),
        ("let_of", "1", ErardStatus::NoSuch, "there is no dial `let_of`"),
    ] {
        assert_eq!(read(dial, text).0, status, "{dial} {text}");
        assert!(crate::last_error().contains(told), "{dial} {text}: {}", crate::last_error());
    }
    unsafe { erard_instrument_free(grand) };
}
