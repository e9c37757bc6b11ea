//! Distribution of the readings of sound keys: normal over all features.
//!
//! Its sources are the usual ranges, uniform inside (a standard deviation of the width over the root of 12), and the
//! simulated effects. Our own estimates are marked.

use super::cause::{Cause, Change, causes};
use super::effect::{BALANCE, FEATURES, FRICTION, N, effects};
use super::entry::{at, entries};
use crate::measure::usual::{ratio_factor, usual};

/// Mean and covariance of the features of sound keys.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Healthy {
    pub mean: [f64; N],
    pub covariance: [[f64; N]; N],
}

/// Weight of the whippen at the key's front, KR WW, g: 0.5 to 0.56 of 16.2 to 19.8 g, and its standard deviation.
pub(super) const WHIPPEN_AT_FRONT_G: [f64; 2] = [9.5, 0.7];
/// Friction of a key alone, of a hammer's flange at 23 mm and of a whippen's at 25 mm, g, and their standard
/// deviations: the built-in grand's 3.8, Renner's 2 to 5 and 1 to 4. Estimates.
const PLACES: [(usize, &str, f64, f64); 3] = [
    (at::KEY_ALONE, "key_friction", 3.8, 1.2),
    (at::HAMMER_FLANGE, "hammer_friction", 4.0, 0.9),
    (at::WHIPPEN_FLANGE, "whippen_friction", 2.6, 0.8),
];
/// Standard deviation of friction elsewhere (knuckle, jack, lever), g of friction weight: an estimate.
const ELSEWHERE_G: f64 = 1.0;
/// Screws: the feature set by each, and a cause that turns it.
const SCREWS: [(usize, &str); 9] = [
    (at::DIP, "dip_deep"),
    (at::BLOW, "hammer_low"),
    (at::JACK, "jack_back"),
    (at::LEVER, "lever_high"),
    (at::LET_OFF, "let_off_wide"),
    (at::DROP, "drop_large"),
    (at::CHECK, "check_far"),
    (at::SPRING, "spring_weak"),
    (at::DAMPER, "damper_early"),
];
/// Feature that a cause sets: the reading of its screw, its pin, its hammer, its leads or its capstan line; `None`
/// where it sets none of its own.
pub(super) fn set_by(cause: &Cause) -> Option<usize> {
    let is_of = |key: &str| causes().iter().any(|own| own.key == key && own.change == cause.change);
    let places = PLACES.iter().map(|(feature, key, ..)| (*feature, *key));
    let own = SCREWS.into_iter().chain(places).find(|(_, key)| is_of(key)).map(|(feature, _)| feature);
    own.or(match cause.change {
        Change::Hammer => Some(at::STRIKE),
        Change::FrontWeight => Some(at::FRONT),
        Change::Capstan => Some(at::RATIO),
        _ => None,
    })
}

/// Scatter of the aftertouch of sound keys not explained by screws, mm: a blow of 46 mm takes 0.5 mm more or less key
/// travel at a leverage of 5.2 or 5.8. An estimate.
const AFTERTOUCH_MM: f64 = 0.5;

/// Middle and standard deviation of a usual range with two ends, as far as nothing is a fault.
fn usual_of(line: &str, key: usize) -> Option<[f64; 2]> {
    let range = usual(line)?;
    let ([low, high], [fault_low, fault_high]) = (range.at(key), range.faults(key));
    let (low, high) = (fault_low.or(low), fault_high.or(high));
    Some([0.5 * (low? + high?), (high? - low?) / libm::sqrt(12.0)])
}

/// Change of each feature by a cause, per unit of one of them.
fn per_unit(cause: &str, of: usize) -> [f64; N] {
    let row = causes().iter().position(|own| own.key == cause).unwrap_or_default();
    let light = &effects()[row][0];
    let own = light.mean[of].filter(|x| *x != 0.0).unwrap_or(1.0);
    std::array::from_fn(|i| if i == of { 1.0 } else { light.mean[i].unwrap_or(0.0) / own })
}

impl Healthy {
    /// Returns the distribution at a key.
    pub(super) fn at(key: usize) -> Self {
        let of = |line: &str| usual_of(line, key).unwrap_or([0.0, 1.0]);
        let mut healthy = Healthy { mean: [0.0; N], covariance: [[0.0; N]; N] };
        for (feature, name) in FEATURES.iter().enumerate() {
            healthy.mean[feature] = usual_of(name, key).map_or(0.0, |[middle, _]| middle);
            // No two keys read exactly the same: a tenth of the precision, so that nothing is certain.
            healthy.covariance[feature][feature] = (0.1 * entries()[feature].precision).powi(2);
        }
        let [balance, balance_sd] = of("balance_weight_g");
        let [strike, strike_sd] = of("strike_weight_g");
        let [ratio, ratio_sd] = of("strike_weight_ratio_weights").map(|end| end * ratio_factor(key));
        healthy.mean[at::RATIO] = ratio;
        healthy.mean[at::SPRING] = 0.25;
        // The equation of balance: a technician sets the balance weight by leads, and the front weight follows.
        healthy.mean[at::FRONT] = WHIPPEN_AT_FRONT_G[0] + ratio * strike - balance;
        healthy.add(&[(BALANCE, balance_sd), (at::FRONT, -balance_sd)]);
        healthy.add(&[(at::STRIKE, strike_sd), (at::FRONT, ratio * strike_sd)]);
        healthy.add(&[(at::RATIO, ratio_sd), (at::FRONT, strike * ratio_sd)]);
        healthy.add(&[(at::FRONT, WHIPPEN_AT_FRONT_G[1])]);
        // Friction weight: the sum of all frictions, with the simulated leverage of each place.
        for (place, cause, mean, sd) in PLACES {
            healthy.mean[place] = mean;
            let unit = per_unit(cause, place);
            healthy.add(&[(place, sd), (FRICTION, unit[FRICTION] * sd)]);
        }
        healthy.add(&[(FRICTION, ELSEWHERE_G)]);
        // Each line has its own screw and is set after the others, except the aftertouch, which follows.
        for (feature, cause) in SCREWS {
            let [_, sd] = of(FEATURES[feature]);
            let unit = per_unit(cause, feature);
            healthy.add(&[(feature, sd), (at::AFTERTOUCH, unit[at::AFTERTOUCH] * sd)]);
        }
        healthy.add(&[(at::AFTERTOUCH, AFTERTOUCH_MM)]);
        // An aftertouch out of its range is set by another dip. Friction is not set: it is what parts have.
        let [middle, sd] = of(FEATURES[at::AFTERTOUCH]);
        healthy.condition(&[(at::AFTERTOUCH, 1.0)], middle, sd);
        healthy
    }

    /// Adds a source of scatter, with its effect on each feature at one standard deviation.
    fn add(&mut self, reason: &[(usize, f64)]) {
        for &(i, a) in reason {
            for &(j, b) in reason {
                self.covariance[i][j] += a * b;
            }
        }
    }

    /// Conditions on a sum of features: its value and standard deviation.
    fn condition(&mut self, row: &[(usize, f64)], value: f64, sd: f64) {
        let column: [f64; N] = std::array::from_fn(|i| row.iter().map(|(j, c)| c * self.covariance[i][*j]).sum());
        let variance = row.iter().map(|(i, c)| c * column[*i]).sum::<f64>() + sd * sd;
        let off = value - row.iter().map(|(i, c)| c * self.mean[*i]).sum::<f64>();
        for i in 0..N {
            self.mean[i] += column[i] / variance * off;
            for j in 0..N {
                self.covariance[i][j] -= column[i] * column[j] / variance;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Both directions of a screw set its reading; the back rail and the knuckle set none of their own.
    #[test]
    fn causes_set_their_readings() {
        let of = |key: &str| causes().iter().find(|cause| cause.key == key).and_then(set_by);
        for (key, feature) in [
            ("let_off_close", at::LET_OFF),
            ("dip_shallow", at::DIP),
            ("hammer_high", at::BLOW),
            ("spring_strong", at::SPRING),
            ("hammer_friction", at::HAMMER_FLANGE),
            ("ratio_low", at::RATIO),
            ("leads_few", at::FRONT),
        ] {
            assert_eq!(of(key), Some(feature), "{key}");
        }
        assert_eq!((of("back_rail"), of("knuckle_friction")), (None, None));
    }

    /// Sound keys agree with the trade: each mean is inside its usual range by about a standard deviation, and the
    /// means satisfy the equation of balance.
    #[test]
    fn sound_keys_are_usual() {
        for key in [1, 16, 40, 64, 88] {
            let healthy = Healthy::at(key);
            for (feature, name) in FEATURES.iter().enumerate() {
                let sd = healthy.covariance[feature][feature].sqrt();
                assert!(sd > 0.0 && sd.is_finite(), "{name} {sd}");
                if let Some([middle, range_sd]) = usual_of(name, key).filter(|_| *name != "repetition_spring_m_per_s") {
                    assert!(
                        (healthy.mean[feature] - middle).abs() < 2.0 * range_sd,
                        "{key} {name} {}",
                        healthy.mean[feature]
                    );
                    assert!(sd < 2.2 * range_sd, "{key} {name} {sd} {range_sd}");
                }
            }
        }
        let middle = Healthy::at(40);
        let by_equation = 9.5 + 5.53 * 9.5 - middle.mean[BALANCE];
        assert!((middle.mean[at::FRONT] - by_equation).abs() < 1.0, "{}", middle.mean[at::FRONT]);
    }
}
