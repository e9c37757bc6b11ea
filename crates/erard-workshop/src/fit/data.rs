//! One recording: the drive of the model and the channels compared, at evenly spaced instants.

use std::ops::Range;

use erard::parameter::Quantity;
use erard::player::Hand;
use erard::run::Setup;
use erard::stroke::{Cursor, ForceSeries, PositionOf, PositionSeries, Prescribed, Recording, Role, Series, Stroke};
use fastrand::Rng;
use moreau::Settings;

use super::FitError;
use super::correlation::unwhiten;
use crate::balance::median;
use erard::recording::{Butterworth, ChannelReport, LowPass, Preparation, Prepared, Whence, prepare};

/// Columns that can be fitted, and their assumed noise if unknown, N, m and m/s.
pub const COLUMNS: [(&str, Role, f64); 4] = [
    ("force_N", Role::Force, 0.02),
    ("key_m", Role::Position, 10e-6),
    ("hammer_rise_m", Role::HammerHead, 50e-6),
    ("hammer_rise_m_per_s", Role::HammerSpeed, 0.02),
];
/// Display unit for misfit and noise of a column, and its factor from SI.
pub fn misfit_unit(column: &str) -> (f64, &'static str) {
    let quantity = Quantity::of_name(column).map_or(Quantity::Length, |(quantity, _)| quantity);
    let fine = match quantity {
        Quantity::Force => "mN",
        Quantity::Speed => "mm/s",
        _ => "um",
    };
    quantity.unit(fine).map_or((1.0, ""), |unit| ((1.0 / unit.si).round(), unit.symbol))
}

/// Samples per second at most: above, a recording shows more of its noise than of the action.
const RATE_HZ: f64 = 4000.0;
/// Samples at both ends of a recorded motion that are not compared: its spline rings where the recording stops, so that
/// forces there are meaningless.
const SPLINE_ENDS: usize = 10;

/// Standard deviations beyond which the correlation of a drive's rest is more than chance, and the largest that counts:
/// a rest shows no slower noise.
const CHANCE: f64 = 3.5;
const MAX_CORRELATION: f64 = 0.99;

/// A recording prepared for a fit.
#[derive(Debug)]
pub struct Data {
    /// Name.
    pub name: String,
    /// Stroke that drives the model.
    pub stroke: Stroke,
    /// Note, if the stroke does not drive exactly as recorded.
    pub note: Option<&'static str>,
    /// Column that drives the model.
    pub driving: &'static str,
    /// Columns compared.
    pub columns: Vec<&'static str>,
    /// Evenly spaced instants on the recording's own clock, s.
    pub time_s: Vec<f64>,
    /// Range of the instants compared.
    pub compared: Range<usize>,
    /// Measured values at these, column by column.
    pub measured: Vec<Vec<f64>>,
    /// Preparation of the driving channel, with its noise.
    pub driven: Prepared,
    /// Preparation of the compared channels.
    pub prepared: Prepared,
    pub(super) settings: Settings<f64>,
    pub(super) every: u64,
    hand: Option<Hand>,
    position_of: PositionOf,
    drive: Option<Prescribed>,
}

impl Data {
    /// Makes the data of a recording. The driving column is prepared as `preparation` says; compared columns are not
    /// filtered, because a filter makes the noise look too small. `columns` are compared; without them, all recorded
    /// columns that do not drive. Steps divide the sampling interval and are no longer than those of `how`; `how` also
    /// gives the hand between stroke and key, the recording the duration.
    ///
    /// # Errors
    /// If the recording has no such drive, or no column is left to compare.
    pub fn new(
        name: &str,
        recording: &Recording,
        position_of: PositionOf,
        preparation: &Preparation,
        drive: Option<Prescribed>,
        columns: Option<&[String]>,
        how: &Setup,
    ) -> Result<Self, FitError> {
        let settings = how.settings;
        let wrong = |message: String| FitError::Recording { recording: name.to_owned(), message };
        let driven = prepare(recording, preparation).map_err(|error| wrong(error.to_string()))?;
        let prepared = if preparation.low_pass == LowPass::Off {
            driven.clone()
        } else {
            let unfiltered = Preparation { low_pass: LowPass::Off, ..preparation.clone() };
            prepare(recording, &unfiltered).map_err(|error| wrong(error.to_string()))?
        };
        let (stroke, note) = Stroke::recorded(name.to_owned(), driven.series.clone(), position_of, drive)?;
        let driving = if stroke.drive == Prescribed::Force { "force_N" } else { "key_m" };
        let recorded =
            |column: &str| COLUMNS.iter().find(|(own, role, _)| *own == column && recording.channel(*role).is_some());
        let wanted: Vec<&str> = match columns {
            Some(columns) => columns.iter().map(String::as_str).collect(),
            None => COLUMNS.iter().map(|(column, ..)| *column).filter(|column| recorded(column).is_some()).collect(),
        };
        let mut columns = Vec::new();
        for column in wanted {
            let (own, ..) = recorded(column)
                .ok_or_else(|| FitError::argument("columns", format!("{name}: has no `{column}` to compare")))?;
            if *own != driving && !columns.contains(own) {
                columns.push(*own);
            }
        }
        let all: Vec<&str> =
            COLUMNS.iter().map(|(column, ..)| *column).filter(|column| recorded(column).is_some()).collect();
        if columns.is_empty() {
            let by = stroke.drive.name();
            return Err(wrong(format!(
                "nothing to fit: the {by} drives the model and no other channel was recorded (recorded: {})",
                all.join(", ")
            )));
        }
        let times = &recording.time_s;
        let span_s = times[times.len() - 1] - times[0];
        let dt_s = median_step(times).max(1.0 / RATE_HZ);
        let every = (dt_s / settings.step - 1e-9).ceil().max(1.0);
        let count = (span_s / dt_s) as usize + 1;
        let ends = if stroke.drive == Prescribed::Force { 0 } else { SPLINE_ENDS };
        if count < 2 * ends + 2 {
            return Err(wrong(format!("found {count} samples, expected {} or more", 2 * ends + 2)));
        }
        let time_s: Vec<f64> = (0..count).map(|n| stroke.start_s + dt_s * n as f64).collect();
        let compared = ends..count - ends;
        let measured = columns.iter().map(|column| at(&prepared.series, column, &time_s[compared.clone()])).collect();
        let settings = Settings { step: dt_s / every, ..settings };
        let data = Data {
            name: name.to_owned(),
            stroke,
            note,
            driving,
            columns,
            time_s,
            compared,
            measured,
            driven,
            prepared,
            settings,
            every: every as u64,
            hand: how.hand,
            position_of,
            drive,
        };
        data.setup().check()?;
        Ok(data)
    }

    /// Reason why no run from rest matches this recording: a fingertip that starts with a force has already pressed the
    /// key.
    pub fn cannot_begin(&self) -> Option<&'static str> {
        self.note.filter(|_| self.stroke.drive == Prescribed::Motion && self.driven.series.force.is_some())
    }

    /// Setup of a run over the recording.
    pub(super) fn setup(&self) -> Setup {
        let duration_s = self.time_s[self.time_s.len() - 1] - self.time_s[0];
        let (settings, hand, start_s) = (self.settings, self.hand, self.stroke.start_s);
        Setup { settings, hand, start_s, ledger: false, ..Setup::new(duration_s) }
    }

    /// Sampling interval of the instants, s.
    pub(super) fn dt_s(&self) -> f64 {
        self.every as f64 * self.settings.step
    }

    /// Whether the noise of a column was read at the upper end of its spectrum, which takes it for white.
    pub(super) fn is_noise_from_spectrum(&self, column: &str) -> bool {
        let role = COLUMNS.iter().find(|(own, ..)| *own == column).map(|(_, role, _)| *role);
        let noise = role.and_then(|role| self.prepared.report.channel(role)?.noise);
        noise.is_some_and(|noise| noise.whence == Whence::Spectrum)
    }

    /// Number of samples compared per column.
    pub fn rows(&self) -> usize {
        self.compared.len()
    }

    /// Root mean square noise of a column, N, m or m/s, measured in its rest or from its spectrum.
    pub(crate) fn noise(&self, column: &str) -> Option<f64> {
        let (_, role, _) = COLUMNS.iter().find(|(own, ..)| *own == column)?;
        Some(self.prepared.report.channel(*role)?.noise?.rms)
    }

    /// Warnings about the driving and the compared channels.
    pub(super) fn warnings(&self) -> Vec<String> {
        let is_compared = |role: Role| COLUMNS.iter().any(|(own, of, _)| *of == role && self.columns.contains(own));
        let of = |channel: &ChannelReport| match channel.role {
            role if role == self.driving_role() => channel.warnings(),
            role if is_compared(role) => channel.misread(),
            _ => Vec::new(),
        };
        self.driven.report.channels.iter().flat_map(of).collect()
    }

    fn driving_role(&self) -> Role {
        if self.driving == "force_N" { Role::Force } else { Role::Position }
    }

    /// Relative standard deviation of [`Data::noise`]; 0 where it is unknown.
    pub(super) fn noise_uncertainty(&self, column: &str) -> f64 {
        let role = COLUMNS.iter().find(|(own, ..)| *own == column).map(|(_, role, _)| *role);
        let noise = role.and_then(|role| self.prepared.report.channel(role)?.noise);
        noise.map_or(0.0, |noise| noise.uncertainty)
    }

    /// Correlation of the drive's noise from sample to sample in its rest; 0 without a rest, or if it is not beyond
    /// chance.
    fn drive_correlation(&self) -> f64 {
        let role = self.driving_role();
        let series = &self.prepared.series;
        let values = match role {
            Role::Force => series.force.as_ref().map(ForceSeries::forces_n),
            _ => series.position.as_ref().map(PositionSeries::positions_m),
        };
        let zero = self.prepared.report.channel(role).and_then(|report| report.zero);
        let (Some(values), Some(zero)) = (values, zero) else { return 0.0 };
        let rest = &values[..zero.samples.min(values.len())];
        let squares: f64 = rest.iter().map(|x| x * x).sum();
        let products: f64 = rest.windows(2).map(|pair| pair[0] * pair[1]).sum();
        let found = if squares > 0.0 { products / squares } else { 0.0 };
        if found > CHANCE / (rest.len() as f64).sqrt() { found.min(MAX_CORRELATION) } else { 0.0 }
    }

    /// The driving stroke with noise of this root mean square added to each sample, after the same zero correction and
    /// filter.
    pub(super) fn disturbed(&self, sigma: f64, rng: &mut Rng) -> Result<Stroke, FitError> {
        let mut series = self.driven.series.clone();
        let role = self.driving_role();
        let wrong = |error: &dyn std::fmt::Display| FitError::Recording {
            recording: self.name.clone(),
            message: error.to_string(),
        };
        let disturb = |values: &[f64], rng: &mut Rng| -> Vec<f64> {
            let mut noise: Vec<f64> = values.iter().map(|_| sigma * normal(rng)).collect();
            unwhiten(&mut noise, self.drive_correlation());
            let report = self.driven.report.channel(role);
            if let Some(zero) = report.and_then(|report| report.zero) {
                let rest = zero.samples.clamp(1, noise.len());
                let mean = noise[..rest].iter().sum::<f64>() / rest as f64;
                noise.iter_mut().for_each(|x| *x -= mean);
            }
            let filter = report.and_then(|report| Some((report.low_pass?, report.rate_hz)));
            let filter = filter.and_then(|(own, rate_hz)| Butterworth::low_pass(own.order, own.cutoff_hz, rate_hz));
            let noise = filter.map_or(noise.clone(), |filter| filter.forth_and_back(&noise));
            values.iter().zip(noise).map(|(value, noise)| value + noise).collect()
        };
        if role == Role::Force {
            if let Some(force) = &series.force {
                let noisy = ForceSeries::new(force.times_s().to_vec(), disturb(force.forces_n(), rng));
                series.force = Some(noisy.map_err(|error| wrong(&error))?);
            }
        } else if let Some(path) = &series.position {
            let noisy = PositionSeries::new(path.times_s().to_vec(), disturb(path.positions_m(), rng));
            series.position = Some(noisy.map_err(|error| wrong(&error))?);
        }
        Ok(Stroke::recorded(self.name.clone(), series, self.position_of, self.drive)?.0)
    }
}

/// A column of a series at these instants; empty if it was not recorded.
fn at(series: &Series, column: &str, times: &[f64]) -> Vec<f64> {
    let mut cursor = Cursor::default();
    let path = |path: &Option<PositionSeries>, cursor: &mut Cursor| -> Vec<f64> {
        path.as_ref().map_or_else(Vec::new, |path| times.iter().map(|t| path.at(*t, cursor).0).collect())
    };
    match column {
        "force_N" => series
            .force
            .as_ref()
            .map_or_else(Vec::new, |force| times.iter().map(|t| force.at(*t, &mut cursor)).collect()),
        "key_m" => path(&series.position, &mut cursor),
        "hammer_rise_m_per_s" => series
            .hammer_speed
            .as_ref()
            .map_or_else(Vec::new, |speed| times.iter().map(|t| speed.at(*t, &mut cursor)).collect()),
        _ => path(&series.hammer_head, &mut cursor),
    }
}

/// Median time between two samples, s.
fn median_step(times: &[f64]) -> f64 {
    let steps: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
    median(&steps).expect("a recording has two rows")
}

/// A standard normal number (Box and Muller).
pub(super) fn normal(rng: &mut Rng) -> f64 {
    (-2.0 * (1.0 - rng.f64()).ln()).sqrt() * (std::f64::consts::TAU * rng.f64()).cos()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Recording {
        Recording::read(text.as_bytes(), "test", &erard::stroke::Columns::default()).unwrap()
    }

    fn data(text: &str, drive: Option<Prescribed>, columns: Option<&[String]>) -> Result<Data, FitError> {
        let none = Preparation::none();
        Data::new("test", &read(text), PositionOf::Key, &none, drive, columns, &Setup::new(1.0))
    }

    fn table(rows: usize, dt_s: f64) -> String {
        let rows =
            (0..rows).map(|n| format!("{},{},{},{}\n", n as f64 * dt_s, 2 + n % 2, 1e-5 * n as f64, 2e-5 * n as f64));
        format!("time_s,force_N,key_m,hammer_rise_m\n{}", rows.collect::<String>())
    }

    /// The force drives, the other columns are compared at the recording's own instants, at most at 4 kHz, in steps
    /// that divide the sampling interval.
    #[test]
    fn recordings_are_made_even() {
        let own = data(&table(101, 1.0 / 1024.0), None, None).unwrap();
        assert_eq!(
            (own.driving, &own.columns[..], own.rows(), own.every),
            ("force_N", &["key_m", "hammer_rise_m"][..], 101, 20)
        );
        assert!((own.measured[1][50] - 1e-3).abs() < 1e-9 && (own.time_s[100] - 100.0 / 1024.0).abs() < 1e-12);
        let fine = data(&table(1001, 1.0 / 8192.0), None, None).unwrap();
        assert_eq!((fine.rows(), fine.every), (489, 5));
        assert!((fine.settings.step - 50e-6).abs() < 1e-18);
        // A motion drives: the force is compared, but not at its ends, where the spline rings.
        let rigid = data(&table(101, 1.0 / 1024.0), Some(Prescribed::Rigid), None).unwrap();
        assert_eq!(
            (rigid.driving, &rigid.columns[..], rigid.compared.clone()),
            ("key_m", &["force_N", "hammer_rise_m"][..], 10..91)
        );
    }

    /// Errors name the recording.
    #[test]
    fn what_cannot_be_fitted_is_said() {
        let message = |result: Result<Data, FitError>| result.unwrap_err().to_string();
        let alone = "time_s,force_N\n0,1\n0.1,2\n";
        assert!(message(data(alone, None, None)).starts_with("test: nothing to fit: the force drives"));
        assert!(message(data(alone, Some(Prescribed::Rigid), None)).contains("`position_m`"));
        let wanted = ["string_N".to_owned()];
        assert!(message(data(&table(11, 1e-3), None, Some(&wanted))).contains("has no `string_N` to compare"));
        assert!(message(data(&table(15, 1e-3), Some(Prescribed::Rigid), None)).contains("expected 22 or more"));
    }

    /// Noise added to the drive has the requested size and is filtered like the recording.
    #[test]
    fn disturbances_are_as_large_as_the_noise() {
        let recording = read(&table(4001, 2.5e-4));
        let rms = |driving: &Preparation| {
            let own = Data::new("x", &recording, PositionOf::Key, driving, None, None, &Setup::new(1.0)).unwrap();
            let noisy = own.disturbed(0.1, &mut Rng::with_seed(1)).unwrap();
            let force = |stroke: &Stroke| {
                let inputs = stroke.inputs(&erard::instrument::Finger::default()).unwrap();
                own.time_s
                    .iter()
                    .map(|t| match inputs(*t) {
                        erard::Input::Force(f) => f,
                        _ => f64::NAN,
                    })
                    .collect::<Vec<_>>()
            };
            let (a, b) = (force(&noisy), force(&own.stroke));
            (a.iter().zip(&b).map(|(a, b)| (a - b).powi(2)).sum::<f64>() / a.len() as f64).sqrt()
        };
        assert!((rms(&Preparation::none()) / 0.1 - 1.0).abs() < 0.03);
        // A 200 Hz low-pass leaves a tenth of the power of white noise up to 2000 Hz.
        let filtered = Preparation { low_pass: erard::recording::LowPass::At(200.0), ..Preparation::none() };
        assert!((rms(&filtered) / 0.1 / 0.1_f64.sqrt() - 1.0).abs() < 0.15, "{}", rms(&filtered));
    }
}
