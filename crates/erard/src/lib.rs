//! The grand piano action, simulated.
//!
//! Data flows one way: instrument file and stroke -> assembled mechanism -> steps -> run (series and events) -> measures.

pub mod assembly;
pub mod bench;
pub mod compare;
pub mod cores;
mod course;
pub mod equilibrium;
pub mod events;
pub mod instrument;
pub mod keyboard;
pub mod kinematics;
pub mod measure;
pub mod mechanism;
pub mod one_dof;
mod recorder;
pub mod regulate;
pub mod regulation;
pub mod reproduce;
pub mod run;
pub mod sight;
pub mod simulation;
pub mod stroke;
pub mod study;
pub mod validate;
