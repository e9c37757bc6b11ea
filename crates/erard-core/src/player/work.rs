//! The work of steps: counts of steps and iterations.

use moreau::{ControlledStep, StepOutcome, StepReport};

/// Method and cost of a run.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Work {
    /// Steps taken; of adaptive steps, their halves.
    pub steps: u64,
    /// Steps that reached an iteration limit.
    pub unconverged_steps: u64,
    /// Newton iterations, all steps and all attempts.
    pub newton_iterations: u64,
    /// Sweeps or active sets likewise.
    pub solver_iterations: u64,
    /// Every how many steps of the settings a row was recorded.
    pub record_every: u64,
    /// Work of the step control; `None` with fixed steps.
    pub control: Option<ControlWork>,
}

/// Steps whose error was controlled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ControlWork {
    /// Adaptive steps taken, of two halves each.
    pub accepted: u64,
    /// Attempts rejected.
    pub rejected: u64,
    /// Inner steps of all attempts, three each.
    pub inner_steps: u64,
    /// Adaptive steps in which whole and halves were combined to a higher order.
    pub extrapolated: u64,
    /// Steps at the smallest length whose error is beyond the tolerance.
    pub beyond_tolerance: u64,
    /// Shortest controlled step, s; not where a row's instant cut it off.
    pub shortest_s: f64,
    /// Longest one, s.
    pub longest_s: f64,
}

impl Work {
    /// Adds the work of one call of the engine.
    pub(crate) fn count(&mut self, report: &StepReport, steps: u64) {
        self.unconverged_steps += u64::from(report.outcome == StepOutcome::IterationLimit);
        self.steps += steps;
        self.newton_iterations += u64::from(report.newton);
        self.solver_iterations += u64::from(report.solver);
    }
}

impl ControlWork {
    pub(crate) fn none() -> Self {
        ControlWork {
            accepted: 0,
            rejected: 0,
            inner_steps: 0,
            extrapolated: 0,
            beyond_tolerance: 0,
            shortest_s: f64::INFINITY,
            longest_s: 0.0,
        }
    }

    /// Counts a step; `cut`: it ended because a row was due.
    pub(crate) fn count(&mut self, step: &ControlledStep<f64>, cut: bool) {
        self.accepted += 1;
        self.rejected += u64::from(step.rejected);
        self.inner_steps += u64::from(step.inner);
        self.extrapolated += u64::from(step.extrapolated);
        self.beyond_tolerance += u64::from(step.error > 1.0);
        if !cut {
            self.shortest_s = self.shortest_s.min(step.step);
        }
        self.longest_s = self.longest_s.max(step.step);
    }
}
