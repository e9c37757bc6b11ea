//! A quick bound of what a step's linearisation leaves out: most steps are settled by it, at a few operations per zone.
//!
//! A felt's force F(g, dg/dt) leaves its linearisation for two reasons: it bends, which is of second order in the change of the
//! velocities, or it meets the onset of touch or the clamp at zero. The bend is bounded with the longest levers that the rows can have
//! and with the felts' coefficients; both are numbers of the model. How far the onset and the clamp are is gathered zone by zone.

use crate::batch::{join, join_all};
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
    pub fn of_lanes<'a, S: Scalar + 'a>(bending: impl Fn(usize) -> &'a Bending<S, B>) -> Self {
        let numbers = |of: fn(&Bending<S, B>) -> [S; B]| join_all(|lane| of(bending(lane)));
        Bending {
            lever: join(|lane| bending(lane).lever),
            stiffness: numbers(|b| b.stiffness),
            stiffness_by_depth: numbers(|b| b.stiffness_by_depth),
            damping: numbers(|b| b.damping),
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

    /// What the linearisation may leave out where no joint's velocity has changed by more than `change`; and where that can be said.
    #[inline(always)]
    pub fn bound<const B: usize>(&self, bending: &Bending<T, B>, timing: &Timing<T>, change: T) -> (Terms<T>, T::Mask) {
        let two = T::from_f64(2.0);
        let (reach, x) = (timing.h_theta + timing.node, timing.theta * change);
        let square = timing.step * reach * x * x;
        let stiffness = reach * square;
        let rate = x * bending.lever;
        let gained = rate * reach;
        // The bend is largest where the change presses the felt deepest.
        let depth = self.depth + gained;
        let damping = square * (reach * self.speed + two * depth);
        // Half the distance and half the pace: a felt with r of up to 3 that is half as deep has at least half its pace.
        let sure = (two * gained).lt(self.clear).and((two * rate).lt(self.pace));
        (Terms { stiffness, stiffness_by_depth: stiffness * depth, damping }, sure)
    }
}

/// Factors of the three sums of [`Bending`].
pub(crate) struct Terms<T> {
    stiffness: T,
    stiffness_by_depth: T,
    damping: T,
}

impl<T: Real> Terms<T> {
    /// Adds what the felts may do to joint i to an impulse on it, N m s.
    #[inline(always)]
    pub fn add_to<const B: usize>(&self, impulse: T, bending: &Bending<T, B>, i: usize) -> T {
        impulse
            .add_product(self.stiffness, bending.stiffness[i])
            .add_product(self.stiffness_by_depth, bending.stiffness_by_depth[i])
            .add_product(self.damping, bending.damping[i])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::Touch;
    use crate::model::{Body, Curve, Felt, GROUND, Model, Zone};
    use crate::pose::Pose;

    /// Where the quick bound says that it holds, no joint may see more of what the felts' forces, worked out again after the change, are
    /// away from their linearisation: on a chain of two bodies between felts of every exponent, from apart to pressed by millimetres,
    /// from rest to faster than any hammer, for changes of any size. It must also hold often, or it would be of no use.
    #[test]
    fn the_quick_bound_is_one() {
        let body = |parent, pivot| Body { parent, pivot, mass: 1.0, ..Body::inert() };
        let bodies = [body(GROUND, [0.0, 0.0]), body(0, [0.2, 0.0])];
        let zone = |disc_body, y, exponent, damping| Zone {
            disc_body,
            center: [0.1, 0.0],
            radius: 0.01,
            curve_body: GROUND,
            curve: Curve::Line { point: [0.0, y], normal: [0.0, 1.0] },
            felt: Felt { stiffness: 3e6, exponent, damping },
            friction: None,
        };
        let zones = [
            // Strongly damped, so that it soon pushes no more.
            zone(0, -0.008, Exponent::Two, 5e7),
            zone(1, -0.011, Exponent::TwoAndHalf, 2e6),
            zone(0, -0.009, Exponent::Three, 2e6),
            Zone { curve: Curve::Disc { center: [0.31, -0.015], radius: 0.005 }, ..zone(1, 0.0, Exponent::Two, 2e6) },
        ];
        let model = Model::<f64, 2, 4>::new(&bodies, &[], &zones, None, 0.0).unwrap();
        let timing = Timing::new(50e-6, 0.5);
        let mut seed = 1_u32;
        let mut random = || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(seed) / f64::from(u32::MAX) - 0.5
        };
        let (mut held, mut tight) = (0, 0.0_f64);
        for _ in 0..20_000 {
            let pose = Pose::of(&model, &[0.05 * random(), 0.05 * random()]);
            let speed = libm::exp(20.0 * random());
            let (w, size) = ([speed * random(), speed * random()], libm::exp(30.0 * random() - 5.0));
            let change = [size * random(), size * random()];
            let (mut ease, mut exact) = (Ease::new(), [0.0; 2]);
            for (z, form) in model.forms.iter().enumerate() {
                let (mut touch, path) = (Touch::apart(), &model.paths[z]);
                let look = touch.evaluate::<2>(form, path, &pose, &w, &timing, true, &mut ease);
                if look.touched {
                    touch.press(form, &timing, true, &mut ease);
                }
                let after = touch.contact(form, path, &pose, &change, &timing, true).force;
                let linear = touch.force + touch.tangent / timing.step * path.product(&touch.row, &change);
                let p = timing.step * (after - if look.touched { linear } else { 0.0 }).abs();
                for (k, j) in path.joints() {
                    exact[j] += p * touch.row[k].abs();
                }
            }
            let largest = change[0].abs().max(change[1].abs());
            let (terms, sure) = ease.bound(&model.bending, &timing, largest);
            if sure {
                held += 1;
                for j in 0..2 {
                    let bound = terms.add_to(0.0, &model.bending, j);
                    // Forces of up to 1e4 N are rounded.
                    assert!(exact[j] <= bound * (1.0 + 1e-9) + 1e-16, "joint {j}: {exact:?} {bound}");
                    tight = tight.max(exact[j] / bound);
                }
            }
        }
        assert!(held > 2_000 && tight > 0.1, "{held} {tight}");
    }

    /// One felt on a lever as long as a row can have it, and at theta = 1 both Gauss points at one place: the bound has little to spare,
    /// and must hold all the same.
    #[test]
    fn the_quick_bound_holds_where_the_lever_is_the_longest() {
        let exponents = [Exponent::Two, Exponent::TwoAndHalf, Exponent::Three];
        let felts = exponents.map(|e| [(e, 0.0), (e, 2e3)]).concat();
        for ((exponent, damping), theta) in felts.into_iter().flat_map(|felt| [(felt, 0.5), (felt, 1.0)]) {
            let timing = Timing::new(50e-6, theta);
            let reach = timing.h_theta + timing.node;
            let zone = Zone {
                disc_body: 0,
                center: [0.1, 0.0],
                radius: 0.01,
                curve_body: GROUND,
                curve: Curve::Line { point: [0.0, -0.009], normal: [0.0, 1.0] },
                felt: Felt { stiffness: 3e6, exponent, damping },
                friction: None,
            };
            let body = Body { parent: GROUND, pivot: [0.0, 0.0], mass: 1.0, ..Body::inert() };
            let model = Model::<f64, 1, 1>::new(&[body], &[], &[zone], None, 0.0).unwrap();
            let (pose, path, form) = (Pose::of(&model, &[0.0]), &model.paths[0], &model.forms[0]);
            let (mut touch, mut ease) = (Touch::apart(), Ease::new());
            let look = touch.evaluate::<1>(form, path, &pose, &[0.0], &timing, true, &mut ease);
            touch.press(form, &timing, look.touched, &mut ease);
            assert!((touch.row[0].abs() - path.lever(0)).abs() < 1e-15 && look.gap > 0.9e-3);
            let mut tight = 0.0_f64;
            // Up to half of what would leave the felt: farther the bound does not speak.
            for share in [1e-4, 1e-2, 0.1, 0.4, 0.499] {
                let change = -touch.row[0].signum() * share * look.gap / (timing.theta * reach * path.lever(0));
                for change in [change, -change] {
                    let (terms, sure) = ease.bound(&model.bending, &timing, change.abs());
                    let after = touch.contact(form, path, &pose, &[change], &timing, true).force;
                    let linear = touch.force + touch.tangent / timing.step * path.product(&touch.row, &[change]);
                    let exact = timing.step * (after - linear).abs() * path.lever(0);
                    let bound = terms.add_to(0.0, &model.bending, 0);
                    let right = !sure || exact <= bound * (1.0 + 1e-9);
                    assert!(right, "{exponent:?} {damping} {theta} {change}: {exact} {bound}");
                    tight = tight.max(if sure { exact / bound } else { 0.0 });
                }
            }
            assert!(tight > 0.3, "{exponent:?} {damping} {theta}: {tight}");
        }
    }
}
