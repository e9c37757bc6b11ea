//! The equation of balance, solved for each of its quantities.

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
    /// What springs at the whippen or magnets take off the balance weight, g at the key's front.
    pub assist_g: f64,
}

impl Parts {
    /// R from the balance weight.
    #[must_use]
    pub(crate) fn ratio(&self, balance_weight_g: f64) -> f64 {
        let weight_g = balance_weight_g + self.front_weight_g + self.assist_g;
        (weight_g - self.key_ratio * self.whippen_weight_g) / self.strike_weight_g
    }

    /// BW from the ratio.
    #[must_use]
    pub(crate) fn balance_weight_g(&self, ratio: f64) -> f64 {
        self.key_ratio * self.whippen_weight_g + ratio * self.strike_weight_g - self.front_weight_g - self.assist_g
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

/// Largest difference of a balance weight or friction weight from that of D and U beside it, g: they are often rounded.
const MAX_ROUNDING_G: f64 = 0.51;

/// Weights of a key as they were read: down-weight and up-weight, or balance weight and friction weight instead of one
/// or both of them.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct WeightReadings {
    /// D, g.
    pub down_g: Option<f64>,
    /// U, g.
    pub up_g: Option<f64>,
    /// BW, g.
    pub balance_g: Option<f64>,
    /// F, g.
    pub friction_g: Option<f64>,
}

/// Fault of weights that were read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct WeightFault {
    /// Name of the reading.
    pub name: &'static str,
    /// Fault.
    pub what: String,
    /// Expected text.
    pub expected: String,
}

impl WeightReadings {
    /// Returns D and U, from BW and F where these were read: D = BW + F, U = BW - F.
    ///
    /// # Errors
    /// BW or F without a second weight, or one that contradicts D and U.
    pub(crate) fn down_and_up(self) -> Result<(Option<f64>, Option<f64>), WeightFault> {
        let WeightReadings { down_g, up_g, balance_g, friction_g } = self;
        let (down, up) = match (down_g, up_g, balance_g, friction_g) {
            (Some(down), Some(up), ..) => (down, up),
            (Some(down), None, Some(balance), _) => (down, 2.0 * balance - down),
            (Some(down), None, None, Some(friction)) => (down, down - 2.0 * friction),
            (None, Some(up), Some(balance), _) => (2.0 * balance - up, up),
            (None, Some(up), None, Some(friction)) => (up + 2.0 * friction, up),
            (None, None, Some(balance), Some(friction)) => (balance + friction, balance - friction),
            (None, None, Some(balance), None) => return Err(Self::alone("balance", balance, "friction weight F")),
            (None, None, None, Some(friction)) => return Err(Self::alone("friction", friction, "balance weight BW")),
            (down, up, None, None) => return Ok((down, up)),
        };
        let own = Balance { down_weight_g: down, up_weight_g: up };
        for (name, word, read, follows) in [
            ("balance_weight_g", "balance weight BW", balance_g, own.balance_weight_g()),
            ("friction_weight_g", "friction weight F", friction_g, own.friction_weight_g()),
        ] {
            if let Some(read) = read.filter(|read| (read - follows).abs() > MAX_ROUNDING_G) {
                let shown = |x: f64| (x * 1e6).round() / 1e6;
                let what = format!(
                    "a {word} of {read} g beside a down-weight of {} g and an up-weight of {} g",
                    shown(down),
                    shown(up)
                );
                let expected = format!("{} g, which follows from these; or give two of D, U, BW and F", shown(follows));
                return Err(WeightFault { name, what, expected });
            }
        }
        Ok((Some(down), Some(up)))
    }

    fn alone(word: &str, read: f64, other: &str) -> WeightFault {
        let (name, letter) = if word == "balance" { ("balance_weight_g", "BW") } else { ("friction_weight_g", "F") };
        WeightFault {
            name,
            what: format!("a {word} weight {letter} of {read} g alone"),
            expected: format!(
                "the {other}, a down-weight D or an up-weight U beside it: D and U follow from two of them"
            ),
        }
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

    /// Any two of the four weights give the same D and U; what contradicts them or stands alone is refused.
    #[test]
    fn any_two_weights_give_down_and_up() {
        let [down_g, up_g, balance_g, friction_g] = [52.0, 28.0, 40.0, 12.0].map(Some);
        let none = WeightReadings::default();
        for read in [
            WeightReadings { down_g, up_g, ..none },
            WeightReadings { balance_g, friction_g, ..none },
            WeightReadings { down_g, balance_g, ..none },
            WeightReadings { down_g, friction_g, ..none },
            WeightReadings { up_g, balance_g, ..none },
            WeightReadings { up_g, friction_g, ..none },
            WeightReadings { down_g, up_g, balance_g, friction_g },
            // Rounded.
            WeightReadings { down_g, up_g, balance_g: Some(40.5), friction_g: None },
        ] {
            assert_eq!(read.down_and_up(), Ok((down_g, up_g)), "{read:?}");
        }
        assert_eq!(WeightReadings { down_g, ..none }.down_and_up(), Ok((down_g, None)));
        assert_eq!(none.down_and_up(), Ok((None, None)));
        for (read, name, told) in [
            (WeightReadings { balance_g, ..none }, "balance_weight_g", "BW of 40 g alone"),
            (WeightReadings { friction_g, ..none }, "friction_weight_g", "F of 12 g alone"),
            (
                WeightReadings { down_g, up_g, balance_g: Some(38.0), friction_g },
                "balance_weight_g",
                "BW of 38 g beside",
            ),
            (WeightReadings { down_g, balance_g, friction_g: Some(20.0), ..none }, "friction_weight_g", "F of 20 g"),
        ] {
            let fault = read.down_and_up().unwrap_err();
            assert!(fault.name == name && fault.what.contains(told), "{fault:?}");
        }
    }

    /// By hand: KR 0.5 times WW 18 g is 9 g, R 5.5 times SW 10 g is 55 g; with FW 26 g, the balance weight is 38 g. A
    /// gram more in front is a gram less balance weight (Love, the same post).
    #[test]
    fn the_equation_by_hand() {
        let parts = Parts {
            front_weight_g: 26.0,
            strike_weight_g: 10.0,
            whippen_weight_g: 18.0,
            key_ratio: 0.5,
            assist_g: 0.0,
        };
        assert_eq!(parts.balance_weight_g(5.5), 38.0);
        assert_eq!(parts.ratio(38.0), 5.5);
        assert_eq!(Parts { strike_weight_g: 20.0, ..parts }.ratio(38.0), 2.75);
        assert_eq!(Parts { strike_weight_g: 20.0, ..parts }.balance_weight_g(2.75), 38.0);
        assert_eq!(Parts { front_weight_g: 27.0, ..parts }.balance_weight_g(5.5), 37.0);
        // A spring that carries the whippen takes KR WW, 9 g, off (Stanwood, Pianotech list, 28 June 1996): like lead.
        assert_eq!(Parts { assist_g: 9.0, ..parts }.balance_weight_g(5.5), 29.0);
        assert_eq!(Parts { assist_g: 9.0, ..parts }.ratio(29.0), 5.5);
    }
}
