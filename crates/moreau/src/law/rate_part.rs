//! The part of a contact's force that is a function of the compression g and the rate dg/dt now: k g^r and a loss in
//! one of two forms.
//!
//! This is the hot part of a law. Laws without memory are nothing else; a law with memory has none of it.

use super::spring::{Curvature, Elastic, Exponent, FAR, Pressed, Spring, TINY};
use crate::real::{Mask, Real};
use crate::timing::Timing;

/// m; square roots of compressions are bounded by their tangent here.
const USUAL_DEPTH: f64 = 1e-3;
/// m; the quick test bounds Hunt and Crossley's loss up to this compression, several times what the felts of an action
/// are pressed by. A felt that is pressed deeper is looked at by itself.
pub(crate) const MAX_DEPTH: f64 = 3e-3;

/// The loss's form.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Form<T> {
    /// b g^2 dg/dt: b, N s/m3.
    Square(T),
    /// a k g^r dg/dt: a, s/m.
    Proportional(T),
}

/// The shortest way, as a part of the compressions at its ends, on which the mean of a force is a difference of
/// potentials. The tangent loses the square of it to rounding; the quadrature loses its fourth power.
fn shortest_way<T: Real>() -> T {
    let single = size_of::<T::Lane>() < size_of::<f64>();
    T::from_f64(if single { 0.05 } else { 1e-3 })
}

/// How strongly a felt's force can bend away from its tangent: with depth the largest compression and speed the largest
/// |dg/dt|, 1/2 |F_gg| <= stiffness + stiffness_by_depth depth + damping speed and |F_gv| <= 2 damping depth, up to the
/// compression `deepest`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CurvatureBound<T> {
    pub stiffness: T,
    pub stiffness_by_depth: T,
    pub damping: T,
    pub deepest: T,
}

impl<T: Real> CurvatureBound<T> {
    /// `sharper`: how much more sharply than the spring a law bends that adds to it.
    pub(crate) fn of(spring: &Spring<T>, form: Form<T>, sharper: T) -> Self {
        let c = T::from_f64;
        let k = spring.stiffness;
        // 1/2 r (r - 1) k g^(r - 2), as a number and one per metre of depth.
        let (constant, by_depth) = match spring.exponent {
            Exponent::Two => (1.0, 0.0),
            // sqrt(g) <= (d + g) / (2 sqrt(d)) for any d.
            Exponent::TwoAndHalf => (0.9375 * libm::sqrt(USUAL_DEPTH), 0.9375 / libm::sqrt(USUAL_DEPTH)),
            Exponent::Three => (0.0, 3.0),
            // No bound: the quick test always leaves it to the exact one.
            Exponent::Other(_) => (FAR, 0.0),
        };
        let (damping, deepest) = match (form, spring.exponent) {
            (Form::Square(b), _) => (b, c(FAR)),
            // a k g^2 dg/dt is the papers' law with b = a k.
            (Form::Proportional(a), Exponent::Two) => (a * k, c(FAR)),
            // 1/2 F_gg = 1/2 r (r - 1) a k g^(r - 2) dg/dt and F_gv = r a k g^(r - 1), and g^(r - 2) <= D^(r - 2) for g
            // <= D and r >= 2.
            (Form::Proportional(a), Exponent::TwoAndHalf) => (a * k * c(1.875 * libm::sqrt(MAX_DEPTH)), c(MAX_DEPTH)),
            (Form::Proportional(a), Exponent::Three) => (a * k * c(3.0 * MAX_DEPTH), c(MAX_DEPTH)),
            (Form::Proportional(_), Exponent::Other(_)) => (T::ZERO, c(FAR)),
        };
        let (stiffness, stiffness_by_depth) = (sharper * k * c(constant), sharper * k * c(by_depth));
        CurvatureBound { stiffness, stiffness_by_depth, damping, deepest }
    }
}

/// Spring and loss, as the step reads them: what does not change is worked out once.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RatePart<T> {
    pub spring: Spring<T>,
    pub form: Form<T>,
    /// b where the form is a square.
    damping: T,
    /// The rate, m/s, at which a felt opens when it just pushes no more, where that does not depend on the compression:
    /// k/b for r = 2, 1/a for Hunt and Crossley's.
    opening: T,
}

impl<T: Real> RatePart<T> {
    pub(crate) fn of(spring: Spring<T>, form: Form<T>) -> Self {
        let tiny = T::from_f64(TINY);
        // For r = 2 Hunt and Crossley's law is the papers', with b = a k.
        let form = match (form, spring.exponent) {
            (Form::Proportional(a), Exponent::Two) => Form::Square(a * spring.stiffness),
            (form, _) => form,
        };
        let (damping, opening) = match form {
            Form::Proportional(a) => (T::ZERO, T::ONE / a.max(tiny)),
            Form::Square(b) => (b, spring.stiffness / b.max(tiny)),
        };
        RatePart { spring, form, damping, opening }
    }

    /// r = 2 with the papers' loss: the mean over a step has a closed form.
    pub(crate) fn is_square(&self) -> bool {
        matches!((self.spring.exponent, self.form), (Exponent::Two, Form::Square(_)))
    }

    /// r = 2 and both Gauss points touched: F = (k + b dg/dt) g^2, whose mean over the path is (k + b dg/dt) (g^2 +
    /// o^2), o being the points' distance from the middle.
    #[inline(always)]
    pub(crate) fn press_square(
        &self,
        compression: T,
        rate: T,
        timing: &Timing<T>,
        touched: T::Mask,
    ) -> (Pressed<T>, Curvature<T>) {
        let (h_theta, node) = (timing.h_theta, timing.node);
        let (offset, reach) = (node * rate, h_theta + node);
        let (deepest, shallowest) = (compression + offset.abs(), compression - offset.abs());
        let bv = self.damping * rate;
        let (factor, square) = (self.spring.stiffness + bv, (compression * compression).add_product(offset, offset));
        // One factor for both points: the clamp takes both or none.
        let pushing = touched.and(T::ZERO.lt(factor));
        let only_pushing = |x: T| T::only(pushing, x);
        let twice = factor + factor;
        let tangent =
            h_theta * (self.damping * square).add_product(twice, (h_theta * compression).add_product(node, offset));
        let pressed = Pressed {
            force: only_pushing(factor * square),
            // What the clamp leaves of the damping undoes the stiffness.
            damping_force: T::select(pushing, bv, -self.spring.stiffness) * square,
            tangent: only_pushing(tangent.max(T::ZERO)),
            opening: self.opening + rate,
        };
        let curvature = Curvature {
            linear: deepest * (reach * twice.abs() + self.damping * deepest),
            quadratic: reach * (reach * (self.spring.stiffness + bv.abs()) + T::from_f64(2.0) * self.damping * deepest),
            slack: only_pushing(factor * shallowest * shallowest),
        };
        (pressed, curvature)
    }

    /// Any law and any path, point by point.
    #[inline(always)]
    pub(crate) fn press_points(
        &self,
        compression: T,
        rate: T,
        timing: &Timing<T>,
        touched: T::Mask,
    ) -> (Pressed<T>, Curvature<T>) {
        let half = T::from_f64(0.5);
        let offset = timing.node * rate;
        let deepest = compression + offset.abs();
        let (first, second) = ((compression + offset).max(T::ZERO), (compression - offset).max(T::ZERO));
        let (elastic_a, elastic_b) = (self.spring.at(first), self.spring.at(second));
        let a = self.at(&elastic_a, first, rate).clamped(first);
        let b = self.at(&elastic_b, second, rate).clamped(second);
        let only_touched = |x: T| T::only(touched, x);
        let (h_theta, node) = (timing.h_theta, timing.node);
        let slope = ((h_theta + node) * a.stiffness).add_product(h_theta - node, b.stiffness);
        // The compression's change by a change of the rate.
        let reach = h_theta + node;
        let bend = self.bend(&elastic_a.max(&elastic_b), deepest, rate);
        let slack = a.slack.min(b.slack);
        let pressed = Pressed {
            force: only_touched(half * (a.force + b.force)),
            damping_force: half * (a.damping_force + b.damping_force),
            tangent: only_touched((half * h_theta * (a.damping + b.damping + slope)).max(T::ZERO)),
            opening: match self.form {
                Form::Proportional(_) => self.opening + rate,
                // The least of the forces over the largest damping.
                _ => slack / bend.largest_damping.max(T::from_f64(TINY)),
            },
        };
        let curvature = Curvature {
            // A point that the clamp holds at zero counts as flat: should it push after the change, the step does not
            // know. That costs the one step in which a felt opens faster than its loss allows some of its exactness; to
            // count it would cost iterations, and move bits that are promised.
            linear: reach * a.stiffness.abs().max(b.stiffness.abs()) + a.damping.max(b.damping),
            quadratic: reach * (reach * bend.by_compression + bend.mixed),
            slack,
        };
        (pressed, curvature)
    }

    /// Its mean along the step's straight path worked out exactly: with V' = k g^r, (V(b) - V(a))/(b - a) from
    /// compression to compression, and (b^3 - a^3)/(3 (b - a)) of g^2, also where the path begins or ends apart.
    /// Two-point quadrature leaves part of a felt's work unexplained where it is touched in mid step, or where r is
    /// neither 2 nor 3; a hammer that rattles on a string would win or lose by that.
    pub(crate) fn press_exactly(&self, compression: T, rate: T, timing: &Timing<T>, touched: T::Mask) -> Pressed<T> {
        let pressed = self.press_points(compression, rate, timing, touched).0;
        let half = timing.step - timing.h_theta;
        let (whole, way) = (half + half, (half + half) * rate);
        let (a, b) = ((compression - half * rate).max(T::ZERO), (compression + half * rate).max(T::ZERO));
        // On a short way the difference of potentials is rounded, and the quadrature is exact to rounding.
        let long = (shortest_way::<T>() * (a + b)).lt(way.abs());
        if !long.any() {
            return pressed;
        }
        let (from, to) = (self.spring.at(a), self.spring.at(b));
        let inverse = T::ONE / T::select(long, way, T::ONE);
        let (ahead, behind) = (timing.h_theta + half, timing.h_theta - half);
        // The mean of what has the integrals v at the ends, and how it changes with the rate.
        let mean = |v: [T; 2], f: [T; 2]| {
            let mean = (v[1] - v[0]) * inverse;
            (mean, (f[1] * ahead - f[0] * behind - whole * mean) * inverse)
        };
        let power = T::ONE / (self.spring.exponent.value() + T::ONE);
        let (elastic, slope) = mean([power * from.force * a, power * to.force * b], [from.force, to.force]);
        let (force, slope) = match self.form {
            Form::Proportional(c) => (elastic + c * rate * elastic, slope + c * (elastic + rate * slope)),
            Form::Square(c) => {
                let third = T::from_f64(1.0 / 3.0);
                let (square, bend) = mean([third * a * a * a, third * b * b * b], [a * a, b * b]);
                (elastic + c * rate * square, slope + c * (square + rate * bend))
            }
        };
        let pushing = touched.and(T::ZERO.lt(force));
        let clamped = T::only(pushing, force);
        let exact = |new: T, old: T| T::select(long, new, old);
        Pressed {
            force: exact(clamped, pressed.force),
            // What the clamp leaves of the loss undoes the stiffness.
            damping_force: exact(T::only(touched, clamped - elastic), pressed.damping_force),
            tangent: exact(T::only(pushing, (timing.h_theta * slope).max(T::ZERO)), pressed.tangent),
            ..pressed
        }
    }

    /// The largest force of a felt that is pressed no deeper and no faster than this, N.
    #[inline(always)]
    pub(crate) fn largest_force(&self, deepest: T, speed: T) -> T {
        let elastic = self.spring.at(deepest).force;
        match self.form {
            Form::Square(b) => elastic + b * deepest * deepest * speed,
            Form::Proportional(a) => elastic + a * elastic * speed,
        }
    }

    /// The law and its partial derivatives, not clamped; `compression` must not be negative.
    #[inline(always)]
    pub(crate) fn at(&self, elastic: &Elastic<T>, compression: T, rate: T) -> FeltState<T> {
        match self.form {
            Form::Square(b) => {
                let bg = b * compression;
                let damping = bg * compression;
                let damping_force = damping * rate;
                let force = elastic.force + damping_force;
                let stiffness = elastic.slope.add_product(bg + bg, rate);
                FeltState { force, damping_force, stiffness, damping, slack: force }
            }
            Form::Proportional(a) => {
                let damping = a * elastic.force;
                let damping_force = damping * rate;
                let force = elastic.force + damping_force;
                let stiffness = elastic.slope.add_product(a * elastic.slope, rate);
                FeltState { force, damping_force, stiffness, damping, slack: force }
            }
        }
    }

    /// Its second derivatives at most, on a path down to `deepest`, given the larger of the elastic forces, slopes and
    /// curvatures there.
    #[inline(always)]
    fn bend(&self, elastic: &Elastic<T>, deepest: T, rate: T) -> Bend<T> {
        let (half, two) = (T::from_f64(0.5), T::from_f64(2.0));
        match self.form {
            Form::Square(b) => Bend {
                by_compression: half * elastic.curvature + b * rate.abs(),
                mixed: two * b * deepest,
                largest_damping: b * deepest * deepest,
            },
            Form::Proportional(a) => Bend {
                by_compression: half * elastic.curvature * (T::ONE + a * rate.abs()),
                mixed: a * elastic.slope,
                largest_damping: a * elastic.force,
            },
        }
    }
}

/// The second derivatives of a law, at most.
struct Bend<T> {
    /// 1/2 |F_gg|.
    by_compression: T,
    /// |F_gv|.
    mixed: T,
    /// F_v.
    largest_damping: T,
}

/// The felt law and its partial derivatives at one compression and rate.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FeltState<T> {
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
    fn clamped(self, compression: T) -> Self {
        let pushing = T::ZERO.lt(self.force);
        let or_zero = |x: T| T::only(pushing, x);
        FeltState {
            force: or_zero(self.force),
            damping_force: T::select(pushing, self.damping_force, self.damping_force - self.force),
            stiffness: or_zero(self.stiffness),
            damping: or_zero(self.damping),
            slack: T::select(T::ZERO.lt(compression), or_zero(self.force), T::from_f64(FAR)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const EXPONENTS: [Exponent<f64>; 4] = [Exponent::Two, Exponent::TwoAndHalf, Exponent::Three, Exponent::Other(1.7)];

    fn laws() -> impl Iterator<Item = (Form<f64>, RatePart<f64>)> {
        let forms = [Form::Square(2e3), Form::Proportional(0.8)];
        EXPONENTS
            .into_iter()
            .flat_map(move |exponent| forms.map(|form| (form, RatePart::of(Spring { stiffness: 3e3, exponent }, form))))
    }

    /// As a felt presses that is touched at both points.
    fn press(law: &RatePart<f64>, compression: f64, rate: f64, timing: &Timing<f64>) -> (Pressed<f64>, Curvature<f64>) {
        let press = if law.is_square() { RatePart::press_square } else { RatePart::press_points };
        press(law, compression, rate, timing, true)
    }

    fn at(law: &RatePart<f64>, g: f64, v: f64) -> FeltState<f64> {
        law.at(&law.spring.at(g), g, v).clamped(g)
    }

    /// The force as the README writes it, by `pow`, against the law's own: to rounding.
    #[test]
    fn the_force_is_the_written_one() {
        for (form, law) in laws() {
            for (g, v) in [(0.02, -0.01), (1e-3, 0.3), (0.5, 1.0)] {
                let elastic = law.spring.stiffness * libm::pow(g, law.spring.exponent.value());
                let written = match form {
                    Form::Square(b) => elastic + b * g * g * v,
                    Form::Proportional(a) => elastic * (1.0 + a * v),
                };
                let ours = at(&law, g, v).force;
                assert!(
                    (ours - written.max(0.0)).abs() <= 1e-14 * written.abs(),
                    "{form:?} {law:?} {g} {v}: {ours} {written}"
                );
            }
        }
    }

    /// The law's partial derivatives against differences, and the clamp: felt never pulls.
    #[test]
    fn partial_derivatives() {
        for (form, law) in laws() {
            let (g, v, e) = (0.02, -0.01, 1e-7);
            let here = at(&law, g, v);
            let dg = (at(&law, g + e, v).force - at(&law, g - e, v).force) / (2.0 * e);
            let dv = (at(&law, g, v + e).force - at(&law, g, v - e).force) / (2.0 * e);
            assert!((here.stiffness - dg).abs() < 1e-6 * dg.abs(), "{form:?} {law:?}");
            assert!((here.damping - dv).abs() < 1e-6 * dv.abs(), "{form:?} {law:?}");
            assert_eq!(at(&law, g, -1e3).force, 0.0);
        }
    }

    /// The stored energy is the integral of the force of a felt that moves infinitely slowly: Simpson's rule over 2000
    /// intervals, whose own error for g^1.7, the least smooth at zero, is below 1e-6.
    #[test]
    fn the_stored_energy_is_the_slow_work() {
        for (form, law) in laws() {
            let (depth, n) = (0.02, 2000);
            let force = |i: i32| at(&law, depth * f64::from(i) / f64::from(n), 0.0).force;
            let inner: f64 = (1..n).map(|i| if i % 2 == 1 { 4.0 * force(i) } else { 2.0 * force(i) }).sum();
            let work = (force(0) + inner + force(n)) * depth / f64::from(n) / 3.0;
            assert!((law.spring.stored(depth) - work).abs() < 1e-6 * work, "{form:?} {law:?}");
        }
    }

    /// Where a law's rate of opening does not depend on the compression, its force vanishes just there.
    #[test]
    fn a_felt_that_opens_so_fast_pushes_no_more() {
        for (form, law) in laws().filter(|(form, law)| law.is_square() || matches!(form, Form::Proportional(_))) {
            for compression in [1e-4, 1e-3, 0.02] {
                assert!(at(&law, compression, -0.999 * law.opening).force > 0.0, "{form:?} {law:?}");
                assert_eq!(at(&law, compression, -1.001 * law.opening).force, 0.0, "{form:?} {law:?}");
            }
        }
    }

    /// The curvature bound is one: second derivatives by differences of the first ones, over compressions and rates up
    /// to its limit. It is met where the law is a square (nothing is lost), and by no more than an order of magnitude
    /// anywhere.
    #[test]
    fn the_curvature_bound_holds() {
        for (form, law) in laws().filter(|(_, law)| !matches!(law.spring.exponent, Exponent::Other(_))) {
            let bound = CurvatureBound::of(&law.spring, form, 1.0);
            for depth in [1e-5, 1e-4, 1e-3, 0.999 * MAX_DEPTH] {
                for v in [-0.9, 0.0, 0.3, 5.0] {
                    let e = 1e-6 * depth;
                    let (up, down) = (
                        law.at(&law.spring.at(depth + e), depth + e, v),
                        law.at(&law.spring.at(depth - e), depth - e, v),
                    );
                    let by_compression = 0.5 * (up.stiffness - down.stiffness).abs() / (2.0 * e);
                    let mixed = (up.damping - down.damping).abs() / (2.0 * e);
                    let rounding = 1.0 + 1e-8;
                    let most = bound.stiffness + bound.stiffness_by_depth * depth + bound.damping * v.abs();
                    assert!(by_compression <= most * rounding, "{form:?} {law:?} {depth} {v}: {by_compression} {most}");
                    assert!(mixed <= 2.0 * bound.damping * depth * rounding, "{form:?} {law:?} {depth} {v}");
                }
            }
        }
    }

    /// Compressions and rates at which both points of the quadrature are touched, for every law; theta between its ends
    /// and at them.
    fn touched() -> impl Iterator<Item = (Form<f64>, RatePart<f64>, f64, f64, Timing<f64>)> {
        let timings = [(50e-6, 0.5), (1e-3, 0.5), (2e-4, 0.7), (50e-6, 1.0)].map(|(h, theta)| Timing::new(h, theta));
        laws().flat_map(move |(form, law)| {
            timings.into_iter().flat_map(move |timing| {
                [(1e-3, 0.3), (2e-3, -0.4), (0.01, 2.0), (0.02, -0.01)]
                    .map(|(compression, rate)| (form, law, compression, rate, timing))
            })
        })
    }

    /// The closed form for a square is the quadrature, in all that it tells.
    #[test]
    fn the_closed_form_is_the_quadrature() {
        for (form, law, compression, rate, timing) in touched().filter(|(_, law, ..)| law.is_square()) {
            let ((closed, closed_bend), (points, bend)) = (
                law.press_square(compression, rate, &timing, true),
                law.press_points(compression, rate, &timing, true),
            );
            let same = |a: f64, b: f64, what: &str| {
                assert!(
                    (a - b).abs() <= 1e-12 * b.abs(),
                    "{form:?} {law:?} {compression} {rate} {timing:?}: {what} {a} {b}"
                );
            };
            same(closed.force, points.force, "force");
            same(closed.damping_force, points.damping_force, "damping force");
            same(closed.tangent, points.tangent, "tangent");
            same(closed_bend.linear, bend.linear, "linear");
            same(closed_bend.quadratic, bend.quadratic, "quadratic");
            same(closed_bend.slack, bend.slack, "slack");
        }
    }

    /// How much slower the felt may close before its force vanishes is exact where the compression plays no
    /// part: by 1/a and its rate.
    #[test]
    fn the_clamp_is_as_far_as_it_says() {
        let mut met = 0;
        for (form, law, compression, rate, timing) in touched() {
            if let Form::Proportional(a) = form {
                let (Pressed { opening, .. }, _) = press(&law, compression, rate, &timing);
                assert!((opening - (1.0 / a + rate)).abs() <= 1e-12 / a, "{form:?} {law:?} {rate}: {opening}");
                met += 1;
            }
        }
        assert!(met > 0);
    }

    /// The mean force is that of the two points of Gauss, and the tangent its derivative by the rate, the compression
    /// going along with it by theta h (a central difference, right to 1e-8).
    #[test]
    fn the_quadrature_and_its_tangent() {
        for (form, law, compression, rate, timing) in touched() {
            let written = |g: f64, v: f64| {
                let elastic = law.spring.stiffness * libm::pow(g, law.spring.exponent.value());
                match form {
                    Form::Square(b) => elastic + b * g * g * v,
                    Form::Proportional(a) => elastic * (1.0 + a * v),
                }
                .max(0.0)
            };
            let mean = |compression: f64, rate: f64| {
                let offset = (timing.step - timing.h_theta) / 3f64.sqrt() * rate;
                0.5 * (written(compression + offset, rate) + written(compression - offset, rate))
            };
            let (pressed, _) = press(&law, compression, rate, &timing);
            let force = mean(compression, rate);
            assert!(
                (pressed.force - force).abs() <= 1e-12 * force,
                "{form:?} {law:?} {compression} {rate}: {} {force}",
                pressed.force
            );
            let e = 1e-6;
            let slope = (mean(compression + timing.h_theta * e, rate + e)
                - mean(compression - timing.h_theta * e, rate - e))
                / (2.0 * e);
            let tangent = timing.h_theta * slope;
            // Where it would pull with the rate it is cut off at zero.
            let off = (pressed.tangent - tangent.max(0.0)).abs();
            assert!(
                off <= 1e-6 * tangent.abs() + 1e-12,
                "{form:?} {law:?} {compression} {rate} {timing:?}: {} {tangent}",
                pressed.tangent
            );
        }
    }

    /// What the step takes for the second derivatives is what they are, where the felt is being compressed: central
    /// differences of the first ones.
    #[test]
    fn second_derivatives() {
        for (form, law) in laws() {
            for (g, v) in [(1e-3, 0.5), (0.02, 2.0)] {
                let e = 1e-5 * g;
                let state = |g: f64| law.at(&law.spring.at(g), g, v);
                let (up, down, bend) = (state(g + e), state(g - e), law.bend(&law.spring.at(g), g, v));
                let by_compression = 0.5 * (up.stiffness - down.stiffness) / (2.0 * e);
                let mixed = (up.damping - down.damping) / (2.0 * e);
                assert!(
                    (bend.by_compression - by_compression).abs() < 1e-6 * by_compression,
                    "{form:?} {law:?} {g}: {} {by_compression}",
                    bend.by_compression
                );
                assert!((bend.mixed - mixed).abs() < 1e-6 * mixed, "{form:?} {law:?} {g}: {} {mixed}", bend.mixed);
                assert!(
                    (bend.largest_damping - state(g).damping).abs() <= 1e-14 * bend.largest_damping,
                    "{form:?} {law:?} {g}"
                );
                let elastic = law.spring.at(g);
                let curvature = (law.spring.at(g + e).slope - law.spring.at(g - e).slope) / (2.0 * e);
                assert!(
                    (elastic.curvature - curvature).abs() < 1e-6 * curvature,
                    "{form:?} {law:?} {g}: {elastic:?} {curvature}"
                );
            }
        }
    }

    /// No deeper and no faster: the largest force is the one at both limits.
    #[test]
    fn the_largest_force_is_the_deepest_and_fastest() {
        for (form, law) in laws() {
            for (g, v) in [(1e-3, 0.5), (0.02, 3.0)] {
                let largest = law.largest_force(g, v);
                assert!((largest - law.at(&law.spring.at(g), g, v).force).abs() <= 1e-14 * largest, "{form:?} {law:?}");
                for (share, part) in [(0.3, 1.0), (1.0, -0.7), (0.9, 0.2)] {
                    let force = law.at(&law.spring.at(share * g), share * g, part * v).force;
                    assert!(force <= largest, "{form:?} {law:?}");
                }
            }
        }
    }
}
