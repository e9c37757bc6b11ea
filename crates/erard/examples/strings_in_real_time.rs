//! What strings cost: a step of the action while its three strings ring and while they are struck, and ten fingers'
//! fortissimo tremolo over a keyboard with strings.
//!
//! `cargo run --release -p erard --example strings_in_real_time`

use std::hint::black_box;
use std::time::Instant;

use erard::keyboard::{Keyboard, Keys, tremolo::Tremolo};
use erard::{Action, Input, Instrument, Settings};

const STEP_S: f64 = 50e-6;
const STEPS: u32 = 20_000;

/// Seconds for a step of a mezzo forte held, every step taken; best of five.
fn step_s(instrument: &Instrument) -> f64 {
    let mut best = f64::INFINITY;
    for _ in 0..5 {
        let mut action = Action::new(instrument).expect("it comes to rest");
        action.let_rest(false);
        let started = Instant::now();
        for _ in 0..STEPS {
            black_box(action.step(Input::Force(4.5)));
        }
        best = best.min(started.elapsed().as_secs_f64() / f64::from(STEPS));
    }
    best
}

/// The same while the strings ring and the action sleeps, in seconds a step; in the first second after the blow, and
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
                0 => keys.drive(key, Input::Force(9.0)),
                222 => keys.drive(key, Input::Free),
                _ => {}
            }
        }
        let block = Instant::now();
        for _ in 0..20 {
            black_box(keys.step());
        }
        worst = worst.max(block.elapsed().as_secs_f64());
    }
    [started.elapsed().as_secs_f64() / seconds as f64, worst]
}

fn main() {
    let strung = Instrument::builtin("concert-grand-strings").expect("built in");
    let (rigid, yielding) = (step_s(&strung.with_rigid_string()), step_s(&strung));
    println!("step, rigid string             {:.3} us", 1e6 * rigid);
    println!("step, one trichord that sounds {:.3} us, {:.2} times as long", 1e6 * yielding, yielding / rigid);
    let [fresh, late] = ringing_s(&strung);
    println!("strings alone, 1 s after a blow {:.3} us, 30 s after it {:.3} us", 1e6 * fresh, 1e6 * late);
    let keyboard = Keyboard::builtin("concert-grand-strings").expect("built in");
    let [load, worst] = ten_notes(&keyboard);
    println!(
        "ten fingers that stay on their keys and repeat them, thirty strings: {load:.2} s for a second; worst millisecond {:.2} ms",
        1e3 * worst
    );
    let keys = Keys::at_rest(&keyboard.instruments().expect("it reads"), Settings::new(STEP_S)).expect("they rest");
    let mut tremolo = Tremolo::new(keys, 10);
    let (mut worst, mut awake, seconds) = (0.0_f64, 0, 3);
    let started = Instant::now();
    // In blocks of a millisecond, which is what a buffer of sound allows.
    for _ in 0..seconds * 1000 {
        let block = Instant::now();
        for _ in 0..20 {
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
