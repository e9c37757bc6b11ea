//! Work of technicians and researchers with an action: measure, regulate, balance, study; compare it with recordings,
//! fit it to them, and validate it against published measurements.
//!
//! Instruments come from [`erard`], which also simulates them.

pub mod balance;
pub mod compare;
pub mod cores;
mod dense;
pub mod diagnose;
pub mod dials;
pub mod digits;
pub mod distances;
pub mod first_impact;
pub mod fit;
pub mod fmu;
pub mod listen;
pub mod measure;
pub mod regulate;
pub mod sample;
pub mod sensitivities;
pub mod study;
pub mod test_press;
pub mod validate;
pub mod weighing;
pub mod worklist;
