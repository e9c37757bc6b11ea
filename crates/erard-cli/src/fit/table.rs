//! The report for people, and the curves as a table.

use std::io::Write;

use erard_workshop::fit::{Channel, FitResult, Problem};

use super::values::unit_shown;
use crate::table::write_optional_csv;

/// Decimals with which a number with this error is shown: two digits of the error, at most six places behind the point; `None` where only powers of ten do.
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
        Some(decimals) => format!("{x:.decimals$}"),
        None => format!("{x:.3e}"),
    }
}

/// The report, line by line.
pub(crate) fn lines(found: &FitResult, problem: &Problem, instrument: &str) -> Vec<String> {
    let names: Vec<&str> = problem.data.iter().map(|one| one.name.as_str()).collect();
    let with = if found.differentiated > 0 {
        format!(" and {} with derivatives", found.differentiated)
    } else {
        String::new()
    };
    let mut lines = vec![
        format!("{instrument} fitted to {}", names.join(", ")),
        format!("  {} samples, {} strokes played{with}; {}", found.residuals.len(), found.evaluations, found.message),
        format!(
            "  reduced chi2 {:.3}; the noise of sensors and drive explains {:.3}",
            found.chi2_reduced, found.chi2_expected
        ),
        String::new(),
    ];
    let head = ["parameter", "value", "+-", "start", "from", "to", "unit", ""].map(str::to_owned);
    let rows = found.values().enumerate().map(|(k, (one, value, std))| {
        let (by, unit) = unit_shown(one.unit);
        let places = decimals(value * by, std * by);
        let number = |x: f64| shown(x * by, places);
        let end = if one.is_at_a_bound(found.x[k]) { "at its end" } else { "" };
        let bounds = [one.si(one.low), one.si(one.high)].map(number);
        let [low, high] = bounds;
        [one.name.clone(), number(value), number(std), number(one.value), low, high, unit.to_owned(), end.to_owned()]
    });
    let rows: Vec<[String; 8]> = std::iter::once(head).chain(rows).collect();
    let width = |k: usize| rows.iter().map(|row| row[k].chars().count()).max().unwrap_or(0);
    for row in &rows {
        let cells: Vec<String> = row
            .iter()
            .enumerate()
            .map(|(k, cell)| {
                let wide = width(k);
                if (1..6).contains(&k) { format!("{cell:>wide$}") } else { format!("{cell:<wide$}") }
            })
            .collect();
        lines.push(format!("  {}", cells.join("  ")).trim_end().to_owned());
    }
    lines.push(String::new());
    for (k, (recording, column)) in problem.channels().enumerate() {
        let (by, unit) = if column == "force_N" { (1e3, "mN") } else { (1e6, "um") };
        let whence = if problem.told[k].is_none() { ", estimated from what is left over" } else { "" };
        let late = match (found.channels[k].2, found.delay_std.get(k)) {
            (Some(delay), Some(std)) => {
                format!("; written down {:.3} +- {:.3} ms later than what drives", delay * 1e3, std * 1e3)
            }
            _ => String::new(),
        };
        lines.push(format!(
            "  {} of {}: noise {:.3} {unit}{whence}{late}",
            column,
            names[recording],
            problem.sigma[k] * by
        ));
    }
    let correlated = found.correlated();
    if !correlated.is_empty() {
        lines.push(String::new());
        lines.push("Correlations above 0.5".to_owned());
        lines.extend(
            correlated
                .into_iter()
                .map(|(i, j, r)| format!("  {} and {}: {r:+.2}", found.free[i].name, found.free[j].name)),
        );
    }
    let unseen = found.unseen();
    if !unseen.is_empty() {
        lines.push(String::new());
        lines.extend(unseen.into_iter().map(|told| format!("Not seen: {told}")));
    }
    lines
}

/// Every recording's curves, one below the other: what was measured, what was fitted, and what is left over in units of the noise.
///
/// # Errors
/// Of the writer.
pub(crate) fn write_csv(channels: &[Channel], recordings: usize, writer: &mut dyn Write) -> std::io::Result<()> {
    let mut names: Vec<&str> = channels.iter().map(|channel| channel.column).collect();
    names.sort_unstable();
    names.dedup();
    let mut columns: Vec<(String, Vec<Option<f64>>)> =
        vec![("recording".into(), Vec::new()), ("time_s".into(), Vec::new())];
    for name in &names {
        columns.extend(["measured_", "fitted_"].map(|what| (format!("{what}{name}"), Vec::new())));
        // In units of the noise it has no unit of its own.
        let bare = name.rsplit_once('_').map_or(*name, |(bare, _)| bare);
        columns.push((format!("left_over_{bare}"), Vec::new()));
    }
    for recording in 0..recordings {
        let own: Vec<&Channel> = channels.iter().filter(|channel| channel.recording == recording).collect();
        let Some(first) = own.first() else { continue };
        for (row, time_s) in first.time_s.iter().enumerate() {
            columns[0].1.push(Some(recording as f64 + 1.0));
            columns[1].1.push(Some(*time_s));
            for (k, name) in names.iter().enumerate() {
                let channel = own.iter().find(|channel| channel.column == *name);
                let of = |get: &dyn Fn(&Channel) -> f64| channel.map(|channel| get(channel));
                columns[2 + 3 * k].1.push(of(&|c| c.measured[row]));
                columns[3 + 3 * k].1.push(of(&|c| c.fitted[row]));
                columns[4 + 3 * k].1.push(of(&|c| (c.fitted[row] - c.measured[row]) / c.sigma));
            }
        }
    }
    write_optional_csv(&columns, writer)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_as_many_digits_as_their_errors() {
        for (value, error, told) in
            [(11.648_37, 0.012_3, "11.648"), (0.25, 3.0, "0.2"), (2e10, 1e8, "2.000e10"), (1.0, 0.0, "1.000e0")]
        {
            assert_eq!(shown(value, decimals(value, error)), told);
        }
    }
}
