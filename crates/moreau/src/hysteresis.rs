//! Felts that remember: laws whose force depends on what was done to the felt before. Each carries one number from step to step, its memory.
//!
//! A cold path: a mechanism without such felts pays nothing for it. `README.md`, "Felts that remember", has the derivations.

use crate::felt::{Curvature, Elastic, Exponent, Loss, Pressed, TINY};
use crate::real::{Mask, Real, Scalar, cast};
use crate::timing::Timing;

/// N; a hereditary felt whose memory is below this has forgotten, so that it comes to rest to the bit.
const FORGOTTEN: f64 = 1e-30;

/// A law with memory, as the step reads it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Remembering<T> {
    stiffness: T,
    exponent: Exponent<T>,
    kind: Kind<T>,
}

#[derive(Debug, Clone, Copy)]
enum Kind<T> {
    /// See [`Loss::Elastoplastic`]. The memory is the spring's stretch e, m^((r+1)/2).
    Elastoplastic { damping: T, eta: T, slip: T },
    /// See [`Loss::Hereditary`]. The memory is Z = k z / (1 - eps), N.
    Hereditary { relaxed: T, time: T },
}

/// What a felt with memory does during a step.
pub(crate) struct Recalled<T> {
    pub pressed: Pressed<T>,
    /// The memory at the step's end.
    pub memory: T,
    /// By how much the energy that the memory holds has grown, J: what the damping force did beyond that is lost.
    pub gained: T,
}

/// The compression's straight path in a step, m.
struct Path<T> {
    /// At the step's start.
    start: T,
    /// Where the part begins over which the force is a mean: for theta = 1/2 the start, for theta = 1 the end.
    from: T,
    /// At the step's end.
    to: T,
}

impl<T: Real> Path<T> {
    #[inline(always)]
    fn of(compression: T, rate: T, timing: &Timing<T>) -> Self {
        let half = timing.step - timing.h_theta;
        Path {
            start: compression.sub_product(timing.h_theta, rate),
            from: compression.sub_product(half, rate),
            to: compression.add_product(half, rate),
        }
    }
}

impl<T: Real> Remembering<T> {
    /// `None` for a loss without memory.
    pub(crate) fn of(stiffness: T, exponent: Exponent<T>, loss: Loss<T>) -> Option<Self> {
        let kind = match loss {
            Loss::Elastoplastic { damping, eta, slip } => Kind::Elastoplastic { damping, eta, slip },
            Loss::Hereditary { relaxed, time } => Kind::Hereditary { relaxed, time },
            Loss::Quadratic(_) | Loss::HuntCrossley(_) | Loss::SetValued { .. } => return None,
        };
        Some(Remembering { stiffness, exponent, kind })
    }

    /// Force, tangent and what the tangent leaves out, at a compression and rate of the theta point, from the memory at the step's start.
    #[inline(always)]
    pub(crate) fn press(&self, compression: T, rate: T, timing: &Timing<T>, touched: T::Mask, memory: T) -> Pressed<T> {
        self.recall(compression, rate, timing, touched, memory).pressed
    }

    /// [`Remembering::press`], and what becomes of the memory.
    #[cold]
    #[inline(never)]
    pub(crate) fn recall(
        &self,
        compression: T,
        rate: T,
        timing: &Timing<T>,
        touched: T::Mask,
        memory: T,
    ) -> Recalled<T> {
        let path = Path::of(compression, rate, timing);
        match self.kind {
            Kind::Elastoplastic { damping, eta, slip } => {
                self.slide([damping, eta, slip], &path, rate, timing, touched, memory)
            }
            Kind::Hereditary { relaxed, time } => {
                self.relax(relaxed, time, &path, compression, rate, timing, touched, memory)
            }
        }
    }

    /// The memory of a felt that was not touched in a step, and by how much the energy that it holds has grown, J.
    #[inline(always)]
    pub(crate) fn left_alone(&self, timing: &Timing<T>, memory: T) -> (T, T) {
        let after = match self.kind {
            Kind::Elastoplastic { .. } => T::ZERO,
            Kind::Hereditary { time, .. } => forget(decay(timing.step / time).left * memory),
        };
        (after, self.held(T::ZERO, after) - self.held(T::ZERO, memory))
    }

    /// The energy that the memory holds beyond the elastic k g^(r+1)/(r+1), J.
    pub(crate) fn held(&self, compression: T, memory: T) -> T {
        let (one, r) = (T::ONE, self.exponent.value());
        match self.kind {
            Kind::Elastoplastic { eta, slip, .. } => {
                let spring = self.slider_spring(eta, slip);
                T::from_f64(0.5) * spring * memory * memory
            }
            Kind::Hereditary { relaxed, .. } => {
                // The felt's surface is where it pushes with no force, if what pressed it has left it behind. y: the compression with which
                // the memory would be at rest.
                let slow = self.stiffness.max(T::from_f64(TINY));
                let quick = slow / (one - relaxed);
                let (root, power) = (one / r, r + one);
                let g = compression.max((memory / quick).powf(root));
                let y = (memory / (quick * relaxed).max(T::from_f64(TINY))).powf(root);
                let total = quick * g.powf(power) / power - memory * g + quick * relaxed * r * y.powf(power) / power;
                total - self.stiffness * compression.max(T::ZERO).powf(power) / power
            }
        }
    }

    /// K of the spring in series with the slider, per x^2.
    #[inline(always)]
    fn slider_spring(&self, eta: T, slip: T) -> T {
        eta * self.stiffness / (self.half_power() * slip)
    }

    /// m = (r + 1)/2.
    #[inline(always)]
    fn half_power(&self) -> T {
        T::from_f64(0.5) * (self.exponent.value() + T::ONE)
    }

    /// The elastoplastic element. In x = g^m, m = (r + 1)/2, the felt is a spring of stiffness kappa = k/m beside a spring K = eta kappa / slip in
    /// series with a slider of bound eta kappa x: all straight lines. On the step's path, which is monotonous, their work is worked out exactly;
    /// the force is that work over the way, so that no step of any length gives energy.
    #[inline(always)]
    fn slide(
        &self,
        [damping, eta, slip]: [T; 3],
        path: &Path<T>,
        rate: T,
        timing: &Timing<T>,
        touched: T::Mask,
        memory: T,
    ) -> Recalled<T> {
        let (half, one, two, tiny) = (T::from_f64(0.5), T::ONE, T::from_f64(2.0), T::from_f64(TINY));
        let m = self.half_power();
        let (kappa, spring) = (self.stiffness / m, self.slider_spring(eta, slip));
        let x0 = self.measure(path.start).x;
        let (before, after) = (self.measure(path.from), self.measure(path.to));
        let (xa, x1) = (before.x, after.x);
        let within = |e: T, x: T| e.max(-(slip * x)).min(slip * x);
        let start = within(memory, x0);
        let ea = within(start + (xa - x0), xa);
        let d = x1 - xa;
        // The slider's bound along the path, per x; how far x goes until the slider gives; and the part of the way until then.
        let side = T::select(T::ZERO.le(d), slip, -slip);
        let until = (side * xa - ea) / (one - side);
        let holds = d.abs().le(until.abs());
        let held = T::select(holds, one, until / T::select(holds, one, d));
        let gives = one - held;
        let end = within(ea + d, x1);
        let mean = ea.add_product(d, half * held * held + gives * (held + half * side * gives));
        let mean_slope = half * (held * held + side * (one - held * held));
        let chord = self.chord(path, &before, &after);
        // The mean force in x and its parts in g.
        let total = (half * kappa * (xa + x1)).add_product(spring, mean);
        let slope = (chord.mean * after.slope * (half * kappa + spring * mean_slope)).add_product(total, chord.slope);
        let reach = two * timing.h_theta;
        // The papers' b, with the mean of g^2 over the path.
        let (ga, g1, third) = (before.g, after.g, T::from_f64(1.0 / 3.0));
        let square = third * (ga * ga + ga * g1 + g1 * g1);
        let viscous = damping * square * chord.part;
        let by_depth = damping * rate * (third * (ga + two * g1) * chord.part).add_product(square, chord.part_slope);
        let slope = (reach * (slope + by_depth) + viscous).max(T::ZERO);
        let force = (total * chord.mean).add_product(viscous, rate);
        let pushing = touched.and(T::ZERO.lt(force));
        let only = |x: T| T::only(touched, x);
        // What the tangent leaves out: second derivatives of the felt while slider or spring hold, and the bend where the slider gives.
        let elastic = before.elastic.max(&after.elastic);
        let (r, ratio) = (self.exponent.value(), eta / slip);
        let steepest = elastic.slope / r * (m * (one + ratio) + (m - one) * (one + eta));
        let stretch = (one + slip) * (one + slip) / (one - slip);
        let bend = elastic.curvature * (one + ratio * (one + half * (m - two).abs() * stretch / r));
        let mixed = holds.not().and(T::ZERO.lt(held));
        let knee = chord.mean * spring * after.slope * after.slope * held * held * (one + slip) / d.abs().max(tiny);
        let knee = T::only(mixed, knee);
        let up = (slip * xa - ea) / (one - slip) - d;
        let down = d + (slip * xa + ea) / (one + slip);
        let room = T::select(holds, up.min(down), d.abs() - until.abs());
        let room = room / (reach * before.slope.max(after.slope)).max(tiny);
        let deepest = ga.max(g1);
        let speed = damping * rate.abs();
        let linear = reach * (steepest + two * speed * deepest) + damping * deepest * deepest;
        let bend = half * reach * (reach * (bend + knee + two * speed) + T::from_f64(4.0) * damping * deepest);
        // How far the clamp is, and the slider's switch.
        let (clamp, switch) = (T::only(pushing, force), half * linear * room);
        let late = mixed.and(timing.theta.le(half).not());
        // What the clamp leaves of the loss undoes the stiffness.
        let elastic = half * kappa * (xa + x1) * chord.mean;
        Recalled {
            pressed: Pressed {
                force: clamp,
                damping_force: only(clamp - elastic),
                tangent: T::only(pushing, timing.h_theta * slope),
                curvature: Curvature { linear, quadratic: bend, slack: T::select(late, T::ZERO, switch.min(clamp)) },
                opening: T::select(mixed, T::ZERO, room.min(clamp / linear.max(tiny))),
            },
            memory: only(end),
            gained: half * spring * (only(end) * only(end) - memory * memory),
        }
    }

    /// x = g^m with its derivative, and the elastic force there.
    #[inline(always)]
    fn measure(&self, compression: T) -> Measure<T> {
        let g = compression.max(T::ZERO);
        let elastic = Elastic::of(self.stiffness, &self.exponent, g);
        let m = self.half_power();
        let (x, slope, root) = match self.exponent {
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
    fn chord(&self, path: &Path<T>, before: &Measure<T>, after: &Measure<T>) -> Chord<T> {
        let (one, half, tiny) = (T::ONE, T::from_f64(0.5), T::from_f64(TINY));
        let (a, b) = (after.root, before.root);
        let (mean, slope) = match self.exponent {
            Exponent::Two => {
                let sum = (a + b).max(tiny);
                ((a * a + a * b + b * b) / sum, (a + b + b) / (sum * sum) * half)
            }
            Exponent::Three => (after.g + before.g, one),
            Exponent::TwoAndHalf | Exponent::Other(_) => {
                let (way, sum) = (after.g - before.g, (after.g + before.g).max(tiny));
                let far = (cube_root_of_epsilon::<T>() * sum).lt(way.abs());
                let divisor = T::select(far, way, one);
                let middle = self.measure(half * sum);
                let m = self.half_power();
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

    /// Stulov's hereditary felt, exact where u = g^r runs linearly.
    #[inline(always)]
    #[allow(clippy::too_many_arguments)]
    fn relax(
        &self,
        relaxed: T,
        time: T,
        path: &Path<T>,
        compression: T,
        rate: T,
        timing: &Timing<T>,
        touched: T::Mask,
        memory: T,
    ) -> Recalled<T> {
        let (half, one, two, tiny) = (T::from_f64(0.5), T::ONE, T::from_f64(2.0), T::from_f64(TINY));
        let quick = one / (one - relaxed);
        let elastic = |g: T| Elastic::of(self.stiffness, &self.exponent, g.max(T::ZERO));
        let offset = timing.node * rate;
        let (a, b) = (elastic(compression + offset), elastic(compression - offset));
        let slow = half * (a.force + b.force);
        let (start, end) = (quick * elastic(path.start).force, elastic(path.to));
        let fade = decay(timing.step / time);
        let after = fade.left * memory + relaxed * (start * fade.first + quick * end.force * fade.last);
        let mean = fade.mean * memory + relaxed * (start * fade.mean_first + quick * end.force * fade.mean_last);
        // For theta > 1/2 the force is that of the step's later part.
        let late = two * timing.theta - one;
        let mean = (one - late) * mean + late * after;
        let by_end = relaxed * ((one - late) * fade.mean_last + late * fade.last);
        let force = quick * slow - mean;
        let pushing = touched.and(T::ZERO.lt(force));
        let only = |x: T| T::only(pushing, x);
        let (reach, h_theta, node) = (timing.h_theta + timing.node, timing.h_theta, timing.node);
        let slope = half * quick * (reach * a.slope).add_product(h_theta - node, b.slope)
            - timing.step * quick * by_end * end.slope;
        let steep = a.max(&b).max(&end);
        let linear = (reach + timing.step) * quick * steep.slope;
        let memory_after = forget(after);
        Recalled {
            pressed: Pressed {
                force: only(force),
                damping_force: T::only(touched, T::select(pushing, force, T::ZERO) - slow),
                tangent: only(h_theta * slope.max(T::ZERO)),
                curvature: Curvature {
                    linear,
                    quadratic: half * quick * (reach * reach + timing.step * timing.step) * steep.curvature,
                    slack: only(force),
                },
                opening: only(force) / linear.max(tiny),
            },
            memory: memory_after,
            gained: self.held(path.to, memory_after) - self.held(path.start, memory),
        }
    }
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

/// The third root of the rounding: a difference over such a part of the numbers is as exact as its replacement by a derivative.
#[inline(always)]
fn cube_root_of_epsilon<T: Real>() -> T {
    T::EPSILON.powf(T::from_f64(1.0 / 3.0))
}

#[inline(always)]
fn forget<T: Real>(memory: T) -> T {
    T::only(T::from_f64(FORGOTTEN).lt(memory), memory)
}

/// What is left of z' = (eps u - z)/tau after h, where u runs linearly from u0 to u1: z1 = left z0 + eps (first u0 + last u1), and its mean over h
/// = mean z0 + eps (mean_first u0 + mean_last u1).
#[derive(Clone, Copy)]
struct Decay<T> {
    left: T,
    first: T,
    last: T,
    mean: T,
    mean_first: T,
    mean_last: T,
}

/// At x = h/tau.
#[inline(always)]
fn decay<T: Real>(x: T) -> Decay<T> {
    let o = T::ZERO;
    let mut all = Decay { left: o, first: o, last: o, mean: o, mean_first: o, mean_last: o };
    for lane in 0..T::LANES {
        let one = decay_of(x.lane(lane).to_f64());
        let set = |all: &mut T, one: f64| *all = all.with_lane(lane, cast(one));
        set(&mut all.left, one.left);
        set(&mut all.first, one.first);
        set(&mut all.last, one.last);
        set(&mut all.mean, one.mean);
        set(&mut all.mean_first, one.mean_first);
        set(&mut all.mean_last, one.mean_last);
    }
    all
}

fn decay_of(x: f64) -> Decay<f64> {
    let gone = -libm::expm1(-x);
    let left = 1.0 - gone;
    // (1 - e^-x)/x and (1 - that)/x: by series where they are differences.
    let mean = if x > 0.0 { gone / x } else { 1.0 };
    let last = if x < 0.02 {
        x * (1.0 / 2.0 - x * (1.0 / 6.0 - x * (1.0 / 24.0 - x * (1.0 / 120.0 - x / 720.0))))
    } else {
        1.0 - mean
    };
    let mean_last = if x < 0.02 {
        x * (1.0 / 6.0 - x * (1.0 / 24.0 - x * (1.0 / 120.0 - x * (1.0 / 720.0 - x / 5040.0))))
    } else {
        0.5 - last / x
    };
    Decay { left, first: gone - last, last, mean, mean_first: last - mean_last, mean_last }
}
