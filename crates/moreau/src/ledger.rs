//! The energy balance: work done, energy stored, energy lost, and the residual, which should be zero.
//!
//! It is separate from the step, so that a step without an audit does not pay for it.

use crate::contact::Contact;
use crate::hand_energy::HandEnergy;
use crate::model::Model;
use crate::pose::Pose;
use crate::real::Scalar;
use crate::settings::{FrictionLaw, Settings};
use crate::state::State;
use crate::timing::Timing;
use crate::vector::dot;
use crate::workspace::Workspace;

/// Stored energies of a state, J.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Energies {
    /// Kinetic energy, 1/2 v . M(q) v.
    pub kinetic: f64,
    /// Gravitational energy, weight times height; zero at the world's origin.
    pub gravity: f64,
    /// Energy of torsion springs, relative to their reference angles (including the potential of a constant torque).
    pub spring: f64,
    /// Energy of compressed felts.
    pub felt: f64,
    /// Energy of compliant surfaces, as reported by the external subsystem; zero without such surfaces.
    pub surface: f64,
}

impl Energies {
    /// Returns the sum of all stored energies, J.
    pub fn total(&self) -> f64 {
        self.kinetic + self.gravity + self.spring + self.felt + self.surface
    }

    /// Returns the energies of a state with all curves at their described places.
    pub fn of<T: Scalar, const B: usize, const Z: usize>(model: &Model<T, B, Z>, state: &State<T, B, Z>) -> Self {
        Energies::displaced(model, state, |_| T::ZERO)
    }

    /// Returns the energies of a state in which compliant surfaces are displaced away from their discs, m. The energy
    /// of the surfaces themselves is not included.
    pub fn displaced<T: Scalar, const B: usize, const Z: usize>(
        model: &Model<T, B, Z>,
        state: &State<T, B, Z>,
        displacement: impl Fn(usize) -> T,
    ) -> Self {
        let pose = Pose::of(model, &state.angle);
        let mut e = Energies::default();
        for i in 0..B {
            let v = state.velocity[i];
            let moment = pose.rotate(i, model.moment[i]);
            e.kinetic += (model.inertia[i] * v * v).to_f64() / 2.0;
            let mut branch = i;
            while model.tree.parent[branch] < B {
                let ancestor = model.tree.parent[branch];
                e.kinetic += (dot(pose.arm(branch), moment) * v * state.velocity[ancestor]).to_f64();
                branch = ancestor;
            }
            // First moments about pivots: pivots that move are in their parents' moments already.
            e.gravity += (model.gravity * moment[1]).to_f64();
            let parent = model.tree.parent[i];
            let relative = if parent < B { state.angle[i] - state.angle[parent] } else { state.angle[i] };
            e.spring += (model.spring_stiffness[i] * relative * relative).to_f64() / 2.0
                - (model.spring_torque[i] * relative).to_f64();
        }
        for (z, zone) in model.zones().iter().enumerate() {
            e.felt += zone.felt.stored(pose.compression(model, z) - displacement(z), &state.memory[z]).to_f64();
        }
        e
    }
}

/// Place where energy is lost in a step: the pivot of a body or a contact zone, by index.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LossIn {
    /// Dry friction of a pivot.
    DryPivot(usize),
    /// Viscous friction of a pivot.
    ViscousPivot(usize),
    /// The felt of a zone.
    Felt(usize),
    /// Coulomb friction of a zone.
    Sliding(usize),
}

/// Energy balance of one run: running totals, J. Losses are positive.
#[derive(Debug, Clone, PartialEq)]
pub struct Ledger {
    /// Stored energy at the start.
    pub start: Energies,
    /// Stored energy at the last call of [`Ledger::update_energies`].
    pub now: Energies,
    /// Work of the drive, signed.
    pub drive_work: f64,
    /// Sum of the positive contributions to the work of the drive: the scale of the relative residual.
    pub drive_work_in: f64,
    /// Energy lost in dry pivots.
    pub pivot_dry: f64,
    /// Energy lost in viscous pivots.
    pub pivot_viscous: f64,
    /// Energy lost in felts.
    pub felt_damping: f64,
    /// Energy lost in Coulomb friction.
    pub coulomb: f64,
    /// Energy lost in compliant surfaces, as reported by the external subsystem.
    pub surface: f64,
    /// Energy that the surfaces had lost before the balance started, J.
    pub surface_lost_before: f64,
    /// Work done from outside through the surfaces up to the last record, J.
    pub surface_given_before: f64,
    /// The most negative loss of any step; zero if no loss was negative. Friction never gives energy, so its losses are
    /// not negative.
    pub smallest_term: f64,
    /// Energies of the driving hand; zero without a hand. The other totals belong to the mechanism and do not include
    /// it.
    pub hand: HandEnergy,
}

impl Ledger {
    /// Starts the energy balance at a state.
    pub fn open<T: Scalar, const B: usize, const Z: usize>(model: &Model<T, B, Z>, state: &State<T, B, Z>) -> Self {
        Ledger::open_at(Energies::of(model, state), 0.0, 0.0)
    }

    /// Starts the energy balance at given stored energies. `surface_lost_before`: energy that the surfaces have lost so
    /// far, J. `surface_given_before`: work done through them from outside so far, J.
    pub fn open_at(start: Energies, surface_lost_before: f64, surface_given_before: f64) -> Self {
        Ledger {
            start,
            now: start,
            drive_work: 0.0,
            drive_work_in: 0.0,
            pivot_dry: 0.0,
            pivot_viscous: 0.0,
            felt_damping: 0.0,
            coulomb: 0.0,
            surface: 0.0,
            surface_lost_before,
            surface_given_before,
            smallest_term: 0.0,
            hand: HandEnergy::default(),
        }
    }

    /// Records one step: the states `before` and `after` it, and its workspace.
    pub fn record<T: Scalar, const B: usize, const Z: usize, const N: usize>(
        &mut self,
        model: &Model<T, B, Z>,
        settings: &Settings<T>,
        before: &State<T, B, Z>,
        after: &State<T, B, Z>,
        workspace: &Workspace<T, B, Z, N>,
    ) {
        let contacts = core::array::from_fn(|z| workspace.contact(model, settings, z));
        self.record_contacts(model, settings, &before.velocity, after, workspace, &contacts);
    }

    /// Records one step, as [`Ledger::record`], for a caller that already has the step's contacts, by zone, and the
    /// absolute velocities before it, rad/s.
    pub fn record_contacts<T: Scalar, const B: usize, const Z: usize, const N: usize>(
        &mut self,
        model: &Model<T, B, Z>,
        settings: &Settings<T>,
        velocity_before: &[T; B],
        after: &State<T, B, Z>,
        workspace: &Workspace<T, B, Z, N>,
        contacts: &[Option<Contact<T>>; Z],
    ) {
        let joints = [velocity_before, &after.velocity].map(|v| model.tree.relative(v));
        let drive_velocity = workspace.drive_velocity(model, settings, &joints);
        let work = workspace.drive.force.to_f64() * drive_velocity * settings.step.to_f64();
        self.drive_work += work;
        self.drive_work_in += work.max(0.0);
        each_loss_between(model, settings, &joints, after, workspace, contacts, |loss_in, loss_j| {
            let account = match loss_in {
                LossIn::DryPivot(_) => &mut self.pivot_dry,
                LossIn::ViscousPivot(_) => &mut self.pivot_viscous,
                LossIn::Felt(_) => &mut self.felt_damping,
                LossIn::Sliding(_) => &mut self.coulomb,
            };
            *account += loss_j;
            self.smallest_term = self.smallest_term.min(loss_j);
        });
    }

    /// Records the totals of the compliant surfaces since their creation: energy `lost`, J, and work `given` from
    /// outside through them, J.
    pub fn record_surfaces(&mut self, lost: f64, given: f64) {
        self.surface = lost - self.surface_lost_before;
        let work = given - core::mem::replace(&mut self.surface_given_before, given);
        self.drive_work += work;
        self.drive_work_in += work.max(0.0);
    }

    /// All energy that can have become motion up to the last update, J: at the start, from the drive, and from heights,
    /// springs and felts that hold less than at the start. What was lost on the way is included.
    pub fn given(&self) -> f64 {
        self.drive_work + self.start.total() - (self.now.total() - self.now.kinetic)
    }

    /// Evaluates the stored energy of a state. The residual refers to the last call.
    pub fn update_energies<T: Scalar, const B: usize, const Z: usize>(
        &mut self,
        model: &Model<T, B, Z>,
        state: &State<T, B, Z>,
    ) {
        self.now = Energies::of(model, state);
    }

    /// Returns the sum of all losses, J.
    pub fn dissipated(&self) -> f64 {
        self.pivot_dry + self.pivot_viscous + self.felt_damping + self.coulomb + self.surface
    }

    /// Returns stored energy minus start minus work plus losses, J: zero if the energy balance closes.
    pub fn residual(&self) -> f64 {
        self.now.total() - self.start.total() - self.drive_work + self.dissipated()
    }

    /// Returns |residual| over the work that the drive put in or over the losses, whichever is larger; if both are
    /// zero, |residual| in J.
    pub fn residual_relative(&self) -> f64 {
        let scale = self.drive_work_in.max(self.dissipated());
        if scale > 0.0 { self.residual().abs() / scale } else { self.residual().abs() }
    }
}

/// Reports every loss of a step to a callback, J. The arguments are those of [`Ledger::record_contacts`].
///
/// Forces act at the theta point, so their work is force times velocity at that point. The loss of dry friction is
/// |force| times the path of its velocity, which is taken as linear over the step. This is never negative, even where
/// the velocity reverses, and equals the scheme's own work wherever it does not reverse.
pub fn each_loss<T: Scalar, const B: usize, const Z: usize, const N: usize>(
    model: &Model<T, B, Z>,
    settings: &Settings<T>,
    velocity_before: &[T; B],
    after: &State<T, B, Z>,
    workspace: &Workspace<T, B, Z, N>,
    contacts: &[Option<Contact<T>>; Z],
    lose: impl FnMut(LossIn, f64),
) {
    let joints = [velocity_before, &after.velocity].map(|v| model.tree.relative(v));
    each_loss_between(model, settings, &joints, after, workspace, contacts, lose);
}

/// [`each_loss`], given the relative velocities before and after the step.
fn each_loss_between<T: Scalar, const B: usize, const Z: usize, const N: usize>(
    model: &Model<T, B, Z>,
    settings: &Settings<T>,
    joints: &[[T; B]; 2],
    after: &State<T, B, Z>,
    workspace: &Workspace<T, B, Z, N>,
    contacts: &[Option<Contact<T>>; Z],
    mut lose: impl FnMut(LossIn, f64),
) {
    let h = settings.step.to_f64();
    for i in 0..B {
        let u = joints.map(|w| w[i].to_f64());
        let rate = settings.at_theta(u);
        lose(LossIn::ViscousPivot(i), model.viscous[i].to_f64() * rate * rate * h);
        let dry = match settings.friction {
            FrictionLaw::SetValued => after.pivot_friction[i].to_f64().abs() * path(u) * h,
            FrictionLaw::Regularised { pivot_width, .. } => {
                let torque = model.dry[i].to_f64() * libm::tanh(rate / pivot_width.to_f64());
                torque * rate * h
            }
        };
        lose(LossIn::DryPivot(i), dry);
    }
    for &z in workspace.touched_zones() {
        let Some(contact) = &contacts[z] else { continue };
        let lost = (contact.damping_force * contact.rate).to_f64() * h - contact.gained.to_f64();
        let unknown = model.remembering_zones().contains(&z) && lost.abs() < rounding(contact, h);
        lose(LossIn::Felt(z), if unknown { 0.0 } else { lost });
        let Some(mu) = model.zones[z].friction else { continue };
        let u = workspace.slip(model, z, joints).map(T::to_f64);
        let sliding = match settings.friction {
            FrictionLaw::SetValued => after.tangential[z].to_f64().abs() * path(u) * h,
            FrictionLaw::Regularised { sliding_width, .. } => {
                let u = settings.at_theta(u);
                let f = (mu * contact.force).to_f64() * libm::tanh(u / sliding_width.to_f64());
                f * u * h
            }
        };
        lose(LossIn::Sliding(z), sliding);
    }
    let timing = Timing::new(settings.step, settings.theta);
    for &z in model.remembering_zones().iter().filter(|&&z| contacts[z].is_none()) {
        let (_, gained) = model.compiled[z].felt.relax(&timing, &workspace.contacts.states[z].memory);
        lose(LossIn::Felt(z), -gained.to_f64());
    }
}

/// Below this what a felt that remembers has lost in a step is not known, J: it is a difference of works and of stored
/// energies, each rounded.
fn rounding<T: Scalar>(contact: &Contact<T>, h: f64) -> f64 {
    let depth = contact.compression.to_f64().abs() + contact.rate.to_f64().abs() * h;
    let force = contact.force.to_f64() + contact.damping_force.to_f64().abs();
    8.0 * T::EPSILON.to_f64() * force * depth
}

/// Mean of |u| over a step in which u runs linearly from u0 to u1.
fn path([u0, u1]: [f64; 2]) -> f64 {
    if u0 * u1 >= 0.0 { (u0 + u1).abs() / 2.0 } else { (u0 * u0 + u1 * u1) / (2.0 * (u0 - u1).abs()) }
}
