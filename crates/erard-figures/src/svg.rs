//! The few things every SVG (and the page) needs: escaping and short numbers.

use std::fmt::Write;

/// Text made safe for XML and HTML, in element content and in quoted attributes alike.
///
/// Names come from files that anybody can write. Control characters that XML 1.0 forbids would make the whole
/// document unreadable, so they become U+FFFD. What is written from right to left, or says so by a mark, is isolated
/// (Unicode Standard Annex 9), so that it does not turn round what is next to it.
pub(crate) fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let is_isolated = text.chars().any(turns_round);
    if is_isolated {
        out.push(FIRST_STRONG_ISOLATE);
    }
    // Isolates in the text end in it, and it ends no others.
    let mut open = 0_usize;
    for c in text.chars() {
        match c {
            '\u{2066}'..='\u{2068}' => open += 1,
            END_OF_ISOLATE if open == 0 => continue,
            END_OF_ISOLATE => open -= 1,
            _ => {}
        }
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            '\t' | '\n' | '\r' => out.push(' '),
            c if c.is_control() || c == '\u{fffe}' || c == '\u{ffff}' => out.push('\u{fffd}'),
            c => out.push(c),
        }
    }
    out.extend(std::iter::repeat_n(END_OF_ISOLATE, open + usize::from(is_isolated)));
    out
}

const FIRST_STRONG_ISOLATE: char = '\u{2068}';
const END_OF_ISOLATE: char = '\u{2069}';

/// Whether a character is written from right to left, or is a mark of direction.
fn turns_round(c: char) -> bool {
    matches!(c, '\u{0590}'..='\u{08ff}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}'
        | '\u{fb1d}'..='\u{fdff}' | '\u{fe70}'..='\u{fefe}' | '\u{10800}'..='\u{10fff}' | '\u{1e800}'..='\u{1efff}')
}

/// A number with at most three decimals and no trailing zeros: short files, and the same bytes every time.
///
/// A coordinate that is not finite is written as 0, because `NaN` anywhere makes a browser drop the whole path.
pub(crate) fn number(value: f64) -> String {
    if !value.is_finite() {
        return "0".to_owned();
    }
    let mut text = String::new();
    let _ = write!(text, "{value:.3}");
    if text.contains('.') {
        let kept = text.trim_end_matches('0').trim_end_matches('.').len();
        text.truncate(kept);
    }
    if text == "-0" {
        text.remove(0);
    }
    text
}

/// Words at a place; `more` are further attributes, each after a space.
pub(crate) fn text(out: &mut String, class: &str, [x, y]: [f64; 2], more: &str, words: &str) {
    let (x, y, words) = (number(x), number(y), escape(words));
    let _ = write!(out, "<text class=\"{class}\" x=\"{x}\" y=\"{y}\"{more}>{words}</text>");
}

/// The attributes of a box: left, top, width and height.
pub(crate) fn sides(sides: [f64; 4]) -> String {
    let [left, top, width, height] = sides.map(number);
    format!(" x=\"{left}\" y=\"{top}\" width=\"{width}\" height=\"{height}\"")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_cannot_break_out_of_the_document() {
        assert_eq!(
            escape("</script><b a=\"x\" c='y'>&"),
            "&lt;/script&gt;&lt;b a=&quot;x&quot; c=&#39;y&#39;&gt;&amp;"
        );
        assert_eq!(escape("a\u{0}b\u{1b}c\nd"), "a\u{fffd}b\u{fffd}c d");
    }

    /// What turns the direction round is isolated, and closed by itself: an override, isolates left open, the end of
    /// one that never began.
    #[test]
    fn names_cannot_turn_round_what_is_beside_them() {
        assert_eq!(escape("\u{202e}abc"), "\u{2068}\u{202e}abc\u{2069}");
        assert_eq!(escape("a\u{2067}b"), "\u{2068}a\u{2067}b\u{2069}\u{2069}");
        assert_eq!(escape("a\u{2069}\u{2069}b"), "\u{2068}ab\u{2069}");
        assert_eq!(escape("\u{5e4}\u{5e1} 5"), "\u{2068}\u{5e4}\u{5e1} 5\u{2069}");
        assert_eq!(escape("caf\u{e9} 5"), "caf\u{e9} 5");
    }

    #[test]
    fn numbers_are_short_and_finite() {
        assert_eq!(number(1.0), "1");
        assert_eq!(number(-0.00001), "0");
        assert_eq!(number(-12.34567), "-12.346");
        assert_eq!(number(1200.0), "1200");
        assert_eq!(number(f64::NAN), "0");
        assert_eq!(number(f64::INFINITY), "0");
    }
}
