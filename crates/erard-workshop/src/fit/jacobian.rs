//! Derivatives of the residuals by the solver's points: by differences in lanes, or by the model's own derivatives.

use crate::dense::Columns;
use crate::sensitivities::Sampled;
use erard::stroke::Prescribed;

use moreau::FrictionLaw;

use super::problem::{Problem, delayed};
use super::readings::Readings;
use super::simulator::Simulator;
use super::{FitError, NoiseModel};

/// Difference steps, as shares of a factor or of half the range of a screw: the middle one is used, all are compared.
pub const DIFFERENCES: [f64; 3] = [4e-3, 1e-3, 2.5e-4];
/// Half the step of a delay's difference, ms.
const DELAY_STEP_MS: f64 = 1e-2;

/// Method for the Jacobian of the last steps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Jacobian {
    /// By central differences.
    #[default]
    Differences,
    /// By the model's own derivatives.
    Gradient,
}

/// Multiplies the rows of a vector by their weights, if there are any.
pub(super) fn weigh(rows: &mut [f64], weights: Option<&[f64]>) {
    if let Some(weights) = weights {
        rows.iter_mut().zip(weights).for_each(|(row, weight)| *row *= weight);
    }
}

/// Computes the Jacobian by central differences, all of them side by side in lanes. Rows are multiplied by `weights`.
///
/// # Errors
/// An interruption.
pub fn by_differences(
    simulator: &mut Simulator<'_>,
    noise: &NoiseModel,
    weights: Option<&[f64]>,
    point: &[f64],
    share: f64,
) -> Result<Columns, FitError> {
    let problem = simulator.problem();
    Ok(Differences::play(simulator, point, share)?.columns(problem, noise, weights, &mut |_, _| ()))
}

/// Points about a middle one, and their readings.
pub(super) struct Differences {
    /// Two points for every parameter, then the middle.
    points: Vec<Vec<f64>>,
    readings: Vec<Readings>,
}

impl Differences {
    /// Plays a point and two points beside it for every parameter; `share` is the step. The simulator remembers the
    /// point.
    pub(super) fn play(simulator: &mut Simulator<'_>, point: &[f64], share: f64) -> Result<Self, FitError> {
        let problem = simulator.problem();
        let count = problem.parameters().len();
        let mut points = vec![point.to_vec(); 2 * count + 1];
        for (k, one) in problem.parameters().iter().enumerate() {
            let [low, high] = one.bounds();
            let by = if one.parameter.is_factor() { share } else { share * one.width() };
            points[2 * k][k] = (point[k] - by).clamp(low, high);
            points[2 * k + 1][k] = (point[k] + by).clamp(low, high);
        }
        let readings = simulator.play(&points)?;
        let middle = &readings[2 * count];
        // A point that cannot be played is played again where its residuals are asked for.
        if problem.fitted(point, middle).iter().flatten().all(|x| x.is_finite()) {
            simulator.remember(point, middle.clone());
        }
        Ok(Differences { points, readings })
    }

    /// Returns the Jacobian at the middle. `played` receives every other point with its residuals, without weights.
    pub(super) fn columns(
        &self,
        problem: &Problem,
        noise: &NoiseModel,
        weights: Option<&[f64]>,
        played: &mut dyn FnMut(&[f64], &[f64]),
    ) -> Columns {
        let count = problem.parameters().len();
        let (point, middle) = (&self.points[2 * count], &self.readings[2 * count]);
        let mut residuals = |point: &[f64], readings: &Readings| {
            let mut residuals = noise.residuals(problem, point, readings);
            played(point, &residuals);
            weigh(&mut residuals, weights);
            residuals
        };
        let mut columns = Vec::with_capacity(point.len());
        for k in 0..count {
            let [below, above] = [2 * k, 2 * k + 1].map(|row| residuals(&self.points[row], &self.readings[row]));
            columns.push(slopes(&below, &above, self.points[2 * k + 1][k] - self.points[2 * k][k]));
        }
        for delay in 0..problem.delays() {
            let [before, after] = [-DELAY_STEP_MS, DELAY_STEP_MS].map(|by| {
                let mut other = point.clone();
                other[count + delay] += by;
                residuals(&other, middle)
            });
            columns.push(slopes(&before, &after, 2.0 * DELAY_STEP_MS));
        }
        columns
    }
}

/// Computes the Jacobian by the model's own derivatives. Rows are multiplied by `weights`.
///
/// # Errors
/// An interruption; a model without derivatives.
pub fn by_gradient(
    simulator: &mut Simulator<'_>,
    noise: &NoiseModel,
    weights: Option<&[f64]>,
    point: &[f64],
) -> Result<Columns, FitError> {
    let problem = simulator.problem();
    let played = simulator.play_with_derivatives(point)?;
    let mut columns = gradient_columns(problem, noise, point, &played)?;
    for column in &mut columns {
        noise.whiten(problem, column);
        weigh(column, weights);
    }
    Ok(columns)
}

fn gradient_columns(
    problem: &Problem,
    noise: &NoiseModel,
    point: &[f64],
    played: &[Vec<Sampled>],
) -> Result<Columns, FitError> {
    let count = problem.parameters().len();
    let mut columns = vec![Vec::with_capacity(problem.rows()); count + problem.delays()];
    for (at, block) in problem.blocks().iter().enumerate() {
        let (name, one) = (block.column, problem.recording_of(block));
        let missing = || FitError::argument("jacobian", format!("{name} has no derivatives; expected differences"));
        let own = played[block.recording].iter().find(|own| own.name == name).ok_or_else(missing)?;
        let late_s = problem.delay_s(point, at);
        let curve = |values: &[f64]| {
            let mut values = values[..values.len().min(one.time_s.len())].to_vec();
            values.resize(one.time_s.len(), f64::NAN);
            delayed(&one.time_s, &values, late_s)
        };
        let scale = 1.0 / noise.sigma[at];
        let mut push = |column: usize, values: &[f64], by: f64| {
            columns[column].extend(values[one.compared.clone()].iter().map(|x| finite(x * by * scale)));
        };
        for (k, slopes) in own.slopes.iter().enumerate() {
            // The solver's value of a factor is its logarithm, and factors begin at 1 for this instrument: d/dlog is
            // d/dfactor.
            push(k, &curve(slopes), problem.parameters()[k].slope_from_itself());
        }
        for other in 0..problem.delays() {
            if other == at {
                // Delays are in ms.
                push(count + other, &rates(&one.time_s, &curve(&own.values)), -1e-3);
            } else {
                push(count + other, &vec![0.0; one.time_s.len()], 0.0);
            }
        }
    }
    Ok(columns)
}

/// Checks that the recordings of a problem have derivatives under their drives.
///
/// # Errors
/// See [`FitError`].
pub(super) fn check_gradient(problem: &Problem) -> Result<(), FitError> {
    let is_rigid = |one: &super::Data| one.stroke.drive == Prescribed::Rigid && one.columns.contains(&"force_N");
    if problem.recordings().iter().any(is_rigid) {
        let why = "force_N has no derivatives under a rigid drive, whose force is what its motion takes";
        return Err(FitError::argument("jacobian", format!("{why}; expected differences")));
    }
    if problem.recordings().iter().any(|one| one.settings.friction != FrictionLaw::SetValued) {
        let why = "derivatives are those of set-valued friction, which truly sticks";
        return Err(FitError::argument("jacobian", format!("{why}; expected differences")));
    }
    Ok(())
}

fn slopes(below: &[f64], above: &[f64], apart: f64) -> Vec<f64> {
    below.iter().zip(above).map(|(below, above)| finite((above - below) / apart)).collect()
}

/// Zero for a value that is not finite.
fn finite(x: f64) -> f64 {
    if x.is_finite() { x } else { 0.0 }
}

/// The rate of a curve at even instants: central differences, one-sided at the ends.
fn rates(times: &[f64], curve: &[f64]) -> Vec<f64> {
    let last = curve.len() - 1;
    (0..curve.len())
        .map(|k| {
            let (a, b) = (k.saturating_sub(1), (k + 1).min(last));
            (curve[b] - curve[a]) / (times[b] - times[a])
        })
        .collect()
}
