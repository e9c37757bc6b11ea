//! A press in numbers that carry derivatives, for each group of directions and each step length, on all cores.

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

/// Treatment of the rest while a number changes a little.
///
/// With dry friction an action can rest in a whole range of poses; which one depends on the way there.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Rest {
    /// The rest moves like that of [`erard::simulate`], in which every variant comes to rest from the pose as drawn.
    #[default]
    Moves,
    /// Friction holds the rest: the angles are those of the unchanged action, despite changed felts and screws.
    Held,
}

/// Two one-sided slopes of the rest that differ by more than this share of the larger one are not one slope.
const ONE_SLOPE: f64 = 0.1;
/// Slopes of the rest below this, rad per unit, come from rounding.
const ROUNDING: f64 = 1e-9;

/// Presses in numbers that carry derivatives, for every step length.
#[derive(Default)]
pub(super) struct Passes {
    /// By step length, then by group of eight numbers.
    each: Vec<Vec<Followed>>,
    /// Presses with the first step length repeated, with derivatives passing unresolved switches; by group, `None`
    /// without such switches.
    passing: Vec<Option<Followed>>,
    /// By number: whether the rest has the same slope to both sides.
    rests: Vec<bool>,
}

impl Passes {
    pub(crate) fn one(&self, which: usize, variable: usize) -> Option<&Followed> {
        self.each.get(which)?.get(variable / DIRECTIONS)
    }

    /// The press with the first step length, with derivatives passing unresolved switches; the plain one if it has
    /// none.
    pub(crate) fn passing(&self, variable: usize) -> Option<&Followed> {
        let own = self.passing.get(variable / DIRECTIONS)?;
        own.as_ref().or_else(|| self.one(0, variable))
    }

    /// Whether the rest has the same slope to both sides of this number.
    pub(crate) fn has_rest(&self, variable: usize) -> bool {
        self.rests.get(variable).copied().unwrap_or(true)
    }

    /// Switches in the last stroke: those at which derivatives jumped, and unresolved ones.
    pub(crate) fn switches(&self) -> [u32; 2] {
        self.each.last().and_then(|all| all.last()).map_or([0; 2], Followed::counts)
    }
}

/// How a press is differentiated.
pub(super) struct How<'a> {
    pub rest: Rest,
    /// Step lengths, as shares of the setup's.
    pub shares: &'a [f64],
    pub sample_every: Option<u64>,
    pub threads: usize,
}

/// Plays the press with every step length.
pub(super) fn passes<'a>(
    instrument: &Instrument,
    by: &[Variable],
    stroke: &(dyn Fn() -> Stroke<'a> + Sync),
    setup: &Setup,
    how: &How<'_>,
    progress: &mut Progress<'_>,
) -> Result<Passes, SensitivityError> {
    on_a_deep_stack(progress, &|_| check(instrument))?;
    // With a hand, the fingertip begins where it is placed, not where it aims.
    let begins_at_m = if setup.hand.is_some() { 0.0 } else { stroke()(setup.start_s).position_m().max(0.0) };
    let poses = Poses::of(instrument, begins_at_m, progress)?;
    let (directions, one_slope) = directions(instrument, by, begins_at_m, how, progress)?;
    // Without numbers only the press itself is played.
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
    // A single step length needs no comparison.
    if shares.len() > 1 {
        let own = gradient::How { sample_every: None, passes_unresolved: true };
        let doubtful = passing.iter_mut().zip(&groups).zip(&each[0]).filter(|(_, one)| one.counts()[1] > 0);
        let work =
            doubtful.map(|((place, group), _)| job(place, move |progress| press(group, shares[0], own, progress)));
        do_all(work.collect(), how.threads, progress)?;
    }
    Ok(Passes { each, passing, rests: one_slope })
}

/// Returns the directions of the numbers, with the slopes of the rest if it moves, and whether these are the same to
/// both sides. The window of these differences is so narrow that the search for the rest goes through the same
/// switches: about ten times the limit set by rounding.
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

/// Whether the rest has the same slope below and above the number's own value.
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

/// Interval at which the caller is asked whether to go on.
const ASK_EVERY: Duration = Duration::from_millis(2);

/// Runs work on a thread with a deep stack, or on the caller's own if threads are not available. The caller's thread
/// keeps asking whether to go on.
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
