//! The keys of a keyboard, played together: a fortissimo tremolo over all of them, and their sleep, which changes no
//! bit.

use std::sync::OnceLock;

use crate::common::USUAL_STEP_S;
use erard::instrument::Instrument;
use erard::keyboard::tremolo::{STROKES, TEN, Tremolo};
use erard::keyboard::{KEYS, Keyboard, Keys};
use erard::player::Input;
use moreau::Settings;

/// The keys of the built-in keyboard, assembled and at rest. Its instruments are read once.
fn keys() -> Keys {
    static READ: OnceLock<Vec<Instrument>> = OnceLock::new();
    let instruments = READ.get_or_init(|| {
        let keyboard = Keyboard::builtin("concert-grand").expect("the built-in keyboard reads");
        keyboard.instruments().expect("every key is an instrument")
    });
    Keys::at_rest(instruments, Settings::new(USUAL_STEP_S)).expect("every key comes to rest")
}

/// What an observer of the tremolo sees in a tick.
fn observed(tremolo: &Tremolo) -> (Vec<(usize, u64)>, Vec<u64>) {
    let impacts = tremolo.keys().impacts().iter().map(|b| (b.key, b.impact.hammer_speed_m_per_s.to_bits()));
    let mut impacts: Vec<_> = impacts.collect();
    impacts.sort_unstable();
    (impacts, (1..=KEYS).map(|key| tremolo.keys().string_force(key).unwrap().to_bits()).collect())
}

/// Ten fingers play a fortissimo tremolo once over all 88 keys. Every stroke sounds, once, at the speeds of a
/// fortissimo (published: 4.5 to 5 m/s; lighter hammers are faster); every step converges; at most the ten keys that
/// are played and the ten that were left last are awake, give or take the slowest to settle; and at the end all keys
/// fall asleep.
#[test]
fn ten_fingers_play_all_keys() {
    let mut tremolo = Tremolo::new(keys(), TEN);
    let mut speeds = vec![Vec::new(); KEYS + 1];
    let mut most_awake = 0;
    for _ in 0..tremolo.ticks_over_all() {
        let tick = tremolo.tick();
        assert_eq!((tick.unconverged, tick.non_finite), (0, 0));
        most_awake = most_awake.max(tick.stepped);
        for impact in tremolo.keys().impacts() {
            speeds[impact.key].push(impact.impact.hammer_speed_m_per_s);
        }
    }
    let all = || speeds.iter().flatten().copied();
    let (slowest, fastest) = (all().fold(f64::MAX, f64::min), all().fold(0.0, f64::max));
    println!("{} impacts of {slowest:.2} to {fastest:.2} m/s, at most {most_awake} keys awake", all().count());
    // Every stroke sounds once. Fingers with a shorter stretch begin anew while the others end; so does every other
    // finger, which is half a stroke ahead.
    let (first, longest) = (|finger: usize| 1 + KEYS * finger / TEN, KEYS.div_ceil(TEN));
    let mut strokes = vec![0; KEYS + 1];
    for finger in 0..TEN {
        let (from, to) = (first(finger), first(finger + 1));
        for stroke in 0..longest * STROKES + usize::from(finger % 2 == 0) {
            strokes[from + stroke / STROKES % (to - from)] += 1;
        }
    }
    assert_eq!(speeds.iter().map(Vec::len).collect::<Vec<_>>(), strokes);
    assert!(slowest > 3.5 && fastest < 7.5, "{slowest} to {fastest} m/s");
    assert!((TEN as u32..=3 * TEN as u32).contains(&most_awake));
    let mut ticks = 0;
    while tremolo.keys().awake() > 0 {
        // Whoever was played is let go.
        (1..=KEYS).for_each(|key| tremolo.keys_mut().drive(key, Input::Force(0.0)).unwrap());
        tremolo.keys_mut().step();
        ticks += 1;
        assert!(ticks < 20_000, "a second after the last stroke {} keys are awake", tremolo.keys().awake());
    }
}

/// A keyboard whose keys sleep and one that is stepped in full go through the same states, bit for bit: impacts, forces
/// on the strings in every tick, and the whole state now and then, while fingers wander, keys fall asleep at rest and
/// under a finger that stays.
#[test]
fn sleep_changes_no_bit() {
    sleeps_as_stepped(3);
}

#[test]
#[ignore = "ci: all keys stepped for a second"]
fn sleep_changes_no_bit_for_a_second() {
    sleeps_as_stepped(1);
}

/// A second or a part of it.
fn sleeps_as_stepped(part: u64) {
    let [mut sleeping, mut stepped] = [keys(), keys()].map(|keys| Tremolo::new(keys, TEN));
    stepped.keys_mut().let_sleep(false);
    let same = |a: &Tremolo, b: &Tremolo, n| {
        for key in 1..=KEYS {
            assert_eq!(
                format!("{:?}", a.keys().save(key).unwrap()),
                format!("{:?}", b.keys().save(key).unwrap()),
                "key {key} after {n} ticks"
            );
        }
    };
    let mut skipped = 0;
    let (wandering, held) = (9_000 / part, 12_000 / part);
    for n in 0..wandering {
        let (less, all) = (sleeping.tick(), stepped.tick());
        assert_eq!(all.stepped as usize, KEYS);
        skipped += all.stepped - less.stepped;
        assert_eq!(observed(&sleeping), observed(&stepped), "tick {n}");
        if n % 500 == 0 {
            same(&sleeping, &stepped, n);
        }
    }
    // Now every other key is held by a constant force: held notes fall asleep, too.
    for n in 0..held {
        for tremolo in [&mut sleeping, &mut stepped] {
            for key in (1..=KEYS).step_by(2) {
                tremolo.keys_mut().drive(key, Input::Force(10.0)).unwrap();
            }
            skipped += KEYS as u32 - tremolo.keys_mut().step().stepped;
        }
        if n % 1000 == 0 {
            same(&sleeping, &stepped, wandering + n);
        }
    }
    same(&sleeping, &stepped, wandering + held);
    println!("{skipped} steps were not taken; {} keys are awake at the end", sleeping.keys().awake());
    assert!(u64::from(skipped) * part > 500_000, "{skipped}");
    assert_eq!(stepped.keys().awake(), KEYS);
}

/// A key wakes at any change of its input, were it in the last bit, and at none that is no change.
#[test]
fn a_key_wakes_at_any_change() {
    let mut keys = keys();
    assert_eq!(keys.awake(), 0, "at rest all sleep");
    keys.drive(40, Input::Free).unwrap();
    assert_eq!(keys.awake(), 0, "as it was driven before");
    let half_way = Input::Motion { position_m: 0.005, velocity_m_per_s: 0.0 };
    for input in [Input::Force(0.0), Input::Force(-0.0), Input::Force(5e-324), half_way, Input::Force(10.0)] {
        keys.drive(40, input).unwrap();
        assert_eq!(keys.awake(), 1, "{input:?}");
        let mut ticks = 0;
        while keys.awake() > 0 {
            keys.step();
            ticks += 1;
            assert!(ticks < 20_000, "{input:?}");
        }
    }
}

/// A key front's imposed motion is that of an action of its own, to the bit, from a saved state in the middle of it as
/// well; another drive forgets where it was.
#[test]
fn an_imposed_motion_is_an_actions() {
    let instrument = Instrument::builtin("concert-grand").unwrap();
    let settings = Settings::new(USUAL_STEP_S);
    let mut keys = Keys::at_rest(std::slice::from_ref(&instrument), settings).unwrap();
    let mut alone = erard::Action::with(&instrument, settings).unwrap();
    alone.restore(&keys.save(1).unwrap()).unwrap();
    // 10 mm down and up again, at a speed that the positions do not quite follow.
    let at = |n: u32| {
        let angle = f64::from(n) * 0.01;
        (0.005 * (1.0 - angle.cos()), 0.005 * 0.0098 / USUAL_STEP_S * angle.sin())
    };
    let play = |keys: &mut Keys, from: u32, to: u32| {
        let step = |n: u32| {
            keys.impose(1, at(n).0, at(n).1).unwrap();
            keys.step();
            keys.key_m(1).unwrap().to_bits()
        };
        (from..to).map(step).collect::<Vec<_>>()
    };
    let mut played = play(&mut keys, 1, 300);
    let saved = keys.save(1).unwrap();
    let rest = play(&mut keys, 300, 700);
    keys.drive(1, Input::Free).unwrap();
    keys.step();
    keys.restore(1, &saved).unwrap();
    assert_eq!(play(&mut keys, 300, 700), rest);
    played.extend(rest);
    for (n, bits) in (1..).zip(played) {
        let (position_m, velocity_m_per_s) = at(n);
        let own = alone.step(Input::Rigid { position_m, velocity_m_per_s });
        assert_eq!(own.key_m.to_bits(), bits, "step {n}");
        assert!((own.key_m - position_m).abs() < 1e-4, "step {n}: {} {position_m}", own.key_m);
    }
    // Let go, and imposed again from where the key is: nothing pulls it to where the first motion ended.
    keys.drive(1, Input::Free).unwrap();
    let mut before_m = 0.0;
    for _ in 0..20 {
        before_m = keys.key_m(1).unwrap();
        keys.step();
        alone.step(Input::Free);
    }
    let from_m = keys.key_m(1).unwrap();
    assert!((from_m - at(699).0).abs() > 2e-4, "{from_m}");
    for n in 1..20 {
        keys.impose(1, from_m, 0.0).unwrap();
        keys.step();
        let own = alone.step(Input::Rigid { position_m: from_m, velocity_m_per_s: 0.0 });
        assert_eq!(own.key_m.to_bits(), keys.key_m(1).unwrap().to_bits(), "step {n}");
        // Half a step of the speed that the key had; a tenth of the way to the old aim would be 46 um.
        let half_m = 0.5 * (from_m - before_m).abs();
        assert!((own.key_m - from_m).abs() < 1.1 * half_m, "step {n}: {} {from_m} {half_m}", own.key_m);
    }
}

/// Wherever a key is left, it comes to a complete rest and sleeps within a second and a half: let go, held by a
/// constant force of up to 40 N, or under a soft finger that stays at any depth down to 14 mm (pushing some 80 N at the
/// bottom). Nothing makes it do so but dry friction, which holds: velocities become exactly zero, or, at the very limit
/// of friction, so small that no angle changes by a bit.
#[test]
fn every_key_comes_to_rest() {
    come_to_rest(2);
}

#[test]
#[ignore = "ci: all keys in eight ways"]
fn every_key_comes_to_rest_however_it_is_left() {
    come_to_rest(8);
}

fn come_to_rest(rounds: usize) {
    let mut keys = keys();
    // Shares that are spread evenly and differ from key to key: multiples of the golden section.
    let share = |round: usize, key: usize| (0.618_033_988_749_895 * (round * KEYS + key) as f64).fract();
    for round in 0..rounds {
        for key in 1..=KEYS {
            let x = share(round, key);
            let held = match round % 4 {
                0 => Input::Force(40.0 * x),
                1 => Input::Force(0.0),
                2 => Input::Motion { position_m: 0.014 * x, velocity_m_per_s: 0.0 },
                _ => Input::Free,
            };
            keys.drive(key, held).unwrap();
        }
        let mut ticks = 0;
        while keys.awake() > 0 && ticks < 30_000 {
            keys.step();
            ticks += 1;
        }
        let restless: Vec<usize> = (1..=KEYS).filter(|&key| keys.is_awake(key).unwrap()).collect();
        assert!(restless.is_empty(), "round {round}: {restless:?}");
    }
}

/// No tick allocates: not with ten fingers, not with all keys awake, not when keys fall asleep or wake.
#[test]
fn a_tick_never_allocates() {
    for fingers in [1, TEN, KEYS] {
        let mut tremolo = Tremolo::new(keys(), fingers);
        let mut stepped = 0;
        let counted = allocation_counter::measure(|| {
            for _ in 0..9_000 {
                stepped += tremolo.tick().stepped;
            }
        });
        assert!(stepped > 9_000);
        assert_eq!((counted.count_total, counted.bytes_total), (0, 0), "{fingers} fingers: {counted:?}");
    }
}

/// The instruments of all keys, from the base's text parsed once, are those of the keys' own texts, to the bit.
#[test]
fn instruments_are_those_of_their_texts() {
    for (name, every) in [("concert-grand", 11), ("concert-grand-strings", 1), ("heavy-touch", 11)] {
        let keyboard = Keyboard::builtin(name).unwrap();
        let all = keyboard.instruments().unwrap();
        assert_eq!(all.len(), KEYS);
        for (index, instrument) in all.iter().enumerate().step_by(every) {
            let key = index + 1;
            let written = Instrument::parse(&keyboard.key_text(key), name).unwrap();
            assert_eq!(instrument, &written, "{name}, key {key}");
            assert_eq!((instrument.digest(), instrument.key()), (written.digest(), Some(key)), "{name}, key {key}");
        }
        assert_eq!(&keyboard.key(88).unwrap(), all.last().unwrap());
    }
}

/// Built-in keyboards by their names: each has its own text, key 40 of each is its instrument with nothing added, and a
/// name that nobody knows has none.
#[test]
fn keyboards_by_name() {
    for name in Keyboard::builtin_names() {
        let text = Keyboard::builtin_text(name).expect("built in");
        assert!(text.contains(&format!("instrument = \"{name}\"")), "{name}");
        let keyboard = Keyboard::builtin(name).expect("it reads");
        let (base, own) = (erard::Instrument::builtin(name).expect("built in"), keyboard.key(40).expect("a key"));
        assert_eq!((&own.bodies, &own.zones, &own.springs), (&base.bodies, &base.zones, &base.springs), "{name}");
    }
    let unknown = Keyboard::builtin("clavichord").expect_err("there is none").to_string();
    assert!(unknown.contains("`clavichord`") && unknown.contains("concert-grand-strings"), "{unknown}");
    assert!(Keyboard::builtin_text("clavichord").is_none());
    let lost = "format = \"erard-keyboard/1\"\nname = \"Lost\"\ninstrument = \"clavichord\"\ninstrument_key = 40\n";
    let error = Keyboard::parse(lost, "lost.toml", std::path::Path::new("")).expect_err("there is no such instrument");
    assert!(error.to_string().contains("concert-grand, "), "{error}");
}
