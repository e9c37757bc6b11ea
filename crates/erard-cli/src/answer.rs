//! The answer of a command: what it found, which files it wrote, and whether that is what was asked for.

use std::path::PathBuf;

use serde::Serialize;
use serde_json::{Map, Value};

use crate::failure::Failure;
use crate::inputs::shown;
use crate::output::Written;
use crate::session::Session;
use crate::table::Table;

/// What a command answers. Its words have been printed by then, its files written; with `--json` the answer is printed
/// instead of the words.
#[derive(Debug, Default)]
pub struct Answer {
    fields: Map<String, Value>,
    /// A text that is printed as it is, such as a built-in file.
    text: Option<String>,
    written: Vec<PathBuf>,
    shortfall: Option<String>,
}

impl Answer {
    /// The fields of a record.
    ///
    /// # Errors
    /// [`Failure::Internal`] where it is no record, or nothing that JSON can hold.
    pub fn of(record: &impl Serialize) -> Result<Self, Failure> {
        match serde_json::to_value(record)? {
            Value::Object(fields) => Ok(Answer { fields, ..Answer::default() }),
            other => Err(Failure::Internal(format!("an answer is a record; found {other}"))),
        }
    }

    /// A text that is printed as it is; with `--json`, the answer's `text`.
    pub fn text(text: impl Into<String>) -> Self {
        Answer { text: Some(text.into()), ..Answer::default() }
    }

    /// A table by its columns, as `table`; `None` where the answer is in the files alone. It is made only where JSON is
    /// wanted: a study has millions of rows.
    pub(crate) fn table(session: &Session, table: Option<&Table<'_>>) -> Self {
        let table = table.filter(|_| session.printer.wants_json()).map_or(Value::Null, Table::json);
        Answer::default().field("table", table)
    }

    /// Adds a field.
    ///
    /// # Errors
    /// [`Failure::Internal`] where the value is nothing that JSON can hold.
    pub fn with(self, name: &str, value: &impl Serialize) -> Result<Self, Failure> {
        Ok(self.field(name, serde_json::to_value(value)?))
    }

    fn field(mut self, name: &str, value: Value) -> Self {
        self.fields.insert(name.to_owned(), value);
        self
    }

    /// Names the files that were written.
    #[must_use]
    pub fn files(mut self, written: &Written) -> Self {
        self.written.extend(written.paths());
        self
    }

    /// Names files that were rewritten in their place.
    #[must_use]
    pub(crate) fn paths(mut self, written: Vec<PathBuf>) -> Self {
        self.written.extend(written);
        self
    }

    /// Prints the first lines of the answer, made of its fields. What is printed after them is the rest, which comes
    /// with `--full` only; `adds` says what that adds.
    pub(crate) fn begin(&self, session: &mut Session, lines: impl FnOnce(&Value) -> Vec<String>, adds: &str) {
        let fields = Value::Object(self.fields.clone());
        for line in lines(&fields) {
            session.printer.line(line);
        }
        session.printer.begin_rest(adds);
    }

    /// Prints first lines that are a part of the rest, such as some rows of a table: `--full` prints the rest alone.
    pub(crate) fn begin_with_part(session: &mut Session, lines: &[String], adds: &str) {
        if !session.printer.is_full() {
            session.printer.line(String::new());
            lines.iter().for_each(|line| session.printer.line(line.clone()));
        }
        session.printer.begin_rest(adds);
    }

    /// Ends what is printed: which files were written, how to repeat the answer, and what `--full` adds.
    #[must_use]
    pub(crate) fn end(self, session: &mut Session, written: &Written) -> Self {
        Self::end_with(session, |is_whole| if is_whole { written.to_string() } else { written.brief() });
        self.files(written)
    }

    /// Ends what is printed of an answer that wrote no file.
    #[must_use]
    pub(crate) fn end_without_files(self, session: &mut Session) -> Self {
        Self::end_with(session, |_| String::new());
        self
    }

    /// Ends what is printed. `written` names the files, all of them where the whole answer is printed.
    fn end_with(session: &mut Session, written: impl FnOnce(bool) -> String) {
        let left_out = session.printer.end_rest();
        let written = written(left_out.is_none());
        if left_out.is_some() || written.is_empty() {
            session.printer.line(String::new());
        }
        if !written.is_empty() {
            session.printer.line(written);
        }
        let repeat = session.provenance.repeated();
        session.printer.line(repeat);
        if let Some(adds) = left_out {
            session.printer.line(format!("More: --full adds {adds}."));
        }
    }

    /// All was done and written, but it is not what was asked for: exit code 1, with this message.
    #[must_use]
    pub fn short_of(mut self, message: Option<String>) -> Self {
        self.shortfall = message;
        self
    }

    /// How it falls short of what was asked for.
    pub(crate) fn shortfall(&self) -> Option<&str> {
        self.shortfall.as_deref()
    }

    /// The text to print as it is.
    pub(crate) fn verbatim(&self) -> Option<&str> {
        self.text.as_deref()
    }

    /// Its fields, and under `written` the files' names.
    pub(crate) fn json(&self) -> Value {
        let mut all = self.fields.clone();
        if let Some(text) = &self.text {
            all.insert("text".into(), text[..].into());
        }
        all.insert("written".into(), self.written.iter().map(|path| Value::from(shown(path))).collect());
        all.into()
    }
}
