//! Arguments and results of `fit`: values with units, the table, the report, the figure.

mod figure;
mod report;
mod table;
mod values;

pub(crate) use figure::figure;
pub(crate) use report::report;
pub(crate) use table::{headlines, lines, table};
pub(crate) use values::{bounds, column, value};
