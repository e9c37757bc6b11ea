//! Outcome of a call, and its message.

use std::cell::RefCell;
use std::ffi::{CStr, CString, c_char};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::ptr::null_mut;

/// Outcome of a call. Zero is success, above zero success with a remark, below zero an error. An error means that
/// nothing has changed; the one exception is erard_keyboard_step.
#[repr(i32)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ErardStatus {
    /// Done.
    Ok = 0,
    /// Done, but a step reached its iteration limit and its error may exceed the tolerance.
    IterationLimit = 1,
    /// A pointer is NULL that must not be.
    Null = -1,
    /// An argument is not allowed: an unknown kind of input, a name that is not UTF-8, a value or JSON that cannot be
    /// read.
    Argument = -2,
    /// A number is not finite, or became so during the step.
    NotFinite = -3,
    /// A number is out of range: a force, position or speed beyond ERARD_MAX_FORCE_N, ERARD_MAX_POSITION_M or
    /// ERARD_MAX_SPEED_M_PER_S, a step length, a time or a number of steps.
    Range = -4,
    /// No key, body, zone, screw, parameter or built-in has this name or number.
    NoSuch = -5,
    /// The caller's memory is too small. erard_action_save and erard_keyboard_save write the size that is needed.
    Size = -6,
    /// The bytes are damaged, or not a saved state of this version.
    Saved = -7,
    /// The saved state belongs to another instrument, or to other settings: another step length, theta, solver or
    /// friction.
    Foreign = -8,
    /// The file's text is invalid: erard_last_error says where.
    File = -9,
    /// The file is valid, but its instrument cannot be assembled, finds no rest, or cannot be measured or regulated.
    Model = -10,
    /// The caller's progress function stopped the work.
    Interrupted = -11,
    /// An error inside this library. Only free the object or, if it is an action, reset or restore it.
    Internal = -12,
    /// The first field of a struct does not hold the struct's size, or a field that this library does not know is not
    /// 0.
    Struct = -13,
}

impl ErardStatus {
    /// Meaning of a status in one line.
    fn text(code: i32) -> &'static CStr {
        match code {
            0 => c"done",
            1 => c"done, but a step reached its iteration limit",
            -1 => c"a pointer is NULL",
            -2 => c"an argument is not one of those that are allowed",
            -3 => c"a number is not finite",
            -4 => c"a number is out of range",
            -5 => c"there is no such key, body, zone, screw or number",
            -6 => c"the memory is too small",
            -7 => c"the bytes are damaged, or not a saved state of this version",
            -8 => c"the bytes are the state of another instrument or of other settings of the steps",
            -9 => c"the text of the file is wrong",
            -10 => c"the instrument cannot be assembled, finds no rest, or cannot be measured",
            -11 => c"the caller ended the work",
            -12 => c"a fault of the library",
            -13 => c"the first field of a struct is not its size, or a field that the library does not know is not 0",
            _ => c"no status of this library",
        }
    }
}

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
