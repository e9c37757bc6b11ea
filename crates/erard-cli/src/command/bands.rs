//! Values with their 5 to 95 % bands over many samples of an instrument.

use clap::Args;
use erard::instrument::Instrument;
use erard::instrument_spec::InstrumentSpec;
use erard_workshop::sample::{self, Band, SampleError, SampleValues, failures};
use serde::Serialize;

use crate::cache;
use crate::failure::Failure;
use crate::instruments::{not_one_sample, samples};
use crate::number::whole;
use crate::output::Output;
use crate::session::Session;
use crate::table::{Table, three};
use crate::warn;

/// Whether values have bands.
#[derive(Debug, Clone, Copy, Args)]
pub(crate) struct BandOptions {
    /// Give each value its 5 to 95 % band over this many random grands, drawn within the spreads of the instrument
    /// file, then regulated and weighed to the usual ranges. The first time takes minutes; the grands are kept in the
    /// user's cache folder [default without a number: 200]
    #[arg(
        long,
        value_name = "SAMPLES",
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = "200",
        value_parser = whole::<u32>(2, 10_000)
    )]
    pub bands: Option<u32>,
}

impl BandOptions {
    /// Refuses bands of one sample before that sample is drawn, which takes seconds.
    pub(crate) fn check(self, asked: &InstrumentSpec) -> Result<(), Failure> {
        self.bands.map_or(Ok(()), |_| not_one_sample(asked))
    }
}

/// A value of the instrument itself, and its band.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct BandRow {
    pub name: String,
    pub unit: String,
    pub value: Option<f64>,
    pub low: Option<f64>,
    pub high: Option<f64>,
    /// In so many samples it came about.
    pub samples: usize,
}

impl BandRow {
    fn new(name: String, unit: String, value: Option<f64>, band: Option<Band>) -> Self {
        let (low, high) = (band.map(|band| band.low), band.map(|band| band.high));
        BandRow { name, unit, value, low, high, samples: band.map_or(0, |band| band.samples) }
    }
}

/// Values with their bands, and the samples that are missing in them.
#[derive(Debug)]
pub(crate) struct Banded {
    pub rows: Vec<BandRow>,
    pub failed: Vec<FailedSample>,
}

/// A sample without some of its values, or without any.
#[derive(Debug, Serialize)]
pub(crate) struct FailedSample {
    /// Its number, from 1.
    pub sample: u32,
    /// Why.
    pub error: String,
}

/// Name of the table of samples that failed.
const FAILED: &str = "failed-samples.csv";

impl Banded {
    /// Stages the table of samples that failed, if some did.
    pub(crate) fn stage_failed(&self, session: &Session, output: &mut Output) -> Result<(), Failure> {
        if self.failed.is_empty() {
            return Ok(());
        }
        output.table(session, FAILED, &Table::of_records(&self.failed)?)
    }

    /// Stages `bands.csv` and `bands.json`, and the samples that failed.
    pub(crate) fn stage(&self, session: &Session, output: &mut Output) -> Result<(), Failure> {
        output.json(session, "bands.json", &self.rows)?;
        output.table(session, "bands.csv", &Table::of_records(&self.rows)?)?;
        self.stage_failed(session, output)
    }
}

/// What a value is called, and its unit.
pub(crate) type NameAndUnit = (String, String);

/// Values of the instrument that was asked for, with their bands over its first samples. `values` finds them in an
/// instrument, in one order; what it finds of a sample is kept as `kind` with what else it depends on, unless that is
/// nothing. Samples without values are left out of the bands, with a warning that gives the reason.
pub(crate) fn bands(
    session: &mut Session,
    asked: &InstrumentSpec,
    count: u32,
    names: &[NameAndUnit],
    own: &[Option<f64>],
    kept: Option<(&str, &str)>,
    values: impl Fn(&Instrument, &str, &mut erard::Progress<'_>) -> Result<SampleValues, SampleError> + Sync,
) -> Result<Banded, Failure> {
    let samples = samples(session, asked)?;
    let file_name = asked.to_string();
    let mut progress = session.progress("sampling");
    let found = samples.each(count, &mut progress, |_, text, progress| {
        let known = kept.and_then(|(kind, of)| serde_json::from_str(&cache::get(kind, &[of, text])?).ok());
        // A sample that an earlier version kept without any value is tried again for its reason.
        let is_whole = |known: &Vec<Option<f64>>| known.len() == names.len() && known.iter().any(Option::is_some);
        if let Some(known) = known.filter(is_whole) {
            return Ok(Ok(known).into());
        }
        let instrument = Instrument::parse(text, &file_name)?;
        let values = values(&instrument, text, progress)?;
        if let (Some((kind, of)), None) = (kept, &values.error)
            && let Ok(json) = serde_json::to_string(&values.values)
        {
            cache::put(kind, &[of, text], &json);
        }
        Ok(values)
    })?;
    drop(progress);
    failures(&found).iter().for_each(|line| warn!(session, "warning: {line}"));
    let rows = names.iter().zip(own).zip(sample::bands(&found, names.len()));
    let rows = rows.map(|(((name, unit), own), band)| BandRow::new(name.clone(), unit.clone(), *own, band)).collect();
    let failed =
        (1..).zip(found).filter_map(|(sample, one)| Some(FailedSample { sample, error: one.error? })).collect();
    Ok(Banded { rows, failed })
}

/// The rows for people.
pub(crate) fn lines(rows: &[BandRow], count: u32) -> Vec<String> {
    let number = |x: Option<f64>| x.map_or_else(|| "-".to_owned(), three);
    let cells = rows.iter().map(|row| {
        let few = if row.samples < count as usize { format!("in {} of {count}", row.samples) } else { String::new() };
        [row.name.clone(), number(row.value), number(row.low), number(row.high), row.unit.clone(), few]
    });
    Table::of(["", "value", "5 %", "95 %", "", ""], cells).lines()
}
