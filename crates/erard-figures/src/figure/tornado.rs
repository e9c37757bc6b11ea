//! A tornado: what changes a quantity most, as bars to either side of its value.

use super::sheet;
use crate::picture::{Anchor, Geometry, Look, Node, Paint, Picture, Rule, Segment, Shape, Words};

/// Width of a panel's names and of its bars, and of the room for the numbers beside them, px.
const NAMES: f64 = 210.0;
const BARS: f64 = 230.0;
const NUMBERS: f64 = 84.0;
/// Height of a bar with the gap below it, px.
const LINE: f64 = 17.0;
/// Between panels, px.
const GAP: f64 = 26.0;
/// Panels beside each other.
const BESIDE: usize = 2;
const TOP: f64 = 62.0;
const SIDES: &[Rule] = &[
    Rule::new(&["up"], &[Look::Fill(Paint::Colour("#0072b2")), Look::Stroke(Paint::Colour("#0072b2"))]),
    Rule::new(&["down"], &[Look::Fill(Paint::Colour("#d55e00")), Look::Stroke(Paint::Colour("#d55e00"))]),
    Rule::new(&["hollow"], &[Look::Fill(Paint::Colour("#fff"))]),
];

/// One bar.
#[derive(Debug, Clone, PartialEq)]
pub struct Bar {
    /// The change and its size.
    pub label: String,
    /// Effect of the change, in the panel's unit.
    pub effect: f64,
    /// Its error.
    pub error: f64,
    /// Whether it is drawn hollow: cannot be trusted as it stands.
    pub marked: bool,
}

/// One quantity.
#[derive(Debug, Clone, PartialEq)]
pub struct TornadoPanel {
    /// The quantity with its value.
    pub title: String,
    /// Unit of the effects.
    pub unit: String,
    /// From top to bottom.
    pub bars: Vec<Bar>,
}

/// The figure.
#[derive(Debug, Clone, PartialEq)]
pub struct Tornado {
    /// Headline.
    pub title: String,
    /// Below it.
    pub subtitle: String,
    /// Two beside each other.
    pub panels: Vec<TornadoPanel>,
}

/// A tornado as a picture.
pub fn tornado_picture(figure: &Tornado) -> Picture {
    let wide = NAMES + BARS + NUMBERS + GAP;
    let tall = |row: &[TornadoPanel]| {
        let most = row.iter().map(|panel| panel.bars.len()).max().unwrap_or(0);
        24.0 + LINE * most as f64 + GAP
    };
    let rows: Vec<&[TornadoPanel]> = figure.panels.chunks(BESIDE).collect();
    let columns = figure.panels.len().clamp(1, BESIDE) as f64;
    let (width, height) = (wide * columns + GAP, TOP + rows.iter().map(|row| tall(row)).sum::<f64>());
    let mut picture = sheet(&figure.title, [width, height], 11, SIDES, [GAP, 24.0]);
    let out = &mut picture.nodes;
    out.push(Words::node("soft", [GAP, 43.0], [], &figure.subtitle));
    let mut y = TOP;
    for row in rows {
        for (column, panel) in row.iter().enumerate() {
            draw(out, panel, GAP + wide * column as f64, y);
        }
        y += tall(row);
    }
    picture
}

fn draw(out: &mut Vec<Node>, panel: &TornadoPanel, left: f64, top: f64) {
    let largest =
        panel.bars.iter().map(|bar| bar.effect.abs() + bar.error).filter(|x| x.is_finite()).fold(0.0, f64::max);
    let scale = if largest > 0.0 { 0.5 * BARS / largest } else { 0.0 };
    let zero = left + NAMES + 0.5 * BARS;
    let (first, last) = (top + 20.0, top + 20.0 + LINE * panel.bars.len() as f64);
    out.push(Words::node("ink", [left, top + 12.0], [Look::FontSize(13.0)], &panel.title));
    let tick = |from, to| Shape::of_class("tick", Geometry::Path(vec![Segment::Move(from), Segment::Line(to)]));
    out.push(tick([zero, first], [zero, last]));
    for (k, bar) in panel.bars.iter().enumerate() {
        let y = first + LINE * k as f64;
        let long = if bar.effect.is_finite() { bar.effect * scale } else { 0.0 };
        let (x, width) = if long < 0.0 { (zero + long, -long) } else { (zero, long) };
        let side = if long < 0.0 { "down" } else { "up" };
        let hollow = if bar.marked { " hollow" } else { "" };
        out.push(Words::node("ink", [left + NAMES - 8.0, y + 12.0], [Look::Anchor(Anchor::End)], &bar.label));
        out.push(Shape::of_class(format!("{side}{hollow}"), Geometry::rect([x, y + 3.0, width, LINE - 6.0])));
        if bar.error > 0.0 && bar.error.is_finite() {
            let at = |effect: f64| [zero + scale * effect, y + 0.5 * LINE];
            out.push(tick(at(bar.effect - bar.error), at(bar.effect + bar.error)));
        }
        let effect = format!("{} {}", signed(bar.effect), panel.unit);
        out.push(Words::node("soft", [left + NAMES + BARS + 8.0, y + 12.0], [], &effect));
    }
}

/// Three digits, with its sign.
fn signed(x: f64) -> String {
    if x == 0.0 || !x.is_finite() {
        return "0".to_owned();
    }
    let digits = (2 - x.abs().log10().floor() as i32).clamp(0, 7) as usize;
    format!("{x:+.digits$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bars_stand_to_the_side_of_their_sign() {
        let bar = |effect: f64, marked| Bar { label: "a<b".into(), effect, error: 0.1, marked };
        let panel = TornadoPanel {
            title: "speed".into(),
            unit: "m/s".into(),
            bars: vec![bar(2.0, false), bar(-1.0, true), bar(f64::NAN, false)],
        };
        let picture = tornado_picture(&Tornado { title: "t".into(), subtitle: String::new(), panels: vec![panel] });
        let svg = picture.svg();
        assert!(svg.contains("class=\"up\"") && svg.contains("class=\"down hollow\"") && svg.contains("a&lt;b"));
        assert!(svg.contains("+2.00 m/s") && svg.contains("-1.00 m/s") && !svg.contains("NaN"));
    }
}
