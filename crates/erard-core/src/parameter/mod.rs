//! The register of an instrument's numbers, and numbers as people type them: quantities with all their units, one
//! reader, one grammar of changes.
//!
//! [`FileNumber`] is a number of instrument files, with the place, unit and limits that the reader uses; every path is
//! made from it. [`Parameter`] is a number that can be changed by name; [`register`] lists those of an instrument with
//! quantity, value, spread and path. Studies, fits, sensitivities, samples, gradings, pages, C and Python read them.
//!
//! [`Quantity::read`] reads a value, [`Change::read`] a change, [`Sweep::read`] several of either: those of
//! `crate::units`, which files read numbers by, too.

mod register;
mod varied;
mod words;

pub use crate::instrument::FileNumber;
pub use crate::units::{Bare, Change, NumberError, Quantity, Sweep, Unit, list_items};
pub use register::{NameError, Parameter, VaryError, file_unit, nearest, ten_digits};
pub use varied::{
    ChangeError, Entry, ParameterChange, acting_number, in_file_unit, known_name, number_of, register, varied,
    varied_of, varied_text, with_changed_numbers,
};
pub use words::{aliases, canonical_name};
