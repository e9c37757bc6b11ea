//! Structs that a caller allocates. Their first field is their size, so that a program and a library of different
//! versions understand each other.

use crate::ErardStatus;

/// Largest size that is believed, bytes: a larger one is memory that was never set.
const MAX_BYTES: usize = 4096;
/// Every size is a multiple of this, bytes.
const ALIGNMENT: usize = 8;

/// A struct that a caller allocates. New fields are added at its end, and 0 must mean what their absence means.
///
/// # Safety
/// The struct is `repr(C)` and consists of numbers, for which every bit pattern is a value. It has no padding, its
/// alignment is 8 or less, and its first field is its size, a `u32`.
pub(crate) unsafe trait CallerStruct: Copy + Default {
    /// Size in the first header that declared the struct, bytes.
    const FIRST_BYTES: usize;
    /// Does not compile if the struct is smaller now: fields are only added.
    const KEEPS_FIRST_BYTES: () = assert!(size_of::<Self>() >= Self::FIRST_BYTES);

    /// Returns the struct with its size; every other number is 0.
    fn zeroed() -> Self {
        // SAFETY: every bit pattern is a value of `Self`, and `value` is aligned and begins with a u32, its size (the
        // contract of this trait); nothing else uses it yet.
        unsafe {
            let mut value = core::mem::zeroed::<Self>();
            (&raw mut value).cast::<u32>().write(size_of::<Self>() as u32);
            value
        }
    }
}

/// Returns the size at the beginning of a caller's struct.
///
/// # Safety
/// `at` is not NULL; it is aligned and begins with an initialised size.
#[inline]
unsafe fn stated_bytes<T: CallerStruct>(at: *const T) -> Result<usize, ErardStatus> {
    let () = T::KEEPS_FIRST_BYTES;
    // SAFETY: `at` is not NULL; it is aligned and begins with an initialised u32 (the contract of this function).
    let bytes = unsafe { at.cast::<u32>().read() } as usize;
    if bytes < T::FIRST_BYTES || bytes > MAX_BYTES || !bytes.is_multiple_of(ALIGNMENT) {
        return Err(ErardStatus::Struct);
    }
    Ok(bytes)
}

/// A caller's memory for results: one struct, or several one after the other.
pub(crate) struct Place<T> {
    at: *mut T,
    bytes: usize,
}

impl<T: CallerStruct> Place<T> {
    /// Reads the size that the first struct states. NULL gives `None`.
    ///
    /// # Safety
    /// `at` is NULL, or aligned memory that begins with an initialised size and has that size.
    #[inline]
    pub(crate) unsafe fn new(at: *mut T) -> Result<Option<Self>, ErardStatus> {
        if at.is_null() {
            return Ok(None);
        }
        // SAFETY: `at` is not NULL; it is aligned and begins with an initialised size, by the contract of this
        // function.
        let bytes = unsafe { stated_bytes(at) }?;
        Ok(Some(Place { at, bytes }))
    }

    /// Writes one struct: as much of it as the caller's header knows, and 0 for the fields that only that header knows.
    ///
    /// # Safety
    /// The caller's memory has room for more than `index` structs of the stated size, and nothing else uses it during
    /// the call.
    #[inline]
    pub(crate) unsafe fn write(&self, index: usize, value: &T) {
        let known = self.bytes.min(size_of::<T>());
        // SAFETY: `self.at` has room for more than `index` structs of `self.bytes` bytes, a multiple of 8, so that each
        // is aligned; `value` has at least `known` bytes.
        unsafe {
            let place = self.at.cast::<u8>().add(index * self.bytes);
            core::ptr::copy_nonoverlapping(core::ptr::from_ref(value).cast::<u8>(), place, known);
            place.add(known).write_bytes(0, self.bytes - known);
            place.cast::<u32>().write(self.bytes as u32);
        }
    }
}

/// Reads a caller's struct: as much of it as this library knows; fields that the caller's header lacks are 0. Refuses
/// a struct in which a field that only the caller's header knows is not 0.
///
/// # Safety
/// `at` is NULL, or an aligned struct that begins with its size and does not change during the call.
#[inline]
pub(crate) unsafe fn given<T: CallerStruct>(at: *const T) -> Result<T, ErardStatus> {
    // SAFETY: `at` is NULL, or an array of one struct, by the contract of this function.
    unsafe { given_nth(at, 0) }
}

/// Reads one of a caller's array of structs, all of which have the size that the first one states.
///
/// # Safety
/// `at` is NULL, or an aligned array of more than `index` structs that begins with their size and does not change
/// during the call.
#[inline]
pub(crate) unsafe fn given_nth<T: CallerStruct>(at: *const T, index: usize) -> Result<T, ErardStatus> {
    if at.is_null() {
        return Err(ErardStatus::Null);
    }
    // SAFETY: `at` is not NULL; it is aligned and begins with an initialised size, by the contract of this function.
    let bytes = unsafe { stated_bytes(at) }?;
    let known = bytes.min(size_of::<T>());
    let mut value = T::default();
    // SAFETY: `at` begins more than `index` times `bytes` initialised bytes, by the contract of this function; `value`
    // has room for `known` of them, and every bit pattern is one of its values.
    let unknown = unsafe {
        let (own, from) = ((&raw mut value).cast::<u8>(), at.cast::<u8>().add(index * bytes));
        core::ptr::copy_nonoverlapping(from, own, known);
        own.cast::<u32>().write(size_of::<T>() as u32);
        core::slice::from_raw_parts(from.add(known), bytes - known)
    };
    if unknown.iter().any(|byte| *byte != 0) {
        return Err(ErardStatus::Struct);
    }
    Ok(value)
}
