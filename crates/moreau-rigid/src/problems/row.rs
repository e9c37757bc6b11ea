//! A row: a quantity of a problem, what it should be, what it is.

/// Known answer for a quantity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Expected {
    /// Its value, and how far ours may be from it.
    Near {
        /// The known value.
        value: f64,
        /// Largest error.
        tolerance: f64,
    },
    /// An upper bound.
    AtMost(f64),
    /// A lower bound.
    AtLeast(f64),
}

/// A quantity, what is known about it, and ours.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// Name of the quantity, with the settings that matter.
    pub quantity: String,
    /// Unit; empty for pure numbers.
    pub unit: &'static str,
    /// Known answer.
    pub expected: Expected,
    /// Result of the engine; not a number if a step failed.
    pub ours: f64,
    /// Why the tolerance or the bound is what it is.
    pub because: &'static str,
}

impl Row {
    /// A row with a known value.
    pub fn new(
        quantity: impl Into<String>,
        unit: &'static str,
        value: f64,
        ours: f64,
        tolerance: f64,
        because: &'static str,
    ) -> Self {
        Row { quantity: quantity.into(), unit, expected: Expected::Near { value, tolerance }, ours, because }
    }

    /// A row with a bound: work that must not grow, or that must be needed.
    pub fn bounded(quantity: &str, expected: Expected, ours: f64, because: &'static str) -> Self {
        Row { quantity: quantity.into(), unit: "", expected, ours, because }
    }

    /// Whether ours is what it should be; false for what is not a number.
    #[must_use]
    pub fn holds(&self) -> bool {
        match self.expected {
            Expected::Near { value, tolerance } => (self.ours - value).abs() <= tolerance,
            Expected::AtMost(bound) => self.ours <= bound,
            Expected::AtLeast(bound) => self.ours >= bound,
        }
    }
}

/// Errors at falling steps.
#[derive(Debug, Clone, PartialEq)]
pub struct Order {
    /// The steps, s, each a constant part of the one before.
    pub steps: Vec<f64>,
    /// The errors.
    pub errors: Vec<f64>,
}

impl Order {
    /// Errors at `count` steps from `first` on, each half of the one before.
    pub fn halving(first: f64, count: i32, error: impl Fn(f64) -> f64) -> Self {
        Self::of(first, (0..count).map(|k| error(first * 0.5_f64.powi(k))).collect())
    }

    /// Errors at steps from `first` on, each half of the one before.
    pub(crate) fn of(first: f64, errors: Vec<f64>) -> Self {
        let steps = (0..errors.len()).map(|k| first * 0.5_f64.powi(k as i32)).collect();
        Order { steps, errors }
    }

    /// Observed order: the mean slope of log(error) over log(step).
    #[must_use]
    pub fn observed(&self) -> f64 {
        let n = self.steps.len() - 1;
        (self.errors[0] / self.errors[n]).ln() / (self.steps[0] / self.steps[n]).ln()
    }
}
