//! Ranges and round numbers for axes.

/// Values that differ by less than this share of themselves are one value to an axis.
const CONSTANT: f64 = 1e-6;

/// The smallest range that holds all finite values, a little widened; never empty.
pub fn range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let (low, high) = values
        .filter(|value| value.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
    if low > high {
        return (0.0, 1.0);
    }
    let spread = high - low;
    // A constant curve, or one whose spread no label of six digits would show: ticks that all read the same say
    // nothing.
    if spread <= CONSTANT * low.abs().max(high.abs()) || spread == 0.0 {
        let half = if low == 0.0 { 1.0 } else { 0.5 * low.abs() };
        return (low - half, high + half);
    }
    (low - 0.06 * spread, high + 0.06 * spread)
}

/// Round numbers 1, 2 or 5 times a power of ten within the range, at most `most` of them.
pub(super) fn ticks((low, high): (f64, f64), most: usize) -> Vec<f64> {
    let spread = high - low;
    if !(spread > 0.0 && spread.is_finite()) || most == 0 {
        return Vec::new();
    }
    let raw = spread / most as f64;
    let power = 10f64.powf(raw.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0]
        .map(|round| round * power)
        .into_iter()
        .find(|step| *step >= raw * (1.0 - 1e-9))
        .unwrap_or(10.0 * power);
    let first = (low / step - 1e-9).ceil();
    (0..=most).map(|index| (first + index as f64) * step).take_while(|tick| *tick <= high + 1e-9 * spread).collect()
}

/// A tick's number with no more decimals than its step needs.
pub(super) fn tick_label(tick: f64, step: f64) -> String {
    let power = (step.abs().log10() + 1e-9).floor();
    if power < -5.0 || tick.abs() >= 1e7 {
        // Beyond a few decimals a power of ten is shorter; its digits are those that tell neighbours apart.
        let first = if tick == 0.0 { power } else { tick.abs().log10().floor() };
        let digits = (first - power).clamp(0.0, 9.0) as usize;
        return if tick.abs() < 1e-3 * step.abs() { "0".to_owned() } else { format!("{tick:.digits$e}") };
    }
    let decimals = (-power).clamp(0.0, 9.0) as usize;
    let text = format!("{tick:.decimals$}");
    match text.trim_start_matches(['-', '0', '.']) {
        "" => "0".to_owned(),
        _ => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_inside() {
        assert_eq!(ticks((-0.3, 10.4), 6), vec![0.0, 2.0, 4.0, 6.0, 8.0, 10.0]);
        assert_eq!(ticks((0.0, 1.0), 5).len(), 6);
        assert!(ticks((1.0, 1.0), 5).is_empty());
        assert!(ticks((0.0, f64::INFINITY), 5).is_empty());
    }

    #[test]
    fn labels_have_the_decimals_of_their_step() {
        assert_eq!(tick_label(0.30000000000000004, 0.1), "0.3");
        assert_eq!(tick_label(20.0, 20.0), "20");
        assert_eq!(tick_label(-0.0, 0.5), "0");
        assert_eq!(tick_label(-2.5, 0.5), "-2.5");
    }

    /// Whatever the data, no two ticks of an axis read the same, and none is longer than the room for it.
    #[test]
    fn ticks_are_told_apart() {
        for (a, b) in
            [(3.0, 3.0), (5.0, 5.000_000_1), (1e-9, 3e-9), (-2e-7, 1e-7), (4e8, 5e8), (1234.5, 1234.6), (0.0, 0.0)]
        {
            let ends = range([a, b].into_iter());
            let marks = ticks(ends, 6);
            let step = marks[1] - marks[0];
            let labels: Vec<String> = marks.iter().map(|tick| tick_label(*tick, step)).collect();
            assert!(labels.windows(2).all(|pair| pair[0] != pair[1]), "{labels:?}");
            assert!(labels.iter().all(|label| label.len() <= 9), "{labels:?}");
        }
    }

    #[test]
    fn a_constant_curve_still_has_a_range() {
        let (low, high) = range([3.0, 3.0].into_iter());
        assert!(low < 3.0 && high > 3.0);
        assert_eq!(range(std::iter::empty()), (0.0, 1.0));
        assert_eq!(range([f64::NAN].into_iter()), (0.0, 1.0));
    }
}
