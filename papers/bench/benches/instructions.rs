//! Instructions per step of the played note that `press` times, and per step of a group of four grands in the lanes of
//! AVX2 (whatever more the processor has, so that the count is the same on all that have it). Counts repeat to the
//! digit, seconds do not. Beside them the step of [`erard::Action`] with everything read (rest-skipping off), and steps
//! of the same note on the grand with bending parts, of 6 to 9 bodies (`crates/erard-core/tests/bending/`), alone and
//! in four lanes; of the grand with dry felts, and with strings; and of the default instrument, alone and in lanes.
//!
//! `cargo bench -p erard-bench --bench instructions` runs itself under valgrind's callgrind, over a whole note and
//! over none of it; the difference is the steps'. It is a gate: `-- --at-most N` fails (exit code 1) above N
//! instructions per step, `--at-most-group M` above M per step of a group of four. Without valgrind it fails, too, so
//! that a gate is never open by accident; with `--if-available` it says that it counts nothing, and succeeds.

use std::hint::black_box;
use std::process::ExitCode;

use erard::{Action, Input, Instrument, Reading, StepOutcome};
use erard_bench::callgrind::{CountError, instructions, is_available};
use erard_bench::{Load, MAX_LANES, MF_N, STEP_S, STEPS, described, grand, group, instrument, note};
use moreau::{Settings, step};
use moreau_kernels::{Lanes, WorkspaceOfSix};

/// What is counted: its name on the command line, the option that bounds it, how often it is done for every step, and
/// what does so many steps.
type Subject = (&'static str, &'static str, u64, fn(u64));

const SUBJECTS: [Subject; 14] = [
    ("step", "--at-most", 1, |steps| {
        black_box(bare_note(steps));
    }),
    ("group_step", "--at-most-group", (MAX_LANES / 4) as u64, |steps| {
        black_box(Load::parameter_study(1, steps).in_lanes(1, Lanes::Four));
    }),
    ("action_step", "--at-most-action", 1, |steps| {
        black_box(action_note(&instrument(), steps));
    }),
    ("step_of_7_bodies", "--at-most-7", 1, |steps| {
        black_box(action_note(&bending(7), steps));
    }),
    ("step_of_8_bodies", "--at-most-8", 1, |steps| {
        black_box(action_note(&bending(8), steps));
    }),
    ("step_of_9_bodies", "--at-most-9", 1, |steps| {
        black_box(action_note(&bending(9), steps));
    }),
    ("action_step_with_elastoplastic_felts", "--at-most-elastoplastic", 1, |steps| {
        black_box(action_note(&with_dry_felts(0.2), steps));
    }),
    ("action_step_with_strings", "--at-most-strings", 1, |steps| {
        black_box(action_note(&Instrument::builtin("concert-grand-strings").expect("built in"), steps));
    }),
    ("group_step_of_6_bodies", "--at-most-group-6", 1, |steps| lanes_note(&instrument(), steps)),
    ("group_step_of_7_bodies", "--at-most-group-7", 1, |steps| lanes_note(&bending(7), steps)),
    ("group_step_of_8_bodies", "--at-most-group-8", 1, |steps| lanes_note(&bending(8), steps)),
    ("group_step_of_9_bodies", "--at-most-group-9", 1, |steps| lanes_note(&bending(9), steps)),
    ("action_step_of_the_concert_grand", "--at-most-grand", 1, |steps| {
        black_box(action_note(&concert_grand(), steps));
    }),
    ("group_step_of_the_concert_grand", "--at-most-group-grand", 1, |steps| lanes_note(&concert_grand(), steps)),
];

/// The default instrument: nine bodies, and felts whose laws have a memory.
fn concert_grand() -> Instrument {
    Instrument::builtin("concert-grand").expect("built in")
}

/// The concert grand with so many bodies, its felts without memory.
fn bending(bodies: usize) -> Instrument {
    let path = format!("{}/../../crates/erard-core/tests/bending/{bodies}-bodies.toml", env!("CARGO_MANIFEST_DIR"));
    Instrument::load(std::path::Path::new(&path)).expect("it reads")
}

/// The concert grand, all felts with a dry loss through a spring. (With a set-valued one some steps of a whole action
/// do not converge.)
fn with_dry_felts(slip: f64) -> Instrument {
    let mut instrument = instrument();
    instrument
        .edit(|fields| {
            for zone in &mut fields.zones {
                zone.felt.loss = moreau::Elastoplastic { damping: 0.0, eta: 0.3, slip }.into();
            }
        })
        .unwrap();
    instrument
}

/// The note by the step alone, compiled into this loop: this package is one unit, so that nothing but the step's own
/// text changes the count.
fn bare_note(steps: u64) -> f64 {
    let (model, mut state) = grand();
    let (settings, mut workspace) = (Settings::new(STEP_S), WorkspaceOfSix::new());
    for n in 0..steps {
        let report = step(&model, &settings, &note(n), &mut state, &mut workspace);
        assert_ne!(report.outcome, StepOutcome::NonFinite);
    }
    state.angle.iter().sum()
}

/// The note, stepped from outside: every field of every reading is read, impacts among them, and every step is taken.
fn action_note(instrument: &Instrument, steps: u64) -> f64 {
    let mut action = Action::new(instrument).expect("it comes to rest");
    action.set_sleep(false);
    let mut sum = 0.0;
    for n in 0..steps {
        let force_n = if n < STEPS / 2 { MF_N } else { 0.0 };
        let Reading {
            key_m,
            key_m_per_s,
            finger_force_n,
            hammer_rise_m,
            hammer_rise_m_per_s,
            string_n,
            impact,
            outcome,
            ..
        } = action.step(Input::Force(force_n));
        assert_eq!(outcome, StepOutcome::Converged);
        sum += key_m + key_m_per_s + finger_force_n + hammer_rise_m + hammer_rise_m_per_s + string_n;
        sum += impact.map_or(0.0, |impact| impact.time_s + impact.hammer_speed_m_per_s);
    }
    sum
}

/// The note on four alike, side by side.
fn lanes_note(instrument: &Instrument, steps: u64) {
    let rest = described(instrument).expect("it comes to rest");
    let mut group = group(&[&rest; 4], &Settings::new(STEP_S), Lanes::Four);
    assert_eq!(group.lanes(), Lanes::Four);
    let mut outcomes = [StepOutcome::Converged; 4];
    for n in 0..steps {
        group.step(&[note(n); 4], &mut outcomes);
    }
    black_box(outcomes);
}

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
        if name.starts_with("group_step") && !Lanes::Four.is_here() {
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
