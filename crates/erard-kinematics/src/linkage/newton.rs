//! Newton-Raphson on the closure equations, without memory allocation.

use super::elimination::Elimination;
use super::mechanism::{LinkageMechanism, Pose, largest};

/// Residual (over the largest length) below which a pose counts as solved.
///
/// Rounding of half a dozen terms of order 1 leaves about 3e-16, and quadratic convergence goes from 1e-8 to below
/// this value in one step. Every solved pose is guaranteed to 1e-12; a tolerance below 1e-15 may never be reached.
pub const TOLERANCE: f64 = 1e-14;

/// What is accepted when steps have become nothing: the promise itself.
const PROMISE: f64 = 1e-12;

/// Largest number of Newton steps. From a fair guess 4 to 6 are needed; near a dead centre, where convergence is linear
/// (one bit per step), up to 25.
pub const MAX_ITERATIONS: usize = 40;

/// Pivots below this count as zero (the Jacobian is of order one). Near a dead centre
/// they shrink like the root of the distance, so this allows 1e-24 of it.
const SINGULAR: f64 = 1e-12;

/// Outcome of an attempt to solve the closure equations.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NewtonOutcome {
    /// The residual is below [`TOLERANCE`] (or below 1e-12 and no longer decreasing).
    Converged,
    /// [`MAX_ITERATIONS`] steps were not enough.
    IterationLimit,
    /// The steps became negligible, but the equations still contradict each other.
    Inconsistent,
    /// The guess was too far away for a continuation step.
    TooFar,
    /// A value became infinite or NaN; it was not used.
    NotFinite,
}

/// Report of one solution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NewtonReport {
    /// Outcome of the attempt.
    pub outcome: NewtonOutcome,
    /// Newton steps taken.
    pub iterations: usize,
    /// Largest closure residual at the end, over the largest length.
    pub residual: f64,
}

impl NewtonReport {
    /// Whether the pose is a solution.
    #[must_use]
    pub(crate) fn converged(&self) -> bool {
        self.outcome == NewtonOutcome::Converged
    }
}

/// What solving needs and nobody keeps.
#[derive(Clone, Debug)]
pub(crate) struct Scratch {
    /// (cos, sin) of the angles in `trig_at`.
    trig: Vec<[f64; 2]>,
    trig_at: Vec<f64>,
    pub sums: Vec<f64>,
    jacobian: Vec<f64>,
    pub elimination: Elimination,
    rhs: Vec<f64>,
    step: Vec<f64>,
    /// Residual before the first step and after each.
    pub history: Vec<f64>,
}

/// How far a continuation corrector may move a coordinate (radians, or sliding over
/// the largest length) from its prediction before the step counts as too large. At
/// 0.5 (29 degrees) it could land on another branch; at 0.01 steps would be needlessly small.
const CORRECTION: f64 = 0.3;

/// A first guess may be far off, but one step may not turn a body more than this (rad).
const MAX_STEP: f64 = 0.7;

/// What the guess is: a user's, or a continuation's.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Guess {
    Rough,
    Predicted,
}

impl Scratch {
    pub(crate) fn new(mechanism: &LinkageMechanism) -> Self {
        let rows = 2 * mechanism.closures().len();
        let n = mechanism.coordinates().len();
        let unknown = mechanism.unknown_places().len();
        Scratch {
            trig: vec![[1.0, 0.0]; mechanism.angle_count()],
            trig_at: vec![0.0; mechanism.angle_count()],
            sums: vec![0.0; rows],
            jacobian: vec![0.0; rows * n],
            elimination: Elimination::new(rows, unknown),
            rhs: vec![0.0; rows],
            step: vec![0.0; unknown],
            history: Vec::with_capacity(MAX_ITERATIONS + 1),
        }
    }

    /// Residual and Jacobian at `pose`.
    pub(crate) fn linearise(&mut self, mechanism: &LinkageMechanism, pose: &Pose) {
        // The prescribed angle is the same in every iteration: its sine is not
        // computed again.
        let known = self.trig.iter_mut().zip(&mut self.trig_at);
        for ((trig, at), angle) in known.zip(&pose.values) {
            if *at != *angle {
                let (s, c) = angle.sin_cos();
                *trig = [c, s];
                *at = *angle;
            }
        }
        let Scratch { trig, sums, jacobian, .. } = self;
        mechanism.loops.linearise(&pose.values, trig, sums, jacobian);
    }

    /// Cosine and sine of an angle coordinate, as linearised last.
    pub(crate) fn cos_sin(&self, place: usize) -> [f64; 2] {
        self.trig[place]
    }

    /// Factorises the unknowns' columns of the Jacobian found last.
    pub(crate) fn factor(&mut self, mechanism: &LinkageMechanism) {
        let n = mechanism.coordinates().len();
        let unknown = mechanism.unknown_places();
        if unknown.is_empty() {
            return;
        }
        let target = self.elimination.matrix_mut().chunks_exact_mut(unknown.len());
        for (to, from) in target.zip(self.jacobian.chunks_exact(n)) {
            for (x, &place) in to.iter_mut().zip(unknown) {
                *x = from[place];
            }
        }
        self.elimination.factor(SINGULAR);
    }

    /// Newton-Raphson from the values in `pose`, prescribed ones held.
    /// Leaves residual and Jacobian at the last values.
    pub(crate) fn newton(&mut self, mechanism: &LinkageMechanism, pose: &mut Pose, guess: Guess) -> NewtonReport {
        self.history.clear();
        let mut iterations = 0;
        let outcome = loop {
            self.linearise(mechanism, pose);
            let residual = largest(&self.sums);
            self.history.push(residual);
            if !residual.is_finite() {
                break NewtonOutcome::NotFinite;
            }
            if residual <= TOLERANCE {
                break NewtonOutcome::Converged;
            }
            if iterations == MAX_ITERATIONS {
                break NewtonOutcome::IterationLimit;
            }
            self.factor(mechanism);
            for (r, sum) in self.rhs.iter_mut().zip(&self.sums) {
                *r = -sum;
            }
            self.elimination.solve(&self.rhs, &mut self.step);
            let length = largest(&self.step);
            // Steps of a rounding error change nothing any more.
            if length <= 4.0 * f64::EPSILON {
                break if residual <= PROMISE { NewtonOutcome::Converged } else { NewtonOutcome::Inconsistent };
            }
            let mut shorten = 1.0;
            match guess {
                Guess::Predicted if length > CORRECTION => break NewtonOutcome::TooFar,
                Guess::Rough if length > MAX_STEP => shorten = MAX_STEP / length,
                _ => {}
            }
            for (&place, step) in mechanism.unknown_places().iter().zip(&self.step) {
                let unit = if place < self.trig.len() { 1.0 } else { mechanism.scale() };
                pose.values[place] += shorten * step * unit;
            }
            iterations += 1;
        };
        NewtonReport { outcome, iterations, residual: *self.history.last().expect("one residual at least") }
    }

    /// Rates of all coordinates (rad and m per unit time) from those of the
    /// prescribed ones, through the Jacobian factorised last.
    pub(crate) fn rates(&mut self, mechanism: &LinkageMechanism, input: &[f64], rates: &mut [f64]) {
        let n = rates.len();
        rates.fill(0.0);
        for (&place, rate) in mechanism.prescribed_places().iter().zip(input) {
            rates[place] = *rate;
        }
        for (r, row) in self.rhs.iter_mut().zip(self.jacobian.chunks_exact(n.max(1))) {
            *r = 0.0;
            for &place in mechanism.prescribed_places() {
                let unit = if place < self.trig.len() { 1.0 } else { mechanism.scale() };
                *r -= row[place] * rates[place] / unit;
            }
        }
        self.back_substitute(mechanism, rates);
    }

    /// Second derivatives of all coordinates while the prescribed ones move at
    /// constant rates; `rates` as found by [`Scratch::rates`].
    pub(crate) fn accelerations(
        &mut self,
        mechanism: &LinkageMechanism,
        pose: &Pose,
        rates: &[f64],
        accelerations: &mut [f64],
    ) {
        accelerations.fill(0.0);
        (mechanism.loops).convective(&pose.values, rates, &self.trig, &mut self.rhs);
        for r in &mut self.rhs {
            *r = -*r;
        }
        self.back_substitute(mechanism, accelerations);
    }

    fn back_substitute(&mut self, mechanism: &LinkageMechanism, out: &mut [f64]) {
        self.elimination.solve(&self.rhs, &mut self.step);
        for (&place, step) in mechanism.unknown_places().iter().zip(&self.step) {
            let unit = if place < self.trig.len() { 1.0 } else { mechanism.scale() };
            out[place] = step * unit;
        }
    }
}
