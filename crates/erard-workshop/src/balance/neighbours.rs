//! Keys that differ from their neighbours.
//!
//! Each quantity is compared with a smooth curve over the keyboard that an outlier does not bend. A key differs if its
//! deviation exceeds both the error of two readings and three standard deviations of the other keys.

use erard::keyboard::{KEYS, is_sharp};

use super::measured::MeasuredKey;
use super::smooth::smooth;

/// A quantity of a key that differs from its neighbours.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Apart {
    /// `strike_weight_g`, `ratio`, `balance_weight_g` or `friction_weight_g`.
    pub quantity: &'static str,
    /// Value at the key, in the quantity's unit.
    pub value: f64,
    /// Value that the neighbours suggest here, in the quantity's unit.
    pub neighbours: f64,
}

/// Quantities compared of a key, g and a ratio.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Weighed {
    key: usize,
    values: [Option<f64>; COMPARED.len()],
}

/// Quantities compared, allowed deviation (twice a reading's precision; for strike weights, the scatter of one set of
/// hammers), whether sharps are compared with sharps only (their levers differ), and how many measured keys must be
/// near: hammers are made along a smooth curve, so that gaps do not matter.
const COMPARED: [(&str, f64, bool, usize); 4] = [
    ("strike_weight_g", 0.3, false, 0),
    ("ratio", 0.3, true, 4),
    ("balance_weight_g", 2.0, false, 4),
    ("friction_weight_g", 2.0, false, 4),
];
/// Keys within an octave are near.
const NEAR_KEYS: usize = 12;
/// Standard deviations beyond which a key differs, and standard deviations per median absolute residual.
const DEVIATIONS: f64 = 3.0;
const PER_MEDIAN: f64 = 1.4826;

impl Weighed {
    pub(super) fn of(key: &MeasuredKey, ratio: Option<f64>) -> Self {
        let values = [key.strike_weight_g, ratio, key.balance_weight_g(), key.friction_weight_g()];
        Weighed { key: key.key, values }
    }
}

/// Returns for every key the quantities that differ.
#[must_use]
pub(super) fn apart(keys: &[Weighed]) -> Vec<Vec<Apart>> {
    let mut all = vec![Vec::new(); keys.len()];
    for (which, (quantity, room, is_by_colour, fewest)) in COMPARED.into_iter().enumerate() {
        let groups: &[&dyn Fn(usize) -> bool] =
            if is_by_colour { &[&is_sharp, &|key| !is_sharp(key)] } else { &[&|_| true] };
        for is_in in groups {
            let mut values = [None; KEYS];
            let group = keys.iter().enumerate().filter(|(_, one)| is_in(one.key));
            let known: Vec<(usize, usize, f64)> =
                group.filter_map(|(at, one)| Some((at, one.key - 1, one.values[which]?))).collect();
            known.iter().for_each(|(_, key, value)| values[*key] = Some(*value));
            let Some(curve) = smooth(&values) else { continue };
            let residuals: Vec<f64> = known.iter().map(|(_, key, value)| (value - curve[*key]).abs()).collect();
            let scatter = PER_MEDIAN * median(&residuals).unwrap_or(0.0);
            for ((at, key, value), residual) in known.iter().zip(&residuals) {
                let near =
                    known.iter().filter(|(_, other, _)| other != key && other.abs_diff(*key) <= NEAR_KEYS).count();
                if near >= fewest && *residual > room.max(DEVIATIONS * scatter) {
                    all[*at].push(Apart { quantity, value: *value, neighbours: curve[*key] });
                }
            }
        }
    }
    all
}

/// Median; for an even number the mean of the middle two.
pub(crate) fn median(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let middle = sorted.len() / 2;
    match sorted.len() {
        0 => None,
        n if n % 2 == 1 => Some(sorted[middle]),
        _ => Some(0.5 * (sorted[middle - 1] + sorted[middle])),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn weighed(key: usize, friction_g: f64, strike_g: f64) -> Weighed {
        Weighed { key, values: [Some(strike_g), None, Some(38.0), Some(friction_g)] }
    }

    /// One key with 8 g more friction and one hammer with 0.9 g more are named, with their neighbours' values, and no
    /// other; a scatter of half a gram of friction names none.
    #[test]
    fn what_sticks_out_is_named() {
        let keys: Vec<Weighed> = (1..=88)
            .map(|key| {
                let x = key as f64;
                let friction = 15.0 - 0.06 * x + if key % 2 == 0 { 0.5 } else { -0.5 };
                weighed(
                    key,
                    friction + if key == 30 { 8.0 } else { 0.0 },
                    10.5 - 0.06 * x + if key == 51 { 0.9 } else { 0.0 },
                )
            })
            .collect();
        let found = apart(&keys);
        for (one, apart) in keys.iter().zip(&found) {
            match one.key {
                30 => assert!(apart.len() == 1 && apart[0].quantity == "friction_weight_g", "{apart:?}"),
                51 => assert!(apart.len() == 1 && apart[0].quantity == "strike_weight_g", "{apart:?}"),
                key => assert!(apart.is_empty(), "{key}: {apart:?}"),
            }
        }
        assert!((found[29][0].neighbours - 13.2).abs() < 0.2 && (found[50][0].neighbours - 7.44).abs() < 0.02);
    }

    /// Sharps with equal levers are not compared with naturals.
    #[test]
    fn sharps_are_compared_with_sharps() {
        let ratio = |key: usize| if is_sharp(key) { 6.2 } else { 5.6 };
        let one = |key: usize, ratio: f64| Weighed { key, values: [None, Some(ratio), None, None] };
        let mut keys: Vec<Weighed> = (1..=88).map(|key| one(key, ratio(key))).collect();
        assert!(apart(&keys).iter().all(Vec::is_empty));
        // A sharp with the naturals' ratio differs.
        let sharp = (40..50).find(|key| is_sharp(*key)).unwrap();
        keys[sharp - 1] = one(sharp, 5.6);
        let found = apart(&keys);
        assert!(found.iter().enumerate().all(|(at, apart)| apart.is_empty() != (at + 1 == sharp)), "{found:?}");
    }

    /// Isolated keys have no neighbours, except along the curve of hammers.
    #[test]
    fn keys_that_stand_alone() {
        let keys: Vec<Weighed> = [1, 20, 35, 40, 42, 59, 61, 64, 88]
            .into_iter()
            .map(|key| {
                weighed(
                    key,
                    if key == 40 { 20.0 } else { 12.0 },
                    10.5 - 0.06 * key as f64 + if key == 59 { 1.0 } else { 0.0 },
                )
            })
            .collect();
        let found: Vec<(usize, &str)> = keys
            .iter()
            .zip(apart(&keys))
            .flat_map(|(one, apart)| apart.into_iter().map(|a| (one.key, a.quantity)).collect::<Vec<_>>())
            .collect();
        assert_eq!(found, [(59, "strike_weight_g")]);
    }

    #[test]
    fn three_keys_have_no_neighbours() {
        assert!(
            apart(&[weighed(1, 30.0, 9.0), weighed(2, 10.0, 9.0), weighed(3, 10.0, 12.0)]).iter().all(Vec::is_empty)
        );
    }
}
