//! Readings of many keys from CSV: a row for each key; cells may be missing.

use super::entry::{Entry, Known, YES_OR_NO, readings};
use crate::balance::{MeasuredError, rows_of_keys, yes_or_no};
use erard::parameter::NumberError;

/// Reads a table: a header that names `key` (1 to 88, or C4) or `note`, and any of the entries by any of their names,
/// and `leads` (`14@165 14@147`); other columns are ignored. `none` under the check distance means that the hammer is
/// not caught; the repetition spring may be weak, right or strong. Keys are returned in ascending order. `file` appears
/// in errors only.
///
/// # Errors
/// The first error, with line and column.
pub fn read(text: &str, file: &str) -> Result<Vec<(usize, Known)>, MeasuredError> {
    let fault = MeasuredError::in_file(file);
    const HEADER: &str = "key,down_weight_g,up_weight_g,let_off_mm,drop_mm";
    let table = rows_of_keys(text, file, HEADER)?;
    let of = |name: &str| readings().find(|entry| entry.is_called(name));
    let columns: Vec<(usize, &Entry)> =
        table.names.iter().enumerate().filter_map(|(at, name)| Some((at, of(name)?))).collect();
    for (at, (index, entry)) in columns.iter().enumerate() {
        if columns[..at].iter().any(|(_, other)| other.name == entry.name) {
            let expected = "one column of each kind".to_owned();
            return Err(fault(table.header_line, &table.names[*index], "named twice".into(), expected));
        }
    }
    if columns.is_empty() {
        let message = "no column holds a reading that is known".to_owned();
        return Err(fault(table.header_line, "", message, format!("a header such as `{HEADER}`")));
    }
    let mut keys: Vec<(usize, Known)> = Vec::new();
    for row in table.rows {
        let mut known = Known::default();
        for (at, entry) in &columns {
            let cell = row.cells.get(*at).map_or("", String::as_str);
            if !cell.is_empty() {
                known
                    .enter(entry, cell)
                    .map_err(|expected| fault(row.line, &table.names[*at], format!("`{cell}`"), expected))?;
            }
        }
        known.leads = row.leads;
        known
            .settle(row.key)
            .and_then(|()| known.check())
            .map_err(|error| fault(row.line, error.entry, error.what, error.expected))?;
        if !known.is_empty() {
            keys.push((row.key, known));
        }
    }
    if keys.is_empty() {
        return Err(fault(0, "", "no key has a reading".into(), "a row for each key that was measured".into()));
    }
    keys.sort_by_key(|(key, _)| *key);
    Ok(keys)
}

/// Returns the names of the columns of a table that [`read`] does not use, in lower case; empty for a text that is no
/// table.
#[must_use]
pub fn unused_columns(text: &str, file: &str) -> Vec<String> {
    let is_known = |name: &str| readings().any(|entry| entry.is_called(name));
    rows_of_keys(text, file, "key").map_or(Vec::new(), |table| table.unused(is_known))
}

/// Whether the header of a text is that of a table of keys: it names a key or a note, and no time, as strokes do.
#[must_use]
pub fn is_table_of_keys(text: &str) -> bool {
    let is_header = |line: &&str| !line.trim().is_empty() && !line.trim_start().starts_with('#');
    let Some(header) = text.trim_start_matches('\u{feff}').lines().find(is_header) else { return false };
    let names: Vec<String> = header
        .split([',', ';', '\t'])
        .map(|name| name.trim().trim_matches('"').trim().to_lowercase().replace([' ', '-'], "_"))
        .collect();
    let names_a_key = names.iter().any(|name| ["key", "note", "key_number"].contains(&name.as_str()));
    names_a_key && !names.iter().any(|name| name.starts_with("time") || name.starts_with("t_") || name == "t")
}

impl Known {
    /// Enters a reading as typed: a number, with a point or a comma, with or without its unit, or one of the entry's
    /// words.
    ///
    /// # Errors
    /// The expected text.
    pub fn enter(&mut self, entry: &Entry, text: &str) -> Result<(), String> {
        let word = text.trim().to_lowercase();
        if entry.unit == YES_OR_NO {
            let answer = yes_or_no(text).ok_or("yes or no")?;
            self.set(entry.name, Some(f64::from(u8::from(answer))));
            return Ok(());
        }
        match (entry.name, word.as_str()) {
            ("check_mm", "none" | "no") => {
                self.is_not_caught = true;
                return Ok(());
            }
            // The rise from the check as judged by eye, by middle and ends of the usual range: estimates.
            ("repetition_spring_m_per_s", "weak") => self.set(entry.name, Some(0.1)),
            ("repetition_spring_m_per_s", "right") => self.set(entry.name, Some(0.3)),
            ("repetition_spring_m_per_s", "strong") => self.set(entry.name, Some(0.6)),
            _ => {
                let [least, most] = entry.limits;
                let expected = |units: &str| {
                    let words = match entry.name {
                        "check_mm" => ", or none",
                        "repetition_spring_m_per_s" => ", or weak, right, strong",
                        _ => "",
                    };
                    format!("{}{units}{words}", format!("a number from {least} to {most} {}", entry.unit).trim_end())
                };
                match entry.read(text) {
                    Ok(value) if (least..=most).contains(&value) => self.set(entry.name, Some(value)),
                    Ok(_) | Err(NumberError::Text { .. }) => return Err(expected("")),
                    Err(NumberError::Unit { known, .. }) => return Err(expected(&format!(" (units: {known})"))),
                    Err(NumberError::NoUnit { example, .. }) => return Err(format!("a unit, as in `{example}`")),
                    Err(NumberError::Comma { decimal, thousands, .. }) => {
                        return Err(format!("`{decimal}` or `{thousands}`"));
                    }
                    Err(error) => return Err(error.to_string()),
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Notes or numbers, names of every region, decimal commas, words, empty cells.
    #[test]
    fn tables_as_people_write_them() {
        let text = "Note;DW;UW;Set-off;drop;backcheck;spring;wippen weight;leads\nC4;58;18;3,5;0,2;none;weak;18,2;14@165\n41;50;;1,5;;;;;\n";
        let keys = read(text, "a.csv").unwrap();
        let (key, known) = &keys[0];
        assert_eq!((*key, keys[1].0, known.friction_g(), known.get("let_off_mm")), (40, 41, Some(20.0), Some(3.5)));
        assert!(known.is_not_caught && known.get("repetition_spring_m_per_s") == Some(0.1) && known.leads.len() == 1);
        assert_eq!((known.get("whippen_weight_g"), keys[1].1.get("up_weight_g")), (Some(18.2), None));
        assert!(unused_columns(text, "a.csv").is_empty());
        assert_eq!(unused_columns("N,BW,F,colour\n40,38,12,red\n", "a.csv"), ["colour"]);
        assert_eq!(read("N,BW,F\n40,38,12\n", "a.csv").unwrap()[0].1.friction_g(), Some(12.0));
    }

    /// A stroke is no table of keys, though its key's position may be called `key`.
    #[test]
    fn strokes_are_no_tables_of_keys() {
        assert!(is_table_of_keys("# mine\nNote;DW;UW\n") && is_table_of_keys("key,SW\n"));
        assert!(!is_table_of_keys("time_s,key\n") && !is_table_of_keys("t (ms);Key\n") && !is_table_of_keys(""));
    }

    /// Errors state their place.
    #[test]
    fn what_is_wrong_is_named() {
        for (text, told) in [
            ("", "a.csv: the file is empty"),
            ("DW,UW\n1,2\n", "no column says which key"),
            ("key,colour\n1,2\n", "no column holds a reading"),
            ("key,drop\n", "it names no key"),
            ("key,drop\n90,1\n", "`90` is not a key"),
            ("key,drop\n40,1\nC4,1\n", "is already in line 2"),
            ("key,drop\n40,-1\n", "a.csv:2: column `drop`: `-1`; expected a number from 0 to 40 mm"),
            ("key,DW,UW\n40,18,58\n", "are they swapped?"),
            ("key,let-off,set-off\n40,1,1\n", "named twice"),
            ("key,drop\n40,\n", "no key has a reading"),
        ] {
            let error = read(text, "a.csv").unwrap_err().to_string();
            assert!(error.contains(told), "{text:?}: {error}");
        }
    }
}
