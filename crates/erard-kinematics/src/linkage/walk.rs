//! Motion of a mechanism from pose to pose: continuation with step halving, which stops where no pose exists.

use std::fmt;

use super::description::CoordinateId;
use super::elimination::Elimination;
use super::mechanism::{LinkageMechanism, Pose};
use super::mobility::{Mobility, Verdict};
use super::newton::{Guess, NewtonReport, Scratch};

/// Steps are halved down to this part of the way: the precision with which a
/// stop is located. Rounding of the coordinate itself is 1e-16.
const SMALLEST_PART: f64 = 1e-14;

/// A pivot below this (of order one elsewhere) where a walk had to stop is blamed on
/// a singular Jacobian. The last good pose lies within 1e-14 of the way of the
/// obstacle: pivots have shrunk to 1e-7 at a dead centre, and below at a crossing.
const NEARLY_SINGULAR: f64 = 1e-4;

/// Error: a walk cannot begin.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum StartError {
    /// Newton-Raphson found no pose from the guess.
    #[error(
        "no pose found: {:?} after {} iterations, residual {:.1e} of the largest length",
        .0.outcome, .0.iterations, .0.residual
    )]
    NoPose(NewtonReport),
    /// The prescribed coordinates do not determine the pose, or contradict each other.
    #[error("{0}")]
    NotDetermined(Box<Mobility>),
}

/// Reason why a walk stopped early.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StopKind {
    /// No pose exists beyond this point: a dead centre or the end of reach. The other coordinates have infinite rates
    /// there, and would then return.
    Unreachable,
    /// A pose exists, but two families of poses cross there: the prescribed coordinates no longer determine the motion.
    Singular,
    /// Newton-Raphson did not converge, and the reason is unknown.
    NoConvergence,
}

/// Position and reason of a stop. The walk stays at the last solved pose.
#[derive(Clone, Debug, PartialEq)]
pub struct Stop {
    /// Reason.
    pub kind: StopKind,
    /// Symbol and value (rad or m) of each prescribed coordinate at the stop.
    pub at: Vec<(String, f64)>,
    /// Share of the way from the last pose to the target that was reached, 0 to 1.
    pub fraction: f64,
}

impl fmt::Display for Stop {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let at: Vec<String> = (self.at.iter()).map(|(s, v)| format!("{s} = {v:.9}")).collect();
        let why = match self.kind {
            StopKind::Unreachable => "no pose exists beyond (dead centre or end of reach)",
            StopKind::Singular => "singular pose, where the linkage may go two ways",
            StopKind::NoConvergence => "Newton-Raphson does not converge beyond",
        };
        write!(f, "stopped at {}: {why}", at.join(", "))
    }
}

impl std::error::Error for Stop {}

/// A mechanism in motion. It is always at a solved pose, with the Jacobian factorised there. Moving it does not
/// allocate.
#[derive(Clone, Debug)]
pub struct Walk<'m> {
    mechanism: &'m LinkageMechanism,
    pose: Pose,
    trial: Pose,
    scratch: Scratch,
    report: NewtonReport,
    history: Vec<f64>,
    from: Vec<f64>,
    way: Vec<f64>,
    rates: Vec<f64>,
    accelerations: Vec<f64>,
}

impl LinkageMechanism {
    /// Solves the closure equations from `guess` with its prescribed values, and returns a walk that starts at this
    /// pose.
    ///
    /// # Errors
    /// [`StartError::NoPose`] if Newton-Raphson finds none from this guess;
    /// [`StartError::NotDetermined`] if the pose is singular, or if too few or too
    /// many coordinates are prescribed.
    pub fn walk(&self, guess: Pose) -> Result<Walk<'_>, StartError> {
        let mut pose = guess;
        let mut scratch = Scratch::new(self);
        let report = scratch.newton(self, &mut pose, Guess::Rough);
        if !report.converged() {
            return Err(StartError::NoPose(report));
        }
        let mobility = self.mobility(&pose);
        if mobility.verdict() != Verdict::Determined {
            return Err(StartError::NotDetermined(Box::new(mobility)));
        }
        scratch.factor(self);
        let n = self.coordinates().len();
        let inputs = self.prescribed_places().len();
        let mut history = Vec::with_capacity(scratch.history.capacity());
        history.extend_from_slice(&scratch.history);
        Ok(Walk {
            mechanism: self,
            trial: pose.clone(),
            history,
            pose,
            scratch,
            report,
            from: vec![0.0; inputs],
            way: vec![0.0; inputs],
            rates: vec![0.0; n],
            accelerations: vec![0.0; n],
        })
    }
}

impl<'m> Walk<'m> {
    /// Returns the solved pose.
    #[must_use]
    pub fn pose(&self) -> &Pose {
        &self.pose
    }

    /// Cosine and sine of an angle coordinate at the pose.
    pub(crate) fn cos_sin(&self, angle: CoordinateId) -> [f64; 2] {
        self.scratch.cos_sin(angle.0)
    }

    /// Returns residual and iterations of the last solution.
    #[must_use]
    pub fn report(&self) -> NewtonReport {
        self.report
    }

    /// Returns the residuals of the last solution (over the largest length), before the first Newton step and after
    /// each. Each is about the square of the one before.
    #[must_use]
    pub fn residual_history(&self) -> &[f64] {
        &self.history
    }

    /// Returns the rates of all coordinates (rad and m per unit time) when the prescribed ones move at the rates
    /// `input`, in their order. With `input = [1.0]` these are the first-order kinematic coefficients dq/dp. They
    /// follow from the Jacobian, not from differences.
    ///
    /// # Panics
    /// Panics if `input` does not have one value per prescribed coordinate.
    pub fn rates(&mut self, input: &[f64]) -> &[f64] {
        assert_eq!(input.len(), self.way.len(), "one rate per prescribed coordinate");
        self.scratch.rates(self.mechanism, input, &mut self.rates);
        &self.rates
    }

    /// Returns the rates as [`Walk::rates`] does, and the second derivatives of all coordinates while the prescribed
    /// ones keep these rates: with `[1.0]`, dq/dp and d²q/dp².
    ///
    /// # Panics
    /// Panics if `input` does not have one value per prescribed coordinate.
    pub fn rates_and_accelerations(&mut self, input: &[f64]) -> (&[f64], &[f64]) {
        self.rates(input);
        self.scratch.accelerations(self.mechanism, &self.pose, &self.rates, &mut self.accelerations);
        (&self.rates, &self.accelerations)
    }

    /// Moves the prescribed coordinates to `targets` (rad or m) along a straight line and follows the branch of poses:
    /// it predicts along the tangent and corrects by Newton-Raphson. A step that fails is halved.
    ///
    /// A step fails if Newton-Raphson does not converge, if its correction is large, or if the determinant changes its
    /// sign. In the last case a singular pose lies in between, and the new pose may belong to another branch. (A
    /// redundant linkage has no determinant; only the first two are checked.)
    ///
    /// # Errors
    /// Returns [`Stop`] with position and reason; the walk then is at the last solved pose.
    ///
    /// # Panics
    /// Panics if `targets` does not have one value per prescribed coordinate.
    pub fn advance(&mut self, targets: &[f64]) -> Result<NewtonReport, Stop> {
        let inputs = self.mechanism.prescribed_places();
        assert_eq!(targets.len(), inputs.len(), "one target per prescribed coordinate");
        for (i, (&place, target)) in inputs.iter().zip(targets).enumerate() {
            self.from[i] = self.pose.values[place];
            self.way[i] = target - self.from[i];
        }
        let (mut done, mut part) = (0.0, 1.0);
        self.scratch.rates(self.mechanism, &self.way, &mut self.rates);
        while done < 1.0 {
            let last = done + part >= 1.0;
            let to = if last { 1.0 } else { done + part };
            self.predict(to - done);
            for (i, &place) in inputs.iter().enumerate() {
                self.trial.values[place] = if last { targets[i] } else { self.from[i] + to * self.way[i] };
            }
            if self.correct() {
                done = to;
                part *= 2.0;
                self.scratch.rates(self.mechanism, &self.way, &mut self.rates);
            } else {
                part *= 0.5;
                if part < SMALLEST_PART {
                    return Err(self.stop(done));
                }
            }
        }
        Ok(self.report)
    }

    fn predict(&mut self, part: f64) {
        let values = self.pose.values.iter().zip(&self.rates);
        for (trial, (value, rate)) in self.trial.values.iter_mut().zip(values) {
            *trial = value + part * rate;
        }
    }

    /// Solves for the trial pose and takes it over if it is on the same branch.
    fn correct(&mut self) -> bool {
        let before = (self.scratch.elimination.orientation(), self.scratch.elimination.rank());
        let report = (self.scratch).newton(self.mechanism, &mut self.trial, Guess::Predicted);
        let mut good = report.converged();
        if good {
            self.scratch.factor(self.mechanism);
            let elimination = &self.scratch.elimination;
            good = before == (elimination.orientation(), elimination.rank());
        }
        if good {
            self.report = report;
            self.history.clone_from(&self.scratch.history);
            std::mem::swap(&mut self.pose, &mut self.trial);
        } else {
            // Back to the factorisation that belongs to the pose.
            self.scratch.linearise(self.mechanism, &self.pose);
            self.scratch.factor(self.mechanism);
        }
        good
    }

    fn stop(&self, done: f64) -> Stop {
        let mechanism = self.mechanism;
        let unknowns = mechanism.unknown_places().len();
        let rows = 2 * mechanism.closures().len();
        let n = mechanism.coordinates().len();
        let mut full = Elimination::new(rows, n);
        full.matrix_mut().copy_from_slice(&mechanism.jacobian(&self.pose));
        full.factor(NEARLY_SINGULAR);
        let kind = if self.scratch.elimination.smallest_pivot(unknowns) > NEARLY_SINGULAR {
            StopKind::NoConvergence
        } else if full.rank() >= unknowns {
            // The equations themselves are sound; only the drive is at its end.
            StopKind::Unreachable
        } else {
            StopKind::Singular
        };
        Stop {
            kind,
            at: (mechanism.prescribed_places().iter().enumerate())
                .map(|(i, &place)| {
                    let symbol = mechanism.coordinates()[place].symbol.clone();
                    // A target that is not a number must not leak into the message.
                    let moved = if done > 0.0 { done * self.way[i] } else { 0.0 };
                    (symbol, self.from[i] + moved)
                })
                .collect(),
            fraction: done,
        }
    }
}

/// Pose of a [`Sweep`].
#[derive(Clone, Debug, PartialEq)]
pub struct SweptPose {
    /// Values of all coordinates.
    pub pose: Pose,
    /// Derivatives of all coordinates by the prescribed one.
    pub rates: Vec<f64>,
    /// Residual and iterations of the solution.
    pub report: NewtonReport,
}

/// Poses for a series of values of the only prescribed coordinate.
#[derive(Clone, Debug, PartialEq)]
pub struct Sweep {
    /// Poses reached, in order.
    pub poses: Vec<SweptPose>,
    /// Position and reason of an early stop; `None` if all poses were reached.
    pub stop: Option<Stop>,
}

impl Walk<'_> {
    /// Moves the only prescribed coordinate through `values` (rad or m), in order, and returns the poses.
    ///
    /// # Panics
    /// Panics if the mechanism does not have exactly one prescribed coordinate.
    pub fn sweep(&mut self, values: impl IntoIterator<Item = f64>) -> Sweep {
        let mut poses = Vec::new();
        for value in values {
            match self.advance(&[value]) {
                Ok(report) => {
                    let rates = self.rates(&[1.0]).to_vec();
                    poses.push(SweptPose { pose: self.pose.clone(), rates, report });
                }
                Err(stop) => {
                    return Sweep { poses, stop: Some(stop) };
                }
            }
        }
        Sweep { poses, stop: None }
    }
}
