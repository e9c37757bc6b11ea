//! The kernel, compiled for each set of instructions.

#![allow(unsafe_code)]

use moreau::{
    Mask, Model, Real, SavedState, Scalar, Settings, SiteInput, State, StepOutcome, Workspace, step_lanes,
    step_out_of_line,
};

use super::Together;
use super::avx2::F64x4;
use super::avx2_single::F32x8;

/// One step of all lanes: writes how each ended, or does nothing and returns false where the inputs are not of one
/// kind, or not all finite.
///
/// # Safety
/// The processor must have the instructions that the kernel is compiled for.
type Kernel<T, const B: usize, const Z: usize, const N: usize> =
    unsafe fn(&mut Stepped<T, B, Z, N>, &[SiteInput<f64>], &mut [StepOutcome]) -> bool;

/// What a step reads and writes, in one place: the kernel then finds all of it from one address, and has registers for
/// other things.
struct Stepped<T: Real, const B: usize, const Z: usize, const N: usize> {
    model: Model<T, B, Z>,
    state: State<T, B, Z>,
    settings: Settings<T>,
    workspace: Workspace<T, B, Z, N>,
}

/// As many mechanisms as T has lanes, side by side.
pub(crate) struct Lanes<T: Real, const B: usize, const Z: usize, const N: usize> {
    kind: super::Lanes,
    kernel: Kernel<T, B, Z, N>,
    stepped: Stepped<T, B, Z, N>,
    models: Vec<Model<f64, B, Z>>,
    own_settings: Settings<f64>,
    /// Inputs under which the last step changed nothing; empty where it did.
    rests_under: Vec<SiteInput<f64>>,
}

impl<T: Real, const B: usize, const Z: usize, const N: usize> Lanes<T, B, Z, N> {
    /// Its parts are written where they stay: lanes of a large mechanism are hundreds of kilobytes, which a thread's
    /// stack holds a few times.
    fn new(
        kind: super::Lanes,
        kernel: Kernel<T, B, Z, N>,
        models: &[Model<f64, B, Z>],
        states: &[State<f64, B, Z>],
        settings: &Settings<f64>,
    ) -> Option<Box<Self>> {
        let mut boxed = Box::<Self>::new_uninit();
        let lanes = boxed.as_mut_ptr();
        // SAFETY: each place lies within the box, and is written once. Where the models are not alike nothing that
        // would have to be dropped has been written.
        unsafe {
            if !write_model(&raw mut (*lanes).stepped.model, models) {
                return None;
            }
            write_state(&raw mut (*lanes).stepped.state, states);
            write_workspace(&raw mut (*lanes).stepped.workspace);
            (&raw mut (*lanes).stepped.settings).write(Settings::in_lanes(settings));
            (&raw mut (*lanes).kind).write(kind);
            (&raw mut (*lanes).kernel).write(kernel);
            (&raw mut (*lanes).models).write(models.to_vec());
            (&raw mut (*lanes).own_settings).write(*settings);
            (&raw mut (*lanes).rests_under).write(Vec::with_capacity(T::LANES));
            // Every field has been written.
            Some(boxed.assume_init())
        }
    }

    /// Inputs of different kinds, or not all finite: each lane alone.
    #[cold]
    #[inline(never)]
    fn one_by_one(&mut self, inputs: &[SiteInput<f64>], outcomes: &mut [StepOutcome]) {
        let mut workspace = Workspace::<f64, B, Z, N>::new();
        for (i, outcome) in outcomes[..T::LANES].iter_mut().enumerate() {
            let mut state = self.stepped.state.lane(i);
            *outcome =
                step_out_of_line(&self.models[i], &self.own_settings, &inputs[i], &mut state, &mut workspace).outcome;
            self.stepped.state.set_lane(i, &state);
        }
    }
}

impl<T: Real<Mask: Send> + Send, const B: usize, const Z: usize, const N: usize> Together<B, Z> for Lanes<T, B, Z, N> {
    fn lanes(&self) -> super::Lanes {
        self.kind
    }

    fn step(&mut self, inputs: &[SiteInput<f64>], outcomes: &mut [StepOutcome]) {
        let Lanes { kernel, stepped, rests_under, .. } = self;
        rests_under.clear();
        // SAFETY: `kernel` asks for the instructions it is compiled for. `new` is called by the functions of `width!`
        // alone, which have asked the processor for those of the kernel that they pass.
        if !unsafe { kernel(stepped, inputs, outcomes) } {
            self.one_by_one(inputs, outcomes);
        }
    }

    fn step_or_rest(&mut self, inputs: &[SiteInput<f64>], outcomes: &mut [StepOutcome]) {
        let (inputs, outcomes) = (&inputs[..T::LANES], &mut outcomes[..T::LANES]);
        if self.is_at_rest() && inputs.iter().zip(&self.rests_under).all(|(a, b)| a.identical(b)) {
            outcomes.fill(StepOutcome::Converged);
            return;
        }
        let before = self.stepped.state.stands().then(|| self.stepped.state.clone());
        self.step(inputs, outcomes);
        let same = before.is_some_and(|before| before.identical(&self.stepped.state));
        if same && outcomes.iter().all(|outcome| *outcome == StepOutcome::Converged) {
            self.rests_under.extend_from_slice(inputs);
        }
    }

    fn is_at_rest(&self) -> bool {
        self.rests_under.len() == T::LANES
    }

    fn copy_motion(&self, lane: usize, angles: &mut [f64; B], velocities: &mut [f64; B]) {
        let SavedState { angle, velocity, .. } = &*self.stepped.state;
        for i in 0..B {
            (angles[i], velocities[i]) = (angle[i].lane_in(lane).to_f64(), velocity[i].lane_in(lane).to_f64());
        }
    }

    fn copy_state(&self, lane: usize, state: &mut State<f64, B, Z>) {
        self.stepped.state.copy_lane(lane, state);
    }

    fn state(&self, lane: usize) -> State<f64, B, Z> {
        self.stepped.state.lane(lane)
    }
}

/// Joins models in a place that may be written to; returns false, and writes nothing, where they are not alike. Each of
/// these functions has a part on its stack, and none has all.
///
/// # Safety
/// `place` is aligned, and points to memory for one model that nothing else refers to.
#[inline(never)]
unsafe fn write_model<T: Real, const B: usize, const Z: usize>(
    place: *mut Model<T, B, Z>,
    models: &[Model<f64, B, Z>],
) -> bool {
    let each: Vec<_> = models.iter().collect();
    let Some(model) = Model::of_lanes(&each) else { return false };
    // SAFETY: `place` is aligned and points to memory for one model that nothing else refers to: a field of the new
    // box.
    unsafe { place.write(model) };
    true
}

/// # Safety
/// `place` is aligned, and points to memory for one state that nothing else refers to.
#[inline(never)]
unsafe fn write_state<T: Real, const B: usize, const Z: usize>(
    place: *mut State<T, B, Z>,
    states: &[State<f64, B, Z>],
) {
    let each: Vec<_> = states.iter().collect();
    // SAFETY: `place` is aligned and points to memory for one state that nothing else refers to: a field of the new
    // box.
    unsafe { place.write(State::of_lanes(&each)) };
}

/// # Safety
/// `place` is aligned, and points to memory for one workspace that nothing else refers to.
#[inline(never)]
unsafe fn write_workspace<T: Real, const B: usize, const Z: usize, const N: usize>(place: *mut Workspace<T, B, Z, N>) {
    // SAFETY: `place` is aligned and points to memory for one workspace that nothing else refers to: a field of the new
    // box.
    unsafe { place.write(Workspace::new()) };
}

/// A width's kernel: `None` where the processor or the models do not allow it.
macro_rules! width {
    ($kind:ident, $name:ident, $number:ident, $has:ident, $kernel:ident, $features:literal) => {
        pub fn $name<const B: usize, const Z: usize, const N: usize>(
            models: &[Model<f64, B, Z>],
            states: &[State<f64, B, Z>],
            settings: &Settings<f64>,
        ) -> Option<Box<Lanes<$number, B, Z, N>>> {
            if !$has() {
                return None;
            }
            Lanes::new(super::Lanes::$kind, $kernel, models, states, settings)
        }

        #[target_feature(enable = $features)]
        fn $kernel<const B: usize, const Z: usize, const N: usize>(
            stepped: &mut Stepped<$number, B, Z, N>,
            inputs: &[SiteInput<f64>],
            outcomes: &mut [StepOutcome],
        ) -> bool {
            step_all(stepped, inputs, outcomes)
        }
    };
}

width!(Four, four, F64x4, has_avx2, four_step, "avx2,fma");
width!(EightSingle, eight_single, F32x8, has_avx2, eight_single_step, "avx2,fma");

pub(crate) fn has_avx2() -> bool {
    is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma")
}

/// The kernel for any number. Inputs are joined in here, so that they are written as wide as they are read.
#[inline(always)]
fn step_all<T: Real, const B: usize, const Z: usize, const N: usize>(
    stepped: &mut Stepped<T, B, Z, N>,
    inputs: &[SiteInput<f64>],
    outcomes: &mut [StepOutcome],
) -> bool {
    // Their number is now known to the compiler.
    let (inputs, outcomes) = (&inputs[..T::LANES], &mut outcomes[..T::LANES]);
    let Some(input) = SiteInput::<T>::of_lanes(inputs) else { return false };
    if !input.finite().all() {
        return false;
    }
    let Stepped { model, state, settings, workspace } = stepped;
    let report = step_lanes(model, settings, &input, state, workspace);
    if report.converged.and(report.finite).all() {
        outcomes.fill(StepOutcome::Converged);
        return true;
    }
    for (i, outcome) in outcomes.iter_mut().enumerate() {
        *outcome = match (report.finite.lane(i), report.converged.lane(i)) {
            (false, _) => StepOutcome::NonFinite,
            (true, true) => StepOutcome::Converged,
            (true, false) => StepOutcome::IterationLimit,
        };
    }
    true
}
