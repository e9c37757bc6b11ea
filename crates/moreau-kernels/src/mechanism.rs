//! A single mechanism of any size.

use moreau::{
    Accuracy, Contact, ControlledStep, Energies, Ledger, LossIn, ModelError, SavedState, Settings, SiteInput,
    StepReport,
};

use crate::controlled::InputDuring;
use crate::engine::Engine;
use crate::observation::Observation;
use crate::size::with_size;
use crate::surfaces::{Halving, Surfaces};
use crate::{Impact, OwnedDescription, Probes, Size};

/// Output of a step. Positions and speeds are those at the step's end; forces are those at its theta point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepOutput {
    /// World coordinate of the driven point along the drive's direction, m.
    pub site_m: f64,
    /// Velocity of the driven point in that direction, m/s.
    pub site_m_per_s: f64,
    /// Force of the drive on the mechanism, N.
    pub drive_n: f64,
    /// World coordinate of the hand along the drive's direction, m, and its velocity, m/s.
    pub hand: [f64; 2],
    /// Position of the probe point in the world, m.
    pub point_m: [f64; 2],
    /// Velocity of the probe point in the world, m/s.
    pub point_m_per_s: [f64; 2],
    /// Normal force of the probe zone, N.
    pub zone_n: f64,
    /// Impact of the probe point on the probe zone in the step; `None` without one.
    pub impact: Option<Impact>,
    /// Outcome and work of the step. A skipped step has the report of the step that it repeats.
    pub report: StepReport,
}

/// Settings of the steps, and which outputs are kept.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stepping {
    /// Settings of the engine.
    pub settings: Settings<f64>,
    /// Halving of a step while the mechanism is near the first surface; at first, as the surfaces request.
    pub halving: Halving,
    /// Whether steps that would change nothing are skipped; true at first. Results are bit-identical either way.
    pub may_rest: bool,
    /// Whether [`Readout::contacts`] is kept after every step, as a ledger needs; false at first.
    pub keeps_contacts: bool,
}

/// Part of a mechanism's state that can be set from outside.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum StatePart {
    /// Present instant, s. The samples for predicting an impact are discarded.
    Instant(f64),
    /// Sets the velocities of all bodies to zero.
    Standstill,
    /// Hand: world coordinate along the drive's direction, m, and velocity, m/s.
    Hand([f64; 2]),
}

/// Present state of a mechanism of any size, and the forces in its last step. Slices have the order of the
/// description's bodies and zones.
#[derive(Clone, Copy)]
pub struct Readout<'a> {
    /// Present instant, s.
    pub now_s: f64,
    /// Length of the last step, s; of its last part, if it was taken in parts; of its second half, if it was adaptive.
    pub last_step_s: f64,
    /// Whether the last step changed nothing. If so, the next one with the same input changes nothing either.
    pub rests: bool,
    /// Whether the last step skipped the bodies because it would not have changed them. If so, the next one with the
    /// same input advances only the subsystem under the zones, which cannot reach them.
    pub bodies_rest: bool,
    /// Output of the last step.
    pub output: &'a StepOutput,
    /// Absolute angles, rad.
    pub angles: &'a [f64],
    /// Absolute angular velocities, rad/s.
    pub velocities: &'a [f64],
    /// Dry friction torques of the pivots in the last step, N m.
    pub pivot_friction: &'a [f64],
    /// Contacts of the zones in the last step if [`Stepping::keeps_contacts`] is set, else empty; `None` for a zone
    /// that was not touched. The slice may be longer than the list of zones.
    pub contacts: &'a [Option<Contact<f64>>],
    /// Coulomb forces of the zones in the last step, N. The slice may be longer than the list of zones.
    pub tangential_forces: &'a [f64],
    /// Settings of the steps.
    pub stepping: &'a Stepping,
    /// Compliant external subsystem under the zones; `None` if there is none.
    pub surfaces: Option<&'a dyn Surfaces>,
}

/// Everything that the following steps depend on, in numbers of the largest size: bodies and zones that the mechanism
/// does not have are zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Saved {
    /// State of the engine, in the largest size.
    pub state: SavedState<f64, 12, 32>,
    /// Origin of the grid of fixed steps, s: the instant is this plus `steps` steps.
    pub origin_s: f64,
    /// Number of steps since `origin_s`.
    pub steps: u64,
    /// The present instant, s.
    pub now_s: f64,
    /// Last two samples for predicting an impact: instant, s; compression of the probe zone, m; speed of the probe
    /// point, m/s.
    pub flight: [Option<[f64; 3]>; 2],
}

/// A mechanism of any size: this trait hides the sizes that the engine is compiled for. Indices have the order of the
/// description's bodies and zones. Only functions that say so allocate.
pub trait Mechanism: Observation + Send {
    /// Advances by one step of the current settings. If the step is taken in parts ([`Surfaces::parts`]), a force is
    /// constant over all parts, and a position advances at its velocity; the output's forces are those of the last
    /// part.
    fn step(&mut self, input: &SiteInput<f64>) -> &StepOutput;
    /// Advances by one step with an input for each part. Calls `observe` after each part; its flag is true after the
    /// last one. If a number becomes infinite or NaN, the parts before stay taken.
    fn step_in_parts(&mut self, input: &mut InputDuring, observe: &mut dyn FnMut(&dyn Mechanism, bool)) -> StepReport;
    /// Advances by one step whose length is set by the error allowed, and is at most `limit` (s). `ends` returns the
    /// instant of a given time, s, after the step's start; `observe` is called after each of its two halves. The first
    /// such step allocates.
    fn controlled_step(
        &mut self,
        accuracy: &Accuracy<f64>,
        limit: f64,
        ends: &dyn Fn(f64) -> f64,
        input: &mut InputDuring,
        observe: &mut dyn FnMut(&dyn Mechanism),
    ) -> ControlledStep<f64>;
    /// Returns the present state and the forces in the last step.
    fn readout(&self) -> Readout<'_>;
    /// Changes the settings of steps from the next one on. Allocates when it begins to keep contacts.
    fn configure(&mut self, stepping: Stepping);
    /// Sets a part of the state from outside, before the next step.
    fn set(&mut self, part: StatePart);
    /// Returns the stored energies, J, of the present pose with the given absolute angular velocities, rad/s.
    fn energies_at(&self, velocities: &[f64]) -> Energies;
    /// Records the last step in a ledger ([`open_ledger`]). Of a step taken in parts only the last part is recorded:
    /// record after each part ([`Mechanism::step_in_parts`]).
    fn record_energy(&self, ledger: &mut Ledger);
    /// Reports the loss of each pivot and each zone in the last step, J, as a ledger records them. Requires
    /// [`Stepping::keeps_contacts`].
    fn each_loss(&self, lose: &mut dyn FnMut(LossIn, f64));
    /// Returns everything that the following steps depend on, except for [`Readout::surfaces`].
    fn save(&self) -> Saved;
    /// Restores a saved state, to the bit.
    fn restore(&mut self, saved: &Saved);
    /// Returns the subsystem under the zones for changes. The next step is then not skipped.
    fn surfaces_mut(&mut self) -> Option<&mut (dyn Surfaces + 'static)>;
}

/// Assembles a mechanism in the smallest size that holds it. `surfaces`: the compliant subsystem under its zones; the
/// description lists these zones as yielding. A mechanism with surfaces takes fixed steps only, whole or in parts.
///
/// # Errors
/// Returns [`ModelError`] if no size holds the mechanism, or a number is out of its range.
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

/// Starts an energy balance at a mechanism's present state, and makes the mechanism keep its contacts. Allocates the
/// first time.
pub fn open_ledger(mechanism: &mut dyn Mechanism) -> Ledger {
    // This also wakes it, so that what rests is booked at least once.
    mechanism.configure(Stepping { keeps_contacts: true, ..*mechanism.readout().stepping });
    let now = mechanism.readout();
    let [lost, given] = now.surfaces.map_or([0.0; 2], |surfaces| [surfaces.lost(), surfaces.given()]);
    Ledger::open_at(mechanism.energies_at(now.velocities), lost, given)
}

/// Evaluates a mechanism's stored energy. The ledger's residual refers to the last call.
pub fn update_energies(mechanism: &dyn Mechanism, ledger: &mut Ledger) {
    ledger.now = mechanism.energies_at(mechanism.readout().velocities);
}
