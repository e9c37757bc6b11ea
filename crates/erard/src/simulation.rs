//! One key press: from rest, driven, to the end of its duration.

use std::time::Instant;

use moreau::{Input, ModelError, Outcome, Settings};
use thiserror::Error;

use crate::equilibrium::{self, EquilibriumError};
use crate::events::Watch;
use crate::instrument::Instrument;
use crate::mechanism::{Mechanism, mechanism};
use crate::recorder::Recorder;
use crate::run::{Run, Work};
use crate::sight::{Visible, head_height};

/// Smallest step that a run accepts, s: below it the rounding of a position sum exceeds what the step improves.
pub const SMALLEST_STEP_S: f64 = 1e-8;
/// Largest step that a run accepts, s: a fortissimo blow lasts two of them.
pub const LARGEST_STEP_S: f64 = 1e-3;
/// Most rows that a run keeps unless told otherwise; longer runs keep every n-th step.
pub const MOST_ROWS: u64 = 200_000;
/// How much of a rigid drive's position error is taken back per step.
const RIGID_CORRECTION: f64 = 0.1;

/// What drives the key. Times in s from the stroke's start; forces in N, positions in m from the key front's rest, both
/// positive downward.
pub enum Drive<'a> {
    /// Nothing.
    Free,
    /// A force on the key front.
    Force(&'a dyn Fn(f64) -> f64),
    /// Position and velocity of the finger, which is soft and only pushes.
    Motion(&'a dyn Fn(f64) -> [f64; 2]),
    /// Position and velocity of the key front itself, imposed.
    Rigid(&'a dyn Fn(f64) -> [f64; 2]),
}

/// How to run.
#[derive(Debug, Clone, Copy)]
pub struct Setup {
    /// The engine's settings.
    pub settings: Settings<f64>,
    /// The instant at which the run starts, on the stroke's own clock, s.
    pub start_s: f64,
    /// Simulated time, s.
    pub duration_s: f64,
    /// Keep a row every so many steps; `None`: every step, or so many that [`MOST_ROWS`] are not exceeded.
    pub record_every: Option<u64>,
}

/// Why a run could not be made.
#[derive(Debug, Error)]
pub enum SimulationError {
    /// The step is out of range.
    #[error("the step is {found} s; expected a number from {SMALLEST_STEP_S:e} to {LARGEST_STEP_S:e} s")]
    Step {
        /// s.
        found: f64,
    },
    /// Theta is out of range.
    #[error("theta is {found}; expected a number from 0.5 (second order) to 1 (damped)")]
    Theta {
        /// Dimensionless.
        found: f64,
    },
    /// The duration is out of range.
    #[error("the duration is {found} s; expected a positive number of at most {longest} s (2^40 steps)")]
    Duration {
        /// s.
        found: f64,
        /// s.
        longest: f64,
    },
    /// The start is no sane instant.
    #[error("the stroke starts at {found} s; expected a number below 1e9 s")]
    Start {
        /// s.
        found: f64,
    },
    /// A number overflowed.
    #[error(
        "at {time_s:.6} s a number became infinite; a smaller step may help, but a stiffness, mass or drive must be far off"
    )]
    NonFinite {
        /// s.
        time_s: f64,
    },
    /// The instrument has no key to drive.
    #[error("the instrument names no key (`roles.key`), so that nothing can be driven")]
    NoKey,
    /// No rest to start from.
    #[error(transparent)]
    Equilibrium(#[from] EquilibriumError),
    /// Not assembled.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// The caller asked to stop.
    #[error("interrupted")]
    Interrupted,
}

impl Setup {
    /// Checks the numbers, and says how many steps they make.
    ///
    /// # Errors
    /// See [`SimulationError`].
    pub fn check(&self) -> Result<u64, SimulationError> {
        let Settings { step, theta, .. } = self.settings;
        if !(SMALLEST_STEP_S..=LARGEST_STEP_S).contains(&step) {
            return Err(SimulationError::Step { found: step });
        }
        if !(0.5..=1.0).contains(&theta) {
            return Err(SimulationError::Theta { found: theta });
        }
        if !(-1e9..=1e9).contains(&self.start_s) {
            return Err(SimulationError::Start { found: self.start_s });
        }
        let longest = step * (1u64 << 40) as f64;
        if !(self.duration_s > 0.0 && self.duration_s <= longest) {
            return Err(SimulationError::Duration { found: self.duration_s, longest });
        }
        Ok((self.duration_s / step).round().max(1.0) as u64)
    }
}

/// Simulates one press. `progress` is told the share done now and then, and ends the run by returning false.
///
/// The mechanism starts in equilibrium, friction included: undriven for a force, under the finger's first position for a
/// motion.
///
/// # Errors
/// See [`SimulationError`]. Steps that do not converge are no error: they are counted in the run's [`Work`].
pub fn simulate(
    instrument: &Instrument,
    drive: &Drive,
    setup: &Setup,
    progress: &mut dyn FnMut(f64) -> bool,
) -> Result<Run, SimulationError> {
    let steps = setup.check()?;
    if instrument.roles.key.is_none() && !matches!(drive, Drive::Free) {
        return Err(SimulationError::NoKey);
    }
    let mut m = mechanism(instrument, setup.settings)?;
    equilibrium::settle(m.as_mut(), &Input::Free)?;
    let rest = Rest { site_m: m.site_position(), head_m: head_height(instrument, m.as_ref()) };
    if let Drive::Motion(position) | Drive::Rigid(position) = drive {
        let at = position(setup.start_s)[0];
        if at > 0.0 {
            equilibrium::settle(m.as_mut(), &Input::Motion { position: rest.site_m + at, velocity: 0.0 })?;
        }
    }
    m.open_ledger();

    let every = setup.record_every.unwrap_or(1 + (steps - 1) / MOST_ROWS).max(1);
    let mut recorder = Recorder::new(instrument, (steps / every) as usize + 2);
    let mut watch = Watch::new(instrument);
    let mut work = Work {
        steps,
        unconverged_steps: 0,
        newton_iterations: 0,
        solver_iterations: 0,
        real_time_factor: 0.0,
        record_every: every,
    };
    let Settings { step: h, theta, .. } = setup.settings;
    let mut peak_force_n = 0.0_f64;
    let mut observe = |time_s: f64, record: bool, m: &dyn Mechanism| {
        let key_m = m.site_position() - rest.site_m;
        let hammer_m = head_height(instrument, m) - rest.head_m;
        watch.look(time_s, key_m, hammer_m, m);
        recorder.step(m);
        if record {
            recorder.row(time_s, key_m, hammer_m, m);
        }
    };
    observe(setup.start_s, true, m.as_ref());
    let start = Instant::now();
    for n in 0..steps {
        if n % 8192 == 0 && !progress(n as f64 / steps as f64) {
            return Err(SimulationError::Interrupted);
        }
        let t0 = setup.start_s + n as f64 * h;
        let input = rest.input(drive, t0, h, theta, m.as_ref());
        let report = m.step(&input);
        match report.outcome {
            Outcome::Converged => {}
            Outcome::IterationLimit => work.unconverged_steps += 1,
            Outcome::NonFinite => return Err(SimulationError::NonFinite { time_s: t0 }),
        }
        work.newton_iterations += u64::from(report.newton);
        work.solver_iterations += u64::from(report.solver);
        peak_force_n = peak_force_n.max(m.drive_force());
        observe(setup.start_s + (n + 1) as f64 * h, (n + 1) % every == 0 || n + 1 == steps, m.as_ref());
    }
    work.real_time_factor = steps as f64 * h / start.elapsed().as_secs_f64().max(1e-9);
    progress(1.0);
    Ok(Run {
        instrument: instrument.name.clone(),
        time_s: recorder.time_s,
        force_n: recorder.force_n,
        key_m: recorder.key_m,
        hammer_head_m: recorder.hammer_head_m,
        bodies: recorder.bodies,
        zones: recorder.zones,
        events: watch.finish(),
        peak_force_n,
        final_pivot_friction_n_m: m.pivot_friction().to_vec(),
        ledger: m.ledger(),
        work,
    })
}

/// What travels are measured from.
pub(crate) struct Rest {
    pub site_m: f64,
    pub head_m: f64,
}

impl Rest {
    /// The engine's input for the step from t0, each number at the instant that the engine expects.
    pub fn input(&self, drive: &Drive, t0: f64, h: f64, theta: f64, m: &dyn Visible) -> Input<f64> {
        let t_theta = t0 + theta * h;
        match drive {
            Drive::Free => Input::Free,
            Drive::Force(force) => Input::Force(force(t_theta)),
            Drive::Motion(position) => {
                let [y, velocity] = position(t_theta);
                Input::Motion { position: self.site_m + y, velocity }
            }
            Drive::Rigid(position) => {
                let behind = self.site_m + position(t0)[0] - m.site_position();
                Input::Rigid { velocity: position(t0 + h)[1] + RIGID_CORRECTION * behind / h }
            }
        }
    }
}
