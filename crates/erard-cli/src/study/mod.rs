//! Results of `erard study`: the table, the figure, sensitivities.

mod figure;
pub(crate) mod sensitivities;
mod table;

pub(crate) use figure::{SpeedBands, figure};
pub(crate) use table::{crossed, shown, table_of};
