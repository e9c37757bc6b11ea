//! State of a mechanism at one instant.

use core::ops::{Deref, DerefMut};

use crate::broad_phase::BroadPhase;
use crate::model::Model;
use crate::real::{Real, Scalar};
use crate::saved::SavedState;

/// State of a mechanism. It dereferences to the numbers that determine the next step ([`SavedState`]). It also holds
/// cached numbers that save work but do not change results.
#[derive(Debug, Clone, PartialEq)]
pub struct State<T: Real, const B: usize, const Z: usize> {
    pub(crate) numbers: SavedState<T, B, Z>,
    /// The zones that may be touched.
    pub(crate) broad_phase: BroadPhase<T, B, Z>,
}

impl<T: Real, const B: usize, const Z: usize> Deref for State<T, B, Z> {
    type Target = SavedState<T, B, Z>;

    #[inline(always)]
    fn deref(&self) -> &Self::Target {
        &self.numbers
    }
}

impl<T: Real, const B: usize, const Z: usize> DerefMut for State<T, B, Z> {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut Self::Target {
        &mut self.numbers
    }
}

impl<T: Real, const B: usize, const Z: usize> From<SavedState<T, B, Z>> for State<T, B, Z> {
    fn from(numbers: SavedState<T, B, Z>) -> Self {
        State { numbers, broad_phase: BroadPhase::none() }
    }
}

impl<T: Scalar, const B: usize, const Z: usize> State<T, B, Z> {
    /// Copies the numbers that determine the next step.
    pub fn save(&self) -> SavedState<T, B, Z> {
        self.numbers
    }
}

impl<T: Real, const B: usize, const Z: usize> State<T, B, Z> {
    /// Returns a state at rest at the given absolute angles, rad.
    pub fn at_rest(angle: [T; B]) -> Self {
        State::from(SavedState::at_rest(angle))
    }

    /// Drops from the contact cache the zones that a new broad phase leaves out.
    #[cold]
    #[inline(never)]
    pub(crate) fn forget_far(&mut self, model: &Model<T, B, Z>) {
        for &z in &model.sliding_zones[..model.sliding_count] {
            if !self.broad_phase.sliding().contains(&z) {
                (self.tangential[z], self.side[z]) = (T::ZERO, T::ZERO);
            }
        }
    }
}
