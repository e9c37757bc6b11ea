//! The tests of what users of the crate see.

mod press;
mod readme;
