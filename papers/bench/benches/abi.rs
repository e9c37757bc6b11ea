//! The cost of the C interface beside the native call, and of denormal numbers: `cargo bench -p erard-bench --bench
//! abi`.
//!
//! Both play the same note, in turns, so that what else the machine does falls on both: means over whole rounds, the
//! least of them; then every step is timed by itself for the slowest. With `--at-most PERCENT` it fails where the
//! interface's mean is more above the native one's.
//!
//! `-- --instructions` counts instead of timing: instructions per step of both over the first 4000 steps of the note,
//! under valgrind's callgrind. Counts repeat to the digit whatever else the machine does; `--at-most` then bounds what
//! is counted.

#![allow(unsafe_code, reason = "a C interface is made of pointers")]

use std::hint::black_box;
use std::ptr::{null, null_mut};
use std::time::Instant;

use erard::{Input, Instrument};
use erard_bench::callgrind::instructions;
use erard_c::*;

const STEPS: usize = 20_000;
const ROUNDS: usize = 30;

fn force(n: usize) -> f64 {
    if n % 10_000 < 5_000 { 5.0 } else { 0.0 }
}

/// Means of rounds, us, the least; and all steps' times, us, ascending.
struct Timed {
    mean_us: f64,
    steps_us: Vec<f32>,
}

impl Timed {
    fn new() -> Self {
        Timed { mean_us: f64::INFINITY, steps_us: Vec::with_capacity(ROUNDS * STEPS) }
    }

    fn round(&mut self, mut step: impl FnMut(usize)) {
        let began = Instant::now();
        (0..STEPS).for_each(&mut step);
        self.mean_us = self.mean_us.min(began.elapsed().as_secs_f64() * 1e6 / STEPS as f64);
        for n in 0..STEPS {
            let began = Instant::now();
            step(n);
            self.steps_us.push(began.elapsed().as_secs_f32() * 1e6);
        }
    }

    fn say(&mut self, name: &str) {
        self.steps_us.sort_unstable_by(f32::total_cmp);
        let at = |share: f64| self.steps_us[((self.steps_us.len() - 1) as f64 * share) as usize];
        println!(
            "{name:<28} mean {:.4} us, timed one by one: median {:.2}, p99 {:.2}, p99.99 {:.2}, worst {:.1} us",
            self.mean_us,
            at(0.5),
            at(0.99),
            at(0.9999),
            at(1.0)
        );
    }
}

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    let at_most =
        arguments.iter().position(|a| a == "--at-most").map(|n| arguments[n + 1].parse::<f64>().expect("percent"));
    let after = |name: &str| arguments.iter().position(|a| a == name).map(|n| arguments[n + 1].as_str());
    if let Some(steps) = after("--steps") {
        return play(after("--count") == Some("native"), steps.parse().expect("steps"));
    }
    if arguments.iter().any(|a| a == "--instructions") {
        return count(at_most);
    }
    let mut native = erard::Action::new(&Instrument::builtin("concert-grand").expect("built in")).expect("it rests");
    let action = unsafe { erard_action_new(null(), 0, 50e-6, null_mut()) };
    let (mut through, mut directly) = (Timed::new(), Timed::new());
    let mut reading = ErardReading::default();
    for _ in 0..ROUNDS {
        directly.round(|n| {
            black_box(native.step(Input::Force(black_box(force(n)))));
            black_box(native.impact());
        });
        through.round(|n| {
            black_box(unsafe { erard_action_step_force(action, black_box(force(n)), &raw mut reading) });
        });
    }
    directly.say("native Action::step");
    through.say("erard_action_step_force");
    let more = 100.0 * (through.mean_us / directly.mean_us - 1.0);
    println!("the interface costs {more:+.1} % in the mean");

    let (mut bytes, mut size) = (vec![0_u8; 4096], 4096);
    let each = |work: &mut dyn FnMut()| {
        let began = Instant::now();
        (0..20_000).for_each(|_| work());
        began.elapsed().as_secs_f64() * 1e6 / 20_000.0
    };
    let saving = each(&mut || unsafe {
        size = 4096;
        assert_eq!(erard_action_save(action, bytes.as_mut_ptr(), &raw mut size), ErardStatus::Ok);
    });
    let restoring =
        each(&mut || unsafe { assert_eq!(erard_action_restore(action, bytes.as_ptr(), size), ErardStatus::Ok) });
    println!("erard_action_save {saving:.2} us, erard_action_restore {restoring:.2} us, {size} bytes");
    unsafe { erard_action_free(action) };
    denormals();
    if let Some(at_most) = at_most
        && more > at_most
    {
        eprintln!("error: the interface costs {more:.1} %; at most {at_most} %");
        std::process::exit(1);
    }
}

/// The note's first steps, natively or through the interface.
fn play(natively: bool, steps: usize) {
    let mut native = erard::Action::new(&Instrument::builtin("concert-grand").expect("built in")).expect("it rests");
    let action = unsafe { erard_action_new(null(), 0, 50e-6, null_mut()) };
    let mut reading = ErardReading::default();
    for n in 0..steps {
        if natively {
            black_box(native.step(Input::Force(black_box(force(n)))));
            black_box(native.impact());
        } else {
            black_box(unsafe { erard_action_step_force(action, black_box(force(n)), &raw mut reading) });
        }
    }
    unsafe { erard_action_free(action) };
}

/// Instructions per step of both.
fn count(at_most: Option<f64>) {
    const COUNTED: u64 = 4000;
    let counted = |who: &str| {
        let over = |steps: u64| instructions(&["--count", who, "--steps", &steps.to_string()]);
        match (over(0), over(COUNTED)) {
            (Ok(none), Ok(all)) => (all - none) as f64 / COUNTED as f64,
            (Err(error), _) | (_, Err(error)) => {
                eprintln!("error: {error}");
                std::process::exit(1);
            }
        }
    };
    let (native, through) = (counted("native"), counted("interface"));
    let more = 100.0 * (through / native - 1.0);
    println!("native Action::step  {native:.0} instructions a step");
    println!("erard_action_step_force     {through:.0} instructions a step");
    println!("the interface costs {more:+.1} % of instructions");
    if let Some(at_most) = at_most
        && more > at_most
    {
        eprintln!("error: the interface costs {more:.1} % of instructions; at most {at_most} %");
        std::process::exit(1);
    }
}

/// An action that dies away, with the processor's flush-to-zero mode off and on.
fn denormals() {
    let mut digests = Vec::new();
    for flush in [false, true] {
        let mut native =
            erard::Action::new(&Instrument::builtin("concert-grand").expect("built in")).expect("it rests");
        // Steps that change nothing are taken all the same: that is where small numbers would be.
        native.set_sleep(false);
        set_flush(flush);
        let (mut denormal, mut small, mut slow_us) = (0_u64, f64::INFINITY, 0.0_f64);
        for round in 0..20 {
            let began = Instant::now();
            for n in 0..STEPS {
                native.step(Input::Force(if n < 5_000 { 5.0 } else { 0.0 }));
                for v in native.velocities() {
                    denormal += u64::from(v.is_subnormal());
                    small = if *v == 0.0 { small } else { small.min(v.abs()) };
                }
            }
            if round > 0 {
                slow_us = slow_us.max(began.elapsed().as_secs_f64() * 1e6 / STEPS as f64);
            }
        }
        let digest = native.angles().iter().fold(0_u64, |d, a| d.rotate_left(7) ^ a.to_bits());
        set_flush(false);
        digests.push(digest);
        println!(
            "flush-to-zero {}: {denormal} denormal velocities in {} steps, the smallest {small:.0e} rad/s; slowest round {slow_us:.3} us a step",
            if flush { "on " } else { "off" },
            20 * STEPS
        );
    }
    println!("the end is {}", if digests[0] == digests[1] { "the same to the bit" } else { "another" });
}

/// Flush-to-zero and denormals-are-zero of this thread.
#[cfg(target_arch = "x86_64")]
fn set_flush(on: bool) {
    let control: u32 = if on { 0x1f80 | 0x8040 } else { 0x1f80 };
    // SAFETY: `control` is the usual word of MXCSR, with or without the two bits that flush; it holds for this thread
    // alone, and lives until the instruction has read it.
    unsafe { std::arch::asm!("ldmxcsr [{}]", in(reg) &raw const control, options(nostack)) };
}

#[cfg(not(target_arch = "x86_64"))]
fn set_flush(_on: bool) {}
