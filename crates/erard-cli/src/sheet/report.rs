//! The sheet for programs.

use serde::Serialize;

use super::{Advised, Task, tasks};

/// What `sheet.json` holds of one action.
#[derive(Debug, Serialize)]
pub(crate) struct Report {
    instrument: String,
    norms_for_key: usize,
    serial: Option<String>,
    date: Option<String>,
    note: Option<String>,
    out_of_the_norm: Vec<&'static str>,
    tasks: Vec<Task>,
}

impl Report {
    /// Of an action.
    pub(crate) fn new(one: &Advised<'_>) -> Self {
        let mut out: Vec<&'static str> = one.measured.sheet.flags.iter().map(|flag| flag.key).collect();
        out.dedup();
        Report {
            instrument: one.measured.label.clone(),
            norms_for_key: one.measured.sheet.norms_for_key,
            serial: one.headed.serial.clone(),
            date: one.headed.date.clone(),
            note: one.headed.note.clone(),
            out_of_the_norm: out,
            tasks: tasks(one),
        }
    }
}
