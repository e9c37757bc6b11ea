//! The grand piano action behind a C ABI: one interface for control loops, haptic keys, simulators (FMI 2.0) and pages
//! (WebAssembly).
//!
//! cbindgen makes `include/erard.h` from this source (`tests/header.rs` checks it); the README beside it is the
//! contract: ownership, allocation, and what may be called in real time. No physics is here: it calls `erard`,
//! `erard-live` and, with the default feature `workshop`, `erard-workshop` and `erard-figures`.

mod action;
// A page senses no keys, and is small.
#[cfg(not(target_family = "wasm"))]
mod board;
#[cfg(not(target_family = "wasm"))]
mod board_contacts;
#[cfg(not(target_family = "wasm"))]
mod board_hammers;
#[cfg(not(target_family = "wasm"))]
mod board_keys;
mod caller_struct;
mod event_detector;
// A simulator loads a unit as a library of its own platform.
#[cfg(all(feature = "workshop", not(target_family = "wasm")))]
mod fmi;
mod halving;
mod instrument;
mod keyboard;
mod outcome;
mod play;
mod reading;
#[cfg(not(target_family = "wasm"))]
mod simulated_contacts;
mod status;
mod stroke;
mod text;
mod version;
#[cfg(feature = "workshop")]
mod workshop;

pub use action::*;
#[cfg(not(target_family = "wasm"))]
pub use board::*;
#[cfg(not(target_family = "wasm"))]
pub use board_contacts::*;
#[cfg(not(target_family = "wasm"))]
pub use board_hammers::*;
pub use event_detector::*;
pub use halving::*;
pub use instrument::*;
pub use keyboard::*;
pub use reading::*;
#[cfg(not(target_family = "wasm"))]
pub use simulated_contacts::*;
pub use status::{ErardStatus, erard_last_error, erard_status_text};
pub use stroke::*;
pub use text::{erard_memory_free, erard_memory_new, erard_text_free};
pub use version::{erard_abi, erard_version};
#[cfg(feature = "workshop")]
pub use workshop::*;
