//! Boards of keys with two or three contacts: edges to bytes of MIDI. Nothing is simulated while they play: the hammer
//! speeds are a table. This file is compiled for chips, too (`bindings/firmware`).

use core::ffi::c_void;
use core::ptr::null_mut;

use erard_live::contacts::{ContactFault, ContactKey, ContactLaw, MAX_CONTACTS, MAX_POINTS, Point, SpeedTable};
use erard_live::sensing::Voice;
use erard_midi::note_of_key;

use crate::board::{ErardBoard, ErardBoardKey, ErardBoardSetup, Keys, List, Send, Sensed, begin, of_u64, refused};
use crate::caller_struct::{CallerStruct, given};
use crate::outcome::ErardStatus;
use crate::status::{Fault, told};

/// Most contacts of a key.
pub const ERARD_MAX_CONTACTS: usize = 3;
/// Most points of a table of contacts.
pub const ERARD_MAX_CONTACT_POINTS: usize = 24;

const _: () = assert!(ERARD_MAX_CONTACTS == MAX_CONTACTS && ERARD_MAX_CONTACT_POINTS == MAX_POINTS);

/// The contacts of all keys of a board, and the hammer speeds by the time between them. It may be a constant.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ErardContacts {
    /// sizeof(ErardContacts).
    pub struct_size: u32,
    /// Number of contacts of a key, 2 or 3.
    pub count: u32,
    /// The contact whose opening ends a note, from 1 for the upper one; never the lowest one.
    pub off: u32,
    /// Points of each table, 2 to 24: of the time from contact 1 to the lowest one, and of three contacts from contact
    /// 2.
    pub point_count: [u32; 2],
    /// 0.
    pub reserved: u32,
    /// Depths of the key's front at which the contacts close, m, rising, 0.1 mm to 20 mm.
    pub depths_m: [f64; ERARD_MAX_CONTACTS],
    /// Period of the scan, s; 0 for edges that interrupts report.
    pub scan_period_s: f64,
    /// How long after its time stamp each contact is read, s, within the period.
    pub scan_phases_s: [f64; ERARD_MAX_CONTACTS],
    /// Changes of a contact within this time after an edge are bounces of it, s, 0 to 0.1.
    pub bounce_s: f64,
    /// The tables, a point each: time to the lowest contact, s, rising; hammer speed, m/s, falling, at most 8; time
    /// from the lowest contact to the impact, s; error of touch, counts of velocity. The last two may be 0.
    pub points: [[[f64; 4]; ERARD_MAX_CONTACT_POINTS]; 2],
}

impl Default for ErardContacts {
    /// No contacts.
    fn default() -> Self {
        Self::zeroed()
    }
}

// SAFETY: a `repr(C)` struct of six u32 and 200 f64: no padding, and every bit pattern is a value. `struct_size` is its
// first field.
unsafe impl CallerStruct for ErardContacts {
    const FIRST_BYTES: usize = 1624;
}

impl ErardContacts {
    /// Checks everything but the tables and the contact that ends notes. Returns the number of contacts.
    pub(crate) fn check(&self) -> Result<usize, Fault> {
        let count = self.count as usize;
        if !(2..=MAX_CONTACTS).contains(&count) {
            return Err(refused(ErardStatus::Argument, "count; expected 2 or 3 contacts"));
        }
        let (depths_m, phases_s) = (&self.depths_m[..count], &self.scan_phases_s[..count]);
        let times = [self.scan_period_s, self.bounce_s];
        if !times.iter().chain(depths_m).chain(phases_s).all(|number| number.is_finite()) {
            return Err(refused(ErardStatus::NotFinite, "a depth or a time of the contacts"));
        }
        let checked = ContactLaw::check_contacts(depths_m, phases_s, self.scan_period_s, self.bounce_s);
        checked.map_err(|fault| fault_of(&fault)).map(|()| count)
    }

    /// The law.
    fn law(&self) -> Result<ContactLaw, Fault> {
        let count = self.check()?;
        let first = self.table(0)?;
        let law = ContactLaw {
            depths_m: self.depths_m,
            count,
            tables: [first, if count > 2 { self.table(1)? } else { first }],
            period_s: self.scan_period_s,
            phases_s: self.scan_phases_s,
            bounce_s: self.bounce_s,
            off: (self.off as usize).wrapping_sub(1),
        };
        law.check().map_err(|fault| fault_of(&fault))?;
        Ok(law)
    }

    /// The table from a contact, from 0, to the lowest one.
    fn table(&self, upper: usize) -> Result<SpeedTable, Fault> {
        let count = self.point_count[upper] as usize;
        let Some(given) = self.points[upper].get(..count) else { return Err(fault_of(&ContactFault::Points(count))) };
        if !given.iter().flatten().all(|number| number.is_finite()) {
            return Err(refused(ErardStatus::NotFinite, "a point of the contacts' tables"));
        }
        let mut points = [Point::default(); MAX_POINTS];
        for (point, [between_s, hammer_speed_m_per_s, delay_s, touch_counts]) in points.iter_mut().zip(given) {
            *point = Point {
                between_s: *between_s,
                hammer_speed_m_per_s: *hammer_speed_m_per_s,
                delay_s: *delay_s,
                touch_counts: *touch_counts,
            };
        }
        SpeedTable::new(&points[..count]).map_err(|fault| fault_of(&fault))
    }
}

pub(crate) fn fault_of(fault: &ContactFault) -> Fault {
    let status = match fault {
        ContactFault::Depth(_) | ContactFault::Time(_) | ContactFault::Point(_) => ErardStatus::Range,
        _ => ErardStatus::Argument,
    };
    Fault::of(status, fault)
}

/// What all keys of a board share: the law, and the lowest key, from 1.
pub(crate) struct SharedContacts {
    law: ContactLaw,
    first_key: usize,
}

/// The keys of a board of contacts.
pub(crate) type ContactKeys = List<SharedContacts, ContactKey>;

impl Keys for ContactKeys {
    fn sensed(&self) -> Sensed {
        Sensed::Contacts(self.shared.law.count)
    }

    fn edge(&mut self, time_s: f64, edge: Option<(usize, usize, bool)>, voice: &Voice<'_>, send: Send<'_>) {
        let (SharedContacts { law, first_key }, keys) = self.parts();
        for (index, key) in keys.iter_mut().enumerate() {
            let Some(key) = key else { continue };
            let note = note_of_key(*first_key + index).unwrap_or(0);
            key.until(law, time_s, &mut |event| send(voice.message(note, event)));
        }
        if let Some((index, contact, is_made)) = edge
            && let Some(Some(key)) = keys.get_mut(index)
        {
            let note = note_of_key(*first_key + index).unwrap_or(0);
            key.take(law, (contact, time_s, is_made), &mut |event| send(voice.message(note, event)));
        }
    }

    fn let_go(&mut self, time_s: f64, voice: &Voice<'_>, send: Send<'_>) {
        let (SharedContacts { first_key, .. }, keys) = self.parts();
        for (index, key) in keys.iter_mut().enumerate() {
            let Some(key) = key else { continue };
            let note = note_of_key(*first_key + index).unwrap_or(0);
            key.let_go(time_s, &mut |event| send(voice.message(note, event)));
        }
    }

    fn reset(&mut self) -> bool {
        self.parts().1.iter_mut().flatten().for_each(|key| *key = ContactKey::new());
        true
    }

    fn read(&self, index: usize) -> Option<ErardBoardKey> {
        let own = self.key(index)?;
        Some(ErardBoardKey {
            asleep: u32::from(own.is_up()),
            bounces: of_u64(own.counts.bounces),
            untimed_strokes: of_u64(own.counts.untimed),
            slow_strokes: of_u64(own.counts.slow),
            swapped_contacts: of_u64(own.counts.swapped),
            fast_strokes: of_u64(own.counts.fast),
            ..ErardBoardKey::default()
        })
    }
}

/// Returns the number of bytes that a board of so many keys with contacts takes; 0 for no key or more than 88. Real
/// time: yes.
#[unsafe(no_mangle)]
pub extern "C" fn erard_board_contacts_bytes(key_count: u32) -> usize {
    ContactKeys::bytes(key_count)
}

/// Makes a board of keys with contacts in `memory` of `bytes` bytes (erard_board_contacts_bytes,
/// erard_board_alignment), which stays the caller's and must not move. Of the setup it takes the keys, the channel and
/// the laws of velocities; all else must be 0. `contacts` is read during the call. Nothing is simulated: the tables are
/// those of `contacts`. Returns the board, or NULL on failure: `status` (which may be NULL) receives the reason, and
/// erard_last_error describes it. Real time: no, but nothing is allocated.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_board_contacts_new(
    memory: *mut c_void,
    bytes: usize,
    setup: *const ErardBoardSetup,
    contacts: *const ErardContacts,
    status: *mut ErardStatus,
) -> *mut ErardBoard {
    told(null_mut(), status, || {
        // SAFETY: `setup` is NULL, or an initialised ErardBoardSetup of the size that it states.
        let setup = unsafe { given(setup) }.map_err(|status| refused(status, "the setup"))?;
        let (voice, keys) = (setup.voice()?, setup.keys()?);
        ErardBoardSetup::unused(&[
            (setup.kind == 0, "kind; expected 0 for contacts"),
            (setup.sensor_law == 0, "sensor_law; expected 0 for contacts"),
            (setup.nearest_at_rest == 0, "nearest_at_rest; expected 0 for contacts"),
            (setup.step_s == 0.0, "step_s; expected 0 for contacts"),
            (setup.travel_m == 0.0, "travel_m; expected 0 for contacts"),
            (setup.sensor_at_m == 0.0, "sensor_at_m; expected 0 for contacts"),
            (setup.nearest_m == 0.0, "nearest_m; expected 0 for contacts"),
            (setup.still == 0.0, "still; expected 0 for contacts"),
        ])?;
        // SAFETY: `contacts` is NULL, or an initialised ErardContacts of the size that it states.
        let contacts = unsafe { given(contacts) }.map_err(|status| refused(status, "the contacts"))?;
        let shared = SharedContacts { law: contacts.law()?, first_key: *keys.start() };
        let make = |place: *mut Option<ContactKey>| {
            for index in 0..keys.count() {
                // SAFETY: `place` is aligned memory with room for the keys of the setup, one of which is this.
                unsafe { place.add(index).write(Some(ContactKey::new())) };
            }
            Ok(shared)
        };
        // SAFETY: `memory` is NULL, or writable memory of `bytes` bytes that stays the board's; `make` writes all keys.
        unsafe { begin((memory, bytes), (&setup, voice), make) }
    })
}

/// Takes an edge of a contact at an instant, s on the scanner's clock: `key` counts from 1, the lowest A of a piano,
/// `contact` from 1, the upper one; `is_made` is 1 as it closes, 0 as it opens. Bounces may be given, too. Writes the
/// resulting MIDI bytes, whole messages, to `midi`, which must have room for ERARD_BOARD_KEY_BYTES for each key, and
/// their number to `length`. A note-on is written as the lowest contact closes, before the hammer meets its string.
/// Returns ERARD_STATUS_NO_SUCH for a key or contact that the board does not have, ERARD_STATUS_RANGE for an instant
/// before the last one, and ERARD_STATUS_ARGUMENT for a board without contacts. Real time: yes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_board_edge(
    board: *mut ErardBoard,
    time_s: f64,
    key: u32,
    contact: u32,
    is_made: u32,
    midi: *mut u8,
    room: usize,
    length: *mut usize,
) -> ErardStatus {
    // SAFETY: `board` is NULL, or was made by this library, has not been freed, and no other call uses it meanwhile.
    let Some(board) = (unsafe { board.as_mut() }) else { return ErardStatus::Null };
    let Sensed::Contacts(count) = board.sensed() else { return ErardStatus::Argument };
    let contact = (contact as usize).checked_sub(1).filter(|contact| *contact < count);
    let (Some(index), Some(contact)) = (board.index(key), contact) else { return ErardStatus::NoSuch };
    if is_made > 1 {
        return ErardStatus::Argument;
    }
    // SAFETY: `midi` is NULL, or writable memory for `room` bytes; `length` is NULL, or writable memory for a size.
    unsafe { take(board, time_s, Some((index, contact, is_made == 1)), (midi, room, length)) }
}

/// Goes on to an instant, s on the scanner's clock, at which no contact has changed: one that stayed changed after its
/// bounces has changed. Call it in every scan without an edge; the next edge of any key does the same. Writes to `midi`
/// and `length` as erard_board_edge does, and returns what that returns. Real time: yes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_board_until(
    board: *mut ErardBoard,
    time_s: f64,
    midi: *mut u8,
    room: usize,
    length: *mut usize,
) -> ErardStatus {
    // SAFETY: `board` is NULL, or was made by this library, has not been freed, and no other call uses it meanwhile.
    let Some(board) = (unsafe { board.as_mut() }) else { return ErardStatus::Null };
    let Sensed::Contacts(_) = board.sensed() else { return ErardStatus::Argument };
    // SAFETY: `midi` is NULL, or writable memory for `room` bytes; `length` is NULL, or writable memory for a size.
    unsafe { take(board, time_s, None, (midi, room, length)) }
}

/// Goes on to an instant, s on the scanner's clock, and takes the edge of a key's contact, both from 0.
///
/// # Safety
/// `midi` is NULL, or writable memory for `room` bytes; `length` is NULL, or writable memory for a size.
unsafe fn take(
    board: &mut ErardBoard,
    time_s: f64,
    edge: Option<(usize, usize, bool)>,
    (midi, room, length): (*mut u8, usize, *mut usize),
) -> ErardStatus {
    if !time_s.is_finite() {
        return ErardStatus::NotFinite;
    }
    let needed = board.room();
    let play = |board: &mut ErardBoard, out: &mut crate::board::Out| {
        let Some(own_s) = board.clock.take_edge(time_s) else { return ErardStatus::Range };
        let (keys, voice) = board.parts();
        keys.edge(own_s, edge, voice, &mut |message| out.put(&message));
        ErardStatus::Ok
    };
    // SAFETY: `midi` is NULL, or writable memory for `room` bytes; `length` is NULL, or writable memory for a size.
    unsafe { board.play((midi, room, length), needed, play) }
}
