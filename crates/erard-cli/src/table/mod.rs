//! The one table: what a command prints, writes (CSV, JSON, Parquet) and puts on pages (HTML), from the same columns.

mod parquet;
mod text;

use std::borrow::Cow;
use std::io::Write;

use erard::run::{Run, column_unit, shortest};
use erard_figures::made_by::MadeBy;
use maud::{Markup, html};
use serde::Serialize;
use serde_json::{Map, Value, json};

pub(crate) use parquet::RowGroups;
use parquet::Values;
pub use text::three;
pub(crate) use text::{MAX_WIDTH, USUAL, decimal, many, wrapped};

/// How the name of a table in text ends.
pub(crate) const TABLE: &str = ".csv";
/// What follows it in the name of the table's metadata: where the W3C's "Metadata Vocabulary for Tabular Data" has
/// programs look.
const METADATA: &str = "-metadata.json";

/// At most so many places out of `count`, evenly spaced, the first and the last among them.
pub(crate) fn spaced(count: usize, most: usize) -> Vec<usize> {
    let shown = most.min(count).max(1);
    (0..shown).map(|k| k * count.saturating_sub(1) / (shown - 1).max(1)).filter(|at| *at < count).collect()
}

/// Name of the metadata of a table.
pub(crate) fn beside(table: &str) -> String {
    format!("{table}{METADATA}")
}

/// Name of the same table as Parquet.
pub(crate) fn as_parquet(table: &str) -> String {
    format!("{}.parquet", table.strip_suffix(TABLE).unwrap_or(table))
}

/// Whether a name is that of a table's metadata.
pub(crate) fn is_beside_a_table(name: &str) -> bool {
    name.strip_suffix(METADATA).is_some_and(|table| table.ends_with(TABLE))
}

/// Columns side by side. One that ends early has empty cells below.
#[derive(Debug, Clone, Default)]
pub struct Table<'a> {
    columns: Vec<(Cow<'a, str>, Cells<'a>)>,
}

#[derive(Debug, Clone)]
enum Cells<'a> {
    All(Cow<'a, [f64]>),
    /// Numbers, some of which are missing.
    Some(Vec<Option<f64>>),
    Words(Vec<String>),
}

impl<'a> Table<'a> {
    /// Its printed lines.
    pub(crate) fn lines(&self) -> Vec<String> {
        self.to_string().lines().map(str::to_owned).collect()
    }

    /// A table of words, row by row: what is printed or shown on a page.
    pub fn of<R: IntoIterator<Item = String>>(
        heads: impl IntoIterator<Item = impl Into<Cow<'a, str>>>,
        rows: impl IntoIterator<Item = R>,
    ) -> Self {
        let mut columns: Vec<_> = heads.into_iter().map(|head| (head.into(), Vec::new())).collect();
        for row in rows {
            columns.iter_mut().zip(row).for_each(|((_, words), cell)| words.push(cell));
        }
        Table { columns: columns.into_iter().map(|(name, words)| (name, Cells::Words(words))).collect() }
    }

    /// A run and columns that go with it.
    pub(crate) fn of_run(run: &'a Run, more: Vec<(String, &'a [f64])>) -> Self {
        run.columns()
            .into_iter()
            .chain(more)
            .fold(Table::default(), |table, (name, values)| table.numbers(name, values))
    }

    /// The fields of serialized records, in their order.
    ///
    /// # Errors
    /// Where a record is none.
    pub(crate) fn of_records(records: &impl Serialize) -> Result<Self, serde_json::Error> {
        let records: Vec<Map<String, Value>> = serde_json::to_value(records).and_then(serde_json::from_value)?;
        let mut table = Table::default();
        for name in records.first().into_iter().flat_map(Map::keys) {
            let values = || records.iter().map(|record| &record[name]);
            table = if values().any(Value::is_string) {
                table.words(name.clone(), values().map(|value| value.as_str().unwrap_or_default()))
            } else {
                table.optional(name.clone(), values().map(Value::as_f64))
            };
        }
        Ok(table)
    }

    /// One column more, of numbers that are all there.
    pub(crate) fn numbers(mut self, name: impl Into<Cow<'a, str>>, values: impl Into<Cow<'a, [f64]>>) -> Self {
        self.columns.push((name.into(), Cells::All(values.into())));
        self
    }

    /// One column more, of numbers of which some are missing or not finite: empty cells.
    pub fn optional(mut self, name: impl Into<Cow<'a, str>>, values: impl IntoIterator<Item = Option<f64>>) -> Self {
        let values = values.into_iter().map(|value| value.filter(|x| x.is_finite())).collect();
        self.columns.push((name.into(), Cells::Some(values)));
        self
    }

    /// One column more, of words.
    pub fn words<W: Into<String>>(mut self, name: impl Into<Cow<'a, str>>, words: impl IntoIterator<Item = W>) -> Self {
        self.columns.push((name.into(), Cells::Words(words.into_iter().map(Into::into).collect())));
        self
    }

    fn heads(&self) -> impl Iterator<Item = &str> {
        self.columns.iter().map(|(name, _)| name.as_ref())
    }

    fn rows(&self) -> usize {
        let lengths = self.columns.iter().map(|(_, cells)| match cells {
            Cells::All(all) => all.len(),
            Cells::Some(some) => some.len(),
            Cells::Words(words) => words.len(),
        });
        lengths.max().unwrap_or(0)
    }

    /// As CSV, every number in its shortest form that reads back as the same number.
    ///
    /// # Errors
    /// Of the writer.
    pub(crate) fn write_csv(&self, writer: &mut dyn Write) -> std::io::Result<()> {
        let mut csv = csv::Writer::from_writer(writer);
        csv.write_record(self.heads())?;
        let mut text = String::new();
        for row in 0..self.rows() {
            for (_, cells) in &self.columns {
                text.clear();
                cells.write(row, &mut text);
                csv.write_field(&text)?;
            }
            csv.write_record(None::<&[u8]>)?;
        }
        csv.flush()
    }

    /// As Parquet, with the title as the name of its rows' type. An empty cell is null.
    ///
    /// # Errors
    /// Of the writer.
    pub(crate) fn write_parquet(&self, title: &str, made_by: &MadeBy, writer: &mut dyn Write) -> std::io::Result<()> {
        let rows = self.rows();
        let columns = self.columns.iter().map(|(name, cells)| {
            let is_there = |row: usize| match cells {
                Cells::Words(words) => words.get(row).is_some_and(|word| !word.is_empty()),
                _ => cells.number(row).is_some(),
            };
            let values = match cells {
                Cells::All(all) => Values::Numbers(Cow::Borrowed(&all[..])),
                Cells::Some(some) => Values::Numbers(some.iter().copied().flatten().collect()),
                Cells::Words(words) => {
                    Values::Words(words.iter().filter(|word| !word.is_empty()).map(|word| word[..].into()).collect())
                }
            };
            (name.as_ref(), values, (0..rows).map(|row| i16::from(is_there(row))).collect())
        });
        parquet::write(title, made_by, &columns.collect::<Vec<_>>(), writer)
    }

    /// Its columns by their names: null where a cell is empty.
    pub(crate) fn json(&self) -> Value {
        let column = |cells: &Cells<'_>| (0..self.rows()).map(|row| cells.json(row)).collect::<Value>();
        self.columns.iter().map(|(name, cells)| (name.to_string(), column(cells))).collect::<Map<_, _>>().into()
    }

    /// What a CSV cannot say of itself, in the W3C's vocabulary for tables on the web (CSVW): the units of its columns.
    /// What made it is added where it is written.
    pub(crate) fn metadata(&self, name: &str) -> Value {
        let column = |title: &str| match column_unit(title) {
            "1" => json!({"titles": title}),
            unit => json!({"titles": title, "datatype": "number", "schema:unitText": unit}),
        };
        let columns: Vec<Value> = self.heads().map(column).collect();
        json!({"@context": "http://www.w3.org/ns/csvw", "url": name, "tableSchema": {"columns": columns}})
    }

    /// Its rows of a page; numbers at the right.
    pub(crate) fn html(&self) -> Markup {
        let columns = self.shown();
        let class = |column: &text::Shown<'_>| column.right.then_some("n");
        html! {
            thead { tr { @for column in &columns {
                @if column.head.is_empty() { td {} } @else { th class=[class(column)] scope="col" { (column.head) } }
            } } }
            tbody {
                @for row in 0..self.rows() {
                    @if text::is_heading(&columns, row) {
                        tr.group { th colspan=(columns.len()) { (columns[0].cells[row].trim()) } }
                    } @else { tr {
                        @for column in columns.iter().take(1) { th class=[class(column)] scope="row" { (column.cells[row]) } }
                        @for column in columns.iter().skip(1) { td class=[class(column)] { (column.cells[row]) } }
                    } }
                }
            }
        }
    }
}

impl Cells<'_> {
    fn number(&self, row: usize) -> Option<f64> {
        match self {
            Cells::All(all) => all.get(row).copied(),
            Cells::Some(some) => some.get(row).copied().flatten(),
            Cells::Words(_) => None,
        }
    }

    fn write(&self, row: usize, text: &mut String) {
        match self {
            Cells::Words(words) => text.push_str(words.get(row).map_or("", String::as_str)),
            _ => self.number(row).into_iter().for_each(|x| shortest(x, text)),
        }
    }

    fn json(&self, row: usize) -> Value {
        match self {
            Cells::Words(words) => words.get(row).filter(|word| !word.is_empty()).cloned().into(),
            _ => match self.number(row) {
                // As a reader of the CSV has it: a whole number without a point.
                Some(x) if x.fract() == 0.0 && x.abs() < 1e9 => (x as i64).into(),
                number => number.into(),
            },
        }
    }
}
