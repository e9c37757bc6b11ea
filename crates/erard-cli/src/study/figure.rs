//! A study as a figure: what came of the strokes over what was varied first.

use erard::run::Events;
use erard_figures::Picture;
use erard_figures::figure::{Chart, ChartCurve, ChartPanel, Dash, subtitled_chart_picture};

use erard_workshop::study::{Axis, StudyRow};

/// More curves than this cannot be distinguished.
const MAX_CURVES: usize = 6;

/// A quantity of a panel, with its unit.
type Quantity = (&'static str, fn(&Events) -> Option<f64>);

const QUANTITIES: [Quantity; 3] = [
    ("hammer speed (m/s)", Events::hammer_speed_m_per_s),
    ("key start to hammer (ms)", |e| Some((e.hammer_contact_s()? - e.key_start_s?) * 1e3)),
    ("hammer before key bottom (ms)", |e| Some((e.key_bottom_s? - e.hammer_contact_s()?) * 1e3)),
];

/// How many rows are missing in the figure.
fn failed(rows: &[StudyRow]) -> String {
    match rows.iter().filter(|row| row.outcome.is_err()).count() {
        0 => String::new(),
        failed => format!("{failed} of {} strokes failed; study.csv holds the reasons", rows.len()),
    }
}

/// The 5 and 95 % of a result over samples, row by row, and how many samples.
pub(crate) struct SpeedBands {
    pub ends: Vec<[Option<f64>; 2]>,
    pub samples: u32,
}

/// The figure, which says how many strokes failed; `None` where [`chart`] makes none.
pub(crate) fn figure(title: &str, axes: &[Axis], rows: &[StudyRow], bands: Option<&SpeedBands>) -> Option<Picture> {
    let mut chart = chart(title, axes, rows)?;
    if let Some(bands) = bands {
        // Of the other quantities, differences of instants, the bands of the instants give none.
        add_bands(&mut chart.panels[0], rows, bands);
    }
    Some(subtitled_chart_picture(&chart, &failed(rows), "study"))
}

/// Adds dotted lines at 5 and 95 % of the samples, in each curve's colour.
fn add_bands(panel: &mut ChartPanel, rows: &[StudyRow], bands: &SpeedBands) {
    let curves = panel.curves.len();
    for k in 0..curves {
        for (end, label) in [format!("5 and 95 % of {} samples", bands.samples), String::new()].into_iter().enumerate()
        {
            let of_curve = rows.iter().zip(&bands.ends).skip(k).step_by(curves);
            let (x, y) = of_curve.filter_map(|(row, ends)| Some((row.values[0], ends[end]?))).unzip();
            panel.curves.push(ChartCurve { label, x, y, colour: k, mark: Dash::Dotted });
        }
    }
}

/// The chart; `None` where the first axis has one value only or the others make too many curves. Rows stand in the
/// order of the axes, the last one fastest.
fn chart(title: &str, axes: &[Axis], rows: &[StudyRow]) -> Option<Chart> {
    let (first, others) = axes.split_first()?;
    let curves: usize = others.iter().map(|axis| axis.shown.len()).product();
    if first.shown.len() < 2 || curves > MAX_CURVES {
        return None;
    }
    let label = |k: usize| {
        let values = rows[k].values.iter().zip(axes).skip(1);
        let named: Vec<String> =
            values.map(|(value, axis)| format!("{} {value} {}", axis.name, axis.unit).trim_end().to_owned()).collect();
        if named.is_empty() { "all else as it is".to_owned() } else { named.join(", ") }
    };
    let panel = |(y_label, get): &Quantity| ChartPanel {
        y_label: (*y_label).into(),
        y_log: false,
        y_range: None,
        curves: (0..curves)
            .map(|k| {
                let points = rows.iter().skip(k).step_by(curves).filter_map(|row| {
                    let events = &row.outcome.as_ref().ok()?.events;
                    Some((row.values[0], get(events)?))
                });
                let (x, y) = points.unzip();
                ChartCurve { label: label(k), x, y, colour: k, mark: Dash::Points }
            })
            .collect(),
    };
    let unit = if first.unit.is_empty() { "factor" } else { first.unit };
    Some(Chart {
        title: title.into(),
        caption: String::new(),
        x_label: format!("{} ({unit})", first.name),
        x_log: false,
        panels: QUANTITIES.iter().map(panel).collect(),
    })
}
