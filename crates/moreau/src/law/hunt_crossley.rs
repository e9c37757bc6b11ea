//! F = k g^r (1 + a dg/dt), clamped at zero: (C5) of the book. K. H. Hunt and F. R. E. Crossley, *Coefficient of
//! restitution interpreted as damping in vibroimpact*, Journal of Applied Mechanics 42 (1975) 440-445. It is a rate
//! part and nothing else.

use super::hook::Law;
use super::number::{LAW_NUMBERS, LawNumber, Range};
use super::rate_part::Form;
use crate::real::Real;

/// F = k g^r (1 + a dg/dt) (K. H. Hunt and F. R. E. Crossley, J. Appl. Mech. 42 (1975) 440-445).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HuntCrossley<T> {
    /// a, s/m.
    pub rate: T,
}

impl<T: Real> Law<T> for HuntCrossley<T> {
    const NUMBERS: &'static [LawNumber] =
        &[LawNumber::needed("hunt_crossley", "hunt_crossley_s_per_m", "s/m", Range::UpTo(1e6))
            .loss()
            .means("Loss a of Hunt and Crossley: F = k g^r (1 + a dg/dt), s/m. It replaces `damping_N_s_per_m3`.")];

    fn numbers(&self) -> [T; LAW_NUMBERS] {
        [self.rate, T::ZERO, T::ZERO]
    }

    fn with([rate, ..]: [T; LAW_NUMBERS]) -> Self {
        HuntCrossley { rate }
    }

    fn rate_part(&self) -> Form<T> {
        Form::Proportional(self.rate)
    }
}
