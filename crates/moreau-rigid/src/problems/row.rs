//! Row of results: a quantity of a problem, its known value, and the engine's value.

/// Known answer for a quantity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Expected {
    /// A known value with a tolerance.
    Near {
        /// The known value.
        value: f64,
        /// Largest error accepted.
        tolerance: f64,
    },
    /// An upper bound.
    AtMost(f64),
    /// A lower bound.
    AtLeast(f64),
}

/// Quantity of a problem, with its known answer and the engine's result.
#[derive(Debug, Clone, PartialEq)]
pub struct ProblemRow {
    /// Name of the quantity, with the relevant settings.
    pub quantity: String,
    /// Unit; empty for dimensionless numbers.
    pub unit: &'static str,
    /// Known answer.
    pub expected: Expected,
    /// Result of the engine; NaN if a step failed.
    pub ours: f64,
    /// Reason for the tolerance or bound.
    pub because: &'static str,
}

impl ProblemRow {
    /// Returns a row with a known value.
    pub fn new(
        quantity: impl Into<String>,
        unit: &'static str,
        value: f64,
        ours: f64,
        tolerance: f64,
        because: &'static str,
    ) -> Self {
        ProblemRow { quantity: quantity.into(), unit, expected: Expected::Near { value, tolerance }, ours, because }
    }

    /// Returns a row with a bound, e.g. on work that must not grow or that must occur.
    pub fn bounded(quantity: &str, expected: Expected, ours: f64, because: &'static str) -> Self {
        ProblemRow { quantity: quantity.into(), unit: "", expected, ours, because }
    }

    /// Returns whether the result agrees with the known answer; false for NaN.
    #[must_use]
    pub fn holds(&self) -> bool {
        match self.expected {
            Expected::Near { value, tolerance } => (self.ours - value).abs() <= tolerance,
            Expected::AtMost(bound) => self.ours <= bound,
            Expected::AtLeast(bound) => self.ours >= bound,
        }
    }
}

/// Errors at decreasing steps.
#[derive(Debug, Clone, PartialEq)]
pub struct Order {
    /// Steps, s; each is the previous one times a constant factor.
    pub steps: Vec<f64>,
    /// Error at each step.
    pub errors: Vec<f64>,
}

impl Order {
    /// Computes errors at `count` steps from `first` (s) on, each half of the previous one.
    pub fn halving(first: f64, count: i32, error: impl Fn(f64) -> f64) -> Self {
        Self::of(first, (0..count).map(|k| error(first * 0.5_f64.powi(k))).collect())
    }

    /// Errors at steps from `first` on, each half of the one before.
    #[must_use]
    pub fn of(first: f64, errors: Vec<f64>) -> Self {
        let steps = (0..errors.len()).map(|k| first * 0.5_f64.powi(k as i32)).collect();
        Order { steps, errors }
    }

    /// Returns the observed order: the mean slope of log(error) over log(step).
    #[must_use]
    pub fn observed(&self) -> f64 {
        let n = self.steps.len() - 1;
        (self.errors[0] / self.errors[n]).ln() / (self.steps[0] / self.steps[n]).ln()
    }
}
