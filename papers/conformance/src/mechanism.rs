//! Runs of a tree of hinged bodies.

use moreau::{Body, Model, Settings, SiteInput, State, StepOutcome, Workspace, step};

/// A model with its state and settings.
pub(crate) struct Mechanism<const B: usize, const Z: usize, const N: usize> {
    pub model: Model<f64, B, Z>,
    pub state: State<f64, B, Z>,
    pub settings: Settings<f64>,
    pub workspace: Workspace<f64, B, Z, N>,
    pub time: f64,
    /// Whether no step has failed so far.
    pub sound: bool,
}

impl<const B: usize, const Z: usize, const N: usize> Mechanism<B, Z, N> {
    pub(crate) fn new(model: Model<f64, B, Z>, angle: [f64; B], velocity: [f64; B], settings: Settings<f64>) -> Self {
        let mut state = State::at_rest(angle);
        state.velocity = velocity;
        Mechanism { model, state, settings, workspace: Workspace::new(), time: 0.0, sound: true }
    }

    pub(crate) fn step(&mut self) {
        let report = step(&self.model, &self.settings, &SiteInput::Free, &mut self.state, &mut self.workspace);
        self.sound &= report.outcome == StepOutcome::Converged;
        self.time += self.settings.step;
    }

    pub(crate) fn run(&mut self, duration: f64) {
        for _ in 0..(duration / self.settings.step).round() as usize {
            self.step();
        }
    }

    /// Returns a number of this run, or NaN if a step failed.
    pub(crate) fn value(&self, x: f64) -> f64 {
        if self.sound { x } else { f64::NAN }
    }
}

/// A hinge on the ground at the origin, with inertia only.
pub(crate) fn hinge(inertia: f64) -> Body<f64> {
    Body { inertia, ..Body::inert() }
}
