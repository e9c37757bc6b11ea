//! Simulation of a mechanism of rigid bodies.

use crate::{Contact, Model, Placement, Settings, State, StepOutcome, StepReport, Surface, Twist, Workspace, step};
use moreau::GROUND;

/// A mechanism with its state and its time.
pub struct Run<'m, const B: usize, const N: usize> {
    /// Model of the mechanism.
    pub model: Model<'m, f64>,
    /// Settings of the steps.
    pub settings: Settings<f64>,
    /// Present state.
    pub state: State<f64, B, N>,
    workspace: Workspace<f64, B, N>,
    steps: u32,
    /// Whether all steps so far converged.
    pub sound: bool,
}

impl<'m, const B: usize, const N: usize> Run<'m, B, N> {
    /// Returns a run of a mechanism with given placements and velocities and the step h (s).
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
        self.sound &= report.outcome == StepOutcome::Converged;
        self.steps += 1;
        report
    }

    /// Advances until an instant, s, or until a step fails.
    pub fn until(&mut self, time: f64) {
        let last = (time / self.settings.step).round() as u32;
        while self.steps < last && self.sound {
            self.step();
        }
    }

    /// Returns a result of this run, or NaN if a step failed.
    pub fn value(&self, x: f64) -> f64 {
        if self.sound { x } else { f64::NAN }
    }
}

/// A smooth point at the centre of the first body, which meets a surface of the ground.
pub(crate) fn point_on(surface: Surface<f64>, restitution: f64) -> Contact<f64> {
    Contact {
        disc_body: 0,
        center: [0.0, 0.0],
        radius: 0.0,
        surface_body: GROUND,
        surface,
        restitution,
        kinetic: 0.0,
        limit: 0.0,
        belt: 0.0,
    }
}

/// Returns a placement; x and y in m, angle in rad.
pub fn at(x: f64, y: f64, angle: f64) -> Placement<f64> {
    Placement { at: [x, y], angle }
}
