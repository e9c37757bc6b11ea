//! Band of a value over many samples.

/// Range of a value in nine of ten samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Band {
    /// 5 % quantile of the value.
    pub low: f64,
    /// 95 % quantile of the value.
    pub high: f64,
    /// Number of samples that have the value.
    pub samples: usize,
}

const SHARES: [f64; 2] = [0.05, 0.95];

/// Returns the 5 to 95 % band of the values that exist, with linear interpolation of the quantiles; `None` for fewer
/// than two.
#[must_use]
pub fn band(values: impl IntoIterator<Item = Option<f64>>) -> Option<Band> {
    let mut sorted: Vec<f64> = values.into_iter().flatten().filter(|x| x.is_finite()).collect();
    if sorted.len() < 2 {
        return None;
    }
    sorted.sort_by(f64::total_cmp);
    let [low, high] = SHARES.map(|share| {
        let at = share * (sorted.len() - 1) as f64;
        let below = (at as usize).min(sorted.len() - 2);
        sorted[below] + (at - below as f64) * (sorted[below + 1] - sorted[below])
    });
    Some(Band { low, high, samples: sorted.len() })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// For 0 to 100 in any order the band is 5 to 95; missing values do not count.
    #[test]
    fn quantiles_of_a_ramp() {
        let ramp = (0..=100).rev().map(|n| Some(f64::from(n)));
        let found = band(ramp.chain([None, Some(f64::NAN)])).unwrap();
        assert_eq!(found, Band { low: 5.0, high: 95.0, samples: 101 });
        assert_eq!(band([Some(1.0), Some(3.0)]).unwrap(), Band { low: 1.1, high: 2.9, samples: 2 });
        assert_eq!(band([Some(1.0), None]), None);
    }
}
