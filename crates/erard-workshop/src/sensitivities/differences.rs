//! Differences over windows wide against the resolution of a step, in steps of several lengths: compared with
//! derivatives, and used for touch weights.

use erard::Progress;
use erard::Settings;
use erard::instrument::Instrument;
use erard::player::Input;
use erard::run::{Events, Setup, SimulationError};

use super::error::SensitivityError;
use super::mark::{Mark, STEP_ERROR};
use super::variable::Variable;
use crate::cores;
use crate::measure::weights::Touch;
use crate::study::{Job, JobResult, OUTCOMES, Played, Stroke, Workers, play_all};
use crate::weighing::touch;

/// Steps of the differences, as shares of the stroke's own.
pub(super) const STEPS: [f64; 2] = [1.0, 0.5];
/// Places at which the quantity is evaluated, in half windows from the number's value.
const PLACES: [f64; 4] = [-2.0, -1.0, 1.0, 2.0];
/// Least change visible in differences, as a share of the quantity.
const SEEN: f64 = 2e-5;
/// Two one-sided slopes that differ by more than this share of the larger one are not one slope.
const ONE_SLOPE: f64 = 0.5;
/// Windows over which derivative and differences that disagree are compared again, as shares of the first one.
const NARROWER: [f64; 3] = [1.0 / 4.0, 1.0 / 16.0, 1.0 / 64.0];
/// See [`NARROWER`].
const WIDER: [f64; 2] = [4.0, 16.0];
/// Differences whose two windows disagree by more than this share say nothing about a derivative.
const CLEAR: f64 = 0.1;

/// A slope over a window.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Differences {
    /// Derivative from differences to both sides, extrapolated from two windows.
    pub slope: f64,
    /// Change between the two windows, and of a stroke's results the errors of corners and of the time step.
    pub error: f64,
    /// Differences downward and upward.
    pub sides: [f64; 2],
    /// Deviation of the five values from a cubic: a sixteenth of their fourth difference.
    left: f64,
    window: f64,
}

impl Differences {
    /// Differences of the values at -2, -1, 0, 1 and 2 times `window`.
    fn of([a, b, m, c, d]: [f64; 5], window: f64) -> Self {
        let (near, far) = ((c - b) / (2.0 * window), (d - a) / (4.0 * window));
        Differences {
            slope: (4.0 * near - far) / 3.0,
            error: (near - far).abs(),
            sides: [(m - b) / window, (c - m) / window],
            left: (a - 4.0 * b + 6.0 * m - 4.0 * c + d).abs() / 16.0,
            window,
        }
    }

    /// Differences in the shortest of several steps, which are shares of a stroke's own, with the errors of corners and
    /// of the time step. An error in proportion to the step is as large as the change from a step twice as long, and
    /// larger than the change from a step less than twice as long by share / (longer - share).
    fn in_steps(found: &[Self], shares: &[f64]) -> Option<Self> {
        let (shortest, share) = (*found.last()?, *shares.last()?);
        let longer = found.iter().zip(shares).take(found.len() - 1);
        let step = longer.map(|(one, longer)| (one.slope - shortest.slope).abs() * (share / (longer - share)).max(1.0));
        // A corner at the number's own value changes the slope by this much to either side.
        let corner = 4.0 * shortest.left / shortest.window;
        Some(Differences { error: shortest.error + corner + step.fold(0.0, f64::max), ..shortest })
    }

    /// Whether these are clear differences with the slope of a derivative, whose error in the time step is given.
    fn shows(&self, slope: f64, error: f64) -> bool {
        self.error <= CLEAR * self.slope.abs().max(slope.abs()) && (self.slope - slope).abs() <= error + self.error
    }

    /// Whether a derivative lies between the slopes to both sides.
    fn encloses(&self, slope: f64, error: f64) -> bool {
        let [below, above] = self.sides;
        (below.min(above) - error..=below.max(above) + error).contains(&slope)
    }

    /// Whether the change of the quantity is visible in differences.
    pub(crate) fn matters(&self, value: f64) -> bool {
        self.slope.abs() * self.window > SEEN * value.abs()
    }

    /// Whether the two sides have different slopes, and no smooth curve fits the values.
    pub(crate) fn jumps(&self) -> bool {
        let [below, above] = self.sides;
        let larger = below.abs().max(above.abs());
        (above - below).abs() > ONE_SLOPE * larger && self.left > 0.1 * larger * self.window
    }
}

/// The variants needed for differences.
pub(super) struct Window<'a> {
    by: &'a [Variable],
    instruments: Vec<Instrument>,
    /// Indices of each variable's instruments; `None` if it cannot be changed to both sides.
    places: Vec<Option<[usize; 4]>>,
    /// Half the window of each variable.
    half: Vec<f64>,
}

impl<'a> Window<'a> {
    pub(crate) fn new(instrument: &Instrument, by: &'a [Variable], half: &dyn Fn(&Variable) -> f64) -> Self {
        let mut instruments = vec![instrument.clone()];
        let places = by
            .iter()
            .map(|variable| {
                let varied: Option<Vec<Instrument>> =
                    PLACES.iter().map(|place| variable.at(instrument, place * half(variable))).collect();
                varied.map(|varied| {
                    let from = instruments.len();
                    instruments.extend(varied);
                    core::array::from_fn(|k| from + k)
                })
            })
            .collect();
        Window { by, instruments, places, half: by.iter().map(half).collect() }
    }

    /// Plays the stroke on all variants.
    pub(crate) fn play<'s>(
        &self,
        stroke: &(dyn Fn() -> Stroke<'s> + Sync),
        setup: &Setup,
        threads: usize,
        progress: &mut Progress<'_>,
    ) -> Result<Vec<JobResult>, SimulationError> {
        let mut force = vec![0.0; self.instruments.len()];
        for ((variable, places), half) in self.by.iter().zip(&self.places).zip(&self.half) {
            for (place, index) in PLACES.iter().zip(places.iter().flatten()) {
                force[*index] = if variable.is_force() { place * half } else { 0.0 };
            }
        }
        let jobs = force.into_iter().enumerate().map(|(instrument, more)| {
            let own = stroke();
            let stroke: Stroke<'s> = match more {
                0.0 => own,
                more => Box::new(move |t| match own(t) {
                    Input::Force(force_n) => Input::Force(force_n + more),
                    other => other,
                }),
            };
            Job { instrument, stroke }
        });
        let workers = Workers { threads, ..Workers::all() };
        let setup = Setup { ledger: false, ..*setup };
        play_all(&self.instruments, jobs.collect(), &setup, workers, progress)
    }

    /// Plays the stroke on all variants in each of several steps, given as shares of the setup's.
    pub(crate) fn play_in_steps<'s>(
        &self,
        shares: &[f64],
        stroke: &(dyn Fn() -> Stroke<'s> + Sync),
        setup: &Setup,
        threads: usize,
        progress: &mut Progress<'_>,
    ) -> Result<Vec<Vec<JobResult>>, SimulationError> {
        let work: f64 = shares.iter().map(|share| 1.0 / share).sum();
        let mut done = 0.0;
        let mut all = Vec::with_capacity(shares.len());
        for share in shares {
            let settings = Settings { step: setup.settings.step * share, ..setup.settings };
            let setup = Setup { settings, ..*setup };
            let part = 1.0 / share / work;
            all.push(self.play(stroke, &setup, threads, &mut |own| progress(done + part * own))?);
            done += part;
        }
        Ok(all)
    }

    /// Weighs all variants by slow loops.
    pub(crate) fn weigh(&self, threads: usize, progress: &mut Progress<'_>) -> Result<Vec<Touch>, SensitivityError> {
        let numbered: Vec<(usize, &Instrument)> = self.instruments.iter().enumerate().collect();
        cores::map(&numbered, threads, progress, |(k, instrument), progress| match touch(instrument, progress) {
            // A variant that cannot be weighed gives no differences; the instrument itself must be weighed.
            Err(error) if *k == 0 || error.is_interruption() => Err(error.into()),
            touch => Ok(touch.unwrap_or_default()),
        })
    }

    /// Differences of a stroke's quantity by a variable, from the stroke in each of several steps, which are shares of
    /// its own.
    pub(crate) fn of_events(
        &self,
        played: &[Vec<JobResult>],
        shares: &[f64],
        variable: usize,
        key: &str,
    ) -> Option<Differences> {
        let in_one = |played: &Vec<JobResult>| {
            self.of(variable, |index| played.get(index)?.as_ref().ok().and_then(|one| event(one, key)))
        };
        let found: Option<Vec<Differences>> = played.iter().map(in_one).collect();
        Differences::in_steps(&found?, shares)
    }

    /// Differences of a weight by a variable.
    pub(crate) fn of_weights(&self, weighed: &[Touch], variable: usize, key: &str) -> Option<Differences> {
        self.of(variable, |index| weight(weighed.get(index)?, key))
    }

    fn of(&self, variable: usize, value: impl Fn(usize) -> Option<f64>) -> Option<Differences> {
        let [a, b, c, d] = self.places[variable]?;
        let values = [value(a)?, value(b)?, value(0)?, value(c)?, value(d)?];
        Some(Differences::of(values, self.half[variable]))
    }
}

/// Windows of several widths in the shortest step, for what disagrees over the first one.
pub(super) struct OtherWindows<'a> {
    windows: Vec<(f64, Window<'a>, Vec<Vec<JobResult>>)>,
}

impl<'a> OtherWindows<'a> {
    /// Plays the stroke on variants of these numbers.
    pub(super) fn play<'s>(
        instrument: &Instrument,
        by: &'a [Variable],
        stroke: &(dyn Fn() -> Stroke<'s> + Sync),
        setup: &Setup,
        threads: usize,
        progress: &mut Progress<'_>,
    ) -> Result<Self, SimulationError> {
        let shares = NARROWER.iter().chain(&WIDER);
        let count = (NARROWER.len() + WIDER.len()) as f64;
        let mut windows = Vec::new();
        for (k, &width) in shares.enumerate() {
            let window = Window::new(instrument, by, &|one| width * one.window);
            let played = window.play_in_steps(&STEPS[STEPS.len() - 1..], stroke, setup, threads, &mut |own| {
                progress((k as f64 + own) / count)
            })?;
            windows.push((width, window, played));
        }
        Ok(OtherWindows { windows })
    }

    /// Why the derivative of a quantity by a variable, with half the range of its steps, differs from `first`, its
    /// differences over the first window.
    pub(super) fn why(
        &self,
        variable: usize,
        key: &str,
        [slope, spread]: [f64; 2],
        first: Option<Differences>,
    ) -> (Mark, String) {
        let error = STEP_ERROR * spread;
        let found: Vec<(f64, Differences)> = self
            .windows
            .iter()
            .filter_map(|(width, window, played)| {
                Some((*width, window.of_events(played, &STEPS[STEPS.len() - 1..], variable, key)?))
            })
            .collect();
        let shows = |(_, one): &&(f64, Differences)| one.shows(slope, error);
        let (narrower, wider): (Vec<_>, Vec<_>) = found.into_iter().partition(|(width, _)| *width < 1.0);
        let half = |one: &Differences| {
            let variable = self.windows.first().map(|(_, window, _)| &window.by[variable]);
            format!("{} {}", float(one.window), variable.map_or("", |one| one.per))
        };
        if let Some((_, one)) = narrower.iter().find(shows) {
            let text = format!("the result bends: differences over {} to both sides agree", half(one));
            return (Mark::Local, text);
        }
        if let Some((_, one)) = wider.iter().find(shows) {
            let text = format!(
                "over a narrow window no switch of friction or contact moves by a whole step: differences over {} to \
                 both sides agree",
                half(one)
            );
            return (Mark::Steps, text);
        }
        let corner = first.into_iter().chain(narrower.iter().map(|(_, one)| *one));
        if let Some(one) = corner.into_iter().find(|one| one.encloses(slope, error)) {
            let text = format!(
                "the result has a corner or a jump within {}: the derivative is between the slopes to both sides",
                half(&one)
            );
            return (Mark::Jumps, text);
        }
        (Mark::Apart, "differences over no window agree: shorter time steps decide".to_owned())
    }
}

/// At most three digits of a window's width.
fn float(x: f64) -> f64 {
    let digits = 10_f64.powf(2.0 - x.abs().log10().floor());
    (x * digits).round() / digits
}

/// Weight by its key, g.
pub(super) fn weight(touch: &Touch, key: &str) -> Option<f64> {
    match key {
        "down_weight_g" => touch.down_weight_g,
        "up_weight_g" => touch.up_weight_g,
        _ => touch.balance_weight_g(),
    }
}

/// Quantity of a stroke by its key.
fn event(played: &Played, key: &str) -> Option<f64> {
    let events: &Events = &played.events;
    match key {
        "key_bottom_after_impact_s" => events.key_bottom_after_impact_s(),
        "free_flight_s" => events.free_flight_s(),
        "key_start_to_hammer_s" => Some(events.hammer_contact_s()? - events.key_start_s?),
        _ => OUTCOMES.iter().find(|(name, _)| *name == key).and_then(|(_, of)| of(played)),
    }
}
