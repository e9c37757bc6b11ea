//! Charts of the report: linear or logarithmic axes, lines and points.

use std::fmt::Write;

use erard_lab::reproduce::{Chart, ChartCurve, ChartPanel, Mark};

use erard_figures::drawing::FONTS;
use erard_figures::figure::{PALETTE, decimate, padded_range};
use erard_figures::svg::{escape, number};

/// Sizes, px: as wide as a page's text.
const WIDTH: f64 = 860.0;
const LEFT: f64 = 84.0;
const RIGHT: f64 = 232.0;
const TOP: f64 = 34.0;
const BOTTOM: f64 = 44.0;
const PANEL: f64 = 230.0;
const GAP: f64 = 14.0;

const STYLE: &str = ".ink{fill:#222}.soft{fill:#555}.frame{fill:none;stroke:#777;stroke-width:.8}\
.grid{stroke:#e3e3e3;stroke-width:.7}";

/// An axis: from where to where, in its own measure (log10 of the values for a logarithmic one).
struct Axis {
    low: f64,
    high: f64,
    log: bool,
}

impl Axis {
    fn of(values: impl Iterator<Item = f64>, log: bool, padded: bool) -> Self {
        let own = values.filter(|v| v.is_finite() && (!log || *v > 0.0)).map(|v| if log { v.log10() } else { v });
        let own: Vec<f64> = own.collect();
        let (low, high) = if padded || own.len() < 2 {
            padded_range(own.into_iter())
        } else {
            own.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(*v), b.max(*v)))
        };
        Axis { low, high, log }
    }

    /// Place of a value, 0 at the low end and 1 at the high one; not a number where there is none.
    fn share(&self, value: f64) -> f64 {
        let own = if self.log { value.log10() } else { value };
        (own - self.low) / (self.high - self.low)
    }

    /// Numbers along the axis, as places and labels.
    fn ticks(&self, most: usize) -> Vec<(f64, String)> {
        if !self.log {
            let marks = erard_figures::figure::round_ticks((self.low, self.high), most);
            let step = if marks.len() > 1 { marks[1] - marks[0] } else { 1.0 };
            return marks.into_iter().map(|t| (self.share(t), erard_figures::figure::round_label(t, step))).collect();
        }
        let decades = (self.high - self.low).ceil().max(1.0);
        let mut ticks = Vec::new();
        let every = (decades / most as f64).ceil().max(1.0) as i32;
        let multiples: &[f64] = if decades <= 3.0 { &[1.0, 2.0, 5.0] } else { &[1.0] };
        for power in (self.low.floor() as i32..=self.high.ceil() as i32).filter(|p| p % every == 0) {
            for multiple in multiples {
                let value = multiple * 10f64.powi(power);
                let share = self.share(value);
                if (-1e-9..=1.0 + 1e-9).contains(&share) {
                    ticks.push((share, log_label(*multiple, power)));
                }
            }
        }
        ticks
    }
}

/// 0.001 to 5000 in full, powers beyond.
fn log_label(multiple: f64, power: i32) -> String {
    match power {
        -3..=3 => {
            let decimals = usize::try_from(-power).unwrap_or(0);
            format!("{:.decimals$}", multiple * 10f64.powi(power))
        }
        _ => format!("{multiple:.0}e{power}"),
    }
}

/// The chart as an SVG element. The same chart gives the same bytes. `id` makes its clip paths unique within a page.
pub fn chart_svg(chart: &Chart, id: &str) -> String {
    let panels = chart.panels.len() as f64;
    let height = TOP + panels * PANEL + (panels - 1.0).max(0.0) * GAP + BOTTOM;
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{w}\" height=\"{h}\" viewBox=\"0 0 {w} {h}\" font-family=\"{FONTS}\" \
         font-size=\"12\" role=\"img\"><title>{title}</title><style>{STYLE}</style><rect width=\"{w}\" height=\"{h}\" \
         fill=\"#fff\"/><text class=\"ink\" x=\"{LEFT}\" y=\"20\" font-size=\"15\">{title}</text>",
        w = number(WIDTH),
        h = number(height),
        title = escape(&chart.title),
    );
    let abscissae = chart.panels.iter().flat_map(|p| p.curves.iter().flat_map(|c| c.x.iter().copied()));
    let points = chart.panels.iter().any(|p| p.curves.iter().any(|c| c.mark == Mark::Points));
    let x = Axis::of(abscissae, chart.x_log, points);
    for (index, panel) in chart.panels.iter().enumerate() {
        let top = TOP + index as f64 * (PANEL + GAP);
        draw_panel(&mut out, panel, &x, top, &format!("{id}-{index}"), index + 1 == chart.panels.len());
    }
    let _ = writeln!(
        out,
        "<text class=\"ink\" x=\"{}\" y=\"{}\" text-anchor=\"middle\">{}</text></svg>",
        number(0.5 * (LEFT + WIDTH - RIGHT)),
        number(height - 10.0),
        escape(&chart.x_label)
    );
    out
}

fn draw_panel(out: &mut String, panel: &ChartPanel, x: &Axis, top: f64, id: &str, last: bool) {
    let (width, bottom) = (WIDTH - LEFT - RIGHT, top + PANEL);
    let y = match panel.y_range {
        Some((low, high)) => Axis::of([low, high].into_iter(), panel.y_log, false),
        None => Axis::of(panel.curves.iter().flat_map(|c| c.y.iter().copied()), panel.y_log, true),
    };
    let _ = write!(
        out,
        "<clipPath id=\"{id}\"><rect x=\"{LEFT}\" y=\"{}\" width=\"{}\" height=\"{PANEL}\"/></clipPath>",
        number(top),
        number(width)
    );
    for (share, label) in x.ticks(10) {
        let at = number(LEFT + share * width);
        let _ = write!(
            out,
            "<line class=\"grid\" x1=\"{at}\" y1=\"{}\" x2=\"{at}\" y2=\"{}\"/>",
            number(top),
            number(bottom)
        );
        if last {
            let _ = write!(
                out,
                "<text class=\"ink\" x=\"{at}\" y=\"{}\" text-anchor=\"middle\" font-size=\"11\">{label}</text>",
                number(bottom + 16.0)
            );
        }
    }
    for (share, label) in y.ticks(8) {
        let at = bottom - share * PANEL;
        let _ = write!(
            out,
            "<line class=\"grid\" x1=\"{LEFT}\" y1=\"{y}\" x2=\"{}\" y2=\"{y}\"/><text class=\"ink\" x=\"{}\" y=\"{}\" \
             text-anchor=\"end\" font-size=\"11\">{label}</text>",
            number(LEFT + width),
            number(LEFT - 6.0),
            number(at + 4.0),
            y = number(at),
        );
    }
    let _ = write!(out, "<g clip-path=\"url(#{id})\">");
    for (index, curve) in panel.curves.iter().enumerate() {
        draw_curve(out, curve, index, x, &y, (LEFT, width), bottom);
    }
    let _ = write!(
        out,
        "</g><rect class=\"frame\" x=\"{LEFT}\" y=\"{}\" width=\"{}\" height=\"{PANEL}\"/>",
        number(top),
        number(width)
    );
    let (at, middle) = (LEFT - 62.0, number(top + 0.5 * PANEL));
    let _ = write!(
        out,
        "<text class=\"ink\" x=\"{at}\" y=\"{middle}\" text-anchor=\"middle\" transform=\"rotate(-90 {at} {middle})\">{}</text>",
        escape(&panel.y_label)
    );
    for (index, curve) in panel.curves.iter().enumerate() {
        let (left, line) = (LEFT + width + 10.0, top + 12.0 + 17.0 * index as f64);
        let _ = write!(
            out,
            "<line x1=\"{}\" y1=\"{y}\" x2=\"{}\" y2=\"{y}\" stroke=\"{}\" stroke-width=\"2\"{}/>",
            number(left),
            number(left + 22.0),
            colour(curve),
            dashes(curve.mark),
            y = number(line),
        );
        if curve.mark == Mark::Points {
            point(out, index, left + 11.0, line, colour(curve));
        }
        let _ = write!(
            out,
            "<text class=\"ink\" x=\"{}\" y=\"{}\" font-size=\"11\">{}</text>",
            number(left + 27.0),
            number(line + 4.0),
            escape(&curve.label)
        );
    }
}

fn draw_curve(
    out: &mut String,
    curve: &ChartCurve,
    index: usize,
    x: &Axis,
    y: &Axis,
    (left, width): (f64, f64),
    bottom: f64,
) {
    let xs: Vec<f64> = curve.x.iter().map(|v| x.share(*v)).collect();
    let ys: Vec<f64> = curve.y.iter().map(|v| y.share(*v)).collect();
    let pixel = |(a, b): (f64, f64)| (number(tenth(left + a * width)), number(tenth(bottom - b * PANEL)));
    // Thinning needs abscissae that ascend; a loop (force over compression) or a falling row is drawn as it is.
    let runs = if xs.is_sorted() {
        decimate(&xs, &ys, (0.0, 1.0), (1.5 * width) as usize)
    } else {
        let all: Vec<(f64, f64)> = xs.iter().copied().zip(ys.iter().copied()).collect();
        all.split(|(a, b)| !(a.is_finite() && b.is_finite())).filter(|run| !run.is_empty()).map(<[_]>::to_vec).collect()
    };
    for run in &runs {
        let _ = write!(
            out,
            "<polyline fill=\"none\" stroke=\"{}\" stroke-width=\"1.4\" stroke-linejoin=\"round\"{} points=\"",
            colour(curve),
            dashes(curve.mark)
        );
        let mut before = None;
        for point in run {
            let (a, b) = pixel(*point);
            let text = format!("{a},{b}");
            if before.as_ref() != Some(&text) {
                let _ = write!(out, "{}{text}", if before.is_none() { "" } else { " " });
            }
            before = Some(text);
        }
        out.push_str("\"/>");
        if curve.mark == Mark::Points {
            for (a, b) in run.iter().filter(|(a, b)| (0.0..=1.0).contains(a) && (0.0..=1.0).contains(b)) {
                point(out, index, left + a * width, bottom - b * PANEL, colour(curve));
            }
        }
    }
}

/// A point; its shape tells curves apart in grey print too.
fn point(out: &mut String, index: usize, x: f64, y: f64, colour: &str) {
    let at = |dx: f64, dy: f64| format!("{},{}", number(tenth(x + dx)), number(tenth(y + dy)));
    let _ = match index % 4 {
        0 => write!(out, "<circle cx=\"{}\" cy=\"{}\" r=\"3\" fill=\"{colour}\"/>", number(tenth(x)), number(tenth(y))),
        shape => {
            let corners: &[(f64, f64)] = match shape {
                1 => &[(-2.8, -2.8), (2.8, -2.8), (2.8, 2.8), (-2.8, 2.8)],
                2 => &[(0.0, -3.8), (3.6, 2.8), (-3.6, 2.8)],
                _ => &[(0.0, -4.0), (3.4, 0.0), (0.0, 4.0), (-3.4, 0.0)],
            };
            let points: Vec<String> = corners.iter().map(|(dx, dy)| at(*dx, *dy)).collect();
            write!(out, "<polygon points=\"{}\" fill=\"{colour}\"/>", points.join(" "))
        }
    };
}

/// To a tenth of a pixel, and never absurdly far outside.
fn tenth(v: f64) -> f64 {
    (v.clamp(-1e5, 1e5) * 10.0).round() / 10.0
}

fn colour(curve: &ChartCurve) -> &'static str {
    PALETTE[curve.colour % PALETTE.len()]
}

fn dashes(mark: Mark) -> &'static str {
    match mark {
        Mark::Line | Mark::Points => "",
        Mark::Dashed => " stroke-dasharray=\"6 3\"",
        Mark::Dotted => " stroke-dasharray=\"1.5 2.5\"",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chart(x_log: bool, y_log: bool, y: Vec<f64>) -> Chart {
        let x = (1..=y.len()).map(|i| i as f64).collect();
        let curve = ChartCurve { label: "<a>".into(), x, y, colour: 1, mark: Mark::Points };
        let panels = vec![ChartPanel { y_label: "y & z".into(), y_log, y_range: None, curves: vec![curve] }];
        Chart { title: "<t>".into(), caption: String::new(), x_label: "x".into(), x_log, panels }
    }

    /// Whatever the values are, the document can be rendered, is the same each time, and holds no NaN.
    #[test]
    fn odd_values_do_not_break_a_chart() {
        for y in [vec![], vec![1.0], vec![0.0, -1.0, 2.0], vec![f64::NAN, 1.0, f64::INFINITY, 3.0], vec![1e-12, 1e12]] {
            for (x_log, y_log) in [(false, false), (true, false), (false, true), (true, true)] {
                let svg = chart_svg(&chart(x_log, y_log, y.clone()), "c");
                assert!(!svg.contains("NaN") && !svg.contains("inf") && !svg.contains("<a>"), "{svg}");
                assert_eq!(svg, chart_svg(&chart(x_log, y_log, y.clone()), "c"));
                erard_figures::figure::png_from_svg(&svg, 0.5).unwrap();
            }
        }
    }

    /// A decade takes the same room wherever it is.
    #[test]
    fn logarithmic_axes_are_logarithmic() {
        let axis = Axis { low: 0.0, high: 4.0, log: true };
        assert!((axis.share(10.0) - 0.25).abs() < 1e-12 && (axis.share(1000.0) - 0.75).abs() < 1e-12);
        let labels: Vec<String> = axis.ticks(8).into_iter().map(|t| t.1).collect();
        assert_eq!(labels, ["1", "10", "100", "1000", "1e4"]);
        assert_eq!(log_label(2.0, -3), "0.002");
        assert_eq!(log_label(1.0, -6), "1e-6");
    }
}
