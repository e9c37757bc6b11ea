//! The tests of the command: one program, so that it is linked once.

mod common;
#[path = "../../../erard-core/tests/common/generated.rs"]
mod generated;
#[path = "../../../erard-core/tests/common/not_run.rs"]
mod not_run;

#[cfg(target_os = "linux")]
mod attack;
mod bad_input;
mod book;
mod desk;
mod diagnose;
mod endings;
mod faults;
mod fit;
mod fmu;
mod formats;
mod good_runs;
mod identity;
mod inside;
mod json;
mod keyboard;
mod kinematics;
mod levels;
mod limits;
mod listen;
mod live;
mod measure;
mod nothing_lost;
mod play;
mod ranges;
mod recordings;
mod regulate;
mod samples;
mod scan;
mod short;
mod studio;
mod study;
mod trust;
mod typed;
mod validate;
mod wav;
mod weigh;

/// What the tests run.
const PROGRAM: &str = env!("CARGO_BIN_EXE_erard");
