//! The tests of linkages and of the three levers: one program, so that it is linked once.

mod common;
#[path = "../../../erard-core/tests/common/generated.rs"]
mod generated;
#[path = "../../../moreau-rigid/src/problems/closed_forms.rs"]
mod textbook;

mod closed_forms;
mod discs;
mod equations;
mod levers;
mod mobility;
mod stops;
mod three_lever;
