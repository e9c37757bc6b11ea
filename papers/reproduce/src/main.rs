//! The program `erard-reproduce`.

use std::process::ExitCode;

fn main() -> ExitCode {
    erard_reproduce::command::run()
}
