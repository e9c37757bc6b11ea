//! The technician's sheet: one printed page of an action, in the words of the bench.

mod advised;
mod page;
mod words;

pub(crate) use advised::{AdvisedInstrument, Task};
pub(crate) use page::html;
pub(crate) use words::{ORDER, beyond, in_the_end, left, tasks};

use erard_workshop::worklist::ReadingQuantity;

use crate::measure::headlines::{READ_AGAIN, STAYS_OUT};
use crate::table::Table;
use crate::units::Lengths;
use words::{name, reading, readings};

/// Every line that work can set, before and after the list, as text.
pub(crate) fn before_and_after(one: &AdvisedInstrument<'_>) -> String {
    let (list, lengths) = (&one.list, one.lengths);
    let rows = ReadingQuantity::ALL.into_iter().map(|quantity| {
        let cell = |readings| {
            let mark = if list.is_out(quantity, readings) { " !" } else { "" };
            format!("{}{mark}", reading(quantity, readings, lengths))
        };
        let usual = crate::measure::usual(quantity.line(), list.key, lengths);
        [name(quantity).to_owned(), cell(&list.before), cell(&list.after), usual]
    });
    if list.items.is_empty() {
        return Table::of(["line", "here", "usual"], rows.map(|[line, here, _, usual]| [line, here, usual]))
            .to_string();
    }
    Table::of(["line", "here", "after the list", "usual"], rows).to_string()
}

/// sheet.json.
pub(crate) fn report(one: &AdvisedInstrument<'_>) -> serde_json::Value {
    let (sheet, page_header) = (&one.measured.sheet, one.page_header);
    let mut out: Vec<&str> = sheet.flags.iter().map(|flag| flag.key).collect();
    out.dedup();
    let of = |heading: &str| {
        let lines = left(&one.list, heading, Lengths::default()).into_iter();
        lines.map(|line| serde_json::json!({"key": line.quantity.key(), "why": line.why})).collect::<Vec<_>>()
    };
    serde_json::json!({
        "instrument": one.measured.label,
        "norms_for_key": sheet.norms_for_key,
        "serial": page_header.serial,
        "date": page_header.date,
        "note": page_header.note,
        "out_of_the_norm": out,
        "tasks": tasks(one),
        "readings_before": readings(&one.list.before),
        "readings_after": readings(&one.list.after),
        "not_by_this_list": beyond(sheet),
        "read_again": of(READ_AGAIN),
        "stays_out": of(STAYS_OUT),
    })
}
