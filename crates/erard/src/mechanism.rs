//! An assembled mechanism of any size behind one interface.
//!
//! The engine is compiled for fixed sizes, so that its loops are unrolled; the file decides which of them is used. The one
//! dynamic call is per step, outside the inner step.

use moreau::{
    Accuracy, ControlledStep, Controller, Energies, FrictionLaw, Halves, Input, Ledger, Model, ModelError, Outcome,
    Pose, Settings, Sleep, State, StepReport, Workspace, controlled_step,
};

use crate::assembly;
use crate::instrument::Instrument;
use crate::sight::{Sight, Visible};

/// What drives an inner step that begins so many s after the controlled step and lasts so long, s; the last argument says where the
/// driven point is then, as [`Visible::site_position`] does.
pub type InputDuring<'a> = dyn FnMut(f64, f64, &dyn Fn() -> f64) -> Input<f64> + 'a;

/// What can be asked of an assembled mechanism. Indices follow the instrument's bodies and zones.
pub trait Mechanism: Visible + Send {
    /// Advances by one step of the current settings.
    fn step(&mut self, input: &Input<f64>) -> StepReport;
    /// Advances by one step that is as long as its error allows, and at most `limit` s. `look` is called after each of its two halves,
    /// with the time since the step's start, s.
    fn controlled_step(
        &mut self,
        accuracy: &Accuracy<f64>,
        limit: f64,
        input: &mut InputDuring,
        look: &mut dyn FnMut(f64, &dyn Mechanism),
    ) -> ControlledStep<f64>;
    /// Length of the last step, or half of a controlled one, s.
    fn last_step(&self) -> f64;
    /// The settings in force.
    fn settings(&self) -> &Settings<f64>;
    /// Changes the settings from the next step on.
    fn set_settings(&mut self, settings: Settings<f64>);
    /// Absolute angles, rad.
    fn angles(&self) -> &[f64];
    /// Absolute angular velocities, rad/s.
    fn velocities(&self) -> &[f64];
    /// Dry friction torques of the pivots, N m.
    fn pivot_friction(&self) -> &[f64];
    /// Sets all velocities to zero.
    fn stop(&mut self);
    /// Normal force of a zone during the last step, N.
    fn normal_force(&self, zone: usize) -> f64;
    /// Coulomb force of a zone during the last step, N.
    fn tangential_force(&self, zone: usize) -> f64;
    /// Contact point and normal of a zone during the last step.
    fn contact(&self, zone: usize) -> [f32; 4];
    /// Force of the drive during the last step, N.
    fn drive_force(&self) -> f64;
    /// dg/dt per unit angular velocity of every body, m.
    fn gap_row(&self, zone: usize) -> Vec<f64>;
    /// Velocity of a point along `n` per unit angular velocity of every body, m.
    fn velocity_row(&self, body: usize, point: [f64; 2], n: [f64; 2]) -> Vec<f64>;
    /// Stored energies if the mechanism moved at the given velocities from where it is, J.
    fn energies_at(&self, velocities: &[f64]) -> Energies;
    /// Opens the energy ledger here.
    fn open_ledger(&mut self);
    /// The ledger since it was opened, stock taken now.
    fn ledger(&mut self) -> Ledger;
}

struct Engine<const B: usize, const Z: usize, const N: usize> {
    model: Model<f64, B, Z>,
    settings: Settings<f64>,
    state: State<f64, B, Z>,
    before: State<f64, B, Z>,
    scratch: Workspace<f64, B, Z, N>,
    repose: Sleep<f64>,
    /// While steps are controlled.
    control: Option<Box<Control<B, Z, N>>>,
    pose: Pose<f64, B>,
    ledger: Ledger,
    bodies: usize,
}

fn boxed<const B: usize, const Z: usize, const N: usize>(
    instrument: &Instrument,
    settings: Settings<f64>,
) -> Result<Box<dyn Mechanism>, ModelError> {
    let model: Model<f64, B, Z> = assembly::assemble(instrument)?;
    let state = State::at_rest(assembly::drawn_angles(instrument));
    let ledger = Ledger::open(&model, &state);
    let pose = Pose::of(&model, &state.angle);
    let (before, scratch, bodies) = (state.clone(), Workspace::for_model(&model)?, instrument.bodies.len());
    let (repose, control) = (Sleep::awake(), None);
    Ok(Box::new(Engine::<B, Z, N> { model, settings, state, before, scratch, repose, control, pose, ledger, bodies }))
}

struct Control<const B: usize, const Z: usize, const N: usize> {
    controller: Controller<f64, Z>,
    halves: Halves<f64, B, Z, N>,
    /// The half that was last.
    half: usize,
}

impl<const B: usize, const Z: usize, const N: usize> Engine<B, Z, N> {
    /// What acted in the last step, and how it was taken.
    fn last(&self) -> (&Settings<f64>, &Workspace<f64, B, Z, N>) {
        last(self.control.as_deref(), &self.settings, &self.scratch)
    }

    /// Books the step from `self.before` to `self.state`.
    fn book(&mut self) {
        let (settings, scratch) = last(self.control.as_deref(), &self.settings, &self.scratch);
        self.ledger.record(&self.model, settings, &self.before, &self.state, scratch);
        self.pose = Pose::of(&self.model, &self.state.angle);
    }
}

/// Of a controlled step its last half, else the step itself.
fn last<'a, const B: usize, const Z: usize, const N: usize>(
    control: Option<&'a Control<B, Z, N>>,
    settings: &'a Settings<f64>,
    scratch: &'a Workspace<f64, B, Z, N>,
) -> (&'a Settings<f64>, &'a Workspace<f64, B, Z, N>) {
    match control {
        Some(control) => (&control.halves.settings, &control.halves.workspace[control.half]),
        None => (settings, scratch),
    }
}

impl<const B: usize, const Z: usize, const N: usize> Engine<B, Z, N> {
    fn sight(&self) -> Sight<'_, B, Z> {
        Sight { model: &self.model, pose: &self.pose, velocity: &self.state.velocity }
    }
}

impl<const B: usize, const Z: usize, const N: usize> Visible for Engine<B, Z, N> {
    fn site_position(&self) -> f64 {
        self.sight().site_position()
    }

    fn gap(&self, zone: usize) -> f64 {
        self.sight().gap(zone)
    }

    fn point_speed(&self, body: usize, point: [f64; 2]) -> f64 {
        self.sight().point_speed(body, point)
    }

    fn point(&self, body: Option<usize>, point: [f64; 2]) -> [f64; 2] {
        self.sight().point(body, point)
    }
}

impl<const B: usize, const Z: usize, const N: usize> Mechanism for Engine<B, Z, N> {
    fn step(&mut self, input: &Input<f64>) -> StepReport {
        self.control = None;
        let rested = self.repose.is_asleep();
        if !rested {
            self.before.clone_from(&self.state);
        }
        let Engine { model, settings, state, scratch, repose, .. } = self;
        let report = repose.step(model, settings, input, state, scratch);
        // A step that was left out has nothing to book, nor has one that changed nothing after another.
        if report.outcome != Outcome::NonFinite && !(rested && self.repose.is_asleep()) {
            self.book();
        }
        report
    }

    fn controlled_step(
        &mut self,
        accuracy: &Accuracy<f64>,
        limit: f64,
        input: &mut InputDuring,
        look: &mut dyn FnMut(f64, &dyn Mechanism),
    ) -> ControlledStep<f64> {
        self.repose.wake();
        let Engine { model, settings, state, before, control, .. } = self;
        let control = control.get_or_insert_with(|| {
            let controller = Controller::new(settings.step);
            Box::new(Control { controller, halves: Halves::new(settings), half: 1 })
        });
        before.clone_from(state);
        let input = |from: f64, h: f64, state: &State<f64, B, Z>| input(from, h, &|| model.site_position(&state.angle));
        let Control { controller, halves, half } = control.as_mut();
        let report = controlled_step(model, settings, accuracy, controller, limit, input, state, halves);
        if report.outcome == Outcome::NonFinite {
            return report;
        }
        *half = 0;
        let end = std::mem::replace(state, halves.middle.clone());
        self.book();
        look(0.5 * report.step, self);
        self.before = std::mem::replace(&mut self.state, end);
        if let Some(control) = &mut self.control {
            control.half = 1;
        }
        self.book();
        look(report.step, self);
        report
    }

    fn last_step(&self) -> f64 {
        self.last().0.step
    }

    fn settings(&self) -> &Settings<f64> {
        &self.settings
    }

    fn set_settings(&mut self, settings: Settings<f64>) {
        self.control = None;
        self.repose.wake();
        self.settings = settings;
    }

    fn angles(&self) -> &[f64] {
        &self.state.angle[..self.bodies]
    }

    fn velocities(&self) -> &[f64] {
        &self.state.velocity[..self.bodies]
    }

    fn pivot_friction(&self) -> &[f64] {
        &self.state.pivot_friction[..self.bodies]
    }

    fn stop(&mut self) {
        self.control = None;
        self.repose.wake();
        self.state.velocity = [0.0; B];
    }

    fn normal_force(&self, zone: usize) -> f64 {
        let (settings, scratch) = self.last();
        scratch.contact(&self.model, settings, zone).map_or(0.0, |c| c.force)
    }

    fn tangential_force(&self, zone: usize) -> f64 {
        self.state.tangential[zone]
    }

    fn contact(&self, zone: usize) -> [f32; 4] {
        let (settings, scratch) = self.last();
        let contact = scratch.contact(&self.model, settings, zone);
        contact.map_or([0.0; 4], |c| [c.point[0] as f32, c.point[1] as f32, c.normal[0] as f32, c.normal[1] as f32])
    }

    fn drive_force(&self) -> f64 {
        self.last().1.drive_force()
    }

    fn gap_row(&self, zone: usize) -> Vec<f64> {
        self.pose.gap_row(&self.model, zone)[..self.bodies].to_vec()
    }

    fn velocity_row(&self, body: usize, point: [f64; 2], n: [f64; 2]) -> Vec<f64> {
        self.pose.velocity_row(&self.model, body, point, n)[..self.bodies].to_vec()
    }

    fn energies_at(&self, velocities: &[f64]) -> Energies {
        let mut state = self.state.clone();
        state.velocity[..self.bodies].copy_from_slice(velocities);
        Energies::of(&self.model, &state)
    }

    fn open_ledger(&mut self) {
        // So that what rests is booked at least once.
        self.repose.wake();
        self.ledger = Ledger::open(&self.model, &self.state);
    }

    fn ledger(&mut self) -> Ledger {
        self.ledger.take_stock(&self.model, &self.state);
        self.ledger.clone()
    }
}

/// The sizes that the engine is compiled for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Size {
    /// One body: the one-degree-of-freedom model.
    One,
    /// A grand action.
    Grand,
    /// As much as an instrument file may hold.
    Most,
}

/// `with_size!(size, f, arguments)` calls `f::<B, Z, N>(arguments)` with the numbers of bodies, zones and laws of that size.
macro_rules! with_size {
    ($size:expr, $f:ident, $($argument:expr),*) => {
        match $size {
            $crate::mechanism::Size::One => $f::<1, 4, 6>($($argument),*),
            $crate::mechanism::Size::Grand => $f::<6, 14, 10>($($argument),*),
            $crate::mechanism::Size::Most => $f::<12, 32, 45>($($argument),*),
        }
    };
}
pub(crate) use with_size;

impl Size {
    /// The smallest that holds an instrument.
    pub fn of(instrument: &Instrument, settings: &Settings<f64>) -> Self {
        let (bodies, zones) = (instrument.bodies.len(), instrument.zones.len());
        let pivots = instrument.bodies.iter().filter(|b| b.friction_torque_n_m > 0.0).count();
        let sliding = instrument.zones.iter().filter(|z| z.friction_coefficient > 0.0).count();
        // One law more for a rigid drive.
        let laws = if settings.friction == FrictionLaw::SetValued { pivots + sliding + 1 } else { 1 };
        match (bodies, zones, laws) {
            (..=1, ..=4, ..=6) => Size::One,
            (..=6, ..=14, ..=10) => Size::Grand,
            _ => Size::Most,
        }
    }
}

/// Assembles an instrument into the smallest engine size that holds it, at the angles as drawn.
///
/// # Errors
/// [`ModelError`] if no size holds it.
pub fn mechanism(instrument: &Instrument, settings: Settings<f64>) -> Result<Box<dyn Mechanism>, ModelError> {
    with_size!(Size::of(instrument, &settings), boxed, instrument, settings)
}
