//! Contact zones: geometry of a disc against a curve, and the felt between them.

use crate::ease::Ease;
use crate::form::Form;
use crate::model::{Exponent, Felt};
use crate::path::Path;
use crate::pose::Pose;
use crate::vector::Vector;
use crate::{Mask, Real};

/// m/s; a zone so far apart that it would need a greater speed to touch within the step is not looked at further. Where one is
/// faster still, its first touch counts from the theta point on; 20 is three times the fastest hammer.
const CLOSING_SPEED: f64 = 20.0;
/// 1/sqrt(3): the two-point Gauss nodes on [-1, 1].
const GAUSS_POINT: f64 = 0.577_350_269_189_625_8;

/// The step's lengths of time that a zone needs, s, and how near it must be to be looked at.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Timing<T> {
    /// h.
    pub step: T,
    /// theta h: from the step's start to the theta point.
    pub h_theta: T,
    pub theta: T,
    /// From the theta point to a Gauss point.
    pub node: T,
    /// Compression that can be gained within the step, m.
    pub reach: T,
}

impl<T: Real> Timing<T> {
    pub fn new(h: T, theta: T) -> Self {
        let node = (T::ONE - theta) * h * T::from_f64(GAUSS_POINT);
        Timing { step: h, h_theta: h * theta, theta, node, reach: node * T::from_f64(CLOSING_SPEED) }
    }
}

/// A zone as it acted during one step, for whoever reads it.
#[derive(Debug, Clone, Copy)]
pub struct Contact<T> {
    /// Compression g at the theta point, m; negative apart.
    pub gap: T,
    /// dg/dt, m/s.
    pub rate: T,
    /// Unit normal out of the curve, toward the disc, in the world.
    pub normal: Vector<T>,
    /// Point of the curve under the disc's centre, in the world.
    pub point: Vector<T>,
    /// Normal force F, N, never negative; pushes the disc along `normal`.
    pub force: T,
    /// The part of `force` due to damping, b g^2 dg/dt (or what the clamp left of it), N.
    pub damping_force: T,
}

/// What the step keeps of a zone that it has looked at; the rest is worked out again for whoever asks.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Touch<T: Real, const B: usize> {
    /// Near enough to be touched during the step.
    pub in_reach: T::Mask,
    /// Normal force F, N, never negative.
    pub force: T,
    /// h dF/dv1 along the row (the linearised felt), never negative.
    pub tangent: T,
    /// Compression at the theta point, m, and dg/dt, m/s: what the felt's bend is worked out from, where it is asked for.
    gap: T,
    rate: T,
    /// Row G in relative velocities, for the joints of the zone's path: dg/dt = G w.
    pub row: [T; B],
}

/// What a look at a zone finds out beside.
pub(crate) struct Look<T: Real> {
    /// Where it is touched during the step.
    pub touched: T::Mask,
    pub gap: T,
    pub normal: Vector<T>,
}

impl<T: Real, const B: usize> Touch<T, B> {
    pub fn apart() -> Self {
        let z = T::ZERO;
        Touch { in_reach: T::Mask::splat(false), force: z, tangent: z, gap: z, rate: z, row: [z; B] }
    }

    /// Evaluates geometry at the theta point, and where the felt is touched during the step; the row has K entries. `candidates`: the
    /// lanes that may be in reach.
    #[inline(always)]
    #[allow(clippy::too_many_arguments)]
    pub fn evaluate<const K: usize>(
        &mut self,
        form: &Form<T>,
        path: &Path<T, B>,
        pose: &Pose<T, B>,
        w: &[T; B],
        timing: &Timing<T>,
        candidates: T::Mask,
        ease: &mut Ease<T>,
    ) -> Look<T> {
        let center = form.center(pose);
        let (gap, normal) = form.gap_and_normal(pose, center);
        let in_reach = candidates.and((-timing.reach).le(gap));
        self.in_reach = in_reach;
        let mut row = path.entries::<K>(&self.row);
        if !in_reach.any() {
            return Look { touched: in_reach, gap, normal };
        }
        for k in 0..K {
            row.entry[k] = path.sign(k) * pose.turning(row.joint[k], center, normal);
            self.row[k] = row.entry[k];
        }
        let rate = row.product(w);
        (self.gap, self.rate) = (gap, rate);
        let touched = in_reach.and(T::ZERO.lt(ease.take_in(gap, rate, timing)));
        Look { touched, gap, normal }
    }

    /// The felt, where it is touched.
    ///
    /// Its force is its mean along the step's straight path in g, by two-point Gauss quadrature. For r = 2 and 3 that is exact, so
    /// that compressing and releasing a felt conserves energy whatever the step; taken at one point instead, the string's felt
    /// alone would leave 2e-3 of the work in the ledger's residual at 50 us. At theta = 1 the path shrinks to the step's end, and the
    /// scheme is backward Euler.
    #[inline(always)]
    pub fn press(&mut self, form: &Form<T>, timing: &Timing<T>, touched: T::Mask, ease: &mut Ease<T>) {
        let pressed = press(form, self.gap, self.rate, timing, touched);
        ease.keep_pace(pressed.pace, touched);
        self.force = pressed.force;
        self.tangent = pressed.tangent;
    }

    /// What a caller may read, at the pose of the last evaluation, given the last change of the relative velocities, with which the force
    /// goes along.
    pub fn contact(
        &self,
        form: &Form<T>,
        path: &Path<T, B>,
        pose: &Pose<T, B>,
        change: &[T; B],
        timing: &Timing<T>,
        touched: T::Mask,
    ) -> Contact<T> {
        let (gap, normal) = form.gap_and_normal(pose, form.center(pose));
        let ahead = timing.theta * path.product(&self.row, change);
        let (rate, ahead_gap) = (self.rate + ahead, gap + timing.h_theta * ahead);
        let pressed = press(form, ahead_gap, rate, timing, touched);
        Contact {
            gap: ahead_gap,
            rate,
            normal,
            point: form.contact_point(pose, gap, normal),
            force: pressed.force,
            damping_force: pressed.damping_force,
        }
    }

    /// How far the force may be from its linearisation after the relative velocities have changed by `change`, N: what one
    /// Newton iteration leaves to the next.
    #[inline(always)]
    pub fn remainder(
        &self,
        form: &Form<T>,
        path: &Path<T, B>,
        change: &[T; B],
        timing: &Timing<T>,
        active: T::Mask,
    ) -> T {
        let rate = (timing.theta * path.product(&self.row, change)).abs();
        // To second order; where the clamp at zero may have come or gone, to first.
        let bend = press(form, self.gap, self.rate, timing, active).bend;
        let (linear, quadratic) = (bend.linear * rate, bend.quadratic * rate * rate);
        let bent = T::select(linear.lt(bend.slack), quadratic, linear.max(quadratic));
        if active.all() {
            return bent;
        }
        // Not touched before: all of it.
        let reach = timing.h_theta + timing.node;
        let deepest = (self.gap + timing.node * self.rate.abs() + reach * rate).max(T::ZERO);
        let (elastic, _, _) = form.felt.elastic(deepest);
        let onset = elastic + form.felt.damping * deepest * deepest * (self.rate.abs() + rate);
        T::select(active, bent, T::only(self.in_reach, onset))
    }

    /// The row that maps relative velocities to the slip u = t . (v_disc - v_curve) at the contact point, in some lanes; t is
    /// the normal turned clockwise by a quarter turn.
    #[inline(always)]
    pub fn slip_row(
        look: &Look<T>,
        form: &Form<T>,
        path: &Path<T, B>,
        pose: &Pose<T, B>,
        lanes: T::Mask,
        row: &mut [T; B],
    ) {
        let (before, point) = (*row, form.contact_point(pose, look.gap, look.normal));
        pose.turning_row(path, point, [-look.normal[1], look.normal[0]], row);
        if !lanes.all() {
            for (k, _) in path.joints() {
                row[k] = T::select(lanes, row[k], before[k]);
            }
        }
    }
}

/// The felt's mean force over the step and its tangent, at a compression and rate.
#[inline(always)]
fn press<T: Real>(form: &Form<T>, gap: T, rate: T, timing: &Timing<T>, active: T::Mask) -> Pressed<T> {
    let felt = &form.felt;
    if !form.is_square() {
        return press_points(felt, gap, rate, timing, active);
    }
    let whole = press_square(form, gap, rate, timing, active);
    let partly = active.and(gap.le((timing.node * rate).abs()));
    if partly.any() {
        // Each lane by the formula that it would take alone.
        whole.or(partly, press_points(felt, gap, rate, timing, active))
    } else {
        whole
    }
}

/// What a felt does during a step.
#[derive(Debug, Clone, Copy)]
struct Pressed<T> {
    force: T,
    damping_force: T,
    tangent: T,
    bend: Bend<T>,
    /// See [`Ease`].
    pace: T,
}

impl<T: Real> Pressed<T> {
    /// The other in some lanes.
    #[inline(always)]
    fn or(self, lanes: T::Mask, other: Self) -> Self {
        let choose = |a: T, b: T| T::select(lanes, b, a);
        Pressed {
            force: choose(self.force, other.force),
            damping_force: choose(self.damping_force, other.damping_force),
            tangent: choose(self.tangent, other.tangent),
            bend: Bend {
                linear: choose(self.bend.linear, other.bend.linear),
                quadratic: choose(self.bend.quadratic, other.bend.quadratic),
                slack: choose(self.bend.slack, other.bend.slack),
            },
            pace: choose(self.pace, other.pace),
        }
    }
}

/// The mean force over a step of a felt with r = 2, both Gauss points touched: F = (k + b dg/dt) g^2, whose mean over the path is
/// (k + b dg/dt) (g^2 + o^2), o being the points' distance from the middle.
#[inline(always)]
fn press_square<T: Real>(form: &Form<T>, gap: T, rate: T, timing: &Timing<T>, active: T::Mask) -> Pressed<T> {
    let (felt, h_theta, node) = (&form.felt, timing.h_theta, timing.node);
    let (offset, reach) = (node * rate, h_theta + node);
    let (deepest, shallowest) = (gap + offset.abs(), gap - offset.abs());
    let bv = felt.damping * rate;
    let (factor, square) = (felt.stiffness + bv, (gap * gap).add_product(offset, offset));
    // One factor for both points: the clamp takes both or none.
    let pushing = active.and(T::ZERO.lt(factor));
    let only_pushing = |x: T| T::only(pushing, x);
    let twice = factor + factor;
    let tangent = h_theta * (felt.damping * square).add_product(twice, (h_theta * gap).add_product(node, offset));
    Pressed {
        force: only_pushing(factor * square),
        // What the clamp leaves of the damping undoes the stiffness.
        damping_force: T::select(pushing, bv, -felt.stiffness) * square,
        tangent: only_pushing(tangent.max(T::ZERO)),
        bend: Bend {
            linear: deepest * (reach * twice.abs() + felt.damping * deepest),
            quadratic: reach * (reach * (felt.stiffness + bv.abs()) + T::from_f64(2.0) * felt.damping * deepest),
            slack: only_pushing(factor * shallowest * shallowest),
        },
        pace: form.stiffness_over_damping + rate,
    }
}

/// The same for any exponent and any path, point by point.
#[inline(always)]
fn press_points<T: Real>(felt: &Felt<T>, gap: T, rate: T, timing: &Timing<T>, active: T::Mask) -> Pressed<T> {
    let (half, two) = (T::from_f64(0.5), T::from_f64(2.0));
    let offset = timing.node * rate;
    let deepest = gap + offset.abs();
    let (first, second) = ((gap + offset).max(T::ZERO), (gap - offset).max(T::ZERO));
    let ((ea, sa, ca), (eb, sb, cb)) = (felt.elastic(first), felt.elastic(second));
    let a = felt.law([ea, sa], first, rate).clamped(first);
    let b = felt.law([eb, sb], second, rate).clamped(second);
    let only_active = |x: T| T::only(active, x);
    let (h_theta, node) = (timing.h_theta, timing.node);
    let slope = ((h_theta + node) * a.stiffness).add_product(h_theta - node, b.stiffness);
    // The gap's change by a change of the rate.
    let reach = h_theta + node;
    let bend = half * ca.max(cb) + felt.damping * rate.abs();
    Pressed {
        force: only_active(half * (a.force + b.force)),
        damping_force: half * (a.damping_force + b.damping_force),
        tangent: only_active((half * h_theta * (a.damping + b.damping + slope)).max(T::ZERO)),
        bend: Bend {
            linear: reach * a.stiffness.abs().max(b.stiffness.abs()) + a.damping.max(b.damping),
            quadratic: reach * (reach * bend + two * felt.damping * deepest),
            slack: a.slack.min(b.slack),
        },
        // The least of the forces over the largest damping.
        pace: a.slack.min(b.slack) / (felt.damping * deepest * deepest).max(T::from_f64(1e-30)),
    }
}

/// How a zone's force bends away from its linearisation.
#[derive(Debug, Clone, Copy)]
struct Bend<T> {
    /// Largest change of the force with the rate, to first and (what is not in the linearisation) to second order.
    linear: T,
    quadratic: T,
    /// Smallest force of a touched Gauss point, N: how far the clamp at zero is.
    slack: T,
}

/// The felt law and its partial derivatives at one compression and rate.
#[derive(Debug, Clone, Copy)]
struct FeltState<T> {
    force: T,
    damping_force: T,
    stiffness: T,
    damping: T,
    /// Force before the clamp's kink; large where the felt is not touched, zero where it is clamped.
    slack: T,
}

impl<T: Real> FeltState<T> {
    /// Clamped at zero: felt never pulls.
    #[inline(always)]
    fn clamped(self, gap: T) -> Self {
        let pushing = T::ZERO.lt(self.force);
        let or_zero = |x: T| T::only(pushing, x);
        FeltState {
            force: or_zero(self.force),
            damping_force: T::select(pushing, self.damping_force, self.damping_force - self.force),
            stiffness: or_zero(self.stiffness),
            damping: or_zero(self.damping),
            slack: T::select(T::ZERO.lt(gap), or_zero(self.force), T::from_f64(1e30)),
        }
    }
}

impl<T: Real> Felt<T> {
    /// k g^r + b g^2 dg/dt and its derivatives, not clamped, given k g^r and its slope; `gap` must not be negative.
    #[inline(always)]
    fn law(&self, [elastic, slope]: [T; 2], gap: T, rate: T) -> FeltState<T> {
        let bg = self.damping * gap;
        let damping = bg * gap;
        let damping_force = damping * rate;
        let force = elastic + damping_force;
        let stiffness = slope.add_product(bg + bg, rate);
        FeltState { force, damping_force, stiffness, damping, slack: force }
    }

    /// k g^r and its first and second derivative in g; `gap` must not be negative.
    #[inline(always)]
    fn elastic(&self, gap: T) -> (T, T, T) {
        let c = T::from_f64;
        match self.exponent {
            Exponent::Two => {
                let kg = self.stiffness * gap;
                (kg * gap, c(2.0) * kg, c(2.0) * self.stiffness)
            }
            Exponent::TwoAndHalf => {
                let k_root = self.stiffness * gap.sqrt();
                let kg = k_root * gap;
                (kg * gap, c(2.5) * kg, c(3.75) * k_root)
            }
            Exponent::Three => {
                let k_gap = self.stiffness * gap;
                let kg = k_gap * gap;
                (kg * gap, c(3.0) * kg, c(6.0) * k_gap)
            }
            Exponent::Other(r) => {
                let kg = self.stiffness * gap.powf(r - T::ONE);
                // r < 2 bends without bound at first touch; a gap of a nanometre is no touch.
                (kg * gap, r * kg, r * (r - T::ONE) * kg / gap.max(c(1e-9)))
            }
        }
    }
}

/// Energy stored in the felt at compression g: k g^(r+1) / (r+1).
pub(crate) fn felt_energy<T: Real>(felt: &Felt<T>, gap: T) -> T {
    let r = match felt.exponent {
        Exponent::Two => T::from_f64(2.0),
        Exponent::TwoAndHalf => T::from_f64(2.5),
        Exponent::Three => T::from_f64(3.0),
        Exponent::Other(r) => r,
    };
    let g = gap.max(T::ZERO);
    felt.stiffness * g.powf(r + T::ONE) / (r + T::ONE)
}

/// Compression of a zone at a pose (negative apart), without forces.
#[inline(always)]
pub(crate) fn gap_of<T: Real, const B: usize>(form: &Form<T>, pose: &Pose<T, B>) -> T {
    form.gap_and_normal(pose, form.center(pose)).0
}

/// The row G of a zone at a pose in relative velocities, with an entry for every joint: dg/dt = G w, with
/// G = -n . (v_disc(c) - v_curve(c)), exact although the contact point moves.
pub(crate) fn gap_row_of<T: Real, const B: usize>(form: &Form<T>, path: &Path<T, B>, pose: &Pose<T, B>) -> [T; B] {
    let center = form.center(pose);
    let (_, normal) = form.gap_and_normal(pose, center);
    let mut row = [T::ZERO; B];
    pose.turning_row(path, center, normal, &mut row);
    let mut dense = [T::ZERO; B];
    path.spread(&row, T::ONE, &mut dense);
    dense
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Body, Curve, GROUND, Model, Zone};

    /// Rows against central differences of the gap, for every kind of curve, on a three-body chain: the claim is that
    /// dg/dt = G v is the exact derivative of g. Differences of step 1e-6 carry an error near 1e-9.
    #[test]
    fn rows_are_the_gradient_of_the_gap() {
        let body = |parent, pivot| Body { parent, pivot, mass: 1.0, ..Body::inert() };
        let bodies = [body(GROUND, [0.1, 0.2]), body(0, [0.5, -0.1]), body(1, [0.3, 0.2]), body(GROUND, [1.0, 1.0])];
        let felt = Felt { stiffness: 1.0, exponent: Exponent::Two, damping: 1.0 };
        let s = 0.5_f64.sqrt();
        let curves = [
            Curve::Line { point: [0.1, 0.3], normal: [s, s] },
            Curve::Segment { from: [0.0, 0.0], direction: [s, -s], length: 0.4, rounding: 0.05 },
            Curve::Disc { center: [0.2, 0.1], radius: 0.1 },
        ];
        for curve in curves {
            for (a, b) in [(2, 3), (3, 2), (2, 0), (0, 2), (GROUND, 2), (2, GROUND)] {
                let zone =
                    Zone { disc_body: a, center: [0.2, -0.3], radius: 5.0, curve_body: b, curve, felt, friction: None };
                let model = Model::<f64, 4, 1>::new(&bodies, &[], &[zone], None, 0.0).unwrap();
                let q = [0.3, -0.7, 1.9, 0.4];
                let gap = |q: &[f64; 4]| gap_of(&Form::of(&zone), &Pose::of(&model, q));
                let mut touch = Touch::apart();
                let timing = Timing::new(1e-3, 0.5);
                let (pose, path) = (Pose::of(&model, &q), &model.paths[0]);
                assert!(
                    touch
                        .evaluate::<4>(&Form::of(&zone), path, &pose, &[0.0; 4], &timing, true, &mut Ease::new())
                        .touched
                );
                let row = Pose::of(&model, &q).gap_row(&model, 0);
                for i in 0..4 {
                    let e = 1e-6;
                    let (mut up, mut down) = (q, q);
                    up[i] += e;
                    down[i] -= e;
                    let difference = (gap(&up) - gap(&down)) / (2.0 * e);
                    assert!((difference - row[i]).abs() < 1e-8, "{curve:?} {a} {b} {i}");
                }
            }
        }
    }

    /// The law's partial derivatives against differences, and the clamp: felt never pulls.
    #[test]
    fn felt_law_derivatives() {
        for exponent in [Exponent::Two, Exponent::TwoAndHalf, Exponent::Three, Exponent::Other(1.7)] {
            let felt = Felt { stiffness: 3e3, exponent, damping: 2e3 };
            let (g, v, e) = (0.02, -0.01, 1e-7);
            let law = |g: f64, v: f64| {
                let (elastic, slope, _) = felt.elastic(g);
                felt.law([elastic, slope], g, v).clamped(g)
            };
            let at = law(g, v);
            let dg = (law(g + e, v).force - law(g - e, v).force) / (2.0 * e);
            let dv = (law(g, v + e).force - law(g, v - e).force) / (2.0 * e);
            assert!((at.stiffness - dg).abs() < 1e-6 * dg.abs(), "{exponent:?}");
            assert!((at.damping - dv).abs() < 1e-6 * dv.abs(), "{exponent:?}");
            assert_eq!(law(g, -1e3).force, 0.0);
        }
    }
}
