//! Bands of values over many samples.

use super::SampleError;

/// Range of a value in nine of ten samples.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
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

/// Values of one sample.
#[derive(Debug, Clone, PartialEq)]
pub struct SampleValues {
    /// The values, in one order; empty if the sample has none.
    pub values: Vec<Option<f64>>,
    /// Reason why it has none, or why some are missing.
    pub error: Option<String>,
}

impl From<Result<Vec<Option<f64>>, String>> for SampleValues {
    fn from(found: Result<Vec<Option<f64>>, String>) -> Self {
        match found {
            Ok(values) => SampleValues { values, error: None },
            Err(error) => SampleValues { values: Vec::new(), error: Some(error) },
        }
    }
}

/// Returns the band of each of the first so many values over the samples that have it.
#[must_use]
pub fn bands(found: &[SampleValues], values: usize) -> Vec<Option<Band>> {
    let of = |index: usize| band(found.iter().map(|one| one.values.get(index).copied().flatten()));
    (0..values).map(of).collect()
}

/// Returns one line for each reason why samples are missing in bands, with the samples' numbers.
#[must_use]
pub fn failures(found: &[SampleValues]) -> Vec<String> {
    let mut reasons: Vec<((bool, &str), Vec<String>)> = Vec::new();
    for (sample, one) in (1..).zip(found) {
        let Some(error) = &one.error else { continue };
        let reason = (one.values.iter().any(Option::is_some), error.as_str());
        match reasons.iter_mut().find(|(known, _)| *known == reason) {
            Some((_, samples)) => samples.push(sample.to_string()),
            None => reasons.push((reason, vec![sample.to_string()])),
        }
    }
    let line = |((has_some, reason), samples): ((bool, &str), Vec<String>)| {
        let which = if samples.len() == 1 { "sample" } else { "samples" };
        let bands = if has_some { "all bands" } else { "the bands" };
        format!("{which} {} not in {bands}: {reason}", samples.join(", "))
    };
    reasons.into_iter().map(line).collect()
}

/// Returns the result for a sample, or the reason why its own instrument has none.
///
/// # Errors
/// [`SampleError::Interrupted`]: it ends the work.
pub fn unless_interrupted<T>(result: Result<T, impl Into<SampleError>>) -> Result<Result<T, String>, SampleError> {
    match result.map_err(Into::into) {
        Ok(found) => Ok(Ok(found)),
        Err(SampleError::Interrupted) => Err(SampleError::Interrupted),
        Err(SampleError::Measure(error)) if error.is_interruption() => Err(SampleError::Interrupted),
        Err(error) => Ok(Err(error.to_string())),
    }
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

    /// Samples with one reason share a line; an interruption is no reason.
    #[test]
    fn failed_samples_are_listed_by_their_reason() {
        let failed = |reason: &str| SampleValues::from(Err(reason.to_owned()));
        let whole = |value| SampleValues::from(Ok(vec![value]));
        let part = SampleValues { error: Some("no rest".to_owned()), ..whole(Some(2.0)) };
        let found = [whole(Some(1.0)), failed("no rest"), failed("no string"), whole(None), failed("no rest"), part];
        let lines = failures(&found);
        assert_eq!(
            lines,
            [
                "samples 2, 5 not in the bands: no rest",
                "sample 3 not in the bands: no string",
                "sample 6 not in all bands: no rest"
            ]
        );
        assert_eq!(bands(&found, 1)[0].map(|band| band.samples), Some(2));
        let interrupted: Result<(), SampleError> = Err(SampleError::Interrupted);
        assert!(unless_interrupted(interrupted).is_err());
        let failed: Result<(), _> = Err(crate::measure::MeasureError::Lost);
        assert_eq!(unless_interrupted(failed).unwrap().unwrap_err(), "a measurement ended without a result");
    }
}
