//! Readings of a key: names, unit, precision, and impossible values.

use erard::instrument::Instrument;
use erard::keyboard::is_sharp;
use erard::parameter::{NumberError, Quantity as Physical};

use super::bench::Bench;
use crate::balance::{
    ASSIST_LIMITS_G, BALANCE_LIMITS_G, Conditions, FRICTION_LIMITS_G, Lead, PLACES_MM, UNTAPPED_G, USUAL_PLACE_MM,
    WeightFault, WeightReadings,
};
use crate::measure::usual::{ratio_range, usual};
use crate::worklist::{ReadingQuantity, Readings};
use erard::parameter::canonical_name;

/// Number of entries.
pub(super) const ENTRIES: usize = 23;

/// Quantity that can be measured on a real key.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Entry {
    /// Name in tables and JSON, with the unit at its end. Its command option has no unit, and hyphens.
    pub name: &'static str,
    /// Name at the bench.
    pub label: &'static str,
    /// Unit; empty for a ratio or a count.
    pub unit: &'static str,
    /// Other names, in this program's words: regional words are accepted for each.
    pub also: &'static [&'static str],
    /// Least and largest possible value.
    pub limits: [f64; 2],
    /// Largest error of a reading: an estimate for scale, rule and eye.
    pub precision: f64,
    /// Number of decimals shown.
    pub decimals: usize,
    /// Protocol of the reading.
    pub how: &'static str,
}

#[allow(clippy::too_many_arguments)]
const fn entry(
    name: &'static str,
    label: &'static str,
    unit: &'static str,
    also: &'static [&'static str],
    limits: [f64; 2],
    precision: f64,
    decimals: usize,
    how: &'static str,
) -> Entry {
    Entry { name, label, unit, also, limits, precision, decimals, how }
}

/// Indices into [`TABLE`] used by code.
pub(super) mod at {
    pub(crate) const DOWN: usize = 0;
    pub(crate) const UP: usize = 1;
    pub(crate) const STRIKE: usize = 2;
    pub(crate) const FRONT: usize = 3;
    pub(crate) const RATIO: usize = 4;
    pub(crate) const DIP: usize = 5;
    pub(crate) const BLOW: usize = 6;
    pub(crate) const JACK: usize = 7;
    pub(crate) const LEVER: usize = 8;
    pub(crate) const LET_OFF: usize = 9;
    pub(crate) const DROP: usize = 10;
    pub(crate) const AFTERTOUCH: usize = 11;
    pub(crate) const CHECK: usize = 12;
    pub(crate) const SPRING: usize = 13;
    pub(crate) const DAMPER: usize = 14;
    pub(crate) const KEY_ALONE: usize = 15;
    pub(crate) const HAMMER_FLANGE: usize = 16;
    pub(crate) const WHIPPEN_FLANGE: usize = 17;
    pub(crate) const SWINGS: usize = 18;
    pub(crate) const WHIPPEN: usize = 19;
    pub(crate) const KEY_RATIO: usize = 20;
    pub(crate) const ASSIST: usize = 22;
}

const TABLE: [Entry; ENTRIES] = [
    entry(
        "down_weight_g",
        "down-weight D",
        "g",
        &["d", "dw", "down_weight", "downweight", "touch_weight"],
        [0.0, 200.0],
        1.0,
        1,
        "pedal down: the least weight on the key's front with which it sinks slowly as far as let-off",
    ),
    entry(
        "up_weight_g",
        "up-weight U",
        "g",
        &["u", "uw", "up_weight", "upweight"],
        [-50.0, 150.0],
        1.0,
        1,
        "pedal down: the largest weight on the key's front that it still lifts from just before let-off",
    ),
    entry(
        "strike_weight_g",
        "strike weight",
        "g",
        &["sw", "strike_weight", "hammer_weight"],
        [1.0, 30.0],
        0.1,
        1,
        "the hammer on its pin with the shank level, its head on the scale",
    ),
    entry(
        "front_weight_g",
        "front weight",
        "g",
        &["fw", "front_weight"],
        [-60.0, 100.0],
        0.5,
        1,
        "the key on its balance pin, level, its front on the scale, the stack out",
    ),
    entry(
        "strike_weight_ratio",
        "leverage (strike-weight ratio)",
        "",
        &["ratio", "r", "swr", "action_ratio"],
        [2.0, 12.0],
        0.15,
        2,
        "2 g more on the hammer: the change of balance weight over 2 g",
    ),
    entry("dip_mm", "dip", "mm", &["dip", "key_dip", "key_depth"], [3.0, 20.0], 0.1, 1, "a dip block and paper strips"),
    entry(
        "blow_mm",
        "blow",
        "mm",
        &["blow", "blow_distance", "striking_distance", "hammer_blow"],
        [20.0, 80.0],
        0.25,
        1,
        "hammer to string at rest",
    ),
    entry(
        "jack_position_mm",
        "jack position",
        "mm",
        &["jack", "jack_position", "fly_position"],
        [-5.0, 8.0],
        0.25,
        1,
        "middle of the knuckle to the rear edge of the jack's top",
    ),
    entry(
        "lever_height_mm",
        "lever height",
        "mm",
        &["lever_height", "balancier_height", "repetition_height"],
        [-2.0, 3.0],
        0.05,
        2,
        "step from the jack's top up to the repetition lever's",
    ),
    entry(
        "let_off_mm",
        "let-off",
        "mm",
        &["let_off"],
        [0.0, 40.0],
        0.25,
        1,
        "key pressed slowly: the hammer's nearest approach to the string",
    ),
    entry(
        "drop_mm",
        "drop",
        "mm",
        &["drop"],
        [0.0, 40.0],
        0.25,
        1,
        "key pressed slowly: how far the hammer falls after let-off; 0 where it does not",
    ),
    entry(
        "aftertouch_mm",
        "aftertouch",
        "mm",
        &["aftertouch", "after_touch"],
        [0.0, 10.0],
        0.1,
        1,
        "what is left of the key's travel after let-off, by strips under the key",
    ),
    entry(
        "check_mm",
        "checking distance",
        "mm",
        &["check", "back_check", "checking", "check_distance"],
        [0.0, 60.0],
        0.25,
        1,
        "hammer to string after a medium blow, the key held; `none` where it is not caught",
    ),
    entry(
        "repetition_spring_m_per_s",
        "rise from the check",
        "m/s",
        &["spring", "repetition_spring"],
        [-1.0, 3.0],
        0.02,
        2,
        "speed at which the spring lifts the hammer out of the check; by eye: weak, right, strong",
    ),
    entry(
        "damper_start_share",
        "damper start, of the dip",
        "",
        &["damper", "damper_start", "damper_timing"],
        [0.0, 1.0],
        0.025,
        2,
        "key travel at which the damper begins to rise, as a share of the dip",
    ),
    entry(
        "key_alone_friction_g",
        "friction of the key alone",
        "g",
        &["key_alone", "key_friction", "key_alone_friction"],
        [0.0, 100.0],
        0.5,
        1,
        "stack out, key on its pins: half the difference of the weights that make its front sink and rise",
    ),
    entry(
        "hammer_flange_g",
        "hammer flange, at 23 mm",
        "g",
        &["hammer_flange", "hammer_centre", "hammer_center", "hammer_pinning"],
        [0.0, 100.0],
        0.5,
        1,
        "gram gauge 23 mm from the hammer's pin",
    ),
    entry(
        "whippen_flange_g",
        "whippen flange, at 25 mm",
        "g",
        &["whippen_flange", "whippen_centre", "whippen_center", "repetition_flange"],
        [0.0, 200.0],
        0.5,
        1,
        "gram gauge 25 mm from the whippen's pin",
    ),
    entry(
        "hammer_swings",
        "hammer swings",
        "",
        &["swings"],
        [0.0, 60.0],
        1.0,
        0,
        "flange held, hammer let go level: how often it passes its lowest point",
    ),
    entry(
        "whippen_weight_g",
        "whippen weight",
        "g",
        &["ww", "whippen_weight", "repetition_weight"],
        [5.0, 50.0],
        0.2,
        1,
        "the whippen on its pin, its heel on the scale",
    ),
    entry(
        "key_ratio",
        "key ratio",
        "",
        &["kr"],
        [0.3, 0.8],
        0.01,
        3,
        "balance pin to capstan over balance pin to the place where the key is pressed",
    ),
    entry(
        "lost_motion_mm",
        "lost motion",
        "mm",
        &["lost_motion"],
        [0.0, 5.0],
        0.1,
        1,
        "key travel before the hammer moves, by strips under the key's front or by eye",
    ),
    entry(
        "assist_g",
        "springs or magnets take off",
        "g",
        &["assist", "spring_assist", "magnets"],
        ASSIST_LIMITS_G,
        1.0,
        1,
        "of springs at the whippen or of magnets: balance weight without them less balance weight with them",
    ),
];

/// Weights that may be read instead of down-weight and up-weight, which follow from them.
const INSTEAD: [Entry; 2] = [
    entry(
        "balance_weight_g",
        "balance weight BW",
        "g",
        &["bw", "balance_weight", "balance"],
        BALANCE_LIMITS_G,
        1.0,
        1,
        "(D + U) / 2, instead of the down-weight or the up-weight",
    ),
    entry(
        "friction_weight_g",
        "friction weight F",
        "g",
        &["f", "friction_weight", "friction"],
        FRICTION_LIMITS_G,
        1.0,
        1,
        "(D - U) / 2, instead of the down-weight or the up-weight",
    ),
];

/// Conditions of the weighing, instead of readings: the place of the weights, then questions of yes and no.
const CONDITIONS: [Entry; 4] = [
    entry(
        "measured_at_mm",
        "place of the weights",
        "mm",
        &["measured_at", "measuring_point"],
        PLACES_MM,
        1.0,
        0,
        "where down-weight, up-weight, front weight and key ratio were taken, from the key's front edge, of a sharp from its own \
         [default: 13]",
    ),
    entry(
        "tapped",
        "key tapped",
        YES_OR_NO,
        &[],
        [0.0, 1.0],
        0.0,
        0,
        "whether the key was tapped as it was weighed, so that it did not stick [default: yes]",
    ),
    entry(
        "dampers_lifted",
        "dampers lifted",
        YES_OR_NO,
        &[],
        [0.0, 1.0],
        0.0,
        0,
        "whether the pedal was down as the key was weighed [default: yes]",
    ),
    entry(
        "stack_on",
        "stack on",
        YES_OR_NO,
        &[],
        [0.0, 1.0],
        0.0,
        0,
        "whether the stack was on the keys; without it, the key's back held down, down-weight and up-weight are those of the key alone \
         [default: yes]",
    ),
];

/// Unit of an answer.
pub(super) const YES_OR_NO: &str = "yes|no";

/// Range at a key beyond which a reading is a fault, open ends infinite; `None` if there is none.
pub(super) fn usual_range(line: &str, key: usize) -> Option<[f64; 2]> {
    let [low, high] = usual(line)?.faults(key);
    Some([low.unwrap_or(f64::NEG_INFINITY), high.unwrap_or(f64::INFINITY)])
}

/// Returns the entries of a diagnosis.
#[must_use]
pub fn entries() -> &'static [Entry] {
    &TABLE
}

/// Returns all that can be entered: the entries, balance weight and friction weight instead of two of them, and the
/// conditions of the weighing.
pub fn readings() -> impl Iterator<Item = &'static Entry> {
    let [weights, others] = [&TABLE[..=at::UP], &TABLE[at::UP + 1..]];
    weights.iter().chain(&INSTEAD).chain(others).chain(&CONDITIONS)
}

impl Entry {
    /// Physical quantity of the reading.
    #[must_use]
    pub fn quantity(&self) -> Physical {
        match self.unit {
            "g" => Physical::Weight,
            "mm" => Physical::Length,
            "m/s" => Physical::Speed,
            _ if self.name.ends_with("_share") => Physical::Share,
            _ => Physical::Number,
        }
    }

    /// Reads a value as typed, in this entry's unit, which is also that of a number without one.
    ///
    /// # Errors
    /// See [`NumberError`].
    pub fn read(&self, text: &str) -> Result<f64, NumberError> {
        let unit = if self.quantity() == Physical::Share { "1" } else { self.unit };
        self.quantity().read_in(text, unit)
    }

    /// Whether a name belongs to this entry, in any spelling of case, spaces and hyphens.
    #[must_use]
    pub fn is_called(&self, name: &str) -> bool {
        let name = canonical_name(&name.trim().to_lowercase().replace([' ', '-'], "_"));
        name == self.name || self.also.contains(&name.as_str())
    }

    /// Returns the usual range at a key, with infinite values for open ends; `None` if there is no usual range.
    #[must_use]
    pub fn range(&self, key: usize) -> Option<[f64; 2]> {
        let line = match self.name {
            "strike_weight_ratio" => "strike_weight_ratio_weights",
            name => name,
        };
        // Renner's technical manual, quoted on the PTG forum: 2 to 5 gf at 23 mm from a hammer's pin; 1 to 4 for a
        // whippen, without an arm: 25 mm is our own.
        match self.name {
            // A free whippen is no fault.
            "hammer_flange_g" => return Some([2.0, 5.0]),
            "whippen_flange_g" => return Some([f64::NEG_INFINITY, 4.0]),
            // "4 - 8 times" (Pianotech list, December 2002), "4 - 7" and "5 to 9" (Caut list).
            "hammer_swings" => return Some([4.0, 9.0]),
            // A strip of paper or two: our own.
            "lost_motion_mm" => return Some([f64::NEG_INFINITY, 0.5]),
            // Stanwood (Pianotech list, December 2003): above 6 g is high; little is no fault.
            "key_alone_friction_g" => return Some([f64::NEG_INFINITY, 6.0]),
            _ => {}
        }
        let range = usual_range(line, key);
        match self.name {
            "strike_weight_ratio" => Some(ratio_range(key)),
            // They follow from balance weight and friction weight: D = BW + F, U = BW - F.
            "down_weight_g" | "up_weight_g" => {
                let [b_low, b_high] = usual_range("balance_weight_g", key)?;
                let [_, f_high] = usual_range("friction_weight_g", key)?;
                let f_low = usual("friction_weight_g")?.at(key)[0]?;
                let is_down = self.name == "down_weight_g";
                Some(if is_down { [b_low + f_low, b_high + f_high] } else { [b_low - f_high, b_high - f_low] })
            }
            _ => range,
        }
    }

    /// Reason why the usual range of this entry is not that of a key; `None` if it is.
    #[must_use]
    pub fn not_judged(&self, key: usize) -> Option<&'static str> {
        let is_of_a_natural = ["front_weight_g", "dip_mm", "key_ratio"].contains(&self.name);
        (is_of_a_natural && is_sharp(key)).then_some(
            "a sharp is shorter than a natural: the usual ranges of key ratio, front weight and dip are those of naturals",
        )
    }
}

/// Known readings of a key. A missing reading was not measured.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Known {
    values: [Option<f64>; ENTRIES],
    /// Whether the back check fails to catch a medium blow.
    pub is_not_caught: bool,
    /// Leads in the key; empty if not given.
    pub leads: Vec<Lead>,
    /// BW and F as read, g, until [`Known::settle`].
    instead: [Option<f64>; 2],
    /// Conditions of the weighing, until [`Known::settle`].
    conditions: Conditions,
    /// Whether starting friction is in the weights.
    pub(super) is_untapped: bool,
    /// What the conditions changed, a sentence each.
    pub(super) notes: Vec<String>,
}

/// An impossible reading.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{what}; expected {expected}")]
pub struct Impossible {
    /// Name of the entry; `key` and `leads` of a form; empty if the fault belongs to none.
    pub entry: &'static str,
    /// Fault.
    pub what: String,
    /// Expected text.
    pub expected: String,
}

impl Known {
    /// Returns a value, by the entry's name.
    #[must_use]
    pub fn get(&self, name: &str) -> Option<f64> {
        TABLE.iter().position(|entry| entry.name == name).and_then(|at| self.values[at])
    }

    pub(super) fn at(&self, at: usize) -> Option<f64> {
        self.values[at]
    }

    /// Sets a value by the entry's name, 1 or 0 for yes or no; other names are ignored.
    pub fn set(&mut self, name: &str, value: Option<f64>) {
        let answer = value.map(|value| value != 0.0);
        match name {
            "measured_at_mm" => self.conditions.measured_at_mm = value,
            "tapped" => self.conditions.tapped = answer,
            "dampers_lifted" => self.conditions.dampers_lifted = answer,
            "stack_on" => self.conditions.stack_on = answer,
            _ => {}
        }
        if let Some(at) = TABLE.iter().position(|entry| entry.name == name) {
            self.values[at] = value;
        } else if let Some(at) = INSTEAD.iter().position(|entry| entry.name == name) {
            self.instead[at] = value;
        }
    }

    /// Replaces balance weight and friction weight by the down-weight and the up-weight that follow from them, and
    /// weights by those under the usual conditions: at the usual place of `key`, with the dampers lifted and the stack
    /// on.
    ///
    /// # Errors
    /// One of them alone, one that contradicts the down-weight and the up-weight, or weights with a damper in them.
    pub fn settle(&mut self, key: usize) -> Result<(), Impossible> {
        let [balance_g, friction_g] = std::mem::take(&mut self.instead);
        let [down_g, up_g] = [self.values[at::DOWN], self.values[at::UP]];
        let read = WeightReadings { down_g, up_g, balance_g, friction_g };
        let impossible = |WeightFault { name, what, expected }: WeightFault| Impossible { entry: name, what, expected };
        (self.values[at::DOWN], self.values[at::UP]) = read.down_and_up().map_err(impossible)?;
        let conditions = std::mem::take(&mut self.conditions);
        let is_weighed = self.values[at::DOWN].or(self.values[at::UP]).is_some();
        if is_weighed {
            conditions.check_dampers().map_err(impossible)?;
        }
        let factor = conditions.factor(key);
        if let Some(at_mm) = conditions.measured_at_mm.filter(|_| factor != 1.0) {
            for at in [at::DOWN, at::UP, at::FRONT, at::KEY_RATIO, at::ASSIST] {
                self.values[at] = self.values[at].map(|own| factor * own);
            }
            self.notes.push(format!(
                "weights were taken {at_mm} mm from the key's edge: all are shown as at the usual {USUAL_PLACE_MM} mm, times {factor:.3}"
            ));
        }
        if is_weighed && conditions.stack_on == Some(false) {
            let Some(own_g) = self.friction_g() else {
                return Err(Impossible {
                    entry: "stack_on",
                    what: "one weight with the stack off".to_owned(),
                    expected: "down-weight and up-weight of the key alone: half their difference is its friction"
                        .to_owned(),
                });
            };
            if self.values[at::KEY_ALONE].replace(own_g).is_some() {
                return Err(Impossible {
                    entry: "stack_on",
                    what: "down-weight and up-weight with the stack off beside a friction of the key alone".to_owned(),
                    expected: "one of the two".to_owned(),
                });
            }
            (self.values[at::DOWN], self.values[at::UP]) = (None, None);
            self.notes.push("with the stack off, half of D less U is the friction of the key alone".to_owned());
        } else if is_weighed && conditions.is_untapped() {
            self.is_untapped = true;
            self.notes.push(format!(
                "the key was not tapped: starting friction is in D and U, and friction may be {UNTAPPED_G} g less (an estimate)"
            ));
        }
        Ok(())
    }

    /// Returns what springs at the whippen or magnets take off the balance weight, g.
    pub(super) fn assist_g(&self) -> f64 {
        self.values[at::ASSIST].unwrap_or(0.0)
    }

    /// Whether no reading is known.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        !self.is_not_caught && self.values.iter().all(Option::is_none)
    }

    /// Readings of an instrument without error: the scale, the distances, and the bench tests.
    #[must_use]
    pub fn of(readings: &Readings, bench: &Bench) -> Self {
        let mut known = Known::default();
        for quantity in ReadingQuantity::ALL {
            if !matches!(
                quantity,
                ReadingQuantity::BalanceWeight | ReadingQuantity::FrictionWeight | ReadingQuantity::Ratio
            ) {
                known.set(quantity.key(), readings.get(quantity));
            }
        }
        known.is_not_caught = known.values[at::CHECK].is_none();
        for (at, value) in [
            (at::KEY_ALONE, bench.key_alone_g),
            (at::HAMMER_FLANGE, bench.hammer_g),
            (at::WHIPPEN_FLANGE, bench.whippen_g),
        ] {
            known.values[at] = Some(value);
        }
        known
    }

    /// Measures all readings on an instrument: trials with the key, a slow loop, the scale, and the friction of its
    /// pins.
    ///
    /// # Errors
    /// See [`crate::measure::MeasureError`].
    pub fn measured(
        instrument: &Instrument,
        progress: &mut erard::Progress<'_>,
    ) -> Result<Self, crate::measure::MeasureError> {
        Ok(Self::of(&Readings::of(instrument, progress)?, &Bench::of(instrument)?))
    }

    /// Checks the readings and reports the first impossible one: out of the possible range, or in conflict with another
    /// one.
    ///
    /// # Errors
    /// The reading, the reason, and the expected values.
    pub fn check(&self) -> Result<(), Impossible> {
        self.faults().into_iter().next().map_or(Ok(()), Err)
    }

    /// Returns all impossible readings.
    pub(super) fn faults(&self) -> Vec<Impossible> {
        let mut faults = Vec::new();
        for (entry, value) in TABLE.iter().zip(self.values) {
            let [least, most] = entry.limits;
            if let Some(value) = value.filter(|value| !(least..=most).contains(value)) {
                faults.push(Impossible {
                    entry: entry.name,
                    what: format!("{} {value} {}", entry.label, entry.unit).trim_end().to_owned(),
                    expected: format!("a number from {least} to {most} {}", entry.unit).trim_end().to_owned(),
                });
            }
        }
        let pairs: [(usize, usize, &str); 5] = [
            (at::UP, at::DOWN, "no more than the down-weight: are they swapped?"),
            (at::DROP, at::BLOW, "less than the blow"),
            (at::LET_OFF, at::BLOW, "less than the blow"),
            (at::CHECK, at::BLOW, "less than the blow: the back check catches the hammer above its rest"),
            (at::AFTERTOUCH, at::DIP, "less than the dip"),
        ];
        for (small, large, expected) in pairs {
            if let (Some(less), Some(more)) = (self.values[small], self.values[large])
                && less > more
            {
                let [small, large] = [small, large].map(|at| &TABLE[at]);
                let what =
                    format!("{} of {less} {} over {} of {more} {}", small.label, small.unit, large.label, large.unit);
                faults.push(Impossible { entry: small.name, what, expected: expected.to_owned() });
            }
        }
        faults
    }

    /// (D + U) / 2, g.
    #[must_use]
    pub fn balance_g(&self) -> Option<f64> {
        Some(0.5 * (self.values[at::DOWN]? + self.values[at::UP]?))
    }

    /// (D - U) / 2, g.
    #[must_use]
    pub fn friction_g(&self) -> Option<f64> {
        Some(0.5 * (self.values[at::DOWN]? - self.values[at::UP]?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every name belongs to one entry, also regional ones.
    #[test]
    fn names_are_one_entrys() {
        let names = || readings().flat_map(|entry| std::iter::once(entry.name).chain(entry.also.iter().copied()));
        for name in names() {
            assert_eq!(readings().filter(|entry| entry.is_called(name)).count(), 1, "{name}");
        }
        for (name, entry) in [("Set-off", "let_off_mm"), ("Wippen weight", "whippen_weight_g"), ("DW", "down_weight_g")]
        {
            assert!(TABLE.iter().any(|own| own.name == entry && own.is_called(name)), "{name}");
        }
    }

    /// Conditions of the weighing: weights at the usual place, the friction of the key alone, and refusals.
    #[test]
    fn conditions_of_the_weighing() {
        let with = |pairs: &[(&str, f64)], key: usize| {
            let mut known = Known::default();
            pairs.iter().for_each(|(name, value)| known.set(name, Some(*value)));
            known.settle(key).map(|()| known)
        };
        // At the edge the arm is 13 mm longer than 250 mm: 50 g there are 52.6 g.
        let [down, up, at] = [("down_weight_g", 50.0), ("up_weight_g", 25.0), ("measured_at_mm", 0.0)];
        let edge = with(&[down, up, at], 40).unwrap();
        assert!((edge.at(at::DOWN).unwrap() - 52.6).abs() < 1e-9 && edge.notes.len() == 1, "{edge:?}");
        assert_eq!(with(&[down, up, ("measured_at_mm", 13.0)], 40), with(&[down, up], 40));
        // Stanwood's protocol (Pianotech list, 1 July 2002): stack off, key's back held down, (D - U) / 2.
        let alone = with(&[("down_weight_g", 9.0), ("up_weight_g", 3.0), ("stack_on", 0.0)], 40).unwrap();
        assert_eq!((alone.get("key_alone_friction_g"), alone.at(at::DOWN)), (Some(3.0), None));
        assert!(with(&[down, up, ("tapped", 0.0)], 40).unwrap().is_untapped);
        assert_eq!(with(&[down, up, ("tapped", 1.0), ("dampers_lifted", 1.0)], 40), with(&[down, up], 40));
        for (pairs, told) in [
            (&[down, ("dampers_lifted", 0.0)][..], "with the pedal down"),
            (&[down, ("stack_on", 0.0)], "down-weight and up-weight of the key alone"),
            (&[down, up, ("stack_on", 0.0), ("key_alone_friction_g", 3.0)], "one of the two"),
        ] {
            let error = with(pairs, 40).unwrap_err().to_string();
            assert!(error.contains(told), "{error}");
        }
        // Without weights there is nothing to refuse.
        assert!(with(&[("dip_mm", 10.0), ("dampers_lifted", 0.0)], 40).is_ok());
    }

    /// No drop and a large let-off distance are possible together. An up-weight above the down-weight is not.
    #[test]
    fn impossible_readings_are_pointed_at() {
        let known = |pairs: &[(&str, f64)]| {
            let mut known = Known::default();
            pairs.iter().for_each(|(name, value)| known.set(name, Some(*value)));
            known.check()
        };
        assert_eq!(
            known(&[("drop_mm", 0.0), ("let_off_mm", 3.5), ("down_weight_g", 58.0), ("up_weight_g", 18.0)]),
            Ok(())
        );
        for (pairs, told) in [
            (&[("down_weight_g", 18.0), ("up_weight_g", 58.0)][..], "are they swapped?"),
            (&[("drop_mm", -1.0)], "drop -1 mm; expected a number from 0 to 40 mm"),
            (&[("drop_mm", 30.0), ("blow_mm", 25.0)], "less than the blow"),
            (&[("aftertouch_mm", 9.0), ("dip_mm", 8.0)], "less than the dip"),
            (&[("damper_start_share", 1.5)], "from 0 to 1"),
        ] {
            let error = known(pairs).unwrap_err().to_string();
            assert!(error.contains(told), "{error}");
        }
    }
}
