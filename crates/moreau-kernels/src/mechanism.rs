//! One mechanism of any size.

use moreau::{
    Accuracy, Contact, ControlledStep, Energies, Input, Ledger, ModelError, SavedState, Settings, State, StepReport,
    Workspace,
};

use crate::engine::{Clock, Engine};
use crate::placed::Visible;
use crate::size::with_size;
use crate::surfaces::{Surfaces, Under};
use crate::{Marks, Meeting, OwnedDescription, Size};

/// What drives an inner step that begins so many s after the controlled step and lasts so long, s; the last argument says where the
/// driven point is then, as [`Visible::site_position`] does.
pub type InputDuring<'a> = dyn FnMut(f64, f64, &dyn Fn() -> f64) -> Input<f64> + 'a;

/// What a caller of every step asks for. Places and speeds are those at the step's end; forces acted in the step, at its theta point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    /// World coordinate of the driven point along the drive's direction, m.
    pub site_m: f64,
    /// Its speed in that direction, m/s.
    pub site_m_s: f64,
    /// Force of the drive on the mechanism, N.
    pub drive_n: f64,
    /// The marked point in the world, m.
    pub point_m: [f64; 2],
    /// Its velocity, m/s.
    pub point_m_s: [f64; 2],
    /// Normal force of the marked zone, N.
    pub zone_n: f64,
    /// The meeting of point and zone in the step, if there was one.
    pub met: Option<Meeting>,
}

/// All that the following steps depend on, in plain numbers of any size: bodies and zones beyond the mechanism's are zero.
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

/// An assembled mechanism. Indices follow the description's bodies and zones. No function but those that say so allocates.
pub trait Mechanism: Visible + Send {
    /// Advances by one step of the current settings.
    fn step(&mut self, input: &Input<f64>) -> StepReport;
    /// [`Mechanism::step`], and what there is to be seen then.
    fn step_and_view(&mut self, input: &Input<f64>) -> (StepReport, View);
    /// What there is to be seen now.
    fn view(&self) -> View;
    /// Advances by one step that is as long as its error allows, and at most `limit` s. `ends` tells the instant of so many s after the
    /// step's start; `look` is called after each of its two halves. Allocates when the first step is taken.
    fn controlled_step(
        &mut self,
        accuracy: &Accuracy<f64>,
        limit: f64,
        ends: &dyn Fn(f64) -> f64,
        input: &mut InputDuring,
        look: &mut dyn FnMut(&dyn Mechanism),
    ) -> ControlledStep<f64>;
    /// The present instant, s.
    fn now_s(&self) -> f64;
    /// Calls the present instant so, s; what the flight of the marked point has shown so far is forgotten.
    fn set_now(&mut self, now_s: f64);
    /// Length of the last step, or half of a controlled one, s.
    fn last_step(&self) -> f64;
    /// How the last step ended and what it took; of a step that was left out, the report of the one that it repeats.
    fn last_report(&self) -> StepReport;
    /// Whether the last step changed nothing: with the same input the next one does not either.
    fn rests(&self) -> bool;
    /// Whether steps that are known to change nothing are left out, as at first. The results are the same bits.
    fn let_rest(&mut self, may_rest: bool);
    /// The settings in force.
    fn settings(&self) -> &Settings<f64>;
    /// Changes the settings from the next step on.
    fn set_settings(&mut self, settings: Settings<f64>);
    /// Absolute angles, rad.
    fn angles(&self) -> &[f64];
    /// Absolute angular velocities, rad/s.
    fn velocities(&self) -> &[f64];
    /// Dry friction torques of the pivots in the last step, N m.
    fn pivot_friction(&self) -> &[f64];
    /// Sets all velocities to zero.
    fn stop(&mut self);
    /// From now on [`Mechanism::contacts`] tells of every step. Allocates the first time.
    fn keep_contacts(&mut self);
    /// The zones as they acted in the last step, once [`Mechanism::keep_contacts`] or [`Mechanism::open_ledger`] has asked for them, else none;
    /// those that were not touched are `None`. There may be more places than zones.
    fn contacts(&self) -> &[Option<Contact<f64>>];
    /// Coulomb forces of the zones in the last step, N. There may be more places than zones.
    fn tangential_forces(&self) -> &[f64];
    /// Normal force of a zone in the last step, N.
    fn normal_force(&self, zone: usize) -> f64;
    /// Coulomb force of a zone in the last step, N.
    fn tangential_force(&self, zone: usize) -> f64 {
        self.tangential_forces()[zone]
    }
    /// Force of the drive in the last step, N.
    fn drive_force(&self) -> f64;
    /// dg/dt per unit angular velocity of every body, m. Allocates.
    fn gap_row(&self, zone: usize) -> Vec<f64>;
    /// Velocity of a point along `n` per unit angular velocity of every body, m. Allocates.
    fn velocity_row(&self, body: usize, point: [f64; 2], n: [f64; 2]) -> Vec<f64>;
    /// Stored energies if the mechanism moved at the given velocities from where it is, J.
    fn energies_at(&self, velocities: &[f64]) -> Energies;
    /// A ledger that is opened here. Allocates the first time.
    fn open_ledger(&mut self) -> Ledger;
    /// Books the last step in a ledger.
    fn book(&self, ledger: &mut Ledger);
    /// Takes stock in a ledger.
    fn take_stock(&self, ledger: &mut Ledger);
    /// All that the following steps depend on, but for [`Mechanism::surfaces`].
    fn save(&self) -> Saved;
    /// Goes on from there, to the bit.
    fn restore(&mut self, saved: &Saved);
    /// What its zones press on, where that yields.
    fn surfaces(&self) -> Option<&dyn Surfaces>;
    /// The same, to be changed; the mechanism then takes its next step.
    fn surfaces_mut(&mut self) -> Option<&mut (dyn Surfaces + 'static)>;
    /// From now on zones press on these. Their zones are said to yield in the description. No controlled steps: those that ring take steps of one
    /// length.
    fn set_surfaces(&mut self, surfaces: Box<dyn Surfaces>);
}

/// Assembles a mechanism into the smallest size that holds it.
///
/// # Errors
/// [`ModelError`] if no size holds it, or a number is not sound.
pub fn mechanism(
    description: &OwnedDescription,
    marks: &Marks,
    settings: Settings<f64>,
) -> Result<Box<dyn Mechanism>, ModelError> {
    with_size!(Size::of(description), boxed, description, marks, settings)
}

fn boxed<const B: usize, const Z: usize, const N: usize>(
    description: &OwnedDescription,
    marks: &Marks,
    settings: Settings<f64>,
) -> Result<Box<dyn Mechanism>, ModelError> {
    Ok(Box::new(Engine::<B, Z, N>::new(description, marks, settings)?))
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

    fn met(&self) -> Option<Meeting> {
        self.core.flight_met()
    }
}

impl<const B: usize, const Z: usize, const N: usize> Mechanism for Engine<B, Z, N> {
    fn step(&mut self, input: &Input<f64>) -> StepReport {
        Engine::step(self, input)
    }

    fn step_and_view(&mut self, input: &Input<f64>) -> (StepReport, View) {
        let report = Engine::step(self, input);
        (report, Engine::view(self))
    }

    fn view(&self) -> View {
        Engine::view(self)
    }

    fn controlled_step(
        &mut self,
        accuracy: &Accuracy<f64>,
        limit: f64,
        ends: &dyn Fn(f64) -> f64,
        input: &mut InputDuring,
        look: &mut dyn FnMut(&dyn Mechanism),
    ) -> ControlledStep<f64> {
        Engine::controlled_step(self, accuracy, limit, ends, input, &mut |engine| look(engine))
    }

    fn now_s(&self) -> f64 {
        self.core.now_s()
    }

    fn set_now(&mut self, now_s: f64) {
        self.core.set_now(now_s);
    }

    fn last_step(&self) -> f64 {
        self.last().0.step
    }

    fn last_report(&self) -> StepReport {
        self.core.report
    }

    fn rests(&self) -> bool {
        self.core.rests()
    }

    fn let_rest(&mut self, may_rest: bool) {
        self.core.may_rest = may_rest;
        self.core.sleep.wake();
    }

    fn settings(&self) -> &Settings<f64> {
        &self.settings
    }

    fn set_settings(&mut self, settings: Settings<f64>) {
        self.control = None;
        if let Some(under) = &mut self.core.under {
            under.surfaces.set_step(settings.step);
        }
        self.settings = settings;
        self.core.sleep.wake();
        self.core.set_clock(Clock::at(self.core.now_s()));
        self.forget_pose();
    }

    fn angles(&self) -> &[f64] {
        &self.core.state.angle[..self.core.bodies]
    }

    fn velocities(&self) -> &[f64] {
        &self.core.state.velocity[..self.core.bodies]
    }

    fn pivot_friction(&self) -> &[f64] {
        &self.core.state.pivot_friction[..self.core.bodies]
    }

    fn stop(&mut self) {
        self.control = None;
        self.core.sleep.wake();
        self.core.state.velocity = [0.0; B];
    }

    fn keep_contacts(&mut self) {
        Engine::keep_contacts(self);
    }

    fn contacts(&self) -> &[Option<Contact<f64>>] {
        Engine::contacts(self)
    }

    fn normal_force(&self, zone: usize) -> f64 {
        let (settings, workspace) = self.last();
        workspace.normal_force(&self.core.model, settings, zone)
    }

    fn tangential_forces(&self) -> &[f64] {
        &self.core.state.tangential
    }

    fn drive_force(&self) -> f64 {
        self.last().1.drive_force()
    }

    fn gap_row(&self, zone: usize) -> Vec<f64> {
        self.pose().gap_row(&self.core.model, zone)[..self.core.bodies].to_vec()
    }

    fn velocity_row(&self, body: usize, point: [f64; 2], n: [f64; 2]) -> Vec<f64> {
        self.pose().velocity_row(&self.core.model, body, point, n)[..self.core.bodies].to_vec()
    }

    fn energies_at(&self, velocities: &[f64]) -> Energies {
        let mut state = self.core.state.clone();
        state.velocity[..self.core.bodies].copy_from_slice(velocities);
        self.core.energies(&state)
    }

    fn open_ledger(&mut self) -> Ledger {
        // So that what rests is booked at least once.
        self.core.sleep.wake();
        Engine::keep_contacts(self);
        self.lost_before = self.core.under.as_ref().map_or(0.0, |under| under.surfaces.lost());
        self.given_before.set(self.core.under.as_ref().map_or(0.0, |under| under.surfaces.given()));
        let start = self.core.energies(&self.core.state);
        Ledger { start, now: start, ..Ledger::open(&self.core.model, &self.core.state) }
    }

    fn book(&self, ledger: &mut Ledger) {
        Engine::book(self, ledger);
    }

    fn take_stock(&self, ledger: &mut Ledger) {
        ledger.now = self.core.energies(&self.core.state);
    }

    fn save(&self) -> Saved {
        self.core.save_at(&self.core.clock())
    }

    fn restore(&mut self, saved: &Saved) {
        self.control = None;
        self.core.restore(saved);
        // What acted last is not part of it.
        self.workspace = Workspace::new();
        self.look_again();
    }

    fn surfaces(&self) -> Option<&dyn Surfaces> {
        self.core.under.as_ref().map(|under| under.surfaces.as_ref())
    }

    fn surfaces_mut(&mut self) -> Option<&mut (dyn Surfaces + 'static)> {
        self.core.sleep.wake();
        self.core.under.as_mut().map(|under| under.surfaces.as_mut())
    }

    fn set_surfaces(&mut self, surfaces: Box<dyn Surfaces>) {
        self.core.sleep.wake();
        self.core.under = Some(Under::new(surfaces, &self.settings));
    }
}

impl<const B: usize, const Z: usize> crate::engine::Stepped<B, Z> {
    /// All that the steps from an instant on depend on, until which nothing has changed since the last step.
    pub fn save_at(&self, clock: &Clock) -> Saved {
        Saved {
            state: self.state.save().sized(),
            origin_s: clock.origin_s,
            steps: clock.steps,
            now_s: clock.now_s,
            flight: self.flight_samples(clock),
        }
    }

    pub fn restore(&mut self, saved: &Saved) {
        self.state = State::from(saved.state.sized());
        self.sleep.wake();
        self.set_clock(Clock {
            origin_s: saved.origin_s,
            steps: saved.steps,
            now_s: saved.now_s,
            before_s: saved.now_s,
        });
        self.resume_flight(saved.flight);
    }
}
