//! Runs shared by the subjects: a stroke or a force step, and its impact.
//!
//! Felts are touched at random phases between two steps, and the error of a single run depends on that phase. The root
//! mean square over nearly equal steps with different phases follows a law.

use moreau::{FrictionLaw, Settings};

use super::{Progress, ReproduceError};
use std::time::Instant;

use erard::instrument::Instrument;
use erard::player::{self, Drive};
use erard::run::Run;
use erard::run::{Setup, simulate};
use erard::stroke::{Series, Touch};

/// Number of steps for an averaged error: h, and 1/64, 2/64 ... less.
pub(crate) const NEIGHBOURS: u32 = 8;

/// Stroke of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Play {
    /// No force.
    Free,
    /// A constant force, N.
    Force(f64),
    /// A built-in stroke's force.
    Stroke(&'static str, Touch),
    /// A built-in stroke's motion, with a soft finger.
    Motion(&'static str, Touch),
}

impl Play {
    /// Runs it, recording every `record_every`-th step.
    pub(crate) fn run(
        self,
        instrument: &Instrument,
        settings: Settings<f64>,
        duration_s: f64,
        record_every: u64,
    ) -> Result<Run, ReproduceError> {
        self.run_told(instrument, settings, duration_s, record_every, &mut |_| true)
    }

    /// Runs it with progress, for runs that take seconds.
    pub(crate) fn run_told(
        self,
        instrument: &Instrument,
        settings: Settings<f64>,
        duration_s: f64,
        record_every: u64,
        progress: &mut Progress,
    ) -> Result<Run, ReproduceError> {
        let setup = Setup { settings, record_every: Some(record_every), ..Setup::new(duration_s) };
        let mut go = |drive: &Drive<'_>| Ok(simulate(instrument, drive, &setup, &mut |share| progress(share))?);
        let missing = |name: &str| ReproduceError::Instrument(format!("the built-in stroke {name} cannot be read"));
        match self {
            Play::Free => go(&|_| player::Input::Free),
            Play::Force(force) => go(&player::force(|_| force)),
            Play::Stroke(name, touch) => {
                let series = own(instrument, name, touch).and_then(|s| s.force).ok_or_else(|| missing(name))?;
                go(&player::force(series.drive()))
            }
            Play::Motion(name, touch) => {
                let series = own(instrument, name, touch).and_then(|s| s.position).ok_or_else(|| missing(name))?;
                go(&player::motion(series.drive()))
            }
        }
    }

    /// Returns its name.
    pub(crate) fn label(self) -> String {
        match self {
            Play::Free => "nothing".into(),
            Play::Force(force) => format!("{force} N held"),
            Play::Stroke(name, touch) => format!("{name} {}, by force", touched(touch)),
            Play::Motion(name, touch) => format!("{name} {}, by motion", touched(touch)),
        }
    }
}

/// Returns the stroke for an instrument: six rigid bodies have their own.
pub(super) fn own(instrument: &Instrument, name: &str, touch: Touch) -> Option<Series> {
    if instrument.has_bends() { Series::builtin(name, touch) } else { Series::rigid(name, touch) }
}

fn touched(touch: Touch) -> &'static str {
    match touch {
        Touch::Pressed => "pressed",
        Touch::Struck => "struck",
    }
}

/// Friction regularised by tanh, with a width in rad/s, a tenth of it in m/s at sliding contacts.
pub(crate) fn regularised(width: f64) -> FrictionLaw<f64> {
    FrictionLaw::Regularised { pivot_width: width, sliding_width: 0.1 * width }
}

/// An impact on the string.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FirstImpact {
    /// Speed of the strike point, m/s; NaN without an impact.
    pub speed: f64,
    /// Time of the impact, s.
    pub contact: f64,
    /// Newton iterations.
    pub newton: f64,
    /// Steps that did not converge.
    pub unconverged: u64,
    /// All steps.
    pub steps: u64,
    /// Elapsed over simulated time.
    pub of_real_time: f64,
}

/// Returns the first impact of a run.
pub(crate) fn impact(
    instrument: &Instrument,
    play: Play,
    settings: Settings<f64>,
    until: f64,
) -> Result<FirstImpact, ReproduceError> {
    let started = Instant::now();
    let run = play.run(instrument, settings, until, u64::MAX)?;
    let took_s = started.elapsed().as_secs_f64();
    Ok(FirstImpact {
        speed: run.events.hammer_speed_m_per_s().unwrap_or(f64::NAN),
        contact: run.events.hammer_contact_s().unwrap_or(f64::NAN),
        newton: run.work.newton_iterations as f64,
        unconverged: run.work.unconverged_steps,
        steps: run.work.steps,
        of_real_time: took_s / until,
    })
}

/// Errors of an impact at a step.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Rung {
    /// h, s.
    pub step: f64,
    /// The run at exactly h.
    pub impact: FirstImpact,
    /// Root mean square of the relative error of the hammer speed over the neighbouring steps.
    pub speed: f64,
    /// Root mean square error of the contact time, s.
    pub contact: f64,
}

/// Errors of an impact at several steps against an exact one.
pub(crate) fn ladder(
    instrument: &Instrument,
    play: Play,
    settings: Settings<f64>,
    steps: &[f64],
    exact: &FirstImpact,
    until: f64,
    progress: &mut Progress,
) -> Result<Vec<Rung>, ReproduceError> {
    let mut impacts: Vec<Option<FirstImpact>> = vec![None; steps.len()];
    let mut errors = |rung: usize, h: f64| {
        let b = impact(instrument, play, Settings { step: h, ..settings }, until)?;
        // The clock is read on all of them: the shortest time counts.
        let own: &mut FirstImpact = impacts[rung].get_or_insert(b);
        own.of_real_time = own.of_real_time.min(b.of_real_time);
        Ok([b.speed / exact.speed - 1.0, b.contact - exact.contact])
    };
    let errors = neighbouring(steps, &mut errors, progress)?;
    let rung = |((&step, impact), [speed, contact]): ((&f64, Option<FirstImpact>), [f64; 2])| {
        impact.map(|impact| Rung { step, impact, speed, contact })
    };
    Ok(steps.iter().zip(impacts).zip(errors).filter_map(rung).collect())
}

/// Errors at several steps, each the root mean square over nearly equal steps. `errors` returns those at a step near
/// one of these, named by its index.
pub(crate) fn neighbouring<const N: usize>(
    steps: &[f64],
    errors: &mut dyn FnMut(usize, f64) -> Result<[f64; N], ReproduceError>,
    progress: &mut Progress,
) -> Result<Vec<[f64; N]>, ReproduceError> {
    // A rung at half the step takes twice as long.
    let all: f64 = steps.iter().map(|h| 1.0 / h).sum();
    let mut done = 0.0;
    let mut means = Vec::with_capacity(steps.len());
    for (rung, &step) in steps.iter().enumerate() {
        let mut squares = [0.0; N];
        for k in 0..NEIGHBOURS {
            tell(progress, done / all)?;
            let found = errors(rung, step * (1.0 - f64::from(k) / 64.0))?;
            squares.iter_mut().zip(found).for_each(|(sum, error)| *sum += error * error);
            done += 1.0 / step / f64::from(NEIGHBOURS);
        }
        means.push(squares.map(|sum| (sum / f64::from(NEIGHBOURS)).sqrt()));
    }
    Ok(means)
}

/// Observed order of an error over a whole ladder.
pub(crate) fn order(rungs: &[Rung], error: fn(&Rung) -> f64) -> f64 {
    match (rungs.first(), rungs.last()) {
        (Some(a), Some(b)) if a.step > b.step => (error(a) / error(b)).ln() / (a.step / b.step).ln(),
        _ => f64::NAN,
    }
}

/// `count` steps, s: `first`, and each half of the one before.
pub(crate) fn halvings(first: f64, count: i32) -> Vec<f64> {
    (0..count).map(|k| first * 0.5_f64.powi(k)).collect()
}

/// Passes progress on; an error if the caller ends the work.
pub(crate) fn tell(progress: &mut Progress, share: f64) -> Result<(), ReproduceError> {
    if progress(share.clamp(0.0, 1.0)) { Ok(()) } else { Err(erard::run::SimulationError::Interrupted.into()) }
}
