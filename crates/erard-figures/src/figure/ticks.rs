//! Ranges and round numbers for axes.

/// The smallest range that holds all finite values, a little widened; never empty.
pub fn range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let (low, high) = values
        .filter(|value| value.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
    if low > high {
        return (0.0, 1.0);
    }
    let spread = high - low;
    // a constant curve, or one whose spread is only rounding
    if spread <= 1e-12 * low.abs().max(high.abs()) || spread == 0.0 {
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
    let decimals = (-(step.abs().log10() + 1e-9).floor()).clamp(0.0, 9.0) as usize;
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

    #[test]
    fn a_constant_curve_still_has_a_range() {
        let (low, high) = range([3.0, 3.0].into_iter());
        assert!(low < 3.0 && high > 3.0);
        assert_eq!(range(std::iter::empty()), (0.0, 1.0));
        assert_eq!(range([f64::NAN].into_iter()), (0.0, 1.0));
    }
}
