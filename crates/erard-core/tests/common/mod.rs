//! The grand, and runs of it under named drives, for the physical tests.
#![allow(dead_code, reason = "every test file uses a part of it")]

pub mod digests;
pub mod energy_audit;
pub mod generated;
pub mod ladder;
pub mod mutants;
pub mod perturb;

use std::f64::consts::PI;

use erard::assembly::describe;
use erard::instrument::Instrument;
use erard::player::{self, Action, Drive};
use erard::run::Run;
use erard::run::{Setup, simulate};
use erard::stroke::{PositionSeries, Series, Touch};
use moreau::{FrictionLaw, Loss, Model, Settings, State};

/// The usual step, s.
pub const USUAL_STEP_S: f64 = 50e-6;

/// The shipped concert grand, whose key and shank bend.
pub fn grand() -> Instrument {
    Instrument::builtin("concert-grand").expect("the built-in grand reads")
}

/// The papers' six rigid bodies.
pub fn rigid_grand() -> Instrument {
    Instrument::builtin("concert-grand-rigid").expect("the built-in grand reads")
}

/// The shipped concert grand with strings, on its soundboard.
pub fn strung() -> Instrument {
    Instrument::builtin("concert-grand-strings").expect("the built-in grand reads")
}

/// An instrument whose bridge stands still: what strings do by themselves.
pub fn with_rigid_bridge(mut instrument: Instrument) -> Instrument {
    instrument.edit(|fields| fields.roles.rigid_bridge = true).expect("a role alone");
    instrument
}

/// The rigid grand in the engine's own types, at rest.
pub fn rigid_grand_at_rest() -> (Model<f64, 6, 14>, State<f64, 6, 14>) {
    let grand = rigid_grand();
    let action = Action::with(&grand, Settings::new(USUAL_STEP_S)).expect("it comes to rest");
    let mut rest = describe(&grand);
    rest.angles = action.angles().to_vec();
    (rest.model().expect("six bodies, fourteen zones"), State::at_rest(rest.first_angles()))
}

/// The rigid grand's own stroke: the built-in ones may be made anew, its bits stay.
pub fn frozen(nuance: &str, touch: Touch) -> Series {
    Series::rigid(nuance, touch).expect("it reads")
}

/// Index of a body.
pub fn body(instrument: &Instrument, name: &str) -> usize {
    instrument.bodies.iter().position(|b| b.name == name).expect("a body of this name")
}

/// How far from its rest a key that was let go may stand, m at its front. The key presses its back-rail cloth with 0.40
/// N, and holds 91 mN at its front by the friction of all pivots it carries (0.0242 N m); the arms' ratio is 265/225.
/// Cloth that has been pressed deeper pushes by 1 - eta of k g^2, cloth that is pressed further by 1 + eta: it rests
/// anywhere between.
pub fn key_rests_within_m(grand: &Instrument) -> f64 {
    let felt = &grand.zones.iter().find(|zone| zone.name == "key_back_rail").expect("a cloth").felt;
    let eta = if let Loss::Iwan(law) = felt.loss { law.eta } else { 0.0 };
    let (arms, weight_n) = (265.0 / 225.0, 0.40);
    let friction_n = 91e-3 * arms;
    let pressed = |force_n: f64, part: f64| (force_n / (part * felt.stiffness)).sqrt();
    arms * (pressed(weight_n + friction_n, 1.0 - eta) - pressed(weight_n - friction_n, 1.0 + eta))
}

/// tanh-regularised friction of a width in rad/s, a tenth of it in m/s at sliding contacts.
pub fn regularised(width: f64) -> FrictionLaw<f64> {
    FrictionLaw::Regularised { pivot_width: width, sliding_width: 0.1 * width }
}

/// A drive with the time it takes.
#[derive(Debug, Clone)]
pub enum Play {
    /// Nothing.
    Free,
    /// A constant force, N, taken away at an instant, s.
    ForceStep(f64, f64),
    /// A built-in stroke's force.
    Stroke(&'static str, Touch),
    /// A built-in stroke's motion, with a soft finger.
    Motion(&'static str, Touch),
    /// A built-in stroke's motion, imposed on the key.
    Rigid(&'static str, Touch),
    /// A frozen stroke's force ([`frozen`]).
    Frozen(&'static str, Touch),
    /// A frozen stroke's motion, with a soft finger.
    FrozenMotion(&'static str, Touch),
    /// A frozen stroke's motion, imposed on the key.
    FrozenRigid(&'static str, Touch),
    /// A soft finger going up and down between two depths (m) at a frequency (Hz), from the upper one.
    Tremolo {
        /// Depth of the finger's upper turning point, m.
        top: f64,
        /// Of its lower one, m.
        bottom: f64,
        /// Strokes per second.
        frequency: f64,
    },
}

impl Play {
    /// All ten built-in strokes.
    pub fn strokes() -> impl Iterator<Item = Play> {
        erard::stroke::NUANCES
            .into_iter()
            .flat_map(|nuance| [Touch::Pressed, Touch::Struck].map(|touch| Play::Stroke(nuance, touch)))
    }

    /// The ten of them that are frozen.
    pub fn frozen_strokes() -> impl Iterator<Item = Play> {
        erard::stroke::NUANCES
            .into_iter()
            .flat_map(|nuance| [Touch::Pressed, Touch::Struck].map(|touch| Play::Frozen(nuance, touch)))
    }

    /// Constant forces from pianissimo to more than fortissimo, held for 0.5 s.
    pub fn force_steps() -> impl Iterator<Item = Play> {
        [0.8, 2.0, 5.0, 8.0, 20.0, 35.0].into_iter().map(|n| Play::ForceStep(n, 0.5))
    }

    /// Runs it.
    pub fn run(&self, instrument: &Instrument, settings: Settings<f64>, duration_s: f64) -> Run {
        self.run_every(instrument, settings, duration_s, None)
    }

    /// Runs it, keeping a row every so many steps.
    pub fn run_every(
        &self,
        instrument: &Instrument,
        settings: Settings<f64>,
        duration_s: f64,
        record_every: Option<u64>,
    ) -> Run {
        self.run_controlled(instrument, settings, duration_s, record_every, None)
    }

    /// Runs it, with the error controlled if there is a tolerance.
    pub fn run_controlled(
        &self,
        instrument: &Instrument,
        settings: Settings<f64>,
        duration_s: f64,
        record_every: Option<u64>,
        tolerance: Option<f64>,
    ) -> Run {
        let setup = Setup { settings, record_every, tolerance, ..Setup::new(duration_s) };
        self.with_drive(|drive| {
            simulate(instrument, drive, &setup, &mut |_| true).unwrap_or_else(|e| panic!("{self:?}: {e}"))
        })
    }

    /// Does something with its drive.
    pub fn with_drive<R>(&self, go: impl FnOnce(&Drive<'_>) -> R) -> R {
        match *self {
            Play::Free => go(&|_| player::Input::Free),
            Play::ForceStep(force, until) => go(&player::force(|t| if t < until { force } else { 0.0 })),
            Play::Stroke(nuance, touch) => {
                let series = Series::builtin(nuance, touch).and_then(|s| s.force).expect("built in");
                go(&player::force(series.drive()))
            }
            Play::Motion(nuance, touch) => go(&player::motion(&motion(nuance, touch).drive())),
            Play::Rigid(nuance, touch) => go(&player::rigid(&motion(nuance, touch).drive())),
            Play::Frozen(nuance, touch) => go(&player::force(frozen(nuance, touch).force.expect("it has one").drive())),
            Play::FrozenMotion(nuance, touch) => {
                go(&player::motion(&frozen(nuance, touch).position.expect("it has one").drive()))
            }
            Play::FrozenRigid(nuance, touch) => {
                go(&player::rigid(&frozen(nuance, touch).position.expect("it has one").drive()))
            }
            Play::Tremolo { top, bottom, frequency } => go(&player::motion(|t| tremolo(top, bottom, frequency, t))),
        }
    }
}

/// A finger's position and velocity: a cosine from `top` to `bottom` and back.
pub fn tremolo(top: f64, bottom: f64, frequency: f64, t: f64) -> [f64; 2] {
    let (half, w) = (0.5 * (bottom - top), 2.0 * PI * frequency);
    [top + half * (1.0 - (w * t).cos()), half * w * (w * t).sin()]
}

/// The motion of a built-in stroke.
fn motion(nuance: &str, touch: Touch) -> PositionSeries {
    Series::builtin(nuance, touch).and_then(|s| s.position).expect("built in")
}

/// Largest absolute value.
pub fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().fold(0.0, |m, x| m.max(x.abs()))
}
