//! Numbers for people: a number that rounds to zero has no sign.

/// Formats a number with `decimals` decimals.
#[must_use]
pub fn plain(x: f64, decimals: usize) -> String {
    let text = format!("{x:.decimals$}");
    if rounds_to_zero(&text) { text.trim_start_matches('-').to_owned() } else { text }
}

/// Formats a difference with its sign and `decimals` decimals.
#[must_use]
pub fn signed(x: f64, decimals: usize) -> String {
    let text = format!("{x:+.decimals$}");
    if rounds_to_zero(&text) { text.trim_start_matches(['+', '-']).to_owned() } else { text }
}

/// Whether a formatted number is 0.
#[must_use]
pub fn rounds_to_zero(text: &str) -> bool {
    !text.contains(|c: char| c.is_ascii_digit() && c != '0')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_rounds_to_nothing_has_no_sign() {
        for (x, decimals, without, with) in
            [(0.26, 1, "0.3", "+0.3"), (-0.26, 1, "-0.3", "-0.3"), (-0.004, 2, "0.00", "0.00"), (-0.0, 0, "0", "0")]
        {
            assert_eq!((plain(x, decimals).as_str(), signed(x, decimals).as_str()), (without, with));
        }
    }
}
