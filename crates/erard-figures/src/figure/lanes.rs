//! Many curves that start and stop, each in a lane of its own over a common logarithmic axis.

use super::axes::{line, short, thinned};
use super::{Area, Figure, Layout, Panel, Window};
use crate::picture::{Anchor, Clip, Geometry, Group, Look, Node, Paint, Segment, Shape, Words};

/// Empty strip at the top of a lane, px, so that neighbours do not touch.
const HEADROOM: f64 = 4.0;

/// The lanes of one window.
pub(super) fn lanes(
    out: &mut Vec<Node>,
    figure: &Figure,
    panel: &Panel,
    window: &Window,
    area: Area,
    numbers: bool,
    clip: &Clip,
) {
    let Layout::Lanes { floor, ceiling } = panel.layout else { return };
    let count = panel.curves.len().max(1) as f64;
    let tall = area.height / count;
    let share = |value: f64| ((value / floor).log10() / (ceiling / floor).log10()).clamp(0.0, 1.0);
    // every other decade is enough in a lane this low: the even or the odd ones, whichever are more
    let marks = decades(floor, ceiling);
    let is_even = |decade: f64| (decade.log10().round() as i64).rem_euclid(2) == 0;
    let evens = marks.iter().filter(|decade| is_even(**decade)).count();
    let is_numbered = |decade: f64| is_even(decade) == (2 * evens >= marks.len());
    for (index, curve) in panel.curves.iter().enumerate() {
        let base = area.top + tall * (index as f64 + 1.0);
        let y_of = |value: f64| {
            if value > floor { base - share(value) * (tall - HEADROOM) } else { base }
        };
        for &decade in &marks {
            let y = y_of(decade);
            line(out, "grid", [area.left, y], [area.right(), y]);
            if numbers && is_numbered(decade) {
                let looks = [Look::Anchor(Anchor::End), Look::FontSize(8.5)];
                out.push(Words::node("soft", [area.left - 5.0, y + 3.0], looks, &decade.to_string()));
            }
        }
        let mut drawn = Vec::new();
        for run in thinned(figure, curve, window, area) {
            let (Some(first), Some(last)) = (run.first(), run.last()) else {
                continue;
            };
            let looks = vec![
                Look::Fill(Paint::Colour(curve.colour)),
                Look::FillOpacity(0.3),
                Look::Stroke(Paint::Colour(curve.colour)),
                Look::StrokeWidth(1.0),
                Look::RoundJoins,
            ];
            let mut path = vec![Segment::Move([short(first.0), short(base)])];
            // Points at the floor in the middle of a rest say nothing; leaving them out keeps files small.
            let mut resting = false;
            for (at, (x, value)) in run.iter().enumerate() {
                let rests = *value <= floor;
                let stays = run.get(at + 1).is_some_and(|next| next.1 <= floor);
                if !(rests && resting && stays) {
                    path.push(Segment::Line([short(*x), short(y_of(*value))]));
                }
                resting = rests;
            }
            path.extend([Segment::Line([short(last.0), short(base)]), Segment::Close]);
            drawn.push(Shape::looking(looks, Geometry::Path(path)));
        }
        out.push(Node::Group(Group { clip: Some(clip.clone()), nodes: drawn, ..Group::default() }));
        line(out, "tick", [area.left, base], [area.right(), base]);
    }
}

/// The lanes' names and their peaks, beside the last window.
pub(super) fn names(out: &mut Vec<Node>, panel: &Panel, left: f64, top: f64) {
    let tall = panel.height_px / panel.curves.len().max(1) as f64;
    for (index, curve) in panel.curves.iter().enumerate() {
        let y = top + tall * (index as f64 + 0.5);
        let peak = curve.y.iter().copied().filter(|value| value.is_finite()).fold(0.0, f64::max);
        let bar = Geometry::rect([left - 4.0, y - 0.5 * tall + HEADROOM, 5.0, tall - HEADROOM]);
        out.push(Shape::with(bar, vec![Look::Fill(Paint::Colour(curve.colour))]));
        out.push(Words::node("ink", [left + 8.0, y + 0.5], [Look::FontSize(11.0)], &curve.label));
        let peak = format!("peak {}", crate::drawing::force_label(peak));
        out.push(Words::node("soft", [left + 8.0, y + 12.0], [Look::FontSize(9.5)], &peak));
    }
}

/// Powers of ten strictly between the ends.
fn decades(floor: f64, ceiling: f64) -> Vec<f64> {
    let first = (floor.log10() + 1e-9).floor() as i32 + 1;
    (first..).map(|power| 10f64.powi(power)).take_while(|decade| *decade < ceiling * (1.0 - 1e-9)).take(20).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decades_lie_between_the_ends() {
        assert_eq!(decades(0.01, 100.0), vec![0.1, 1.0, 10.0]);
        assert_eq!(decades(0.02, 500.0).len(), 4);
    }
}
