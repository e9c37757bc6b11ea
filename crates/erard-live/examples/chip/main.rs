//! Prints what firmware compiles in beside the grand (`.ci/regenerate firmware`): `keyboard.rs`, and with the argument
//! `scan` a scan of ten keys, `scan.bin`.

#[path = "../../tests/it/press.rs"]
mod press;
mod recorded;

use std::io::{Result, Write, stdout};

fn main() -> Result<()> {
    match std::env::args().nth(1).as_deref() {
        Some("scan") => stdout().write_all(&recorded::scan()),
        _ => stdout().write_all(recorded::keyboard().as_bytes()),
    }
}
