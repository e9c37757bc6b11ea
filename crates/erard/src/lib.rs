//! The grand piano action, simulated: from a force or a motion of the finger to the hammer at the string.
//!
//! ```
//! use erard::{Action, Input, Instrument, Press};
//!
//! let grand = Instrument::builtin("concert-grand")?;
//! // One press from rest, recorded: series, events, energy balance.
//! let run = Press::new(&grand).force(5.0).duration(0.1).run()?;
//! println!("{:?} m/s", run.events.hammer_speed_m_per_s());
//! // The same action, stepped by a control loop: no allocation, bounded time.
//! let mut action = Action::new(&grand)?;
//! let reading = action.step(Input::Force(4.5));
//! println!("{} m, {} m/s", reading.key_m, reading.hammer_rise_m_per_s);
//! # assert!(reading.key_m > 0.0 && run.events.hammer_speed_m_per_s().is_some());
//! # Ok::<(), erard::Error>(())
//! ```
//!
//! | to | use |
//! |---|---|
//! | choose an instrument | [`Instrument`], [`InstrumentFile`], [`InstrumentSpec`] for `concert-grand:key=40` |
//! | change it by name | [`varied`], [`Parameter`], [`ParameterChange`] |
//! | record one press | [`Press`], which gives a [`Run`] |
//! | play what was recorded | [`Series`] from a file, [`Stroke`] to drive with it |
//! | step one action | [`Action`], [`Input`], [`Reading`], [`Snapshot`] |
//! | step 88 of them | [`Keyboard`], [`Keys`] |
//!
//! Every error converts into [`Error`]. SI units; key and finger positive downward, the hammer upward. Nothing here
//! uses a clock or starts a thread.
//!
//! # What is kept
//!
//! The names in this list, their fields, and their methods as far as their signatures consist of these names and of
//! the standard library's. A change that breaks one comes in a release that says so, after a release in which it is
//! deprecated. The types come from `erard-core`, which promises nothing: what is not in this list may change in any
//! release.

mod error;
mod press;

pub use error::Error;
pub use press::Press;

// Instruments and their numbers.
pub use erard_core::instrument::{Certainty, FileError, InstrumentFile, InvalidInstrument, UnknownInstrument};
pub use erard_core::instrument_spec::{InstrumentSpec, InstrumentSpecError};
pub use erard_core::parameter::{ChangeError, NameError, Parameter, ParameterChange, Quantity, VaryError, varied};
pub use erard_core::{IndexError, Instrument};

// One action, stepped.
pub use erard_core::mechanism::Halving;
pub use erard_core::player::{Fingertip, HandError, HandInput, Joints, PlayError};
pub use erard_core::{
    Action, ActionError, FrictionLaw, Hand, Impact, Input, Progress, Reading, Settings, Snapshot, SnapshotError,
    Solver, StepOutcome,
};

// Keyboards.
pub use erard_core::key::{KEYS, UnknownKey, key_named, note_name};
pub use erard_core::keyboard::{KeyImpact, Keyboard, Keys, KeysError, Tick, UnknownKeyboard};
pub use erard_core::knocks::{KeyBed, Knock};
pub use erard_core::strings::{Pedal, PedalError, Strings};

// Strokes.
pub use erard_core::level::{HandKind, LevelError};
pub use erard_core::stroke::{
    DrivingError, HandStroke, PositionOf, Prescribed, SampleError, Series, Stroke, StrokeError, Touch,
};

// Runs.
pub use erard_core::run::{BodySeries, LiftSeries, StringSeries, Work, ZoneSeries};
pub use erard_core::trust::{Warning, WarningKind};
pub use erard_core::{Events, Run, SimulationError};
pub use moreau::{Energies, HandEnergy, Ledger};

/// The examples of the README are tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
