//! Names of parts around the picture, with leader lines to what they name.

use super::anchor::visible_point;
use super::outline::MM;
use super::piece::Piece;
use crate::picture::{Anchor, Geometry, Group, Look, Node, Segment, Shape, Words};
use erard::instrument::{Instrument, Placement, Vec2};

/// Height of a label's letters, mm of the picture.
const SIZE: f64 = 6.4;
/// Width of an average letter against its height.
const LETTER: f64 = 0.6;
/// Room between neighbouring labels, mm.
const GAP: f64 = 5.0;
/// Distance between the two rows on either side, mm.
const ROW: f64 = 10.0;

/// A label before and after it found its place; picture millimetres, y down.
#[derive(Debug, Clone, PartialEq)]
struct Label {
    text: String,
    anchor: Vec2,
    /// Edge of the picture on the label's side.
    edge: f64,
    x: f64,
    row: usize,
}

impl Label {
    fn width(&self) -> f64 {
        self.text.chars().count() as f64 * SIZE * LETTER
    }

    /// How far from the edge lies what it names.
    fn depth(&self) -> f64 {
        (self.anchor[1] - self.edge).abs()
    }
}

/// Room that the labels need above and below the picture, mm.
pub(crate) const MARGIN: f64 = 2.0 * ROW + 6.0;

/// The labels around a picture that spans `[left, top, right, bottom]` in picture millimetres.
///
/// Only main parts are named: a name with a comma (`whippen, post felt`) is a detail, and of several parts of one
/// name the first is labelled.
pub(crate) fn labels(pieces: &[Piece], placed: &[Placement], bounds: [f64; 4]) -> Node {
    let [left, top, right, bottom] = bounds;
    let mut found: Vec<Label> = Vec::new();
    for (index, world) in visible_points(pieces, placed) {
        let anchor = [world[0] * MM, -world[1] * MM];
        found.push(Label { text: pieces[index].name.clone(), anchor, edge: 0.0, x: anchor[0], row: 0 });
    }
    let mut heights: Vec<f64> = found.iter().map(|label| label.anchor[1]).collect();
    heights.sort_by(f64::total_cmp);
    let middle = heights.get(heights.len() / 2).copied().unwrap_or(0.0);
    let (mut above, mut below): (Vec<Label>, Vec<Label>) =
        found.into_iter().partition(|label| label.anchor[1] < middle);
    let mut nodes = Vec::new();
    for (side, edge, outward) in [(&mut above, top, -1.0), (&mut below, bottom, 1.0)] {
        for label in side.iter_mut() {
            label.edge = edge;
        }
        spread(side, left, right);
        for label in side.iter() {
            let y = edge + outward * (5.0 + ROW * label.row as f64);
            let leader = vec![
                Segment::Move([label.x, y - outward * 1.0]),
                Segment::Vertical(edge + outward * 4.0),
                Segment::Line(label.anchor),
            ];
            nodes.push(Shape::of_class("leader", Geometry::Path(leader)));
            nodes.push(Shape::of_class("leader-end", Geometry::Circle(Some(label.anchor), 0.9)));
            let place = [label.x, if outward < 0.0 { y - 1.0 } else { y + SIZE * 0.8 }];
            let looks = [Look::FontSize(SIZE), Look::Anchor(Anchor::Middle)];
            nodes.push(Words::node("label", place, looks, &label.text));
        }
    }
    Node::Group(Group { class: "labels", nodes, ..Group::default() })
}

/// The pieces that have a label: a name with a comma is a detail, and of several pieces of one name the first is
/// labelled. With a point of each that can be seen, m in the world.
fn visible_points(pieces: &[Piece], placed: &[Placement]) -> Vec<(usize, Vec2)> {
    let outlines: Vec<Vec<Vec2>> = pieces
        .iter()
        .map(|piece| piece.outline_m.iter().map(|point| piece.carrier.placement(placed).to_world(*point)).collect())
        .collect();
    let is_first = |index: usize| !pieces[..index].iter().any(|other| other.name == pieces[index].name);
    (0..pieces.len())
        .filter(|&index| !pieces[index].name.contains(',') && !pieces[index].name.is_empty() && is_first(index))
        .filter_map(|index| Some((index, visible_point(&outlines, index)?)))
        .collect()
}

/// The pieces that have a label, each with a point of it that can be seen as drawn, m in its carrier's frame.
pub(crate) fn named_points(instrument: &Instrument, pieces: &[Piece]) -> Vec<(usize, Vec2)> {
    let drawn = instrument.drawn();
    let in_carrier = |(index, world): (usize, Vec2)| (index, pieces[index].carrier.placement(&drawn).from_world(world));
    visible_points(pieces, &drawn).into_iter().map(in_carrier).collect()
}

/// Puts the labels of one side into two staggered rows, in the order of what they name, pushed apart as little as
/// needed and kept within the picture. Row 0 is the one next to the picture: a leader from row 1 has to pass beside the
/// names in it.
fn spread(side: &mut [Label], left: f64, right: f64) {
    side.sort_by(|a, b| a.anchor[0].total_cmp(&b.anchor[0]));
    // Two leaders that cross are untangled by swapping their places, then everything is pushed apart again.
    for _ in 0..side.len().max(1) {
        for (index, label) in side.iter_mut().enumerate() {
            label.row = index % 2;
            label.x = label.anchor[0];
        }
        push_apart(side, left, right);
        let Some(index) = (1..side.len()).find(|index| cross(&side[index - 1], &side[*index])) else {
            break;
        };
        side.swap(index - 1, index);
    }
}

/// Relaxation: neighbours that are too close move apart by halves. A few hundred rounds settle some twenty labels.
fn push_apart(side: &mut [Label], left: f64, right: f64) {
    for _ in 0..600 {
        for index in 1..side.len() {
            let near = if side[index].row == 0 { index } else { index - 1 };
            separate(side, index - 1, index, 0.5 * side[near].width() + 3.5);
            if index > 1 {
                let room = 0.5 * (side[index - 2].width() + side[index].width()) + GAP;
                separate(side, index - 2, index, room);
            }
        }
        for label in side.iter_mut() {
            let half = 0.5 * label.width();
            label.x = label.x.min(right - half).max(left + half);
        }
    }
}

fn separate(side: &mut [Label], before: usize, after: usize, room: f64) {
    let lack = room - (side[after].x - side[before].x);
    if lack > 0.0 {
        side[before].x -= 0.5 * lack;
        side[after].x += 0.5 * lack;
    }
}

/// Whether two leaders, drawn from their labels' places on one line to their anchors, cross.
fn cross(a: &Label, b: &Label) -> bool {
    // from the labels (depth 0) to the shallower of the two anchors
    let depth = a.depth().min(b.depth());
    let at = |label: &Label| {
        let share = depth / label.depth().max(1e-9);
        label.x + share * (label.anchor[0] - label.x)
    };
    (a.x - b.x) * (at(a) - at(b)) < 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_of_a_row_do_not_overlap() {
        let mut side: Vec<Label> = (0..9)
            .map(|i| Label {
                text: format!("a rather long name {i}"),
                anchor: [f64::from(i), 0.0],
                edge: -50.0,
                x: f64::from(i),
                row: 0,
            })
            .collect();
        spread(&mut side, -300.0, 300.0);
        for row in 0..2 {
            let members: Vec<&Label> = side.iter().filter(|label| label.row == row).collect();
            for pair in members.windows(2) {
                assert!(pair[1].x - pair[0].x > pair[0].width(), "{pair:?}");
            }
        }
    }
}
