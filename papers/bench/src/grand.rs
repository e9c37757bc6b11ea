//! The subjects of the timing: the concert grand in the engine's own types, and one played note.

use moreau::{Model, SavedState, Settings, SiteInput, State, StepOutcome, step};
use moreau_kernels::{Lanes, OwnedDescription, SideBySide, WorkspaceOfSix, side_by_side};

use erard::assembly;
use erard::instrument::Instrument;
use erard::player::Action;
use erard::run::SimulationError;

/// The usual step, s.
pub const STEP_S: f64 = 50e-6;
/// Steps of one second.
pub const STEPS: u64 = 20_000;
/// A mezzo forte, N.
pub const MF_N: f64 = 5.0;

/// The grand's engine size: six bodies, fourteen zones.
pub(crate) type GrandModel = Model<f64, 6, 14>;
/// The same.
pub(crate) type GrandState = State<f64, 6, 14>;

/// The concert grand of six rigid bodies, which the counts and times of earlier versions belong to.
///
/// # Panics
/// If the built-in file cannot be read, which a test rules out; so do all functions here.
pub fn instrument() -> Instrument {
    Instrument::builtin("concert-grand-rigid").expect("built in")
}

/// An instrument of the grand's topology, at rest.
///
/// # Errors
/// Where it finds no rest.
pub fn at_rest(instrument: &Instrument) -> Result<(GrandModel, GrandState), SimulationError> {
    let rest = described(instrument)?;
    Ok((rest.model()?, State::at_rest(rest.first_angles())))
}

/// An instrument's mechanism at rest, whatever its size.
///
/// # Errors
/// Where it finds no rest.
pub fn described(instrument: &Instrument) -> Result<OwnedDescription, SimulationError> {
    let action = Action::with(instrument, Settings::new(STEP_S))?;
    Ok(OwnedDescription { angles: action.angles().to_vec(), ..assembly::describe(instrument) })
}

/// Mechanisms at rest, side by side in lanes.
///
/// # Panics
/// If one of them is too large.
pub fn group(rests: &[&OwnedDescription], settings: &Settings<f64>, lanes: Lanes) -> Box<dyn SideBySide> {
    let at_rest = |rest: &&OwnedDescription| -> SavedState<f64, 12, 32> { State::at_rest(rest.first_angles()).save() };
    let states: Vec<_> = rests.iter().map(at_rest).collect();
    side_by_side(rests, &states, settings, lanes).expect("a size holds it")
}

/// The concert grand, at rest.
pub fn grand() -> (GrandModel, GrandState) {
    at_rest(&instrument()).expect("the built-in grand comes to rest")
}

/// The force on the key at a step: a mezzo forte for half a second, then nothing.
#[inline(always)]
pub fn note(n: u64) -> SiteInput<f64> {
    SiteInput::Force(if n < STEPS / 2 { MF_N } else { 0.0 })
}

/// Plays the first `steps` steps of the note.
///
/// # Panics
/// If a number becomes infinite.
pub fn press((model, state): &(GrandModel, GrandState), settings: &Settings<f64>, steps: u64) -> GrandState {
    let (mut state, mut workspace) = (state.clone(), WorkspaceOfSix::new());
    let finite = steps_of_six(model, settings, &mut (0..steps).map(note), &mut state, &mut workspace);
    assert!(finite, "a number became infinite");
    state
}

/// Steps of six bodies in types of fixed size, with nothing around them: one for each input. Returns true if all
/// numbers stayed finite, and stops with false at the first step where one did not. The step is compiled into this
/// loop, here and not in a library that products are made of.
#[inline(never)]
pub(crate) fn steps_of_six(
    model: &GrandModel,
    settings: &Settings<f64>,
    inputs: &mut dyn Iterator<Item = SiteInput<f64>>,
    state: &mut GrandState,
    workspace: &mut WorkspaceOfSix,
) -> bool {
    for input in inputs {
        if step(model, settings, &input, state, workspace).outcome == StepOutcome::NonFinite {
            return false;
        }
    }
    true
}
