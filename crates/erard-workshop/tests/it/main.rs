//! Tests of the workshop: one program, so that it is linked once.

#[path = "../../../erard-core/tests/common/mod.rs"]
mod common;

mod bends;
mod combinations;
mod compare;
mod diagnose;
mod distances;
mod fit;
mod further_instruments;
mod fuzz_parsers;
mod keyboard;
mod listen;
mod measures;
mod press_mutants;
mod real_piano;
mod register;
mod regulate;
mod samples;
mod sensitivities;
mod study;
mod validate;
mod worklist;
