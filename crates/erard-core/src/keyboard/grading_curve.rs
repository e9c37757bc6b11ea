//! A quantity over the keyboard.

use crate::instrument::Citation;

/// A point of a curve.
#[derive(Debug, Clone, PartialEq)]
pub struct GradingPoint {
    /// Number of the key, 1 to 88.
    pub key: usize,
    /// The quantity there, in the unit that the curve's name in the file ends with.
    pub value: f64,
    /// Source of the number; `None` for a bare one.
    pub citation: Option<Citation>,
}

/// Interpolation of a curve between its points.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Between {
    /// Along a straight line.
    Linear,
    /// Along a straight line of the logarithm: for ratios, so that halving and doubling are alike.
    Logarithmic,
}

/// A quantity over the number of the key: points, joined by straight lines; level before the first and after the last.
#[derive(Debug, Clone, PartialEq)]
pub struct GradingCurve {
    /// At least one, of ascending keys.
    pub points: Vec<GradingPoint>,
    /// Between them.
    pub between: Between,
}

impl GradingCurve {
    /// The quantity at a key.
    #[must_use]
    pub fn at(&self, key: usize) -> f64 {
        let after = self.points.partition_point(|p| p.key < key);
        match (after.checked_sub(1).map(|before| &self.points[before]), self.points.get(after)) {
            (_, Some(p)) if p.key == key => p.value,
            (Some(a), Some(b)) => {
                let share = (key - a.key) as f64 / (b.key - a.key) as f64;
                match self.between {
                    Between::Linear => a.value + share * (b.value - a.value),
                    Between::Logarithmic => a.value * libm::pow(b.value / a.value, share),
                }
            }
            (Some(p), None) | (None, Some(p)) => p.value,
            (None, None) => f64::NAN,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(between: Between, points: &[(usize, f64)]) -> GradingCurve {
        let points = points.iter().map(|&(key, value)| GradingPoint { key, value, citation: None }).collect();
        GradingCurve { points, between }
    }

    #[test]
    fn straight_between_the_points_and_level_beyond() {
        let line = curve(Between::Linear, &[(20, 1.0), (40, 0.0), (60, -4.0)]);
        let at = [1, 20, 30, 40, 45, 60, 88].map(|key| line.at(key));
        assert_eq!(at, [1.0, 1.0, 0.5, 0.0, -1.0, -4.0, -4.0]);
        let ratio = curve(Between::Logarithmic, &[(40, 1.0), (60, 4.0)]);
        let at = [20, 40, 50, 60].map(|key| ratio.at(key));
        assert_eq!(at, [1.0, 1.0, 2.0, 4.0]);
    }
}
