//! Data of the one-step problem: the linearised step, its set-valued laws, and the guess of each law's side.

use crate::linear::{Symmetric, product};
use crate::real::{Mask, Real, Scalar};

/// One linearised step in relative velocities.
#[derive(Debug, Clone)]
pub struct System<T, const B: usize, const N: usize> {
    /// Matrix A, symmetric positive definite.
    pub a: Symmetric<T, B>,
    /// Right-hand side b: the impulse of the step without set-valued laws, plus A w for the iterate w.
    pub b: [T; B],
    /// Impulse bound h c_d of each pivot; 0 without friction.
    pub pivot_bound: [T; B],
    /// Laws of sliding contacts, dry felts and a prescribed motion.
    pub sliding: [SlidingLaw<T, B>; N],
    /// Number of laws in use.
    pub count: usize,
}

/// Law of a sliding contact or a dry felt, or a prescribed velocity.
#[derive(Debug, Clone, Copy)]
pub struct SlidingLaw<T, const B: usize> {
    /// Jacobian row of the velocity u = row . w - target.
    pub row: [T; B],
    /// Imposed velocity; zero for friction.
    pub target: T,
    /// Bound of the impulse at w = 0.
    pub bound: T,
    /// Gradient of the bound in w.
    pub slope: [T; B],
    /// Whether the impulse has no bound, so that u = 0.
    pub rigid: bool,
}

/// Impulses of a system: the warm start before a solve, the solution after it.
#[derive(Debug, Clone, Copy)]
pub struct Impulses<T, const B: usize, const N: usize> {
    /// Impulse of each pivot.
    pub pivot: [T; B],
    /// Impulse of each sliding law.
    pub sliding: [T; N],
}

impl<T: Real, const B: usize, const N: usize> System<T, B, N> {
    pub(crate) fn new() -> Self {
        let z = T::ZERO;
        let law = SlidingLaw { row: [z; B], target: z, bound: z, slope: [z; B], rigid: false };
        System { a: Symmetric::zero(), b: [z; B], pivot_bound: [z; B], sliding: [law; N], count: 0 }
    }
}

impl<T: Real, const B: usize, const N: usize> System<T, B, N> {
    /// The velocity of a sliding law, m/s, where the joints move at `w`.
    pub(crate) fn slip(&self, law: usize, w: &[T; B]) -> T {
        let SlidingLaw { row, target, .. } = &self.sliding[law];
        product(row, w) - *target
    }
}

impl<T: Real, const B: usize, const N: usize> Impulses<T, B, N> {
    pub(crate) fn new() -> Self {
        Impulses { pivot: [T::ZERO; B], sliding: [T::ZERO; N] }
    }
}

impl<T: Real, const B: usize, const N: usize> System<T, B, N> {
    /// One lane's system.
    pub(crate) fn lane(&self, lane: usize) -> System<T::Lane, B, N> {
        System {
            a: self.a.lane(lane),
            b: self.b.map(|x| x.lane(lane)),
            pivot_bound: self.pivot_bound.map(|x| x.lane(lane)),
            sliding: self.sliding.map(|law| SlidingLaw {
                row: law.row.map(|x| x.lane(lane)),
                target: law.target.lane(lane),
                bound: law.bound.lane(lane),
                slope: law.slope.map(|x| x.lane(lane)),
                rigid: law.rigid,
            }),
            count: self.count,
        }
    }
}

impl<T: Real, const B: usize, const N: usize> Impulses<T, B, N> {
    /// One lane's impulses.
    pub(crate) fn lane(&self, lane: usize) -> Impulses<T::Lane, B, N> {
        Impulses { pivot: self.pivot.map(|x| x.lane(lane)), sliding: self.sliding.map(|x| x.lane(lane)) }
    }

    /// Sets one lane's impulses.
    pub(crate) fn set_lane(&mut self, lane: usize, one: &Impulses<T::Lane, B, N>) {
        for i in 0..B {
            self.pivot[i] = self.pivot[i].with_lane(lane, one.pivot[i]);
        }
        for k in 0..N {
            self.sliding[k] = self.sliding[k].with_lane(lane, one.sliding[k]);
        }
    }
}

/// Outcome of a solve.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct SolveReport {
    /// Whether the tolerance was met.
    pub converged: bool,
    /// Sweeps or active sets tried.
    pub iterations: u32,
}

/// Side of each law: 0 if it sticks, +1 or -1 if it slides with p = +bound or -bound.
#[derive(Debug, Clone)]
pub struct Guess<T: Real, const B: usize, const N: usize> {
    /// Side of each pivot; a pivot without dry friction never sticks.
    pub pivot: [T; B],
    /// Side of each sliding law.
    pub sliding: [T; N],
    /// Sliding laws whose bound falls to zero within the step, because the felt is left: p = 0, whatever the velocity.
    pub(crate) open: [T::Mask; N],
}

impl<T: Real, const B: usize, const N: usize> Guess<T, B, N> {
    pub(crate) fn new() -> Self {
        Guess { pivot: [T::ZERO; B], sliding: [T::ZERO; N], open: [T::Mask::splat(false); N] }
    }

    pub(super) fn lane(&self, lane: usize) -> Guess<T::Lane, B, N> {
        Guess {
            pivot: self.pivot.map(|x| x.lane(lane)),
            sliding: self.sliding.map(|x| x.lane(lane)),
            open: self.open.map(|x| x.lane(lane)),
        }
    }

    pub(super) fn set_lane(&mut self, lane: usize, one: &Guess<T::Lane, B, N>) {
        for i in 0..B {
            self.pivot[i] = self.pivot[i].with_lane(lane, one.pivot[i]);
        }
        for k in 0..N {
            self.sliding[k] = self.sliding[k].with_lane(lane, one.sliding[k]);
        }
    }
}

impl<T: Scalar, const B: usize, const N: usize> Guess<T, B, N> {
    /// What a solution's impulses say: a law at its bound slides.
    pub(crate) fn read(&mut self, system: &System<T, B, N>, impulses: &Impulses<T, B, N>) {
        for k in 0..system.count {
            let (law, p) = (&system.sliding[k], impulses.sliding[k]);
            let side = if p >= law.bound { T::ONE } else { -T::ONE };
            self.sliding[k] = if law.rigid || p.abs() < law.bound { T::ZERO } else { side };
        }
    }
}

/// Lane after lane, in those that are asked for, by a solver that knows one: its velocities, its impulses, and the
/// guess that follows from them. Says which lanes did not fail, and the most sweeps or active sets.
#[inline(always)]
pub(super) fn lane_by_lane<T: Real, const B: usize, const N: usize>(
    system: &System<T, B, N>,
    impulses: &mut Impulses<T, B, N>,
    guess: &mut Guess<T, B, N>,
    w: &mut [T; B],
    lanes: T::Mask,
    one: impl Fn(&System<T::Lane, B, N>, &mut Impulses<T::Lane, B, N>) -> ([T::Lane; B], SolveReport),
) -> (T::Mask, u32) {
    let (mut failed, mut most) = (T::ZERO, 0);
    for lane in 0..T::LANES {
        if !lanes.lane(lane) {
            continue;
        }
        let system = system.lane(lane);
        let (mut own, mut sides) = (impulses.lane(lane), guess.lane(lane));
        let (velocities, report) = one(&system, &mut own);
        sides.read(&system, &own);
        impulses.set_lane(lane, &own);
        guess.set_lane(lane, &sides);
        for i in 0..B {
            w[i] = w[i].with_lane(lane, velocities[i]);
        }
        if !report.converged {
            failed = failed.with_lane(lane, T::Lane::ONE);
        }
        most = most.max(report.iterations);
    }
    (failed.le(T::ZERO), most)
}
