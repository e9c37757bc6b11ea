//! Effect of a noisy drive on the residuals, from strokes disturbed by that noise.

use std::ops::Range;

use crate::study::Job;
use erard::saved::{FNV1A, fnv1a};
use fastrand::Rng;

use super::problem::sampled;
use super::svd::Columns;
use super::{FitError, Problem};

/// Number of strokes with a disturbed drive per recording.
pub(super) const DISTURBED: usize = 48;

/// Changes of the residuals under a disturbed drive: [`DISTURBED`] columns for each recording whose drive has noise.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Disturbed {
    /// All columns; zero in the rows of other recordings.
    pub columns: Columns,
}

impl Disturbed {
    /// Expected reduced chi2: 1, plus the contribution of a typical disturbance of each recording.
    pub(crate) fn explained(&self, rows: usize) -> f64 {
        let typical = |own: &[Vec<f64>]| {
            let mut squares: Vec<f64> = own.iter().map(|column| column.iter().map(|x| x * x).sum()).collect();
            squares.sort_unstable_by(f64::total_cmp);
            0.5 * (squares[squares.len() / 2 - 1] + squares[squares.len() / 2])
        };
        1.0 + self.columns.chunks_exact(DISTURBED).map(typical).sum::<f64>() / rows as f64
    }

    /// The largest mean square that a disturbance causes in some rows, over the noise; 0 without disturbances.
    pub(crate) fn most(&self, rows: Range<usize>) -> f64 {
        let mean = |column: &Vec<f64>| column[rows.clone()].iter().map(|x| x * x).sum::<f64>() / rows.len() as f64;
        self.columns.iter().map(mean).fold(0.0, f64::max)
    }
}

impl Problem {
    /// Plays strokes with a disturbed drive at a point. The noise is a function of the recording: an error from so few
    /// disturbances is itself uncertain by a tenth, which must not go to one side in all fits.
    ///
    /// # Errors
    /// An interruption.
    pub(crate) fn drive_noise(&mut self, point: &[f64]) -> Result<Disturbed, FitError> {
        let instrument = self.at(point).ok_or(FitError::Unplayable)?;
        let undisturbed = self.simulate(&[point.to_vec()])?;
        let (mut columns, mut first, total) = (Vec::new(), 0, self.rows());
        let mut channel = 0;
        for (i, one) in self.data.iter().enumerate() {
            let (own_rows, own_channels) = (one.rows() * one.columns.len(), one.columns.len());
            let sigma = &self.sigma[channel..channel + own_channels];
            channel += own_channels;
            let (begins, noise) = (first, self.drive_sigma[i].unwrap_or(0.0));
            first += own_rows;
            if noise == 0.0 {
                continue;
            }
            let bytes = one.measured.iter().flatten().flat_map(|x| x.to_le_bytes());
            let mut rng = Rng::with_seed(fnv1a(FNV1A, bytes));
            let strokes = (0..DISTURBED).map(|_| one.disturbed(noise, &mut rng)).collect::<Result<Vec<_>, _>>()?;
            let jobs = strokes
                .iter()
                .map(|stroke| stroke.inputs(&instrument.finger).map(|stroke| Job { instrument: 0, stroke }));
            let jobs = jobs.collect::<Result<Vec<_>, _>>()?;
            let (all, workers) = (std::slice::from_ref(&instrument), self.workers());
            let played = sampled(&instrument, all, one, jobs, workers, self.evaluations, &mut self.watch)?;
            for samples in played {
                let mut column = vec![0.0; total];
                let own = samples.iter().flatten().zip(&undisturbed[i][0]).zip(sigma);
                let moved = own.flat_map(|((disturbed, still), sigma)| {
                    one.compared.clone().map(move |n| (disturbed[n] - still[n]) / sigma)
                });
                for (place, x) in column[begins..begins + own_rows].iter_mut().zip(moved) {
                    *place = if x.is_finite() { x } else { 0.0 };
                }
                columns.push(column);
            }
            self.evaluations += DISTURBED as u64;
        }
        self.go_on()?;
        Ok(Disturbed { columns })
    }
}
