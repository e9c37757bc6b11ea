//! `erard calibrate`.

use erard::parameter::Quantity;
use std::collections::BTreeMap;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};

use clap::Args;
use erard_live::calibrate::{Found, Readings, stops, unlike};
use erard_live::profile::Profile;
use erard_live::sensor::{Law, LawFault};
use erard_live::stream::{Head, Of, Reader, SensorUnit};
use serde_json::json;

use super::out::OwnFile;
use crate::answer::Answer;
use crate::failure::Failure;
use crate::inputs::shown;
use crate::law_points::{LawPoints, law_points};
use crate::number::between;
use crate::output::Output;
use crate::print_line;
use crate::session::Session;
use crate::table::{Table, decimal};

/// What stands below the options.
const AFTER: &str = include_str!("help/calibrate.txt");

/// Finds the stops of sensed keys: readings to millimetres, for `erard live`.
#[derive(Debug, Args)]
#[command(after_help = AFTER)]
pub(crate) struct Calibrate {
    /// Readings of every key: at rest, pressed and held, let go. CSV with the header `time_s,key,raw`
    #[arg(value_name = "READINGS.csv")]
    readings: PathBuf,
    /// Law of the sensors: linear, cny70, hall, or a file of your own points (CSV with the header `raw,mm`)
    #[arg(long, value_name = "LAW", default_value = "linear")]
    sensor_law: String,
    /// Travel of the sensed place between a key's two stops, mm
    #[arg(long, value_name = "MM", default_value_t = 10.0, value_parser = between(Quantity::Length, "mm", 0.5, 100.0), allow_hyphen_values = true)]
    travel: f64,
    /// Hall sensors: smallest distance to the magnet, mm. The default is an estimate
    #[arg(long, value_name = "MM", default_value_t = 3.0, value_parser = between(Quantity::Length, "mm", 0.1, 100.0), allow_hyphen_values = true)]
    nearest: f64,
    /// Hall sensors: the magnet is nearest while the key is at rest
    #[arg(long)]
    nearest_at_rest: bool,
    /// This device's polyphonic pressure is the key's depth
    #[arg(long)]
    pressure_is_depth: bool,
    /// File of the profile [default: READINGS.toml in this folder]
    #[arg(long, short, value_name = "FILE")]
    out_file: Option<PathBuf>,
    /// Replace FILE if it exists
    #[arg(long)]
    force: bool,
}

impl Calibrate {
    /// Runs the command.
    pub(crate) fn run(&self, session: &mut Session) -> Result<Answer, Failure> {
        let law = self.law(session)?;
        let asked = shown(&self.readings);
        let OwnFile { folder, name } =
            OwnFile::of(session, self.out_file.as_deref(), &asked, ".toml", "profile's", self.force)?;
        let found = stops(&self.read(session)?).map_err(|fault| Failure::Usage(format!("{asked}: {fault}")))?;
        let profile = Profile {
            law,
            travel_m: 1e-3 * self.travel,
            pressure_is_depth: self.pressure_is_depth,
            keys: found.iter().map(|(key, one)| (*key, one.stops)).collect(),
        };
        let mut output = Output::files(session, &folder, self.force, &[&name])?;
        output.text(session, &name, &profile.text())?;
        let written = output.commit(session)?;
        self.tell(session, &found);
        print_line!(session, "{written}");
        Ok(self.answer(&found)?.files(&written))
    }

    /// The readings of all keys.
    fn read(&self, session: &mut Session) -> Result<BTreeMap<usize, Readings>, Failure> {
        let name = shown(&self.readings);
        let wrong = |line: usize, what: String| Failure::Usage(format!("{name}, line {line}: {what}"));
        let unread = |error: std::io::Error| Failure::Usage(format!("{name}: cannot be read: {error}"));
        let file = session.inputs.open(&self.readings).map_err(unread)?;
        let (mut reader, mut keys) = (None, BTreeMap::<usize, Readings>::new());
        for (index, line) in BufReader::new(file).lines().enumerate() {
            let line = line.map_err(unread)?;
            let text = line.trim();
            if text.is_empty() || text.starts_with('#') {
                continue;
            }
            let Some(reader) = &mut reader else {
                let head = Head::parse(text).map_err(|fault| wrong(index + 1, fault.to_string()))?;
                if !matches!(head.quantity, SensorUnit::Raw | SensorUnit::Pressure) {
                    return Err(wrong(index + 1, format!("found `{text}`; expected a reading, `time_s,key,raw`")));
                }
                reader = Some(Reader::new(head));
                continue;
            };
            let sample = reader.line(text).map_err(|fault| wrong(index + 1, fault.to_string()))?;
            if let Some(sample) = sample
                && let Of::Key(key) = sample.of
            {
                let all = &mut keys.entry(key).or_default().all;
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
        Ok(keys)
    }

    fn law(&self, session: &mut Session) -> Result<Law, Failure> {
        Ok(match self.sensor_law.as_str() {
            "linear" => Law::Linear {},
            "cny70" => Law::Cny70 {},
            "hall" => Law::Hall { nearest_mm: self.nearest, at_rest: self.nearest_at_rest },
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
        Answer::of(&json!({"law": self.sensor_law, "travel_mm": self.travel, "keys": keys, "unlike": unlike}))
    }

    fn tell(&self, session: &mut Session, found: &BTreeMap<usize, Found>) {
        print_line!(session, "{} - {} keys", shown(&self.readings), found.len());
        print_line!(session);
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
        print_line!(session, "{}", Table::of(["key", "rest", "pressed", "noise, %", "drift, %"], rows));
        for (key, ratio) in unlike(found) {
            let what = "was it pressed to its bottom, and is its sensor like the others?";
            print_line!(session, "key {key}: its range is {ratio:.2} of the median of all keys; {what}");
        }
    }
}

/// A law of one's own points: readings and millimetres, from the rest to the bottom.
fn own_table(session: &mut Session, path: &Path) -> Result<Law, Failure> {
    let read = law_points(session, "--sensor-law", path, "raw,mm", "linear, cny70, hall")?;
    let LawPoints { name, points, lines } = read;
    let (law, averaged, changed) = Law::of_points(&points).map_err(|fault| {
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
