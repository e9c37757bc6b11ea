//! What `erard live` reads and sends: lines as they come, bytes as they go, and how long they took.

pub(crate) mod feed;
pub(crate) mod latency;
pub(crate) mod report;
mod wire;

pub(crate) use wire::{Bits, Sounding, Wire};
