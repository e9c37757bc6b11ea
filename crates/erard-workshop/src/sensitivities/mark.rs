//! Remarks on derivatives, and the steps from which they follow.

/// Steps of the differentiated press, as shares of the stroke's own.
pub(super) const SHARES: [f64; 3] = [0.5, 0.4, 0.25];
/// Error of the middle one of three derivatives in steps of [`SHARES`], in units of half their range, if it is in
/// proportion to the step.
pub(super) const STEP_ERROR: f64 = 2.0 * SHARES[1] / (SHARES[0] - SHARES[2]);

/// Remark on a derivative.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mark {
    /// No remark.
    None,
    /// Derivatives differ between step lengths: there is none.
    Unconverged,
    /// Differences to the two sides have different slopes: the solution jumps or has a corner within the window.
    Jumps,
    /// Differences over the window disagree with the derivative, and those over a narrower one agree: it holds for a
    /// smaller neighbourhood only.
    Local,
    /// Differences over the window disagree with the derivative, and those over a wider one agree: no switch of
    /// friction or contact moves by a whole step over the narrow one.
    Steps,
    /// Differences disagree with the derivative over every window.
    Apart,
    /// The number cannot be changed to both sides.
    OneSided,
}

impl Mark {
    /// Returns the name in results; empty for none.
    pub fn name(self) -> &'static str {
        match self {
            Mark::None => "",
            Mark::Unconverged => "unconverged",
            Mark::Jumps => "jumps",
            Mark::Local => "local",
            Mark::Steps => "steps",
            Mark::Apart => "apart",
            Mark::OneSided => "one-sided",
        }
    }
}
