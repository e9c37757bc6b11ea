//! Figures of a run, drawings of the action, and a page that plays it.
//!
//! No physics here: poses, forces and instants come from [`erard::run::Run`]; these modules only ask for them and draw
//! them. No files and no terminal either: every function returns text or bytes, for the command, a page or a notebook.

pub mod drawing;
pub mod figure;
pub mod made_by;
pub mod page;
mod picture;
pub mod roll;
mod svg;

pub use picture::Picture;
#[cfg(feature = "png")]
pub use picture::PngError;

/// The style of every page: colours by day and night, type, tables, figures, print. A page adds what only it has.
pub const HOUSE_STYLE: &str = include_str!("house.css");
