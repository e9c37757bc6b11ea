//! Writes synthetic recordings of a concert grand slightly different from the built-in one,
//! `recordings/heavier-<nuance>.csv`, into a folder: `.ci/regenerate recordings`.
//!
//! [`TRUE`] lists the differences. Sensors as in a laboratory, at 4 kHz: a load cell with 20 mN of noise, the key to 10
//! um, the hammer to 50 um, each with its own offset, after a rest of 0.1 s; they end 3 ms after the impact. Noise is
//! normal and white; all these sizes are estimates.

use std::fmt::Write as _;
use std::path::PathBuf;

use erard::instrument::Instrument;
use erard::parameter::Parameter;
use erard::run::{Setup, simulate};
use erard::stroke::{Stroke, Touch};

/// Differences from the file: factors, and a screw's turn in m.
pub const TRUE: [(&str, f64); 4] = [
    ("body.hammer.mass", 1.06),
    ("body.key_back.friction", 1.5),
    ("zone.capstan_heel.stiffness", 1.25),
    ("let_off", 3e-4),
];
/// The strokes.
pub const NUANCES: [&str; 2] = ["mf", "f"];
/// Noise and offset of force, key and hammer, N and m.
const SENSORS: [[f64; 2]; 3] = [[0.02, 0.11], [10e-6, -0.3e-3], [50e-6, 1e-3]];
const RATE_HZ: f64 = 4000.0;
const REST_S: f64 = 0.1;
/// Recorded time after the impact, s: later motion, check and rebound, reacts strongly to small changes.
const AFTER_THE_BLOW_S: f64 = 3e-3;

/// The recorded grand.
pub fn recorded() -> Instrument {
    let mut grand = Instrument::builtin("concert-grand").expect("it is built in");
    let all = Parameter::all(&grand);
    for (name, by) in TRUE {
        let (_, parameter) = all.iter().find(|(known, _)| known == name).expect("the grand has it");
        parameter.vary(&mut grand, by).unwrap_or_else(|error| panic!("{name}: {error}"));
    }
    grand
}

/// A normal number of variance 1: the sum of twelve uniform numbers of Knuth's linear congruential generator, which is
/// the same in every version of every library.
fn normal(state: &mut u64) -> f64 {
    let mut even = || {
        *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*state >> 11) as f64 / (1_u64 << 53) as f64
    };
    (0..12).map(|_| even()).sum::<f64>() - 6.0
}

/// Returns a recording as text, with noise from a seed.
pub fn recording(grand: &Instrument, nuance: &str, seed: u64) -> String {
    let (stroke, _) = Stroke::curve(nuance, Touch::Pressed, None).expect("it is built in").expect("it drives");
    let inputs = stroke.inputs(&grand.finger).expect("a force drives any key");
    let setup = Setup { record_every: Some(1), ..Setup::new(0.12) };
    let run = simulate(grand, inputs.as_ref(), &setup, &mut |_| true).expect("the grand plays");
    let end_s = run.events.hammer_contact_s().expect("the hammer reaches the string") + AFTER_THE_BLOW_S;
    let every = (1.0 / RATE_HZ / setup.settings.step).round() as usize;
    let rest = (REST_S * RATE_HZ) as usize;
    let mut state = seed;
    let mut text = String::from("time_s,force_N,key_m,hammer_head_m\n");
    for n in 0..rest + (end_s * RATE_HZ) as usize {
        let of = |column: &[f64]| n.checked_sub(rest).map_or(0.0, |row| column[row * every]);
        let [force, key, hammer] = [&run.force_n, &run.key_m, &run.hammer_rise_m].map(|column| of(column));
        let mut seen = |value: f64, [noise, offset]: [f64; 2]| value + offset + noise * normal(&mut state);
        let (force, key) = (seen(force, SENSORS[0]), seen(key, SENSORS[1]));
        let hammer = seen(hammer, SENSORS[2]);
        let _ = writeln!(text, "{:.5},{force:.4},{key:.7},{hammer:.6}", n as f64 / RATE_HZ);
    }
    text
}

fn main() -> std::io::Result<()> {
    let folder = PathBuf::from(std::env::args_os().nth(1).expect("a folder as argument"));
    std::fs::create_dir_all(&folder)?;
    let grand = recorded();
    for (seed, nuance) in NUANCES.into_iter().enumerate() {
        std::fs::write(folder.join(format!("heavier-{nuance}.csv")), recording(&grand, nuance, seed as u64 + 1))?;
    }
    Ok(())
}
