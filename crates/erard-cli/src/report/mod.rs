//! One page with everything that was reproduced: claims and verdicts, figures, tables. It needs nothing but itself, also on paper.

mod chart;
mod html;

pub use chart::chart_svg;
pub use html::{Reproduced, page};
