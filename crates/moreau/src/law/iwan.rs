//! The papers' law, and beside it sliders in parallel: loading and unloading run along different curves, partial loops
//! run inside, and none of it depends on the speed. W. D. Iwan, *A distributed-element model for hysteresis and its
//! steady-state dynamic response*, Journal of Applied Mechanics 33 (1966) 893-900; here the sliders' bounds grow with
//! the felt's own force, for cloth and leather lose a part of it.
//!
//! Each of the four sliders bears a quarter of the loss, and they give one after the other: at a quarter, a half, three
//! quarters and the whole of `slip`. Pressed for the first time the felt pushes with (1 + eta) k g^r. In x =
//! g^((r+1)/2), let go from X, a slider i turns round at X (1 - s_i)/(1 + s_i), and pulls then with eta/4 of k g^r. The
//! loop between two depths closes on itself. An impact loses 2 eta / (1 + eta) of its energy, times the mean of (1 -
//! s_i)/(1 + s_i).

use super::hook::{Law, MEMORY, Memory, Pressing};
use super::number::{DAMPING, LAW_NUMBERS, LawNumber, Range};
use super::rate_part::Form;
use super::slider::{Slider, curvature, effective_exponent, load_state, press, stored_energy};
use super::spring::{Curvature, Pressed, Spring};
use crate::real::Real;

/// F = k g^r + b g^2 dg/dt, and four sliders in parallel, each with a quarter of eta (W. D. Iwan, J. Appl. Mech. 33
/// (1966) 893-900). The memory is the stretch of their springs, m^((r+1)/2), that of the slider first that gives first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Iwan<T> {
    /// b, N s/m3.
    pub damping: T,
    /// eta, 1, below 1: the sliders' bounds together, as a part of k g^r.
    pub eta: T,
    /// The stretch at which the last slider gives, as a part of x = g^((r+1)/2); 1, above 0 and below 1.
    pub slip: T,
}

impl<T: Real> Iwan<T> {
    #[inline(always)]
    fn sliders(&self) -> [Slider<T>; MEMORY] {
        let first = self.eta / self.slip;
        let mut sliders = [Slider { ratio: first, slip: self.slip }; MEMORY];
        for (i, slider) in sliders.iter_mut().enumerate() {
            let place = (i + 1) as f64;
            slider.ratio = T::from_f64(1.0 / place) * first;
            slider.slip = T::from_f64(place / MEMORY as f64) * self.slip;
        }
        sliders
    }
}

impl<T: Real> Law<T> for Iwan<T> {
    const NUMBERS: &'static [LawNumber] = &[
        DAMPING,
        LawNumber::needed("eta", "iwan_loss", "1", Range::Part).loss().means(
            "Loss eta of four sliders in parallel (Iwan's model), from 0 to below 1 (in files at most 0.99): the part \
             of k g^r by which the forces of loading and unloading differ from it, however slowly the felt moves. An \
             impact loses 2 eta / (1 + eta) of its energy, times the mean of (1 - s_i)/(1 + s_i) over the sliders' \
             slips s_i. Requires `iwan_slip`.",
        ),
        LawNumber::needed("slip", "iwan_slip", "1", Range::InnerPart).means(
            "Slip s of the last of the four sliders: the part of g^((r+1)/2) by which it yields before it slips, \
             above 0 and below 1 (in files from 0.001 to 0.99). The others slip at a quarter, a half and three \
             quarters of it. Requires `iwan_loss`.",
        ),
    ];
    const REMEMBERS: usize = MEMORY;

    fn numbers(&self) -> [T; LAW_NUMBERS] {
        [self.damping, self.eta, self.slip]
    }

    fn with([damping, eta, slip]: [T; LAW_NUMBERS]) -> Self {
        Iwan { damping, eta, slip }
    }

    fn rate_part(&self) -> Form<T> {
        Form::Square(self.damping)
    }

    fn largest(&self) -> T {
        T::ONE + self.eta
    }

    fn effective_exponent(&self, exponent: T) -> T {
        effective_exponent(&self.sliders(), exponent)
    }

    #[inline(always)]
    fn press(&self, spring: &Spring<T>, pressing: &Pressing<'_, T>, memory: &Memory<T>) -> Pressed<T> {
        press(&self.sliders(), self.damping, spring, pressing, memory)
    }

    #[inline(always)]
    fn curvature(&self, spring: &Spring<T>, pressing: &Pressing<'_, T>, memory: &Memory<T>) -> Curvature<T> {
        curvature(&self.sliders(), self.damping, spring, pressing, memory)
    }

    #[inline(always)]
    fn load_state(&self, spring: &Spring<T>, pressing: &Pressing<'_, T>, memory: &Memory<T>) -> Memory<T> {
        load_state(&self.sliders(), spring, pressing, memory)
    }

    #[inline(always)]
    fn stored_energy(&self, spring: &Spring<T>, _: T, memory: &Memory<T>) -> T {
        stored_energy(&self.sliders(), spring, memory)
    }
}

#[cfg(test)]
mod tests {
    use super::super::Exponent;
    use super::*;
    use crate::timing::Timing;

    const LAW: Iwan<f64> = Iwan { damping: 0.0, eta: 0.4, slip: 0.3 };
    const SLIPS: [f64; 4] = [0.075, 0.15, 0.225, 0.3];
    /// N/m^r, and r.
    const SPRING: Spring<f64> = Spring { stiffness: 5e7, exponent: Exponent::Two };

    /// The work that goes in, J, on a straight way in g, and the memory after it.
    fn go(from: f64, to: f64, memory: &mut Memory<f64>) -> f64 {
        let (timing, steps) = (Timing::new(50e-6, 0.5), 100);
        let mut work = 0.0;
        for k in 0..steps {
            let at = |k: i32| from + (to - from) * f64::from(k) / f64::from(steps);
            let (compression, rate) = (0.5 * (at(k) + at(k + 1)), (at(k + 1) - at(k)) / 50e-6);
            let pressing = Pressing { compression, rate, timing: &timing, touched: true };
            work += LAW.press(&SPRING, &pressing, memory).force * (at(k + 1) - at(k));
            *memory = LAW.load_state(&SPRING, &pressing, memory);
        }
        work
    }

    /// The force just there, N: a way of a nanometre, onward or back.
    fn force(compression: f64, back: bool, memory: &Memory<f64>) -> f64 {
        let timing = Timing::new(50e-6, 0.5);
        let rate = if back { -2e-8 } else { 2e-8 };
        let pressing = Pressing { compression: compression + 25e-6 * rate, rate, timing: &timing, touched: true };
        LAW.press(&SPRING, &pressing, memory).force
    }

    /// Loading for the first time and unloading to where every slider has turned: k g^r (1 +- eta). Between them slider
    /// i is stretched by s_i X - (X - x).
    #[test]
    fn the_branches_are_the_written_ones() {
        let (deepest, k, m) = (1e-3, 5e7, 1.5);
        let mut memory = [0.0; MEMORY];
        go(0.0, deepest, &mut memory);
        let near =
            |found: f64, expected: f64| assert!((found - expected).abs() < 1e-5 * expected, "{found} {expected}");
        near(force(deepest, false, &memory), k * 1e-6 * 1.4);
        let x = |g: f64| g * g.sqrt();
        for depth in [0.95, 0.8, 0.6, 0.3].map(|part| part * deepest) {
            let mut memory = memory;
            go(deepest, depth, &mut memory);
            // Per kappa = k/m; dx/dg = m sqrt(g).
            let stretched: f64 =
                SLIPS.iter().map(|s| 0.1 / s * (s * x(deepest) - (x(deepest) - x(depth))).max(-(s * x(depth)))).sum();
            near(force(depth, true, &memory), k / m * (x(depth) + stretched) * m * depth.sqrt());
        }
        go(deepest, 0.3 * deepest, &mut memory);
        near(force(0.3 * deepest, true, &memory), k * 9e-8 * 0.6);
    }

    /// A partial loop comes back to where it left the branch, force and memory, and loses what its sliders slid.
    #[test]
    fn partial_loops_close() {
        let (deepest, kappa) = (1e-3, 5e7 / 1.5);
        let x = |g: f64| libm::pow(g, 1.5);
        let top = x(deepest);
        for depth in [0.95, 0.7, 0.4].map(|part| part * deepest) {
            let mut memory = [0.0; MEMORY];
            go(0.0, deepest, &mut memory);
            let before = memory;
            let lost = go(deepest, depth, &mut memory) + go(depth, deepest, &mut memory);
            for (e, was) in memory.iter().zip(before) {
                assert!((e - was).abs() < 1e-12 * was, "{depth}: {memory:?} {before:?}");
            }
            // Slider i slides from x_i down to x_r with bound eta kappa x, and on the way back from x_u up: (1 +- s)
            // per x.
            let slid: f64 = SLIPS
                .iter()
                .map(|s| {
                    let (turned, low) = (top * (1.0 - s) / (1.0 + s), x(depth));
                    if low >= turned {
                        return 0.0;
                    }
                    let again = low * (1.0 + s) / (1.0 - s);
                    let down = (1.0 + s) * (turned * turned - low * low);
                    0.5 * 0.1 * kappa * (down + (1.0 - s) * (top * top - again * again))
                })
                .sum();
            assert!((lost - slid).abs() < 1e-10 * kappa * top * top, "{depth}: {lost} {slid}");
        }
    }
}
