//! Effect of a noisy drive on the residuals, from strokes disturbed by that noise.

use std::ops::Range;

use crate::dense::Columns;
use erard::saved::{FNV1A, fnv1a};
use fastrand::Rng;

use super::simulator::Simulator;
use super::{FitError, NoiseModel};

/// Number of strokes with a disturbed drive per recording.
pub(super) const DISTURBED: usize = 48;

/// Changes of the residuals under a disturbed drive: [`DISTURBED`] columns for each recording whose drive has noise.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct DriveNoise {
    /// All columns over the sensors' noise; zero in the rows of other recordings.
    pub columns: Columns,
    /// The same, whitened as residuals are.
    pub whitened: Columns,
}

impl DriveNoise {
    /// Plays strokes with a disturbed drive at a point. The noise is a function of the recording: an error from so few
    /// disturbances is itself uncertain by a tenth, which must not go to one side in all fits.
    ///
    /// # Errors
    /// An interruption.
    pub(super) fn play(simulator: &mut Simulator<'_>, noise: &NoiseModel, point: &[f64]) -> Result<Self, FitError> {
        let problem = simulator.problem();
        let undisturbed = &simulator.play(&[point.to_vec()])?[0];
        let mut columns = Vec::new();
        for (i, one) in problem.recordings().iter().enumerate() {
            let drive_sigma = noise.drive_sigma[i].unwrap_or(0.0);
            if drive_sigma == 0.0 {
                continue;
            }
            let bytes = one.measured.iter().flatten().flat_map(|x| x.to_le_bytes());
            let mut rng = Rng::with_seed(fnv1a(FNV1A, bytes));
            let strokes =
                (0..DISTURBED).map(|_| one.disturbed(drive_sigma, &mut rng)).collect::<Result<Vec<_>, _>>()?;
            for played in simulator.play_drives(point, one, &strokes)? {
                let mut column = vec![0.0; problem.rows()];
                let own = problem.blocks().iter().enumerate().filter(|(_, block)| block.recording == i);
                for ((k, block), disturbed) in own.zip(played.iter().flatten()) {
                    let still = undisturbed.curve(k);
                    for (row, n) in column[block.rows.clone()].iter_mut().zip(one.compared.clone()) {
                        let x = (disturbed[n] - still[n]) / noise.sigma[k];
                        *row = if x.is_finite() { x } else { 0.0 };
                    }
                }
                columns.push(column);
            }
        }
        simulator.report()?;
        let mut whitened = columns.clone();
        whitened.iter_mut().for_each(|column| noise.whiten(problem, column));
        Ok(DriveNoise { columns, whitened })
    }

    /// Expected reduced chi2: 1, plus the contribution of a typical disturbance of each recording.
    pub(super) fn explained(&self, rows: usize) -> f64 {
        let typical = |own: &[Vec<f64>]| {
            let mut squares: Vec<f64> = own.iter().map(|column| column.iter().map(|x| x * x).sum()).collect();
            squares.sort_unstable_by(f64::total_cmp);
            0.5 * (squares[squares.len() / 2 - 1] + squares[squares.len() / 2])
        };
        1.0 + self.whitened.chunks_exact(DISTURBED).map(typical).sum::<f64>() / rows as f64
    }

    /// Columns whose outer products add up to the covariance of the drive's effect on the residuals.
    pub(super) fn covariance_columns(&self) -> Columns {
        let scale = (DISTURBED as f64).sqrt().recip();
        self.columns.iter().map(|column| column.iter().map(|x| x * scale).collect()).collect()
    }

    /// The largest mean square that a disturbance causes in some rows, over the noise; 0 without disturbances.
    pub(super) fn largest(&self, rows: Range<usize>) -> f64 {
        largest(&self.columns, &rows)
    }

    /// The same of whitened residuals.
    pub(super) fn largest_whitened(&self, rows: Range<usize>) -> f64 {
        largest(&self.whitened, &rows)
    }
}

/// The largest mean square of a column in some rows.
fn largest(columns: &Columns, rows: &Range<usize>) -> f64 {
    let mean = |column: &Vec<f64>| column[rows.clone()].iter().map(|x| x * x).sum::<f64>() / rows.len() as f64;
    columns.iter().map(mean).fold(0.0, f64::max)
}
