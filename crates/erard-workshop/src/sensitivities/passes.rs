//! A press in numbers that carry derivatives, as often as there are groups of directions and lengths of step, on all
//! cores.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use erard::Progress;
use erard::gradient::{DIRECTIONS, Direction, Followed, Number, QUANTITIES, STACK_BYTES, follow};
use erard::instrument::Instrument;
use erard::run::{Setup, SimulationError};
use moreau::Settings;

use super::Variable;
use super::error::SensitivityError;
use crate::cores::{do_all, job};
use crate::study::Stroke;

/// A press, and what it depends on.
#[derive(Debug, Clone, PartialEq)]
pub struct Gradient {
    /// By what.
    pub by: Vec<Variable>,
    /// Of every quantity of [`QUANTITIES`]: its value, and its derivatives by every variable, per bare number
    /// (`Variable::per_bare_number`); `None` where it did not happen.
    pub of: Vec<(&'static str, Option<ValueAndSlopes>)>,
    /// Samples.
    pub sampled: Vec<Sampled>,
    /// Switches of friction at which derivatives jumped, and those that could not be told from others.
    pub switches: [u32; 2],
}

/// A value, and its derivatives by every variable.
pub(crate) type ValueAndSlopes = (f64, Vec<f64>);

/// A column, and its derivatives.
#[derive(Debug, Clone, PartialEq)]
pub struct Sampled {
    /// As in a run's table.
    pub name: &'static str,
    /// Its samples.
    pub values: Vec<f64>,
    /// Derivatives of the samples by every variable, per bare number.
    pub slopes: Vec<Vec<f64>>,
}

/// Plays a press with its derivatives by an instrument's numbers: of its instants and speeds, and of key travel, rise
/// of the hammer's head and finger's force after every so many steps, if asked for.
///
/// `stroke` makes what drives the key. `progress` receives the share done and ends the work by returning false.
///
/// # Errors
/// What cannot be differentiated or played.
pub fn gradient<'a>(
    instrument: &Instrument,
    by: Vec<Variable>,
    stroke: &(dyn Fn() -> Stroke<'a> + Sync),
    setup: &Setup,
    sample_every: Option<u64>,
    threads: usize,
    progress: &mut Progress<'_>,
) -> Result<Gradient, SensitivityError> {
    let instrument = &Instrument { parts: Vec::new(), ..instrument.clone() };
    let found = passes(instrument, &by, stroke, setup, &[1.0], sample_every, threads, progress)?;
    let bare: Vec<f64> = by.iter().map(Variable::per_bare_number).collect();
    let slope = |k: usize, of: &dyn Fn(&Followed) -> Option<Number>| {
        found.one(0, k).and_then(of).map_or(f64::NAN, |x| x.slope[k % DIRECTIONS] * bare[k])
    };
    let first = found.one(0, 0);
    let of = QUANTITIES.iter().map(|(key, get)| {
        let value = first.and_then(|one| get(&one.instants)).map(|x| x.value);
        let slopes = || (0..by.len()).map(|k| slope(k, &|one| get(&one.instants))).collect();
        (*key, value.map(|value| (value, slopes())))
    });
    let of = of.collect();
    let count = first.map_or(0, |one| one.samples.len());
    let sampled = ["key_m", "hammer_head_m", "force_N"].into_iter().enumerate().map(|(column, name)| Sampled {
        name,
        values: first.map_or_else(Vec::new, |one| one.samples.iter().map(|row| row[column].value).collect()),
        slopes: (0..by.len())
            .map(|k| (0..count).map(|n| slope(k, &|one| one.samples.get(n).map(|row| row[column]))).collect())
            .collect(),
    });
    let sampled = if sample_every.is_some() { sampled.collect() } else { Vec::new() };
    Ok(Gradient { of, sampled, switches: found.switches, by })
}

/// Gradients with every step.
#[derive(Default)]
pub(super) struct Passes {
    /// Of every length of step: of every eight numbers, one after the other.
    each: Vec<Vec<Followed>>,
    /// Switches in the last stroke: see [`Gradient::switches`].
    pub switches: [u32; 2],
}

impl Passes {
    pub(crate) fn one(&self, which: usize, variable: usize) -> Option<&Followed> {
        self.each.get(which)?.get(variable / DIRECTIONS)
    }
}

/// With steps that are these shares of the setup's.
#[allow(clippy::too_many_arguments)]
pub(super) fn passes<'a>(
    instrument: &Instrument,
    by: &[Variable],
    stroke: &(dyn Fn() -> Stroke<'a> + Sync),
    setup: &Setup,
    shares: &[f64],
    sample_every: Option<u64>,
    threads: usize,
    progress: &mut Progress<'_>,
) -> Result<Passes, SensitivityError> {
    let directions: Vec<_> = by.iter().map(|one| one.direction.clone()).collect();
    // Without a number to differentiate by there is the press itself.
    let groups: Vec<&[Direction]> =
        if directions.is_empty() { vec![&[]] } else { directions.chunks(DIRECTIONS).collect() };
    let mut found: Vec<Option<Followed>> = vec![None; shares.len() * groups.len()];
    let work = found.iter_mut().enumerate().map(|(k, place)| {
        let (group, step) = (groups[k / shares.len()], setup.settings.step * shares[k % shares.len()]);
        let setup = Setup { settings: Settings { step, ..setup.settings }, ..*setup };
        job(place, move |progress| -> Result<Followed, SensitivityError> {
            let followed = on_a_deep_stack(progress, &|progress| {
                let drive = stroke();
                follow(
                    instrument,
                    group,
                    drive.as_ref(),
                    &setup,
                    erard::player::equilibrium::STEP_S,
                    sample_every,
                    progress,
                )
            });
            Ok(followed?)
        })
    });
    do_all(work.collect(), threads, progress)?;
    let mut passes = Passes { each: vec![Vec::new(); shares.len()], switches: [0; 2] };
    for (k, one) in found.into_iter().enumerate() {
        let one = one.ok_or(SimulationError::Interrupted)?;
        if k == shares.len() - 1 {
            passes.switches = [one.switches, one.unresolved];
        }
        passes.each[k % shares.len()].push(one);
    }
    Ok(passes)
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
