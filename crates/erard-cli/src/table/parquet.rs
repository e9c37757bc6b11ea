//! A table as Parquet.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::{Error, Write};
use std::sync::Arc;

use erard::run::column_unit;
use parquet::basic::Compression;
use parquet::data_type::{DoubleType, Int32Type};
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;

use crate::identity;

/// Name, the values that are there, and for every row whether it has one.
pub(super) type ParquetColumn<'a> = (&'a str, Cow<'a, [f64]>, Vec<i16>);

/// Columns that count: whole numbers.
const COUNTS: [&str; 4] = ["strikes", "unconverged_steps", "failed", "key"];

/// One row group, compressed by Snappy, which every reader of Parquet knows: doubles, and whole numbers for what
/// counts. Its metadata hold what made it (`made_by`) and every column's unit (`units`), as JSON.
pub(super) fn write(title: &str, columns: &[ParquetColumn<'_>], writer: &mut dyn Write) -> std::io::Result<()> {
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
    let units: BTreeMap<&str, &str> = columns.iter().map(|(name, ..)| (*name, column_unit(name))).collect();
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
