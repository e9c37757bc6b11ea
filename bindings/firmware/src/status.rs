//! How a call of the C interface ends on a chip: with its status alone.

use core::ffi::c_char;
use core::fmt::Display;

use crate::outcome::ErardStatus;

/// An error.
pub(crate) struct Fault {
    status: ErardStatus,
}

impl Fault {
    /// Its text is for callers that have a place for it.
    pub(crate) fn of(status: ErardStatus, _: &dyn Display) -> Self {
        Fault { status }
    }
}

/// Runs work that may fail. Returns its result, or `none`; the code is then written to `status` (which may be NULL).
pub(crate) fn told<T>(none: T, status: *mut ErardStatus, work: impl FnOnce() -> Result<T, Fault>) -> T {
    let (result, code) = match work() {
        Ok(result) => (result, ErardStatus::Ok),
        Err(fault) => (none, fault.status),
    };
    // SAFETY: `status` is NULL, or aligned and writable memory for one ErardStatus that nothing else uses during the
    // call.
    if let Some(status) = unsafe { status.as_mut() } {
        *status = code;
    }
    result
}

/// Like [`told`], for a function that returns its status.
pub(crate) fn tell(work: impl FnOnce() -> Result<(), Fault>) -> ErardStatus {
    work().map_or_else(|fault| fault.status, |()| ErardStatus::Ok)
}

/// Runs work allowed in real time.
pub(crate) fn quick(work: impl FnOnce() -> ErardStatus) -> ErardStatus {
    work()
}

/// Returns the meaning of a status as one line of English; never NULL. Real time: yes.
#[unsafe(no_mangle)]
pub extern "C" fn erard_status_text(status: i32) -> *const c_char {
    ErardStatus::text(status).as_ptr()
}

/// Returns an empty text: a chip keeps no messages, and creation returns its status. Never NULL. Real time: yes.
#[unsafe(no_mangle)]
pub extern "C" fn erard_last_error() -> *const c_char {
    c"".as_ptr()
}
