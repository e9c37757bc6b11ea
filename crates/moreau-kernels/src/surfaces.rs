//! What yields under zones of a mechanism, and is no part of it: strings, say. The engine asks it before every step, and tells it afterwards what
//! pressed it.

use std::any::Any;

use moreau::{Settings, Surface, TOGETHER, Workspace};

/// Things under zones that yield ([`moreau::Yields`]). Indices count the zones in the order of [`Surfaces::zones`]. Displacements are along the zone's
/// normal, positive away from the disc.
///
/// The zones' surfaces may belong to one thing: a force on one then displaces the others within the same step ([`Surfaces::together`]).
pub trait Surfaces: Send {
    /// The mechanism's zones.
    fn zones(&self) -> &[usize];
    /// The length of the steps that follow, s. May allocate.
    fn set_step(&mut self, step_s: f64);
    /// While a mechanism is brought to rest: the surfaces follow their forces as if they had no inertia, so that they ring no longer than it moves.
    fn follow(&mut self, statically: bool);
    /// What a surface would do in the next step.
    fn surface(&self, index: usize) -> Surface<f64>;
    /// How many surfaces, from the first one on, belong to one thing. By how much a newton on one displaces another at the next step's end, m/N, the same both
    /// ways; and what pressed them in the last step, N. [`Surfaces::surface`] then says what each does if nothing presses any of them.
    fn together(&self, compliance: &mut [[f64; TOGETHER]; TOGETHER], forces: &mut [f64; TOGETHER]) -> usize {
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
    /// All that the following steps depend on, in lists of numbers: to each its name, of at most 24 bytes, and its numbers.
    fn save(&self, put: &mut dyn FnMut(&'static str, &mut dyn Iterator<Item = f64>));
    /// Goes on from there; from nothing (no list has any numbers) at rest. `each` tells the numbers of a list, with their indices, and returns how many
    /// there are.
    fn restore(&mut self, each: &dyn Fn(&str, &mut TellNumbers<'_>) -> usize);
    /// The thing itself, for who knows what it is.
    fn as_any(&self) -> &dyn Any;
    /// The same, to be changed.
    fn as_any_mut(&mut self) -> &mut dyn Any;
}

/// Told the numbers of a list one by one, each with its index.
pub type TellNumbers<'a> = dyn FnMut(usize, f64) + 'a;

/// Zones that may yield at once.
pub(crate) const MOST: usize = 8;

/// Surfaces with what the engine keeps for them.
pub(crate) struct Under {
    pub surfaces: Box<dyn Surfaces>,
    /// Forces of the last step, N.
    pub forces: [f64; MOST],
}

impl Under {
    pub fn new(mut surfaces: Box<dyn Surfaces>, settings: &Settings<f64>) -> Self {
        assert!(surfaces.zones().len() <= MOST, "at most {MOST} zones yield");
        surfaces.set_step(settings.step);
        Under { surfaces, forces: [0.0; MOST] }
    }

    /// Before a step of the mechanism.
    pub fn tell<const B: usize, const Z: usize, const N: usize>(
        &self,
        settings: &Settings<f64>,
        workspace: &mut Workspace<f64, B, Z, N>,
    ) {
        for (index, &zone) in self.surfaces.zones().iter().enumerate() {
            workspace.set_surface(settings, zone, &self.surfaces.surface(index));
        }
        let (mut compliance, mut forces) = ([[0.0; TOGETHER]; TOGETHER], [0.0; TOGETHER]);
        let count = self.surfaces.together(&mut compliance, &mut forces);
        workspace.set_together(settings, &self.surfaces.zones()[..count], &compliance, &forces);
    }

    /// The step, under the forces that were set.
    pub fn advance(&mut self) {
        let count = self.surfaces.zones().len();
        self.surfaces.advance(&self.forces[..count]);
    }

    /// How far a zone's surface is displaced, m; 0 for others.
    pub fn displacement(&self, zone: usize) -> f64 {
        let index = self.surfaces.zones().iter().position(|&z| z == zone);
        index.map_or(0.0, |index| self.surfaces.surface(index).displacement)
    }
}
