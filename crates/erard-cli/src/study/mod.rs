//! What `erard study` is asked and answers: what is varied, the table, the figure.

mod figure;
pub mod sensitivities;
mod table;
mod vary;

pub use figure::chart;
pub use table::{Row, columns, doubts, lines};
pub use vary::{Axis, GRADING, Source, Target};
