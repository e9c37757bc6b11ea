//! Steps that would change nothing are not taken.
//!
//! A step is a function of state and input. Where one left the state identical to the bit, every further step with the identical input
//! does so too, and would report and leave in the scratch what that one did. No threshold, no drift: with or without, the same bits. It
//! needs dry friction that truly sticks.

use crate::model::Model;
use crate::settings::Settings;
use crate::state::{Input, Scratch, State};
use crate::step::{StepReport, step};
use crate::{Real, Scalar};

/// Whether a mechanism's last step changed nothing, and under which input. It belongs to one [`State`] and its [`Settings`]: where either is
/// changed otherwise than by [`Repose::step`], or the [`Scratch`] is used for another state and is to be read, call [`Repose::end`].
#[derive(Debug, Clone, Copy)]
pub struct Repose<T> {
    of: Option<(Input<T>, StepReport)>,
}

impl<T> Repose<T> {
    /// Nothing is known to rest.
    pub const fn none() -> Self {
        Repose { of: None }
    }

    /// The next step is taken.
    pub fn end(&mut self) {
        self.of = None;
    }

    /// Whether the last step changed nothing.
    pub fn is_complete(&self) -> bool {
        self.of.is_some()
    }
}

impl<T: Scalar> Repose<T> {
    /// [`step()`], unless it would change nothing: then only its report is given.
    pub fn step<const B: usize, const Z: usize, const N: usize>(
        &mut self,
        model: &Model<T, B, Z>,
        settings: &Settings<T>,
        input: &Input<T>,
        state: &mut State<T, B, Z>,
        scratch: &mut Scratch<T, B, Z, N>,
    ) -> StepReport {
        if let Some((last, report)) = &self.of
            && last.identical(input)
        {
            return *report;
        }
        // Of what moves no copy is kept to compare with.
        let before = state.stands().then(|| state.clone());
        let report = step(model, settings, input, state, scratch);
        let same = before.as_ref().is_some_and(|before| before.identical(state));
        self.of = same.then_some((*input, report));
        report
    }
}

impl<T: Real, const B: usize, const Z: usize> State<T, B, Z> {
    /// Whether nothing moves, in any lane.
    #[inline(always)]
    pub fn stands(&self) -> bool {
        self.velocity.iter().all(|v| (0..T::LANES).all(|lane| v.lane(lane).to_f64() == 0.0))
    }

    /// Whether two states are the same to the bit, signs of zeros included, in everything that a step's result depends on. (The survey of
    /// zones only tells which of them cannot be touched: with any survey a step gives the same bits.)
    pub fn identical(&self, other: &Self) -> bool {
        let same = |a: &[T], b: &[T]| a.iter().zip(b).all(|(a, b)| same_bits(*a, *b));
        same(&self.velocity, &other.velocity)
            && same(&self.angle, &other.angle)
            && same(&self.trend, &other.trend)
            && same(&self.pivot_friction, &other.pivot_friction)
            && same(&self.tangential, &other.tangential)
            && same(&self.side, &other.side)
            && same_bits(self.rigid_force, other.rigid_force)
    }
}

impl<T: Real> Input<T> {
    /// Whether two inputs are the same to the bit. What is not a number is identical to itself.
    pub fn identical(&self, other: &Self) -> bool {
        match (*self, *other) {
            (Input::Free, Input::Free) => true,
            (Input::Force(a), Input::Force(b)) => same_bits(a, b),
            (Input::Motion { position: a, velocity: v }, Input::Motion { position: b, velocity: w }) => {
                same_bits(a, b) && same_bits(v, w)
            }
            (Input::Rigid { velocity: a }, Input::Rigid { velocity: b }) => same_bits(a, b),
            _ => false,
        }
    }
}

/// Widening to f64 keeps every bit's meaning.
fn same_bits<T: Real>(a: T, b: T) -> bool {
    (0..T::LANES).all(|lane| a.lane(lane).to_f64().to_bits() == b.lane(lane).to_f64().to_bits())
}
