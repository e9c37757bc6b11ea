//! Physical quantities with all their units, and numbers as people type them: one reader, one grammar of changes.
//!
//! [`Quantity::read`] reads a value, [`Change::read`] a change, [`Sweep::read`] several of either. Options, files, C,
//! Python and the studio call these and no other reader. A number without a unit is in the unit that the caller names
//! ([`Bare`]); it is never a factor. [`crate::parameter`] is the public module.

mod change;
mod number;
mod quantity;
mod sweep;

pub use change::Change;
pub use number::{Bare, NumberError};
pub use quantity::{Quantity, Unit};
pub use sweep::{Sweep, list_items};
