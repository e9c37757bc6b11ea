//! The grand piano action, simulated.
//!
//! Data flows one way: instrument file and stroke -> assembled mechanism -> steps -> run (series and events) -> measures.

pub mod instrument;
pub mod run;
