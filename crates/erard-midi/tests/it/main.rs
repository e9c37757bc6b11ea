//! One program, so that it is linked once.

mod bytes;
mod files;
mod foreign;
mod habits;
mod laws;
mod messages;
#[path = "../../../erard-core/tests/common/not_run.rs"]
mod not_run;
mod notes;
mod second_reader;
