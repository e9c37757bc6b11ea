//! A run as a table: CSV and Parquet, the same columns in the same order.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::{Error, Write};
use std::sync::Arc;

use erard::run::{Run, column_unit};
use parquet::basic::Compression;
use parquet::data_type::{DoubleType, Int32Type};
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;
use serde::Serialize;
use serde_json::{Value, json};

use crate::identity;

/// How the name of a table in text ends.
pub(crate) const TABLE: &str = ".csv";
/// What follows it in the name of the table's metadata: where the W3C's "Metadata Vocabulary for Tabular Data" has programs look.
const METADATA: &str = "-metadata.json";

/// Name of the metadata of a table.
pub(crate) fn beside(table: &str) -> String {
    format!("{table}{METADATA}")
}

/// Whether a name is that of a table's metadata.
pub(crate) fn is_beside_a_table(name: &str) -> bool {
    name.strip_suffix(METADATA).is_some_and(|table| table.ends_with(TABLE))
}

/// Writes the run, and columns that go with it, as CSV, every number in its shortest form that reads back as the same number.
///
/// # Errors
/// Of the writer.
pub(crate) fn write_csv(run: &Run, more: &[(String, &[f64])], writer: &mut dyn Write) -> std::io::Result<()> {
    let columns: Vec<(String, &[f64])> = run.columns().into_iter().chain(more.iter().cloned()).collect();
    write_columns(&columns, run.time_s.len(), writer)
}

/// Writes columns as CSV; a column that ends early leaves its cells empty.
///
/// # Errors
/// Of the writer.
pub(crate) fn write_columns(columns: &[(String, &[f64])], rows: usize, writer: &mut dyn Write) -> std::io::Result<()> {
    let heads: Vec<&str> = columns.iter().map(|(name, _)| name.as_str()).collect();
    let cells = |row| columns.iter().map(move |(_, values)| values.get(row).copied());
    write_rows(&heads, (0..rows).map(|row| ([""; 0], cells(row))), writer)
}

/// Writes rows as CSV: first words, then numbers, which may be missing.
///
/// # Errors
/// Of the writer.
pub(crate) fn write_rows<W: AsRef<str>>(
    heads: &[&str],
    rows: impl IntoIterator<Item = (impl IntoIterator<Item = W>, impl IntoIterator<Item = Option<f64>>)>,
    writer: &mut dyn Write,
) -> std::io::Result<()> {
    let mut csv = csv::Writer::from_writer(writer);
    csv.write_record(heads)?;
    let mut text = String::new();
    for (words, numbers) in rows {
        for word in words {
            csv.write_field(word.as_ref())?;
        }
        for number in numbers {
            text.clear();
            if let Some(x) = number {
                shortest(x, &mut text);
            }
            csv.write_field(&text)?;
        }
        csv.write_record(None::<&[u8]>)?;
    }
    csv.flush()
}

/// Appends a number in its shortest form that reads back as the same number.
pub(crate) fn shortest(x: f64, text: &mut String) {
    use std::fmt::Write as _;
    // Writing to a string does not fail.
    let _ = if x != 0.0 && (x.abs() < 1e-4 || x.abs() >= 1e9) { write!(text, "{x:e}") } else { write!(text, "{x}") };
}

/// Three digits that count.
pub(crate) fn three(x: f64) -> String {
    let decimals = (2 - x.abs().max(1e-9).log10().floor() as i32).clamp(0, 3);
    format!("{x:.*}", decimals as usize)
}

/// Writes columns in which values may be missing as CSV: empty cells.
///
/// # Errors
/// Of the writer.
pub(crate) fn write_optional_csv(
    columns: &[(String, Vec<Option<f64>>)],
    writer: &mut dyn Write,
) -> std::io::Result<()> {
    let heads: Vec<&str> = columns.iter().map(|(name, _)| name.as_str()).collect();
    let rows = columns.first().map_or(0, |(_, values)| values.len());
    let cells = |row: usize| columns.iter().map(move |(_, values)| values[row]);
    write_rows(&heads, (0..rows).map(|row| ([""; 0], cells(row))), writer)
}

/// A serialized list as CSV, its fields in their order as columns.
///
/// # Errors
/// Of the writer.
pub(crate) fn write_records(
    rows: impl IntoIterator<Item = impl Serialize>,
    writer: &mut dyn Write,
) -> std::io::Result<()> {
    let mut csv = csv::Writer::from_writer(writer);
    for row in rows {
        csv.serialize(row)?;
    }
    csv.flush()
}

/// Writes the run, and columns that go with it, as Parquet.
///
/// # Errors
/// Of the writer.
pub(crate) fn write_parquet(run: &Run, more: &[(String, &[f64])], writer: &mut dyn Write) -> std::io::Result<()> {
    let rows = run.time_s.len();
    let columns: Vec<ParquetColumn> = run
        .columns()
        .into_iter()
        .chain(more.iter().cloned())
        .map(|(name, values)| (name, values.into(), vec![i16::from(!values.is_empty()); rows]))
        .collect();
    parquet("run", &columns, writer)
}

/// The same for columns in which values may be missing: null.
///
/// # Errors
/// Of the writer.
pub(crate) fn write_optional_parquet(
    title: &str,
    columns: &[(String, Vec<Option<f64>>)],
    writer: &mut dyn Write,
) -> std::io::Result<()> {
    let columns: Vec<ParquetColumn> = columns
        .iter()
        .map(|(name, values)| {
            let there = values.iter().map(|value| i16::from(value.is_some())).collect();
            (name.clone(), values.iter().copied().flatten().collect::<Vec<f64>>().into(), there)
        })
        .collect();
    parquet(title, &columns, writer)
}

/// Name, the values that are there, and for every row whether it has one.
type ParquetColumn<'a> = (String, Cow<'a, [f64]>, Vec<i16>);

/// Columns that count: whole numbers.
const COUNTS: [&str; 4] = ["strikes", "unconverged_steps", "failed", "key"];

/// What a CSV cannot say of itself, in the W3C's vocabulary for tables on the web (CSVW): the units of its columns. What made it is added where it
/// is written.
pub(crate) fn metadata<'a>(name: &str, titles: impl Iterator<Item = &'a str>) -> String {
    let column = |title: &str| {
        let mut column = json!({"titles": title});
        let unit = column_unit(title);
        if unit != "1" {
            column["datatype"] = "number".into();
            column["schema:unitText"] = unit.into();
        }
        column
    };
    let columns: Vec<Value> = titles.map(column).collect();
    let metadata = json!({
        "@context": "http://www.w3.org/ns/csvw",
        "url": name,
        "tableSchema": {"columns": columns},
    });
    format!("{metadata:#}\n")
}

/// One row group, compressed by Snappy, which every reader of Parquet knows: doubles, and whole numbers for what counts. Its metadata hold what made it (`made_by`) and every
/// column's unit (`units`), as JSON.
fn parquet(title: &str, columns: &[ParquetColumn], writer: &mut dyn Write) -> std::io::Result<()> {
    let counts = |name: &str| COUNTS.contains(&name);
    let fields = columns
        .iter()
        .map(|(name, ..)| {
            let kind = if counts(name) { parquet::basic::Type::INT32 } else { parquet::basic::Type::DOUBLE };
            Type::primitive_type_builder(name, kind)
                .with_repetition(parquet::basic::Repetition::OPTIONAL)
                .build()
                .map(Arc::new)
        })
        .collect::<Result<Vec<_>, _>>()
        .map_err(Error::other)?;
    let schema = Type::group_type_builder(title).with_fields(fields).build().map_err(Error::other)?;
    let units: BTreeMap<&str, &str> = columns.iter().map(|(name, ..)| (name.as_str(), column_unit(name))).collect();
    let metadata = vec![
        KeyValue::new("made_by".into(), identity::made_by().json()),
        KeyValue::new("units".into(), serde_json::to_string(&units)?),
    ];
    let properties = WriterProperties::builder()
        .set_dictionary_enabled(false)
        .set_compression(Compression::SNAPPY)
        .set_key_value_metadata(Some(metadata));
    // The library wants a writer that can be sent to another thread; a buffer in between can.
    let mut bytes = Vec::new();
    let mut file =
        SerializedFileWriter::new(&mut bytes, Arc::new(schema), Arc::new(properties.build())).map_err(Error::other)?;
    let mut group = file.next_row_group().map_err(Error::other)?;
    for (name, values, there) in columns {
        let Some(mut column) = group.next_column().map_err(Error::other)? else { break };
        if counts(name) {
            let whole: Vec<i32> = values.iter().map(|value| value.round() as i32).collect();
            column.typed::<Int32Type>().write_batch(&whole, Some(there), None).map_err(Error::other)?;
        } else {
            column.typed::<DoubleType>().write_batch(values, Some(there), None).map_err(Error::other)?;
        }
        column.close().map_err(Error::other)?;
    }
    group.close().map_err(Error::other)?;
    file.close().map_err(Error::other)?;
    writer.write_all(&bytes)
}
