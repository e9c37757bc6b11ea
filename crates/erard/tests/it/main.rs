//! The tests of what users of the crate see.

mod formats;
mod press;
mod public;
mod readme;
