//! Options of a performance.

use erard_workshop::cores;

/// Options of a performance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// A row for every so many seconds in which a key is awake; rounded to steps.
    pub row_s: f64,
    /// Whether sound is handed over: all keys are stepped by a sample then.
    pub sound: bool,
    /// Of each key so many notes with faults, and so many without, are kept as [`crate::Moment`]s.
    pub moments: usize,
    /// On so many threads. The results do not depend on it.
    pub threads: usize,
}

impl Default for Options {
    fn default() -> Self {
        Options { row_s: 1e-3, sound: false, moments: 0, threads: cores::count() }
    }
}
