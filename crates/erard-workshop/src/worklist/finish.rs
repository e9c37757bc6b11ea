//! The list as it is carried out: work on one screw is one line, and each line is done anew for its expected effect.

use std::collections::VecDeque;

use super::WorklistResult;
use super::hand::Work;
use super::list::{Item, Left, REGULATION, Why, Worklist};
use super::planner::{Done, Planner, can_be_seen};
use super::readings::{ReadingQuantity, Readings};
use erard::instrument::Instrument;

impl Planner<'_, '_> {
    /// Makes the list, from the copy as it was when the work began, its own readings, and the piano's.
    pub(super) fn finish(mut self, begun: &Instrument, own: Readings, readings: Readings) -> WorklistResult<Worklist> {
        let is_weight = |done: &Done| matches!(done.work, Work::Leads(_) | Work::FrontWeight { .. });
        let (weights, mut others): (Vec<Done>, Vec<Done>) =
            merged(std::mem::take(&mut self.done)).into_iter().partition(is_weight);
        // Lines done anew stand at their place in the trade's order.
        others.sort_by_key(|done| REGULATION.iter().position(|quantity| *quantity == done.quantity));
        let mut list = Worklist {
            key: self.key,
            before: readings,
            items: vec![],
            after: readings,
            left: vec![],
            copy: begun.clone(),
        };
        // Weights come right after the regulation.
        let own = self.carry_out(others, own, &mut list)?;
        self.carry_out(weights, own, &mut list)?;
        for quantity in ReadingQuantity::ALL {
            let why = self.why.iter().find(|left| left.quantity == quantity).map(|left| left.why.clone());
            // Only the copy knows what could not be read.
            if list.after.is_out(quantity, self.key) || why == Some(Why::Unreadable) {
                list.left.push(Left { quantity, why: why.unwrap_or(Why::Follows) });
            }
        }
        Ok(list)
    }

    /// Carries out lines on the list's copy, whose own readings are `own`, and returns those after them.
    ///
    /// A line that makes its reading worse at its place waits for the others: one of them may need it. If none does, it
    /// was made after a line that came to nothing.
    fn carry_out(&mut self, lines: Vec<Done>, mut own: Readings, list: &mut Worklist) -> WorklistResult<Readings> {
        let (mut queue, mut waits, mut has_changed) = (VecDeque::from(lines), Vec::new(), false);
        loop {
            let Some(Done { quantity, work, instead }) = queue.pop_front() else {
                if !has_changed {
                    return Ok(own);
                }
                (queue, has_changed) = (std::mem::take(&mut waits).into(), false);
                continue;
            };
            let Some(work) = work.in_steps() else { continue };
            // Its wire is bent for what dip and blow did when it was planned; they may have been planned anew.
            let is_right = |check: f64| !self.is_check_at_risk(check);
            if quantity == ReadingQuantity::Check && list.after.get(quantity).is_some_and(is_right) {
                continue;
            }
            let mut copy = list.copy.clone();
            work.carry_out_on(&mut self.scale, &mut copy, self.progress)?;
            let own_after = Readings::weighed(&copy, &mut self.scale, self.progress)?;
            let after = list.after.moved(&own, &own_after);
            if after.beyond(quantity, self.key) > list.after.beyond(quantity, self.key) {
                waits.push(Done { quantity, work, instead });
            } else if can_be_seen(quantity, &list.after, &after) {
                // Turns in opposite directions may cancel.
                list.items.push(Item { quantity, work, instead, before: list.after, after });
                (list.copy, list.after, own, has_changed) = (copy, after, own_after, true);
            }
        }
    }
}

/// Lines with the turns of each screw in one.
fn merged(lines: Vec<Done>) -> Vec<Done> {
    let mut merged: Vec<Done> = Vec::new();
    for done in lines {
        let same = |other: &&mut Done| match (&other.work, &done.work) {
            (Work::Screw { name: a, .. }, Work::Screw { name: b, .. }) => a == b,
            _ => false,
        };
        match merged.iter_mut().find(same) {
            Some(other) => other.work = other.work.with_amount(other.work.amount() + done.work.amount(), 0.0),
            None => merged.push(done),
        }
    }
    merged
}
