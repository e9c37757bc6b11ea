//! The tests of the laboratory: one program, so that it is linked once.

mod compare;
mod fit;
mod real_piano;
mod reproduce;
mod validate;
