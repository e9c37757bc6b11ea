//! The whole grand without the standard library and without a heap: what a control loop on a chip steps.
//!
//! `grand.rs` is the built-in instrument as source, made by `.ci/regenerate firmware` and
//! checked by `crates/erard-core/tests/it/firmware.rs`. The model is built at start, on the stack or in a static.

#![no_std]

// The C interface of boards is that of `liberard`, from the same source.
#[path = "../../c/src/board.rs"]
mod board;
#[path = "../../c/src/board_contacts.rs"]
mod board_contacts;
#[path = "../../c/src/board_hammers.rs"]
mod board_hammers;
mod board_keys;
#[path = "../../c/src/caller_struct.rs"]
mod caller_struct;
#[path = "../../../crates/erard-core/src/fnv1a.rs"]
mod fnv1a;
// Generated: a test compares it with what the example prints.
#[rustfmt::skip]
mod grand;
#[rustfmt::skip]
mod keyboard;
mod keys;
#[path = "../../c/src/outcome.rs"]
mod outcome;
mod play;
mod scan;
mod status;

pub use board::*;
pub use board_contacts::*;
pub use board_hammers::*;
pub use grand::{BODIES, ZONES};
pub use keyboard::{FRAMES, KEYS, PERIOD_S};
pub use keys::{Key, Keys, LONG_STEP_S, LOWEST_KEY};
pub use outcome::ErardStatus;
pub use play::{Note, STEP_S, STEPS, Work, digest, play};
pub use scan::{Scanned, reading};

use moreau::{
    Description, Model, ModelError, Scalar, Settings, SiteHand, SiteInput, State, StepOutcome, StepReport, Workspace,
    step,
};

#[cfg(feature = "alone")]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    loop {}
}

/// The grand, with all the memory that it ever needs.
pub struct Grand<T: Scalar> {
    model: Model<T, BODIES, ZONES>,
    settings: Settings<T>,
    /// Where it is.
    pub state: State<T, BODIES, ZONES>,
    workspace: Workspace<T, BODIES, ZONES, { grand::LAWS }>,
    rest_m: T,
}

impl<T: Scalar> Grand<T> {
    /// At rest.
    ///
    /// # Errors
    /// None, for the instrument that is compiled in; another one may have a number that is not sound.
    pub fn new(step_s: T) -> Result<Self, ModelError> {
        let model = model()?;
        let mut state = State::at_rest(grand::REST.map(T::from_f64));
        let workspace = Workspace::for_model(&model)?;
        let rest_m = model.site_position(&state.angle);
        state.hand = [rest_m, T::ZERO];
        Ok(Grand { settings: Settings::new(step_s), rest_m, model, state, workspace })
    }

    /// One step under a force on the key front, N, down positive. A force that is not finite leaves it where it was.
    pub fn step_force(&mut self, force_n: T) -> StepReport {
        step(&self.model, &self.settings, &SiteInput::Force(force_n), &mut self.state, &mut self.workspace)
    }

    /// One step under a device that is so far below the key's rest, m, and moves so fast, m/s, behind a soft fingertip.
    pub fn step_motion(&mut self, position_m: T, velocity_m_per_s: T) -> StepReport {
        let input = SiteInput::Motion { position: self.rest_m + position_m, velocity: velocity_m_per_s };
        step(&self.model, &self.settings, &input, &mut self.state, &mut self.workspace)
    }

    /// One step under a hand whose muscle has this force, N, down positive. A number that is not finite leaves it where
    /// it was.
    pub fn step_hand(&mut self, mass_kg: T, force_n: T) -> StepReport {
        let z = T::ZERO;
        let hand = SiteHand {
            mass: mass_kg,
            force: force_n,
            stiffness: z,
            damping: z,
            position: z,
            velocity: z,
            compliance: z,
            retardation: z,
        };
        step(&self.model, &self.settings, &SiteInput::Hand(hand), &mut self.state, &mut self.workspace)
    }

    /// Places the hand, m below the key's rest, with a velocity, m/s, down positive; a new grand has it at the key's
    /// rest.
    pub fn place_hand(&mut self, position_m: T, velocity_m_per_s: T) {
        self.state.hand = [self.rest_m + position_m, velocity_m_per_s];
    }

    /// Travel of the key front, m.
    pub fn key_m(&self) -> T {
        self.model.site_position(&self.state.angle) - self.rest_m
    }

    /// Force of the finger in the last step, N.
    pub fn finger_force_n(&self) -> T {
        self.workspace.drive_force()
    }

    /// Place of the hand, m below the key's rest.
    pub fn hand_m(&self) -> T {
        self.state.hand[0] - self.rest_m
    }

    /// Angular velocity of the hammer, rad/s.
    pub fn hammer_rad_per_s(&self) -> T {
        self.state.velocity[grand::HAMMER]
    }
}

/// The model of the grand, from its description in flash.
fn model<T: Scalar>() -> Result<Model<T, BODIES, ZONES>, ModelError> {
    let (bodies, springs, zones) = (grand::bodies(), grand::springs(), grand::zones());
    let site = Some(grand::site());
    let description = Description {
        bodies: &bodies,
        springs: &springs,
        zones: &zones,
        dwells: &[],
        yields: &[],
        site,
        gravity: T::from_f64(grand::GRAVITY),
    };
    description.compile()
}

/// For a linker that wants to see that nothing else is needed: steps the grand so many times under a force, N, and
/// returns how far its key has gone, m; not-a-number if a step failed.
#[unsafe(no_mangle)]
pub extern "C" fn erard_key_travel(force_n: f32, step_s: f32, steps: u32) -> f32 {
    let Ok(mut grand) = Grand::new(step_s) else { return f32::NAN };
    for _ in 0..steps {
        if grand.step_force(force_n).outcome == StepOutcome::NonFinite {
            return f32::NAN;
        }
    }
    grand.key_m()
}
