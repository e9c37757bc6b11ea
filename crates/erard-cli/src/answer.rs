//! The answer of a command with `--json`: its own JSON result, or what it names as one, or its table.

use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, PoisonError};

use serde::Serialize;
use serde_json::{Map, Value};

use crate::failure::Failure;
use crate::identity;
use crate::inputs::shown;
use crate::say;
use crate::table::{Table, is_beside_a_table};

/// What there is to answer with.
#[derive(Default)]
struct Answer {
    json: Option<String>,
    table: Option<Value>,
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

/// A text that a command prints as it is, such as a built-in file: with `--json`, the answer's `text`.
///
/// # Errors
/// As [`give`].
pub(crate) fn text(text: &str) -> Result<(), Failure> {
    if say::wants_json() {
        return give(&serde_json::json!({ "text": text }));
    }
    say::verbatim(text);
    Ok(())
}

/// What went wrong, as the answer: nothing was answered before.
pub(crate) fn print_error(message: &str, exit_code: u8) {
    let error = serde_json::json!({ "error": { "message": message, "exit_code": exit_code } });
    if let Ok(text) = serde_json::to_string_pretty(&error) {
        say::verbatim(&format!("{text}\n"));
    }
}

/// Takes a JSON result that is written to a file: it is the answer unless another was given. Metadata of a table are
/// none.
pub(crate) fn offer(name: &str, bytes: &[u8]) {
    if takes(name) {
        let text = || String::from_utf8(bytes.to_vec()).ok();
        let mut answer = answer();
        let json = &mut answer.get_or_insert_default().json;
        *json = json.take().or_else(text);
    }
}

/// Takes a table that is written to a file: it is the answer where no JSON is.
pub(crate) fn offer_table(table: &Table<'_>) {
    if say::wants_json() {
        answer().get_or_insert_default().table.get_or_insert_with(|| table.json());
    }
}

/// Whether a result of this name may be an answer.
pub(crate) fn takes(name: &str) -> bool {
    say::wants_json() && name.ends_with(".json") && !is_beside_a_table(name)
}

/// Remembers which files were written.
pub(crate) fn written(paths: impl Iterator<Item = PathBuf>) {
    if say::wants_json() {
        answer().get_or_insert_default().written.extend(paths);
    }
}

/// Prints the answer, where one is wanted and there is anything to answer.
pub(crate) fn print() {
    let Some(answer) = answer().take() else { return };
    let text = answer.json.or_else(|| {
        let mut all = Map::new();
        all.insert("table".into(), answer.table.unwrap_or(Value::Null));
        all.insert("written".into(), answer.written.iter().map(|path| Value::from(shown(path))).collect());
        let text = serde_json::to_string_pretty(&all).ok()?;
        Some(identity::made_by().in_json(&text))
    });
    if let Some(text) = text {
        say::verbatim(&format!("{}\n", text.trim_end()));
    }
}
