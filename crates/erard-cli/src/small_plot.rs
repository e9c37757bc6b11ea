//! A curve on a terminal, a few lines high: Braille's dots, two by four in a character.

/// Points across, two to a character.
pub(crate) const COLUMNS: usize = 128;
/// Lines of text.
const LINES: usize = 4;
/// A character's dots, from top to bottom, left and right.
const DOTS: [[u32; 2]; 4] = [[0x01, 0x08], [0x02, 0x10], [0x04, 0x20], [0x40, 0x80]];

/// The curve of these values from left to right, its range over the full height; nothing where it has none.
pub(crate) fn lines(values: &[f64]) -> Vec<String> {
    let (low, high) = values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), &x| (a.min(x), b.max(x)));
    if high <= low || !(high - low).is_finite() {
        return Vec::new();
    }
    let rows = 4 * LINES;
    let row = |value: f64| ((high - value) / (high - low) * (rows - 1) as f64).round() as usize;
    let mut cells = vec![[0_u32; LINES]; values.len().div_ceil(2)];
    for (x, &value) in values.iter().enumerate() {
        // As far as half-way to its neighbours, so that a steep curve stays one line.
        let beside = |n: Option<usize>| n.and_then(|n| values.get(n)).map_or(value, |other| 0.5 * (value + other));
        let ends = [row(beside(x.checked_sub(1))), row(value), row(beside(Some(x + 1)))];
        let (top, bottom) = ends.iter().fold((rows, 0), |(a, b), &r| (a.min(r), b.max(r)));
        for y in top..=bottom {
            cells[x / 2][y / 4] |= DOTS[y % 4][x % 2];
        }
    }
    let dots = |line: usize| cells.iter().map(move |cell| char::from_u32(0x2800 + cell[line]).unwrap_or(' '));
    (0..LINES).map(|line| dots(line).collect::<String>().trim_end_matches('\u{2800}').to_owned()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_and_a_constant() {
        let step: Vec<f64> = (0..8).map(|n| f64::from(u8::from(n >= 4))).collect();
        let lines = lines(&step);
        // The upper half of the step on the right, the lower half on the left, and the way between them.
        assert_eq!(lines[0], "\u{2800}\u{2800}\u{284f}\u{2809}");
        assert_eq!(lines[3], "\u{28c0}\u{28f8}");
        assert!(super::lines(&[3.0; 9]).is_empty() && super::lines(&[]).is_empty());
    }
}
