//! The rows of a study: printed, and as columns of a file.

use erard::run::Events;
use erard::trust::worst_of_each;
use erard_workshop::measure::norms::Line;
use erard_workshop::study::{OUTCOMES, Played};

use super::Axis;
use crate::table::three;

/// One stroke of a study.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Row {
    /// What was varied, as shown, one for each axis.
    pub values: Vec<f64>,
    /// What came of it, or why nothing did.
    pub outcome: Result<Played, String>,
    /// What was measured of the variant, in the order asked for; or why nothing could be.
    pub measured: Result<Vec<Option<f64>>, String>,
}

impl Row {
    /// Whether it was played and nothing speaks against it.
    pub(crate) fn is_trusted(&self) -> bool {
        self.outcome.as_ref().is_ok_and(|played| played.warnings.is_empty())
    }
}

/// What speaks against the strokes of a study: of every kind and part how many strokes, and the worst of them as a sentence.
pub(crate) fn doubts(rows: &[Row]) -> Vec<String> {
    let warnings = rows.iter().filter_map(|row| row.outcome.as_ref().ok()).flat_map(|played| &played.warnings);
    let each = worst_of_each(warnings).into_iter();
    each.map(|(count, worst)| format!("{count} of {} strokes; the worst: {worst}", rows.len())).collect()
}

/// Name and values of every column: what was varied, what came of it, what was measured, whether the stroke failed (1, and nothing came of it),
/// whether it can be trusted (1) and what of its energy is not explained.
pub(crate) fn columns(axes: &[Axis], measures: &[&Line], rows: &[Row]) -> Vec<(String, Vec<Option<f64>>)> {
    let varied = axes.iter().enumerate().map(|(i, axis)| {
        let values = rows.iter().map(|row| row.values.get(i).copied()).collect();
        (axis.column(), values)
    });
    let outcomes = OUTCOMES.iter().map(|(name, get)| {
        let values = rows.iter().map(|row| row.outcome.as_ref().ok().and_then(get)).collect();
        ((*name).to_owned(), values)
    });
    let failed = rows.iter().map(|row| Some(f64::from(u8::from(row.outcome.is_err())))).collect();
    let trusted = rows.iter().map(|row| Some(f64::from(u8::from(row.is_trusted())))).collect();
    let residual = rows.iter().map(|row| row.outcome.as_ref().ok().and_then(|p| p.energy_residual)).collect();
    let last = [("failed", failed), ("trusted", trusted), ("energy_residual_relative", residual)];
    let measured = measures.iter().enumerate().map(|(i, line)| {
        let values = rows.iter().map(|row| row.measured.as_ref().ok().and_then(|all| *all.get(i)?)).collect();
        (line.key.to_owned(), values)
    });
    varied.chain(outcomes).chain(measured).chain(last.map(|(name, values)| (name.to_owned(), values))).collect()
}

/// A column of the printed table: its heading and its cell.
type Shown = (&'static str, fn(&Events) -> Option<f64>);

const SHOWN: [Shown; 5] = [
    ("hammer m/s", Events::hammer_speed_m_s),
    ("at ms", |e| e.hammer_contact_s().map(|s| s * 1e3)),
    ("let-off ms", |e| e.let_off_s.map(|s| s * 1e3)),
    ("bottom ms", |e| e.key_bottom_s.map(|s| s * 1e3)),
    ("check ms", |e| e.check_s.map(|s| s * 1e3)),
];

/// The table for people, at most so many rows of it, the first and the last among them.
pub(crate) fn lines(axes: &[Axis], measures: &[&Line], rows: &[Row], most: usize) -> Vec<String> {
    let mut head = String::from(" ");
    for axis in axes {
        head += &format!(" {:>width$}", axis.column(), width = width(axis));
    }
    for (name, _) in SHOWN {
        head += &format!(" {name:>11}");
    }
    head += &format!(" {:>8}", "strikes");
    for line in measures {
        head += &format!(" {:>width$}", line.key, width = wide(line));
    }
    let mut lines = vec![head];
    let shown = most.min(rows.len()).max(1);
    for k in 0..shown {
        let Some(row) = rows.get(k * rows.len().saturating_sub(1) / (shown - 1).max(1)) else { continue };
        let mut line = String::from(" ");
        for (axis, value) in axes.iter().zip(&row.values) {
            line += &format!(" {:>width$}", (value * 1e4).round() / 1e4, width = width(axis));
        }
        match &row.outcome {
            Ok(played) => {
                for (_, get) in SHOWN {
                    line += &format!(" {:>11}", get(&played.events).map_or("-".to_owned(), three));
                }
                line += &format!(" {:>8}", played.events.impacts.len());
                if !played.warnings.is_empty() {
                    line += "  not trusted";
                }
            }
            Err(error) => line += &format!("  failed: {error}"),
        }
        match &row.measured {
            Ok(values) => {
                for (measure, value) in measures.iter().zip(values) {
                    let text = value.map_or("-".to_owned(), |x| format!("{x:.*}", measure.decimals));
                    line += &format!(" {text:>width$}", width = wide(measure));
                }
            }
            Err(error) if row.outcome.is_ok() => line += &format!("  not measured: {error}"),
            Err(_) => {}
        }
        lines.push(line);
    }
    lines
}

fn wide(line: &Line) -> usize {
    line.key.chars().count().max(8)
}

fn width(axis: &Axis) -> usize {
    axis.column().chars().count().max(10)
}
