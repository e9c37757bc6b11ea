//! Many mechanisms at once: in the lanes of the processor's vectors.
//!
//! The physics is `moreau`'s one generic kernel ([`moreau::step_lanes`]); this crate gives it numbers that are four (AVX2) or eight
//! (AVX-512) wide, compiled for those instructions and chosen when the program runs. Elsewhere the same mechanisms are stepped one
//! after the other. Either way every mechanism gets the numbers that [`moreau::step()`] gives it alone, to rounding.

#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
#[cfg(target_arch = "x86_64")]
mod kernels;
#[cfg(target_arch = "x86_64")]
mod number;

use moreau::{Input, Model, Outcome, Scratch, Settings, State, step};

/// Mechanisms in a group.
pub const WIDTH: usize = 8;

/// How many mechanisms of a group are stepped at once.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Lanes {
    /// One after the other.
    One,
    /// Four doubles in a register: AVX2.
    Four,
    /// Eight: AVX-512.
    Eight,
}

impl Lanes {
    /// The most that this processor has instructions for.
    pub fn most() -> Self {
        #[cfg(target_arch = "x86_64")]
        if kernels::has_avx512() {
            return Lanes::Eight;
        } else if kernels::has_avx2() {
            return Lanes::Four;
        }
        Lanes::One
    }

    /// Mechanisms at once.
    pub fn count(self) -> usize {
        match self {
            Lanes::One => 1,
            Lanes::Four => 4,
            Lanes::Eight => 8,
        }
    }
}

/// [`WIDTH`] mechanisms of one topology, stepped together.
pub struct Group<const B: usize, const Z: usize, const N: usize> {
    kind: Kind<B, Z, N>,
}

enum Kind<const B: usize, const Z: usize, const N: usize> {
    #[cfg(target_arch = "x86_64")]
    Eight(Box<kernels::Lanes<avx512::F64x8, B, Z, N>>),
    #[cfg(target_arch = "x86_64")]
    Four(Box<[kernels::Lanes<avx2::F64x4, B, Z, N>; 2]>),
    One(Box<OneByOne<B, Z, N>>),
}

struct OneByOne<const B: usize, const Z: usize, const N: usize> {
    models: [Model<f64, B, Z>; WIDTH],
    states: [State<f64, B, Z>; WIDTH],
    settings: Settings<f64>,
    scratch: Scratch<f64, B, Z, N>,
}

impl<const B: usize, const Z: usize, const N: usize> Group<B, Z, N> {
    /// Mechanisms where they are now, `at_most` so many at once: fewer where the processor does not have the instructions, one by one
    /// where the mechanisms differ in more than their numbers.
    pub fn new(
        models: [Model<f64, B, Z>; WIDTH],
        states: [State<f64, B, Z>; WIDTH],
        settings: Settings<f64>,
        at_most: Lanes,
    ) -> Self {
        #[cfg(target_arch = "x86_64")]
        {
            if at_most == Lanes::Eight
                && let Some(eight) = kernels::eight(&models, &states, &settings)
            {
                return Group { kind: Kind::Eight(Box::new(eight)) };
            }
            let half = |k: usize| kernels::four(&models[4 * k..4 * k + 4], &states[4 * k..4 * k + 4], &settings);
            if at_most >= Lanes::Four
                && let (Some(first), Some(second)) = (half(0), half(1))
            {
                return Group { kind: Kind::Four(Box::new([first, second])) };
            }
        }
        let _ = at_most;
        Group { kind: Kind::One(Box::new(OneByOne { models, states, settings, scratch: Scratch::new() })) }
    }

    /// How many are stepped at once.
    pub fn lanes(&self) -> Lanes {
        match self.kind {
            #[cfg(target_arch = "x86_64")]
            Kind::Eight(_) => Lanes::Eight,
            #[cfg(target_arch = "x86_64")]
            Kind::Four(_) => Lanes::Four,
            Kind::One(_) => Lanes::One,
        }
    }

    /// One step of all; says how each ended. The inputs of mechanisms that are stepped at once must be of one kind (they are taken one
    /// by one otherwise).
    pub fn step(&mut self, inputs: &[Input<f64>; WIDTH]) -> [Outcome; WIDTH] {
        let mut outcomes = [Outcome::Converged; WIDTH];
        match &mut self.kind {
            #[cfg(target_arch = "x86_64")]
            Kind::Eight(eight) => eight.step(inputs, &mut outcomes),
            #[cfg(target_arch = "x86_64")]
            Kind::Four(halves) => {
                for (k, four) in halves.iter_mut().enumerate() {
                    four.step(&inputs[4 * k..4 * k + 4], &mut outcomes[4 * k..4 * k + 4]);
                }
            }
            Kind::One(one) => {
                let OneByOne { models, states, settings, scratch } = one.as_mut();
                for i in 0..WIDTH {
                    outcomes[i] = step(&models[i], settings, &inputs[i], &mut states[i], scratch).outcome;
                }
            }
        }
        outcomes
    }

    /// One mechanism's state.
    pub fn state(&self, index: usize) -> State<f64, B, Z> {
        match &self.kind {
            #[cfg(target_arch = "x86_64")]
            Kind::Eight(eight) => eight.state(index),
            #[cfg(target_arch = "x86_64")]
            Kind::Four(halves) => halves[index / 4].state(index % 4),
            Kind::One(one) => one.states[index].clone(),
        }
    }
}
