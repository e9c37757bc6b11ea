//! The subcommands.

mod bands;
mod calibrate;
mod check;
mod check_recording;
mod compare;
mod diagnose;
mod draw;
mod fit;
mod fmu;
mod hand;
mod keyboard;
mod kinematics;
mod list;
mod live;
mod manual;
mod measure;
pub mod options;
pub mod out;
mod play;
mod press;
mod press_pair;
mod regulate;
mod samples;
mod scan;
mod studio;
mod study;
mod validate;
mod weigh;

use std::ffi::OsString;
use std::io::ErrorKind;
use std::process::ExitCode;

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use erard::files::steers;

use crate::failure::Failure;
use crate::inputs::clipped;
use crate::live as wire;
use crate::{answer, identity, output, progress, say, signals};

/// Simulates the grand piano action: from a key press to the hammer's impact on the string.
#[derive(Debug, Parser)]
#[command(name = "erard", version = version(), max_term_width = 100)]
pub(crate) struct Command {
    #[command(subcommand)]
    subcommand: Sub,
    #[command(flatten)]
    speech: Speech,
}

/// How a program of this library speaks.
#[derive(Debug, clap::Args)]
pub struct Speech {
    /// Print errors and warnings only; files are written as usual
    #[arg(long, global = true)]
    quiet: bool,
    /// Print the answer as JSON on standard output
    #[arg(long, global = true)]
    json: bool,
}

/// The version, with the commit where it is known.
pub fn version() -> String {
    let commit = identity::COMMIT.map_or(String::new(), |commit| format!(" ({commit})"));
    format!("{}{commit}", env!("CARGO_PKG_VERSION"))
}

#[derive(Debug, Subcommand)]
enum Sub {
    /// Simulates one key press and shows what happened.
    Press(Box<press::Press>),
    /// Plays a MIDI file on the simulated keys of a keyboard, and says which notes are lost and why.
    Play(play::Play),
    /// Plays a stream of sensed keys, and sends MIDI as the hammers meet the strings.
    Live(live::Live),
    /// Writes what sensors under the keys read while a piece or misleading motions are played, and the true strikes.
    Scan(scan::Scan),
    /// Finds the stops of sensed keys: readings to millimetres, for `erard live`.
    Calibrate(calibrate::Calibrate),
    /// Draws the action in one pose, as SVG and PNG.
    Draw(Box<draw::Draw>),
    /// Plays a stroke on many variants of an instrument: a parameter study.
    Study(Box<study::Study>),
    /// Measures an action as a technician does: weights, ratios, regulation, inertia, timing, repetition.
    Measure(measure::Measure),
    /// Ranks what may be wrong with a key of your own piano, from whatever was measured of it.
    Diagnose(Box<diagnose::Diagnose>),
    /// Weighs the keys of a keyboard from bass to treble, or prints one key's instrument file.
    Keyboard(keyboard::Keyboard),
    /// Shows leverage and sliding over the key's travel, from the geometry alone.
    Kinematics(Box<kinematics::Kinematics>),
    /// Turns the screws of an instrument until it meets a specification, and writes a new file.
    Regulate(Box<regulate::Regulate>),
    /// Compares an instrument with published measurements of real pianos.
    Validate(validate::Validate),
    /// Checks a file of any kind that Erard reads, and shows its contents.
    Check(check::Check),
    /// Compares a recording with the models.
    Compare(compare::Compare),
    /// Fits parameters of an instrument to recordings, with error bars.
    Fit(Box<fit::Fit>),
    /// Exports an instrument for simulators, as an FMI 2.0 unit for co-simulation.
    Fmu(fmu::Fmu),
    /// Opens the studio in the browser: press the key, turn the screws, compare two actions.
    Studio(studio::Studio),
    /// Lists the built-in instruments, keyboards, linkages and strokes, or prints one.
    List(list::List),
    /// Prints a script that completes `erard` commands in a shell.
    Completions(manual::Completions),
    /// Prints a manual page, or writes the pages of all commands.
    Man(manual::Man),
}

/// Runs the command line of this process. Exit codes: 0 done, 2 wrong input or usage, 130 interrupted, 1 anything else
/// (goals of `regulate` that cannot be met and doubtful fits, among it).
pub fn run() -> ExitCode {
    run_program(&definition(), |command: &Command| &command.speech, |command| command.subcommand.run())
}

impl Sub {
    fn run(&self) -> Result<(), Failure> {
        match self {
            Sub::Press(press) => press.run(),
            Sub::Play(play) => play.run(),
            Sub::Live(live) => live.run(),
            Sub::Scan(scan) => scan.run(),
            Sub::Calibrate(calibrate) => calibrate.run(),
            Sub::Draw(draw) => draw.run(),
            Sub::Study(study) => study.run(),
            Sub::Measure(measure) => measure.run(),
            Sub::Diagnose(diagnose) => diagnose.run(),
            Sub::Keyboard(keyboard) => keyboard.run(),
            Sub::Kinematics(kinematics) => kinematics.run(),
            Sub::Regulate(regulate) => regulate.run(),
            Sub::Validate(validate) => validate.run(),
            Sub::Check(check) => check.run(),
            Sub::Compare(compare) => compare.run(),
            Sub::Fit(fit) => fit.run(),
            Sub::Fmu(fmu) => fmu.run(),
            Sub::Studio(studio) => studio.run(),
            Sub::List(list) => list.run(),
            Sub::Completions(completions) => completions.run(),
            Sub::Man(man) => man.run(),
        }
    }
}

/// Runs a program that has this library's manners: arguments parsed by `definition`, requests to end heard, answers as
/// text or JSON, exit codes as [`run`] says. `speech` finds the shared options among the parsed ones; `work` does the
/// work.
pub fn run_program<P: FromArgMatches>(
    definition: &clap::Command,
    speech: impl Fn(&P) -> &Speech,
    work: impl FnOnce(&P) -> Result<(), Failure>,
) -> ExitCode {
    signals::listen(&[progress::clear, wire::silence, output::clear_stages]);
    let arguments: Vec<OsString> = std::env::args_os().collect();
    let program = match definition.clone().try_get_matches_from(&arguments).and_then(|matches| {
        identity::remember(&arguments, definition, &matches);
        P::from_arg_matches(&matches)
    }) {
        Ok(program) => program,
        Err(error) => return usage(&error, &arguments),
    };
    say::how(speech(&program).quiet, speech(&program).json);
    let result = work(&program);
    if result.as_ref().err().is_none_or(Failure::has_answered) {
        answer::print();
    }
    // A failure is worth more than words that did not arrive.
    match result.and_then(|()| say::finish().map_err(Failure::Said)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.report(),
    }
}

/// The program's arguments, as they are read, told by `--help`, and listed in the book.
pub fn definition() -> clap::Command {
    out::with_default_folders(Command::command())
}

/// Help, the version, or what is wrong with the arguments.
fn usage(error: &clap::Error, arguments: &[OsString]) -> ExitCode {
    let text = error.to_string();
    let code = u8::try_from(error.exit_code()).unwrap_or(2);
    let clip = clipped(&text);
    if error.use_stderr() && arguments.iter().take_while(|one| *one != "--").any(|one| one == "--json") {
        answer::print_error(clip.trim_start_matches("error: ").trim_end(), code);
    }
    if error.use_stderr() && (text.contains(|c: char| steers(c)) || clip != text) {
        // In colours it would steer the terminal as the arguments will.
        say::aside(clip.trim_end().to_owned());
    } else if let Err(fault) = error.print()
        && !error.use_stderr()
        && fault.kind() != ErrorKind::BrokenPipe
    {
        return Failure::Said(fault).report();
    }
    ExitCode::from(code)
}
