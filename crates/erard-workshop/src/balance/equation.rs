//! The equation of balance, solved for each of its quantities.

use super::measured::MeasuredKey;

/// Weights and ratio balanced by a key, g and 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parts {
    /// FW: weight of the key's front on the scale.
    pub front_weight_g: f64,
    /// SW: weight of the hammer on the scale, its shank level.
    pub strike_weight_g: f64,
    /// WW: weight of the whippen on the scale, at its heel.
    pub whippen_weight_g: f64,
    /// KR: grams at the key's front per gram over the capstan.
    pub key_ratio: f64,
}

impl Parts {
    /// R from the balance weight.
    #[must_use]
    pub(crate) fn ratio(&self, balance_weight_g: f64) -> f64 {
        (balance_weight_g + self.front_weight_g - self.key_ratio * self.whippen_weight_g) / self.strike_weight_g
    }

    /// BW from the ratio.
    #[must_use]
    pub(crate) fn balance_weight_g(&self, ratio: f64) -> f64 {
        self.key_ratio * self.whippen_weight_g + ratio * self.strike_weight_g - self.front_weight_g
    }
}

/// Down-weight and up-weight of a key.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Balance {
    /// D, g.
    pub down_weight_g: f64,
    /// U, g.
    pub up_weight_g: f64,
}

impl Balance {
    /// Returns those of a key; `None` unless both were measured.
    #[must_use]
    pub(super) fn of(key: &MeasuredKey) -> Option<Self> {
        Some(Balance { down_weight_g: key.down_weight_g?, up_weight_g: key.up_weight_g? })
    }

    /// BW = (D + U) / 2, g.
    #[must_use]
    pub(crate) fn balance_weight_g(&self) -> f64 {
        0.5 * (self.down_weight_g + self.up_weight_g)
    }

    /// F = (D - U) / 2, g.
    #[must_use]
    pub(crate) fn friction_weight_g(&self) -> f64 {
        0.5 * (self.down_weight_g - self.up_weight_g)
    }
}

impl MeasuredKey {
    /// BW = (D + U) / 2, g; `None` unless both were measured.
    #[must_use]
    pub fn balance_weight_g(&self) -> Option<f64> {
        Balance::of(self).map(|own| own.balance_weight_g())
    }

    /// F = (D - U) / 2, g; `None` unless both were measured.
    #[must_use]
    pub fn friction_weight_g(&self) -> Option<f64> {
        Balance::of(self).map(|own| own.friction_weight_g())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// David Love's example (Caut list, "The balance weight is the modern standard"): D 52 g and U 28 g are a balance
    /// weight of 40 g and a friction weight of 12 g; a gram more friction (53, 27) does not change the balance weight.
    #[test]
    fn the_published_example() {
        let key = Balance { down_weight_g: 52.0, up_weight_g: 28.0 };
        assert_eq!((key.balance_weight_g(), key.friction_weight_g()), (40.0, 12.0));
        let stiffer = Balance { down_weight_g: 53.0, up_weight_g: 27.0 };
        assert_eq!((stiffer.balance_weight_g(), stiffer.friction_weight_g()), (40.0, 13.0));
    }

    /// By hand: KR 0.5 times WW 18 g is 9 g, R 5.5 times SW 10 g is 55 g; with FW 26 g, the balance weight is 38 g. A
    /// gram more in front is a gram less balance weight (Love, the same post).
    #[test]
    fn the_equation_by_hand() {
        let parts = Parts { front_weight_g: 26.0, strike_weight_g: 10.0, whippen_weight_g: 18.0, key_ratio: 0.5 };
        assert_eq!(parts.balance_weight_g(5.5), 38.0);
        assert_eq!(parts.ratio(38.0), 5.5);
        assert_eq!(Parts { strike_weight_g: 20.0, ..parts }.ratio(38.0), 2.75);
        assert_eq!(Parts { strike_weight_g: 20.0, ..parts }.balance_weight_g(2.75), 38.0);
        assert_eq!(Parts { front_weight_g: 27.0, ..parts }.balance_weight_g(5.5), 37.0);
    }
}
