//! Observers of the steps of a run.

use crate::mechanism::Mechanism;

/// A further observer of a run.
pub trait Observer {
    /// Where the run begins: the mechanism stands still, and this instant is its first row.
    fn begin(&mut self, time_s: f64, mechanism: &dyn Mechanism);
    /// After every step, which ends at `time_s`; `row`: this instant is a row of the run.
    fn step(&mut self, time_s: f64, row: bool, mechanism: &dyn Mechanism);
}
