//! What a command answers with `--json`: its own JSON result, or what it says is one, or its table.

use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, PoisonError};

use serde::Serialize;
use serde_json::{Map, Number, Value};

use crate::failure::Failure;
use crate::identity;
use crate::inputs::shown;
use crate::say;
use crate::table::is_beside_a_table;

/// What there is to answer with.
#[derive(Default)]
struct Answer {
    json: Option<String>,
    table: Option<Vec<u8>>,
    written: Vec<PathBuf>,
}

static ANSWER: Mutex<Option<Answer>> = Mutex::new(None);

fn answer() -> MutexGuard<'static, Option<Answer>> {
    ANSWER.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Takes this as the answer, whatever is written to files.
///
/// # Errors
/// [`Failure::Internal`] where it is nothing that JSON can hold.
pub fn give(value: &impl Serialize) -> Result<(), Failure> {
    if say::wants_json() {
        let text = serde_json::to_string_pretty(value).map_err(|error| Failure::Internal(error.to_string()))?;
        answer().get_or_insert_default().json = Some(identity::made_by().in_json(&text));
    }
    Ok(())
}

/// Takes a result that is written to a file: JSON is the answer unless another was given, a table where there is none.
pub(crate) fn offer(name: &str, bytes: &[u8]) {
    if !say::wants_json() {
        return;
    }
    let mut answer = answer();
    let answer = answer.get_or_insert_default();
    if is_beside_a_table(name) {
        // It tells of the table, and is none of its own.
    } else if name.ends_with(".json") && answer.json.is_none() {
        answer.json = String::from_utf8(bytes.to_vec()).ok();
    } else if name.ends_with(".csv") && answer.table.is_none() {
        answer.table = Some(bytes.to_vec());
    }
}

/// Whether a result of this name may be an answer.
pub(crate) fn takes(name: &str) -> bool {
    say::wants_json() && (name.ends_with(".json") || name.ends_with(".csv"))
}

/// Remembers which files were written.
pub(crate) fn written(paths: &[PathBuf]) {
    if say::wants_json() {
        answer().get_or_insert_default().written.extend(paths.iter().cloned());
    }
}

/// Prints the answer, where one is wanted and there is anything to answer.
pub(crate) fn print() {
    let Some(answer) = answer().take() else { return };
    let text = answer.json.or_else(|| {
        let mut all = Map::new();
        all.insert("table".into(), answer.table.and_then(|table| columns(&table)).unwrap_or(Value::Null));
        all.insert("written".into(), answer.written.iter().map(|path| Value::from(shown(path))).collect());
        let text = serde_json::to_string_pretty(&all).ok()?;
        Some(identity::made_by().in_json(&text))
    });
    if let Some(text) = text {
        say::verbatim(&format!("{}\n", text.trim_end()));
    }
}

/// A table's columns by their names, numbers where they are, null where a cell is empty.
fn columns(table: &[u8]) -> Option<Value> {
    let mut reader = csv::Reader::from_reader(table);
    let names: Vec<String> = reader.headers().ok()?.iter().map(str::to_owned).collect();
    let mut values: Vec<Vec<Value>> = vec![Vec::new(); names.len()];
    for record in reader.records() {
        for (column, cell) in values.iter_mut().zip(&record.ok()?) {
            let number =
                cell.parse::<i64>().ok().map(Number::from).or_else(|| cell.parse().ok().and_then(Number::from_f64));
            column.push(if cell.is_empty() { Value::Null } else { number.map_or_else(|| cell.into(), Value::Number) });
        }
    }
    Some(names.into_iter().zip(values.into_iter().map(Value::from)).collect::<Map<_, _>>().into())
}
