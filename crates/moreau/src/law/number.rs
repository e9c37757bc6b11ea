//! One number of a contact law, as its law's constant table says it: from these tables come the engine's checks, and
//! the reader, the schema and the messages of whoever writes laws into files.

use crate::fault::Fault;
use crate::real::Scalar;

/// Most numbers that a law has beside the spring's.
pub const LAW_NUMBERS: usize = 3;

/// A number of a contact law.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct LawNumber {
    /// Its name in the description, e.g. `damping`.
    pub name: &'static str,
    /// Its key in files, the unit at the end, e.g. `damping_N_s_per_m3`.
    pub key: &'static str,
    /// The key's unit; `1` for a number without one.
    pub unit: &'static str,
    /// Number of these units in one of the engine's: 1000 for ms.
    pub units_per_si: f64,
    /// Allowed range, in the engine's units.
    pub range: Range,
    /// Whether a law that is written down must say it. One that need not be said is 0 then.
    pub needed: bool,
    /// Whether more of it is more loss.
    pub is_loss: bool,
    /// Meaning, in a sentence or two.
    pub meaning: &'static str,
}

/// Allowed range of a number.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Range {
    /// From 0 to the given number.
    UpTo(f64),
    /// From the first number, above 0, to the second.
    Between(f64, f64),
    /// From 0 to below 1.
    Part,
    /// Above 0 and below 1.
    InnerPart,
}

impl LawNumber {
    /// A number that must be said, in the engine's units.
    pub(crate) const fn needed(name: &'static str, key: &'static str, unit: &'static str, range: Range) -> Self {
        LawNumber { name, key, unit, units_per_si: 1.0, range, needed: true, is_loss: false, meaning: "" }
    }

    /// More of it is more loss.
    pub(crate) const fn loss(self) -> Self {
        LawNumber { is_loss: true, ..self }
    }

    /// It is 0 where it is not said.
    pub(crate) const fn optional(self) -> Self {
        LawNumber { needed: false, ..self }
    }

    pub(crate) const fn units_per_si(self, units_per_si: f64) -> Self {
        LawNumber { units_per_si, ..self }
    }

    pub(crate) const fn means(self, meaning: &'static str) -> Self {
        LawNumber { meaning, ..self }
    }

    /// What is wrong with it, if anything. How large a number with a unit may be is for its reader to say.
    pub(crate) fn fault<T: Scalar>(&self, x: T) -> Option<Fault> {
        match self.range {
            Range::UpTo(_) => Fault::negative(self.name, x),
            Range::Between(..) => Fault::not_positive(self.name, x),
            Range::Part => Fault::not_a_part(self.name, x),
            Range::InnerPart => Fault::not_a_part(self.name, x).or_else(|| Fault::not_positive(self.name, x)),
        }
    }
}

/// b of the papers' law, which other losses may be combined with.
pub(crate) const DAMPING: LawNumber = LawNumber::needed("damping", "damping_N_s_per_m3", "N s/m3", Range::UpTo(1e18))
    .loss()
    .optional()
    .means("Damping b of F = k g^r + b g^2 dg/dt, N s/m3; 0 when absent.");
