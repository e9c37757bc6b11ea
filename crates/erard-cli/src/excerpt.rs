//! The wrong place in a file: its line between its neighbours, underlined.

use std::fmt::Write;

use erard::instrument::FileError;

use crate::table::{MAX_WIDTH, wrapped};

/// Characters of a long line that stay in front of the wrong ones.
const BEFORE: usize = 20;

/// Draws the place of an error, at most [`MAX_WIDTH`] characters wide: of longer lines the part around the wrong
/// characters. `None` where the error belongs to no line.
pub(crate) fn excerpt(error: &FileError) -> Option<String> {
    let wrong = error.line.checked_sub(1)?;
    let lines: Vec<&str> = error.text.lines().collect();
    let shown = wrong.saturating_sub(1)..lines.len().min(wrong + 2);
    if !shown.contains(&wrong) {
        return None;
    }
    let room = shown.end.to_string().len();
    let margin = " ".repeat(room + 2);
    let mut out = format!("  × {}\n{margin}╭─[{}:{}:{}]\n", error.message, error.file, error.line, error.column);
    let width = MAX_WIDTH - room - 4;
    let (before, length) = marked(error);
    // The message hangs from the middle of the mark.
    let message = 4 + error.message.chars().count();
    let from = if before + length.min(width / 2) + message <= width { 0 } else { before.saturating_sub(BEFORE) };
    for (number, line) in shown.clone().zip(&lines[shown]) {
        let line = part(line, from, width);
        // Writing to a string does not fail.
        let _ = writeln!(out, " {:>room$} │ {line}", number + 1);
        if number == wrong {
            let [mark, stem] = mark(before - from, length.min(width - (before - from)));
            let _ = write!(out, "{margin}· {mark}\n{margin}· {stem}╰── {}\n", error.message);
        }
    }
    let _ = writeln!(out, "{margin}╰────");
    if !error.expected.is_empty() {
        let help = format!("expected {}", error.expected);
        let _ = writeln!(out, "  help: {}", wrapped(&help, MAX_WIDTH - 8).join("\n        "));
    }
    Some(out)
}

/// How many characters of its line stand before the wrong ones, and how many are wrong.
fn marked(error: &FileError) -> (usize, usize) {
    let wrong = error.text.get(error.span.clone()).unwrap_or("");
    (error.column.saturating_sub(1), wrong.chars().take_while(|c| !matches!(c, '\n' | '\r')).count())
}

/// At most `width` characters of a line, `from` one on; an ellipsis in place of the first or last of them where more
/// is there.
fn part(line: &str, from: usize, width: usize) -> String {
    // A tab is as wide as one character, so that the mark stands below its place.
    let mut shown: Vec<char> =
        line.chars().skip(from).take(width + 1).map(|c| if c == '\t' { ' ' } else { c }).collect();
    if shown.len() > width {
        shown.truncate(width);
        shown[width - 1] = '\u{2026}';
    }
    if from > 0
        && let Some(first) = shown.first_mut()
    {
        *first = '\u{2026}';
    }
    shown.into_iter().collect()
}

/// The mark below the wrong characters, and the blanks before the stem that hangs from it.
fn mark(before: usize, length: usize) -> [String; 2] {
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
    use erard::instrument::{FileError, InstrumentFile};

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
        assert!(drawn.lines().all(|line| line.chars().count() <= super::MAX_WIDTH), "{drawn}");
    }

    #[test]
    fn a_missing_character_is_pointed_at() {
        let drawn = drawn("[[body]\n").unwrap();
        assert!(drawn.contains("1 │ [[body]\n   ·        ▲\n   ·        ╰── unclosed"), "{drawn}");
    }

    #[test]
    fn of_long_lines_the_part_around_the_wrong_characters_is_drawn() {
        let note = "y".repeat(500);
        let text = format!("first = \"{note}{note}\"\nx = \"{note}\", wrong = 3\n");
        let at = |wrong: &str| {
            let start = text.find(wrong).unwrap();
            let before = &text[..start];
            let line_start = before.rfind('\n').map_or(0, |newline| newline + 1);
            excerpt(&FileError {
                file: "a.toml".to_owned(),
                line: before.matches('\n').count() + 1,
                column: start - line_start + 1,
                key: String::new(),
                message: "unknown key".to_owned(),
                found: wrong.to_owned(),
                expected: String::new(),
                span: start..start + wrong.len(),
                text: text.as_str().into(),
            })
            .unwrap()
        };
        let drawn = at("wrong");
        let (dots, bar) = ('\u{2026}', '\u{2502}');
        assert!(drawn.contains(&format!(" 1 {bar} {dots}yyy")), "{drawn}");
        assert!(drawn.contains(&format!(" 2 {bar} {dots}{}\", wrong = 3\n", "y".repeat(16))), "{drawn}");
        assert!(drawn.contains("  \u{b7}                     \u{2500}\u{2500}\u{252c}\u{2500}\u{2500}\n"), "{drawn}");
        for drawn in [drawn, at("x ="), at(&note[..400])] {
            assert!(drawn.lines().all(|line| line.chars().count() <= super::MAX_WIDTH), "{drawn}");
            assert!(drawn.contains(dots), "{drawn}");
        }
    }
}
