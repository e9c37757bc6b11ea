//! A reason to doubt a fit.

/// A reason to doubt a fit.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Doubt {
    /// Kind of doubt.
    pub kind: DoubtKind,
    /// The doubt and its meaning, in a sentence without a full stop.
    pub text: String,
}

/// Kinds of doubt, in the order in which they are reported.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum DoubtKind {
    /// The recording's hammer reaches the string; the fitted model's does not.
    NoImpact,
    /// The residuals exceed what the noise of sensor and drive explains, or differ from noise by their course.
    Misfit,
    /// The noise is correlated over so long a time that the recordings are too short for errors.
    TooShort,
    /// A parameter ended at a bound.
    Bound,
    /// Attempts from several starts ended at different places.
    Restarts,
    /// Data continue beyond the first impact.
    BeyondImpact,
    /// Derivatives depend on their difference step.
    Derivatives,
    /// Unknown noise of a column. For a driving column it then counts as zero; for a compared column it is estimated
    /// from the residuals.
    NoiseUnknown,
    /// A recording has suspicious features.
    Recording,
}

impl DoubtKind {
    /// Returns the name in files and in Python.
    pub fn name(self) -> &'static str {
        match self {
            DoubtKind::NoImpact => "no_impact",
            DoubtKind::Misfit => "misfit",
            DoubtKind::TooShort => "too_short",
            DoubtKind::Bound => "bound",
            DoubtKind::Restarts => "restarts",
            DoubtKind::BeyondImpact => "beyond_impact",
            DoubtKind::Derivatives => "derivatives",
            DoubtKind::NoiseUnknown => "noise_unknown",
            DoubtKind::Recording => "recording",
        }
    }
}
