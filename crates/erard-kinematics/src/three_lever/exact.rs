//! The three levers solved by trigonometry, one contact after the other: the first
//! guess for Newton-Raphson, and an answer independent of it.

use super::{ThreeLever, ThreeLeverError};
use crate::linkage::closed_form::{cosine_equation, wrap};

/// The four unknowns (rad, m) for a given key angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Exact {
    pub w: f64,
    pub h: f64,
    pub s1: f64,
    pub s2: f64,
}

/// Of two solutions, the one nearest to level: at rest a whippen lies and a shank
/// lies; the other solution has it upside down.
fn nearest_to_level(solutions: [f64; 2]) -> f64 {
    nearest(solutions, 0.0)
}

/// Of two angles, whole turns apart or not, the one nearest to `to`, and within half a turn of it.
pub(super) fn nearest(solutions: [f64; 2], to: f64) -> f64 {
    let [a, b] = solutions.map(|x| wrap(x - to));
    to + if a.abs() <= b.abs() { a } else { b }
}

pub(super) fn rotate(angle: f64, [x, y]: [f64; 2]) -> [f64; 2] {
    let (s, c) = angle.sin_cos();
    [c * x - s * y, s * x + c * y]
}

impl ThreeLever {
    /// The pose at key angle `k`, whippen and shank nearest to level.
    pub(crate) fn exact(&self, k: f64) -> Result<Exact, ThreeLeverError> {
        let l = &self.lengths;
        // The heel's contact lies at height L2 along the key's normal: with x = w - k,
        // L3 cos x + L4 sin x = L2 - n . (L1, L5).
        let (sk, ck) = k.sin_cos();
        let height = l.l2 - l.l1 * ck - l.l5 * sk;
        let w = cosine_equation(l.l3, l.l4, height)
            .map(|solutions| nearest_to_level(solutions.map(|x| x + k)))
            .ok_or(ThreeLeverError::OutOfReach { contact: "capstan", lever: "k", at: k })?;
        let [_, s1] = self.capstan_seen_from_key(k, w);

        // The knuckle's contact lies at height -L7 over the whippen: with x = h - w,
        // L8 sin x - L9 cos x = -L7 - L6 sin w - L10 cos w.
        let (sw, cw) = w.sin_cos();
        let height = -l.l7 - l.l6 * sw - l.l10 * cw;
        let h = cosine_equation(-l.l9, l.l8, height)
            .map(|solutions| nearest_to_level(solutions.map(|x| x + w)))
            .ok_or(ThreeLeverError::OutOfReach { contact: "knuckle", lever: "k", at: k })?;
        let [x, _] = rotate(-w, self.knuckle_from_whippen_pivot(h));
        Ok(Exact { w, h, s1, s2: -x })
    }

    /// The whippen's angle at a given hammer angle, nearest to level.
    pub(crate) fn whippen_under(&self, h: f64) -> Result<f64, ThreeLeverError> {
        // The knuckle's contact, seen from B, has height -L7 in the whippen's frame.
        let [x, y] = self.knuckle_from_whippen_pivot(h);
        cosine_equation(y, -x, -self.lengths.l7).map(nearest_to_level).ok_or(ThreeLeverError::OutOfReach {
            contact: "knuckle",
            lever: "h",
            at: h,
        })
    }

    /// The heel's contact in the key's frame: (L2, S1) if the pose is a true one.
    pub(crate) fn capstan_seen_from_key(&self, k: f64, w: f64) -> [f64; 2] {
        let l = &self.lengths;
        let [x, y] = rotate(w, [l.l3, -l.l4]);
        rotate(-k, [l.l1 + x, l.l5 + y])
    }

    fn knuckle_from_whippen_pivot(&self, h: f64) -> [f64; 2] {
        let l = &self.lengths;
        let [x, y] = rotate(h, [l.l8, -l.l9]);
        [x - l.l6, y + l.l10]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Newton-Raphson on the generated equations and trigonometry agree at every
    /// key position. Both round at 1e-16 times a condition number below 100 here:
    /// 1e-13 rad and 1e-13 m are generous, and any wrong sign fails by far.
    #[test]
    fn newton_agrees_with_trigonometry() {
        for levers in [ThreeLever::c7f_like(), ThreeLever::steinway_o_like()] {
            let stroke = levers.assemble().unwrap().stroke(0.0, 0.010, 200);
            assert_eq!(stroke.poses.len(), 201);
            for pose in &stroke.poses {
                let exact = levers.exact(pose.k).unwrap();
                let errors = [pose.w - exact.w, pose.h - exact.h, pose.s1 - exact.s1, pose.s2 - exact.s2];
                assert!(errors.iter().all(|e| e.abs() < 1e-13), "{errors:?}");
            }
        }
    }
}
