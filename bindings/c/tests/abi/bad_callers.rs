//! Whatever a caller does that can be seen: an error code, the object as it was, and it plays on.

use std::ffi::{CString, c_char};
use std::ptr::{null, null_mut};

use erard_c::*;

use crate::{Action, last_error, moving, pushed};

/// An action in the middle of a stroke.
fn midway() -> Action {
    let action = Action::grand();
    for _ in 0..400 {
        action.force(5.0);
    }
    action
}

/// After a refusal the action is as it was, to the bit, and plays on.
fn unchanged(action: &Action, before: &[u8], what: &str) {
    assert_eq!(action.save(), before, "{what}");
}

#[test]
fn numbers_that_no_action_takes() {
    let action = midway();
    let before = action.save();
    let huge = f64::MAX;
    for (bad, expected) in [
        (f64::NAN, ErardStatus::NotFinite),
        (f64::INFINITY, ErardStatus::NotFinite),
        (f64::NEG_INFINITY, ErardStatus::NotFinite),
        (huge, ErardStatus::Range),
        (-huge, ErardStatus::Range),
        (2.0 * ERARD_MAX_FORCE_N, ErardStatus::Range),
    ] {
        let mut r = ErardReading::default();
        let place = &raw mut r;
        let found = unsafe {
            [
                erard_action_step_force(action.0, bad, place),
                erard_action_step_motion(action.0, bad, 0.0, place),
                erard_action_step_motion(action.0, 0.0, bad, place),
                erard_action_step_fingertip(action.0, bad, 0.0, 800.0, 0.8, place),
                erard_action_step_fingertip(action.0, 0.0, bad, 800.0, 0.8, place),
                erard_action_step_fingertip(action.0, 0.0, 0.0, 800.0, bad, place),
                erard_action_step_rigid(action.0, bad, 0.0, place),
                erard_action_step_rigid(action.0, 0.0, bad, place),
                erard_action_advance(action.0, 1e-3, &pushed(bad), place),
                erard_action_advance(action.0, 1e-3, &moving(bad, 0.0), place),
                erard_action_advance(action.0, bad, &pushed(1.0), place),
            ]
        };
        assert_eq!(found, [expected; 11], "{bad}");
        unchanged(&action, &before, &bad.to_string());
        assert_eq!(r, action.read(), "the reading is the one before");
    }
    let unknown = ErardInput { kind: 5, ..ErardInput::default() };
    assert_eq!(unsafe { erard_action_advance(action.0, 1e-3, &raw const unknown, null_mut()) }, ErardStatus::Argument);
    assert_eq!(unsafe { erard_action_advance(action.0, -1e-3, &pushed(1.0), null_mut()) }, ErardStatus::Range);
    unchanged(&action, &before, "kind and time");
    action.force(5.0);
}

/// The largest numbers that are taken: the action survives them, and comes back to its rest.
#[test]
fn the_largest_numbers_that_it_takes() {
    let action = Action::grand();
    let (f, x, v) = (ERARD_MAX_FORCE_N, ERARD_MAX_POSITION_M, ERARD_MAX_SPEED_M_PER_S);
    let extremes = [pushed(f), pushed(-f), moving(x, v), moving(-x, -v), moving(x, -v)];
    let rigid = extremes.iter().skip(2).map(|input| ErardInput { kind: ERARD_INPUT_RIGID, ..*input });
    for input in extremes.iter().copied().chain(rigid) {
        assert_eq!(unsafe { erard_action_reset(action.0) }, ErardStatus::Ok);
        let mut r = ErardReading::default();
        for n in 0..2000 {
            let status = unsafe { erard_action_advance(action.0, 50e-6, &raw const input, &raw mut r) };
            assert_ne!(status, ErardStatus::Internal, "{input:?}, step {n}");
            let all = [r.key_m, r.key_m_per_s, r.finger_force_n, r.hammer_rise_m, r.hammer_rise_m_per_s, r.string_n];
            assert!(all.iter().all(|number| number.is_finite()), "{input:?}, step {n}: {r:?}");
        }
        assert_eq!(unsafe { erard_action_reset(action.0) }, ErardStatus::Ok);
        for _ in 0..1000 {
            action.force(5.0);
        }
        assert_eq!(action.read().impact_count, 1, "{input:?}");
    }
}

/// Nothing at all: every function takes NULL for every pointer.
#[test]
fn nothing_at_all() {
    let (action, keyboard, instrument) = (null_mut::<ErardAction>(), null_mut::<ErardKeyboard>(), null_mut());
    let (mut n, mut number) = (0_usize, 0.0);
    let input = pushed(1.0);
    unsafe {
        for status in [
            erard_action_step_force(action, 1.0, null_mut()),
            erard_action_step_motion(action, 0.0, 0.0, null_mut()),
            erard_action_step_fingertip(action, 0.0, 0.0, 800.0, 0.8, null_mut()),
            erard_action_step_rigid(action, 0.0, 0.0, null_mut()),
            erard_action_step_free(action, null_mut()),
            erard_action_advance(action, 1e-3, &raw const input, null_mut()),
            erard_action_read(action, null_mut()),
            erard_action_reset(action),
            erard_action_save(action, null_mut(), &raw mut n),
            erard_action_restore(action, null(), 0),
            erard_action_angles(action, null_mut(), 0),
            erard_action_string_shape(action, null_mut(), 0),
            erard_action_velocities(action, null_mut(), 0),
            erard_action_contact_forces(action, null_mut(), 0),
            erard_keyboard_drive(keyboard, 1, &raw const input),
            erard_keyboard_step(keyboard, 1, null_mut(), 0, null_mut()),
            erard_keyboard_read(keyboard, 1, null_mut()),
            erard_keyboard_angles(keyboard, 1, null_mut(), 0),
            erard_keyboard_save(keyboard, null_mut(), &raw mut n),
            erard_keyboard_restore(keyboard, null(), 0),
            erard_instrument_get(instrument, c"name".as_ptr(), 0, &raw mut number),
            erard_instrument_set(instrument, c"name".as_ptr(), 0, 1.0),
            erard_instrument_vary(instrument, c"body.hammer.mass".as_ptr(), c"*1.1".as_ptr()),
        ] {
            assert_eq!(status, ErardStatus::Null);
        }
        erard_action_free(action);
        erard_keyboard_free(keyboard);
        erard_instrument_free(instrument);
        erard_text_free(null_mut());
        erard_memory_free(null_mut(), 0);
        assert_eq!(
            (erard_action_body_count(action), erard_action_zone_count(action), erard_keyboard_key_count(keyboard)),
            (0, 0, 0)
        );
        assert_eq!(erard_keyboard_awake_count(keyboard), 0);
        assert!(erard_action_body_name(action, 0).is_null() && erard_action_zone_name(action, 0).is_null());
        assert!(erard_memory_new(0).is_null());
        let mut status = ErardStatus::Ok;
        let place = &raw mut status;
        assert!(erard_action_of_instrument(null(), 50e-6, place).is_null() && *place == ErardStatus::Null);
        assert!(erard_action_new(null(), 5, 50e-6, place).is_null() && *place == ErardStatus::Null);
        assert!(erard_instrument_builtin(null(), place).is_null() && *place == ErardStatus::Null);
        assert!(erard_file_check(null(), 0, null_mut(), place).is_null() && *place == ErardStatus::Null);
        for text in [
            erard_instrument_text(instrument, null_mut(), place),
            erard_instrument_json(instrument, null_mut(), place),
            erard_instrument_draw(instrument, null(), 0, 800.0, 0, null_mut(), place),
            erard_instrument_measure(instrument, 0, null(), None, null_mut(), null_mut(), place),
            erard_instrument_regulate(instrument, null(), None, null_mut(), null_mut(), place),
            erard_diagnose(null(), null_mut(), place),
            erard_diagnose_check(null(), null_mut(), place),
        ] {
            assert!(text.is_null() && *place == ErardStatus::Null);
        }
        // And an object, but nothing else.
        let action = Action::grand();
        for status in [
            erard_action_advance(action.0, 1e-3, null(), null_mut()),
            erard_action_read(action.0, null_mut()),
            erard_action_save(action.0, null_mut(), null_mut()),
            erard_action_restore(action.0, null(), 0),
            erard_action_angles(action.0, null_mut(), 99),
        ] {
            assert_eq!(status, ErardStatus::Null);
        }
        assert_eq!(erard_action_step_force(action.0, 1.0, null_mut()), ErardStatus::Ok, "a reading may be NULL");
    }
}

/// Bytes that are no saved state, of another step, another instrument, or damaged; and too little room.
#[test]
fn states_that_do_not_fit() {
    let action = midway();
    let good = action.save();
    let other = unsafe { erard_action_new(null(), 0, 25e-6, null_mut()) };
    let heavy = unsafe { erard_instrument_builtin(c"heavy-touch".as_ptr(), null_mut()) };
    let third = unsafe { erard_action_of_instrument(heavy, 50e-6, null_mut()) };
    unsafe { erard_instrument_free(heavy) };
    for foreign in [Action(other), Action(third)] {
        assert_eq!(action.restore(&foreign.save()), ErardStatus::Foreign);
        assert_eq!(foreign.restore(&good), ErardStatus::Foreign);
    }
    assert_eq!(action.restore(&good[..good.len() - 1]), ErardStatus::Saved);
    assert_eq!(action.restore(&[]), ErardStatus::Saved);
    for n in 0..good.len() {
        let mut bad = good.clone();
        bad[n] ^= 1 << (n % 8);
        assert_eq!(action.restore(&bad), ErardStatus::Saved, "byte {n}");
    }
    unchanged(&action, &good, "refused states");
    assert_eq!(action.restore(&good), ErardStatus::Ok);
    let (mut small, mut size) = (vec![7_u8; good.len() - 1], good.len() - 1);
    assert_eq!(unsafe { erard_action_save(action.0, small.as_mut_ptr(), &raw mut size) }, ErardStatus::Size);
    assert!(size == good.len() && small.iter().all(|byte| *byte == 7), "nothing is written");
    assert_eq!(unsafe { erard_action_angles(action.0, [0.0].as_mut_ptr(), 1) }, ErardStatus::Size);
}

/// A keyboard that is driven wrongly.
#[test]
fn keys_that_are_not_there() {
    let keyboard = unsafe { erard_keyboard_new(null(), 0, 50e-6, null_mut()) };
    let mut size = 0;
    unsafe { erard_keyboard_save(keyboard, null_mut(), &raw mut size) };
    let save = || {
        let (mut bytes, mut n) = (vec![0_u8; size], size);
        assert_eq!(unsafe { erard_keyboard_save(keyboard, bytes.as_mut_ptr(), &raw mut n) }, ErardStatus::Ok);
        bytes
    };
    let good = save();
    let restore = |bytes: &[u8]| unsafe { erard_keyboard_restore(keyboard, bytes.as_ptr(), bytes.len()) };
    unsafe {
        for key in [0, 89, u32::MAX] {
            assert_eq!(erard_keyboard_drive(keyboard, key, &pushed(1.0)), ErardStatus::NoSuch);
            let mut reading = ErardReading::default();
            assert_eq!(erard_keyboard_read(keyboard, key, &raw mut reading), ErardStatus::NoSuch);
            assert_eq!(erard_keyboard_angles(keyboard, key, &raw mut reading.time_s, 1), ErardStatus::NoSuch);
        }
        let mut angle = 7.0;
        assert_eq!(erard_keyboard_angles(keyboard, 1, &raw mut angle, 1), ErardStatus::Size);
        assert_eq!(angle, 7.0);
        assert_eq!(erard_keyboard_drive(keyboard, 1, &pushed(f64::NAN)), ErardStatus::NotFinite);
        assert_eq!(erard_keyboard_step(keyboard, 0, null_mut(), 0, null_mut()), ErardStatus::Range);
        assert_eq!(erard_keyboard_step(keyboard, u32::MAX, null_mut(), 0, null_mut()), ErardStatus::Range);
        assert_eq!(erard_keyboard_step(keyboard, 1, null_mut(), 5, null_mut()), ErardStatus::Null);
    }
    for n in (0..size).step_by(101) {
        let mut bad = good.clone();
        bad[n] ^= 0x10;
        assert_eq!(restore(&bad), ErardStatus::Saved, "byte {n}");
    }
    assert_eq!(restore(&good[..size - 8]), ErardStatus::Saved);
    assert_eq!(save(), good);
    assert_eq!(restore(&good), ErardStatus::Ok);
    unsafe { erard_keyboard_free(keyboard) };
}

/// Files that are wrong, names that are not there, steps that no action takes: a code, and words.
#[test]
fn files_names_and_steps() {
    let read = |text: &[u8]| {
        let mut status = ErardStatus::Ok;
        let action = unsafe { erard_action_new(text.as_ptr().cast::<c_char>(), text.len(), 50e-6, &raw mut status) };
        assert!(action.is_null());
        (status, last_error())
    };
    for (text, words) in [
        (&b"\xff\xfe"[..], "UTF-8"),
        (b" ", "empty"),
        (b"format = 3", "format"),
        (b"format = \"erard-instrument/1\"\nname = \"x\"\ngravity_m_s2 = nan\n", "instrument:"),
        (b"a\0b = 1", "instrument:1"),
    ] {
        let (status, said) = read(text);
        assert_eq!(status, ErardStatus::File);
        assert!(said.contains(words), "{said}");
    }
    for step_s in [0.0, -1.0, f64::NAN, f64::INFINITY, 1.0, 1e-300, 9e-9, 1.1e-3] {
        let mut status = ErardStatus::Ok;
        assert!(unsafe { erard_action_new(null(), 0, step_s, &raw mut status) }.is_null());
        assert_eq!(status, ErardStatus::Range, "{step_s}");
        assert!(last_error().contains("step"), "{}", last_error());
        assert!(unsafe { erard_keyboard_new(null(), 0, step_s, &raw mut status) }.is_null());
        assert_eq!(status, ErardStatus::Range, "{step_s}");
    }
    let mut status = ErardStatus::Ok;
    let unknown = CString::new("concert-gong").unwrap();
    assert!(unsafe { erard_instrument_builtin(unknown.as_ptr(), &raw mut status) }.is_null());
    assert_eq!(status, ErardStatus::NoSuch);
    assert!(last_error().contains("concert-gong") && last_error().contains("heavy-touch"), "{}", last_error());
    for key in [0, 89] {
        assert!(erard_instrument_of_key(key, &raw mut status).is_null() && status == ErardStatus::NoSuch);
    }
    // Every status has words, and so has what is none.
    for code in (-13..=1).chain([77, i32::MIN]) {
        let text = unsafe { std::ffi::CStr::from_ptr(erard_status_text(code)) };
        assert!(text.to_str().is_ok_and(|text| text.len() > 3), "{code}");
    }
}

/// Threads: each has its own last error, and an action may be handed on.
#[test]
fn threads() {
    let mut status = ErardStatus::Ok;
    erard_instrument_of_key(0, &raw mut status);
    let mine = last_error();
    let action = midway();
    let before = action.read();
    let handed = action.0 as usize;
    let moved = std::thread::spawn(move || {
        assert_eq!(last_error(), "");
        let action = Action(handed as *mut ErardAction);
        let reading = action.force(5.0);
        std::mem::forget(action);
        reading
    });
    assert!(moved.join().unwrap().time_s > before.time_s);
    assert_eq!(last_error(), mine);
}

/// Steps of 1 ms are far too long for motions of up to 10 m/s and forces of 10 kN, all of them legal: the action may
/// fly apart. A refused call then leaves every byte of the state, and no reading with the status OK has a number that
/// is not finite.
#[test]
fn what_flies_apart_is_refused_without_a_trace() {
    let (mut refused, mut taken) = (0, 0);
    for name in ["concert-grand", "heavy-touch", "concert-grand-rigid"] {
        let text = erard::Instrument::builtin_text(name).expect("it is built in");
        for seed in 1..=20_u64 {
            let mut status = ErardStatus::Internal;
            let action = Action(unsafe { erard_action_new(text.as_ptr().cast(), text.len(), 1e-3, &raw mut status) });
            assert_eq!(status, ErardStatus::Ok, "{}", last_error());
            let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
            let mut chance = || {
                state ^= state << 13;
                state ^= state >> 7;
                state ^= state << 17;
                2.0 * (state >> 11) as f64 / (1_u64 << 53) as f64 - 1.0
            };
            for n in 0..120 {
                let before = action.save();
                let mut r = ErardReading::default();
                let (kind, a, b) = (chance(), chance(), chance());
                let status = unsafe {
                    match kind {
                        k if k < -0.6 => erard_action_step_force(action.0, 1e4 * a, &raw mut r),
                        k if k < -0.4 => erard_action_advance(action.0, 3e-3, &moving(0.02 * a, 10.0 * b), &raw mut r),
                        k if k < 0.3 => erard_action_step_motion(action.0, 0.02 * a, 10.0 * b, &raw mut r),
                        _ => erard_action_step_rigid(action.0, 0.02 * a, 10.0 * b, &raw mut r),
                    }
                };
                if (status as i32) < 0 {
                    refused += 1;
                    let after = action.save();
                    let differs = before.iter().zip(&after).position(|(a, b)| a != b);
                    // A list's name stands in front of its numbers.
                    let near = |at: usize| String::from_utf8_lossy(&before[at.saturating_sub(200)..at]).into_owned();
                    let near = differs.map(near);
                    assert!(differs.is_none(), "{name}, {seed}, call {n}: {status:?}, {kind} {a} {b} {near:?}");
                    assert_eq!(action.read(), r, "{name}, {seed}, call {n}");
                } else {
                    taken += 1;
                    let all = [
                        r.time_s,
                        r.key_m,
                        r.key_m_per_s,
                        r.finger_force_n,
                        r.finger_force_mean_n,
                        r.hammer_rise_m,
                        r.hammer_rise_m_per_s,
                        r.string_n,
                        r.hand_m,
                        r.hand_m_per_s,
                        r.impact_time_s,
                        r.hammer_speed_m_per_s,
                    ];
                    assert!(all.iter().all(|number| number.is_finite()), "{name}, {seed}, call {n}: {r:?}");
                }
            }
        }
    }
    println!("{refused} calls refused, {taken} taken");
    assert!(refused > 0, "nothing flies apart any more: choose other calls");
}
