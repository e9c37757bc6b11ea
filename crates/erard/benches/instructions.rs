//! Instructions per step of the played note that `press` times, and per step of a group of four grands in the lanes of AVX2
//! (whatever more the processor has, so that the count is the same on all that have it). Counts repeat
//! to the digit, seconds do not.
//!
//! `cargo bench -p erard --bench instructions` runs itself under valgrind's callgrind, over a whole note and over none of it; the
//! difference is the steps'. It is a gate: `-- --at-most N` fails (exit code 1) above N instructions per step, `--at-most-group M`
//! above M per step of a group of four. Without valgrind it fails, too, so that a gate is never open by accident; with
//! `--if-available` it says that it counts nothing, and succeeds.

use std::hint::black_box;
use std::process::ExitCode;

use erard_lab::benchmarks::callgrind::{CountError, instructions, is_available};
use erard_lab::benchmarks::{Load, STEP_S, STEPS, WIDEST, grand, press};
use moreau::Settings;
use moreau_lanes::Lanes;

/// What is counted: its name on the command line, the option that bounds it, how often it is done for every step, and what does so many
/// steps.
type Subject = (&'static str, &'static str, u64, fn(u64));

const SUBJECTS: [Subject; 2] = [
    ("step", "--at-most", 1, |steps| {
        black_box(press(&grand(), &Settings::new(STEP_S), steps));
    }),
    ("group_step", "--at-most-group", (WIDEST / 4) as u64, |steps| {
        black_box(Load::parameter_study(1, steps).in_lanes(1, Lanes::Four));
    }),
];

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let after = |name: &str| arguments.iter().position(|a| a == name).map(|at| arguments.get(at + 1));
    let number = |name: &str| {
        let text = after(name)?;
        Some(text.and_then(|v| v.parse::<u64>().ok()).unwrap_or_else(|| panic!("{name} needs a number")))
    };
    if let Some(steps) = number("--steps") {
        let subject = after("--count").flatten().and_then(|name| SUBJECTS.iter().find(|(n, ..)| n == name));
        let (.., go) = subject.expect("--steps N needs --count step or group_step");
        go(steps);
        return ExitCode::SUCCESS;
    }
    if let Err(error) = is_available() {
        if arguments.iter().any(|a| a == "--if-available") {
            println!("skipped, nothing is counted: {error}");
            return ExitCode::SUCCESS;
        }
        eprintln!("error: {error}; install it, or say --if-available to go on without the count");
        return ExitCode::FAILURE;
    }
    let mut passed = true;
    for (name, option, times, _) in SUBJECTS {
        if name == "group_step" && !Lanes::Four.is_here() {
            println!("skipped, this processor has no AVX2: instructions_per_group_step");
            continue;
        }
        let per_step = match per_step(name, times) {
            Ok(per_step) => per_step,
            Err(error) => {
                eprintln!("error: {error}");
                return ExitCode::FAILURE;
            }
        };
        println!("instructions_per_{name} {per_step}");
        if let Some(most) = number(option).filter(|most| per_step > *most) {
            eprintln!("error: {per_step} instructions per {name}, at most {most} allowed");
            passed = false;
        }
    }
    if passed { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// Instructions of one step of a subject that every step does so many times.
fn per_step(subject: &str, times: u64) -> Result<u64, CountError> {
    let count = |steps: u64| instructions(&["--count", subject, "--steps", &steps.to_string()]);
    Ok((count(STEPS)? - count(0)?) / (STEPS * times))
}
