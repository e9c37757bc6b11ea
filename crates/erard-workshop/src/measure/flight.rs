//! Free flight of the hammer, counted twice: from the last push on the knuckle, and from the head's largest speed,
//! which papers with an accelerometer on the head call escapement.
//!
//! Distance and speed are along the string's normal, upward. At the constant speed of the impact, the head would take
//! distance / speed; gravity and the shank, which still swings, make the difference.

use erard::run::Events;
use serde::Serialize;

/// A flight from one instant to the string.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Flight {
    /// Distance of the head from the string, mm.
    pub way_mm: f64,
    /// Time of flight from there, ms.
    pub time_ms: f64,
    /// Time of flight at the constant speed of the impact, ms.
    pub at_constant_speed_ms: f64,
}

/// Flights of one stroke; `None` if the hammer did not reach the string.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Flights {
    /// Speed of the head along the string's normal as it meets the string, m/s.
    pub speed_m_per_s: f64,
    /// Largest speed of the head before the impact, m/s.
    pub largest_speed_m_per_s: f64,
    /// Flight from the last push on the knuckle; `None` if jack and lever pushed until the impact.
    pub from_last_push: Option<Flight>,
    /// Flight from the largest speed.
    pub from_largest_speed: Flight,
}

/// Returns the flights of a run from its times t, s, and the head's rises y, m, of every step.
pub(crate) fn flights(t: &[f64], y: &[f64], events: &Events) -> Option<Flights> {
    let contact_s = events.hammer_contact_s()?;
    let last = t.partition_point(|&t| t <= contact_s).min(y.len()).checked_sub(1)?;
    let speed = |i: usize| (y[i] - y[i - 1]) / (t[i] - t[i - 1]);
    let largest = (1..=last).max_by(|&a, &b| speed(a).total_cmp(&speed(b)))?;
    // The last row before the impact and the one before it: without string force.
    let speed_m_per_s = speed(last);
    let string_m = y[last] + speed_m_per_s * (contact_s - t[last]);
    let from = |at_s: f64| {
        let row = t.partition_point(|&t| t <= at_s).clamp(1, last);
        let way_m = string_m - (y[row] + speed(row) * (at_s - t[row]));
        Flight {
            way_mm: way_m * 1e3,
            time_ms: (contact_s - at_s) * 1e3,
            at_constant_speed_ms: way_m / speed_m_per_s * 1e3,
        }
    };
    let from_last_push = events.let_off_s.filter(|&at_s| at_s < contact_s).map(from);
    Some(Flights {
        speed_m_per_s,
        largest_speed_m_per_s: speed(largest),
        from_last_push,
        from_largest_speed: from(0.5 * (t[largest] + t[largest - 1])),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use erard::Impact;

    /// A head thrown up: uniform speed to 30 ms, then gravity alone.
    #[test]
    fn a_throw_is_what_the_closed_form_says() {
        let (v, g, off, impact) = (1.0, 9.81, 0.030, 0.032);
        let height = |t: f64| if t < off { v * t } else { v * t - 0.5 * g * (t - off) * (t - off) };
        let time_s: Vec<f64> = (0..=700).map(|i| f64::from(i) * 50e-6).collect();
        let head_m: Vec<f64> = time_s.iter().map(|&t| height(t)).collect();
        let impacts = vec![Impact { time_s: impact, hammer_speed_m_per_s: 1.0, hammer_speed_normal_m_per_s: 1.0 }];
        let events = Events { let_off_s: Some(off), impacts, ..Events::default() };
        let found = flights(&time_s, &head_m, &events).unwrap();
        let near = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-3, "{found} {expected}");
        near(found.speed_m_per_s, v - g * (impact - off));
        near(found.largest_speed_m_per_s, v);
        let flight = found.from_last_push.unwrap();
        near(flight.time_ms, 2.0);
        near(flight.way_mm, (height(impact) - height(off)) * 1e3);
        near(flight.at_constant_speed_ms, flight.way_mm / (v - g * (impact - off)));
        assert!(found.from_largest_speed.time_ms >= 2.0 - 0.05);
    }
}
