//! Textbook problems with known answers: hinged bodies, felts, set-valued pivots, and the one-step problem alone.
//!
//! Every reference value was evaluated independently of this project (closed forms, or published figures); each test states
//! the claim and why its tolerance is what it is.

// Matrix problems index several arrays by one number.
#![allow(clippy::needless_range_loop)]

mod drives;
mod felt;
mod mechanism;
mod pivots;
mod relay;
