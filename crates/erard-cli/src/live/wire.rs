//! Bytes of MIDI to whoever takes them; where the process is ended, notes that sound are ended first.

use std::io::{self, Write};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use erard::keyboard::note_name;
use erard_live::Event;
use erard_live::cable::Cable;
use erard_midi::file::{Note, PedalChange, Piece, write};
use erard_midi::{KEYS, Message, Packet, Resolution, Velocity, note_of_key};

use crate::table::Table;

/// Bits of a velocity.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Bits {
    /// MIDI 1.0
    #[value(name = "7")]
    Seven,
    /// MIDI 1.0 with controller 88 before each note
    #[value(name = "14")]
    Fourteen,
    /// MIDI 2.0: packets of eight bytes
    #[value(name = "16")]
    Sixteen,
}

impl Bits {
    pub(crate) fn resolution(self) -> Resolution {
        if self == Bits::Fourteen { Resolution::FourteenBits } else { Resolution::SevenBits }
    }

    /// A velocity as it is sent, in counts.
    fn sent(self, velocity: Velocity) -> f64 {
        match self {
            Bits::Seven => f64::from(velocity.seven_bits()),
            Bits::Fourteen => Velocity::of_fourteen_bits(velocity.fourteen_bits()).counts(),
            Bits::Sixteen => Velocity::of_sixteen_bits(velocity.sixteen_bits()).counts(),
        }
    }
}

/// What takes bytes.
pub(crate) type Sink = Box<dyn Write + Send>;

/// A sink, and the notes that sound on it.
struct Open {
    sink: Sink,
    sounding: [u32; KEYS],
    bits: Bits,
    channel: u8,
}

/// The notes that sound, shared with the thread that ends the process.
#[derive(Clone, Default)]
pub(crate) struct Sounding(Arc<Mutex<Option<Open>>>);

impl Sounding {
    /// Ends what sounds, before the process is ended.
    pub(crate) fn silence(&self) {
        // Whoever is writing now finishes its message first.
        let mut open = self.open();
        let Some(open) = open.as_mut() else { return };
        for key in 1..=KEYS {
            for _ in 0..std::mem::take(&mut open.sounding[key - 1]) {
                // Nobody is left to tell.
                let _ = open.off(key, None).and_then(|bytes| open.sink.write_all(&bytes).ok());
            }
        }
        let _ = open.sink.flush();
    }

    fn open(&self) -> MutexGuard<'_, Option<Open>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Open {
    /// A note-off; 64, without more bits, where nobody saw the release.
    fn off(&self, key: usize, release: Option<Velocity>) -> Option<Vec<u8>> {
        let note = note_of_key(key)?;
        let unseen = (Velocity::of_seven_bits(64), Resolution::SevenBits);
        let (velocity, resolution) = release.map_or(unseen, |release| (release, self.bits.resolution()));
        Some(match self.bits {
            Bits::Sixteen => Packet::note_off(0, self.channel, note, velocity).bytes().to_vec(),
            _ => Message::note_off(self.channel, note, velocity, resolution).bytes().to_vec(),
        })
    }

    fn bytes(&mut self, event: &Event) -> Option<Vec<u8>> {
        match *event {
            Event::On { key, velocity, .. } => {
                let note = note_of_key(key)?;
                // A key that strikes again before its damper is down has one note-off.
                self.sounding[key - 1] = 1;
                Some(match self.bits {
                    Bits::Sixteen => Packet::note_on(0, self.channel, note, velocity).bytes().to_vec(),
                    bits => Message::note_on(self.channel, note, velocity, bits.resolution()).bytes().to_vec(),
                })
            }
            Event::Off { key, release, .. } => {
                self.sounding[key - 1] = 0;
                self.off(key, release)
            }
            Event::Pedal { controller, value, .. } => Some(match self.bits {
                // The lowest and the highest value stay so.
                Bits::Sixteen => {
                    let wide = (u64::from(value) * u64::from(u32::MAX) / 127) as u32;
                    Packet::controller(0, self.channel, controller, wide).bytes().to_vec()
                }
                _ => Message::controller(self.channel, controller, value).bytes().to_vec(),
            }),
        }
    }
}

/// Bytes of a file that appears when all is done.
#[derive(Clone, Default)]
struct Kept(Arc<Mutex<Vec<u8>>>);

impl Write for Kept {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// A note of a table.
struct Row {
    key: usize,
    time_s: f64,
    hammer_speed_m_per_s: f64,
    velocity: Velocity,
    /// When it ended, s, and the release's velocity, where it was seen.
    ended: Option<(f64, Option<Velocity>)>,
}

/// Where events go: bytes to a sink at once, or a file.
pub(crate) struct Wire {
    sounding: Sounding,
    kept: Option<Kept>,
    piece: Option<Piece>,
    rows: Option<Vec<Row>>,
    open: Vec<Option<Note>>,
    begins_s: Option<f64>,
    cable: Option<Cable>,
}

impl Wire {
    /// Bytes to a sink.
    pub(crate) fn bytes(sounding: &Sounding, sink: Sink, bits: Bits, channel: u8) -> Self {
        *sounding.open() = Some(Open { sink, sounding: [0; KEYS], bits, channel });
        let cable = (bits != Bits::Sixteen).then(Cable::default);
        let sounding = sounding.clone();
        Wire { sounding, kept: None, piece: None, rows: None, open: Vec::new(), begins_s: None, cable }
    }

    /// Bytes for a file.
    pub(crate) fn kept(sounding: &Sounding, bits: Bits, channel: u8) -> Self {
        let kept = Kept::default();
        Wire { kept: Some(kept.clone()), ..Wire::bytes(sounding, Box::new(kept), bits, channel) }
    }

    /// A piece for a Standard MIDI File.
    pub(crate) fn piece() -> Self {
        Wire { piece: Some(Piece::default()), open: vec![None; KEYS], ..Wire::table() }
    }

    /// Notes for a table.
    pub(crate) fn table() -> Self {
        let (sounding, rows) = (Sounding::default(), Some(Vec::new()));
        Wire { sounding, kept: None, piece: None, rows, open: Vec::new(), begins_s: None, cable: None }
    }

    /// Sends an event at an instant of the stream, s.
    pub(crate) fn send(&mut self, event: &Event, begins_s: f64) -> io::Result<()> {
        self.begins_s.get_or_insert(begins_s);
        if self.piece.is_some() {
            self.keep(event);
            return Ok(());
        }
        if let Some(rows) = &mut self.rows {
            note_down(rows, event);
            return Ok(());
        }
        let mut open = self.sounding.open();
        let Some(open) = open.as_mut() else { return Ok(()) };
        let Some(bytes) = open.bytes(event) else { return Ok(()) };
        if let Some(cable) = &mut self.cable {
            let (Event::On { time_s, .. } | Event::Off { time_s, .. } | Event::Pedal { time_s, .. }) = *event;
            cable.send(time_s, bytes.len());
        }
        open.sink.write_all(&bytes)?;
        open.sink.flush()
    }

    /// The longest time that a message took on a DIN cable, s.
    pub(crate) fn longest_on_a_cable_s(&self) -> f64 {
        self.cable.map_or(0.0, |cable| cable.longest_s)
    }

    fn keep(&mut self, event: &Event) {
        let begins_s = self.begins_s.unwrap_or(0.0);
        let Wire { kept: None, piece: Some(piece), open, .. } = self else { return };
        match *event {
            Event::On { key, time_s, velocity, .. } => {
                let start_s = time_s - begins_s;
                // A key that strikes again before its damper is down: the note goes over into the next.
                piece.notes.extend(open[key - 1].take().map(|note| Note { end_s: start_s, ..note }));
                open[key - 1] = Some(Note { key, start_s, end_s: start_s, velocity, release: None });
            }
            Event::Off { key, time_s, release } => {
                let end = |note: Note| {
                    // The file's ticks are a twentieth of a millisecond.
                    let end_s = (time_s - begins_s).max(note.start_s + 1e-4);
                    Note { end_s, release, ..note }
                };
                piece.notes.extend(open[key - 1].take().map(end));
            }
            Event::Pedal { controller, time_s, value } => {
                piece.pedals.push(PedalChange { time_s: time_s - begins_s, controller, value });
            }
        }
    }

    /// The notes, where they are a table: instants on the stream's clock, to a microsecond, speeds to a tenth of a
    /// millimetre per second, velocities as they would be sent with these bits.
    pub(crate) fn notes(&mut self, bits: Bits) -> Option<Table<'static>> {
        let rows = self.rows.take().filter(|_| self.piece.is_none())?;
        let number = |of: &dyn Fn(&Row) -> Option<f64>| rows.iter().map(of).collect::<Vec<_>>();
        let table = Table::default()
            .optional("key", number(&|row| Some(row.key as f64)))
            .words("name", rows.iter().map(|row| note_name(row.key)))
            .optional("time_s", number(&|row| Some(rounded(row.time_s, 1e6))))
            .optional("hammer_speed_m_per_s", number(&|row| Some(rounded(row.hammer_speed_m_per_s, 1e4))))
            .optional("velocity", number(&|row| Some(bits.sent(row.velocity))))
            .optional("release_s", number(&|row| row.ended.map(|(at_s, _)| rounded(at_s, 1e6))))
            .optional(
                "release_velocity",
                number(&|row| row.ended.and_then(|(_, release)| release.map(|one| bits.sent(one)))),
            );
        Some(table)
    }

    /// The bytes of the file, where it is one.
    pub(crate) fn file(&mut self, bits: Bits) -> Result<Option<Vec<u8>>, String> {
        if let Some(Kept(bytes)) = &self.kept {
            return Ok(Some(bytes.lock().unwrap_or_else(PoisonError::into_inner).clone()));
        }
        let Some(piece) = &mut self.piece else { return Ok(None) };
        // A note of no length, of a key that struck twice within a tick, is none.
        piece.notes.retain(|note| note.end_s > note.start_s);
        piece.notes.sort_by(|a, b| a.start_s.total_cmp(&b.start_s).then(a.key.cmp(&b.key)));
        piece.pedals.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
        write(piece, bits.resolution()).map(Some).map_err(|error| error.to_string())
    }
}

/// A number to a share of one.
fn rounded(number: f64, parts: f64) -> f64 {
    (number * parts).round() / parts
}

/// Takes an event into the notes of a table. A key that strikes again before its damper is down has one end.
fn note_down(rows: &mut Vec<Row>, event: &Event) {
    match *event {
        Event::On { key, time_s, hammer_speed_m_per_s, velocity, .. } => {
            rows.push(Row { key, time_s, hammer_speed_m_per_s, velocity, ended: None });
        }
        Event::Off { key, time_s, release } => {
            if let Some(row) = rows.iter_mut().rev().find(|row| row.key == key) {
                row.ended = Some((time_s, release));
            }
        }
        Event::Pedal { .. } => {}
    }
}
