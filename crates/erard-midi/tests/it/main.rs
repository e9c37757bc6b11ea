//! One program, so that it is linked once.

mod files;
mod laws;
mod messages;
mod notes;
