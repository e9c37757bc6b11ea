//! Halving of steps near modal strings.

use erard::mechanism::Halving;

use crate::action::ErardAction;
use crate::keyboard::ErardKeyboard;
use crate::status::{ErardStatus, Fault, tell};

/// Steps are halved as often as the strings need while a hammer is near them; the default. Impacts are converged. The
/// step in which ten impacts coincide in the top octave takes eight times as long.
pub const ERARD_HALVING_AUTO: u32 = 0;
/// Steps are never halved, so all take about the same time. The accuracy of impacts then depends on the step length: at
/// 1/24000 s the contact of the top octave lasts a sixth too long.
pub const ERARD_HALVING_NEVER: u32 = 1;
/// Steps are halved two times less often than the strings need: the worst step takes a third of the time, for loops
/// that play sound. Impacts are right to half a per cent, partials within 40 dB of the strongest to a decibel.
pub const ERARD_HALVING_FEWER: u32 = 2;

/// How many times less often.
const FEWER: u32 = 2;

fn halving(kind: u32) -> Result<Halving, Fault> {
    match kind {
        ERARD_HALVING_AUTO => Ok(Halving::Auto),
        ERARD_HALVING_NEVER => Ok(Halving::Never),
        ERARD_HALVING_FEWER => Ok(Halving::Fewer(FEWER)),
        _ => Err(Fault::new(
            ErardStatus::Argument,
            format!(
                "there is no way {kind} to halve steps; expected ERARD_HALVING_AUTO (0), ERARD_HALVING_NEVER (1) or \
                 ERARD_HALVING_FEWER (2)"
            ),
        )),
    }
}

/// Chooses how often an action's steps are halved while its hammer is near modal strings, from the next step on:
/// ERARD_HALVING_AUTO (the default), ERARD_HALVING_FEWER or ERARD_HALVING_NEVER, else the call returns
/// ERARD_STATUS_ARGUMENT. Saved states do not contain this choice: set it again after making an action. Without modal
/// strings it changes nothing. Real time: no (it may allocate); call it before the loop.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_action_set_halving(action: *mut ErardAction, kind: u32) -> ErardStatus {
    tell(|| {
        // SAFETY: `action` is NULL, or comes from erard_action_new or erard_action_of_instrument, has not been freed,
        // and no other call uses it meanwhile.
        let action = unsafe { action.as_mut() }.ok_or_else(|| Fault::null("the action"))?;
        action.play.action.halve(halving(kind)?);
        Ok(())
    })
}

/// Chooses the halving of steps for all keys of a keyboard, as erard_action_set_halving does. Keys that are played wake
/// all others; at rest all sleep on. Real time: no.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_keyboard_set_halving(keyboard: *mut ErardKeyboard, kind: u32) -> ErardStatus {
    tell(|| {
        // SAFETY: `keyboard` is NULL, or comes from erard_keyboard_new or erard_keyboard_builtin, has not been freed,
        // and no other call uses it meanwhile.
        let keyboard = unsafe { keyboard.as_mut() }.ok_or_else(|| Fault::null("the keyboard"))?;
        keyboard.halve(halving(kind)?);
        Ok(())
    })
}
