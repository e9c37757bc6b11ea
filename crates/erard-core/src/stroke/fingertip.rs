//! Between key and finger: the fingertip is soft, and where force was recorded too, one position gives the other.

use super::{Cursor, ForceSeries, PositionOf, PositionSeries, SHORTEST_STEP_S, SampleError, Series};
use crate::instrument::Finger;

impl Series {
    /// The position of the key's front or of the fingertip, whichever is wanted, when the recorded one is `of` the
    /// other.
    ///
    /// The fingertip is ahead of the key by its compression: F/k, which its damper lets follow with the time constant
    /// c/k (k d + c d' = F with d the difference, the finger's own law). `None` where there is no position, or where
    /// the other one is wanted and no force was recorded. The position of the key's back counts as the key's.
    ///
    /// # Errors
    /// Where the two together cannot be interpolated.
    pub fn position_of(
        &self,
        wanted: PositionOf,
        of: PositionOf,
        finger: &Finger,
    ) -> Result<Option<PositionSeries>, SampleError> {
        let Some(position) = &self.position else { return Ok(None) };
        let is_key = |one: PositionOf| one != PositionOf::Fingertip;
        if is_key(wanted) == is_key(of) {
            return Ok(Some(position.clone()));
        }
        let Some(force) = &self.force else { return Ok(None) };
        let sign = if wanted == PositionOf::Fingertip { 1.0 } else { -1.0 };
        let times = merged(position.times_s(), force.times_s());
        let given_way = compression(force, &times, finger);
        let mut cursor = Cursor::default();
        let positions = times.iter().zip(given_way).map(|(&t, d)| position.at(t, &mut cursor).0 + sign * d).collect();
        PositionSeries::new(times, positions).map(Some)
    }
}

/// All instants of two axes, s, those once that both have.
fn merged(a: &[f64], b: &[f64]) -> Vec<f64> {
    let mut times = [a, b].concat();
    times.sort_unstable_by(f64::total_cmp);
    times.dedup_by(|later, earlier| *later - *earlier < SHORTEST_STEP_S);
    times
}

/// How far the fingertip is pressed in at these instants, m, by a force that only pushes; at rest before the first one.
fn compression(force: &ForceSeries, times: &[f64], finger: &Finger) -> Vec<f64> {
    let (k, tau) = (finger.stiffness_n_per_m, finger.damping_n_s_per_m / finger.stiffness_n_per_m);
    let mut cursor = Cursor::default();
    let mut last: Option<[f64; 3]> = None;
    times
        .iter()
        .map(|&t| {
            let f = force.at(t, &mut cursor).max(0.0) / k;
            let d = match last {
                Some([t0, f0, d0]) if tau > 0.0 => {
                    // Exact for a force that changes linearly from instant to instant.
                    let lag = tau * (f - f0) / (t - t0);
                    f - lag + (d0 - f0 + lag) * libm::exp(-(t - t0) / tau)
                }
                _ => f,
            };
            last = Some([t, f, d]);
            d
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const FINGER: Finger = Finger { stiffness_n_per_m: 2e4, damping_n_s_per_m: 20.0 };

    fn held(force_n: f64) -> Series {
        let times = vec![0.0, 0.001, 0.5, 1.0];
        Series {
            force: Some(ForceSeries::new(times.clone(), vec![0.0, force_n, force_n, force_n]).unwrap()),
            position: Some(PositionSeries::new(times, vec![0.0, 0.0, 0.01, 0.01]).unwrap()),
            hammer_head: None,
            hammer_speed: None,
        }
    }

    /// 4 N on 20 N/mm is 0.2 mm, long after its start; and back again.
    #[test]
    fn a_held_force_presses_the_fingertip_in() {
        let series = held(4.0);
        let tip = series.position_of(PositionOf::Fingertip, PositionOf::Key, &FINGER).unwrap().unwrap();
        let at = |s: &PositionSeries, t| s.at(t, &mut Cursor::default()).0;
        assert!((at(&tip, 1.0) - 0.0102).abs() < 1e-12, "{}", at(&tip, 1.0));
        let back = Series { position: Some(tip), ..series.clone() };
        let key = back.position_of(PositionOf::Key, PositionOf::Fingertip, &FINGER).unwrap().unwrap();
        for t in [0.0, 0.001, 0.5, 1.0] {
            assert!((at(&key, t) - at(series.position.as_ref().unwrap(), t)).abs() < 1e-12);
        }
    }

    /// A step of force: 1 - exp(-t/tau) of it, the closed form of the spring and damper.
    #[test]
    fn the_damper_lets_it_follow() {
        let times: Vec<f64> = (0..400).map(|n| f64::from(n) * 5e-5).collect();
        let force = ForceSeries::new(times.clone(), times.iter().map(|_| 2.0).collect()).unwrap();
        // At rest under the force from the start: nothing moves.
        assert!(compression(&force, &times, &FINGER).iter().all(|d| (d - 1e-4).abs() < 1e-15));
        let ramp = ForceSeries::new(times.clone(), times.iter().map(|t| 100.0 * t).collect()).unwrap();
        for (t, d) in times.iter().zip(compression(&ramp, &times, &FINGER)) {
            // d = (F' / k) (t - tau (1 - exp(-t/tau)))
            let exact = 100.0 / 2e4 * (t - 1e-3 * (1.0 - (-t / 1e-3).exp()));
            assert!((d - exact).abs() < 2e-9, "{t}: {d} {exact}");
        }
    }

    #[test]
    fn without_force_nothing_is_known_of_the_other() {
        let series = Series { force: None, ..held(1.0) };
        let of = |wanted, of| series.position_of(wanted, of, &FINGER).unwrap();
        assert_eq!(of(PositionOf::Fingertip, PositionOf::Key), None);
        assert_eq!(of(PositionOf::Key, PositionOf::Key), series.position);
    }
}
