//! One mechanism of any size.

use moreau::{
    Accuracy, Contact, ControlledStep, Energies, Input, Ledger, LossIn, ModelError, SavedState, Settings, StepReport,
};

use crate::controlled::InputDuring;
use crate::engine::Engine;
use crate::observation::Observation;
use crate::size::with_size;
use crate::surfaces::{Halving, Surfaces};
use crate::{Impact, OwnedDescription, Probes, Size};

/// Output of a step. Places and speeds are those at the step's end; forces acted in the step, at its theta point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepOutput {
    /// World coordinate of the driven point along the drive's direction, m.
    pub site_m: f64,
    /// Its speed in that direction, m/s.
    pub site_m_per_s: f64,
    /// Force of the drive on the mechanism, N.
    pub drive_n: f64,
    /// World coordinate of the hand along the drive's direction, m, and its velocity, m/s.
    pub hand: [f64; 2],
    /// The marked point in the world, m.
    pub point_m: [f64; 2],
    /// Its velocity, m/s.
    pub point_m_per_s: [f64; 2],
    /// Normal force of the marked zone, N.
    pub zone_n: f64,
    /// The impact of the marked point on the marked zone in the step, if there was one.
    pub impact: Option<Impact>,
    /// Outcome and work of the step; a skipped step has the report of the step that it repeats.
    pub report: StepReport,
}

/// Settings of the steps, and the outputs that are kept.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stepping {
    /// The engine's settings.
    pub settings: Settings<f64>,
    /// Number of halvings of a step while something is near the first surface; at first, as the surfaces require.
    pub halving: Halving,
    /// Whether steps that are known to change nothing are left out, as at first. The results are the same bits.
    pub may_rest: bool,
    /// Whether [`Readout::contacts`] is kept after every step, as a ledger needs it; not at first.
    pub keeps_contacts: bool,
}

/// A part of a mechanism's state, to be set from outside.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Part {
    /// The present instant, s; the flight of the marked point so far is forgotten.
    Instant(f64),
    /// All velocities of bodies, to zero.
    Standstill,
    /// The hand: world coordinate along the drive's direction, m, and velocity, m/s.
    Hand([f64; 2]),
}

/// The present state of a mechanism and what acted in its last step, whatever its size. Slices follow the description's
/// bodies and zones.
#[derive(Clone, Copy)]
pub struct Readout<'a> {
    /// The present instant, s.
    pub now_s: f64,
    /// Length of the last step, or part of one, or half of an adaptive one, s.
    pub last_step_s: f64,
    /// Whether the last step changed nothing: with the same input the next one does not either.
    pub rests: bool,
    /// Whether the last step left the bodies out, as it would have changed nothing of them: with the same input only
    /// what is under the zones goes on, which cannot reach them.
    pub bodies_rest: bool,
    /// Output of the last step.
    pub output: &'a StepOutput,
    /// Absolute angles, rad.
    pub angles: &'a [f64],
    /// Absolute angular velocities, rad/s.
    pub velocities: &'a [f64],
    /// Dry friction torques of the pivots in the last step, N m.
    pub pivot_friction: &'a [f64],
    /// The zones as they acted in the last step, where [`Stepping::keeps_contacts`], else none; those that were not
    /// touched are `None`. There may be more places than zones.
    pub contacts: &'a [Option<Contact<f64>>],
    /// Coulomb forces of the zones in the last step, N. There may be more places than zones.
    pub tangential_forces: &'a [f64],
    /// Settings of the steps.
    pub stepping: &'a Stepping,
    /// The compliant external subsystem under the zones, where there is one.
    pub surfaces: Option<&'a dyn Surfaces>,
}

/// All that the following steps depend on, in plain numbers of any size: bodies and zones beyond the mechanism's are
/// zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Saved {
    /// The engine's state, in the largest size.
    pub state: SavedState<f64, 12, 32>,
    /// Instant, s: steps since an origin, and the origin.
    pub origin_s: f64,
    /// See `origin_s`.
    pub steps: u64,
    /// The present instant, s.
    pub now_s: f64,
    /// The last two samples of the marked zone: instant, s; compression, m; speed of the point, m/s.
    pub flight: [Option<[f64; 3]>; 2],
}

/// An assembled mechanism, whatever its size: this trait erases the sizes that the engine is compiled for. Indices
/// follow the description's bodies and zones. No function but those that say so allocates.
pub trait Mechanism: Observation + Send {
    /// Advances by one step of the current settings. Where it is taken in parts ([`Surfaces::parts`]) forces are held
    /// for all of them and places go on at their velocities; the output's forces are those of the last part.
    fn step(&mut self, input: &Input<f64>) -> &StepOutput;
    /// The same, with an input for each part and `observe` called after each; true after the last one. Where a number
    /// is not finite the parts before stay taken.
    fn step_in_parts(&mut self, input: &mut InputDuring, observe: &mut dyn FnMut(&dyn Mechanism, bool)) -> StepReport;
    /// Advances by one step that is as long as its error allows, and at most `limit` s. `ends` gives the instant of so
    /// many s after the step's start; `observe` is called after each of its two halves. Allocates when the first step
    /// is taken.
    fn controlled_step(
        &mut self,
        accuracy: &Accuracy<f64>,
        limit: f64,
        ends: &dyn Fn(f64) -> f64,
        input: &mut InputDuring,
        observe: &mut dyn FnMut(&dyn Mechanism),
    ) -> ControlledStep<f64>;
    /// The present state, and what acted in the last step.
    fn readout(&self) -> Readout<'_>;
    /// Changes how steps are taken, from the next one on. Allocates when contacts begin to be kept.
    fn configure(&mut self, stepping: Stepping);
    /// Sets a part of the state from outside, for the next step on.
    fn set(&mut self, part: Part);
    /// Stored energies if the mechanism moved at the given velocities from where it is, J.
    fn energies_at(&self, velocities: &[f64]) -> Energies;
    /// Books the last step in a ledger ([`open_ledger`]); of one taken in parts, the last part. Whoever keeps a ledger
    /// books each part ([`Mechanism::step_in_parts`]).
    fn book(&self, ledger: &mut Ledger);
    /// Reports what each pivot and each zone has lost in the last step, J, where [`Stepping::keeps_contacts`]: what a
    /// ledger books.
    fn each_loss(&self, lose: &mut dyn FnMut(LossIn, f64));
    /// All that the following steps depend on, but for [`Readout::surfaces`].
    fn save(&self) -> Saved;
    /// Goes on from there, to the bit.
    fn restore(&mut self, saved: &Saved);
    /// The subsystem under the zones, to be changed; the mechanism then takes its next step.
    fn surfaces_mut(&mut self) -> Option<&mut (dyn Surfaces + 'static)>;
}

/// Assembles a mechanism into the smallest size that holds it. Its zones press on `surfaces` if there are any; the
/// description says which ones then yield. Such a mechanism takes fixed steps only, and parts of them.
///
/// # Errors
/// [`ModelError`] if no size holds it, or a number is not sound.
pub fn mechanism(
    description: &OwnedDescription,
    probes: &Probes,
    settings: Settings<f64>,
    surfaces: Option<Box<dyn Surfaces>>,
) -> Result<Box<dyn Mechanism>, ModelError> {
    with_size!(Size::of(description), boxed, description, probes, settings, surfaces)
}

fn boxed<const B: usize, const Z: usize, const N: usize>(
    description: &OwnedDescription,
    probes: &Probes,
    settings: Settings<f64>,
    surfaces: Option<Box<dyn Surfaces>>,
) -> Result<Box<dyn Mechanism>, ModelError> {
    Ok(Box::new(Engine::<B, Z, N>::new(description, probes, settings, surfaces)?))
}

/// A ledger that is opened where a mechanism is; from now on the mechanism keeps its contacts. Allocates the first
/// time.
pub fn open_ledger(mechanism: &mut dyn Mechanism) -> Ledger {
    // This also wakes it, so that what rests is booked at least once.
    mechanism.configure(Stepping { keeps_contacts: true, ..*mechanism.readout().stepping });
    let now = mechanism.readout();
    let [lost, given] = now.surfaces.map_or([0.0; 2], |surfaces| [surfaces.lost(), surfaces.given()]);
    Ledger::open_at(mechanism.energies_at(now.velocities), lost, given)
}

/// Records a mechanism's stored energy, to which the ledger's residual refers.
pub fn take_stock(mechanism: &dyn Mechanism, ledger: &mut Ledger) {
    ledger.now = mechanism.energies_at(mechanism.readout().velocities);
}
