//! Erard's side of the comparison in `papers/peers/`: the mechanism as JSON for programs that are not this one, and the
//! engine's own rows.
//!
//! `cargo run --release -p erard-core --example peers -- export|blow|batch|hold|steps [--quick] [--step=S] [--loose]
//! [NAME or FILE.toml]`; the rigid concert grand unless another instrument is named. `export` prints the mechanism (its
//! format stands in `export.rs`), `steps` a table of where long steps lose accuracy and time, the others one JSON
//! object a line and setting. `--step` leaves `blow` and `batch` that step alone, without the reference; `--loose` with
//! Newton's loosened tolerance.

mod export;
mod play;
mod rows;
mod steps;

use std::path::Path;
use std::process::ExitCode;

use erard_core::assembly;
use erard_core::instrument::Instrument;
use moreau_kernels::Size;

use play::{Action, Steps};
use rows::Chosen;

fn main() -> ExitCode {
    match run(std::env::args().skip(1).collect()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(2)
        }
    }
}

fn run(arguments: Vec<String>) -> Result<(), Box<dyn std::error::Error>> {
    let has = |option: &str| arguments.iter().any(|a| a == option);
    let step = arguments.iter().find_map(|a| a.strip_prefix("--step="));
    let chosen = match step.map(str::parse).transpose()? {
        Some(step) => Chosen::One(if has("--loose") { Steps::Loose(step) } else { Steps::Fixed(step) }),
        None if has("--quick") => Chosen::Quick,
        None => Chosen::All,
    };
    let mut words = arguments.iter().filter(|a| !a.starts_with("--"));
    let command = words.next().ok_or("expected export, blow, batch, hold or steps")?;
    let instrument = match words.next() {
        Some(name) if Path::new(name).extension().is_none() => Instrument::builtin(name)?,
        Some(file) => Instrument::load(Path::new(file))?,
        None => Instrument::builtin("concert-grand-rigid")?,
    };
    match Size::of(&assembly::describe::<f64>(&instrument)) {
        Size::Six => play::<6, 14, 10>(instrument, command, chosen),
        Size::Eight => play::<8, 20, 49>(instrument, command, chosen),
        size => {
            let [bodies, zones, _] = size.holds();
            let found = format!("the engine's size of {bodies} bodies and {zones} zones");
            Err(format!("{}: {found}; expected six bodies or eight, as in the built-in grands", instrument.name).into())
        }
    }
}

/// In the engine of this size.
fn play<const B: usize, const Z: usize, const N: usize>(
    instrument: Instrument,
    command: &str,
    chosen: Chosen,
) -> Result<(), Box<dyn std::error::Error>> {
    let action = Action::<B, Z, N>::new(instrument)?;
    match command {
        "export" => println!("{}", export::mechanism(&action)?),
        "blow" => rows::blows(&action, chosen),
        "batch" => rows::batches(&action, chosen),
        "hold" => rows::holds(&action, chosen == Chosen::Quick),
        "steps" => steps::where_errors_arise(&action),
        other => return Err(format!("unknown command {other}; expected export, blow, batch, hold or steps").into()),
    }
    Ok(())
}
