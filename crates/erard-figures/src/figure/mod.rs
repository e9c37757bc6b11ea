//! Figures: panels of curves over a shared abscissa, time or the key's travel, as pictures.
//!
//! Drawn here rather than through a plotting crate: those tried place everything on whole pixels (slow curves
//! turn into stairs), cannot clip a curve to a window and draw dashes as thousands of separate strokes.
//!
//! One or several windows of time stand side by side over the same panels: an impact takes ten milliseconds of a run
//! that takes a second, and both are worth seeing.

mod axes;
mod axis;
mod chart;
mod decimate;
mod lanes;
mod markers;
mod pair;
mod run;
mod spectrogram;
mod ticks;
mod tornado;

pub use axis::Scale;
pub use chart::{Chart, ChartCurve, ChartPanel, chart_picture, subtitled_chart_picture};
pub(crate) use decimate::decimate;
pub use pair::{COINCIDE, pair_picture};
pub(crate) use pair::{pair_figure, paired_zones};
pub(crate) use run::run_figure;
pub use run::{events, instants, over_run, run_picture};
pub use spectrogram::Spectrogram;
pub use ticks::range as padded_range;
pub use tornado::{Bar, Tornado, TornadoPanel, tornado_picture};

use crate::picture::{Anchor, Clip, Geometry, Head, Look, Node, Paint, Picture, Rule, Shape, Words};
use std::borrow::Cow;

/// Colours distinguished by everybody, also in grey print when combined with [`Dash`]: first Okabe and Ito's set
/// (yellow left out because it vanishes on paper), then darker and duller ones, so that sixteen curves of one panel
/// have sixteen colours.
pub const PALETTE: [&str; 16] = [
    "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#000000", "#7a4b9e", "#8c6d1f", "#a1253b",
    "#4a7a3a", "#5c6f8a", "#c08a6a", "#00807f", "#8f8f8f", "#3a3f8f",
];

/// Line style of a curve.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Dash {
    /// Unbroken.
    #[default]
    Solid,
    /// Long strokes.
    Dashed,
    /// Dots.
    Dotted,
    /// Unbroken, with a point at every sample.
    Points,
    /// A point at every sample, and nothing between: samples that are no steps of one thing.
    Alone,
}

/// One curve.
#[derive(Debug, Clone, PartialEq)]
pub struct Trace<'a> {
    /// Name in the legend.
    pub label: String,
    /// Abscissae in the unit of the data (time: s). Long series should ascend: only these are thinned.
    pub x: &'a [f64],
    /// Ordinates, in the unit of the panel.
    pub y: Cow<'a, [f64]>,
    /// Colour, `#rgb` or `#rrggbb`, usually from [`PALETTE`].
    pub colour: &'static str,
    /// Line style.
    pub dash: Dash,
}

impl<'a> Trace<'a> {
    /// A curve in a colour of [`PALETTE`], which begins again after its last.
    pub fn new(
        label: impl Into<String>,
        x: &'a [f64],
        y: impl Into<Cow<'a, [f64]>>,
        colour: usize,
        dash: Dash,
    ) -> Self {
        Trace { label: label.into(), x, y: y.into(), colour: PALETTE[colour % PALETTE.len()], dash }
    }
}

/// Arrangement of the curves in a panel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Layout {
    /// All over one axis.
    Together,
    /// All over one logarithmic axis.
    Logarithmic,
    /// One upon the other from zero, the space below each in its colour: parts of a whole. None may be negative.
    Stacked,
    /// Each in a lane of its own, all lanes with the same logarithmic axis from `floor` to `ceiling`: for many
    /// curves that start and stop and span decades, such as contact forces.
    Lanes {
        /// Values below are drawn as nothing.
        floor: f64,
        /// Values above are cut.
        ceiling: f64,
    },
}

/// One panel of the stack.
#[derive(Debug, Clone, PartialEq)]
pub struct Panel<'a> {
    /// Quantity, e.g. `key`.
    pub quantity: String,
    /// Unit of the ordinates, e.g. `mm`; empty where the quantity says it, or has none.
    pub unit: &'static str,
    /// Height, px.
    pub height_px: f64,
    /// Arrangement of the curves.
    pub layout: Layout,
    /// Range of the axis; `None` fits it to what the windows show.
    pub y_range: Option<(f64, f64)>,
    /// The curves.
    pub curves: Vec<Trace<'a>>,
}

impl<'a> Panel<'a> {
    /// Its height, px: as much as its legend needs, at least.
    fn height(&self) -> f64 {
        match self.layout {
            Layout::Lanes { .. } => self.height_px,
            Layout::Together | Layout::Logarithmic | Layout::Stacked => self.height_px.max(axes::legend_height(self)),
        }
    }

    /// Curves over one axis that fits them.
    pub fn new(quantity: impl Into<String>, unit: &'static str, height_px: f64, curves: Vec<Trace<'a>>) -> Self {
        Panel { quantity: quantity.into(), unit, height_px, layout: Layout::Together, y_range: None, curves }
    }

    /// The panel with another axis.
    pub fn within(self, low: f64, high: f64) -> Self {
        Panel { y_range: Some((low, high)), ..self }
    }
}

/// An instant, drawn as a thin line through all panels.
#[derive(Debug, Clone, PartialEq)]
pub struct Marker {
    /// When.
    pub x: f64,
    /// Label.
    pub label: String,
}

/// A stretch of the abscissa.
#[derive(Debug, Clone, PartialEq)]
pub struct Window {
    /// Start, in the unit of the data.
    pub from: f64,
    /// End.
    pub to: f64,
    /// Share of the figure's width.
    pub weight: f64,
    /// A word above it; may be empty.
    pub heading: String,
    /// Whether the markers are named here (their lines are always drawn).
    pub names_markers: bool,
}

impl Window {
    /// All that is shown; markers are named.
    pub fn whole(from: f64, to: f64) -> Self {
        Window { from, to, weight: 1.0, heading: String::new(), names_markers: true }
    }
}

/// A whole figure.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure<'a> {
    /// Headline.
    pub title: String,
    /// A smaller line below it; may be empty.
    pub subtitle: String,
    /// Width, px.
    pub width_px: f64,
    /// Quantity and unit of the abscissa, e.g. `time (ms)`.
    pub x_label: String,
    /// Factor from the data's unit to the axis' (s to ms: 1000).
    pub x_unit: f64,
    /// Scale of the abscissa.
    pub x_scale: Scale,
    /// Stretches of the abscissa, side by side.
    pub windows: Vec<Window>,
    /// The panels, from top to bottom.
    pub panels: Vec<Panel<'a>>,
    /// The instants.
    pub markers: Vec<Marker>,
}

impl<'a> Figure<'a> {
    /// Panels over time in seconds, which the axis shows in milliseconds.
    pub fn over_time(title: String, subtitle: String, windows: Vec<Window>, panels: Vec<Panel<'a>>) -> Self {
        Figure {
            title,
            subtitle,
            width_px: 1180.0,
            x_label: "time (ms)".into(),
            x_unit: 1e3,
            x_scale: Scale::Linear,
            windows,
            panels,
            markers: Vec::new(),
        }
    }

    /// Panels over another quantity in the data's own unit, as wide as a page's text.
    pub fn over(
        x_label: &str,
        (from, to): (f64, f64),
        title: String,
        subtitle: String,
        panels: Vec<Panel<'a>>,
    ) -> Self {
        Figure {
            width_px: 860.0,
            x_label: x_label.into(),
            x_unit: 1.0,
            ..Figure::over_time(title, subtitle, vec![Window::whole(from, to)], panels)
        }
    }
}

/// A rectangle of the figure, px.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Area {
    pub left: f64,
    pub top: f64,
    pub width: f64,
    pub height: f64,
}

impl Area {
    pub(crate) fn right(&self) -> f64 {
        self.left + self.width
    }

    pub(crate) fn bottom(&self) -> f64 {
        self.top + self.height
    }
}

/// Room for the ordinates' numbers and names, px.
const LEFT: f64 = 78.0;
/// Room for legends, px.
const RIGHT: f64 = 216.0;
/// Room for the abscissa's numbers and name, px.
const BOTTOM: f64 = 48.0;
/// Between panels, px.
const PANEL_GAP: f64 = 12.0;
/// Between windows, px.
const WINDOW_GAP: f64 = 34.0;

/// The style of all figures.
const STYLE: &[Rule] = &[
    Rule::new(&["ink"], &[Look::Fill(Paint::Colour("#222"))]),
    Rule::new(&["soft"], &[Look::Fill(Paint::Colour("#555"))]),
    Rule::new(&["frame"], &[Look::Fill(Paint::None), Look::Stroke(Paint::Colour("#777")), Look::StrokeWidth(0.8)]),
    Rule::new(&["grid"], &[Look::Stroke(Paint::Colour("#e3e3e3")), Look::StrokeWidth(0.7)]),
    Rule::new(&["tick"], &[Look::Stroke(Paint::Colour("#777")), Look::StrokeWidth(0.8)]),
    Rule::new(&["mark"], &[Look::Stroke(Paint::Colour("#444")), Look::StrokeWidth(0.7), Look::Dashes([3.0, 2.5])]),
    Rule::new(&["lead"], &[Look::Stroke(Paint::Colour("#444")), Look::StrokeWidth(0.6), Look::Fill(Paint::None)]),
];

/// The figure as a picture.
pub fn figure_picture(figure: &Figure) -> Picture {
    figure_picture_named(figure, "clip")
}

/// The same for a page that holds several: `name` makes its clip paths its own.
pub(crate) fn figure_picture_named(figure: &Figure, name: &str) -> Picture {
    let named = figure.windows.iter().any(|window| window.names_markers) && !figure.markers.is_empty();
    let heading = if figure.windows.iter().all(|window| window.heading.is_empty()) { 0.0 } else { 18.0 };
    let top = 30.0 + if figure.subtitle.is_empty() { 0.0 } else { 18.0 } + heading;
    let marks = if named { markers::HEIGHT } else { 8.0 };
    let heights: f64 = figure.panels.iter().map(Panel::height).sum();
    let gaps = PANEL_GAP * figure.panels.len().saturating_sub(1) as f64;
    let (width, height) = (figure.width_px, top + marks + heights + gaps + BOTTOM);
    let mut picture = sheet(&figure.title, [width, height], 12, &[], [LEFT, 22.0]);
    let out = &mut picture.nodes;
    if !figure.subtitle.is_empty() {
        out.push(Words::node("soft", [LEFT, 41.0], [], &figure.subtitle));
    }
    let columns = columns(figure, width);
    for (window, (left, wide)) in figure.windows.iter().zip(&columns) {
        if !window.heading.is_empty() {
            out.push(Words::node("soft", [*left, top - 5.0], [], &window.heading));
        }
        if window.names_markers {
            let strip = Area { left: *left, top, width: *wide, height: marks };
            markers::names(out, figure, window, strip);
        }
    }
    let mut y = top + marks;
    for (index, panel) in figure.panels.iter().enumerate() {
        let is_last = index + 1 == figure.panels.len();
        for (column, (window, (left, wide))) in figure.windows.iter().zip(&columns).enumerate() {
            let area = Area { left: *left, top: y, width: *wide, height: panel.height() };
            let place = [area.left, area.top, area.width, area.height];
            let clip = Clip { id: format!("{name}-{index}-{column}"), area: place };
            out.push(Node::Clip(clip.clone()));
            axes::abscissa(out, figure, window, area, is_last);
            match panel.layout {
                Layout::Together | Layout::Logarithmic | Layout::Stacked => {
                    axes::together(out, figure, panel, window, area, column == 0, &clip)
                }
                Layout::Lanes { .. } => lanes::lanes(out, figure, panel, window, area, column == 0, &clip),
            }
            markers::lines(out, figure, window, area);
            out.push(Shape::of_class("frame", Geometry::rect(place)));
        }
        axes::panel_name(out, panel, y);
        match panel.layout {
            Layout::Together | Layout::Logarithmic | Layout::Stacked => {
                axes::legend(out, panel, width - RIGHT + 12.0, y)
            }
            Layout::Lanes { .. } => lanes::names(out, panel, width - RIGHT + 12.0, y),
        }
        y += panel.height() + PANEL_GAP;
    }
    if let (Some((first, _)), Some((last, wide))) = (columns.first(), columns.last()) {
        let middle = [0.5 * (first + last + wide), height - 12.0];
        out.push(Words::node("ink", middle, [Look::Anchor(Anchor::Middle)], &figure.x_label));
    }
    picture
}

/// An empty figure: its sheet, and its headline at a place. `style` comes after that of all figures.
fn sheet(title: &str, size_px: [f64; 2], font_size: u8, style: &'static [Rule], headline: [f64; 2]) -> Picture {
    let head = Head {
        title: title.to_owned(),
        size_px,
        view: [0.0, 0.0, size_px[0], size_px[1]],
        font_size: Some(font_size),
        style: vec![STYLE, style],
        rule_end: "",
        gradients: &[],
    };
    let sheet =
        Shape { after: vec![Look::Fill(Paint::Colour("#fff"))], ..Shape::new("sheet", Geometry::Rect(None, size_px)) };
    let headline = Words::node("ink", headline, [Look::FontSize(16.0)], title);
    Picture { head, nodes: vec![Node::Shape(sheet), headline] }
}

/// Left edge and width of every window, px.
fn columns(figure: &Figure, width: f64) -> Vec<(f64, f64)> {
    let gaps = WINDOW_GAP * figure.windows.len().saturating_sub(1) as f64;
    let room = (width - LEFT - RIGHT - gaps).max(50.0);
    let weights: f64 = figure.windows.iter().map(|window| window.weight).sum();
    let mut left = LEFT;
    figure
        .windows
        .iter()
        .map(|window| {
            let wide = room * window.weight / weights;
            let column = (left, wide);
            left += wide + WINDOW_GAP;
            column
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drawing::fixture::two_levers_run;

    #[test]
    fn the_same_run_gives_the_same_bytes() {
        let run = two_levers_run(500);
        assert_eq!(run_picture(&run, "mf").svg(), run_picture(&run, "mf").svg());
    }

    #[test]
    fn labels_from_files_are_escaped() {
        let mut run = two_levers_run(500);
        run.instrument = "a<b>&\"".into();
        run.zones[0].label = "</svg><script>".into();
        let svg = run_picture(&run, "mf").svg();
        assert!(svg.contains("a&lt;b&gt;&amp;&quot;") && svg.contains("&lt;/svg&gt;"));
        assert_eq!(svg.matches("</svg>").count(), 1);
    }

    /// A run that is empty, has one row, or is full of NaN still gives a figure that can be rendered.
    #[test]
    fn odd_runs_do_not_break_the_figure() {
        let mut broken = two_levers_run(300);
        broken.force_n.fill(f64::NAN);
        broken.zones[0].normal_n[7] = f64::INFINITY;
        for run in [two_levers_run(0), two_levers_run(1), broken] {
            let picture = run_picture(&run, "mf");
            let svg = picture.svg();
            assert!(!svg.contains("NaN") && !svg.contains("inf"));
            #[cfg(feature = "png")]
            picture.png(0.5).unwrap();
        }
    }

    /// A legend that is longer than its panel makes the panel longer, and does not run into the next one's.
    #[test]
    fn long_legends_have_room() {
        let curves =
            |count: usize| (0..count).map(|k| Trace::new(format!("c{k}"), &[0.0, 1.0], vec![0.0, 1.0], k, Dash::Solid));
        let panel = |count| Panel::new("q", "", 60.0, curves(count).collect());
        let figure = Figure::over("x", (0.0, 1.0), "t".into(), String::new(), vec![panel(12), panel(1)]);
        let svg = figure_picture(&figure).svg();
        let y_of = |label: &str| -> f64 {
            let before = svg.split(&format!(">{label}</text>")).next().unwrap();
            before.rsplit(" y=\"").next().unwrap().split('"').next().unwrap().parse().unwrap()
        };
        assert!(svg.matches(">c0</text>").count() == 2);
        let second = svg.rsplit(">c0</text>").nth(1).unwrap();
        let second: f64 = second.rsplit(" y=\"").next().unwrap().split('"').next().unwrap().parse().unwrap();
        assert!(second - y_of("c11") > 17.0, "{} {second}", y_of("c11"));
    }

    /// Areas stand one upon the other: parts of 1 and 3 end at 1 and at 4 of an axis that ends at 4.2, a twentieth
    /// above the whole.
    #[test]
    fn stacked_areas_end_at_their_sums() {
        let trace = |label: &str, y: f64, colour| Trace::new(label, &[0.0, 1.0], vec![y, y], colour, Dash::Solid);
        let curves = vec![trace("one", 1.0, 0), trace("other", 3.0, 1)];
        let panel = Panel { layout: Layout::Stacked, ..Panel::new("lost", "mJ", 210.0, curves) };
        let figure =
            Figure { width_px: 600.0, ..Figure::over("x", (0.0, 1.0), "t".into(), String::new(), vec![panel]) };
        let svg = figure_picture(&figure).svg();
        let tops: Vec<f64> = svg
            .split("<polygon ")
            .skip(1)
            .map(|polygon| {
                let points = polygon.split("points=\"").nth(1).unwrap().split('"').next().unwrap();
                let ordinates = points.split(' ').map(|point| point.split_once(',').unwrap().1.parse::<f64>().unwrap());
                ordinates.fold(f64::INFINITY, f64::min)
            })
            .collect();
        // The title and a margin stand above the panel: 38 px. The whole is drawn first, the part over it.
        let y = |value: f64| 38.0 + 210.0 * (1.0 - value / 4.2);
        assert_eq!(tops.len(), 2);
        assert!((tops[0] - y(4.0)).abs() < 0.06 && (tops[1] - y(1.0)).abs() < 0.06, "{tops:?}");
    }
}
