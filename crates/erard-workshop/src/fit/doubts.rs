//! Doubts about the result of a fit, each in one sentence.

use std::ops::Range;

use crate::dense::{Cholesky, Columns, dot};

use super::correlation::independent_squares;
use super::data::misfit_unit;
use super::drive_noise::DriveNoise;
use super::noise::FEWEST_PER_PARAMETER;
use super::{Doubt, DoubtKind, FitError, FitResult, Problem, Simulator};

/// Data that end within this time after the first impact do not count as beyond it, s: the string has thrown the hammer
/// back, and the check is far.
const BEYOND_S: f64 = 5e-3;
/// Standard deviations beyond which a mean square is more than noise; exceeded by chance in about one of 4000 channels.
const CHANCE: f64 = 3.5;
/// Derivatives are doubtful if they change by more than this share with their difference step, or with the time step.
const UNSTEADY: f64 = 0.1;
/// A disturbed drive explains nothing if its mean square over the noise is smaller than this.
const QUIET: f64 = 0.1;
/// Every channel is compared with itself in so many pieces, of so many samples at least, and a piece that differs by
/// more standard deviations is no noise: by chance one of about a thousand fits has such a piece.
const PIECES: usize = 8;
const FEWEST_IN_A_PIECE: usize = 24;
const UNLIKE: f64 = 4.0;
/// Attempts as good as the best one disagree beyond this many standard deviations.
const APART: f64 = 5.0;

/// Returns all doubts of a fit, sorted by kind.
///
/// # Errors
/// An interruption.
pub(super) fn doubts(
    simulator: &mut Simulator<'_>,
    found: &FitResult,
    jacobian: &Columns,
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
    let mut whitened = found.residuals.clone();
    found.noise.whiten(problem, &mut whitened);
    doubts.extend(misfits(problem, found, &whitened, drive_noise));
    if found.noise.whitens {
        doubts.extend(unlike_noise(problem, found, &whitened, jacobian, drive_noise));
    }
    doubts.extend(too_short(problem, found));
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
    if found.time_step_agreement > UNSTEADY {
        let text = format!(
            "derivatives depend by {:.0} % on the time step: error bars are wrong by as much; use a shorter one",
            100.0 * found.time_step_agreement
        );
        doubts.push(Doubt { kind: DoubtKind::Derivatives, text });
    }
    doubts.extend(unknown(found));
    doubts.sort_by_key(|doubt| doubt.kind);
    Ok(doubts)
}

/// Channels of known noise whose residuals exceed it, and channels of unknown noise whose residuals are correlated.
fn misfits(problem: &Problem, found: &FitResult, whitened: &[f64], drive_noise: &DriveNoise) -> Vec<Doubt> {
    let mut doubts = Vec::new();
    for (k, (channel, block)) in found.channels.iter().zip(problem.blocks()).enumerate() {
        let rows = block.rows.clone();
        if !channel.noise_is_known {
            let correlation = from_sample_to_sample(&whitened[rows.clone()]);
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
        let samples = independent_squares(rows.len(), channel.correlation);
        let chance = CHANCE * (2.0 / samples + (2.0 * found.noise.uncertainty[k]).powi(2)).sqrt();
        let explained = channel.noise * (1.0 + chance + drive_noise.largest(rows)).sqrt();
        if channel.rms > explained {
            let (by, unit) = misfit_unit(block.column);
            let text = format!(
                "{} differs from the model by {:.3} {unit} rms; its noise explains at most {:.3} {unit}. The rest is the model's, which does not describe the recording: the error bars are about noise only and do not hold",
                channel.title,
                by * channel.rms,
                by * explained
            );
            doubts.push(Doubt { kind: DoubtKind::Misfit, text });
        }
    }
    doubts
}

/// Residuals that are larger or smaller for a while than noise, which does not change with time, can be: there the
/// model does not describe the recording, whatever noise was estimated. Says what the parameters would be without that
/// while.
fn unlike_noise(
    problem: &Problem,
    found: &FitResult,
    whitened: &[f64],
    jacobian: &Columns,
    drive_noise: &DriveNoise,
) -> Option<Doubt> {
    let pieces = found.channels.iter().zip(problem.blocks()).flat_map(|(channel, block)| {
        let own = &whitened[block.rows.clone()];
        // Known noise is 1, noise estimated from the residuals is their own mean square.
        let mean = if channel.noise_is_known { 1.0 } else { dot(own, own) / own.len() as f64 };
        let count = PIECES.min(own.len() / FEWEST_IN_A_PIECE).max(1);
        (0..count).map(move |n| {
            let rows = block.rows.start + own.len() * n / count..block.rows.start + own.len() * (n + 1) / count;
            (channel, block, rows, mean)
        })
    });
    let rated = pieces.map(|(channel, block, rows, mean)| {
        let own = &whitened[rows.clone()];
        let share = dot(own, own) / own.len() as f64 / (mean + drive_noise.largest_whitened(rows.clone()));
        (from_noise(share, own.len()), share, channel, block, rows)
    });
    let (deviations, share, channel, block, rows) = rated.max_by(|a, b| a.0.total_cmp(&b.0))?;
    if deviations < UNLIKE {
        return None;
    }
    let one = problem.recording_of(block);
    let time_s = |row: usize| one.time_s[one.compared.start + row - block.rows.start];
    let mut text = format!(
        "from {:.4} to {:.4} s the residuals of {} are {:.1} times its noise, which does not change with time: there the model does not describe the recording. Errors are about noise only",
        time_s(rows.start),
        time_s(rows.end - 1),
        channel.title,
        share.sqrt()
    );
    if let Some((k, by, errors)) = without(found, whitened, jacobian, &rows) {
        let one = &found.parameters[k];
        let (name, (shown, unit)) = (&one.name, one.shown_unit());
        let by = if one.parameter.is_factor() {
            format!("{:+.2} %", 100.0 * by / found.x[k])
        } else {
            format!("{:+.3} {unit}", shown * by)
        };
        text += &format!("; without these samples {name} would differ by {by}, {errors:.1} standard deviations");
    }
    Some(Doubt { kind: DoubtKind::Misfit, text })
}

/// Standard deviations by which the mean square of so many unit normal numbers is larger than it should be (Wilson and
/// Hilferty, PNAS 17 (1931)).
fn from_noise(mean_square: f64, samples: usize) -> f64 {
    let variance = 2.0 / (9.0 * samples as f64);
    (mean_square.cbrt() - (1.0 - variance)) / variance.sqrt()
}

/// The parameter that moves the most, in its standard deviations, if these rows are left out, how far it moves (as in
/// [`FitResult::x`]) and these deviations: one step of Gauss and Newton.
fn without(found: &FitResult, whitened: &[f64], jacobian: &Columns, rows: &Range<usize>) -> Option<(usize, f64, f64)> {
    let count = jacobian.len();
    let outside = |a: &[f64], b: &[f64]| dot(a, b) - dot(&a[rows.clone()], &b[rows.clone()]);
    let normal: Vec<f64> = (0..count * count).map(|n| outside(&jacobian[n / count], &jacobian[n % count])).collect();
    let seen: Vec<f64> = jacobian.iter().map(|column| -outside(column, whitened)).collect();
    let step = Cholesky::of(&normal, count)?.solve(&seen);
    let of = |k: usize| {
        let by = step[k] * found.parameters[k].slope(found.point[k]);
        (k, by, by.abs() / found.std[k])
    };
    let moves = (0..found.parameters.len()).map(of).filter(|(.., errors)| errors.is_finite());
    moves.max_by(|a, b| a.2.total_cmp(&b.2))
}

/// Correlated noise that leaves fewer independent samples than errors need.
fn too_short(problem: &Problem, found: &FitResult) -> Option<Doubt> {
    if found.has_errors() {
        return None;
    }
    let (samples, parameters) = (found.independent_samples, found.point.len());
    let length = |one: &super::Data| one.time_s[one.compared.end - 1] - one.time_s[one.compared.start];
    let (strokes, length_s) = (problem.recordings().len(), problem.recordings().iter().map(length).sum::<f64>());
    let times = FEWEST_PER_PARAMETER * parameters as f64 / samples;
    let longest = found.channels.iter().max_by(|a, b| a.correlation_time_s.total_cmp(&b.correlation_time_s))?;
    let text = format!(
        "the noise of {} is correlated over {:.1} ms: {} samples tell as much as {samples:.0} independent ones, fewer than {FEWEST_PER_PARAMETER:.0} for each of {parameters} numbers, so no errors are given. {:.2} s of recording would do, {} strokes like the {strokes} of {length_s:.2} s here",
        longest.title,
        1e3 * longest.correlation_time_s,
        found.residuals.len(),
        times * length_s,
        (times * strokes as f64).ceil(),
    );
    Some(Doubt { kind: DoubtKind::TooShort, text })
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
    let correlated: Vec<String> = found
        .channels
        .iter()
        .filter(|channel| !channel.noise_is_known && channel.correlation_time_s > 0.0)
        .map(|channel| format!("{} over {:.2} ms", channel.title, 1e3 * channel.correlation_time_s))
        .collect();
    let compared = (!estimated.is_empty()).then(|| {
        let with = match correlated.is_empty() {
            true => String::new(),
            false => format!(" (correlated: {})", correlated.join(", ")),
        };
        format!(
            "the noise of {} is unknown and estimated from the residuals{with}: it cannot be distinguished from misfit",
            estimated.join(", ")
        )
    });
    drive.into_iter().chain(compared).map(|text| Doubt { kind: DoubtKind::NoiseUnknown, text })
}
