//! Chooses the bounds of `erard_core::trust`: `cargo run --release -p erard-core --example trust`.
//!
//! Every built-in instrument, and the outer keys of the built-in keyboard, under every built-in stroke and steps of
//! force, with steps from 1 ms to 12.5 us and both ends of theta: the energy that the energy balance does not explain,
//! beside the error of the hammer's speed against a run with 1.5625 us. Then how deep felts are pressed and how far
//! bodies turn.

extern crate erard_core as erard;

#[path = "../tests/common/mod.rs"]
mod common;

use common::{Play, USUAL_STEP_S};
use erard_core::instrument::Instrument;
use erard_core::keyboard::Keyboard;
use erard_core::run::Run;
use erard_core::trust::energy_residual;
use moreau::Settings;

/// Long enough for the softest note and the way back, s.
const DURATION_S: f64 = 0.4;
const REFERENCE_S: f64 = 1.5625e-6;
const STEPS_S: [f64; 7] = [1e-3, 400e-6, 200e-6, 100e-6, USUAL_STEP_S, 25e-6, 12.5e-6];

/// A run at some step beside one at a far smaller one.
struct Beside {
    theta: f64,
    step_s: f64,
    residual: f64,
    /// Of the hammer's speed, relative; 1 where only one of the two strikes.
    error: f64,
    trusted: bool,
}

fn instruments() -> Vec<Instrument> {
    let keyboard = Keyboard::builtin("concert-grand").expect("built in");
    let keys = [1, 88].map(|key| keyboard.key(key).expect("a key"));
    Instrument::builtin_names().map(|name| Instrument::builtin(name).expect("built in")).chain(keys).collect()
}

fn plays() -> Vec<Play> {
    Play::strokes().chain(Play::force_steps()).collect()
}

fn go(instrument: &Instrument, play: &Play, theta: f64, step: f64) -> Run {
    play.run_every(instrument, Settings { theta, ..Settings::new(step) }, DURATION_S, Some(u64::MAX))
}

fn error(run: &Run, exact: &Run) -> f64 {
    match (run.events.hammer_speed_m_per_s(), exact.events.hammer_speed_m_per_s()) {
        (Some(speed), Some(exact)) => (speed / exact - 1.0).abs(),
        (None, None) => 0.0,
        _ => 1.0,
    }
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

fn energy(instruments: &[Instrument]) {
    let mut all = Vec::new();
    for instrument in instruments {
        for play in plays() {
            let exact = go(instrument, &play, 0.5, REFERENCE_S);
            for theta in [0.5, 1.0] {
                for step_s in STEPS_S {
                    let run = go(instrument, &play, theta, step_s);
                    let residual = run.ledger.as_ref().map_or(f64::NAN, energy_residual);
                    all.push(Beside { theta, step_s, residual, error: error(&run, &exact), trusted: run.is_trusted() });
                }
            }
        }
        eprintln!("{}", instrument.name);
    }
    println!(
        "theta   dt, us    residual: median   largest    error of the speed: median   largest    runs not trusted"
    );
    for theta in [0.5, 1.0] {
        for step_s in STEPS_S {
            let own: Vec<&Beside> = all.iter().filter(|b| b.theta == theta && b.step_s == step_s).collect();
            let of = |f: fn(&Beside) -> f64| own.iter().map(|b| f(b)).collect::<Vec<f64>>();
            let most = |values: Vec<f64>| values.into_iter().fold(0.0, f64::max);
            println!(
                "{theta:5.1} {:8.1}            {:8.1e}  {:8.1e}                      {:8.1e}  {:8.1e}    {} of {}",
                step_s * 1e6,
                median(of(|b| b.residual)),
                most(of(|b| b.residual)),
                median(of(|b| b.error)),
                most(of(|b| b.error)),
                own.iter().filter(|b| !b.trusted).count(),
                own.len()
            );
        }
    }
    println!();
    println!("residual from     to     runs    error of the speed: median   nine tenths below   largest");
    let edges = [0.0, 1e-5, 1e-4, 1e-3, 3e-3, 1e-2, 2e-2, 5e-2, 1e-1, 2e-1, 5e-1, f64::INFINITY];
    for edge in edges.windows(2) {
        let mut errors: Vec<f64> =
            all.iter().filter(|b| (edge[0]..edge[1]).contains(&b.residual)).map(|b| b.error).collect();
        errors.sort_by(f64::total_cmp);
        let at = |share: f64| errors.get((errors.len().saturating_sub(1) as f64 * share) as usize).copied();
        let shown = |value: Option<f64>| value.map_or("       -".to_owned(), |v| format!("{v:8.1e}"));
        println!(
            "      {:7.0e} {:7.0e}   {:6}                      {}            {}  {}",
            edge[0],
            edge[1],
            errors.len(),
            shown(at(0.5)),
            shown(at(0.9)),
            shown(at(1.0))
        );
    }
}

fn extremes(instruments: &[Instrument]) {
    println!();
    println!("Deepest compression of every felt, mm, and furthest turn of every body, degrees, at 50 us");
    for instrument in instruments {
        println!("{}", instrument.name);
        let runs: Vec<(Play, Run)> =
            plays().into_iter().map(|play| (play.clone(), go(instrument, &play, 0.5, USUAL_STEP_S))).collect();
        for (z, zone) in instrument.zones.iter().enumerate() {
            let deepest =
                runs.iter().max_by(|a, b| a.1.extremes.deepest[z].value.total_cmp(&b.1.extremes.deepest[z].value));
            if let Some((play, run)) = deepest {
                let thickness = zone.felt.thickness_m.map_or("-".to_owned(), |m| format!("{}", m * 1e3));
                println!("  {:20} {:7.2} of {thickness:4} {play:?}", zone.name, run.extremes.deepest[z].value * 1e3);
            }
        }
        for (b, body) in instrument.bodies.iter().enumerate() {
            let turned = |run: &Run, side: usize| run.extremes.turned[b][side].value.to_degrees();
            let lowest = runs.iter().map(|(_, run)| turned(run, 0)).fold(0.0, f64::min);
            let (play, highest) = runs
                .iter()
                .map(|(play, run)| (play, turned(run, 1)))
                .max_by(|a, b| a.1.total_cmp(&b.1))
                .expect("there are plays");
            let stops = body
                .turn_rad
                .map_or("-".to_owned(), |t| format!("{:?}", t.map(|x| (x.to_degrees() * 10.0).round() / 10.0)));
            println!("  {:20} {lowest:7.2} to {highest:7.2}   of {stops}   {play:?}", body.name);
        }
        if std::env::args().any(|a| a == "--each") {
            for (play, run) in &runs {
                let each = run
                    .extremes
                    .turned
                    .iter()
                    .map(|[low, high]| format!("{:.1}..{:.1}", low.value.to_degrees(), high.value.to_degrees()));
                println!("  {play:?} {}", each.collect::<Vec<_>>().join("  "));
            }
        }
        for (play, run) in &runs {
            for warning in &run.warnings {
                println!("  {play:?}: {warning}");
            }
        }
    }
}

fn main() {
    let instruments = instruments();
    if !std::env::args().any(|a| a == "--extremes") {
        energy(&instruments);
    }
    extremes(&instruments);
}
