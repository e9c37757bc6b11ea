//! Instants: thin lines through the panels, their names above.

use super::axes::line;
use super::{Area, Figure, Marker, Window};
use crate::picture::{Anchor, Geometry, Look, Node, Segment, Shape, Words};

/// Height of the strip with the names, px.
pub(super) const HEIGHT: f64 = 46.0;
/// Font size, px.
const SIZE: f64 = 10.5;

/// The lines in one panel.
pub(super) fn lines(out: &mut Vec<Node>, figure: &Figure, window: &Window, area: Area) {
    for marker in shown(figure, window) {
        let x = at(marker.x, window, area);
        line(out, "mark", [x, area.top], [x, area.bottom()]);
    }
}

/// The names, in two rows, each joined to its line.
pub(super) fn names(out: &mut Vec<Node>, figure: &Figure, window: &Window, strip: Area) {
    let mut markers: Vec<&Marker> = shown(figure, window).collect();
    markers.sort_by(|a, b| a.x.total_cmp(&b.x));
    let wide = |marker: &Marker| marker.label.chars().count() as f64 * SIZE * 0.56 + 8.0;
    let mut places: Vec<f64> = markers.iter().map(|marker| at(marker.x, window, strip)).collect();
    // neighbours stand in different rows; a leader from the upper row must pass beside the name in the lower one
    for _ in 0..300 {
        for index in 1..places.len() {
            let beside = 0.5 * wide(markers[if index % 2 == 0 { index } else { index - 1 }]);
            push_apart(&mut places, index - 1, index, beside);
            if index > 1 {
                let same_row = 0.5 * (wide(markers[index - 2]) + wide(markers[index]));
                push_apart(&mut places, index - 2, index, same_row);
            }
        }
        for (place, marker) in places.iter_mut().zip(&markers) {
            let half = 0.5 * wide(marker);
            *place = place.min(strip.right() + 60.0 - half).max(strip.left - 20.0 + half);
        }
    }
    for (index, (marker, place)) in markers.iter().zip(&places).enumerate() {
        let baseline = strip.top + if index % 2 == 0 { 24.0 } else { 9.0 };
        let x = at(marker.x, window, strip);
        let lead = vec![
            Segment::Move([*place, baseline + 3.0]),
            Segment::Line([*place, strip.top + 29.0]),
            Segment::Line([x, strip.bottom()]),
        ];
        out.push(Shape::of_class("lead", Geometry::Path(lead)));
        let looks = [Look::Anchor(Anchor::Middle), Look::FontSize(SIZE)];
        out.push(Words::node("ink", [*place, baseline], looks, &marker.label));
    }
}

fn push_apart(places: &mut [f64], left: usize, right: usize, need: f64) {
    let lack = need - (places[right] - places[left]);
    if lack > 0.0 {
        places[left] -= 0.5 * lack;
        places[right] += 0.5 * lack;
    }
}

fn shown<'a>(figure: &'a Figure, window: &'a Window) -> impl Iterator<Item = &'a Marker> {
    figure.markers.iter().filter(|marker| (window.from..=window.to).contains(&marker.x))
}

fn at(x: f64, window: &Window, area: Area) -> f64 {
    area.left + (x - window.from) / (window.to - window.from) * area.width
}
