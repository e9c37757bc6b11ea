//! An assembled mechanism of any size behind one interface.
//!
//! The engine is compiled for fixed sizes, so that its loops are unrolled; the file decides which of them is used. The one
//! dynamic call is per step, outside the inner step.

use moreau::{
    Energies, FrictionLaw, Input, Ledger, Model, ModelError, Outcome, Pose, Scratch, Settings, State, StepReport, step,
};

use crate::assembly;
use crate::instrument::Instrument;

/// What can be asked of an assembled mechanism. Indices follow the instrument's bodies and zones.
pub trait Mechanism: Send {
    /// Advances by one step of the current settings.
    fn step(&mut self, input: &Input<f64>) -> StepReport;
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
    /// World coordinate of the driven point along the drive's direction (down), m.
    fn site_position(&self) -> f64;
    /// Compression of a zone now, m.
    fn gap(&self, zone: usize) -> f64;
    /// Speed of a point of a body now, m/s.
    fn point_speed(&self, body: usize, point: [f64; 2]) -> f64;
    /// A point of a body in the world now, m.
    fn point(&self, body: Option<usize>, point: [f64; 2]) -> [f64; 2];
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
    scratch: Scratch<f64, B, Z, N>,
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
    let (before, scratch, bodies) = (state.clone(), Scratch::new(), instrument.bodies.len());
    Ok(Box::new(Engine::<B, Z, N> { model, settings, state, before, scratch, pose, ledger, bodies }))
}

impl<const B: usize, const Z: usize, const N: usize> Mechanism for Engine<B, Z, N> {
    fn step(&mut self, input: &Input<f64>) -> StepReport {
        self.before.clone_from(&self.state);
        let report = step(&self.model, &self.settings, input, &mut self.state, &mut self.scratch);
        if report.outcome != Outcome::NonFinite {
            self.ledger.record(&self.model, &self.settings, &self.before, &self.state, &self.scratch);
            self.pose = Pose::of(&self.model, &self.state.angle);
        }
        report
    }

    fn settings(&self) -> &Settings<f64> {
        &self.settings
    }

    fn set_settings(&mut self, settings: Settings<f64>) {
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
        self.state.velocity = [0.0; B];
    }

    fn normal_force(&self, zone: usize) -> f64 {
        self.scratch.contact(&self.model, &self.settings, zone).map_or(0.0, |c| c.force)
    }

    fn tangential_force(&self, zone: usize) -> f64 {
        self.state.tangential[zone]
    }

    fn contact(&self, zone: usize) -> [f32; 4] {
        let contact = self.scratch.contact(&self.model, &self.settings, zone);
        contact.map_or([0.0; 4], |c| [c.point[0] as f32, c.point[1] as f32, c.normal[0] as f32, c.normal[1] as f32])
    }

    fn drive_force(&self) -> f64 {
        self.scratch.drive_force
    }

    fn site_position(&self) -> f64 {
        self.model.site().map_or(0.0, |s| {
            let x = self.pose.point(s.body, s.point);
            s.direction[0] * x[0] + s.direction[1] * x[1]
        })
    }

    fn gap(&self, zone: usize) -> f64 {
        self.pose.gap(&self.model, zone)
    }

    fn point_speed(&self, body: usize, point: [f64; 2]) -> f64 {
        let along = |n| {
            let row = self.pose.velocity_row(&self.model, body, point, n);
            row.iter().zip(&self.state.velocity).map(|(r, v)| r * v).sum::<f64>()
        };
        along([1.0, 0.0]).hypot(along([0.0, 1.0]))
    }

    fn point(&self, body: Option<usize>, point: [f64; 2]) -> [f64; 2] {
        body.map_or(point, |b| self.pose.point(b, point))
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
        self.ledger = Ledger::open(&self.model, &self.state);
    }

    fn ledger(&mut self) -> Ledger {
        self.ledger.take_stock(&self.model, &self.state);
        self.ledger.clone()
    }
}

/// The sizes that the engine is compiled for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Size {
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
    pub(crate) fn of(instrument: &Instrument, settings: &Settings<f64>) -> Self {
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
