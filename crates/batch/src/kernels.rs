//! The kernel, compiled for each set of instructions.

use moreau::{Input, Mask, Model, Outcome, Real, Scalar, Scratch, Settings, State, step, step_lanes};

use crate::avx2::F64x4;
use crate::avx2_single::F32x8;
use crate::avx512::F64x8;
use crate::avx512_single::F32x16;

/// One step of all lanes: writes how each ended, or does nothing and returns false where the inputs are not of one kind.
///
/// # Safety
/// The processor must have the instructions that the kernel is compiled for.
type Kernel<T, const B: usize, const Z: usize, const N: usize> = unsafe fn(
    &Model<T, B, Z>,
    &Settings<T>,
    &[Input<f64>],
    &mut State<T, B, Z>,
    &mut Scratch<T, B, Z, N>,
    &mut [Outcome],
) -> bool;

/// As many mechanisms as T has lanes, side by side.
pub struct Lanes<T: Real, const B: usize, const Z: usize, const N: usize> {
    kernel: Kernel<T, B, Z, N>,
    model: Model<T, B, Z>,
    state: State<T, B, Z>,
    settings: Settings<T>,
    scratch: Scratch<T, B, Z, N>,
    models: Vec<Model<f64, B, Z>>,
    own_settings: Settings<f64>,
}

impl<T: Real, const B: usize, const Z: usize, const N: usize> Lanes<T, B, Z, N> {
    fn new(
        kernel: Kernel<T, B, Z, N>,
        models: &[Model<f64, B, Z>],
        states: &[State<f64, B, Z>],
        settings: &Settings<f64>,
    ) -> Option<Self> {
        let (each_model, each_state): (Vec<_>, Vec<_>) = (models.iter().collect(), states.iter().collect());
        Some(Lanes {
            kernel,
            model: Model::of_lanes(&each_model)?,
            state: State::of_lanes(&each_state),
            settings: Settings::in_lanes(settings),
            scratch: Scratch::new(),
            models: models.to_vec(),
            own_settings: *settings,
        })
    }

    /// One step; writes how each mechanism's ended.
    #[inline]
    pub fn step(&mut self, inputs: &[Input<f64>], outcomes: &mut [Outcome]) {
        let (inputs, outcomes) = (&inputs[..T::LANES], &mut outcomes[..T::LANES]);
        let Lanes { kernel, model, state, settings, scratch, .. } = self;
        // SAFETY: a `Lanes` is made only where the kernel's instructions have been detected.
        if !unsafe { kernel(model, settings, inputs, state, scratch, outcomes) } {
            self.one_by_one(inputs, outcomes);
        }
    }

    /// Inputs of different kinds: each lane alone.
    #[cold]
    fn one_by_one(&mut self, inputs: &[Input<f64>], outcomes: &mut [Outcome]) {
        let mut scratch = Scratch::<f64, B, Z, N>::new();
        for (i, outcome) in outcomes.iter_mut().enumerate() {
            let mut state = self.state.lane(i);
            *outcome = step(&self.models[i], &self.own_settings, &inputs[i], &mut state, &mut scratch).outcome;
            self.state.set_lane(i, &state);
        }
    }

    /// One lane's angles and velocities.
    #[inline]
    pub fn motion(&self, lane: usize) -> ([f64; B], [f64; B]) {
        (self.state.angle.map(|x| x.lane(lane).to_f64()), self.state.velocity.map(|x| x.lane(lane).to_f64()))
    }

    /// One lane's state.
    pub fn state(&self, lane: usize) -> State<f64, B, Z> {
        self.state.lane(lane)
    }
}

/// A width's kernel: `None` where the processor or the models do not allow it.
macro_rules! width {
    ($name:ident, $number:ident, $has:ident, $kernel:ident, $features:literal) => {
        pub fn $name<const B: usize, const Z: usize, const N: usize>(
            models: &[Model<f64, B, Z>],
            states: &[State<f64, B, Z>],
            settings: &Settings<f64>,
        ) -> Option<Lanes<$number, B, Z, N>> {
            if !$has() {
                return None;
            }
            Lanes::new($kernel, models, states, settings)
        }

        #[target_feature(enable = $features)]
        fn $kernel<const B: usize, const Z: usize, const N: usize>(
            model: &Model<$number, B, Z>,
            settings: &Settings<$number>,
            inputs: &[Input<f64>],
            state: &mut State<$number, B, Z>,
            scratch: &mut Scratch<$number, B, Z, N>,
            outcomes: &mut [Outcome],
        ) -> bool {
            step_all(model, settings, inputs, state, scratch, outcomes)
        }
    };
}

width!(four, F64x4, has_avx2, four_step, "avx2,fma");
width!(eight, F64x8, has_avx512, eight_step, "avx512f,avx512vl,avx512dq,avx512bw");
width!(eight_single, F32x8, has_avx2, eight_single_step, "avx2,fma");
width!(sixteen_single, F32x16, has_avx512, sixteen_single_step, "avx512f,avx512vl,avx512dq,avx512bw");

pub fn has_avx2() -> bool {
    is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma")
}

pub fn has_avx512() -> bool {
    is_x86_feature_detected!("avx512f")
        && is_x86_feature_detected!("avx512vl")
        && is_x86_feature_detected!("avx512dq")
        && is_x86_feature_detected!("avx512bw")
}

/// The kernel for any number. Inputs are joined in here, so that they are written as wide as they are read.
#[inline(always)]
fn step_all<T: Real, const B: usize, const Z: usize, const N: usize>(
    model: &Model<T, B, Z>,
    settings: &Settings<T>,
    inputs: &[Input<f64>],
    state: &mut State<T, B, Z>,
    scratch: &mut Scratch<T, B, Z, N>,
    outcomes: &mut [Outcome],
) -> bool {
    let Some(input) = Input::of_lanes(inputs) else { return false };
    let report = step_lanes(model, settings, &input, state, scratch);
    if report.converged.and(report.finite).all() {
        outcomes.fill(Outcome::Converged);
        return true;
    }
    for (i, outcome) in outcomes.iter_mut().enumerate() {
        *outcome = match (report.finite.lane(i), report.converged.lane(i)) {
            (false, _) => Outcome::NonFinite,
            (true, true) => Outcome::Converged,
            (true, false) => Outcome::IterationLimit,
        };
    }
    true
}
