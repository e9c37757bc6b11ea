//! What `fit` is asked and answers: values with units, the table, the report, the figure.

mod figure;
mod report;
mod table;
mod values;

pub use figure::figure;
pub use report::Report;
pub use table::{lines, write_csv};
pub use values::{column, value};
