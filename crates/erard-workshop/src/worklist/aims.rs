//! Targets of the screws' lines: the middle of each range, except dip and blow, which determine the aftertouch.

use super::WorklistResult;
use super::hand::{Work, screw_step};
use super::list::{DECIDE, REGULATION};
use super::planner::{Planner, Priority, is_surely_out};
use super::readings::{ReadingQuantity, Readings};
use crate::regulate::{Goal, Specification};

use ReadingQuantity::{Aftertouch, Blow, Check, Dip, Drop, JackPosition, LetOff, LeverHeight};

/// Key travel per hammer travel, for changes of the aftertouch by the blow.
pub(super) const KEY_PER_HAMMER: f64 = 0.19;
const MAX_KEY_PER_HAMMER: f64 = 2.0 * KEY_PER_HAMMER;
/// Most trials of dip and blow on the copy.
const TRIALS: u32 = 4;
/// Distance from the ends of its range, mm, at which a line tolerates the errors of hand and reading: a paper and a
/// reading; 1/8 turn of the capstan and a reading; both for the aftertouch; a bend of the back check's wire and a
/// reading; 1/8 turn of the jack's or the lever's screw and a reading.
const ROOM_DIP_MM: f64 = 0.3;
const ROOM_BLOW_MM: f64 = 1.5;
const ROOM_AFTERTOUCH_MM: f64 = 0.3;
const ROOM_CHECK_MM: f64 = 0.7;
const ROOM_JACK_MM: f64 = 0.35;
const ROOM_LEVER_MM: f64 = 0.15;
/// Factors by which paper under the key and bends of the wire move a piano's check distance, over what they do on the
/// copy: of samples 2, 4, 5, 7, 8 and 9, adjusted copies beside them, 0.65 to 1.6, about the same for both.
const CHECK_MOVES: [f64; 2] = [0.65, 1.6];
/// Gain of that distance that makes a millimetre of dip and blow worth the work.
const WORK: f64 = 0.1;
/// Share of a reading's error by which jack and lever move each other noticeably.
const NEAR: f64 = 0.3;

/// Share of a reading's error that must remain of the room of dip, blow and aftertouch where one of them has to move: a
/// paper laid by half a step too far, and a reading off by its whole error, then end within another such error.
const ROOM_TO_MOVE: f64 = 0.6;

/// Smallest turn of the capstan, on the copy.
struct CapstanStep {
    /// Change of the blow, mm.
    blow_mm: f64,
    /// Loss of aftertouch per blow.
    key_per_hammer: f64,
}

impl CapstanStep {
    /// Takes the loss of aftertouch from two trials of dip, blow and aftertouch, mm, if their blows differ by a turn.
    fn learn(&mut self, [dip, blow, aftertouch]: [f64; 3], then: [f64; 3]) {
        let by = then[1] - blow;
        if by.abs() > Blow.least_change() {
            self.key_per_hammer = (((then[0] - dip) - (then[2] - aftertouch)) / by).clamp(0.0, MAX_KEY_PER_HAMMER);
        }
    }
}

/// Targets by line.
pub(super) type Aims = Vec<(ReadingQuantity, f64)>;

impl Planner<'_, '_> {
    /// Returns the targets of the lines that are out of range, or have been brought close to its end.
    pub(super) fn aims(&mut self) -> WorklistResult<Aims> {
        let mut aims: Aims = REGULATION
            .into_iter()
            .filter(|quantity| self.is_out(*quantity) || self.is_at_risk(*quantity))
            .map(|quantity| (quantity, self.aim(quantity)))
            .collect();
        if self.is_unreadable(LetOff) {
            self.without_a_fall(&mut aims);
            return Ok(aims);
        }
        let (mut capstan, mut tried): (Option<CapstanStep>, Option<[f64; 3]>) = (None, None);
        for _ in 0..TRIALS {
            let then = self.with_distances_at(&aims)?;
            let (Some(aftertouch), Some(dip), Some(blow)) = (then.get(Aftertouch), then.get(Dip), then.get(Blow))
            else {
                break;
            };
            let is_asked = aims.iter().any(|(quantity, _)| [Dip, Blow].contains(quantity));
            if !is_asked && !then.is_out(Aftertouch, self.key) {
                break;
            }
            let capstan = match &mut capstan {
                Some(known) => known,
                None => capstan.insert(self.capstan_step()?),
            };
            if let Some(last) = tried.replace([dip, blow, aftertouch]) {
                capstan.learn(last, [dip, blow, aftertouch]);
            }
            let chosen = self.dip_and_blow([dip, blow], aftertouch, capstan);
            let is_tried = (chosen[0] - dip).abs() < 0.5 * Dip.least_change()
                && (chosen[1] - blow).abs() < 0.5 * Blow.least_change();
            for (quantity, value) in [(Dip, chosen[0]), (Blow, chosen[1])] {
                aims.retain(|(other, _)| *other != quantity);
                let is_far =
                    self.now.get(quantity).is_none_or(|now| (now - value).abs() >= 0.999 * quantity.least_change());
                if is_far || self.is_out(quantity) {
                    aims.push((quantity, value));
                }
            }
            if is_tried {
                break;
            }
        }
        Ok(aims)
    }

    /// Sets the targets of let-off and drop if the hammer does not fall. The jack lets off where the reading says, or
    /// farther from the string: the button may bring it nearer, never farther away. The lever is not lowered below the
    /// end of the let-off's range, or below its present height: for any jack position, the hammer then comes as near as
    /// before.
    fn without_a_fall(&self, aims: &mut Aims) {
        let Some(read) = self.now.get(LetOff) else { return };
        let nearest = read.min(LetOff.aim(self.key));
        let lowest = LetOff.range(self.key)[1].max(read) + 0.5 * LetOff.precision();
        aims.retain(|(quantity, _)| ![LetOff, Drop].contains(quantity));
        if read - nearest >= LetOff.least_change() {
            aims.push((LetOff, nearest));
        }
        aims.push((Drop, Drop.aim(self.key).min(lowest - nearest)));
    }

    /// Returns the target of a line.
    ///
    /// A quarter turn of the drop's screw moves the drop of samples 112 and 122 by 1.2 to 1.3 times what it does on
    /// their copies. Its target tolerates the same factor of error either way: the change is the geometric mean of
    /// those to the two ends of the range. A check's wire moves its distance by even more uncertain amounts, but is
    /// bent until the hammer is caught where it should be: in the middle, or as far from here as can be seen.
    pub(super) fn aim(&self, quantity: ReadingQuantity) -> f64 {
        let middle = quantity.aim(self.key);
        let [low, high] = quantity.range(self.key);
        match self.now.get(quantity) {
            Some(now) if quantity == Drop => {
                let room = Drop.precision();
                let change = |near: f64, far: f64| (near.max(0.0) * far).sqrt();
                let aim = if now < middle {
                    now + change(low - now, high - now)
                } else {
                    now - change(now - high, now - low)
                };
                aim.clamp(low + room, high - room)
            }
            // No farther than needed: jack and lever affect friction and leverage, and so every weight.
            Some(now) if [JackPosition, LeverHeight].contains(&quantity) => {
                let room = if quantity == LeverHeight { ROOM_LEVER_MM } else { ROOM_JACK_MM };
                now.clamp(low + room, (high - room).max(low + room))
            }
            Some(now) if quantity == Check && !self.is_out(Check) => {
                // A step of the wire is less than that.
                let least = 1.25 * Check.least_change();
                if now > middle { middle.min(now - least) } else { middle.max(now + least) }
            }
            _ => middle,
        }
    }

    /// Whether other lines of this list have brought one so near to the end of its range that its reading cannot tell
    /// on which side it is.
    ///
    /// Dip and blow move the check distance, and on a piano by more or less than on the copy.
    pub(super) fn is_at_risk(&self, quantity: ReadingQuantity) -> bool {
        let Some(now) = self.now.get(quantity) else { return false };
        match quantity {
            Check => self.has_done(&[Dip, Blow]) && self.is_check_at_risk(now),
            // They move each other.
            JackPosition | LeverHeight => {
                self.moved(quantity) > NEAR * quantity.precision() && self.room(quantity, now) < quantity.precision()
            }
            _ => self.is_moved(quantity) && self.room(quantity, now) < quantity.precision(),
        }
    }

    /// Whether a check distance of this expected value, mm, may turn out outside its range.
    pub(super) fn is_check_at_risk(&self, now: f64) -> bool {
        let room = |value: f64| self.room(Check, value);
        let is_near =
            |share: f64| self.read.get(Check).is_some_and(|read| room(read + share * (now - read)) < Check.precision());
        room(now) < ROOM_CHECK_MM || CHECK_MOVES.into_iter().any(is_near)
    }

    /// Distance of a value from the nearer end of its range; negative outside.
    fn room(&self, quantity: ReadingQuantity, value: f64) -> f64 {
        let [low, high] = quantity.range(self.key);
        (value - low).min(high - value)
    }

    /// Turns the copy's capstan by one step.
    fn capstan_step(&mut self) -> WorklistResult<CapstanStep> {
        let mut step = CapstanStep { blow_mm: Blow.least_change(), key_per_hammer: KEY_PER_HAMMER };
        if let Some(name) = self.screw_of(Goal::Blow) {
            let (_, turned) = self.tried(&Work::Screw { name, by: screw_step(name) })?;
            let by = |quantity: ReadingQuantity| Some(turned.get(quantity)? - self.own.get(quantity)?);
            if let Some(blow_mm) = by(Blow).filter(|by| by.abs() > Blow.precision()) {
                step.blow_mm = blow_mm.abs();
                step.key_per_hammer = by(Aftertouch).map_or(KEY_PER_HAMMER, |by| (-by / blow_mm).max(0.0));
            }
        }
        Ok(step)
    }

    /// Returns the readings expected with these lines at their targets, without weighing.
    fn with_distances_at(&mut self, aims: &Aims) -> WorklistResult<Readings> {
        let asked: Specification = aims
            .iter()
            .filter(|(quantity, _)| DECIDE.contains(quantity))
            .filter_map(|(quantity, aim)| self.target(*quantity, *aim))
            .collect();
        if asked.is_empty() {
            return Ok(self.now);
        }
        let regulated = self.regulated(&self.copy.clone(), &asked)?;
        Ok(self.now.moved(&self.own, &self.own.regulated(&regulated, self.progress)?))
    }

    /// Returns dip and blow that bring the aftertouch into range, from a dip, a blow and their aftertouch.
    ///
    /// With aftertouch first, both are chosen so that all three lie as far inside their ranges as a hand needs, with
    /// little work. With dip first, the dip stays if it is in its range, or goes to the middle.
    fn dip_and_blow(&self, [dip, blow]: [f64; 2], aftertouch: f64, capstan: &CapstanStep) -> [f64; 2] {
        let room = |quantity: ReadingQuantity, value: f64, room: f64| (self.room(quantity, value) / room).min(1.0);
        let here = |quantity: ReadingQuantity, other: f64| self.now.get(quantity).unwrap_or(other);
        let after =
            |[new_dip, new_blow]: [f64; 2]| aftertouch + (new_dip - dip) - capstan.key_per_hammer * (new_blow - blow);
        let gain = |new_dip: f64, new_blow: f64| {
            let least = room(Dip, new_dip, ROOM_DIP_MM).min(room(Blow, new_blow, ROOM_BLOW_MM)).min(room(
                Aftertouch,
                after([new_dip, new_blow]),
                ROOM_AFTERTOUCH_MM,
            ));
            let work = (new_dip - here(Dip, dip)).abs() + KEY_PER_HAMMER * (new_blow - here(Blow, blow)).abs();
            least - WORK * work
        };
        // Only changes that a hand makes, from where they are.
        let reachable = |quantity: ReadingQuantity, here: f64| {
            let [low, high] = quantity.range(self.key);
            let step = if quantity == Blow { capstan.blow_mm } else { quantity.least_change() };
            // Where the range cannot be reached, nearer to it.
            let [from, to] = [((low - here) / step).ceil().min(0.0), ((high - here) / step).floor().max(0.0)];
            (from as i32..=to as i32).map(move |n| here + step * f64::from(n))
        };
        let dips: Vec<f64> = match self.priority {
            Priority::Aftertouch => reachable(Dip, here(Dip, dip)).collect(),
            Priority::Dip if self.is_out(Dip) => vec![Dip.aim(self.key)],
            Priority::Dip => vec![here(Dip, dip)],
        };
        // What is inside stays inside, by a reading's error if it was; by less, but surely, where one of the three has
        // to move.
        let must_move =
            [Dip, Blow, Aftertouch].into_iter().any(|quantity| is_surely_out(quantity, &self.now, self.key));
        let share = if must_move { ROOM_TO_MOVE } else { 1.0 };
        let keeps = |new: &[f64; 2]| {
            [(Dip, new[0]), (Blow, new[1]), (Aftertouch, after(*new))].into_iter().all(|(quantity, new)| {
                let room = self.now.get(quantity).map_or(f64::NEG_INFINITY, |now| self.room(quantity, now));
                room < 0.0 || self.room(quantity, new) >= room.min(share * quantity.precision()) - 1e-9
            })
        };
        let best = |blows: Vec<f64>| {
            let pairs = || dips.iter().flat_map(|dip| blows.iter().map(|blow| [*dip, *blow]));
            let by_gain = |a: &[f64; 2], b: &[f64; 2]| gain(a[0], a[1]).total_cmp(&gain(b[0], b[1]));
            pairs().filter(keeps).max_by(by_gain).or_else(|| pairs().max_by(by_gain)).unwrap_or([dip, blow])
        };
        // A turn of the capstan is coarser than a paper: no other blow for what may be a reading's error, unless paper
        // alone leaves the aftertouch within that error of the end of its range.
        let is_small = self.now.beyond(Aftertouch, self.key) <= Aftertouch.precision();
        if is_small && !self.is_out(Blow) && self.priority == Priority::Aftertouch {
            let papered = best(vec![here(Blow, blow)]);
            if self.room(Aftertouch, after(papered)) >= Aftertouch.precision() {
                return papered;
            }
        }
        best(reachable(Blow, here(Blow, blow)).collect())
    }
}
