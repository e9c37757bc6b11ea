//! The report of a recording: its changes and remarks, as data and in words.

use serde_json::{Value, json};

use crate::stroke::{Gaps, Role};

use super::noise::{Noise, Whence, range};

/// All channels, in the order of their roles.
#[derive(Debug, Clone, PartialEq, Default)]
#[non_exhaustive]
pub struct Report {
    /// The channels.
    pub channels: Vec<ChannelReport>,
}

/// The zero that was taken from a channel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Zero {
    /// N or m: subtracted from every value.
    pub offset: f64,
    /// The rest before the touch ends here, s.
    pub until_s: f64,
    /// Samples of that rest.
    pub samples: usize,
}

/// A low-pass that was applied forward and backward.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Filtered {
    /// Order of the filter in one pass.
    pub order: usize,
    /// Frequency at which an amplitude is halved, Hz.
    pub cutoff_hz: f64,
}

/// One channel. SI units: N, m or m/s.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct ChannelReport {
    /// Quantity of the channel.
    pub role: Role,
    /// Lowest and highest value, zero and sign applied, before the low-pass.
    pub range: (f64, f64),
    /// Samples per second, usually.
    pub rate_hz: f64,
    /// Whether it is sampled evenly.
    pub is_even: bool,
    /// Missing samples.
    pub gaps: Gaps,
    /// Its zero, where one was found and taken.
    pub zero: Option<Zero>,
    /// Whether it is computed, not measured, so that its beginning is not taken as its zero: one number, and no noise.
    pub is_computed: bool,
    /// Zero that was stated and taken, N, m or m/s, its sign turned with the channel's.
    pub stated_zero: Option<f64>,
    /// Whether its sign was turned.
    pub inverted: bool,
    /// Delay against the others, s, as the caller gave it.
    pub late_s: f64,
    /// Its noise, where it shows any.
    pub noise: Option<Noise>,
    /// Frequency up to which the signal is above the noise, Hz; `None` where no noise was found.
    pub band_hz: Option<f64>,
    /// The low-pass.
    pub low_pass: Option<Filtered>,
    /// Rate of the even clock on which the samples were interpolated by straight lines, Hz; `None` where the recorded
    /// samples themselves are used. Only a low-pass needs an even clock.
    pub resampled_hz: Option<f64>,
    /// Whether the channel moves opposite to a key, so that its sign is probably reversed.
    pub looks_inverted: bool,
    /// First value, N or m, if it is far from zero and no zero was subtracted.
    pub begins_at: Option<f64>,
    first: f64,
}

/// How much farther one way than the other is the wrong way.
const WRONG_WAY: f64 = 3.0;
/// How far from zero a channel begins that is said to, as a share of its range.
const OFF: f64 = 0.02;

impl ChannelReport {
    pub(super) fn new(role: Role, values: &[f64], rest: usize) -> Self {
        let first = super::noise::mean(&values[..rest.max(1)]);
        ChannelReport {
            role,
            range: range(values),
            rate_hz: 0.0,
            is_even: false,
            gaps: Gaps::default(),
            zero: None,
            is_computed: false,
            stated_zero: None,
            inverted: false,
            late_s: 0.0,
            noise: None,
            band_hz: None,
            low_pass: None,
            resampled_hz: None,
            looks_inverted: false,
            begins_at: None,
            first,
        }
    }

    /// Hints in the numbers themselves.
    pub(super) fn told(&mut self, values: &[f64]) {
        let (low, high) = self.range;
        let noise = self.noise.map_or(0.0, |noise| noise.rms);
        // From where it begins: an offset is no direction.
        let (down, up) = (values[0].min(self.first) - low, high - values[0].max(self.first));
        self.looks_inverted = down > WRONG_WAY * up.max(0.0) + 10.0 * noise;
        let off = self.first.abs() > (OFF * (high - low)).max(6.0 * noise) && self.first != 0.0;
        self.begins_at = (self.zero.is_none() && self.stated_zero.is_none() && off).then_some(self.first);
    }

    /// Its value as people read it.
    fn shown(&self, value: f64) -> String {
        match self.role.quantity().shown() {
            (_, "mm") if value.abs() < 1e-4 => format!("{:.2} um", value * 1e6),
            (factor, unit) => format!("{:.4} {unit}", value * factor),
        }
    }

    /// Changes and remarks, one to a line.
    pub fn lines(&self) -> Vec<String> {
        let mut lines = Vec::new();
        if self.gaps.rows > 0 {
            let longest = if self.gaps.longest_s > 0.0 {
                format!(", the longest bridges {:.1} ms", self.gaps.longest_s * 1e3)
            } else {
                String::new()
            };
            lines.push(format!("{} rows are empty{longest}", self.gaps.rows));
        }
        if self.inverted {
            lines.push("sign reversed".into());
        }
        if self.late_s != 0.0 {
            lines.push(format!("delay: {:.3} ms removed", -self.late_s * 1e3));
        }
        if let Some(zero) = self.zero {
            lines.push(format!(
                "zero: {} subtracted, the mean of {} samples of rest until {:.4} s",
                self.shown(zero.offset),
                zero.samples,
                zero.until_s
            ));
        }
        if let Some(at) = self.stated_zero {
            lines.push(format!("zero: {} subtracted, as was said", self.shown(at)));
        }
        if let Some(noise) = self.noise {
            let whence = match noise.whence {
                Whence::Rest => "in the rest before the touch",
                Whence::Spectrum => "at the upper end of its spectrum",
            };
            let tells = match self.band_hz {
                Some(band) if band <= 0.0 => "no signal above noise".to_owned(),
                Some(band) => format!("signal above noise up to {band:.0} Hz"),
                None => "up to where is not known".to_owned(),
            };
            lines.push(format!("noise: {} rms {whence}; {tells}", self.shown(noise.rms)));
        }
        if let Some(rate_hz) = self.resampled_hz {
            lines.push(format!("resampled: evenly at {rate_hz:.0} Hz, by straight lines, for the low-pass"));
        }
        if let Some(filter) = self.low_pass {
            lines.push(format!(
                "low-pass: Butterworth, order {}, forward and backward, {:.0} Hz (amplitude halved there)",
                filter.order, filter.cutoff_hz
            ));
        }
        lines
    }

    /// Preparation of the channel as JSON, the `preparation` of results: ranges and zeros in SI units, rates and
    /// frequencies in Hz, null for what was not done or not found.
    pub fn json(&self) -> Value {
        let noise_from = self.noise.map(|noise| match noise.whence {
            Whence::Rest => "rest",
            Whence::Spectrum => "spectrum",
        });
        json!({
            "channel": self.role.name(),
            "range": [self.range.0, self.range.1],
            "rate_Hz": self.rate_hz,
            "empty_rows": self.gaps.rows,
            "zero": self.zero.map(|zero| zero.offset).or(self.stated_zero),
            "rest_until_s": self.zero.map(|zero| zero.until_s),
            "inverted": self.inverted,
            "late_s": self.late_s,
            "noise_rms": self.noise.map(|noise| noise.rms),
            "noise_from": noise_from,
            "tells_to_Hz": self.band_hz,
            "resampled_Hz": self.resampled_hz,
            "low_pass_Hz": self.low_pass.map(|filter| filter.cutoff_hz),
            "low_pass_order": self.low_pass.map(|filter| filter.order),
        })
    }

    /// Warnings for a series that drives a key.
    pub fn warnings(&self) -> Vec<String> {
        let mut warnings = self.misread();
        if self.noise.is_some() && self.low_pass.is_none() && self.role == Role::Position {
            let what = "noise is not filtered: as a drive it becomes force";
            warnings.push(format!("the {}'s {what}", self.role.name()));
        }
        warnings
    }

    /// Warnings for any use of the series: its sign and its zero.
    pub fn misread(&self) -> Vec<String> {
        let name = self.role.name();
        let mut warnings = Vec::new();
        if self.looks_inverted {
            let way = if matches!(self.role, Role::HammerHead | Role::HammerSpeed) { "down" } else { "up" };
            warnings.push(format!(
                "the {name} goes {way}, from {} to {}: it looks inverted",
                self.shown(self.first),
                self.shown(self.range.0)
            ));
        }
        if let Some(off) = self.begins_at {
            // As it is to be stated: in the file's own sign.
            let at = self.shown(if self.inverted { -off } else { off }).replace(' ', "");
            let shown = self.shown(off);
            warnings.push(format!(
                "the {name} begins at {shown}, and no zero was taken from it{}. If it rests there: --zero {name}={at} (in Python, zero)",
                if self.is_computed { ", because it has no noise: it is computed, not measured" } else { "" }
            ));
        }
        warnings
    }
}

impl Report {
    /// Report of the channel of a role.
    pub fn channel(&self, role: Role) -> Option<&ChannelReport> {
        self.channels.iter().find(|channel| channel.role == role)
    }

    /// Until when all channels rest, s; `None` where no channel shows a rest before the touch.
    pub fn rest_until_s(&self) -> Option<f64> {
        self.channels.iter().filter_map(|channel| Some(channel.zero?.until_s)).reduce(f64::min)
    }

    /// Changes and remarks, a line each, with the name of the channel in front.
    pub fn told(&self) -> Vec<String> {
        let done = self.channels.iter().flat_map(|channel| {
            let name = channel.role.name();
            channel.lines().into_iter().map(move |line| format!("{name}: {line}"))
        });
        done.chain(self.warnings().into_iter().map(|warning| format!("warning: {warning}"))).collect()
    }

    /// Preparation of all channels as JSON: a list of [`ChannelReport::json`].
    pub fn json(&self) -> Value {
        self.channels.iter().map(ChannelReport::json).collect()
    }

    /// Warnings of all channels.
    pub fn warnings(&self) -> Vec<String> {
        self.channels.iter().flat_map(ChannelReport::warnings).collect()
    }
}
