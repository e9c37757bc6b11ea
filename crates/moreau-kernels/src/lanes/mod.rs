//! Several mechanisms in parallel in the processor's vector lanes.
//!
//! The physics is `moreau`'s one generic kernel ([`moreau::step_lanes`]). This module supplies numbers that are four
//! doubles or eight numbers of single precision wide (AVX2), compiled for those instructions and selected at run time.
//! On other processors the mechanisms are stepped one after the other. Either way every mechanism gets the result of
//! [`moreau::step()`] alone, to rounding. Models and states are passed in doubles even in single precision.

#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx2_single;
#[cfg(target_arch = "x86_64")]
mod kernels;
#[cfg(target_arch = "x86_64")]
mod number;

use moreau::{Model, Settings, SiteInput, Sleep, State, StepOutcome, Workspace, step_out_of_line};

/// Number of mechanisms stepped in parallel, and their precision.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Lanes {
    /// One mechanism after the other, in doubles.
    One,
    /// Four doubles in a register: AVX2.
    Four,
    /// Eight numbers of single precision in a register: AVX2.
    EightSingle,
}

impl Lanes {
    /// Returns all lanes that this processor supports, narrow ones first.
    pub fn here() -> impl Iterator<Item = Self> {
        let all = [Lanes::One, Lanes::Four, Lanes::EightSingle];
        all.into_iter().filter(|lanes| lanes.is_here())
    }

    /// Returns the most lanes of doubles that this processor supports.
    pub fn most() -> Self {
        if Lanes::Four.is_here() { Lanes::Four } else { Lanes::One }
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
            #[cfg(not(target_arch = "x86_64"))]
            _ => false,
        }
    }

    /// Returns the number of mechanisms stepped in parallel.
    pub fn count(self) -> usize {
        match self {
            Lanes::One => 1,
            Lanes::Four => 4,
            Lanes::EightSingle => 8,
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
    /// Behind a pointer, so that a size's code is compiled only for the lanes of which such groups are made.
    together: Box<dyn Together<B, Z>>,
}

/// What a group is in one kind of lanes. The functions are those of [`Group`].
trait Together<const B: usize, const Z: usize>: Send {
    fn lanes(&self) -> Lanes;
    fn step(&mut self, inputs: &[SiteInput<f64>], outcomes: &mut [StepOutcome]);
    fn step_or_rest(&mut self, inputs: &[SiteInput<f64>], outcomes: &mut [StepOutcome]);
    fn is_at_rest(&self) -> bool;
    fn copy_motion(&self, index: usize, angles: &mut [f64; B], velocities: &mut [f64; B]);
    fn copy_state(&self, index: usize, state: &mut State<f64, B, Z>);
    fn state(&self, index: usize) -> State<f64, B, Z>;
}

struct OneByOne<const B: usize, const Z: usize, const N: usize> {
    models: Vec<Model<f64, B, Z>>,
    states: Vec<State<f64, B, Z>>,
    settings: Settings<f64>,
    workspace: Workspace<f64, B, Z, N>,
    sleeps: Vec<Sleep<f64>>,
}

impl<const B: usize, const Z: usize, const N: usize> Together<B, Z> for OneByOne<B, Z, N> {
    fn lanes(&self) -> Lanes {
        Lanes::One
    }

    fn step(&mut self, inputs: &[SiteInput<f64>], outcomes: &mut [StepOutcome]) {
        let OneByOne { models, states, settings, workspace, sleeps } = self;
        for (i, (model, state)) in models.iter().zip(states).enumerate() {
            sleeps[i].wake();
            outcomes[i] = step_out_of_line(model, settings, &inputs[i], state, workspace).outcome;
        }
    }

    fn step_or_rest(&mut self, inputs: &[SiteInput<f64>], outcomes: &mut [StepOutcome]) {
        let OneByOne { models, states, settings, workspace, sleeps } = self;
        for (i, (model, state)) in models.iter().zip(states).enumerate() {
            outcomes[i] = sleeps[i].step(model, settings, &inputs[i], state, workspace).outcome;
        }
    }

    fn is_at_rest(&self) -> bool {
        self.sleeps.iter().all(Sleep::is_asleep)
    }

    fn copy_motion(&self, index: usize, angles: &mut [f64; B], velocities: &mut [f64; B]) {
        (*angles, *velocities) = (self.states[index].angle, self.states[index].velocity);
    }

    fn copy_state(&self, index: usize, state: &mut State<f64, B, Z>) {
        **state = *self.states[index];
    }

    fn state(&self, index: usize) -> State<f64, B, Z> {
        self.states[index].clone()
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
        match lanes {
            Lanes::One => {}
            Lanes::Four => {
                if let Some(together) = kernels::four::<B, Z, N>(models, states, settings) {
                    return Group { together };
                }
            }
            Lanes::EightSingle => {
                if let Some(together) = kernels::eight_single::<B, Z, N>(models, states, settings) {
                    return Group { together };
                }
            }
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
            && let Some(together) = kernels::four::<B, Z, N>(models, states, settings)
        {
            return Group { together };
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
            && let Some(together) = kernels::eight_single::<B, Z, N>(models, states, settings)
        {
            return Group { together };
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
        let one_by_one: OneByOne<B, Z, N> = OneByOne {
            models: models.to_vec(),
            states: states.to_vec(),
            settings: *settings,
            workspace: Workspace::new(),
            sleeps: vec![Sleep::awake(); models.len()],
        };
        Group { together: Box::new(one_by_one) }
    }

    /// Returns the lanes in which the mechanisms are stepped.
    pub fn lanes(&self) -> Lanes {
        self.together.lanes()
    }

    /// Advances all mechanisms by one step, with an input for each, and writes their outcomes. If the inputs are of
    /// different kinds, the mechanisms are stepped one by one.
    ///
    /// # Panics
    /// Panics if there are fewer inputs or outcomes than mechanisms.
    pub fn step(&mut self, inputs: &[SiteInput<f64>], outcomes: &mut [StepOutcome]) {
        self.together.step(inputs, outcomes);
    }

    /// Advances all mechanisms as [`Group::step`] does, but skips steps that would change nothing; lanes are skipped
    /// only if no lane would change. Results are bit-identical.
    ///
    /// # Panics
    /// As [`Group::step`].
    pub fn step_or_rest(&mut self, inputs: &[SiteInput<f64>], outcomes: &mut [StepOutcome]) {
        self.together.step_or_rest(inputs, outcomes);
    }

    /// Returns whether the last call of [`Group::step_or_rest`] changed nothing.
    pub fn is_at_rest(&self) -> bool {
        self.together.is_at_rest()
    }

    /// Returns one mechanism's absolute angles, rad, and angular velocities, rad/s.
    pub fn motion(&self, index: usize) -> ([f64; B], [f64; B]) {
        let (mut angles, mut velocities) = ([0.0; B], [0.0; B]);
        self.copy_motion(index, &mut angles, &mut velocities);
        (angles, velocities)
    }

    /// [`Group::motion`] into places that are there: what is looked at after every step of a study.
    pub(crate) fn copy_motion(&self, index: usize, angles: &mut [f64; B], velocities: &mut [f64; B]) {
        self.together.copy_motion(index, angles, velocities);
    }

    /// One mechanism's state, into one that is there; what that knows of the zones' distances stays as it was.
    pub(crate) fn copy_state(&self, index: usize, state: &mut State<f64, B, Z>) {
        self.together.copy_state(index, state);
    }

    /// Returns one mechanism's state.
    pub fn state(&self, index: usize) -> State<f64, B, Z> {
        self.together.state(index)
    }
}

fn check<const B: usize, const Z: usize>(models: &[Model<f64, B, Z>], states: &[State<f64, B, Z>], room: usize) {
    assert_eq!(models.len(), states.len(), "a state for each model");
    assert!(models.iter().all(|model| model.laws() <= room), "room for all set-valued laws");
}
