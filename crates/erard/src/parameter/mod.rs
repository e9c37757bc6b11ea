//! Numbers as people type them: quantities with all their units, one reader, one grammar of changes.
//!
//! [`Quantity::read`] reads a value, [`Change::read`] a change, [`Sweep::read`] several of either. Options, files, C,
//! Python and the studio call these and no other reader. A number without a unit is in the unit that the caller names
//! ([`Bare`]); it is never a factor.

mod change;
mod number;
mod quantity;
mod sweep;

pub use change::Change;
pub use number::{Bare, NumberError};
pub use quantity::{Quantity, Unit};
pub use sweep::{Sweep, read_list};
