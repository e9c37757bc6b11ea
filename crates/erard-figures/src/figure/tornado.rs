//! A tornado: what changes a quantity most, as bars to either side of its value.

use std::fmt::Write;

use super::sheet;
use crate::svg::{number, sides, text};

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
const SIDES: &str = ".up{fill:#0072b2;stroke:#0072b2}.down{fill:#d55e00;stroke:#d55e00}.hollow{fill:#fff}";

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

/// A tornado as an SVG document. The same figure gives the same bytes.
pub fn tornado_svg(figure: &Tornado) -> String {
    let wide = NAMES + BARS + NUMBERS + GAP;
    let tall = |row: &[TornadoPanel]| {
        let most = row.iter().map(|panel| panel.bars.len()).max().unwrap_or(0);
        24.0 + LINE * most as f64 + GAP
    };
    let rows: Vec<&[TornadoPanel]> = figure.panels.chunks(BESIDE).collect();
    let columns = figure.panels.len().clamp(1, BESIDE) as f64;
    let (width, height) = (wide * columns + GAP, TOP + rows.iter().map(|row| tall(row)).sum::<f64>());
    let mut out = sheet(&figure.title, [width, height], 11, SIDES, [GAP, 24.0]);
    text(&mut out, "soft", [GAP, 43.0], "", &figure.subtitle);
    let mut y = TOP;
    for row in rows {
        for (column, panel) in row.iter().enumerate() {
            draw(&mut out, panel, GAP + wide * column as f64, y);
        }
        y += tall(row);
    }
    out.push_str("</svg>\n");
    out
}

fn draw(out: &mut String, panel: &TornadoPanel, left: f64, top: f64) {
    let largest =
        panel.bars.iter().map(|bar| bar.effect.abs() + bar.error).filter(|x| x.is_finite()).fold(0.0, f64::max);
    let scale = if largest > 0.0 { 0.5 * BARS / largest } else { 0.0 };
    let zero = left + NAMES + 0.5 * BARS;
    let (first, last) = (top + 20.0, top + 20.0 + LINE * panel.bars.len() as f64);
    text(out, "ink", [left, top + 12.0], " font-size=\"13\"", &panel.title);
    let [z, from, to] = [zero, first, last].map(number);
    let _ = write!(out, "<path class=\"tick\" d=\"M{z} {from}L{z} {to}\"/>");
    for (k, bar) in panel.bars.iter().enumerate() {
        let y = first + LINE * k as f64;
        let long = if bar.effect.is_finite() { bar.effect * scale } else { 0.0 };
        let (x, width) = if long < 0.0 { (zero + long, -long) } else { (zero, long) };
        let side = if long < 0.0 { "down" } else { "up" };
        let hollow = if bar.marked { " hollow" } else { "" };
        text(out, "ink", [left + NAMES - 8.0, y + 12.0], " text-anchor=\"end\"", &bar.label);
        let place = sides([x, y + 3.0, width, LINE - 6.0]);
        let _ = write!(out, "<rect class=\"{side}{hollow}\"{place}/>");
        if bar.error > 0.0 && bar.error.is_finite() {
            let [a, b] = [bar.effect - bar.error, bar.effect + bar.error].map(|e| number(zero + scale * e));
            let middle = number(y + 0.5 * LINE);
            let _ = write!(out, "<path class=\"tick\" d=\"M{a} {middle}L{b} {middle}\"/>");
        }
        let effect = format!("{} {}", signed(bar.effect), panel.unit);
        text(out, "soft", [left + NAMES + BARS + 8.0, y + 12.0], "", &effect);
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
        let svg = tornado_svg(&Tornado { title: "t".into(), subtitle: String::new(), panels: vec![panel] });
        assert!(svg.contains("class=\"up\"") && svg.contains("class=\"down hollow\"") && svg.contains("a&lt;b"));
        assert!(svg.contains("+2.00 m/s") && svg.contains("-1.00 m/s") && !svg.contains("NaN"));
    }
}
