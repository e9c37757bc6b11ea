//! Where values stand along an axis, linear or logarithmic.

use super::ticks::{range, tick_label, ticks};

/// Scale of an axis.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Scale {
    /// Equal differences take equal room.
    #[default]
    Linear,
    /// Equal ratios take equal room; what is not positive has no place.
    Logarithmic,
}

/// An axis, from its low end to its high one in its own measure: the values, or their decimal logarithms.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Axis {
    scale: Scale,
    pub low: f64,
    pub high: f64,
}

impl Axis {
    /// From one value to another.
    pub(crate) fn between(scale: Scale, (low, high): (f64, f64)) -> Self {
        let axis = Axis { scale, low: 0.0, high: 1.0 };
        Axis { low: axis.measure(low), high: axis.measure(high), ..axis }
    }

    /// A little longer than all values need that have a place.
    pub(crate) fn around(scale: Scale, values: impl Iterator<Item = f64>) -> Self {
        let axis = Axis { scale, low: 0.0, high: 1.0 };
        let (low, high) = range(values.map(|value| axis.measure(value)));
        Axis { low, high, ..axis }
    }

    /// A value in the axis' own measure; not finite where it has no place.
    pub(crate) fn measure(&self, value: f64) -> f64 {
        match self.scale {
            Scale::Linear => value,
            Scale::Logarithmic => value.log10(),
        }
    }

    /// Where a value in the axis' own measure stands: 0 at the low end, 1 at the high one.
    pub(crate) fn share(&self, measure: f64) -> f64 {
        (measure - self.low) / (self.high - self.low)
    }

    /// Round numbers along the axis, about `most` of them: where they stand, and their labels.
    pub(crate) fn ticks(&self, most: usize) -> Vec<(f64, String)> {
        match self.scale {
            Scale::Linear => {
                let marks = ticks((self.low, self.high), most);
                let step = if marks.len() > 1 { marks[1] - marks[0] } else { 1.0 };
                marks.into_iter().map(|tick| (self.share(tick), tick_label(tick, step))).collect()
            }
            Scale::Logarithmic => self.powers(most),
        }
    }

    /// Powers of ten, with their doubles and fivefolds where there is room for them; round values where the axis is
    /// shorter than that.
    fn powers(&self, most: usize) -> Vec<(f64, String)> {
        let decades = (self.high - self.low).max(1e-12);
        let every = (decades / most as f64).ceil().max(1.0) as i32;
        let multiples: &[f64] = if 3.0 * decades <= most as f64 { &[1.0, 2.0, 5.0] } else { &[1.0] };
        let mut marks = Vec::new();
        for power in (self.low.floor() as i32..=self.high.ceil() as i32).filter(|power| power % every == 0) {
            for multiple in multiples {
                let share = self.share(self.measure(multiple * 10f64.powi(power)));
                if (-1e-9..=1.0 + 1e-9).contains(&share) {
                    marks.push((share, power_label(*multiple, power)));
                }
            }
        }
        if marks.len() >= 2 {
            return marks;
        }
        let values = ticks((10f64.powf(self.low), 10f64.powf(self.high)), most.min(5));
        let step = if values.len() > 1 { values[1] - values[0] } else { 1.0 };
        values.into_iter().map(|value| (self.share(self.measure(value)), tick_label(value, step))).collect()
    }
}

/// 0.001 to 5000 in full, powers beyond.
fn power_label(multiple: f64, power: i32) -> String {
    match power {
        -3..=3 => {
            let decimals = usize::try_from(-power).unwrap_or(0);
            format!("{:.decimals$}", multiple * 10f64.powi(power))
        }
        _ => format!("{multiple:.0}e{power}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A decade takes the same room wherever it is.
    #[test]
    fn logarithmic_axes_are_logarithmic() {
        let axis = Axis::between(Scale::Logarithmic, (1.0, 1e4));
        let share = |value: f64| axis.share(axis.measure(value));
        assert!((share(10.0) - 0.25).abs() < 1e-12 && (share(1000.0) - 0.75).abs() < 1e-12);
        let labels: Vec<String> = axis.ticks(8).into_iter().map(|t| t.1).collect();
        assert_eq!(labels, ["1", "10", "100", "1000", "1e4"]);
        assert_eq!(power_label(2.0, -3), "0.002");
        assert_eq!(power_label(1.0, -6), "1e-6");
    }

    /// An axis of a tenth of a decade has numbers too.
    #[test]
    fn short_logarithmic_axes_are_labelled() {
        let labels: Vec<String> =
            Axis::between(Scale::Logarithmic, (3.05, 3.55)).ticks(6).into_iter().map(|t| t.1).collect();
        assert_eq!(labels, ["3.1", "3.2", "3.3", "3.4", "3.5"]);
    }

    #[test]
    fn what_has_no_place_does_not_stretch_an_axis() {
        let axis = Axis::around(Scale::Logarithmic, [-1.0, 0.0, 10.0, 1000.0, f64::NAN].into_iter());
        assert!(axis.low > 0.8 && axis.low < 1.0 && axis.high > 3.0 && axis.high < 3.2);
    }
}
