//! Leverage and sliding from the geometry alone: touch in a second, without dynamics.
//!
//! A [`Design`] is three levers (key, whippen with its jack, hammer) and the height at which the hammer is let off. It
//! comes from a linkage file with the papers' lengths L1 to L10 ([`LinkageFile`]) or from an instrument file
//! ([`derive()`]), where the contacts stay what they are: a dome that slides along the heel, a roller on the jack.
//! [`Design::case`] moves parts and regulates again; [`slow_press`] lets the dynamic model say how well the geometry
//! alone predicts it.
//!
//! Metres and radians; `k`, `w`, `h` are the absolute angles of the equations, and `k` (the direction of the key
//! surface's normal) grows as the key goes down.

mod case;
mod derive;
mod file;
mod format;
mod slow_press;

pub use case::{Case, Design, Digest, LetOff, Spot};

pub use derive::{DeriveError, Derived, NotThreeLevers, derive};
pub use file::{LinkageFile, json_schema};
pub use slow_press::{Agreement, SlowPress, slow_press};
