//! A file's tracks, put together.

use std::collections::BTreeMap;
use std::format;
use std::string::{String, ToString};
use std::vec::Vec;

use midly::{Format, MetaMessage, MidiMessage, Smf, Timing, Track, TrackEventKind};

use super::{Note, PedalChange, Piece};
use crate::message::{HIGH_RESOLUTION, SOFT, SOSTENUTO, SUSTAIN};
use crate::{Velocity, key_of_note};

/// The largest file that is read, bytes.
const MAX_BYTES: usize = 16 << 20;
/// The channel of percussion, from 0.
const PERCUSSION: u8 = 9;

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
        }
    }
}

impl std::error::Error for ReadError {}

/// Reads a piece from the bytes of a Standard MIDI File of format 0 or 1. Memory and work are linear in the number of
/// bytes, except for sorting.
///
/// Leaves out, with a remark, events that a piano does not play: notes of the percussion channel, and notes outside the
/// keyboard. A key that one track or channel presses while another holds it is struck again, and held until the last of
/// them lets go. A note without a note-off is held to the file's last event.
///
/// # Errors
/// [`ReadError`].
pub fn read(bytes: &[u8]) -> Result<Piece, ReadError> {
    if bytes.len() > MAX_BYTES {
        return Err(ReadError::TooLong(bytes.len()));
    }
    let Smf { header, tracks } = Smf::parse(bytes).map_err(|error| ReadError::Syntax(error.to_string()))?;
    if header.format == Format::Sequential {
        return Err(ReadError::Sequences(tracks.len()));
    }
    let clock = Clock::of(header.timing, &tracks)?;
    let mut events = Vec::new();
    for (track, all) in tracks.iter().enumerate() {
        let mut tick = 0_u64;
        for event in all {
            tick += u64::from(event.delta.as_int());
            if let TrackEventKind::Midi { channel, message } = event.kind {
                events.push(Event { tick, track, channel: channel.as_int(), message });
            }
        }
    }
    // Within a tick the file's order counts, track by track.
    events.sort_by_key(|event| event.tick);
    let last = tracks.iter().map(|track| track.iter().map(|e| u64::from(e.delta.as_int())).sum()).max().unwrap_or(0);
    let mut reader = Reader::default();
    for event in &events {
        reader.take(event, clock.seconds(event.tick));
    }
    let mut piece = reader.finish(clock.seconds(last));
    let breaks_off = |track: &Track<'_>| {
        !matches!(track.last().map(|event| event.kind), Some(TrackEventKind::Meta(MetaMessage::EndOfTrack)))
    };
    for (i, _) in tracks.iter().enumerate().filter(|(_, track)| breaks_off(track)) {
        piece.remarks.push(format!("track {} breaks off; the rest of it was not read", i + 1));
    }
    Ok(piece)
}

/// What a channel plays, in the order of time.
struct Event {
    tick: u64,
    track: usize,
    channel: u8,
    message: MidiMessage,
}

/// Instants of ticks.
struct Clock {
    /// Tempo from a tick on: its instant, s, and the duration of a tick, s; the first entry is for tick 0.
    from: Vec<(u64, f64, f64)>,
}

impl Clock {
    fn of(timing: Timing, tracks: &[Track<'_>]) -> Result<Self, ReadError> {
        let per_quarter = match timing {
            Timing::Metrical(ticks) if ticks.as_int() > 0 => f64::from(ticks.as_int()),
            Timing::Timecode(frames, ticks) if ticks > 0 => {
                let tick_s = 1.0 / (f64::from(frames.as_f32()) * f64::from(ticks));
                return Ok(Clock { from: std::vec![(0, 0.0, tick_s)] });
            }
            _ => return Err(ReadError::NoTime),
        };
        let mut tempi = Vec::new();
        for track in tracks {
            let mut tick = 0_u64;
            for event in track {
                tick += u64::from(event.delta.as_int());
                if let TrackEventKind::Meta(MetaMessage::Tempo(quarter_us)) = event.kind {
                    tempi.push((tick, f64::from(quarter_us.as_int()) * 1e-6 / per_quarter));
                }
            }
        }
        tempi.sort_by_key(|(tick, _)| *tick);
        // 120 quarter notes a minute where nothing is said.
        let mut from: Vec<(u64, f64, f64)> = std::vec![(0, 0.0, 0.5 / per_quarter)];
        for (tick, tick_s) in tempi {
            let &(since, time_s, before_s) = from.last().unwrap_or(&(0, 0.0, tick_s));
            from.push((tick, time_s + (tick - since) as f64 * before_s, tick_s));
        }
        Ok(Clock { from })
    }

    fn seconds(&self, tick: u64) -> f64 {
        let at = self.from.partition_point(|(since, ..)| *since <= tick).saturating_sub(1);
        let (since, time_s, tick_s) = self.from[at];
        time_s + (tick - since) as f64 * tick_s
    }
}

/// The holder of a key: a track and a channel.
type Holder = (usize, u8);

/// What is known so far.
#[derive(Default)]
struct Reader {
    piece: Piece,
    /// Held keys: their note in the piece, and their holders.
    held: BTreeMap<usize, (usize, Vec<Holder>)>,
    /// The seven bits below the next note's velocity.
    below: BTreeMap<Holder, u8>,
    percussion: usize,
    beyond: usize,
}

impl Reader {
    fn take(&mut self, event: &Event, time_s: f64) {
        let holder = (event.track, event.channel);
        // Anything of the channel that comes between takes a controller 88 away from its note.
        let below = self.below.remove(&holder).unwrap_or(0);
        let velocity = |upper: u8| Velocity::of_fourteen_bits(u16::from(upper) << 7 | u16::from(below));
        match event.message {
            MidiMessage::Controller { controller, value } => {
                let (controller, value) = (controller.as_int(), value.as_int());
                if controller == HIGH_RESOLUTION {
                    self.below.insert(holder, value);
                } else if [SUSTAIN, SOSTENUTO, SOFT].contains(&controller) && event.channel != PERCUSSION {
                    self.piece.pedals.push(PedalChange { time_s, controller, value });
                }
            }
            MidiMessage::NoteOn { key, vel } if vel.as_int() > 0 => {
                if event.channel == PERCUSSION {
                    self.percussion += 1;
                } else if let Some(key) = key_of_note(key.as_int()) {
                    self.press(key, holder, time_s, velocity(vel.as_int()));
                } else {
                    self.beyond += 1;
                }
            }
            MidiMessage::NoteOn { key, .. } => self.let_go(key.as_int(), holder, time_s, None),
            MidiMessage::NoteOff { key, vel } => {
                let measured = !(below == 0 && [0, 64].contains(&vel.as_int()));
                self.let_go(key.as_int(), holder, time_s, measured.then(|| velocity(vel.as_int())));
            }
            _ => {}
        }
    }

    fn press(&mut self, key: usize, holder: Holder, time_s: f64, velocity: Velocity) {
        let notes = &mut self.piece.notes;
        let next = notes.len();
        let (note, holders) = self.held.entry(key).or_insert_with(|| (next, Vec::new()));
        if *note != next {
            // Struck again while it is held.
            notes[*note].end_s = time_s;
        }
        *note = next;
        if !holders.contains(&holder) {
            holders.push(holder);
        }
        notes.push(Note { key, start_s: time_s, end_s: f64::INFINITY, velocity, release: None });
    }

    fn let_go(&mut self, note: u8, holder: Holder, time_s: f64, release: Option<Velocity>) {
        let Some(key) = key_of_note(note) else { return };
        let Some((note, holders)) = self.held.get_mut(&key) else { return };
        holders.retain(|one| *one != holder);
        if holders.is_empty() {
            let note = &mut self.piece.notes[*note];
            (note.end_s, note.release) = (time_s, release);
            self.held.remove(&key);
        }
    }

    fn finish(self, end_s: f64) -> Piece {
        let Reader { mut piece, held, percussion, beyond, .. } = self;
        for (note, _) in held.values() {
            piece.notes[*note].end_s = end_s;
        }
        let say = |count: usize, what: &str| {
            (count > 0).then(|| format!("{count} {}{what}", if count == 1 { "note" } else { "notes" }))
        };
        piece.remarks.extend(say(percussion, " of the percussion channel, 10, left out"));
        piece.remarks.extend(say(beyond, " beyond the keyboard, A0 to C8, left out"));
        piece.remarks.extend(say(held.len(), " without an end: held until the file's last event"));
        // Two keys of one instant: the lower one first. What is of no duration cannot be played.
        let empty = piece.notes.iter().filter(|note| note.end_s <= note.start_s).count();
        piece.notes.retain(|note| note.end_s > note.start_s);
        piece.remarks.extend(say(empty, " that end as they begin, left out"));
        piece.notes.sort_by(|a, b| a.start_s.total_cmp(&b.start_s).then(a.key.cmp(&b.key)));
        piece
    }
}
