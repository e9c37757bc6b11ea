//! Inputs and readings: plain numbers, SI units; key and finger positive downward, the hammer upward.

use erard::Input;
use erard::player::{Hand, HandInput};

use crate::status::ErardStatus;

/// The version of this interface: the layout of structures and the meaning of functions. A library of another version
/// cannot be used with this header; compare with erard_abi().
pub const ERARD_ABI: u32 = 1;

/// Largest force that an action takes, N, up or down: a hundred times a fortissimo.
pub const ERARD_LARGEST_FORCE_N: f64 = 10000.0;
/// Largest position that an action takes, m from rest, up or down: ten times a key's dip.
pub const ERARD_LARGEST_POSITION_M: f64 = 0.1;
/// Largest speed that an action takes, m/s, up or down.
pub const ERARD_LARGEST_SPEED_M_PER_S: f64 = 100.0;
// The ranges of every front.
const _: () = assert!(ERARD_LARGEST_FORCE_N == erard::player::LARGEST_FORCE_N);
const _: () = assert!(ERARD_LARGEST_POSITION_M == erard::player::LARGEST_POSITION_M);
const _: () = assert!(ERARD_LARGEST_SPEED_M_PER_S == erard::player::LARGEST_SPEED_M_PER_S);
/// Longest time that erard_advance takes at once, s.
pub const ERARD_LONGEST_ADVANCE_S: f64 = 1.0;

/// ErardInput.kind: nothing touches the key.
pub const ERARD_FREE: u32 = 0;
/// ErardInput.kind: a force on the key front (admittance).
pub const ERARD_FORCE: u32 = 1;
/// ErardInput.kind: the driver's end of a soft fingertip is somewhere and moves (impedance). The fingertip only pushes.
pub const ERARD_MOTION: u32 = 2;
/// ErardInput.kind: the key front itself is somewhere and moves, imposed. Not for a loop with a device: see "Closed
/// loop" in the README.
pub const ERARD_RIGID: u32 = 3;
/// ErardInput.kind: a hand, a mass that muscle moves, behind a soft fingertip. Its place and speed are part of the
/// action's state; erard_place_hand sets them.
pub const ERARD_HAND: u32 = 4;

/// Input of a key. Fields that its kind does not use are ignored.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ErardInput {
    /// ERARD_FREE, ERARD_FORCE, ERARD_MOTION, ERARD_RIGID or ERARD_HAND.
    pub kind: u32,
    /// 0.
    pub reserved: u32,
    /// N, down positive; of a hand, its muscle's force.
    pub force_n: f64,
    /// m below the key front's rest; of a hand, where its muscle holds it.
    pub position_m: f64,
    /// m/s, down positive; of a hand, the velocity toward which its muscle damps it.
    pub velocity_m_per_s: f64,
    /// Hand: effective mass at the fingertip, kg, 0.001 to 100.
    pub hand_mass_kg: f64,
    /// Hand: stiffness with which the muscle holds it at position_m, N/m, 0 to 1e7; 0 for none.
    pub muscle_n_per_m: f64,
    /// Hand: damping of the muscle, N s/m, 0 to 1e5.
    pub muscle_n_s_per_m: f64,
}

impl ErardInput {
    /// The input, if it is one that an action takes.
    pub(crate) fn checked(&self) -> Result<Input, ErardStatus> {
        let Self { kind, force_n, position_m, velocity_m_per_s, .. } = *self;
        match kind {
            ERARD_FREE => Ok(Input::Free),
            ERARD_FORCE => Ok(Input::Force(within(force_n, ERARD_LARGEST_FORCE_N)?)),
            ERARD_MOTION | ERARD_RIGID => {
                let position_m = within(position_m, ERARD_LARGEST_POSITION_M)?;
                let velocity_m_per_s = within(velocity_m_per_s, ERARD_LARGEST_SPEED_M_PER_S)?;
                Ok(if kind == ERARD_MOTION {
                    Input::Motion { position_m, velocity_m_per_s }
                } else {
                    Input::Rigid { position_m, velocity_m_per_s }
                })
            }
            ERARD_HAND => {
                let hand = Hand {
                    mass_kg: self.hand_mass_kg,
                    stiffness_n_per_m: self.muscle_n_per_m,
                    damping_n_s_per_m: self.muscle_n_s_per_m,
                    ..Hand::default()
                };
                let numbers = [hand.mass_kg, hand.stiffness_n_per_m, hand.damping_n_s_per_m];
                if !numbers.iter().all(|number| number.is_finite()) {
                    return Err(ErardStatus::NotFinite);
                }
                hand.check().map_err(|_| ErardStatus::Range)?;
                Ok(Input::Hand(HandInput {
                    mass_kg: hand.mass_kg,
                    force_n: within(force_n, ERARD_LARGEST_FORCE_N)?,
                    stiffness_n_per_m: hand.stiffness_n_per_m,
                    damping_n_s_per_m: hand.damping_n_s_per_m,
                    position_m: within(position_m, ERARD_LARGEST_POSITION_M)?,
                    velocity_m_per_s: within(velocity_m_per_s, ERARD_LARGEST_SPEED_M_PER_S)?,
                }))
            }
            _ => Err(ErardStatus::Argument),
        }
    }
}

/// A number up to a limit, either way.
#[inline(always)]
pub(crate) fn within(number: f64, limit: f64) -> Result<f64, ErardStatus> {
    if !number.is_finite() {
        Err(ErardStatus::NotFinite)
    } else if number.abs() > limit {
        Err(ErardStatus::Range)
    } else {
        Ok(number)
    }
}

/// Reading after a step: positions and speeds at its end, from rest; forces as they acted in it.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ErardReading {
    /// The present instant, s from the action's creation or its last reset.
    pub time_s: f64,
    /// Travel of the key front, m.
    pub key_m: f64,
    /// Its speed, m/s.
    pub key_m_per_s: f64,
    /// Force of the finger on the key in the last step, N: what a haptic key has to give back.
    pub finger_n: f64,
    /// Mean finger force over all steps of the call that made this reading, N: for a device that is slower than the
    /// steps.
    pub finger_mean_n: f64,
    /// Rise of the hammer's strike point, m.
    pub hammer_m: f64,
    /// How fast it rises, m/s.
    pub hammer_m_per_s: f64,
    /// Force between hammer and string, N, never negative.
    pub string_n: f64,
    /// Instant of the last impact of the hammer on its string, s; 0 before the first.
    pub impact_time_s: f64,
    /// Total speed of the strike point at that impact, m/s; 0 before the first.
    pub hammer_speed_m_per_s: f64,
    /// Number of impacts since the action was created or reset.
    pub impact_count: u32,
    /// Number of impacts in the call that made this reading.
    pub new_impact_count: u32,
    /// Place of the hand, m below the key front's rest; where none presses, where the last one was.
    pub hand_m: f64,
    /// Its speed, m/s.
    pub hand_m_per_s: f64,
}

/// An impact of a hammer on its string.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ErardImpact {
    /// The key, from 1.
    pub key: u32,
    /// 0.
    pub reserved: u32,
    /// Instant of the impact, s.
    pub time_s: f64,
    /// Total speed of the strike point at the impact, m/s.
    pub hammer_speed_m_per_s: f64,
}
