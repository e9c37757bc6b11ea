//! The tables of contacts, made by a simulated action: on a computer, for boards of contacts there and on chips.

use std::ffi::c_char;
use std::path::Path;

use erard::instrument::utf8;
use erard::keyboard::Keyboard;
use erard_live::contact_table::{ContactTableError, PRESSED_KEY, Presses};

use crate::board::refused;
use crate::board_contacts::{ErardContacts, fault_of};
use crate::caller_struct::{Place, given};
use crate::instrument::{builtin_keyboard, file_fault};
use crate::outcome::ErardStatus;
use crate::status::{Fault, tell};
use crate::text::bytes;

/// Fills the tables of contacts, and which of them ends a note, by a simulated action, as `erard calibrate --contacts`
/// does: reads `count`, `depths_m` and the scan's numbers of `contacts`, and writes `off`, `point_count` and `points`.
/// Middle C of a keyboard is pressed, struck and re-struck, which takes some seconds. `keyboard` is the text of a
/// keyboard file (UTF-8, `length` bytes) whose base instrument is built in; NULL and 0 give the built-in concert grand.
/// Where two or three contacts lie too near to each other, or below the key's dip, it returns ERARD_STATUS_RANGE. Not
/// on a chip: a program there has the result as a constant. Real time: no.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_contacts_simulate(
    contacts: *mut ErardContacts,
    keyboard: *const c_char,
    length: usize,
) -> ErardStatus {
    tell(|| {
        // SAFETY: `contacts` is NULL, or an initialised ErardContacts of the size that it states.
        let asked = unsafe { given(contacts) }.map_err(|status| refused(status, "the contacts"))?;
        // SAFETY: `contacts` is aligned and writable memory that begins with its size.
        let place = unsafe { Place::new(contacts) }.map_err(|status| refused(status, "the contacts"))?;
        let place = place.ok_or_else(|| refused(ErardStatus::Null, "the contacts"))?;
        let count = asked.check()?;
        // SAFETY: `keyboard` is NULL, or `length` readable bytes that do not change during the call.
        let keyboard = match unsafe { bytes(keyboard, length) }? {
            None => builtin_keyboard("concert-grand")?,
            Some(bytes) => {
                let text = utf8(bytes, "keyboard").map_err(|error| file_fault(&error))?;
                Keyboard::parse(text, "keyboard", Path::new("")).map_err(|error| file_fault(&error))?
            }
        };
        let model = |error: &dyn std::fmt::Display| Fault::of(ErardStatus::Model, error);
        let instrument = keyboard.key(PRESSED_KEY).map_err(|error| model(&error))?;
        let presses = Presses::of(&instrument, &mut |_| true).map_err(|error| model(&error))?;
        let law =
            presses.law(&asked.depths_m[..count], asked.scan_period_s, asked.bounce_s).map_err(
                |error| match error {
                    ContactTableError::Contacts(fault) => fault_of(&fault),
                    ContactTableError::Beyond { .. } => Fault::of(ErardStatus::Range, &error),
                    error => model(&error),
                },
            )?;
        let mut made = ErardContacts { off: law.off as u32 + 1, ..asked };
        (made.point_count, made.points) = Default::default();
        for (upper, table) in law.tables().iter().enumerate() {
            made.point_count[upper] = table.points().len() as u32;
            for (place, point) in made.points[upper].iter_mut().zip(table.points()) {
                *place = [point.between_s, point.hammer_speed_m_per_s, point.delay_s, point.touch_counts];
            }
        }
        // SAFETY: `place` is the caller's memory for one struct, which nothing else uses during the call.
        unsafe { place.write(0, &made) };
        Ok(())
    })
}
