//! The list: its lines, what stays out of range, and why.

use super::WorklistResult;
use super::hand::Work;
use super::readings::{ReadingQuantity, Readings};
use erard::Progress;
use erard::instrument::Instrument;

use ReadingQuantity::{
    Blow, Check, Damper, Dip, DownWeight, Drop, FrontWeight, JackPosition, LetOff, LeverHeight, Spring, UpWeight,
};

/// Lines with screws, in the trade's order of work. Aftertouch has no screw: it follows from dip and blow.
pub(super) const REGULATION: [ReadingQuantity; 9] =
    [Dip, Blow, JackPosition, LeverHeight, LetOff, Drop, Check, Spring, Damper];
/// Lines that determine the aftertouch.
pub(super) const DECIDE: [ReadingQuantity; 6] = [Dip, Blow, JackPosition, LeverHeight, LetOff, Drop];
/// A line of work.
#[derive(Debug, Clone, PartialEq)]
pub struct Item {
    /// Quantity that the work corrects.
    pub quantity: ReadingQuantity,
    /// The work.
    pub work: Work,
    /// Alternative work.
    pub instead: Option<Work>,
    /// Readings expected before it.
    pub before: Readings,
    /// Readings expected after it.
    pub after: Readings,
}

impl Item {
    /// Returns D and U that the key reads after this line, in the whole grams that a sheet prints; `None` without both.
    #[must_use]
    pub fn weighed_g(&self) -> Option<[f64; 2]> {
        let [down_g, up_g] = [DownWeight, UpWeight].map(|weight| self.after.get(weight).map(f64::round));
        Some([down_g?, up_g?])
    }

    /// Returns how far, in whole mm, the leads of this line may be shifted toward the front beyond the places it names,
    /// until the front weight of key `key` is at its ceiling, or as large as before; `None` where they have more room
    /// than the readings can err, or where it puts no lead in. `key_front_mm` is the key's front arm.
    #[must_use]
    pub fn room_to_shift_mm(&self, key: usize, key_front_mm: f64) -> Option<f64> {
        let Work::Leads(leads) = &self.work else { return None };
        let (before_g, after_g) = (self.before.get(FrontWeight)?, self.after.get(FrontWeight)?);
        let room_g = (FrontWeight.range(key)[1].max(before_g) - after_g).max(0.0);
        let mass_g: f64 = leads.put.iter().map(|lead| lead.mass_g).sum();
        let is_near = mass_g > 0.0 && room_g <= 2.0 * FrontWeight.precision();
        is_near.then(|| (room_g * key_front_mm / mass_g).floor())
    }
}

/// Reason why a line stays out of its range.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Why {
    /// The correction is finer than a hand can make.
    TooFine,
    /// These screws are at the end of their range.
    EndOfRange(Vec<&'static str>),
    /// No setting of these screws reaches it.
    NoSetting(Vec<&'static str>),
    /// The file has no screw for it.
    NoScrew,
    /// Friction must come right first.
    Friction,
    /// The quantity cannot be known before the hammer drops, or before the check catches it.
    Unreadable,
    /// Earlier lines change it, by more than the model can predict: it must be read again.
    ReadAgain,
    /// No dip and blow bring dip, blow and aftertouch into their ranges.
    NoRoom,
    /// At this friction weight no balance weight has every weight in its range.
    NoBalance,
    /// The front weight is at its ceiling.
    Ceiling,
    /// The leverage of the keyboard must come right first.
    Leverage,
    /// The quantity follows from other lines, which are in range or are left.
    Follows,
}

impl Why {
    /// Whether the line is only not known yet, so that it is read again and may be in its range then.
    #[must_use]
    pub fn is_read_again(&self) -> bool {
        matches!(self, Why::ReadAgain | Why::Unreadable)
    }
}

/// A line that the list leaves out of its range.
#[derive(Debug, Clone, PartialEq)]
pub struct Left {
    /// The line.
    pub quantity: ReadingQuantity,
    /// Reason.
    pub why: Why,
}

/// Work to do, in order.
#[derive(Debug, Clone)]
pub struct Worklist {
    /// The key whose usual ranges hold.
    pub key: usize,
    /// Readings before the first line.
    pub before: Readings,
    /// The lines.
    pub items: Vec<Item>,
    /// Readings expected after the last line.
    pub after: Readings,
    /// Quantities that stay out of range.
    pub left: Vec<Left>,
    /// The simulated copy on which the list has been carried out.
    pub copy: Instrument,
}

impl Worklist {
    /// Whether a line of these readings is out of its range.
    #[must_use]
    pub fn is_out(&self, quantity: ReadingQuantity, readings: &Readings) -> bool {
        readings.is_out(quantity, self.key)
    }

    /// Returns the place of the last line that decides the aftertouch, after which it has to be read.
    #[must_use]
    pub fn aftertouch_is_decided_by(&self) -> Option<usize> {
        self.items.iter().rposition(|item| DECIDE.contains(&item.quantity))
    }

    /// Returns the list with its first `lines` lines only, carried out on `begun`, from which the list was made.
    /// `progress` receives the share done, and ends the work by returning false.
    ///
    /// # Errors
    /// See [`super::WorklistError`].
    pub fn first(&self, lines: usize, begun: &Instrument, progress: &mut Progress<'_>) -> WorklistResult<Worklist> {
        let items: Vec<Item> = self.items.iter().take(lines).cloned().collect();
        let mut copy = begun.clone();
        for item in &items {
            item.work.carry_out(&mut copy, progress)?;
        }
        let after = items.last().map_or(self.before, |item| item.after);
        Ok(Worklist { key: self.key, before: self.before, items, after, left: Vec::new(), copy })
    }
}
