//! A table as Parquet.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::{Error, Write};
use std::sync::{Arc, Mutex, PoisonError};

use erard::run::column_unit;
use erard_figures::made_by::MadeBy;
use parquet::basic::{Compression, LogicalType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int32Type};
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;

/// The values of a column that are there.
pub(super) enum Values<'a> {
    Numbers(Cow<'a, [f64]>),
    Words(Vec<ByteArray>),
}

/// Name, the values that are there, and for every row whether it has one.
pub(super) type ParquetColumn<'a> = (&'a str, Values<'a>, Vec<i16>);

/// Columns that count: whole numbers.
const COUNTS: [&str; 4] = ["impact_count", "unconverged_steps", "failed", "key"];

/// One row group: doubles, whole numbers for what counts, and words.
pub(super) fn write(
    title: &str,
    made_by: &MadeBy,
    columns: &[ParquetColumn<'_>],
    writer: &mut dyn Write,
) -> std::io::Result<()> {
    let names: Vec<&str> = columns.iter().map(|(name, ..)| *name).collect();
    let kinds: Vec<_> = columns.iter().map(|(name, values, _)| (*name, kind(name, values))).collect();
    // The library wants a writer that can be sent to another thread; a buffer in between can.
    let mut bytes = Vec::new();
    let mut file = SerializedFileWriter::new(
        &mut bytes,
        schema(title, &kinds, Repetition::OPTIONAL)?,
        properties(made_by, &names)?,
    )
    .map_err(Error::other)?;
    let mut group = file.next_row_group().map_err(Error::other)?;
    for (name, values, there) in columns {
        let Some(mut column) = group.next_column().map_err(Error::other)? else { break };
        let there = Some(&there[..]);
        match values {
            Values::Words(words) => column.typed::<ByteArrayType>().write_batch(words, there, None),
            Values::Numbers(numbers) if counts(name) => {
                let whole: Vec<i32> = numbers.iter().map(|value| value.round() as i32).collect();
                column.typed::<Int32Type>().write_batch(&whole, there, None)
            }
            Values::Numbers(numbers) => column.typed::<DoubleType>().write_batch(numbers, there, None),
        }
        .map_err(Error::other)?;
        column.close().map_err(Error::other)?;
    }
    group.close().map_err(Error::other)?;
    file.close().map_err(Error::other)?;
    writer.write_all(&bytes)
}

fn counts(name: &str) -> bool {
    COUNTS.contains(&name)
}

fn kind(name: &str, values: &Values<'_>) -> Physical {
    match values {
        Values::Words(_) => Physical::BYTE_ARRAY,
        Values::Numbers(_) if counts(name) => Physical::INT32,
        Values::Numbers(_) => Physical::DOUBLE,
    }
}

fn schema(title: &str, columns: &[(&str, Physical)], repetition: Repetition) -> std::io::Result<Arc<Type>> {
    let fields = columns
        .iter()
        .map(|(name, kind)| {
            let words = (*kind == Physical::BYTE_ARRAY).then_some(LogicalType::String);
            let field = Type::primitive_type_builder(name, *kind).with_logical_type(words);
            field.with_repetition(repetition).build().map(Arc::new)
        })
        .collect::<Result<Vec<_>, _>>()
        .map_err(Error::other)?;
    Ok(Arc::new(Type::group_type_builder(title).with_fields(fields).build().map_err(Error::other)?))
}

/// Compressed by Snappy, which every reader of Parquet knows. The metadata hold what made the file (`made_by`) and
/// every column's unit (`units`), as JSON.
fn properties(made_by: &MadeBy, names: &[&str]) -> std::io::Result<Arc<WriterProperties>> {
    let units: BTreeMap<&str, &str> = names.iter().map(|name| (*name, column_unit(name))).collect();
    let metadata = vec![
        KeyValue::new("made_by".into(), made_by.json()),
        KeyValue::new("units".into(), serde_json::to_string(&units)?),
    ];
    let properties = WriterProperties::builder()
        .set_dictionary_enabled(false)
        .set_compression(Compression::SNAPPY)
        .set_key_value_metadata(Some(metadata));
    Ok(Arc::new(properties.build()))
}

/// What has been written and not been taken yet.
#[derive(Clone, Default)]
struct Taken(Arc<Mutex<Vec<u8>>>);

impl Write for Taken {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

/// A table too long to be held, group of rows by group of rows: no cell is empty. The first column counts.
pub(crate) struct RowGroups<'w> {
    file: SerializedFileWriter<Taken>,
    taken: Taken,
    writer: &'w mut dyn Write,
}

impl<'w> RowGroups<'w> {
    /// # Errors
    /// Of the writer.
    pub(crate) fn new(
        title: &str,
        made_by: &MadeBy,
        names: &[&str],
        writer: &'w mut dyn Write,
    ) -> std::io::Result<Self> {
        let taken = Taken::default();
        let kinds: Vec<_> =
            names.iter().map(|name| (*name, kind(name, &Values::Numbers(Cow::Borrowed(&[]))))).collect();
        let schema = schema(title, &kinds, Repetition::REQUIRED)?;
        let file =
            SerializedFileWriter::new(taken.clone(), schema, properties(made_by, names)?).map_err(Error::other)?;
        Ok(RowGroups { file, taken, writer })
    }

    /// Rows that all have the same number in the first column, and these in the others.
    ///
    /// # Errors
    /// Of the writer.
    pub(crate) fn group(&mut self, first: i32, columns: &[Vec<f64>]) -> std::io::Result<()> {
        let rows = columns.first().map_or(0, Vec::len);
        let mut group = self.file.next_row_group().map_err(Error::other)?;
        if let Some(mut column) = group.next_column().map_err(Error::other)? {
            column.typed::<Int32Type>().write_batch(&vec![first; rows], None, None).map_err(Error::other)?;
            column.close().map_err(Error::other)?;
        }
        for values in columns {
            let Some(mut column) = group.next_column().map_err(Error::other)? else { break };
            column.typed::<DoubleType>().write_batch(values, None, None).map_err(Error::other)?;
            column.close().map_err(Error::other)?;
        }
        group.close().map_err(Error::other)?;
        self.hand_on()
    }

    fn hand_on(&mut self) -> std::io::Result<()> {
        let bytes = std::mem::take(&mut *self.taken.0.lock().unwrap_or_else(PoisonError::into_inner));
        self.writer.write_all(&bytes)
    }

    /// Writes the end.
    ///
    /// # Errors
    /// Of the writer.
    pub(crate) fn finish(mut self) -> std::io::Result<()> {
        self.file.finish().map_err(Error::other)?;
        self.hand_on()
    }
}
