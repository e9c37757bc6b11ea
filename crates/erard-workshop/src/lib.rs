//! What technicians and researchers do with an action: measure, regulate, balance, study.
//!
//! An instrument comes from [`erard`]; what is measured, regulated or studied here is simulated by it.

pub mod advice;
pub mod balance;
pub mod cores;
pub mod dials;
pub mod distances;
pub mod fmu;
pub mod kinematics;
pub mod measure;
pub mod regulate;
pub mod sensitivities;
pub mod study;
pub mod trying;
pub mod weighing;
