//! The report of `erard check` on a recording: its channels, and last the columns that are used and not used.

use erard::stroke::{Column, Cursor, Dialect, PositionOf, PositionSeries, ROLES, Recording, Role, Series};
use erard_workshop::compare::MAX_DURATION_S;
use serde_json::{Value, json};

use super::checked::checked;
use crate::print_line;
use crate::recordings::Ready;
use crate::session::Session;
use crate::small_plot;

/// Says what a recording is, and answers with it.
pub(super) fn told(session: &mut Session, ready: &Ready) -> Value {
    let Ready { name, recording, prepared, position_of } = ready;
    let (start_s, end_s) = (prepared.series.start_s(), prepared.series.end_s());
    let rows = recording.time_s.len();
    print_line!(session, "{name}: a stroke of {rows} rows, {start_s} to {end_s} s");
    print_line!(session);
    let steps = recording.time_s.windows(2).map(|t| t[1] - t[0]);
    let (shortest, longest) = steps.fold((f64::INFINITY, 0.0_f64), |(a, b), x| (a.min(x), b.max(x)));
    print_line!(session, "  time          sampled every {:.4} to {:.4} ms", shortest * 1e3, longest * 1e3);
    if end_s - start_s > MAX_DURATION_S {
        print_line!(
            session,
            "                longer than `compare` takes: `--duration {MAX_DURATION_S}` compares its first {MAX_DURATION_S} s"
        );
    }
    for channel in &prepared.report.channels {
        let (factor, unit) = channel.role.quantity().shown();
        let (low, high) = channel.range;
        print_line!(session, "  {:<12}  {:.4} to {:.4} {unit}", channel.role.name(), low * factor, high * factor);
    }
    let warnings = prepared.report.warnings();
    for warning in &warnings {
        print_line!(session, "  warning: {warning}");
    }
    told_columns(session, recording, *position_of);
    session.printer.begin_rest("the table's form, and of each channel its zero, its noise, its low-pass and its curve");
    let Dialect { separator, decimal_comma, skipped_rows } = recording.dialect;
    let separated = match separator {
        Some(',') => "separated by commas",
        Some(';') => "separated by semicolons",
        Some('\t') => "separated by tabulators",
        Some(_) => "text",
        None => "Parquet",
    };
    let decimals = if decimal_comma { ", decimal commas" } else { "" };
    let skipped = match skipped_rows {
        0 => String::new(),
        rows => format!(", {rows} rows above the header skipped"),
    };
    print_line!(session, "  table         {separated}{decimals}{skipped}");
    for channel in &prepared.report.channels {
        print_line!(session, "  {}", channel.role.name());
        let lines = channel.lines().into_iter().chain(picture(&prepared.series, channel.role, start_s, end_s));
        for line in lines {
            print_line!(session, "                {line}");
        }
    }
    let column = |c: &Column| json!({"role": c.role.name(), "title": c.title, "unit": c.unit});
    let mut checked = checked("stroke", name, None, [("rows", rows)]);
    checked["stroke"] = json!({
        "start_s": start_s,
        "end_s": end_s,
        "position_of": position_of.name(),
        "columns": recording.layout.columns.iter().map(column).collect::<Value>(),
        "not_used": recording.layout.unused,
        "channels": prepared.report.json(),
        "warnings": warnings,
    });
    checked
}

/// A channel over the whole stroke, the way it drives: up is up.
fn picture(series: &Series, role: Role, start_s: f64, end_s: f64) -> Vec<String> {
    let time = |n: usize| start_s + (end_s - start_s) * n as f64 / (small_plot::COLUMNS - 1) as f64;
    let path = |s: &Option<PositionSeries>| {
        let drive = s.as_ref()?.drive();
        Some((0..small_plot::COLUMNS).map(|n| drive(time(n))[0]).collect::<Vec<f64>>())
    };
    let values = match role {
        Role::Force => series.force.as_ref().map(|s| {
            let drive = s.drive();
            (0..small_plot::COLUMNS).map(|n| drive(time(n))).collect()
        }),
        Role::Position => path(&series.position),
        Role::HammerHead => path(&series.hammer_head),
        Role::HammerSpeed => series.hammer_speed.as_ref().map(|s| {
            let mut cursor = Cursor::default();
            (0..small_plot::COLUMNS).map(|n| s.at(time(n), &mut cursor)).collect()
        }),
        Role::Time => None,
    };
    values.map(|values| small_plot::lines(&values)).unwrap_or_default()
}

/// Columns without use that are named.
const MAX_UNUSED: usize = 12;
/// Letters of a title that are shown.
const MAX_TITLE_LENGTH: usize = 60;

/// The columns that are used and those that are not, with what to type for them.
fn told_columns(session: &mut Session, recording: &Recording, position_of: PositionOf) {
    let layout = &recording.layout;
    print_line!(session);
    print_line!(session, "  columns used");
    for column in &layout.columns {
        let whose = match column.role {
            Role::Position => format!(", the {}'s", position_of.name()),
            _ => String::new(),
        };
        print_line!(
            session,
            "  {:<12}  column {}, `{}`, in {}{whose}",
            column.role.name(),
            column.index + 1,
            column.title,
            column.unit
        );
    }
    if layout.unused.is_empty() {
        print_line!(session, "  columns not used: none");
        return;
    }
    let short = |title: &String| title.chars().take(MAX_TITLE_LENGTH).collect::<String>();
    let unused: Vec<String> =
        layout.unused.iter().take(MAX_UNUSED).map(|title| format!("`{}`", short(title))).collect();
    let more = match layout.unused.len() - unused.len() {
        0 => String::new(),
        more => format!(" and {more} more (--json names all)"),
    };
    print_line!(session, "  columns not used: {}{more}", unused.join(", "));
    let example = short(&layout.unused[0]);
    let free: Vec<&str> = ROLES
        .iter()
        .filter(|role| layout.columns.iter().all(|column| column.role != **role))
        .map(|role| role.name())
        .collect();
    let instead = layout.columns.last().map_or("position", |column| column.role.name());
    let name = free.first().copied().unwrap_or(instead);
    print_line!(session, "  to use one, give its meaning, title and unit:");
    print_line!(session, "    --columns '{name}={example}:{}'", example_unit(name));
    if free.len() > 1 {
        print_line!(session, "  no column yet for {}", free.join(", "));
    }
}

/// A unit that a quantity of this name may have.
fn example_unit(name: &str) -> &'static str {
    match name {
        "time" => "ms",
        "force" => "N",
        "hammer_speed" => "m/s",
        _ => "mm",
    }
}
