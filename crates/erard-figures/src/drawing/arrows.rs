//! Forces as arrows, with numbers that neither arrows nor other numbers cross.

use super::force::{ARROW, Arrow, force_label};
use super::outline::MM;
use crate::picture::{Anchor, Geometry, Group, Look, Node, Segment, Shape, Words};
use erard::instrument::Vec2;

/// Half the width of an arrow's head, mm, and its length.
const HALF_HEAD: f64 = 1.9;
const HEAD: f64 = 4.0;
/// Height of a number and width of its average letter, mm.
const HEIGHT: f64 = 5.0;
const LETTER: f64 = 3.2;
/// Room around a number, mm.
const ROOM: f64 = 0.8;

/// An upright box, picture millimetres: left, top, right, bottom.
type Box4 = [f64; 4];

/// The arrows, in picture millimetres.
pub(crate) fn arrows(arrows: &[Arrow]) -> Node {
    let drawn: Vec<&Arrow> = arrows.iter().filter(|arrow| arrow.force_n >= ARROW.smallest_drawn_n).collect();
    let shafts: Vec<[Vec2; 2]> = drawn.iter().map(|arrow| shaft(arrow)).collect();
    let mut nodes = Vec::new();
    let mut numbers = Vec::new();
    let mut taken: Vec<Box4> = Vec::new();
    for (arrow, [from, _]) in drawn.iter().zip(&shafts) {
        let [ux, uy] = [arrow.direction[0], -arrow.direction[1]];
        let length = ARROW.length_mm(arrow.force_n);
        let point = |along: f64, across: f64| [from[0] + ux * along - uy * across, from[1] + uy * along + ux * across];
        let neck = length - HEAD;
        let path = vec![
            Segment::Move(point(0.0, 0.0)),
            Segment::Line(point(neck, 0.0)),
            Segment::Move(point(length, 0.0)),
            Segment::Line(point(neck, HALF_HEAD)),
            Segment::Line(point(neck, -HALF_HEAD)),
            Segment::Close,
        ];
        nodes.push(Shape::of_class(format!("arrow {}", arrow.kind.class()), Geometry::Path(path)));
        if arrow.force_n < ARROW.smallest_labelled_n {
            continue;
        }
        let label = force_label(arrow.force_n);
        let size = [label.chars().count() as f64 * LETTER, HEIGHT];
        let place = free_place(arrow, size, &shafts, &taken);
        taken.push(place);
        let middle = [0.5 * (place[0] + place[2]), place[3] - 0.8];
        let class = format!("newton {}", arrow.kind.class());
        numbers.push(Words::node(class, middle, [Look::Anchor(Anchor::Middle)], &label));
    }
    // numbers after all arrows, so that none is struck through
    nodes.extend(numbers);
    Node::Group(Group { class: "forces", nodes, ..Group::default() })
}

/// From where to where an arrow goes, picture millimetres.
fn shaft(arrow: &Arrow) -> [Vec2; 2] {
    let from = [arrow.point_m[0] * MM, -arrow.point_m[1] * MM];
    let length = ARROW.length_mm(arrow.force_n);
    [from, [from[0] + arrow.direction[0] * length, from[1] - arrow.direction[1] * length]]
}

/// The nearest place for a number about its arrow's tip that no arrow and no other number crosses. Rings of growing
/// radius about the tip are tried, each from the arrow's own direction to its opposite; the page's script does the
/// same.
fn free_place(arrow: &Arrow, [width, height]: Vec2, shafts: &[[Vec2; 2]], taken: &[Box4]) -> Box4 {
    let [_, tip] = shaft(arrow);
    let heading = (-arrow.direction[1]).atan2(arrow.direction[0]);
    let mut first = None;
    for ring in 0..40 {
        for turn in [0.0, 0.5, -0.5, 1.0, -1.0, 1.5, -1.5, 2.0, -2.0, 2.5, -2.5, 3.1] {
            let (sin, cos) = f64::sin_cos(heading + turn);
            // A box whose edge is so far from the tip.
            let away = 1.5 + 2.0 * f64::from(ring) + 0.5 * (width * cos.abs() + height * sin.abs());
            let center = [tip[0] + away * cos, tip[1] + away * sin];
            let place =
                [center[0] - 0.5 * width, center[1] - 0.5 * height, center[0] + 0.5 * width, center[1] + 0.5 * height];
            let wide = [place[0] - ROOM, place[1] - ROOM, place[2] + ROOM, place[3] + ROOM];
            let is_free = !taken.iter().any(|other| overlap(other, &wide))
                && !shafts.iter().any(|shaft| crosses(shaft, &wide, HALF_HEAD));
            if is_free {
                return place;
            }
            first.get_or_insert(place);
        }
    }
    first.unwrap_or([tip[0], tip[1], tip[0] + width, tip[1] + height])
}

fn overlap(a: &Box4, b: &Box4) -> bool {
    a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3]
}

/// Whether a line of some half width crosses a box: Liang and Barsky's clipping against the box made wider.
fn crosses([from, to]: &[Vec2; 2], place: &Box4, half: f64) -> bool {
    let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
    for axis in 0..2 {
        let (low, high) = (place[axis] - half, place[axis + 2] + half);
        let way = to[axis] - from[axis];
        if way.abs() < 1e-12 {
            if from[axis] < low || from[axis] > high {
                return false;
            }
            continue;
        }
        let (a, b) = ((low - from[axis]) / way, (high - from[axis]) / way);
        enter = enter.max(a.min(b));
        leave = leave.min(a.max(b));
    }
    enter <= leave
}

#[cfg(test)]
mod tests {
    use super::super::force::ArrowKind;
    use super::*;

    fn arrow(x: f64, y: f64, angle: f64, force_n: f64) -> Arrow {
        let (sin, cos) = angle.sin_cos();
        Arrow { kind: ArrowKind::Contact, point_m: [x, y], direction: [cos, sin], force_n }
    }

    fn svg(all: &[Arrow]) -> String {
        crate::picture::nodes(&[arrows(all)])
    }

    #[test]
    fn small_forces_stay_silent() {
        assert!(!svg(&[arrow(0.0, 0.0, 1.0, 0.001)]).contains("path"));
        assert!(!svg(&[arrow(0.0, 0.0, 1.0, 0.1)]).contains("text"));
        assert!(svg(&[arrow(0.0, 0.0, 1.0, 12.34)]).contains("12.3 N"));
    }

    /// Thirty arrows in the space of a hand, numbers of all lengths: none is crossed. The boxes are read from the text
    /// that is written.
    #[test]
    fn no_arrow_crosses_a_number() {
        let mut seed = 7_u64;
        let mut random = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1_u64 << 53) as f64
        };
        for _ in 0..50 {
            let all: Vec<Arrow> = (0..30)
                .map(|_| arrow(0.15 * random(), 0.1 * random(), 6.3 * random(), 200.0 * random().powi(4)))
                .collect();
            let svg = svg(&all);
            let number_after = |text: &str, name: &str| -> f64 {
                text.split(name).nth(1).unwrap().split('"').next().unwrap().parse().unwrap()
            };
            let boxes: Vec<Box4> = svg
                .split("<text ")
                .skip(1)
                .map(|text| {
                    let (x, y) = (number_after(text, " x=\""), number_after(text, " y=\""));
                    let letters = text.split('>').nth(1).unwrap().split('<').next().unwrap().chars().count();
                    let half = 0.5 * letters as f64 * LETTER;
                    [x - half, y - 4.2, x + half, y + 0.8]
                })
                .collect();
            assert!(boxes.len() > 10);
            for (index, place) in boxes.iter().enumerate() {
                assert!(!boxes[..index].iter().any(|other| overlap(other, place)), "two numbers meet");
                for arrow in all.iter().filter(|arrow| arrow.force_n >= ARROW.smallest_drawn_n) {
                    assert!(!crosses(&shaft(arrow), place, 0.0), "{arrow:?} crosses a number");
                }
            }
        }
    }
}
