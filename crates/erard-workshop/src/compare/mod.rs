//! Comparison of a measured stroke with the models: the share of it that each drive and each model explains.
//!
//! A measured force drives the key, and the key's motion results; a measured position drives a soft finger by the
//! fingertip's position, and the key rigidly by its own, and the finger's force results. If both were measured, the
//! result is compared with the measurement [T12 fig. 3]. A position is the key's unless [`Choice::position_of`] says
//! that it is the fingertip's; with force, each follows from the other ([`Series::position_of`]). One that was read
//! behind the balance pin drives the action's key there ([`Instrument::driven_at_key_back`]).
//!
//! No model explains the noise of a recording. Errors are reported only up to the frequency below which both the
//! driving and the compared series contain signal above noise ([`Choice::tells_to_hz`]).

mod errors;
mod force_uncertainty;
mod key_back;

pub use errors::{Band, Errors, Rest};
pub use force_uncertainty::{ForceUncertainty, PathNoise};

use key_back::KeyBack;
use thiserror::Error;

use erard::Progress;
use erard::instrument::Instrument;
use erard::one_dof::{OneDofError, reduce};
use erard::player::{self, Drive};
use erard::recording::{Butterworth, ChannelReport, Report, interpolated};
use erard::run::{MAX_ROWS_ASKED, Setup, SimulationError, simulate};
use erard::stroke::{ForceSeries, PositionOf, PositionSeries, Prescribed, Role, SampleError, Series};

/// Rate of the common time axis, Hz: twice the minimum for the highest band.
pub const RATE_HZ: f64 = 4000.0;

/// Drives in the order of trials and reports.
pub const DRIVES: [Prescribed; 3] = [Prescribed::Force, Prescribed::Motion, Prescribed::Rigid];

/// Name of the quantity that results from a drive.
pub fn outcome(driven: Prescribed) -> &'static str {
    match driven {
        Prescribed::Force => "position",
        Prescribed::Motion | Prescribed::Rigid => "force",
    }
}

/// Model of an instrument.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Which {
    /// All bodies.
    Action,
    /// One-degree-of-freedom model.
    OneDof,
}

impl Which {
    /// Returns the name in files.
    pub const fn name(self) -> &'static str {
        match self {
            Which::Action => "action",
            Which::OneDof => "one-dof",
        }
    }

    /// Returns this model of a full instrument.
    ///
    /// # Errors
    /// See [`OneDofError`].
    pub fn of(self, full: Instrument) -> Result<Instrument, OneDofError> {
        Ok(match self {
            Which::Action => full,
            Which::OneDof => reduce(&full)?.instrument,
        })
    }

    /// Name in a sentence.
    fn spoken(self) -> &'static str {
        match self {
            Which::Action => "the action",
            Which::OneDof => "one degree of freedom",
        }
    }
}

/// Both models.
pub(crate) const MODELS: [Which; 2] = [Which::Action, Which::OneDof];

/// Options of a comparison.
#[derive(Debug, Clone, PartialEq)]
pub struct Choice {
    /// Drives to try, of those that the series has.
    pub drives: Vec<Prescribed>,
    /// Models to run.
    pub models: Vec<Which>,
    /// Part whose position was recorded.
    pub position_of: PositionOf,
    /// Frequency up to which force, position and hammer contain signal above noise, Hz; infinite without a limit.
    pub tells_to_hz: [f64; 3],
    /// End of the rest, s; minus infinity if there is no known rest.
    pub rest_until_s: f64,
    /// Noise of the recorded position; `None` if it shows none.
    pub path_noise: Option<PathNoise>,
    /// What may be wrong with the recorded force and position, each with its remedy: a zero that was not taken, a
    /// reversed sign.
    pub misread: [Vec<String>; 2],
}

impl Default for Choice {
    fn default() -> Self {
        Choice {
            drives: DRIVES.to_vec(),
            models: MODELS.to_vec(),
            position_of: PositionOf::Key,
            tells_to_hz: [f64::INFINITY; 3],
            rest_until_s: f64::NEG_INFINITY,
            path_noise: None,
            misread: Default::default(),
        }
    }
}

impl Choice {
    /// Limits the comparison by a prepared recording's noise, low-pass, sample rate and rest before the touch, and
    /// takes from it what may be wrong with its channels.
    #[must_use]
    pub fn limited_by(mut self, report: &Report) -> Self {
        for (limit, role) in self.tells_to_hz.iter_mut().zip([Role::Force, Role::Position, Role::HammerHead]) {
            let Some(channel) = report.channel(role) else { continue };
            let low_pass = channel.low_pass.map(|filter| filter.cutoff_hz);
            let noise = channel.band_hz.into_iter().chain(low_pass).map(|hz| WELL_WITHIN * hz);
            *limit = noise.chain([0.5 * channel.rate_hz]).fold(*limit, f64::min);
        }
        self.path_noise = PathNoise::of(report);
        self.misread = [Role::Force, Role::Position]
            .map(|role| report.channel(role).map(ChannelReport::misread).unwrap_or_default());
        self.rest_until_s = report.rest_until_s().unwrap_or(self.rest_until_s);
        self
    }
}

/// Share of the frequency limit of noise or low-pass up to which errors are reported: at the limit half of an amplitude
/// may be filtered away, at this share of it, with the default filter, six in a hundred.
const WELL_WITHIN: f64 = 0.7;
/// Lowest useful end of a band, Hz: a key is down in a twentieth of a second.
const LOWEST_LIMIT_HZ: f64 = 10.0;

/// One drive of one model, on the common time axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Trial {
    /// The drive.
    pub driven: Prescribed,
    /// The model.
    pub which: Which,
    /// Travel of the key front, m, down positive.
    pub key_m: Vec<f64>,
    /// Finger force, N.
    pub force_n: Vec<f64>,
    /// Highest frequency for which errors are reported, Hz; infinite without a limit.
    pub told_to_hz: f64,
    /// Differences between model and measurement (position in m, force in N) below that frequency; `None` if the file
    /// has no such series, or only noise.
    pub errors: Option<Errors>,
    /// Effect of the recording's noise on the force, under a recorded motion; `None` if unknown.
    pub force_uncertainty: Option<ForceUncertainty>,
    /// Rise of the hammer's strike point, m; empty for a model without a hammer.
    pub hammer_rise_m: Vec<f64>,
    /// Highest frequency for which errors of the hammer are reported, Hz.
    pub hammer_told_to_hz: f64,
    /// Errors of the hammer's motion, if it was both simulated and measured.
    pub hammer_errors: Option<Errors>,
}

impl Trial {
    /// The simulated result: the key's travel, m, or the finger's force, N.
    pub fn simulated(&self) -> &[f64] {
        match self.driven {
            Prescribed::Force => &self.key_m,
            Prescribed::Motion | Prescribed::Rigid => &self.force_n,
        }
    }
}

/// Measured stroke with its simulated runs.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Comparison {
    /// Common time axis, s.
    pub time_s: Vec<f64>,
    /// Measured force, N.
    pub measured_force_n: Option<Vec<f64>>,
    /// Measured position of the key's front, m; of the fingertip if the key's is unknown.
    pub measured_position_m: Option<Vec<f64>>,
    /// Part whose position was recorded.
    pub position_of: PositionOf,
    /// Measured rise of the hammer's strike point, m.
    pub measured_hammer_rise_m: Option<Vec<f64>>,
    /// Trials in the order of [`DRIVES`], the action before the one-degree-of-freedom model.
    pub trials: Vec<Trial>,
    /// Assumptions, and drives that could not be tried, in words.
    pub notes: Vec<String>,
    /// What may be wrong with the recorded force and position ([`Choice::misread`]).
    pub misread: [Vec<String>; 2],
}

/// Share of the largest value at which the upward motion is nearly over.
const NEARLY_THERE: f64 = 0.9;
/// Time after that in which the hammer may still rise, s.
const STILL_RISING_S: f64 = 0.02;

/// Returns the end of a stroke's upward motion, s: the first time at which the hammer is highest or, if the hammer was
/// not recorded, at which the key is down. `None` if neither was recorded or nothing moves.
pub fn way_up_ends_s(series: &Series) -> Option<f64> {
    let path = series.hammer_head.as_ref().or(series.position.as_ref())?;
    let (drive, start_s) = (path.drive(), series.start_s());
    let count = ((series.end_s() - start_s) * RATE_HZ).floor() as usize;
    let values: Vec<f64> = (0..=count).map(|n| drive(start_s + n as f64 / RATE_HZ)[0]).collect();
    let largest = values.iter().copied().fold(0.0, f64::max);
    let there = values.iter().position(|x| largest > 0.0 && *x >= NEARLY_THERE * largest)?;
    let last = values.len().min(there + (STILL_RISING_S * RATE_HZ) as usize + 1);
    let top = (there..last).max_by(|&a, &b| values[a].total_cmp(&values[b]).then(b.cmp(&a)))?;
    Some(start_s + top as f64 / RATE_HZ)
}

/// Longest series for a comparison, s: a million instants of the common axis.
pub const MAX_DURATION_S: f64 = 250.0;

/// Reason why a comparison cannot be made.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum CompareError {
    /// The measured series is too short.
    #[error("the recording lasts {found_s:.4} s; expected at least {least_s} s")]
    TooShort {
        /// s.
        found_s: f64,
        /// s.
        least_s: f64,
    },
    /// The measured series and the models' results would not fit into memory.
    #[error("the recording lasts {found_s} s; expected at most {MAX_DURATION_S} s")]
    TooLong {
        /// s.
        found_s: f64,
    },
    /// The series has none of the chosen drives.
    #[error(
        "the recording does not allow the chosen drives; expected a force for the drive `force`, a position for `motion` or `rigid`"
    )]
    NoDrive,
    /// Force and position together give no position of the fingertip or of the key.
    #[error(transparent)]
    Samples(#[from] SampleError),
    /// A model cannot be run.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    /// The instrument has no one-degree-of-freedom model.
    #[error(transparent)]
    OneDof(#[from] OneDofError),
}

/// Shortest series for a comparison, s.
const SHORTEST_S: f64 = 0.01;

/// [`compare_chosen`] with every drive of the series and both models, for a key's position without noise.
///
/// # Errors
/// See [`CompareError`].
pub fn compare(
    instrument: &Instrument,
    series: &Series,
    setup: &Setup,
    progress: &mut Progress<'_>,
) -> Result<Comparison, CompareError> {
    compare_chosen(instrument, series, &Choice::default(), setup, progress)
}

/// Runs the models under the chosen drives and computes their errors.
///
/// `setup`'s start and duration are replaced by the series'. `progress` receives the share done, and ends the work by
/// returning false.
///
/// # Errors
/// See [`CompareError`].
pub fn compare_chosen(
    instrument: &Instrument,
    series: &Series,
    choice: &Choice,
    setup: &Setup,
    progress: &mut Progress<'_>,
) -> Result<Comparison, CompareError> {
    let (start_s, duration_s) = (series.start_s(), series.end_s() - series.start_s());
    if duration_s < SHORTEST_S {
        return Err(CompareError::TooShort { found_s: duration_s, least_s: SHORTEST_S });
    }
    if duration_s > MAX_DURATION_S {
        return Err(CompareError::TooLong { found_s: duration_s });
    }
    let reduced = reduce(instrument)?.instrument;
    let at_the_back = (choice.position_of == PositionOf::KeyBack).then(|| KeyBack::of(instrument));
    let time_s: Vec<f64> =
        (0..=(duration_s * RATE_HZ).floor() as usize).map(|n| start_s + n as f64 / RATE_HZ).collect();
    let mut notes = Vec::new();
    let position = |of| series.position_of(of, choice.position_of, &instrument.finger);
    let (mut fingertip, key) = (position(PositionOf::Fingertip)?, position(PositionOf::Key)?);
    if fingertip.is_none() && key.is_some() {
        notes.push(
            "driven by fingertip motion: without a recorded force the fingertip's position is unknown. The key's position is used instead; it lags by F/k"
                .into(),
        );
        fingertip = key.clone();
    }
    if key.is_none() && fingertip.is_some() {
        notes.push(
            "driven by key motion: without a recorded force the key's position cannot be computed from the fingertip's"
                .into(),
        );
    }
    let own_force = series.force.as_ref().map(ForceSeries::drive);
    let (own_tip, own_key) = (fingertip.as_ref().map(PositionSeries::drive), key.as_ref().map(PositionSeries::drive));
    let force = |t: f64| own_force.as_ref().map_or(0.0, |own| own(t));
    let tip_position = |t: f64| own_tip.as_ref().map_or([0.0; 2], |own| own(t));
    let key_position = |t: f64| own_key.as_ref().map_or([0.0; 2], |own| own(t));
    let path = |s: &PositionSeries| time_s.iter().copied().map(s.drive()).map(|[y, _]| y).collect::<Vec<f64>>();
    let measured_force_n: Option<Vec<f64>> =
        series.force.as_ref().map(|s| time_s.iter().copied().map(s.drive()).collect());
    let measured_position_m = key.as_ref().or(series.position.as_ref()).map(path);
    let measured_hammer_rise_m = series.hammer_head.as_ref().map(path);

    let mut setup = Setup {
        start_s,
        duration_s: duration_s + 2.0 * setup.settings.step,
        record_every: None,
        ledger: false,
        ..*setup
    };
    // Every step if memory allows, else fewer, but at least as many as the common axis needs.
    setup.record_every = Some(setup.check()?.div_ceil(MAX_ROWS_ASKED).max(1));
    let mut plan = Vec::new();
    for driven in DRIVES.into_iter().filter(|driven| choice.drives.contains(driven)) {
        let has = match driven {
            Prescribed::Force => series.force.is_some(),
            Prescribed::Motion => fingertip.is_some(),
            Prescribed::Rigid => key.is_some(),
        };
        if has {
            plan.extend(MODELS.into_iter().filter(|which| choice.models.contains(which)).map(|which| (driven, which)));
        }
    }
    if plan.is_empty() {
        return Err(CompareError::NoDrive);
    }
    let [force_hz, position_hz, hammer_hz] = choice.tells_to_hz;
    let told_to_hz = force_hz.min(position_hz);
    let resting = time_s.partition_point(|t| *t <= choice.rest_until_s);
    let mut trials = Vec::new();
    for (done, &(driven, which)) in plan.iter().enumerate() {
        let behind = at_the_back.as_ref().filter(|_| (which, driven) == (Which::Action, Prescribed::Rigid));
        let model = match (which, behind) {
            (Which::OneDof, _) => &reduced,
            (Which::Action, Some(behind)) => &behind.instrument,
            (Which::Action, None) => instrument,
        };
        let count = plan.len() as f64;
        let mut own = |share: f64| progress((done as f64 + share) / count);
        let run = match (behind, &key) {
            (Some(behind), Some(key)) => behind.play(key, (&time_s, RATE_HZ), &setup, &mut own)?,
            _ => {
                let drive: &Drive<'_> = match driven {
                    Prescribed::Force => &player::force(&force),
                    Prescribed::Motion => &player::motion(&tip_position),
                    Prescribed::Rigid => &player::rigid(&key_position),
                };
                simulate(model, drive, &setup, &mut own)?
            }
        };
        let key_m = interpolated(&run.time_s, &run.key_m, &time_s);
        let force_n = interpolated(&run.time_s, &run.force_n, &time_s);
        // A force-driven run of a file without position can be compared by the hammer only, and vice versa.
        let drive_hz = match driven {
            Prescribed::Force => force_hz,
            Prescribed::Motion | Prescribed::Rigid if fingertip == key => position_hz,
            Prescribed::Motion | Prescribed::Rigid => position_hz.min(force_hz),
        };
        let (measured, simulated) = match driven {
            Prescribed::Force => (&measured_position_m, &key_m),
            Prescribed::Motion | Prescribed::Rigid => (&measured_force_n, &force_n),
        };
        let played = |disturbed: &PositionSeries, progress: &mut Progress<'_>| {
            let path = disturbed.drive();
            let run = match (behind, driven) {
                (Some(behind), _) => behind.play(disturbed, (&time_s, RATE_HZ), &setup, progress)?,
                (None, Prescribed::Rigid) => simulate(model, &player::rigid(&path), &setup, progress)?,
                (None, _) => simulate(model, &player::motion(&path), &setup, progress)?,
            };
            Ok(interpolated(&run.time_s, &run.force_n, &time_s))
        };
        let path = match driven {
            Prescribed::Force => None,
            Prescribed::Motion => fingertip.as_ref(),
            Prescribed::Rigid => key.as_ref(),
        };
        let noise = choice.path_noise.as_ref().filter(|_| which == Which::Action);
        let force_uncertainty = match (noise, path) {
            (Some(noise), Some(path)) => Some(ForceUncertainty::of(noise, path, &force_n, resting, &played, progress)?),
            _ => None,
        };
        let errors = measured.as_ref().and_then(|m| errors_within(m, simulated, resting, told_to_hz));
        let hammer_rise_m = match model.roles.hammer {
            Some(_) => interpolated(&run.time_s, &run.hammer_rise_m, &time_s),
            None => Vec::new(),
        };
        let hammer_told_to_hz = hammer_hz.min(drive_hz);
        let hammer_errors = measured_hammer_rise_m
            .as_ref()
            .filter(|_| !hammer_rise_m.is_empty())
            .and_then(|m| errors_within(m, &hammer_rise_m, resting, hammer_told_to_hz));
        trials.push(Trial {
            driven,
            which,
            key_m,
            force_n,
            told_to_hz,
            errors,
            force_uncertainty,
            hammer_rise_m,
            hammer_told_to_hz,
            hammer_errors,
        });
    }
    let position_of = choice.position_of;
    let misread = choice.misread.clone();
    Ok(Comparison {
        time_s,
        measured_force_n,
        measured_position_m,
        position_of,
        measured_hammer_rise_m,
        trials,
        notes,
        misread,
    })
}

/// Errors up to a frequency, Hz: both series pass the same low-pass, forward and backward. `None` if nothing is left to
/// compare.
fn errors_within(measured: &[f64], simulated: &[f64], resting: usize, told_to_hz: f64) -> Option<Errors> {
    if told_to_hz >= 0.5 * RATE_HZ {
        return Some(Errors::new(measured, simulated, resting));
    }
    if told_to_hz < LOWEST_LIMIT_HZ {
        return None;
    }
    let low_pass = Butterworth::low_pass(4, told_to_hz, RATE_HZ)?;
    let [m, s] = [measured, simulated].map(|x| low_pass.forth_and_back(x));
    // Band errors are those of the unfiltered series.
    Some(Errors { bands: errors::bands(measured, simulated), ..Errors::new(&m, &s, resting) })
}

impl Comparison {
    /// The trial of a drive and a model.
    pub fn trial(&self, driven: Prescribed, which: Which) -> Option<&Trial> {
        self.trials.iter().find(|t| t.driven == driven && t.which == which)
    }

    /// The measured series of the quantity that results from this drive.
    pub fn measured(&self, driven: Prescribed) -> Option<&Vec<f64>> {
        match driven {
            Prescribed::Force => self.measured_position_m.as_ref(),
            Prescribed::Motion | Prescribed::Rigid => self.measured_force_n.as_ref(),
        }
    }

    /// Describes how much of the explained variance is due to the rest before the touch, and how much is explained
    /// without it; for the action, for each measured quantity.
    pub fn rests(&self) -> Vec<String> {
        let action = self.trials.iter().filter(|trial| trial.which == Which::Action);
        let told = action.filter_map(|trial| {
            let of = |what, errors: Option<&Errors>| Some((what, errors?.rest?));
            let both = [of(outcome(trial.driven), trial.errors.as_ref()), of("hammer", trial.hammer_errors.as_ref())];
            let rests: Vec<_> = both.into_iter().flatten().collect();
            let mut parts: Vec<String> = rests.iter().map(|(_, rest)| share(rest.share, 0)).collect();
            parts.dedup();
            let explained: Vec<String> = rests
                .iter()
                .enumerate()
                .map(|(n, (what, rest))| {
                    let of = if n == 0 { format!("the {what}'s variance") } else { format!("the {what}'s") };
                    format!("{} of {of}", share(rest.explained_without, 1))
                })
                .collect();
            (!rests.is_empty()).then(|| {
                format!(
                    "{}: without the rest before the touch ({} of the variance) the action explains {}",
                    trial.driven.driven(),
                    parts.join(" and "),
                    explained.join(", ")
                )
            })
        });
        told.collect()
    }

    /// Describes, for every recorded motion that drives the action, the accuracy of the computed force.
    pub fn force_uncertainties(&self) -> Vec<String> {
        let action = self.trials.iter().filter(|trial| trial.which == Which::Action);
        action.filter_map(|trial| Some(trial.force_uncertainty?.describe(trial.driven))).collect()
    }

    /// Describes, for every drive, how much each model explains and which one is closer. Where none explains anything,
    /// none is closer; what may be wrong with the recording that drives is the reason.
    pub fn verdicts(&self) -> Vec<String> {
        let mut verdicts = Vec::new();
        for driven in DRIVES {
            let what = outcome(driven);
            let missing = if driven == Prescribed::Force { "position_m" } else { "force_N" };
            let name = driven.driven();
            let trials: Vec<&Trial> = MODELS.iter().filter_map(|which| self.trial(driven, *which)).collect();
            let Some(first) = trials.first() else { continue };
            let told: Vec<(&Trial, &Errors)> =
                trials.iter().filter_map(|trial| Some((*trial, trial.errors.as_ref()?))).collect();
            if self.measured(driven).is_none() {
                verdicts
                    .push(format!("{name}: the file has no column `{missing}` to compare the simulated {what} with"));
            } else if told.is_empty() {
                verdicts.push(format!("{name}: nothing can be concluded on the {what}: above {LOWEST_LIMIT_HZ} Hz the recording holds only noise or nothing"));
            } else if told.iter().all(|(_, errors)| errors.explained <= 0.0) {
                let shares: Vec<String> = told
                    .iter()
                    .map(|(trial, errors)| format!("{} {}", trial.which.spoken(), share(errors.explained, 1)))
                    .collect();
                let who = if told.len() > 1 { "neither model explains any" } else { "the model explains none" };
                let why: String = self.misread_by(driven).iter().map(|reason| format!("; {reason}")).collect();
                let limit = up_to(first.told_to_hz);
                verdicts.push(format!("{name}{limit}: {who} of the {what}'s variance ({}){why}", shares.join(", ")));
            } else {
                let shares: Vec<String> = told
                    .iter()
                    .enumerate()
                    .map(|(n, (trial, errors))| {
                        let of = if n == 0 { format!("of the {what}'s variance") } else { String::new() };
                        format!("{} explains {} {of}", trial.which.spoken(), share(errors.explained, 1))
                            .trim_end()
                            .to_owned()
                    })
                    .collect();
                let nearer = match told[..] {
                    [(_, a), (_, o)] => match a.rms / o.rms.max(f64::MIN_POSITIVE) {
                        r if r < 0.9 => ": the action is nearer",
                        r if r > 1.1 => ": the one-degree-of-freedom model is nearer",
                        _ => ": both are equally near",
                    },
                    _ => "",
                };
                let shares = shares.join(", ").replacen(
                    "one degree of freedom explains",
                    "one degree of freedom",
                    usize::from(told.len() > 1),
                );
                verdicts.push(format!("{name}{}: {shares}{nearer}", up_to(first.told_to_hz)));
            }
            if let Some((trial, hammer)) = trials.iter().find_map(|trial| Some((*trial, trial.hammer_errors.as_ref()?)))
            {
                let (limit, explained) = (up_to(trial.hammer_told_to_hz), share(hammer.explained, 1));
                match verdicts.last_mut().filter(|_| !told.is_empty()) {
                    // One sentence for a drive.
                    Some(verdict) => {
                        let limit = if trial.hammer_told_to_hz == first.told_to_hz { String::new() } else { limit };
                        verdict.push_str(&format!("; the action explains {explained} of the hammer's{limit}"));
                    }
                    None => {
                        verdicts
                            .push(format!("{name}{limit}: the action explains {explained} of the hammer's variance"));
                    }
                }
            }
        }
        verdicts
    }

    /// The verdicts in brief: a heading, then for every drive the share of each measured quantity's variance that the
    /// action explains, and one degree of freedom in brackets. Where no number came out, the verdicts.
    pub fn brief(&self) -> Vec<String> {
        let said = |explained: f64| if explained > 0.0 { share(explained, 1) } else { "nothing".to_owned() };
        // Drive, frequency up to which its first quantity is compared, and what is said of its quantities.
        let mut drives: Vec<(Prescribed, f64, Vec<String>)> = Vec::new();
        let (mut firsts, mut others) = (Vec::new(), Vec::new());
        for driven in DRIVES {
            let trials: Vec<&Trial> = MODELS.iter().filter_map(|which| self.trial(driven, *which)).collect();
            let told: Vec<(&Trial, &Errors)> =
                trials.iter().filter_map(|trial| Some((*trial, trial.errors.as_ref()?))).collect();
            let (mut limits_hz, mut quantities) = (Vec::new(), Vec::new());
            if let [(first, errors), rest @ ..] = &told[..] {
                let brackets: String =
                    rest.iter().map(|(_, errors)| format!(" ({})", said(errors.explained))).collect();
                quantities.push(format!("{} {}{brackets}", outcome(driven), said(errors.explained)));
                firsts.push(first.which);
                others.extend(rest.iter().map(|(trial, _)| trial.which));
                limits_hz.push(first.told_to_hz);
            }
            for trial in &trials {
                if let Some(hammer) = &trial.hammer_errors {
                    quantities.push(format!("hammer {}", said(hammer.explained)));
                    firsts.push(trial.which);
                    limits_hz.push(trial.hammer_told_to_hz);
                }
            }
            if !told.is_empty() && told.iter().all(|(_, errors)| errors.explained <= 0.0) {
                quantities.extend(self.misread_by(driven).iter().cloned());
            }
            if let Some(limit_hz) = limits_hz.first() {
                drives.push((driven, *limit_hz, quantities));
            }
        }
        let (Some(first), Some((_, limit_hz, _))) = (firsts.first(), drives.first()) else { return self.verdicts() };
        let all_alike = drives.iter().all(|(_, hz, _)| hz == limit_hz);
        let limit = if all_alike { up_to(*limit_hz) } else { String::new() };
        let other = others.first().map_or(String::new(), |other| format!(" (by {})", other.spoken()));
        let heading = format!("Variance explained{limit} by {}{other}:", first.spoken());
        let line = |(driven, hz, quantities): &(Prescribed, f64, Vec<String>)| {
            let limit = if all_alike { String::new() } else { up_to(*hz) };
            format!("  {}{limit}: {}", driven.driven(), quantities.join(", "))
        };
        [heading].into_iter().chain(drives.iter().map(line)).collect()
    }

    /// What may be wrong with the recorded quantity that drives, if nothing is explained.
    fn misread_by(&self, driven: Prescribed) -> &[String] {
        match driven {
            Prescribed::Force => &self.misread[0],
            Prescribed::Motion | Prescribed::Rigid => &self.misread[1],
        }
    }

    /// Warnings about the recording: an inverted trace, an offset, or a delay.
    pub fn warnings(&self) -> Vec<String> {
        let (mut warnings, mut delays) = (Vec::new(), Vec::new());
        for (what, unit, driven) in [
            ("position", ("mm", 1e3), &[Prescribed::Force][..]),
            ("force", ("N", 1.0), &[Prescribed::Rigid, Prescribed::Motion]),
        ] {
            let Some(trial) = driven.iter().find_map(|driven| self.trial(*driven, Which::Action)) else { continue };
            let Some(errors) = &trial.errors else { continue };
            let (simulated, Some(measured)) = (trial.simulated(), self.measured(trial.driven)) else { continue };
            if errors.correlation < -0.5 {
                warnings.push(format!(
                    "the measured {what} moves against the simulated one (correlation {:.2}): one of the traces looks inverted",
                    errors.correlation
                ));
                continue;
            }
            let off = measured.iter().zip(simulated).map(|(m, s)| m - s).sum::<f64>() / measured.len() as f64;
            // Only if it makes up most of the error, and more than a fiftieth of the range.
            if off * off > 0.5 * errors.rms * errors.rms
                && off.abs() > 0.02 * errors.rms / errors.rms_of_range.max(1e-12)
            {
                warnings.push(format!(
                    "the measured {what} differs from the simulated one by a constant {:+.3} {}",
                    off * unit.1,
                    unit.0
                ));
            }
            // The delay must halve the missing correlation, or it is one of many equally good ones.
            let shifted = errors::correlation(measured, simulated, (errors.delay_s * RATE_HZ).round() as isize);
            let together = errors::correlation(measured, simulated, 0);
            if errors.delay_s.abs() > 1e-3 && shifted > 0.5 && 1.0 - shifted < 0.5 * (1.0 - together) {
                let when = if errors.delay_s > 0.0 { "later" } else { "earlier" };
                delays.push(format!("the simulated {what} comes {:.2} ms {when}", errors.delay_s.abs() * 1e3));
            }
        }
        if !delays.is_empty() {
            warnings.push(format!("{} than measured: are all channels on one clock?", delays.join(", ")));
        }
        warnings
    }
}

/// Formats a share of the variance in percent with `decimals` decimals; below -1000 %, as "less than -1000 %".
#[must_use]
pub fn share(explained: f64, decimals: usize) -> String {
    if explained < -10.0 { "less than -1000 %".into() } else { format!("{:.decimals$} %", 100.0 * explained) }
}

/// ` up to 120 Hz`; empty without a limit.
fn up_to(hz: f64) -> String {
    if hz < 0.5 * RATE_HZ { format!(" up to {hz:.0} Hz") } else { String::new() }
}
