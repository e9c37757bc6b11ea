//! Several mechanisms in parallel in the processor's vector lanes.
//!
//! The physics is `moreau`'s one generic kernel ([`moreau::step_lanes`]). This module supplies numbers that are four
//! (AVX2) or eight (AVX-512) doubles wide, compiled for those instructions and selected at run time. On other
//! processors the mechanisms are stepped one after the other. Either way every mechanism gets the result of
//! [`moreau::step()`] alone, to rounding. AVX2 holds eight numbers in single precision; models and states are passed in
//! doubles even then.

#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx2_single;
#[cfg(target_arch = "x86_64")]
mod avx512;
#[cfg(target_arch = "x86_64")]
mod kernels;
#[cfg(target_arch = "x86_64")]
mod number;

use moreau::{Input, Model, Outcome, Settings, Sleep, State, Workspace, step_out_of_line};

/// Number of mechanisms stepped in parallel, and their precision.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Lanes {
    /// One mechanism after the other, in doubles.
    One,
    /// Four doubles in a register: AVX2.
    Four,
    /// Eight doubles in a register: AVX-512.
    Eight,
    /// Eight numbers of single precision in a register: AVX2.
    EightSingle,
}

impl Lanes {
    /// Returns all lanes that this processor supports, narrow ones first.
    pub fn here() -> impl Iterator<Item = Self> {
        let all = [Lanes::One, Lanes::Four, Lanes::Eight, Lanes::EightSingle];
        all.into_iter().filter(|lanes| lanes.is_here())
    }

    /// Returns the widest lanes of doubles that this processor supports.
    pub fn most() -> Self {
        [Lanes::Eight, Lanes::Four].into_iter().find(|lanes| lanes.is_here()).unwrap_or(Lanes::One)
    }

    /// Returns the most lanes in single precision; doubles if the processor has no lanes.
    pub fn most_single() -> Self {
        if Lanes::EightSingle.is_here() { Lanes::EightSingle } else { Lanes::One }
    }

    /// Returns whether this processor supports these lanes.
    pub fn is_here(self) -> bool {
        match self {
            Lanes::One => true,
            #[cfg(target_arch = "x86_64")]
            Lanes::Four | Lanes::EightSingle => kernels::has_avx2(),
            #[cfg(target_arch = "x86_64")]
            Lanes::Eight => kernels::has_avx512(),
            #[cfg(not(target_arch = "x86_64"))]
            _ => false,
        }
    }

    /// Returns the number of mechanisms stepped in parallel.
    pub fn count(self) -> usize {
        match self {
            Lanes::One => 1,
            Lanes::Four => 4,
            Lanes::Eight | Lanes::EightSingle => 8,
        }
    }

    /// Returns whether the numbers have single precision.
    pub fn is_single(self) -> bool {
        self == Lanes::EightSingle
    }

    /// Returns the lanes of doubles in the same registers.
    pub fn in_doubles(self) -> Self {
        match self {
            Lanes::EightSingle => Lanes::Four,
            doubles => doubles,
        }
    }
}

/// Mechanisms of one topology, stepped together.
pub struct Group<const B: usize, const Z: usize, const N: usize> {
    kind: Kind<B, Z, N>,
}

enum Kind<const B: usize, const Z: usize, const N: usize> {
    #[cfg(target_arch = "x86_64")]
    Eight(Box<kernels::Lanes<avx512::F64x8, B, Z, N>>),
    #[cfg(target_arch = "x86_64")]
    Four(Box<kernels::Lanes<avx2::F64x4, B, Z, N>>),
    #[cfg(target_arch = "x86_64")]
    EightSingle(Box<kernels::Lanes<avx2_single::F32x8, B, Z, N>>),
    OneByOne(Box<OneByOne<B, Z, N>>),
}

struct OneByOne<const B: usize, const Z: usize, const N: usize> {
    models: Vec<Model<f64, B, Z>>,
    states: Vec<State<f64, B, Z>>,
    settings: Settings<f64>,
    workspace: Workspace<f64, B, Z, N>,
    sleeps: Vec<Sleep<f64>>,
}

impl<const B: usize, const Z: usize, const N: usize> OneByOne<B, Z, N> {
    #[inline(never)]
    fn step(&mut self, inputs: &[Input<f64>], outcomes: &mut [Outcome]) {
        let OneByOne { models, states, settings, workspace, sleeps } = self;
        for (i, (model, state)) in models.iter().zip(states).enumerate() {
            sleeps[i].wake();
            outcomes[i] = step_out_of_line(model, settings, &inputs[i], state, workspace).outcome;
        }
    }

    #[inline(never)]
    fn step_or_rest(&mut self, inputs: &[Input<f64>], outcomes: &mut [Outcome]) {
        let OneByOne { models, states, settings, workspace, sleeps } = self;
        for (i, (model, state)) in models.iter().zip(states).enumerate() {
            outcomes[i] = sleeps[i].step(model, settings, &inputs[i], state, workspace).outcome;
        }
    }
}

impl<const B: usize, const Z: usize, const N: usize> Group<B, Z, N> {
    /// Groups mechanisms in given states. If they are as many as the processor has `lanes` for, and differ in their
    /// numbers only, they are stepped in parallel; otherwise one by one.
    ///
    /// # Panics
    /// Panics if the numbers of states and models differ, or a model has more than N set-valued laws ([`Model::laws`]).
    pub fn new(
        models: &[Model<f64, B, Z>],
        states: &[State<f64, B, Z>],
        settings: &Settings<f64>,
        lanes: Lanes,
    ) -> Self {
        check(models, states, N);
        #[cfg(target_arch = "x86_64")]
        let kind = match lanes {
            Lanes::One => None,
            Lanes::Four => kernels::four(models, states, settings).map(Kind::Four),
            Lanes::Eight => kernels::eight(models, states, settings).map(Kind::Eight),
            Lanes::EightSingle => kernels::eight_single(models, states, settings).map(Kind::EightSingle),
        };
        #[cfg(target_arch = "x86_64")]
        if let Some(kind) = kind {
            return Group { kind };
        }
        let _ = lanes;
        Group::one_by_one(models, states, settings)
    }

    /// Four at once in doubles, or one by one: no other lanes are compiled for a size of which only such groups are
    /// made.
    ///
    /// # Panics
    /// As [`Group::new`].
    pub(crate) fn in_fours(models: &[Model<f64, B, Z>], states: &[State<f64, B, Z>], settings: &Settings<f64>) -> Self {
        check(models, states, N);
        #[cfg(target_arch = "x86_64")]
        if models.len() == Lanes::Four.count()
            && let Some(four) = kernels::four(models, states, settings)
        {
            return Group { kind: Kind::Four(four) };
        }
        Group::one_by_one(models, states, settings)
    }

    /// Eight at once in doubles, or one by one: no other lanes are compiled for a size of which only such groups are
    /// made.
    ///
    /// # Panics
    /// As [`Group::new`].
    pub(crate) fn in_eights(
        models: &[Model<f64, B, Z>],
        states: &[State<f64, B, Z>],
        settings: &Settings<f64>,
    ) -> Self {
        check(models, states, N);
        #[cfg(target_arch = "x86_64")]
        if models.len() == Lanes::Eight.count()
            && let Some(eight) = kernels::eight(models, states, settings)
        {
            return Group { kind: Kind::Eight(eight) };
        }
        Group::one_by_one(models, states, settings)
    }

    /// Eight at once in single precision, or one by one: no other lanes are compiled for a size of which only such
    /// groups are made.
    ///
    /// # Panics
    /// As [`Group::new`].
    pub(crate) fn in_eights_single(
        models: &[Model<f64, B, Z>],
        states: &[State<f64, B, Z>],
        settings: &Settings<f64>,
    ) -> Self {
        check(models, states, N);
        #[cfg(target_arch = "x86_64")]
        if models.len() == Lanes::EightSingle.count()
            && let Some(eight) = kernels::eight_single(models, states, settings)
        {
            return Group { kind: Kind::EightSingle(eight) };
        }
        Group::one_by_one(models, states, settings)
    }

    /// The same, stepped one by one whatever the processor has: no lanes are compiled for a size of which only such
    /// groups are made.
    pub(crate) fn one_by_one(
        models: &[Model<f64, B, Z>],
        states: &[State<f64, B, Z>],
        settings: &Settings<f64>,
    ) -> Self {
        let one_by_one = OneByOne {
            models: models.to_vec(),
            states: states.to_vec(),
            settings: *settings,
            workspace: Workspace::new(),
            sleeps: vec![Sleep::awake(); models.len()],
        };
        Group { kind: Kind::OneByOne(Box::new(one_by_one)) }
    }

    /// Returns the lanes in which the mechanisms are stepped.
    pub fn lanes(&self) -> Lanes {
        match self.kind {
            #[cfg(target_arch = "x86_64")]
            Kind::Eight(_) => Lanes::Eight,
            #[cfg(target_arch = "x86_64")]
            Kind::Four(_) => Lanes::Four,
            #[cfg(target_arch = "x86_64")]
            Kind::EightSingle(_) => Lanes::EightSingle,
            Kind::OneByOne(_) => Lanes::One,
        }
    }

    /// Advances all mechanisms by one step, with an input for each, and writes their outcomes. If the inputs are of
    /// different kinds, the mechanisms are stepped one by one.
    ///
    /// # Panics
    /// Panics if there are fewer inputs or outcomes than mechanisms.
    pub fn step(&mut self, inputs: &[Input<f64>], outcomes: &mut [Outcome]) {
        match &mut self.kind {
            #[cfg(target_arch = "x86_64")]
            Kind::Eight(eight) => eight.step(inputs, outcomes),
            #[cfg(target_arch = "x86_64")]
            Kind::Four(four) => four.step(inputs, outcomes),
            #[cfg(target_arch = "x86_64")]
            Kind::EightSingle(eight) => eight.step(inputs, outcomes),
            Kind::OneByOne(one) => one.step(inputs, outcomes),
        }
    }

    /// Advances all mechanisms as [`Group::step`] does, but skips steps that would change nothing; lanes are skipped
    /// only if no lane would change. Results are bit-identical.
    ///
    /// # Panics
    /// As [`Group::step`].
    pub fn step_or_rest(&mut self, inputs: &[Input<f64>], outcomes: &mut [Outcome]) {
        match &mut self.kind {
            #[cfg(target_arch = "x86_64")]
            Kind::Eight(eight) => eight.step_or_rest(inputs, outcomes),
            #[cfg(target_arch = "x86_64")]
            Kind::Four(four) => four.step_or_rest(inputs, outcomes),
            #[cfg(target_arch = "x86_64")]
            Kind::EightSingle(eight) => eight.step_or_rest(inputs, outcomes),
            Kind::OneByOne(one) => one.step_or_rest(inputs, outcomes),
        }
    }

    /// Returns whether the last call of [`Group::step_or_rest`] changed nothing.
    pub fn is_at_rest(&self) -> bool {
        match &self.kind {
            #[cfg(target_arch = "x86_64")]
            Kind::Eight(eight) => eight.is_at_rest(),
            #[cfg(target_arch = "x86_64")]
            Kind::Four(four) => four.is_at_rest(),
            #[cfg(target_arch = "x86_64")]
            Kind::EightSingle(eight) => eight.is_at_rest(),
            Kind::OneByOne(one) => one.sleeps.iter().all(Sleep::is_asleep),
        }
    }

    /// Returns one mechanism's absolute angles, rad, and angular velocities, rad/s.
    #[inline]
    pub fn motion(&self, index: usize) -> ([f64; B], [f64; B]) {
        match &self.kind {
            #[cfg(target_arch = "x86_64")]
            Kind::Eight(eight) => eight.motion(index),
            #[cfg(target_arch = "x86_64")]
            Kind::Four(four) => four.motion(index),
            #[cfg(target_arch = "x86_64")]
            Kind::EightSingle(eight) => eight.motion(index),
            Kind::OneByOne(one) => (one.states[index].angle, one.states[index].velocity),
        }
    }

    /// [`Group::motion`] into places that are there: what is looked at after every step of a study.
    #[inline]
    pub(crate) fn copy_motion(&self, index: usize, angles: &mut [f64; B], velocities: &mut [f64; B]) {
        match &self.kind {
            #[cfg(target_arch = "x86_64")]
            Kind::Eight(eight) => eight.copy_motion(index, angles, velocities),
            #[cfg(target_arch = "x86_64")]
            Kind::Four(four) => four.copy_motion(index, angles, velocities),
            #[cfg(target_arch = "x86_64")]
            Kind::EightSingle(eight) => eight.copy_motion(index, angles, velocities),
            Kind::OneByOne(one) => (*angles, *velocities) = (one.states[index].angle, one.states[index].velocity),
        }
    }

    /// One mechanism's state, into one that is there; what that knows of the zones' distances stays as it was.
    pub(crate) fn copy_state(&self, index: usize, state: &mut State<f64, B, Z>) {
        match &self.kind {
            #[cfg(target_arch = "x86_64")]
            Kind::Eight(eight) => eight.copy_state(index, state),
            #[cfg(target_arch = "x86_64")]
            Kind::Four(four) => four.copy_state(index, state),
            #[cfg(target_arch = "x86_64")]
            Kind::EightSingle(eight) => eight.copy_state(index, state),
            Kind::OneByOne(one) => **state = *one.states[index],
        }
    }

    /// Returns one mechanism's state.
    pub fn state(&self, index: usize) -> State<f64, B, Z> {
        match &self.kind {
            #[cfg(target_arch = "x86_64")]
            Kind::Eight(eight) => eight.state(index),
            #[cfg(target_arch = "x86_64")]
            Kind::Four(four) => four.state(index),
            #[cfg(target_arch = "x86_64")]
            Kind::EightSingle(eight) => eight.state(index),
            Kind::OneByOne(one) => one.states[index].clone(),
        }
    }
}

fn check<const B: usize, const Z: usize>(models: &[Model<f64, B, Z>], states: &[State<f64, B, Z>], room: usize) {
    assert_eq!(models.len(), states.len(), "a state for each model");
    assert!(models.iter().all(|model| model.laws() <= room), "room for all set-valued laws");
}
