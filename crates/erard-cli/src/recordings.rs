//! Recordings from files, text or Parquet, and the options by which they are understood and prepared.

use std::fs::File;
use std::io::{self, Cursor, Read, Seek, SeekFrom, Write};
use std::path::Path;
use std::sync::Arc;

use clap::Args;
use erard::parameter::{Bare, Quantity};
use erard::recording::{LowPass, MAX_LATE_S, Preparation, Prepared, prepare};
use erard::stroke::{Columns, Layout, MAX_BYTES, MAX_ROWS, PositionOf, ROLES, Recording, Role, StrokeError};
use parquet::basic::Type as Physical;
use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::data_type::DataType;
use parquet::file::metadata::ParquetMetaDataReader;
use sha2::{Digest, Sha256};

use crate::failure::Failure;
use crate::inputs::shown;
use crate::names::{Name, one_of};
use crate::session::Session;
use crate::zstandard::column_reader;

/// How a recording is understood and prepared.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Recordings")]
pub(crate) struct RecordingOptions {
    /// Columns of the file by their titles, if they are not found automatically: `time=Time (s),position=Displacement
    /// (mm),force=F [gf],hammer=h`. `#3` is the third column, `x:mm` a column `x` in mm, `none` no column
    #[arg(long, value_name = "NAME=TITLE,..")]
    columns: Option<Columns>,
    /// Which position was recorded, the key's or the fingertip's. The two differ by the compression of the fingertip,
    /// F/k and its damper. `key-back` is for a sensor behind the balance pin; only `compare` drives that point
    /// [default: the key's, unless the column title says otherwise]
    #[arg(long, value_name = "WHOSE", value_parser = one_of(&POSITIONS))]
    position: Option<PositionOf>,
    /// Zero of the channels: `rest` (the mean of the rest before the touch, if there is one), `off` (numbers as they
    /// are in the file), or what a channel reads at its zero, with its unit, e.g. position=0.4mm,force=3gf [default:
    /// rest, but a computed channel, which shows no noise, stays as it is]
    #[arg(long, value_name = "rest|off|CHANNEL=VALUE", value_delimiter = ',', value_parser = zero)]
    zero: Vec<ZeroOf>,
    /// Channels whose sign to reverse: force, position, hammer
    #[arg(long, value_name = "CHANNELS", value_delimiter = ',', value_parser = channel)]
    invert: Vec<Role>,
    /// Delay of a channel behind the others, with its unit, e.g. force=1.5ms; it is removed
    #[arg(long, value_name = "CHANNEL=TIME", value_delimiter = ',', value_parser = delay)]
    delay: Vec<(Role, f64)>,
    /// Low-pass filter (Butterworth, forward and backward, hence without delay): the frequency in Hz at which
    /// amplitudes are halved, `own` (where the noise of each channel begins) or `off`
    #[arg(long, value_name = "HZ|own|off", default_value = "own", value_parser = low_pass)]
    low_pass: LowPass,
    /// Order of the low-pass filter in one pass
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = order)]
    order: usize,
}

impl RecordingOptions {
    /// The same with other titles, where they are given.
    pub(crate) fn with_columns(&self, columns: Option<&Columns>) -> Self {
        RecordingOptions { columns: columns.or(self.columns.as_ref()).cloned(), ..self.clone() }
    }
}

const POSITIONS: [Name<PositionOf>; 3] = [
    (PositionOf::Key.name(), "Front of the key", PositionOf::Key),
    (PositionOf::Fingertip.name(), "Fingertip", PositionOf::Fingertip),
    (PositionOf::KeyBack.name(), "Key behind its balance pin, calibrated at the front", PositionOf::KeyBack),
];

/// Where a zero comes from.
#[derive(Debug, Clone, Copy, PartialEq)]
enum ZeroOf {
    /// From the rest, where a channel shows one.
    Rest,
    /// It is the file's.
    Off,
    /// It was stated, N, m or m/s.
    At(Role, f64),
}

fn zero(text: &str) -> Result<ZeroOf, String> {
    match text.trim() {
        "rest" => Ok(ZeroOf::Rest),
        "off" => Ok(ZeroOf::Off),
        text => {
            let expected = || "expected `rest`, `off`, or a channel and a value, as in position=0.4mm".to_owned();
            let (name, value) = text.split_once('=').ok_or_else(expected)?;
            let role = channel(name)?;
            let value = role.quantity().read(value, Bare::Refused);
            Ok(ZeroOf::At(role, value.map_err(|error| format!("{error}; {}", expected()))?))
        }
    }
}

fn channel(text: &str) -> Result<Role, String> {
    let role = ROLES.into_iter().find(|role| *role != Role::Time && role.name() == text.trim());
    role.ok_or_else(|| "expected force, position, hammer or hammer_speed".to_owned())
}

fn delay(text: &str) -> Result<(Role, f64), String> {
    let expected = || "expected a channel and a time, as in force=1.5ms or position=-0.2ms".to_owned();
    let (name, time) = text.split_once('=').ok_or_else(expected)?;
    let seconds = Quantity::Time.read(time, Bare::Refused).map_err(|error| format!("{error}; {}", expected()))?;
    if seconds.abs() > MAX_LATE_S {
        return Err(format!("expected a time of at most {MAX_LATE_S} s"));
    }
    Ok((channel(name)?, seconds))
}

fn low_pass(text: &str) -> Result<LowPass, String> {
    match text {
        "own" => Ok(LowPass::Own),
        "off" => Ok(LowPass::Off),
        hz => match Quantity::Frequency.read(hz, Bare::Si) {
            Ok(hz) if hz > 0.0 => Ok(LowPass::At(hz)),
            Ok(_) => Err("expected a frequency above 0 Hz, `own` or `off`".to_owned()),
            Err(error) => Err(format!("{error}; or `own` or `off`")),
        },
    }
}

fn order(text: &str) -> Result<usize, String> {
    text.parse().ok().filter(|order| (1..=10).contains(order)).ok_or_else(|| "expected 1 to 10".to_owned())
}

/// A recording and what was made of it.
#[derive(Debug)]
pub(crate) struct Ready {
    /// Its name as messages show it.
    pub name: String,
    /// As it stands in the file, in SI units.
    pub recording: Recording,
    /// Prepared.
    pub prepared: Prepared,
    /// Whose position it is.
    pub position_of: PositionOf,
}

impl RecordingOptions {
    /// Whether any of them is asked for: they belong to files.
    pub(crate) fn are_given(&self) -> bool {
        self.columns.is_some()
            || self.position.is_some()
            || !self.zero.is_empty()
            || !self.invert.is_empty()
            || !self.delay.is_empty()
            || self.low_pass != LowPass::Own
            || self.order != 4
    }

    /// As if none were given.
    pub(crate) fn none() -> Self {
        RecordingOptions {
            columns: None,
            position: None,
            zero: Vec::new(),
            invert: Vec::new(),
            delay: Vec::new(),
            low_pass: LowPass::Own,
            order: 4,
        }
    }

    fn stated_zeros(&self) -> impl Iterator<Item = (Role, f64)> {
        self.zero.iter().filter_map(|zero| match zero {
            ZeroOf::At(role, at) => Some((*role, *at)),
            _ => None,
        })
    }

    /// What is done to a recording.
    pub(crate) fn preparation(&self) -> Preparation {
        Preparation {
            zero: !self.zero.contains(&ZeroOf::Off),
            zero_of_computed: self.zero.contains(&ZeroOf::Rest),
            zero_at: self.stated_zeros().collect(),
            inverted: self.invert.clone(),
            late_s: self.delay.clone(),
            low_pass: self.low_pass,
            order: self.order,
        }
    }

    /// Reads a recording: its name, its rows as they are, and whose position was recorded.
    pub(crate) fn read(&self, session: &mut Session, path: &Path) -> Result<(String, Recording, PositionOf), Failure> {
        let name = shown(path);
        let recording = read(session, path, &name, self.columns.as_ref().unwrap_or(&Columns::default()))?;
        let position_of = self.position_of(&name, &recording)?;
        Ok((name, recording, position_of))
    }

    /// Reads a recording and makes it ready.
    pub(crate) fn load(&self, session: &mut Session, path: &Path) -> Result<Ready, Failure> {
        let (name, recording, position_of) = self.read(session, path)?;
        self.prepared(name, recording, position_of)
    }

    /// The same of a text that is no file.
    pub(crate) fn make_ready(&self, name: &str, text: &[u8]) -> Result<Ready, Failure> {
        let recording = Recording::read(text, name, self.columns.as_ref().unwrap_or(&Columns::default()))?;
        let position_of = self.position_of(name, &recording)?;
        self.prepared(name.to_owned(), recording, position_of)
    }

    /// Whose position was recorded. What is to be done to channels has to be there.
    fn position_of(&self, name: &str, recording: &Recording) -> Result<PositionOf, Failure> {
        for (role, option) in self
            .invert
            .iter()
            .map(|role| (*role, "--invert"))
            .chain(self.delay.iter().map(|(role, _)| (*role, "--delay")))
            .chain(self.stated_zeros().map(|(role, _)| (role, "--zero")))
        {
            if recording.channel(role).is_none() {
                return Err(Failure::Usage(format!("{option} {}: {name} does not have this channel", role.name())));
            }
        }
        Ok(self.position.unwrap_or(recording.position_of))
    }

    fn prepared(&self, name: String, recording: Recording, position_of: PositionOf) -> Result<Ready, Failure> {
        let prepared =
            prepare(&recording, &self.preparation()).map_err(|error| Failure::Usage(format!("{name}: {error}")))?;
        Ok(Ready { name, recording, prepared, position_of })
    }
}

/// What a Parquet file begins with.
const PARQUET: &[u8] = b"PAR1";

/// Reads a recording, of text or Parquet: what the file begins with tells which.
fn read(session: &mut Session, path: &Path, name: &str, columns: &Columns) -> Result<Recording, Box<StrokeError>> {
    let mut file = match session.inputs.open(path) {
        Ok(file) => file,
        Err(error) => {
            if let Some(force) = force(name) {
                let expected = format!("a stroke file; a constant force is --force-step {force}");
                return Err(fault(name, "", format!("cannot be read: {error}"), &expected));
            }
            return Recording::read_opened(Err::<File, _>(error), name, columns);
        }
    };
    let mut head = Vec::new();
    if let Err(error) = (&mut file).take(PARQUET.len() as u64).read_to_end(&mut head) {
        return Recording::read_opened(Err::<File, _>(error), name, columns);
    }
    if head == PARQUET {
        let recording = read_parquet(file.try_clone(), name, columns)?;
        let mut hash = Sha256::new();
        let whole = file
            .seek(SeekFrom::Start(0))
            .and_then(|_| io::copy(&mut file, &mut Hashed { hash: &mut hash, inner: io::empty() }));
        whole.map_err(|error| fault(name, "", format!("cannot be read: {error}"), ""))?;
        session.provenance.used_hashed("recording", name, name, hash);
        return Ok(recording);
    }
    let mut hash = Sha256::new();
    let hashed = Hashed { hash: &mut hash, inner: Cursor::new(head).chain(file) };
    let recording = Recording::read(hashed, name, columns)?;
    session.provenance.used_hashed("recording", name, name, hash);
    Ok(recording)
}

/// The number of a force that was given where a file belongs: `2`, `2N`, `2.5 N`.
fn force(name: &str) -> Option<f64> {
    Quantity::Force.read(name, Bare::Si).ok()
}

/// What is read through it, or written to it, is hashed.
struct Hashed<'a, R> {
    hash: &'a mut Sha256,
    inner: R,
}

impl<R: Read> Read for Hashed<'_, R> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        let count = self.inner.read(out)?;
        self.hash.update(&out[..count]);
        Ok(count)
    }
}

impl<R> Write for Hashed<'_, R> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.hash.update(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// A fault of the file as a whole, or of one of its columns.
fn fault(file: &str, column: &str, message: String, expected: &str) -> Box<StrokeError> {
    Box::new(StrokeError {
        file: file.to_owned(),
        line: 0,
        column: column.to_owned(),
        message,
        found: String::new(),
        expected: expected.to_owned(),
    })
}

fn read_parquet(file: io::Result<File>, name: &str, columns: &Columns) -> Result<Recording, Box<StrokeError>> {
    let unreadable = |error: &dyn std::fmt::Display| fault(name, "", format!("cannot be read as Parquet: {error}"), "");
    let file = file.map_err(|error| unreadable(&error))?;
    let regular = file.metadata().map_err(|error| unreadable(&error))?;
    if !regular.is_file() {
        return Err(fault(name, "", "Parquet cannot be read from a pipe; expected a file".to_owned(), "a file"));
    }
    if regular.len() > MAX_BYTES {
        return Err(fault(name, "", format!("larger than {} MiB", MAX_BYTES >> 20), ""));
    }
    let file = Arc::new(file);
    let metadata = ParquetMetaDataReader::new().parse_and_finish(file.as_ref()).map_err(|error| unreadable(&error))?;
    let rows = usize::try_from(metadata.file_metadata().num_rows()).unwrap_or(0);
    if rows > MAX_ROWS {
        let expected = format!("at most {MAX_ROWS}: cut the recording or sample it more coarsely");
        return Err(fault(name, "", format!("too many rows: {rows}"), &expected));
    }
    let schema = metadata.file_metadata().schema_descr();
    let titles: Vec<String> = schema.columns().iter().map(|column| column.path().string()).collect();
    let titles: Vec<&str> = titles.iter().map(String::as_str).collect();
    let layout = Layout::of(&titles, columns, name)?;
    let mut values: Vec<Vec<f64>> = Vec::new();
    for column in &layout.columns {
        let described = schema.column(column.index);
        let numbers =
            matches!(described.physical_type(), Physical::DOUBLE | Physical::FLOAT | Physical::INT32 | Physical::INT64);
        if !numbers || described.max_rep_level() > 0 {
            return Err(fault(name, &column.title, "not a column of numbers".to_owned(), "one number in every row"));
        }
        let mut all = Vec::with_capacity(rows);
        for group in 0..metadata.num_row_groups() {
            let chunk = metadata.row_group(group).column(column.index);
            if chunk.uncompressed_size() > MAX_BYTES as i64 {
                return Err(fault(name, &column.title, format!("larger than {} MiB", MAX_BYTES >> 20), ""));
            }
            let reader = column_reader(&file, &metadata, group, column.index).map_err(|error| unreadable(&error))?;
            let taken = match reader {
                ColumnReader::DoubleColumnReader(reader) => {
                    take(reader, described.max_def_level(), |x: &f64| *x, &mut all)
                }
                ColumnReader::FloatColumnReader(reader) => {
                    take(reader, described.max_def_level(), |x: &f32| f64::from(*x), &mut all)
                }
                ColumnReader::Int32ColumnReader(reader) => {
                    take(reader, described.max_def_level(), |x: &i32| f64::from(*x), &mut all)
                }
                ColumnReader::Int64ColumnReader(reader) => {
                    take(reader, described.max_def_level(), |x: &i64| *x as f64, &mut all)
                }
                _ => Ok(()),
            };
            taken.map_err(|error| unreadable(&error))?;
        }
        values.push(all);
    }
    let values: Vec<&[f64]> = values.iter().map(Vec::as_slice).collect();
    Recording::from_columns(layout, name, &values)
}

/// Rows that are read at a time.
const PORTION: usize = 65_536;

/// Takes a column's numbers; what is null is not a number.
fn take<T: DataType>(
    mut reader: ColumnReaderImpl<T>,
    there: i16,
    number: impl Fn(&T::T) -> f64,
    all: &mut Vec<f64>,
) -> parquet::errors::Result<()> {
    loop {
        let (mut values, mut levels) = (Vec::new(), Vec::new());
        let of_levels = (there > 0).then_some(&mut levels);
        let (records, ..) = reader.read_records(PORTION, of_levels, None, &mut values)?;
        if records == 0 {
            return Ok(());
        }
        if there == 0 {
            all.extend(values.iter().map(&number));
        } else {
            let mut values = values.iter();
            all.extend(levels.iter().map(|level| {
                let value = if *level == there { values.next() } else { None };
                value.map_or(f64::NAN, &number)
            }));
        }
        if all.len() > MAX_ROWS {
            return Err(parquet::errors::ParquetError::General("more rows than the file says it has".into()));
        }
    }
}
