//! Compliant external subsystems under zones of a mechanism, e.g. strings. The engine asks for the motion of their
//! surfaces before every step, and passes them the contact forces after it.

use std::any::Any;

use moreau::{COUPLED, Model, Pose, Settings, SiteInput, Sleep, State, Surface, Workspace};

/// A compliant external subsystem under zones ([`moreau::Yields`]), implemented by the caller. An index is a zone's
/// place in [`Surfaces::zones`]. Displacements are along the zone's normal, positive away from the disc.
///
/// The surfaces may be coupled: a force on one then displaces the others within the same step ([`Surfaces::coupled`]).
pub trait Surfaces: Send {
    /// Returns the zones of the mechanism that press on this subsystem.
    fn zones(&self) -> &[usize];
    /// Returns the number of parts in which a step of this length, s, should be taken.
    fn parts(&self, step_s: f64) -> Parts {
        let _ = step_s;
        Parts::WHOLE
    }
    /// Sets the length of the following steps, s, and their parts. Prepares everything that depends on the length of a
    /// part, for both lengths. May allocate. The parts are then [`Parts::apart`] until [`Surfaces::take`] is called.
    fn set_step(&mut self, step_s: f64, parts: &Parts);
    /// Sets whether the following steps are taken in [`Parts::near`] parts. Changes neither positions nor energy; does
    /// not allocate.
    fn take(&mut self, near: bool);
    /// Sets whether the surfaces follow their forces without inertia. Used while a mechanism is brought to rest, so
    /// that the surfaces do not ring longer than it moves.
    fn follow(&mut self, statically: bool);
    /// Returns the predicted motion of a surface in the next step.
    fn surface(&self, index: usize) -> Surface<f64>;
    /// Returns how many surfaces, from the first on, are coupled. Writes their compliance matrix (displacement of one
    /// at the next step's end per newton on another, m/N, symmetric) and the forces of the last step, N.
    /// [`Surfaces::surface`] then returns the motion of each without force on any of them.
    fn coupled(&self, compliance: &mut [[f64; COUPLED]; COUPLED], forces: &mut [f64; COUPLED]) -> usize {
        let _ = (compliance, forces);
        0
    }
    /// Advances by one step under contact forces, N, that are constant over the step.
    fn advance(&mut self, forces: &[f64]);
    /// Returns whether the last step changed nothing. If so, the next one under the same forces changes nothing either.
    fn rests(&self) -> bool;
    /// Returns the largest possible displacement of a surface from its described place toward the mechanism, m, while
    /// the mechanism stands still and no new contact begins. Infinite if unknown: the excursion of the mechanism's
    /// description then limits it. Minus infinity if the surface can touch nothing new. It decides which steps are
    /// skipped because they change nothing: a larger value costs time, but changes no result.
    fn reach(&self, index: usize) -> f64 {
        let _ = index;
        f64::INFINITY
    }
    /// Returns the stored energy of the subsystem, J.
    fn energy(&self) -> f64;
    /// Returns the energy lost since the subsystem was created, J.
    fn lost(&self) -> f64;
    /// Returns the work done on the mechanism from outside through the surfaces since they were created, J.
    fn given(&self) -> f64 {
        0.0
    }
    /// Saves everything that the following steps depend on, as lists of numbers. `put` receives each list's name, of at
    /// most 24 bytes, and its numbers.
    fn save(&self, put: &mut dyn FnMut(&'static str, &mut dyn Iterator<Item = f64>));
    /// Restores saved lists; if all lists are empty, resets to rest. `each` passes the numbers of a list, with their
    /// indices, to a callback, and returns how many there are.
    fn restore(&mut self, each: &dyn Fn(&str, &mut TellNumbers<'_>) -> usize);
    /// Returns the subsystem itself, for callers that know its type.
    fn as_any(&self) -> &dyn Any;
    /// Returns the subsystem itself for changes, for callers that know its type.
    fn as_any_mut(&mut self) -> &mut dyn Any;
}

/// Number of equal parts of a step: few while the mechanism is far from the first surface, more while it presses the
/// surface or may do so before the step ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parts {
    /// Number of parts while the mechanism is far; a power of two.
    pub apart: u32,
    /// Number of parts while it is near; a power of two, not below `apart`.
    pub near: u32,
    /// Distance of the first zone's disc from its surface at which the mechanism counts as near, m.
    pub reach_m: f64,
}

impl Parts {
    /// One part in every step.
    pub const WHOLE: Self = Parts { apart: 1, near: 1, reach_m: 0.0 };
}

/// Halving of steps near a surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Halving {
    /// The number of parts that the surfaces request.
    #[default]
    Auto,
    /// This many more halvings than requested, to estimate the remaining error.
    Further(u32),
    /// This many fewer, for loops that must not be late.
    Fewer(u32),
    /// No halving: all steps are whole.
    Never,
}

impl Halving {
    /// What becomes of the parts that surfaces ask for.
    fn of(self, asked: Parts) -> Parts {
        match self {
            Halving::Auto => asked,
            Halving::Further(times) => Parts { near: asked.near.saturating_mul(1 << times.min(16)), ..asked },
            Halving::Fewer(times) => Parts { near: (asked.near >> times.min(31)).max(asked.apart), ..asked },
            Halving::Never => Parts::WHOLE,
        }
    }
}

/// Callback that receives the numbers of a list one by one, each with its index.
pub type TellNumbers<'a> = dyn FnMut(usize, f64) + 'a;

/// Largest number of zones with compliant surfaces.
pub(crate) const MOST: usize = 8;

/// Largest number of steps after which a distant zone is checked again.
const FARTHEST: f64 = 256.0;

/// Contact conditions of a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Over {
    /// No compliant surface.
    Nothing,
    /// The surfaces are still, and the mechanism sleeps.
    Still,
    /// The surfaces ring while the mechanism sleeps.
    Ringing,
    /// The mechanism moves on its surfaces.
    Awake,
}

/// Surfaces, with the engine's data about them.
pub(crate) struct Under {
    pub surfaces: Box<dyn Surfaces>,
    /// Forces of the last step, N.
    pub forces: [f64; MOST],
    parts: Parts,
    /// Whether the last step's parts were those of [`Parts::near`].
    near: bool,
    /// Number of steps in which nothing can come near the first surface, however it moves.
    far: u32,
}

impl Under {
    pub(crate) fn new(surfaces: Box<dyn Surfaces>, step_s: f64, halving: Halving) -> Self {
        assert!(surfaces.zones().len() <= MOST, "at most {MOST} zones yield");
        let mut under = Under { surfaces, forces: [0.0; MOST], parts: Parts::WHOLE, near: false, far: 0 };
        under.prepare(step_s, halving);
        under
    }

    /// For steps of another length. May allocate.
    pub(crate) fn prepare(&mut self, step_s: f64, halving: Halving) {
        self.parts = halving.of(self.surfaces.parts(step_s));
        self.surfaces.set_step(step_s, &self.parts);
        (self.near, self.far) = (false, 0);
    }

    /// The mechanism was put somewhere else.
    pub(crate) fn moved(&mut self) {
        self.far = 0;
    }

    /// Into how many parts the next step is taken. That is a function of where everything is, so that whoever goes on
    /// from a saved state takes the same parts. A change wakes what sleeps: it slept in steps of another length.
    pub(crate) fn choose<const B: usize, const Z: usize>(
        &mut self,
        input: &SiteInput<f64>,
        (model, state, sleep): (&Model<f64, B, Z>, &State<f64, B, Z>, &mut Sleep<f64>),
    ) -> u32 {
        let Parts { apart, near, reach_m } = self.parts;
        if near == apart {
            return apart;
        }
        if self.far > 0 {
            self.far -= 1;
            return apart;
        }
        if sleep.would_rest(input).is_some() && self.surfaces.rests() {
            // Nothing changes, however it is taken.
            return 1;
        }
        let is_near = self.surfaces.zones().first().is_some_and(|&zone| {
            let open_m = -Pose::of(model, &state.angle).compression(model, zone);
            let beyond_m = open_m - reach_m - model.excursion(zone);
            // It comes nearer by the reach in a step, at most; below zero this is none.
            self.far = (beyond_m / reach_m).min(FARTHEST) as u32;
            beyond_m < 0.0 && open_m + self.surfaces.surface(0).displacement < reach_m
        });
        if is_near != self.near {
            self.near = is_near;
            self.surfaces.take(is_near);
            sleep.wake();
        }
        if is_near { near } else { apart }
    }

    /// Before a step: hands the surfaces to the workspace. A mechanism that sleeps is left out while they ring, if they
    /// cannot reach it.
    #[cold]
    #[inline(never)]
    pub(crate) fn before_step<const B: usize, const Z: usize, const N: usize>(
        &self,
        settings: &Settings<f64>,
        input: &SiteInput<f64>,
        (model, state, sleep): (&Model<f64, B, Z>, &State<f64, B, Z>, Option<&mut Sleep<f64>>),
        workspace: &mut Workspace<f64, B, Z, N>,
    ) -> Over {
        let rested = self.surfaces.rests();
        let asleep = sleep.is_some_and(|sleep| {
            if !rested && sleep.is_asleep() && self.reach(model, state) {
                sleep.wake();
            }
            sleep.would_rest(input).is_some()
        });
        if !asleep {
            self.hand_over(settings, workspace);
        }
        match (asleep, rested) {
            (true, true) => Over::Still,
            (true, false) => Over::Ringing,
            (false, _) => Over::Awake,
        }
    }

    /// Whether a surface could touch the mechanism where it is now.
    fn reach<const B: usize, const Z: usize>(&self, model: &Model<f64, B, Z>, state: &State<f64, B, Z>) -> bool {
        let pose = Pose::of(model, &state.angle);
        let reaches = |(index, &zone): (usize, &usize)| {
            pose.compression(model, zone) > -model.excursion(zone).min(self.surfaces.reach(index))
        };
        self.surfaces.zones().iter().enumerate().any(reaches)
    }

    fn hand_over<const B: usize, const Z: usize, const N: usize>(
        &self,
        settings: &Settings<f64>,
        workspace: &mut Workspace<f64, B, Z, N>,
    ) {
        for (index, &zone) in self.surfaces.zones().iter().enumerate() {
            workspace.set_surface(settings, zone, &self.surfaces.surface(index));
        }
        let (mut compliance, mut forces) = ([[0.0; COUPLED]; COUPLED], [0.0; COUPLED]);
        let count = self.surfaces.coupled(&mut compliance, &mut forces);
        workspace.set_coupled_surfaces(settings, &self.surfaces.zones()[..count], &compliance, &forces);
    }

    /// After a step: the surfaces take theirs, under the mechanism's forces.
    #[cold]
    #[inline(never)]
    pub(crate) fn after_step<const B: usize, const Z: usize, const N: usize>(
        &mut self,
        over: Over,
        settings: &Settings<f64>,
        model: &Model<f64, B, Z>,
        workspace: &mut Workspace<f64, B, Z, N>,
    ) {
        if over == Over::Awake {
            workspace.settle_surfaces(model, settings);
            for (index, &zone) in self.surfaces.zones().iter().enumerate() {
                self.forces[index] = workspace.normal_force(model, settings, zone);
            }
        }
        if over != Over::Still {
            let count = self.surfaces.zones().len();
            self.surfaces.advance(&self.forces[..count]);
        }
    }

    /// Displacement of a zone's surface, m; 0 for rigid ones.
    pub(crate) fn displacement(&self, zone: usize) -> f64 {
        let index = self.surfaces.zones().iter().position(|&z| z == zone);
        index.map_or(0.0, |index| self.surfaces.surface(index).displacement)
    }
}
