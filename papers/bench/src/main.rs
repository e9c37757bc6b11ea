//! The program `erard-bench`: speed of simulation on this machine. It uses the command's library and this package's
//! workloads.

#![deny(
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "`print_line!` and `warn!` neither panic nor let names steer a terminal"
)]

use std::process::ExitCode;

use clap::{CommandFactory, Parser};
use erard::run::SimulationError;
use erard_bench::{Effort, PARTS, measure};
use erard_cli::answer::Answer;
use erard_cli::command::{run_program, version};
use erard_cli::failure::Failure;
use erard_cli::print_line;
use erard_cli::printer::OutputMode;
use erard_cli::session::Session;
use erard_cli::table::{Table, three};
use serde_json::Value;

/// Text below the options.
const AFTER: &str = include_str!("help.txt");

/// Measures how fast this machine simulates: a step, a press, many at once, a keyboard, the worst step, the kinematics.
#[derive(Debug, Parser)]
#[command(name = "erard-bench", version = version(), about, after_help = AFTER, max_term_width = 100)]
struct Bench {
    /// Take one second instead of half a minute. The times are rough
    #[arg(long)]
    quick: bool,
    #[command(flatten)]
    mode: OutputMode,
}

/// Exit codes are those of `erard`.
fn main() -> ExitCode {
    run_program(&Bench::command(), |bench: &Bench| bench.mode, Bench::run)
}

impl Bench {
    fn run(&self, session: &mut Session) -> Result<Answer, Failure> {
        let mut progress = session.progress("measuring");
        let effort = if self.quick { Effort::QUICK } else { Effort::USUAL };
        let report = measure(&effort, &mut |share| {
            let (what, _) = PARTS.iter().find(|(_, end)| share < *end).unwrap_or(&PARTS[PARTS.len() - 1]);
            progress.say(what);
            progress.tell(share)
        });
        drop(progress);
        let report = report.ok_or(SimulationError::Interrupted)?;
        print(session, &report);
        Answer::of(&report)
    }
}

/// Prints medians and spreads of the times by name, with their speed relative to real time or to another row.
fn print(session: &mut Session, report: &Value) {
    let number = |key: &str| report[key].as_f64().unwrap_or(f64::NAN);
    let lanes = match number("lanes") {
        lanes if lanes > 1.0 => format!("{lanes} in lanes"),
        _ => "without lanes".to_owned(),
    };
    let real_time = |key: &str| format!("{} x real time", three(number(key)));
    let speed = |key: &str| format!("{:.2} x one after the other", number(key));
    let timed = |name: &str, stem: &str, then: String| {
        let unit = stem.rsplit('_').next().unwrap_or_default();
        let spread = format!("+-{:.0} %", 50.0 * number(&format!("{stem}_spread")));
        [name.to_owned(), three(number(&format!("{stem}_median"))), unit.to_owned(), spread, then]
    };
    let ratio = |name: String, then: String| [name, String::new(), String::new(), String::new(), then];
    let mut many = vec![
        timed("batch, one after the other", "batch_one_by_one_ns", String::new()),
        timed(&format!("batch, {lanes}"), "batch_lanes_ns", speed("batch_speedup_per_core")),
        timed(&format!("batch, {lanes}, all cores"), "batch_all_cores_ns", speed("batch_speedup_all_cores")),
    ];
    if number("lanes") > 4.0 && !report["batch_four_lanes_speedup_per_core"].is_null() {
        many.push(ratio("batch, 4 in lanes".to_owned(), speed("batch_four_lanes_speedup_per_core")));
    }
    if !report["batch_single_lanes"].is_null() {
        let name = format!("batch, {} in lanes of single precision", report["batch_single_lanes"]);
        many.push(ratio(name, speed("batch_single_speedup_per_core")));
    }
    many.push(ratio(format!("tremolo, {lanes}"), speed("batch_tremolo_speedup_per_core")));
    many.push(ratio(format!("tremolo, {lanes}, all cores"), speed("batch_tremolo_speedup_all_cores")));
    many.push(timed("study, a stroke on all cores", "study_stroke_ms", String::new()));
    let single = [
        timed("step", "step_ns", real_time("real_time_factor")),
        timed("press", "press_ms", real_time("press_real_time_factor")),
        timed("kinematics, a pose", "kinematics_pose_ns", String::new()),
    ];
    let bare = |key: &str| format!("{:.2} x its bare steps", number(key));
    let keyboard = [
        ratio("keyboard, ten-finger tremolo".to_owned(), real_time("keyboard_real_time_factor")),
        ratio("keyboard, all 88 keys at once".to_owned(), real_time("keyboard_all_keys_real_time_factor")),
        ratio("a recorded press, energy balance kept".to_owned(), bare("press_over_bare_steps")),
        ratio("a key awake, ten fingers".to_owned(), bare("keyboard_key_over_bare_step")),
        ratio("a key awake, all 88 keys".to_owned(), bare("keyboard_all_keys_over_bare_step")),
    ];
    let sets = report["instruction_sets"].as_array().into_iter().flatten().filter_map(Value::as_str);
    print_line!(
        session,
        "The concert grand on this machine: {} cores, {}",
        report["cores"],
        sets.collect::<Vec<_>>().join(", ")
    );
    print_line!(session);
    print_line!(session, "{}", Table::of([""; 5], single.into_iter().chain(many).chain(keyboard)));
    print_line!(
        session,
        "  in the tremolo {:.1} keys are awake on average, {} at most; {} of {} ticks took longer than they simulate",
        number("keyboard_awake_mean"),
        report["keyboard_awake_max"],
        report["keyboard_ticks_over_budget"],
        report["keyboard_ticks_timed"]
    );
    print_line!(session);
    let rows = [
        ("one grand", "steps_timed", "step_ns"),
        ("as many as there are lanes", "group_steps_timed", "group_step_ns"),
        ("a tick of the tremolo", "keyboard_ticks_timed", "keyboard_tick_ns"),
    ];
    let rows = rows.map(|(name, timed, stem)| {
        let times = ["p50", "p99", "p9999", "max"].map(|which| report[format!("{stem}_{which}")].to_string());
        [vec![name.to_owned(), report[timed].to_string()], times.to_vec()].concat()
    });
    print_line!(session, "{}", Table::of(["single steps (ns)", "timed", "50 %", "99 %", "99.99 %", "slowest"], rows));
    print_line!(
        session,
        "  at most {} Newton iterations and {} active sets a step; {} steps not converged; the clock itself takes {} ns",
        report["newton_iterations_max"],
        report["active_sets_max"],
        report["unconverged_steps"],
        report["clock_ns"]
    );
}
