//! `fit.json`.

use erard_workshop::fit::{FitResult, Problem};
use serde::Serialize;

use crate::compare::PreparedChannel;

/// The whole of it. SI units.
#[derive(Debug, Serialize)]
pub(crate) struct Report {
    instrument: String,
    /// Why the solver ended.
    ended: String,
    recordings: Vec<RecordingReport>,
    /// Samples that were compared.
    samples: usize,
    degrees_of_freedom: usize,
    /// Sum of the squared residuals over the degrees of freedom.
    chi2_reduced: f64,
    /// What it should be if the model were true.
    chi2_expected: f64,
    parameters: Vec<ParameterReport>,
    /// Of the parameters as they were varied, in their order.
    covariance: Vec<Vec<f64>>,
    correlations: Vec<CorrelationReport>,
    channels: Vec<ChannelReport>,
    /// Below 1 a direction is known no better from the data than from its bounds.
    singular_values: Vec<f64>,
    /// Such directions in words.
    unseen: Vec<String>,
    /// How far the derivatives depend on the length of their steps.
    jacobian_agreement: f64,
    strokes: u64,
    strokes_with_derivatives: u64,
    warnings: Vec<String>,
}

#[derive(Debug, Serialize)]
struct RecordingReport {
    name: String,
    /// `force`, `motion` or `rigid`.
    drive: &'static str,
    samples: usize,
    /// Noise of what drives, N or m; null where nothing tells it, and it counts as none.
    drive_noise: Option<f64>,
    /// What was done to what drives.
    preparation: Vec<PreparedChannel>,
}

#[derive(Debug, Serialize)]
struct ParameterReport {
    name: String,
    /// Of value, standard deviation, start and bounds.
    unit: &'static str,
    value: f64,
    std: f64,
    start: f64,
    low: f64,
    high: f64,
    at_a_bound: bool,
    varied: VariedReport,
}

/// The same as `study --vary` and Python's `vary` take it, in SI units.
#[derive(Debug, Serialize)]
struct VariedReport {
    /// `factor` or `turn`.
    kind: &'static str,
    value: f64,
    std: f64,
    low: f64,
    high: f64,
}

#[derive(Debug, Serialize)]
struct CorrelationReport {
    of: [String; 2],
    correlation: f64,
}

#[derive(Debug, Serialize)]
#[allow(non_snake_case)]
struct ChannelReport {
    recording: String,
    column: &'static str,
    /// N or m.
    noise: f64,
    /// Whether it was estimated from what is left over.
    noise_is_estimated: bool,
    /// How much later than the drive it was written down; null where that was not estimated.
    delay_s: Option<f64>,
    delay_std_s: Option<f64>,
}

impl Report {
    /// Of a fit.
    pub(crate) fn new(found: &FitResult, problem: &Problem, instrument: &str) -> Self {
        let recordings = problem.data.iter().zip(&problem.drive_sigma).map(|(one, sigma)| RecordingReport {
            name: one.name.clone(),
            drive: one.stroke.drive.name(),
            samples: one.rows() * one.columns.len(),
            drive_noise: *sigma,
            preparation: one.driven.report.channels.iter().map(PreparedChannel::new).collect(),
        });
        let parameters = found.values().enumerate().map(|(k, (one, value, std))| ParameterReport {
            name: one.name.clone(),
            unit: one.unit,
            value,
            std,
            start: one.value,
            low: one.si(one.low),
            high: one.si(one.high),
            at_a_bound: one.is_at_a_bound(found.x[k]),
            varied: VariedReport {
                kind: if one.parameter.is_factor() { "factor" } else { "turn" },
                value: found.x[k],
                std: found.std[k],
                low: one.low,
                high: one.high,
            },
        });
        let correlations = found.correlated().into_iter().map(|(i, j, correlation)| CorrelationReport {
            of: [found.free[i].name.clone(), found.free[j].name.clone()],
            correlation,
        });
        let channels = problem.channels().enumerate().map(|(k, (recording, column))| ChannelReport {
            recording: problem.data[recording].name.clone(),
            column,
            noise: problem.sigma[k],
            noise_is_estimated: problem.told[k].is_none(),
            delay_s: found.channels[k].2,
            delay_std_s: found.delay_std.get(k).copied(),
        });
        let seen = problem.data.iter().flat_map(|one| {
            let name = one.name.clone();
            let notes = one.note.map(str::to_owned).into_iter().chain(one.driven.report.warnings());
            notes.map(move |warning| format!("{name}: {warning}")).collect::<Vec<_>>()
        });
        Report {
            instrument: instrument.to_owned(),
            ended: found.message.clone(),
            recordings: recordings.collect(),
            samples: found.residuals.len(),
            degrees_of_freedom: found.degrees_of_freedom,
            chi2_reduced: found.chi2_reduced,
            chi2_expected: found.chi2_expected,
            parameters: parameters.collect(),
            covariance: found.cov.clone(),
            correlations: correlations.collect(),
            channels: channels.collect(),
            singular_values: found.singular_values.clone(),
            unseen: found.unseen(),
            jacobian_agreement: found.jacobian_agreement,
            strokes: found.evaluations,
            strokes_with_derivatives: found.differentiated,
            warnings: seen.chain(found.warnings()).collect(),
        }
    }

    /// What is to be said against it.
    pub(crate) fn warnings(&self) -> &[String] {
        &self.warnings
    }
}
