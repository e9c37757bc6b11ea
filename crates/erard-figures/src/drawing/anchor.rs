//! A point of a part that can be seen: where a leader line may end.

use erard::instrument::Vec2;

/// Points tried across a part's width and height.
const GRID: usize = 32;
/// How far from any edge a leader's end should lie, m; given up where a part has no such point.
const CLEAR: f64 = 1.2e-3;

/// The point of the outline `index` that is nearest to its centroid and neither outside it (an L, a ring's sickle) nor
/// covered by a later outline; `None` where the outline is no area or wholly covered. All outlines in one frame.
pub(crate) fn visible_point(outlines: &[Vec<Vec2>], index: usize) -> Option<Vec2> {
    let (outline, covers) = (&outlines[index], &outlines[index + 1..]);
    let centroid = centroid(outline)?;
    let seen = |point: Vec2| inside(outline, point) && !covers.iter().any(|cover| inside(cover, point));
    let clear = |point: Vec2| {
        let [x, y] = point;
        [[CLEAR, 0.0], [-CLEAR, 0.0], [0.0, CLEAR], [0.0, -CLEAR]].iter().all(|d| seen([x + d[0], y + d[1]]))
    };
    let mut candidates = vec![centroid];
    let bound = |axis: usize| {
        let values = outline.iter().map(move |point| point[axis]);
        (values.clone().fold(f64::INFINITY, f64::min), values.fold(f64::NEG_INFINITY, f64::max))
    };
    let ((left, right), (low, high)) = (bound(0), bound(1));
    for row in 0..GRID {
        for column in 0..GRID {
            let share = |step: usize| (step as f64 + 0.5) / GRID as f64;
            candidates.push([left + share(column) * (right - left), low + share(row) * (high - low)]);
        }
    }
    // The nearest first: of most parts the first few points answer, and looking at a point is what takes time.
    let away = |point: Vec2| (point[0] - centroid[0]).hypot(point[1] - centroid[1]);
    let mut nearest: Vec<(f64, Vec2)> = candidates.into_iter().map(|point| (away(point), point)).collect();
    nearest.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut visible = nearest.into_iter().map(|(_, point)| point).filter(|point| seen(*point)).peekable();
    let first = visible.peek().copied();
    visible.find(|point| clear(*point)).or(first)
}

fn centroid(outline: &[Vec2]) -> Option<Vec2> {
    let mut doubled_area = 0.0;
    let mut moment = [0.0; 2];
    for (index, a) in outline.iter().enumerate() {
        let b = outline[(index + 1) % outline.len()];
        let cross = a[0] * b[1] - b[0] * a[1];
        doubled_area += cross;
        moment[0] += (a[0] + b[0]) * cross;
        moment[1] += (a[1] + b[1]) * cross;
    }
    let centroid = [moment[0] / (3.0 * doubled_area), moment[1] / (3.0 * doubled_area)];
    centroid.iter().all(|c| c.is_finite()).then_some(centroid)
}

/// Even-odd rule.
fn inside(outline: &[Vec2], [x, y]: Vec2) -> bool {
    let mut is_inside = false;
    for (index, a) in outline.iter().enumerate() {
        let b = outline[(index + 1) % outline.len()];
        if (a[1] > y) != (b[1] > y) && x < a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0]) {
            is_inside = !is_inside;
        }
    }
    is_inside
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rectangle(x0: f64, y0: f64, x1: f64, y1: f64) -> Vec<Vec2> {
        vec![[x0, y0], [x1, y0], [x1, y1], [x0, y1]]
    }

    #[test]
    fn a_leader_ends_inside_an_l() {
        let l = vec![[0.0, 0.0], [0.1, 0.0], [0.1, 0.01], [0.01, 0.01], [0.01, 0.1], [0.0, 0.1]];
        let point = visible_point(std::slice::from_ref(&l), 0).unwrap();
        assert!(inside(&l, point), "{point:?}");
    }

    #[test]
    fn a_leader_ends_beside_what_covers_the_middle() {
        let outlines = [rectangle(0.0, 0.0, 0.1, 0.1), rectangle(0.03, -0.1, 0.07, 0.2)];
        let point = visible_point(&outlines, 0).unwrap();
        assert!(!(0.03..=0.07).contains(&point[0]), "{point:?}");
    }

    #[test]
    fn what_cannot_be_seen_has_no_point() {
        let outlines = [rectangle(0.0, 0.0, 0.1, 0.1), rectangle(-0.1, -0.1, 0.2, 0.2)];
        assert_eq!(visible_point(&outlines, 0), None);
        assert_eq!(visible_point(&[vec![[0.0, 0.0], [1.0, 1.0]]], 0), None);
        assert_eq!(visible_point(&[vec![[f64::NAN, 0.0], [1.0, 1.0], [1.0, 0.0]]], 0), None);
    }
}
