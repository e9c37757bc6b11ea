//! A chart: panels of curves over one abscissa, with a caption, as a figure.

use super::{Dash, Figure, Layout, Panel, Scale, Trace, figure_picture_named, padded_range};
use crate::picture::Picture;

/// Panels of curves over one abscissa.
#[derive(Debug, Clone, PartialEq)]
pub struct Chart {
    /// Headline.
    pub title: String,
    /// Caption: content and conditions.
    pub caption: String,
    /// Quantity and unit of the abscissa.
    pub x_label: String,
    /// Whether it is logarithmic.
    pub x_log: bool,
    /// From top to bottom.
    pub panels: Vec<ChartPanel>,
}

/// One panel.
#[derive(Debug, Clone, PartialEq)]
pub struct ChartPanel {
    /// Quantity and unit.
    pub y_label: String,
    /// Whether the ordinate is logarithmic.
    pub y_log: bool,
    /// Its range, where the curves' own would hide what is meant.
    pub y_range: Option<(f64, f64)>,
    /// The curves.
    pub curves: Vec<ChartCurve>,
}

/// One curve.
#[derive(Debug, Clone, PartialEq)]
pub struct ChartCurve {
    /// Name.
    pub label: String,
    /// Abscissae, increasing or decreasing.
    pub x: Vec<f64>,
    /// Ordinates.
    pub y: Vec<f64>,
    /// Colour; the same number is the same colour in all figures. 0 is the blue of the one-degree-of-freedom model.
    pub colour: usize,
    /// Style.
    pub mark: Dash,
}

/// Width, px: as wide as a page's text.
const WIDTH: f64 = 860.0;
/// Characters of a label that there is room for, and what one more takes, px.
const ROOM: usize = 25;
const CHARACTER: f64 = 7.0;
/// Height of a panel, px.
const PANEL: f64 = 230.0;

/// The chart as a picture. `id` makes its clip paths unique within a page.
pub fn chart_picture(chart: &Chart, id: &str) -> Picture {
    subtitled_chart_picture(chart, "", id)
}

/// The chart as a picture with a line under its title, for what its caption cannot say outside a page.
pub fn subtitled_chart_picture(chart: &Chart, subtitle: &str, id: &str) -> Picture {
    let panels = chart.panels.iter().map(panel).collect();
    let labels = chart.panels.iter().flat_map(|panel| &panel.curves).map(|curve| curve.label.chars().count());
    let longest = labels.max().unwrap_or(0);
    let figure = Figure {
        width_px: WIDTH + CHARACTER * longest.saturating_sub(ROOM) as f64,
        x_scale: if chart.x_log { Scale::Logarithmic } else { Scale::Linear },
        ..Figure::over(&chart.x_label, abscissae(chart), chart.title.clone(), subtitle.to_owned(), panels)
    };
    figure_picture_named(&figure, id)
}

fn panel(panel: &ChartPanel) -> Panel<'_> {
    let curves =
        panel.curves.iter().map(|curve| Trace::new(&curve.label, &curve.x, &curve.y, curve.colour, curve.mark));
    Panel {
        layout: if panel.y_log { Layout::Logarithmic } else { Layout::Together },
        y_range: panel.y_range,
        ..Panel::new(&panel.y_label, "", PANEL, curves.collect())
    }
}

/// From where to where the abscissa goes: as far as its values, and a little further where points would be cut by the
/// frame.
fn abscissae(chart: &Chart) -> (f64, f64) {
    let curves = || chart.panels.iter().flat_map(|panel| &panel.curves);
    let place = |x: f64| if chart.x_log { x.log10() } else { x };
    let places = || curves().flat_map(|curve| &curve.x).map(|x| place(*x)).filter(|x| x.is_finite());
    let (low, high) = places().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
    let has_points = curves().any(|curve| matches!(curve.mark, Dash::Points | Dash::Alone));
    let (low, high) = if has_points || low >= high { padded_range(places()) } else { (low, high) };
    if chart.x_log { (10f64.powf(low), 10f64.powf(high)) } else { (low, high) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chart(x_log: bool, y_log: bool, y: Vec<f64>) -> Chart {
        let x = (1..=y.len()).map(|i| i as f64).collect();
        let curve = ChartCurve { label: "<a>".into(), x, y, colour: 1, mark: Dash::Points };
        let panels = vec![ChartPanel { y_label: "y & z".into(), y_log, y_range: None, curves: vec![curve] }];
        Chart { title: "<t>".into(), caption: String::new(), x_label: "x".into(), x_log, panels }
    }

    /// Whatever the values are, the document can be rendered, is the same each time, and holds no NaN.
    #[test]
    fn odd_values_do_not_break_a_chart() {
        for y in [vec![], vec![1.0], vec![0.0, -1.0, 2.0], vec![f64::NAN, 1.0, f64::INFINITY, 3.0], vec![1e-12, 1e12]] {
            for (x_log, y_log) in [(false, false), (true, false), (false, true), (true, true)] {
                let picture = chart_picture(&chart(x_log, y_log, y.clone()), "c");
                let svg = picture.svg();
                assert!(!svg.contains("NaN") && !svg.contains("inf") && !svg.contains("<a>"), "{svg}");
                assert_eq!(svg, chart_picture(&chart(x_log, y_log, y.clone()), "c").svg());
                picture.png(0.5).unwrap();
            }
        }
    }
}
