//! Instructions per step of the played note that `press` times. Counts repeat to the digit, seconds do not.
//!
//! `cargo bench -p erard --bench instructions` runs itself under valgrind's callgrind, over a whole note and over none of it; the
//! difference is the steps'. `-- --at-most N` fails (exit code 1) above N instructions per step: the gate.

mod common;

use std::process::{Command, ExitCode, Stdio};

use common::{STEP_S, STEPS, grand, press};
use moreau::Settings;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let value = |name: &str| {
        let at = arguments.iter().position(|a| a == name)?;
        Some(
            arguments
                .get(at + 1)
                .and_then(|v| v.parse::<u64>().ok())
                .unwrap_or_else(|| panic!("{name} needs a number")),
        )
    };
    if let Some(steps) = value("--play") {
        std::hint::black_box(press(&grand(), &Settings::new(STEP_S), steps));
        return ExitCode::SUCCESS;
    }
    let per_step = (count(STEPS) - count(0)) / STEPS;
    println!("instructions_per_step {per_step}");
    match value("--at-most") {
        Some(most) if per_step > most => {
            eprintln!("error: {per_step} instructions per step, at most {most} allowed");
            ExitCode::FAILURE
        }
        _ => ExitCode::SUCCESS,
    }
}

/// Instructions of this program when it plays so many steps.
fn count(steps: u64) -> u64 {
    let output = Command::new("valgrind")
        .args(["--tool=callgrind", "--callgrind-out-file=/dev/null"])
        .arg(std::env::current_exe().expect("this program has a path"))
        .args(["--play", &steps.to_string()])
        .stdin(Stdio::null())
        .output()
        .unwrap_or_else(|e| panic!("valgrind cannot be started: {e}"));
    let text = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "valgrind failed:\n{text}");
    let collected = text.lines().find_map(|line| line.split_once("Collected : ")).map(|(_, n)| n.trim().parse());
    collected.and_then(Result::ok).unwrap_or_else(|| panic!("valgrind reported no count:\n{text}"))
}
