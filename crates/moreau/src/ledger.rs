//! The energy balance: what went in, what is stored, what was lost, and the residual that should be zero.
//!
//! Separate from the step, so that a step that nobody audits does not pay for it.

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
    /// 1/2 v . M(q) v.
    pub kinetic: f64,
    /// Weight times height; zero at the world's origin.
    pub gravity: f64,
    /// Torsion springs, relative to their reference angles (a constant torque's potential included).
    pub spring: f64,
    /// Compressed felts.
    pub felt: f64,
    /// Energy in compliant surfaces, as reported by their owners; zero without such surfaces.
    pub surface: f64,
}

impl Energies {
    /// Their sum.
    pub fn total(&self) -> f64 {
        self.kinetic + self.gravity + self.spring + self.felt + self.surface
    }

    /// Energies of a state, all curves as drawn.
    pub fn of<T: Scalar, const B: usize, const Z: usize>(model: &Model<T, B, Z>, state: &State<T, B, Z>) -> Self {
        Energies::displaced(model, state, |_| T::ZERO)
    }

    /// Energies of a state in which compliant surfaces are displaced, m away from their discs. What is in those
    /// surfaces is not among them.
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

/// Place of a loss in a step: the pivot of a body or a contact zone, by index.
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

/// Running totals of one run, J. Every dissipation is counted with the sign that a loss is positive.
#[derive(Debug, Clone, PartialEq)]
pub struct Ledger {
    /// Stored energy at the start.
    pub start: Energies,
    /// Stored energy when stock was last taken.
    pub now: Energies,
    /// Work of the drive, signed.
    pub drive_work: f64,
    /// Work of the drive where it was positive: the scale that the residual is compared with.
    pub drive_work_in: f64,
    /// Lost in dry pivots.
    pub pivot_dry: f64,
    /// Lost in viscous pivots.
    pub pivot_viscous: f64,
    /// Lost in felts.
    pub felt_damping: f64,
    /// Lost in Coulomb friction.
    pub coulomb: f64,
    /// Lost in surfaces that yield, as their owners say.
    pub surface: f64,
    /// Loss of the surfaces before the ledger was opened, J.
    pub surface_lost_before: f64,
    /// Work that had been done through surfaces from outside when it was last booked, J.
    pub surface_given_before: f64,
    /// The smallest single dissipation term of any step: friction never gives energy, so this is not negative.
    pub smallest_term: f64,
    /// Energies of the driving hand; zero without a hand. Separate from the other accounts, which belong to the
    /// mechanism.
    pub hand: HandEnergy,
}

impl Ledger {
    /// Starts the energy balance at a state.
    pub fn open<T: Scalar, const B: usize, const Z: usize>(model: &Model<T, B, Z>, state: &State<T, B, Z>) -> Self {
        Ledger::open_at(Energies::of(model, state), 0.0, 0.0)
    }

    /// Starts the energy balance at stored energies, where surfaces have lost so much before, J, and so much work has
    /// been done through them from outside, J.
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

    /// Books one step: `before` and `after` it, and the workspace that it left.
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

    /// [`Ledger::record`] for a caller that has the step's contacts at hand, zone by zone, and the absolute velocities
    /// before it, rad/s.
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

    /// Books what surfaces have lost since they were made, J, and what work has been done through them from outside, J.
    pub fn record_surfaces(&mut self, lost: f64, given: f64) {
        self.surface = lost - self.surface_lost_before;
        let work = given - core::mem::replace(&mut self.surface_given_before, given);
        self.drive_work += work;
        self.drive_work_in += work.max(0.0);
    }

    /// Takes stock of what is stored at a state; the residual refers to the last stock-taking.
    pub fn take_stock<T: Scalar, const B: usize, const Z: usize>(
        &mut self,
        model: &Model<T, B, Z>,
        state: &State<T, B, Z>,
    ) {
        self.now = Energies::of(model, state);
    }

    /// Everything lost.
    pub fn dissipated(&self) -> f64 {
        self.pivot_dry + self.pivot_viscous + self.felt_damping + self.coulomb + self.surface
    }

    /// Stored minus start minus work plus lost, J: zero if the energy balance closes.
    pub fn residual(&self) -> f64 {
        self.now.total() - self.start.total() - self.drive_work + self.dissipated()
    }

    /// |residual| over the work that the drive put in (over the energy lost and stored, where nothing was put in).
    pub fn residual_relative(&self) -> f64 {
        let scale = self.drive_work_in.max(self.dissipated());
        if scale > 0.0 { self.residual().abs() / scale } else { self.residual().abs() }
    }
}

/// Reports every loss of a step, J. The arguments are those of [`Ledger::record_contacts`].
///
/// Forces act at the theta point, so their work is force times velocity there. A dry law's loss is |force| times the
/// path of its velocity, which runs linearly over the step from before to after: not negative by itself even where the
/// velocity turns, and equal to the scheme's own work wherever it does not.
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
        let (_, gained) = model.compiled[z].felt.left_alone(&timing, &workspace.contacts.states[z].memory);
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
