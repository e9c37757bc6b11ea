//! Outlines as paths.
//!
//! SVG's y points down and the piano's up, so everything is written as (x, -y) in millimetres; a body's frame then
//! becomes `translate(x -y) rotate(-angle)` and text needs no flipping back.

use super::piece::Piece;
use crate::picture::{Segment, Turn};
use erard::instrument::{Placement, Vec2};

/// Metres of the instrument to millimetres of the picture.
pub(crate) const MM: f64 = 1000.0;

/// The path of a piece in the frame of its carrier; empty where the outline is no area.
///
/// A smooth piece has every corner cut by half the shorter of its two edges and replaced by an arc through the cuts.
/// Long edges so stay straight, short ones blend into a curve through their midpoints, and a corner written twice
/// stays sharp.
pub(crate) fn path(piece: &Piece) -> Vec<Segment> {
    let points: Vec<Vec2> = piece
        .outline_m
        .iter()
        .filter(|point| point.iter().all(|c| c.is_finite()))
        .map(|point| [point[0] * MM, -point[1] * MM])
        .collect();
    if points.len() < 3 {
        return Vec::new();
    }
    let mut out = if piece.smooth {
        smooth(&points)
    } else {
        points.iter().enumerate().map(|(index, point)| onward(index, *point)).collect()
    };
    out.push(Segment::Close);
    out
}

/// The way to a point, from nowhere to the first.
fn onward(index: usize, point: Vec2) -> Segment {
    if index == 0 { Segment::Move(point) } else { Segment::Line(point) }
}

fn smooth(points: &[Vec2]) -> Vec<Segment> {
    let mut out = Vec::with_capacity(2 * points.len() + 1);
    let count = points.len();
    for index in 0..count {
        let before = points[(index + count - 1) % count];
        let corner = points[index];
        let after = points[(index + 1) % count];
        let (to_before, to_after) = (length(corner, before), length(corner, after));
        let cut = 0.5 * to_before.min(to_after);
        let enter = along(corner, before, to_before, cut);
        let leave = along(corner, after, to_after, cut);
        out.push(onward(index, enter));
        if cut > 0.0 {
            out.push(Segment::Quad(corner, leave));
        }
    }
    out
}

fn length(a: Vec2, b: Vec2) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

fn along(from: Vec2, to: Vec2, distance: f64, step: f64) -> Vec2 {
    if distance <= 0.0 {
        return from;
    }
    let share = step / distance;
    [from[0] + share * (to[0] - from[0]), from[1] + share * (to[1] - from[1])]
}

/// What carries a body's frame into the picture.
pub(crate) fn turn(placement: &Placement) -> Turn {
    let [x, y] = placement.pivot_m;
    Turn { to: [x * MM, -y * MM], degrees: -placement.angle_rad.to_degrees() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drawing::Carrier;
    use crate::drawing::material::Finish;
    use crate::picture;

    fn square(smooth: bool) -> Piece {
        Piece {
            name: "square".into(),
            carrier: Carrier::Ground,
            finish: Finish::Wood,
            outline_m: vec![[0.0, 0.0], [0.01, 0.0], [0.01, 0.01], [0.0, 0.01]],
            smooth,
        }
    }

    fn text(piece: &Piece) -> String {
        picture::path(&path(piece))
    }

    #[test]
    fn y_points_down_in_the_picture() {
        assert_eq!(text(&square(false)), "M0 0L10 0L10 -10L0 -10Z");
    }

    #[test]
    fn smooth_corners_meet_at_the_middle_of_the_edges() {
        let drawn = text(&square(true));
        assert!(drawn.starts_with("M0 -5Q0 0 5 0L5 0Q10 0 10 -5"), "{drawn}");
    }

    #[test]
    fn a_corner_written_twice_stays_sharp() {
        let mut part = square(true);
        part.outline_m.insert(1, [0.01, 0.0]);
        assert!(text(&part).contains("L10 0L10 0"), "{}", text(&part));
    }

    #[test]
    fn what_is_no_area_draws_nothing() {
        let mut part = square(false);
        part.outline_m = vec![[0.0, 0.0], [f64::NAN, 0.0], [0.0, 1.0]];
        assert_eq!(text(&part), "");
    }
}
