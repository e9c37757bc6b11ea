//! A mechanism with its state, for the tests.

use moreau::{Body, Input, Model, Outcome, Scratch, Settings, State, step};

/// A model, where it is, and how it is stepped.
pub struct Mechanism<const B: usize, const Z: usize, const N: usize> {
    pub model: Model<f64, B, Z>,
    pub state: State<f64, B, Z>,
    pub settings: Settings<f64>,
    pub scratch: Scratch<f64, B, Z, N>,
    pub time: f64,
}

impl<const B: usize, const Z: usize, const N: usize> Mechanism<B, Z, N> {
    pub fn new(model: Model<f64, B, Z>, angle: [f64; B], velocity: [f64; B], settings: Settings<f64>) -> Self {
        let mut state = State::at_rest(angle);
        state.velocity = velocity;
        Mechanism { model, state, settings, scratch: Scratch::new(), time: 0.0 }
    }

    /// One step, which must converge.
    pub fn step(&mut self) {
        let report = step(&self.model, &self.settings, &Input::Free, &mut self.state, &mut self.scratch);
        assert_eq!(report.outcome, Outcome::Converged, "at t = {} s: {report:?}", self.time);
        self.time += self.settings.step;
    }

    pub fn run(&mut self, duration: f64) {
        for _ in 0..(duration / self.settings.step).round() as usize {
            self.step();
        }
    }
}

/// A hinge on the ground at the origin with nothing but inertia.
pub fn hinge(inertia: f64) -> Body<f64> {
    Body { inertia, ..Body::inert() }
}

/// Observed order of convergence from errors at steps h, h/2, h/4, ...: the mean slope in log2.
pub fn order(errors: &[f64]) -> f64 {
    let n = errors.len() - 1;
    (errors[0] / errors[n]).log2() / n as f64
}
