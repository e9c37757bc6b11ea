//! Options of a performance.

use erard::knocks::Knock;
use erard::run::Heard;
use erard_workshop::cores;

/// Options of a performance.
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// Interval of the rows while a key is awake, s; rounded to steps.
    pub row_s: f64,
    /// What sound is handed over, if any; all keys are then stepped by a sample.
    pub sound: Option<Heard>,
    /// What knocks in it.
    pub knocks: Vec<Knock>,
    /// Number of notes with faults, and of notes without, that are kept for each key as [`crate::Moment`]s.
    pub moments: usize,
    /// Number of threads. The results do not depend on it.
    pub threads: usize,
}

impl Default for Options {
    fn default() -> Self {
        Options { row_s: 1e-3, sound: None, knocks: Knock::ALL.to_vec(), moments: 0, threads: cores::count() }
    }
}
