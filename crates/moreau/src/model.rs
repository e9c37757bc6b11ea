//! The compiled model: a checked [`Description`] with all quantities that do not change from step to step. Immutable.

use crate::compiled_zone::CompiledZone;
use crate::curvature::Curvatures;
use crate::description::{Body, Description, DescriptionPart, Dwell, GROUND, ModelError, Site, Spring, Zone};
use crate::real::{Real, Scalar};
use crate::support::Support;
use crate::tree::Tree;
use crate::vector::{Vector, add, dot, scale};

/// Stands in place of a row's length where a zone's curve yields.
pub(crate) const YIELDING: usize = usize::MAX;

/// How a model's laws gain friction at rest: of pivots and of zones, ratio - 1 and 1/tau, 1/s; zero where they do not.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Dwelling<T, const B: usize, const Z: usize> {
    pub pivot_gain: [T; B],
    pub pivot_rate: [T; B],
    pub zone_gain: [T; Z],
    pub zone_rate: [T; Z],
    /// Number of laws whose friction grows at rest.
    pub count: usize,
}

impl<T: Real, const B: usize, const Z: usize> Dwelling<T, B, Z> {
    pub(crate) fn none() -> Self {
        let z = T::ZERO;
        Dwelling { pivot_gain: [z; B], pivot_rate: [z; B], zone_gain: [z; Z], zone_rate: [z; Z], count: 0 }
    }
}

/// Mechanism of at most `B` bodies and `Z` zones, checked and ready for stepping. Built by [`Description::compile`].
#[derive(Debug, Clone)]
pub struct Model<T, const B: usize, const Z: usize> {
    pub(crate) tree: Tree<T, B>,
    // The pivots.
    pub(crate) dry: [T; B],
    pub(crate) viscous: [T; B],
    /// Spring torque at relative angle 0, and stiffness.
    pub(crate) spring_torque: [T; B],
    pub(crate) spring_stiffness: [T; B],
    // Inertia.
    /// Diagonal of the mass matrix in absolute velocities: own inertia plus every descendant's mass at its branch's
    /// pivot.
    pub(crate) inertia: [T; B],
    /// What that diagonal contributes to the one of the mass matrix in relative velocities: a joint turns all that it
    /// carries.
    pub(crate) joint_inertia: [T; B],
    /// First moment of body and descendants about the pivot, fixed in the body's frame (see README, "Inertia").
    pub(crate) moment: [Vector<T>; B],
    pub(crate) moment_x: [T; B],
    pub(crate) moment_y: [T; B],
    /// Gravity times |moment|, N m, and |branch arm| times |moment|, kg m2: how strongly weight and centrifugal force
    /// change with the pose.
    pub(crate) weight: [T; B],
    pub(crate) centrifugal: [T; B],
    // The zones.
    /// Zones of the description; unused places are vacant.
    pub(crate) zones: [Zone<T>; Z],
    /// Zones in the form that the step reads.
    pub(crate) compiled: [CompiledZone<T>; Z],
    /// Supporting joints of each zone.
    pub(crate) supports: [Support<T, B>; Z],
    /// Largest displacement of each curve toward its disc, m; zero where it does not yield.
    pub(crate) excursions: [T; Z],
    /// How the narrow phase looks at each: the length of its row, or [`YIELDING`].
    pub(crate) look: [usize; Z],
    pub(crate) zone_count: usize,
    /// The zones with Coulomb friction.
    pub(crate) sliding_zones: [usize; Z],
    pub(crate) sliding_count: usize,
    /// Zones whose felts have an internal state.
    pub(crate) remembering: [usize; Z],
    pub(crate) remembering_count: usize,
    /// Zones whose felts have a set-valued loss.
    pub(crate) dry_felts: [usize; Z],
    pub(crate) dry_count: usize,
    /// Dry friction that grows while it sticks.
    pub(crate) dwelling: Dwelling<T, B, Z>,
    /// Whether a felt has an internal state or friction grows at rest: numbers kept besides motion and contact cache.
    pub(crate) remembers: bool,
    /// Bound on the error of a step's linearisation due to all felts.
    pub(crate) curvatures: Curvatures<T, B>,
    /// Largest number of set-valued laws in one step: [`Description::laws`].
    pub(crate) laws: usize,
    // The drive.
    pub(crate) site: Option<Site<T>>,
    pub(crate) site_support: Support<T, B>,
    /// Gravity, pointing toward -y.
    pub(crate) gravity: T,
}

impl<T: Scalar> Description<'_, T> {
    /// Checks the description and compiles it for `B` bodies and `Z` zones. [`Body::inert`] fills unused places.
    ///
    /// # Errors
    /// Returns the first fault ([`Description::check`]), or [`ModelError::TooManyBodies`] or
    /// [`ModelError::TooManyZones`] if the model has too little room.
    pub fn compile<const B: usize, const Z: usize>(&self) -> Result<Model<T, B, Z>, ModelError> {
        let Description { bodies, zones, .. } = *self;
        if bodies.len() > B {
            return Err(ModelError::TooManyBodies { found: bodies.len(), room: B });
        }
        if zones.len() > Z {
            return Err(ModelError::TooManyZones { found: zones.len(), room: Z });
        }
        self.check()?;
        let tree = Tree::of(bodies);
        let supports =
            core::array::from_fn(|z| zones.get(z).map_or(Support::empty(), |zone| Support::of_zone(&tree, zone)));
        let all_zones = core::array::from_fn(|z| zones.get(z).copied().unwrap_or(Zone::vacant()));
        let zero = [T::ZERO; B];
        let mut model = Model {
            dry: core::array::from_fn(|i| bodies.get(i).map_or(T::ZERO, |body| body.dry)),
            viscous: core::array::from_fn(|i| bodies.get(i).map_or(T::ZERO, |body| body.viscous)),
            spring_torque: zero,
            spring_stiffness: zero,
            inertia: [T::ONE; B],
            joint_inertia: zero,
            moment: [[T::ZERO; 2]; B],
            moment_x: zero,
            moment_y: zero,
            weight: zero,
            centrifugal: zero,
            zones: all_zones,
            compiled: all_zones.map(|zone| CompiledZone::of(&zone)),
            curvatures: Curvatures::of(zones.iter().zip(&supports)),
            excursions: [T::ZERO; Z],
            look: supports.each_ref().map(Support::count),
            supports,
            zone_count: zones.len(),
            sliding_zones: [0; Z],
            sliding_count: 0,
            remembering: [0; Z],
            remembering_count: 0,
            dry_felts: [0; Z],
            dry_count: 0,
            dwelling: Dwelling::none(),
            remembers: false,
            laws: self.laws(),
            site_support: self.site.map_or(Support::empty(), |site| Support::of_point(&tree, site.body, site.point)),
            site: self.site,
            gravity: self.gravity,
            tree,
        };
        model.set_inertia(bodies);
        model.set_springs(self.springs);
        for (z, zone) in zones.iter().enumerate() {
            if zone.friction.is_some() {
                model.sliding_zones[model.sliding_count] = z;
                model.sliding_count += 1;
            }
            if zone.felt.dry().is_some() {
                model.dry_felts[model.dry_count] = z;
                model.dry_count += 1;
            }
            if zone.felt.remembers() {
                model.remembering[model.remembering_count] = z;
                model.remembering_count += 1;
            }
        }
        for yields in self.yields {
            model.compiled[yields.zone].set_yielding();
            model.look[yields.zone] = YIELDING;
            model.excursions[yields.zone] = yields.excursion;
        }
        model.set_dwells(self.dwells);
        model.remembers = model.remembering_count > 0 || model.dwelling.count > 0;
        Ok(model)
    }
}

impl<T: Scalar, const B: usize, const Z: usize> Model<T, B, Z> {
    /// The mass matrix's constant part, first moments, and how strongly weight and centrifugal force change (README,
    /// "Inertia").
    fn set_inertia(&mut self, bodies: &[Body<T>]) {
        let mut branch_mass = [T::ZERO; B];
        for (i, body) in bodies.iter().enumerate() {
            self.inertia[i] = body.inertia;
            self.moment[i] = scale(body.center_of_mass, body.mass);
            branch_mass[i] = body.mass;
        }
        for i in (0..bodies.len()).rev() {
            let p = bodies[i].parent;
            if p != GROUND {
                let m = branch_mass[i];
                branch_mass[p] += m;
                self.inertia[p] += m * dot(bodies[i].pivot, bodies[i].pivot);
                self.moment[p] = add(self.moment[p], scale(bodies[i].pivot, m));
            }
        }
        for i in 0..B {
            for j in 0..=i {
                if self.tree.carries(j, i) {
                    self.joint_inertia[j] += self.inertia[i];
                }
            }
        }
        for i in 0..bodies.len() {
            [self.moment_x[i], self.moment_y[i]] = self.moment[i];
            let moment = dot(self.moment[i], self.moment[i]).sqrt();
            self.weight[i] = self.gravity.abs() * moment;
            let p = bodies[i].parent;
            if p != GROUND {
                let arm = dot(bodies[i].pivot, bodies[i].pivot).sqrt();
                self.centrifugal[i] = arm * moment;
                self.centrifugal[p] += arm * moment;
            }
        }
    }

    fn set_springs(&mut self, springs: &[Spring<T>]) {
        for s in springs {
            self.spring_torque[s.body] += s.torque + s.stiffness * s.reference;
            self.spring_stiffness[s.body] += s.stiffness;
        }
    }

    fn set_dwells(&mut self, dwells: &[Dwell<T>]) {
        for dwell in dwells {
            let (gain, rate) = (dwell.ratio - T::ONE, T::ONE / dwell.time);
            let at = &mut self.dwelling;
            match dwell.part {
                DescriptionPart::Body(i) => (at.pivot_gain[i], at.pivot_rate[i]) = (gain, rate),
                DescriptionPart::Zone(z) => (at.zone_gain[z], at.zone_rate[z]) = (gain, rate),
                _ => continue,
            }
            at.count += 1;
        }
    }

    /// Returns the number of zones in use.
    pub fn zone_count(&self) -> usize {
        self.zone_count
    }

    /// Returns the zones in use.
    pub fn zones(&self) -> &[Zone<T>] {
        &self.zones[..self.zone_count]
    }

    /// Returns the parent of a body, or [`GROUND`].
    pub fn parent(&self, body: usize) -> usize {
        self.tree.parent[body]
    }

    /// Returns the driven point; `None` if there is none.
    pub fn site(&self) -> Option<&Site<T>> {
        self.site.as_ref()
    }
}

impl<T: Real, const B: usize, const Z: usize> Model<T, B, Z> {
    /// Returns the largest number of set-valued laws in one step ([`Description::laws`]). A workspace must have room
    /// for at least as many.
    pub fn laws(&self) -> usize {
        self.laws
    }

    /// Zones whose felts have an internal state: [`State::memory`](crate::SavedState::memory).
    pub(crate) fn remembering_zones(&self) -> &[usize] {
        &self.remembering[..self.remembering_count]
    }

    /// Whether a zone's curve yields.
    pub(crate) fn yields(&self, zone: usize) -> bool {
        zone < self.zone_count && self.compiled[zone].felt.yields()
    }

    /// Returns the largest displacement of a zone's curve toward the disc from its described place, m; zero if the
    /// curve belongs to no compliant subsystem.
    pub fn excursion(&self, zone: usize) -> T {
        self.excursions[zone]
    }

    /// Zones whose felts have a set-valued loss.
    pub(crate) fn dry_zones(&self) -> &[usize] {
        &self.dry_felts[..self.dry_count]
    }

    /// x and y of the first moments, in the bodies' frames.
    #[inline(always)]
    pub(crate) fn first_moments(&self) -> [&[T; B]; 2] {
        [&self.moment_x, &self.moment_y]
    }
}
