#![doc = include_str!("../README.md")]
//!
//! ## From files
//!
//! A [`Design`] is three levers (key, whippen with its jack, hammer) and the height of the hammer at let-off. It comes
//! from a linkage file with the papers' lengths L1 to L10 ([`LinkageFile`]) or from an instrument file ([`derive()`]).
//! In the second case the contacts keep their shapes: a dome that slides along the heel, a roller on the jack.
//! [`Design::case`] moves parts and regulates again. [`slow_press`] runs the dynamic model to show how accurate the
//! geometry alone is.
//!
//! Metres and radians. `k`, `w`, `h` are the absolute angles in the equations; `k` (the direction of the key surface's
//! normal) increases as the key goes down.

mod case;
mod derive;
mod file;
mod format;
mod slow_press;

pub mod linkage;
pub mod three_lever;

pub use case::{Case, Design, Digest, LetOff, Spot};

pub use derive::{DeriveError, Derived, NotThreeLevers, derive};
pub use file::{LinkageFile, json_schema};
pub use slow_press::{Agreement, SlowPress, slow_press};
