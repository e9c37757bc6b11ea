//! The drive of a mechanism in one step.

use crate::hand::Hand;
use crate::real::{Real, Scalar, join, same_bits};

/// Correction gain for prescribed motions ([`Input::Rigid`]), per step. A caller adds this share of the site's lag
/// behind the prescribed position, divided by the step, to the velocity of the next step. Errors of rounding and of
/// unconverged steps then do not accumulate.
pub const RIGID_CORRECTION: f64 = 0.1;

/// Input of the mechanism at the model's [`Site`](crate::Site) during one step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Input<T> {
    /// No drive.
    Free,
    /// A force, N, along the site's direction, at time t0 + theta h.
    Force(T),
    /// The driver's position (m, world coordinate along the site's direction) and velocity at t0 + theta h; the force
    /// comes from the site's spring and damper, which only push.
    Motion {
        /// Position, m.
        position: T,
        /// Velocity, m/s.
        velocity: T,
    },
    /// Imposed velocity of the site along its direction at the step's end.
    Rigid {
        /// Velocity, m/s.
        velocity: T,
    },
    /// A hand: a mass moved by muscle. Its position and velocity are part of the state. The site's spring and damper
    /// act as its fingertip and give the force.
    Hand(Hand<T>),
}

impl<T: Real> Input<T> {
    /// Its kind, and its numbers in a fixed order; places that it does not use are zero.
    fn taken_apart(&self) -> (u8, [T; 6]) {
        let z = T::ZERO;
        match *self {
            Input::Free => (0, [z; 6]),
            Input::Force(force) => (1, [force, z, z, z, z, z]),
            Input::Motion { position, velocity } => (2, [position, velocity, z, z, z, z]),
            Input::Rigid { velocity } => (3, [velocity, z, z, z, z, z]),
            Input::Hand(hand) => (4, hand.numbers()),
        }
    }

    /// Returns whether two inputs are identical to the bit. A NaN is identical to itself.
    pub fn identical(&self, other: &Self) -> bool {
        let (a, b) = (self.taken_apart(), other.taken_apart());
        a.0 == b.0 && a.1.iter().zip(&b.1).all(|(a, b)| same_bits(*a, *b))
    }

    /// The input in numbers of another type.
    pub(crate) fn map<U>(&self, to: impl Fn(T) -> U) -> Input<U> {
        match *self {
            Input::Free => Input::Free,
            Input::Force(force) => Input::Force(to(force)),
            Input::Motion { position, velocity } => Input::Motion { position: to(position), velocity: to(velocity) },
            Input::Rigid { velocity } => Input::Rigid { velocity: to(velocity) },
            Input::Hand(hand) => Input::Hand(hand.map(to)),
        }
    }

    /// Joins one input per lane; `None` if the inputs are of different kinds or their number is not the number of
    /// lanes.
    #[inline(always)]
    pub fn of_lanes<S: Scalar>(inputs: &[Input<S>]) -> Option<Self> {
        match inputs.first()? {
            Input::Free => inputs.iter().all(|i| matches!(i, Input::Free)).then_some(Input::Free),
            Input::Force(_) => {
                each(inputs, |i| if let Input::Force(f) = i { Some([*f]) } else { None }).map(|[f]| Input::Force(f))
            }
            Input::Motion { .. } => each(inputs, |i| match i {
                Input::Motion { position, velocity } => Some([*position, *velocity]),
                _ => None,
            })
            .map(|[position, velocity]| Input::Motion { position, velocity }),
            Input::Rigid { .. } => {
                each(inputs, |i| if let Input::Rigid { velocity } = i { Some([*velocity]) } else { None })
                    .map(|[velocity]| Input::Rigid { velocity })
            }
            Input::Hand(_) => hands_of_lanes(inputs),
        }
    }
}

/// One lane's numbers each, where all inputs are of the kind that has them.
#[inline(always)]
fn each<S: Scalar, T: Real, const K: usize>(
    inputs: &[Input<S>],
    numbers: impl Fn(&Input<S>) -> Option<[S; K]>,
) -> Option<[T; K]> {
    let all = inputs.len() == T::LANES && inputs.iter().all(|input| numbers(input).is_some());
    all.then(|| core::array::from_fn(|k| join(|lane| numbers(&inputs[lane]).unwrap_or([S::ZERO; K])[k])))
}

/// A hand per lane. Out of line, so that nothing else pays for it.
#[cold]
#[inline(never)]
fn hands_of_lanes<S: Scalar, T: Real>(inputs: &[Input<S>]) -> Option<Input<T>> {
    let numbers = each(inputs, |i| if let Input::Hand(hand) = i { Some(hand.numbers()) } else { None });
    numbers.map(|numbers| Input::Hand(Hand::of_numbers(numbers)))
}
