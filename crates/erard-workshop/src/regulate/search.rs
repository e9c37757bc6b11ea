//! Search for one screw's setting: the secant method, kept inside a bracket once there is one.
//!
//! The plain secant method fails for two reasons. Distances saturate (a hammer that blocks has no let-off, a lever that
//! is not stopped no drop, a weak spring does not lift), so that two turns may show no difference; then the expected
//! effect is used. And dry friction makes distances rough by some micrometres; so slopes are taken over large turns
//! only.

/// Largest factor between slope and expected effect: beyond it a difference is roughness or saturation.
const SLOPE_FACTOR: f64 = 8.0;

/// Properties of a screw for its search.
#[derive(Debug, Clone, Copy)]
pub(super) struct Turning {
    /// Expected change of the goal per unit of setting, never 0.
    pub slope: f64,
    /// Lowest and highest setting.
    pub limits: [f64; 2],
    /// Largest turn at once.
    pub stride: f64,
}

/// A search in progress. It receives measured values and returns the settings to try.
#[derive(Debug, Clone)]
pub(super) struct Search {
    turning: Turning,
    /// The present slope.
    slope: f64,
    target: f64,
    /// Settings that give too little and too much.
    too_little: Option<f64>,
    too_much: Option<f64>,
    previous: Option<(f64, f64)>,
    /// The best so far: setting and value.
    pub best: Option<(f64, f64)>,
}

impl Search {
    /// A search for `target` with `slope` (the one found last time), unless it is far from the expected one.
    pub(crate) fn new(turning: Turning, slope: Option<f64>, target: f64) -> Self {
        let slope = slope.filter(|&slope| plausible(slope, turning.slope)).unwrap_or(turning.slope);
        Search { turning, slope, target, too_little: None, too_much: None, previous: None, best: None }
    }

    /// Returns the slope found.
    pub(crate) fn slope(&self) -> f64 {
        self.slope
    }

    /// Records that `setting` gives `value` and returns the next setting to try; `None` if none can be better.
    pub(crate) fn next(&mut self, setting: f64, value: f64) -> Option<f64> {
        let error = value - self.target;
        if self.best.is_none_or(|(_, best)| error.abs() < (best - self.target).abs()) {
            self.best = Some((setting, value));
        }
        if let Some((before, value_before)) = self.previous
            && setting != before
            && value.is_finite()
            && value_before.is_finite()
        {
            let slope = (value - value_before) / (setting - before);
            self.slope = if plausible(slope, self.turning.slope) { slope } else { self.turning.slope };
        }
        self.previous = Some((setting, value));
        if error < 0.0 {
            self.too_little = Some(setting);
        } else {
            self.too_much = Some(setting);
        }
        let [from, to] = self.turning.limits;
        // A hammer that the check does not catch is infinitely far: a full stride.
        let step = (-error / self.slope).clamp(-self.turning.stride, self.turning.stride);
        let mut next = (setting + step).clamp(from, to);
        if let (Some(a), Some(b)) = (self.too_little, self.too_much) {
            let (low, high) = (a.min(b), a.max(b));
            // Near an end of the bracket the secant method is slow; bisection is not.
            let margin = 0.02 * (high - low);
            if !(low + margin..=high - margin).contains(&next) {
                next = 0.5 * (low + high);
            }
        }
        (next != setting).then_some(next)
    }
}

fn plausible(slope: f64, expected: f64) -> bool {
    let ratio = slope / expected;
    (1.0 / SLOPE_FACTOR..=SLOPE_FACTOR).contains(&ratio)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Runs a search on a known function. Returns the evaluations to come within 1e-6, and the end point.
    fn run(f: impl Fn(f64) -> f64, slope: f64, target: f64) -> (u32, f64) {
        let mut search = Search::new(Turning { slope, limits: [-4.0, 4.0], stride: 1.0 }, None, target);
        let mut x = 0.0;
        for n in 1..60 {
            let y = f(x);
            if (y - target).abs() < 1e-6 {
                return (n, x);
            }
            match search.next(x, y) {
                Some(next) => x = next,
                None => return (n, x),
            }
        }
        (60, x)
    }

    /// A line with a slope guessed three times too small is met in four evaluations; saturating functions and jumps to
    /// infinity are met too; targets out of range end at the end of the range.
    #[test]
    fn known_functions() {
        let (n, x) = run(|x| 3.0 * x - 1.0, 1.0, 0.5);
        assert!(n <= 4 && (x - 0.5).abs() < 1e-6, "{n} {x}");
        let (n, x) = run(|x| (2.0 * (x - 2.0)).max(0.0), 1.0, 1.0);
        assert!(n < 15 && (x - 2.5).abs() < 1e-6, "{n} {x}");
        let (n, x) = run(|x| if x < 1.5 { f64::INFINITY } else { 10.0 - 3.0 * x }, -3.0, 2.5);
        assert!(n < 15 && (x - 2.5).abs() < 1e-6, "{n} {x}");
        let (_, x) = run(|x| x, 1.0, 7.0);
        assert_eq!(x, 4.0);
    }

    /// A jump across the target: the search converges to it and keeps the better side.
    #[test]
    fn a_jump_is_closed_in_on() {
        let f = |x: f64| if x < 0.3 { 0.0 } else { 1.5 };
        let mut search = Search::new(Turning { slope: 1.0, limits: [-4.0, 4.0], stride: 1.0 }, None, 1.0);
        let mut x = 0.0;
        for _ in 0..40 {
            match search.next(x, f(x)) {
                Some(next) => x = next,
                None => break,
            }
        }
        assert!((x - 0.3).abs() < 1e-3, "{x}");
        assert_eq!(search.best.unwrap().1, 1.5);
    }
}
