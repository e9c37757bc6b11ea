//! Streams whose truth is known, played and read back.

mod announced;
mod calibrated;
mod common;
mod limited;
mod played;
mod streams;
