//! Fourier transform of a series. The library's code is generic: it is compiled here only, for all that use it.

use rustfft::num_complex::Complex;
use rustfft::{Fft, FftPlanner};
use std::sync::Arc;

/// Fourier transform of real series that have the same number of values.
pub struct Fourier {
    transform: Arc<dyn Fft<f64>>,
}

impl Fourier {
    /// Plans the transform of series of this many numbers.
    #[must_use]
    pub fn of(length: usize) -> Self {
        Fourier { transform: FftPlanner::new().plan_fft_forward(length) }
    }

    /// Returns the squared magnitudes of a series' discrete Fourier transform, unscaled, in the square of the series'
    /// unit; as many as the series has numbers. Number n belongs to n periods in the series.
    ///
    /// # Panics
    /// Panics if the series has another length.
    #[must_use]
    pub fn squares(&self, series: impl Iterator<Item = f64>) -> Vec<f64> {
        let mut numbers: Vec<Complex<f64>> = series.map(|x| Complex::new(x, 0.0)).collect();
        self.transformed(&mut numbers)
    }

    fn transformed(&self, numbers: &mut [Complex<f64>]) -> Vec<f64> {
        assert_eq!(numbers.len(), self.transform.len(), "a series of the planned length");
        self.transform.process(numbers);
        numbers.iter().map(Complex::norm_sqr).collect()
    }
}
