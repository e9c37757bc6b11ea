//! The outputs of `erard scan`: streams of readings, the sensors' profiles, the truth.

pub(crate) mod report;

use std::collections::BTreeMap;
use std::io::Write;

use erard::instrument::Instrument;
use erard::keyboard::{Keyboard, note_name};
use erard_live::contacts::{ContactLaw, MAX_CONTACTS};
use erard_live::profile::{Profile, Sensed};
use erard_live::sensor::Law as SensorLaw;
use erard_midi::Law;
use erard_piece::Score;
use erard_piece::scan::{Reading, Sensor, Strike, Truth, stops};

use crate::failure::Failure;
use crate::output::Output;
use crate::session::Session;
use crate::table::Table;

/// What was scanned.
pub(crate) struct Scanned<'a> {
    /// The piece's file.
    pub piece: Option<String>,
    pub score: Option<&'a Score<'a>>,
    pub keyboard: &'a Keyboard,
    /// The keyboard as it was asked for, and the sample's number in that.
    pub asked: &'a str,
    pub sample: Option<u32>,
    pub has_scatter: bool,
    pub seed: u32,
    pub instruments: &'a [Instrument],
    /// Travel of each key's front, or of its hammer's head, m.
    pub travels_m: &'a [f64],
    pub are_hammers: bool,
    /// Contacts, by the rate of their scan, Hz; empty of other sensors.
    pub contacts: &'a [(f64, ContactLaw)],
    /// Keys that are played, from 1.
    pub played: &'a [usize],
    pub sensors: &'a [Sensor],
    pub truth: &'a Truth,
}

/// The file of a sensor's readings.
fn scan_name(sensor: &Sensor) -> String {
    if sensor.bits == 1 {
        return format!("scan-contacts-{}hz-{}.csv", sensor.rate_hz, percent(sensor));
    }
    format!("scan-{}bit-{}hz-{}.csv", sensor.bits, sensor.rate_hz, percent(sensor))
}

/// The file of a sensor's profile: one for sensors with as many bits, and for contacts with the same rate.
fn profile_name(sensor: &Sensor) -> String {
    match sensor.bits {
        1 => format!("profile-contacts-{}hz.toml", sensor.rate_hz),
        bits => format!("profile-{bits}bit.toml"),
    }
}

/// Noise of a sensor, % of a key's travel.
fn percent(sensor: &Sensor) -> f64 {
    (1e10 * sensor.noise).round() / 1e8
}

impl Scanned<'_> {
    /// What the owner of the sensors knows of the travel between the stops, m: the mean of the keys, to 0.1 mm.
    fn known_travel_m(&self) -> f64 {
        let sum: f64 = self.played.iter().map(|key| self.travels_m[key - 1]).sum();
        1e-4 * (1e4 * sum / self.played.len() as f64).round()
    }

    /// Writes all but the summary. Returns how many readings each sensor sent.
    pub(crate) fn write(
        &self,
        session: &Session,
        readings: Vec<Vec<Reading>>,
        output: &mut Output,
    ) -> Result<Vec<usize>, Failure> {
        let counts = readings.iter().map(Vec::len).collect();
        let pedals = self.score.map(Score::sustain).unwrap_or_default();
        for (sensor, readings) in self.sensors.iter().zip(readings) {
            let write = if self.contacts.is_empty() { stream } else { edges };
            output.stage(session, &scan_name(sensor), |writer| write(&readings, &pedals, writer))?;
        }
        for (rate_hz, law) in self.contacts {
            let sensor = Sensor { bits: 1, rate_hz: *rate_hz, noise: 0.0 };
            output.text(session, &profile_name(&sensor), &Profile::of_contacts(*law).text())?;
        }
        let own = self.sensors.iter().filter(|_| self.contacts.is_empty());
        let sensors: BTreeMap<u32, &Sensor> = own.map(|sensor| (sensor.bits, sensor)).collect();
        for (bits, sensor) in sensors {
            let keys = self.played.iter().map(|key| (*key, stops(bits))).collect();
            let travel_m = self.known_travel_m();
            let law = SensorLaw::Linear {};
            let sensed = if self.are_hammers { Sensed::Hammers(None) } else { Sensed::Keys };
            let profile = Profile { sensed, law, travel_m, pressure_is_depth: false, keys };
            output.text(session, &profile_name(sensor), &profile.text())?;
        }
        output.table(session, "truth.csv", &self.strikes())?;
        output.table(session, "windows.csv", &self.windows())?;
        Ok(counts)
    }

    fn strikes(&self) -> Table<'static> {
        let Truth { windows, strikes } = self.truth;
        let number = |of: &dyn Fn(&Strike) -> Option<f64>| strikes.iter().map(of).collect::<Vec<_>>();
        Table::default()
            .optional("key", number(&|one| Some(one.key as f64)))
            .words("name", strikes.iter().map(|one| note_name(one.key)))
            .words("case", strikes.iter().map(|one| windows[one.window].case))
            .optional("window", number(&|one| Some((one.window + 1) as f64)))
            .optional("time_s", number(&|one| Some(one.time_s)))
            .optional("hammer_speed_m_per_s", number(&|one| Some(one.hammer_speed_m_per_s)))
            .optional("velocity", number(&|one| Some(Law::GOEBL.velocity(one.hammer_speed_m_per_s).counts())))
            .optional("again", number(&|one| Some(f64::from(u8::from(one.again)))))
            .optional("release_s", number(&|one| one.released.map(|[at_s, _]| at_s)))
            .optional("release_m_per_s", number(&|one| one.released.map(|[_, speed]| speed)))
    }

    fn windows(&self) -> Table<'static> {
        let windows = &self.truth.windows;
        let impacts = |index: usize| self.truth.strikes.iter().filter(|one| one.window == index).count();
        Table::default()
            .optional("window", (1..=windows.len()).map(|n| Some(n as f64)))
            .optional("key", windows.iter().map(|one| Some(one.key as f64)))
            .words("case", windows.iter().map(|one| one.case))
            .optional("from_s", windows.iter().map(|one| Some(one.from_s)))
            .optional("to_s", windows.iter().map(|one| Some(one.to_s)))
            .optional("impact_count", (0..windows.len()).map(|index| Some(impacts(index) as f64)))
    }
}

/// Readings and the sustain pedal as the stream that `erard live` reads.
fn stream(readings: &[Reading], pedals: &[[f64; 2]], writer: &mut dyn Write) -> std::io::Result<()> {
    writeln!(writer, "time_us,key,raw")?;
    with_pedals(readings, pedals, writer, &mut |Reading { time_us, key, raw }, writer| {
        writeln!(writer, "{time_us},{key},{raw}")
    })
}

/// Edges of contacts and the sustain pedal as that stream. Of contacts that close in one scan the upper one comes
/// first, of those that open the lower one.
fn edges(readings: &[Reading], pedals: &[[f64; 2]], writer: &mut dyn Write) -> std::io::Result<()> {
    writeln!(writer, "time_us,key,contact,state")?;
    let mut before: BTreeMap<usize, u32> = BTreeMap::new();
    with_pedals(readings, pedals, writer, &mut |Reading { time_us, key, raw }, writer| {
        let was = before.insert(*key, *raw).unwrap_or(0);
        let mut edge = |contact: usize, state: &str| writeln!(writer, "{time_us},{key},{},{state}", contact + 1);
        let bit = |contact: &usize, of: u32| of >> contact & 1 == 1;
        (0..MAX_CONTACTS).rev().filter(|one| bit(one, was & !raw)).try_for_each(|one| edge(one, "open"))?;
        (0..MAX_CONTACTS).filter(|one| bit(one, raw & !was)).try_for_each(|one| edge(one, "made"))
    })
}

/// Readings, each written by a function, and the motions of the sustain pedal between them.
fn with_pedals(
    readings: &[Reading],
    pedals: &[[f64; 2]],
    writer: &mut dyn Write,
    write: &mut dyn FnMut(&Reading, &mut dyn Write) -> std::io::Result<()>,
) -> std::io::Result<()> {
    let mut pedals = pedals.iter().map(|[at_s, down]| ((1e6 * at_s).round() as u64, down)).peekable();
    for reading in readings {
        while let Some((at_us, down)) = pedals.next_if(|(at_us, _)| *at_us <= reading.time_us) {
            writeln!(writer, "{at_us},sustain,{down:.3}")?;
        }
        write(reading, writer)?;
    }
    pedals.try_for_each(|(at_us, down)| writeln!(writer, "{at_us},sustain,{down:.3}"))
}
