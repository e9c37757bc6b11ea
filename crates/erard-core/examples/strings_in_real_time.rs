//! The cost of strings: a step of the action while its three strings ring and while they are struck, a second of C4
//! beside fixed steps of 50 us, ten fingers' fortissimo tremolo over a keyboard with strings, the worst step of ten
//! fingers in the top octave; and blocks of sound: ten notes that ring, and all keys under the pedal on two cores.
//!
//! `cargo run --release -p erard-core --example strings_in_real_time`

use std::hint::black_box;
use std::time::Instant;

use erard_core::keyboard::{Keyboard, Keys, tremolo::Tremolo};
use erard_core::mechanism::Halving;
use erard_core::{Action, Input, Instrument, Settings};

/// The usual step where strings sound, s, and how many of them a millisecond has.
const STEP_S: f64 = 1.0 / 24e3;
const STEPS_PER_MS: u32 = 24;
/// The step that all were before they were halved, s.
const FIXED_STEP_S: f64 = 50e-6;
const STEPS: u32 = 20_000;
/// Steps of a block of sound, 128 samples at 48 kHz, and how many blocks are timed.
const STEPS_PER_BLOCK: u32 = 64;
const BLOCKS: usize = 10_000;

/// Seconds for a step of a mezzo forte held, every step taken; best of five.
fn step_s(instrument: &Instrument) -> f64 {
    let mut best = f64::INFINITY;
    for _ in 0..5 {
        let mut action = Action::new(instrument).expect("it comes to rest");
        action.set_sleep(false);
        let started = Instant::now();
        for _ in 0..STEPS {
            black_box(action.step(Input::Force(4.5)));
        }
        best = best.min(started.elapsed().as_secs_f64() / f64::from(STEPS));
    }
    best
}

/// The same while the strings ring and the action sleeps, in seconds a step; in the first second after the impact, and
/// after 30 s, when most modes have died away.
fn ringing_s(instrument: &Instrument) -> [f64; 2] {
    let mut action = Action::new(instrument).expect("it comes to rest");
    let mut go = |steps: u32, force_n: f64| {
        let started = Instant::now();
        for _ in 0..steps {
            black_box(action.step(Input::Force(force_n)));
        }
        started.elapsed().as_secs_f64() / f64::from(steps)
    };
    go(4000, 4.5);
    go(4000, 0.0);
    let fresh = go(STEPS, 0.0);
    go(28 * STEPS, 0.0);
    [fresh, go(STEPS, 0.0)]
}

/// Ten fingers, each of which stays on its key and presses it three times a second, forte, in turn; three strings a
/// key. Seconds for a second, and for the worst millisecond.
fn ten_notes(keyboard: &Keyboard) -> [f64; 2] {
    let pressed = [40, 42, 44, 45, 47, 49, 51, 52, 54, 56];
    let keys = Keys::at_rest(&keyboard.instruments().expect("it reads"), Settings::new(STEP_S));
    let mut keys = keys.expect("they rest");
    let (started, mut worst, seconds) = (Instant::now(), 0.0_f64, 3);
    for ms in 0..seconds * 1000 {
        for (finger, key) in pressed.into_iter().enumerate() {
            // Down for two thirds of the time.
            match (ms + 33 * finger) % 333 {
                0 => keys.drive(key, Input::Force(9.0)).expect("a key"),
                222 => keys.drive(key, Input::Free).expect("a key"),
                _ => {}
            }
        }
        let block = Instant::now();
        for _ in 0..STEPS_PER_MS {
            black_box(keys.step());
        }
        worst = worst.max(block.elapsed().as_secs_f64());
    }
    [started.elapsed().as_secs_f64() / seconds as f64, worst]
}

/// Blocks of sound while strings ring that a press of these keys has struck, forte, all keys of which are then held or
/// let go under the pedal. The mean and the worst block as a share of its time; `sleep`: whether actions that rest are
/// left out.
fn blocks(instruments: &[Instrument], pressed: &[usize], pedal_m: f64, sleep: bool, blocks: usize) -> [f64; 2] {
    let mut keys = Keys::at_rest(instruments, Settings::new(STEP_S)).expect("they rest");
    keys.halve(Halving::Fewer(2));
    keys.let_sleep(sleep);
    keys.set_pedal(pedal_m);
    let go = |steps: u32, keys: &mut Keys| {
        let started = Instant::now();
        for _ in 0..steps {
            black_box(keys.step());
            black_box(keys.pressure_pa());
        }
        started.elapsed().as_secs_f64() / (f64::from(steps) * STEP_S)
    };
    go(4800, &mut keys);
    pressed.iter().for_each(|key| keys.drive(*key, Input::Force(9.0)).expect("a key"));
    go(4800, &mut keys);
    if pedal_m > 0.0 {
        pressed.iter().for_each(|key| keys.drive(*key, Input::Free).expect("a key"));
        go(4800, &mut keys);
    }
    let shares: Vec<f64> = (0..blocks).map(|_| go(STEPS_PER_BLOCK, &mut keys)).collect();
    [shares.iter().sum::<f64>() / blocks as f64, shares.into_iter().fold(0.0, f64::max)]
}

/// Seconds for a simulated second of a mezzo forte: pressed, held for half a second, and let go; best of five. Steps
/// that change nothing are left out, as they usually are.
fn second_s(instrument: &Instrument, step_s: f64, halving: Halving) -> f64 {
    let mut best = f64::INFINITY;
    for _ in 0..5 {
        let mut action = Action::with(instrument, Settings::new(step_s)).expect("it comes to rest");
        action.halve(halving);
        let steps = (1.0 / step_s).round() as u32;
        let started = Instant::now();
        for n in 0..steps {
            black_box(action.step(if n < steps / 2 { Input::Force(4.5) } else { Input::Free }));
        }
        best = best.min(started.elapsed().as_secs_f64());
    }
    best
}

/// Ten fingers strike keys 79 to 88 at once, fortissimo, eight times: the mean and the worst step, s, and how many of
/// the steps of an impact take longer than they may. Every impact is the same, so that the quickest of the eight tells
/// what a step costs, and the longest what this computer lost to something else.
fn top_octave(instruments: &[Instrument], halving: Halving) -> ([f64; 2], usize) {
    let mut keys = Keys::at_rest(instruments, Settings::new(STEP_S)).expect("they rest");
    keys.halve(halving);
    let rest: Vec<_> = (1..=keys.count()).map(|key| keys.save(key).expect("a key")).collect();
    let mut took = vec![f64::INFINITY; 12_000];
    for _ in 0..8 {
        rest.iter().enumerate().for_each(|(i, state)| keys.restore(i + 1, state).expect("its own state"));
        // What is restored is awake, and soon falls asleep.
        for _ in 0..100 {
            black_box(keys.step());
        }
        for (n, took) in took.iter_mut().enumerate() {
            match n {
                0 => (79..=88).for_each(|key| keys.drive(key, Input::Force(20.0)).expect("a key")),
                6000 => (79..=88).for_each(|key| keys.drive(key, Input::Free).expect("a key")),
                _ => {}
            }
            let started = Instant::now();
            black_box(keys.step());
            *took = took.min(started.elapsed().as_secs_f64());
        }
    }
    let worst = took.iter().copied().fold(0.0, f64::max);
    ([took.iter().sum::<f64>() / took.len() as f64, worst], took.iter().filter(|took| **took > STEP_S).count())
}

fn main() {
    let strung = Instrument::builtin("concert-grand-strings").expect("built in");
    let (rigid, yielding) = (step_s(&strung.with_rigid_string()), step_s(&strung));
    println!("step, rigid string             {:.3} us", 1e6 * rigid);
    println!("step, one trichord that sounds {:.3} us, {:.2} times as long", 1e6 * yielding, yielding / rigid);
    let [fresh, late] = ringing_s(&strung);
    println!("strings alone, 1 s after an impact {:.3} us, 30 s after it {:.3} us", 1e6 * fresh, 1e6 * late);
    let fixed = second_s(&strung, FIXED_STEP_S, Halving::Never);
    let halved = second_s(&strung, STEP_S, Halving::Auto);
    println!(
        "a second of C4 mf, halved steps {:.1} ms, {:.2} times as long as with fixed steps of 50 us ({:.1} ms)",
        1e3 * halved,
        halved / fixed,
        1e3 * fixed
    );
    let keyboard = Keyboard::builtin("concert-grand-strings").expect("built in");
    for (name, halving) in [("halved", Halving::Auto), ("fewer", Halving::Fewer(2)), ("whole", Halving::Never)] {
        let ([mean, worst], late) = top_octave(&keyboard.instruments().expect("it reads"), halving);
        println!(
            "ten fingers at once in the top octave, ff, {name} steps: mean {:.1} us, worst {:.0} us; {late} steps of an impact take longer than the {:.1} us that pass meanwhile",
            1e6 * mean,
            1e6 * worst,
            1e6 * STEP_S
        );
    }
    let [load, worst] = ten_notes(&keyboard);
    println!(
        "ten fingers that stay on their keys and repeat them, thirty strings: {load:.2} s for a second; worst millisecond {:.2} ms",
        1e3 * worst
    );
    let instruments = keyboard.instruments().expect("it reads");
    let ten = [28, 31, 35, 40, 43, 47, 52, 55, 59, 64];
    let mut bare = None;
    for (name, sleep) in [("their actions asleep", true), ("their actions stepped", false)] {
        let held: Vec<Instrument> = ten.iter().map(|key| instruments[key - 1].clone()).collect();
        let [mean, worst] = blocks(&held, &(1..=10).collect::<Vec<_>>(), 0.0, sleep, BLOCKS);
        println!(
            "ten held notes that ring, {name}: {:.0} % of real time, {:.1} times the strings alone; worst of {BLOCKS} blocks {:.0} %",
            100.0 * mean,
            mean / *bare.get_or_insert(mean),
            100.0 * worst
        );
    }
    let halves = std::thread::scope(|scope| {
        let half = |from: usize| {
            let own: Vec<Instrument> = instruments.iter().skip(from).step_by(2).cloned().collect();
            scope.spawn(move || blocks(&own, &(1..=own.len()).collect::<Vec<_>>(), 7e-3, true, BLOCKS / 10))
        };
        [half(0), half(1)].map(|half| half.join().expect("it steps"))
    });
    let [mean, worst] = [0, 1].map(|k| halves[0][k].max(halves[1][k]));
    println!(
        "all 88 keys ring under the pedal, half of them on each of two cores: {:.0} % of real time; worst of {} blocks {:.0} %",
        100.0 * mean,
        BLOCKS / 10,
        100.0 * worst
    );
    let keys = Keys::at_rest(&instruments, Settings::new(STEP_S)).expect("they rest");
    let mut tremolo = Tremolo::new(keys, 10);
    let (mut worst, mut awake, seconds) = (0.0_f64, 0, 3);
    let started = Instant::now();
    // In blocks of a millisecond, which is what a buffer of sound allows.
    for _ in 0..seconds * 1000 {
        let block = Instant::now();
        for _ in 0..STEPS_PER_MS {
            awake = awake.max(tremolo.tick().stepped);
        }
        worst = worst.max(block.elapsed().as_secs_f64());
    }
    let load = started.elapsed().as_secs_f64() / f64::from(seconds);
    println!(
        "ten fingers, at most {awake} keys awake at once: {load:.2} s for a second; worst millisecond {:.2} ms",
        1e3 * worst
    );
}
