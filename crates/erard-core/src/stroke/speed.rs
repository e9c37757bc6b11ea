//! A recorded speed: straight lines between its samples.

use super::{Cursor, SampleError, check_samples};

/// A speed sampled at increasing instants, m/s.
#[derive(Debug, Clone, PartialEq)]
pub struct SpeedSeries {
    times: Vec<f64>,
    values: Vec<f64>,
}

impl SpeedSeries {
    /// A series of instants, s, and speeds, m/s.
    ///
    /// # Errors
    /// [`SampleError`]: fewer than two, not as many, not increasing, or not finite.
    pub fn new(times_s: Vec<f64>, speeds_m_per_s: Vec<f64>) -> Result<Self, SampleError> {
        check_samples(&times_s, &speeds_m_per_s)?;
        Ok(SpeedSeries { times: times_s, values: speeds_m_per_s })
    }

    /// The instants, s.
    pub fn times_s(&self) -> &[f64] {
        &self.times
    }

    /// The speeds at these, m/s.
    pub fn speeds_m_per_s(&self) -> &[f64] {
        &self.values
    }

    /// The speed at an instant, m/s; that of the first sample before it, that of the last one after it.
    pub fn at(&self, t: f64, cursor: &mut Cursor) -> f64 {
        let last = self.times.len() - 1;
        if t <= self.times[0] {
            return self.values[0];
        }
        if t >= self.times[last] {
            return self.values[last];
        }
        let i = cursor.seek(&self.times, t);
        let share = (t - self.times[i]) / (self.times[i + 1] - self.times[i]);
        self.values[i] + share * (self.values[i + 1] - self.values[i])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn straight_lines_between_samples() {
        let series = SpeedSeries::new(vec![0.0, 1.0, 3.0], vec![0.0, 2.0, -2.0]).unwrap();
        let mut cursor = Cursor::default();
        for (t, speed) in [(-1.0, 0.0), (0.5, 1.0), (1.0, 2.0), (2.0, 0.0), (2.5, -1.0), (4.0, -2.0), (0.25, 0.5)] {
            assert_eq!(series.at(t, &mut cursor), speed, "{t}");
        }
        assert!(SpeedSeries::new(vec![0.0, 0.0], vec![1.0, 1.0]).is_err());
    }
}
