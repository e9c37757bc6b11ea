//! Reading strokes from CSV: a header, then one row per instant.
//!
//! Columns `time_s` and `force_N` and/or `position_m`, and `hammer_head_m` where the hammer was measured too, in any order,
//! among others that are ignored (a run's own `run.csv` is a stroke file too). Comma-separated; sampling may be uneven; lines that start with `#` are comments.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use super::rows::{Place, Row, Rows, excerpt};
use super::{ForceSeries, PositionSeries, SHORTEST_STEP_S, SampleError, Series, StrokeError};
use crate::files::shown;

/// Most rows that are read: more than an hour at 1 kHz.
pub const MAX_ROWS: usize = 5_000_000;
/// Largest force, N: a finger plays fortissimo with less than 50.
pub const MAX_FORCE_N: f64 = 1e4;
/// Largest position, m: a key dips by 0.01.
pub const MAX_POSITION_M: f64 = 1.0;
/// Largest time, s: a day. A larger number is milliseconds, or a calendar.
const MAX_TIME_S: f64 = 86_400.0;

/// A column that means something here.
struct Column {
    name: &'static str,
    /// What the quantity is called too, in columns of another unit or of none.
    stems: &'static [&'static str],
    units: &'static [&'static str],
    largest: f64,
    /// What is expected of a number that is larger.
    hint: &'static str,
}

const TIME: Column = Column {
    name: "time_s",
    stems: &["time", "t"],
    units: TIMES,
    largest: MAX_TIME_S,
    hint: "seconds from the start of the stroke, at most 86400 (milliseconds?)",
};
const FORCE: Column = Column {
    name: "force_N",
    stems: &["force", "f", "load", "finger_force", "key_force"],
    units: FORCES,
    largest: MAX_FORCE_N,
    hint: "newtons, at most 10000 (another unit?)",
};
const POSITION: Column = Column {
    name: "position_m",
    stems: &[
        "position",
        "pos",
        "travel",
        "displacement",
        "depth",
        "dip",
        "key_position",
        "key_travel",
        "key_displacement",
        "key_depth",
        "key_dip",
        "finger_position",
        "finger_travel",
    ],
    units: LENGTHS,
    largest: MAX_POSITION_M,
    hint: "metres, at most 1 (millimetres?)",
};
const HAMMER: Column = Column {
    name: "hammer_head_m",
    stems: &["hammer_head", "hammer_head_position", "hammer_head_travel", "hammer_head_displacement"],
    ..POSITION
};

impl Series {
    /// Reads a stroke file from disk.
    ///
    /// # Errors
    /// The first thing that is wrong, with line and column; also when the file cannot be read.
    pub fn load(path: &Path) -> Result<Self, Box<StrokeError>> {
        Self::read_opened(File::open(path), &shown(path))
    }

    /// Reads a stroke file that has been opened, or says why it could not be; `file_name` appears in errors only.
    ///
    /// # Errors
    /// As [`Series::load`].
    pub fn read_opened(file: std::io::Result<impl Read>, file_name: &str) -> Result<Self, Box<StrokeError>> {
        match file {
            Ok(file) => Self::read(file, file_name),
            Err(error) => {
                Err(Place { file: file_name.to_owned(), line: 0 }.whole_file(format!("cannot be read: {error}"), ""))
            }
        }
    }

    /// Reads the text of a stroke file; `file_name` appears in errors only.
    ///
    /// # Errors
    /// The first thing that is wrong, with line and column.
    pub fn parse(text: &str, file_name: &str) -> Result<Self, Box<StrokeError>> {
        Self::read(text.as_bytes(), file_name)
    }

    /// Reads a stroke file from any reader, a row at a time; `file_name` appears in errors only.
    ///
    /// # Errors
    /// The first thing that is wrong, with line and column.
    pub fn read(reader: impl Read, file_name: &str) -> Result<Self, Box<StrokeError>> {
        let mut rows = Rows::new(reader, file_name);
        let header = match rows.next()? {
            Some(row) => Header::read(row)?,
            None => {
                let expected = "a header `time_s,force_N` or `time_s,position_m`";
                return Err(rows.place().whole_file("the file is empty", expected));
            }
        };
        let header_place = rows.place().clone();
        let mut first_row_place = None;

        let (mut times, mut forces, mut positions, mut heads) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        while let Some(row) = rows.next()? {
            if times.len() == MAX_ROWS {
                let expected = format!("at most {MAX_ROWS} rows: cut the recording or sample it more coarsely");
                return Err(row.place.fault("", "too many rows", format!("more than {MAX_ROWS}"), expected));
            }
            if row.len() != header.width {
                let message = "this row does not fit the header";
                return Err(row.place.fault("", message, count(row.len(), "cell"), count(header.width, "cell")));
            }
            let time = number(row, header.time, &TIME)?;
            match times.last() {
                None => first_row_place = Some(row.place.clone()),
                Some(&previous) => check_order(previous, time, row.place)?,
            }
            times.push(time);
            if let Some(index) = header.force {
                forces.push(number(row, index, &FORCE)?);
            }
            if let Some(index) = header.position {
                positions.push(number(row, index, &POSITION)?);
            }
            if let Some(index) = header.hammer {
                heads.push(number(row, index, &HAMMER)?);
            }
        }
        if times.len() < 2 {
            let (place, message) = match first_row_place {
                None => (header_place, "a header and no rows"),
                Some(place) => (place, "one row is no stroke"),
            };
            return Err(place.fault("", message, count(times.len(), "row"), "two rows or more"));
        }
        // The rows are checked: what the interpolants could still refuse belongs to no line.
        let refused = |error: SampleError| header_place.whole_file(error.to_string(), "");
        let path = |index: Option<usize>, values| match index {
            Some(_) => PositionSeries::new(times.clone(), values).map(Some).map_err(refused),
            None => Ok(None),
        };
        let (position, hammer_head) = (path(header.position, positions)?, path(header.hammer, heads)?);
        let force = match header.force {
            Some(_) => Some(ForceSeries::new(times, forces).map_err(refused)?),
            None => None,
        };
        Ok(Self { force, position, hammer_head })
    }
}

/// Where the known columns stand.
struct Header {
    time: usize,
    force: Option<usize>,
    position: Option<usize>,
    hammer: Option<usize>,
    width: usize,
}

impl Header {
    fn read(row: Row<'_>) -> Result<Self, Box<StrokeError>> {
        let names: Vec<&str> = (0..row.len()).map(|index| row.cell(index)).collect();
        let all_names = || excerpt(&names.join(","));
        if names.len() == 1 && names[0].contains([';', '\t']) {
            let message = "the columns are not separated by commas";
            return Err(row.place.fault("", message, all_names(), "`,` between columns and `.` in numbers"));
        }
        let find = |column: &Column| {
            let mut places = names.iter().enumerate().filter(|(_, name)| **name == column.name).map(|(place, _)| place);
            match (places.next(), places.next()) {
                (Some(_), Some(_)) => {
                    Err(row.place.fault(column.name, "there are two columns of this name", all_names(), "one"))
                }
                (Some(place), None) => Ok(Some(place)),
                (None, _) => match names.iter().find(|name| is_nearly(name, column)) {
                    // Ignoring a column in millimetres would be a trap.
                    Some(near) => {
                        let message = "not the name and unit of a column";
                        Err(row.place.fault(near, message, excerpt(near), format!("`{}`", column.name)))
                    }
                    None => Ok(None),
                },
            }
        };
        let (time, force, position) = (find(&TIME)?, find(&FORCE)?, find(&POSITION)?);
        let Some(time) = time else {
            return Err(row.place.fault(TIME.name, "this column is missing", all_names(), "a header with `time_s`"));
        };
        if force.is_none() && position.is_none() {
            let expected = "`force_N`, `position_m` or both beside `time_s`";
            return Err(row.place.fault(FORCE.name, "there is neither force nor position", all_names(), expected));
        }
        let hammer = find(&HAMMER)?;
        Ok(Self { time, force, position, hammer, width: names.len() })
    }
}

/// Units as people write them, capitals aside; the empty one is a title without a unit.
const TIMES: &[&str] = &[
    "",
    "s",
    "sec",
    "secs",
    "second",
    "seconds",
    "ms",
    "msec",
    "millisecond",
    "milliseconds",
    "us",
    "\u{b5}s",
    "\u{3bc}s",
    "microseconds",
    "ns",
    "min",
    "minutes",
    "h",
    "samples",
];
const FORCES: &[&str] = &[
    "", "n", "newton", "newtons", "kn", "mn", "cn", "dan", "gf", "kgf", "g", "kg", "gram", "grams", "lbf", "lb", "lbs",
    "ozf", "oz", "dyn", "p", "pond",
];
const LENGTHS: &[&str] = &[
    "",
    "m",
    "meter",
    "meters",
    "metre",
    "metres",
    "mm",
    "millimeter",
    "millimeters",
    "millimetre",
    "millimetres",
    "cm",
    "dm",
    "um",
    "\u{b5}m",
    "\u{3bc}m",
    "in",
    "inch",
    "inches",
    "mil",
    "mils",
    "ft",
];

/// Whether a title means a known column but has another name, another unit, none, or other capitals.
fn is_nearly(name: &str, column: &Column) -> bool {
    // `Force (lbf)`, `force.lbf` and `force-lbf` are `force_lbf`.
    let name = name.to_lowercase();
    let words: Vec<&str> = name.split(|c: char| !c.is_alphanumeric()).filter(|word| !word.is_empty()).collect();
    let (last, before) = match words.split_last() {
        Some((last, before)) => (*last, before.join("_")),
        None => return false,
    };
    column.stems.contains(&words.join("_").as_str())
        || (column.stems.contains(&before.as_str()) && column.units.contains(&last))
        // Without anything between them, as in `forceN`; a stem of one letter says nothing then.
        || (before.is_empty()
            && column.stems.iter().any(|stem| stem.len() > 2 && last.strip_prefix(stem).is_some_and(|unit| column.units.contains(&unit))))
}

/// The number in a cell, finite and of sane size.
fn number(row: Row<'_>, index: usize, column: &Column) -> Result<f64, Box<StrokeError>> {
    let text = row.cell(index);
    let fault = |message: &str, expected: &str| {
        let found = if text.is_empty() { "an empty cell".to_owned() } else { excerpt(text) };
        row.place.fault(column.name, message, found, expected)
    };
    let number: f64 = text.parse().map_err(|_| fault("not a number", "a number such as 0.25"))?;
    if !number.is_finite() {
        return Err(fault("not a finite number", "a finite number"));
    }
    if number.abs() > column.largest {
        return Err(fault("too large to be true", column.hint));
    }
    Ok(number)
}

fn check_order(previous: f64, time: f64, place: &Place) -> Result<(), Box<StrokeError>> {
    if time - previous >= SHORTEST_STEP_S {
        return Ok(());
    }
    let message = if time < previous {
        "time goes backwards"
    } else if time == previous {
        "the same time twice"
    } else {
        "two times too close together"
    };
    Err(place.fault(TIME.name, message, format!("{time}"), format!("more than {previous}, the time before it")))
}

/// `1 row`, `2 rows`.
fn count(number: usize, what: &str) -> String {
    format!("{number} {what}{}", if number == 1 { "" } else { "s" })
}
