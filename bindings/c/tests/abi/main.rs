//! The C interface from outside: what a good caller gets, what a bad one, from Rust and from plain C.

mod attack;
mod bad_callers;
mod board;
mod board_kinds;
mod exact;
mod fmi;
mod fmi_keyboard;
mod fronts;
#[path = "../../../../crates/erard-core/tests/common/generated.rs"]
mod generated;
mod haptic;
mod haptic_loop;
mod header;
mod memory;
#[path = "../../../../crates/erard-core/tests/common/not_run.rs"]
mod not_run;
mod object;
mod pages;
mod playing;
mod programs;
mod ranges;
mod sizes;

use std::ptr::{null, null_mut};

use erard_c::*;

/// An action that is freed when it goes.
pub(crate) struct Action(pub(crate) *mut ErardAction);

impl Action {
    /// The built-in concert grand, 50 us a step.
    pub(crate) fn grand() -> Self {
        let mut status = ErardStatus::Internal;
        let action = unsafe { erard_action_new(null(), 0, 50e-6, &raw mut status) };
        assert_eq!((status, action.is_null()), (ErardStatus::Ok, false), "{}", last_error());
        Action(action)
    }

    /// The built-in concert grand whose strings yield.
    pub(crate) fn strung() -> Self {
        Action::of(include_str!("../../../../crates/erard-core/instruments/concert-grand-strings.toml"))
    }

    /// What a file's text describes.
    pub(crate) fn of(text: &str) -> Self {
        let mut status = ErardStatus::Internal;
        let action = unsafe { erard_action_new(text.as_ptr().cast(), text.len(), 50e-6, &raw mut status) };
        assert_eq!((status, action.is_null()), (ErardStatus::Ok, false), "{}", last_error());
        Action(action)
    }

    pub(crate) fn force(&self, force_n: f64) -> ErardReading {
        let mut reading = ErardReading::default();
        assert_eq!(unsafe { erard_action_step_force(self.0, force_n, &raw mut reading) }, ErardStatus::Ok);
        reading
    }

    pub(crate) fn advance(&self, dt_s: f64, input: ErardInput) -> ErardReading {
        let mut reading = ErardReading::default();
        assert_eq!(unsafe { erard_action_advance(self.0, dt_s, &raw const input, &raw mut reading) }, ErardStatus::Ok);
        reading
    }

    pub(crate) fn read(&self) -> ErardReading {
        let mut reading = ErardReading::default();
        assert_eq!(unsafe { erard_action_read(self.0, &raw mut reading) }, ErardStatus::Ok);
        reading
    }

    pub(crate) fn save(&self) -> Vec<u8> {
        let mut size = 0;
        assert_eq!(unsafe { erard_action_save(self.0, null_mut(), &raw mut size) }, ErardStatus::Ok);
        let mut bytes = vec![0; size];
        assert_eq!(unsafe { erard_action_save(self.0, bytes.as_mut_ptr(), &raw mut size) }, ErardStatus::Ok);
        bytes
    }

    pub(crate) fn restore(&self, bytes: &[u8]) -> ErardStatus {
        unsafe { erard_action_restore(self.0, bytes.as_ptr(), bytes.len()) }
    }

    pub(crate) fn angles(&self) -> Vec<u64> {
        let mut angles = vec![0.0; unsafe { erard_action_body_count(self.0) }];
        assert_eq!(unsafe { erard_action_angles(self.0, angles.as_mut_ptr(), angles.len()) }, ErardStatus::Ok);
        angles.iter().map(|angle| angle.to_bits()).collect()
    }
}

impl Drop for Action {
    fn drop(&mut self) {
        unsafe { erard_action_free(self.0) };
    }
}

pub(crate) fn last_error() -> String {
    unsafe { std::ffi::CStr::from_ptr(erard_last_error()) }.to_str().expect("UTF-8").to_owned()
}

/// A text of the library, given back.
pub(crate) fn taken(text: *mut std::ffi::c_char) -> String {
    assert!(!text.is_null(), "{}", last_error());
    let own = unsafe { std::ffi::CStr::from_ptr(text) }.to_str().expect("UTF-8").to_owned();
    unsafe { erard_text_free(text) };
    own
}

pub(crate) fn moving(position_m: f64, velocity_m_per_s: f64) -> ErardInput {
    ErardInput { kind: ERARD_INPUT_MOTION, position_m, velocity_m_per_s, ..ErardInput::default() }
}

pub(crate) fn pushed(force_n: f64) -> ErardInput {
    ErardInput { kind: ERARD_INPUT_FORCE, force_n, ..ErardInput::default() }
}
