//! Erard's side of the comparison in `peers/`: the mechanism as JSON for programs that are not this one, and the engine's own rows.
//!
//! `cargo run --release -p erard --example peers -- export|blow|batch|hold [--quick] [FILE.toml]`; the rigid concert grand unless a file is
//! named. `export` prints the mechanism (its format stands in `export.rs`), the others one JSON object a line and setting.

mod export;
mod play;
mod rows;

use std::path::Path;
use std::process::ExitCode;

use erard::instrument::Instrument;

use play::Action;

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
    let quick = arguments.iter().any(|a| a == "--quick");
    let mut words = arguments.iter().filter(|a| *a != "--quick");
    let command = words.next().ok_or("expected export, blow, batch or hold")?;
    let instrument = match words.next() {
        Some(file) => Instrument::load(Path::new(file))?,
        None => Instrument::builtin("concert-grand-rigid")?,
    };
    let action = Action::new(instrument)?;
    match command.as_str() {
        "export" => println!("{}", export::mechanism(&action)?),
        "blow" => rows::blows(&action, quick),
        "batch" => rows::batches(&action, quick),
        "hold" => rows::holds(&action, quick),
        other => return Err(format!("unknown command {other}; expected export, blow, batch or hold").into()),
    }
    Ok(())
}
