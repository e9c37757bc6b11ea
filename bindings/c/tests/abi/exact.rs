//! The interface adds nothing: the same bits as the native library, and as a run that was not disturbed.

use std::ptr::{null, null_mut};

use erard::Input;
use erard::knocks::{KeyBed, Knock, Knocks};
use erard_c::*;

use crate::{Action, last_error, moving, pushed};

/// Two strokes, the second of them before the first has died away.
fn stroke(n: usize) -> f64 {
    [5.0, 0.0, 9.0, 0.0][n / 2500 % 4]
}

fn bits(r: &ErardReading) -> [u64; 8] {
    [
        r.time_s,
        r.key_m,
        r.key_m_per_s,
        r.finger_force_n,
        r.hammer_rise_m,
        r.hammer_rise_m_per_s,
        r.string_n,
        r.hammer_speed_m_per_s,
    ]
    .map(f64::to_bits)
}

/// Every number of every step is the native action's, force and motion, impacts among it.
#[test]
fn steps_are_the_native_actions() {
    let grand = erard::Instrument::builtin("concert-grand").unwrap();
    for by_motion in [false, true] {
        let (here, mut there) = (Action::grand(), erard::Action::new(&grand).unwrap());
        let mut impacts = 0;
        for n in 0..10_000 {
            let t = n as f64 * 50e-6;
            let (input, native) = if by_motion {
                let (position_m, velocity_m_per_s) = (0.006 * (1.0 - (20.0 * t).cos()), 0.12 * (20.0 * t).sin());
                (moving(position_m, velocity_m_per_s), Input::Motion { position_m, velocity_m_per_s })
            } else {
                (pushed(stroke(n)), Input::Force(stroke(n)))
            };
            let mut r = ErardReading::default();
            let status = if by_motion {
                unsafe { erard_action_step_motion(here.0, input.position_m, input.velocity_m_per_s, &raw mut r) }
            } else {
                unsafe { erard_action_step_force(here.0, input.force_n, &raw mut r) }
            };
            let native = there.step(native);
            assert_eq!(status == ErardStatus::Ok, native.outcome == erard::StepOutcome::Converged);
            let found = [r.key_m, r.key_m_per_s, r.finger_force_n, r.hammer_rise_m, r.hammer_rise_m_per_s, r.string_n];
            let expected = [
                native.key_m,
                native.key_m_per_s,
                native.finger_force_n,
                native.hammer_rise_m,
                native.hammer_rise_m_per_s,
                native.string_n,
            ];
            assert_eq!(found.map(f64::to_bits), expected.map(f64::to_bits), "step {n}");
            assert_eq!(r.time_s, there.time_s());
            assert_eq!(r.new_impact_count == 1, there.impact().is_some(), "step {n}");
            if let Some(impact) = there.impact() {
                impacts += 1;
                assert_eq!(
                    (r.impact_time_s, r.hammer_speed_m_per_s, r.impact_count),
                    (impact.time_s, impact.hammer_speed_m_per_s, impacts)
                );
            }
        }
        assert!(impacts >= 2, "{impacts} impacts");
        let angles: Vec<u64> = there.angles().iter().map(|angle| angle.to_bits()).collect();
        assert_eq!(here.angles(), angles);
    }
}

/// Restored anywhere, in another action, after anything: readings of then, and the same bits from there on; modal
/// strings ring on as they did.
#[test]
fn saved_states_go_on_to_the_bit() {
    goes_on(&Action::grand(), &Action::grand());
    let (straight, other) = (Action::strung(), Action::strung());
    assert!(straight.save().len() > Action::grand().save().len() + 16 * 50, "fifty modes and more are saved");
    assert_eq!(other.restore(&Action::grand().save()), ErardStatus::Foreign);
    assert_eq!(Action::grand().restore(&straight.save()), ErardStatus::Foreign, "strings into an action without");
    goes_on(&straight, &other);
}

fn goes_on(straight: &Action, other: &Action) {
    let mut all = Vec::new();
    let mut saved = Vec::new();
    for n in 0..10_000 {
        if n % 97 == 0 {
            saved.push((n, straight.save(), straight.read()));
        }
        all.push(bits(&straight.force(stroke(n))));
    }
    let last = straight.angles();
    for (k, (from, bytes, reading)) in saved.iter().enumerate() {
        for _ in 0..k % 40 {
            other.force(30.0);
        }
        assert_eq!(other.restore(bytes), ErardStatus::Ok);
        assert_eq!(other.read(), *reading);
        assert_eq!(other.save(), *bytes, "what is saved anew is the same");
        let end = if k % 10 == 0 { all.len() } else { (from + 200).min(all.len()) };
        for (n, expected) in all.iter().enumerate().take(end).skip(*from) {
            assert_eq!(bits(&other.force(stroke(n))), *expected, "saved at {from}, step {n}");
        }
        if end == all.len() {
            assert_eq!(other.angles(), last);
        }
    }
}

/// Reset is what it was when it was made.
#[test]
fn reset_is_the_beginning() {
    let (used, fresh) = (Action::grand(), Action::grand());
    for n in 0..3000 {
        used.force(stroke(n));
    }
    assert_eq!(unsafe { erard_action_reset(used.0) }, ErardStatus::Ok);
    assert_eq!(used.read(), fresh.read());
    for n in 0..3000 {
        assert_eq!(bits(&used.force(stroke(n))), bits(&fresh.force(stroke(n))), "step {n}");
    }
}

/// A period of any length is as many steps as it has room for, none lost, none too many; and twenty at once are twenty.
#[test]
fn periods_are_steps() {
    let (whole, single) = (Action::grand(), Action::grand());
    for n in 0..200 {
        let force_n = if n < 100 { 6.0 } else { 0.0 };
        let reading = whole.advance(1e-3, pushed(force_n));
        let (mut last, mut sum, mut impacts) = (ErardReading::default(), 0.0, 0);
        for _ in 0..20 {
            last = single.force(force_n);
            sum += last.finger_force_n;
            impacts += last.new_impact_count;
        }
        assert_eq!(bits(&reading), bits(&last), "period {n}");
        assert_eq!((reading.finger_force_mean_n, reading.new_impact_count), (sum / 20.0, impacts));
    }
    assert!(whole.read().impact_count > 0);
    // 44.1 kHz: less than a step, and no multiple of it.
    let action = Action::grand();
    for n in 1..=44_100 {
        let reading = action.advance(1.0 / 44_100.0, pushed(0.1));
        let due = f64::from(n) / 44_100.0;
        assert!(reading.time_s <= due + 1e-9 && reading.time_s > due - 50e-6 - 1e-9, "{} of {due}", reading.time_s);
    }
    assert_eq!(unsafe { erard_action_reset(action.0) }, ErardStatus::Ok);
    // A device's position moves on within its period: a straight way in periods of 20 steps is the same as step by
    // step.
    let single = Action::grand();
    let (v, h) = (0.1, 50e-6);
    for n in 0..80 {
        let x = v * f64::from(n) * 20.0 * h;
        let reading = action.advance(20.0 * h, moving(x, v));
        let mut last = ErardReading::default();
        for k in 0..20 {
            let at = x + v * (f64::from(k) * h + 0.5 * h);
            assert_eq!(unsafe { erard_action_step_motion(single.0, at, v, &raw mut last) }, ErardStatus::Ok);
        }
        assert_eq!(bits(&reading), bits(&last), "period {n}");
    }
    assert!(action.read().key_m > 7e-3);
}

/// A key's bodies stand as those of its instrument alone.
#[test]
fn keys_show_their_angles() {
    let keyboard = Keyboard::new();
    let instrument = erard_instrument_of_key(40, null_mut());
    let alone = Action(unsafe { erard_action_of_instrument(instrument, 50e-6, null_mut()) });
    let bodies = unsafe { erard_action_body_count(alone.0) };
    let angles = || {
        let mut angles = vec![0.0_f64; bodies];
        assert_eq!(unsafe { erard_keyboard_angles(keyboard.0, 40, angles.as_mut_ptr(), bodies) }, ErardStatus::Ok);
        angles.iter().map(|angle| angle.to_bits()).collect::<Vec<u64>>()
    };
    assert_eq!(angles(), alone.angles());
    let rest = angles();
    keyboard.drive(40, 6.0);
    keyboard.step(1000);
    for _ in 0..1000 {
        alone.force(6.0);
    }
    assert_eq!(angles(), alone.angles());
    assert_ne!(angles(), rest);
    drop(alone);
    unsafe { erard_instrument_free(instrument) };
}

/// The string's shape is that of a run: it bulges away from the hammer where it is struck, and of a rigid string there
/// is none.
#[test]
fn strings_show_their_shape() {
    let (rigid, strung) = (Action::grand(), Action::strung());
    assert_eq!(unsafe { erard_action_string_places(rigid.0, null_mut(), 0) }, 0);
    let count = unsafe { erard_action_string_places(strung.0, null_mut(), 0) };
    let mut places = vec![0.0; count];
    assert_eq!(unsafe { erard_action_string_places(strung.0, places.as_mut_ptr(), count) }, count);
    assert!(count > 10 && places.is_sorted() && places[0] < 0.0 && places[count - 1] > 0.0, "{places:?}");
    let shape = || {
        let mut shape = vec![0.0_f32; count];
        assert_eq!(unsafe { erard_action_string_shape(strung.0, shape.as_mut_ptr(), count) }, ErardStatus::Ok);
        shape
    };
    assert_eq!(unsafe { erard_action_string_shape(strung.0, [0.0_f32].as_mut_ptr(), 1) }, ErardStatus::Size);
    // It rests under its damper, which presses it by hundredths of a millimetre.
    assert!(shape().iter().all(|m| m.abs() < 1e-4), "{:?}", shape());
    let mut struck = 0;
    for _ in 0..4000 {
        let reading = strung.force(6.0);
        if reading.string_n > 5.0 {
            // The hammer displaces the string where it pushes, by tenths of a millimetre.
            let middle = places.iter().position(|place| *place >= 0.0).unwrap();
            struck += u32::from(shape()[middle] > 1e-5);
            assert!(shape().iter().all(|m| m.abs() < 5e-3));
        }
    }
    assert!(struck > 5, "{struck}");
}

struct Keyboard(*mut ErardKeyboard);

impl Keyboard {
    fn new() -> Self {
        let keyboard = unsafe { erard_keyboard_new(null(), 0, 50e-6, null_mut()) };
        assert!(!keyboard.is_null());
        Keyboard(keyboard)
    }

    fn strung() -> Self {
        let text = include_str!("../../../../crates/erard-core/keyboards/concert-grand-strings.toml");
        let keyboard = unsafe { erard_keyboard_new(text.as_ptr().cast(), text.len(), 50e-6, null_mut()) };
        assert!(!keyboard.is_null(), "{}", last_error());
        Keyboard(keyboard)
    }

    fn drive(&self, key: u32, force_n: f64) {
        assert_eq!(unsafe { erard_keyboard_drive(self.0, key, &pushed(force_n)) }, ErardStatus::Ok);
    }

    fn step(&self, steps: u32) -> Vec<ErardImpact> {
        let (mut impacts, mut count) = (vec![ErardImpact::default(); 64], 0);
        let status = unsafe { erard_keyboard_step(self.0, steps, impacts.as_mut_ptr(), 64, &raw mut count) };
        assert_eq!(status, ErardStatus::Ok);
        impacts.truncate(count);
        impacts
    }

    fn read(&self, key: u32) -> ErardReading {
        let mut reading = ErardReading::default();
        assert_eq!(unsafe { erard_keyboard_read(self.0, key, &raw mut reading) }, ErardStatus::Ok);
        reading
    }

    fn save(&self) -> Vec<u8> {
        let mut size = 0;
        unsafe { erard_keyboard_save(self.0, null_mut(), &raw mut size) };
        let mut bytes = vec![0; size];
        assert_eq!(unsafe { erard_keyboard_save(self.0, bytes.as_mut_ptr(), &raw mut size) }, ErardStatus::Ok);
        bytes
    }
}

impl Drop for Keyboard {
    fn drop(&mut self) {
        unsafe { erard_keyboard_free(self.0) };
    }
}

/// While strings of three keys ring, in another keyboard: the same bits of readings, and the same impacts.
#[test]
fn a_strung_keyboard_goes_on() {
    strung_goes_on(1);
}

#[test]
#[ignore = "ci: six rounds"]
fn a_strung_keyboard_goes_on_for_long() {
    strung_goes_on(6);
}

fn strung_goes_on(rounds: u32) {
    let (first, second) = (Keyboard::strung(), Keyboard::strung());
    let press = |keyboard: &Keyboard, force_n| [1, 40, 88].map(|key| keyboard.drive(key, force_n));
    press(&first, 16.0);
    assert!(first.step(1600).len() >= 3);
    press(&first, 0.0);
    first.step(500);
    let bytes = first.save();
    press(&second, 12.0);
    second.step(300);
    assert_eq!(unsafe { erard_keyboard_restore(second.0, bytes.as_ptr(), bytes.len()) }, ErardStatus::Ok);
    for round in 0..rounds {
        let force_n = if round % 2 == 0 { 9.0 } else { 0.0 };
        press(&first, force_n);
        press(&second, force_n);
        assert_eq!(first.step(1500).len(), second.step(1500).len());
        for key in [1, 40, 88] {
            // Instants are right to a rounding, and with them the speed of the impact, which is read from the flight
            // before it.
            let (here, there) = (first.read(key), second.read(key));
            assert_eq!(bits(&here)[1..7], bits(&there)[1..7], "key {key} in round {round}");
            assert!(
                (here.hammer_speed_m_per_s - there.hammer_speed_m_per_s).abs() < 1e-9,
                "{} {}",
                here.hammer_speed_m_per_s,
                there.hammer_speed_m_per_s
            );
        }
    }
    let mut bad = bytes.clone();
    bad.truncate(bytes.len() - 8);
    assert_eq!(unsafe { erard_keyboard_restore(second.0, bad.as_ptr(), bad.len()) }, ErardStatus::Saved);
}

/// A chord on strings, the pedal down: the force of each key on the bridge is that of the native keys, to the bit; and
/// that of one action is the native action's.
#[test]
fn a_chord_is_heard_at_the_bridge() {
    chord_is_heard([700, 1100], 16.0);
}

#[test]
#[ignore = "ci: the chord damped for a tenth of a second"]
fn a_chord_is_heard_until_it_is_damped() {
    chord_is_heard([2400, 4800], 6.0);
}

/// The steps at which the fingers leave, and the test ends; the force of each.
fn chord_is_heard([leave, end]: [u32; 2], pressed_n: f64) {
    const STEP_S: f64 = 1.0 / 24_000.0;
    let name = c"concert-grand-strings";
    let keyboard = Keyboard(unsafe { erard_keyboard_builtin(name.as_ptr(), STEP_S, null_mut()) });
    assert!(!keyboard.0.is_null(), "{}", last_error());
    let native = erard::keyboard::Keyboard::builtin("concert-grand-strings").unwrap();
    let instruments = native.instruments().unwrap();
    let mut keys = erard::keyboard::Keys::at_rest(&instruments, erard::Settings::new(STEP_S)).unwrap();
    keys.listen(&instruments, &Knock::ALL);
    let mut beds = [KeyBed::new(1.0 / STEP_S), KeyBed::new(1.0 / STEP_S)];
    keys.set_pedal(0.007);
    assert_eq!(unsafe { erard_keyboard_set_pedal(keyboard.0, 0.007) }, ErardStatus::Ok);
    let alone = Action(unsafe {
        let instrument = erard_instrument_builtin(name.as_ptr(), null_mut());
        let action = erard_action_of_instrument(instrument, STEP_S, null_mut());
        erard_instrument_free(instrument);
        action
    });
    assert_eq!(unsafe { erard_action_set_pedal(alone.0, 0.007) }, ErardStatus::Ok);
    let own = erard::Instrument::builtin("concert-grand-strings").unwrap();
    let mut beside = erard::Action::with(&own, erard::Settings::new(STEP_S)).unwrap();
    beside.set_pedal(0.007);
    let knocks = Knocks::of(&own, &Knock::ALL);
    let (mut impacts, mut loudest_n, mut force_n) = (0, 0.0_f64, f64::NAN);
    // Of all keys and of one alone: the loudest sound, and the loudest of the knocks in it, Pa.
    let (mut heard_pa, mut loudest_pa) = ([0.0; 2], [[0.0_f64; 2]; 2]);
    for n in 0..end {
        let finger_force_n = if n < leave { pressed_n } else { 0.0 };
        for key in [40, 44, 47] {
            keyboard.drive(key, finger_force_n);
            keys.drive(key as usize, Input::Force(finger_force_n)).unwrap();
        }
        impacts += keyboard.step(1).len();
        keys.step();
        for key in [40, 44, 47] {
            assert_eq!(unsafe { erard_keyboard_bridge_force(keyboard.0, key, &raw mut force_n) }, ErardStatus::Ok);
            let own_n = keys.strings(key as usize).unwrap().unwrap().bridge_n();
            assert_eq!(force_n.to_bits(), own_n.to_bits(), "key {key} in step {n}: {force_n} and {own_n}");
            loudest_n = loudest_n.max(force_n.abs());
        }
        assert_eq!(unsafe { erard_keyboard_total_bridge_force(keyboard.0, &raw mut force_n) }, ErardStatus::Ok);
        assert_eq!(force_n.to_bits(), keys.bridge_n().to_bits(), "all keys in step {n}");
        alone.force(finger_force_n);
        beside.step(Input::Force(finger_force_n));
        assert_eq!(unsafe { erard_action_bridge_force(alone.0, &raw mut force_n) }, ErardStatus::Ok);
        let strings = beside.strings().unwrap();
        assert_eq!(force_n.to_bits(), strings.bridge_n().to_bits(), "step {n}");
        // The pressure: the boards', and the key bed's.
        let own_n = knocks.force_n(|zone| beside.mechanism().normal_force(zone));
        for (which, (strings_pa, force_n)) in
            [(keys.pressure_pa(), keys.knocks_n()), (strings.pressure_pa().unwrap(), own_n)].into_iter().enumerate()
        {
            let status = match which {
                0 => unsafe { erard_keyboard_pressure(keyboard.0, heard_pa.as_mut_ptr()) },
                _ => unsafe { erard_action_pressure(alone.0, heard_pa.as_mut_ptr()) },
            };
            let bed_pa = beds[which].hear(force_n);
            assert_eq!(status, ErardStatus::Ok);
            assert_eq!(heard_pa, [strings_pa[0] + bed_pa[0], strings_pa[1] + bed_pa[1]], "{which} in step {n}");
            let [all, knocks] = &mut loudest_pa[which];
            (*all, *knocks) = (all.max(heard_pa[0].abs()), knocks.max(bed_pa[0].abs()));
        }
    }
    assert!(impacts == 3 && loudest_n > 1.0, "{impacts} impacts, {loudest_n} N");
    assert!(loudest_pa.iter().all(|[all, knocks]| *all > 0.1 && *knocks > 0.01), "{loudest_pa:?}");
    // A key that rests is silent; what is wrong is refused.
    unsafe {
        assert_eq!(erard_keyboard_bridge_force(keyboard.0, 89, &raw mut force_n), ErardStatus::NoSuch);
        assert_eq!(erard_keyboard_bridge_force(keyboard.0, 40, null_mut()), ErardStatus::Null);
        assert_eq!(erard_action_bridge_force(null_mut(), &raw mut force_n), ErardStatus::Null);
        assert_eq!(erard_keyboard_total_bridge_force(null_mut(), &raw mut force_n), ErardStatus::Null);
        assert_eq!(erard_keyboard_total_bridge_force(keyboard.0, null_mut()), ErardStatus::Null);
        assert_eq!(erard_keyboard_pressure(keyboard.0, null_mut()), ErardStatus::Null);
        assert_eq!(erard_keyboard_pressure(null_mut(), heard_pa.as_mut_ptr()), ErardStatus::Null);
        assert_eq!(erard_action_pressure(null_mut(), heard_pa.as_mut_ptr()), ErardStatus::Null);
        // Without a soundboard there is nothing to hear.
        let rigid = Keyboard::new();
        assert_eq!(erard_keyboard_pressure(rigid.0, heard_pa.as_mut_ptr()), ErardStatus::NoSuch);
        let rigid = Action::grand();
        assert_eq!(erard_action_pressure(rigid.0, heard_pa.as_mut_ptr()), ErardStatus::NoSuch);
        // A key's instrument by the keyboard's name: the same as of the file.
        let mut status = ErardStatus::Ok;
        let instrument = erard_instrument_of_keyboard(name.as_ptr(), 47, &raw mut status);
        assert_eq!(crate::taken(erard_instrument_text(instrument, null_mut(), null_mut())), native.key_text(47));
        erard_instrument_free(instrument);
        assert!(erard_instrument_of_keyboard(name.as_ptr(), 89, &raw mut status).is_null());
        assert_eq!(status, ErardStatus::NoSuch);
        assert_eq!(erard_keyboard_set_pedal(keyboard.0, f64::NAN), ErardStatus::NotFinite);
        let mut status = ErardStatus::Ok;
        assert!(erard_keyboard_builtin(c"harpsichord".as_ptr(), STEP_S, &raw mut status).is_null());
        assert_eq!(status, ErardStatus::NoSuch);
        assert!(last_error().contains("built in are concert-grand"), "{}", last_error());
    }
}

/// the keys that are played strike, each as an action of its own does; those at rest sleep. Saved and restored, at
/// another instant of the clock and one step before an impact: the same bits, the same impact.
#[test]
fn a_keyboard_plays() {
    let keyboard = Keyboard::new();
    assert_eq!(unsafe { (erard_keyboard_key_count(keyboard.0), erard_keyboard_awake_count(keyboard.0)) }, (88, 0));
    keyboard.step(100);
    let began_s = keyboard.read(40).time_s;
    assert!((began_s - 5e-3).abs() < 1e-12);

    // A key is the action of its instrument.
    let native = erard::keyboard::Keyboard::builtin("concert-grand").unwrap().key(40).unwrap();
    let mut alone = erard::Action::with(&native, erard::Settings::new(50e-6)).unwrap();
    let mut alone_impact = None;
    keyboard.drive(40, 6.0);
    keyboard.drive(41, 9.0);
    let mut impacts = Vec::new();
    let mut before = Vec::new();
    for n in 0.. {
        // Before each step that may bring an impact: a hammer is near its string.
        let near = [40, 41].iter().any(|&key| keyboard.read(key).hammer_rise_m > 0.03);
        let saved = near.then(|| keyboard.save());
        let new = keyboard.step(1);
        alone.step(Input::Force(6.0));
        if let Some(impact) = alone.impact() {
            alone_impact = Some((n, impact));
        }
        if !new.is_empty() {
            before.push((saved.expect("no impact from afar"), new.clone()));
            impacts.extend(new);
        }
        if impacts.len() == 2 {
            break;
        }
        assert!(n < 4000, "no two impacts");
    }
    assert_eq!(unsafe { erard_keyboard_awake_count(keyboard.0) }, 2);
    let mine = impacts.iter().find(|impact| impact.key == 40).expect("key 40 sounds");
    let (_, impact) = alone_impact.expect("alone, too");
    assert_eq!(mine.hammer_speed_m_per_s.to_bits(), impact.hammer_speed_m_per_s.to_bits());
    assert!((mine.time_s - began_s - impact.time_s).abs() < 1e-12);

    let other = Keyboard::new();
    other.drive(7, 20.0);
    other.step(1234);
    for (saved, expected) in &before {
        assert_eq!(unsafe { erard_keyboard_restore(other.0, saved.as_ptr(), saved.len()) }, ErardStatus::Ok);
        let found = other.step(1);
        assert_eq!(found.len(), expected.len());
        for (a, b) in found.iter().zip(expected) {
            assert_eq!(a.key, b.key);
            // Its place in the flight is computed from instants that were moved: rounding of the clock.
            assert!(
                (a.time_s - b.time_s).abs() < 1e-11
                    && (a.hammer_speed_m_per_s / b.hammer_speed_m_per_s - 1.0).abs() < 1e-9,
                "{a:?} {b:?}"
            );
        }
    }
    keyboard.step(500);
    other.step(500);
    for key in [7, 40, 41] {
        let (a, b) = (keyboard.read(key), other.read(key));
        assert_eq!(
            (a.key_m.to_bits(), a.hammer_rise_m.to_bits()),
            (b.key_m.to_bits(), b.hammer_rise_m.to_bits()),
            "key {key}"
        );
        assert!((a.time_s - b.time_s).abs() < 1e-11);
    }
    keyboard.drive(40, 0.0);
    keyboard.drive(41, 0.0);
    keyboard.step(40_000);
    assert_eq!(unsafe { erard_keyboard_awake_count(keyboard.0) }, 0, "what was let go sleeps");
}

/// A state has lists with names: a native snapshot is a state that lacks the interface's own, and a state is a snapshot
/// that has more.
#[test]
fn states_and_snapshots_are_one() {
    let (here, native) = (Action::strung(), erard::Instrument::builtin("concert-grand-strings").unwrap());
    let mut there = erard::Action::with(&native, erard::Settings::new(50e-6)).unwrap();
    while there.impact().is_none() {
        there.step(Input::Force(6.0));
        here.force(6.0);
    }
    let (state, snapshot) = (here.save(), there.save());
    assert_eq!(erard::Snapshot::from_bytes(&state), Ok(snapshot.clone()));
    let impacts = here.read().impact_count;
    for _ in 0..100 {
        here.force(1.0);
    }
    assert_eq!(here.restore(&snapshot.to_vec()), ErardStatus::Ok);
    assert_eq!((here.read().impact_count, impacts), (0, 1), "the snapshot knows of no impact");
    for n in 0..200 {
        let native = there.step(Input::Force(2.0));
        assert_eq!(here.force(2.0).hammer_rise_m.to_bits(), native.hammer_rise_m.to_bits(), "step {n}");
    }
    // Of the same numbers by another name.
    let text = erard::Instrument::builtin_text("concert-grand-strings").unwrap();
    let name = text.lines().find(|line| line.starts_with("name = ")).unwrap();
    let other = Action::of(&text.replacen(name, "name = \"mine\"", 1));
    assert_eq!(other.restore(&state), ErardStatus::Ok);
    assert_eq!(other.save(), state);
}
