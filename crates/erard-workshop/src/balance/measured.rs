//! Weights read from a table: one row per key; keys and cells may be missing.

use super::conditions::{Conditions, PLACES_MM, yes_or_no};
use super::equation::{Balance, WeightFault, WeightReadings};
use super::leads::Lead;
use super::rows::{MeasuredError, length, number, ratio, rows_of_keys};

/// Measured weights of a key; `None` if not weighed.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct MeasuredKey {
    /// Number of the key, from 1.
    pub key: usize,
    /// SW, g.
    pub strike_weight_g: Option<f64>,
    /// FW, g.
    pub front_weight_g: Option<f64>,
    /// D, g.
    pub down_weight_g: Option<f64>,
    /// U, g.
    pub up_weight_g: Option<f64>,
    /// WW, g.
    pub whippen_weight_g: Option<f64>,
    /// KR.
    pub key_ratio: Option<f64>,
    /// What springs at the whippen or magnets take off the balance weight, g; `None` for a key without them.
    pub assist_g: Option<f64>,
    /// Aftertouch, mm.
    pub aftertouch_mm: Option<f64>,
    /// Dip, mm.
    pub dip_mm: Option<f64>,
    /// Whether the key was not tapped, so that starting friction is in D and U.
    pub is_untapped: bool,
    /// Leads in the key; empty if not given.
    pub leads: Vec<Lead>,
}

impl MeasuredKey {
    /// BW = (D + U) / 2, g; `None` unless both were measured.
    #[must_use]
    pub fn balance_weight_g(&self) -> Option<f64> {
        self.balance().map(|own| own.balance_weight_g())
    }

    /// F = (D - U) / 2, g; `None` unless both were measured.
    #[must_use]
    pub fn friction_weight_g(&self) -> Option<f64> {
        self.balance().map(|own| own.friction_weight_g())
    }

    /// D and U; `None` unless both were measured.
    pub(super) fn balance(&self) -> Option<Balance> {
        Some(Balance { down_weight_g: self.down_weight_g?, up_weight_g: self.up_weight_g? })
    }
}

/// A column: its name, its other names, and the least and largest value of a cell.
struct Column {
    name: &'static str,
    also: &'static [&'static str],
    limits: [f64; 2],
    unit: &'static str,
    cell: fn(&mut Row) -> &mut Option<f64>,
}

/// Cells of a row.
#[derive(Default)]
struct Row {
    key: MeasuredKey,
    /// BW and F, g: read instead of D and U.
    balance_g: Option<f64>,
    friction_g: Option<f64>,
    conditions: Conditions,
}

const fn column(
    name: &'static str,
    also: &'static [&'static str],
    limits: [f64; 2],
    unit: &'static str,
    cell: fn(&mut Row) -> &mut Option<f64>,
) -> Column {
    Column { name, also, limits, unit, cell }
}

/// Least and largest balance weight that can be read, g: between the limits of D and U.
pub(crate) const BALANCE_LIMITS_G: [f64; 2] = [-25.0, 175.0];
/// Least and largest friction weight that can be read, g.
pub(crate) const FRICTION_LIMITS_G: [f64; 2] = [0.0, 100.0];

/// Least and largest weight that springs or magnets take off, g.
pub(crate) const ASSIST_LIMITS_G: [f64; 2] = [0.0, 60.0];

const COLUMNS: [Column; 12] = [
    column("strike_weight_g", &["strike_weight", "sw", "sw_g"], [1.0, 30.0], "g", |row| &mut row.key.strike_weight_g),
    column("front_weight_g", &["front_weight", "fw", "fw_g"], [-60.0, 100.0], "g", |row| &mut row.key.front_weight_g),
    column("down_weight_g", &["down_weight", "dw", "dw_g", "d"], [0.0, 200.0], "g", |row| &mut row.key.down_weight_g),
    column("up_weight_g", &["up_weight", "uw", "uw_g", "u"], [-50.0, 150.0], "g", |row| &mut row.key.up_weight_g),
    column(
        "whippen_weight_g",
        &["whippen_weight", "wippen_weight_g", "wippen_weight", "ww", "ww_g"],
        [5.0, 50.0],
        "g",
        |row| &mut row.key.whippen_weight_g,
    ),
    column("balance_weight_g", &["balance_weight", "bw", "bw_g"], BALANCE_LIMITS_G, "g", |row| &mut row.balance_g),
    column("friction_weight_g", &["friction_weight", "f", "f_g"], FRICTION_LIMITS_G, "g", |row| &mut row.friction_g),
    column("key_ratio", &["kr"], [0.3, 0.8], "", |row| &mut row.key.key_ratio),
    column("assist_g", &["assist", "spring_assist", "magnets"], ASSIST_LIMITS_G, "g", |row| &mut row.key.assist_g),
    column("aftertouch_mm", &["aftertouch", "after_touch"], [0.0, 10.0], "mm", |row| &mut row.key.aftertouch_mm),
    column("dip_mm", &["dip", "key_dip", "key_depth"], [3.0, 20.0], "mm", |row| &mut row.key.dip_mm),
    column("measured_at_mm", &["measured_at"], PLACES_MM, "mm", |row| &mut row.conditions.measured_at_mm),
];

/// Place of an answer.
type Answer = fn(&mut Conditions) -> &mut Option<bool>;

/// Columns of yes or no.
const ANSWERS: [(&str, Answer); 3] = [
    ("tapped", |conditions| &mut conditions.tapped),
    ("dampers_lifted", |conditions| &mut conditions.dampers_lifted),
    ("stack_on", |conditions| &mut conditions.stack_on),
];

/// Returns the names of the columns of a table that [`read`] does not use, in lower case; empty for a text that is no
/// table.
#[must_use]
pub fn unused_columns(text: &str, file: &str) -> Vec<String> {
    let is_column = |name: &str| COLUMNS.iter().any(|column| column.name == name || column.also.contains(&name));
    let is_known = |name: &str| is_column(name) || ANSWERS.iter().any(|(own, _)| *own == name);
    rows_of_keys(text, file, "key").map_or(Vec::new(), |table| table.unused(is_known))
}

/// Reads a table: a header that names `key` (1 to 88, or C4) or `note` (A0 to C8), and any of `strike_weight_g`,
/// `front_weight_g`, `down_weight_g`, `up_weight_g`, `whippen_weight_g`, `key_ratio`, `leads` (such as `14@165 14@147`:
/// grams at millimetres in front of the balance pin), `aftertouch_mm`, `dip_mm`. `balance_weight_g` and
/// `friction_weight_g` may replace down-weight and up-weight. `assist_g` is what springs at the whippen or magnets take
/// off; `measured_at_mm`, `tapped`, `dampers_lifted` and `stack_on` are the conditions of the weighing. The trade's
/// letters (SW, FW, DW, UW, BW, F, WW, KR) are accepted; other columns are ignored. Cells end at commas, or at
/// semicolons or tabs if the header has one, and then decimals may have commas. Empty cells were not weighed; lines
/// that begin with `#` are comments. Keys are returned in ascending order. `file` appears in errors only.
///
/// # Errors
/// The first error, with line and column.
pub fn read(text: &str, file: &str) -> Result<Vec<MeasuredKey>, MeasuredError> {
    let fault = MeasuredError::in_file(file);
    const HEADER: &str = "key,strike_weight_g,front_weight_g,down_weight_g,up_weight_g";
    let table = rows_of_keys(text, file, HEADER)?;
    let place = |names: &[&str]| {
        let twice =
            |name: String| fault(table.header_line, &name, "named twice".into(), "one column of each kind".into());
        table.column(names).map_err(twice)
    };
    let mut columns: Vec<(usize, &Column)> = Vec::new();
    for column in &COLUMNS {
        let wanted: Vec<&str> = std::iter::once(column.name).chain(column.also.iter().copied()).collect();
        columns.extend(place(&wanted)?.map(|index| (index, column)));
    }
    let mut answers = Vec::new();
    for (name, of) in ANSWERS {
        answers.extend(place(&[name])?.map(|index| (index, of)));
    }
    if columns.is_empty() {
        let expected = format!("a header such as `{HEADER}`");
        return Err(fault(table.header_line, "", "no column holds a weight".into(), expected));
    }
    let mut keys: Vec<MeasuredKey> = Vec::new();
    for row in table.rows {
        let key = MeasuredKey { key: row.key, leads: row.leads, ..MeasuredKey::default() };
        let mut read = Row { key, ..Row::default() };
        for &(index, column) in &columns {
            let text = row.cells.get(index).map_or("", String::as_str);
            if text.is_empty() {
                continue;
            }
            let [least, most] = column.limits;
            let value = match column.unit {
                "" => ratio(text),
                "mm" => length(text),
                _ => number(text),
            };
            let value = value.filter(|value| (least..=most).contains(value)).ok_or_else(|| {
                let expected = format!("a number from {least} to {most} {}", column.unit);
                fault(row.line, &table.names[index], format!("`{text}`"), expected.trim_end().to_owned())
            })?;
            *(column.cell)(&mut read) = Some(value);
        }
        for &(index, of) in &answers {
            let text = row.cells.get(index).map_or("", String::as_str);
            if text.is_empty() {
                continue;
            }
            let wrong = || fault(row.line, &table.names[index], format!("`{text}`"), "yes or no".to_owned());
            *of(&mut read.conditions) = Some(yes_or_no(text).ok_or_else(wrong)?);
        }
        let Row { key: mut measured, balance_g, friction_g, conditions } = read;
        let weights =
            WeightReadings { down_g: measured.down_weight_g, up_g: measured.up_weight_g, balance_g, friction_g };
        let refused = |wrong: WeightFault| fault(row.line, wrong.name, wrong.what, wrong.expected);
        (measured.down_weight_g, measured.up_weight_g) = weights.down_and_up().map_err(refused)?;
        if measured.down_weight_g.or(measured.up_weight_g).is_some() {
            conditions.check_dampers().map_err(refused)?;
            if conditions.stack_on == Some(false) {
                let expected = "weights with the stack on; `erard diagnose` takes these for the key's own friction";
                let what = "down-weight or up-weight with the stack off".to_owned();
                return Err(fault(row.line, "stack_on", what, expected.to_owned()));
            }
        }
        let factor = conditions.factor(row.key);
        for weight in [
            &mut measured.down_weight_g,
            &mut measured.up_weight_g,
            &mut measured.front_weight_g,
            &mut measured.key_ratio,
            &mut measured.assist_g,
        ] {
            *weight = weight.map(|own| own * factor);
        }
        measured.is_untapped = conditions.is_untapped();
        if let (Some(down), Some(up)) = (measured.down_weight_g, measured.up_weight_g)
            && up > down
        {
            let message = format!("an up-weight of {up} g over a down-weight of {down} g");
            return Err(fault(
                row.line,
                "up_weight_g",
                message,
                "no more than the down-weight: are they swapped?".into(),
            ));
        }
        keys.push(measured);
    }
    keys.sort_by_key(|key| key.key);
    Ok(keys)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A column `N` is the key's number; columns that are not used are named.
    #[test]
    fn columns_as_people_have_them() {
        let text = "N;D;U;SW;colour;R\n16;50;25;10,4;red;5,6\n";
        let keys = read(text, "a.csv").unwrap();
        assert_eq!((keys[0].key, keys[0].strike_weight_g), (16, Some(10.4)));
        assert_eq!(unused_columns(text, "a.csv"), ["colour", "r"]);
        assert!(unused_columns("", "a.csv").is_empty());
    }

    /// Commas with points, semicolons with decimal commas, tabs; numbers or notes; empty cells, comments, other
    /// columns.
    #[test]
    fn tables_as_people_write_them() {
        let plain = "# weighed on Monday\nkey,SW,FW,DW,UW,who\n40,8.7,21.2,50,26,me\n1,10.4,,54.5,,\n";
        let keys = read(plain, "a.csv").unwrap();
        assert_eq!((keys.len(), keys[0].key, keys[1].key), (2, 1, 40));
        assert_eq!((keys[0].strike_weight_g, keys[0].front_weight_g, keys[0].up_weight_g), (Some(10.4), None, None));
        assert_eq!((keys[1].down_weight_g, keys[1].up_weight_g), (Some(50.0), Some(26.0)));
        let german = "Note;Strike weight;Front Weight;leads\nC4;8,7;21,2;14@165 14@147,5\nA0;10,4;;\n";
        let keys = read(german, "b.csv").unwrap();
        assert_eq!((keys[0].key, keys[0].strike_weight_g), (1, Some(10.4)));
        assert_eq!(keys[1].leads, [Lead { mass_g: 14.0, at_mm: 165.0 }, Lead { mass_g: 14.0, at_mm: 147.5 }]);
        // Balance weight and friction weight instead of down-weight and up-weight.
        for text in ["key,BW,F\n40,38,12\n", "key,DW,BW\n40,50,38\n", "key;f;Up weight\n40;12,0;26\n"] {
            let keys = read(text, "d.csv").unwrap();
            assert_eq!((keys[0].down_weight_g, keys[0].up_weight_g), (Some(50.0), Some(26.0)), "{text}");
        }
        assert_eq!(read("key\tWW\tKR\n3\t18,5\t0,53\n", "c").unwrap()[0].key_ratio, Some(0.53));
    }

    /// Errors state line, column and what is expected.
    #[test]
    fn what_is_wrong_is_named() {
        for (text, told) in [
            ("", "m.csv: the file is empty"),
            ("SW,FW\n1,2\n", "m.csv:1: no column says which key"),
            ("key,colour\n1,2\n", "no column holds a weight"),
            ("key,SW\n", "it names no key"),
            ("key,SW\n89,8\n", "m.csv:2: column `key`: `89` is not a key"),
            ("note,SW\nH1,8\n", "column `note`: `H1` is not a key"),
            ("key,SW\n1,8\n1,9\n", "m.csv:3: key 1 is already in line 2"),
            ("key,SW\n1,heavy\n", "column `sw`: `heavy`; expected a number from 1 to 30 g"),
            ("key,SW\n1,nan\n", "`nan`"),
            ("key,SW\n1,8700\n", "`8700`"),
            ("key,SW\n1,8,7\n", "3 cells where the header has 2"),
            ("key,SW,FW\n1,8,7\n2,8\n", "m.csv:3: 2 cells where the header has 3: the row is cut short"),
            ("key,SW\n1,\"8\n", "m.csv:2: a quote is not closed on its line"),
            ("key,\"SW\n1,8\n", "m.csv:1: a quote is not closed on its line"),
            ("key,DW,UW\n1,20,50\n", "are they swapped?"),
            ("key,BW\n1,38\n", "m.csv:2: column `balance_weight_g`: a balance weight BW of 38 g alone"),
            ("key,DW,UW,BW\n1,50,26,30\n", "expected 38 g, which follows from these"),
            ("key,SW,leads\n1,8,14g\n", "column `leads`: `14g`"),
            ("key,SW,sw_g\n1,8,8\n", "named twice"),
            ("key,KR\n1,0.5g\n", "column `kr`: `0.5g`; expected a number from 0.3 to 0.8"),
        ] {
            let error = read(text, "m.csv").unwrap_err().to_string();
            assert!(error.contains(told), "{text:?}: {error}");
        }
    }
}
