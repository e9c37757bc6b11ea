//! Jobs of a study: a stroke on an instrument, and what came of it.

use erard::player::Input;
use erard::run::{Events, SimulationError};
use erard::trust::Warning;

/// Drive of the key in a job: like [`erard::Drive`], but owned, so that another thread can take it.
pub type Stroke<'a> = Box<dyn Fn(f64) -> Input + Send + 'a>;

/// Stroke on an instrument.
pub struct Job<'a> {
    /// Index of the instrument.
    pub instrument: usize,
    /// The stroke.
    pub stroke: Stroke<'a>,
}

/// Result of a job.
#[derive(Debug, Clone, PartialEq)]
pub struct Played {
    /// Instants and speeds.
    pub events: Events,
    /// Greatest rise of the hammer's strike point from rest, m; 0 without a hammer.
    pub highest_m: f64,
    /// Steps that reached an iteration limit.
    pub unconverged_steps: u64,
    /// Error of the energy balance, as a share of the energy turned over ([`erard::trust`]); `None` without the setup's
    /// ledger.
    pub energy_residual: Option<f64>,
    /// Reasons why the stroke cannot be trusted; without the setup's ledger neither energy nor felts are judged.
    pub warnings: Vec<Warning>,
    /// Samples, column by column; empty without sampling, or if the run ended early.
    pub samples: Vec<Vec<f64>>,
}

/// Result of a job; a failed job does not stop the others.
pub type JobResult = Result<Played, SimulationError>;
