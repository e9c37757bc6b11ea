//! A press in numbers that carry derivatives, as often as there are groups of directions and lengths of step, on all
//! cores.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use erard::Progress;
use erard::gradient::{self, DIRECTIONS, Direction, Followed, Poses, STACK_BYTES, check, follow};
use erard::instrument::Instrument;
use erard::run::{Setup, SimulationError};
use moreau::Settings;

use super::error::SensitivityError;
use super::variable::Variable;
use crate::cores::{do_all, job};
use crate::study::{Stroke, rests};

/// The pose in which the action rests, while a number changes a little.
///
/// With dry friction an action can rest in a whole range of poses; it depends on the way there which one it is in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Rest {
    /// It moves as the rest of [`erard::simulate`] does, which lets every variant come to rest from the pose as drawn.
    #[default]
    Moves,
    /// Friction holds it: the angles are those of the unchanged action, whatever felts and screws then do.
    Held,
}

/// Two slopes of the rest to the two sides that differ by more than this share of the larger one are not one slope.
const ONE_SLOPE: f64 = 0.1;
/// Slopes of the rest below this, rad per unit, come from rounding.
const ROUNDING: f64 = 1e-9;

/// Presses in numbers that carry derivatives, with every length of step.
#[derive(Default)]
pub(super) struct Passes {
    /// Of every length of step: of every eight numbers, one after the other.
    each: Vec<Vec<Followed>>,
    /// With the first length of step once more, where derivatives pass switches that could not be told from others; of
    /// those presses that have any.
    passing: Vec<Option<Followed>>,
    /// Of every number: whether the rest moves by one slope to either side.
    rests: Vec<bool>,
}

impl Passes {
    pub(crate) fn one(&self, which: usize, variable: usize) -> Option<&Followed> {
        self.each.get(which)?.get(variable / DIRECTIONS)
    }

    /// The press with the first length of step, its derivatives passing unresolved switches; the same one where it has
    /// none.
    pub(crate) fn passing(&self, variable: usize) -> Option<&Followed> {
        let own = self.passing.get(variable / DIRECTIONS)?;
        own.as_ref().or_else(|| self.one(0, variable))
    }

    /// Whether the rest has one slope by this number.
    pub(crate) fn has_rest(&self, variable: usize) -> bool {
        self.rests.get(variable).copied().unwrap_or(true)
    }

    /// Switches in the last stroke: those at which derivatives jumped, and those that could not be told from others.
    pub(crate) fn switches(&self) -> [u32; 2] {
        self.each.last().and_then(|all| all.last()).map_or([0; 2], Followed::counts)
    }
}

/// How a press is differentiated.
pub(super) struct How<'a> {
    pub rest: Rest,
    /// Lengths of step, as shares of the setup's.
    pub shares: &'a [f64],
    pub sample_every: Option<u64>,
    pub threads: usize,
}

/// The press with every length of step.
pub(super) fn passes<'a>(
    instrument: &Instrument,
    by: &[Variable],
    stroke: &(dyn Fn() -> Stroke<'a> + Sync),
    setup: &Setup,
    how: &How<'_>,
    progress: &mut Progress<'_>,
) -> Result<Passes, SensitivityError> {
    on_a_deep_stack(progress, &|_| check(instrument))?;
    // A hand begins where it is placed, and not where it aims.
    let begins_at_m = if setup.hand.is_some() { 0.0 } else { stroke()(setup.start_s).position_m().max(0.0) };
    let poses = Poses::of(instrument, begins_at_m, progress)?;
    let (directions, one_slope) = directions(instrument, by, begins_at_m, how, progress)?;
    // Without a number to differentiate by there is the press itself.
    let groups: Vec<&[Direction]> =
        if directions.is_empty() { vec![&[]] } else { directions.chunks(DIRECTIONS).collect() };
    let shares = how.shares;
    let mut found: Vec<Option<Followed>> = vec![None; shares.len() * groups.len()];
    let poses = &poses;
    let press = |group: &[Direction], share: f64, how: gradient::How, progress: &mut Progress<'_>| {
        let settings = Settings { step: setup.settings.step * share, ..setup.settings };
        let setup = Setup { settings, ..*setup };
        let followed = on_a_deep_stack(progress, &|progress| {
            follow(instrument, group, stroke().as_ref(), &setup, poses, how, progress)
        });
        followed.map_err(SensitivityError::from)
    };
    let press = &press;
    let work = found.iter_mut().enumerate().map(|(k, place)| {
        let (group, share) = (groups[k / shares.len()], shares[k % shares.len()]);
        let own = gradient::How { sample_every: how.sample_every, passes_unresolved: false };
        job(place, move |progress| press(group, share, own, progress))
    });
    do_all(work.collect(), how.threads, progress)?;
    let mut each = vec![Vec::new(); shares.len()];
    for (k, one) in found.into_iter().enumerate() {
        each[k % shares.len()].push(one.ok_or(SimulationError::Interrupted)?);
    }
    let mut passing: Vec<Option<Followed>> = vec![None; groups.len()];
    // One length of step is not judged.
    if shares.len() > 1 {
        let own = gradient::How { sample_every: None, passes_unresolved: true };
        let doubtful = passing.iter_mut().zip(&groups).zip(&each[0]).filter(|(_, one)| one.counts()[1] > 0);
        let work =
            doubtful.map(|((place, group), _)| job(place, move |progress| press(group, shares[0], own, progress)));
        do_all(work.collect(), how.threads, progress)?;
    }
    Ok(Passes { each, passing, rests: one_slope })
}

/// The directions of the numbers, with the slopes of the rest if it moves, and whether these are the same to both
/// sides. They are differences over so narrow a window that the search for the rest goes through the same switches:
/// some ten times what rounding leaves of a slope's digits.
fn directions(
    instrument: &Instrument,
    by: &[Variable],
    begins_at_m: f64,
    how: &How<'_>,
    progress: &mut Progress<'_>,
) -> Result<(Vec<Direction>, Vec<bool>), SensitivityError> {
    let held = || by.iter().map(|one| one.direction.clone());
    if how.rest == Rest::Held {
        return Ok((held().collect(), vec![true; by.len()]));
    }
    let mut instruments = vec![instrument.clone()];
    let mut places = Vec::with_capacity(by.len());
    for variable in by {
        let half = variable.rest_half();
        let sides = [-half, half].map(|by| variable.at(instrument, by));
        places.push(match sides {
            [Some(low), Some(high)] if !variable.is_force() => {
                instruments.extend([low, high]);
                Some((instruments.len() - 2, half))
            }
            _ => None,
        });
    }
    let found = rests(&instruments, begins_at_m, how.threads, progress)?;
    let Some(own) = &found[0] else { return Ok((held().collect(), vec![false; by.len()])) };
    let mut one_slope = Vec::with_capacity(by.len());
    let moved: Vec<Direction> = held()
        .zip(places)
        .map(|(direction, place)| {
            let Some((at, half)) = place else {
                one_slope.push(true);
                return direction;
            };
            let (Some(low), Some(high)) = (&found[at], &found[at + 1]) else {
                one_slope.push(false);
                return direction;
            };
            one_slope.push(are_one_slope(low, own, high, half));
            direction.moving(low, high, 2.0 * half)
        })
        .collect();
    Ok((moved, one_slope))
}

/// Whether the rest moves by the same slope from the lower number to the own one as from there to the higher one.
fn are_one_slope(low: &Poses, own: &Poses, high: &Poses, half: f64) -> bool {
    let slope = |a: &Poses, b: &Poses, i: usize| (b.start.angle[i] - a.start.angle[i]) / half;
    let (mut largest, mut apart) = (0.0_f64, 0.0_f64);
    for i in 0..own.start.angle.len() {
        let (below, above) = (slope(low, own, i), slope(own, high, i));
        largest = largest.max(below.abs()).max(above.abs());
        apart = apart.max((above - below).abs());
    }
    apart <= ONE_SLOPE * largest || apart < ROUNDING / half.min(1.0)
}

/// How often the caller is asked whether to go on.
const ASK_EVERY: Duration = Duration::from_millis(2);

/// Does work on a thread with a deep stack; on the caller's own where no thread is available. The caller's thread asks
/// on whether to go on.
fn on_a_deep_stack<T: Send>(progress: &mut Progress<'_>, work: &(dyn Fn(&mut Progress<'_>) -> T + Sync)) -> T {
    let stop = AtomicBool::new(false);
    let found = std::thread::scope(|scope| {
        let deep = std::thread::Builder::new()
            .stack_size(STACK_BYTES)
            .spawn_scoped(scope, || work(&mut |_| !stop.load(Ordering::Relaxed)))
            .ok()?;
        while !deep.is_finished() {
            if !progress(0.0) {
                stop.store(true, Ordering::Relaxed);
            }
            std::thread::park_timeout(ASK_EVERY);
        }
        Some(deep.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
    });
    found.unwrap_or_else(|| work(progress))
}
