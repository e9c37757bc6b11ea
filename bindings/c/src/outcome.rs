//! Outcome of a call. This file is compiled for chips, too (`bindings/firmware`).

use core::ffi::CStr;

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
    pub(crate) fn text(code: i32) -> &'static CStr {
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
