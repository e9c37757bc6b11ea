//! `erard calibrate`.

use erard::parameter::Quantity;
use std::collections::BTreeMap;
use std::io::BufReader;
use std::path::{Path, PathBuf};

use clap::Args;
use erard::damper::{USUAL_HEIGHT_M, damper_height_m};
use erard::instrument_spec::Base;
use erard::run::SimulationError;
use erard_live::calibrate::{Found, Readings, stops, unlike};
use erard_live::contact_table::{ContactTableError, PRESSED_KEY, Presses, error_counts};
use erard_live::contacts::{ContactFault, ContactLaw, Point, SpeedTable};
use erard_live::profile::{Profile, Release, Sensed};
use erard_live::sensor::{Law as SensorLaw, LawFault};
use erard_live::stream::{Fault, Of, SensorUnit};
use erard_midi::Law;
use serde_json::json;

use super::live::stream_reader;
use super::out::OwnFile;
use crate::answer::Answer;
use crate::failure::Failure;
use crate::inputs::shown;
use crate::instruments::load_keyboard;
use crate::law_points::{LawPoints, law_points};
use crate::live::feed::lines_of;
use crate::number::{Values, between, list};
use crate::output::Output;
use crate::print_line;
use crate::session::Session;
use crate::table::{Table, decimal, many, spaced};
use crate::warn;

/// Headers of a ruler's table and of a maker's own table of contacts.
pub(super) const RULER_HEAD: &str = "raw,mm";
pub(super) const CONTACT_HEAD: &str = "between_ms,hammer_speed_m_per_s";
/// Readings of sensors by their keys.
type Sensors = BTreeMap<usize, Readings>;
/// What stands below the options.
const AFTER: &str = include_str!("help/calibrate.txt");

/// Finds the stops of sensed keys: readings to millimetres, for `erard live`.
#[derive(Debug, Args)]
#[command(after_help = AFTER)]
pub(crate) struct Calibrate {
    /// Readings of every key: at rest, pressed and held, let go. CSV with the header `time_s,key,raw`
    #[arg(value_name = "READINGS.csv", required_unless_present = "contacts", conflicts_with = "contacts")]
    readings: Option<PathBuf>,
    /// Sampling rate of a log without times, Hz. The header names the keys of the columns, such as `40,41`, or is
    /// `key,raw`
    #[arg(long, value_name = "HZ", conflicts_with = "contacts", value_parser = between(Quantity::Frequency, "Hz", 20.0, 1e6), allow_hyphen_values = true)]
    rate: Option<f64>,
    /// Law of the sensors: linear, cny70, hall, or a file of your own points (CSV with the header `raw,mm`)
    #[arg(long, value_name = "LAW", default_value = "linear")]
    sensor_law: String,
    /// Travel of the sensed place between its two stops, mm [default: 10, of a hammer's head 46]
    #[arg(long, value_name = "MM", value_parser = between(Quantity::Length, "mm", 0.5, 100.0), allow_hyphen_values = true)]
    travel: Option<f64>,
    /// The sensors sit at the hammers' shanks: readings of each hammer at rest, held against its string or stop rail,
    /// let go
    #[arg(long, conflicts_with_all = ["contacts", "pressure_is_depth"])]
    hammers: bool,
    /// Hammers: travel of a second sensor at each key, mm, whose readings are those of `40:release`
    #[arg(long, value_name = "MM", requires = "hammers", value_parser = between(Quantity::Length, "mm", 0.5, 100.0), allow_hyphen_values = true)]
    release_travel: Option<f64>,
    /// Hall sensors: smallest distance to the magnet, mm. The default is an estimate
    #[arg(long, value_name = "MM", default_value_t = 3.0, value_parser = between(Quantity::Length, "mm", 0.1, 100.0), allow_hyphen_values = true)]
    nearest: f64,
    /// Hall sensors: the magnet is nearest while the key is at rest
    #[arg(long)]
    nearest_at_rest: bool,
    /// This device's polyphonic pressure is the key's depth
    #[arg(long)]
    pressure_is_depth: bool,
    /// Two or three contacts under each key, instead of readings: depths of the key's front at which they close, mm,
    /// the upper one first
    #[arg(long, value_name = "MM,MM", value_parser = list(between(Quantity::Length, "mm", 0.1, 20.0)), allow_hyphen_values = true)]
    contacts: Option<Values>,
    /// Contacts: period of their scan, us
    #[arg(long, value_name = "US", default_value_t = 1000.0, value_parser = microseconds, allow_hyphen_values = true)]
    scan_period: f64,
    /// Contacts: how long after its time stamp each of them is read, us [default: 0]
    #[arg(long, value_name = "US,US", value_parser = list(microseconds), allow_hyphen_values = true, requires = "contacts")]
    scan_phases: Option<Values>,
    /// Contacts: changes within this time after an edge are bounces, s
    #[arg(long, value_name = "S", default_value_t = 2e-3, value_parser = between(Quantity::Time, "s", 0.0, 0.1), allow_hyphen_values = true)]
    bounce: f64,
    /// Contacts: the maker's own table from the first contact to the last, instead of the simulated action's. CSV with
    /// the header `between_ms,hammer_speed_m_per_s`
    #[arg(long, value_name = "FILE", requires = "contacts")]
    contact_table: Option<PathBuf>,
    /// Contacts: keyboard whose key 40 is pressed to find the hammer speeds
    #[arg(long, value_name = "KEYBOARD", default_value = "concert-grand")]
    keyboard: Base,
    /// File of the profile [default: READINGS.toml, contacts.toml in this folder]
    #[arg(long, short, value_name = "FILE")]
    out_file: Option<PathBuf>,
    /// Replace FILE if it exists
    #[arg(long)]
    force: bool,
}

/// Rows of a long table of keys that are printed first.
const FIRST_ROWS: usize = 7;

impl Calibrate {
    /// Runs the command.
    pub(crate) fn run(&self, session: &mut Session) -> Result<Answer, Failure> {
        if let Some(Values(depths_mm)) = &self.contacts {
            return self.run_contacts(session, depths_mm);
        }
        let law = self.law(session)?;
        let asked = shown(self.readings());
        let OwnFile { folder, name } =
            OwnFile::of(session, self.out_file.as_deref(), &asked, ".toml", "profile's", self.force)?;
        let (readings, second) = self.read(session)?;
        let wrong = |what: String| Failure::Usage(format!("{asked}: {what}"));
        let found = stops(&readings).map_err(|fault| wrong(fault.to_string()))?;
        let profile = Profile {
            sensed: self.sensed(session, &second, &asked)?,
            law,
            travel_m: 1e-3 * self.travel_mm(),
            pressure_is_depth: self.pressure_is_depth,
            keys: found.iter().map(|(key, one)| (*key, one.stops)).collect(),
        };
        let mut output = Output::files(session, &folder, self.force, &[&name])?;
        output.text(session, &name, &profile.text())?;
        let written = output.commit(session)?;
        self.tell(session, &found);
        Ok(self.answer(&found)?.end(session, &written))
    }

    fn travel_mm(&self) -> f64 {
        self.travel.unwrap_or(if self.hammers { 46.0 } else { 10.0 })
    }

    /// What is sensed: keys, or hammers, whose releases a second sensor may see.
    fn sensed(&self, session: &mut Session, second: &Sensors, asked: &str) -> Result<Sensed, Failure> {
        let wrong = |what: &str| Failure::Usage(format!("{asked}: {what}"));
        match (self.hammers, self.release_travel, second.is_empty()) {
            (false, _, true) => Ok(Sensed::Keys),
            (false, _, false) => Err(wrong("`:release` is a second sensor beside a hammer; expected --hammers")),
            (true, None, true) => Ok(Sensed::Hammers(None)),
            (true, None, false) => Err(wrong("readings of `:release`; expected their travel, --release-travel MM")),
            (true, Some(_), true) => Err(wrong("no readings of a second sensor, such as `40:release`")),
            (true, Some(travel_mm), false) => {
                let keyboard = load_keyboard(session, &self.keyboard)?;
                let failed = |error: &dyn std::fmt::Display| Failure::Usage(format!("{}: {error}", keyboard.name));
                let instrument = keyboard.key(PRESSED_KEY).map_err(|error| failed(&error))?;
                let damper_m = damper_height_m(&instrument).map_err(|error| failed(&error))?;
                let dip_m = erard_live::dip_m(&instrument).map_err(|error| failed(&error))?;
                let travel_m = 1e-3 * travel_mm;
                let off_m = travel_m * damper_m.unwrap_or(USUAL_HEIGHT_M) / dip_m;
                // To a hundredth of a millimetre.
                let release = Release { travel_m, off_m: 1e-5 * (1e5 * off_m).round() };
                let found = stops(second).map_err(|fault| wrong(&format!("{fault} (`:release`)")))?;
                Ok(Sensed::Hammers(Some((release, found.iter().map(|(key, one)| (*key, one.stops)).collect()))))
            }
        }
    }

    fn readings(&self) -> &Path {
        self.readings.as_deref().unwrap_or(Path::new(""))
    }

    /// A profile of contacts: nothing is read, a simulated key is pressed.
    fn run_contacts(&self, session: &mut Session, depths_mm: &[f64]) -> Result<Answer, Failure> {
        let OwnFile { folder, name } =
            OwnFile::of(session, self.out_file.as_deref(), "contacts", ".toml", "profile's", self.force)?;
        let own = self.contact_table.as_deref().map(|path| own_speeds(session, path)).transpose()?;
        let keyboard = load_keyboard(session, &self.keyboard)?;
        let wrong = |what: String| Failure::Usage(what);
        let instrument = keyboard.key(PRESSED_KEY).map_err(|error| wrong(format!("{}: {error}", keyboard.name)))?;
        let mut progress = session.progress("pressing a key");
        let presses = Presses::of(&instrument, &mut |share| progress.tell(share));
        drop(progress);
        let presses = presses.map_err(|error| match error {
            ContactTableError::Interrupted => SimulationError::Interrupted.into(),
            error => wrong(format!("{}: {error}", keyboard.name)),
        })?;
        let depths_m: Vec<f64> = depths_mm.iter().map(|mm| 1e-3 * mm).collect();
        let (period_s, bounce_s) = (1e-6 * self.scan_period, self.bounce);
        let law = presses.law(&depths_m, period_s, bounce_s);
        let mut law = law.map_err(|error| wrong(format!("--contacts: {error}")))?;
        if let Some(Values(phases_us)) = &self.scan_phases {
            if phases_us.len() != law.count {
                let found = phases_us.len();
                return Err(wrong(format!(
                    "--scan-phases: {found} phases; expected one for each of {} contacts",
                    law.count
                )));
            }
            law.phases_s.iter_mut().zip(phases_us).for_each(|(phase_s, us)| *phase_s = 1e-6 * us);
            law.check().map_err(|fault| wrong(format!("--scan-phases: {fault}")))?;
        }
        if let Some(table) = own {
            law.tables[0] = table;
        }
        let best = presses.best(period_s);
        let mut output = Output::files(session, &folder, self.force, &[&name])?;
        output.text(session, &name, &Profile::of_contacts(law).text())?;
        let written = output.commit(session)?;
        tell_contacts(session, &law, &keyboard.name, best);
        Ok(contacts_answer(&law, best)?.end(session, &written))
    }

    /// The readings of all keys, and those of second sensors.
    fn read(&self, session: &mut Session) -> Result<(Sensors, Sensors), Failure> {
        let name = shown(self.readings());
        let wrong = |line: usize, what: String| Failure::Usage(format!("{name}, line {line}: {what}"));
        let unread = |error: std::io::Error| Failure::Usage(format!("{name}: cannot be read: {error}"));
        let file = session.inputs.open(self.readings()).map_err(unread)?;
        let (mut reader, mut keys, mut second) = (None, Sensors::new(), Sensors::new());
        for (index, line) in lines_of(BufReader::new(file)).enumerate() {
            let line = line.map_err(unread)?;
            let text = line.trim();
            if text.is_empty() || text.starts_with('#') {
                continue;
            }
            let Some(reader) = &mut reader else {
                let made = stream_reader(text, self.rate).map_err(|what| wrong(index + 1, what))?;
                if !matches!(made.quantity(), SensorUnit::Raw | SensorUnit::Pressure) {
                    return Err(wrong(index + 1, format!("found `{text}`; expected a reading, `time_s,key,raw`")));
                }
                reader = Some(made);
                continue;
            };
            let samples = match reader.received(&line) {
                // A log that was broken off.
                Err(fault @ Fault::NoEnd { .. }) => {
                    warn!(session, "warning: {name}, line {}: left out: {fault}", index + 1);
                    continue;
                }
                found => found.map_err(|fault| wrong(index + 1, fault.to_string()))?,
            };
            for sample in samples {
                let (key, sensors) = match sample.of {
                    Of::Key(key) => (key, &mut keys),
                    Of::Release(key) => (key, &mut second),
                    _ => continue,
                };
                let all = &mut sensors.entry(key).or_default().all;
                if all.last().is_some_and(|[t, _]| *t >= sample.time_s) {
                    return Err(wrong(index + 1, format!("key {key}: the time does not come after its last one")));
                }
                all.push([sample.time_s, sample.value]);
            }
        }
        if keys.is_empty() {
            return Err(Failure::Usage(format!(
                "{name}: no readings; expected the header `time_s,key,raw` and a line for each reading"
            )));
        }
        session.provenance.used_without_file("readings", &name);
        Ok((keys, second))
    }

    fn law(&self, session: &mut Session) -> Result<SensorLaw, Failure> {
        Ok(match self.sensor_law.as_str() {
            "linear" => SensorLaw::Linear {},
            "cny70" => SensorLaw::Cny70 {},
            "hall" => SensorLaw::Hall { nearest_mm: self.nearest, at_rest: self.nearest_at_rest },
            file => own_table(session, Path::new(file))?,
        })
    }

    fn answer(&self, found: &BTreeMap<usize, Found>) -> Result<Answer, Failure> {
        let keys: Vec<_> = found
            .iter()
            .map(|(key, one)| {
                json!({
                    "key": key,
                    "rest": one.stops.rest,
                    "pressed": one.stops.pressed,
                    "noise": one.noise,
                    "drift": one.drift,
                    "readings": one.count,
                })
            })
            .collect();
        let unlike: Vec<_> =
            unlike(found).into_iter().map(|(key, ratio)| json!({"key": key, "range_to_median": ratio})).collect();
        Answer::of(&json!({"law": self.sensor_law, "travel_mm": self.travel_mm(), "keys": keys, "unlike": unlike}))
    }

    fn tell(&self, session: &mut Session, found: &BTreeMap<usize, Found>) {
        print_line!(session, "{} - {}", shown(self.readings()), many(found.len(), "key"));
        let rows: Vec<Vec<String>> = found
            .iter()
            .map(|(key, one)| {
                vec![
                    key.to_string(),
                    one.stops.rest.to_string(),
                    one.stops.pressed.to_string(),
                    decimal(Some(100.0 * one.noise), 2),
                    decimal(Some(100.0 * one.drift), 2),
                ]
            })
            .collect();
        let table = |rows: Vec<Vec<String>>| Table::of(["key", "rest", "pressed", "noise, %", "drift, %"], rows);
        let places = spaced(rows.len(), FIRST_ROWS);
        if places.len() < rows.len() {
            let some = table(places.iter().map(|at| rows[*at].clone()).collect()).lines();
            Answer::begin_with_part(session, &some, "the stops of every key");
        } else {
            print_line!(session);
        }
        print_line!(session, "{}", table(rows));
        for (key, ratio) in unlike(found) {
            let what = "was it pressed to its bottom, and is its sensor like the others?";
            print_line!(session, "key {key}: its range is {ratio:.2} of the median of all keys; {what}");
        }
    }
}

fn microseconds(text: &str) -> Result<f64, String> {
    let us: f64 = text.trim().parse().map_err(|_| format!("found `{text}`; expected microseconds, such as 500"))?;
    Some(us).filter(|us| (0.0..=1e5).contains(us)).ok_or_else(|| format!("found {text}; expected 0 to 100000 us"))
}

/// A maker's own table: times between two contacts, ms, and hammer speeds, m/s.
pub(super) fn own_speeds(session: &mut Session, path: &Path) -> Result<SpeedTable, Failure> {
    let expected = "CSV with the header `between_ms,hammer_speed_m_per_s`";
    let LawPoints { name, points, lines } = law_points(session, "--contact-table", path, CONTACT_HEAD, expected)?;
    let of = |[between_ms, hammer_speed_m_per_s]: &[f64; 2]| Point {
        between_s: 1e-3 * between_ms,
        hammer_speed_m_per_s: *hammer_speed_m_per_s,
        ..Point::default()
    };
    let points: Vec<Point> = points.iter().map(of).collect();
    SpeedTable::new(&points).map_err(|fault| {
        Failure::Usage(match fault {
            ContactFault::Point(index) => format!("{name}, line {}: {fault}", lines[index]),
            fault => format!("{name}: {fault}"),
        })
    })
}

/// The tables of contacts, and which depths would be better.
fn tell_contacts(session: &mut Session, law: &ContactLaw, keyboard: &str, best: Option<([f64; 2], f64)>) {
    print_line!(session, "{} contacts on key {PRESSED_KEY} of {keyboard}, pressed, struck and re-struck", law.count);
    for (upper, table) in law.tables().iter().enumerate() {
        let ends = table.points().first().zip(table.points().last());
        let ends = ends.map(|(fast, slow)| [fast, slow].map(|one| (1e3 * one.between_s, one.hammer_speed_m_per_s)));
        if let Some([(fast_ms, fast), (slow_ms, slow)]) = ends {
            print_line!(
                session,
                "Contact {} to {}: from {fast_ms:.2} ms, hammer {fast:.2} m/s, to {slow_ms:.2} ms, {slow:.2} m/s.",
                upper + 1,
                law.count
            );
        }
    }
    let own = error_counts(&law.tables[0], law.period_s);
    print_line!(
        session,
        "{}",
        match best {
            Some(([upper_m, lower_m], counts)) if counts < own => format!(
                "Errors are {own:.1} counts rms; contacts at {:.1} and {:.1} mm would err least: {counts:.1}.",
                1e3 * upper_m,
                1e3 * lower_m
            ),
            _ => format!("Errors are {own:.1} counts rms."),
        }
    );
    print_line!(session, "A note ends as contact {} opens.", law.off + 1);
    session.printer.begin_rest("the hammer speeds between contacts, with their errors");
    for (upper, table) in law.tables().iter().enumerate() {
        // Every second one of many.
        let every = table.points().len().div_ceil(13);
        let rows = table.points().iter().step_by(every).map(|point| {
            vec![
                decimal(Some(1e3 * point.between_s), 2),
                decimal(Some(point.hammer_speed_m_per_s), 3),
                decimal(Some(Law::GOEBL.velocity(point.hammer_speed_m_per_s).counts()), 1),
                decimal(Some(1e3 * point.delay_s), 2),
                decimal(Some(point.touch_counts), 1),
                decimal(Some(table.time_counts(point.between_s, law.period_s)), 1),
            ]
        });
        let heads = ["between, ms", "hammer, m/s", "velocity", "impact after, ms", "touch, counts", "time, counts"];
        print_line!(session, "contact {} to {}", upper + 1, law.count);
        print_line!(session, "{}", Table::of(heads, rows.collect::<Vec<_>>()));
    }
}

fn contacts_answer(law: &ContactLaw, best: Option<([f64; 2], f64)>) -> Result<Answer, Failure> {
    let tables = law.tables().iter().enumerate().map(|(upper, table)| {
        let points = table.points().iter().map(|point| {
            json!({
                "between_ms": 1e3 * point.between_s,
                "hammer_speed_m_per_s": point.hammer_speed_m_per_s,
                "delay_ms": 1e3 * point.delay_s,
                "touch_counts": point.touch_counts,
                "time_counts": table.time_counts(point.between_s, law.period_s),
            })
        });
        json!({"from": upper + 1, "points": points.collect::<Vec<_>>()})
    });
    let best = best.map(|(depths_m, counts)| json!({"depths_mm": depths_m.map(|m| 1e3 * m), "error_counts": counts}));
    Answer::of(&json!({
        "contacts": law.count,
        "off": law.off + 1,
        "tables": tables.collect::<Vec<_>>(),
        "error_counts": error_counts(&law.tables[0], law.period_s),
        "best": best,
    }))
}

/// A law of one's own points: readings and millimetres, from the rest to the bottom.
pub(super) fn own_table(session: &mut Session, path: &Path) -> Result<SensorLaw, Failure> {
    let read = law_points(session, "--sensor-law", path, RULER_HEAD, "linear, cny70, hall")?;
    let LawPoints { name, points, lines } = read;
    let (law, averaged, changed) = SensorLaw::of_points(&points).map_err(|fault| {
        let ends = |of: usize| [points.first(), points.last()].map(|point| point.map_or(0.0, |point| point[of]));
        Failure::Usage(match fault {
            LawFault::Travel { index } => {
                let [reading, mm] = points[index];
                let before = index.checked_sub(1).map_or(String::new(), |i| format!(" after {} mm", points[i][1]));
                let expected = "expected millimetres that rise from the rest to the bottom";
                format!("{name}, line {}: reading {reading} at {mm} mm{before}; {expected}", lines[index])
            }
            LawFault::Flat => {
                let ([r0, r1], [x0, x1]) = (ends(0), ends(1));
                format!(
                    "{name}: readings from {r0} at {x0} mm to {r1} at {x1} mm do not rise or fall; expected a sensor that \
                     sees the key move"
                )
            }
            other => format!("{name}: {other}"),
        })
    })?;
    if averaged > 0 {
        print_line!(
            session,
            "{name}: {averaged} of {} readings that do not rise or fall with the others were averaged, by up to {changed:.4}",
            points.len()
        );
    }
    Ok(law)
}
