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
    /// The length of the steps that follow, s. May allocate.
    fn set_step(&mut self, step_s: f64);
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
    /// Whether a surface may come to touch what it does not touch now, while the mechanism stands still.
    fn may_reach(&self, index: usize) -> bool {
        let _ = index;
        true
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

/// Told the numbers of a list one by one, each with its index.
pub type TellNumbers<'a> = dyn FnMut(usize, f64) + 'a;

/// Zones that may yield at once.
pub(crate) const MOST: usize = 8;

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
}

impl Under {
    pub(crate) fn new(mut surfaces: Box<dyn Surfaces>, settings: &Settings<f64>) -> Self {
        assert!(surfaces.zones().len() <= MOST, "at most {MOST} zones yield");
        surfaces.set_step(settings.step);
        Under { surfaces, forces: [0.0; MOST] }
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
            self.surfaces.may_reach(index) && pose.compression(model, zone) > -model.excursion(zone)
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

    /// How far a zone's surface is displaced, m; 0 for others.
    pub(crate) fn displacement(&self, zone: usize) -> f64 {
        let index = self.surfaces.zones().iter().position(|&z| z == zone);
        index.map_or(0.0, |index| self.surfaces.surface(index).displacement)
    }
}
