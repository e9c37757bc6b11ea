//! Streams whose truth is known, played and read back.

mod announced;
mod calibrated;
mod chip;
mod clocks;
mod common;
mod contacts;
mod foreign;
mod garbled;
#[path = "../../../erard-core/tests/common/generated.rs"]
mod generated;
mod hammers;
mod limited;
mod played;
mod press;
mod streams;
