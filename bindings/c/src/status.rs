//! How a call ends: its outcome, its message, and no panic beyond it.

use std::cell::RefCell;
use std::ffi::{CString, c_char};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::ptr::null_mut;

pub use crate::outcome::ErardStatus;

thread_local! {
    static LAST: RefCell<Option<CString>> = const { RefCell::new(None) };
}

/// Bytes kept of the beginning and of the end of a long message: a caller may give a name of a million letters.
const SHOWN: usize = 1000;

/// Returns the text; of a long one, beginning and end.
fn shortened(text: &str) -> String {
    let (begin, end) = (text.floor_char_boundary(SHOWN), text.ceil_char_boundary(text.len().saturating_sub(SHOWN)));
    if begin >= end {
        return text.to_owned();
    }
    format!("{} ... ({} bytes left out) ... {}", &text[..begin], end - begin, &text[end..])
}

/// An error with its code.
#[derive(Debug)]
pub(crate) struct Fault {
    pub status: ErardStatus,
    pub text: String,
}

impl Fault {
    pub(crate) fn new(status: ErardStatus, text: impl Into<String>) -> Self {
        Fault { status, text: text.into() }
    }

    /// Makes the fault that something says. Boards do.
    #[cfg(not(target_family = "wasm"))]
    pub(crate) fn of(status: ErardStatus, what: &dyn std::fmt::Display) -> Self {
        Fault::new(status, what.to_string())
    }

    /// Makes the fault of a NULL pointer.
    pub(crate) fn null(what: &str) -> Self {
        Fault::new(ErardStatus::Null, format!("{what} is NULL"))
    }
}

/// Frees a caller's object. NULL does nothing; a panic ends here.
///
/// # Safety
/// The object was boxed by this library, and is used no more.
pub(crate) unsafe fn ended<T>(own: *mut T) {
    if !own.is_null() {
        told((), null_mut(), || {
            // SAFETY: `own` is not NULL, was boxed by this library, has not been freed, and is not used again (the
            // contract of this function).
            drop(unsafe { Box::from_raw(own) });
            Ok(())
        });
    }
}

/// Runs work that may allocate and fail. Returns its result, or `none` on failure; the code is then written to `status`
/// (which may be NULL), and the text is kept for [`erard_last_error`]. A panic ends here.
pub(crate) fn told<T>(none: T, status: *mut ErardStatus, work: impl FnOnce() -> Result<T, Fault>) -> T {
    let done = catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|panic| {
        let said = panic.downcast_ref::<String>().cloned().or(panic.downcast_ref::<&str>().map(|s| (*s).to_owned()));
        let said = said.unwrap_or_default();
        Err(Fault::new(ErardStatus::Internal, format!("internal error of the library: {said}")))
    });
    let (result, code) = match done {
        Ok(result) => (result, ErardStatus::Ok),
        Err(fault) => {
            // A text for C ends at its first zero.
            let text = CString::new(shortened(&fault.text).replace('\0', " ")).unwrap_or_default();
            LAST.with(|last| *last.borrow_mut() = Some(text));
            (none, fault.status)
        }
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
    let mut status = ErardStatus::Ok;
    told((), &raw mut status, work);
    status
}

/// Runs work allowed in real time: no text is kept. A panic ends here.
pub(crate) fn quick(work: impl FnOnce() -> ErardStatus) -> ErardStatus {
    catch_unwind(AssertUnwindSafe(work)).unwrap_or(ErardStatus::Internal)
}

/// Returns the message of this thread's last failed call: one line of UTF-8, with line and key for a file; empty if no
/// call failed. Real-time functions return a status only and leave the message as it is. The text belongs to the
/// library and is valid until the next such call fails.
#[unsafe(no_mangle)]
pub extern "C" fn erard_last_error() -> *const c_char {
    // At the end of a thread its storage is gone: there is no message then.
    LAST.try_with(|last| last.borrow().as_ref().map_or(c"".as_ptr(), |text| text.as_ptr())).unwrap_or(c"".as_ptr())
}

/// Returns the meaning of a status as one line of English; never NULL. Real time: yes.
#[unsafe(no_mangle)]
pub extern "C" fn erard_status_text(status: i32) -> *const c_char {
    ErardStatus::text(status).as_ptr()
}
