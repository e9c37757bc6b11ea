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

/// Mechanisms of one topology, stepped together: as many as there are lanes.
pub struct Group<const B: usize, const Z: usize, const N: usize> {
    kind: Kind<B, Z, N>,
}

enum Kind<const B: usize, const Z: usize, const N: usize> {
    #[cfg(target_arch = "x86_64")]
    Eight(Box<kernels::Lanes<avx512::F64x8, B, Z, N>>),
    #[cfg(target_arch = "x86_64")]
    Four(Box<kernels::Lanes<avx2::F64x4, B, Z, N>>),
    OneByOne(Box<OneByOne<B, Z, N>>),
}

struct OneByOne<const B: usize, const Z: usize, const N: usize> {
    models: Vec<Model<f64, B, Z>>,
    states: Vec<State<f64, B, Z>>,
    settings: Settings<f64>,
    scratch: Scratch<f64, B, Z, N>,
}

impl<const B: usize, const Z: usize, const N: usize> Group<B, Z, N> {
    /// Mechanisms where they are now. Where there are as many of them as the processor has `lanes` for, and they differ in their numbers
    /// only, they are stepped at once; otherwise one by one.
    ///
    /// # Panics
    /// If there are not as many states as models.
    pub fn new(
        models: &[Model<f64, B, Z>],
        states: &[State<f64, B, Z>],
        settings: &Settings<f64>,
        lanes: Lanes,
    ) -> Self {
        assert_eq!(models.len(), states.len(), "a state for each model");
        #[cfg(target_arch = "x86_64")]
        match lanes {
            Lanes::Eight => {
                if let Some(eight) = kernels::eight(models, states, settings) {
                    return Group { kind: Kind::Eight(Box::new(eight)) };
                }
            }
            Lanes::Four => {
                if let Some(four) = kernels::four(models, states, settings) {
                    return Group { kind: Kind::Four(Box::new(four)) };
                }
            }
            Lanes::One => {}
        }
        let _ = lanes;
        let (models, states) = (models.to_vec(), states.to_vec());
        Group {
            kind: Kind::OneByOne(Box::new(OneByOne { models, states, settings: *settings, scratch: Scratch::new() })),
        }
    }

    /// How many are stepped at once.
    pub fn lanes(&self) -> Lanes {
        match self.kind {
            #[cfg(target_arch = "x86_64")]
            Kind::Eight(_) => Lanes::Eight,
            #[cfg(target_arch = "x86_64")]
            Kind::Four(_) => Lanes::Four,
            Kind::OneByOne(_) => Lanes::One,
        }
    }

    /// One step of all, with an input for each; writes how each ended. Inputs of different kinds are taken one by one.
    ///
    /// # Panics
    /// If there are fewer inputs or outcomes than mechanisms.
    pub fn step(&mut self, inputs: &[Input<f64>], outcomes: &mut [Outcome]) {
        match &mut self.kind {
            #[cfg(target_arch = "x86_64")]
            Kind::Eight(eight) => eight.step(inputs, outcomes),
            #[cfg(target_arch = "x86_64")]
            Kind::Four(four) => four.step(inputs, outcomes),
            Kind::OneByOne(one) => {
                let OneByOne { models, states, settings, scratch } = one.as_mut();
                for (i, (model, state)) in models.iter().zip(states).enumerate() {
                    outcomes[i] = step(model, settings, &inputs[i], state, scratch).outcome;
                }
            }
        }
    }

    /// One mechanism's absolute angles, rad, and angular velocities, rad/s: what is looked at after every step.
    #[inline]
    pub fn motion(&self, index: usize) -> ([f64; B], [f64; B]) {
        match &self.kind {
            #[cfg(target_arch = "x86_64")]
            Kind::Eight(eight) => eight.motion(index),
            #[cfg(target_arch = "x86_64")]
            Kind::Four(four) => four.motion(index),
            Kind::OneByOne(one) => (one.states[index].angle, one.states[index].velocity),
        }
    }

    /// One mechanism's state.
    pub fn state(&self, index: usize) -> State<f64, B, Z> {
        match &self.kind {
            #[cfg(target_arch = "x86_64")]
            Kind::Eight(eight) => eight.state(index),
            #[cfg(target_arch = "x86_64")]
            Kind::Four(four) => four.state(index),
            Kind::OneByOne(one) => one.states[index].clone(),
        }
    }
}
