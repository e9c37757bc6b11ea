//! Texts and memory passed between library and caller.

use std::ffi::{CStr, CString, c_char};

use crate::status::{ErardStatus, Fault};

/// Passes a text to the caller, who frees it with `erard_text_free`; `length` (which may be NULL) receives its length.
pub(crate) fn give(text: String, length: *mut usize) -> Result<*mut c_char, Fault> {
    let text = CString::new(text).map_err(|_| Fault::new(ErardStatus::Internal, "a text with a zero in it"))?;
    // SAFETY: `length` is NULL, or aligned and writable memory for one size that nothing else uses during the call.
    if let Some(length) = unsafe { length.as_mut() } {
        *length = text.as_bytes().len();
    }
    Ok(text.into_raw())
}

/// Returns the caller's bytes; `None` for NULL.
pub(crate) unsafe fn bytes<'a>(text: *const c_char, length: usize) -> Result<Option<&'a [u8]>, Fault> {
    if text.is_null() {
        return if length == 0 { Ok(None) } else { Err(Fault::null("the text, with a length that is not 0,")) };
    }
    if length > isize::MAX as usize {
        return Err(Fault::new(ErardStatus::Size, "a length that no memory has"));
    }
    // SAFETY: `text` is not NULL and begins `length` readable bytes, no more than an isize counts, that do not change
    // during the call.
    Ok(Some(unsafe { core::slice::from_raw_parts(text.cast(), length) }))
}

/// Returns the caller's zero-terminated name.
pub(crate) unsafe fn name<'a>(name: *const c_char, what: &str) -> Result<&'a str, Fault> {
    if name.is_null() {
        return Err(Fault::null(what));
    }
    // SAFETY: `name` is not NULL, ends with a zero, and does not change during the call.
    let name = unsafe { CStr::from_ptr(name) };
    name.to_str().map_err(|_| Fault::new(ErardStatus::Argument, format!("{what} is not UTF-8")))
}

/// Frees a text that the library returned. NULL does nothing. Real time: no.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_text_free(text: *mut c_char) {
    if !text.is_null() {
        // SAFETY: `text` is not NULL, comes from `give` (`CString::into_raw`), has not been freed, and is not used
        // again.
        drop(unsafe { CString::from_raw(text) });
    }
}

/// Allocates `bytes` bytes, set to zero, for callers that have no memory to pass, such as a web page. Returns NULL for
/// 0 bytes and when memory is exhausted. Free it with erard_memory_free. Real time: no.
#[unsafe(no_mangle)]
pub extern "C" fn erard_memory_new(bytes: usize) -> *mut u8 {
    if bytes == 0 || bytes > isize::MAX as usize {
        return core::ptr::null_mut();
    }
    let mut memory = Vec::<u8>::new();
    if memory.try_reserve_exact(bytes).is_err() {
        return core::ptr::null_mut();
    }
    memory.resize(bytes, 0);
    Box::into_raw(memory.into_boxed_slice()).cast()
}

/// Frees memory that erard_memory_new returned; `bytes` must be its size. NULL does nothing. Real time: no.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_memory_free(memory: *mut u8, bytes: usize) {
    if !memory.is_null() {
        // SAFETY: `memory` is not NULL, comes from `erard_memory_new` with this number of `bytes`, has not been freed,
        // and is not used again.
        drop(unsafe { Box::from_raw(core::ptr::slice_from_raw_parts_mut(memory, bytes)) });
    }
}
