//! Running a mechanism of rigid bodies.

use crate::{Model, Outcome, Placement, Settings, State, StepReport, Twist, Workspace, step};

/// A mechanism with its state and time.
pub struct Run<'m, const B: usize, const N: usize> {
    /// The mechanism.
    pub model: Model<'m, f64>,
    /// How it is stepped.
    pub settings: Settings<f64>,
    /// Present state.
    pub state: State<f64, B, N>,
    workspace: Workspace<f64, B, N>,
    steps: u32,
    /// No step has failed so far.
    pub sound: bool,
}

impl<'m, const B: usize, const N: usize> Run<'m, B, N> {
    /// A mechanism whose bodies are placed and move so, stepped by h (s).
    pub fn new(model: Model<'m, f64>, h: f64, bodies: &[(Placement<f64>, Twist<f64>)]) -> Self {
        Run {
            model,
            settings: Settings::new(h),
            state: State::new(bodies),
            workspace: Workspace::new(),
            steps: 0,
            sound: true,
        }
    }

    /// s.
    pub(crate) fn time(&self) -> f64 {
        f64::from(self.steps) * self.settings.step
    }

    /// One step.
    pub(crate) fn step(&mut self) -> StepReport<f64> {
        let report = step(&self.model, &self.settings, &[], &mut self.state, &mut self.workspace);
        self.sound &= report.outcome == Outcome::Converged;
        self.steps += 1;
        report
    }

    /// Steps until an instant, s, or until a step fails.
    pub fn until(&mut self, time: f64) {
        let last = (time / self.settings.step).round() as u32;
        while self.steps < last && self.sound {
            self.step();
        }
    }

    /// A number of this run, or not a number if a step failed.
    pub fn value(&self, x: f64) -> f64 {
        if self.sound { x } else { f64::NAN }
    }
}

/// A placement.
pub fn at(x: f64, y: f64, angle: f64) -> Placement<f64> {
    Placement { at: [x, y], angle }
}
