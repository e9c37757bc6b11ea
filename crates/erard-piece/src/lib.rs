//! Plays a piece on the simulated actions of a keyboard.
//!
//! - [`Score`]: a piece as a list of motions: instants, hammer speeds, releases, the pedals' rails;
//! - [`perform`]: plays a score on the instruments of its keys, a job per key on all cores, and reports the result of
//!   each note ([`Played`]) with its faults and their reasons ([`Fault`], [`Reason`]);
//! - [`Sink`]: takes rows and sound as they are made;
//! - [`scan`]: the readings of sensors under the keys, for builders who derive notes from sensors.
//!
//! The crate finds a note's hand by trial. It saves the key's real state, tries a hand, and restores the state if the
//! hammer came too fast, too slow, too early or too late; the first trial that is good enough is the note. It remembers
//! successful hands from rest for each key, so most notes need one trial.
//!
//! SI units; key and finger positive downward, the hammer upward.

mod error;
mod hand;
mod key;
mod key_score;
mod moment;
mod note;
mod options;
mod perform;
mod press;
mod release;
pub mod scan;
mod score;
mod seek;
mod sink;
mod touches;

pub use error::PerformError;
pub use key::RATE_HZ;
pub use moment::Moment;
pub use note::{Fault, Played, Reason, Summary};
pub use options::Options;
pub use perform::{Performance, perform};
pub use score::{FULL_PEDAL_M, LEAD_S, Score, WrittenNote, passage};
pub use sink::{Block, COLUMNS, Sample, Silence, Sink};
