//! Sensed keys as MIDI: a stream of key positions or forces, played on the simulated action of every key.
//!
//! - [`stream`]: the text that a sender writes, line by line;
//! - [`sensor`], [`profile`], [`calibrate`]: raw readings to millimetres, from the two stops of each key and the
//!   sensor's law, drift followed;
//! - [`Live`]: takes samples as they come and gives notes ([`Event`]) as their hammers meet the strings, or before
//!   ([`Options::ahead`]); it counts what was limited, clipped, late or lost ([`Report`]);
//! - [`cable`]: how long bytes queue for a DIN cable; [`quality`]: what bits and rate of a sensor cost.
//!
//! SI units but for files, which have millimetres; key and finger positive downward, the hammer upward.

pub mod ahead;
pub mod cable;
pub mod calibrate;
mod drive;
mod error;
mod key;
mod limits;
mod live;
pub mod profile;
pub mod quality;
mod report;
pub mod sensor;
pub mod stream;

pub use drive::SensorKind;
pub use error::LiveError;
pub use limits::{LARGEST_HAMMER_M_PER_S, Limits};
pub use live::{Event, Live, Options};
pub use report::{Lead, Report};
