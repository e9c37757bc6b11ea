//! Two runs on one clock: their curves over each other, and their difference where they lie too close to be
//! distinguished.

use super::run::{FORCE_FLOOR, scaled, windows};
use super::ticks::range;
use super::{Dash, Figure, Layout, Marker, Panel, Trace, figure_picture};
use crate::picture::Picture;
use erard::run::Run;

/// Two curves whose largest difference is below this share of what they span are taken to coincide.
pub const COINCIDE: f64 = 0.1;
/// How a curve of the first and of the second run is drawn.
const DASHES: [Dash; 2] = [Dash::Solid, Dash::Dashed];

/// The figure of two runs as a picture.
pub fn pair_picture(title: &str, runs: [(&str, &Run); 2]) -> Picture {
    figure_picture(&pair_figure(title, runs))
}

/// What two runs are compared in: its name, its unit, the unit's share of the SI unit, and the series.
type Quantity = (&'static str, &'static str, f64, fn(&Run) -> &[f64]);
const QUANTITIES: [Quantity; 3] = [
    ("force", "N", 1.0, |run| &run.force_n),
    ("key", "mm", 1e3, |run| &run.key_m),
    ("hammer", "mm", 1e3, |run| &run.hammer_rise_m),
];

/// The figure of two runs, each with its name.
pub(crate) fn pair_figure<'a>(title: &str, runs: [(&str, &'a Run); 2]) -> Figure<'a> {
    let mut panels = Vec::new();
    for (quantity, unit, factor, of) in QUANTITIES {
        let series: Vec<(usize, &str, &Run)> = runs
            .iter()
            .enumerate()
            .filter(|(_, (_, run))| !of(run).is_empty())
            .map(|(k, (n, run))| (k, *n, *run))
            .collect();
        if series.is_empty() {
            continue;
        }
        let curves: Vec<Trace> = series
            .iter()
            .map(|&(index, name, run)| Trace::new(name, &run.time_s, scaled(of(run), factor), index, DASHES[index]))
            .collect();
        let y_range = range(curves.iter().flat_map(|curve| curve.y.iter().copied()).chain([0.0]));
        let difference = if let [first, second] = &curves[..] { difference(first, second) } else { None };
        panels.push(Panel::new(quantity, unit, 120.0, curves).within(y_range.0, y_range.1));
        let largest = difference.iter().flatten().fold(0.0, |most, d: &f64| f64::max(most, d.abs()));
        // A force that is prescribed is the same, and differs nowhere.
        let is_told_apart = largest >= COINCIDE * (y_range.1 - y_range.0);
        if let Some(y) = difference.filter(|_| !is_told_apart && (largest > 0.0 || quantity != "force")) {
            let (low, high) = range(y.iter().copied().chain([0.0]));
            let curve = Trace::new("difference", &runs[0].1.time_s, y, 6, Dash::Solid);
            let quantity = format!("{quantity}, second − first");
            panels.push(Panel::new(quantity, unit, 120.0, vec![curve]).within(low, high));
        }
    }
    let zones = paired_zones([runs[0].1, runs[1].1]);
    let peak = runs.iter().flat_map(|(_, run)| run.zones.iter().flat_map(|zone| zone.normal_n.iter().copied()));
    let peak = peak.filter(|force| force.is_finite()).fold(10.0, f64::max);
    if !zones.is_empty() {
        let curve = |&(index, zone): &(usize, usize)| {
            let (name, run) = runs[index];
            let series = &run.zones[zone];
            let label = if index == 0 { series.label.clone() } else { format!("    {name}") };
            Trace::new(label, &run.time_s, &series.normal_n, index, Dash::Solid)
        };
        let curves = zones.iter().map(curve).collect();
        panels.push(Panel {
            layout: Layout::Lanes { floor: FORCE_FLOOR, ceiling: 1.5 * peak },
            ..Panel::new("contact forces", "N", 27.0 * zones.len() as f64, curves)
        });
    }
    let speed =
        |run: &Run| run.events.hammer_speed_m_per_s().map_or("no impact".to_owned(), |speed| format!("{speed:.2} m/s"));
    let impact = |(name, run): (&str, &Run)| {
        Some(Marker {
            x: run.events.hammer_contact_s()?,
            label: format!("impact, {name} {:.1}", run.events.hammer_contact_s()? * 1e3),
        })
    };
    let longer = if runs[1].1.time_s.last() > runs[0].1.time_s.last() { runs[1].1 } else { runs[0].1 };
    // The window holds the impacts of both.
    let mut shown = windows(longer);
    if let ([_, first], [_, second]) = (&windows(runs[0].1)[..], &windows(runs[1].1)[..])
        && shown.len() == 2
    {
        (shown[1].from, shown[1].to) = (first.from.min(second.from), first.to.max(second.to));
    }
    let speeds = runs.map(|(name, run)| format!("{name}, {}", speed(run)));
    let subtitle = format!("hammer at the string: {}", speeds.join(" - "));
    let markers = runs.into_iter().filter_map(impact).collect();
    Figure { markers, ..Figure::over_time(title.to_owned(), subtitle, shown, panels) }
}

/// The zones of two runs, by run and index: those of one name stand together.
pub(crate) fn paired_zones(runs: [&Run; 2]) -> Vec<(usize, usize)> {
    let [first, second] = runs;
    let twin = |name: &str| second.zones.iter().position(|zone| zone.name == name);
    let mut out = Vec::new();
    for (index, zone) in first.zones.iter().enumerate() {
        out.push((0, index));
        out.extend(twin(&zone.name).map(|index| (1, index)));
    }
    let is_new = |name: &str| !first.zones.iter().any(|zone| zone.name == name);
    out.extend(second.zones.iter().enumerate().filter(|(_, zone)| is_new(&zone.name)).map(|(index, _)| (1, index)));
    out
}

/// The second curve less the first at the first one's instants, as far as both go; `None` where they never meet in
/// time.
fn difference(first: &Trace, second: &Trace) -> Option<Vec<f64>> {
    let mut at = 0;
    let values: Vec<f64> = first
        .x
        .iter()
        .zip(first.y.iter())
        .map(|(x, y)| {
            while at + 1 < second.x.len() && second.x[at + 1] <= *x {
                at += 1;
            }
            let (Some(x0), Some(y0)) = (second.x.get(at), second.y.get(at)) else { return f64::NAN };
            match (second.x.get(at + 1), second.y.get(at + 1)) {
                (Some(x1), Some(y1)) if x >= x0 => y0 + (x - x0) / (x1 - x0) * (y1 - y0) - y,
                _ if (x - x0).abs() < 1e-9 => y0 - y,
                _ => f64::NAN,
            }
        })
        .collect();
    values.iter().any(|value| value.is_finite()).then_some(values)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drawing::fixture::two_levers_run;

    /// A run beside itself differs nowhere, and says so; a heavier one beside it does not coincide and has no
    /// difference plotted.
    #[test]
    fn a_difference_is_drawn_where_curves_coincide() {
        let run = two_levers_run(400);
        let same = pair_figure("t", [("a", &run), ("b", &run)]);
        let panel = same.panels.iter().find(|panel| panel.quantity == "key, second − first").unwrap();
        assert!(panel.curves[0].y.iter().all(|value| *value == 0.0));
        assert!(!same.panels.iter().any(|panel| panel.quantity.starts_with("force, second")));
        let mut harder = run.clone();
        harder.force_n.iter_mut().for_each(|force| *force *= 2.0);
        let other = pair_figure("t", [("a", &run), ("b", &harder)]);
        assert!(!other.panels.iter().any(|panel| panel.quantity.starts_with("force, second")));
        assert!(other.panels.iter().any(|panel| panel.quantity.starts_with("key, second")));
    }

    #[test]
    fn differences_are_taken_between_rows_and_end_with_the_shorter_run() {
        let trace = |x: &'static [f64], y: &[f64]| Trace::new("", x, y.to_vec(), 0, Dash::Solid);
        let found = difference(&trace(&[0.0, 1.0, 2.0, 3.0], &[0.0; 4]), &trace(&[0.0, 2.0], &[0.0, 4.0])).unwrap();
        assert_eq!(found[..3], [0.0, 2.0, 4.0]);
        assert!(found[3].is_nan());
    }
}
