//! The drive of a mechanism in one step.

use crate::hand::SiteHand;
use crate::real::{Mask, Real, Scalar, join, same_bits};

/// Correction gain for prescribed motions ([`SiteInput::Rigid`]), per step. A caller adds this share of the site's lag
/// behind the prescribed position, divided by the step, to the velocity of the next step. Errors of rounding and of
/// unconverged steps then do not accumulate.
pub const RIGID_CORRECTION: f64 = 0.1;

/// Input of the mechanism at the model's [`Site`](crate::Site) during one step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SiteInput<T> {
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
    /// A hand: a mass moved by muscle. Its position and velocity are part of the state. The site's spring and damper,
    /// with the joints of its finger in series, give the force.
    Hand(SiteHand<T>),
}

impl<T: Real> SiteInput<T> {
    /// Its kind, and its numbers in a fixed order; places that it does not use are zero.
    fn taken_apart(&self) -> (u8, [T; 8]) {
        let z = T::ZERO;
        match *self {
            SiteInput::Free => (0, [z; 8]),
            SiteInput::Force(force) => (1, [force, z, z, z, z, z, z, z]),
            SiteInput::Motion { position, velocity } => (2, [position, velocity, z, z, z, z, z, z]),
            SiteInput::Rigid { velocity } => (3, [velocity, z, z, z, z, z, z, z]),
            SiteInput::Hand(hand) => (4, hand.numbers()),
        }
    }

    /// Returns whether all numbers are finite. The step's result does not tell: where dry friction or a stop holds the
    /// site, laws that clamp swallow a NaN.
    #[inline(always)]
    pub fn finite(&self) -> T::Mask {
        match *self {
            SiteInput::Free => T::Mask::splat(true),
            SiteInput::Force(force) => force.finite(),
            SiteInput::Motion { position, velocity } => position.finite().and(velocity.finite()),
            SiteInput::Rigid { velocity } => velocity.finite(),
            SiteInput::Hand(hand) => hand.numbers().iter().fold(T::Mask::splat(true), |all, n| all.and(n.finite())),
        }
    }

    /// Returns whether two inputs are identical to the bit. A NaN is identical to itself.
    pub fn identical(&self, other: &Self) -> bool {
        let (a, b) = (self.taken_apart(), other.taken_apart());
        a.0 == b.0 && a.1.iter().zip(&b.1).all(|(a, b)| same_bits(*a, *b))
    }

    /// The input in numbers of another type.
    pub(crate) fn map<U>(&self, to: impl Fn(T) -> U) -> SiteInput<U> {
        match *self {
            SiteInput::Free => SiteInput::Free,
            SiteInput::Force(force) => SiteInput::Force(to(force)),
            SiteInput::Motion { position, velocity } => {
                SiteInput::Motion { position: to(position), velocity: to(velocity) }
            }
            SiteInput::Rigid { velocity } => SiteInput::Rigid { velocity: to(velocity) },
            SiteInput::Hand(hand) => SiteInput::Hand(hand.map(to)),
        }
    }

    /// Joins one input per lane; `None` if the inputs are of different kinds or their number is not the number of
    /// lanes.
    #[inline(always)]
    pub fn of_lanes<S: Scalar>(inputs: &[SiteInput<S>]) -> Option<Self> {
        match inputs.first()? {
            SiteInput::Free => inputs.iter().all(|i| matches!(i, SiteInput::Free)).then_some(SiteInput::Free),
            SiteInput::Force(_) => each(inputs, |i| if let SiteInput::Force(f) = i { Some([*f]) } else { None })
                .map(|[f]| SiteInput::Force(f)),
            SiteInput::Motion { .. } => each(inputs, |i| match i {
                SiteInput::Motion { position, velocity } => Some([*position, *velocity]),
                _ => None,
            })
            .map(|[position, velocity]| SiteInput::Motion { position, velocity }),
            SiteInput::Rigid { .. } => {
                each(inputs, |i| if let SiteInput::Rigid { velocity } = i { Some([*velocity]) } else { None })
                    .map(|[velocity]| SiteInput::Rigid { velocity })
            }
            SiteInput::Hand(_) => hands_of_lanes(inputs),
        }
    }
}

/// One lane's numbers each, where all inputs are of the kind that has them.
#[inline(always)]
fn each<S: Scalar, T: Real, const K: usize>(
    inputs: &[SiteInput<S>],
    numbers: impl Fn(&SiteInput<S>) -> Option<[S; K]>,
) -> Option<[T; K]> {
    let all = inputs.len() == T::LANES && inputs.iter().all(|input| numbers(input).is_some());
    all.then(|| core::array::from_fn(|k| join(|lane| numbers(&inputs[lane]).unwrap_or([S::ZERO; K])[k])))
}

/// A hand per lane. Out of line, so that nothing else pays for it.
#[cold]
#[inline(never)]
fn hands_of_lanes<S: Scalar, T: Real>(inputs: &[SiteInput<S>]) -> Option<SiteInput<T>> {
    let numbers = each(inputs, |i| if let SiteInput::Hand(hand) = i { Some(hand.numbers()) } else { None });
    numbers.map(|numbers| SiteInput::Hand(SiteHand::of_numbers(numbers)))
}
