//! Unchecked description of a mechanism, as the caller writes it. [`Description::compile`] checks it and builds the
//! [`Model`](crate::Model).

use core::fmt;

use crate::fault::Fault;
use crate::felt::Felt;
use crate::real::{Real, Scalar};
use crate::vector::Vector;

/// Body index of the ground.
pub const GROUND: usize = usize::MAX;

/// One hinged rigid body. Its frame has the origin at its pivot.
#[derive(Debug, Clone, Copy)]
pub struct Body<T> {
    /// Parent on which it is hinged: the index of an earlier body, or [`GROUND`].
    pub parent: usize,
    /// The pivot in the parent's frame, m.
    pub pivot: Vector<T>,
    /// Mass, kg.
    pub mass: T,
    /// Moment of inertia about its own pivot, kg m2.
    pub inertia: T,
    /// Centre of mass in its own frame, m.
    pub center_of_mass: Vector<T>,
    /// Dry friction torque c_d of the pivot, N m.
    pub dry: T,
    /// Viscous friction c_v of the pivot, N m s.
    pub viscous: T,
}

impl<T: Real> Body<T> {
    /// Returns a body of unit inertia with no mass and no friction. It fills unused places of a model of fixed size.
    pub fn inert() -> Self {
        let o = [T::ZERO; 2];
        let zero = T::ZERO;
        Body { parent: GROUND, pivot: o, mass: zero, inertia: T::ONE, center_of_mass: o, dry: zero, viscous: zero }
    }
}

/// A torsion spring at a body's pivot. Torque on the body: `torque - stiffness (relative angle - reference)`.
#[derive(Debug, Clone, Copy)]
pub struct Spring<T> {
    /// The hinged body; the opposite torque acts on its parent.
    pub body: usize,
    /// Torque at the reference, N m, counter-clockwise.
    pub torque: T,
    /// Stiffness, N m/rad.
    pub stiffness: T,
    /// Relative angle (body minus parent) at which `torque` holds, rad.
    pub reference: T,
}

/// Surface that a zone's disc presses on, in the frame of the body that carries the curve.
#[derive(Debug, Clone, Copy)]
pub enum ContactCurve<T> {
    /// A straight line through `point` with outward unit `normal`.
    Line {
        /// A point of the line.
        point: Vector<T>,
        /// Outward unit normal.
        normal: Vector<T>,
    },
    /// Rounded segment: all points within `rounding` of a straight core of finite length. A disc can slip off its ends.
    Segment {
        /// Start of the core, m.
        from: Vector<T>,
        /// Unit vector from the start of the core to its end.
        direction: Vector<T>,
        /// Length of the core, m.
        length: T,
        /// Rounding radius, m.
        rounding: T,
    },
    /// A disc.
    Disc {
        /// Centre, m.
        center: Vector<T>,
        /// Radius, m.
        radius: T,
    },
}

/// Contact zone: a disc (radius 0: a point) on one body against a curve on another, with felt between them.
#[derive(Debug, Clone, Copy)]
pub struct Zone<T> {
    /// Carrier of the disc, or [`GROUND`].
    pub disc_body: usize,
    /// Disc centre in its carrier's frame, m.
    pub center: Vector<T>,
    /// Disc radius, m.
    pub radius: T,
    /// Carrier of the curve, or [`GROUND`].
    pub curve_body: usize,
    /// Surface that the disc presses on.
    pub curve: ContactCurve<T>,
    /// Felt: stiffness and energy loss of the contact.
    pub felt: Felt<T>,
    /// Coulomb friction coefficient; `None` without friction.
    pub friction: Option<T>,
}

impl<T: Real> Zone<T> {
    /// Fills the unused places of a model's array; never evaluated.
    pub(crate) fn vacant() -> Self {
        let o = [T::ZERO; 2];
        Zone {
            disc_body: GROUND,
            center: o,
            radius: T::ZERO,
            curve_body: GROUND,
            curve: ContactCurve::Disc { center: o, radius: T::ZERO },
            felt: Felt::none(),
            friction: None,
        }
    }

    /// Number of set-valued laws that it adds to a step.
    fn laws(&self) -> usize {
        usize::from(self.friction.is_some()) + self.felt.laws()
    }
}

/// Point where the mechanism is driven: a point of a body, a world direction, and the spring and damper between driver
/// and body.
#[derive(Debug, Clone, Copy)]
pub struct Site<T> {
    /// Driven body.
    pub body: usize,
    /// Driven point in the body's frame, m.
    pub point: Vector<T>,
    /// Unit direction of a positive push, in the world.
    pub direction: Vector<T>,
    /// Stiffness of the spring between driver and body, N/m.
    pub stiffness: T,
    /// Damping in parallel with the spring, N s/m.
    pub damping: T,
}

/// Ageing of dry friction: the friction of a pivot or a zone grows while it sticks. The coefficient given for the body
/// or zone is the kinetic one. While it sticks, friction grows from this toward `ratio` times it, as 1 -
/// exp(-t/`time`). When it slips, friction falls back to the kinetic value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dwell<T> {
    /// The body whose pivot has dry friction, or the zone with Coulomb friction.
    pub part: DescriptionPart,
    /// Static over kinetic friction, at least 1.
    pub ratio: T,
    /// Time constant tau of the growth, s.
    pub time: T,
}

/// Zone whose curve is the surface of a compliant external subsystem, e.g. a string. Call
/// [`Workspace::set_surface`](crate::Workspace::set_surface) before every step to set the surface's motion; until the
/// first call the surface does not move.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Yields<T> {
    /// Index of the zone. Its felt must not have a set-valued loss.
    pub zone: usize,
    /// Largest displacement of the curve toward the disc from its described place, m. A zone that is open by more than
    /// this is treated as out of contact.
    pub excursion: T,
}

/// Lists of a mechanism's parts, borrowed and not yet checked. [`Description::compile`] builds the model from it.
#[derive(Debug, Clone, Copy)]
pub struct Description<'a, T> {
    /// Bodies. A parent precedes its children.
    pub bodies: &'a [Body<T>],
    /// Torsion springs at pivots.
    pub springs: &'a [Spring<T>],
    /// Contact zones.
    pub zones: &'a [Zone<T>],
    /// Pivots and zones whose dry friction grows while it sticks.
    pub dwells: &'a [Dwell<T>],
    /// Zones whose curves belong to compliant subsystems.
    pub yields: &'a [Yields<T>],
    /// Driven point; `None` if nothing drives the mechanism.
    pub site: Option<Site<T>>,
    /// Gravity, m/s2, pointing toward -y.
    pub gravity: T,
}

/// Empty description without gravity. Fill only some lists with `Description { bodies, ..Description::default() }`.
impl<T: Real> Default for Description<'_, T> {
    fn default() -> Self {
        Description { bodies: &[], springs: &[], zones: &[], dwells: &[], yields: &[], site: None, gravity: T::ZERO }
    }
}

/// Error of a description that cannot be compiled.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum ModelError {
    /// More bodies than the model has room for.
    TooManyBodies {
        /// Bodies in the description.
        found: usize,
        /// Largest number of bodies, B.
        room: usize,
    },
    /// More zones than the model has room for.
    TooManyZones {
        /// Zones in the description.
        found: usize,
        /// Largest number of zones, Z.
        room: usize,
    },
    /// More set-valued laws than the workspace has room for.
    TooManyLaws {
        /// Number of laws that can act in one step: [`Description::laws`].
        found: usize,
        /// Largest number of laws, N.
        room: usize,
    },
    /// A body's parent does not precede it.
    ParentOrder {
        /// Index of the body.
        body: usize,
        /// Index of its parent.
        parent: usize,
    },
    /// A part refers to a body index that does not exist.
    UnknownBody {
        /// Part that contains the index.
        part: DescriptionPart,
        /// The index.
        body: usize,
    },
    /// A number is out of its range.
    BadNumber {
        /// Part that contains the number.
        part: DescriptionPart,
        /// Name, value and expected range.
        fault: Fault,
    },
}

/// A part of a description, by its index in its list.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DescriptionPart {
    /// A body.
    Body(usize),
    /// A spring.
    Spring(usize),
    /// A zone.
    Zone(usize),
    /// The site.
    Site,
    /// The mechanism as a whole.
    Mechanism,
}

impl fmt::Display for DescriptionPart {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            DescriptionPart::Body(i) => write!(f, "body {i}"),
            DescriptionPart::Spring(i) => write!(f, "spring {i}"),
            DescriptionPart::Zone(i) => write!(f, "zone {i}"),
            DescriptionPart::Site => write!(f, "the driven site"),
            DescriptionPart::Mechanism => write!(f, "the mechanism"),
        }
    }
}

impl fmt::Display for ModelError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ModelError::TooManyBodies { found, room } => {
                write!(f, "the mechanism has {found} bodies, this size has room for {room}")
            }
            ModelError::TooManyZones { found, room } => {
                write!(f, "the mechanism has {found} zones, this size has room for {room}")
            }
            ModelError::TooManyLaws { found, room } => {
                write!(f, "the mechanism has {found} set-valued laws, this size has room for {room}")
            }
            ModelError::ParentOrder { body, parent } => {
                write!(f, "body {body} is hinged on body {parent}, which must precede it")
            }
            ModelError::UnknownBody { part, body } => write!(f, "{part} names body {body}, which is not there"),
            ModelError::BadNumber { part, fault } => write!(f, "{part}: {fault}"),
        }
    }
}

impl core::error::Error for ModelError {}

impl<T: Scalar> Description<'_, T> {
    /// Returns the largest number of set-valued laws in one step: one for each pivot with dry friction, one for each
    /// zone with Coulomb friction, one for each felt with a set-valued loss, and one for a prescribed motion if there
    /// is a site.
    pub fn laws(&self) -> usize {
        let pivots = self.bodies.iter().filter(|body| body.dry > T::ZERO).count();
        let zones: usize = self.zones.iter().map(Zone::laws).sum();
        pivots + zones + usize::from(self.site.is_some())
    }

    /// Checks every part of the description, but not whether a model of given size has room for it.
    ///
    /// # Errors
    /// Returns the first fault: the part, the number, and the expected range.
    pub fn check(&self) -> Result<(), ModelError> {
        for (i, body) in self.bodies.iter().enumerate() {
            if body.parent != GROUND && body.parent >= i {
                return Err(ModelError::ParentOrder { body: i, parent: body.parent });
            }
            sound(DescriptionPart::Body(i), body_fault(body))?;
        }
        for (i, spring) in self.springs.iter().enumerate() {
            self.known(DescriptionPart::Spring(i), spring.body)?;
            sound(DescriptionPart::Spring(i), spring_fault(spring))?;
        }
        for (i, zone) in self.zones.iter().enumerate() {
            for body in [zone.disc_body, zone.curve_body] {
                if body != GROUND {
                    self.known(DescriptionPart::Zone(i), body)?;
                }
            }
            sound(DescriptionPart::Zone(i), zone_fault(zone))?;
        }
        for dwell in self.dwells {
            let dry = match dwell.part {
                DescriptionPart::Body(i) => self.bodies.get(i).is_some_and(|body| body.dry > T::ZERO),
                DescriptionPart::Zone(z) => self.zones.get(z).is_some_and(|zone| zone.friction.is_some()),
                _ => false,
            };
            let nothing =
                (!dry).then_some(Fault { field: "dwell", found: 0.0, expected: "dry friction that can grow" });
            let fault = nothing
                .or_else(|| Fault::below_one("static over kinetic friction", dwell.ratio))
                .or_else(|| Fault::not_positive("dwell time", dwell.time));
            sound(dwell.part, fault)?;
        }
        for yields in self.yields {
            let of = |field, found, expected| Some(Fault { field, found, expected });
            let fault = match self.zones.get(yields.zone) {
                None => of("the zone that yields", yields.zone as f64, "the index of a zone"),
                Some(zone) => zone.felt.dry().and_then(|eta| {
                    of("the eta of a zone that yields", eta.to_f64(), "a felt without a set-valued loss")
                }),
            };
            sound(
                DescriptionPart::Zone(yields.zone),
                fault.or_else(|| Fault::negative("excursion", yields.excursion)),
            )?;
        }
        if let Some(site) = &self.site {
            self.known(DescriptionPart::Site, site.body)?;
            sound(DescriptionPart::Site, site_fault(site))?;
        }
        sound(DescriptionPart::Mechanism, Fault::not_finite("gravity", self.gravity))
    }

    fn known(&self, part: DescriptionPart, body: usize) -> Result<(), ModelError> {
        if body < self.bodies.len() { Ok(()) } else { Err(ModelError::UnknownBody { part, body }) }
    }
}

fn sound(part: DescriptionPart, fault: Option<Fault>) -> Result<(), ModelError> {
    fault.map_or(Ok(()), |fault| Err(ModelError::BadNumber { part, fault }))
}

fn body_fault<T: Scalar>(body: &Body<T>) -> Option<Fault> {
    Fault::vector("pivot", body.pivot)
        .or_else(|| Fault::negative("mass", body.mass))
        .or_else(|| Fault::not_positive("inertia", body.inertia))
        .or_else(|| Fault::vector("center_of_mass", body.center_of_mass))
        .or_else(|| Fault::negative("dry", body.dry))
        .or_else(|| Fault::negative("viscous", body.viscous))
}

fn spring_fault<T: Scalar>(spring: &Spring<T>) -> Option<Fault> {
    Fault::not_finite("torque", spring.torque)
        .or_else(|| Fault::not_finite("stiffness", spring.stiffness))
        .or_else(|| Fault::not_finite("reference", spring.reference))
}

fn zone_fault<T: Scalar>(zone: &Zone<T>) -> Option<Fault> {
    let curve = match zone.curve {
        ContactCurve::Line { point, normal } => {
            Fault::vector("point", point).or_else(|| Fault::not_unit("normal", normal))
        }
        ContactCurve::Segment { from, direction, length, rounding } => Fault::vector("from", from)
            .or_else(|| Fault::not_unit("direction", direction))
            .or_else(|| Fault::negative("length", length))
            .or_else(|| Fault::negative("rounding", rounding)),
        ContactCurve::Disc { center, radius } => {
            Fault::vector("the curve's center", center).or_else(|| Fault::negative("the curve's radius", radius))
        }
    };
    Fault::vector("center", zone.center)
        .or_else(|| Fault::negative("radius", zone.radius))
        .or(curve)
        .or_else(|| zone.felt.fault())
        .or_else(|| zone.friction.and_then(|mu| Fault::negative("friction", mu)))
}

fn site_fault<T: Scalar>(site: &Site<T>) -> Option<Fault> {
    Fault::vector("point", site.point)
        .or_else(|| Fault::not_unit("direction", site.direction))
        .or_else(|| Fault::not_finite("stiffness", site.stiffness))
        .or_else(|| Fault::not_finite("damping", site.damping))
}
