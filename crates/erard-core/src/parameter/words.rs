//! Regional words, accepted in names wherever this program's own are.

/// Regional word and this program's word.
const WORDS: [(&str, &str); 7] = [
    ("wippen", "whippen"),
    ("set_off", "let_off"),
    ("setoff", "let_off"),
    ("letoff", "let_off"),
    ("escapement", "let_off"),
    ("backcheck", "back_check"),
    ("roller", "knuckle"),
];

/// Returns a name with this program's words: `set-off` becomes `let-off`, `body.wippen.mass_g` `body.whippen.mass_g`.
/// Trims blanks.
#[must_use]
pub fn canonical_name(name: &str) -> String {
    let name = name.trim();
    WORDS.iter().fold(name.to_owned(), |name, (theirs, ours)| replaced(&name, theirs, ours))
}

/// Returns the regional names accepted for a name.
#[must_use]
pub fn aliases(name: &str) -> Vec<String> {
    let all = WORDS.iter().map(|(theirs, ours)| replaced(name, ours, theirs));
    all.filter(|other| other != name).collect()
}

/// Replaces a word wherever it is a whole part of a name, between ends, dots, hyphens and underscores. Words of several
/// parts are joined like the name's.
fn replaced(name: &str, from: &str, to: &str) -> String {
    let joint = if name.contains('-') { "-" } else { "_" };
    let [from, to] = [from, to].map(|word| word.replace('_', joint));
    let is_part = |c: char| c.is_alphanumeric();
    let mut at = name.match_indices(&from).map(|(at, _)| at);
    let whole = |at: &usize| !name[..*at].ends_with(is_part) && !name[at + from.len()..].starts_with(is_part);
    match at.find(whole) {
        Some(at) => format!("{}{to}{}", &name[..at], &name[at + from.len()..]),
        None => name.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_by_themselves_are_replaced() {
        for (name, wanted) in [
            ("set-off", "let-off"),
            ("setoff_mm", "let_off_mm"),
            ("body.wippen.mass_g", "body.whippen.mass_g"),
            (" escapement", "let_off"),
            ("rollers", "rollers"),
            ("offset_off_mm", "offset_off_mm"),
            ("dip_mm", "dip_mm"),
        ] {
            assert_eq!(canonical_name(name), wanted);
        }
        assert_eq!(aliases("let-off"), ["set-off", "setoff", "letoff", "escapement"]);
        assert!(aliases("dip").is_empty());
    }
}
