//! Felts: a spring k g^r with a contact law ([`Loss`], `law/`), in the form of a description and in the form that the
//! step reads.
//!
//! | who asks | what |
//! |---|---|
//! | the step (`contact.rs`) | [`FeltLaw::press`]: mean force over the step and its tangent; [`FeltLaw::recall`]: the memory after it |
//! | the exact test (`acceptance.rs`) | [`FeltLaw::bend`]: what the tangent leaves out |
//! | the broad phase (`broad_phase.rs`) | [`ONSET`]: the compression at which a felt begins to push |
//! | the quick test (`curvature.rs`) | [`Felt::curvature_bound`]: how strongly the force can bend; [`Pressed::opening`]: how far the clamp is |
//! | the lanes (`lanes.rs`) | [`Felt::kind`], [`Felt::of_lanes`] |
//! | the ledger (`ledger.rs`) | [`Felt::stored`], and the loss in [`Contact::damping_force`](crate::Contact::damping_force) |
//! | the description (`description.rs`) | [`Felt::fault`] |

use crate::fault::Fault;
use crate::law::{CurvatureBound, Exponent, Loss, MEMORY, Memory, Pressed, Pressing, RatePart, Spring};
use crate::real::{Aside, Mask, Real, Scalar, join};
use crate::surface::{Yielding, solve};
use crate::timing::Timing;

pub(crate) use crate::law::{Curvature, FAR, ONSET, TINY};

/// Felt with force F(g, dg/dt) at the compression g. It never pulls: F is limited to at least 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Felt<T> {
    /// Stiffness k, N/m^r.
    pub stiffness: T,
    /// Exponent r.
    pub exponent: Exponent<T>,
    /// Law of the energy loss.
    pub loss: Loss<T>,
}

/// Kind of a felt: everything but its numbers. Felts in the lanes of one model must be of one kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct FeltKind {
    exponent: u8,
    law: usize,
}

impl<T: Real> Felt<T> {
    /// A felt without a loss that pushes with no force: fills unused places.
    pub(crate) fn none() -> Self {
        Felt { stiffness: T::ZERO, exponent: Exponent::Two, loss: Loss::none() }
    }

    /// Returns the kind, which all lanes of a model must share.
    pub fn kind(&self) -> FeltKind {
        let exponent = match self.exponent {
            Exponent::Two => 0,
            Exponent::TwoAndHalf => 1,
            Exponent::Three => 2,
            Exponent::Other(_) => 3,
        };
        FeltKind { exponent, law: self.loss.law() }
    }

    /// Number of set-valued laws that it adds to a step.
    pub(crate) fn laws(&self) -> usize {
        usize::from(self.dry().is_some())
    }

    /// eta of a set-valued loss.
    pub(crate) fn dry(&self) -> Option<T> {
        self.loss.set_valued()
    }

    /// Whether it carries numbers from step to step.
    pub(crate) fn remembers(&self) -> bool {
        self.loss.remembers() > 0
    }

    /// The felts of all lanes; their kind is the first one's.
    pub(crate) fn of_lanes<S: Scalar>(felt: impl Fn(usize) -> Felt<S>) -> Self {
        Felt {
            stiffness: join(|lane| felt(lane).stiffness),
            exponent: felt(0).exponent.map(|_| join(|lane| felt(lane).exponent.value())),
            loss: Loss::of_lanes(|lane| felt(lane).loss),
        }
    }

    fn spring(&self) -> Spring<T> {
        Spring { stiffness: self.stiffness, exponent: self.exponent }
    }

    /// Energy stored at a compression g: k g^(r+1) / (r+1), J, and what its memory holds.
    pub(crate) fn stored(&self, compression: T, memory: &Memory<T>) -> T {
        let spring = self.spring();
        spring.stored(compression) + self.loss.stored_energy(&spring, compression, memory)
    }
}

impl<T: Scalar> Felt<T> {
    /// What is wrong with its numbers, if anything.
    pub(crate) fn fault(&self) -> Option<Fault> {
        let exponent = match self.exponent {
            Exponent::Other(r) => Fault::below_one("exponent", r),
            _ => None,
        };
        let numbers = self.loss.table().iter().zip(self.loss.numbers());
        let loss = numbers.filter_map(|(number, x)| number.fault(x)).next();
        exponent.or_else(|| Fault::negative("stiffness", self.stiffness)).or(loss)
    }

    /// See [`CurvatureBound`].
    pub(crate) fn curvature_bound(&self) -> CurvatureBound<T> {
        CurvatureBound::of(&self.spring(), self.loss.rate_part(), self.loss.effective_exponent(self.exponent.value()))
    }
}

/// Felt in the form that the step reads, with precomputed constants.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FeltLaw<T> {
    /// Part of the force that depends only on the present compression and rate.
    rate_part: RatePart<T>,
    /// Whether the rate part is the whole force, and its mean over a step has a closed form.
    square: bool,
    /// Whether the surface is compliant.
    yields: bool,
    /// Whether a law with internal state gives the whole force.
    remembers: bool,
    /// Largest ratio of the force to that of the rate part.
    largest: T,
    loss: Loss<T>,
}

/// Force of a law with internal state.
struct Press<'a, T: Real>(&'a FeltLaw<T>, Pressing<'a, T>, &'a Memory<T>);

impl<T: Real> Aside for Press<'_, T> {
    type Output = Pressed<T>;
    #[inline(always)]
    fn run(self) -> Pressed<T> {
        let Press(law, pressing, memory) = self;
        law.loss.press(&law.rate_part.spring, &pressing, memory)
    }
}

/// Curvature of the force of a law with internal state.
struct Bend<'a, T: Real>(&'a FeltLaw<T>, Pressing<'a, T>, &'a Memory<T>);

impl<T: Real> Aside for Bend<'_, T> {
    type Output = Curvature<T>;
    #[inline(always)]
    fn run(self) -> Curvature<T> {
        let Bend(law, pressing, memory) = self;
        law.loss.curvature(&law.rate_part.spring, &pressing, memory)
    }
}

/// State of a felt at the start of a step.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Carried<'a, T> {
    /// Internal state, if the law has one.
    pub memory: &'a Memory<T>,
    /// Surface that it presses on, if the surface is compliant.
    pub surface: &'a Yielding<T>,
}

impl<T: Real> FeltLaw<T> {
    pub(crate) fn of(felt: &Felt<T>) -> Self {
        let rate_part = RatePart::of(felt.spring(), felt.loss.rate_part());
        // A set-valued loss remembers its force, and has a rate part beside it.
        let remembers = felt.remembers() && felt.dry().is_none();
        FeltLaw {
            square: rate_part.is_square() && !remembers,
            rate_part,
            yields: false,
            remembers,
            largest: felt.loss.largest(),
            loss: felt.loss,
        }
    }

    /// Sets the surface to be compliant.
    pub(crate) fn set_yielding(&mut self) {
        self.yields = true;
    }

    pub(crate) fn yields(&self) -> bool {
        self.yields
    }

    /// The felt's mean force over the step and its tangent, at a compression and rate, in the lanes that are touched.
    ///
    /// The mean is taken along the step's straight path in g, by two-point Gauss quadrature. For r = 2 and 3 that is
    /// exact, so that compressing and releasing a felt conserves energy whatever the step; taken at one point instead,
    /// the string's felt alone would leave 2e-3 of the work in the ledger's residual at 50 us. At theta = 1 the path
    /// shrinks to the step's end, and the scheme is backward Euler.
    #[inline(always)]
    pub(crate) fn press(
        &self,
        compression: T,
        rate: T,
        timing: &Timing<T>,
        touched: T::Mask,
        memory: &Memory<T>,
    ) -> Pressed<T> {
        if !self.square {
            if self.remembers {
                return self.press_remembering(compression, rate, timing, touched, memory);
            }
            return self.rate_part.press_points(compression, rate, timing, touched).0;
        }
        let whole = self.rate_part.press_square(compression, rate, timing, touched).0;
        let partly = touched.and(compression.le((timing.node * rate).abs()));
        if partly.any() {
            // Each lane by the formula that it would take alone.
            whole.or(partly, self.rate_part.press_points(compression, rate, timing, touched).0)
        } else {
            whole
        }
    }

    /// How the force of [`FeltLaw::press`] bends away from its tangent.
    #[inline(always)]
    pub(crate) fn curvature(
        &self,
        compression: T,
        rate: T,
        timing: &Timing<T>,
        touched: T::Mask,
        memory: &Memory<T>,
    ) -> Curvature<T> {
        if !self.square {
            return self.bend_exactly(compression, rate, timing, touched, memory);
        }
        let whole = self.rate_part.press_square(compression, rate, timing, touched).1;
        let partly = touched.and(compression.le((timing.node * rate).abs()));
        if partly.any() {
            whole.or(partly, self.rate_part.press_points(compression, rate, timing, touched).1)
        } else {
            whole
        }
    }

    /// A law with memory. Out of line, and its arguments by value: a mechanism without such laws pays nothing for them.
    #[cold]
    #[inline(never)]
    fn press_remembering(
        &self,
        compression: T,
        rate: T,
        timing: &Timing<T>,
        touched: T::Mask,
        memory: &Memory<T>,
    ) -> Pressed<T> {
        T::aside(Press(self, Pressing { compression, rate, timing, touched }, memory))
    }

    #[cold]
    #[inline(never)]
    fn bend_remembering(
        &self,
        compression: T,
        rate: T,
        timing: &Timing<T>,
        touched: T::Mask,
        memory: &Memory<T>,
    ) -> Curvature<T> {
        T::aside(Bend(self, Pressing { compression, rate, timing, touched }, memory))
    }

    /// Any law with its exact mean: one with memory has no other.
    pub(crate) fn press_exactly(
        &self,
        compression: T,
        rate: T,
        timing: &Timing<T>,
        touched: T::Mask,
        memory: &Memory<T>,
    ) -> Pressed<T> {
        if self.remembers {
            return self.press_remembering(compression, rate, timing, touched, memory);
        }
        self.rate_part.press_exactly(compression, rate, timing, touched)
    }

    /// How the force of [`FeltLaw::press_exactly`] bends away from its tangent.
    #[inline(always)]
    fn bend_exactly(
        &self,
        compression: T,
        rate: T,
        timing: &Timing<T>,
        touched: T::Mask,
        memory: &Memory<T>,
    ) -> Curvature<T> {
        if self.remembers {
            return self.bend_remembering(compression, rate, timing, touched, memory);
        }
        self.rate_part.press_points(compression, rate, timing, touched).1
    }

    /// Any law on a surface that yields, at the compression and the rate that there would be if it were not pressed.
    ///
    /// With P the law's mean force and P' its slope with the rate, F = P(rate - a F) has the slope P'/(1 + a P'). The
    /// quick test knows nothing of how it bends: a margin of zero leaves such a zone to the exact one.
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
        let slope = T::ONE + carried.surface.mobility * (pressed.tangent / timing.h_theta);
        Pressed { tangent: pressed.tangent / slope, opening: T::ZERO, ..pressed }
    }

    /// How the force of [`FeltLaw::press_yielding`] bends away from its tangent: less than the law itself, F'' =
    /// P''/(1 + a P')^3, at a compression that is no deeper, so that the law's curvature there is a bound.
    pub(crate) fn bend_yielding(
        &self,
        compression: T,
        rate: T,
        timing: &Timing<T>,
        touched: T::Mask,
        carried: Carried<'_, T>,
    ) -> Curvature<T> {
        let (compression, rate) = self.give_way(compression, rate, timing, touched, carried);
        self.bend_exactly(compression, rate, timing, touched, carried.memory)
    }

    /// Compression and its rate at the theta point, less the displacement of a compliant surface under the felt's
    /// force. The arguments are those of the surface without load.
    pub(crate) fn give_way(
        &self,
        compression: T,
        rate: T,
        timing: &Timing<T>,
        touched: T::Mask,
        carried: Carried<'_, T>,
    ) -> (T, T) {
        let mobility = carried.surface.mobility;
        let behind = |force: T| (compression - timing.h_theta * (mobility * force), rate - mobility * force);
        let force = solve(touched, |force| {
            let (compression, rate) = behind(force);
            let pressed = self.press_exactly(compression, rate, timing, touched, carried.memory);
            [pressed.force, mobility * (pressed.tangent / timing.h_theta)]
        });
        behind(force)
    }

    /// What becomes of its memory, where it has one; at the compression and rate of [`FeltLaw::give_way`] on a surface
    /// that yields.
    #[inline(always)]
    pub(crate) fn load_state(
        &self,
        compression: T,
        rate: T,
        timing: &Timing<T>,
        touched: T::Mask,
        memory: &Memory<T>,
    ) -> Option<Memory<T>> {
        let pressing = Pressing { compression, rate, timing, touched };
        if !self.remembers {
            return None;
        }
        Some(self.loss.load_state(&self.rate_part.spring, &pressing, memory))
    }

    /// By how much the energy that its memory holds has grown, J; what the damping force did beyond that is lost.
    pub(crate) fn gained(
        &self,
        compression: T,
        rate: T,
        timing: &Timing<T>,
        touched: T::Mask,
        memory: &Memory<T>,
    ) -> T {
        let Some(after) = self.load_state(compression, rate, timing, touched, memory) else { return T::ZERO };
        let path = Pressing { compression, rate, timing, touched }.path();
        let held =
            |compression: T, memory: &Memory<T>| self.loss.stored_energy(&self.rate_part.spring, compression, memory);
        T::only(touched, held(path.to, &after) - held(path.start, memory))
    }

    /// The memory after a step in which it was not touched, and by how much the energy that it holds has grown, J:
    /// nothing where it holds none.
    #[inline(always)]
    pub(crate) fn relax(&self, timing: &Timing<T>, memory: &Memory<T>) -> (Memory<T>, T) {
        let mut largest = T::ZERO;
        for x in memory {
            largest = largest.max(x.abs());
        }
        if !T::ZERO.lt(largest).any() {
            return ([T::ZERO; MEMORY], T::ZERO);
        }
        let (spring, after) = (&self.rate_part.spring, self.loss.relax(timing, memory));
        (after, self.loss.stored_energy(spring, T::ZERO, &after) - self.loss.stored_energy(spring, T::ZERO, memory))
    }

    /// The largest force of a felt that is pressed no deeper and no faster than this, N.
    #[inline(always)]
    pub(crate) fn largest_force(&self, deepest: T, speed: T) -> T {
        self.largest * self.rate_part.largest_force(deepest, speed)
    }
}
