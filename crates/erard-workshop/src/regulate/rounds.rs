//! Order of work, repeated in rounds until no goal is disturbed by another.

use std::cell::Cell;

use super::screw::{KnownScrew, known_screw, way};
use super::search::{Search, Turning};
use super::workshop::Workshop;
use super::{Goal, RegulateError, Specification};
use crate::distances::{Distances, Protocol};
use erard::instrument::{Instrument, ScrewAction};
use erard::player::AtRest;

/// Most rounds: goals not settled by then will not settle.
const MAX_ROUNDS: u32 = 8;
/// Most measurements for one goal in one round.
const MAX_TRIES: u32 = 14;
/// Most measurements to meet a goal again while another's screw is turned.
const MAX_TRIES_TO_KEEP: u32 = 6;
/// Share of its tolerance to which a goal is met, so that later work may disturb it a little.
const WORKING_SHARE: f64 = 0.3;
/// Assumed number of rounds, for the progress.
const USUAL_ROUNDS: f64 = 4.0;
/// Step by which the drop screw is turned out of the way, m, and most such steps.
const OUT_OF_THE_WAY_M: f64 = 0.3e-3;
/// See [`OUT_OF_THE_WAY_M`].
const MAX_OUT_OF_THE_WAY: u32 = 5;
/// Drop that shows that the drop screw is out of the way, m: more than twice the usual one.
const FAR_DROP_M: f64 = 3.5e-3;

/// Progress of the work.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Status {
    /// Round, from 1.
    pub round: u32,
    /// Goal that is being regulated; `None` while the whole action is measured.
    pub goal: Option<Goal>,
    /// Simulations made so far.
    pub simulations: u32,
    /// Share done, by a guess at the number of rounds.
    pub share: f64,
}

/// Result for a goal.
#[derive(Debug, Clone, PartialEq)]
pub struct Achieved {
    /// The goal.
    pub goal: Goal,
    /// Target, m, m/s, or share.
    pub target: f64,
    /// Value before; `None` if it did not happen.
    pub before: Option<f64>,
    /// Value after.
    pub after: Option<f64>,
    /// Reason of a miss; `after` is then the nearest value found.
    pub miss: Option<Miss>,
}

/// Reason why a goal is not met.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Miss {
    /// These screws are at the end of their range.
    EndOfRange(Vec<&'static str>),
    /// No setting of these screws reaches the goal: it jumps past it, does not happen, or does not react to them.
    NoSetting(Vec<&'static str>),
    /// The goal can be met, but not together with the others.
    Disturbed,
}

/// A screw that has been turned.
#[derive(Debug, Clone, PartialEq)]
pub struct Turned {
    /// Index into the instrument's screws.
    pub screw: usize,
    /// Name of the screw.
    pub name: String,
    /// Turn of the screw: m, rad, or N m.
    pub action: ScrewAction,
    /// Setting before and after, m, rad, or N m.
    pub setting: [f64; 2],
    /// Direction, in a word or two: `up`, `to the back`, `tighter`.
    pub way: &'static str,
}

/// A regulated action.
#[derive(Debug, Clone)]
pub struct Regulated {
    /// The instrument with its screws turned.
    pub instrument: Instrument,
    /// Outcome of every goal, in the order of work.
    pub achieved: Vec<Achieved>,
    /// The screws that were turned.
    pub turned: Vec<Turned>,
    /// All distances before the work.
    pub before: Distances,
    /// All distances after the work.
    pub after: Distances,
    /// Rounds of work.
    pub rounds: u32,
    /// Simulated trials.
    pub simulations: u32,
}

impl Regulated {
    /// Whether every goal is met.
    pub fn all_met(&self) -> bool {
        self.achieved.iter().all(|a| a.miss.is_none())
    }
}

/// One goal with its screws.
struct Task {
    goal: Goal,
    target: f64,
    /// Screws with their properties, and their effect on the goal per unit of setting: expected, then found.
    screws: Vec<(usize, &'static KnownScrew, f64, Option<f64>)>,
    miss: Option<Miss>,
    /// The nearest value found at the last miss.
    nearest: Option<f64>,
}

/// Regulates a copy of an instrument, played before each measurement unless it rests as drawn. `progress` receives the
/// share done, and ends the work by returning false.
///
/// Goals are worked on in the order of [`Goal::ALL`], whatever the order of the specification; the last of repeated
/// goals counts. Before let-off is set for the first time, a drop screw that lets the lever carry the hammer too long
/// is turned out of the way, as on the bench.
///
/// # Errors
/// See [`RegulateError`]. A goal that cannot be met is no error: see [`Achieved::miss`].
pub fn regulate(
    action: &dyn AtRest,
    specification: &Specification,
    protocol: &Protocol,
    progress: &mut dyn FnMut(&Status) -> bool,
) -> Result<Regulated, RegulateError> {
    let instrument = action.instrument();
    let mut tasks = tasks(instrument, specification)?;
    let status = Cell::new(Status { round: 1, goal: None, simulations: 0, share: 0.0 });
    let mut go_on = |simulations| progress(&Status { simulations, ..status.get() });
    let mut shop = Workshop::new(action, *protocol, &mut go_on);
    let before = shop.all()?;

    let mut rounds = 0;
    let mut best: Option<(f64, Vec<f64>)> = None;
    let mut stalled = 0;
    while rounds < MAX_ROUNDS && !tasks.is_empty() {
        rounds += 1;
        let settings = shop.settings();
        for n in 0..tasks.len() {
            let share = (f64::from(rounds - 1) + n as f64 / tasks.len() as f64) / USUAL_ROUNDS;
            status.set(Status { round: rounds, goal: Some(tasks[n].goal), share: share.min(0.97), simulations: 0 });
            if rounds == 1 && tasks[n].goal == Goal::LetOff && !is_met(&tasks[n], &mut shop)? {
                clear_the_drop_screw(&tasks, &mut shop)?;
            }
            work(&mut tasks, n, MAX_TRIES, &mut shop)?;
        }
        let error = total_error(&tasks, &mut shop)?;
        if best.as_ref().is_none_or(|(least, _)| error < 0.9 * least) {
            stalled = 0;
        } else {
            stalled += 1;
        }
        if best.as_ref().is_none_or(|(least, _)| error < *least) {
            best = Some((error, shop.settings()));
        }
        if error == 0.0 || stalled >= 2 || shop.settings() == settings {
            break;
        }
    }
    if let Some((_, settings)) = best {
        shop.restore(&settings);
    }
    status.set(Status { goal: None, share: 0.99, ..status.get() });
    let after = shop.all()?;
    let achieved = tasks
        .iter()
        .map(|task| {
            let after = task.goal.of(&after);
            let met = after.is_some_and(|value| (value - task.target).abs() <= task.goal.tolerance(task.target));
            let miss = (!met).then(|| task.miss.clone().unwrap_or(Miss::Disturbed));
            Achieved { goal: task.goal, target: task.target, before: task.goal.of(&before), after, miss }
        })
        .collect();
    let turned = instrument.screws.iter().zip(&shop.instrument.screws).enumerate();
    let turned = turned
        .filter(|(_, (old, new))| old.setting != new.setting)
        .map(|(screw, (old, new))| Turned {
            screw,
            name: new.name.clone(),
            action: new.action.clone(),
            setting: [old.setting, new.setting],
            way: way(&new.action, new.setting - old.setting),
        })
        .collect();
    let simulations = shop.simulations;
    Ok(Regulated { instrument: shop.instrument, achieved, turned, before, after, rounds, simulations })
}

/// The goals in the order of work, each with the instrument's screws for it.
fn tasks(instrument: &Instrument, specification: &Specification) -> Result<Vec<Task>, RegulateError> {
    let mut tasks = Vec::new();
    for goal in Goal::ALL {
        let Some(&(_, target)) = specification.iter().rev().find(|(asked, _)| *asked == goal) else { continue };
        // A screw that an earlier goal needs is not turned for this one.
        let taken = |screw: &KnownScrew| {
            let others = specification.iter().filter(|(other, _)| *other < goal);
            others.filter_map(|(other, _)| other.screws().next()).any(|(first, _)| first.name == screw.name)
        };
        let usable = || goal.screws().filter(|(screw, _)| !taken(screw));
        let screws: Vec<_> = usable()
            .filter_map(|(known, effect)| {
                let screw = instrument.screw(known.name)?;
                Some((screw, known, effect * known.sense(&instrument.screws[screw]), None))
            })
            .collect();
        if screws.is_empty() {
            let names: Vec<String> = usable().map(|(screw, _)| format!("`{}`", screw.name)).collect();
            return Err(RegulateError::NoScrew { goal: goal.name(), needs: names.join(" or ") });
        }
        tasks.push(Task { goal, target, screws, miss: None, nearest: None });
    }
    Ok(tasks)
}

fn is_met(task: &Task, shop: &mut Workshop<'_>) -> Result<bool, RegulateError> {
    let value = shop.value(task.goal)?;
    Ok(value.is_some_and(|value| (value - task.target).abs() <= task.goal.tolerance(task.target)))
}

/// Sum of the goals' errors beyond their tolerances, in tolerances; a missing event counts as an error of 1e6.
fn total_error(tasks: &[Task], shop: &mut Workshop<'_>) -> Result<f64, RegulateError> {
    let mut total = 0.0;
    for task in tasks {
        let off = shop.value(task.goal)?.map_or(1e6, |value| (value - task.target).abs());
        total += (off / task.goal.tolerance(task.target) - 1.0).max(0.0);
    }
    Ok(total)
}

/// A repetition lever that is not stopped in time carries the hammer on after the jack has gone, and let-off cannot be
/// seen: as on the bench, the drop screw is turned out of the way until the hammer drops far. If the drop is not set
/// afterwards, it is turned only until the hammer drops at all.
fn clear_the_drop_screw(tasks: &[Task], shop: &mut Workshop<'_>) -> Result<(), RegulateError> {
    let Some(screw) = shop.instrument.screw("drop") else { return Ok(()) };
    let Some(known) = known_screw("drop") else { return Ok(()) };
    let is_set_afterwards = tasks.iter().any(|task| task.goal == Goal::Drop);
    let enough = if is_set_afterwards { FAR_DROP_M } else { f64::MIN_POSITIVE };
    let began_at = shop.setting(screw);
    let sense = known.sense(&shop.instrument.screws[screw]);
    let [from, to] = known.limits(&shop.instrument, &shop.instrument.screws[screw]);
    for _ in 0..MAX_OUT_OF_THE_WAY {
        if shop.value(Goal::Drop)?.is_some_and(|drop| drop >= enough) {
            return Ok(());
        }
        shop.turn(screw, (shop.setting(screw) + sense * OUT_OF_THE_WAY_M).clamp(from, to));
    }
    if !is_set_afterwards && shop.value(Goal::Drop)? == Some(0.0) {
        // The drop screw did not keep the hammer up.
        shop.turn(screw, began_at);
    }
    Ok(())
}

/// Turns the screws of task `n` until its goal is met, or as near as possible in `tries` measurements for each. A goal
/// that must be kept is met again after every turn.
fn work(tasks: &mut [Task], n: usize, tries: u32, shop: &mut Workshop<'_>) -> Result<(), RegulateError> {
    let (goal, target) = (tasks[n].goal, tasks[n].target);
    let near_enough = WORKING_SHARE * goal.tolerance(target);
    let tolerance = goal.tolerance(target);
    // A goal missed earlier is not tried again unless its value has moved.
    let value = shop.value(goal)?;
    if let (Some(value), Some(nearest)) = (value, tasks[n].nearest)
        && (value - nearest).abs() <= tolerance
    {
        return Ok(());
    }
    let kept = goal.keeps().and_then(|kept| tasks.iter().position(|task| task.goal == kept));
    let (mut ends, mut tried) = (Vec::new(), Vec::new());
    for at in 0..tasks[n].screws.len() {
        let (screw, known, expected, found) = tasks[n].screws[at];
        let limits = known.limits(&shop.instrument, &shop.instrument.screws[screw]);
        let turning = Turning { slope: expected, limits, stride: (limits[1] - limits[0]) / 8.0 };
        let mut search = Search::new(turning, found, target);
        let began = shop.value(goal)?.unwrap_or(goal.missing());
        // The nearest value with the settings of all screws, including those of the kept goal.
        let (mut nearest, mut nearest_with) = (began, shop.settings());
        for _ in 0..tries {
            let (setting, value) = (shop.setting(screw), shop.value(goal)?.unwrap_or(goal.missing()));
            let off = (value - target).abs();
            let is_kept = match kept {
                Some(kept) => is_met(&tasks[kept], shop)?,
                None => true,
            };
            if is_kept && off <= near_enough {
                tasks[n].screws[at].3 = Some(search.slope());
                (tasks[n].miss, tasks[n].nearest) = (None, None);
                return Ok(());
            }
            // A screw that hardly helps stays where it was.
            let helps = off < (nearest - target).abs() && off + tolerance <= (began - target).abs();
            if is_kept && helps {
                (nearest, nearest_with) = (value, shop.settings());
            }
            let Some(next) = search.next(setting, value) else { break };
            shop.turn(screw, next);
            if let Some(kept) = kept {
                work(tasks, kept, MAX_TRIES_TO_KEEP, shop)?;
            }
        }
        shop.restore(&nearest_with);
        if let Some((setting, _)) = search.best {
            let at_end = limits.iter().any(|end| (setting - end).abs() < 1e-3 * (limits[1] - limits[0]));
            if at_end {
                ends.push(known.name)
            } else {
                tried.push(known.name)
            }
            if !at_end {
                break;
            }
        }
    }
    let met = is_met(&tasks[n], shop)?;
    tasks[n].nearest = shop.value(goal)?.filter(|_| !met);
    tasks[n].miss = match (met, tried.is_empty()) {
        (true, _) => None,
        (false, true) => Some(Miss::EndOfRange(ends)),
        (false, false) => Some(Miss::NoSetting(tried)),
    };
    Ok(())
}
