//! A comparison in numbers: printed, and as `compare.json`.

use erard::recording::{ChannelReport, Report, Whence};
use erard_workshop::compare::{Comparison, Driven, Errors, RATE_HZ, Trial, share};
use serde::Serialize;

use crate::say;

/// One quantity of a trial, held against what was measured.
struct Finding<'a> {
    trial: &'a Trial,
    quantity: &'static str,
    /// SI unit.
    unit: &'static str,
    /// Factor to the unit that is shown, and that unit.
    shown: (f64, &'static str),
    /// Errors are told up to here, Hz.
    told_to_hz: f64,
    measured: bool,
    errors: Option<&'a Errors>,
}

/// What came out of every trial, and the hammer where it was measured.
fn findings(c: &Comparison) -> Vec<Finding<'_>> {
    let mut findings = Vec::new();
    for trial in &c.trials {
        let length = ("m", (1e3, "mm"));
        let (quantity, (unit, shown)) = match trial.driven {
            Driven::ByForce => ("position", length),
            Driven::ByMotion | Driven::Rigidly => ("force", ("N", (1.0, "N"))),
        };
        let measured = match trial.driven {
            Driven::ByForce => c.measured_position_m.is_some(),
            Driven::ByMotion | Driven::Rigidly => c.measured_force_n.is_some(),
        };
        let (told_to_hz, errors) = (trial.told_to_hz, trial.errors.as_ref());
        findings.push(Finding { trial, quantity, unit, shown, told_to_hz, measured, errors });
        if c.measured_hammer_m.is_some() && !trial.hammer_m.is_empty() {
            let (unit, shown) = length;
            let (told_to_hz, errors) = (trial.hammer_told_to_hz, trial.hammer_errors.as_ref());
            findings.push(Finding { trial, quantity: "hammer", unit, shown, told_to_hz, measured: true, errors });
        }
    }
    findings
}

/// The errors as a table, then by frequency.
pub(crate) fn print_table(comparison: &Comparison) {
    let findings = findings(comparison);
    say!("  drive   model     of         rms          of range   largest      explained  correlation  delay");
    for Finding { trial, quantity, shown: (factor, unit), measured, errors, .. } in &findings {
        let start = format!("  {:<7} {:<9} {quantity:<9}", trial.driven.name(), trial.which.name());
        match errors {
            Some(e) => say!(
                "{start}  {:>7.4} {unit:<3}  {:>7.2} %  {:>7.4} {unit:<3}  {:>9}  {:>10.5}  {:>6.2} ms",
                e.rms * factor,
                e.rms_of_range * 100.0,
                e.largest * factor,
                share(e.explained, 2).replace("less than ", "< "),
                e.correlation,
                e.delay_s * 1e3
            ),
            None if *measured => say!("{start}  - (the recording tells of nothing here)"),
            None => say!("{start}  not measured"),
        }
    }
    let limit = findings.iter().map(|f| f.told_to_hz).fold(f64::INFINITY, f64::min);
    if limit < 0.5 * RATE_HZ {
        let all = findings.iter().all(|f| f.told_to_hz == limit);
        say!(
            "  (all of it up to {limit:.0} Hz{}: above, the recording tells of noise or of nothing)",
            if all { "" } else { " or more" }
        );
    }
    say!();
    if findings.iter().any(|f| f.errors.is_some()) {
        say!("  error by frequency (rms; in brackets, of what was measured in the band)");
        for Finding { trial, quantity, shown: (factor, unit), told_to_hz, errors, .. } in &findings {
            let Some(errors) = errors else { continue };
            let mut line = format!("  {:<7} {:<9} {quantity:<9}", trial.driven.name(), trial.which.name());
            for band in &errors.bands {
                if band.to_hz > *told_to_hz {
                    line += &format!("  {:.0}-{:.0} Hz -", band.from_hz, band.to_hz);
                    continue;
                }
                let share = 100.0 * band.error_rms / band.measured_rms.max(f64::MIN_POSITIVE);
                // A band in which next to nothing was measured has no share worth reading.
                let share = if share < 1e3 { format!("{share:.1} %") } else { "> 1000 %".to_owned() };
                let error = band.error_rms * factor;
                line += &format!("  {:.0}-{:.0} Hz {error:.4} {unit} ({share})", band.from_hz, band.to_hz);
            }
            say!("{line}");
        }
        say!();
    }
}

/// `compare.json`.
#[derive(Debug, Serialize)]
pub(crate) struct ComparisonReport {
    /// The recording's name.
    measured: String,
    /// The instrument's name.
    instrument: String,
    /// Whose position was recorded: `key` or `fingertip`.
    position_of: &'static str,
    /// What was done to the recording before.
    preparation: Vec<PreparedChannel>,
    /// In words.
    verdicts: Vec<String>,
    /// What was taken for granted, or could not be tried.
    notes: Vec<String>,
    /// What should be looked at.
    warnings: Vec<String>,
    findings: Vec<FindingReport>,
}

/// One channel of the recording. SI units: N or m.
#[derive(Debug, Serialize)]
#[allow(non_snake_case)]
pub(crate) struct PreparedChannel {
    /// `force`, `position` or `hammer`.
    channel: &'static str,
    /// Lowest and highest value, zero and sign applied.
    range: [f64; 2],
    /// Samples per second.
    rate_Hz: f64,
    /// Rows without a value.
    empty_rows: usize,
    /// What was subtracted; null where no zero was taken.
    zero: Option<f64>,
    /// The rest before the touch ends here, s.
    rest_until_s: Option<f64>,
    /// Whether its sign was turned.
    inverted: bool,
    /// How much later than the others it was written down, s.
    late_s: f64,
    /// Standard deviation of its noise; null where none was found.
    noise_rms: Option<f64>,
    /// Where the noise was read: `rest` or `spectrum`.
    noise_from: Option<&'static str>,
    /// Up to here it tells of more than its noise, Hz.
    tells_to_Hz: Option<f64>,
    /// The low-pass, forth and back: where an amplitude is halved, Hz; null where there is none.
    low_pass_Hz: Option<f64>,
    /// Its order, of one pass.
    low_pass_order: Option<usize>,
}

#[derive(Debug, Serialize)]
#[allow(non_snake_case)]
struct FindingReport {
    drive: &'static str,
    model: &'static str,
    quantity: &'static str,
    unit: &'static str,
    /// Errors are told up to here; null where nothing limits them.
    told_to_Hz: Option<f64>,
    errors: Option<ErrorsReport>,
}

#[derive(Debug, Serialize)]
struct ErrorsReport {
    rms: f64,
    rms_of_range: f64,
    largest: f64,
    explained: f64,
    correlation: f64,
    delay_s: f64,
    bands: Vec<BandReport>,
}

#[derive(Debug, Serialize)]
#[allow(non_snake_case)]
struct BandReport {
    from_Hz: f64,
    to_Hz: f64,
    measured_rms: f64,
    error_rms: f64,
    /// Whether all of it lies below `told_to_Hz`: elsewhere the numbers are those of noise.
    told: bool,
}

impl ComparisonReport {
    /// Of a recording by its name and an instrument by its own.
    pub(crate) fn new(c: &Comparison, prepared: &Report, measured: &str, instrument: &str) -> Self {
        ComparisonReport {
            measured: measured.into(),
            instrument: instrument.into(),
            position_of: c.position_of.name(),
            preparation: prepared.channels.iter().map(PreparedChannel::new).collect(),
            verdicts: c.verdicts(),
            notes: c.notes.clone(),
            warnings: prepared.warnings().into_iter().chain(c.warnings()).collect(),
            findings: findings(c).iter().map(FindingReport::new).collect(),
        }
    }
}

impl PreparedChannel {
    /// Of a channel.
    pub(crate) fn new(channel: &ChannelReport) -> Self {
        PreparedChannel {
            channel: channel.role.name(),
            range: [channel.range.0, channel.range.1],
            rate_Hz: channel.rate_hz,
            empty_rows: channel.gaps.rows,
            zero: channel.zero.map(|zero| zero.offset),
            rest_until_s: channel.zero.map(|zero| zero.until_s),
            inverted: channel.inverted,
            late_s: channel.late_s,
            noise_rms: channel.noise.map(|noise| noise.rms),
            noise_from: channel.noise.map(|noise| match noise.whence {
                Whence::Rest => "rest",
                Whence::Spectrum => "spectrum",
            }),
            tells_to_Hz: channel.band_hz,
            low_pass_Hz: channel.low_pass.map(|filter| filter.cutoff_hz),
            low_pass_order: channel.low_pass.map(|filter| filter.order),
        }
    }
}

impl FindingReport {
    fn new(f: &Finding) -> Self {
        let errors = f.errors.map(|e| ErrorsReport {
            rms: e.rms,
            rms_of_range: e.rms_of_range,
            largest: e.largest,
            explained: e.explained,
            correlation: e.correlation,
            delay_s: e.delay_s,
            bands: e
                .bands
                .iter()
                .map(|b| BandReport {
                    from_Hz: b.from_hz,
                    to_Hz: b.to_hz,
                    measured_rms: b.measured_rms,
                    error_rms: b.error_rms,
                    told: b.to_hz <= f.told_to_hz,
                })
                .collect(),
        });
        let told_to_hz = Some(f.told_to_hz).filter(|hz| *hz < 0.5 * RATE_HZ);
        let (drive, model) = (f.trial.driven.name(), f.trial.which.name());
        FindingReport { drive, model, quantity: f.quantity, unit: f.unit, told_to_Hz: told_to_hz, errors }
    }
}
