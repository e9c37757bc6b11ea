//! The tests of the actions, their files and their runs: one program, so that it is linked once.

// As the other crates of the workspace call it, which share some of these files.
extern crate erard_core as erard;

#[path = "../common/mod.rs"]
mod common;

mod absurdity;
mod allocation;
mod bends;
mod bounded_work;
mod checked_instruments;
mod control;
mod convergence;
mod damper_compass;
mod dampers;
mod determinism;
mod directions;
mod energy;
mod felt_laws;
mod firmware;
mod halving;
mod hand;
mod instrument_errors;
mod instrument_schema;
mod keys;
mod levels;
mod one_dof;
mod player;
mod playing;
mod reactions;
mod repose;
mod rest;
mod rest_pose;
mod robustness;
mod saved_states;
mod shipped_instruments;
mod single_precision;
mod solvers;
mod strings;
mod stroke_files;
mod trust;
mod typed_files;
mod typed_table;
