//! Pieces played on a few keys, and what became of their notes.

mod common;
mod files;
#[path = "../../../erard-core/tests/common/generated.rs"]
mod generated;
mod notes;
mod pedals;
mod performances;
mod rows;
mod scans;
