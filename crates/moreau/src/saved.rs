//! A state taken apart into plain numbers, and put together again.

use crate::broad_phase::BroadPhase;
use crate::real::{Real, Scalar};
use crate::state::State;

/// Everything that a step's result depends on. What a [`State`] holds beside it only saves work.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SavedState<T, const B: usize, const Z: usize> {
    /// Absolute angles, rad.
    pub angle: [T; B],
    /// Absolute angular velocities, rad/s.
    pub velocity: [T; B],
    /// Change of the velocities over the last step, rad/s.
    pub increment: [T; B],
    /// Dry friction torque of each pivot over the last step, N m.
    pub pivot_friction: [T; B],
    /// Coulomb force of each zone over the last step, N.
    pub tangential: [T; Z],
    /// The sign with which each zone's Coulomb force was at its bound over the last step, or 0.
    pub side: [T; Z],
    /// Force of a rigid drive over the last step, N.
    pub rigid_force: T,
    /// What the felts remember.
    pub memory: [T; Z],
    /// How far the pivots' and the zones' friction has grown while it stuck.
    pub pivot_rested: [T; B],
    /// See `pivot_rested`.
    pub rested: [T; Z],
}

impl<T: Real, const B: usize, const Z: usize> SavedState<T, B, Z> {
    /// The same in another size: cut off, or filled up with zeros.
    pub fn sized<const C: usize, const Y: usize>(&self) -> SavedState<T, C, Y> {
        SavedState {
            angle: sized(&self.angle),
            velocity: sized(&self.velocity),
            increment: sized(&self.increment),
            pivot_friction: sized(&self.pivot_friction),
            tangential: sized(&self.tangential),
            side: sized(&self.side),
            rigid_force: self.rigid_force,
            memory: sized(&self.memory),
            pivot_rested: sized(&self.pivot_rested),
            rested: sized(&self.rested),
        }
    }
}

impl<T: Real, const B: usize, const Z: usize> SavedState<T, B, Z> {
    /// The same with bodies and zones in another order: place i takes what place `bodies[i]` has.
    pub fn reordered(&self, bodies: &[usize; B], zones: &[usize; Z]) -> Self {
        SavedState {
            angle: reordered(&self.angle, bodies),
            velocity: reordered(&self.velocity, bodies),
            increment: reordered(&self.increment, bodies),
            pivot_friction: reordered(&self.pivot_friction, bodies),
            tangential: reordered(&self.tangential, zones),
            side: reordered(&self.side, zones),
            rigid_force: self.rigid_force,
            memory: reordered(&self.memory, zones),
            pivot_rested: reordered(&self.pivot_rested, bodies),
            rested: reordered(&self.rested, zones),
        }
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

impl<T: Scalar, const B: usize, const Z: usize> State<T, B, Z> {
    /// The state in plain numbers.
    pub fn save(&self) -> SavedState<T, B, Z> {
        SavedState {
            angle: self.angle,
            velocity: self.velocity,
            increment: self.increment,
            pivot_friction: self.pivot_friction,
            tangential: self.tangential,
            side: self.side,
            rigid_force: self.rigid_force,
            memory: self.memory,
            pivot_rested: self.pivot_rested,
            rested: self.rested,
        }
    }
}

impl<T: Real, const B: usize, const Z: usize> From<SavedState<T, B, Z>> for State<T, B, Z> {
    fn from(saved: SavedState<T, B, Z>) -> Self {
        State {
            angle: saved.angle,
            velocity: saved.velocity,
            increment: saved.increment,
            pivot_friction: saved.pivot_friction,
            tangential: saved.tangential,
            rigid_force: saved.rigid_force,
            side: saved.side,
            memory: saved.memory,
            pivot_rested: saved.pivot_rested,
            rested: saved.rested,
            broad_phase: BroadPhase::none(),
        }
    }
}
