//! Writes the built-in strokes, `strokes/<nuance>-<touch>.csv`: `cargo run --release -p erard --example strokes`.
//!
//! The forces are formulas (below); the positions are what the concert grand's key front does under them. A struck stroke is
//! scaled so that its hammer speed equals the pressed one's, so that the two touches can be compared at equal loudness.

use std::f64::consts::PI;
use std::fmt::Write as _;
use std::path::Path;

use erard::instrument::Instrument;
use erard::player;
use erard::run::Run;
use erard::simulation::{Setup, simulate};
use moreau::Settings;

/// Name, force that is reached (N), time in which it is reached when pressed (s), duration of the blow when struck (s).
const NUANCES: [(&str, f64, f64, f64); 5] = [
    ("pp", 0.9, 0.060, 0.030),
    ("p", 2.0, 0.045, 0.024),
    ("mf", 4.5, 0.030, 0.018),
    ("f", 9.0, 0.020, 0.014),
    ("ff", 20.0, 0.014, 0.010),
];
/// The key is let go at this instant, s, within [`RELEASE_S`]; the stroke ends at [`END_S`].
const LET_GO_S: f64 = 0.5;
/// What stays on a struck key after the blow, N, at least: enough to hold it down.
const WEIGHT_N: f64 = 0.65;
const RELEASE_S: f64 = 0.030;
const END_S: f64 = 0.8;

fn ramp(x: f64) -> f64 {
    0.5 - 0.5 * (PI * x.clamp(0.0, 1.0)).cos()
}

fn let_go(t: f64) -> f64 {
    1.0 - ramp((t - LET_GO_S) / RELEASE_S)
}

/// Rises smoothly to `level` and stays.
fn pressed(t: f64, level: f64, rise: f64) -> f64 {
    level * ramp(t / rise) * let_go(t)
}

/// A blow of the falling finger, then the finger's weight.
fn struck(t: f64, level: f64, blow: f64, scale: f64) -> f64 {
    let pulse = if t < blow { scale * (PI * t / blow).sin().powi(2) } else { 0.0 };
    (pulse + (0.35 * level).max(WEIGHT_N) * ramp((t - 0.5 * blow) / blow)) * let_go(t)
}

fn run(grand: &Instrument, force: &dyn Fn(f64) -> f64) -> Run {
    let setup = Setup {
        settings: Settings::new(10e-6),
        start_s: 0.0,
        duration_s: END_S,
        record_every: Some(50),
        tolerance: None,
        ledger: true,
    };
    simulate(grand, &player::force(force), &setup, &mut |_| true).expect("the concert grand runs")
}

/// The force that gives the blow the wanted hammer speed, by bisection.
fn scale_for(grand: &Instrument, speed: f64, level: f64, blow: f64) -> f64 {
    // Far harder blows throw the key through before the hammer has followed, and loudness falls again.
    let (mut low, mut high) = (0.0, 8.0 * level);
    for _ in 0..25 {
        let middle = 0.5 * (low + high);
        let reached = run(grand, &|t| struck(t, level, blow, middle)).events.hammer_speed_m_s.unwrap_or(0.0);
        if reached < speed { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// Half a millisecond while it moves, more sparsely while it is held: unevenly sampled, as files may be.
fn kept(t: f64) -> bool {
    let ms = (t * 2e3).round() as u64;
    ms <= 400 || (1000..1200).contains(&ms) || ms.is_multiple_of(10)
}

fn write(folder: &Path, name: &str, run: &Run, force: &dyn Fn(f64) -> f64) {
    let mut text = String::from("time_s,force_N,position_m\n");
    for (t, y) in run.time_s.iter().zip(&run.key_m).filter(|(t, _)| kept(**t)) {
        writeln!(text, "{t:.4},{:.4},{:.7}", force(*t), y).expect("a string takes any text");
    }
    std::fs::write(folder.join(format!("{name}.csv")), text).expect("the folder `strokes` can be written");
    let e = &run.events;
    println!(
        "{name:12} peak {:6.2} N  hammer {:.3} m/s at {:6.2} ms  key bottom {:6.2} ms",
        run.peak_force_n,
        e.hammer_speed_m_s.unwrap_or(0.0),
        e.hammer_contact_s.unwrap_or(0.0) * 1e3,
        e.key_bottom_s.unwrap_or(0.0) * 1e3
    );
}

fn main() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("strokes");
    let grand = Instrument::builtin("concert-grand").expect("built in");
    for (name, level, rise, blow) in NUANCES {
        let force = |t| pressed(t, level, rise);
        let reference = run(&grand, &force);
        write(&folder, &format!("{name}-pressed"), &reference, &force);
        let speed = reference.events.hammer_speed_m_s.unwrap_or(0.0);
        let scale = scale_for(&grand, speed, level, blow);
        let force = |t| struck(t, level, blow, scale);
        write(&folder, &format!("{name}-struck"), &run(&grand, &force), &force);
    }
}
