//! Sliders: springs in series with dry friction, beside the spring of a felt. What laws with rate-independent loss are
//! made of.
//!
//! In x = g^m, m = (r + 1)/2, the felt is a spring of stiffness kappa = k/m; beside it stand springs K = eta kappa /
//! slip, each in series with a slider of bound eta kappa x: all straight lines. On the step's path, which is
//! monotonous, their work is worked out exactly; the force is that work over the way, so that no step of any length
//! gives energy. `README.md`, "Felts with an internal state", has the derivation.

use super::hook::{MEMORY, Memory, Path, Pressing, Recalled};
use super::spring::{Curvature, Elastic, Exponent, Pressed, Spring, TINY};
use crate::real::{Mask, Real};

/// A spring in series with a slider. Its memory is the spring's stretch e, m^((r+1)/2).
#[derive(Debug, Clone, Copy)]
pub(crate) struct Slider<T> {
    /// The slider's bound as a part of k g^r.
    pub eta: T,
    /// The spring's stretch at which the slider gives, as a part of x.
    pub slip: T,
}

impl<T: Real> Slider<T> {
    /// K over kappa.
    #[inline(always)]
    fn ratio(&self) -> T {
        self.eta / self.slip
    }

    /// A factor in the bound of its bend (README, "Felts with an internal state").
    #[inline(always)]
    fn stretch(&self) -> T {
        (T::ONE + self.slip) * (T::ONE + self.slip) / (T::ONE - self.slip)
    }
}

/// How much more sharply than the spring a felt with sliders may bend, for the exponent r.
pub(crate) fn sharper<T: Real>(sliders: &[Slider<T>], r: T) -> T {
    let (one, c) = (T::ONE, T::from_f64);
    let mut sum = one;
    for slider in sliders {
        sum += slider.ratio() * (one + c(0.25) * (r - c(3.0)).abs() * slider.stretch() / r);
    }
    sum
}

/// The energy in the sliders' springs, J.
pub(crate) fn held<T: Real>(sliders: &[Slider<T>], spring: &Spring<T>, memory: &Memory<T>) -> T {
    let kappa = spring.stiffness / half_power(spring);
    let mut sum = T::ZERO;
    for (slider, e) in sliders.iter().zip(memory) {
        sum += T::from_f64(0.5) * (slider.ratio() * kappa) * *e * *e;
    }
    sum
}

/// m = (r + 1)/2.
#[inline(always)]
fn half_power<T: Real>(spring: &Spring<T>) -> T {
    T::from_f64(0.5) * (spring.exponent.value() + T::ONE)
}

/// What one slider does on the path in x.
struct Slide<T: Real> {
    /// The spring's stretch at the path's end and its mean over the path, with its derivative by the path's end.
    end: T,
    mean: T,
    mean_slope: T,
    /// The part of the way on which the slider holds, where it holds at first and gives then.
    held: T,
    mixed: T::Mask,
    /// How far in x its switch is.
    room: T,
}

impl<T: Real> Slide<T> {
    /// From a stretch at x0, where the step starts, over the path from xa to x1.
    #[inline(always)]
    fn of(slip: T, memory: T, [x0, xa, x1]: [T; 3]) -> Self {
        let (half, one) = (T::from_f64(0.5), T::ONE);
        let within = |e: T, x: T| e.max(-(slip * x)).min(slip * x);
        let start = within(memory, x0);
        let ea = within(start + (xa - x0), xa);
        let d = x1 - xa;
        // The slider's bound along the path, per x; how far x goes until the slider gives; and the part of the way
        // until then.
        let side = T::select(T::ZERO.le(d), slip, -slip);
        let until = (side * xa - ea) / (one - side);
        let holds = d.abs().le(until.abs());
        let held = T::select(holds, one, until / T::select(holds, one, d));
        let gives = one - held;
        let mean = ea.add_product(d, half * held * held + gives * (held + half * side * gives));
        let mean_slope = half * (held * held + side * (one - held * held));
        let up = (slip * xa - ea) / (one - slip) - d;
        let down = d + (slip * xa + ea) / (one + slip);
        let room = T::select(holds, up.min(down), d.abs() - until.abs());
        Slide { end: within(ea + d, x1), mean, mean_slope, held, mixed: holds.not().and(T::ZERO.lt(held)), room }
    }
}

/// A felt with sliders and b beside its spring, from the memory at the step's start.
pub(crate) fn slide<T: Real>(
    sliders: &[Slider<T>],
    damping: T,
    spring: &Spring<T>,
    pressing: &Pressing<'_, T>,
    memory: &Memory<T>,
) -> Recalled<T> {
    let (half, one, two, tiny) = (T::from_f64(0.5), T::ONE, T::from_f64(2.0), T::from_f64(TINY));
    let Pressing { rate, timing, touched, .. } = *pressing;
    let path = pressing.path();
    let m = half_power(spring);
    let kappa = spring.stiffness / m;
    let x0 = measure(spring, path.start).x;
    let (before, after) = (measure(spring, path.from), measure(spring, path.to));
    let (xa, x1) = (before.x, after.x);
    let way = (x1 - xa).abs();
    let chord = chord(spring, &path, &before, &after);
    let (elastic, r) = (before.elastic.max(&after.elastic), spring.exponent.value());
    // The mean force in x and its slope, what is in the springs, and what the tangent leaves out: second derivatives of
    // the felt while slider or spring hold, and the bend where a slider gives.
    let (mut total, mut slope) = (half * kappa * (xa + x1), half * kappa);
    let (mut gained, mut ratios, mut bounds, mut bends, mut knee) = (T::ZERO, one, one, one, T::ZERO);
    let (mut room, mut mixed) = (T::from_f64(super::spring::FAR), T::Mask::splat(false));
    let mut kept = [T::ZERO; MEMORY];
    for ((slider, &e), kept) in sliders.iter().zip(memory).zip(&mut kept) {
        let stiffness = slider.ratio() * kappa;
        let slid = Slide::of(slider.slip, e, [x0, xa, x1]);
        total = total.add_product(stiffness, slid.mean);
        slope = slope.add_product(stiffness, slid.mean_slope);
        *kept = T::only(touched, slid.end);
        gained += half * stiffness * (*kept * *kept - e * e);
        ratios += slider.ratio();
        bounds += slider.eta;
        bends += slider.ratio() * (one + half * (m - two).abs() * slider.stretch() / r);
        knee += T::only(slid.mixed, stiffness * slid.held * slid.held * (one + slider.slip));
        room = room.min(slid.room);
        mixed = mixed.or(slid.mixed);
    }
    let slope = (chord.mean * after.slope * slope).add_product(total, chord.slope);
    let reach = two * timing.h_theta;
    // The papers' b, with the mean of g^2 over the path.
    let (ga, g1, third) = (before.g, after.g, T::from_f64(1.0 / 3.0));
    let square = third * (ga * ga + ga * g1 + g1 * g1);
    let viscous = damping * square * chord.part;
    let by_depth = damping * rate * (third * (ga + two * g1) * chord.part).add_product(square, chord.part_slope);
    let slope = (reach * (slope + by_depth) + viscous).max(T::ZERO);
    let force = (total * chord.mean).add_product(viscous, rate);
    let pushing = touched.and(T::ZERO.lt(force));
    let steepest = elastic.slope / r * (m * ratios + (m - one) * bounds);
    let bend = elastic.curvature * bends;
    let knee = T::only(mixed, chord.mean * after.slope * after.slope * knee / way.max(tiny));
    let room = room / (reach * before.slope.max(after.slope)).max(tiny);
    let deepest = ga.max(g1);
    let speed = damping * rate.abs();
    let linear = reach * (steepest + two * speed * deepest) + damping * deepest * deepest;
    let bend = half * reach * (reach * (bend + knee + two * speed) + T::from_f64(4.0) * damping * deepest);
    // How far the clamp is, and the nearest slider's switch.
    let (clamp, switch) = (T::only(pushing, force), half * linear * room);
    // For theta above 1/2 the memory at the path's beginning goes along with the rate. The tangent does not know that:
    // what it leaves out is of first order, which a slack of zero says.
    let late = timing.theta.le(half).not();
    // What the clamp leaves of the loss undoes the stiffness.
    let stored = half * kappa * (xa + x1) * chord.mean;
    Recalled {
        pressed: Pressed {
            force: clamp,
            damping_force: T::only(touched, clamp - stored),
            tangent: T::only(pushing, timing.h_theta * slope),
            curvature: Curvature { linear, quadratic: bend, slack: T::select(late, T::ZERO, switch.min(clamp)) },
            opening: T::select(mixed, T::ZERO, room.min(clamp / linear.max(tiny))),
        },
        memory: kept,
        gained,
    }
}

/// x = g^m with its derivative, and the elastic force there.
#[inline(always)]
fn measure<T: Real>(spring: &Spring<T>, compression: T) -> Measure<T> {
    let g = compression.max(T::ZERO);
    let elastic = spring.at(g);
    let m = half_power(spring);
    let (x, slope, root) = match spring.exponent {
        Exponent::Two => {
            let root = g.sqrt();
            (g * root, m * root, root)
        }
        Exponent::TwoAndHalf => {
            let root = g.sqrt();
            let lower = root * root.sqrt();
            (g * lower, m * lower, root)
        }
        Exponent::Three => (g * g, m * g, g),
        Exponent::Other(_) => {
            let lower = g.powf(m - T::ONE);
            (g * lower, m * lower, g)
        }
    };
    Measure { g, x, slope, root, elastic }
}

/// See [`Chord`], without a difference of nearly equal numbers.
#[inline(always)]
fn chord<T: Real>(spring: &Spring<T>, path: &Path<T>, before: &Measure<T>, after: &Measure<T>) -> Chord<T> {
    let (one, half, tiny) = (T::ONE, T::from_f64(0.5), T::from_f64(TINY));
    let (a, b) = (after.root, before.root);
    let (mean, slope) = match spring.exponent {
        Exponent::Two => {
            let sum = (a + b).max(tiny);
            ((a * a + a * b + b * b) / sum, (a + b + b) / (sum * sum) * half)
        }
        Exponent::Three => (after.g + before.g, one),
        Exponent::TwoAndHalf | Exponent::Other(_) => {
            let (way, sum) = (after.g - before.g, (after.g + before.g).max(tiny));
            let far = (cube_root_of_epsilon::<T>() * sum).lt(way.abs());
            let divisor = T::select(far, way, one);
            let middle = measure(spring, half * sum);
            let m = half_power(spring);
            let bend = (m - one) * middle.slope / middle.g.max(tiny);
            let mean = T::select(far, (after.x - before.x) / divisor, middle.slope);
            (mean, T::select(far, (after.slope - mean) / divisor, half * bend))
        }
    };
    // Where the path begins or ends apart, only a part of it counts.
    let whole = T::ZERO.le(path.from).and(T::ZERO.le(path.to));
    let way = path.to - path.from;
    let way = T::select(whole.or(T::ZERO.lt(way.abs()).not()), one, way);
    let part = T::select(whole, one, (after.g - before.g) / way);
    let part_slope = T::select(whole, T::ZERO, path.from.abs() / (way * way));
    Chord { mean: mean * part, slope: (slope * part).add_product(mean, part_slope), part, part_slope }
}

/// x = g^m at a compression.
struct Measure<T> {
    /// The compression, not negative.
    g: T,
    x: T,
    slope: T,
    /// Its square root where r = 2, else of no use.
    root: T,
    elastic: Elastic<T>,
}

/// The mean of dx/dg over a path, and the part of the path that is touched, each with its derivative by the path's end.
struct Chord<T> {
    mean: T,
    slope: T,
    part: T,
    part_slope: T,
}

/// The third root of the rounding: a difference over such a part of the numbers is as exact as its replacement by a
/// derivative.
#[inline(always)]
fn cube_root_of_epsilon<T: Real>() -> T {
    T::EPSILON.powf(T::from_f64(1.0 / 3.0))
}
