//! Parameter study: many strokes on many variants of an instrument, in the processor's vector lanes and on all its
//! cores. A [`Grid`] plays and measures all combinations of what its [`Axis`]es vary.
//!
//! Mechanisms of the same topology are stepped together, as many as the processor has lanes; their results agree with
//! [`simulate`] to rounding (of single precision, if requested), and have the same bits for any number of threads. Only
//! the instants of each stroke are recorded. Instruments of up to nine bodies and twenty zones go in lanes, except
//! single bodies with up to four zones; the others are played one by one on all cores. So are instruments with modal
//! strings, and adaptive steps, because lanes share their steps.

mod axis;
mod grid;
mod job;
mod lanes;
mod rests;
mod sampling;
mod topology;

pub use axis::{Axis, GRADING, MAX_STROKES, Source, Target};
pub use grid::{Column, Grid, StudyRow, doubts, measured_title};
pub use job::{Job, JobResult, Played, Stroke};
pub(crate) use rests::rests;
pub use sampling::{Sampling, SamplingError};

pub use moreau_kernels::Lanes;

use crate::cores::{self, do_all, job};
use erard::IndexError;
use erard::Progress;
use erard::assembly::describe;
use erard::instrument::Instrument;
use erard::level::LevelError;
use erard::mechanism::Size;
use erard::player::Input;
use erard::run::{Setup, SimulationError, simulate};
use erard::trust::energy_residual;
use lanes::{Player, Rested, play, settle};
use topology::{Topology, groups};

/// Threads and lanes for the work.
#[derive(Debug, Clone, Copy)]
pub struct Workers {
    /// Number of threads.
    pub threads: usize,
    /// Lanes per thread. In single precision hammer speeds are accurate to some 1e-4; equilibria are found in doubles.
    pub lanes: Lanes,
}

impl Workers {
    /// Returns workers on all of the processor's threads.
    pub fn all() -> Self {
        Workers { threads: cores::count(), lanes: Lanes::most() }
    }

    /// Returns one worker, for callers that use the other threads themselves.
    pub fn one() -> Self {
        Workers { threads: 1, ..Workers::all() }
    }

    /// Returns workers on all threads, in single precision.
    pub fn all_single() -> Self {
        Workers { lanes: Lanes::most_single(), ..Workers::all() }
    }
}

/// A number of a job's result; `None` if the event did not happen.
pub(crate) type Outcome = fn(&Played) -> Option<f64>;

/// Results of a stroke, by the names of a study's columns, in SI units. Instants count from the stroke's start.
pub const OUTCOMES: [(&str, Outcome); 10] = [
    ("key_start_s", |p| p.events.key_start_s),
    ("toe_contact_s", |p| p.events.toe_contact_s),
    ("let_off_s", |p| p.events.let_off_s),
    ("hammer_contact_s", |p| p.events.hammer_contact_s()),
    ("hammer_speed_m_per_s", |p| p.events.hammer_speed_m_per_s()),
    ("key_bottom_s", |p| p.events.key_bottom_s),
    ("check_s", |p| p.events.check_s),
    ("impact_count", |p| Some(p.events.impacts.len() as f64)),
    ("hammer_highest_m", |p| Some(p.highest_m)),
    ("unconverged_steps", |p| Some(p.unconverged_steps as f64)),
];

/// Plays all jobs and returns their results in order. `setup` applies to all of them (nothing is recorded). `progress`
/// receives the share done and ends the work by returning false.
///
/// # Errors
/// A setup out of range, a job of an instrument that does not exist, or [`SimulationError::Interrupted`]; an error of
/// one job is that job's result.
pub fn play_all(
    instruments: &[Instrument],
    jobs: Vec<Job<'_>>,
    setup: &Setup,
    workers: Workers,
    progress: &mut Progress<'_>,
) -> Result<Vec<JobResult>, SimulationError> {
    sample_all(instruments, jobs, setup, None, workers, progress)
}

/// Result of a stroke, or its error.
pub type OwnResult = Result<Played, String>;

/// Makes the stroke for an instrument.
pub type MakeStroke<'a> =
    dyn Fn(&Instrument, &mut Progress<'_>) -> Result<erard::stroke::Stroke, LevelError> + Sync + 'a;

/// Plays on each instrument the stroke that `make` makes for it, one by one on each thread. A level out of reach is
/// that instrument's result.
///
/// # Errors
/// See [`play_all`].
pub fn play_each(
    instruments: &[Instrument],
    make: &MakeStroke<'_>,
    setup: &Setup,
    threads: usize,
    progress: &mut Progress<'_>,
) -> Result<Vec<OwnResult>, SimulationError> {
    let play = |instrument: &Instrument, progress: &mut Progress<'_>| {
        let stroke = match make(instrument, progress) {
            Ok(stroke) => stroke,
            Err(LevelError::Interrupted) => return Err(SimulationError::Interrupted),
            Err(error) => return Ok(Err(error.to_string())),
        };
        let stroke_inputs = match stroke.inputs(&instrument.finger) {
            Ok(inputs) => inputs,
            Err(error) => return Ok(Err(error.to_string())),
        };
        let setup = Setup { hand: stroke.hand(), ..*setup };
        let job = vec![Job { instrument: 0, stroke: stroke_inputs }];
        let mut played = play_all(std::slice::from_ref(instrument), job, &setup, Workers::one(), progress)?;
        Ok(played.remove(0).map_err(|error| error.to_string()))
    };
    cores::map(instruments, threads, progress, play)
}

/// Plays all jobs as [`play_all`] does, and samples every stroke if requested ([`Played::samples`]).
///
/// # Errors
/// See [`play_all`].
pub fn sample_all(
    instruments: &[Instrument],
    jobs: Vec<Job<'_>>,
    setup: &Setup,
    sampling: Option<&Sampling>,
    workers: Workers,
    progress: &mut Progress<'_>,
) -> Result<Vec<JobResult>, SimulationError> {
    setup.check()?;
    jobs.iter().try_for_each(|job| IndexError::check("instrument", job.instrument, instruments.len()))?;
    let in_lanes: Vec<bool> =
        instruments.iter().map(|i| Size::of(&describe(i)).has_lanes() && !i.has_yielding_strings()).collect();
    let mut results: Vec<Option<JobResult>> = jobs.iter().map(|_| None).collect();
    let count = jobs.len() as f64;
    let (lanes, others): (Vec<_>, Vec<_>) = jobs.into_iter().enumerate().partition(|(_, job)| {
        let by_force = || matches!((job.stroke)(setup.start_s), Input::Force(_));
        let seen = sampling.is_none_or(|sampling| sampling.is_seen_in_lanes(by_force()));
        in_lanes[job.instrument] && setup.tolerance.is_none() && seen
    });
    let share = lanes.len() as f64 / count.max(1.0);
    play_in_lanes(instruments, lanes, setup, workers, sampling, &mut results, &mut |own| progress(share * own))?;
    play_alone(instruments, others, setup, workers, sampling, &mut results, &mut |own| {
        progress(share + (1.0 - share) * own)
    })?;
    Ok(results.into_iter().map(|result| result.unwrap_or(Err(SimulationError::Interrupted))).collect())
}

/// Plays jobs one by one on several threads.
fn play_alone(
    instruments: &[Instrument],
    jobs: Vec<(usize, Job<'_>)>,
    setup: &Setup,
    workers: Workers,
    sampling: Option<&Sampling>,
    results: &mut [Option<JobResult>],
    progress: &mut Progress<'_>,
) -> Result<(), SimulationError> {
    let setup = Setup { record_every: Some(1), ..*setup };
    let indices: Vec<usize> = jobs.iter().map(|(index, _)| *index).collect();
    let mut outcomes: Vec<_> = jobs.iter().map(|_| None).collect();
    let work = jobs.into_iter().zip(&mut outcomes).map(|((_, Job { instrument, stroke }), outcome)| {
        let instrument = &instruments[instrument];
        job(outcome, move |progress| match simulate(instrument, stroke.as_ref(), &setup, progress) {
            Err(SimulationError::Interrupted) => Err(SimulationError::Interrupted),
            played => Ok(played.map(|run| Played {
                samples: sampling.map(|sampling| sampling.of_run(&run)).unwrap_or_default(),
                highest_m: run.hammer_rise_m.iter().fold(0.0, |a: f64, b| a.max(*b)),
                events: run.events,
                unconverged_steps: run.work.unconverged_steps,
                energy_residual: run.ledger.as_ref().map(energy_residual),
                warnings: run.warnings,
            })),
        })
    });
    do_all(work.collect(), workers.threads, progress)?;
    for (index, outcome) in indices.into_iter().zip(outcomes) {
        results[index] = outcome;
    }
    Ok(())
}

/// Assumed cost of an equilibrium, in seconds of stroke played in the same time, for the progress.
const REST_S: f64 = 0.3;

/// Plays jobs in lanes: first all instruments in use come to rest, then all strokes are played.
fn play_in_lanes(
    instruments: &[Instrument],
    jobs: Vec<(usize, Job<'_>)>,
    setup: &Setup,
    workers: Workers,
    sampling: Option<&Sampling>,
    results: &mut [Option<JobResult>],
    progress: &mut Progress<'_>,
) -> Result<(), SimulationError> {
    let Workers { threads, lanes } = workers;
    let settled_in = lanes.in_doubles();
    let mut used: Vec<usize> = jobs.iter().map(|(_, job)| job.instrument).collect();
    used.sort_unstable();
    used.dedup();
    let rests = used.len() as f64 * REST_S;
    let settling = rests / (rests + jobs.len() as f64 * setup.duration_s).max(f64::MIN_POSITIVE);

    let topologies: Vec<Topology> = used.iter().map(|&i| Topology::of(&instruments[i])).collect();
    let kinds = topologies.iter().enumerate().map(|(place, topology)| (topology, place));
    let settled_together = groups(kinds, settled_in.count());
    let mut outcomes: Vec<_> = settled_together.iter().map(|_| None).collect();
    let work = settled_together.iter().zip(&mut outcomes).map(|(group, outcome)| {
        let group: Vec<&Instrument> = group.iter().map(|&place| &instruments[used[place]]).collect();
        job(outcome, move |progress| settle(&group, setup.settings, settled_in, progress))
    });
    do_all(work.collect(), threads, &mut |share| progress(settling * share))?;
    let mut rested: Vec<Option<Rested>> = used.iter().map(|_| None).collect();
    for (group, outcome) in settled_together.iter().zip(outcomes) {
        for (place, one) in group.iter().zip(outcome.into_iter().flatten()) {
            rested[*place] = Some(one);
        }
    }

    let place_of = |instrument: usize| used.binary_search(&instrument).unwrap_or(0);
    let kinds: Vec<_> = jobs
        .iter()
        .map(|(_, job)| {
            let topology = &topologies[place_of(job.instrument)];
            let begins = (job.stroke)(setup.start_s);
            (topology, kind(&begins), begins.position_m() > 0.0)
        })
        .collect();
    let played_together = groups(kinds.into_iter().zip(0..), lanes.count());
    let (indices, jobs): (Vec<usize>, Vec<Job>) = jobs.into_iter().unzip();
    let mut waiting: Vec<Option<Job>> = jobs.into_iter().map(Some).collect();
    let mut outcomes: Vec<_> = played_together.iter().map(|_| None).collect();
    let mut work = Vec::new();
    let rested = &rested;
    for (group, outcome) in played_together.iter().zip(&mut outcomes) {
        let own = group.iter().filter_map(|&place| waiting[place].take());
        let players: Vec<Player> = own
            .filter_map(|Job { instrument, stroke }| {
                let rest = rested[place_of(instrument)].as_ref()?;
                Some(Player { instrument: &instruments[instrument], stroke, rest })
            })
            .collect();
        work.push(job(outcome, move |progress| play(&players, setup, sampling, lanes, progress)));
    }
    do_all(work, threads, &mut |share| progress(settling + (1.0 - settling) * share))?;
    for (group, outcome) in played_together.iter().zip(outcomes) {
        for (place, played) in group.iter().zip(outcome.into_iter().flatten()) {
            results[indices[*place]] = Some(played);
        }
    }
    Ok(())
}

/// Kind of an input, which lanes must share.
fn kind(input: &Input) -> u8 {
    match input {
        Input::Free => 0,
        Input::Force(_) => 1,
        Input::Motion { .. } => 2,
        Input::Hand(_) => 4,
        _ => 3,
    }
}
