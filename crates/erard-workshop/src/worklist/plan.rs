//! Order of work: friction first, because it is in every weight; then hammer and capstan line, because they undo every
//! screw; then the screws in the trade's order; the leads last.

use super::WorklistResult;
use super::aims::Aims;
use super::hand::{Work, screw_step};
use super::list::{Left, REGULATION, Why, Worklist};
use super::planner::{Done, Planner, Priority, is_surely_out};
use super::readings::{ReadingQuantity, Readings, is_seen_to_drop};
use super::weights::{WEIGHED, best_friction_g, eased_by_g, friction_under_ceiling_g};
use crate::balance::{KeyModel, Lead};
use crate::distances::Protocol;
use crate::measure::norms::norms_key;
use crate::regulate::{Miss, Specification, Status, known_screw, regulate};
use crate::weighing::Scale;
use erard::Progress;
use erard::instrument::Instrument;

use ReadingQuantity::{
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
const MAX_CAPSTAN_MM: f64 = 8.0;

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
) -> WorklistResult<Worklist> {
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

impl Planner<'_, '_> {
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

    /// Returns the readings with every screw at its target: a jack or a lever out of place shows as friction and
    /// leverage.
    fn as_if_regulated(&mut self, aims: &Aims) -> WorklistResult<Readings> {
        let asked: Specification = aims.iter().filter_map(|(quantity, aim)| self.target(*quantity, *aim)).collect();
        if asked.is_empty() {
            return Ok(self.now);
        }
        let regulated = self.regulated(&self.copy.clone(), &asked)?;
        let own = Readings::weighed(&regulated, &mut self.scale, self.progress)?;
        Ok(self.now.moved(&self.own, &own))
    }

    /// Changes friction to where all weights have room, allowing for the effects of screws and lighter parts.
    fn friction(&mut self, aims: &Aims) -> WorklistResult<()> {
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
    fn friction_of_parts(&mut self, then: &Readings) -> WorklistResult<f64> {
        let before = (self.copy.clone(), self.own, self.now, self.done.len());
        self.parts(then)?;
        let later_g = before.2.get(FrictionWeight).zip(self.now.get(FrictionWeight)).map(|(then, now)| then - now);
        (self.copy, self.own, self.now) = (before.0, before.1, before.2);
        self.done.truncate(before.3);
        Ok(later_g.unwrap_or_default().max(0.0))
    }

    /// Corrects hammer and capstan line, once friction is in its range.
    fn leverage(&mut self, aims: &Aims) -> WorklistResult<()> {
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
    fn parts(&mut self, then: &Readings) -> WorklistResult<()> {
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
            let by_mm = by_mm.clamp(-MAX_CAPSTAN_MM, MAX_CAPSTAN_MM);
            self.do_it(Ratio, &Work::Capstan { by_mm }, None)?;
        }
        Ok(())
    }

    /// Whether a line is out, if at all, because of the expected effects of earlier lines, and by less than their
    /// error.
    fn is_doubtful(&self, quantity: ReadingQuantity) -> bool {
        let beyond = self.now.beyond(quantity, self.key);
        self.is_moved(quantity) && beyond > 0.0 && beyond < DOUBT * self.moved(quantity)
    }

    /// Sets the screws, in the trade's order.
    fn regulation(&mut self, aims: &Aims) -> WorklistResult<()> {
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
    fn bend_toward_the_hammer(&mut self) -> WorklistResult<()> {
        if self.has_done(&[Check]) || self.is_unreadable(LetOff) || self.copy.screw("back_check").is_none() {
            return Ok(());
        }
        self.do_it(Check, &Work::Screw { name: "back_check", by: 2.0 * screw_step("back_check") }, None)
    }

    /// Sets a line to its target with its own screw, in steps of the hand, or records why it stays out.
    fn set(&mut self, quantity: ReadingQuantity, aim: f64) -> WorklistResult<()> {
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
    fn step_nearer(&mut self, quantity: ReadingQuantity, aim: f64, name: &'static str) -> WorklistResult<()> {
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
    fn again(&mut self) -> WorklistResult<bool> {
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
