//! Words for people: results on standard output, what goes wrong on standard error.
//!
//! Names and paths come from files and strangers. What could steer a terminal is shown by its code instead.

use std::io::{self, ErrorKind, Write};
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::sync::{Mutex, PoisonError};

use erard::files::printable;

/// Whether words on standard output are left out.
static QUIET: AtomicBool = AtomicBool::new(false);
/// Whether the answer is wanted as JSON, in place of words.
static JSON: AtomicBool = AtomicBool::new(false);

/// The first thing that went wrong on standard output.
static FAULT: Mutex<Option<io::Error>> = Mutex::new(None);

/// Prints a line on standard output.
#[macro_export]
macro_rules! say {
    () => { $crate::say::line(String::new()) };
    ($($text:tt)*) => { $crate::say::line(format!($($text)*)) };
}

/// Prints a line on standard error.
#[macro_export]
macro_rules! tell {
    ($($text:tt)*) => { $crate::say::aside(format!($($text)*)) };
}

/// How this process tells its results: in words, as JSON, or not at all.
pub(crate) fn how(quiet: bool, json: bool) {
    QUIET.store(quiet, Relaxed);
    JSON.store(json, Relaxed);
}

/// Whether progress and words are left out.
pub(crate) fn is_quiet() -> bool {
    QUIET.load(Relaxed)
}

/// Whether the answer is wanted as JSON.
pub(crate) fn wants_json() -> bool {
    JSON.load(Relaxed)
}

/// Writes a line to standard output. `finish` reports what went wrong.
pub fn line(text: String) {
    if is_quiet() || wants_json() {
        return;
    }
    keep(writeln!(io::stdout(), "{}", printable(&text)));
}

/// Bytes on standard output as they are: a file, not words.
pub fn verbatim(text: &str) {
    keep(io::stdout().write_all(text.as_bytes()));
}

/// A line on standard error. Where even that cannot be written, nobody is left to tell.
pub fn aside(text: String) {
    let _ = writeln!(io::stderr(), "{}", printable(&text));
}

/// Keeps the first fault. A reader that has gone away, as in `erard check FILE | head -1`, has read enough: that is
/// none.
fn keep(result: io::Result<()>) {
    if let Err(error) = result
        && error.kind() != ErrorKind::BrokenPipe
    {
        FAULT.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
    }
}

/// Whether all that was said has arrived.
///
/// # Errors
/// The first fault of standard output.
pub(crate) fn finish() -> io::Result<()> {
    keep(io::stdout().flush());
    match FAULT.lock().unwrap_or_else(PoisonError::into_inner).take() {
        Some(source) => Err(source),
        None => Ok(()),
    }
}
