//! The bytes of a Standard MIDI File as the events of its tracks. Lengths and statuses are claims: where they are
//! wrong, reading goes on at the next place that makes sense, and the loss is counted.

use std::vec::Vec;

/// Number of events that a place must begin with to be where a damaged track goes on.
const SENSE: usize = 8;
/// Number of events by which such places are compared.
const COMPARED: usize = 32;

/// Duration of a tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Timing {
    /// So many ticks for a quarter note, whose duration tempi give.
    Quarter(u16),
    /// s.
    Fixed(f64),
}

/// A message of a channel that matters to a piano.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Message {
    /// Note number and velocity, which is not 0.
    On(u8, u8),
    /// Note number and velocity; `None` for a note-on of velocity 0.
    Off(u8, Option<u8>),
    /// Controller and value.
    Controller(u8, u8),
    /// From 0.
    Program(u8),
    /// Another message.
    Other,
}

/// What a channel plays.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Event {
    pub tick: u64,
    pub track: u16,
    pub channel: u8,
    pub message: Message,
}

/// Bytes of a track that are no events.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Skipped {
    /// Instant of the last event before them.
    pub tick: u64,
    /// Place in the file, from 0, and number.
    pub at: usize,
    pub count: usize,
    /// Notes that seem to begin in them.
    pub notes: usize,
    /// Whether delays of events may be among them, so that what follows is early.
    pub untimed: bool,
}

/// What a track holds besides its events.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(super) struct Account {
    /// Note-ons that were read.
    pub notes: usize,
    pub skipped: Vec<Skipped>,
    /// Whether it has no end.
    pub breaks_off: bool,
    /// Instant of its last event.
    pub last_tick: u64,
    /// Instants of tempi of 0.
    pub no_tempi: Vec<u64>,
}

/// A file.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Tracks {
    pub format: u16,
    pub timing: Timing,
    /// Track by track.
    pub events: Vec<Event>,
    /// Instants and durations of a quarter note, us, track by track.
    pub tempi: Vec<(u64, u32)>,
    pub accounts: Vec<Account>,
    /// Number of tracks that the header announces.
    pub announced: usize,
}

/// Why there are no tracks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum HeadFault {
    /// It does not begin like a file of this kind.
    NoHead,
    /// A MIDI 2.0 clip.
    Clip,
    /// The header is cut off or too short.
    Short,
    /// Its format is not 0, 1 or 2.
    Format(u16),
    /// It has so many frames a second; expected 24, 25, 29 or 30.
    Frames(u8),
    /// A quarter note or a frame has no ticks.
    NoTime,
}

/// Reads a file. Work and memory are linear in its length.
pub(super) fn tracks(bytes: &[u8]) -> Result<Tracks, HeadFault> {
    let start = head(bytes)?;
    let u16_at = |at: usize| bytes.get(at..at + 2).map(|two| u16::from_be_bytes([two[0], two[1]]));
    let u32_at = |at: usize| bytes.get(at..at + 4).map(|four| u32::from_be_bytes([four[0], four[1], four[2], four[3]]));
    let (Some(length), Some(format), Some(announced), Some(division)) =
        (u32_at(start + 4), u16_at(start + 8), u16_at(start + 10), u16_at(start + 12))
    else {
        return Err(HeadFault::Short);
    };
    let first = start + 8 + length as usize;
    if length < 6 || first > bytes.len() {
        return Err(HeadFault::Short);
    }
    if format > 2 {
        return Err(HeadFault::Format(format));
    }
    let mut all = Tracks {
        format,
        timing: timing(division)?,
        events: Vec::new(),
        tempi: Vec::new(),
        accounts: Vec::new(),
        announced: usize::from(announced),
    };
    let mut at = first;
    while let Some(length) = u32_at(at + 4) {
        let body = at + 8;
        if !is_chunk(bytes, at) {
            let Some(next) = track_from(bytes, at + 1) else { break };
            at = next;
            continue;
        }
        let mut end = body.saturating_add(length as usize).min(bytes.len());
        if &bytes[at..at + 4] != b"MTrk" {
            at = end;
            continue;
        }
        // Where nothing begins behind a track, its length is wrong: it goes on to the next one.
        if end < bytes.len() && !is_chunk(bytes, end) {
            end = track_from(bytes, body).unwrap_or(bytes.len());
        }
        let number = all.accounts.len().min(usize::from(u16::MAX)) as u16;
        let mut track = Track { bytes: &bytes[..end], all: &mut all, number, own: Account::default() };
        let read_to = track.read(body);
        let own = track.own;
        all.accounts.push(own);
        // A track that ends before its length says, right before another one.
        at = if bytes[read_to..].starts_with(b"MTrk") { read_to } else { end };
    }
    Ok(all)
}

/// Where the header begins.
fn head(bytes: &[u8]) -> Result<usize, HeadFault> {
    if bytes.starts_with(b"SMF2CLIP") {
        return Err(HeadFault::Clip);
    }
    let is_riff = bytes.starts_with(b"RIFF") && bytes.get(8..12) == Some(b"RMID");
    let start = if is_riff { bytes.windows(4).take(4096).position(|four| four == b"MThd") } else { Some(0) };
    start.filter(|start| bytes[*start..].starts_with(b"MThd")).ok_or(HeadFault::NoHead)
}

fn timing(division: u16) -> Result<Timing, HeadFault> {
    let [high, ticks] = division.to_be_bytes();
    if high < 0x80 {
        return if division > 0 { Ok(Timing::Quarter(division)) } else { Err(HeadFault::NoTime) };
    }
    let frames = high.wrapping_neg();
    let frames_per_s = match frames {
        24 | 25 | 30 => f64::from(frames),
        // Drop frame.
        29 => 30_000.0 / 1001.0,
        _ => return Err(HeadFault::Frames(frames)),
    };
    if ticks == 0 {
        return Err(HeadFault::NoTime);
    }
    Ok(Timing::Fixed(1.0 / (frames_per_s * f64::from(ticks))))
}

/// Whether a chunk may begin here: a name of four letters, or the file's end.
fn is_chunk(bytes: &[u8], at: usize) -> bool {
    bytes.get(at..at + 4).is_some_and(|name| name.iter().all(|letter| (b' '..=b'~').contains(letter)))
        && bytes.len() >= at + 8
}

fn track_from(bytes: &[u8], at: usize) -> Option<usize> {
    bytes.get(at..)?.windows(4).position(|four| four == b"MTrk").map(|found| at + found)
}

/// What stands at a place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Found {
    Voice(u8, Message),
    Tempo(u32),
    End,
    Skip,
}

/// A whole event: its delay in ticks, what it is, the place behind it, and the running status then.
type Whole = (u32, Found, usize, Option<u8>);

/// Why there is no whole event.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Torn {
    /// The track ends in it.
    CutOff,
    /// At a place, after a delay in ticks that was read. A message of a channel that has a bad data byte there has a
    /// place behind it, and a status.
    Bad { at: usize, delay: u32, message: Option<(usize, u8)> },
}

struct Track<'a> {
    /// The file up to the track's end.
    bytes: &'a [u8],
    all: &'a mut Tracks,
    number: u16,
    own: Account,
}

impl Track<'_> {
    /// Reads a track from a place on; returns the place behind its last event.
    fn read(&mut self, from: usize) -> usize {
        let (mut at, mut running, mut tick) = (from, None, 0_u64);
        while at < self.bytes.len() {
            if let Some((delay, begin, end)) = self.unmeasured(at, running) {
                tick += u64::from(delay);
                self.own.skipped.push(Skipped { tick, at: begin, count: end - begin, notes: 0, untimed: false });
                at = end;
                continue;
            }
            match self.event(at, running) {
                Ok((delay, found, next, status)) => {
                    tick += u64::from(delay);
                    (at, running) = (next, status);
                    if self.take(tick, found) {
                        self.own.last_tick = tick;
                        return at;
                    }
                }
                Err(Torn::CutOff) => {
                    at = self.bytes.len();
                }
                Err(Torn::Bad { at: bad, delay, message }) => {
                    tick += u64::from(delay);
                    (at, running) = self.go_on(tick, at, bad, message, running);
                }
            }
        }
        self.own.last_tick = tick;
        self.own.breaks_off = true;
        at
    }

    /// Takes an event; returns whether it ends the track.
    fn take(&mut self, tick: u64, found: Found) -> bool {
        match found {
            Found::Voice(channel, message) => {
                self.own.notes += usize::from(matches!(message, Message::On(..)));
                self.all.events.push(Event { tick, track: self.number, channel, message });
            }
            Found::Tempo(0) => self.own.no_tempi.push(tick),
            Found::Tempo(quarter_us) => self.all.tempi.push((tick, quarter_us)),
            Found::End => return true,
            Found::Skip => {}
        }
        false
    }

    /// The event at a place.
    fn event(&self, at: usize, running: Option<u8>) -> Result<Whole, Torn> {
        let (delay, at) = self.number(at).map_err(|bad| bad.map_or(Torn::CutOff, |at| torn(at, 0)))?;
        let (found, next, status) = self.message(at, running, delay)?;
        Ok((delay, found, next, status))
    }

    /// The message at a place, after a delay in ticks.
    fn message(&self, at: usize, running: Option<u8>, delay: u32) -> Result<(Found, usize, Option<u8>), Torn> {
        let first = *self.bytes.get(at).ok_or(Torn::CutOff)?;
        let (status, data) = match (first, running) {
            (0x80.., _) => (first, at + 1),
            (_, Some(status)) => (status, at),
            (_, None) => return Err(torn(at, delay)),
        };
        match status {
            0x80..=0xEF => {
                let count = if matches!(status, 0xC0..=0xDF) { 1 } else { 2 };
                let end = data + count;
                let own = self.bytes.get(data..end).ok_or(Torn::CutOff)?;
                if let Some(bad) = own.iter().position(|byte| *byte >= 0x80) {
                    return Err(Torn::Bad { at: data + bad, delay, message: Some((end, status)) });
                }
                let message = message(status, own[0], own.get(1).copied().unwrap_or(0));
                Ok((Found::Voice(status & 0x0F, message), end, Some(status)))
            }
            0xF0 | 0xF7 => Ok((Found::Skip, self.skipped(data, delay)?.1, running)),
            0xFF => {
                let kind = *self.bytes.get(data).ok_or(Torn::CutOff)?;
                if kind >= 0x80 {
                    return Err(torn(data, delay));
                }
                let (own, end) = self.skipped(data + 1, delay)?;
                let found = match (kind, own) {
                    (0x51, [a, b, c, ..]) => Found::Tempo(u32::from_be_bytes([0, *a, *b, *c])),
                    (0x2F, _) => Found::End,
                    _ => Found::Skip,
                };
                Ok((found, end, running))
            }
            _ => Err(torn(at, delay)),
        }
    }

    /// Bytes behind their number, and the place behind them.
    fn skipped(&self, at: usize, delay: u32) -> Result<(&[u8], usize), Torn> {
        let (count, from) = self.number(at).map_err(|bad| bad.map_or(Torn::CutOff, |at| torn(at, delay)))?;
        let end = from + count as usize;
        // A length beyond the end of the track is bad, unless the whole file ends in it.
        self.bytes.get(from..end).map(|own| (own, end)).ok_or(torn(at, delay))
    }

    /// A system exclusive message without its length, as it is sent: its delay, where it begins, and the place behind
    /// it. Its first byte is taken for a length if that makes as much sense.
    fn unmeasured(&self, at: usize, running: Option<u8>) -> Option<(u32, usize, usize)> {
        let (delay, begin) = self.number(at).ok().filter(|(_, begin)| self.bytes.get(*begin) == Some(&0xF0))?;
        let status = begin + 1 + self.bytes[begin + 1..].iter().position(|byte| *byte >= 0x80)?;
        let end = Some(status + 1).filter(|_| self.bytes[status] == 0xF7)?;
        let stated = self.skipped(begin + 1, delay).ok().map(|(_, end)| end);
        if stated.is_some_and(|stated| stated <= end) {
            return None;
        }
        let sense = |from: usize| {
            let sense = self.sense(from, running, COMPARED);
            (sense.events >= SENSE, sense.statuses)
        };
        (sense(end) > stated.map_or((false, 0), sense)).then_some((delay, begin, end))
    }

    /// A number of variable length, and the place behind it; the bad place, or `None` where the track ends in it.
    fn number(&self, at: usize) -> Result<(u32, usize), Option<usize>> {
        let mut number = 0;
        for i in 0..4 {
            let byte = *self.bytes.get(at + i).ok_or(None)?;
            number = number << 7 | u32::from(byte & 0x7F);
            if byte < 0x80 {
                return Ok((number, at + i + 1));
            }
        }
        Err(Some(at))
    }

    /// Where a track goes on whose event at `at` is bad at another place, and with which running status. The bad byte
    /// may be another's, or too many; else the next message that makes sense counts.
    fn go_on(
        &mut self,
        tick: u64,
        at: usize,
        bad: usize,
        message: Option<(usize, u8)>,
        running: Option<u8>,
    ) -> (usize, Option<u8>) {
        let is_system = self.bytes[bad] >= 0xF1 && self.bytes[bad] < 0xFF;
        if is_system && let Some(next) = self.without_system(tick, bad, message, running) {
            return next;
        }
        // A data byte that is none: the rest of the message stands.
        if let Some((end, status)) = message
            && self.sense(end, Some(status), COMPARED).events >= SENSE
        {
            let notes = usize::from(matches!(status, 0x90..=0x9F) && self.bytes[end - 1] != 0);
            self.own.skipped.push(Skipped { tick, at, count: end - at, notes, untimed: false });
            return (end, Some(status));
        }
        let goes_on = |next: &usize| self.begins(*next) && self.sense(*next, None, SENSE).events >= SENSE;
        let next = (bad + 1..self.bytes.len()).find(goes_on).unwrap_or(self.bytes.len());
        let begins = |i: &usize| matches!(self.bytes[*i], 0x90..=0x9F) && *i + 1 < next;
        let notes = (at..next).filter(begins).count();
        self.own.skipped.push(Skipped { tick, at, count: next - at, notes, untimed: true });
        (next, None)
    }

    /// System messages, which no file holds: within another message, before it, or with a delay of their own. Nothing
    /// else is lost.
    fn without_system(
        &mut self,
        tick: u64,
        bad: usize,
        message: Option<(usize, u8)>,
        running: Option<u8>,
    ) -> Option<(usize, Option<u8>)> {
        let own = |first: u8| match first {
            0xF1 | 0xF3 => 2,
            0xF2 => 3,
            _ => 1,
        };
        let is_system = |at: usize| self.bytes.get(at).copied().filter(|byte| (0xF1..0xFF).contains(byte));
        if let Some((_, status)) = message {
            // Within a message of a channel: its data, without them.
            let count = if matches!(status, 0xC0..=0xDF) { 1 } else { 2 };
            let (mut data, mut end) = ([0; 2], bad);
            let before = message.map_or(0, |(end, _)| count - (end - bad).min(count));
            data[..before].copy_from_slice(&self.bytes[bad - before..bad]);
            for one in &mut data[before..count] {
                while is_system(end).is_some() {
                    end += 1;
                }
                *one = self.bytes.get(end).copied().filter(|byte| *byte < 0x80)?;
                end += 1;
            }
            if self.sense(end, Some(status), COMPARED).events < SENSE {
                return None;
            }
            self.own.skipped.push(Skipped {
                tick,
                at: bad,
                count: end + before - bad - count,
                notes: 0,
                untimed: false,
            });
            self.take(tick, Found::Voice(status & 0x0F, self::message(status, data[0], data[1])));
            return Some((end, Some(status)));
        }
        let mut end = bad;
        while let Some(first) = is_system(end) {
            end += own(first);
        }
        let alone = self.sense(end, running, COMPARED);
        // Without a delay of its own: that of the next message, which follows at once.
        let next = self.message(end, running, 0);
        let together = next.map_or(Sense::default(), |(_, next, status)| self.sense(next, status, COMPARED));
        if alone.events.max(together.events) < SENSE {
            return None;
        }
        let count = end.min(self.bytes.len()) - bad;
        self.own.skipped.push(Skipped { tick, at: bad, count, notes: 0, untimed: false });
        // Delays and data that are read in each other's place make a sense of their own, but without statuses.
        if (alone.events >= SENSE, alone.statuses) >= (together.events >= SENSE, together.statuses) {
            return Some((end, running));
        }
        let Ok((found, next, status)) = next else { return None };
        self.take(tick, found);
        Some((next, status))
    }

    /// Whether a delay and a status are here.
    fn begins(&self, at: usize) -> bool {
        self.number(at).is_ok_and(|(_, next)| self.bytes.get(next).is_some_and(|status| *status >= 0x80))
    }

    /// Events that follow each other from a place on, at most `most`: the track's end is as good as all.
    fn sense(&self, from: usize, running: Option<u8>, most: usize) -> Sense {
        let (mut at, mut running, mut sense) = (from, running, Sense::default());
        while sense.events < most && at < self.bytes.len() {
            sense.statuses += usize::from(self.begins(at));
            match self.event(at, running) {
                Ok((_, Found::End, ..)) | Err(Torn::CutOff) => break,
                Ok((_, _, next, status)) => (at, running) = (next, status),
                Err(Torn::Bad { .. }) => return sense,
            }
            sense.events += 1;
        }
        Sense { events: most, ..sense }
    }
}

/// Sense that bytes make.
#[derive(Debug, Clone, Copy, Default)]
struct Sense {
    /// Events, and those of them with a status of their own.
    events: usize,
    statuses: usize,
}

fn torn(at: usize, delay: u32) -> Torn {
    Torn::Bad { at, delay, message: None }
}

fn message(status: u8, first: u8, second: u8) -> Message {
    match status & 0xF0 {
        0x80 => Message::Off(first, Some(second)),
        0x90 if second > 0 => Message::On(first, second),
        0x90 => Message::Off(first, None),
        0xB0 => Message::Controller(first, second),
        0xC0 => Message::Program(first),
        _ => Message::Other,
    }
}
