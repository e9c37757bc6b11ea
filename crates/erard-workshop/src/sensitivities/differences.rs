//! Differences over windows wide against the resolution of a step: compared with derivatives, and used for touch
//! weights.

use erard::Progress;
use erard::instrument::Instrument;
use erard::player::Input;
use erard::run::Events;
use erard::run::{Setup, SimulationError};

use super::error::SensitivityError;
use super::variable::Variable;
use crate::cores;
use crate::measure::weights::Touch;
use crate::study::{Job, JobResult, OUTCOMES, Played, Stroke, Workers, play_all};
use crate::weighing::touch;

/// Places at which the quantity is evaluated, in half windows from the number's value.
const PLACES: [f64; 4] = [-2.0, -1.0, 1.0, 2.0];
/// Least change visible in differences, as a share of the quantity.
const SEEN: f64 = 2e-5;
/// Two one-sided slopes that differ by more than this share of the larger one are not one slope.
const ONE_SLOPE: f64 = 0.5;

/// A slope over a window.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Differences {
    /// Derivative from differences to both sides, extrapolated from two windows.
    pub slope: f64,
    /// Difference between the two windows' results.
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
    pub(crate) fn new(instrument: &Instrument, by: &'a [Variable], half: fn(&Variable) -> f64) -> Self {
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

    /// Weighs all variants by slow loops.
    pub(crate) fn weigh(&self, threads: usize, progress: &mut Progress<'_>) -> Result<Vec<Touch>, SensitivityError> {
        let numbered: Vec<(usize, &Instrument)> = self.instruments.iter().enumerate().collect();
        cores::map(&numbered, threads, progress, |(k, instrument), progress| match touch(instrument, progress) {
            // A variant that cannot be weighed gives no differences; the instrument itself must be weighed.
            Err(error) if *k == 0 || error.is_interruption() => Err(error.into()),
            touch => Ok(touch.unwrap_or_default()),
        })
    }

    /// Differences of a stroke's quantity by a variable.
    pub(crate) fn of_events(&self, played: &[JobResult], variable: usize, key: &str) -> Option<Differences> {
        let value = |index: usize| played.get(index)?.as_ref().ok().and_then(|one| event(one, key));
        self.of(variable, value)
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
