//! Rest, friction included: the start of a run.

use moreau::{FrictionLaw, ModelError, Settings, SiteInput, StepOutcome, StepReport};
use thiserror::Error;

use super::{Action, PlayError};
use crate::instrument::Instrument;
use crate::progress::Progress;

/// Step of the settling run, s. It is the same for every run, so that runs with different steps start from the same
/// pose.
pub const STEP_S: f64 = crate::strings::STEP_S;
/// A mechanism that has not come to rest by itself after this time is slowed down artificially.
pub const PATIENCE_S: f64 = 2.0;
/// Most work of a search: steps, their Newton iterations and their solvers' iterations. It takes about a second,
/// whatever the mechanism makes of the steps; of 3003 random files that came to rest, all but one took at most 440 000.
const MOST_WORK: u64 = 600_000;
/// Rest has to last this long.
const QUIET_S: f64 = 0.05;
/// Below this speed (rad/s) a mechanism without dry friction counts as resting.
const CREEP_RAD_PER_S: f64 = 1e-9;

/// The search gives up after this many steps in a row without a solution (10 ms, longer than any impact lasts).
pub(crate) const UNSOLVED_STEPS: u32 = 200;

/// Why there is no rest to start from.
#[derive(Debug, Clone, Error)]
#[non_exhaustive]
pub enum EquilibriumError {
    /// The mechanism keeps moving.
    #[error(
        "{instrument}: the mechanism does not come to rest within {time_s:.1} s: the body `{body}` still turns at {speed:.1e} rad/s. Is a stop missing, or is it in unstable balance?"
    )]
    NoRest {
        /// The instrument's name.
        instrument: String,
        /// Simulated time until the search gave up, s.
        time_s: f64,
        /// The fastest body.
        body: String,
        /// Its angular speed, rad/s.
        speed: f64,
    },
    /// The solver finds no solution, step after step.
    #[error(
        "{instrument}: the mechanism does not come to rest: {UNSOLVED_STEPS} steps in a row, until {time_s:.3} s, reached the solver's iteration limit. Look for a stiffness, mass or length that is far off"
    )]
    Unsolved {
        /// The instrument's name.
        instrument: String,
        /// Simulated time until the search gave up, s.
        time_s: f64,
    },
    /// A number overflowed.
    #[error(
        "the mechanism flies apart while it settles (a number became infinite). Look for a stiffness, mass or length that is far off"
    )]
    NonFinite,
    /// Not assembled.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// The caller asked to stop.
    #[error("interrupted")]
    Interrupted,
}

/// Settings for the search for rest: true dry friction, and theta = 1, which damps the remaining motion without moving
/// the rest position.
pub fn settings() -> Settings<f64> {
    Settings { theta: 1.0, friction: FrictionLaw::SetValued, ..Settings::new(STEP_S) }
}

/// Watches a mechanism come to rest.
#[derive(Debug, Clone, Copy, Default)]
pub struct Settling {
    /// Simulated time so far, s.
    pub time_s: f64,
    quiet_s: f64,
    /// Largest angular speed now, rad/s.
    speed: f64,
    /// Steps in a row that found no solution while something moved.
    unsolved: u32,
    /// Steps and iterations so far.
    work: u64,
}

impl Settling {
    /// Call after every step of [`STEP_S`]; true when the mechanism has come to rest.
    pub fn rests(&mut self, velocities: &[f64]) -> bool {
        self.time_s += STEP_S;
        self.speed = velocities.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        self.quiet_s = if self.speed <= CREEP_RAD_PER_S { self.quiet_s + STEP_S } else { 0.0 };
        self.quiet_s >= QUIET_S
    }

    /// Counts the work of a step; true when the search should give up for it.
    fn is_exhausted(&mut self, report: &StepReport) -> bool {
        self.work += 1 + u64::from(report.newton) + u64::from(report.solver);
        self.work > MOST_WORK
    }

    /// Counts steps without a solution; call it with every step's outcome after [`Settling::rests`]. True when the
    /// search should give up. Steps in which nothing moves do not count: there forces may be undetermined (felts with a
    /// set-valued loss can lock more than there are degrees of freedom).
    pub fn is_hopeless(&mut self, outcome: StepOutcome) -> bool {
        let unsolved = outcome == StepOutcome::IterationLimit && self.quiet_s == 0.0;
        self.unsolved = if unsolved { self.unsolved + 1 } else { 0 };
        outcome == StepOutcome::NonFinite || self.unsolved >= UNSOLVED_STEPS
    }
}

/// Lets an action come to rest under a constant input, with true dry friction whatever its settings say; they are
/// restored, and the velocities are zero, at the end. `instrument` is what it was assembled from. Returns the simulated
/// time it took, s.
///
/// # Errors
/// See [`EquilibriumError`].
pub(crate) fn settle(
    action: &mut Action,
    instrument: &Instrument,
    input: &SiteInput<f64>,
    progress: &mut Progress<'_>,
) -> Result<f64, EquilibriumError> {
    let own = *action.settings();
    action.set_settings(settings());
    action.let_strings_follow(true);
    let (mut settling, mut energy, mut result) = (Settling::default(), 0.0_f64, None);
    let played = action.play_engine(progress, &mut |action, last| {
        let Some(report) = last else { return Some(*input) };
        let velocities = action.velocities();
        if settling.rests(velocities) {
            result = Some(Ok(settling.time_s));
            return None;
        }
        if settling.is_hopeless(report.outcome) {
            let (instrument, time_s) = (instrument.name.clone(), settling.time_s);
            result = Some(Err(EquilibriumError::Unsolved { instrument, time_s }));
            return None;
        }
        if settling.is_exhausted(report) {
            let fastest = velocities.iter().enumerate().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
            let body = fastest.and_then(|(body, _)| instrument.bodies.get(body));
            result = Some(Err(EquilibriumError::NoRest {
                instrument: instrument.name.clone(),
                time_s: settling.time_s,
                body: body.map_or_else(String::new, |body| body.name.clone()),
                speed: settling.speed,
            }));
            return None;
        }
        if settling.time_s > PATIENCE_S {
            // Kinetic damping (dynamic relaxation): at every peak of the kinetic energy, start again from standstill.
            let kinetic = action.mechanism().energies_at(velocities).kinetic;
            if kinetic < energy {
                action.stop();
                energy = 0.0;
            } else {
                energy = kinetic;
            }
        }
        Some(*input)
    });
    action.stop();
    action.let_strings_follow(false);
    action.set_settings(own);
    match (played, result) {
        (Err(PlayError::Interrupted), _) | (Ok(()), None) => Err(EquilibriumError::Interrupted),
        (Err(PlayError::NonFinite { .. }), _) => Err(EquilibriumError::NonFinite),
        (Ok(()), Some(result)) => result,
    }
}
