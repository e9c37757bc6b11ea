//! Plays a piece on the simulated actions of a keyboard.
//!
//! - [`Score`]: a piece as motions to be made: instants, hammer speeds, releases, the pedals' rails;
//! - [`perform`]: plays a score on the instruments of its keys, a job per key on all cores, and reports what became of
//!   each note ([`Played`]) and why ([`Fault`], [`Reason`]);
//! - [`Sink`]: takes rows and sound as they are made;
//! - [`scan`]: what sensors under the keys read meanwhile, for builders who derive notes from sensors.
//!
//! A note's hand is found by playing it. The key's real state is saved, a hand is tried, and the state is restored if
//! the hammer came too fast, too slow, too early or too late; the trial that is good enough is the note. Hands that
//! were right from rest are remembered per key, so most notes need one trial.
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
pub use score::{FULL_PEDAL_M, LEAD_S, Score, Wanted, passage};
pub use sink::{Block, COLUMNS, Silence, Sink};
