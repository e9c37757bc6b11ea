//! Possible weights of a key: down-weight, up-weight, balance weight and friction weight all in their ranges.

use super::hand::{FRICTION_FOUND_G, Work};
use super::readings::ReadingQuantity;

/// Weights that leads change, all by as much.
pub(super) const WEIGHED: [ReadingQuantity; 3] =
    [ReadingQuantity::DownWeight, ReadingQuantity::UpWeight, ReadingQuantity::BalanceWeight];

/// A balance weight, and the least margin of the readings that depend on it inside their ranges (negative: outside).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Balance {
    pub balance_g: f64,
    pub margin_g: f64,
}

/// Returns the balance weight farthest from the ends of the ranges of D = B + F, U = B - F and B, at a friction weight.
#[must_use]
pub(super) fn balance_for(friction_g: f64, key: usize) -> Balance {
    let of = |quantity: ReadingQuantity| quantity.range(key);
    let ([d_low, d_high], [u_low, u_high], [b_low, b_high]) =
        (of(ReadingQuantity::DownWeight), of(ReadingQuantity::UpWeight), of(ReadingQuantity::BalanceWeight));
    let low = b_low.max(d_low - friction_g).max(u_low + friction_g);
    let high = b_high.min(d_high - friction_g).min(u_high + friction_g);
    Balance { balance_g: 0.5 * (low + high), margin_g: 0.5 * (high - low) }
}

/// Friction weight in its range with the largest margin.
fn best_of(key: usize, margin: impl Fn(f64) -> f64) -> f64 {
    let [low, high] = ReadingQuantity::FrictionWeight.range(key);
    const STEPS: u32 = 200;
    let margin = |friction_g: f64| margin(friction_g).min(friction_g - low).min(high - friction_g);
    (0..=STEPS)
        .map(|n| low + (high - low) * f64::from(n) / f64::from(STEPS))
        .max_by(|a, b| margin(*a).total_cmp(&margin(*b)))
        .unwrap_or(0.5 * (low + high))
}

/// Returns the friction weight farthest from the ends of its own range and those of the weights that go with it.
#[must_use]
pub(super) fn best_friction_g(key: usize) -> f64 {
    best_of(key, |friction_g| balance_for(friction_g, key).margin_g)
}

/// Returns the same for a key whose balance weight comes down no farther than by `most_front_g` of front weight, its
/// ceiling.
#[must_use]
pub(super) fn friction_under_ceiling_g(balance_g: f64, most_front_g: f64, key: usize) -> f64 {
    let usual_g = best_friction_g(key);
    let lowest_g = balance_g - most_front_g;
    if lowest_g <= balance_for(usual_g, key).balance_g {
        return usual_g;
    }
    best_of(key, |friction_g| {
        let best = balance_for(friction_g, key);
        best.margin_g - (lowest_g - best.balance_g).max(0.0)
    })
}

/// Returns the change of a friction weight to a target, g, with the weights on the key: at least the smallest change
/// that they show.
#[must_use]
pub(super) fn eased_by_g(friction_g: f64, aim_g: f64) -> f64 {
    let least_g = Work::Friction { by_g: 0.0 }.step() + 2.0 * FRICTION_FOUND_G;
    let by_g = aim_g - friction_g;
    by_g.abs().max(least_g).copysign(by_g)
}

/// Returns the change of a friction weight toward a target, g, for work away from the scale: of the hand's steps on
/// either side of the target, the one that ends in the range, or else nearest to it.
#[must_use]
pub(super) fn friction_change_g(friction_g: f64, aim_g: f64, key: usize) -> f64 {
    let [low, high] = ReadingQuantity::FrictionWeight.range(key);
    let step = Work::Friction { by_g: 0.0 }.step();
    let steps = ((aim_g - friction_g) / step).floor();
    let off = |by_g: &f64| {
        let after_g = friction_g + by_g;
        100.0 * (low - after_g).max(after_g - high).max(0.0) + (after_g - aim_g).abs()
    };
    let candidates = [steps, steps + 1.0].map(|n| n * step);
    candidates.into_iter().min_by(|a, b| off(a).total_cmp(&off(b))).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// At middle C, by hand: B from 34 to 40, F from 9 to 12.5 g, and D and U follow: every pair has usual D and U,
    /// 37 g has 3 g to either end, and the best friction is the middle of its range.
    #[test]
    fn middle_c_by_hand() {
        assert!((best_friction_g(40) - 10.75).abs() < 0.02);
        for friction_g in [9.0, 10.75, 12.5] {
            let balance = balance_for(friction_g, 40);
            assert!((balance.balance_g - 37.0).abs() < 1e-9 && (balance.margin_g - 3.0).abs() < 1e-9, "{balance:?}");
        }
        // Less friction than usual leaves D less room from below.
        assert!(balance_for(7.0, 40).margin_g < 3.0);
    }

    /// With the weights on the key friction comes to its target, by no less than they show. A balance weight that no
    /// lead can bring down keeps the usual friction.
    #[test]
    fn friction_by_the_weights() {
        let near = |found: f64, expected: f64| assert!((found - expected).abs() < 0.05, "{found} {expected}");
        near(eased_by_g(20.0, 11.4), -8.6);
        near(eased_by_g(12.6, 11.4), -2.1);
        near(eased_by_g(8.0, 11.4), 3.4);
        near(friction_under_ceiling_g(37.3, 0.0, 40), best_friction_g(40));
        near(friction_under_ceiling_g(37.3, 5.0, 40), best_friction_g(40));
        near(friction_under_ceiling_g(33.0, 0.0, 40), best_friction_g(40));
    }
}
