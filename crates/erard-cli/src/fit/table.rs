//! The report for people, and the curves as a table.

use erard_workshop::fit::{Channel, FitResult, Meaning, Problem, misfit_unit};

use crate::table::Table;

/// Decimals with which a number with this error is shown: two digits of the error, at most six places behind the point;
/// `None` where only powers of ten do.
fn decimals(value: f64, error: f64) -> Option<usize> {
    let size = value.abs().max(error);
    if !(error > 0.0 && error.is_finite() && size < 1e6 && (size == 0.0 || size >= 1e-3)) {
        return None;
    }
    Some((1.0 - error.log10().floor()).clamp(0.0, 6.0) as usize)
}

/// A number with so many decimals.
fn shown(x: f64, decimals: Option<usize>) -> String {
    match decimals {
        _ if !x.is_finite() => "unknown".to_owned(),
        Some(decimals) => format!("{x:.decimals$}"),
        None => format!("{x:.3e}"),
    }
}

/// The first lines: doubts, then each parameter with its error.
pub(crate) fn headlines(found: &FitResult) -> Vec<String> {
    let mut lines: Vec<String> = found.doubts.iter().map(|doubt| format!("Doubtful: {}.", doubt.text)).collect();
    for (k, (one, value, std)) in found.values().enumerate() {
        let (by, unit) = one.shown_unit();
        let places = decimals(value * by, if std.is_nan() { 1e-3 * (value * by).abs() } else { std * by });
        let number = |x: f64| shown(x * by, places);
        let half = one.si_error(found.x[k], found.half_width_95[k]);
        let error = if half.is_finite() {
            format!(" ({} to {}, 95 %)", number(value - half), number(value + half))
        } else {
            ", without an error bar".to_owned()
        };
        let line = format!("{} {} {unit}{error}; it was {} {unit}", one.name, number(value), number(one.value));
        lines.push(line.replace("  ", " ").replace(" ;", ";").trim_end().to_owned());
    }
    lines.push(match found.chi2() {
        Some((reduced, expected)) => {
            format!("Reduced chi2 {reduced:.3}; the noise of sensors and drive explains {expected:.3}.")
        }
        None => "Reduced chi2 is no test here: the noise is estimated from the residuals.".to_owned(),
    });
    lines
}

/// The rest of the report, line by line.
pub(crate) fn lines(found: &FitResult, problem: &Problem) -> Vec<String> {
    let with = if found.differentiated > 0 {
        format!(" and {} with derivatives", found.differentiated)
    } else {
        String::new()
    };
    let mut lines = Vec::from([
        format!("  {} samples, {} strokes played{with}; {}", found.residuals.len(), found.evaluations, found.message),
        match found.chi2() {
            Some((reduced, expected)) => {
                format!("  reduced chi2 {reduced:.3}; the noise of sensors and drive explains {expected:.3}")
            }
            None => "  reduced chi2: not a test, because the noise is estimated from the residuals".to_owned(),
        },
        String::new(),
    ]);
    let head = ["parameter", "value", "+-", "95 %", "start", "from", "to", "unit", ""].map(str::to_owned);
    let rows = found.values().enumerate().map(|(k, (one, value, std))| {
        let (by, unit) = one.shown_unit();
        // Without an error, four digits of the value.
        let places = decimals(value * by, if std.is_nan() { 1e-3 * (value * by).abs() } else { std * by });
        let number = |x: f64| shown(x * by, places);
        let end = if one.is_at_a_bound(found.x[k]) { "at its end" } else { "" };
        let bounds = [one.si(one.low), one.si(one.high)].map(number);
        let [low, high] = bounds;
        let half = one.si_error(found.x[k], found.half_width_95[k]);
        [
            one.name.clone(),
            number(value),
            number(std),
            number(half),
            number(one.value),
            low,
            high,
            unit.to_owned(),
            end.to_owned(),
        ]
    });
    lines.extend(Table::of(head, rows).lines());
    lines.push(match found.has_errors() {
        true => "  +-: one standard deviation; 95 %: half of that interval; both are due to noise alone".to_owned(),
        false => "  no errors: the recordings are too short for their noise".to_owned(),
    });
    for Meaning { name, explanation, quantity, unit, before, value, std } in &found.meanings {
        let places = decimals(*value, *std);
        let [value, std, before] = [*value, *std, *before].map(|x| shown(x, places));
        let text = format!("{name} is {explanation}: {quantity} {value} +- {std} {unit}, at the start {before} {unit}");
        lines.push(format!("  {text}"));
    }
    lines.push(String::new());
    lines.extend(misfits(found, problem));
    let correlated = found.correlated();
    if !correlated.is_empty() {
        lines.push(String::new());
        lines.push("Correlations above 0.5".to_owned());
        lines.extend(
            correlated
                .into_iter()
                .map(|(i, j, r)| format!("  {} and {}: {r:+.2}", found.parameters[i].name, found.parameters[j].name)),
        );
    }
    let unseen = found.unseen();
    if !unseen.is_empty() {
        lines.push(String::new());
        lines.extend(unseen.into_iter().map(|direction| format!("Not seen: {direction}")));
    }
    lines
}

/// Of every channel root mean square misfit where the fit began and at its end beside the sensor's noise, in the data's
/// unit; delays.
fn misfits(found: &FitResult, problem: &Problem) -> Vec<String> {
    let is_correlated = found.channels.iter().any(|channel| channel.correlation_time_s > 0.0);
    let correlated = if is_correlated { "correlated, ms" } else { "" };
    let head = ["measured less fitted, rms", "start", "end", "noise", "unit", correlated, ""].map(str::to_owned);
    let rows = problem.blocks().iter().zip(&found.channels).map(|(block, channel)| {
        let (by, unit) = misfit_unit(block.column);
        let places = decimals(channel.noise * by, 0.1 * channel.noise * by);
        let number = |x: f64| shown(x * by, places);
        [
            format!("{} of {}", block.column, problem.recordings()[block.recording].name),
            number(channel.rms_at_start),
            number(channel.rms),
            number(channel.noise),
            unit.to_owned(),
            match channel.correlation_time_s {
                time_s if time_s > 0.0 => format!("{:.2}", 1e3 * time_s),
                _ if is_correlated => "no".to_owned(),
                _ => String::new(),
            },
            if channel.noise_is_known { String::new() } else { "noise from the residuals".to_owned() },
        ]
    });
    let mut lines = Table::of(head, rows).lines();
    let late = problem.blocks().iter().zip(&found.channels).filter_map(|(block, channel)| {
        let (delay, std) = channel.delay_s?;
        let (name, delay, std) = (&problem.recordings()[block.recording].name, delay * 1e3, std * 1e3);
        Some(format!("  {} of {name}: delayed by {delay:.3} +- {std:.3} ms behind the drive", block.column))
    });
    lines.extend(late);
    lines
}

/// fit.csv: every recording's samples, one below the other.
pub(crate) fn table(channels: &[Channel], recordings: usize) -> Table<'static> {
    let mut names: Vec<&str> = channels.iter().map(|channel| channel.column).collect();
    names.sort_unstable();
    names.dedup();
    let own = |recording: usize| channels.iter().filter(move |channel| channel.recording == recording);
    let rows: Vec<(usize, usize, f64)> = (0..recordings)
        .filter_map(|recording| Some((recording, own(recording).next()?)))
        .flat_map(|(recording, first)| first.time_s.iter().enumerate().map(move |(row, time)| (recording, row, *time)))
        .collect();
    let mut table = Table::default()
        .optional("recording", rows.iter().map(|(recording, ..)| Some(*recording as f64 + 1.0)))
        .optional("time_s", rows.iter().map(|(.., time_s)| Some(*time_s)));
    for name in names {
        let column = |get: fn(&Channel, usize) -> f64| {
            let cell = |(recording, row, _): &(usize, usize, f64)| {
                own(*recording).find(|channel| channel.column == name).map(|channel| get(channel, *row))
            };
            rows.iter().map(cell).collect::<Vec<_>>()
        };
        let bare = name.rsplit_once('_').map_or(name, |(bare, _)| bare);
        table = table
            .optional(format!("measured_{name}"), column(|c, row| c.measured[row]))
            .optional(format!("fitted_{name}"), column(|c, row| c.fitted[row]))
            .optional(format!("left_over_{bare}"), column(|c, row| (c.fitted[row] - c.measured[row]) / c.sigma));
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_as_many_digits_as_their_errors() {
        for (value, error, expected) in
            [(11.648_37, 0.012_3, "11.648"), (0.25, 3.0, "0.2"), (2e10, 1e8, "2.000e10"), (1.0, 0.0, "1.000e0")]
        {
            assert_eq!(shown(value, decimals(value, error)), expected);
        }
    }
}
