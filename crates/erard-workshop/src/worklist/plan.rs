//! Order of work: friction first, because it is in every weight; then hammer and capstan line, because they undo every
//! screw; then the screws in the trade's order; the leads last.

use super::Worked;
use super::aims::{Aims, DECIDE, REGULATION};
use super::hand::{Work, screw_step};
use super::readings::{Quantity, Readings, is_seen_to_drop};
use super::weights::{WEIGHED, best_friction_g, eased_by_g, friction_under_ceiling_g};
use crate::balance::{KeyModel, Lead};
use crate::distances::Protocol;
use crate::measure::norms::norms_key;
use crate::regulate::{Goal, Miss, Specification, Status, known_screw, regulate};
use crate::weighing::Scale;
use erard::Progress;
use erard::instrument::Instrument;

use Quantity::{
    Aftertouch, BalanceWeight, Blow, Check, Dip, DownWeight, Drop, FrictionWeight, FrontWeight, JackPosition, LetOff,
    LeverHeight, Ratio, Spring, StrikeWeight, UpWeight,
};

/// Most repetitions of lines that later ones have disturbed.
const ROUNDS: u32 = 3;
/// Relative error of the change that earlier lines are expected to make of a reading. (On drawn grands worked on by
/// their lists, a check distance moved by twice the expected change, a drop by 1.7 times.)
const DOUBT: f64 = 0.5;
/// Friction that regulation takes away beyond what it takes from the copy, as a share of that: samples 13 and 17 lost
/// 1.4 and 1.3 times as much as their copies.
const DOUBT_FRICTION: f64 = 0.3;
/// Largest move of a capstan line, mm: more needs other parts.
const MOST_CAPSTAN_MM: f64 = 8.0;

/// Priority of dip and aftertouch if not both can be in range.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Priority {
    /// Dip stays: the blow changes.
    Dip,
    /// Aftertouch comes right: the dip changes, within its range, then the blow.
    #[default]
    Aftertouch,
}

/// A line of work.
#[derive(Debug, Clone, PartialEq)]
pub struct Item {
    /// Quantity that the work corrects.
    pub quantity: Quantity,
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
    /// The quantity follows from other lines, which are in range or are left.
    Follows,
}

/// A line that the list leaves out of its range.
#[derive(Debug, Clone, PartialEq)]
pub struct Left {
    /// The line.
    pub quantity: Quantity,
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
    pub fn is_out(&self, quantity: Quantity, readings: &Readings) -> bool {
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
    pub fn first(&self, lines: usize, begun: &Instrument, progress: &mut Progress<'_>) -> Worked<Worklist> {
        let items: Vec<Item> = self.items.iter().take(lines).cloned().collect();
        let mut copy = begun.clone();
        for item in &items {
            item.work.carry_out(&mut copy, progress)?;
        }
        let after = items.last().map_or(self.before, |item| item.after);
        Ok(Worklist { key: self.key, before: self.before, items, after, left: Vec::new(), copy })
    }
}

/// Works out the list of a key. `copy` is the instrument itself, or a [`super::twin`] of a piano; `readings` are the
/// piano's, `leads` the key's leads where known. The usual ranges are those of the copy's key ([`norms_key`]).
/// `progress` receives the share done, and ends the work by returning false.
///
/// # Errors
/// See [`super::WorklistError`].
pub fn worklist(
    copy: &Instrument,
    readings: &Readings,
    leads: &[Lead],
    priority: Priority,
    progress: &mut Progress<'_>,
) -> Worked<Worklist> {
    let mut scale = Scale::default();
    let own = Readings::weighed(copy, &mut scale, progress)?;
    let mut planner = Planner {
        copy: copy.clone(),
        own,
        read: *readings,
        now: *readings,
        scale,
        weighed: true,
        key: norms_key(copy),
        priority,
        done: Vec::new(),
        why: Vec::new(),
        progress,
    };
    planner.unreadable();
    let aims = planner.aims()?;
    planner.friction(&aims)?;
    planner.leverage(&aims)?;
    // Changes of the leverage have undone the screws.
    let aims = if planner.done.is_empty() { aims } else { planner.aims()? };
    planner.regulation(&aims)?;
    planner.leads(leads)?;
    for _ in 1..ROUNDS {
        if !planner.again()? {
            break;
        }
    }
    planner.finish(copy, own, *readings)
}

/// Work done on the copy, in order.
pub(super) struct Done {
    pub quantity: Quantity,
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
    weighed: bool,
    pub key: usize,
    pub priority: Priority,
    pub done: Vec<Done>,
    pub why: Vec<Left>,
    pub progress: &'a mut Progress<'p>,
}

impl Planner<'_, '_> {
    pub(super) fn is_out(&self, quantity: Quantity) -> bool {
        self.now.is_out(quantity, self.key)
    }

    /// Tries a piece of work on the copy and returns the copy's readings after it; screws do not need weighing.
    pub(super) fn tried(&mut self, work: &Work) -> Worked<(Instrument, Readings)> {
        let mut copy = self.copy.clone();
        work.carry_out_on(&mut self.scale, &mut copy, self.progress)?;
        let own = match work {
            Work::Screw { .. } => self.own.regulated(&copy, self.progress)?,
            _ => Readings::weighed(&copy, &mut self.scale, self.progress)?,
        };
        Ok((copy, own))
    }

    fn accept(&mut self, work: &Work, (copy, own): (Instrument, Readings)) {
        self.now = self.now.moved(&self.own, &own);
        (self.copy, self.own) = (copy, own);
        self.weighed &= !matches!(work, Work::Screw { .. });
    }

    /// Carries out a piece of work, in whole steps.
    pub(super) fn do_it(&mut self, quantity: Quantity, work: &Work, instead: Option<Work>) -> Worked<()> {
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
    pub(super) fn weigh(&mut self) -> Worked<()> {
        if !self.weighed {
            let own = Readings::weighed(&self.copy, &mut self.scale, self.progress)?;
            self.now = self.now.moved(&self.own, &own);
            (self.own, self.weighed) = (own, true);
        }
        Ok(())
    }

    pub(super) fn leave(&mut self, quantity: Quantity, why: Why) {
        self.clear(quantity);
        if !self.is_unreadable(quantity) {
            self.why.push(Left { quantity, why });
        }
    }

    /// Forgets why a line stays out. An unreadable line stays unreadable.
    fn clear(&mut self, quantity: Quantity) {
        self.why.retain(|left| left.quantity != quantity || left.why == Why::Unreadable);
    }

    /// Flags lines that cannot be known before this list is done.
    ///
    /// If the hammer does not drop, the lever carries it beyond let-off, and the jack lets off at the distance read, or
    /// farther from the string. How much farther, the aftertouch, and the drop to come cannot be seen. If the check
    /// does not catch the hammer, but catches the copy's, how far away it stands cannot be seen.
    fn unreadable(&mut self) {
        let mut lines = Vec::new();
        if !is_seen_to_drop(self.now.get(Drop)) {
            self.now.set(Aftertouch, None);
            lines.extend([LetOff, Drop, Aftertouch]);
        }
        if self.now.get(Check).is_none() && self.own.get(Check).is_some() {
            lines.extend([Check, Spring]);
        }
        self.why = lines.into_iter().map(|quantity| Left { quantity, why: Why::Unreadable }).collect();
    }

    pub(super) fn is_unreadable(&self, quantity: Quantity) -> bool {
        self.why.iter().any(|left| left.quantity == quantity && left.why == Why::Unreadable)
    }

    /// Returns the readings with every screw at its target: a jack or a lever out of place shows as friction and
    /// leverage.
    fn as_if_regulated(&mut self, aims: &Aims) -> Worked<Readings> {
        let asked: Specification = aims.iter().filter_map(|(quantity, aim)| self.target(*quantity, *aim)).collect();
        if asked.is_empty() {
            return Ok(self.now);
        }
        let regulated = self.regulated(&self.copy.clone(), &asked)?;
        let own = Readings::weighed(&regulated, &mut self.scale, self.progress)?;
        Ok(self.now.moved(&self.own, &own))
    }

    /// Changes friction to where all weights have room, allowing for the effects of screws and lighter parts.
    fn friction(&mut self, aims: &Aims) -> Worked<()> {
        let then = self.as_if_regulated(aims)?;
        let (Some(now_g), Some(then_g)) = (self.now.get(FrictionWeight), then.get(FrictionWeight)) else {
            return Ok(());
        };
        // If only the copy says that a line is out, it must be so beyond a reading's error.
        let is_out = if self.is_out(FrictionWeight) {
            then.is_out(FrictionWeight, self.key)
        } else {
            is_surely_out(FrictionWeight, &then, self.key)
        };
        if !is_out {
            return Ok(());
        }
        // What is eased too far stays so: not before what regulation takes away can be read.
        let beyond_g = then.beyond(FrictionWeight, self.key);
        if then_g < now_g && beyond_g < FrictionWeight.precision().min(DOUBT * (now_g - then_g)) {
            self.leave(FrictionWeight, Why::ReadAgain);
            return Ok(());
        }
        let [_, high] = FrictionWeight.range(self.key);
        // Friction from hammer and leverage changes after this line; until then friction must be in its range.
        let later_g = self.friction_of_parts(&then)?;
        let best_g = match (then.get(BalanceWeight), then.get(FrontWeight)) {
            (Some(balance_g), Some(front_g)) if later_g == 0.0 => {
                let ceiling_g = FrontWeight.range(self.key)[1];
                friction_under_ceiling_g(balance_g, (ceiling_g - front_g).max(0.0), self.key)
            }
            _ => best_friction_g(self.key),
        };
        // A jack or lever out of place rubs by more than the copy shows, and what is eased too far stays so.
        let later_g = later_g + DOUBT_FRICTION * (now_g - then_g).max(0.0);
        let aim_g = if then_g > high { (best_g + later_g).clamp(best_g, high) } else { best_g };
        let by_g = eased_by_g(then_g, aim_g);
        // Not to where another weight is out of its range, if a reading's error is all that makes it necessary. Leads
        // will follow where a weight is surely out.
        let mut eased = then;
        eased.set(DownWeight, then.get(DownWeight).map(|down_g| down_g + by_g));
        eased.set(UpWeight, then.get(UpWeight).map(|up_g| up_g - by_g));
        let has_leads = WEIGHED.iter().any(|weight| is_surely_out(*weight, &then, self.key));
        let leads = self.change_of_front_weight(&eased).filter(|_| has_leads);
        let leads_g = leads.map_or(0.0, |change| change.by_g);
        let moves_out = [DownWeight, UpWeight].into_iter().any(|weight| {
            let mut leaded = eased;
            leaded.set(weight, eased.get(weight).map(|now_g| now_g - leads_g));
            leaded.beyond(weight, self.key) > then.beyond(weight, self.key)
        });
        if moves_out && !is_surely_out(FrictionWeight, &then, self.key) {
            self.leave(FrictionWeight, Why::TooFine);
            return Ok(());
        }
        // Friction cannot be negative.
        if now_g + by_g > 0.0 { self.do_it(FrictionWeight, &Work::Friction { by_g }, None) } else { Ok(()) }
    }

    /// Friction weight that will go with changes of hammer and leverage, g.
    fn friction_of_parts(&mut self, then: &Readings) -> Worked<f64> {
        let before = (self.copy.clone(), self.own, self.now, self.done.len());
        self.parts(then)?;
        let later_g = before.2.get(FrictionWeight).zip(self.now.get(FrictionWeight)).map(|(then, now)| then - now);
        (self.copy, self.own, self.now) = (before.0, before.1, before.2);
        self.done.truncate(before.3);
        Ok(later_g.unwrap_or_default().max(0.0))
    }

    /// Corrects hammer and capstan line, once friction is in its range.
    fn leverage(&mut self, aims: &Aims) -> Worked<()> {
        let then = self.as_if_regulated(aims)?;
        if !self.is_out(FrictionWeight) {
            return self.parts(&then);
        }
        for quantity in [StrikeWeight, Ratio] {
            if is_surely_out(quantity, &then, self.key) {
                self.leave(quantity, Why::Friction);
            }
        }
        Ok(())
    }

    /// Corrects hammer and capstan line if they are surely out once the screws are at their targets.
    fn parts(&mut self, then: &Readings) -> Worked<()> {
        if is_surely_out(StrikeWeight, then, self.key)
            && let Some(strike_g) = then.get(StrikeWeight)
        {
            let [low, high] = StrikeWeight.range(self.key);
            // To the nearest usual weight, not to the middle: filing cannot be undone.
            let by_g = strike_g.clamp(low + StrikeWeight.precision(), high - StrikeWeight.precision()) - strike_g;
            self.do_it(StrikeWeight, &Work::Hammer { by_g }, None)?;
        }
        if is_surely_out(Ratio, then, self.key)
            && let Some(ratio) = then.get(Ratio)
        {
            let aim = Ratio.aim(self.key);
            let by_mm = KeyModel::of(&self.copy)?.capstan_move_mm(aim / ratio);
            let by_mm = by_mm.clamp(-MOST_CAPSTAN_MM, MOST_CAPSTAN_MM);
            self.do_it(Ratio, &Work::Capstan { by_mm }, None)?;
        }
        Ok(())
    }

    /// Whether a line is out, if at all, because of the expected effects of earlier lines, and by less than their
    /// error.
    fn is_doubtful(&self, quantity: Quantity) -> bool {
        let beyond = self.now.beyond(quantity, self.key);
        self.is_moved(quantity) && beyond > 0.0 && beyond < DOUBT * self.moved(quantity)
    }

    /// Change of a reading expected from earlier lines; 0 without a reading before or after.
    pub(super) fn moved(&self, quantity: Quantity) -> f64 {
        self.read.get(quantity).zip(self.now.get(quantity)).map_or(0.0, |(read, now)| (now - read).abs())
    }

    /// Whether that exceeds the reading's precision.
    pub(super) fn is_moved(&self, quantity: Quantity) -> bool {
        self.moved(quantity) > quantity.precision()
    }

    /// Whether work on one of these lines has been done.
    pub(super) fn has_done(&self, quantities: &[Quantity]) -> bool {
        self.done.iter().any(|done| quantities.contains(&done.quantity))
    }

    /// Sets the screws, in the trade's order.
    fn regulation(&mut self, aims: &Aims) -> Worked<()> {
        for quantity in REGULATION {
            if quantity == Check && self.is_unreadable(Check) {
                self.bend_toward_the_hammer()?;
            }
            if [Check, Spring].contains(&quantity) && self.is_unreadable(quantity) {
                continue;
            }
            let chosen = aims.iter().find(|(other, _)| *other == quantity).map(|(_, aim)| *aim);
            let aim = match quantity {
                // Chosen together: neither goes anywhere alone.
                Dip | Blow => chosen,
                LetOff | Drop if self.is_unreadable(LetOff) => chosen,
                // Earlier lines may have brought it right.
                _ => (self.is_out(quantity) || self.is_at_risk(quantity)).then(|| self.aim(quantity)),
            };
            let Some(aim) = aim else {
                if [Dip, Blow].contains(&quantity) && self.is_out(quantity) {
                    self.leave(quantity, Why::NoRoom);
                }
                continue;
            };
            // Lines chosen together are all carried out. Dip moves the check by 5 to 10 mm for each mm: more than its
            // uncertainty. Jack and lever move each other, and are set until they read right. A line that was read out
            // of its range has to move anyway.
            let is_due = [Dip, Blow, JackPosition, LeverHeight, Check].contains(&quantity)
                || self.is_unreadable(LetOff)
                || self.read.is_out(quantity, self.key);
            if !is_due && self.is_doubtful(quantity) {
                self.leave(quantity, Why::ReadAgain);
                continue;
            }
            self.set(quantity, aim)?;
        }
        Ok(())
    }

    /// Bends the check's wire by a little toward a hammer that drops and is not caught, once in a list.
    fn bend_toward_the_hammer(&mut self) -> Worked<()> {
        if self.has_done(&[Check]) || self.is_unreadable(LetOff) || self.copy.screw("back_check").is_none() {
            return Ok(());
        }
        self.do_it(Check, &Work::Screw { name: "back_check", by: 2.0 * screw_step("back_check") }, None)
    }

    /// The copy's screw for a goal.
    pub(super) fn screw_of(&self, goal: Goal) -> Option<&'static str> {
        goal.screws().iter().map(|(name, _)| *name).find(|name| self.copy.screw(name).is_some())
    }

    /// Setting of the copy's screw that brings the piano's reading to its target, in SI units.
    pub(super) fn target(&self, quantity: Quantity, aim: f64) -> Option<(Goal, f64)> {
        let goal = quantity.goal()?;
        self.screw_of(goal)?;
        let by = self.now.get(quantity).zip(self.own.get(quantity));
        let value = by.map_or(aim, |(now, own)| own + aim - now);
        Some((goal, value / quantity.factor()))
    }

    pub(super) fn regulated(&mut self, copy: &Instrument, asked: &Specification) -> Worked<Instrument> {
        let mut going = |status: &Status| (self.progress)(status.share);
        Ok(regulate(copy, asked, &Protocol::default(), &mut going)?.instrument)
    }

    /// Sets a line to its target with its own screw, in steps of the hand, or records why it stays out.
    fn set(&mut self, quantity: Quantity, aim: f64) -> Worked<()> {
        let Some((goal, value)) = self.target(quantity, aim) else {
            if self.is_out(quantity) {
                self.leave(quantity, Why::NoScrew);
            }
            return Ok(());
        };
        let count = self.done.len();
        let mut going = |status: &Status| (self.progress)(status.share);
        let regulated = regulate(&self.copy, &vec![(goal, value)], &Protocol::default(), &mut going)?;
        for turned in &regulated.turned {
            let Some(known) = known_screw(&turned.name) else { continue };
            let work = Work::Screw { name: known.name, by: turned.setting[1] - turned.setting[0] };
            self.do_it(quantity, &work, None)?;
        }
        // The step nearest to the setting may not be nearest to the target, because distances are not linear; and a
        // line out by less than half a step comes in by a whole one. Dip and blow have been chosen in steps.
        let has_done = self.done.len() > count;
        if let Some(name) = self.screw_of(goal)
            && (has_done || ![Dip, Blow].contains(&quantity))
        {
            self.step_nearer(quantity, aim, name)?;
        }
        if self.is_out(quantity) {
            let why = match regulated.achieved.first().and_then(|achieved| achieved.miss.clone()) {
                Some(Miss::EndOfRange(screws)) => Why::EndOfRange(screws),
                Some(Miss::NoSetting(screws)) => Why::NoSetting(screws),
                _ if [Dip, Blow].contains(&quantity) && quantity.line().is_out_at(Some(aim), self.key) => Why::NoRoom,
                _ => Why::TooFine,
            };
            self.leave(quantity, why);
        } else {
            self.clear(quantity);
        }
        Ok(())
    }

    /// Tries one step more or less if the line is out, and keeps it if that brings it in or nearer to the target.
    fn step_nearer(&mut self, quantity: Quantity, aim: f64, name: &'static str) -> Worked<()> {
        let key = self.key;
        let off = |now: &Readings| {
            let from_aim = now.get(quantity).map_or(f64::INFINITY, |value| (value - aim).abs());
            (now.is_out(quantity, key), from_aim)
        };
        if !self.is_out(quantity) {
            return Ok(());
        }
        for by in [screw_step(name), -screw_step(name)] {
            let work = Work::Screw { name, by };
            let tried = self.tried(&work)?;
            if off(&self.now.moved(&self.own, &tried.1)) < off(&self.now) {
                self.accept(&work, tried);
                self.done.push(Done { quantity, work, instead: None });
                break;
            }
        }
        Ok(())
    }

    /// Repeats lines that later ones have disturbed. Returns whether there were any.
    fn again(&mut self) -> Worked<bool> {
        let count = self.done.len();
        let given_up = |planner: &Self, quantity| planner.why.iter().any(|left| left.quantity == quantity);
        let mut screws = [Aftertouch].into_iter().chain(REGULATION);
        if screws.any(|quantity| self.is_out(quantity) && !given_up(self, quantity)) {
            let aims = self.aims()?;
            self.regulation(&aims)?;
        }
        Ok(self.done.len() > count)
    }
}

/// Whether a line's reading changes by at least its least change; true without a reading before or after. (A thousandth
/// of it allows for rounding.)
pub(super) fn can_be_seen(quantity: Quantity, before: &Readings, after: &Readings) -> bool {
    let change = before.get(quantity).zip(after.get(quantity)).map(|(before, after)| (after - before).abs());
    change.is_none_or(|change| change >= 0.999 * quantity.least_change())
}

/// Whether a line is out by more than the reading's error: for work that cannot be undone.
pub(super) fn is_surely_out(quantity: Quantity, readings: &Readings, key: usize) -> bool {
    let beyond = readings.beyond(quantity, key);
    beyond.is_finite() && beyond > quantity.precision()
}
