//! A copy of the key on which a list is worked out, and the readings expected on the piano.

use super::WorklistResult;
use super::hand::Work;
use super::list::{Left, Why};
use super::readings::{ReadingQuantity, Readings};
use crate::distances::Protocol;
use crate::regulate::{Goal, Specification, Status, regulate};
use crate::weighing::Scale;
use erard::Progress;
use erard::instrument::Instrument;

/// Priority of dip and aftertouch if not both can be in range.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Priority {
    /// Dip stays: the blow changes.
    Dip,
    /// Aftertouch comes right: the dip changes, within its range, then the blow.
    #[default]
    Aftertouch,
}

/// Work done on the copy, in order.
pub(super) struct Done {
    pub quantity: ReadingQuantity,
    pub work: Work,
    pub instead: Option<Work>,
}

/// Works out a list on a copy.
pub(super) struct Planner<'a, 'p> {
    pub copy: Instrument,
    /// The copy's own readings.
    pub own: Readings,
    /// Readings on the piano.
    pub read: Readings,
    /// Expected readings now.
    pub now: Readings,
    /// Copies weighed so far.
    pub scale: Scale,
    /// Whether the copy has been weighed since a screw was turned.
    pub weighed: bool,
    pub key: usize,
    pub priority: Priority,
    pub done: Vec<Done>,
    pub why: Vec<Left>,
    pub progress: &'a mut Progress<'p>,
}

impl Planner<'_, '_> {
    pub(super) fn is_out(&self, quantity: ReadingQuantity) -> bool {
        self.now.is_out(quantity, self.key)
    }

    /// Tries a piece of work on the copy and returns the copy's readings after it; screws do not need weighing.
    pub(super) fn tried(&mut self, work: &Work) -> WorklistResult<(Instrument, Readings)> {
        let mut copy = self.copy.clone();
        work.carry_out_on(&mut self.scale, &mut copy, self.progress)?;
        let own = match work {
            Work::Screw { .. } => self.own.regulated(&copy, self.progress)?,
            _ => Readings::weighed(&copy, &mut self.scale, self.progress)?,
        };
        Ok((copy, own))
    }

    pub(super) fn accept(&mut self, work: &Work, (copy, own): (Instrument, Readings)) {
        self.now = self.now.moved(&self.own, &own);
        (self.copy, self.own) = (copy, own);
        self.weighed &= !matches!(work, Work::Screw { .. });
    }

    /// Carries out a piece of work, in whole steps.
    pub(super) fn do_it(
        &mut self,
        quantity: ReadingQuantity,
        work: &Work,
        instead: Option<Work>,
    ) -> WorklistResult<()> {
        if let Some(work) = work.in_steps() {
            if !matches!(work, Work::Screw { .. }) {
                self.weigh()?;
            }
            let tried = self.tried(&work)?;
            if can_be_seen(quantity, &self.now, &self.now.moved(&self.own, &tried.1)) {
                self.accept(&work, tried);
                self.done.push(Done { quantity, work, instead });
            } else if self.is_out(quantity) {
                self.leave(quantity, Why::TooFine);
            }
        }
        Ok(())
    }

    /// Weighs the copy if screws have been turned since.
    pub(super) fn weigh(&mut self) -> WorklistResult<()> {
        if !self.weighed {
            let own = Readings::weighed(&self.copy, &mut self.scale, self.progress)?;
            self.now = self.now.moved(&self.own, &own);
            (self.own, self.weighed) = (own, true);
        }
        Ok(())
    }

    pub(super) fn leave(&mut self, quantity: ReadingQuantity, why: Why) {
        self.clear(quantity);
        if !self.is_unreadable(quantity) {
            self.why.push(Left { quantity, why });
        }
    }

    /// Forgets why a line stays out. An unreadable line stays unreadable.
    pub(super) fn clear(&mut self, quantity: ReadingQuantity) {
        self.why.retain(|left| left.quantity != quantity || left.why == Why::Unreadable);
    }

    pub(super) fn is_unreadable(&self, quantity: ReadingQuantity) -> bool {
        self.why.iter().any(|left| left.quantity == quantity && left.why == Why::Unreadable)
    }

    /// Change of a reading expected from earlier lines; 0 without a reading before or after.
    pub(super) fn moved(&self, quantity: ReadingQuantity) -> f64 {
        self.read.get(quantity).zip(self.now.get(quantity)).map_or(0.0, |(read, now)| (now - read).abs())
    }

    /// Whether that exceeds the reading's precision.
    pub(super) fn is_moved(&self, quantity: ReadingQuantity) -> bool {
        self.moved(quantity) > quantity.precision()
    }

    /// Whether work on one of these lines has been done.
    pub(super) fn has_done(&self, quantities: &[ReadingQuantity]) -> bool {
        self.done.iter().any(|done| quantities.contains(&done.quantity))
    }

    /// The copy's screw for a goal.
    pub(super) fn screw_of(&self, goal: Goal) -> Option<&'static str> {
        goal.screws().map(|(known, _)| known.name).find(|name| self.copy.screw(name).is_some())
    }

    /// Setting of the copy's screw that brings the piano's reading to its target, in SI units.
    pub(super) fn target(&self, quantity: ReadingQuantity, aim: f64) -> Option<(Goal, f64)> {
        let goal = quantity.goal()?;
        self.screw_of(goal)?;
        let by = self.now.get(quantity).zip(self.own.get(quantity));
        let value = by.map_or(aim, |(now, own)| own + aim - now);
        Some((goal, value / quantity.factor()))
    }

    pub(super) fn regulated(&mut self, copy: &Instrument, asked: &Specification) -> WorklistResult<Instrument> {
        let mut going = |status: &Status| (self.progress)(status.share);
        Ok(regulate(copy, asked, &Protocol::default(), &mut going)?.instrument)
    }
}

/// Whether a line's reading changes by at least its least change; true without a reading before or after. (A thousandth
/// of it allows for rounding.)
pub(super) fn can_be_seen(quantity: ReadingQuantity, before: &Readings, after: &Readings) -> bool {
    let change = before.get(quantity).zip(after.get(quantity)).map(|(before, after)| (after - before).abs());
    change.is_none_or(|change| change >= 0.999 * quantity.least_change())
}

/// Whether a line is out by more than the reading's error: for work that cannot be undone.
pub(super) fn is_surely_out(quantity: ReadingQuantity, readings: &Readings, key: usize) -> bool {
    let beyond = readings.beyond(quantity, key);
    beyond.is_finite() && beyond > quantity.precision()
}
