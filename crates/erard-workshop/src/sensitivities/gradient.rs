//! A press and its derivatives by an instrument's numbers.

use erard::Progress;
use erard::gradient::{DIRECTIONS, Followed, Number, QUANTITIES};
use erard::instrument::Instrument;
use erard::run::Setup;

use super::differences::Window;
use super::error::SensitivityError;
use super::parting::{Refusal, parting};
use super::passes::{How, Passes, Rest, passes};
use super::variable::Variable;
use crate::study::Stroke;

/// A change of a quantity below this share, for the number's usual change, does not matter.
pub(super) const NEGLIGIBLE: f64 = 1e-5;
/// Derivatives that differ between step lengths by more than this share of the larger one do not converge.
const CONVERGED: f64 = 0.1;

/// Press with its derivatives.
#[derive(Debug, Clone, PartialEq)]
pub struct Gradient {
    /// Variables of the derivatives.
    pub by: Vec<Variable>,
    /// Value of every quantity of [`QUANTITIES`] and its derivatives by every variable, per bare number
    /// (`Variable::per_bare_number`); `None` if the event did not happen.
    pub of: Vec<(&'static str, Option<ValueAndSlopes>)>,
    /// Samples.
    pub sampled: Vec<Sampled>,
    /// Number of friction switches at which derivatives jumped, and of those that could not be distinguished.
    pub switches: [u32; 2],
    /// Derivatives that do not converge; they are NaN in `of`.
    pub refused: Vec<Refusal>,
}

/// A value, and its derivatives by every variable.
#[derive(Debug, Clone, PartialEq)]
pub struct ValueAndSlopes {
    /// The value.
    pub value: f64,
    /// Derivatives.
    pub slopes: Vec<f64>,
    /// Derivatives in steps of [`SHORTER`]; empty if they were not requested.
    pub in_shorter_steps: Vec<f64>,
    /// Uncertainty of each derivative from friction switches that could not be distinguished; empty likewise.
    pub unresolved: Vec<f64>,
}

/// A column, and its derivatives.
#[derive(Debug, Clone, PartialEq)]
pub struct Sampled {
    /// Name in a run's table.
    pub name: &'static str,
    /// Samples of the column.
    pub values: Vec<f64>,
    /// Derivatives of the samples by every variable, per bare number.
    pub slopes: Vec<Vec<f64>>,
}

/// Shorter step for the comparison of derivatives, as a share of the setup's.
pub const SHORTER: f64 = 0.8;

/// Settings of the differentiation of a press.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Differentiation {
    /// Treatment of the rest.
    pub rest: Rest,
    /// Number of steps between samples of the columns, if they are sampled.
    pub sample_every: Option<u64>,
    /// Plays the press once more in shorter steps, compares the derivatives, and refuses those that do not converge.
    pub compares: bool,
    /// Whether a derivative that does not converge is an error; otherwise it is listed.
    pub refuses: bool,
    /// Quantities whose derivatives are compared, by the names of [`QUANTITIES`]; empty for all.
    pub of: Vec<String>,
    /// Threads.
    pub threads: usize,
}

/// Plays a press with its derivatives by an instrument's numbers: of its instants and speeds and, if requested, of
/// sampled key travel, hammer rise and finger force.
///
/// `stroke` makes the drive of the key. `progress` receives the share done and ends the work by returning false.
///
/// # Errors
/// A press that cannot be differentiated or played; a derivative that does not converge.
pub fn gradient<'a>(
    instrument: &Instrument,
    by: Vec<Variable>,
    stroke: &(dyn Fn() -> Stroke<'a> + Sync),
    setup: &Setup,
    how: Differentiation,
    progress: &mut Progress<'_>,
) -> Result<Gradient, SensitivityError> {
    let instrument = &instrument.clone().without_outlines();
    let Differentiation { rest, sample_every, threads, .. } = how;
    let shares: &[f64] = if how.compares { &[1.0, SHORTER] } else { &[1.0] };
    let asked = How { rest, shares, sample_every, threads };
    let found = passes(instrument, &by, stroke, setup, &asked, progress)?;
    let mut all = collected(&found, by, &how);
    if how.compares {
        all.refused = refusals(&found, &all, &how.of);
        if !all.refused.is_empty() {
            look_to_both_sides(instrument, &mut all, stroke, setup, &how, progress)?;
        }
        if let (true, Some(first)) = (how.refuses, all.refused.first()) {
            let (told, more) = (first.told.clone(), all.refused.len() - 1);
            return Err(SensitivityError::Unconverged { told, more });
        }
        let places: Vec<[usize; 2]> = all.refused.iter().map(|one| one.place).collect();
        for [of, by] in places {
            if let Some(one) = &mut all.of[of].1 {
                one.slopes[by] = f64::NAN;
            }
        }
    }
    Ok(all)
}

fn collected(found: &Passes, by: Vec<Variable>, how: &Differentiation) -> Gradient {
    let bare: Vec<f64> = by.iter().map(Variable::per_bare_number).collect();
    let slope = |press: Option<&Followed>, k: usize, of: &dyn Fn(&Followed) -> Option<Number>| {
        press.and_then(of).map_or(f64::NAN, |x| x.slope[k % DIRECTIONS] * bare[k])
    };
    let first = found.one(0, 0);
    let of = QUANTITIES.iter().map(|(key, get)| {
        let value = first.and_then(|one| get(&one.instants)).map(|x| x.value);
        let slopes = |pass: usize| -> Vec<f64> {
            (0..by.len()).map(|k| slope(found.one(pass, k), k, &|one| get(&one.instants))).collect()
        };
        let passing = |k: usize| slope(found.passing(k), k, &|one| get(&one.instants));
        let one = value.map(|value| {
            let own = slopes(0);
            let compared = how
                .compares
                .then(|| (slopes(1), own.iter().enumerate().map(|(k, slope)| (slope - passing(k)).abs()).collect()));
            let (in_shorter_steps, unresolved) = compared.unwrap_or_default();
            ValueAndSlopes { value, slopes: own, in_shorter_steps, unresolved }
        });
        (*key, one)
    });
    let of = of.collect();
    let count = first.map_or(0, |one| one.samples.len());
    let sampled = ["key_m", "hammer_rise_m", "force_N"].into_iter().enumerate().map(|(column, name)| Sampled {
        name,
        values: first.map_or_else(Vec::new, |one| one.samples.iter().map(|row| row[column].value).collect()),
        slopes: (0..by.len())
            .map(|k| {
                (0..count)
                    .map(|n| slope(found.one(0, k), k, &|one| one.samples.get(n).map(|row| row[column])))
                    .collect()
            })
            .collect(),
    });
    let sampled = if how.sample_every.is_some() { sampled.collect() } else { Vec::new() };
    Gradient { of, sampled, switches: found.switches(), by, refused: Vec::new() }
}

/// Whether two derivatives of a value agree, or differ by too little to matter for the number's usual change.
pub(super) fn converges(a: f64, b: f64, usual: f64, value: f64) -> bool {
    let (larger, apart) = (a.abs().max(b.abs()), (a - b).abs());
    apart <= CONVERGED * larger || apart * usual <= NEGLIGIBLE * value.abs()
}

/// Returns the derivatives that do not converge, each with the event where this begins.
fn refusals(found: &Passes, all: &Gradient, asked: &[String]) -> Vec<Refusal> {
    let mut refused = Vec::new();
    for (of, (key, one)) in all.of.iter().enumerate() {
        let Some(one) = one.as_ref().filter(|_| asked.is_empty() || asked.iter().any(|asked| asked == key)) else {
            continue;
        };
        for (by, variable) in all.by.iter().enumerate() {
            let usual = variable.usual / variable.per_bare_number();
            let [a, b] = [one.slopes[by], one.in_shorter_steps[by]];
            let rests = found.has_rest(by) || a.abs() * usual <= NEGLIGIBLE * one.value.abs();
            let passes = converges(a, a + one.unresolved[by], usual, one.value);
            if rests && passes && converges(a, b, usual, one.value) {
                continue;
            }
            let event = match (rests, found.one(0, by), found.one(1, by)) {
                (true, Some(first), Some(second)) => {
                    let other = if passes { Some(second) } else { found.passing(by) };
                    other.and_then(|other| parting(first, other, by % DIRECTIONS))
                }
                _ => None,
            };
            refused.push(Refusal {
                place: [of, by],
                of: key,
                by: variable.name.clone(),
                slopes: [a, b],
                event,
                sides: None,
                told: String::new(),
            });
        }
    }
    refused
}

/// Plays the strokes for one-sided differences of numbers with a refused derivative.
fn look_to_both_sides<'a>(
    instrument: &Instrument,
    all: &mut Gradient,
    stroke: &(dyn Fn() -> Stroke<'a> + Sync),
    setup: &Setup,
    how: &Differentiation,
    progress: &mut Progress<'_>,
) -> Result<(), SensitivityError> {
    let mut numbers: Vec<usize> = all.refused.iter().map(|one| one.place[1]).collect();
    numbers.sort_unstable();
    numbers.dedup();
    let by: Vec<Variable> = numbers.iter().map(|&k| all.by[k].clone()).collect();
    let window = Window::new(instrument, &by, &|one: &Variable| one.window);
    let played = window.play_in_steps(&[1.0], stroke, setup, how.threads, progress)?;
    let steps_s = [1.0, SHORTER].map(|share| share * setup.settings.step);
    for one in &mut all.refused {
        let Ok(k) = numbers.binary_search(&one.place[1]) else { continue };
        let found = window.of_events(&played, &[1.0], k, one.of);
        let bare = by[k].per_bare_number();
        one.sides = found.map(|found| found.sides.map(|slope| slope * bare));
        one.told = one.tell(instrument, steps_s);
    }
    Ok(())
}
