//! Many mechanisms at once: in the lanes of the processor's vectors.
//!
//! The physics is `moreau`'s one generic kernel ([`moreau::step_lanes`]); this crate gives it numbers that are four wide, compiled for
//! AVX2 and chosen when the program runs. Elsewhere the same four mechanisms are stepped one after the other. Either way every
//! mechanism gets the numbers that [`moreau::step()`] gives it alone.

#[cfg(target_arch = "x86_64")]
mod avx2;

use moreau::{Input, Model, Outcome, Scratch, Settings, State, step};

/// Mechanisms in a group.
pub const WIDTH: usize = 4;

/// Four mechanisms of one topology, stepped together.
pub struct Group<const B: usize, const Z: usize, const N: usize> {
    kind: Kind<B, Z, N>,
}

enum Kind<const B: usize, const Z: usize, const N: usize> {
    #[cfg(target_arch = "x86_64")]
    Avx2(Box<avx2_group::Lanes<B, Z, N>>),
    OneByOne(Box<OneByOne<B, Z, N>>),
}

struct OneByOne<const B: usize, const Z: usize, const N: usize> {
    models: [Model<f64, B, Z>; WIDTH],
    states: [State<f64, B, Z>; WIDTH],
    settings: Settings<f64>,
    scratch: Scratch<f64, B, Z, N>,
}

impl<const B: usize, const Z: usize, const N: usize> Group<B, Z, N> {
    /// Four mechanisms where they are now. Where the processor has AVX2 and the four differ in their numbers only, in lanes; otherwise
    /// (or if told so) one by one.
    pub fn new(
        models: [Model<f64, B, Z>; WIDTH],
        states: [State<f64, B, Z>; WIDTH],
        settings: Settings<f64>,
        in_lanes: bool,
    ) -> Self {
        #[cfg(target_arch = "x86_64")]
        if in_lanes && let Some(lanes) = avx2_group::Lanes::new(&models, &states, &settings) {
            return Group { kind: Kind::Avx2(Box::new(lanes)) };
        }
        let _ = in_lanes;
        Group { kind: Kind::OneByOne(Box::new(OneByOne { models, states, settings, scratch: Scratch::new() })) }
    }

    /// Whether the four are stepped in lanes.
    pub fn in_lanes(&self) -> bool {
        !matches!(self.kind, Kind::OneByOne(_))
    }

    /// One step of all four; says how each ended. The inputs must be of one kind for the lanes to be used (they are taken one by one
    /// otherwise).
    pub fn step(&mut self, inputs: &[Input<f64>; WIDTH]) -> [Outcome; WIDTH] {
        match &mut self.kind {
            #[cfg(target_arch = "x86_64")]
            Kind::Avx2(lanes) => lanes.step(inputs),
            Kind::OneByOne(one) => {
                let OneByOne { models, states, settings, scratch } = one.as_mut();
                core::array::from_fn(|i| step(&models[i], settings, &inputs[i], &mut states[i], scratch).outcome)
            }
        }
    }

    /// One mechanism's absolute angles, rad, and angular velocities, rad/s: what is looked at after every step.
    #[inline(always)]
    pub fn motion(&self, index: usize) -> ([f64; B], [f64; B]) {
        match &self.kind {
            #[cfg(target_arch = "x86_64")]
            Kind::Avx2(lanes) => lanes.motion(index),
            Kind::OneByOne(one) => (one.states[index].angle, one.states[index].velocity),
        }
    }

    /// One mechanism's state.
    pub fn state(&self, index: usize) -> State<f64, B, Z> {
        match &self.kind {
            #[cfg(target_arch = "x86_64")]
            Kind::Avx2(lanes) => lanes.state(index),
            Kind::OneByOne(one) => one.states[index].clone(),
        }
    }
}

#[cfg(target_arch = "x86_64")]
mod avx2_group {
    use moreau::{Input, LanesReport, Mask, Model, Outcome, Real, Scratch, Settings, State, step, step_lanes};

    use crate::WIDTH;
    use crate::avx2::{F64x4, M64x4};

    /// Four mechanisms in lanes; exists only where AVX2 has been found.
    pub struct Lanes<const B: usize, const Z: usize, const N: usize> {
        model: Model<F64x4, B, Z>,
        state: State<F64x4, B, Z>,
        settings: Settings<F64x4>,
        scratch: Scratch<F64x4, B, Z, N>,
        models: [Model<f64, B, Z>; WIDTH],
        own_settings: Settings<f64>,
        own_scratch: Scratch<f64, B, Z, N>,
    }

    impl<const B: usize, const Z: usize, const N: usize> Lanes<B, Z, N> {
        pub fn new(
            models: &[Model<f64, B, Z>; WIDTH],
            states: &[State<f64, B, Z>; WIDTH],
            settings: &Settings<f64>,
        ) -> Option<Self> {
            if !is_x86_feature_detected!("avx2") {
                return None;
            }
            Some(Lanes {
                model: Model::of_lanes(&models.each_ref())?,
                state: State::of_lanes(&states.each_ref()),
                settings: Settings::in_lanes(settings),
                scratch: Scratch::new(),
                models: models.clone(),
                own_settings: *settings,
                own_scratch: Scratch::new(),
            })
        }

        pub fn step(&mut self, inputs: &[Input<f64>; WIDTH]) -> [Outcome; WIDTH] {
            let Some(input) = Input::of_lanes(inputs) else { return self.one_by_one(inputs) };
            // SAFETY: a `Lanes` is made only where AVX2 has been detected.
            let report = unsafe { avx2_step(&self.model, &self.settings, &input, &mut self.state, &mut self.scratch) };
            core::array::from_fn(|i| match (report.finite.lane(i), report.converged.lane(i)) {
                (false, _) => Outcome::NonFinite,
                (true, true) => Outcome::Converged,
                (true, false) => Outcome::IterationLimit,
            })
        }

        /// Inputs of different kinds: each lane alone.
        #[cold]
        fn one_by_one(&mut self, inputs: &[Input<f64>; WIDTH]) -> [Outcome; WIDTH] {
            let mut states: [State<f64, B, Z>; WIDTH] = core::array::from_fn(|i| self.state(i));
            let outcomes = core::array::from_fn(|i| {
                step(&self.models[i], &self.own_settings, &inputs[i], &mut states[i], &mut self.own_scratch).outcome
            });
            self.state = State::of_lanes(&states.each_ref());
            outcomes
        }

        #[inline(always)]
        pub fn motion(&self, index: usize) -> ([f64; B], [f64; B]) {
            (self.state.angle.map(|x| x.lane(index)), self.state.velocity.map(|x| x.lane(index)))
        }

        pub fn state(&self, index: usize) -> State<f64, B, Z> {
            debug_assert!(index < F64x4::LANES);
            self.state.lane(index)
        }
    }

    /// The kernel, compiled for AVX2.
    #[target_feature(enable = "avx2")]
    fn avx2_step<const B: usize, const Z: usize, const N: usize>(
        model: &Model<F64x4, B, Z>,
        settings: &Settings<F64x4>,
        input: &Input<F64x4>,
        state: &mut State<F64x4, B, Z>,
        scratch: &mut Scratch<F64x4, B, Z, N>,
    ) -> LanesReport<M64x4> {
        step_lanes(model, settings, input, state, scratch)
    }
}
