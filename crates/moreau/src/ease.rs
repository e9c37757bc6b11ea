//! A quick bound of what a step's linearisation leaves out: most steps are settled by it, at a few operations per zone.
//!
//! A felt's force F(g, dg/dt) leaves its linearisation for two reasons: it bends, which is of second order in the change of the
//! velocities, or it meets the onset of touch or the clamp at zero. The bend is bounded with the longest levers that the rows can have
//! and with the felts' coefficients; both are numbers of the model. How far the onset and the clamp are is gathered zone by zone.

use crate::contact::Timing;
use crate::model::{Exponent, Zone};
use crate::path::Path;
use crate::{Mask, Real, Scalar};

/// m; square roots of compressions are bounded by their tangent here.
const USUAL_DEPTH: f64 = 1e-3;
/// Longer than any distance, faster than any speed.
const FAR: f64 = 1e30;

/// What the felts of a model can do at most to each joint.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bending<T, const B: usize> {
    /// The largest |dg/dt| of any zone for joint velocities of at most 1, m.
    lever: T,
    /// Sums over the joint's zones of its lever times the square of |dg/dt| for joint velocities of at most 1, times half the second
    /// derivative of k g^r, at no compression and per metre of it, and times b.
    stiffness: [T; B],
    stiffness_by_depth: [T; B],
    damping: [T; B],
}

impl<T: Scalar, const B: usize> Bending<T, B> {
    pub fn of<'a>(zones: impl Iterator<Item = (&'a Zone<T>, &'a Path<T, B>)>) -> Self
    where
        T: 'a,
    {
        let (c, o) = (T::from_f64, [T::ZERO; B]);
        let mut bending = Bending { lever: T::ZERO, stiffness: o, stiffness_by_depth: o, damping: o };
        for (zone, path) in zones {
            let mut lever = T::ZERO;
            for (k, _) in path.joints() {
                lever += path.lever(k);
            }
            bending.lever = bending.lever.max(lever);
            let (constant, by_depth) = match zone.felt.exponent {
                Exponent::Two => (1.0, 0.0),
                // sqrt(g) <= (d + g) / (2 sqrt(d)) for any d.
                Exponent::TwoAndHalf => (0.9375 * libm::sqrt(USUAL_DEPTH), 0.9375 / libm::sqrt(USUAL_DEPTH)),
                Exponent::Three => (0.0, 3.0),
                // No bound: always looked at zone by zone.
                Exponent::Other(_) => (FAR, 0.0),
            };
            for (k, j) in path.joints() {
                let share = path.lever(k) * lever * lever;
                bending.stiffness[j] += share * zone.felt.stiffness * c(constant);
                bending.stiffness_by_depth[j] += share * zone.felt.stiffness * c(by_depth);
                bending.damping[j] += share * zone.felt.damping;
            }
        }
        bending
    }
}

impl<T: Real, const B: usize> Bending<T, B> {
    /// Of as many models as there are lanes.
    pub fn of_lanes<'a>(bending: impl Fn(usize) -> &'a Bending<T::Lane, B>) -> Self
    where
        T::Lane: 'a,
    {
        let join = |of: fn(&Bending<T::Lane, B>) -> &[T::Lane; B]| {
            core::array::from_fn(|i| T::join(|lane| of(bending(lane))[i]))
        };
        Bending {
            lever: T::join(|lane| bending(lane).lever),
            stiffness: join(|b| &b.stiffness),
            stiffness_by_depth: join(|b| &b.stiffness_by_depth),
            damping: join(|b| &b.damping),
        }
    }
}

/// How far the zones of a step are from the onset of touch and from the clamp, and how strongly they bend.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ease<T> {
    /// Smallest distance of a Gauss point from the onset, m; negative where one is touched and one is not.
    clear: T,
    /// Smallest rate, m/s, by which a touched felt would have to open faster before it pushes no more.
    pace: T,
    /// Largest rate, m/s, and largest compression, m.
    speed: T,
    depth: T,
}

impl<T: Real> Ease<T> {
    pub fn new() -> Self {
        let far = T::from_f64(FAR);
        Ease { clear: far, pace: far, speed: T::ZERO, depth: T::ZERO }
    }

    /// Takes a zone in. Returns its largest compression during the step, m; not positive where it is not touched.
    #[inline(always)]
    pub fn take_in(&mut self, gap: T, rate: T, timing: &Timing<T>) -> T {
        let speed = rate.abs();
        let offset = timing.node * speed;
        let deepest = gap.add_product(timing.node, speed);
        self.clear = self.clear.min(gap.abs() - offset);
        self.speed = self.speed.max(speed);
        self.depth = self.depth.max(deepest);
        deepest
    }

    /// Takes in the pace of a felt, where it is touched.
    #[inline(always)]
    pub fn keep_pace(&mut self, pace: T, touched: T::Mask) {
        self.pace = self.pace.min(T::select(touched, pace, T::from_f64(FAR)));
    }

    /// Adds to each joint's impulse, N m s, what the linearisation may leave out where no joint's velocity has changed by more than
    /// `change`. Returns where that can be said.
    #[inline(always)]
    pub fn add_bound<const B: usize>(
        &self,
        bending: &Bending<T, B>,
        timing: &Timing<T>,
        change: T,
        impulse: &mut [T; B],
    ) -> T::Mask {
        let two = T::from_f64(2.0);
        let (reach, x) = (timing.h_theta + timing.node, timing.theta * change);
        let square = timing.step * reach * x * x;
        let (by_stiffness, by_damping) = (reach * square, square * (reach * self.speed + two * self.depth));
        let by_depth = by_stiffness * self.depth;
        for i in 0..B {
            impulse[i] = impulse[i]
                .add_product(by_stiffness, bending.stiffness[i])
                .add_product(by_depth, bending.stiffness_by_depth[i])
                .add_product(by_damping, bending.damping[i]);
        }
        // Half the distance and half the pace: a felt with r of up to 3 that is half as deep has at least half its pace.
        let rate = two * x * bending.lever;
        (reach * rate).lt(self.clear).and(rate.lt(self.pace))
    }
}
