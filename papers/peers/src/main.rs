//! The same piano action by a stiff solver: `stiff-peer MECHANISM.json samples|blow|limit|hold [--quick] [--method=NAME
//! --tolerance=NUMBER --width=NUMBER]`, one JSON object a line; with these options for one setting only.
//!
//! - `samples`: states along a blow and their accelerations, as references for other programs.
//! - `blow`: hammer speeds and seconds at several tolerances and widths of the regularised friction.
//! - `limit`: the hammer speed at a tight tolerance as the friction law becomes sharper.
//! - `hold`: a hammer held in check.

mod equations;
mod mechanism;
mod number;
mod run;

use std::process::ExitCode;

use equations::{Equations, Widths};
use mechanism::Mechanism;
use run::{Method, Run, Setup, run};
use serde_json::{Value, json};

/// Settings of the runs, and repetitions: the shortest time counts. Widths in rad/s at the pivots; at sliding contacts
/// a tenth of the number in m/s.
struct Plan {
    methods: &'static [Method],
    tolerances: &'static [f64],
    widths: &'static [f64],
    repetitions: usize,
}

const BLOW: Plan = Plan {
    methods: &[Method::Bdf, Method::TrBdf2, Method::Esdirk34],
    tolerances: &[1e-2, 1e-3, 3e-4, 1e-4, 3e-5, 1e-5, 1e-6, 1e-8],
    widths: &[0.3, 0.1, 0.03, 0.01, 3e-3, 1e-3, 1e-4],
    repetitions: 7,
};
const QUICK_BLOW: Plan = Plan {
    methods: &[Method::Bdf, Method::TrBdf2],
    tolerances: &[1e-3, 1e-4, 1e-5],
    widths: &[0.1, 0.01, 1e-3],
    repetitions: 3,
};
/// The sharpest width is the limit of double precision.
const LIMIT: Plan =
    Plan { methods: &[Method::Bdf], tolerances: &[1e-8], widths: &[1e-2, 1e-3, 1e-4, 1e-5], repetitions: 1 };
const HOLD: Plan = Plan {
    methods: &[Method::Bdf, Method::TrBdf2],
    tolerances: &[1e-4, 1e-6],
    widths: &[0.1, 0.01, 1e-3],
    repetitions: 1,
};
const QUICK_HOLD: Plan =
    Plan { methods: &[Method::Bdf], tolerances: &[1e-6], widths: &[0.1, 0.01, 1e-3], repetitions: 1 };

fn main() -> ExitCode {
    match command(std::env::args().skip(1).collect()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(2)
        }
    }
}

fn command(arguments: Vec<String>) -> Result<(), String> {
    let quick = arguments.iter().any(|a| a == "--quick");
    let option = |name: &str| arguments.iter().find_map(|a| a.strip_prefix(name)?.strip_prefix('='));
    let number = |name: &str| option(name).and_then(|text| text.parse().ok());
    let alone = match (option("--method"), number("--tolerance"), number("--width")) {
        (Some(name), Some(tolerance), Some(width)) => {
            let method = *BLOW.methods.iter().find(|method| method.name() == name).ok_or("no such method")?;
            Some(Setup { method, tolerance, widths: widths(width) })
        }
        _ => None,
    };
    let words: Vec<&str> = arguments.iter().map(String::as_str).filter(|a| !a.starts_with("--")).collect();
    let [path, command] = words[..] else {
        return Err("expected MECHANISM.json and one of samples, blow, limit, hold".into());
    };
    let mechanism = mechanism::read(path)?;
    match mechanism.bodies.len() {
        6 => play::<6, 12>(&mechanism, command, quick, alone),
        8 => play::<8, 16>(&mechanism, command, quick, alone),
        found => Err(format!("{path}: {found} bodies; this program is compiled for 6 and 8")),
    }
}

fn play<const B: usize, const S: usize>(
    mechanism: &Mechanism,
    command: &str,
    quick: bool,
    alone: Option<Setup>,
) -> Result<(), String> {
    match (command, alone) {
        ("blow", Some(setup)) => {
            blow::<B, S>(mechanism, "blow", &setup, BLOW.repetitions);
            return Ok(());
        }
        (_, Some(_)) => return Err("one setting is for `blow`".into()),
        _ => {}
    }
    match command {
        "samples" => println!("{}", samples::<B, S>(mechanism)?),
        "blow" => blows::<B, S>(mechanism, "blow", if quick { &QUICK_BLOW } else { &BLOW }),
        "limit" => blows::<B, S>(mechanism, "limit", &LIMIT),
        "hold" => holds::<B, S>(mechanism, if quick { &QUICK_HOLD } else { &HOLD }),
        other => return Err(format!("unknown command {other}; expected samples, blow, limit or hold")),
    }
    Ok(())
}

fn widths(pivot: f64) -> Widths {
    Widths { pivot, sliding: 0.1 * pivot }
}

impl Plan {
    fn each(&self, mut row: impl FnMut(&Setup)) {
        for &method in self.methods {
            for &width in self.widths {
                for &tolerance in self.tolerances {
                    eprintln!("diffsol: {}, width {width:e} rad/s, tolerance {tolerance:e}", method.name());
                    row(&Setup { method, tolerance, widths: widths(width) });
                }
            }
        }
    }
}

fn describe(task: &str, setup: &Setup) -> Value {
    json!({
        "task": task,
        "peer": "diffsol",
        "method": setup.method.name(),
        "tolerance": setup.tolerance,
        "width_rad_per_s": setup.widths.pivot,
    })
}

fn blows<const B: usize, const S: usize>(mechanism: &Mechanism, task: &str, plan: &Plan) {
    plan.each(|setup| blow::<B, S>(mechanism, task, setup, plan.repetitions));
}

fn blow<const B: usize, const S: usize>(mechanism: &Mechanism, task: &str, setup: &Setup, repetitions: usize) {
    let blow = &mechanism.blow;
    let mut row = describe(task, setup);
    let play = |&scale: &f64| {
        let mut runs = (0..repetitions)
            .map(|_| run::<B, S>(mechanism, setup, &|t| scale * blow.force(t), &[blow.until_s]))
            .collect::<Result<Vec<Run<S>>, String>>()?;
        runs.sort_by(|a, b| a.seconds.total_cmp(&b.seconds));
        let best = &runs[0];
        Ok(json!({
            "scale": scale,
            "speed_m_per_s": best.strike.map(|s| s[0]),
            "contact_s": best.strike.map(|s| s[1]),
            "seconds": best.seconds,
            "steps": best.steps,
        }))
    };
    match blow.scales.iter().map(play).collect::<Result<Vec<Value>, String>>() {
        Ok(played) => row["blows"] = played.into(),
        Err(error) => row["failed"] = error.into(),
    }
    println!("{row}");
}

fn holds<const B: usize, const S: usize>(mechanism: &Mechanism, plan: &Plan) {
    let hold = &mechanism.hold;
    plan.each(|setup| {
        let mut row = describe("hold", setup);
        match run::<B, S>(mechanism, setup, &|_| hold.force, &hold.instants()) {
            Ok(run) => {
                row["angles_rad"] = run.states.iter().map(|y| y[mechanism.strike.body]).collect();
                row["seconds"] = run.seconds.into();
                row["steps"] = run.steps.into();
            }
            Err(error) => row["failed"] = error.into(),
        }
        println!("{row}");
    });
}

/// Prints states for every millisecond of a blow.
fn samples<const B: usize, const S: usize>(mechanism: &Mechanism) -> Result<Value, String> {
    let setup = Setup { method: Method::Bdf, tolerance: 1e-6, widths: widths(0.1) };
    let instants: Vec<f64> = (1..=60).map(|k| mechanism.blow.until_s * f64::from(k) / 60.0).collect();
    let played = run::<B, S>(mechanism, &setup, &|t| mechanism.blow.force(t), &instants)?;
    let equations = Equations::<B, S>::new(mechanism, setup.widths);
    let sample = |(y, t): (&[f64; S], &f64)| {
        let rates = equations.rates(mechanism.blow.force(*t), y);
        json!({
            "time_s": t,
            "angles_rad": y[..B],
            "rates_rad_per_s": y[B..],
            "accelerations_rad_per_s2": rates[B..],
        })
    };
    let samples: Vec<Value> = played.states.iter().zip(&instants).map(sample).collect();
    Ok(json!({ "width_rad_per_s": setup.widths.pivot, "samples": samples }))
}
