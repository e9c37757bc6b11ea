//! Whether steps are halved near strings that sound.

use erard::mechanism::Halving;

use crate::action::ErardAction;
use crate::keyboard::ErardKeyboard;
use crate::status::{ErardStatus, Fault, tell};

/// Steps are halved as often as the strings ask while a hammer is near them, as at first. Impacts are converged; the
/// step in which ten of them happen at once in the top octave takes fifteen times as long.
pub const ERARD_HALVE_AS_ASKED: u32 = 0;
/// All steps are whole: every one takes about the same time. Impacts on strings are then as accurate as the step is
/// short; at 1/24000 s the contact of the top octave lasts a sixth too long.
pub const ERARD_HALVE_NEVER: u32 = 1;

fn halving(kind: u32) -> Result<Halving, Fault> {
    match kind {
        ERARD_HALVE_AS_ASKED => Ok(Halving::AsAsked),
        ERARD_HALVE_NEVER => Ok(Halving::Never),
        _ => Err(Fault::new(
            ErardStatus::Argument,
            format!(
                "there is no way {kind} to halve steps; expected ERARD_HALVE_AS_ASKED (0) or ERARD_HALVE_NEVER (1)"
            ),
        )),
    }
}

/// Whether an action's steps are halved while its hammer is near strings that sound (ERARD_HALVE_AS_ASKED, as at first,
/// or ERARD_HALVE_NEVER), from the next step on. No saved state holds this: choose it again after making an action.
/// Without strings that sound it changes nothing. Real time: no (it may allocate); choose before the loop.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_halve(action: *mut ErardAction, kind: u32) -> ErardStatus {
    tell(|| {
        // SAFETY: the caller's promise: NULL, or an action.
        let action = unsafe { action.as_mut() }.ok_or_else(|| Fault::null("the action"))?;
        action.play.action.halve(halving(kind)?);
        Ok(())
    })
}

/// Chooses the halving of steps for all keys of a keyboard; wakes them. Real time: no.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_keyboard_halve(keyboard: *mut ErardKeyboard, kind: u32) -> ErardStatus {
    tell(|| {
        // SAFETY: the caller's promise: NULL, or a keyboard.
        let keyboard = unsafe { keyboard.as_mut() }.ok_or_else(|| Fault::null("the keyboard"))?;
        keyboard.keys.halve(halving(kind)?);
        Ok(())
    })
}
