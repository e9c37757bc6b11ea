//! The papers' law, F = k g^r + b g^2 dg/dt, clamped at zero: (C2) of the book. It is a rate part and nothing else.

use super::hook::Law;
use super::number::{DAMPING, LAW_NUMBERS, LawNumber};
use super::rate_part::Form;
use crate::real::Real;

/// F = k g^r + b g^2 dg/dt. The papers call b also p.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quadratic<T> {
    /// b, N s/m3.
    pub damping: T,
}

impl<T: Real> Law<T> for Quadratic<T> {
    const NUMBERS: &'static [LawNumber] = &[DAMPING];

    fn numbers(&self) -> [T; LAW_NUMBERS] {
        [self.damping, T::ZERO, T::ZERO]
    }

    fn with([damping, ..]: [T; LAW_NUMBERS]) -> Self {
        Quadratic { damping }
    }

    fn rate_part(&self) -> Form<T> {
        Form::Square(self.damping)
    }
}
