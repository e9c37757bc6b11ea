//! A file's tracks, put together.

use std::collections::BTreeMap;
use std::format;
use std::string::String;
use std::vec::Vec;

use super::chunks::{Event, HeadFault, Message, Timing, Tracks, tracks};
use super::pairing::{Hold, Touch, holds, strikes};
use super::remarks::{Loss, Remarks, Skipped};
use super::{Note, PedalChange, Piece};
use crate::message::{ALL_NOTES_OFF, ALL_SOUND_OFF, HIGH_RESOLUTION, RESET_CONTROLLERS, SOFT, SOSTENUTO, SUSTAIN};
use crate::{Velocity, key_of_note};

/// The largest file that is read, bytes.
const MAX_BYTES: usize = 16 << 20;
/// The channel of percussion, from 0.
const PERCUSSION: u8 = 9;
/// Pedals, by their controllers.
const PEDALS: [u8; 3] = [SUSTAIN, SOSTENUTO, SOFT];

/// Why a file is not read.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum ReadError {
    /// The file is not a Standard MIDI File, or is damaged; with the reason.
    Syntax(String),
    /// The file is longer than 16 MiB; with its length, bytes.
    TooLong(usize),
    /// Its tracks are separate pieces (format 2); with their number.
    Sequences(usize),
    /// Its header gives no time: zero ticks for a quarter note or a frame.
    NoTime,
    /// It is a clip file of MIDI 2.0.
    Clip,
}

impl std::fmt::Display for ReadError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            ReadError::Syntax(what) => write!(f, "not a readable Standard MIDI File: {what}"),
            ReadError::TooLong(bytes) => write!(f, "{bytes} bytes; at most {MAX_BYTES} are read"),
            ReadError::Sequences(count) => {
                write!(f, "a file of format 2, {count} independent pieces; expected format 0 or 1")
            }
            ReadError::NoTime => f.write_str("the header gives a quarter note or a frame 0 ticks; expected at least 1"),
            ReadError::Clip => {
                f.write_str("a MIDI 2.0 clip file; expected a Standard MIDI File: export it as MIDI 1.0")
            }
        }
    }
}

impl std::error::Error for ReadError {}

impl From<HeadFault> for ReadError {
    fn from(fault: HeadFault) -> Self {
        ReadError::Syntax(match fault {
            HeadFault::Clip => return ReadError::Clip,
            HeadFault::NoTime => return ReadError::NoTime,
            HeadFault::NoHead => "it does not begin with `MThd`".into(),
            HeadFault::Short => "its header is cut off; expected 6 bytes or more".into(),
            HeadFault::Format(format) => format!("format {format}; expected 0 or 1"),
            HeadFault::Frames(frames) => format!("{frames} frames a second; expected 24, 25, 29 or 30"),
        })
    }
}

/// Reads a piece from the bytes of a Standard MIDI File of format 0 or 1, or of format 2 with one track. Memory and
/// work are linear in the number of bytes, except for sorting.
///
/// Notes of all channels but that of percussion, 10, are played on one keyboard:
/// - Strikes of a key in one tick are one strike, as loud as the loudest, held to the last of their note-offs.
/// - A key that is struck while it is held ends one note and begins the next, which lasts until all have let go:
///   note-ons are counted against note-offs, by channel. A note-off ends what began before its tick; where nothing did,
///   a note that began in its tick is left out. A note-on for which no note-off is left is held until the key's next
///   note, or the file's last event.
/// - A channel's controllers 123 to 127 (all notes off) let its keys up; 121 lets its pedals up; 120 (all sound off)
///   lets up its keys and the two pedals that hold dampers, until the pedal's next message.
/// - Each of the three pedals is where the channel is that presses it farthest.
/// - A controller 88 belongs to the note right after it in its track and channel: whatever message of the channel
///   stands between takes it away [CA-031 leaves that open].
///
/// Events of known length are skipped by it, whatever they hold; a system exclusive message without its length ends
/// where it says so, if only that makes sense. Where bytes are no event, reading goes on at the next that makes sense.
/// [`Piece::remarks`] says what was left out, merged or lost.
///
/// # Errors
/// [`ReadError`].
pub fn read(bytes: &[u8]) -> Result<Piece, ReadError> {
    if bytes.len() > MAX_BYTES {
        return Err(ReadError::TooLong(bytes.len()));
    }
    let mut all = tracks(bytes)?;
    if all.format == 2 && all.accounts.len() > 1 {
        return Err(ReadError::Sequences(all.accounts.len()));
    }
    let clock = Clock::of(&all);
    let mut remarks = losses(&all, &clock);
    let last_s = clock.seconds(all.accounts.iter().map(|own| own.last_tick).max().unwrap_or(0));
    let mut events = std::mem::take(&mut all.events);
    // Within a tick the file's order counts, track by track.
    events.sort_by_key(|event| event.tick);
    let pedals = pedals(&events, &clock, &mut remarks);
    let notes = notes(&touches(events, &clock, &mut remarks), &clock, last_s, &mut remarks);
    Ok(Piece { notes, pedals, remarks })
}

/// Instants of ticks.
struct Clock {
    /// Tempo from a tick on: its instant, s, and the duration of a tick, s; the first entry is for tick 0.
    from: Vec<(u64, f64, f64)>,
}

impl Clock {
    fn of(all: &Tracks) -> Self {
        let per_quarter = match all.timing {
            Timing::Quarter(ticks) => f64::from(ticks),
            Timing::Fixed(tick_s) => return Clock { from: std::vec![(0, 0.0, tick_s)] },
        };
        let tick_s = |quarter_us: u32| f64::from(quarter_us) * 1e-6 / per_quarter;
        let mut tempi: Vec<(u64, f64)> = all.tempi.iter().map(|(tick, us)| (*tick, tick_s(*us))).collect();
        tempi.sort_by_key(|(tick, _)| *tick);
        // 120 quarter notes a minute where nothing is said.
        let mut from: Vec<(u64, f64, f64)> = std::vec![(0, 0.0, 0.5 / per_quarter)];
        for (tick, tick_s) in tempi {
            let &(since, time_s, before_s) = from.last().unwrap_or(&(0, 0.0, tick_s));
            from.push((tick, time_s + (tick - since) as f64 * before_s, tick_s));
        }
        Clock { from }
    }

    fn seconds(&self, tick: u64) -> f64 {
        let at = self.from.partition_point(|(since, ..)| *since <= tick).saturating_sub(1);
        let (since, time_s, tick_s) = self.from[at];
        time_s + (tick - since) as f64 * tick_s
    }
}

/// What is lost of the tracks.
fn losses(all: &Tracks, clock: &Clock) -> Remarks {
    let loss = |(i, own): (usize, &super::chunks::Account)| {
        let skipped = own.skipped.iter().map(|one| Skipped {
            time_s: clock.seconds(one.tick),
            at: one.at,
            count: one.count,
            notes: one.notes,
            untimed: one.untimed,
        });
        let breaks_off_s = own.breaks_off.then(|| clock.seconds(own.last_tick));
        Loss { track: i + 1, read: own.notes, skipped: skipped.collect(), breaks_off_s }
    };
    let is_whole = |loss: &Loss| loss.skipped.is_empty() && loss.breaks_off_s.is_none();
    let found = all.accounts.len();
    Remarks {
        tracks: all.accounts.iter().enumerate().map(loss).filter(|loss| !is_whole(loss)).collect(),
        missing: (all.announced != found).then_some([all.announced, found]),
        no_tempo_s: all.accounts.iter().flat_map(|own| &own.no_tempi).map(|tick| clock.seconds(*tick)).collect(),
        ..Remarks::default()
    }
}

/// Motions of the pedals.
fn pedals(events: &[Event], clock: &Clock, remarks: &mut Remarks) -> Vec<PedalChange> {
    let mut changes = Vec::new();
    // By pedal: values of the channels, and where the pedal is.
    let mut values = [([0_u8; 16], None); PEDALS.len()];
    for event in events.iter().filter(|event| event.channel != PERCUSSION) {
        let Message::Controller(controller, value) = event.message else { continue };
        let (moved, value) = match controller {
            ALL_SOUND_OFF => (&PEDALS[..2], 0),
            RESET_CONTROLLERS => (&PEDALS[..], 0),
            _ => match PEDALS.iter().position(|pedal| *pedal == controller) {
                Some(pedal) => (&PEDALS[pedal..=pedal], value),
                None => continue,
            },
        };
        let time_s = clock.seconds(event.tick);
        for (controller, (channels, now)) in PEDALS.iter().zip(&mut values) {
            if !moved.contains(controller) {
                continue;
            }
            channels[usize::from(event.channel)] = value;
            let lowest = channels.iter().copied().max().unwrap_or(0);
            // A pedal that no message has moved is up.
            let is_message = moved.len() == 1;
            if *now != Some(lowest) && (is_message || now.is_some()) {
                *now = Some(lowest);
                changes.push(PedalChange { time_s, controller: *controller, value: lowest });
            }
            if is_message {
                remarks.pedals.entry(event.channel).or_insert(time_s);
            }
        }
    }
    changes
}

/// What each channel does to each key, from the lowest key, in the order of time.
type Touches = BTreeMap<(usize, u8), Vec<(u64, Touch)>>;

fn touches(events: Vec<Event>, clock: &Clock, remarks: &mut Remarks) -> Touches {
    let mut touches = Touches::new();
    let mut programs = [None; 16];
    // The seven bits below the next note's velocity.
    let mut below: BTreeMap<(u16, u8), u8> = BTreeMap::new();
    for Event { tick, track, channel, message } in events {
        let low = below.remove(&(track, channel)).unwrap_or(0);
        let velocity = |upper: u8| u16::from(upper) << 7 | u16::from(low);
        match message {
            Message::Controller(HIGH_RESOLUTION, value) => {
                below.insert((track, channel), value);
            }
            Message::Controller(ALL_SOUND_OFF | ALL_NOTES_OFF..=127, _) => {
                for (_, all) in touches.iter_mut().filter(|((_, own), _)| *own == channel) {
                    if !matches!(all.last(), Some((_, Touch::AllOff))) {
                        all.push((tick, Touch::AllOff));
                    }
                }
            }
            Message::Program(program) => programs[usize::from(channel)] = Some(program),
            Message::On(..) if channel == PERCUSSION => remarks.percussion_s.push(clock.seconds(tick)),
            Message::On(note, upper) => match key_of_note(note) {
                Some(key) => {
                    touches.entry((key, channel)).or_default().push((tick, Touch::On(velocity(upper))));
                    let program = programs[usize::from(channel)];
                    remarks.played.entry((channel, program)).or_default().push(clock.seconds(tick));
                }
                None => remarks.beyond_s.push(clock.seconds(tick)),
            },
            Message::Off(note, upper) => {
                let own = key_of_note(note).and_then(|key| touches.get_mut(&(key, channel)));
                // Senders that measure no release send 0 or 64.
                let upper = upper.filter(|upper| !(low == 0 && [0, 64].contains(upper)));
                own.into_iter().for_each(|all| all.push((tick, Touch::Off(upper.map(velocity)))));
            }
            Message::Controller(..) | Message::Other => {}
        }
    }
    touches
}

/// The notes in the order of their beginnings, then of their keys.
fn notes(touches: &Touches, clock: &Clock, last_s: f64, remarks: &mut Remarks) -> Vec<Note> {
    let mut by_key: BTreeMap<usize, Vec<Hold>> = BTreeMap::new();
    for ((key, _), own) in touches {
        let (held, empty) = holds(own);
        remarks.empty_s.extend(empty.into_iter().map(|tick| clock.seconds(tick)));
        by_key.entry(*key).or_default().extend(held);
    }
    let mut notes = Vec::new();
    for (key, own) in by_key {
        for strike in strikes(own) {
            let start_s = clock.seconds(strike.on);
            let end_s = strike.off.map_or(last_s, |(tick, _)| clock.seconds(tick));
            remarks.merged_s.extend(std::iter::repeat_n(start_s, strike.count - 1));
            if strike.is_endless {
                remarks.endless_s.push(start_s);
            }
            // One that begins with the file's last event.
            if end_s <= start_s {
                remarks.empty_s.push(start_s);
                continue;
            }
            let velocity = Velocity::of_fourteen_bits(strike.velocity);
            let release = strike.off.and_then(|(_, release)| release).map(Velocity::of_fourteen_bits);
            notes.push(Note { key, start_s, end_s, velocity, release });
        }
    }
    // Two keys of one instant: the lower one first.
    notes.sort_by(|a, b| a.start_s.total_cmp(&b.start_s).then(a.key.cmp(&b.key)));
    notes
}
