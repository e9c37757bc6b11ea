//! Indices that callers pass.

use thiserror::Error;

/// An index that a caller passed is out of range: of a body, zone, spring, screw, string, key.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("found {what} {found}, expected one of {count}, counted from {first}")]
#[non_exhaustive]
pub struct IndexError {
    /// Singular noun of what was asked for, e.g. `body`.
    pub what: &'static str,
    /// Index found.
    pub found: usize,
    /// How many there are.
    pub count: usize,
    /// The lowest index: 1 of keys, otherwise 0.
    pub first: usize,
}

impl IndexError {
    /// Checks an index that counts from 0. `what` is a singular noun, e.g. `body`.
    ///
    /// # Errors
    /// It is not below `count`.
    pub fn check(what: &'static str, found: usize, count: usize) -> Result<(), Self> {
        if found < count { Ok(()) } else { Err(IndexError { what, found, count, first: 0 }) }
    }

    /// Checks the number of a key, and returns its index.
    pub(crate) fn key(found: usize, count: usize) -> Result<usize, Self> {
        let index = found.checked_sub(1).filter(|index| *index < count);
        index.ok_or(IndexError { what: "key", found, count, first: 1 })
    }
}
