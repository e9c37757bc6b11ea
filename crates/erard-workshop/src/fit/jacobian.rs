//! Derivatives of the residuals by the inner parameters: by differences in lanes, or by the model's own derivatives.

use crate::sensitivities::{Differentiation, Rest, Sampled, SensitivityError, Variable, gradient};
use crate::study::Stroke;
use erard::player::Input;
use erard::stroke::Prescribed;

use moreau::FrictionLaw;

use super::problem::moved;
use super::svd::Columns;
use super::{FitError, Problem};

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

impl Problem {
    /// Returns the model's own derivatives if requested and the step is the usual one, else differences.
    ///
    /// # Errors
    /// An interruption; a model without derivatives.
    pub(crate) fn jacobian(&mut self, point: &[f64], share: f64) -> Result<Columns, FitError> {
        if self.exact && share == DIFFERENCES[1] { self.by_gradient(point) } else { self.by_differences(point, share) }
    }

    /// Computes the Jacobian by central differences, all of them side by side in lanes.
    ///
    /// # Errors
    /// An interruption.
    pub fn by_differences(&mut self, point: &[f64], share: f64) -> Result<Columns, FitError> {
        let count = self.free.len();
        let mut points = vec![point.to_vec(); 2 * count + 1];
        for (k, one) in self.free.iter().enumerate() {
            let [low, high] = one.bounds();
            let by = if one.parameter.is_factor() { share } else { share * one.width() };
            points[2 * k][k] = (point[k] - by).clamp(low, high);
            points[2 * k + 1][k] = (point[k] + by).clamp(low, high);
        }
        let played = self.simulate(&points)?;
        let mut columns = Vec::with_capacity(point.len());
        for k in 0..count {
            let [below, above] = [2 * k, 2 * k + 1].map(|row| self.left(&points[row], &played, row));
            columns.push(slopes(&below, &above, points[2 * k + 1][k] - points[2 * k][k]));
        }
        for channel in 0..self.delays() {
            let [before, after] = [-DELAY_STEP_MS, DELAY_STEP_MS].map(|by| {
                let mut other = point.to_vec();
                other[count + channel] += by;
                self.left(&other, &played, 2 * count)
            });
            columns.push(slopes(&before, &after, 2.0 * DELAY_STEP_MS));
        }
        let middle = self.unweighted(point, &played, 2 * count);
        // A point that cannot be played keeps the residuals of `residuals`.
        if middle.iter().all(|x| x.is_finite()) {
            self.kept = Some((point.to_vec(), middle));
        }
        Ok(columns)
    }

    /// Computes the Jacobian by the model's own derivatives: each recording is played once, eight parameters at a time.
    ///
    /// # Errors
    /// An interruption; a model without derivatives.
    pub fn by_gradient(&mut self, point: &[f64]) -> Result<Columns, FitError> {
        let instrument = self.at(point).ok_or(FitError::Unplayable)?;
        let mut by = Vec::with_capacity(self.free.len());
        for one in &self.free {
            let variable = Variable::named(&instrument, "", &one.name);
            by.push(variable.map_err(|error| FitError::asked("jacobian", error.to_string()))?);
        }
        let mut played: Vec<Vec<Sampled>> = Vec::new();
        for one in &self.data {
            // Reports errors of the stroke before any work.
            drop(one.stroke.inputs(&instrument.finger)?);
            let stroke = || -> Stroke<'_> {
                one.stroke.inputs(&instrument.finger).unwrap_or_else(|_| Box::new(|_| Input::Free))
            };
            let (watch, count) = (&mut self.watch, self.evaluations);
            let setup = one.setup();
            let mut tell = |_: f64| watch(count);
            let how = Differentiation {
                rest: Rest::Moves,
                sample_every: Some(one.every),
                compares: false,
                refuses: false,
                of: Vec::new(),
                threads: self.threads,
            };
            let found = gradient(&instrument, by.clone(), &stroke, &setup, how, &mut tell)?;
            self.differentiated += 1;
            played.push(found.sampled);
        }
        self.go_on()?;
        let count = self.free.len();
        let mut columns = vec![Vec::with_capacity(self.rows()); count + self.delays()];
        for (channel, (i, name)) in self.channels().enumerate() {
            let one = &self.data[i];
            let missing = || FitError::asked("jacobian", format!("{name} has no derivatives; expected differences"));
            let own = played[i].iter().find(|own| own.name == name).ok_or_else(missing)?;
            let late_s = self.delay_s(point, channel);
            let curve = |values: &[f64]| {
                let mut values = values[..values.len().min(one.time_s.len())].to_vec();
                values.resize(one.time_s.len(), f64::NAN);
                moved(&one.time_s, &values, late_s)
            };
            let scale = 1.0 / self.sigma[channel];
            let mut push = |column: usize, values: &[f64], by: f64| {
                columns[column].extend(values[one.compared.clone()].iter().map(|x| finite(x * by * scale)));
            };
            for (k, slopes) in own.slopes.iter().enumerate() {
                // A factor's inner value is its logarithm, and factors begin at 1 for this instrument: d/dlog is
                // d/dfactor.
                push(k, &curve(slopes), self.free[k].slope_from_itself());
            }
            for other in 0..self.delays() {
                if other == channel {
                    // Delays are in ms.
                    push(count + other, &rates(&one.time_s, &curve(&own.values)), -1e-3);
                } else {
                    push(count + other, &vec![0.0; one.time_s.len()], 0.0);
                }
            }
        }
        if self.weights.is_some() {
            columns.iter_mut().for_each(|column| self.weigh(column));
        }
        Ok(columns)
    }

    /// Uses the model's own derivatives in the last steps. Models without them are reported before the work begins.
    ///
    /// # Errors
    /// See [`FitError`].
    pub(crate) fn use_gradient(&mut self, point: &[f64]) -> Result<(), FitError> {
        let rigid = |(i, name): (usize, &str)| self.data[i].stroke.drive == Prescribed::Rigid && name == "force_N";
        if self.channels().any(rigid) {
            let why = "force_N has no derivatives under a rigid drive, whose force is what its motion takes";
            return Err(FitError::asked("jacobian", format!("{why}; expected differences")));
        }
        if self.data.iter().any(|one| one.settings.friction != FrictionLaw::SetValued) {
            let why = "derivatives are those of set-valued friction, which truly sticks";
            return Err(FitError::asked("jacobian", format!("{why}; expected differences")));
        }
        match self.by_gradient(point) {
            Err(FitError::Sensitivity(SensitivityError::Gradient(error))) if !error.is_interruption() => {
                return Err(FitError::asked("jacobian", format!("{error}; expected differences")));
            }
            Err(error) => return Err(error),
            Ok(_) => {}
        }
        self.exact = true;
        Ok(())
    }
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
