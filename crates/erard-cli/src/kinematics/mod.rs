//! `erard kinematics`: cases of the three levers as numbers, a table and figures.

mod figures;
pub(crate) mod moves;
mod shown;
mod summary;
mod table;

pub(crate) use figures::{dynamics_picture, leverage_picture, sliding_picture};
pub(crate) use shown::Shown;
pub(crate) use summary::Summary;
pub(crate) use table::table;
