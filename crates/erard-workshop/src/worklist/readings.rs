//! The readings of a key before and after a line of work.

use crate::balance::KeyModel;
use crate::distances::{self, Distances, Protocol};
use crate::measure::MeasureError;
use crate::measure::Sheet;
use crate::measure::norms::{Line, lines};
use crate::regulate::Goal;
use crate::weighing::Scale;
use erard::Progress;
use erard::instrument::Instrument;

use ReadingQuantity::{
    Aftertouch, BalanceWeight, Blow, Check, Damper, Dip, DownWeight, Drop, FrictionWeight, FrontWeight, JackPosition,
    LetOff, LeverHeight, Ratio, Spring, StrikeWeight, UpWeight,
};

/// A line of the sheet that work can set.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum ReadingQuantity {
    /// D, g.
    DownWeight,
    /// U, g.
    UpWeight,
    /// (D + U) / 2, g.
    BalanceWeight,
    /// (D - U) / 2, g.
    FrictionWeight,
    /// SW, g.
    StrikeWeight,
    /// FW, g.
    FrontWeight,
    /// R by the equation of balance.
    Ratio,
    /// Dip, mm.
    Dip,
    /// Blow, mm.
    Blow,
    /// Jack position, mm.
    JackPosition,
    /// Lever height, mm.
    LeverHeight,
    /// Let-off, mm.
    LetOff,
    /// Drop, mm.
    Drop,
    /// Aftertouch, mm.
    Aftertouch,
    /// Check distance, mm.
    Check,
    /// Speed of the rise from the check, m/s.
    Spring,
    /// Start of the damper, as a share of the dip.
    Damper,
}

impl ReadingQuantity {
    /// All quantities, in the order of the sheet's columns.
    pub const ALL: [ReadingQuantity; 17] = [
        DownWeight,
        UpWeight,
        BalanceWeight,
        FrictionWeight,
        StrikeWeight,
        FrontWeight,
        Ratio,
        Dip,
        Blow,
        JackPosition,
        LeverHeight,
        LetOff,
        Drop,
        Aftertouch,
        Check,
        Spring,
        Damper,
    ];

    /// Key in `measure.json`, largest error of a reading, and the target if it is not the middle of the usual range.
    fn known(self) -> (&'static str, f64, Option<f64>) {
        match self {
            DownWeight => ("down_weight_g", 1.0, None),
            UpWeight => ("up_weight_g", 1.0, None),
            BalanceWeight => ("balance_weight_g", 1.0, None),
            FrictionWeight => ("friction_weight_g", 1.0, None),
            StrikeWeight => ("strike_weight_g", 0.1, None),
            FrontWeight => ("front_weight_g", 0.5, None),
            Ratio => ("strike_weight_ratio_weights", 0.15, None),
            Dip => ("dip_mm", 0.1, None),
            Blow => ("blow_mm", 0.25, None),
            JackPosition => ("jack_position_mm", 0.25, None),
            LeverHeight => ("lever_height_mm", 0.05, None),
            LetOff => ("let_off_mm", 0.25, None),
            Drop => ("drop_mm", 0.25, None),
            // Key travel, like dip: felt and seen with strips of known thickness under the key.
            Aftertouch => ("aftertouch_mm", 0.1, None),
            Check => ("check_mm", 0.25, None),
            // Not the middle: a brisker spring makes soft notes strike twice.
            Spring => ("repetition_spring_m_per_s", 0.02, Some(0.25)),
            Damper => ("damper_start_share", 0.025, None),
        }
    }

    /// Returns the key in `measure.json`.
    #[must_use]
    pub fn key(self) -> &'static str {
        self.known().0
    }

    /// Largest error of a reading, in the line's unit.
    #[must_use]
    pub fn precision(self) -> f64 {
        self.known().1
    }

    /// Smallest change that a line of work requests, in the line's unit: the least that a hand can do and a scale or
    /// rule can show.
    #[must_use]
    pub fn least_change(self) -> f64 {
        match self {
            DownWeight | UpWeight | BalanceWeight | FrictionWeight => 2.0,
            FrontWeight | Blow => 0.5,
            StrikeWeight | Dip => 0.1,
            LetOff | Drop => 0.25,
            Check => 1.0,
            Ratio | JackPosition | LeverHeight | Aftertouch | Spring | Damper => 0.0,
        }
    }

    /// Returns the line of the sheet.
    ///
    /// # Panics
    /// Never: a test looks for each.
    #[must_use]
    pub fn line(self) -> &'static Line {
        lines().find(|line| line.key == self.key()).expect("every quantity is a line of the sheet")
    }

    /// Usual range of a key, open ends infinite.
    #[must_use]
    pub(crate) fn range(self, key: usize) -> [f64; 2] {
        let [low, high] = self.line().range(key);
        [low.unwrap_or(f64::NEG_INFINITY), high.unwrap_or(f64::INFINITY)]
    }

    /// Target of the work.
    #[must_use]
    pub(super) fn aim(self, key: usize) -> f64 {
        let [low, high] = self.range(key);
        self.known().2.unwrap_or(0.5 * (low + high))
    }

    /// Whether a screw, paper, a wire or a spring of its own sets this line.
    #[must_use]
    pub fn has_screw(self) -> bool {
        self.goal().is_some()
    }

    /// Goal of regulation for this line.
    #[must_use]
    pub(crate) fn goal(self) -> Option<Goal> {
        Some(match self {
            Dip => Goal::Dip,
            Blow => Goal::Blow,
            JackPosition => Goal::JackPosition,
            LeverHeight => Goal::LeverHeight,
            LetOff => Goal::LetOff,
            Drop => Goal::Drop,
            Check => Goal::Check,
            Spring => Goal::RepetitionSpring,
            Damper => Goal::DamperStart,
            _ => return None,
        })
    }

    /// Factor from SI to the sheet's unit.
    #[must_use]
    pub(crate) fn factor(self) -> f64 {
        if matches!(self, Spring | Damper) { 1.0 } else { 1e3 }
    }
}

/// Readings of one key; `None` if the event did not happen, or was not measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Readings {
    values: [Option<f64>; ReadingQuantity::ALL.len()],
    /// KR WW, weight of the whippen at the key's front, g. It is needed for the ratio; only work on the capstan changes
    /// it.
    whippen_at_front_g: f64,
}

impl Readings {
    /// Empty readings, with the weight of the whippen at the key's front, g.
    #[must_use]
    pub(crate) fn none(whippen_at_front_g: f64) -> Self {
        Readings { values: [None; ReadingQuantity::ALL.len()], whippen_at_front_g }
    }

    /// Reads an instrument as it is: two trials with the key, one slow loop with the damper lifted, and the scale.
    ///
    /// # Errors
    /// See [`MeasureError`].
    pub fn of(instrument: &Instrument, progress: &mut Progress<'_>) -> Result<Self, MeasureError> {
        Self::weighed(instrument, &mut Scale::default(), progress)
    }

    /// The same with a scale that may know the action.
    ///
    /// # Errors
    /// See [`MeasureError`].
    pub(super) fn weighed(
        instrument: &Instrument,
        scale: &mut Scale,
        progress: &mut Progress<'_>,
    ) -> Result<Self, MeasureError> {
        let distances = distances::measure(instrument, &Protocol::default(), progress)?;
        let mut readings = Self::on_the_scale(instrument)?.with_distances(&distances);
        let touch = scale.touch(instrument, progress)?;
        readings.set(DownWeight, touch.down_weight_g);
        readings.set(UpWeight, touch.up_weight_g);
        Ok(readings)
    }

    /// Returns these readings with the distances of an instrument, from two trials with the key. Weights stay.
    ///
    /// # Errors
    /// See [`MeasureError`].
    pub(super) fn regulated(self, instrument: &Instrument, progress: &mut Progress<'_>) -> Result<Self, MeasureError> {
        Ok(self.with_distances(&distances::measure(instrument, &Protocol::default(), progress)?))
    }

    fn on_the_scale(instrument: &Instrument) -> Result<Self, MeasureError> {
        let model = KeyModel::of(instrument)?;
        let mut readings = Self::none(model.key_ratio * model.whippen_weight_g);
        readings.set(StrikeWeight, Some(model.strike_weight_g));
        readings.set(FrontWeight, Some(model.front_weight_g));
        Ok(readings)
    }

    fn with_distances(mut self, distances: &Distances) -> Self {
        for quantity in ReadingQuantity::ALL {
            if let Some(goal) = quantity.goal() {
                self.set(quantity, goal.of(distances).map(|value| value * quantity.factor()));
            }
        }
        self.set(Aftertouch, distances.aftertouch_m.map(|m| 1e3 * m));
        self
    }

    /// Returns the readings on a sheet.
    #[must_use]
    pub fn on(sheet: &Sheet) -> Self {
        let mut readings = Self::none(sheet.key_ratio * sheet.whippen_weight_g);
        for quantity in ReadingQuantity::ALL {
            readings.set(quantity, (quantity.line().value)(sheet).filter(|value| value.is_finite()));
        }
        readings
    }

    /// Returns the reading of a quantity.
    #[must_use]
    pub fn get(&self, quantity: ReadingQuantity) -> Option<f64> {
        let own = |quantity: ReadingQuantity| self.values[quantity as usize];
        match quantity {
            BalanceWeight => Some(0.5 * (own(DownWeight)? + own(UpWeight)?)),
            FrictionWeight => Some(0.5 * (own(DownWeight)? - own(UpWeight)?)),
            Ratio => {
                let action_g = self.get(BalanceWeight)? + own(FrontWeight)? - self.whippen_at_front_g;
                Some(action_g / own(StrikeWeight)?)
            }
            _ => own(quantity),
        }
    }

    /// Sets a reading. Balance weight, friction weight and ratio follow from the others and cannot be set.
    pub fn set(&mut self, quantity: ReadingQuantity, value: Option<f64>) {
        if !matches!(quantity, BalanceWeight | FrictionWeight | Ratio) {
            self.values[quantity as usize] = value;
        }
    }

    /// Whether a reading is out of its usual range at a key.
    #[must_use]
    pub fn is_out(&self, quantity: ReadingQuantity, key: usize) -> bool {
        quantity.line().is_out_at(self.get(quantity), key)
    }

    /// Returns the distance of a reading from its range, in the line's unit: 0 inside, infinite if it is missing and
    /// should not be.
    #[must_use]
    pub fn beyond(&self, quantity: ReadingQuantity, key: usize) -> f64 {
        let [low, high] = quantity.range(key);
        match self.get(quantity) {
            _ if !self.is_out(quantity, key) => 0.0,
            Some(value) => (low - value).max(value - high).max(0.0),
            None => f64::INFINITY,
        }
    }

    /// Returns these readings with the change of a copy from `before` to `after`.
    #[must_use]
    pub(super) fn moved(&self, before: &Readings, after: &Readings) -> Readings {
        let mut moved = *self;
        moved.whippen_at_front_g += after.whippen_at_front_g - before.whippen_at_front_g;
        for (quantity, value) in ReadingQuantity::ALL.into_iter().zip(&mut moved.values) {
            let at = quantity as usize;
            *value = match (*value, before.values[at], after.values[at]) {
                // A copy whose hammer does not drop gives no change of a drop, or of an aftertouch.
                (value, before, _) if quantity == Drop && is_seen_to_drop(value) && !is_seen_to_drop(before) => value,
                (Some(value), None, _) if quantity == Aftertouch => Some(value),
                (Some(value), Some(before), Some(after)) => Some(value + after - before),
                // What the copy shows before and after, and the piano does not, stays unknown.
                (None, Some(_), Some(_)) => None,
                (.., after) => after,
            };
        }
        moved
    }
}

/// Whether a drop, mm, is more than a reading's error: the hammer is seen to drop.
#[must_use]
pub(super) fn is_seen_to_drop(drop_mm: Option<f64>) -> bool {
    drop_mm.is_some_and(|drop_mm| drop_mm > Drop.precision())
}
