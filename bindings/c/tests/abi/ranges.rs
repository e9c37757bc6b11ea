//! The C interface accepts and refuses the numbers that the command and the Python interface accept and refuse.

use std::ffi::{CStr, CString};
use std::ptr::{null, null_mut};

use erard_c::*;

use crate::Action;

/// Rows of `quantity, value, accepted`, which every front is held against.
const RANGES: &str = include_str!("../../../../crates/erard/tests/ranges.csv");

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
            // Presses of a duration are the command's and Python's.
            "duration_s" | "force_n" | "hammer_speed_m_per_s" => continue,
            other => panic!("{other} is not tried on the C interface"),
        };
        assert_eq!(is_accepted, accepted == "yes", "{row}: {}", crate::last_error());
        tried += 1;
    }
    assert!(tried > 30, "{tried}");
}

/// Rows of `name, text, command, other`: what C makes of a text.
const TYPED: &str = include_str!("../../../../crates/erard/tests/typed.tsv");

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
        let (now, by): (f64, f64) = (parameter.value(&own), told.parse().unwrap());
        let wanted = match kind {
            "set" => by,
            "add" => now + by,
            _ => now * by,
        };
        let found = parameter.value(&Instrument::parse(&varied, "varied").unwrap());
        assert!((found - wanted).abs() <= 1e-9 * wanted.abs() + 1e-12, "{row}: {found} {wanted}");
    }
}
