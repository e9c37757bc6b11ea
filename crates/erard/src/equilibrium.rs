//! Rest, friction included: where a run starts.

use moreau::{FrictionLaw, Input, ModelError, Outcome, Settings};
use thiserror::Error;

use crate::mechanism::Mechanism;

/// Step of the settling run, s. It is the same for every run, so that runs with different steps start from the same pose.
pub const STEP_S: f64 = 50e-6;
/// A mechanism that has not come to rest by itself after this time is slowed down by force.
const PATIENCE_S: f64 = 2.0;
/// Largest settling time in all.
const LIMIT_S: f64 = 20.0;
/// Rest has to last this long.
const QUIET_S: f64 = 0.05;
/// Below this speed (rad/s) a mechanism without dry friction counts as resting.
const CREEP_RAD_PER_S: f64 = 1e-9;

/// Why there is no rest to start from.
#[derive(Debug, Error)]
pub enum EquilibriumError {
    /// The mechanism keeps moving.
    #[error(
        "the mechanism finds no rest within {LIMIT_S} s: after that time a body still turns at {speed:.1e} rad/s. Is a stop missing, or does a body hang in unstable balance?"
    )]
    NoRest {
        /// Largest angular speed, rad/s.
        speed: f64,
    },
    /// A number overflowed.
    #[error(
        "the mechanism flies apart while it settles (a number became infinite): a stiffness, mass or length must be far off"
    )]
    NonFinite,
    /// Not assembled.
    #[error(transparent)]
    Model(#[from] ModelError),
}

/// Lets a mechanism come to rest under a constant input, with true dry friction whatever its settings say; they are
/// restored, and the velocities are zero, at the end. Returns the simulated time it took, s.
///
/// # Errors
/// See [`EquilibriumError`].
pub fn settle(mechanism: &mut dyn Mechanism, input: &Input<f64>) -> Result<f64, EquilibriumError> {
    let own = *mechanism.settings();
    // theta = 1 damps what the felts leave, and does not move the rest position.
    mechanism.set_settings(Settings { theta: 1.0, friction: FrictionLaw::SetValued, ..Settings::new(STEP_S) });
    let (mut time, mut quiet, mut energy) = (0.0, 0.0, 0.0_f64);
    let result = loop {
        if mechanism.step(input).outcome == Outcome::NonFinite {
            break Err(EquilibriumError::NonFinite);
        }
        time += STEP_S;
        let speed = mechanism.velocities().iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        quiet = if speed <= CREEP_RAD_PER_S { quiet + STEP_S } else { 0.0 };
        if quiet >= QUIET_S {
            break Ok(time);
        }
        if time > LIMIT_S {
            break Err(EquilibriumError::NoRest { speed });
        }
        if time > PATIENCE_S {
            // Kinetic damping (dynamic relaxation): at every peak of the kinetic energy, start again from standstill.
            let kinetic = mechanism.energies_at(mechanism.velocities()).kinetic;
            if kinetic < energy {
                mechanism.stop();
                energy = 0.0;
            } else {
                energy = kinetic;
            }
        }
    };
    mechanism.stop();
    mechanism.set_settings(own);
    result
}
