//! Instructions, counted by valgrind's callgrind: they repeat to the digit, seconds do not.
//!
//! A benchmark runs itself under callgrind twice, doing its work and doing none of it; the difference is the work's.

use std::process::{Command, Stdio};

/// Why nothing was counted.
#[derive(Debug, thiserror::Error)]
pub enum CountError {
    /// There is no valgrind.
    #[error("valgrind cannot be started: {0}")]
    NoValgrind(std::io::Error),
    /// It ended without a count.
    #[error("valgrind failed:\n{0}")]
    Failed(String),
}

/// Whether valgrind can be started.
///
/// # Errors
/// [`CountError::NoValgrind`].
pub fn is_available() -> Result<(), CountError> {
    let version = Command::new("valgrind").arg("--version").stdout(Stdio::null()).status();
    version.map(|_| ()).map_err(CountError::NoValgrind)
}

/// Instructions that this program takes with these arguments.
///
/// # Errors
/// See [`CountError`].
pub fn instructions(arguments: &[&str]) -> Result<u64, CountError> {
    let this = std::env::current_exe().map_err(CountError::NoValgrind)?;
    let output = Command::new("valgrind")
        .args(["--tool=callgrind", "--callgrind-out-file=/dev/null"])
        .arg(this)
        .args(arguments)
        .stdin(Stdio::null())
        .output()
        .map_err(CountError::NoValgrind)?;
    let text = String::from_utf8_lossy(&output.stderr);
    let collected = text.lines().find_map(|line| line.split_once("Collected : ")).map(|(_, n)| n.trim().parse());
    match collected {
        Some(Ok(count)) if output.status.success() => Ok(count),
        _ => Err(CountError::Failed(text.into_owned())),
    }
}
