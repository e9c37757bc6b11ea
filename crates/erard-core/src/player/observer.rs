//! Observers of the steps of a run.

use crate::mechanism::Mechanism;

/// A further observer of a run.
pub trait Observer {
    /// The start of the run: the mechanism does not move, and this instant is its first row.
    fn begin(&mut self, time_s: f64, mechanism: &dyn Mechanism);
    /// After every step, which ends at `time_s`; `row`: this instant is a row of the run.
    fn step(&mut self, time_s: f64, row: bool, mechanism: &dyn Mechanism);
}
