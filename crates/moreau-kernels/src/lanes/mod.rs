//! Several mechanisms at once in the lanes of the processor's vectors.
//!
//! The physics is `moreau`'s one generic kernel ([`moreau::step_lanes`]); this module gives it numbers that are four
//! (AVX2) or eight (AVX-512) wide, compiled for those instructions and chosen when the program runs. Elsewhere the same
//! mechanisms are stepped one after the other. Either way every mechanism gets the numbers that [`moreau::step()`]
//! gives it alone, to rounding. Eight fit in AVX2 in single precision, for those who can do with it: models and states
//! go in and out in doubles all the same.

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

/// Number of mechanisms that are stepped at once, and their precision.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Lanes {
    /// One after the other, in doubles.
    One,
    /// Four doubles in a register: AVX2.
    Four,
    /// Eight: AVX-512.
    Eight,
    /// Eight numbers of single precision in a register: AVX2.
    EightSingle,
}

impl Lanes {
    /// All that this processor has instructions for, the narrow ones first.
    pub fn here() -> impl Iterator<Item = Self> {
        let all = [Lanes::One, Lanes::Four, Lanes::Eight, Lanes::EightSingle];
        all.into_iter().filter(|lanes| lanes.is_here())
    }

    /// The most doubles that this processor has instructions for.
    pub fn most() -> Self {
        [Lanes::Eight, Lanes::Four].into_iter().find(|lanes| lanes.is_here()).unwrap_or(Lanes::One)
    }

    /// Returns the most lanes in single precision; doubles if the processor has no lanes.
    pub fn most_single() -> Self {
        if Lanes::EightSingle.is_here() { Lanes::EightSingle } else { Lanes::One }
    }

    /// Whether this processor has the instructions.
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

    /// Mechanisms at once.
    pub fn count(self) -> usize {
        match self {
            Lanes::One => 1,
            Lanes::Four => 4,
            Lanes::Eight | Lanes::EightSingle => 8,
        }
    }

    /// Whether numbers are of single precision.
    pub fn is_single(self) -> bool {
        self == Lanes::EightSingle
    }

    /// The doubles that the same registers hold.
    pub fn in_doubles(self) -> Self {
        match self {
            Lanes::EightSingle => Lanes::Four,
            doubles => doubles,
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
    /// Mechanisms where they are now. Where there are as many of them as the processor has `lanes` for, and they differ
    /// in their numbers only, they are stepped at once; otherwise one by one.
    ///
    /// # Panics
    /// If there are not as many states as models, or a model has more than N set-valued laws ([`Model::laws`]).
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

    /// Number of mechanisms that are stepped at once.
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
            #[cfg(target_arch = "x86_64")]
            Kind::EightSingle(eight) => eight.step(inputs, outcomes),
            Kind::OneByOne(one) => one.step(inputs, outcomes),
        }
    }

    /// As `step`, without the steps that would change nothing: of lanes, where none of them would change. The same
    /// bits either way.
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

    /// Whether the last step, if it was one of [`Group::step_or_rest`], changed nothing.
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

    /// One mechanism's absolute angles, rad, and angular velocities, rad/s: what is looked at after every step.
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

    /// One mechanism's state.
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
