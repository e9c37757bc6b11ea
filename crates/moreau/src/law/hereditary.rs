//! Stulov's hereditary felt, F = k/(1 - eps) (u - z) with u = g^r and dz/dt = (eps u - z)/tau, clamped at zero: (C8) of
//! the book. A. Stulov, *Hysteretic model of the grand piano hammer felt*, JASA 97 (1995) 2577-2585.
//!
//! A cold path: a mechanism without such felts pays nothing for it. `README.md`, "Felts with an internal state", has
//! the derivation.

use super::hook::{Law, MEMORY, Memory, Path, Pressing};
use super::number::{LAW_NUMBERS, LawNumber, Range};
use super::rate_part::{Form, RatePart};
use super::spring::{Curvature, Pressed, Spring, TINY};
use crate::real::{Mask, Real, Scalar, cast};
use crate::timing::Timing;

/// N; a felt whose memory is below this has forgotten, so that it comes to rest to the bit.
const FORGOTTEN: f64 = 1e-30;

/// F = k/(1 - eps) (u - z), u = g^r, dz/dt = (eps u - z)/tau (A. Stulov, JASA 97 (1995) 2577-2585). The spring's k is
/// the stiffness of a slow compression, k/(1 - eps) that of a quick one. The memory is Z = k z / (1 - eps), N.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hereditary<T> {
    /// eps, 1, below 1.
    pub relaxed: T,
    /// tau, s.
    pub time: T,
}

impl<T: Real> Law<T> for Hereditary<T> {
    const NUMBERS: &'static [LawNumber] = &[
        LawNumber::needed("relaxed", "relaxed", "1", Range::Part).loss().means(
            "Relaxing part eps of Stulov's hereditary felt, from 0 to below 1 (in files at most 0.99): the part of the \
             force of a quick compression that relaxes. k is the stiffness of a slow compression, k / (1 - eps) that \
             of a quick one. Requires `relaxation_ms`.",
        ),
        LawNumber::needed("time", "relaxation_ms", "ms", Range::Between(1e-9, 1e3))
            .units_per_si(1e3)
            .means("Time constant tau of the relaxation, ms. Requires `relaxed`."),
    ];
    const REMEMBERS: usize = 1;

    fn numbers(&self) -> [T; LAW_NUMBERS] {
        [self.relaxed, self.time, T::ZERO]
    }

    fn with([relaxed, time, _]: [T; LAW_NUMBERS]) -> Self {
        Hereditary { relaxed, time }
    }

    fn largest(&self) -> T {
        T::ONE / (T::ONE - self.relaxed)
    }

    fn effective_exponent(&self, _: T) -> T {
        T::from_f64(4.0) / (T::ONE - self.relaxed)
    }

    #[inline(always)]
    fn relax(&self, timing: &Timing<T>, memory: &Memory<T>) -> Memory<T> {
        let mut left = [T::ZERO; MEMORY];
        left[0] = forget(decay(timing.step / self.time).left * memory[0]);
        left
    }

    #[inline(always)]
    fn stored_energy(&self, spring: &Spring<T>, compression: T, memory: &Memory<T>) -> T {
        let (one, r, memory) = (T::ONE, spring.exponent.value(), memory[0]);
        // The felt's surface is where it pushes with no force, if what pressed it has left it behind. y: the
        // compression with which the memory would be at rest.
        let slow = spring.stiffness.max(T::from_f64(TINY));
        let quick = slow / (one - self.relaxed);
        let (root, power) = (one / r, r + one);
        let g = compression.max((memory / quick).powf(root));
        let y = (memory / (quick * self.relaxed).max(T::from_f64(TINY))).powf(root);
        let total = quick * g.powf(power) / power - memory * g + quick * self.relaxed * r * y.powf(power) / power;
        total - spring.stiffness * compression.max(T::ZERO).powf(power) / power
    }

    #[inline(always)]
    fn press(&self, spring: &Spring<T>, pressing: &Pressing<'_, T>, memory: &Memory<T>) -> Pressed<T> {
        self.relaxing(spring, pressing, memory).0
    }

    #[inline(always)]
    fn curvature(&self, spring: &Spring<T>, pressing: &Pressing<'_, T>, memory: &Memory<T>) -> Curvature<T> {
        self.relaxing(spring, pressing, memory).1
    }

    #[inline(always)]
    fn load_state(&self, spring: &Spring<T>, pressing: &Pressing<'_, T>, memory: &Memory<T>) -> Memory<T> {
        let fade = decay(pressing.timing.step / self.time);
        let mut after = [T::ZERO; MEMORY];
        after[0] = forget(self.after(&fade, spring, &pressing.path(), memory[0]));
        after
    }
}

impl<T: Real> Hereditary<T> {
    /// The memory after a step in which u = g^r runs linearly.
    #[inline(always)]
    fn after(&self, fade: &Decay<T>, spring: &Spring<T>, path: &Path<T>, memory: T) -> T {
        let quick = T::ONE / (T::ONE - self.relaxed);
        let [start, end] = [path.start, path.to].map(|g| quick * spring.at(g.max(T::ZERO)).force);
        fade.left * memory + self.relaxed * (start * fade.first + end * fade.last)
    }

    /// Exact where u = g^r runs linearly.
    #[inline(always)]
    fn relaxing(
        &self,
        spring: &Spring<T>,
        pressing: &Pressing<'_, T>,
        memory: &Memory<T>,
    ) -> (Pressed<T>, Curvature<T>) {
        let Pressing { compression, rate, timing, touched } = *pressing;
        let (path, memory) = (pressing.path(), memory[0]);
        let (relaxed, time) = (self.relaxed, self.time);
        let (half, one, two, tiny) = (T::from_f64(0.5), T::ONE, T::from_f64(2.0), T::from_f64(TINY));
        let quick = one / (one - relaxed);
        let elastic = |g: T| spring.at(g.max(T::ZERO));
        let offset = timing.node * rate;
        let (a, b) = (elastic(compression + offset), elastic(compression - offset));
        // Exact from end to end, so that the energy balance includes what the spring stores.
        let slow = RatePart::of(*spring, Form::Square(T::ZERO)).press_exactly(compression, rate, timing, touched);
        let (start, end) = (quick * elastic(path.start).force, elastic(path.to));
        let fade = decay(timing.step / time);
        let after = self.after(&fade, spring, &path, memory);
        let mean = fade.mean * memory + relaxed * (start * fade.mean_first + quick * end.force * fade.mean_last);
        // For theta > 1/2 the force is that of the step's later part.
        let late = two * timing.theta - one;
        let mean = (one - late) * mean + late * after;
        let by_end = relaxed * ((one - late) * fade.mean_last + late * fade.last);
        let force = quick * slow.force - mean;
        let pushing = touched.and(T::ZERO.lt(force));
        let only = |x: T| T::only(pushing, x);
        let (reach, h_theta) = (timing.h_theta + timing.node, timing.h_theta);
        let slope = quick * (slow.tangent / h_theta) - timing.step * quick * by_end * end.slope;
        let steep = a.max(&b).max(&end);
        let linear = (reach + timing.step) * quick * steep.slope;
        let pressed = Pressed {
            force: only(force),
            damping_force: T::only(touched, T::select(pushing, force, T::ZERO) - slow.force),
            tangent: only(h_theta * slope.max(T::ZERO)),
            opening: only(force) / linear.max(tiny),
        };
        let curvature = Curvature {
            linear,
            quadratic: half * quick * (reach * reach + timing.step * timing.step) * steep.curvature,
            slack: only(force),
        };
        (pressed, curvature)
    }
}

#[inline(always)]
fn forget<T: Real>(memory: T) -> T {
    T::only(T::from_f64(FORGOTTEN).lt(memory), memory)
}

/// What is left of z' = (eps u - z)/tau after h, where u runs linearly from u0 to u1: z1 = left z0 + eps (first u0 +
/// last u1), and its mean over h = mean z0 + eps (mean_first u0 + mean_last u1).
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
