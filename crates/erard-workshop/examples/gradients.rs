//! Derivatives held against differences over wide windows: every built-in stroke, every parameter, several steps.
//!
//! `cargo run --release --workspace --example gradients -- [INSTRUMENT ..]` prints a line for each stroke and step, and
//! below it what is marked or disagrees.

use erard::stroke::{NUANCES, Stroke, Touch};
use erard::{Instrument, Settings, Setup};
use erard_workshop::cores;
use erard_workshop::sensitivities::{Mark, Method, Sensitivities, Sensitivity, Variable, quantities, sensitivities};

/// Steps of the press, s.
const STEPS_S: [f64; 2] = [50e-6, 25e-6];
/// The results that are held.
const OF: [&str; 4] = ["hammer_speed_m_per_s", "let_off_s", "hammer_contact_s", "key_bottom_after_blow_s"];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let asked: Vec<String> = std::env::args().skip(1).collect();
    let names = if asked.is_empty() { vec!["concert-grand".into(), "concert-grand-rigid".into()] } else { asked };
    println!(
        "{:22} {:14} {:>7} {:>6} {:>6} {:>6} {:>6} {:>9}",
        "", "stroke", "step", "rows", "agree", "local", "jumps", "median"
    );
    let mut total = [0; 3];
    for name in &names {
        let instrument = Instrument::builtin(name)?;
        for (nuance, touch) in NUANCES.into_iter().flat_map(|n| [(n, Touch::Pressed), (n, Touch::Struck)]) {
            let Some(stroke) = Stroke::curve(nuance, touch, None) else { continue };
            let (stroke, _) = stroke?;
            for step in STEPS_S {
                let setup = Setup {
                    settings: Settings::new(step),
                    start_s: stroke.start_s,
                    ledger: false,
                    ..Setup::new(stroke.duration_s)
                };
                let of = quantities().into_iter().filter(|q| OF.contains(&q.key)).collect();
                let finger = instrument.finger;
                let inputs = || stroke.inputs(&finger).unwrap_or_else(|_| Box::new(|_| erard::Input::Free));
                let by = Variable::all(&instrument);
                match sensitivities(&instrument, by, of, &inputs, &setup, cores::count(), &mut |_| true) {
                    Ok(all) => {
                        let counts = tell(name, &stroke.title, step, &all);
                        total = core::array::from_fn(|k| total[k] + counts[k]);
                    }
                    Err(error) => println!("{name:22} {:14} {:7.1} {error}", stroke.title, step * 1e6),
                }
            }
        }
    }
    let [agree, local, jumps] = total;
    let rows = agree + local + jumps;
    let share = 100.0 * f64::from(agree) / f64::from(rows.max(1));
    println!("{rows} rows: {agree} agree ({share:.1} %), {local} local, {jumps} jumps");
    Ok(())
}

/// Says it of one stroke; how many rows agree, are local, jump.
fn tell(name: &str, stroke: &str, step: f64, all: &Sensitivities) -> [u32; 3] {
    // What is too small to be seen by differences is not held against them.
    let matters = |row: &&Sensitivity| {
        all.of[row.of].method == Method::Gradient
            && row.effect(all).abs() > 2e-5 * all.values[row.of].unwrap_or(f64::INFINITY).abs()
    };
    let rows: Vec<&Sensitivity> = all.rows.iter().filter(matters).collect();
    let apart = |row: &Sensitivity| {
        row.differences.map_or(0.0, |[slope, _]| (slope - row.derivative).abs() / slope.abs().max(row.derivative.abs()))
    };
    let marked = |mark: Mark| rows.iter().filter(|row| row.mark == mark).count();
    let mut off: Vec<f64> = rows.iter().filter(|row| row.mark == Mark::None).map(|row| apart(row)).collect();
    off.sort_by(f64::total_cmp);
    let median = off.get(off.len() / 2).copied().unwrap_or(0.0);
    println!(
        "{name:22} {stroke:14} {:7.1} {:6} {:6} {:6} {:6} {median:9.1e}",
        step * 1e6,
        rows.len(),
        marked(Mark::None),
        marked(Mark::Local),
        marked(Mark::Jumps)
    );
    for row in rows.iter().filter(|row| row.mark != Mark::None) {
        let (of, by) = (&all.of[row.of], &all.by[row.by]);
        let [slope, error] = row.differences.unwrap_or([f64::NAN; 2]);
        println!(
            "    {:9} {:24} {:32} {:11.3e} +- {:8.1e}   differences {slope:11.3e} +- {error:8.1e} per {}",
            row.mark.name(),
            of.key,
            by.name,
            row.derivative,
            row.error,
            by.per
        );
    }
    [Mark::None, Mark::Local, Mark::Jumps].map(|mark| marked(mark) as u32)
}
