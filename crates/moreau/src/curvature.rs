//! Quick test of a step's linearisation: a bound on its error, at a few operations per zone. It decides most steps.
//!
//! A felt's force F(g, dg/dt) deviates from its tangent for two reasons: it is curved (an effect of second order in the
//! change of the velocities), or it reaches a kink (the onset of touch, or the limit at zero force). The curvature is
//! bounded by the longest possible levers of the rows and by the felts' own bounds
//! ([`Felt::curvature_bound`](crate::Felt)); both are numbers of the model ([`Curvatures`]). The distances to the kinks
//! are collected zone by zone ([`Margins`]).

use crate::description::Zone;
use crate::felt::FAR;
use crate::real::{Mask, Real, Scalar, join, join_all};
use crate::support::Support;
use crate::timing::Timing;

/// Bound on how strongly all felts of a model together can curve the force on each joint.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Curvatures<T, const B: usize> {
    /// The largest |dg/dt| of any zone for joint velocities of at most 1, m.
    lever: T,
    /// Sums over the joint's zones of its lever times the square of |dg/dt| for joint velocities of at most 1, times
    /// the felt's [`CurvatureBound`](crate::felt::CurvatureBound).
    stiffness: [T; B],
    stiffness_by_depth: [T; B],
    damping: [T; B],
    /// The compression, m, up to which the bounds hold for all felts.
    deepest: T,
}

impl<T: Scalar, const B: usize> Curvatures<T, B> {
    pub(crate) fn of<'a>(zones: impl Iterator<Item = (&'a Zone<T>, &'a Support<T, B>)>) -> Self
    where
        T: 'a,
    {
        let o = [T::ZERO; B];
        let mut sums =
            Curvatures { lever: T::ZERO, stiffness: o, stiffness_by_depth: o, damping: o, deepest: T::from_f64(FAR) };
        for (zone, support) in zones {
            let mut lever = T::ZERO;
            for (k, _) in support.joints() {
                lever += support.lever(k);
            }
            sums.lever = sums.lever.max(lever);
            let felt = zone.felt.curvature_bound();
            sums.deepest = sums.deepest.min(felt.deepest);
            for (k, j) in support.joints() {
                let share = support.lever(k) * lever * lever;
                sums.stiffness[j] += share * felt.stiffness;
                sums.stiffness_by_depth[j] += share * felt.stiffness_by_depth;
                sums.damping[j] += share * felt.damping;
            }
        }
        sums
    }
}

impl<T: Real, const B: usize> Curvatures<T, B> {
    /// Of as many models as there are lanes.
    pub(crate) fn of_lanes<'a, S: Scalar + 'a>(one: impl Fn(usize) -> &'a Curvatures<S, B>) -> Self {
        let numbers = |of: fn(&Curvatures<S, B>) -> [S; B]| join_all(|lane| of(one(lane)));
        Curvatures {
            lever: join(|lane| one(lane).lever),
            stiffness: numbers(|b| b.stiffness),
            stiffness_by_depth: numbers(|b| b.stiffness_by_depth),
            damping: numbers(|b| b.damping),
            deepest: join(|lane| one(lane).deepest),
        }
    }
}

/// How far the zones of a step are from the onset of touch and from the clamp, and how fast and deep they are pressed.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Margins<T> {
    /// Smallest distance of a Gauss point from the onset, m; negative where one is touched and one is not.
    onset: T,
    /// Smallest rate, m/s, by which a touched felt would have to open faster before it pushes no more.
    opening: T,
    /// Largest rate, m/s, and largest compression, m.
    speed: T,
    depth: T,
}

impl<T: Real> Margins<T> {
    pub(crate) fn new() -> Self {
        let far = T::from_f64(FAR);
        Margins { onset: far, opening: far, speed: T::ZERO, depth: T::ZERO }
    }

    /// Takes a zone in. Returns its largest compression during the step, m; not positive where it is not touched.
    #[inline(always)]
    pub(crate) fn include(&mut self, compression: T, rate: T, timing: &Timing<T>) -> T {
        let speed = rate.abs();
        let offset = timing.node * speed;
        let deepest = compression.add_product(timing.node, speed);
        self.onset = self.onset.min(compression.abs() - offset);
        self.speed = self.speed.max(speed);
        self.depth = self.depth.max(deepest);
        deepest
    }

    /// Takes in the rate by which a felt would have to open faster, where it is touched.
    #[inline(always)]
    pub(crate) fn include_opening(&mut self, opening: T, touched: T::Mask) {
        self.opening = self.opening.min(T::select(touched, opening, T::from_f64(FAR)));
    }

    /// What the linearisation may leave out where no joint's velocity has changed by more than `change`, and where that
    /// bound holds.
    ///
    /// A zone's rate then changes by at most `rate` = lever theta change, and the compression at its Gauss points by at
    /// most `gained` = reach rate. Two conditions keep every felt on one side of its kinks:
    ///
    /// - no Gauss point reaches the onset: gained < distance. It is asked for twice that, so that no felt loses more
    ///   than half of its compression;
    /// - no felt comes to the clamp: it pushes no more when it opens faster than k g^(r - 2) / b. `rate` uses up one
    ///   half of the margin. The other half is for felts with r > 2, whose k g^(r - 2) / b falls with the compression
    ///   (by k gained / b for r = 3).
    #[inline(always)]
    pub(crate) fn bound<const B: usize>(
        &self,
        sums: &Curvatures<T, B>,
        timing: &Timing<T>,
        change: T,
    ) -> (Terms<T>, T::Mask) {
        let two = T::from_f64(2.0);
        let (reach, x) = (timing.h_theta + timing.node, timing.theta * change);
        let square = timing.step * reach * x * x;
        let stiffness = reach * square;
        let rate = x * sums.lever;
        let gained = rate * reach;
        // The bend is largest where the change presses the felt deepest.
        let depth = self.depth + gained;
        let damping = square * (reach * self.speed + two * depth);
        let holds = (two * gained).lt(self.onset).and((two * rate).lt(self.opening)).and(depth.le(sums.deepest));
        (Terms { stiffness, stiffness_by_depth: stiffness * depth, damping }, holds)
    }
}

/// Factors of the three sums of [`Curvatures`].
pub(crate) struct Terms<T> {
    stiffness: T,
    stiffness_by_depth: T,
    damping: T,
}

impl<T: Real> Terms<T> {
    /// Adds what the felts may do to joint i to an impulse on it, N m s.
    #[inline(always)]
    pub(crate) fn add_to<const B: usize>(&self, impulse: T, sums: &Curvatures<T, B>, i: usize) -> T {
        impulse
            .add_product(self.stiffness, sums.stiffness[i])
            .add_product(self.stiffness_by_depth, sums.stiffness_by_depth[i])
            .add_product(self.damping, sums.damping[i])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::ContactState;
    use crate::description::{Body, ContactCurve, Description, GROUND};
    use crate::felt::Felt;
    use crate::law::{Exponent, Loss};
    use crate::pose::Pose;
    use crate::surface::Yielding;

    /// Where the quick bound says that it holds, no joint may see more of what the felts' forces, worked out again
    /// after the change, are away from their linearisation: on a chain of two bodies between felts of every exponent,
    /// from apart to pressed by millimetres, from rest to faster than any hammer, for changes of any size. It must also
    /// hold often, or it would be of no use.
    #[test]
    fn the_quick_bound_is_one() {
        let body = |parent, pivot| Body { parent, pivot, mass: 1.0, ..Body::inert() };
        let bodies = [body(GROUND, [0.0, 0.0]), body(0, [0.2, 0.0])];
        let zone = |disc_body, y, exponent, loss| Zone {
            disc_body,
            center: [0.1, 0.0],
            radius: 0.01,
            curve_body: GROUND,
            curve: ContactCurve::Line { point: [0.0, y], normal: [0.0, 1.0] },
            felt: Felt { stiffness: 3e6, exponent, loss },
            friction: None,
        };
        let (quadratic, hunt_crossley) = (Loss::quadratic(2e6), Loss::hunt_crossley(0.7));
        let against_disc = |loss| Zone {
            curve: ContactCurve::Disc { center: [0.31, -0.015], radius: 0.005 },
            ..zone(1, 0.0, Exponent::Two, loss)
        };
        // The first is strongly damped, so that it soon pushes no more.
        let papers = [
            zone(0, -0.008, Exponent::Two, Loss::quadratic(5e7)),
            zone(1, -0.011, Exponent::TwoAndHalf, quadratic),
            zone(0, -0.009, Exponent::Three, quadratic),
            against_disc(quadratic),
        ];
        let hunt_and_crossley = [
            zone(0, -0.008, Exponent::Two, Loss::hunt_crossley(17.0)),
            zone(1, -0.0095, Exponent::TwoAndHalf, hunt_crossley),
            zone(0, -0.009, Exponent::Three, hunt_crossley),
            against_disc(hunt_crossley),
        ];
        // Hunt and Crossley's bound speaks of no felt that is pressed deeper than millimetres: swings are smaller.
        quick_bound(&bodies, papers, 0.05);
        quick_bound(&bodies, hunt_and_crossley, 0.01);
    }

    fn quick_bound(bodies: &[Body<f64>], zones: [Zone<f64>; 4], swing: f64) {
        let description = Description { bodies, zones: &zones, ..Description::default() };
        let model = description.compile::<2, 4>().unwrap();
        let timing = Timing::new(50e-6, 0.5);
        let mut seed = 1_u32;
        let mut random = || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(seed) / f64::from(u32::MAX) - 0.5
        };
        let (mut held, mut tight) = (0, 0.0_f64);
        for _ in 0..20_000 {
            let pose = Pose::of(&model, &[swing * random(), swing * random()]);
            let speed = libm::exp(20.0 * random());
            let (w, size) = ([speed * random(), speed * random()], libm::exp(30.0 * random() - 5.0));
            let change = [size * random(), size * random()];
            let (mut margins, mut exact) = (Margins::new(), [0.0; 2]);
            for (z, zone) in model.compiled.iter().enumerate() {
                let (mut contact, support) = (ContactState::apart(), &model.supports[z]);
                let touched = contact
                    .evaluate::<2, false>(zone, support, &pose, &w, &timing, true, &Yielding::still(), &mut margins)
                    .touched;
                if touched {
                    contact.press(zone, &timing, true, &Yielding::still(), &mut margins);
                }
                let after = contact.contact(zone, support, &pose, &change, &timing, true, &Yielding::still()).force;
                let linear = contact.force + contact.tangent / timing.step * support.product(&contact.row, &change);
                let p = timing.step * (after - if touched { linear } else { 0.0 }).abs();
                for (k, j) in support.joints() {
                    exact[j] += p * contact.row[k].abs();
                }
            }
            let largest = change[0].abs().max(change[1].abs());
            let (terms, sure) = margins.bound(&model.curvatures, &timing, largest);
            if sure {
                held += 1;
                for j in 0..2 {
                    let bound = terms.add_to(0.0, &model.curvatures, j);
                    // Forces of up to 1e4 N are rounded.
                    assert!(exact[j] <= bound * (1.0 + 1e-9) + 1e-16, "joint {j}: {exact:?} {bound}");
                    tight = tight.max(exact[j] / bound);
                }
            }
        }
        assert!(held > 2_000 && tight > 0.1, "{held} {tight}");
    }

    /// One felt on a lever as long as a row can have it, and at theta = 1 both Gauss points at one place: the bound has
    /// little to spare, and must hold all the same.
    #[test]
    fn the_quick_bound_holds_where_the_lever_is_the_longest() {
        let exponents = [Exponent::Two, Exponent::TwoAndHalf, Exponent::Three];
        let losses = [Loss::quadratic(0.0), Loss::quadratic(2e3), Loss::hunt_crossley(0.7)];
        let felts = exponents.into_iter().flat_map(|exponent| losses.map(|loss| (exponent, loss)));
        for ((exponent, loss), theta) in felts.flat_map(|felt| [(felt, 0.5), (felt, 1.0)]) {
            let timing = Timing::new(50e-6, theta);
            let reach = timing.h_theta + timing.node;
            let zone = Zone {
                disc_body: 0,
                center: [0.1, 0.0],
                radius: 0.01,
                curve_body: GROUND,
                curve: ContactCurve::Line { point: [0.0, -0.009], normal: [0.0, 1.0] },
                felt: Felt { stiffness: 3e6, exponent, loss },
                friction: None,
            };
            let body = Body { parent: GROUND, pivot: [0.0, 0.0], mass: 1.0, ..Body::inert() };
            let description = Description { bodies: &[body], zones: &[zone], ..Description::default() };
            let model = description.compile::<1, 1>().unwrap();
            let (pose, support, zone) = (Pose::of(&model, &[0.0]), &model.supports[0], &model.compiled[0]);
            let (mut contact, mut margins) = (ContactState::<f64, 1>::apart(), Margins::new());
            let near = contact.evaluate::<1, false>(
                zone,
                support,
                &pose,
                &[0.0],
                &timing,
                true,
                &Yielding::still(),
                &mut margins,
            );
            contact.press(zone, &timing, near.touched, &Yielding::still(), &mut margins);
            assert!((contact.row[0].abs() - support.lever(0)).abs() < 1e-15 && near.compression > 0.9e-3);
            let mut tight = 0.0_f64;
            // Up to half of what would leave the felt: the bound says nothing of more.
            for share in [1e-4, 1e-2, 0.1, 0.4, 0.499] {
                let change =
                    -contact.row[0].signum() * share * near.compression / (timing.theta * reach * support.lever(0));
                for change in [change, -change] {
                    let (terms, sure) = margins.bound(&model.curvatures, &timing, change.abs());
                    let after =
                        contact.contact(zone, support, &pose, &[change], &timing, true, &Yielding::still()).force;
                    let linear =
                        contact.force + contact.tangent / timing.step * support.product(&contact.row, &[change]);
                    let exact = timing.step * (after - linear).abs() * support.lever(0);
                    let bound = terms.add_to(0.0, &model.curvatures, 0);
                    let right = !sure || exact <= bound * (1.0 + 1e-9);
                    assert!(right, "{exponent:?} {loss:?} {theta} {change}: {exact} {bound}");
                    tight = tight.max(if sure { exact / bound } else { 0.0 });
                }
            }
            // Hunt and Crossley's loss is bounded as at 3 mm, three times as deep as here.
            let spared = if matches!(loss, Loss::HuntCrossley(_)) { 0.1 } else { 0.3 };
            assert!(tight > spared, "{exponent:?} {loss:?} {theta}: {tight}");
        }
    }
}
