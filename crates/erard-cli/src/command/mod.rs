//! The subcommands.

mod bench;
mod check;
mod compare;
mod draw;
mod keyboard;
mod kinematics;
mod measure;
mod options;
mod press;
mod regulate;
mod reproduce;
mod study;
mod validate;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

use crate::progress::listen_for_interrupts;

/// Simulates the grand piano action: a key press goes in, and out comes everything the mechanism does.
#[derive(Debug, Parser)]
#[command(name = "erard", version, about, max_term_width = 100)]
pub struct Command {
    #[command(subcommand)]
    subcommand: Sub,
}

#[derive(Debug, Subcommand)]
enum Sub {
    /// Simulates one key press and shows what happened.
    Press(Box<press::Press>),
    /// Draws the action in one pose, as SVG and PNG.
    Draw(Box<draw::Draw>),
    /// Shows leverage and sliding over the key's travel, from the geometry alone.
    Kinematics(Box<kinematics::Kinematics>),
    /// Plays a stroke on many variants of an instrument: a parameter study.
    Study(Box<study::Study>),
    /// Measures an action as a technician does: weights, ratios, regulation, inertia, timing, repetition.
    Measure(measure::Measure),
    /// Weighs the keys of a keyboard from bass to treble, or writes one key's instrument.
    Keyboard(keyboard::Keyboard),
    /// Turns an instrument's screws until its action meets a specification; writes a new instrument file.
    Regulate(Box<regulate::Regulate>),
    /// Holds an instrument against what has been measured on real pianos.
    Validate(validate::Validate),
    /// Checks an instrument or keyboard (TOML) or stroke (CSV) file and says what it holds.
    Check(check::Check),
    /// Holds a measured stroke against the models
    Compare(compare::Compare),
    /// Computes the papers' figures and claims anew and shows which hold.
    Reproduce(reproduce::Reproduce),
    /// Measures how fast this machine simulates.
    Bench(bench::Bench),
}

/// Runs the command line of this process. Exit codes: 0 done, 2 wrong input or usage, 130 interrupted, 1 anything else
/// (goals of `regulate` that cannot be met, among it).
pub fn run() -> ExitCode {
    let command = Command::parse();
    listen_for_interrupts();
    let result = match command.subcommand {
        Sub::Press(press) => press.run(),
        Sub::Draw(draw) => draw.run(),
        Sub::Kinematics(kinematics) => kinematics.run(),
        Sub::Study(study) => study.run(),
        Sub::Measure(measure) => measure.run(),
        Sub::Keyboard(keyboard) => keyboard.run(),
        Sub::Regulate(regulate) => regulate.run(),
        Sub::Validate(validate) => validate.run(),
        Sub::Check(check) => check.run(),
        Sub::Compare(compare) => compare.run(),
        Sub::Reproduce(reproduce) => reproduce.run(),
        Sub::Bench(bench) => bench.run(),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.report(),
    }
}
