//! `fit.json`.

use erard_workshop::fit::{FitResult, Problem};
use serde_json::{Value, json};

/// fit.json. Parameters are in SI units; of what was varied a factor or, of screws, how far they are turned.
pub(crate) fn report(found: &FitResult, problem: &Problem, instrument: &str) -> Value {
    let recordings = problem.recordings().iter().zip(&found.noise.drive_sigma).map(|(one, sigma)| {
        json!({
            "name": one.name,
            "drive": one.stroke.drive.name(),
            "samples": one.rows() * one.columns.len(),
            "drive_noise": sigma,
            "preparation": one.driven.report.json(),
        })
    });
    let parameters = found.values().enumerate().map(|(k, (one, value, std))| {
        let interval = [-1.0, 1.0].map(|way| one.si(found.x[k] + way * found.half_width_95[k]));
        let varied = json!({
            "kind": if one.parameter.is_factor() { "factor" } else { "turn" },
            "value": found.x[k],
            "std": found.std[k],
            "low": one.low,
            "high": one.high,
        });
        json!({
            "name": one.name,
            "unit": one.unit(),
            "value": value,
            "std": std,
            "interval_95": interval,
            "start": one.value,
            "low": one.si(one.low),
            "high": one.si(one.high),
            "at_a_bound": one.is_at_a_bound(found.x[k]),
            "varied": varied,
        })
    });
    let meanings = found.meanings.iter().map(|one| {
        json!({
            "name": one.name,
            "explanation": one.explanation,
            "quantity": one.quantity,
            "unit": one.unit,
            "start": one.before,
            "value": one.value,
            "std": one.std,
        })
    });
    let correlations = found
        .correlated()
        .into_iter()
        .map(|(i, j, correlation)| json!({"of": [found.parameters[i].name, found.parameters[j].name], "correlation": correlation}));
    let channels = problem.blocks().iter().zip(&found.channels).map(|(block, channel)| {
        json!({
            "recording": problem.recordings()[block.recording].name,
            "column": block.column,
            "noise": channel.noise,
            "noise_is_estimated": !channel.noise_is_known,
            "correlation_time_s": channel.correlation_time_s,
            "rms_at_start": channel.rms_at_start,
            "rms": channel.rms,
            "delay_s": channel.delay_s.map(|(s, _)| s),
            "delay_std_s": channel.delay_s.map(|(_, std)| std),
        })
    });
    let doubts = found.doubts.iter().map(|doubt| json!({"kind": doubt.kind.name(), "text": doubt.text}));
    json!({
        "instrument": instrument,
        "doubts": doubts.collect::<Value>(),
        "ended": found.message,
        "recordings": recordings.collect::<Value>(),
        "samples": found.residuals.len(),
        "independent_samples": found.independent_samples,
        "degrees_of_freedom": found.degrees_of_freedom,
        "chi2_reduced": found.chi2().map(|(reduced, _)| reduced),
        "chi2_expected": found.chi2().map(|(_, expected)| expected),
        "parameters": parameters.collect::<Value>(),
        "meanings": meanings.collect::<Value>(),
        "covariance": found.cov,
        "correlations": correlations.collect::<Value>(),
        "channels": channels.collect::<Value>(),
        "singular_values": found.singular_values,
        "unseen": found.unseen(),
        "jacobian_agreement": found.jacobian_agreement,
        "time_step_agreement": found.time_step_agreement,
        "strokes": found.evaluations,
        "strokes_with_derivatives": found.differentiated,
    })
}
