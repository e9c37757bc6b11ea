//! What the command `erard` shows: pictures of the action, figures of a run, and the page that plays it.
//!
//! No physics here: poses, forces and instants come from [`erard::run::Run`]; these modules only draw them.

pub mod drawing;
pub mod figure;
pub mod page;
pub mod svg;
