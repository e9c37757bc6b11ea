//! The concert grand under steps of constant force: `cargo run --release -p erard-core --example force_steps`.

extern crate erard_core as erard;

#[path = "../tests/common/mod.rs"]
mod common;

use common::{Play, USUAL_STEP_S, grand};
use moreau::Settings;

fn main() {
    let grand = grand();
    println!(
        "force   start to bottom   hammer before bottom   speed   let-off before string   check after   impacts   energy"
    );
    println!(
        "    N                ms                     ms     m/s                      ms            ms           residual"
    );
    for force in [0.8, 2.0, 5.0, 8.0, 20.0, 35.0] {
        let run = Play::ForceStep(force, 0.5).run(&grand, Settings::new(USUAL_STEP_S), 1.2);
        let e = &run.events;
        let ms = |from: Option<f64>, to: Option<f64>| match (from, to) {
            (Some(from), Some(to)) => format!("{:.2}", (to - from) * 1e3),
            _ => "-".into(),
        };
        println!(
            "{force:5}   {:>15}   {:>20}   {:5.3}   {:>21}   {:>11}   {:5}   {:8.1e}",
            ms(e.key_start_s, e.key_bottom_s),
            ms(e.hammer_contact_s(), e.key_bottom_s),
            e.hammer_speed_m_per_s().unwrap_or(0.0),
            ms(e.let_off_s, e.hammer_contact_s()),
            ms(e.hammer_contact_s(), e.check_s),
            e.impacts.len(),
            run.ledger.as_ref().expect("kept").residual_relative()
        );
    }
}
