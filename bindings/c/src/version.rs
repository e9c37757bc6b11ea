//! Version of the library.

use std::ffi::c_char;

use crate::reading::ERARD_ABI;

/// Returns the version of this library, e.g. "0.1.0"; never NULL. Real time: yes.
#[unsafe(no_mangle)]
pub extern "C" fn erard_version() -> *const c_char {
    concat!(env!("CARGO_PKG_VERSION"), "\0").as_ptr().cast()
}

/// Returns the version of this interface: ERARD_ABI of the header that the library was built with. Real time: yes.
#[unsafe(no_mangle)]
pub extern "C" fn erard_abi() -> u32 {
    ERARD_ABI
}
