//! Accuracy of a force computed under a recorded motion.
//!
//! A prescribed motion is differentiated twice: noise of the position becomes force. Its size is simulated: the same
//! motion is played with more noise of the recording's size, passed through the recording's filter. To first order, the
//! recording's own noise causes the same error. Motion missing from the samples (faster than half their rate, or
//! filtered away) is not included.

use erard::Progress;
use erard::instrument::Instrument;
use erard::player::{self, Drive};
use erard::recording::{Butterworth, ChannelReport, Report};
use erard::run::{Run, Setup, SimulationError, simulate};
use erard::stroke::{PositionSeries, Prescribed, Role, Stroke};
use fastrand::Rng;

use super::CompareError;

/// Number of motions with added noise.
const PLAYED: u64 = 8;

/// The noise of a recorded position.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathNoise {
    /// Root mean square of the noise before the filter, m.
    pub rms_m: f64,
    /// Its filter: order, cutoff and rate, Hz.
    pub filter: Option<(usize, f64, f64)>,
}

impl PathNoise {
    /// Reads the noise from a report; `None` if the recording has no position or its position shows no noise.
    #[must_use]
    pub fn of(report: &Report) -> Option<Self> {
        report.channel(Role::Position).and_then(Self::of_channel)
    }

    fn of_channel(channel: &ChannelReport) -> Option<Self> {
        let filter = channel.low_pass.map(|own| (own.order, own.cutoff_hz, channel.rate_hz));
        Some(PathNoise { rms_m: channel.noise?.rms, filter })
    }

    /// Adds noise of the same size to a path.
    fn added(&self, path: &PositionSeries, rng: &mut Rng) -> Option<PositionSeries> {
        // The sum of twelve uniform numbers is nearly normal.
        let normal = |rng: &mut Rng| (0..12).map(|_| rng.f64()).sum::<f64>() - 6.0;
        let noise: Vec<f64> = path.positions_m().iter().map(|_| self.rms_m * normal(rng)).collect();
        let noise = match self.filter {
            Some((order, cutoff_hz, rate_hz)) => {
                Butterworth::low_pass(order, cutoff_hz, rate_hz)?.forth_and_back(&noise)
            }
            None => noise,
        };
        let positions = path.positions_m().iter().zip(noise).map(|(position, noise)| position + noise).collect();
        PositionSeries::new(path.times_s().to_vec(), positions).ok()
    }
}

/// Uncertainty of a force that was computed under a recorded motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ForceUncertainty {
    /// Root mean square error of the force after the rest that is due to the recording's noise, N; infinite if the
    /// motion with its noise cannot be played.
    pub rms_n: f64,
    /// Largest error of 95 % of the samples, N.
    pub within_n: f64,
    /// Noise of the position before the filter, m.
    pub noise_m: f64,
}

/// Plays a path and returns the force on the axis of the undisturbed one, N.
pub(super) type Play<'a> = dyn Fn(&PositionSeries, &mut Progress<'_>) -> Result<Vec<f64>, SimulationError> + 'a;

impl ForceUncertainty {
    /// Computes the accuracy from the undisturbed force, whose first `resting` samples are at rest.
    pub(super) fn of(
        noise: &PathNoise,
        path: &PositionSeries,
        force_n: &[f64],
        resting: usize,
        play: &Play<'_>,
        progress: &mut Progress<'_>,
    ) -> Result<Self, CompareError> {
        let mut off = Vec::new();
        let noise_m = noise.rms_m;
        for seed in 0..PLAYED {
            let disturbed = noise.added(path, &mut Rng::with_seed(seed));
            let played = match disturbed.map(|path| play(&path, progress)) {
                Some(Err(error)) if matches!(error, SimulationError::Interrupted) => return Err(error.into()),
                Some(Ok(played)) => played,
                _ => return Ok(ForceUncertainty { rms_n: f64::INFINITY, within_n: f64::INFINITY, noise_m }),
            };
            let from = resting.min(force_n.len());
            off.extend(played.iter().zip(force_n).skip(from).map(|(a, b)| (a - b).abs()));
        }
        off.sort_unstable_by(f64::total_cmp);
        let mean = off.iter().map(|x| x * x).sum::<f64>() / off.len().max(1) as f64;
        let within_n = off.get(off.len() * 95 / 100).copied().unwrap_or(0.0);
        Ok(ForceUncertainty { rms_n: mean.sqrt(), within_n, noise_m })
    }

    /// Computes the accuracy for a run under a recorded stroke, over the rows from the end of its rest, s, to its own
    /// end. `None` if the stroke is not a recorded motion.
    ///
    /// # Errors
    /// When interrupted.
    pub fn of_run(
        run: &Run,
        instrument: &Instrument,
        stroke: &Stroke,
        setup: &Setup,
        (noise, rest_until_s): (&PathNoise, f64),
        progress: &mut Progress<'_>,
    ) -> Result<Option<Self>, CompareError> {
        let Ok(Some(path)) = stroke.path(&instrument.finger) else { return Ok(None) };
        let row = |until_s: f64| run.time_s.partition_point(|t| *t <= until_s);
        let end = path.times_s().last().map_or(0, |end_s| row(*end_s));
        let play = |disturbed: &PositionSeries, progress: &mut Progress<'_>| {
            let path = disturbed.drive();
            let drive: &Drive<'_> = match stroke.drive {
                Prescribed::Rigid => &player::rigid(&path),
                _ => &player::motion(&path),
            };
            let setup = Setup { ledger: false, ..*setup };
            let mut force_n = simulate(instrument, drive, &setup, progress)?.force_n;
            force_n.truncate(end);
            Ok(force_n)
        };
        ForceUncertainty::of(noise, &path, &run.force_n[..end], row(rest_until_s), &play, progress).map(Some)
    }

    /// Describes the accuracy in words.
    #[must_use]
    pub fn describe(&self, driven: Prescribed) -> String {
        let ForceUncertainty { rms_n, within_n, noise_m } = self;
        let begin = format!("{}: the position's noise, {:.2} um rms,", driven.driven(), 1e6 * noise_m);
        if !rms_n.is_finite() {
            return format!("{begin} makes the motion unplayable: the simulated force cannot be used");
        }
        format!(
            "{begin} makes the simulated force uncertain by {rms_n:.3} N rms, and in 95 % of the samples by less than {within_n:.3} N ({PLAYED} motions with as much noise added)"
        )
    }
}
