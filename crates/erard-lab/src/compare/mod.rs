//! A measured stroke beside the models: what each drive and each model explains of it.
//!
//! A file with a force drives the key by that force, and the key's motion comes out; one with a position drives a soft finger
//! by that position, and the key itself rigidly, and the finger's force comes out. With both, what comes out can be held
//! against what was measured [T12 fig. 3]. A position measured on the key belongs to the rigid drive (which makes force out of
//! the noise of its curvature), one measured on the finger to the soft one.

mod errors;

pub use errors::{BANDS_HZ, Band, Errors};

use thiserror::Error;

use erard::instrument::Instrument;
use erard::one_dof::{OneDofError, reduce};
use erard::player::{self, Drive};
use erard::simulation::{MOST_ROWS_ASKED, Setup, SimulationError, simulate};
use erard::stroke::{ForceSeries, PositionSeries, Series};

/// Rate of the common time axis, Hz: twice what the highest band needs.
pub const RATE_HZ: f64 = 4000.0;

/// What drives a comparison's run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Driven {
    /// The measured force; the key's position comes out.
    ByForce,
    /// The measured position, through the soft finger; the force comes out.
    ByMotion,
    /// The measured position, imposed on the key; the force comes out.
    Rigidly,
}

/// All drives, in the order in which they are tried and shown.
pub const DRIVES: [Driven; 3] = [Driven::ByForce, Driven::ByMotion, Driven::Rigidly];

/// Which model ran.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Which {
    /// All bodies.
    Action,
    /// One degree of freedom.
    OneDof,
}

impl Driven {
    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Driven::ByForce => "force",
            Driven::ByMotion => "motion",
            Driven::Rigidly => "rigid",
        }
    }
}

impl Which {
    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Which::Action => "action",
            Which::OneDof => "one-dof",
        }
    }
}

/// One run of a comparison, on the common time axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Trial {
    /// What drove it.
    pub driven: Driven,
    /// Which model.
    pub which: Which,
    /// Travel of the key front, m, down positive.
    pub key_m: Vec<f64>,
    /// Finger force, N.
    pub force_n: Vec<f64>,
    /// What came out against what was measured (position in m, force in N); `None` where the file holds no such series.
    pub errors: Option<Errors>,
    /// Rise of the hammer's strike point, m; empty for a model without a hammer.
    pub hammer_m: Vec<f64>,
    /// The same against what was measured, where both exist.
    pub hammer_errors: Option<Errors>,
}

/// A measured stroke and the runs beside it.
#[derive(Debug, Clone, PartialEq)]
pub struct Comparison {
    /// Common time axis, s.
    pub time_s: Vec<f64>,
    /// Measured force, N.
    pub measured_force_n: Option<Vec<f64>>,
    /// Measured position, m.
    pub measured_position_m: Option<Vec<f64>>,
    /// Measured rise of the hammer's strike point, m.
    pub measured_hammer_m: Option<Vec<f64>>,
    /// In the order of [`DRIVES`], the action before the one-degree-of-freedom model.
    pub trials: Vec<Trial>,
}

/// Longest series that is compared, s: a million instants of the common axis.
pub const LONGEST_S: f64 = 250.0;

/// Why a comparison cannot be made.
#[derive(Debug, Error)]
pub enum CompareError {
    /// The measured series is too short to say anything.
    #[error("the measured series lasts {found_s:.4} s; at least {least_s} s are needed to compare anything")]
    TooShort {
        /// s.
        found_s: f64,
        /// s.
        least_s: f64,
    },
    /// The measured series would not fit into memory beside what the models make of it.
    #[error("the measured series lasts {found_s} s; at most {LONGEST_S} s are compared")]
    TooLong {
        /// s.
        found_s: f64,
    },
    /// A model does not run.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    /// No one-degree-of-freedom model follows.
    #[error(transparent)]
    OneDof(#[from] OneDofError),
}

/// Shortest series that is compared, s.
const SHORTEST_S: f64 = 0.01;

/// Runs both models under every drive that the series has, and measures what they miss.
///
/// `setup`'s start and duration are replaced by the series'. `progress` is told the share done, and ends the work by
/// returning false.
///
/// # Errors
/// See [`CompareError`].
pub fn compare(
    instrument: &Instrument,
    series: &Series,
    setup: &Setup,
    progress: &mut dyn FnMut(f64) -> bool,
) -> Result<Comparison, CompareError> {
    let (start_s, duration_s) = (series.start_s(), series.end_s() - series.start_s());
    if duration_s < SHORTEST_S {
        return Err(CompareError::TooShort { found_s: duration_s, least_s: SHORTEST_S });
    }
    if duration_s > LONGEST_S {
        return Err(CompareError::TooLong { found_s: duration_s });
    }
    let reduced = reduce(instrument)?.instrument;
    let time_s: Vec<f64> =
        (0..=(duration_s * RATE_HZ).floor() as usize).map(|n| start_s + n as f64 / RATE_HZ).collect();
    let (own_force, own_position) =
        (series.force.as_ref().map(ForceSeries::drive), series.position.as_ref().map(PositionSeries::drive));
    let force = |t: f64| own_force.as_ref().map_or(0.0, |own| own(t));
    let position = |t: f64| own_position.as_ref().map_or([0.0; 2], |own| own(t));
    let path = |s: &PositionSeries| time_s.iter().copied().map(s.drive()).map(|[y, _]| y).collect::<Vec<f64>>();
    let measured_force_n: Option<Vec<f64>> =
        series.force.as_ref().map(|s| time_s.iter().copied().map(s.drive()).collect());
    let measured_position_m = series.position.as_ref().map(path);
    let measured_hammer_m = series.hammer_head.as_ref().map(path);

    let mut setup = Setup {
        start_s,
        duration_s: duration_s + 2.0 * setup.settings.step,
        record_every: None,
        ledger: false,
        ..*setup
    };
    // Every step as long as memory allows; then fewer, but none farther apart than the common axis needs.
    setup.record_every = Some(setup.check()?.div_ceil(MOST_ROWS_ASKED).max(1));
    let mut plan = Vec::new();
    for driven in DRIVES {
        let has = match driven {
            Driven::ByForce => series.force.is_some(),
            Driven::ByMotion | Driven::Rigidly => series.position.is_some(),
        };
        if has {
            plan.extend([(driven, Which::Action), (driven, Which::OneDof)]);
        }
    }
    let mut trials = Vec::new();
    for (done, &(driven, which)) in plan.iter().enumerate() {
        let drive: &Drive<'_> = match driven {
            Driven::ByForce => &player::force(&force),
            Driven::ByMotion => &player::motion(&position),
            Driven::Rigidly => &player::rigid(&position),
        };
        let model = if which == Which::Action { instrument } else { &reduced };
        let count = plan.len() as f64;
        let run = simulate(model, drive, &setup, &mut |share| progress((done as f64 + share) / count))?;
        let key_m = sample(&run.time_s, &run.key_m, &time_s);
        let force_n = sample(&run.time_s, &run.force_n, &time_s);
        let errors = match driven {
            Driven::ByForce => measured_position_m.as_ref().map(|m| Errors::new(m, &key_m)),
            Driven::ByMotion | Driven::Rigidly => measured_force_n.as_ref().map(|m| Errors::new(m, &force_n)),
        };
        let hammer_m = match model.roles.hammer {
            Some(_) => sample(&run.time_s, &run.hammer_head_m, &time_s),
            None => Vec::new(),
        };
        let hammer_errors =
            measured_hammer_m.as_ref().filter(|_| !hammer_m.is_empty()).map(|m| Errors::new(m, &hammer_m));
        trials.push(Trial { driven, which, key_m, force_n, errors, hammer_m, hammer_errors });
    }
    Ok(Comparison { time_s, measured_force_n, measured_position_m, measured_hammer_m, trials })
}

impl Comparison {
    /// The trial of a drive and a model.
    pub fn trial(&self, driven: Driven, which: Which) -> Option<&Trial> {
        self.trials.iter().find(|t| t.driven == driven && t.which == which)
    }

    /// In words: for every drive, how much each model explains, and which is nearer.
    pub fn verdicts(&self) -> Vec<String> {
        let mut verdicts = Vec::new();
        for driven in DRIVES {
            let (what, missing) = match driven {
                Driven::ByForce => ("position", "position_m"),
                Driven::ByMotion | Driven::Rigidly => ("force", "force_N"),
            };
            let (Some(action), Some(one_dof)) = (self.trial(driven, Which::Action), self.trial(driven, Which::OneDof))
            else {
                continue;
            };
            let name = driven.name();
            verdicts.push(match (&action.errors, &one_dof.errors) {
                (Some(a), Some(o)) => {
                    let nearer = match a.rms / o.rms.max(f64::MIN_POSITIVE) {
                        r if r < 0.9 => "the action is nearer",
                        r if r > 1.1 => "the one-degree-of-freedom model is nearer",
                        _ => "both are equally near",
                    };
                    format!(
                        "{name} driven: the action explains {:.1} % of the {what}'s variance, one degree of freedom {:.1} %: {nearer}",
                        100.0 * a.explained,
                        100.0 * o.explained,
                    )
                }
                _ => format!(
                    "{name} driven: the file has no column `{missing}`, so that the {what} that comes out stands alone"
                ),
            });
            if let Some(hammer) = &action.hammer_errors {
                verdicts.push(format!(
                    "{name} driven: the action explains {:.1} % of the hammer's variance",
                    100.0 * hammer.explained
                ));
            }
        }
        verdicts
    }
}

/// A series at other instants, linearly interpolated; both axes ascend.
fn sample(time: &[f64], values: &[f64], at: &[f64]) -> Vec<f64> {
    let mut i = 0;
    at.iter()
        .map(|&t| {
            while i + 2 < time.len() && time[i + 1] <= t {
                i += 1;
            }
            let share = ((t - time[i]) / (time[i + 1] - time[i])).clamp(0.0, 1.0);
            values[i] + share * (values[i + 1] - values[i])
        })
        .collect()
}
