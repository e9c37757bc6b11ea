//! The contract between the engine and a contact law: the engine asks nothing else of it. `../law_contract.rs` holds
//! every law to it.
//!
//! A law's force over a step is its rate part ([`RatePart`]: what depends on compression and rate now), or, where it
//! has a memory, what [`Law::press`] says in its place. Both are mean forces along the step's straight path in g. Every
//! iteration asks for the force, a step's end for the memory, and the exact acceptance test alone for the curvature.

use super::number::{LAW_NUMBERS, LawNumber};
use super::rate_part::Form;
use super::spring::{Curvature, Pressed, Spring};
use crate::real::Real;
use crate::timing::Timing;

/// Most numbers that a law carries from step to step.
pub const MEMORY: usize = 4;

/// What a law remembers; zeros beyond what it uses, and in a felt that was never pressed.
pub(crate) type Memory<T> = [T; MEMORY];

/// A contact law: one file; `mod.rs` names it.
pub(crate) trait Law<T: Real>: Copy {
    /// Its numbers beside the spring's.
    const NUMBERS: &'static [LawNumber];
    /// Numbers of its internal state, at most [`MEMORY`].
    const REMEMBERS: usize = 0;

    /// Its numbers' values in the order of [`Law::NUMBERS`], filled up with zeros.
    fn numbers(&self) -> [T; LAW_NUMBERS];

    /// The law with these numbers.
    fn with(numbers: [T; LAW_NUMBERS]) -> Self;

    /// The loss that is a function of compression and rate now.
    fn rate_part(&self) -> Form<T> {
        Form::Square(T::ZERO)
    }

    /// eta of a loss F_n eta Sign(dg/dt) beside the rate part F_n. A set-valued force is an unknown of the one-step
    /// problem, as Coulomb's is, and no function of the path: `dry_felts.rs` solves it, and the law's memory is its
    /// force.
    fn set_valued(&self) -> Option<T> {
        None
    }

    /// The law's largest force over its rate part's.
    fn largest(&self) -> T {
        T::ONE
    }

    /// By how much more sharply than the spring k g^r the law may bend, for the exponent r.
    fn effective_exponent(&self, exponent: T) -> T {
        let _ = exponent;
        T::ONE
    }

    /// Force and tangent. This, [`Law::bend`] and [`Law::recall`] are asked only of laws with a memory.
    #[inline(always)]
    fn press(&self, spring: &Spring<T>, pressing: &Pressing<'_, T>, memory: &Memory<T>) -> Pressed<T> {
        let _ = (spring, pressing, memory);
        Pressed::nothing()
    }

    /// How the force of [`Law::press`] bends away from its tangent.
    #[inline(always)]
    fn curvature(&self, spring: &Spring<T>, pressing: &Pressing<'_, T>, memory: &Memory<T>) -> Curvature<T> {
        let _ = (spring, pressing, memory);
        Curvature::nothing()
    }

    /// The memory at the step's end.
    #[inline(always)]
    fn load_state(&self, spring: &Spring<T>, pressing: &Pressing<'_, T>, memory: &Memory<T>) -> Memory<T> {
        let _ = (spring, pressing, memory);
        [T::ZERO; MEMORY]
    }

    /// The memory after a step in which the felt was not touched.
    #[inline(always)]
    fn relax(&self, timing: &Timing<T>, memory: &Memory<T>) -> Memory<T> {
        let _ = (timing, memory);
        [T::ZERO; MEMORY]
    }

    /// The energy that the memory holds beyond the spring's k g^(r+1)/(r+1), J.
    #[inline(always)]
    fn stored_energy(&self, spring: &Spring<T>, compression: T, memory: &Memory<T>) -> T {
        let _ = (spring, compression, memory);
        T::ZERO
    }
}

/// A felt during a step: where and how fast it is at the theta point.
pub(crate) struct Pressing<'a, T: Real> {
    /// g, m, negative apart, and dg/dt, m/s.
    pub compression: T,
    pub rate: T,
    pub timing: &'a Timing<T>,
    /// The lanes in which it is touched during the step.
    pub touched: T::Mask,
}

/// The compression's straight path in a step, m.
pub(crate) struct Path<T> {
    /// At the step's start.
    pub start: T,
    /// Where the part begins over which the force is a mean: for theta = 1/2 the start, for theta = 1 the end.
    pub from: T,
    /// At the step's end.
    pub to: T,
}

impl<T: Real> Pressing<'_, T> {
    #[inline(always)]
    pub(crate) fn path(&self) -> Path<T> {
        let Pressing { compression, rate, timing, .. } = *self;
        let half = timing.step - timing.h_theta;
        Path {
            start: compression.sub_product(timing.h_theta, rate),
            from: compression.sub_product(half, rate),
            to: compression.add_product(half, rate),
        }
    }
}
