//! Events of a press while it is played, and contact points.

use std::ptr::null_mut;

use erard::events::EventDetector;
use erard::instrument::Instrument;
use erard::mechanism::Stepping;

use crate::action::ErardAction;
use crate::caller_struct::{CallerStruct, Place};
use crate::instrument::{ErardInstrument, given};
use crate::status::{ErardStatus, Fault, ended, tell, told};

/// Event detector: observes an action step by step and finds the events of one press. It belongs to the caller until
/// erard_event_detector_free.
pub struct ErardEventDetector {
    instrument: Instrument,
    detector: EventDetector,
}

/// Events of one press. Times are s on the action's clock; events that have not happened are NaN.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ErardEvents {
    /// sizeof(ErardEvents).
    pub struct_size: u32,
    /// 0.
    pub reserved: u32,
    /// The key front is a tenth of a millimetre below its rest.
    pub key_start_s: f64,
    /// The jack's toe touches the let-off button.
    pub toe_contact_s: f64,
    /// The last push on the knuckle before the impact ends. Without an impact: the last push before the hammer's
    /// highest point.
    pub let_off_s: f64,
    /// First impact of the hammer on the string.
    pub hammer_contact_s: f64,
    /// Total speed of the strike point at that impact, m/s.
    pub hammer_speed_m_per_s: f64,
    /// The key touches its front punching.
    pub key_bottom_s: f64,
    /// The hammer's tail touches the back check, after the impact.
    pub check_s: f64,
    /// Time from let-off to the impact, s.
    pub free_flight_s: f64,
    /// Time from the impact to the key's bottom, s; negative if the key reaches the bottom first.
    pub key_bottom_after_impact_s: f64,
}

impl Default for ErardEvents {
    /// Nothing has happened.
    fn default() -> Self {
        ErardEvents {
            struct_size: size_of::<Self>() as u32,
            reserved: 0,
            key_start_s: f64::NAN,
            toe_contact_s: f64::NAN,
            let_off_s: f64::NAN,
            hammer_contact_s: f64::NAN,
            hammer_speed_m_per_s: f64::NAN,
            key_bottom_s: f64::NAN,
            check_s: f64::NAN,
            free_flight_s: f64::NAN,
            key_bottom_after_impact_s: f64::NAN,
        }
    }
}

// SAFETY: a `repr(C)` struct of two u32 and nine f64: no padding, and every bit pattern is a value. `struct_size` is
// its first field.
unsafe impl CallerStruct for ErardEvents {
    const FIRST_BYTES: usize = 80;
}

/// Makes an event detector for one press on an action of this instrument. Returns NULL if the instrument is NULL. Real
/// time: no.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_event_detector_new(
    instrument: *const ErardInstrument,
    status: *mut ErardStatus,
) -> *mut ErardEventDetector {
    told(null_mut(), status, || {
        // SAFETY: `instrument` is NULL, or comes from this library, has not been freed, and no call changes it
        // meanwhile.
        let instrument = unsafe { given(instrument) }?.instrument();
        Ok(Box::into_raw(Box::new(ErardEventDetector {
            instrument: instrument.clone(),
            detector: EventDetector::new(instrument),
        })))
    })
}

/// Frees an event detector. NULL does nothing. Real time: no.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_event_detector_free(detector: *mut ErardEventDetector) {
    // SAFETY: `detector` is NULL, or comes from erard_event_detector_new, has not been freed, and is not used again.
    unsafe { ended(detector) }
}

/// Clears the events that were found, so that the next press can be observed. Real time: no.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_event_detector_reset(detector: *mut ErardEventDetector) -> ErardStatus {
    tell(|| {
        // SAFETY: `detector` is NULL, or comes from erard_event_detector_new, has not been freed, and no other call
        // uses it meanwhile.
        let own = unsafe { detector.as_mut() }.ok_or_else(|| Fault::null("the event detector"))?;
        own.detector = EventDetector::new(&own.instrument);
        Ok(())
    })
}

/// Observes the action once. Call it before the first step of a press and after every step. Returns
/// ERARD_STATUS_FOREIGN if the action does not match the detector's instrument. Real time: no.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_event_detector_observe(
    detector: *mut ErardEventDetector,
    action: *const ErardAction,
) -> ErardStatus {
    tell(|| {
        // SAFETY: `detector` is NULL, or comes from erard_event_detector_new, has not been freed, and no other call
        // uses it meanwhile.
        let own = unsafe { detector.as_mut() }.ok_or_else(|| Fault::null("the event detector"))?;
        // SAFETY: `action` is NULL, or comes from erard_action_new or erard_action_of_instrument, has not been freed,
        // and no other call changes it meanwhile.
        let action = unsafe { action.as_ref() }.ok_or_else(|| Fault::null("the action"))?;
        let played = &action.play.action;
        if played.angles().len() != own.instrument.bodies.len() || action.play.zones != own.instrument.zones.len() {
            return Err(Fault::new(ErardStatus::Foreign, "the event detector is another instrument's"));
        }
        own.detector.observe_action(played);
        Ok(())
    })
}

/// Writes the events found so far to `events`. Real time: no.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_event_detector_read(
    detector: *const ErardEventDetector,
    events: *mut ErardEvents,
) -> ErardStatus {
    tell(|| {
        // SAFETY: `detector` is NULL, or comes from erard_event_detector_new, has not been freed, and no other call
        // changes it meanwhile.
        let own = unsafe { detector.as_ref() }.ok_or_else(|| Fault::null("the event detector"))?;
        // SAFETY: `events` is NULL, or aligned and writable memory for one ErardEvents that begins with its size and
        // that nothing else uses during the call.
        let place = unsafe { Place::new(events) }
            .map_err(|status| Fault::new(status, "the events: set struct_size to sizeof(ErardEvents)"))?;
        let place = place.ok_or_else(|| Fault::null("the place for the events"))?;
        let seen = own.detector.so_far();
        let or_nan = |value: Option<f64>| value.unwrap_or(f64::NAN);
        let found = ErardEvents {
            key_start_s: or_nan(seen.key_start_s),
            toe_contact_s: or_nan(seen.toe_contact_s),
            let_off_s: or_nan(seen.let_off_s),
            hammer_contact_s: or_nan(seen.hammer_contact_s()),
            hammer_speed_m_per_s: or_nan(seen.hammer_speed_m_per_s()),
            key_bottom_s: or_nan(seen.key_bottom_s),
            check_s: or_nan(seen.check_s),
            free_flight_s: or_nan(seen.free_flight_s()),
            key_bottom_after_impact_s: or_nan(seen.key_bottom_after_impact_s()),
            ..ErardEvents::default()
        };
        // SAFETY: `place` is the caller's memory for one ErardEvents that nothing else uses during the call.
        unsafe { place.write(0, &found) };
        Ok(())
    })
}

/// Makes an action record where its zones touch, from the next step on, for erard_action_contacts. Recording costs a
/// few percent of a step and does not change the results by a bit. Real time: no.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_action_record_contacts(action: *mut ErardAction) -> ErardStatus {
    tell(|| {
        // SAFETY: `action` is NULL, or comes from erard_action_new or erard_action_of_instrument, has not been freed,
        // and no other call uses it meanwhile.
        let action = unsafe { action.as_mut() }.ok_or_else(|| Fault::null("the action"))?;
        let mechanism = action.play.action.mechanism_mut();
        mechanism.configure(Stepping { keeps_contacts: true, ..*mechanism.readout().stepping });
        Ok(())
    })
}

/// Writes the state of the contact zones in the last step to `numbers`, five for each zone: force, N; the contact
/// point, m in the world, x to the back and y up; the unit normal, in the direction in which the force pushes the disc.
/// They are 0 for zones that do not touch, and before erard_action_record_contacts. `count` is the room in `numbers`,
/// at least five times erard_action_zone_count, else the call returns ERARD_STATUS_SIZE. Real time: no.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_action_contacts(
    action: *const ErardAction,
    numbers: *mut f64,
    count: usize,
) -> ErardStatus {
    tell(|| {
        // SAFETY: `action` is NULL, or comes from erard_action_new or erard_action_of_instrument, has not been freed,
        // and no other call changes it meanwhile.
        let action = unsafe { action.as_ref() }.ok_or_else(|| Fault::null("the action"))?;
        let zones = action.play.zones;
        if numbers.is_null() {
            return Err(Fault::null("the place for the numbers"));
        }
        if count < 5 * zones {
            return Err(Fault::new(ErardStatus::Size, format!("{count} numbers for {zones} zones of five")));
        }
        // SAFETY: `numbers` is not NULL; it is aligned and has room for `count` numbers, no fewer than five for each of
        // `zones`, as checked above.
        let out = unsafe { core::slice::from_raw_parts_mut(numbers, 5 * zones) };
        out.fill(0.0);
        let contacts = action.play.action.mechanism().readout().contacts;
        for (place, contact) in out.chunks_exact_mut(5).zip(contacts) {
            if let Some(contact) = contact {
                let ([x, y], [nx, ny]) = (contact.point, contact.normal);
                place.copy_from_slice(&[contact.force, x, y, nx, ny]);
            }
        }
        Ok(())
    })
}

/// Returns 1 if the last step changed nothing, so that further steps under the same input change nothing either; else
/// 0, also for NULL. Real time: no.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_action_is_asleep(action: *const ErardAction) -> u32 {
    // SAFETY: `action` is NULL, or comes from erard_action_new or erard_action_of_instrument, has not been freed, and
    // no other call changes it meanwhile.
    u32::from(unsafe { action.as_ref() }.is_some_and(|action| action.play.action.is_asleep()))
}
