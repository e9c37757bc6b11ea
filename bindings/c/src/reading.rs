//! Inputs and readings: plain numbers, SI units; key and finger positive downward, the hammer upward.

use erard::Input;
use erard::player::{Hand, HandInput, Joints};

use crate::caller_struct::CallerStruct;
use crate::status::ErardStatus;

/// Version of this interface: the layout of its structures and the meaning of its functions. A library with another
/// version cannot be used with this header: check that erard_abi() returns this value.
pub const ERARD_ABI: u32 = 1;

/// Largest force that an action accepts, N, up or down: a hundred times a fortissimo.
pub const ERARD_MAX_FORCE_N: f64 = 10000.0;
/// Largest distance from rest that an action accepts, m, up or down: ten times a key's dip.
pub const ERARD_MAX_POSITION_M: f64 = 0.1;
/// Largest speed that an action accepts, m/s, up or down.
pub const ERARD_MAX_SPEED_M_PER_S: f64 = 100.0;
// The ranges of every front.
const _: () = assert!(ERARD_MAX_FORCE_N == erard::player::MAX_FORCE_N);
const _: () = assert!(ERARD_MAX_POSITION_M == erard::player::MAX_POSITION_M);
const _: () = assert!(ERARD_MAX_SPEED_M_PER_S == erard::player::MAX_SPEED_M_PER_S);
/// Longest time that one call of erard_action_advance accepts, s.
pub const ERARD_MAX_ADVANCE_S: f64 = 1.0;

/// ErardInput.kind: nothing touches the key.
pub const ERARD_INPUT_FREE: u32 = 0;
/// ErardInput.kind: a force on the key front (admittance).
pub const ERARD_INPUT_FORCE: u32 = 1;
/// ErardInput.kind: prescribed position and velocity of the fingertip's driven end (impedance). The fingertip is soft
/// and can only push.
pub const ERARD_INPUT_MOTION: u32 = 2;
/// ErardInput.kind: prescribed position and velocity of the key front itself. Do not use it in a loop with a device:
/// see "Closed loop" in the README.
pub const ERARD_INPUT_RIGID: u32 = 3;
/// ErardInput.kind: a hand, which is a mass moved by a muscle, behind a soft fingertip. The hand's position and
/// velocity are part of the action's state; erard_action_place_hand sets them.
pub const ERARD_INPUT_HAND: u32 = 4;

/// Input of a key. Fields that the kind does not use are ignored.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ErardInput {
    /// sizeof(ErardInput).
    pub struct_size: u32,
    /// ERARD_INPUT_FREE, ERARD_INPUT_FORCE, ERARD_INPUT_MOTION, ERARD_INPUT_RIGID or ERARD_INPUT_HAND.
    pub kind: u32,
    /// Force on the key front, N, down positive. With ERARD_INPUT_HAND: force of the muscle on the hand.
    pub force_n: f64,
    /// Position, m below the key front's rest. With ERARD_INPUT_HAND: the position at which the muscle holds the hand.
    pub position_m: f64,
    /// Velocity, m/s, down positive. With ERARD_INPUT_HAND: the velocity toward which the muscle damps the hand.
    pub velocity_m_per_s: f64,
    /// Effective mass of the hand at the fingertip, kg, 0.001 to 100.
    pub hand_mass_kg: f64,
    /// Stiffness with which the muscle holds the hand at position_m, N/m, 0 to 1e7; 0 for none.
    pub muscle_n_per_m: f64,
    /// Damping of the muscle, N s/m, 0 to 1e5.
    pub muscle_n_s_per_m: f64,
    /// Compliance of the joints of the hand's finger, m/N, 0 to 0.1; 0 for stiff ones.
    pub joints_m_per_n: f64,
    /// Damping of the joints over their stiffness, s, 0 to 1.
    pub joints_s: f64,
}

impl Default for ErardInput {
    /// A free key.
    fn default() -> Self {
        Self::zeroed()
    }
}

// SAFETY: a `repr(C)` struct of two u32 and eight f64: no padding, and every bit pattern is a value. `struct_size` is
// its first field.
unsafe impl CallerStruct for ErardInput {
    const FIRST_BYTES: usize = 56;
}

impl ErardInput {
    /// Returns the input if an action accepts it.
    pub(crate) fn checked(&self) -> Result<Input, ErardStatus> {
        let Self { kind, force_n, position_m, velocity_m_per_s, .. } = *self;
        match kind {
            ERARD_INPUT_FREE => Ok(Input::Free),
            ERARD_INPUT_FORCE => Ok(Input::Force(within(force_n, ERARD_MAX_FORCE_N)?)),
            ERARD_INPUT_MOTION | ERARD_INPUT_RIGID => {
                let position_m = within(position_m, ERARD_MAX_POSITION_M)?;
                let velocity_m_per_s = within(velocity_m_per_s, ERARD_MAX_SPEED_M_PER_S)?;
                Ok(if kind == ERARD_INPUT_MOTION {
                    Input::Motion { position_m, velocity_m_per_s }
                } else {
                    Input::Rigid { position_m, velocity_m_per_s }
                })
            }
            ERARD_INPUT_HAND => {
                let hand = Hand {
                    mass_kg: self.hand_mass_kg,
                    stiffness_n_per_m: self.muscle_n_per_m,
                    damping_n_s_per_m: self.muscle_n_s_per_m,
                    joints: Joints { compliance_m_per_n: self.joints_m_per_n, retardation_s: self.joints_s },
                    ..Hand::default()
                };
                let Joints { compliance_m_per_n, retardation_s } = hand.joints;
                let numbers =
                    [hand.mass_kg, hand.stiffness_n_per_m, hand.damping_n_s_per_m, compliance_m_per_n, retardation_s];
                if !numbers.iter().all(|number| number.is_finite()) {
                    return Err(ErardStatus::NotFinite);
                }
                hand.check().map_err(|_| ErardStatus::Range)?;
                Ok(Input::Hand(HandInput {
                    mass_kg: hand.mass_kg,
                    force_n: within(force_n, ERARD_MAX_FORCE_N)?,
                    stiffness_n_per_m: hand.stiffness_n_per_m,
                    damping_n_s_per_m: hand.damping_n_s_per_m,
                    position_m: within(position_m, ERARD_MAX_POSITION_M)?,
                    velocity_m_per_s: within(velocity_m_per_s, ERARD_MAX_SPEED_M_PER_S)?,
                    joints: hand.joints,
                }))
            }
            _ => Err(ErardStatus::Argument),
        }
    }
}

/// Returns the number if its magnitude is within a limit.
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

/// Reading after a step. Positions are relative to rest; positions and velocities are those at the end of the step,
/// forces those that acted during it.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ErardReading {
    /// sizeof(ErardReading).
    pub struct_size: u32,
    /// 0.
    pub reserved: u32,
    /// The present instant, s from the action's creation or its last reset.
    pub time_s: f64,
    /// Travel of the key front, m, down positive.
    pub key_m: f64,
    /// Velocity of the key front, m/s, down positive.
    pub key_m_per_s: f64,
    /// Force of the finger on the key in the last step, N, down positive: the force that a haptic key renders.
    pub finger_force_n: f64,
    /// Mean finger force over all steps of the call that made this reading, N: for a device that is slower than the
    /// steps.
    pub finger_force_mean_n: f64,
    /// Rise of the hammer's strike point, m, up positive.
    pub hammer_rise_m: f64,
    /// Upward velocity of the hammer's strike point, m/s.
    pub hammer_rise_m_per_s: f64,
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
    /// Position of the hand, m below the key front's rest. Without a hand, the last position of the last one.
    pub hand_m: f64,
    /// Velocity of the hand, m/s, down positive.
    pub hand_m_per_s: f64,
}

impl Default for ErardReading {
    /// All numbers are 0.
    fn default() -> Self {
        Self::zeroed()
    }
}

// SAFETY: a `repr(C)` struct of two u32, ten f64, two u32 and two f64: no padding, and every bit pattern is a value.
// `struct_size` is its first field.
unsafe impl CallerStruct for ErardReading {
    const FIRST_BYTES: usize = 112;
}

/// Impact of a hammer on its string. In an array, set the size of the first element only: it holds for all.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ErardImpact {
    /// sizeof(ErardImpact).
    pub struct_size: u32,
    /// The key, from 1.
    pub key: u32,
    /// Instant of the impact, s.
    pub time_s: f64,
    /// Total speed of the strike point at the impact, m/s.
    pub hammer_speed_m_per_s: f64,
}

impl Default for ErardImpact {
    /// No key's.
    fn default() -> Self {
        Self::zeroed()
    }
}

// SAFETY: a `repr(C)` struct of two u32 and two f64: no padding, and every bit pattern is a value. `struct_size` is its
// first field.
unsafe impl CallerStruct for ErardImpact {
    const FIRST_BYTES: usize = 24;
}
