//! What the benchmarks share: the concert grand at rest, and one played note.
#![allow(dead_code, reason = "every benchmark uses a part of it")]

use erard::{assembly, equilibrium, instrument::Instrument, mechanism::mechanism};
use moreau::{Input, Model, Outcome, Scratch, Settings, State, step};

/// The usual step, s.
pub const STEP_S: f64 = 50e-6;
/// Steps of one second.
pub const STEPS: u64 = 20_000;

/// The grand's engine size.
pub type GrandModel = Model<f64, 6, 14>;
pub type GrandState = State<f64, 6, 14>;
pub type GrandScratch = Scratch<f64, 6, 14, 10>;

/// The concert grand, at rest.
pub fn grand() -> (GrandModel, GrandState) {
    let instrument = Instrument::builtin("concert-grand").expect("built in");
    let mut rest = mechanism(&instrument, Settings::new(STEP_S)).expect("assembles");
    equilibrium::settle(rest.as_mut(), &Input::Free).expect("settles");
    let angles = core::array::from_fn(|i| rest.angles()[i]);
    (assembly::assemble(&instrument).expect("fits"), State::at_rest(angles))
}

/// The force on the key at a step: 5 N (a mezzo forte) for half a second, then nothing.
#[inline(always)]
pub fn note(n: u64) -> Input<f64> {
    if n < STEPS / 2 { Input::Force(5.0) } else { Input::Force(0.0) }
}

/// Plays the first `steps` steps of the note.
pub fn press((model, state): &(GrandModel, GrandState), settings: &Settings<f64>, steps: u64) -> GrandState {
    let (mut state, mut scratch) = (state.clone(), GrandScratch::new());
    for n in 0..steps {
        let report = step(model, settings, &note(n), &mut state, &mut scratch);
        assert_ne!(report.outcome, Outcome::NonFinite);
    }
    state
}
