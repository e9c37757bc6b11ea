//! Sensed keys as MIDI: a stream of key positions or forces, played on the simulated action of every key.
//!
//! - [`stream`]: the text that a sender writes, line by line;
//! - [`sensor`], [`profile`], [`calibrate`]: raw readings to millimetres, from the two stops of each key and the
//!   sensor's law, drift followed;
//! - [`contacts`], [`contact_table`]: two or three contacts under each key, and the hammer speeds that a simulated
//!   action has for the time between them;
//! - [`hammers`]: sensors at hammer shanks, whose speed is read directly;
//! - [`Live`]: takes samples as they come and returns notes ([`Event`]) when their hammers meet the strings, or before
//!   ([`Options::ahead`]); it counts limited, clipped, late and lost samples ([`Report`]);
//! - [`cable`]: how long bytes queue for a DIN cable; [`quality`]: errors from bits and rate of a sensor.
//!
//! Without the feature `std` (on by default) the crate contains the parts for a microcontroller, without a heap and
//! also in single precision: [`sensor`], [`converter`], [`stops`], [`sensed`], [`sensing`], [`contacts`], [`hammers`]
//! and [`board`]. A stream's keys go through the same code. With the feature `actions` alone the actions of `erard`
//! move under sensed keys and make the table of contacts, and there is neither text nor file: `liberard` is built so.
//!
//! SI units, except for files, which use millimetres; key and finger positive downward, the hammer upward.

#![cfg_attr(not(feature = "actions"), no_std)]

#[cfg(feature = "actions")]
pub mod action;
#[cfg(feature = "std")]
pub mod ahead;
pub mod board;
#[cfg(feature = "std")]
pub mod cable;
#[cfg(feature = "std")]
pub mod calibrate;
#[cfg(feature = "std")]
mod clock;
#[cfg(feature = "actions")]
pub mod contact_table;
pub mod contacts;
pub mod converter;
mod drive;
#[cfg(feature = "std")]
mod error;
#[cfg(feature = "actions")]
mod find;
#[cfg(feature = "actions")]
pub mod finger;
pub mod hammers;
#[cfg(feature = "std")]
mod key;
mod limits;
#[cfg(feature = "std")]
mod live;
#[cfg(feature = "std")]
pub mod profile;
#[cfg(feature = "std")]
pub mod quality;
#[cfg(feature = "std")]
mod report;
pub mod sensed;
pub mod sensing;
pub mod sensor;
pub mod stops;
#[cfg(feature = "std")]
pub mod stream;

pub use drive::{Push, SensorKind};
#[cfg(feature = "std")]
pub use error::LiveError;
#[cfg(feature = "actions")]
pub use find::{blow_m, dip_m};
pub use limits::{Limits, MAX_HAMMER_M_PER_S};
#[cfg(feature = "std")]
pub use live::{Event, Live, Options};
#[cfg(feature = "std")]
pub use report::{Lead, Report};
