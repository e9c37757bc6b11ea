//! Several mechanisms of one topology, stepped in parallel in the processor's vector lanes.

use core::any::Any;

use moreau::{Model, ModelError, SavedState, Settings, SiteInput, State, StepOutcome};

use crate::size::with_size;
use crate::{EveryBody, Group, Lanes, OwnedDescription, Size};

/// Mechanisms that are stepped together. Indices count from 0. Only [`side_by_side`] allocates.
pub trait SideBySide: Send {
    /// Returns the lanes in which the mechanisms are stepped.
    fn lanes(&self) -> Lanes;
    /// Advances all mechanisms by one step, with an input for each, and writes their outcomes. If the inputs are of
    /// different kinds, the mechanisms are stepped one by one.
    ///
    /// # Panics
    /// Panics if there are fewer inputs or outcomes than mechanisms.
    fn step(&mut self, inputs: &[SiteInput<f64>], outcomes: &mut [StepOutcome]);
    /// Advances all mechanisms as [`SideBySide::step`] does, but skips steps that would change nothing. Results are
    /// bit-identical.
    ///
    /// # Panics
    /// As [`SideBySide::step`].
    fn step_or_rest(&mut self, inputs: &[SiteInput<f64>], outcomes: &mut [StepOutcome]);
    /// Copies one mechanism's absolute angles, rad, and angular velocities, rad/s. Places beyond the mechanism's size
    /// keep their values.
    fn motion(&self, index: usize, angles: &mut EveryBody, velocities: &mut EveryBody);
    /// Returns one mechanism's state, in the largest size.
    fn state(&self, index: usize) -> SavedState<f64, 12, 32>;
    /// Copies one mechanism's state into a `State<f64, B, Z>` of the size in which it is stepped. Returns false, and
    /// copies nothing, if `state` is of another type.
    fn copy_state(&self, index: usize, state: &mut dyn Any) -> bool;
}

/// Assembles mechanisms in given states. If they fill the `lanes` and differ in their numbers only, they are stepped in
/// parallel, or in several groups if lanes that wide are not compiled for their size ([`Size::lanes`]). Otherwise they
/// are stepped one by one.
///
/// # Errors
/// Returns [`ModelError`] if no size holds one of them, or a number is out of its range.
///
/// # Panics
/// Panics if the numbers of states and descriptions differ.
pub fn side_by_side(
    descriptions: &[&OwnedDescription],
    states: &[SavedState<f64, 12, 32>],
    settings: &Settings<f64>,
    lanes: Lanes,
) -> Result<Box<dyn SideBySide>, ModelError> {
    assert_eq!(descriptions.len(), states.len(), "a state for each description");
    let size = descriptions.iter().map(|d| Size::of(d)).max().unwrap_or(Size::One);
    let compiled = size.lanes(lanes);
    let size = if compiled == Lanes::One { size } else { size.in_lanes() };
    let width = compiled.count();
    if 1 < width && width < descriptions.len() {
        let parts = descriptions.chunks(width).zip(states.chunks(width));
        let parts = parts.map(|(d, s)| one_part(size, d, s, settings, compiled)).collect::<Result<_, _>>()?;
        return Ok(Box::new(Parts { parts, lanes: compiled }));
    }
    one_part(size, descriptions, states, settings, compiled)
}

fn one_part(
    size: Size,
    descriptions: &[&OwnedDescription],
    states: &[SavedState<f64, 12, 32>],
    settings: &Settings<f64>,
    lanes: Lanes,
) -> Result<Box<dyn SideBySide>, ModelError> {
    // Each arm compiles one kernel: [`Size::lanes`] names these and no others.
    match (size, lanes) {
        (Size::Six, Lanes::Four) => grouped::<6, 14, 10>(Group::in_fours, descriptions, states, settings),
        (Size::Six, Lanes::EightSingle) => {
            grouped::<6, 14, 10>(Group::in_eights_single, descriptions, states, settings)
        }
        (Size::Nine, Lanes::Four) => grouped::<9, 20, 50>(Group::in_fours, descriptions, states, settings),
        (Size::Nine, Lanes::EightSingle) => {
            grouped::<9, 20, 50>(Group::in_eights_single, descriptions, states, settings)
        }
        _ => with_size!(size, one_by_one, descriptions, states, settings),
    }
}

/// How a group is made of models and states.
type Grouping<const B: usize, const Z: usize, const N: usize> =
    fn(&[Model<f64, B, Z>], &[State<f64, B, Z>], &Settings<f64>) -> Group<B, Z, N>;

fn grouped<const B: usize, const Z: usize, const N: usize>(
    group: Grouping<B, Z, N>,
    descriptions: &[&OwnedDescription],
    states: &[SavedState<f64, 12, 32>],
    settings: &Settings<f64>,
) -> Result<Box<dyn SideBySide>, ModelError> {
    let (models, states) = assembled(descriptions, states)?;
    Ok(Box::new(group(&models, &states, settings)))
}

/// Mechanisms in several groups of so many each, the last one perhaps of fewer.
struct Parts {
    parts: Vec<Box<dyn SideBySide>>,
    lanes: Lanes,
}

impl Parts {
    fn place(&self, index: usize) -> (&dyn SideBySide, usize) {
        let width = self.lanes.count();
        (self.parts[index / width].as_ref(), index % width)
    }

    fn each(&mut self, inputs: &[SiteInput<f64>], outcomes: &mut [StepOutcome], step: StepOfPart) {
        let width = self.lanes.count();
        for ((part, inputs), outcomes) in
            self.parts.iter_mut().zip(inputs.chunks(width)).zip(outcomes.chunks_mut(width))
        {
            step(part.as_mut(), inputs, outcomes);
        }
    }
}

type StepOfPart = fn(&mut dyn SideBySide, &[SiteInput<f64>], &mut [StepOutcome]);

impl SideBySide for Parts {
    fn lanes(&self) -> Lanes {
        self.parts.first().map_or(Lanes::One, |part| part.lanes())
    }

    fn step(&mut self, inputs: &[SiteInput<f64>], outcomes: &mut [StepOutcome]) {
        self.each(inputs, outcomes, |part, inputs, outcomes| part.step(inputs, outcomes));
    }

    fn step_or_rest(&mut self, inputs: &[SiteInput<f64>], outcomes: &mut [StepOutcome]) {
        self.each(inputs, outcomes, |part, inputs, outcomes| part.step_or_rest(inputs, outcomes));
    }

    fn motion(&self, index: usize, angles: &mut EveryBody, velocities: &mut EveryBody) {
        let (part, index) = self.place(index);
        part.motion(index, angles, velocities);
    }

    fn state(&self, index: usize) -> SavedState<f64, 12, 32> {
        let (part, index) = self.place(index);
        part.state(index)
    }

    fn copy_state(&self, index: usize, state: &mut dyn Any) -> bool {
        let (part, index) = self.place(index);
        part.copy_state(index, state)
    }
}

type Assembled<const B: usize, const Z: usize> = (Vec<Model<f64, B, Z>>, Vec<State<f64, B, Z>>);

fn assembled<const B: usize, const Z: usize>(
    descriptions: &[&OwnedDescription],
    states: &[SavedState<f64, 12, 32>],
) -> Result<Assembled<B, Z>, ModelError> {
    let models = descriptions.iter().map(|d| d.model()).collect::<Result<_, _>>()?;
    Ok((models, states.iter().map(|saved| State::from(saved.sized())).collect()))
}

fn one_by_one<const B: usize, const Z: usize, const N: usize>(
    descriptions: &[&OwnedDescription],
    states: &[SavedState<f64, 12, 32>],
    settings: &Settings<f64>,
) -> Result<Box<dyn SideBySide>, ModelError> {
    let (models, states) = assembled(descriptions, states)?;
    Ok(Box::new(Group::<B, Z, N>::one_by_one(&models, &states, settings)))
}

impl<const B: usize, const Z: usize, const N: usize> SideBySide for Group<B, Z, N> {
    fn lanes(&self) -> Lanes {
        Group::lanes(self)
    }

    fn step(&mut self, inputs: &[SiteInput<f64>], outcomes: &mut [StepOutcome]) {
        Group::step(self, inputs, outcomes);
    }

    fn step_or_rest(&mut self, inputs: &[SiteInput<f64>], outcomes: &mut [StepOutcome]) {
        Group::step_or_rest(self, inputs, outcomes);
    }

    fn motion(&self, index: usize, angles: &mut EveryBody, velocities: &mut EveryBody) {
        // No size has more bodies.
        if let (Some(angles), Some(velocities)) = (angles.first_chunk_mut(), velocities.first_chunk_mut()) {
            Group::copy_motion(self, index, angles, velocities);
        }
    }

    fn state(&self, index: usize) -> SavedState<f64, 12, 32> {
        Group::state(self, index).save().sized()
    }

    fn copy_state(&self, index: usize, state: &mut dyn Any) -> bool {
        let Some(state) = state.downcast_mut() else { return false };
        Group::copy_state(self, index, state);
        true
    }
}
