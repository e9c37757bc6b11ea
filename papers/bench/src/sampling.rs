//! Times by the clock: taken in turn, so that what disturbs the machine disturbs all alike, and given as medians.

use erard::Progress;
use std::time::Instant;

use serde::Serialize;

/// The median of several times, and the quartiles around it, in ns of whatever was counted.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Times {
    /// Half of the times are below it.
    pub median: f64,
    /// A quarter of the times are below it.
    pub lower_quartile: f64,
    /// A quarter of the times are above it.
    pub upper_quartile: f64,
    /// Number of measured times.
    pub samples: usize,
}

impl Times {
    /// Of times in any order.
    ///
    /// # Panics
    /// If there is none.
    pub(crate) fn of(mut ns: Vec<f64>) -> Self {
        ns.sort_unstable_by(f64::total_cmp);
        // Linear between the ranks.
        let quantile = |share: f64| {
            let rank = share * (ns.len() - 1) as f64;
            let (low, high) = (ns[rank.floor() as usize], ns[rank.ceil() as usize]);
            low + (rank - rank.floor()) * (high - low)
        };
        Times {
            median: quantile(0.5),
            lower_quartile: quantile(0.25),
            upper_quartile: quantile(0.75),
            samples: ns.len(),
        }
    }

    /// Distance of the quartiles over the median: how far the clock is to be trusted.
    pub(crate) fn spread(&self) -> f64 {
        (self.upper_quartile - self.lower_quartile) / self.median
    }
}

/// Something to be timed: what it does, and how many things of its kind it then has done.
pub(crate) struct Timed<'a> {
    /// Steps, poses or presses done in one go.
    pub count: f64,
    /// Does them.
    pub go: Box<dyn FnMut() + 'a>,
}

/// Times several things in turn, round after round, after one round that does not count. Time of each per thing done,
/// ns; `None` where `progress`, told the share done, ended the work by returning false.
pub(crate) fn in_turn(rounds: usize, subjects: &mut [Timed<'_>], progress: &mut Progress<'_>) -> Option<Vec<Times>> {
    let mut ns = vec![Vec::with_capacity(rounds); subjects.len()];
    let all = ((rounds + 1) * subjects.len()) as f64;
    for round in 0..=rounds {
        for (index, subject) in subjects.iter_mut().enumerate() {
            if !progress((round * ns.len() + index) as f64 / all) {
                return None;
            }
            let start = Instant::now();
            (subject.go)();
            let elapsed = start.elapsed().as_nanos() as f64;
            if round > 0 {
                ns[index].push(elapsed / subject.count);
            }
        }
    }
    Some(ns.into_iter().map(Times::of).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians_and_quartiles() {
        let times = Times::of(vec![5.0, 1.0, 3.0, 2.0, 4.0]);
        assert_eq!((times.lower_quartile, times.median, times.upper_quartile), (2.0, 3.0, 4.0));
        assert_eq!(Times::of(vec![1.0, 2.0]).median, 1.5);
        assert!((times.spread() - 2.0 / 3.0).abs() < 1e-15);
    }

    #[test]
    fn every_subject_goes_once_a_round_and_once_before() {
        let (mut a, mut b) = (0, 0);
        let mut subjects =
            [Timed { count: 1.0, go: Box::new(|| a += 1) }, Timed { count: 2.0, go: Box::new(|| b += 1) }];
        let times = in_turn(4, &mut subjects, &mut |_| true).unwrap();
        assert!(times.iter().all(|times| times.samples == 4));
        assert!(in_turn(4, &mut subjects, &mut |_| false).is_none());
        drop(subjects);
        assert_eq!((a, b), (5, 5));
    }
}
