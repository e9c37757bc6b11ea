//! Working memory of a step, grouped by stage. Each group says which stage writes it and which ones read it; the stages
//! are those of the README's table, in call order.

use crate::contact::{Contact, ContactState};
use crate::curvature::Margins;
use crate::description::ModelError;
use crate::model::Model;
use crate::osnsp::active_set::Condensed;
use crate::osnsp::{Guess, Impulses, System};
use crate::pose::Pose;
use crate::real::{Mask, Real, Scalar};
use crate::settings::Settings;
use crate::surface::{COUPLED, Coupled, Surface, Yielding};
use crate::timing::Timing;

/// Working memory of a step. After the step it holds the forces and contacts at the time t0 + theta h.
///
/// A step's result does not depend on previous contents, so several mechanisms may share one workspace.
#[derive(Debug, Clone)]
pub struct Workspace<T: Real, const B: usize, const Z: usize, const N: usize> {
    pub(crate) kinematics: Kinematics<T, B>,
    pub(crate) contacts: Contacts<T, B, Z>,
    pub(crate) inertia: Inertia<T, B>,
    pub(crate) drive: Drive<T, B>,
    pub(crate) problem: Problem<T, B, N>,
    pub(crate) turning: Turning<T, Z>,
    pub(crate) forces: Forces<T, B, Z>,
    pub(crate) dry: DryFelts<T, Z>,
    pub(crate) dwell: Rested<T, B, Z>,
    /// The last Newton correction of the relative velocities. Written by `iterate` after the solver, read by
    /// `linearisation_holds` and by whoever asks for a contact after the step.
    pub(crate) correction: [T; B],
}

/// Where everything is and how fast it moves at the theta point.
///
/// Written by `theta_point` and `Pose::place` at the start of every Newton iteration. Read by all later stages.
#[derive(Debug, Clone)]
pub(crate) struct Kinematics<T, const B: usize> {
    pub pose: Pose<T, B>,
    /// Absolute angular velocities, before the iteration's correction.
    pub velocity: [T; B],
    /// Relative angular velocities, before the iteration's correction.
    pub joint_velocity: [T; B],
}

/// The zones near contact.
///
/// `narrow_phase` writes geometry and slip rows, `add_felts` the forces, tangents and margins. `assemble_laws` reads
/// forces and rows, `linearisation_holds` reads all of it.
#[derive(Debug, Clone)]
pub(crate) struct Contacts<T: Real, const B: usize, const Z: usize> {
    pub states: [ContactState<T, B>; Z],
    /// Lanes in which a zone is touched. Valid only for zones that the narrow phase tested (see `touched_in`).
    pub active: [T::Mask; Z],
    /// The zones that are touched in any lane, in the order in which they come.
    pub touched: [usize; Z],
    pub touched_count: usize,
    /// Distances of the felts from their kinks.
    pub margins: Margins<T>,
    /// Rows of the slip velocity, of zones with friction: written when such a zone first touches in a step, and kept.
    pub slip_row: [[T; B]; Z],
    pub has_slip_row: [T::Mask; Z],
    /// Motion of the compliant curves, as the caller has set it.
    pub surfaces: [Yielding<T>; Z],
    /// Compliant curves that are coupled, because they belong to one subsystem.
    pub coupled: Coupled<T>,
}

impl<T: Real, const B: usize, const Z: usize> Contacts<T, B, Z> {
    /// A zone that nobody has seen touched is: in its place among the others.
    pub(crate) fn touch(&mut self, zone: usize) {
        let mut place = self.touched_count;
        while place > 0 && self.touched[place - 1] > zone {
            self.touched[place] = self.touched[place - 1];
            place -= 1;
        }
        self.touched[place] = zone;
        self.touched_count += 1;
        self.active[zone] = T::Mask::splat(true);
        self.margins.include_opening(T::ZERO, self.active[zone]);
    }
}

/// Inertia at the predicted pose q_*.
///
/// Written by `joint_momentum` once per step, read by `linearise` in every iteration.
#[derive(Debug, Clone)]
pub(crate) struct Inertia<T, const B: usize> {
    /// Couplings of M(q_*) in absolute velocities, to the parent and to ancestors beyond it.
    pub coupling: [T; B],
    pub deep_coupling: [[T; B]; B],
    /// M w0.
    pub momentum: [T; B],
}

/// The drive.
///
/// `joint_momentum` writes the row once per step, `linearise` the force and tangent, `store_forces` the force of a
/// rigid drive, `move_hand` a hand. `linearisation_holds` reads an elastic drive's force and carries it along with the
/// correction.
#[derive(Debug, Clone)]
pub(crate) struct Drive<T, const B: usize> {
    pub site_row: [T; B],
    /// Force on the mechanism, N.
    pub force: T,
    /// Force of an elastic drive before its clamp at zero, N, and h dF/d(site velocity).
    pub pull: T,
    pub tangent: T,
    /// Place, m, and velocity, m/s, of a hand at the step's end, in the lanes that have ended.
    pub hand: [T; 2],
}

/// The one-step non-smooth problem and its solution.
///
/// `linearise` and `add_felts` write A and b, `warm_start_pivots` and `assemble_laws` the bounds, laws, impulses and
/// guess. The solver reads the system and corrects impulses and guess; `store_forces` and `keep_forces` read those.
#[derive(Debug, Clone)]
pub(crate) struct Problem<T: Real, const B: usize, const N: usize> {
    pub system: System<T, B, N>,
    pub impulses: Impulses<T, B, N>,
    pub guess: Guess<T, B, N>,
    /// The active-set solver's own.
    pub condensed: Condensed<T, B, N>,
    /// Origin of each sliding law.
    pub sources: [LawSource; N],
}

/// What a sliding law of the one-step problem represents.
#[derive(Debug, Clone, Copy)]
pub(crate) enum LawSource {
    /// Coulomb friction of a zone.
    Zone(usize),
    /// The set-valued loss of a zone's felt.
    Felt(usize),
    /// The rigid drive.
    Drive,
}

/// Rate at which each slip row turns, for steps that include it (README, "Sticking contacts").
///
/// `controlled_step` writes `slip_before` and `span` before the step; at fixed steps the span is zero, and nothing is
/// allowed for. `assemble_laws` reads them and writes `turn`.
#[derive(Debug, Clone)]
pub(crate) struct Turning<T, const Z: usize> {
    /// The slip velocity at the step's start along the last step's row, m/s.
    pub slip_before: [T; Z],
    /// The time from where that row was taken to the step's start, s. Zero: not known.
    pub span: T,
    /// Contribution of the row's turning until the step's end to each slip velocity, m/s, if the span is known.
    pub turn: [T; Z],
}

/// Felts with a set-valued loss; nobody touches this where there are none.
///
/// Written by `dry_felts::begin` before a step's first iteration, then by `dry_felts::assemble`, `store_forces` and
/// `dry_felts::unsettled`.
#[derive(Debug, Clone)]
pub(crate) struct DryFelts<T: Real, const Z: usize> {
    /// The dry part of the normal force, N; positive pushes.
    pub force: [T; Z],
    /// Data that Coulomb's law received for it.
    pub before: [T; Z],
    /// h dF/du1 of a felt that reverses.
    pub tangent: [T; Z],
    pub side: [T; Z],
    /// The lanes in which dg/dt changes its sign within the step.
    pub reversing: [T::Mask; Z],
    /// The lanes in which the one-step problem has a law for the felt.
    pub law: [T::Mask; Z],
}

/// How far friction has grown at rest, in this step: what slips in it has lost it. Nobody touches this where no
/// friction grows.
///
/// Written by `dwell::begin` before a step's first iteration and by `dwell::slipped`, read by `dwell::raise_bounds` and
/// `dwell::keep`.
#[derive(Debug, Clone)]
pub(crate) struct Rested<T, const B: usize, const Z: usize> {
    pub pivot: [T; B],
    pub zone: [T; Z],
}

/// Forces and sides of the set-valued laws, kept from iteration to iteration.
///
/// Written by `store_forces` (and `regularised_friction`), read by `assemble_laws` in the next iteration and by
/// `keep_forces`, which hands them to the state's contact cache.
#[derive(Debug, Clone)]
pub(crate) struct Forces<T, const B: usize, const Z: usize> {
    /// Torques of the pivots where their friction is regularised, N m.
    pub pivot_friction: [T; B],
    pub tangential: [T; Z],
    pub side: [T; Z],
    pub rigid_force: T,
}

impl<T: Real, const B: usize, const Z: usize, const N: usize> Workspace<T, B, Z, N> {
    /// Returns new working memory. [`Workspace::for_model`] also checks that it has room for a model's laws.
    pub fn new() -> Self {
        let z = T::ZERO;
        let no = T::Mask::splat(false);
        Workspace {
            kinematics: Kinematics { pose: Pose::new(), velocity: [z; B], joint_velocity: [z; B] },
            contacts: Contacts {
                states: [ContactState::apart(); Z],
                active: [no; Z],
                touched: [0; Z],
                touched_count: 0,
                margins: Margins::new(),
                slip_row: [[z; B]; Z],
                has_slip_row: [no; Z],
                surfaces: [Yielding::still(); Z],
                coupled: Coupled::nothing(),
            },
            inertia: Inertia { coupling: [z; B], deep_coupling: [[z; B]; B], momentum: [z; B] },
            drive: Drive { site_row: [z; B], force: z, pull: z, tangent: z, hand: [z; 2] },
            problem: Problem {
                system: System::new(),
                impulses: Impulses::new(),
                guess: Guess::new(),
                condensed: Condensed::new(),
                sources: [LawSource::Drive; N],
            },
            turning: Turning { slip_before: [z; Z], span: z, turn: [z; Z] },
            forces: Forces { pivot_friction: [z; B], tangential: [z; Z], side: [z; Z], rigid_force: z },
            dry: DryFelts {
                force: [z; Z],
                before: [z; Z],
                tangent: [z; Z],
                side: [z; Z],
                reversing: [no; Z],
                law: [no; Z],
            },
            dwell: Rested { pivot: [z; B], zone: [z; Z] },
            correction: [z; B],
        }
    }

    /// Returns new working memory with room for a model's laws.
    ///
    /// # Errors
    /// [`ModelError::TooManyLaws`] if the model has more than N.
    pub fn for_model(model: &Model<T, B, Z>) -> Result<Self, ModelError> {
        if model.laws() > N {
            return Err(ModelError::TooManyLaws { found: model.laws(), room: N });
        }
        Ok(Workspace::new())
    }

    /// Sets the motion of a zone's compliant surface ([`Description::yields`](crate::Description)) in the next step of
    /// these settings. Call it before every step: the workspace keeps the last motion set.
    pub fn set_surface(&mut self, settings: &Settings<T>, zone: usize, surface: &Surface<T>) {
        let h = settings.step;
        self.contacts.surfaces[zone] = Yielding::of(surface, h, settings.theta * h);
    }

    /// Couples the surfaces of one external subsystem by its compliance matrix. Call it before every step, after
    /// [`Workspace::set_surface`] has set the motion of each surface without contact forces.
    ///
    /// `compliance[i][j]`, m/N, is the displacement of surface i at the step's end per newton that acts on surface j
    /// throughout the step. The matrix is symmetric; its diagonal is not read. `guess`: estimated contact forces, N.
    /// With fewer than two zones, or more than [`COUPLED`], no surfaces are coupled.
    pub fn set_coupled_surfaces(
        &mut self,
        settings: &Settings<T>,
        zones: &[usize],
        compliance: &[[T; COUPLED]; COUPLED],
        guess: &[T; COUPLED],
    ) {
        let coupled = &mut self.contacts.coupled;
        coupled.count = if (2..=COUPLED).contains(&zones.len()) { zones.len() } else { 0 };
        for i in 0..coupled.count {
            coupled.zone[i] = zones[i];
            for j in 0..coupled.count {
                coupled.mobility[i][j] = if i == j { T::ZERO } else { compliance[i][j] / settings.step };
            }
        }
        for i in 0..coupled.count {
            coupled.from_others[i] = coupled.others(i, guess);
            let surface = &mut self.contacts.surfaces[zones[i]];
            surface.drift += coupled.from_others[i];
            surface.offset += settings.theta * settings.step * coupled.from_others[i];
        }
    }

    /// Solves for the forces on coupled surfaces at the velocities at the step's end, and removes the coupling. Call it
    /// after a step, before you read its forces.
    pub fn settle_surfaces(&mut self, model: &Model<T, B, Z>, settings: &Settings<T>) {
        if self.contacts.coupled.count > 1 {
            crate::coupled::settle(model, settings, self);
            self.contacts.coupled.count = 0;
        }
    }

    /// Returns the pose at which the last Newton iteration evaluated the forces.
    pub fn pose(&self) -> &Pose<T, B> {
        &self.kinematics.pose
    }

    /// Returns the force of the drive on the mechanism during the last step, N, along the site's direction.
    pub fn drive_force(&self) -> T {
        self.drive.force
    }

    /// Velocity of the driven point at the theta point of the last step, m/s, given the relative velocities before and
    /// after it.
    pub(crate) fn drive_velocity(&self, model: &Model<T, B, Z>, settings: &Settings<T>, joints: &[[T; B]; 2]) -> f64
    where
        T: Scalar,
    {
        settings.at_theta(joints.each_ref().map(|w| model.site_support.product(&self.drive.site_row, w).to_f64()))
    }

    /// Returns the normal force of a zone during the last step, N; zero if it was not touched.
    #[inline]
    pub fn normal_force(&self, model: &Model<T, B, Z>, settings: &Settings<T>, zone: usize) -> T {
        if self.touched_zones().contains(&zone) { self.pressed(model, settings, zone) } else { T::ZERO }
    }

    #[cold]
    #[inline(never)]
    fn pressed(&self, model: &Model<T, B, Z>, settings: &Settings<T>, zone: usize) -> T {
        self.contact(model, settings, zone).map_or(T::ZERO, |contact| contact.force)
    }

    /// Returns a zone's contact during the last step; `None` if it was not touched.
    pub fn contact(&self, model: &Model<T, B, Z>, settings: &Settings<T>, zone: usize) -> Option<Contact<T>> {
        let touched = self.touched_in(zone);
        if !touched.any() {
            return None;
        }
        let (compiled, support) = (&model.compiled[zone], &model.supports[zone]);
        let timing = Timing::new(settings.step, settings.theta);
        let state = &self.contacts.states[zone];
        let contact = state.contact(
            compiled,
            support,
            self.pose(),
            &self.correction,
            &timing,
            touched,
            &self.contacts.surfaces[zone],
        );
        if !compiled.dry {
            return Some(contact);
        }
        let dry = T::only(touched, self.dry.force[zone]);
        let (force, damping_force) = ((contact.force + dry).max(T::ZERO), contact.damping_force + dry);
        Some(Contact { force, damping_force, ..contact })
    }

    /// Returns the zones that were touched during the last step (in any lane), ascending.
    pub fn touched_zones(&self) -> &[usize] {
        &self.contacts.touched[..self.contacts.touched_count]
    }

    /// The lanes in which a zone was touched during the last step.
    pub(crate) fn touched_in(&self, zone: usize) -> T::Mask {
        let contacts = &self.contacts;
        let anywhere = contacts.touched[..contacts.touched_count].contains(&zone);
        if anywhere { contacts.active[zone] } else { T::Mask::splat(false) }
    }

    /// Slip velocities of a zone with friction before and after the last step, along its row, given the relative
    /// velocities, m/s; zero if it was not touched.
    pub(crate) fn slip(&self, model: &Model<T, B, Z>, zone: usize, joints: &[[T; B]; 2]) -> [T; 2] {
        if !(self.touched_in(zone).any() && model.compiled[zone].slides) {
            return [T::ZERO; 2];
        }
        let [u0, u1] = joints.each_ref().map(|w| model.supports[zone].product(&self.contacts.slip_row[zone], w));
        let turn = T::only(T::ZERO.lt(self.turning.span), self.turning.turn[zone]);
        [u0 - turn, u1 + turn]
    }
}

impl<T: Real, const B: usize, const Z: usize, const N: usize> Default for Workspace<T, B, Z, N> {
    fn default() -> Self {
        Self::new()
    }
}
