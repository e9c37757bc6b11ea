//! The papers' law, and beside it one slider in series with a spring, so that a held felt gives to small changes of its
//! load.
//!
//! A cold path: a mechanism without such felts pays nothing for it.

use super::hook::{Law, Memory, Pressing};
use super::number::{DAMPING, LAW_NUMBERS, LawNumber, Range};
use super::rate_part::Form;
use super::set_valued::ETA;
use super::slider::{Slider, curvature, effective_exponent, load_state, press, stored_energy};
use super::spring::{Curvature, Pressed, Spring};
use crate::real::Real;

/// F = k g^r + b g^2 dg/dt, and one slider of bound eta k g^r in series with a spring. The memory is the stretch of the
/// slider's spring, m^((r+1)/2).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Elastoplastic<T> {
    /// b, N s/m3.
    pub damping: T,
    /// eta, 1, below 1: the slider's bound as a part of k g^r.
    pub eta: T,
    /// The spring's stretch at which the slider gives, as a part of x = g^((r+1)/2); 1, above 0 and below 1. As it goes
    /// to 0 the law goes to [`SetValued`](super::SetValued).
    pub slip: T,
}

impl<T: Real> Elastoplastic<T> {
    #[inline(always)]
    fn sliders(&self) -> [Slider<T>; 1] {
        [Slider { ratio: self.eta / self.slip, slip: self.slip }]
    }
}

impl<T: Real> Law<T> for Elastoplastic<T> {
    const NUMBERS: &'static [LawNumber] = &[
        DAMPING,
        ETA,
        LawNumber::needed("slip", "dry_slip", "1", Range::InnerPart).means(
            "Elastic part s of the dry loss, above 0 and below 1 (in files from 0.001 to 0.99): the felt yields \
             elastically by the part s of g^((r+1)/2) before the loss slips, so a held felt can still vibrate a \
             little. Requires `dry_loss`.",
        ),
    ];
    const REMEMBERS: usize = 1;

    fn numbers(&self) -> [T; LAW_NUMBERS] {
        [self.damping, self.eta, self.slip]
    }

    fn with([damping, eta, slip]: [T; LAW_NUMBERS]) -> Self {
        Elastoplastic { damping, eta, slip }
    }

    fn rate_part(&self) -> Form<T> {
        Form::Square(self.damping)
    }

    fn largest(&self) -> T {
        T::ONE + self.eta
    }

    fn effective_exponent(&self, exponent: T) -> T {
        effective_exponent(&self.sliders(), exponent)
    }

    #[inline(always)]
    fn press(&self, spring: &Spring<T>, pressing: &Pressing<'_, T>, memory: &Memory<T>) -> Pressed<T> {
        press(&self.sliders(), self.damping, spring, pressing, memory)
    }

    #[inline(always)]
    fn curvature(&self, spring: &Spring<T>, pressing: &Pressing<'_, T>, memory: &Memory<T>) -> Curvature<T> {
        curvature(&self.sliders(), self.damping, spring, pressing, memory)
    }

    #[inline(always)]
    fn load_state(&self, spring: &Spring<T>, pressing: &Pressing<'_, T>, memory: &Memory<T>) -> Memory<T> {
        load_state(&self.sliders(), spring, pressing, memory)
    }

    #[inline(always)]
    fn stored_energy(&self, spring: &Spring<T>, _: T, memory: &Memory<T>) -> T {
        stored_energy(&self.sliders(), spring, memory)
    }
}
