//! The most informative next measurement: the one whose reading is expected to reveal most about the causes, in bits.

use std::collections::BTreeMap;

use super::belief::Belief;
use super::effect::{BALANCE, FRICTION, N};
use super::entry::at;

/// Points of the integral over a reading's probability.
const POINTS: usize = 400;

/// A feature, its expected information, bits, and its expected reading under each of the likeliest sets of causes, the
/// likeliest first.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Next {
    pub feature: usize,
    pub bits: f64,
    pub would_read: Vec<(Vec<usize>, f64)>,
}

/// Returns the best of the unread features.
pub(super) fn next(belief: &Belief, is_known: impl Fn(usize) -> bool) -> Option<Next> {
    // Balance weight comes with friction weight; leverage needs a weighing with another hammer, and follows.
    let candidates = (0..N).filter(|feature| !is_known(*feature) && ![BALANCE, at::RATIO].contains(feature));
    candidates.map(|feature| of(belief, feature)).max_by(|a, b| {
        // Of two equally informative ones, the quicker one: D and U first.
        let rank = |next: &Next| (next.bits, next.feature == FRICTION);
        rank(a).partial_cmp(&rank(b)).unwrap_or(std::cmp::Ordering::Equal)
    })
}

fn of(belief: &Belief, feature: usize) -> Next {
    let told = belief.foretold(feature);
    let total: f64 = told.iter().map(|(p, ..)| p).sum();
    let low = told.iter().map(|(_, _, mean, sd)| mean - 4.0 * sd).fold(f64::INFINITY, f64::min);
    let high = told.iter().map(|(_, _, mean, sd)| mean + 4.0 * sd).fold(f64::NEG_INFINITY, f64::max);
    let step = (high - low) / POINTS as f64;
    // Grouped by the set of causes, whatever their grades.
    let mut by_causes: BTreeMap<&[usize], Vec<(f64, f64, f64)>> = BTreeMap::new();
    for (p, causes, mean, sd) in &told {
        by_causes.entry(causes).or_default().push((p / total, *mean, *sd));
    }
    let mut bits = 0.0;
    for point in 0..POINTS {
        let x = low + (point as f64 + 0.5) * step;
        let normal =
            |mean: f64, sd: f64| libm::exp(-0.5 * ((x - mean) / sd).powi(2)) / (sd * libm::sqrt(std::f64::consts::TAU));
        let joint: Vec<(f64, f64)> = by_causes
            .values()
            .map(|of| {
                let prior: f64 = of.iter().map(|(p, ..)| p).sum();
                (prior, of.iter().map(|(p, mean, sd)| p * normal(*mean, *sd)).sum())
            })
            .collect();
        let here: f64 = joint.iter().map(|(_, joint)| joint).sum();
        for (prior, joint) in joint.into_iter().filter(|(prior, joint)| *joint > 0.0 && *prior > 0.0) {
            bits += step * joint * libm::log2(joint / (prior * here));
        }
    }
    let mut would_read: Vec<(f64, Vec<usize>, f64)> = by_causes
        .into_iter()
        .map(|(causes, of)| {
            let p: f64 = of.iter().map(|(p, ..)| p).sum();
            (p, causes.to_vec(), of.iter().map(|(own, mean, _)| own * mean).sum::<f64>() / p)
        })
        .collect();
    would_read.sort_by(|a, b| b.0.total_cmp(&a.0));
    let would_read = would_read.into_iter().map(|(_, causes, mean)| (causes, mean)).collect();
    Next { feature, bits, would_read }
}
