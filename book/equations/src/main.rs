//! The preprocessor that `book/book.toml` names: mdBook writes the book into its standard input, and reads it back with
//! the equations typeset.

use std::io::{Read, stdin};
use std::process::ExitCode;

fn main() -> ExitCode {
    // `supports RENDERER`: MathML is for browsers.
    if let [question, renderer] = &std::env::args().skip(1).collect::<Vec<_>>()[..] {
        return if question == "supports" && renderer == "html" { ExitCode::SUCCESS } else { ExitCode::FAILURE };
    }
    match book() {
        Ok(book) => {
            println!("{book}");
            ExitCode::SUCCESS
        }
        Err(reason) => {
            eprintln!("error: {reason}");
            ExitCode::FAILURE
        }
    }
}

/// The book, typeset, as JSON.
fn book() -> Result<String, String> {
    let mut text = String::new();
    stdin().read_to_string(&mut text).map_err(|error| error.to_string())?;
    let given: serde_json::Value = serde_json::from_str(&text).map_err(|error| error.to_string())?;
    let serde_json::Value::Array(given) = given else {
        return Err("expected what mdBook writes to a preprocessor: an array of context and book".into());
    };
    let [_, mut book] =
        <[_; 2]>::try_from(given).map_err(|given| format!("expected 2 values, found {}", given.len()))?;
    erard_equations::typeset_book(&mut book)?;
    Ok(book.to_string())
}
