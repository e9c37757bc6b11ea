//! The subcommands.

mod bands;
mod calibrate;
mod cases;
mod check;
mod check_recording;
mod check_sensors;
mod checked;
mod compare;
mod diagnose;
mod draw;
mod fit;
mod fmu;
mod hand;
mod help;
mod keyboard;
mod kinematics;
mod list;
#[cfg(feature = "listen")]
mod listen;
mod live;
mod manual;
mod measure;
pub mod options;
pub mod out;
mod play;
mod press;
mod press_pair;
mod regulate;
mod renamed;
mod scan;
mod sound;
mod studio;
mod study;
mod upgrade;
mod validate;
mod weigh;

use std::ffi::OsString;
use std::io::ErrorKind;
use std::process::ExitCode;

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use erard::files::steers;

use crate::answer::Answer;
use crate::excerpt::excerpt;
use crate::failure::Failure;
pub use crate::identity::version;
use crate::inputs::clipped;
use crate::printer::OutputMode;
use crate::session::Session;
use crate::signals;
use crate::suggest;
use crate::warn;

/// Simulates the grand piano action: from a key press to the hammer's impact on the string.
#[derive(Debug, Parser)]
#[command(name = "erard", version = version(), max_term_width = 100)]
pub(crate) struct Command {
    #[command(subcommand)]
    subcommand: Sub,
    #[command(flatten)]
    mode: OutputMode,
    /// Print all of the answer, not its first lines only
    #[arg(long, global = true)]
    full: bool,
}

#[derive(Debug, Subcommand)]
enum Sub {
    /// Plays one note: what the finger feels, how fast the hammer arrives, and when.
    Press(Box<press::Press>),
    /// Plays a MIDI file on 88 simulated actions: which notes are lost, and why.
    Play(play::Play),
    /// Turns a stream of sensed keys into MIDI, as simulated hammers would strike.
    Live(live::Live),
    /// Writes what sensors would read of known notes, to test your own algorithm.
    Scan(scan::Scan),
    /// Finds the stops of sensed keys: readings to millimetres, for `erard live`.
    Calibrate(calibrate::Calibrate),
    /// Draws the action in one pose, as SVG and PNG.
    Draw(Box<draw::Draw>),
    /// Plays a note on many variants of an instrument, or ranks its parameters.
    Study(Box<study::Study>),
    /// Weighs and measures an action as a technician does; what to turn (--sheet).
    Measure(measure::Measure),
    /// Ranks what may be wrong with a key of your piano, from what you measured.
    Diagnose(Box<diagnose::Diagnose>),
    /// Weighs the keys from bass to treble; balances the keys of a real piano.
    Keyboard(keyboard::Keyboard),
    /// Shows leverage and sliding over the key's travel, from the geometry alone.
    Kinematics(Box<kinematics::Kinematics>),
    /// Turns the screws of an instrument until it meets a specification.
    Regulate(Box<regulate::Regulate>),
    /// Compares an instrument with published measurements of real pianos.
    Validate(validate::Validate),
    /// Measures recordings of notes: decay, partials, inharmonicity, centroid.
    #[cfg(feature = "listen")]
    Listen(listen::Listen),
    /// Checks a file of any kind that Erard reads, and shows its contents.
    Check(check::Check),
    /// Compares a recording of a real key with the models.
    Compare(compare::Compare),
    /// Fits parameters of an instrument to recordings, with error bars.
    Fit(Box<fit::Fit>),
    /// Exports an instrument for simulators, as an FMI 2.0 unit for co-simulation.
    Fmu(fmu::Fmu),
    /// Opens the studio in the browser: press the key, turn the screws, compare.
    Studio(studio::Studio),
    /// Lists what is built in: instruments, keyboards, linkages, strokes.
    List(list::List),
    /// Prints a script that completes `erard` commands in a shell.
    Completions(manual::Completions),
    /// Prints a manual page, or writes the pages of all commands.
    Man(manual::Man),
}

/// Runs the command line of this process. Exit codes: 0 done, 2 wrong input or usage, 130 interrupted, 1 anything else
/// (goals of `regulate` that cannot be met and doubtful fits, among it).
pub fn run() -> ExitCode {
    let mode = |command: &Command| OutputMode { full: command.full, ..command.mode };
    run_program(&definition(), mode, |command, session| command.subcommand.run(session))
}

impl Sub {
    fn run(&self, session: &mut Session) -> Result<Answer, Failure> {
        match self {
            Sub::Press(press) => press.run(session),
            Sub::Play(play) => play.run(session),
            Sub::Live(live) => live.run(session),
            Sub::Scan(scan) => scan.run(session),
            Sub::Calibrate(calibrate) => calibrate.run(session),
            Sub::Draw(draw) => draw.run(session),
            Sub::Study(study) => study.run(session),
            Sub::Measure(measure) => measure.run(session),
            Sub::Diagnose(diagnose) => diagnose.run(session),
            Sub::Keyboard(keyboard) => keyboard.run(session),
            Sub::Kinematics(kinematics) => kinematics.run(session),
            Sub::Regulate(regulate) => regulate.run(session),
            Sub::Validate(validate) => validate.run(session),
            #[cfg(feature = "listen")]
            Sub::Listen(listen) => listen.run(session),
            Sub::Check(check) => check.run(session),
            Sub::Compare(compare) => compare.run(session),
            Sub::Fit(fit) => fit.run(session),
            Sub::Fmu(fmu) => fmu.run(session),
            Sub::Studio(studio) => studio.run(session),
            Sub::List(list) => list.run(session),
            Sub::Completions(completions) => completions.run(),
            Sub::Man(man) => man.run(session),
        }
    }
}

/// Runs a program that has this library's manners: arguments parsed by `definition`, requests to end heard, answers as
/// text or JSON, exit codes as [`run`] says. `mode` finds the shared options among the parsed ones; `work` does the
/// work.
pub fn run_program<P: FromArgMatches>(
    definition: &clap::Command,
    mode: impl Fn(&P) -> OutputMode,
    work: impl FnOnce(&P, &mut Session) -> Result<Answer, Failure>,
) -> ExitCode {
    let mut session = Session::new(OutputMode::default());
    signals::listen(session.stop.clone(), session.cleaner());
    let arguments = help::as_option(std::env::args_os().collect());
    let program = match definition.clone().try_get_matches_from(&arguments).and_then(|matches| {
        session.provenance.remember(&arguments, definition, &matches);
        P::from_arg_matches(&matches)
    }) {
        Ok(program) => program,
        Err(mut error) => {
            let subcommand = arguments.iter().skip(1).filter_map(|one| one.to_str()).find(|one| !one.starts_with('-'));
            suggest::complete(&mut error, definition);
            renamed::name_renamed(&mut error, subcommand);
            return usage(&mut session, &error, &arguments);
        }
    };
    session.printer.set_output_mode(mode(&program));
    let result = work(&program, &mut session);
    end(&mut session, result)
}

/// Prints the answer, or what went wrong. A failure is worth more than words that did not arrive.
fn end(session: &mut Session, result: Result<Answer, Failure>) -> ExitCode {
    let mut answer = match result {
        Ok(answer) => answer,
        Err(failure) => return report(session, &failure),
    };
    if session.printer.wants_bibtex() {
        let entry = session.provenance.bibtex();
        entry.lines().for_each(|line| session.printer.line(line.to_owned()));
        answer = match answer.with("bibtex", &entry) {
            Ok(answer) => answer,
            Err(failure) => return report(session, &failure),
        };
    }
    if session.printer.wants_json() {
        match serde_json::to_string_pretty(&answer.json()) {
            Ok(text) => print_json(session, &session.provenance.made_by().in_json(&text)),
            Err(error) => return report(session, &error.into()),
        }
    } else if let Some(text) = answer.verbatim() {
        session.printer.verbatim(text);
    }
    if let Some(message) = answer.shortfall() {
        session.stop.yield_to_the_end();
        warn!(session, "error: {}", clipped(message));
        return ExitCode::from(SHORT_OF);
    }
    match session.printer.finish() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => report(session, &Failure::Said(error)),
    }
}

/// Exit code where all was done and is not what was asked for.
const SHORT_OF: u8 = 1;

fn print_json(session: &mut Session, text: &str) {
    session.printer.verbatim(&format!("{}\n", text.trim_end()));
}

/// Prints a failure on stderr, with `--json` as the answer too; gives the exit code.
fn report(session: &mut Session, failure: &Failure) -> ExitCode {
    session.stop.yield_to_the_end();
    let (code, text) = (failure.exit_code(), failure.to_string());
    let message = clipped(&text);
    warn!(session, "error: {message}");
    if session.printer.wants_json() {
        print_error(session, &message, code);
    }
    if let Failure::Instrument(error) = failure
        && let Some(excerpt) = excerpt(error)
    {
        warn!(session, "{excerpt}");
    }
    ExitCode::from(code)
}

/// What went wrong, as the answer.
fn print_error(session: &mut Session, message: &str, exit_code: u8) {
    let error = serde_json::json!({ "error": { "message": message, "exit_code": exit_code } });
    print_json(session, &format!("{error:#}"));
}

/// The program's arguments, as they are read, printed by `--help` and `--help-all`, and listed in the book.
pub fn definition() -> clap::Command {
    help::arranged(out::with_default_folders(Command::command()))
}

/// Help, the version, or what is wrong with the arguments.
fn usage(session: &mut Session, error: &clap::Error, arguments: &[OsString]) -> ExitCode {
    let text = error.to_string();
    let code = u8::try_from(error.exit_code()).unwrap_or(2);
    let clip = clipped(&text);
    if error.use_stderr() && arguments.iter().take_while(|one| *one != "--").any(|one| one == "--json") {
        print_error(session, clip.trim_start_matches("error: ").trim_end(), code);
    }
    if error.use_stderr() && (text.contains(|c: char| steers(c)) || clip != text) {
        // In colours it would steer the terminal as the arguments will.
        warn!(session, "{}", clip.trim_end());
    } else if let Err(fault) = error.print()
        && !error.use_stderr()
        && fault.kind() != ErrorKind::BrokenPipe
    {
        return report(session, &Failure::Said(fault));
    }
    ExitCode::from(code)
}
