//! The command `erard`.

use std::process::ExitCode;

fn main() -> ExitCode {
    erard_cli::command::run()
}
