//! The register of an instrument's numbers, and numbers as people type them: quantities with all their units, one
//! reader, one grammar of changes.
//!
//! [`FileNumber`] is a number of instrument files, with the place, unit and limits that the reader uses; every path is
//! made from it. [`Parameter`] is a number that can be changed by name; [`register`] lists those of an instrument with
//! quantity, value, spread and path. Studies, fits, sensitivities, samples, gradings, pages, C and Python read them.
//!
//! [`Quantity::read`] reads a value, [`Change::read`] a change, [`Sweep::read`] several of either. Options, files, C,
//! Python and the studio call these and no other reader. A number without a unit is in the unit that the caller names
//! ([`Bare`]); it is never a factor.

mod change;
mod number;
mod quantity;
mod register;
mod sweep;
mod varied;
mod words;

pub use crate::instrument::FileNumber;
pub use change::Change;
pub use number::{Bare, NumberError};
pub use quantity::{Quantity, Unit};
pub use register::{NameError, Parameter, nearest, ten_digits};
pub use sweep::{Sweep, list_items};
pub use varied::{
    ChangeError, Entry, Wanted, acting_number, file_unit, in_file_unit, known_name, number_of, register, varied,
    varied_of, varied_text, with_changed_numbers,
};
pub use words::{aliases, canonical_name};
