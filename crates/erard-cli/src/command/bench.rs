//! `erard bench`.

use clap::Args;
use erard::run::SimulationError;
use erard_workshop::benchmarks::{Effort, Report, measure};

use crate::answer;
use crate::failure::Failure;
use crate::progress::Progress;
use crate::say;
use crate::table::three;

/// What stands below the options.
const AFTER: &str = "\
All on the built-in concert grand with steps of 50 us. `step` is the engine alone over a played note, `press` what `erard press`
computes, `batch` a parameter study and a tremolo, grands side by side in the lanes of the processor's vectors and on all
its cores, `keyboard` a fortissimo tremolo over 88 keys on one core, `single steps` random playing with every step timed by itself, `kinematics` the geometry alone. Times are wall-clock
medians with the distance of the quartiles in percent: on a machine that does other work they are worth less, and the slowest
single steps are those that the operating system interrupts. Nothing is written.";

/// Measures how fast this machine simulates: a step, a press, many at once, a keyboard, the worst step, the kinematics.
#[derive(Debug, Args)]
#[command(after_help = AFTER)]
pub(crate) struct Bench {
    /// Take a second instead of half a minute: shows that everything works, and little more
    #[arg(long)]
    quick: bool,
}

impl Bench {
    /// Runs the command.
    pub(crate) fn run(&self) -> Result<(), Failure> {
        let mut progress = Progress::new("measuring");
        let effort = if self.quick { Effort::QUICK } else { Effort::USUAL };
        let report = measure(&effort, &mut |what, share| {
            progress.say(what);
            progress.tell(share)
        });
        drop(progress);
        let report = report.ok_or(SimulationError::Interrupted)?;
        answer::give(&report)?;
        if !say::wants_json() {
            print(&report);
        }
        Ok(())
    }
}

fn print(report: &Report) {
    let Report { instruction_sets, single, many, keyboard, latencies } = report;
    let row = |name: &str, value: f64, unit: &str, spread: f64, then: String| {
        say!("  {name:<34}{:>9} {unit:<4}{:>6} %   {then}", three(value), format!("+-{:.0}", 50.0 * spread));
    };
    let real_time = |factor: f64| format!("{} x real time", three(factor));
    say!("The concert grand on this machine: {} cores, {}", many.cores, instruction_sets.join(", "));
    say!();
    row("step", single.step_ns_median, "ns", single.step_ns_spread, real_time(single.real_time_factor));
    row("press", single.press_ms_median, "ms", single.press_ms_spread, real_time(single.press_real_time_factor));
    row("kinematics, a pose", single.kinematics_pose_ns_median, "ns", single.kinematics_pose_ns_spread, String::new());
    say!();
    let lanes = if many.lanes > 1 { format!("{} in lanes", many.lanes) } else { "without lanes".to_owned() };
    let speed = |factor: f64| format!("{factor:.2} x one after the other");
    row(
        "batch, one after the other",
        many.batch_one_by_one_ns_median,
        "ns",
        many.batch_one_by_one_ns_spread,
        String::new(),
    );
    row(
        &format!("batch, {lanes}"),
        many.batch_lanes_ns_median,
        "ns",
        many.batch_lanes_ns_spread,
        speed(many.batch_speedup_per_core),
    );
    row(
        &format!("batch, {lanes}, all cores"),
        many.batch_all_cores_ns_median,
        "ns",
        many.batch_all_cores_ns_spread,
        speed(many.batch_speedup_all_cores),
    );
    if let Some(factor) = many.batch_four_lanes_speedup_per_core.filter(|_| many.lanes > 4) {
        say!("  {:<58}{}", "batch, 4 in lanes", speed(factor));
    }
    if let (Some(lanes), Some(factor)) = (many.batch_single_lanes, many.batch_single_speedup_per_core) {
        say!("  {:<58}{}", format!("batch, {lanes} in lanes of single precision"), speed(factor));
    }
    say!("  {:<58}{}", format!("tremolo, {lanes}"), speed(many.batch_tremolo_speedup_per_core));
    say!("  {:<58}{}", format!("tremolo, {lanes}, all cores"), speed(many.batch_tremolo_speedup_all_cores));
    row("study, a stroke on all cores", many.study_stroke_ms_median, "ms", many.study_stroke_ms_spread, String::new());
    say!();
    say!("  {:<58}{}", "keyboard, ten-finger tremolo", real_time(keyboard.keyboard_real_time_factor));
    say!("  {:<58}{}", "keyboard, all 88 keys at once", real_time(keyboard.keyboard_all_keys_real_time_factor));
    say!(
        "  in the tremolo {:.1} keys are awake on average, {} at most; {} of {} ticks took longer than they simulate",
        keyboard.keyboard_awake_mean,
        keyboard.keyboard_awake_max,
        keyboard.keyboard_ticks_over_budget,
        keyboard.keyboard_ticks_timed
    );
    say!();
    say!("  {:<30}{:>11}{:>10}{:>10}{:>10}{:>11}", "single steps (ns)", "timed", "50 %", "99 %", "99.99 %", "slowest");
    for (name, timed, times) in [
        (
            "one grand",
            latencies.steps_timed,
            [latencies.step_ns_p50, latencies.step_ns_p99, latencies.step_ns_p9999, latencies.step_ns_max],
        ),
        (
            "as many as there are lanes",
            latencies.group_steps_timed,
            [
                latencies.group_step_ns_p50,
                latencies.group_step_ns_p99,
                latencies.group_step_ns_p9999,
                latencies.group_step_ns_max,
            ],
        ),
        (
            "a tick of the tremolo",
            keyboard.keyboard_ticks_timed,
            [
                keyboard.keyboard_tick_ns_p50,
                keyboard.keyboard_tick_ns_p99,
                keyboard.keyboard_tick_ns_p9999,
                keyboard.keyboard_tick_ns_max,
            ],
        ),
    ] {
        let [half, most, nearly, slowest] = times;
        say!("  {name:<30}{timed:>11}{half:>10}{most:>10}{nearly:>10}{slowest:>11}");
    }
    say!(
        "  at most {} Newton iterations and {} active sets a step; {} steps not converged; the clock itself takes {} ns",
        latencies.newton_iterations_max,
        latencies.active_sets_max,
        latencies.unconverged_steps,
        latencies.clock_ns
    );
}
