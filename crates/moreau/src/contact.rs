//! Contact zones: geometry of a disc against a curve, and the felt between them.

use crate::linear::product;
use crate::model::{Curve, Exponent, Felt, Zone};
use crate::pose::Pose;
use crate::vector::{Vector, add, dot, scale, sub};
use crate::{Mask, Real};

/// m/s; a zone so far apart that it would need a greater speed to touch within the step is not looked at further. Where one is
/// faster still, its first touch counts from the theta point on; 20 is three times the fastest hammer.
const CLOSING_SPEED: f64 = 20.0;
/// 1/sqrt(3): the two-point Gauss nodes on [-1, 1].
const GAUSS_POINT: f64 = 0.577_350_269_189_625_8;

/// A zone during one step.
#[derive(Debug, Clone, Copy)]
pub struct Contact<T, const B: usize> {
    /// Whether the felt is touched; the other fields (but `gap` and `force`) hold only then.
    pub active: bool,
    /// Too far apart to be touched during the step.
    pub(crate) out_of_reach: bool,
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
    /// h dF/dv1 along the row (the linearised felt), never negative.
    pub(crate) tangent: T,
    /// Change of the rate by the last Newton correction.
    ahead: T,
    /// What [`Contact::remainder`] needs of the felt.
    bend: Bend<T>,
    /// Row G in relative velocities: dg/dt = G w.
    pub(crate) row: [T; B],
}

impl<T: Real, const B: usize> Contact<T, B> {
    pub(crate) fn apart() -> Self {
        let (z, o) = (T::ZERO, [T::ZERO; 2]);
        Contact {
            active: false,
            out_of_reach: false,
            gap: z,
            rate: z,
            normal: o,
            point: o,
            force: z,
            damping_force: z,
            tangent: z,
            ahead: z,
            bend: Bend { deepest: z, slope: z, damping: z, slack: z },
            row: [z; B],
        }
    }

    /// Evaluates geometry at the theta point, and the felt where it is touched during the step.
    ///
    /// The felt's force is its mean along the step's straight path in g, by two-point Gauss quadrature. For r = 2 and 3 that is
    /// exact, so that compressing and releasing a felt conserves energy whatever the step; taken at one point instead, the
    /// string's felt alone would leave 2e-3 of the work in the ledger's residual at 50 us. At theta = 1 the path shrinks to the
    /// step's end, and the scheme is backward Euler.
    #[inline(always)]
    pub(crate) fn evaluate(&mut self, zone: &Zone<T>, carried: &[T; B], pose: &Pose<T, B>, w: &[T; B], h: T, theta: T) {
        let center = pose.point(zone.disc_body, zone.center);
        let (distance, normal) = distance_to_curve(zone, pose, center);
        self.gap = zone.radius - distance;
        self.active = false;
        self.force = T::ZERO;
        let reach = (T::ONE - theta) * h * T::from_f64(GAUSS_POINT);
        if !(-reach * T::from_f64(CLOSING_SPEED)).le(self.gap).any() {
            self.out_of_reach = true;
            return;
        }
        self.out_of_reach = false;
        self.row = pose.turning_row(carried, center, normal);
        self.rate = product(&self.row, w);
        let offset = reach * self.rate;
        self.bend.deepest = self.gap + offset.abs();
        if !T::ZERO.lt(self.bend.deepest).any() {
            return;
        }
        self.active = true;
        self.normal = normal;
        self.point = sub(center, scale(normal, distance));
        self.press(zone, offset, reach, h * theta);
    }

    /// The felt's mean force over the step and its tangent, at the present compression and rate.
    #[inline(always)]
    fn press(&mut self, zone: &Zone<T>, offset: T, reach: T, h_theta: T) {
        let half = T::from_f64(0.5);
        let a = felt_law(&zone.felt, (self.gap + offset).max(T::ZERO), self.rate);
        let b = felt_law(&zone.felt, (self.gap - offset).max(T::ZERO), self.rate);
        self.force = half * (a.force + b.force);
        self.damping_force = half * (a.damping_force + b.damping_force);
        let slope = (h_theta + reach) * a.stiffness + (h_theta - reach) * b.stiffness;
        self.tangent = (half * h_theta * (a.damping + b.damping + slope)).max(T::ZERO);
        self.bend.slope = a.stiffness.abs().max(b.stiffness.abs());
        self.bend.damping = a.damping.max(b.damping);
        self.bend.slack = a.slack.min(b.slack);
    }

    /// Follows the change of the relative velocities that [`Contact::remainder`] has seen, without looking at the geometry again.
    #[inline(always)]
    pub(crate) fn follow(&mut self, zone: &Zone<T>, h: T, theta: T) {
        if !self.active {
            return;
        }
        self.rate += self.ahead;
        self.gap += theta * h * self.ahead;
        let reach = (T::ONE - theta) * h * T::from_f64(GAUSS_POINT);
        self.press(zone, reach * self.rate, reach, h * theta);
    }

    /// How far the force may be from its linearisation after the relative velocities have changed by `change`, N: what one
    /// Newton iteration leaves to the next.
    #[inline(always)]
    pub(crate) fn remainder(&mut self, zone: &Zone<T>, change: &[T; B], h: T, theta: T) -> T {
        if self.out_of_reach {
            return T::ZERO;
        }
        self.ahead = theta * product(&self.row, change);
        let rate = self.ahead.abs();
        let gap = (theta * h + (T::ONE - theta) * h * T::from_f64(GAUSS_POINT)) * rate;
        let deepest = self.bend.deepest + gap;
        if !T::ZERO.lt(deepest).any() {
            return T::ZERO;
        }
        let half = T::from_f64(0.5);
        let (elastic, _, curvature) = zone.felt.elastic(deepest.max(T::ZERO));
        let damping = zone.felt.damping * deepest * deepest;
        if !self.active {
            return elastic + damping * (self.rate.abs() + rate);
        }
        // To second order; where the clamp at zero may have come or gone, to first.
        let second = half * (curvature + T::from_f64(2.0) * zone.felt.damping * self.rate.abs()) * gap * gap
            + T::from_f64(2.0) * zone.felt.damping * deepest * gap * rate;
        let first = self.bend.slope * gap + self.bend.damping * rate;
        T::select(first.lt(self.bend.slack), second, first.max(second))
    }

    /// The row that maps relative velocities to the slip u = t . (v_disc - v_curve) at the contact point; t is the normal
    /// turned clockwise by a quarter turn.
    #[inline(always)]
    pub(crate) fn slip_row(&self, carried: &[T; B], pose: &Pose<T, B>) -> [T; B] {
        pose.turning_row(carried, self.point, [-self.normal[1], self.normal[0]])
    }
}

/// Signed distance from the disc's centre to the curve, and the curve's outward unit normal there.
#[inline(always)]
fn distance_to_curve<T: Real, const B: usize>(zone: &Zone<T>, pose: &Pose<T, B>, center: Vector<T>) -> (T, Vector<T>) {
    match zone.curve {
        Curve::Line { point, normal } => {
            let n = pose.rotate(zone.curve_body, normal);
            (dot(sub(center, pose.point(zone.curve_body, point)), n), n)
        }
        Curve::Segment { from, direction, length, rounding } => {
            let t = pose.rotate(zone.curve_body, direction);
            let from = pose.point(zone.curve_body, from);
            let along = dot(sub(center, from), t).max(T::ZERO).min(length);
            let (d, n) = length_and_direction(sub(center, add(from, scale(t, along))), [-t[1], t[0]]);
            (d - rounding, n)
        }
        Curve::Disc { center: other, radius } => {
            let other = pose.point(zone.curve_body, other);
            let (d, n) = length_and_direction(sub(center, other), [T::ZERO, T::ONE]);
            (d - radius, n)
        }
    }
}

/// |a| and a/|a|; `fallback` (a unit vector) where a vanishes, so that no division by zero can start a NaN.
#[inline(always)]
fn length_and_direction<T: Real>(a: Vector<T>, fallback: Vector<T>) -> (T, Vector<T>) {
    let squared = dot(a, a);
    let usable = T::from_f64(1e-30).lt(squared);
    let length = T::select(usable, squared, T::ONE).sqrt();
    let inverse = T::ONE / length;
    let n = [T::select(usable, a[0] * inverse, fallback[0]), T::select(usable, a[1] * inverse, fallback[1])];
    (T::select(usable, length, T::ZERO), n)
}

/// How a zone's force bends away from its linearisation.
#[derive(Debug, Clone, Copy)]
struct Bend<T> {
    /// Largest compression during the step, m; negative where there is none.
    deepest: T,
    /// Largest |dF/dg| and dF/d(dg/dt) of the Gauss points.
    slope: T,
    damping: T,
    /// Smallest force of a touched Gauss point, N: how far the clamp at zero is.
    slack: T,
}

/// The felt law and its partial derivatives at one compression and rate.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FeltState<T> {
    pub force: T,
    pub damping_force: T,
    pub stiffness: T,
    pub damping: T,
    /// Force before the clamp's kink; large where the felt is not touched, zero where it is clamped.
    pub slack: T,
}

/// F = max(0, k g^r + b g^2 dg/dt) and dF/dg, dF/d(dg/dt); `gap` must not be negative.
#[inline(always)]
pub(crate) fn felt_law<T: Real>(felt: &Felt<T>, gap: T, rate: T) -> FeltState<T> {
    let two = T::from_f64(2.0);
    let (elastic, slope, _) = felt.elastic(gap);
    let bg = felt.damping * gap;
    let damping = bg * gap;
    let force = elastic + damping * rate;
    let pushing = T::ZERO.lt(force);
    FeltState {
        force: T::select(pushing, force, T::ZERO),
        damping_force: T::select(pushing, damping * rate, -elastic),
        stiffness: T::select(pushing, slope + two * bg * rate, T::ZERO),
        damping: T::select(pushing, damping, T::ZERO),
        slack: T::select(T::ZERO.lt(gap), T::select(pushing, force, T::ZERO), T::from_f64(1e30)),
    }
}

impl<T: Real> Felt<T> {
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
pub(crate) fn gap_of<T: Real, const B: usize>(zone: &Zone<T>, pose: &Pose<T, B>) -> T {
    let (distance, _) = distance_to_curve(zone, pose, pose.point(zone.disc_body, zone.center));
    zone.radius - distance
}

/// The row G of a zone at a pose in relative velocities: dg/dt = G w, with G = -n . (v_disc(c) - v_curve(c)), exact although
/// the contact point moves. `carried` is +1 for joints that carry the curve only, -1 for the disc only.
pub(crate) fn gap_row_of<T: Real, const B: usize>(zone: &Zone<T>, carried: &[T; B], pose: &Pose<T, B>) -> [T; B] {
    let center = pose.point(zone.disc_body, zone.center);
    let (_, normal) = distance_to_curve(zone, pose, center);
    pose.turning_row(carried, center, normal)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Body, GROUND, Model};

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
                let gap = |q: &[f64; 4]| gap_of(&zone, &Pose::of(&model, q));
                let mut contact = Contact::apart();
                contact.evaluate(&zone, &model.carried[0], &Pose::of(&model, &q), &[0.0; 4], 1e-3, 0.5);
                assert!(contact.active);
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
            let at = felt_law(&felt, g, v);
            let dg = (felt_law(&felt, g + e, v).force - felt_law(&felt, g - e, v).force) / (2.0 * e);
            let dv = (felt_law(&felt, g, v + e).force - felt_law(&felt, g, v - e).force) / (2.0 * e);
            assert!((at.stiffness - dg).abs() < 1e-6 * dg.abs(), "{exponent:?}");
            assert!((at.damping - dv).abs() < 1e-6 * dv.abs(), "{exponent:?}");
            assert_eq!(felt_law(&felt, g, -1e3).force, 0.0);
        }
    }
}
