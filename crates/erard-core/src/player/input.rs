//! The drive of an action: owned values, one for each step.

use super::hand::HandInput;

/// The drive of the key in a step. Forces in N, positions in m from the key front's rest, both positive downward
/// (pushing).
///
/// The numbers of a force or of a soft finger belong to the step's theta point (with the usual theta of 1/2: its
/// middle), those of an imposed motion to its end. A control loop that has one number per period simply passes it.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Input {
    /// Nothing touches the key.
    Free,
    /// A force on the key front.
    Force(f64),
    /// Position of the driver's end of a soft fingertip. The fingertip's spring and damper (the instrument's
    /// `[finger]`) only push.
    Motion {
        /// m.
        position_m: f64,
        /// m/s.
        velocity_m_per_s: f64,
    },
    /// Position of the key front itself, imposed.
    Rigid {
        /// m.
        position_m: f64,
        /// m/s.
        velocity_m_per_s: f64,
    },
    /// A hand ([`super::Hand::input`]): a mass that muscle moves, whose fingertip is the instrument's `[finger]`, in
    /// series with the finger's [`Joints`](super::Joints). Its place and speed are part of the action's state;
    /// [`crate::Action::place_hand`] sets them.
    Hand(HandInput),
}

impl Input {
    /// The input `t` s later, for a step of `h` s: a motion continues at its velocity. A soft finger's place, and the
    /// place where a muscle holds its hand, belong to the middle of the step, an imposed one to its end. A device that
    /// is slower than the steps gives one input for all steps of its period; `t` counts from the period's beginning.
    #[must_use]
    pub fn later(self, t: f64, h: f64) -> Self {
        match self {
            Input::Motion { position_m, velocity_m_per_s } => {
                Input::Motion { position_m: position_m + velocity_m_per_s * (t + 0.5 * h), velocity_m_per_s }
            }
            Input::Rigid { position_m, velocity_m_per_s } => {
                Input::Rigid { position_m: position_m + velocity_m_per_s * (t + h), velocity_m_per_s }
            }
            Input::Hand(hand) => {
                Input::Hand(HandInput { position_m: hand.position_m + hand.velocity_m_per_s * (t + 0.5 * h), ..hand })
            }
            held => held,
        }
    }

    /// Position of a motion, m; 0 for inputs without one.
    pub fn position_m(&self) -> f64 {
        match *self {
            Input::Free | Input::Force(_) | Input::Hand(_) => 0.0,
            Input::Motion { position_m, .. } | Input::Rigid { position_m, .. } => position_m,
        }
    }
}

/// A fingertip between a pointer and the key front that belongs to the player, not to the instrument: a spring and a
/// damper that only push. Its force is that of the key's last reading, held over a step ([`Input::Force`]), so that the
/// instrument stays as its file has it. The steps stay stable while their square times the stiffness, and their length
/// times the damping, are well below the mass at the key front (some 0.1 kg: with 50 us, below 1e6 N/m and 1e3 N s/m).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fingertip {
    /// N/m.
    pub stiffness_n_per_m: f64,
    /// N s/m.
    pub damping_n_s_per_m: f64,
}

impl Fingertip {
    /// Returns its force on the key front, N, not negative: `position_m` and `velocity_m_per_s` are the pointer's, as
    /// in [`Input::Motion`]; `key_m` and `key_m_per_s` the key's, as in a [`Reading`](super::Reading).
    #[must_use]
    pub fn force_n(&self, [position_m, velocity_m_per_s]: [f64; 2], [key_m, key_m_per_s]: [f64; 2]) -> f64 {
        let depth_m = position_m - key_m;
        if depth_m <= 0.0 {
            return 0.0;
        }
        (self.stiffness_n_per_m * depth_m + self.damping_n_s_per_m * (velocity_m_per_s - key_m_per_s)).max(0.0)
    }
}

/// The input of the key as a function of time, s from the stroke's start.
pub type Drive<'a> = dyn Fn(f64) -> Input + 'a;

/// The inputs of a force over time, s to N.
pub fn force(force_n: impl Fn(f64) -> f64) -> impl Fn(f64) -> Input {
    move |t| Input::Force(force_n(t))
}

/// The inputs of a soft finger's motion, s to m and m/s.
pub fn motion(position: impl Fn(f64) -> [f64; 2]) -> impl Fn(f64) -> Input {
    move |t| {
        let [position_m, velocity_m_per_s] = position(t);
        Input::Motion { position_m, velocity_m_per_s }
    }
}

/// The inputs of a motion that is imposed on the key front, s to m and m/s.
pub fn rigid(position: impl Fn(f64) -> [f64; 2]) -> impl Fn(f64) -> Input {
    move |t| {
        let [position_m, velocity_m_per_s] = position(t);
        Input::Rigid { position_m, velocity_m_per_s }
    }
}

/// Largest force that one step takes, N, up or down: a hundred times a fortissimo.
pub const MAX_FORCE_N: f64 = 1e4;
/// Largest position that one step takes, m from rest, up or down: ten times a key's dip.
pub const MAX_POSITION_M: f64 = 0.1;
/// Largest speed that one step takes, m/s, up or down.
pub const MAX_SPEED_M_PER_S: f64 = 100.0;

/// A number out of range for a step.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("found {found}; expected a number of at most {most} {unit} either way")]
pub struct InputRange {
    /// The value given, in `unit`.
    pub found: f64,
    /// The largest, in `unit`.
    pub most: f64,
    /// `N`, `m` or `m/s`.
    pub unit: &'static str,
}

/// Checks the drive of a key for one step: force, fingertip's or key's motion. Code that takes numbers from outside
/// calls this; the step itself does not. A hand's input is checked where its numbers are set.
///
/// # Errors
/// [`InputRange`] with the number that is not finite or beyond its range.
pub fn check(input: &Input) -> Result<(), InputRange> {
    let within = |found: f64, most: f64, unit: &'static str| {
        if found.abs() <= most { Ok(()) } else { Err(InputRange { found, most, unit }) }
    };
    match *input {
        Input::Force(n) => within(n, MAX_FORCE_N, "N"),
        Input::Motion { position_m, velocity_m_per_s } | Input::Rigid { position_m, velocity_m_per_s } => {
            within(position_m, MAX_POSITION_M, "m")?;
            within(velocity_m_per_s, MAX_SPEED_M_PER_S, "m/s")
        }
        _ => Ok(()),
    }
}
