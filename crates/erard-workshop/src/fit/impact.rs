//! Time of the first impact in a recording of the hammer.

use super::Data;

/// The hammer's speed before and after is measured over this time, s, and over at least `MIN_SAMPLES` samples.
const SPEED_OVER_S: f64 = 2e-3;
const MIN_SAMPLES: usize = 4;
/// A string changes the hammer's speed by more than this within that time, m/s. Gravity changes it by 0.04, springs and
/// felts under a freely flying hammer not at all.
const TURNED_M_PER_S: f64 = 0.15;
/// A reversal must also exceed this many standard deviations of noise.
const CHANCE: f64 = 6.0;

impl Data {
    /// Time at which the string first threw the recorded hammer back, s; `None` if it never did or the hammer was not
    /// recorded.
    pub(super) fn recorded_impact_s(&self) -> Option<f64> {
        let series = &self.prepared.series;
        if let Some(path) = &series.hammer_head {
            let noise = self.noise("hammer_rise_m").unwrap_or(0.0);
            return thrown_back_s(path.times_s(), path.positions_m(), noise);
        }
        // The noise of the integrated speed is small.
        let speed = series.hammer_speed.as_ref()?;
        let (times, speeds) = (speed.times_s(), speed.speeds_m_per_s());
        let mut rise = vec![0.0];
        for (k, pair) in speeds.windows(2).enumerate() {
            rise.push(rise[k] + 0.5 * (pair[0] + pair[1]) * (times[k + 1] - times[k]));
        }
        thrown_back_s(times, &rise, 0.0)
    }
}

/// Time at which a rise is first thrown back; `noise` is its sensor's, m.
fn thrown_back_s(times: &[f64], rise: &[f64], noise: f64) -> Option<f64> {
    let turn = |n: usize| {
        let from = times.partition_point(|t| *t < times[n] - SPEED_OVER_S).min((n + 1).saturating_sub(MIN_SAMPLES));
        let to = times.partition_point(|t| *t <= times[n] + SPEED_OVER_S).max(n + MIN_SAMPLES);
        if to > times.len() || n + 1 < MIN_SAMPLES {
            return None;
        }
        let (before, unsure) = slope(&times[from..=n], &rise[from..=n]);
        let (after, also) = slope(&times[n..to], &rise[n..to]);
        let turned = before - after;
        let beyond = TURNED_M_PER_S + CHANCE * noise * unsure.hypot(also);
        (before > 0.0 && after < 0.0 && turned > beyond).then_some(turned)
    };
    let turns: Vec<Option<f64>> = (0..times.len()).map(turn).collect();
    // First run of instants with a reversal; the largest in it.
    let first = turns.iter().position(Option::is_some)?;
    let stretch = turns[first..].iter().map_while(|turn| *turn);
    let largest = stretch.enumerate().max_by(|a, b| a.1.total_cmp(&b.1))?;
    Some(times[first + largest.0])
}

/// Slope of the straight line through some samples, and its standard deviation per unit noise of a sample.
fn slope(times: &[f64], values: &[f64]) -> (f64, f64) {
    let count = times.len() as f64;
    let (middle, mean) = (times.iter().sum::<f64>() / count, values.iter().sum::<f64>() / count);
    let squares: f64 = times.iter().map(|t| (t - middle).powi(2)).sum();
    let products: f64 = times.iter().zip(values).map(|(t, x)| (t - middle) * (x - mean)).sum();
    (products / squares, squares.powf(-0.5))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::data::normal;
    use fastrand::Rng;

    /// A hammer thrown back at half its speed by a string that holds it for 2 ms, or in free flight.
    fn rise(speed: f64, string: bool, rate_hz: f64, noise: f64) -> (Vec<f64>, Vec<f64>) {
        let mut rng = Rng::with_seed(4);
        let times: Vec<f64> = (0..(0.2 * rate_hz) as usize).map(|n| n as f64 / rate_hz).collect();
        let at = |t: f64| {
            let flown = t - 0.1;
            if string && flown > 2e-3 {
                speed * 2e-3 * 0.25 - 0.5 * speed * (flown - 2e-3)
            } else if string && flown > 0.0 {
                // From speed to minus half of it, at constant deceleration.
                speed * flown - 0.75 * speed / 2e-3 * flown * flown
            } else {
                speed * flown - 5.0 * flown.max(0.0).powi(2)
            }
        };
        let values = times.iter().map(|t| at(*t) + noise * normal(&mut rng)).collect();
        (times, values)
    }

    /// Impacts are found to a millisecond at usual rates and sensor noise; free flight is no impact.
    #[test]
    fn a_string_is_seen_and_flight_is_not() {
        for (speed, rate_hz, noise) in [(0.5, 4000.0, 0.0), (0.5, 4000.0, 50e-6), (3.0, 1000.0, 50e-6)] {
            let (times, values) = rise(speed, true, rate_hz, noise);
            let seen = thrown_back_s(&times, &values, noise).unwrap();
            assert!((seen - 0.1).abs() < 2e-3, "{speed} {rate_hz}: {seen}");
            let (times, values) = rise(0.3, false, rate_hz, noise);
            assert_eq!(thrown_back_s(&times, &values, noise), None, "{speed} {rate_hz}");
        }
    }
}
