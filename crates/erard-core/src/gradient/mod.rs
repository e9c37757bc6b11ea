//! Derivatives of a key press: how its instants and speeds depend on the numbers of the instrument and on the force, by
//! forward mode.
//!
//! The press is played once in dual numbers ([`moreau_kernels::Tangents`]), up to eight directions at a time, from its
//! rest to the impact. This differentiates the motion itself, with dry friction that truly sticks and felts that are
//! not smoothed: steps end where sliding stops or reverses, and there the derivatives jump as they must (the engine's
//! README, "Derivatives"). The smooth map from an instrument's numbers to the mechanism's is differentiated by
//! differences.
//!
//! It starts at the rest of [`crate::simulate`], to the bit ([`Poses`]). With dry friction an action can rest in many
//! poses, depending on its history. A [`Direction`] therefore determines how the rest changes: [`Direction::moving`]
//! moves it as the rest of `simulate` moves; [`Direction::between`] alone holds it, as in an action that is changed
//! while its friction holds it.
//!
//! A derivative is valid for the smooth piece of the solution that contains the press. It does not show nearby jumps of
//! the solution, for example between one and two impacts of the hammer.

mod start;
mod watch;

pub use moreau_kernels::{DIRECTIONS, Number};
pub use start::Poses;
pub use watch::{Instants, QUANTITIES};

use moreau::{ModelError, Real, Settings, SiteInput, Switch, SwitchKind, TangentError, TangentReport};
use moreau_kernels::{Tangents, tangents};
use thiserror::Error;

use crate::assembly::describe;
use crate::instrument::Instrument;
use crate::player::{self, Drive};
use crate::progress::Progress;
use crate::run::{Setup, SimulationError};
use start::Moves;
use watch::DualEventDetector;

/// Why there are no derivatives.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum GradientError {
    /// The run could not be made.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    /// Static friction.
    #[error(
        "derivatives are not supported with friction that grows at rest (`dwell_s`), whose bound jumps at release; expected an instrument without it"
    )]
    Dwell,
    /// A set-valued felt.
    #[error(
        "derivatives are not supported with a felt with `dry_loss` and no `dry_slip`; expected `dry_slip` above 0, or no `dry_loss`"
    )]
    SetValuedFelt,
    /// A modal string.
    #[error(
        "derivatives are not supported with modal strings; expected a rigid string (`rigid_string = true` in [roles])"
    )]
    Yielding,
    /// A feature of the engine that has no derivatives.
    #[error("{what} has no derivatives here")]
    NotDerived {
        /// Name of the part without derivatives.
        what: &'static str,
    },
    /// Changing the number changes the structure of the mechanism.
    #[error("a small change of the number changes what the mechanism is made of")]
    Makeup,
    /// Error control.
    #[error("derivatives need fixed steps; remove the tolerance")]
    Controlled,
    /// More directions than the dual numbers hold.
    #[error("found {found} directions, expected at most {DIRECTIONS}")]
    Directions {
        /// Number of directions.
        found: usize,
    },
}

impl GradientError {
    /// Whether the caller asked to stop.
    pub fn is_interruption(&self) -> bool {
        matches!(self, GradientError::Simulation(SimulationError::Interrupted))
    }
}

impl From<TangentError> for GradientError {
    fn from(error: TangentError) -> Self {
        match error {
            TangentError::Model(error) => SimulationError::from(error).into(),
            TangentError::Dwell => GradientError::Dwell,
            TangentError::SetValuedFelt => GradientError::SetValuedFelt,
            TangentError::Yielding => GradientError::Yielding,
            _ => GradientError::NotDerived { what: "this mechanism" },
        }
    }
}

impl From<ModelError> for GradientError {
    fn from(error: ModelError) -> Self {
        SimulationError::from(error).into()
    }
}

/// Variation, to first order.
#[derive(Debug, Clone, PartialEq)]
pub struct Direction {
    /// The derivative of every number of the mechanism's description.
    numbers: Vec<f64>,
    /// Derivative of the hammer's strike point, m.
    head: [f64; 2],
    /// Derivative of the force on the key, N.
    force: f64,
    /// Derivatives of the poses at the start; `None` where they are held.
    moves: Option<Moves>,
}

impl Direction {
    /// The force on the key: by 1 N.
    pub fn force() -> Self {
        Direction { numbers: Vec::new(), head: [0.0; 2], force: 1.0, moves: None }
    }

    /// Direction from an instrument with a number a little lower to one with the number higher by `apart`. The pose at
    /// the start is held.
    ///
    /// # Errors
    /// [`GradientError::Makeup`].
    pub fn between(low: &Instrument, high: &Instrument, apart: f64) -> Result<Self, GradientError> {
        let [a, b] = [low, high].map(describe::<f64>);
        let [x, y] = [a.numbers(), b.numbers()];
        let kinds = |d: &moreau_kernels::OwnedDescription| d.zones.iter().map(|z| z.felt.kind()).collect::<Vec<_>>();
        if x.len() != y.len() || kinds(&a) != kinds(&b) {
            return Err(GradientError::Makeup);
        }
        let slope = |(x, y): (&f64, &f64)| (y - x) / apart;
        let numbers = x.iter().zip(&y).map(slope).collect();
        let [p, q] = [low, high].map(|one| one.roles.hammer_strike_point_m);
        Ok(Direction { numbers, head: [slope((&p[0], &q[0])), slope((&p[1], &q[1]))], force: 0.0, moves: None })
    }

    /// This direction with moving poses at the start: from those with the number a little lower to those with it higher
    /// by `apart`.
    #[must_use]
    pub fn moving(self, low: &Poses, high: &Poses, apart: f64) -> Self {
        Direction { moves: Some(Moves::between(low, high, apart)), ..self }
    }
}

/// A switch of friction in a press.
#[derive(Debug, Clone, PartialEq)]
pub struct SwitchAt {
    /// When, s.
    pub time_s: f64,
    /// Law and kind of the switch.
    pub switch: Switch,
    /// Derivatives of the bodies' angular velocities at the end of the step, rad/s per unit of every direction.
    pub slopes: Vec<[f64; DIRECTIONS]>,
}

/// Result of a press in dual numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct Followed {
    /// Instants and speeds; slopes in the order of the directions.
    pub instants: Instants,
    /// Key travel and rise of the strike point, m, and the finger's force, N, after every step that was asked for, from
    /// the start on; until the end of the setup's duration then. Under a rigid drive the force is the one that its
    /// motion takes, and is not known here: NaN.
    pub samples: Vec<[Number; 3]>,
    /// Switches of friction, in the order of time.
    pub switches: Vec<SwitchAt>,
    /// Steps in which velocities or derivatives did not converge.
    pub unconverged: u32,
}

impl Followed {
    /// Switches at which derivatives jumped, and switches so close together that they could not be resolved:
    /// derivatives may then be wrong.
    pub fn counts(&self) -> [u32; 2] {
        let unresolved = self.switches.iter().filter(|one| one.switch.kind == SwitchKind::Unresolved).count();
        [self.switches.len() - unresolved, unresolved].map(|count| count as u32)
    }
}

/// Reports of a press in dual numbers, and its rule at switches that cannot be distinguished.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct How {
    /// Steps between two samples, if there are to be any.
    pub sample_every: Option<u64>,
    /// Derivatives continue unchanged across switches that cannot be distinguished. Their distance from those of the
    /// other method, which steps across, is the uncertainty that such switches cause.
    pub passes_unresolved: bool,
}

/// Checks whether an instrument has derivatives at all: gives the errors of [`follow`] before any work.
///
/// # Errors
/// See [`GradientError`].
pub fn check(instrument: &Instrument) -> Result<(), GradientError> {
    tangents(&describe::<f64>(instrument), &[])?;
    Ok(())
}

/// Presses the key in dual numbers with at most [`DIRECTIONS`] directions. The run ends when all events have been
/// found, at the latest with the setup's duration; with samples, it ends with the duration.
///
/// It starts at `poses`: those of the instrument ([`Poses::of`]).
///
/// # Errors
/// See [`GradientError`].
///
/// Call it on a thread with [`STACK_BYTES`] of stack.
pub fn follow(
    instrument: &Instrument,
    directions: &[Direction],
    drive: &Drive<'_>,
    setup: &Setup,
    poses: &Poses,
    how: How,
    progress: &mut Progress<'_>,
) -> Result<Followed, GradientError> {
    let How { sample_every, passes_unresolved } = how;
    if directions.len() > DIRECTIONS {
        return Err(GradientError::Directions { found: directions.len() });
    }
    let steps = setup.check()?;
    if setup.tolerance.is_some() {
        return Err(GradientError::Controlled);
    }
    let by_hand = setup.driven(drive).map_err(SimulationError::from)?;
    let drive: &Drive<'_> = &by_hand;
    if instrument.roles.key.is_none() && drive(setup.start_s) != player::Input::Free {
        return Err(SimulationError::NoKey.into());
    }
    let description = describe::<f64>(instrument);
    let mut slopes = vec![[0.0; DIRECTIONS]; description.numbers().len()];
    let (mut head, mut force) = (instrument.roles.hammer_strike_point_m.map(Number::constant), [0.0; DIRECTIONS]);
    for (d, direction) in directions.iter().enumerate() {
        for (all, one) in slopes.iter_mut().zip(&direction.numbers) {
            all[d] = *one;
        }
        head[0].slope[d] = direction.head[0];
        head[1].slope[d] = direction.head[1];
        force[d] = direction.force;
    }
    let mut mechanism = tangents(&description, &slopes)?;
    let [at_rest, mut start] = start::dual(poses, directions.iter().map(|one| one.moves.as_ref()));
    if passes_unresolved {
        mechanism.pass_unresolved();
    }
    mechanism.begin(&at_rest);
    let site = mechanism.site_position();
    let rest = Places { site, head, force };
    let mut watch = DualEventDetector::new(instrument, &rest, mechanism.as_ref());
    if let Some(hand) = &setup.hand {
        start.hand = [site + Number::constant(hand.start_m), Number::constant(hand.start_m_per_s)];
    }
    mechanism.begin(&start);
    let settings = Settings { tolerance: setup.settings.tolerance.min(TOLERANCE), ..setup.settings };
    let h = settings.step;
    watch.observe(setup.start_s, &setup.settings, mechanism.as_ref());
    let sample = |watch: &DualEventDetector, mechanism: &dyn Tangents, time_s: f64| {
        let [key_m, hammer_rise_m] = watch.travels(mechanism);
        [key_m, hammer_rise_m, rest.force(drive, time_s, mechanism)]
    };
    let first = sample_every.map(|_| sample(&watch, mechanism.as_ref(), setup.start_s));
    let mut samples: Vec<[Number; 3]> = first.into_iter().collect();
    let (mut all, mut switches) = (TangentReport::default(), Vec::new());
    for n in 0..steps {
        if n.is_multiple_of(ASK_EVERY) && !progress(0.0) {
            return Err(SimulationError::Interrupted.into());
        }
        let t0 = setup.start_s + n as f64 * h;
        let before = switches.len();
        let did = mechanism.step(
            &settings,
            &mut |from, length, at| rest.input(drive, t0 + from, length, settings.theta, h, at),
            &mut |switch| switches.push(SwitchAt { time_s: t0 + switch.after_s, switch, slopes: Vec::new() }),
        );
        all = all.and(did);
        for one in &mut switches[before..] {
            one.slopes = mechanism.velocities().iter().map(|v| v.slope).collect();
        }
        if did.failed {
            return Err(SimulationError::NonFinite { time_s: t0 }.into());
        }
        let now = setup.start_s + (n + 1) as f64 * h;
        watch.observe(now, &setup.settings, mechanism.as_ref());
        match sample_every {
            Some(every) if (n + 1).is_multiple_of(every) => samples.push(sample(&watch, mechanism.as_ref(), now)),
            None if watch.has_seen_all() => break,
            _ => {}
        }
    }
    Ok(Followed { instants: watch.finish(), samples, switches, unconverged: all.unconverged })
}

/// Stack that [`follow`] needs on its thread, bytes: a step's working memory in dual numbers is nine times that in
/// plain ones. New threads have less by default.
pub const STACK_BYTES: usize = 64 << 20;

/// Newton's tolerance, so that velocities are as exact as derivatives, which have their own.
const TOLERANCE: f64 = 1e-8;
/// Steps between two questions whether to go on.
const ASK_EVERY: u64 = 64;

/// Reference of travels, and the drive.
struct Places {
    site: Number,
    /// The strike point in the hammer's frame.
    head: [Number; 2],
    force: [f64; DIRECTIONS],
}

impl Places {
    /// The finger's force at an instant, N.
    fn force(&self, drive: &Drive<'_>, t: f64, mechanism: &dyn Tangents) -> Number {
        match drive(t) {
            player::Input::Free => Number::ZERO,
            player::Input::Force(force_n) => Number { value: force_n, slope: self.force },
            player::Input::Motion { position_m, velocity_m_per_s } => {
                mechanism.push(self.site + Number::constant(position_m), Number::constant(velocity_m_per_s))
            }
            player::Input::Rigid { .. } => Number::constant(f64::NAN),
            player::Input::Hand(_) => {
                let [position, velocity] = mechanism.hand();
                mechanism.push(position, velocity)
            }
        }
    }

    /// The engine's input, as [`player::rest::Rest::input`] gives it.
    fn input(
        &self,
        drive: &Drive<'_>,
        t0: f64,
        h: f64,
        theta: f64,
        correction_s: f64,
        at: Number,
    ) -> SiteInput<Number> {
        match drive(t0 + theta * h) {
            player::Input::Free => SiteInput::Free,
            player::Input::Force(force_n) => SiteInput::Force(Number { value: force_n, slope: self.force }),
            player::Input::Motion { position_m, velocity_m_per_s } => SiteInput::Motion {
                position: self.site + Number::constant(position_m),
                velocity: Number::constant(velocity_m_per_s),
            },
            player::Input::Rigid { .. } => {
                let behind = self.site + Number::constant(drive(t0).position_m()) - at;
                let velocity = match drive(t0 + h) {
                    player::Input::Rigid { velocity_m_per_s, .. } => velocity_m_per_s,
                    _ => 0.0,
                };
                let back = Number::constant(player::rest::RIGID_CORRECTION / correction_s);
                SiteInput::Rigid { velocity: Number::constant(velocity) + back * behind }
            }
            player::Input::Hand(hand) => SiteInput::Hand(moreau::SiteHand {
                mass: Number::constant(hand.mass_kg),
                force: Number { value: hand.force_n, slope: self.force },
                stiffness: Number::constant(hand.stiffness_n_per_m),
                damping: Number::constant(hand.damping_n_s_per_m),
                position: self.site + Number::constant(hand.position_m),
                velocity: Number::constant(hand.velocity_m_per_s),
                compliance: Number::constant(hand.joints.compliance_m_per_n),
                retardation: Number::constant(hand.joints.retardation_s),
            }),
        }
    }
}
