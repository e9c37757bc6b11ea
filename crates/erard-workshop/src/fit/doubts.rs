//! Doubts about the result of a fit, each in one sentence.

use super::data::misfit_unit;
use super::drive_noise::DriveNoise;
use super::{Doubt, DoubtKind, FitError, FitResult, Problem, Simulator};

/// Data that end within this time after the first impact do not count as beyond it, s: the string has thrown the hammer
/// back, and the check is far.
const BEYOND_S: f64 = 5e-3;
/// Standard deviations beyond which a mean square is more than noise; exceeded by chance in about one of 4000 channels.
const CHANCE: f64 = 3.5;
/// Derivatives are doubtful if they change by more than this share with their difference step.
const UNSTEADY: f64 = 0.1;
/// A disturbed drive explains nothing if its mean square over the noise is smaller than this.
const QUIET: f64 = 0.1;
/// Attempts as good as the best one disagree beyond this many standard deviations.
const APART: f64 = 5.0;

/// Returns all doubts of a fit, sorted by kind.
///
/// # Errors
/// An interruption.
pub(super) fn doubts(
    simulator: &mut Simulator<'_>,
    found: &FitResult,
    drive_noise: &DriveNoise,
) -> Result<Vec<Doubt>, FitError> {
    let problem = simulator.problem();
    let mut doubts = Vec::new();
    let impacts = simulator.first_impacts(&found.point)?;
    for (one, modelled_s) in problem.recordings().iter().zip(&impacts) {
        let recorded_s = one.recorded_impact_s();
        let (first_s, last_s) = (one.time_s[0], one.time_s[one.compared.end - 1]);
        if let (Some(s), None) = (recorded_s, modelled_s) {
            let text = format!(
                "{}: the recorded hammer reaches the string at {s:.4} s; in the fitted model it never does",
                one.name
            );
            doubts.push(Doubt { kind: DoubtKind::NoImpact, text });
        }
        let impact_s = recorded_s.or(*modelled_s).filter(|s| last_s > s + BEYOND_S);
        if let Some(s) = impact_s {
            let text = format!(
                "{} continues for {:.0} ms after the first impact. There a tiny change of a parameter has large effects, and error bars are too small: fit only its first {:.3} s",
                one.name,
                1e3 * (last_s - s),
                s + 0.8 * BEYOND_S - first_s
            );
            doubts.push(Doubt { kind: DoubtKind::BeyondImpact, text });
        }
        let notes = one.note.map(str::to_owned).into_iter().chain(one.warnings());
        doubts.extend(notes.map(|note| Doubt { kind: DoubtKind::Recording, text: format!("{}: {note}", one.name) }));
    }
    doubts.extend(misfits(problem, found, drive_noise));
    doubts.extend(found.parameters.iter().zip(&found.x).filter(|(one, x)| one.is_at_a_bound(**x)).map(|(one, x)| {
        let end = if (x - one.low).abs() < (x - one.high).abs() { "lower" } else { "upper" };
        Doubt { kind: DoubtKind::Bound, text: format!("{} ended at its {end} bound", one.name) }
    }));
    doubts.extend(restarts(found));
    if found.jacobian_agreement > UNSTEADY {
        let text = format!(
            "derivatives by differences depend by {:.0} % on their step size: the model jumps as a parameter varies, and the error bars are too small",
            100.0 * found.jacobian_agreement
        );
        doubts.push(Doubt { kind: DoubtKind::Derivatives, text });
    }
    doubts.extend(unknown(found));
    doubts.sort_by_key(|doubt| doubt.kind);
    Ok(doubts)
}

/// Channels of known noise whose residuals exceed it, and channels of unknown noise whose residuals are correlated.
fn misfits(problem: &Problem, found: &FitResult, drive_noise: &DriveNoise) -> Vec<Doubt> {
    let mut doubts = Vec::new();
    for (k, (channel, block)) in found.channels.iter().zip(problem.blocks()).enumerate() {
        let rows = block.rows.clone();
        if !channel.noise_is_known {
            let correlation = from_sample_to_sample(&found.residuals[rows.clone()]);
            // A noisy drive makes correlated residuals, too.
            if drive_noise.largest(rows.clone()) < QUIET && correlation > CHANCE / (rows.len() as f64).sqrt() {
                let text = format!(
                    "the residuals of {} are correlated ({correlation:.2} from sample to sample), so they are misfit and not noise: the error bars are too small",
                    channel.title
                );
                doubts.push(Doubt { kind: DoubtKind::Misfit, text });
            }
            continue;
        }
        // The sensor's noise within its uncertainty; the largest effect of a disturbed drive.
        let chance = CHANCE * (2.0 / rows.len() as f64 + (2.0 * found.noise.uncertainty[k]).powi(2)).sqrt();
        let explained = channel.noise * (1.0 + chance + drive_noise.largest(rows)).sqrt();
        if channel.rms > explained {
            let (by, unit) = misfit_unit(block.column);
            let text = format!(
                "{} differs from the model by {:.3} {unit} rms; its noise explains at most {:.3} {unit}. The model does not describe the recording, and the error bars do not hold",
                channel.title,
                by * channel.rms,
                by * explained
            );
            doubts.push(Doubt { kind: DoubtKind::Misfit, text });
        }
    }
    doubts
}

/// Correlation of residuals with those one sample later. For n independent ones its standard deviation is 1 / sqrt(n).
fn from_sample_to_sample(residuals: &[f64]) -> f64 {
    let squares: f64 = residuals.iter().map(|x| x * x).sum();
    let products: f64 = residuals.windows(2).map(|pair| pair[0] * pair[1]).sum();
    if squares > 0.0 { products / squares } else { 0.0 }
}

fn restarts(found: &FitResult) -> Option<Doubt> {
    let [attempts, good] = found.attempts;
    let text = if attempts > 1 && good == 1 {
        format!("{attempts} starts led to different results, and only one of them to the best")
    } else if found.apart > APART {
        format!(
            "{good} of {attempts} starts fit equally well but differ by up to {:.0} standard deviations",
            found.apart
        )
    } else {
        return None;
    };
    Some(Doubt { kind: DoubtKind::Restarts, text })
}

fn unknown(found: &FitResult) -> impl Iterator<Item = Doubt> + '_ {
    let drive = (!found.silent.is_empty()).then(|| {
        format!(
            "the noise of {}, which drives the model, is unknown and taken as zero: if there is any, the error bars are too small",
            found.silent.join(" and ")
        )
    });
    let estimated: Vec<&str> =
        found.channels.iter().filter(|channel| !channel.noise_is_known).map(|channel| channel.title.as_str()).collect();
    let compared = (!estimated.is_empty()).then(|| {
        format!(
            "the noise of {} is unknown and estimated from the residuals: it cannot be distinguished from misfit",
            estimated.join(", ")
        )
    });
    drive.into_iter().chain(compared).map(|text| Doubt { kind: DoubtKind::NoiseUnknown, text })
}
