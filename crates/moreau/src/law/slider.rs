//! Sliders: springs in series with dry friction, beside the spring of a felt. What laws with rate-independent loss are
//! made of.
//!
//! In x = g^m, m = (r + 1)/2, the felt is a spring of stiffness kappa = k/m; beside it stand springs K = eta kappa /
//! slip, each in series with a slider of bound eta kappa x: all straight lines. On the step's path, which is
//! monotonous, their work is worked out exactly; the force is that work over the way, so that no step of any length
//! gives energy. `README.md`, "Felts with an internal state", has the derivation.

use super::hook::{MEMORY, Memory, Path, Pressing};
use super::spring::{Curvature, Exponent, FAR, Pressed, Spring, TINY};
use crate::real::{Mask, Real, Scalar};

/// A slider that gives early on the step's path bends the force by less than the quick test allows it, if the square of
/// the part of the way on which it held, times x over the way, is below this.
const EARLY: f64 = 0.0625;

/// A spring in series with a slider. Its memory is the spring's stretch e, m^((r+1)/2).
#[derive(Debug, Clone, Copy)]
pub(crate) struct Slider<T> {
    /// K over kappa.
    pub ratio: T,
    /// The spring's stretch at which the slider gives, as a part of x.
    pub slip: T,
}

impl<T: Real> Slider<T> {
    /// The slider's bound as a part of k g^r.
    #[inline(always)]
    fn eta(&self) -> T {
        self.ratio * self.slip
    }

    /// A factor in the bound of its bend (README, "Felts with an internal state").
    #[inline(always)]
    fn stretch(&self) -> T {
        (T::ONE + self.slip) * (T::ONE + self.slip) / (T::ONE - self.slip)
    }

    /// A stretch within its bounds at x.
    #[inline(always)]
    fn within(&self, e: T, x: T) -> T {
        let bound = self.slip * x;
        e.max(-bound).min(bound)
    }

    /// The stretch where the path begins over which the force is a mean.
    #[inline(always)]
    fn start(&self, memory: T, way: &Way<T>) -> T {
        let start = self.within(memory, way.start);
        if way.late { self.within(start + (way.from.x - way.start), way.from.x) } else { start }
    }
}

/// How much more sharply than the spring a felt with sliders may bend, for the exponent r.
pub(crate) fn effective_exponent<T: Real>(sliders: &[Slider<T>], r: T) -> T {
    let (one, c) = (T::ONE, T::from_f64);
    let mut sum = one;
    for slider in sliders {
        sum += slider.ratio * (one + c(0.25) * (r - c(3.0)).abs() * slider.stretch() / r);
    }
    sum
}

/// The energy in the sliders' springs, J.
#[inline(always)]
pub(crate) fn stored_energy<T: Real>(sliders: &[Slider<T>], spring: &Spring<T>, memory: &Memory<T>) -> T {
    let mut sum = T::ZERO;
    for (slider, e) in sliders.iter().zip(memory) {
        sum = sum.add_product(slider.ratio, *e * *e);
    }
    T::from_f64(0.5) * (spring.stiffness * inverse_power(spring)) * sum
}

/// The memory at the step's end, from the memory at its start.
#[inline(always)]
pub(crate) fn load_state<T: Real>(
    sliders: &[Slider<T>],
    spring: &Spring<T>,
    pressing: &Pressing<'_, T>,
    memory: &Memory<T>,
) -> Memory<T> {
    let way = Way::of(spring, pressing);
    let mut after = [T::ZERO; MEMORY];
    for ((slider, &e), after) in sliders.iter().zip(memory).zip(&mut after) {
        *after = T::only(pressing.touched, slider.within(slider.start(e, &way) + way.length, way.to.x));
    }
    after
}

/// Force and tangent of a felt with sliders and b beside its spring, from the memory at the step's start.
#[inline(always)]
pub(crate) fn press<T: Real>(
    sliders: &[Slider<T>],
    damping: T,
    spring: &Spring<T>,
    pressing: &Pressing<'_, T>,
    memory: &Memory<T>,
) -> Pressed<T> {
    Pushed::of(sliders, damping, spring, pressing, memory).pressed
}

/// How that force bends away from its tangent.
#[inline(always)]
pub(crate) fn curvature<T: Real>(
    sliders: &[Slider<T>],
    damping: T,
    spring: &Spring<T>,
    pressing: &Pressing<'_, T>,
    memory: &Memory<T>,
) -> Curvature<T> {
    let (half, one, two, tiny) = (T::from_f64(0.5), T::ONE, T::from_f64(2.0), T::from_f64(TINY));
    let Pushed { way, pressed, linear, room } = Pushed::of(sliders, damping, spring, pressing, memory);
    let Pressing { rate, timing, .. } = *pressing;
    let (r, m) = (spring.exponent.value(), half_power(spring));
    // Second derivatives of the felt while slider or spring hold, and the bend where a slider gives.
    let (mut bends, mut knee) = (one, T::ZERO);
    for (slider, &e) in sliders.iter().zip(memory) {
        let slid = Slide::of(slider, e, &way);
        bends += slider.ratio * (one + half * (m - two).abs() * slider.stretch() / r);
        knee += T::only(slid.holds.not(), slider.ratio * slid.held * slid.held * (one + slider.slip));
    }
    let reach = two * timing.h_theta;
    let curvature = way.from.curvature(spring).max(way.to.curvature(spring));
    let knee = way.kappa * knee * way.chord.mean * way.to.slope * way.to.slope / way.length.abs().max(tiny);
    let deepest = way.from.g.max(way.to.g);
    let speed = damping * rate.abs();
    let quadratic =
        half * reach * (reach * (curvature * bends + knee + two * speed) + T::from_f64(4.0) * damping * deepest);
    // How far the clamp is, and the nearest slider's switch. For theta above 1/2 the tangent leaves out what is of
    // first order (`Pushed::of`), which a slack of zero says.
    let slack = (half * linear * room).min(pressed.force);
    Curvature { linear, quadratic, slack: T::select(timing.theta.le(half), slack, T::ZERO) }
}

/// Force and tangent, and what its bend is worked out from.
struct Pushed<T> {
    way: Way<T>,
    pressed: Pressed<T>,
    /// The largest change of the force with the rate.
    linear: T,
    /// By how much the rate may change, m/s, until a slider begins to give, or the way turns round.
    room: T,
}

impl<T: Real> Pushed<T> {
    #[inline(always)]
    fn of(
        sliders: &[Slider<T>],
        damping: T,
        spring: &Spring<T>,
        pressing: &Pressing<'_, T>,
        memory: &Memory<T>,
    ) -> Self {
        let (half, one, two, tiny) = (T::from_f64(0.5), T::ONE, T::from_f64(2.0), T::from_f64(TINY));
        let Pressing { rate, timing, touched, .. } = *pressing;
        let way = Way::of(spring, pressing);
        let (from, to, chord) = (&way.from, &way.to, &way.chord);
        // The mean force in x and its slope, over kappa. For theta above 1/2 the stretch at the path's beginning goes
        // along with the rate, which the slope does not know: such a felt is always near a switch.
        let elastic = half * (from.x + to.x);
        let (mut total, mut slope, mut ratios, mut bounds) = (elastic, half, one, one);
        let (mut room, mut near) = (T::from_f64(FAR), timing.theta.le(half).not());
        for (slider, &e) in sliders.iter().zip(memory) {
            let slid = Slide::of(slider, e, &way);
            total = total.add_product(slider.ratio, slid.mean);
            slope = slope.add_product(slider.ratio, slid.mean_slope);
            ratios += slider.ratio;
            bounds += slider.eta();
            room = room.min(slid.room);
            near = near.or(slid.near);
        }
        let slope = way.kappa * (chord.mean * to.slope * slope).add_product(total, chord.slope);
        let reach = two * timing.h_theta;
        // The papers' b, with the mean of g^2 over the path.
        let third = T::from_f64(1.0 / 3.0);
        let square = third * (from.g * from.g + from.g * to.g + to.g * to.g);
        let viscous = damping * square * chord.part;
        let by_depth =
            damping * rate * (third * (from.g + two * to.g) * chord.part).add_product(square, chord.part_slope);
        let slope = (reach * (slope + by_depth) + viscous).max(T::ZERO);
        let force = (way.kappa * total * chord.mean).add_product(viscous, rate);
        let pushing = touched.and(T::ZERO.lt(force));
        let force = T::only(pushing, force);
        let (steepest, deepest) = (from.slope.max(to.slope), from.g.max(to.g));
        let m = half_power(spring);
        let steep = way.kappa * steepest * steepest * ratios.add_product((m - one) * inverse_power(spring), bounds);
        let lossy = damping * deepest;
        let linear = (lossy * deepest).add_product(reach, steep.add_product(two * rate.abs(), lossy));
        let room = room / (reach * steepest).max(tiny);
        let pressed = Pressed {
            force,
            // What the clamp leaves of the loss undoes the stiffness.
            damping_force: T::only(touched, force - way.kappa * elastic * chord.mean),
            tangent: T::only(pushing, timing.h_theta * slope),
            opening: T::select(near, T::ZERO, room.min(force / linear.max(tiny))),
        };
        Pushed { way, pressed, linear, room }
    }
}

/// What one slider does on the path in x.
struct Slide<T: Real> {
    /// Its spring's mean stretch over the path, with its derivative by the path's end.
    mean: T,
    mean_slope: T,
    /// Where it holds all the way, and else the part of the way on which it does.
    holds: T::Mask,
    held: T,
    /// It gives so far on the way that its switch counts as near.
    near: T::Mask,
    /// How far its switch is in x, at least.
    room: T,
}

impl<T: Real> Slide<T> {
    #[inline(always)]
    fn of(slider: &Slider<T>, memory: T, way: &Way<T>) -> Self {
        let (half, one) = (T::from_f64(0.5), T::ONE);
        let Way { from, to, length: d, .. } = way;
        let (e, slip) = (slider.start(memory, way), slider.slip);
        let (onward, bound) = (e + *d, slip * to.x);
        let (up, down) = (bound - onward, bound + onward);
        let holds = T::ZERO.le(up).and(T::ZERO.le(down));
        // One of them would be longer by 1/(1 - slip), the other shorter by 1/(1 + slip).
        let room = up.min(down * (one - slip));
        if holds.all() {
            let none = T::Mask::splat(false);
            return Slide { mean: e.add_product(half, *d), mean_slope: half, holds, held: one, near: none, room };
        }
        // The slider's bound along the path, per x, and the part of the way until it gives.
        let side = T::select(T::ZERO.le(*d), slip, -slip);
        let held = T::select(holds, one, (side * from.x - e) / T::select(holds, one, (one - side) * *d));
        let gives = one - held;
        let way = d.abs();
        Slide {
            mean: e.add_product(*d, half * held * held + gives * (held + half * side * gives)),
            mean_slope: half * (held * held + side * (one - held * held)),
            holds,
            held,
            near: holds.not().and((T::from_f64(EARLY) * way).le(held * held * from.x.max(to.x))),
            room: T::select(holds, room, way * gives),
        }
    }
}

/// The step's path in x, with what is measured of it.
struct Way<T> {
    kappa: T,
    /// x where the step starts.
    start: T,
    /// Where the part begins over which the force is a mean, and where it ends.
    from: Measure<T>,
    to: Measure<T>,
    /// How long that part is; negative where the felt opens.
    length: T,
    chord: Chord<T>,
    /// The mean is taken over the step's last part only: theta > 1/2.
    late: bool,
}

impl<T: Real> Way<T> {
    #[inline(always)]
    fn of(spring: &Spring<T>, pressing: &Pressing<'_, T>) -> Self {
        let (path, theta) = (pressing.path(), pressing.timing.theta);
        let late = !theta.le(T::from_f64(0.5)).all();
        let (from, to) = (Measure::of(spring, path.from), Measure::of(spring, path.to));
        let start = if late { Measure::of(spring, path.start).x } else { from.x };
        let chord = Chord::of(spring, &path, &from, &to);
        let kappa = spring.stiffness * inverse_power(spring);
        Way { kappa, start, length: to.x - from.x, from, to, chord, late }
    }
}

/// m = (r + 1)/2.
#[inline(always)]
fn half_power<T: Real>(spring: &Spring<T>) -> T {
    T::from_f64(0.5) * (spring.exponent.value() + T::ONE)
}

/// 1/m.
#[inline(always)]
fn inverse_power<T: Real>(spring: &Spring<T>) -> T {
    match spring.exponent {
        Exponent::Two => T::from_f64(1.0 / 1.5),
        Exponent::TwoAndHalf => T::from_f64(1.0 / 1.75),
        Exponent::Three => T::from_f64(0.5),
        Exponent::Other(_) => T::ONE / half_power(spring),
    }
}

/// x = g^m at a compression.
struct Measure<T> {
    /// The compression, not negative.
    g: T,
    x: T,
    /// dx/dg.
    slope: T,
    /// Its square root where r = 2, its fourth root where r = 2.5, else g^(m - 1).
    root: T,
}

impl<T: Real> Measure<T> {
    #[inline(always)]
    fn of(spring: &Spring<T>, compression: T) -> Self {
        let g = compression.max(T::ZERO);
        let m = half_power(spring);
        let (lower, root) = match spring.exponent {
            Exponent::Two => {
                let root = g.sqrt();
                (root, root)
            }
            Exponent::TwoAndHalf => {
                let square = g.sqrt();
                let root = square.sqrt();
                (square * root, root)
            }
            Exponent::Three => (g, g),
            Exponent::Other(_) => {
                let lower = g.powf(m - T::ONE);
                (lower, lower)
            }
        };
        Measure { g, x: g * lower, slope: m * lower, root }
    }

    /// The second derivative of k g^r, without another power: g^(r - 1) is the square of g^(m - 1).
    #[inline(always)]
    fn curvature(&self, spring: &Spring<T>) -> T {
        match spring.exponent {
            Exponent::Other(_) => spring.bent(spring.stiffness * self.root * self.root, self.g),
            _ => spring.at(self.g).curvature,
        }
    }
}

/// The mean of dx/dg over a path, and the part of the path that is touched, each with its derivative by the path's end.
struct Chord<T> {
    mean: T,
    slope: T,
    part: T,
    part_slope: T,
}

impl<T: Real> Chord<T> {
    /// Without a difference of nearly equal numbers: with roots a and b of the compressions, g = a^n and x = a^p, the
    /// mean is N/D, where N and D are a^p - b^p and a^n - b^n divided by a - b, and its derivative is what is left of
    /// dx/dg D - N when it is divided by a - b, over D^2.
    #[inline(always)]
    fn of(spring: &Spring<T>, path: &Path<T>, before: &Measure<T>, after: &Measure<T>) -> Self {
        let (one, half, c, tiny) = (T::ONE, T::from_f64(0.5), T::from_f64, T::from_f64(TINY));
        let (a, b) = (after.root, before.root);
        let (mean, slope) = match spring.exponent {
            Exponent::Two => {
                let inverse = one / (a + b).max(tiny);
                ((a * a + a * b + b * b) * inverse, half.add_product(half * b, inverse) * inverse)
            }
            Exponent::TwoAndHalf => {
                let (aa, ab, bb) = (a * a, a * b, b * b);
                let (aaa, bbb, squares) = (aa * a, bb * b, aa + bb);
                let inverse = one / ((a + b) * squares).max(tiny);
                let mean = (aa * aa + bb * bb) * squares + ab * (aa * squares + bb * bb);
                let rest = aaa * (c(0.75) * aa + c(1.5) * ab + c(2.25) * bb) + bbb * (c(3.0) * aa + c(2.0) * ab + bb);
                (mean * inverse, rest * inverse * inverse)
            }
            Exponent::Three => (after.g + before.g, one),
            Exponent::Other(_) => {
                let (way, sum) = (after.g - before.g, (after.g + before.g).max(tiny));
                let far = (cube_root_of_epsilon::<T>() * sum).lt(way.abs());
                let divisor = T::select(far, way, one);
                let mean = (after.x - before.x) / divisor;
                let slope = (after.slope - mean) / divisor;
                if far.all() {
                    (mean, slope)
                } else {
                    let middle = Measure::of(spring, half * sum);
                    let bend = (half_power(spring) - one) * middle.slope / middle.g.max(tiny);
                    (T::select(far, mean, middle.slope), T::select(far, slope, half * bend))
                }
            }
        };
        // Where the path begins or ends apart, only a part of it counts.
        let whole = T::ZERO.le(path.from).and(T::ZERO.le(path.to));
        if whole.all() {
            return Chord { mean, slope, part: one, part_slope: T::ZERO };
        }
        let way = path.to - path.from;
        let way = T::select(whole.or(T::ZERO.lt(way.abs()).not()), one, way);
        let part = T::select(whole, one, (after.g - before.g) / way);
        let part_slope = T::select(whole, T::ZERO, path.from.abs() / (way * way));
        Chord { mean: mean * part, slope: (slope * part).add_product(mean, part_slope), part, part_slope }
    }
}

/// The third root of the rounding: a difference over such a part of the numbers is as exact as its replacement by a
/// derivative.
#[inline(always)]
fn cube_root_of_epsilon<T: Real>() -> T {
    let is_double = T::EPSILON.lane(0).to_f64() < f64::from(f32::EPSILON);
    T::from_f64(if is_double { 6.055454452393343e-6 } else { 4.921566601151848e-3 })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn third_roots_of_both_precisions() {
        let near = |root: f64, epsilon: f64| (root * root * root - epsilon).abs() < 1e-6 * epsilon;
        assert!(near(cube_root_of_epsilon(), f64::EPSILON));
        assert!(near(f64::from(cube_root_of_epsilon::<f32>()), f64::from(f32::EPSILON)));
    }

    /// The second derivative without another power is the spring's own, for any exponent.
    #[test]
    fn curvature_is_the_springs() {
        for r in [1.5, 1.8, 2.0, 2.3, 2.5, 3.0, 3.4] {
            let spring = Spring { stiffness: 2e7, exponent: Exponent::new(r) };
            for g in [0.0, 1e-9, 1e-5, 7e-4] {
                let (found, own) = (Measure::of(&spring, g).curvature(&spring), spring.at(g).curvature);
                assert!((found - own).abs() <= 1e-14 * own, "{r} {g}: {found} {own}");
            }
        }
    }
}
