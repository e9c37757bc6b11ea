//! One action, or the keys of a keyboard, played by an instance.

use erard::Instrument;
use erard::saved::{Lists, Writer};
use erard::strings::Strings;

use crate::action::ErardAction;
use crate::keyboard::{ErardKeyboard, restore};
use crate::reading::{ERARD_INPUT_HAND, ERARD_INPUT_MOTION, ERARD_INPUT_RIGID, ErardInput, ErardReading};
use crate::status::{ErardStatus, Fault};

/// One action, or the keys of a keyboard. Keys count from 1; a single action is key 1.
pub(super) enum Played {
    Key(Box<ErardAction>),
    Keyboard(ErardKeyboard),
}

/// A step within a communication step.
#[derive(Clone, Copy)]
pub(super) struct Instant {
    /// Start of the experiment and of the communication step on the importer's clock, s.
    pub start_s: f64,
    pub now_s: f64,
    /// Length of a step, s.
    pub step_s: f64,
    /// Steps since the start.
    pub steps: u64,
    /// Whether it is the first of its communication step.
    pub is_first: bool,
}

impl Instant {
    /// Returns the input in this step: a finger's position is taken at the step's middle, an imposed key front's at its
    /// end.
    fn later(&self, input: &ErardInput) -> ErardInput {
        let share = if input.kind == ERARD_INPUT_RIGID { 1.0 } else { 0.5 };
        let later_s = (self.start_s + (self.steps as f64 + share) * self.step_s - self.now_s).max(0.0);
        ErardInput { position_m: input.position_m + input.velocity_m_per_s * later_s, ..*input }
    }
}

/// Describes a refused input.
fn refused(status: ErardStatus, input: &ErardInput) -> String {
    format!("a step could not be taken: {status:?}; inputs are {input:?}")
}

impl Played {
    pub(super) fn at_rest(instruments: &[Instrument], is_keyboard: bool, step_s: f64) -> Result<Self, Fault> {
        match instruments {
            [one] if !is_keyboard => Ok(Played::Key(Box::new(ErardAction::new(one, step_s)?))),
            all => Ok(Played::Keyboard(ErardKeyboard::new(all, step_s)?)),
        }
    }

    pub(super) fn set_pedal(&mut self, lift_m: f64) {
        match self {
            Played::Key(action) => action.play.action.set_pedal(lift_m),
            Played::Keyboard(own) => own.keys.set_pedal(lift_m),
        }
    }

    /// Takes one step under these inputs of the keys.
    pub(super) fn step(&mut self, inputs: &[ErardInput], at: Instant) -> Result<ErardStatus, String> {
        match self {
            Played::Key(action) => {
                let input = at.later(&inputs[0]);
                Ok(action.play.step(input.checked().map_err(|status| refused(status, &inputs[0]))?))
            }
            Played::Keyboard(own) => {
                for (index, input) in inputs.iter().enumerate() {
                    // Constant inputs hold within a communication step.
                    let moves =
                        input.velocity_m_per_s != 0.0 && [ERARD_INPUT_MOTION, ERARD_INPUT_HAND].contains(&input.kind);
                    let status = match input.kind {
                        ERARD_INPUT_RIGID => own.impose(index + 1, &at.later(input)),
                        _ if at.is_first || moves => own.drive(index + 1, &at.later(input)),
                        _ => ErardStatus::Ok,
                    };
                    if status != ErardStatus::Ok {
                        return Err(format!("key {}: {}", index + 1, refused(status, input)));
                    }
                }
                Ok(own.step(&mut |_| {}))
            }
        }
    }

    pub(super) fn reading(&self, key: usize) -> ErardReading {
        match self {
            Played::Key(action) => action.play.reading,
            Played::Keyboard(own) => own.reading(key).unwrap_or_default(),
        }
    }

    /// Force of a key's strings on the bridge, N; 0 without sounding strings.
    pub(super) fn bridge_n(&self, key: usize) -> f64 {
        match self {
            Played::Key(action) => action.play.action.strings().map_or(0.0, Strings::bridge_n),
            Played::Keyboard(own) => own.bridge_n(key),
        }
    }

    /// Force of the strings of all keys on the bridge, N.
    pub(super) fn bridge_sum_n(&self) -> f64 {
        match self {
            Played::Key(_) => self.bridge_n(1),
            Played::Keyboard(own) => own.keys.bridge_n(),
        }
    }

    /// Number of awake keys.
    pub(super) fn awake(&self) -> usize {
        match self {
            Played::Key(_) => 1,
            Played::Keyboard(own) => own.keys.awake(),
        }
    }

    /// Normal force of a contact zone, N; a keyboard has none among its variables.
    pub(super) fn contact_force(&self, zone: usize) -> f64 {
        match self {
            Played::Key(action) => action.play.action.contact_force(zone).unwrap_or(f64::NAN),
            Played::Keyboard(_) => 0.0,
        }
    }

    /// Writes the lists of the state.
    pub(super) fn write(&self, out: &mut Writer<'_>) {
        match self {
            Played::Key(action) => action.play.write(out),
            Played::Keyboard(own) => own.write(out),
        }
    }

    /// Restores the state from these lists.
    pub(super) fn read(&mut self, lists: &Lists<'_>) -> ErardStatus {
        match self {
            Played::Key(action) => action.play.read(lists),
            Played::Keyboard(own) => restore(own, lists),
        }
    }
}
