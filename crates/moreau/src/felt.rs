//! The felt law: everything that the engine asks of a felt, in one file.
//!
//! A new law is a variant of [`Loss`] or of [`Exponent`] and an arm in every `match` below. The compiler lists only the matches without `_`. Look yourself at
//! `at`, `bend`, `largest_force`, `press_exactly` and both rates of opening (`FeltLaw::of`, `press_points`): a law that is forgotten there is a felt
//! without loss. A number of an existing law is changed in two places: `FeltLaw::of`, which all forces read, and `curvature_bound`, which reads the file's
//! number. Who asks what:
//!
//! | who asks | what |
//! |---|---|
//! | the step (`contact.rs`) | [`FeltLaw::press`]: mean force over the step, its tangent, and what the tangent leaves out |
//! | the broad phase (`broad_phase.rs`) | [`ONSET`]: the compression at which a felt begins to push |
//! | the quick test (`curvature.rs`) | [`Felt::curvature_bound`]: how strongly the force can bend; [`Pressed::opening`]: how far the clamp is |
//! | the lanes (`lanes.rs`) | [`Felt::kind`], [`Felt::of_lanes`] |
//! | the ledger (`ledger.rs`) | [`Felt::stored`], and the loss in [`Contact::damping_force`](crate::Contact::damping_force) |
//! | the description (`description.rs`) | [`Felt::fault`] |
//!
//! **The set-valued loss**, F = (k g^r + b g^2 dg/dt) (1 + eta Sign(dg/dt)), is here the first factor alone. The sign is a law of the one-step problem: `dry_felts.rs`
//! gives the zone a law along its row G with the bound h eta times that, as `laws.rs` gives a zone with Coulomb friction one along its slip row, and
//! [`Felt::laws`] counts it. Felts that remember are `hysteresis.rs`.

use crate::fault::Fault;
use crate::hysteresis::{Recalled, Remembering};
use crate::real::{Mask, Real, Scalar, join};
use crate::surface::{Yielding, solve};
use crate::timing::Timing;

/// m; every felt pushes at a compression above this and at no other.
pub(crate) const ONSET: f64 = 0.0;
/// m; square roots of compressions are bounded by their tangent here.
const USUAL_DEPTH: f64 = 1e-3;
/// m; the quick test bounds Hunt and Crossley's loss up to this compression, several times what the felts of an action are pressed by.
/// A felt that is pressed deeper is looked at by itself.
const LARGEST_DEPTH: f64 = 3e-3;
/// Longer than any distance, faster than any speed, larger than any force.
pub(crate) const FAR: f64 = 1e30;
/// What a divisor may not fall below.
pub(crate) const TINY: f64 = 1e-30;

/// The felt law's exponent. The usual ones are computed without `pow`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Exponent<T> {
    /// r = 2.
    Two,
    /// r = 2.5.
    TwoAndHalf,
    /// r = 3.
    Three,
    /// Any r >= 1.
    Other(T),
}

impl<T: Scalar> Exponent<T> {
    /// The variant for a given r.
    pub fn new(r: T) -> Self {
        match r.to_f64() {
            2.0 => Exponent::Two,
            2.5 => Exponent::TwoAndHalf,
            3.0 => Exponent::Three,
            _ => Exponent::Other(r),
        }
    }
}

impl<T: Real> Exponent<T> {
    /// r.
    pub(crate) fn value(&self) -> T {
        match self {
            Exponent::Two => T::from_f64(2.0),
            Exponent::TwoAndHalf => T::from_f64(2.5),
            Exponent::Three => T::from_f64(3.0),
            Exponent::Other(r) => *r,
        }
    }
}

/// How a felt loses energy.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Loss<T> {
    /// The papers' law, F = k g^r + b g^2 dg/dt: b, N s/m3. The papers call b also p.
    Quadratic(T),
    /// F = k g^r (1 + a dg/dt): a, s/m. K. H. Hunt and F. R. E. Crossley, *Coefficient of restitution interpreted as damping in
    /// vibroimpact*, Journal of Applied Mechanics 42 (1975) 440-445.
    HuntCrossley(T),
    /// F = (k g^r + b g^2 dg/dt) (1 + eta Sign(dg/dt)), the sign set-valued at rest. A pressed felt that is held is locked: it does not give at all
    /// until its load changes by more than eta of it.
    SetValued {
        /// b, N s/m3.
        damping: T,
        /// eta, 1, below 1.
        eta: T,
    },
    /// The papers' law, and beside it a slider in series with a spring, so that a held felt gives to small changes of its load. The memory of the
    /// felt is the spring's stretch.
    Elastoplastic {
        /// b, N s/m3.
        damping: T,
        /// eta, 1, below 1: the slider's bound as a part of k g^r.
        eta: T,
        /// The spring's stretch at which the slider gives, as a part of x = g^((r+1)/2); 1, above 0 and below 1. As it goes to 0 the law goes to
        /// [`Loss::SetValued`].
        slip: T,
    },
    /// Stulov's hereditary felt, F = k/(1 - eps) (u - z) with u = g^r and dz/dt = (eps u - z)/tau, clamped at zero; k is the stiffness of a slow
    /// compression, k/(1 - eps) that of a quick one. A. Stulov, *Hysteretic model of the grand piano hammer felt*, JASA 97 (1995) 2577-2585.
    Hereditary {
        /// eps, 1, below 1.
        relaxed: T,
        /// tau, s.
        time: T,
    },
}

impl<T: Real> Loss<T> {
    /// Its numbers, and the same law with others.
    fn numbers(&self) -> [T; 3] {
        let o = T::ZERO;
        match *self {
            Loss::Quadratic(x) | Loss::HuntCrossley(x) => [x, o, o],
            Loss::SetValued { damping, eta } => [damping, eta, o],
            Loss::Elastoplastic { damping, eta, slip } => [damping, eta, slip],
            Loss::Hereditary { relaxed, time } => [relaxed, time, o],
        }
    }
}

/// A felt: F(g, dg/dt) for the compression g, clamped at zero, for it never pulls.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Felt<T> {
    /// k, N/m^r.
    pub stiffness: T,
    /// r.
    pub exponent: Exponent<T>,
    /// How it loses energy.
    pub loss: Loss<T>,
}

/// What two felts must have in common to be pressed side by side in lanes: all but their numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct FeltKind {
    exponent: u8,
    loss: u8,
}

/// How strongly a felt's force can bend away from its tangent: with depth the largest compression and speed the largest |dg/dt|,
/// 1/2 |F_gg| <= stiffness + stiffness_by_depth depth + damping speed and |F_gv| <= 2 damping depth, up to the compression `deepest`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CurvatureBound<T> {
    pub stiffness: T,
    pub stiffness_by_depth: T,
    pub damping: T,
    pub deepest: T,
}

impl<T: Real> Felt<T> {
    /// A felt without a loss that pushes with no force: fills unused places.
    pub(crate) fn none() -> Self {
        Felt { stiffness: T::ZERO, exponent: Exponent::Two, loss: Loss::Quadratic(T::ZERO) }
    }

    /// What must be alike for lanes.
    pub fn kind(&self) -> FeltKind {
        let exponent = match self.exponent {
            Exponent::Two => 0,
            Exponent::TwoAndHalf => 1,
            Exponent::Three => 2,
            Exponent::Other(_) => 3,
        };
        let loss = match self.loss {
            Loss::Quadratic(_) => 0,
            Loss::HuntCrossley(_) => 1,
            Loss::SetValued { .. } => 2,
            Loss::Elastoplastic { .. } => 3,
            Loss::Hereditary { .. } => 4,
        };
        FeltKind { exponent, loss }
    }

    /// How many set-valued laws it brings into a step.
    pub(crate) fn laws(&self) -> usize {
        usize::from(self.dry().is_some())
    }

    /// eta of a set-valued loss.
    pub(crate) fn dry(&self) -> Option<T> {
        if let Loss::SetValued { eta, .. } = self.loss { Some(eta) } else { None }
    }

    /// Its memory, if it has one.
    pub(crate) fn remembering(&self) -> Option<Remembering<T>> {
        Remembering::of(self.stiffness, self.exponent, self.loss)
    }

    /// The felts of all lanes; their kind is the first one's.
    pub(crate) fn of_lanes<S: Scalar>(felt: impl Fn(usize) -> Felt<S>) -> Self {
        let first = felt(0);
        let [x, y, z] = [0, 1, 2].map(|k| join(|lane| felt(lane).loss.numbers()[k]));
        Felt {
            stiffness: join(|lane| felt(lane).stiffness),
            exponent: match first.exponent {
                Exponent::Two => Exponent::Two,
                Exponent::TwoAndHalf => Exponent::TwoAndHalf,
                Exponent::Three => Exponent::Three,
                Exponent::Other(_) => Exponent::Other(join(|lane| felt(lane).exponent.value())),
            },
            loss: match first.loss {
                Loss::Quadratic(_) => Loss::Quadratic(x),
                Loss::HuntCrossley(_) => Loss::HuntCrossley(x),
                Loss::SetValued { .. } => Loss::SetValued { damping: x, eta: y },
                Loss::Elastoplastic { .. } => Loss::Elastoplastic { damping: x, eta: y, slip: z },
                Loss::Hereditary { .. } => Loss::Hereditary { relaxed: x, time: y },
            },
        }
    }

    /// Energy stored at a compression g: k g^(r+1) / (r+1), J, and what its memory holds.
    pub(crate) fn stored(&self, compression: T, memory: T) -> T {
        let r = self.exponent.value();
        let g = compression.max(T::ZERO);
        let elastic = self.stiffness * g.powf(r + T::ONE) / (r + T::ONE);
        self.remembering().map_or(elastic, |law| elastic + law.held(compression, memory))
    }
}

impl<T: Scalar> Felt<T> {
    /// What is wrong with its numbers, if anything.
    pub(crate) fn fault(&self) -> Option<Fault> {
        let loss = match self.loss {
            Loss::Quadratic(b) => Fault::negative("damping", b),
            Loss::HuntCrossley(a) => Fault::negative("Hunt and Crossley's a", a),
            Loss::SetValued { damping, eta } => {
                Fault::negative("damping", damping).or_else(|| Fault::not_a_part("eta", eta))
            }
            Loss::Elastoplastic { damping, eta, slip } => Fault::negative("damping", damping)
                .or_else(|| Fault::not_a_part("eta", eta))
                .or_else(|| Fault::not_a_part("slip", slip))
                .or_else(|| Fault::not_positive("slip", slip)),
            Loss::Hereditary { relaxed, time } => {
                Fault::not_a_part("relaxed", relaxed).or_else(|| Fault::not_positive("time", time))
            }
        };
        let exponent = match self.exponent {
            Exponent::Other(r) => Fault::below_one("exponent", r),
            _ => None,
        };
        exponent.or_else(|| Fault::negative("stiffness", self.stiffness)).or(loss)
    }

    /// See [`CurvatureBound`].
    pub(crate) fn curvature_bound(&self) -> CurvatureBound<T> {
        let c = T::from_f64;
        let k = self.stiffness;
        // 1/2 r (r - 1) k g^(r - 2), as a number and one per metre of depth.
        let (constant, by_depth) = match self.exponent {
            Exponent::Two => (1.0, 0.0),
            // sqrt(g) <= (d + g) / (2 sqrt(d)) for any d.
            Exponent::TwoAndHalf => (0.9375 * libm::sqrt(USUAL_DEPTH), 0.9375 / libm::sqrt(USUAL_DEPTH)),
            Exponent::Three => (0.0, 3.0),
            // No bound: the quick test always leaves it to the exact one.
            Exponent::Other(_) => (FAR, 0.0),
        };
        // A felt that remembers bends more sharply while its memory changes.
        let sharper = match self.loss {
            Loss::Quadratic(_) | Loss::HuntCrossley(_) | Loss::SetValued { .. } => T::ONE,
            Loss::Elastoplastic { eta, slip, .. } => {
                let (one, r) = (T::ONE, self.exponent.value());
                let stretch = (one + slip) * (one + slip) / (one - slip);
                one + eta / slip * (one + c(0.25) * (r - c(3.0)).abs() * stretch / r)
            }
            Loss::Hereditary { relaxed, .. } => c(4.0) / (T::ONE - relaxed),
        };
        let (stiffness, stiffness_by_depth) = (sharper * k * c(constant), sharper * k * c(by_depth));
        let (damping, deepest) = match (self.loss, self.exponent) {
            (Loss::Quadratic(b), _) => (b, c(FAR)),
            (Loss::SetValued { damping, .. } | Loss::Elastoplastic { damping, .. }, _) => (damping, c(FAR)),
            // a k g^2 dg/dt is the papers' law with b = a k.
            (Loss::HuntCrossley(a), Exponent::Two) => (a * k, c(FAR)),
            // 1/2 F_gg = 1/2 r (r - 1) a k g^(r - 2) dg/dt and F_gv = r a k g^(r - 1), and g^(r - 2) <= D^(r - 2) for g <= D and r >= 2.
            (Loss::HuntCrossley(a), Exponent::TwoAndHalf) => {
                (a * k * c(1.875 * libm::sqrt(LARGEST_DEPTH)), c(LARGEST_DEPTH))
            }
            (Loss::HuntCrossley(a), Exponent::Three) => (a * k * c(3.0 * LARGEST_DEPTH), c(LARGEST_DEPTH)),
            (Loss::HuntCrossley(_), Exponent::Other(_)) => (T::ZERO, c(FAR)),
            (Loss::Hereditary { .. }, _) => (T::ZERO, c(FAR)),
        };
        CurvatureBound { stiffness, stiffness_by_depth, damping, deepest }
    }
}

/// A felt as the step reads it: what does not change is worked out once.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FeltLaw<T> {
    stiffness: T,
    exponent: Exponent<T>,
    /// The papers' or Hunt and Crossley's; any other is not part of the force that is worked out here, and stands as none.
    loss: Loss<T>,
    /// r = 2 with the papers' loss: the mean over a step has a closed form.
    square: bool,
    /// Whether what it presses on yields.
    yields: bool,
    /// A law with memory, which stands for all of the force.
    remembering: Option<Remembering<T>>,
    /// The largest force over the one that is worked out here, where another loss stands beside it.
    largest: T,
    /// b of the papers' loss.
    damping: T,
    /// The rate, m/s, at which a felt opens when it just pushes no more, where that does not depend on the compression: k/b for r = 2,
    /// 1/a for Hunt and Crossley's.
    opening: T,
}

/// What a felt finds when a step begins.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Carried<'a, T> {
    /// Its memory, where it has one.
    pub memory: &'a T,
    /// What it presses on, where that yields.
    pub surface: &'a Yielding<T>,
}

/// What a felt does during a step.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Pressed<T> {
    /// Mean force over the step, N.
    pub force: T,
    /// The part of it due to the loss, N.
    pub damping_force: T,
    /// h dF/d(rate), never negative.
    pub tangent: T,
    pub curvature: Curvature<T>,
    /// The rate, m/s, by which it would have to open faster before it pushes no more.
    pub opening: T,
}

/// How a felt's mean force bends away from its tangent.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Curvature<T> {
    /// Largest change of the force with the rate, to first and (what is not in the tangent) to second order.
    pub linear: T,
    pub quadratic: T,
    /// Smallest force of a touched Gauss point, N: how far the clamp at zero is.
    pub slack: T,
}

impl<T: Real> FeltLaw<T> {
    pub(crate) fn of(felt: &Felt<T>) -> Self {
        let (stiffness, exponent, tiny) = (felt.stiffness, felt.exponent, T::from_f64(TINY));
        // For r = 2 Hunt and Crossley's law is the papers', with b = a k.
        let loss = match (felt.loss, exponent) {
            (Loss::HuntCrossley(a), Exponent::Two) => Loss::Quadratic(a * stiffness),
            (loss @ (Loss::Quadratic(_) | Loss::HuntCrossley(_)), _) => loss,
            (Loss::SetValued { damping, .. } | Loss::Elastoplastic { damping, .. }, _) => Loss::Quadratic(damping),
            (Loss::Hereditary { .. }, _) => Loss::Quadratic(T::ZERO),
        };
        let (damping, opening) = match loss {
            Loss::HuntCrossley(a) => (T::ZERO, T::ONE / a.max(tiny)),
            Loss::Quadratic(b) => (b, stiffness / b.max(tiny)),
            _ => (T::ZERO, T::from_f64(FAR)),
        };
        let remembering = felt.remembering();
        let square = matches!((exponent, loss), (Exponent::Two, Loss::Quadratic(_))) && remembering.is_none();
        let largest = match felt.loss {
            Loss::Quadratic(_) | Loss::HuntCrossley(_) => T::ONE,
            Loss::SetValued { eta, .. } | Loss::Elastoplastic { eta, .. } => T::ONE + eta,
            Loss::Hereditary { relaxed, .. } => T::ONE / (T::ONE - relaxed),
        };
        FeltLaw { stiffness, exponent, loss, square, yields: false, remembering, largest, damping, opening }
    }

    /// What it presses on yields.
    pub(crate) fn set_yielding(&mut self) {
        self.yields = true;
    }

    pub(crate) fn yields(&self) -> bool {
        self.yields
    }

    /// The felt's mean force over the step and its tangent, at a compression and rate, in the lanes that are touched.
    ///
    /// The mean is taken along the step's straight path in g, by two-point Gauss quadrature. For r = 2 and 3 that is exact, so that
    /// compressing and releasing a felt conserves energy whatever the step; taken at one point instead, the string's felt alone would
    /// leave 2e-3 of the work in the ledger's residual at 50 us. At theta = 1 the path shrinks to the step's end, and the scheme is
    /// backward Euler.
    #[inline(always)]
    pub(crate) fn press(
        &self,
        compression: T,
        rate: T,
        timing: &Timing<T>,
        touched: T::Mask,
        memory: &T,
    ) -> Pressed<T> {
        if !self.square {
            return match &self.remembering {
                None => self.press_points(compression, rate, timing, touched),
                Some(law) => law.press(compression, rate, timing, touched, *memory),
            };
        }
        let whole = self.press_square(compression, rate, timing, touched);
        let partly = touched.and(compression.le((timing.node * rate).abs()));
        if partly.any() {
            // Each lane by the formula that it would take alone.
            whole.or(partly, self.press_points(compression, rate, timing, touched))
        } else {
            whole
        }
    }

    /// Any law on a surface that stands still.
    fn press_still(&self, compression: T, rate: T, timing: &Timing<T>, touched: T::Mask, memory: &T) -> Pressed<T> {
        match &self.remembering {
            None => self.press_points(compression, rate, timing, touched),
            Some(law) => law.press(compression, rate, timing, touched, *memory),
        }
    }

    /// Any law, its mean along the step's straight path worked out exactly: with V' = k g^r, (V(b) - V(a))/(b - a) from compression to compression, and (b^3 - a^3)/(3 (b - a)) of
    /// g^2, also where the path begins or ends apart. Two-point quadrature leaves part of a felt's work in the books where it is touched in mid step, or where
    /// r is neither 2 nor 3; a hammer that rattles on a string would win or lose by that.
    fn press_exactly(&self, compression: T, rate: T, timing: &Timing<T>, touched: T::Mask, memory: &T) -> Pressed<T> {
        let pressed = self.press_still(compression, rate, timing, touched, memory);
        if self.remembering.is_some() {
            return pressed;
        }
        let half = timing.step - timing.h_theta;
        let (whole, way) = (half + half, (half + half) * rate);
        let (a, b) = ((compression - half * rate).max(T::ZERO), (compression + half * rate).max(T::ZERO));
        // On a short way the difference of potentials is rounded, and the quadrature is exact to rounding.
        let long = (T::from_f64(1e-3) * (a + b)).lt(way.abs());
        if !long.any() {
            return pressed;
        }
        let (from, to) = (self.elastic(a), self.elastic(b));
        let inverse = T::ONE / T::select(long, way, T::ONE);
        let (ahead, behind) = (timing.h_theta + half, timing.h_theta - half);
        // The mean of what has the integrals v at the ends, and how it changes with the rate.
        let mean = |v: [T; 2], f: [T; 2]| {
            let mean = (v[1] - v[0]) * inverse;
            (mean, (f[1] * ahead - f[0] * behind - whole * mean) * inverse)
        };
        let power = T::ONE / (self.exponent.value() + T::ONE);
        let (elastic, slope) = mean([power * from.force * a, power * to.force * b], [from.force, to.force]);
        let (force, slope) = match self.loss {
            Loss::HuntCrossley(c) => (elastic + c * rate * elastic, slope + c * (elastic + rate * slope)),
            Loss::Quadratic(c) => {
                let third = T::from_f64(1.0 / 3.0);
                let (square, bend) = mean([third * a * a * a, third * b * b * b], [a * a, b * b]);
                (elastic + c * rate * square, slope + c * (square + rate * bend))
            }
            _ => (elastic, slope),
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

    /// Any law on a surface that yields, at the compression and the rate that there would be if it were not pressed.
    ///
    /// With P the law's mean force and P' its slope with the rate, F = P(rate - a F) has the slope P'/(1 + a P'). It bends less than the law itself,
    /// F'' = P''/(1 + a P')^3, at a compression that is no deeper, so that the law's curvature there is a bound. The quick test knows nothing
    /// of that: a margin of zero leaves such a zone to the exact one.
    pub(crate) fn press_yielding(
        &self,
        compression: T,
        rate: T,
        timing: &Timing<T>,
        touched: T::Mask,
        carried: Carried<'_, T>,
    ) -> Pressed<T> {
        let (compression, rate) = self.give_way(compression, rate, timing, touched, carried);
        let pressed = self.press_exactly(compression, rate, timing, touched, carried.memory);
        let slope = T::ONE + carried.surface.give * (pressed.tangent / timing.h_theta);
        Pressed { tangent: pressed.tangent / slope, opening: T::ZERO, ..pressed }
    }

    /// The compression and its rate at the theta point, with what a surface that yields gives way under the felt's force: from those that there
    /// would be if it were not pressed.
    pub(crate) fn give_way(
        &self,
        compression: T,
        rate: T,
        timing: &Timing<T>,
        touched: T::Mask,
        carried: Carried<'_, T>,
    ) -> (T, T) {
        let give = carried.surface.give;
        let behind = |force: T| (compression - timing.h_theta * (give * force), rate - give * force);
        let force = solve(touched, |force| {
            let (compression, rate) = behind(force);
            let pressed = self.press_exactly(compression, rate, timing, touched, carried.memory);
            [pressed.force, give * (pressed.tangent / timing.h_theta)]
        });
        behind(force)
    }

    /// What becomes of its memory, where it has one; at the compression and rate of [`FeltLaw::give_way`] on a surface that yields.
    pub(crate) fn recall(
        &self,
        compression: T,
        rate: T,
        timing: &Timing<T>,
        touched: T::Mask,
        memory: T,
    ) -> Option<Recalled<T>> {
        self.remembering.as_ref().map(|law| law.recall(compression, rate, timing, touched, memory))
    }

    /// The memory after a step in which it was not touched, and by how much the energy that it holds has grown, J.
    pub(crate) fn left_alone(&self, timing: &Timing<T>, memory: T) -> (T, T) {
        self.remembering.as_ref().map_or((T::ZERO, T::ZERO), |law| law.left_alone(timing, memory))
    }

    /// r = 2 and both Gauss points touched: F = (k + b dg/dt) g^2, whose mean over the path is (k + b dg/dt) (g^2 + o^2), o being the
    /// points' distance from the middle.
    #[inline(always)]
    fn press_square(&self, compression: T, rate: T, timing: &Timing<T>, touched: T::Mask) -> Pressed<T> {
        let (h_theta, node) = (timing.h_theta, timing.node);
        let (offset, reach) = (node * rate, h_theta + node);
        let (deepest, shallowest) = (compression + offset.abs(), compression - offset.abs());
        let bv = self.damping * rate;
        let (factor, square) = (self.stiffness + bv, (compression * compression).add_product(offset, offset));
        // One factor for both points: the clamp takes both or none.
        let pushing = touched.and(T::ZERO.lt(factor));
        let only_pushing = |x: T| T::only(pushing, x);
        let twice = factor + factor;
        let tangent =
            h_theta * (self.damping * square).add_product(twice, (h_theta * compression).add_product(node, offset));
        Pressed {
            force: only_pushing(factor * square),
            // What the clamp leaves of the damping undoes the stiffness.
            damping_force: T::select(pushing, bv, -self.stiffness) * square,
            tangent: only_pushing(tangent.max(T::ZERO)),
            curvature: Curvature {
                linear: deepest * (reach * twice.abs() + self.damping * deepest),
                quadratic: reach * (reach * (self.stiffness + bv.abs()) + T::from_f64(2.0) * self.damping * deepest),
                slack: only_pushing(factor * shallowest * shallowest),
            },
            opening: self.opening + rate,
        }
    }

    /// Any law and any path, point by point.
    #[inline(always)]
    fn press_points(&self, compression: T, rate: T, timing: &Timing<T>, touched: T::Mask) -> Pressed<T> {
        let half = T::from_f64(0.5);
        let offset = timing.node * rate;
        let deepest = compression + offset.abs();
        let (first, second) = ((compression + offset).max(T::ZERO), (compression - offset).max(T::ZERO));
        let (elastic_a, elastic_b) = (self.elastic(first), self.elastic(second));
        let a = self.at(&elastic_a, first, rate).clamped(first);
        let b = self.at(&elastic_b, second, rate).clamped(second);
        let only_touched = |x: T| T::only(touched, x);
        let (h_theta, node) = (timing.h_theta, timing.node);
        let slope = ((h_theta + node) * a.stiffness).add_product(h_theta - node, b.stiffness);
        // The compression's change by a change of the rate.
        let reach = h_theta + node;
        let bend = self.bend(&elastic_a.max(&elastic_b), deepest, rate);
        let slack = a.slack.min(b.slack);
        Pressed {
            force: only_touched(half * (a.force + b.force)),
            damping_force: half * (a.damping_force + b.damping_force),
            tangent: only_touched((half * h_theta * (a.damping + b.damping + slope)).max(T::ZERO)),
            curvature: Curvature {
                linear: reach * a.stiffness.abs().max(b.stiffness.abs()) + a.damping.max(b.damping),
                quadratic: reach * (reach * bend.by_compression + bend.mixed),
                slack,
            },
            opening: match self.loss {
                Loss::HuntCrossley(_) => self.opening + rate,
                // The least of the forces over the largest damping.
                _ => slack / bend.largest_damping.max(T::from_f64(TINY)),
            },
        }
    }

    /// The largest force of a felt that is pressed no deeper and no faster than this, N.
    #[inline(always)]
    pub(crate) fn largest_force(&self, deepest: T, speed: T) -> T {
        let elastic = self.elastic(deepest).force;
        match self.loss {
            Loss::Quadratic(b) => self.largest * (elastic + b * deepest * deepest * speed),
            Loss::HuntCrossley(a) => elastic + a * elastic * speed,
            _ => self.largest * elastic,
        }
    }

    /// The law and its partial derivatives, not clamped; `compression` must not be negative.
    #[inline(always)]
    fn at(&self, elastic: &Elastic<T>, compression: T, rate: T) -> FeltState<T> {
        match self.loss {
            Loss::Quadratic(b) => {
                let bg = b * compression;
                let damping = bg * compression;
                let damping_force = damping * rate;
                let force = elastic.force + damping_force;
                let stiffness = elastic.slope.add_product(bg + bg, rate);
                FeltState { force, damping_force, stiffness, damping, slack: force }
            }
            Loss::HuntCrossley(a) => {
                let damping = a * elastic.force;
                let damping_force = damping * rate;
                let force = elastic.force + damping_force;
                let stiffness = elastic.slope.add_product(a * elastic.slope, rate);
                FeltState { force, damping_force, stiffness, damping, slack: force }
            }
            _ => {
                let Elastic { force, slope, .. } = *elastic;
                FeltState { force, damping_force: T::ZERO, stiffness: slope, damping: T::ZERO, slack: force }
            }
        }
    }

    /// Its second derivatives at most, on a path down to `deepest`, given the larger of the elastic forces, slopes and curvatures there.
    #[inline(always)]
    fn bend(&self, elastic: &Elastic<T>, deepest: T, rate: T) -> Bend<T> {
        let (half, two) = (T::from_f64(0.5), T::from_f64(2.0));
        match self.loss {
            Loss::Quadratic(b) => Bend {
                by_compression: half * elastic.curvature + b * rate.abs(),
                mixed: two * b * deepest,
                largest_damping: b * deepest * deepest,
            },
            Loss::HuntCrossley(a) => Bend {
                by_compression: half * elastic.curvature * (T::ONE + a * rate.abs()),
                mixed: a * elastic.slope,
                largest_damping: a * elastic.force,
            },
            _ => Bend { by_compression: half * elastic.curvature, mixed: T::ZERO, largest_damping: T::ZERO },
        }
    }

    /// k g^r and its first and second derivative in g; `compression` must not be negative.
    #[inline(always)]
    fn elastic(&self, compression: T) -> Elastic<T> {
        Elastic::of(self.stiffness, &self.exponent, compression)
    }
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
            curvature: Curvature {
                linear: choose(self.curvature.linear, other.curvature.linear),
                quadratic: choose(self.curvature.quadratic, other.curvature.quadratic),
                slack: choose(self.curvature.slack, other.curvature.slack),
            },
            opening: choose(self.opening, other.opening),
        }
    }
}

/// k g^r with its first and second derivative in g.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Elastic<T> {
    pub force: T,
    pub slope: T,
    pub curvature: T,
}

impl<T: Real> Elastic<T> {
    /// At a compression, which must not be negative.
    #[inline(always)]
    pub(crate) fn of(stiffness: T, exponent: &Exponent<T>, compression: T) -> Self {
        let c = T::from_f64;
        match *exponent {
            Exponent::Two => {
                let kg = stiffness * compression;
                Elastic { force: kg * compression, slope: c(2.0) * kg, curvature: c(2.0) * stiffness }
            }
            Exponent::TwoAndHalf => {
                let k_root = stiffness * compression.sqrt();
                let kg = k_root * compression;
                Elastic { force: kg * compression, slope: c(2.5) * kg, curvature: c(3.75) * k_root }
            }
            Exponent::Three => {
                let k_compression = stiffness * compression;
                let kg = k_compression * compression;
                Elastic { force: kg * compression, slope: c(3.0) * kg, curvature: c(6.0) * k_compression }
            }
            Exponent::Other(r) => {
                let kg = stiffness * compression.powf(r - T::ONE);
                // r < 2 bends without bound at first touch; a compression of a nanometre is no touch.
                let curvature = r * (r - T::ONE) * kg / compression.max(c(1e-9));
                Elastic { force: kg * compression, slope: r * kg, curvature }
            }
        }
    }

    /// The larger of each.
    #[inline(always)]
    pub(crate) fn max(&self, other: &Self) -> Self {
        Elastic {
            force: self.force.max(other.force),
            slope: self.slope.max(other.slope),
            curvature: self.curvature.max(other.curvature),
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

    fn laws() -> impl Iterator<Item = (Felt<f64>, FeltLaw<f64>)> {
        let losses = [Loss::Quadratic(2e3), Loss::HuntCrossley(0.8)];
        EXPONENTS.into_iter().flat_map(move |exponent| {
            losses.map(|loss| {
                let felt = Felt { stiffness: 3e3, exponent, loss };
                (felt, FeltLaw::of(&felt))
            })
        })
    }

    fn at(law: &FeltLaw<f64>, g: f64, v: f64) -> FeltState<f64> {
        law.at(&law.elastic(g), g, v).clamped(g)
    }

    /// The force as the README writes it, by `pow`, against the law's own: to rounding.
    #[test]
    fn the_force_is_the_written_one() {
        for (felt, law) in laws() {
            for (g, v) in [(0.02, -0.01), (1e-3, 0.3), (0.5, 1.0)] {
                let elastic = felt.stiffness * libm::pow(g, felt.exponent.value());
                let written = match felt.loss {
                    Loss::Quadratic(b) => elastic + b * g * g * v,
                    Loss::HuntCrossley(a) => elastic * (1.0 + a * v),
                    _ => elastic,
                };
                let ours = at(&law, g, v).force;
                assert!((ours - written.max(0.0)).abs() <= 1e-14 * written.abs(), "{felt:?} {g} {v}: {ours} {written}");
            }
        }
    }

    /// The law's partial derivatives against differences, and the clamp: felt never pulls.
    #[test]
    fn partial_derivatives() {
        for (felt, law) in laws() {
            let (g, v, e) = (0.02, -0.01, 1e-7);
            let here = at(&law, g, v);
            let dg = (at(&law, g + e, v).force - at(&law, g - e, v).force) / (2.0 * e);
            let dv = (at(&law, g, v + e).force - at(&law, g, v - e).force) / (2.0 * e);
            assert!((here.stiffness - dg).abs() < 1e-6 * dg.abs(), "{felt:?}");
            assert!((here.damping - dv).abs() < 1e-6 * dv.abs(), "{felt:?}");
            assert_eq!(at(&law, g, -1e3).force, 0.0);
        }
    }

    /// The stored energy is the integral of the force of a felt that moves infinitely slowly: Simpson's rule over 2000 intervals, whose
    /// own error for g^1.7, the least smooth at zero, is below 1e-6.
    #[test]
    fn the_stored_energy_is_the_slow_work() {
        for (felt, law) in laws() {
            let (depth, n) = (0.02, 2000);
            let force = |i: i32| at(&law, depth * f64::from(i) / f64::from(n), 0.0).force;
            let inner: f64 = (1..n).map(|i| if i % 2 == 1 { 4.0 * force(i) } else { 2.0 * force(i) }).sum();
            let work = (force(0) + inner + force(n)) * depth / f64::from(n) / 3.0;
            assert!((felt.stored(depth, 0.0) - work).abs() < 1e-6 * work, "{felt:?}");
        }
    }

    /// Where a law's rate of opening does not depend on the compression, its force vanishes just there.
    #[test]
    fn a_felt_that_opens_so_fast_pushes_no_more() {
        for (felt, law) in laws().filter(|(felt, law)| law.square || matches!(felt.loss, Loss::HuntCrossley(_))) {
            for compression in [1e-4, 1e-3, 0.02] {
                assert!(at(&law, compression, -0.999 * law.opening).force > 0.0, "{felt:?}");
                assert_eq!(at(&law, compression, -1.001 * law.opening).force, 0.0, "{felt:?}");
            }
        }
    }

    /// The curvature bound is one: second derivatives by differences of the first ones, over compressions and rates up to its limit. It is
    /// met where the law is a square (nothing is lost), and by no more than an order of magnitude anywhere.
    #[test]
    fn the_curvature_bound_holds() {
        for (felt, law) in laws().filter(|(felt, _)| !matches!(felt.exponent, Exponent::Other(_))) {
            let bound = felt.curvature_bound();
            for depth in [1e-5, 1e-4, 1e-3, 0.999 * LARGEST_DEPTH] {
                for v in [-0.9, 0.0, 0.3, 5.0] {
                    let e = 1e-6 * depth;
                    let (up, down) =
                        (law.at(&law.elastic(depth + e), depth + e, v), law.at(&law.elastic(depth - e), depth - e, v));
                    let by_compression = 0.5 * (up.stiffness - down.stiffness).abs() / (2.0 * e);
                    let mixed = (up.damping - down.damping).abs() / (2.0 * e);
                    let rounding = 1.0 + 1e-8;
                    let most = bound.stiffness + bound.stiffness_by_depth * depth + bound.damping * v.abs();
                    assert!(by_compression <= most * rounding, "{felt:?} {depth} {v}: {by_compression} {most}");
                    assert!(mixed <= 2.0 * bound.damping * depth * rounding, "{felt:?} {depth} {v}");
                }
            }
        }
    }

    /// Compressions and rates at which both points of the quadrature are touched, for every law; theta between its ends and at them.
    fn touched() -> impl Iterator<Item = (Felt<f64>, FeltLaw<f64>, f64, f64, Timing<f64>)> {
        let timings = [(50e-6, 0.5), (1e-3, 0.5), (2e-4, 0.7), (50e-6, 1.0)].map(|(h, theta)| Timing::new(h, theta));
        laws().flat_map(move |(felt, law)| {
            timings.into_iter().flat_map(move |timing| {
                [(1e-3, 0.3), (2e-3, -0.4), (0.01, 2.0), (0.02, -0.01)]
                    .map(|(compression, rate)| (felt, law, compression, rate, timing))
            })
        })
    }

    /// The closed form for a square is the quadrature, in all that it tells.
    #[test]
    fn the_closed_form_is_the_quadrature() {
        for (felt, law, compression, rate, timing) in touched().filter(|(_, law, ..)| law.square) {
            let (closed, points) = (
                law.press_square(compression, rate, &timing, true),
                law.press_points(compression, rate, &timing, true),
            );
            let same = |a: f64, b: f64, what: &str| {
                assert!((a - b).abs() <= 1e-12 * b.abs(), "{felt:?} {compression} {rate} {timing:?}: {what} {a} {b}");
            };
            same(closed.force, points.force, "force");
            same(closed.damping_force, points.damping_force, "damping force");
            same(closed.tangent, points.tangent, "tangent");
            same(closed.curvature.linear, points.curvature.linear, "linear");
            same(closed.curvature.quadratic, points.curvature.quadratic, "quadratic");
            same(closed.curvature.slack, points.curvature.slack, "slack");
        }
    }

    /// How much slower the felt may close before its force vanishes is told exactly where the compression plays no part: by 1/a and its rate.
    #[test]
    fn the_clamp_is_as_far_as_it_says() {
        let mut met = 0;
        for (felt, law, compression, rate, timing) in touched() {
            if let Loss::HuntCrossley(a) = felt.loss {
                let opening = law.press(compression, rate, &timing, true, &0.0).opening;
                assert!((opening - (1.0 / a + rate)).abs() <= 1e-12 / a, "{felt:?} {rate}: {opening}");
                met += 1;
            }
        }
        assert!(met > 0);
    }

    /// The mean force is that of the two points of Gauss, and the tangent its derivative by the rate, the compression going along with it by
    /// theta h (a central difference, right to 1e-8).
    #[test]
    fn the_quadrature_and_its_tangent() {
        for (felt, law, compression, rate, timing) in touched() {
            let written = |g: f64, v: f64| {
                let elastic = felt.stiffness * libm::pow(g, felt.exponent.value());
                match felt.loss {
                    Loss::Quadratic(b) => elastic + b * g * g * v,
                    Loss::HuntCrossley(a) => elastic * (1.0 + a * v),
                    _ => elastic,
                }
                .max(0.0)
            };
            let mean = |compression: f64, rate: f64| {
                let offset = (timing.step - timing.h_theta) / 3f64.sqrt() * rate;
                0.5 * (written(compression + offset, rate) + written(compression - offset, rate))
            };
            let pressed = law.press(compression, rate, &timing, true, &0.0);
            let force = mean(compression, rate);
            assert!(
                (pressed.force - force).abs() <= 1e-12 * force,
                "{felt:?} {compression} {rate}: {} {force}",
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
                "{felt:?} {compression} {rate} {timing:?}: {} {tangent}",
                pressed.tangent
            );
        }
    }

    /// What the step takes for the second derivatives is what they are, where the felt is being compressed: central differences of the first ones.
    #[test]
    fn second_derivatives() {
        for (felt, law) in laws() {
            for (g, v) in [(1e-3, 0.5), (0.02, 2.0)] {
                let e = 1e-5 * g;
                let state = |g: f64| law.at(&law.elastic(g), g, v);
                let (up, down, bend) = (state(g + e), state(g - e), law.bend(&law.elastic(g), g, v));
                let by_compression = 0.5 * (up.stiffness - down.stiffness) / (2.0 * e);
                let mixed = (up.damping - down.damping) / (2.0 * e);
                assert!(
                    (bend.by_compression - by_compression).abs() < 1e-6 * by_compression,
                    "{felt:?} {g}: {} {by_compression}",
                    bend.by_compression
                );
                assert!((bend.mixed - mixed).abs() < 1e-6 * mixed, "{felt:?} {g}: {} {mixed}", bend.mixed);
                assert!(
                    (bend.largest_damping - state(g).damping).abs() <= 1e-14 * bend.largest_damping,
                    "{felt:?} {g}"
                );
                let elastic = law.elastic(g);
                let curvature = (law.elastic(g + e).slope - law.elastic(g - e).slope) / (2.0 * e);
                assert!(
                    (elastic.curvature - curvature).abs() < 1e-6 * curvature,
                    "{felt:?} {g}: {elastic:?} {curvature}"
                );
            }
        }
    }

    /// No deeper and no faster: the largest force is the one at both limits.
    #[test]
    fn the_largest_force_is_the_deepest_and_fastest() {
        for (felt, law) in laws() {
            for (g, v) in [(1e-3, 0.5), (0.02, 3.0)] {
                let largest = law.largest_force(g, v);
                assert!((largest - law.at(&law.elastic(g), g, v).force).abs() <= 1e-14 * largest, "{felt:?}");
                for (share, part) in [(0.3, 1.0), (1.0, -0.7), (0.9, 0.2)] {
                    let force = law.at(&law.elastic(share * g), share * g, part * v).force;
                    assert!(force <= largest, "{felt:?}");
                }
            }
        }
    }
}
