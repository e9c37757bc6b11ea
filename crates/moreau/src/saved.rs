//! Numbers of a state: the single list by which they are copied, compared, and put into lanes.

use crate::law::MEMORY;
use crate::real::{Real, Scalar, cast};

/// All numbers that a step's result depends on. The other contents of a [`State`](crate::State) only save work.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SavedState<T, const B: usize, const Z: usize> {
    /// Absolute angles q, rad.
    pub angle: [T; B],
    /// Absolute angular velocities v, rad/s.
    pub velocity: [T; B],
    /// Change of the velocities over the last step, rad/s. The next step's iteration starts from it.
    pub increment: [T; B],
    // The contact cache: what the set-valued laws did in the last step. It warm-starts the solver.
    /// Dry friction torque of each pivot over the last step, N m (counter-clockwise on the body).
    pub pivot_friction: [T; B],
    /// Coulomb force of each zone over the last step, N, on the disc along the tangent.
    pub tangential: [T; Z],
    /// Force of a prescribed motion ([`SiteInput::Rigid`](crate::SiteInput::Rigid)) over the last step, N.
    pub rigid_force: T,
    /// World coordinate of the hand along the site's direction, m, and its velocity, m/s
    /// ([`SiteHand`](crate::SiteHand)). They change only in steps driven by a hand.
    pub hand: [T; 2],
    /// Internal states of the felts, as their laws define them ([`Loss`](crate::Loss)). Unused places are zero.
    pub memory: [[T; MEMORY]; Z],
    /// Growth of each pivot's dry friction while it stuck, from 0 (kinetic) to 1 (static); zero for friction that does
    /// not grow ([`Dwell`](crate::Dwell)).
    pub pivot_rested: [T; B],
    /// Growth of each zone's Coulomb friction, as in `pivot_rested`.
    pub rested: [T; Z],
    /// Sign of each zone's Coulomb force if it was at its bound over the last step, else 0. The solver's first guess.
    pub side: [T; Z],
}

/// Makes, from the fields with a number for every body, for every zone, with two and alone, what is done with all of
/// them.
macro_rules! each_field {
    (bodies: $($body:ident)*; zones: $($zone:ident)*; memories: $($memory:ident)*; pairs: $($pair:ident)*; alone: $($alone:ident)*) => {
        impl<T: Real, const B: usize, const Z: usize> SavedState<T, B, Z> {
            /// All zero.
            fn zero() -> Self {
                SavedState { $($body: [T::ZERO; B],)* $($zone: [T::ZERO; Z],)* $($memory: [[T::ZERO; MEMORY]; Z],)* $($pair: [T::ZERO; 2],)* $($alone: T::ZERO,)* }
            }

            /// The same in other arrays.
            fn rearranged<const C: usize, const Y: usize>(
                &self,
                bodies: impl Fn(&[T; B]) -> [T; C],
                zones: impl Fn(&[T; Z]) -> [T; Y],
            ) -> SavedState<T, C, Y> {
                SavedState {
                    $($body: bodies(&self.$body),)*
                    $($zone: zones(&self.$zone),)*
                    $($memory: {
                        // Plain loops: what a real-time caller reaches holds no clean-up after a panic.
                        let mut all = [[T::ZERO; MEMORY]; Y];
                        for k in 0..MEMORY {
                            let mut place = [T::ZERO; Z];
                            for z in 0..Z {
                                place[z] = self.$memory[z][k];
                            }
                            let place = zones(&place);
                            for z in 0..Y {
                                all[z][k] = place[z];
                            }
                        }
                        all
                    },)*
                    $($pair: self.$pair,)*
                    $($alone: self.$alone,)*
                }
            }

            /// One lane's numbers, in another precision.
            pub(crate) fn lane_in<S: Scalar>(&self, lane: usize) -> SavedState<S, B, Z> {
                let one = |x: &T| cast(x.lane_in(lane));
                SavedState {
                    $($body: self.$body.each_ref().map(one),)*
                    $($zone: self.$zone.each_ref().map(one),)*
                    $($memory: self.$memory.each_ref().map(|numbers| numbers.each_ref().map(one)),)*
                    $($pair: self.$pair.each_ref().map(one),)*
                    $($alone: one(&self.$alone),)*
                }
            }

            /// Number by number, with those of another.
            #[inline(always)]
            pub(crate) fn zip<U: Copy, V>(
                &self,
                other: &SavedState<U, B, Z>,
                mut f: impl FnMut(T, U) -> V,
            ) -> SavedState<V, B, Z> {
                SavedState {
                    $($body: core::array::from_fn(|i| f(self.$body[i], other.$body[i])),)*
                    $($zone: core::array::from_fn(|z| f(self.$zone[z], other.$zone[z])),)*
                    $($memory: core::array::from_fn(|z| {
                        core::array::from_fn(|k| f(self.$memory[z][k], other.$memory[z][k]))
                    }),)*
                    $($pair: core::array::from_fn(|k| f(self.$pair[k], other.$pair[k])),)*
                    $($alone: f(self.$alone, other.$alone),)*
                }
            }
        }
    };
}

each_field!(
    bodies: velocity angle increment pivot_friction pivot_rested;
    zones: tangential side rested;
    memories: memory;
    pairs: hand;
    alone: rigid_force
);

impl<T: Real, const B: usize, const Z: usize> SavedState<T, B, Z> {
    /// Returns a state at rest at the given absolute angles, rad.
    pub fn at_rest(angle: [T; B]) -> Self {
        SavedState { angle, ..SavedState::zero() }
    }

    /// Number by number.
    #[inline(always)]
    pub(crate) fn map<V>(&self, mut f: impl FnMut(T) -> V) -> SavedState<V, B, Z> {
        self.zip(self, |x, _| f(x))
    }

    /// Returns this state in another size: cut off, or filled with zeros.
    pub fn sized<const C: usize, const Y: usize>(&self) -> SavedState<T, C, Y> {
        self.rearranged(|bodies| sized(bodies), |zones| sized(zones))
    }

    /// Returns this state with bodies and zones in another order: place i takes the content of place `bodies[i]`, or
    /// `zones[i]`.
    pub fn reordered(&self, bodies: &[usize; B], zones: &[usize; Z]) -> Self {
        self.rearranged(|numbers| reordered(numbers, bodies), |numbers| reordered(numbers, zones))
    }
}

fn reordered<T: Real, const K: usize>(numbers: &[T; K], order: &[usize; K]) -> [T; K] {
    // A plain loop: what a real-time caller reaches holds no clean-up after a panic.
    let mut sorted = [T::ZERO; K];
    for i in 0..K {
        if let Some(number) = numbers.get(order[i]) {
            sorted[i] = *number;
        }
    }
    sorted
}

fn sized<T: Real, const K: usize>(numbers: &[T]) -> [T; K] {
    core::array::from_fn(|i| numbers.get(i).copied().unwrap_or(T::ZERO))
}
