//! Long series thinned to what a figure can show, without losing a spike.

/// A curve cut to `[from, to]` and thinned to about `columns` columns of pixels, as runs without a gap.
///
/// Of the samples in a column the first, the lowest, the highest and the last are kept, in their order in time: the
/// polyline through them covers the same pixels as the polyline through all, so a contact that lasts two samples of a
/// million still shows with its full height. One sample beyond either end is kept, so that curves reach the frame.
/// Samples that are not finite break the curve.
pub(crate) fn decimate(x: &[f64], y: &[f64], (from, to): (f64, f64), columns: usize) -> Vec<Vec<(f64, f64)>> {
    let samples = x.len().min(y.len());
    let first = x[..samples].partition_point(|&t| t < from).saturating_sub(1);
    let last = (x[..samples].partition_point(|&t| t <= to) + 1).min(samples);
    let mut runs = Vec::new();
    let mut run = Vec::new();
    let mut column = Column::default();
    let mut at = None;
    for index in first..last.max(first) {
        let point = (x[index], y[index]);
        if !(point.0.is_finite() && point.1.is_finite()) {
            column.flush(&mut run);
            if !run.is_empty() {
                runs.push(std::mem::take(&mut run));
            }
            at = None;
            continue;
        }
        // a cast from float to integer saturates, so samples beyond the ends fall into columns of their own
        let now = ((point.0 - from) / (to - from) * columns as f64).floor() as i64;
        if at != Some(now) {
            column.flush(&mut run);
            at = Some(now);
        }
        column.add(point);
    }
    column.flush(&mut run);
    if !run.is_empty() {
        runs.push(run);
    }
    runs
}

/// The samples that fall into one column of pixels.
#[derive(Default)]
struct Column {
    seen: usize,
    first: (f64, f64),
    last: (f64, f64),
    low: (usize, (f64, f64)),
    high: (usize, (f64, f64)),
}

impl Column {
    fn add(&mut self, point: (f64, f64)) {
        if self.seen == 0 {
            self.first = point;
            self.low = (0, point);
            self.high = (0, point);
        }
        if point.1 < self.low.1.1 {
            self.low = (self.seen, point);
        }
        if point.1 > self.high.1.1 {
            self.high = (self.seen, point);
        }
        self.last = point;
        self.seen += 1;
    }

    fn flush(&mut self, run: &mut Vec<(f64, f64)>) {
        if self.seen == 0 {
            return;
        }
        let mut kept = [(0, self.first), self.low, self.high, (self.seen - 1, self.last)];
        kept.sort_by_key(|(order, _)| *order);
        let mut previous = usize::MAX;
        for (order, point) in kept {
            if order != previous {
                run.push(point);
            }
            previous = order;
        }
        self.seen = 0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spike_of_one_sample_in_a_million_survives() {
        let x: Vec<f64> = (0..1_000_000).map(|i| i as f64 * 1e-6).collect();
        let mut y: Vec<f64> = x.iter().map(|t| (t * 20.0).sin()).collect();
        y[612_345] = 80.0;
        y[612_400] = -7.0;
        let runs = decimate(&x, &y, (0.0, 1.0), 500);
        assert_eq!(runs.len(), 1);
        let kept = &runs[0];
        assert!(kept.len() <= 4 * 501, "{}", kept.len());
        assert!(kept.contains(&(x[612_345], 80.0)) && kept.contains(&(x[612_400], -7.0)));
        assert!(kept.is_sorted_by(|a, b| a.0 < b.0));
        assert_eq!((kept[0], kept[kept.len() - 1]), ((x[0], y[0]), (x[999_999], y[999_999])));
    }

    #[test]
    fn short_series_are_left_alone() {
        let x = [0.0, 0.1, 0.2, 0.3];
        let y = [1.0, 2.0, 1.0, 0.0];
        let all: Vec<(f64, f64)> = x.into_iter().zip(y).collect();
        assert_eq!(decimate(&x, &y, (0.0, 0.3), 800), vec![all]);
    }

    #[test]
    fn a_window_keeps_one_sample_beyond_either_end() {
        let x: Vec<f64> = (0..100).map(f64::from).collect();
        let runs = decimate(&x, &x, (40.5, 42.5), 10);
        assert_eq!(runs, vec![vec![(40.0, 40.0), (41.0, 41.0), (42.0, 42.0), (43.0, 43.0)]]);
    }

    #[test]
    fn gaps_stay_gaps() {
        let x = [0.0, 1.0, 2.0, 3.0, 4.0];
        let y = [1.0, f64::NAN, 2.0, 3.0, f64::INFINITY];
        let runs = decimate(&x, &y, (0.0, 4.0), 100);
        assert_eq!(runs, vec![vec![(0.0, 1.0)], vec![(2.0, 2.0), (3.0, 3.0)]]);
        assert!(decimate(&[], &[], (0.0, 1.0), 10).is_empty());
    }
}
