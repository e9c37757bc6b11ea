//! The tests of linkages: one program, so that it is linked once.

mod common;

mod closed_forms;
mod discs;
mod equations;
mod mobility;
mod stops;
mod three_lever;
