//! The tests of what users of the crate see.

mod readme;
