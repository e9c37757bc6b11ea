//! Outlines as SVG paths.
//!
//! SVG's y points down and the piano's up, so everything is written as (x, -y) in millimetres; a body's frame then
//! becomes `translate(x -y) rotate(-angle)` and text needs no flipping back.

use super::piece::Piece;
use crate::svg::number;
use erard::instrument::{Placement, Vec2};
use std::fmt::Write;

/// Metres of the instrument to millimetres of the picture.
pub(crate) const MM: f64 = 1000.0;

/// The path of a piece in the frame of its carrier; empty where the outline is no area.
///
/// A smooth piece has every corner cut by half the shorter of its two edges and replaced by an arc through the cuts.
/// Long edges so stay straight, short ones blend into a curve through their midpoints, and a corner written twice
/// stays sharp.
pub(crate) fn path(piece: &Piece) -> String {
    let points: Vec<Vec2> = piece
        .outline_m
        .iter()
        .filter(|point| point.iter().all(|c| c.is_finite()))
        .map(|point| [point[0] * MM, -point[1] * MM])
        .collect();
    if points.len() < 3 {
        return String::new();
    }
    let mut out = String::new();
    if piece.smooth {
        smooth(&points, &mut out);
    } else {
        for (index, point) in points.iter().enumerate() {
            let command = if index == 0 { 'M' } else { 'L' };
            let _ = write!(out, "{command}{} {}", number(point[0]), number(point[1]));
        }
    }
    out.push('Z');
    out
}

fn smooth(points: &[Vec2], out: &mut String) {
    let count = points.len();
    for index in 0..count {
        let before = points[(index + count - 1) % count];
        let corner = points[index];
        let after = points[(index + 1) % count];
        let (to_before, to_after) = (length(corner, before), length(corner, after));
        let cut = 0.5 * to_before.min(to_after);
        let enter = along(corner, before, to_before, cut);
        let leave = along(corner, after, to_after, cut);
        let command = if index == 0 { 'M' } else { 'L' };
        let _ = write!(out, "{command}{} {}", number(enter[0]), number(enter[1]));
        if cut > 0.0 {
            let _ =
                write!(out, "Q{} {} {} {}", number(corner[0]), number(corner[1]), number(leave[0]), number(leave[1]));
        }
    }
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

/// The `transform` attribute that carries a body's frame into the picture.
pub(crate) fn transform(placement: &Placement) -> String {
    format!(
        "translate({} {}) rotate({})",
        number(placement.pivot_m[0] * MM),
        number(-placement.pivot_m[1] * MM),
        number(-placement.angle_rad.to_degrees())
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drawing::Carrier;
    use crate::drawing::material::Finish;

    fn square(smooth: bool) -> Piece {
        Piece {
            name: "square".into(),
            carrier: Carrier::Ground,
            finish: Finish::Wood,
            outline_m: vec![[0.0, 0.0], [0.01, 0.0], [0.01, 0.01], [0.0, 0.01]],
            smooth,
        }
    }

    #[test]
    fn y_points_down_in_the_picture() {
        assert_eq!(path(&square(false)), "M0 0L10 0L10 -10L0 -10Z");
    }

    #[test]
    fn smooth_corners_meet_at_the_middle_of_the_edges() {
        let drawn = path(&square(true));
        assert!(drawn.starts_with("M0 -5Q0 0 5 0L5 0Q10 0 10 -5"), "{drawn}");
    }

    #[test]
    fn a_corner_written_twice_stays_sharp() {
        let mut part = square(true);
        part.outline_m.insert(1, [0.01, 0.0]);
        assert!(path(&part).contains("L10 0L10 0"), "{}", path(&part));
    }

    #[test]
    fn what_is_no_area_draws_nothing() {
        let mut part = square(false);
        part.outline_m = vec![[0.0, 0.0], [f64::NAN, 0.0], [0.0, 1.0]];
        assert_eq!(path(&part), "");
    }
}
