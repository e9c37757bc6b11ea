//! Many actions, one row each.

use erard_workshop::measure::norms::{Line, lines};

use crate::table::{Table, decimal};

/// One action: what it is called, and the values of the lines.
#[derive(Debug, Clone)]
pub(crate) struct MeasuredRow {
    /// Label that distinguishes it from the others.
    pub label: String,
    /// The number of its key; `None` where nobody says.
    pub key: Option<usize>,
    /// Its values, in the order of the lines, `None` for what did not happen; or the reason why it has none.
    pub values: Result<Vec<Option<f64>>, String>,
}

impl MeasuredRow {
    fn value(&self, line: usize) -> Option<f64> {
        self.values.as_ref().ok()?.get(line).copied().flatten()
    }
}

/// What is measured of each where nobody asks for anything else, and how it is page_header.
const USUAL: [(&str, &str); 15] = [
    ("down_weight_g", "D g"),
    ("up_weight_g", "U g"),
    ("balance_weight_g", "BW g"),
    ("friction_weight_g", "F g"),
    ("front_weight_g", "FW g"),
    ("strike_weight_g", "SW g"),
    ("strike_weight_ratio_weights", "R"),
    ("effective_inertia_kg", "inertia kg"),
    ("dip_mm", "dip mm"),
    ("blow_mm", "blow mm"),
    ("let_off_mm", "let-off mm"),
    ("drop_mm", "drop mm"),
    ("check_mm", "check mm"),
    ("repetition_spring_m_per_s", "rise m/s"),
    ("repetition_rate_half_hz", "rep. Hz"),
];

/// The lines of a usual row.
pub(crate) fn usual() -> Vec<&'static Line> {
    USUAL.iter().filter_map(|(key, _)| lines().find(|line| line.key == *key)).collect()
}

fn heading(line: &Line) -> &'static str {
    USUAL.iter().find(|(key, _)| *key == line.key).map_or(line.key, |(_, heading)| heading)
}

/// The table.
pub(crate) fn text(lines: &[&Line], rows: &[MeasuredRow]) -> String {
    let failed = rows.iter().any(|row| row.values.is_err());
    let heads = [""].into_iter().chain(lines.iter().map(|line| heading(line))).chain(failed.then_some(""));
    let cells = rows.iter().map(|row| {
        let values = lines.iter().enumerate().map(|(i, line)| decimal(row.value(i), line.decimals));
        let failed = row.values.as_ref().err().map(|error| format!("failed: {error}"));
        std::iter::once(row.label.clone()).chain(values).chain(failed)
    });
    Table::of(heads, cells).to_string()
}

/// measure.csv.
pub(crate) fn table(lines: &[&Line], rows: &[MeasuredRow]) -> Table<'static> {
    let keys = Table::default().optional("key", rows.iter().map(|row| row.key.map(|key| key as f64)));
    let values = lines
        .iter()
        .enumerate()
        .fold(keys, |table, (i, line)| table.optional(line.key, rows.iter().map(|row| row.value(i))));
    values.words("error", rows.iter().map(|row| row.values.as_ref().err().cloned().unwrap_or_default()))
}

/// The same for programs: a list of objects.
pub(crate) fn json(lines: &[&Line], rows: &[MeasuredRow]) -> serde_json::Value {
    let object = |row: &MeasuredRow| {
        let mut object = serde_json::Map::new();
        object.insert("instrument".into(), row.label.clone().into());
        object.insert("norms_for_key".into(), row.key.into());
        for (i, line) in lines.iter().enumerate() {
            object.insert(line.key.into(), row.value(i).into());
        }
        object.insert("error".into(), row.values.as_ref().err().cloned().into());
        serde_json::Value::Object(object)
    };
    rows.iter().map(object).collect()
}
