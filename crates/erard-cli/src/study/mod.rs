//! Arguments and results of `erard study`: the varied parameters, the table, the figure.

mod figure;
pub(crate) mod sensitivities;
mod table;
mod vary;

pub(crate) use figure::chart;
pub(crate) use table::{Column, Row, columns, doubts, shown, table_of};
pub(crate) use vary::{Axis, GRADING, Source, Target};
