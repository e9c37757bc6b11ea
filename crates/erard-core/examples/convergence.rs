//! How hammer speed and contact instant approach a run with a 64 times smaller step, and what the Newton tolerance
//! costs: `cargo run --release -p erard-core --example convergence`.

extern crate erard_core as erard;

#[path = "../tests/common/mod.rs"]
mod common;

use common::ladder::{NEIGHBOURS, halvings, impact, ladder};
use common::{Play, grand};
use erard_core::instrument::Instrument;
use erard_core::stroke::Touch;
use moreau::Settings;

/// What is played, and when it has struck, s.
fn cases() -> Vec<(&'static str, Play, f64)> {
    vec![
        ("mf, pressed", Play::Stroke("mf", Touch::Pressed), 0.06),
        ("0.8 N", Play::ForceStep(0.8, 1.0), 0.14),
        ("2 N", Play::ForceStep(2.0, 1.0), 0.07),
        ("5 N", Play::ForceStep(5.0, 1.0), 0.04),
        ("8 N", Play::ForceStep(8.0, 1.0), 0.03),
        ("20 N", Play::ForceStep(20.0, 1.0), 0.02),
        ("35 N", Play::ForceStep(35.0, 1.0), 0.015),
        ("ff, struck", Play::Stroke("ff", Touch::Struck), 0.02),
    ]
}

fn steps(grand: &Instrument) {
    println!(
        "Errors against a step of 3.125/64 us. rms: over {NEIGHBOURS} steps from h down to 7/64 less, whose phases differ."
    );
    println!("ratio: of the rms to that of half the step; 2 is order one, 4 is order two.");
    for (name, play, until) in cases() {
        for theta in [0.5, 1.0] {
            println!();
            println!("{name}, theta {theta}");
            println!(
                "   dt, us   speed, m/s   error      rms        ratio   contact, us   rms       ratio   newton/step"
            );
            let rungs = ladder(grand, &play, theta, &halvings(200e-6, 7), 64.0, until);
            for (i, r) in rungs.iter().enumerate() {
                let ratio = |f: fn(&common::ladder::Rung) -> f64| {
                    rungs.get(i + 1).map_or("     ".into(), |next| format!("{:5.2}", f(r) / f(next)))
                };
                println!(
                    "{:9.3}   {:.6}     {:+.1e}   {:.1e}   {}   {:+11.4}   {:8.4}   {}   {:.3}",
                    r.step * 1e6,
                    r.impact.speed,
                    r.speed_error,
                    r.speed_rms,
                    ratio(|r| r.speed_rms),
                    r.contact_error * 1e6,
                    r.contact_rms * 1e6,
                    ratio(|r| r.contact_rms),
                    r.impact.newton
                );
            }
        }
    }
}

fn tolerances(grand: &Instrument) {
    println!();
    println!("What the Newton tolerance adds, at theta 0.5, against a tolerance of 1e-12 at the same step");
    println!(
        "case            dt, us   tolerance   speed, relative   contact, us   energy residual   newton/step   solver/step"
    );
    for (name, play, until) in cases() {
        for step in [50e-6, 12.5e-6] {
            let with = |tolerance| Settings { tolerance, ..Settings::new(step) };
            let best = impact(grand, &play, with(1e-12), until);
            for tolerance in [1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-9] {
                let run = play.run_every(grand, with(tolerance), until, Some(u64::MAX));
                let b = impact(grand, &play, with(tolerance), until);
                println!(
                    "{name:14} {:7.1}     {tolerance:7.0e}           {:7.1e}       {:7.1e}           {:7.1e}         {:.3}         {:.3}",
                    step * 1e6,
                    (b.speed / best.speed - 1.0).abs(),
                    (b.contact - best.contact).abs() * 1e6,
                    run.ledger.as_ref().expect("kept").residual_relative(),
                    b.newton,
                    run.work.solver_iterations as f64 / run.work.steps as f64
                );
            }
        }
    }
}

fn main() {
    let grand = grand();
    steps(&grand);
    tolerances(&grand);
}
