//! Compliant external subsystems under zones of a mechanism: strings, say. The engine asks for their surfaces before
//! every step, and reports the contact forces to them afterwards.

use std::any::Any;

use moreau::{COUPLED, Input, Model, Pose, Settings, Sleep, State, Surface, Workspace};

/// A compliant external subsystem under zones ([`moreau::Yields`]). The trait inverts a dependency: the subsystem is
/// the caller's. Indices count the zones in the order of [`Surfaces::zones`]. Displacements are along the zone's
/// normal, positive away from the disc.
///
/// The surfaces may be coupled: a force on one then displaces the others within the same step ([`Surfaces::coupled`]).
pub trait Surfaces: Send {
    /// The mechanism's zones.
    fn zones(&self) -> &[usize];
    /// Into how many parts a step of a length, s, is to be taken.
    fn parts(&self, step_s: f64) -> Parts {
        let _ = step_s;
        Parts::WHOLE
    }
    /// The length of the steps that follow, s, and their parts: whatever depends on the length of a part is prepared
    /// for both lengths. May allocate. Parts are then those apart, until [`Surfaces::take`].
    fn set_step(&mut self, step_s: f64, parts: &Parts);
    /// Whether the steps that follow are taken in the parts of [`Parts::near`]. Changes neither where anything is nor
    /// what energy it has; does not allocate.
    fn take(&mut self, near: bool);
    /// While a mechanism is brought to rest: the surfaces follow their forces as if they had no inertia, so that they
    /// ring no longer than it moves.
    fn follow(&mut self, statically: bool);
    /// What a surface would do in the next step.
    fn surface(&self, index: usize) -> Surface<f64>;
    /// How many surfaces, from the first one on, are coupled; writes their compliance matrix (the displacement of one
    /// at the next step's end per newton on another, m/N, symmetric) and the forces of the last step, N.
    /// [`Surfaces::surface`] then says what each does if nothing presses any of them.
    fn coupled(&self, compliance: &mut [[f64; COUPLED]; COUPLED], forces: &mut [f64; COUPLED]) -> usize {
        let _ = (compliance, forces);
        0
    }
    /// Takes the step, under forces, N, that lasted for all of it.
    fn advance(&mut self, forces: &[f64]);
    /// Whether the last step changed nothing, so that the next one does not either if the same forces press.
    fn rests(&self) -> bool;
    /// The farthest that a surface may come out of where it is drawn, toward the mechanism, while this stands still and
    /// nothing presses on it anew, m: infinite where that is not known, for it counts up to the excursion of the
    /// mechanism's description; minus infinity if it touches nothing that it does not touch now. It decides which steps
    /// are left out because they change nothing, so that a larger one costs time and no bit.
    fn reach(&self, index: usize) -> f64 {
        let _ = index;
        f64::INFINITY
    }
    /// Energy that is in them, J.
    fn energy(&self) -> f64;
    /// Energy that they have lost since they were made, J.
    fn lost(&self) -> f64;
    /// Work that whatever moves them from outside has done on the mechanism since they were made, J.
    fn given(&self) -> f64 {
        0.0
    }
    /// All that the following steps depend on, in lists of numbers: to each its name, of at most 24 bytes, and its
    /// numbers.
    fn save(&self, put: &mut dyn FnMut(&'static str, &mut dyn Iterator<Item = f64>));
    /// Goes on from there; from nothing (no list has any numbers) at rest. `each` tells the numbers of a list, with
    /// their indices, and returns how many there are.
    fn restore(&mut self, each: &dyn Fn(&str, &mut TellNumbers<'_>) -> usize);
    /// The subsystem itself, for callers that know its type.
    fn as_any(&self) -> &dyn Any;
    /// The same, to be changed.
    fn as_any_mut(&mut self) -> &mut dyn Any;
}

/// Into how many equal parts a step is taken: few while nothing is near the first surface, more while something presses
/// it or may do so before the step ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parts {
    /// While nothing is near; a power of two.
    pub apart: u32,
    /// While something is; a power of two, and no fewer.
    pub near: u32,
    /// Distance of the first zone's disc from its surface at which halving begins, m.
    pub reach_m: f64,
}

impl Parts {
    /// Every step is taken whole.
    pub const WHOLE: Self = Parts { apart: 1, near: 1, reach_m: 0.0 };
}

/// How often steps are halved where something is near.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Halving {
    /// The order that the surfaces request.
    #[default]
    AsAsked,
    /// So many times more: what is left of the error is seen from it.
    Further(u32),
    /// Never: all steps are whole.
    Never,
}

impl Halving {
    /// What becomes of the parts that surfaces ask for.
    fn of(self, asked: Parts) -> Parts {
        match self {
            Halving::AsAsked => asked,
            Halving::Further(times) => Parts { near: asked.near.saturating_mul(1 << times.min(16)), ..asked },
            Halving::Never => Parts::WHOLE,
        }
    }
}

/// Told the numbers of a list one by one, each with its index.
pub type TellNumbers<'a> = dyn FnMut(usize, f64) + 'a;

/// Zones that may yield at once.
pub(crate) const MOST: usize = 8;

/// What is far is looked at again after so many steps.
const FARTHEST: f64 = 256.0;

/// What a step presses on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Over {
    /// Nothing compliant.
    Nothing,
    /// Surfaces that are still, and the mechanism sleeps.
    Still,
    /// Surfaces that ring while it sleeps.
    Ringing,
    /// Surfaces, and it moves.
    Awake,
}

/// Surfaces with what the engine keeps for them.
pub(crate) struct Under {
    pub surfaces: Box<dyn Surfaces>,
    /// Forces of the last step, N.
    pub forces: [f64; MOST],
    parts: Parts,
    /// Whether the last step's parts were those of [`Parts::near`].
    near: bool,
    /// For so many steps nothing can come near, wherever it goes.
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
        input: &Input<f64>,
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
        input: &Input<f64>,
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
