//! Closure terms as numbers: sums of vectors, with their derivatives.

use super::closure::{Magnitude, Term};
use super::description::{BodyId, JointId, Linkage};

/// A constant vector `v` fixed on the body with angle coordinate `angle`.
#[derive(Clone, Copy, Debug)]
struct Rigid {
    sum: usize,
    angle: usize,
    v: [f64; 2],
}

/// `s u`, with `u` fixed on the body with angle coordinate `angle`, or on the ground.
#[derive(Clone, Copy, Debug)]
struct Slide {
    sum: usize,
    angle: Option<usize>,
    sliding: usize,
    u: [f64; 2],
}

/// Several sums of terms, compiled for evaluation. Lengths are divided by `scale`
/// (metres), so that values are pure numbers and residuals relative.
#[derive(Clone, Debug)]
pub(crate) struct VectorSums {
    fixed: Vec<[f64; 2]>,
    rigid: Vec<Rigid>,
    slides: Vec<Slide>,
    scale: f64,
}

/// Where a body's angle and a joint's sliding sit among the coordinates.
pub(crate) struct Places<'a> {
    /// By body; `None` for the ground and for bodies held to it.
    pub angle: &'a [Option<usize>],
    /// By joint; `None` for revolute joints.
    pub sliding: &'a [Option<usize>],
}

impl Places<'_> {
    fn angle(&self, body: BodyId) -> Option<usize> {
        self.angle[body.0]
    }

    fn sliding(&self, joint: JointId) -> usize {
        self.sliding[joint.0].expect("only prismatic joints slide")
    }
}

#[inline]
fn turn([c, s]: [f64; 2], v: [f64; 2]) -> [f64; 2] {
    [c * v[0] - s * v[1], s * v[0] + c * v[1]]
}

impl VectorSums {
    pub(crate) fn new(linkage: &Linkage, places: &Places<'_>, scale: f64, sums: &[&[Term]]) -> Self {
        let mut fixed = vec![[0.0; 2]; sums.len()];
        let mut rigid: Vec<Rigid> = Vec::new();
        let mut slides = Vec::new();
        for (sum, term) in (sums.iter().enumerate()).flat_map(|(i, s)| s.iter().map(move |t| (i, t))) {
            let direction = term.direction.cos_sin(&linkage.angles);
            let u = direction.map(|x| f64::from(term.coefficient) * x);
            let angle = places.angle(term.frame);
            match term.magnitude {
                Magnitude::Sliding(joint) => slides.push(Slide { sum, angle, sliding: places.sliding(joint), u }),
                Magnitude::Length(id) => {
                    let length = linkage.lengths[id.0].value / scale;
                    let v = u.map(|x| x * length);
                    let same = rigid.iter().position(|r| r.sum == sum && Some(r.angle) == angle);
                    let target = match (angle, same) {
                        (None, _) => &mut fixed[sum],
                        (Some(_), Some(at)) => &mut rigid[at].v,
                        (Some(angle), None) => {
                            rigid.push(Rigid { sum, angle, v: [0.0; 2] });
                            &mut rigid.last_mut().expect("just pushed").v
                        }
                    };
                    target[0] += v[0];
                    target[1] += v[1];
                }
            }
        }
        VectorSums { fixed, rigid, slides, scale }
    }

    /// `sums[2i..2i+2]` becomes the i-th vector over `scale`; `jacobian`
    /// (row-major, `q.len()` columns) its derivatives, angles per radian and
    /// slidings per `scale`. `trig` holds (cos, sin) of the angle coordinates.
    pub(crate) fn linearise(&self, q: &[f64], trig: &[[f64; 2]], sums: &mut [f64], jacobian: &mut [f64]) {
        let n = q.len();
        for (out, fixed) in sums.chunks_exact_mut(2).zip(&self.fixed) {
            out.copy_from_slice(fixed);
        }
        jacobian.fill(0.0);
        for r in &self.rigid {
            let [x, y] = turn(trig[r.angle], r.v);
            let row = 2 * r.sum;
            sums[row] += x;
            sums[row + 1] += y;
            jacobian[row * n + r.angle] -= y;
            jacobian[(row + 1) * n + r.angle] += x;
        }
        for slide in &self.slides {
            let [dx, dy] = slide.angle.map_or(slide.u, |angle| turn(trig[angle], slide.u));
            let s = q[slide.sliding] / self.scale;
            let row = 2 * slide.sum;
            sums[row] += s * dx;
            sums[row + 1] += s * dy;
            jacobian[row * n + slide.sliding] += dx;
            jacobian[(row + 1) * n + slide.sliding] += dy;
            if let Some(angle) = slide.angle {
                jacobian[row * n + angle] -= s * dy;
                jacobian[(row + 1) * n + angle] += s * dx;
            }
        }
    }

    /// The second time derivative of the vectors with all accelerations zero:
    /// what the velocities `v` (rad/s, m/s) alone contribute, over `scale`.
    pub(crate) fn convective(&self, q: &[f64], v: &[f64], trig: &[[f64; 2]], out: &mut [f64]) {
        out.fill(0.0);
        for r in &self.rigid {
            let [x, y] = turn(trig[r.angle], r.v);
            let w = v[r.angle];
            out[2 * r.sum] -= w * w * x;
            out[2 * r.sum + 1] -= w * w * y;
        }
        for slide in &self.slides {
            let Some(angle) = slide.angle else { continue };
            let [dx, dy] = turn(trig[angle], slide.u);
            let w = v[angle];
            let (s, rate) = (q[slide.sliding] / self.scale, v[slide.sliding] / self.scale);
            out[2 * slide.sum] += -2.0 * rate * w * dy - s * w * w * dx;
            out[2 * slide.sum + 1] += 2.0 * rate * w * dx - s * w * w * dy;
        }
    }
}
