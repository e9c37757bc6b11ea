//! The wrong place in a file: its line between its neighbours, underlined.

use std::fmt::Write;

use erard::instrument::FileError;

use crate::table::{WIDEST, wrapped};

/// Longest line that is shown, bytes: more would bury the message.
const LONGEST_LINE: usize = 400;

/// Draws the place of an error; `None` where the error belongs to no line, or a line there is longer than a terminal
/// can show.
pub(crate) fn excerpt(error: &FileError) -> Option<String> {
    let wrong = error.line.checked_sub(1)?;
    let lines: Vec<&str> = error.text.lines().collect();
    let shown = wrong.saturating_sub(1)..lines.len().min(wrong + 2);
    if !shown.contains(&wrong) || lines[shown.clone()].iter().any(|line| line.len() > LONGEST_LINE) {
        return None;
    }
    let room = shown.end.to_string().len();
    let margin = " ".repeat(room + 2);
    let mut out = format!("  × {}\n{margin}╭─[{}:{}:{}]\n", error.message, error.file, error.line, error.column);
    for (number, line) in shown.clone().zip(&lines[shown]) {
        // A tab is as wide as one character, so that the mark stands below its place.
        let line = line.replace('\t', " ");
        // Writing to a string does not fail.
        let _ = writeln!(out, " {:>room$} │ {line}", number + 1);
        if number == wrong {
            let [mark, stem] = mark(error);
            let _ = write!(out, "{margin}· {mark}\n{margin}· {stem}╰── {}\n", error.message);
        }
    }
    let _ = writeln!(out, "{margin}╰────");
    if !error.expected.is_empty() {
        let help = format!("expected {}", error.expected);
        let _ = writeln!(out, "  help: {}", wrapped(&help, WIDEST - 8).join("\n        "));
    }
    Some(out)
}

/// The mark below the wrong characters, and the blanks before the stem that hangs from it.
fn mark(error: &FileError) -> [String; 2] {
    let before = error.column.saturating_sub(1);
    let marked = error.text.get(error.span.clone()).unwrap_or("");
    let length = marked.chars().take_while(|c| !matches!(c, '\n' | '\r')).count();
    let middle = length / 2;
    let mark = match length {
        0 => "▲".to_owned(),
        _ => format!("{}┬{}", "─".repeat(middle), "─".repeat(length - 1 - middle)),
    };
    [format!("{}{mark}", " ".repeat(before)), " ".repeat(before + middle)]
}

#[cfg(test)]
mod tests {
    use super::excerpt;
    use erard::instrument::InstrumentFile;

    fn drawn(text: &str) -> Option<String> {
        excerpt(&InstrumentFile::parse(text, "a.toml").expect_err("it is wrong"))
    }

    #[test]
    fn the_wrong_key_is_underlined() {
        let drawn = drawn("name = \"stick\"\n[[body]]\n\tweight_g = 140\nname = \"a\"\n").unwrap();
        let picture = "  × unknown key
   ╭─[a.toml:3:2]
 2 │ [[body]]
 3 │  weight_g = 140
   ·  ────┬───
   ·      ╰── unknown key
 4 │ name = \"a\"
   ╰────
  help: expected one of `name`, `hinged_on`, `pivot_mm`, `angle_deg`, `mass_g`, `inertia_kg_m2`,
        `center_of_mass_mm`,";
        assert!(drawn.starts_with(picture), "{drawn}");
        assert!(drawn.lines().all(|line| line.chars().count() <= super::WIDEST), "{drawn}");
    }

    #[test]
    fn a_missing_character_is_pointed_at() {
        let drawn = drawn("[[body]\n").unwrap();
        assert!(drawn.contains("1 │ [[body]\n   ·        ▲\n   ·        ╰── unclosed"), "{drawn}");
    }

    #[test]
    fn long_lines_are_not_drawn() {
        assert_eq!(drawn(&format!("x = \"{}\"\n", "y".repeat(500))), None);
    }
}
