//! The model of a mechanism of rigid bodies: bodies, joints, springs, contacts. Immutable once made.

use core::fmt;

use super::contact::{Contact, Matter, PolygonContact};
use moreau::vector::{Vector, dot};
use moreau::{GROUND, Scalar};

/// A rigid body. Its frame has the origin at its centre of mass; without a joint it is planar-free.
#[derive(Debug, Clone, Copy)]
pub struct Body<T> {
    /// Mass, kg.
    pub mass: T,
    /// Moment of inertia about the centre of mass, kg m2.
    pub inertia: T,
}

/// Freedom of a joint.
#[derive(Debug, Clone, Copy)]
pub enum JointKind<T> {
    /// The two points coincide; the second body turns about them.
    Hinge,
    /// The second body's point slides on the line through the first body's point; neither turns against the other.
    Slide {
        /// Unit direction of the line, in the first body's frame.
        axis: Vector<T>,
        /// Angle of the second body minus that of the first, rad.
        angle: T,
    },
    /// A pin in a straight slot: the second body's point stays on the line through the first body's point; both turn
    /// freely. Friction and motor act on the pin's way along the slot. Where the slot ends, a contact of the pin with a
    /// line on the first body is the stop.
    Slot {
        /// Unit direction of the slot, in the first body's frame.
        axis: Vector<T>,
    },
}

/// A joint between two bodies, or of a body with the ground. A tree's joint and the closure of a loop are the same
/// thing.
#[derive(Debug, Clone, Copy)]
pub struct Joint<T> {
    /// Hinge, slide or slot.
    pub kind: JointKind<T>,
    /// The first body, or [`GROUND`].
    pub first: usize,
    /// The point in the first body's frame (the world's for the ground), m.
    pub at_first: Vector<T>,
    /// The second body, or [`GROUND`].
    pub second: usize,
    /// The point in the second body's frame, m.
    pub at_second: Vector<T>,
    /// Dry friction: torque (hinge, N m) or force (slide and slot, N).
    pub dry: T,
    /// Viscous friction, N m s or N s/m.
    pub viscous: T,
    /// A motor: the rate of the coordinate that the joint leaves, at the end of every step, rad/s or m/s. A body on a
    /// driven joint is moving ground. For a rate that varies, make the model anew: it borrows its parts and costs next
    /// to nothing.
    pub rate: Option<T>,
}

/// A straight spring between two points, with a damper in parallel: it pulls with `stiffness (distance - length)`.
#[derive(Debug, Clone, Copy)]
pub struct Spring<T> {
    /// The first body, or [`GROUND`].
    pub first: usize,
    /// Its point, m.
    pub at_first: Vector<T>,
    /// The second body, or [`GROUND`].
    pub second: usize,
    /// Its point, m.
    pub at_second: Vector<T>,
    /// N/m.
    pub stiffness: T,
    /// N s/m.
    pub damping: T,
    /// Distance without force, m.
    pub length: T,
}

/// A spring that resists turning, with a damper in parallel: the moment `stiffness (phi_2 - phi_1 - angle) + damping
/// (rate)` on the first body, its opposite on the second.
#[derive(Debug, Clone, Copy)]
pub struct Torsion<T> {
    /// The first body, or [`GROUND`].
    pub first: usize,
    /// The second body, or [`GROUND`].
    pub second: usize,
    /// N m/rad.
    pub stiffness: T,
    /// N m s/rad.
    pub damping: T,
    /// Angle of the second body minus that of the first without moment, rad.
    pub angle: T,
}

/// A mechanism. It borrows its parts, so that it needs neither heap nor sizes of its own.
#[derive(Debug, Clone, Copy)]
pub struct Model<'m, T> {
    pub(super) bodies: &'m [Body<T>],
    pub(super) joints: &'m [Joint<T>],
    pub(super) springs: &'m [Spring<T>],
    pub(super) torsions: &'m [Torsion<T>],
    pub(super) contacts: &'m [Contact<'m, T>],
    pub(super) polygons: &'m [PolygonContact<'m, T>],
    pub(super) gravity: Vector<T>,
}

/// Why a model could not be made.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ModelError {
    /// A joint, spring or contact names a body that is not there, or one body twice.
    UnknownBody,
    /// A number of this body is not finite, or its mass or inertia is not positive.
    BadBody(usize),
    /// A number of this joint is not finite, its axis is not a unit vector, or its friction is negative.
    BadJoint(usize),
    /// A number of this spring is not finite.
    BadSpring(usize),
    /// A number of this torsion spring is not finite or negative.
    BadTorsion(usize),
    /// A number of this contact is not finite or out of its range.
    BadContact(usize),
    /// A number of this contact of polygons is not finite or out of its range, or a polygon is not convex or not
    /// counter-clockwise.
    BadPolygonContact(usize),
    /// Gravity is not finite.
    BadGravity,
}

impl fmt::Display for ModelError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ModelError::UnknownBody => {
                write!(f, "a joint, spring or contact names a body that is not there, or one twice")
            }
            ModelError::BadBody(i) => write!(f, "body {i}: mass and inertia must be positive and finite"),
            ModelError::BadJoint(i) => write!(f, "joint {i}: a number is not finite or out of range"),
            ModelError::BadSpring(i) => write!(f, "spring {i}: a number is not finite or out of range"),
            ModelError::BadTorsion(i) => write!(f, "torsion spring {i}: a number is not finite or out of range"),
            ModelError::BadPolygonContact(i) => {
                write!(
                    f,
                    "polygon contact {i}: a number is out of range or a polygon is not convex and counter-clockwise"
                )
            }
            ModelError::BadContact(i) => write!(f, "contact {i}: a number is not finite or out of range"),
            ModelError::BadGravity => write!(f, "gravity is not finite"),
        }
    }
}

impl core::error::Error for ModelError {}

/// How far a direction's length may be from one.
const UNIT: f64 = 1e-6;

impl<'m, T: Scalar> Model<'m, T> {
    /// Checks the parts of a mechanism. `gravity` is the acceleration, m/s2, in the world.
    ///
    /// # Errors
    /// See [`ModelError`]; nothing that is not finite enters a model.
    pub fn new(
        bodies: &'m [Body<T>],
        joints: &'m [Joint<T>],
        springs: &'m [Spring<T>],
        contacts: &'m [Contact<'m, T>],
        gravity: Vector<T>,
    ) -> Result<Self, ModelError> {
        let known = |a, b| known(bodies.len(), a, b);
        for (i, body) in bodies.iter().enumerate() {
            if !(finite(&[body.mass, body.inertia]) && body.mass > T::ZERO && body.inertia > T::ZERO) {
                return Err(ModelError::BadBody(i));
            }
        }
        for (i, joint) in joints.iter().enumerate() {
            if !known(joint.first, joint.second) {
                return Err(ModelError::UnknownBody);
            }
            let sound = match joint.kind {
                JointKind::Hinge => true,
                JointKind::Slide { axis, angle } => angle.finite() && unit(axis),
                JointKind::Slot { axis } => unit(axis),
            };
            let numbers = [joint.at_first, joint.at_second, [joint.dry, joint.viscous]];
            let finite = numbers.iter().all(|pair| finite(pair));
            let driven = joint.rate.is_none_or(|rate| rate.finite());
            if !(sound && finite && driven && joint.dry >= T::ZERO && joint.viscous >= T::ZERO) {
                return Err(ModelError::BadJoint(i));
            }
        }
        for (i, spring) in springs.iter().enumerate() {
            if !known(spring.first, spring.second) {
                return Err(ModelError::UnknownBody);
            }
            let ends = finite(&spring.at_first) && finite(&spring.at_second);
            let law = [spring.stiffness, spring.damping, spring.length];
            if !(ends && finite(&law) && law.iter().all(|x| *x >= T::ZERO)) {
                return Err(ModelError::BadSpring(i));
            }
        }
        for (i, contact) in contacts.iter().enumerate() {
            if !known(contact.disc_body, contact.surface_body) {
                return Err(ModelError::UnknownBody);
            }
            if !contact.is_sound() {
                return Err(ModelError::BadContact(i));
            }
        }
        if !finite(&gravity) {
            return Err(ModelError::BadGravity);
        }
        Ok(Model { bodies, joints, springs, torsions: &[], contacts, polygons: &[], gravity })
    }

    /// This model with other torsion springs.
    ///
    /// # Errors
    /// See [`ModelError`].
    pub fn with_torsions(self, torsions: &'m [Torsion<T>]) -> Result<Self, ModelError> {
        for (i, torsion) in torsions.iter().enumerate() {
            if !known(self.bodies.len(), torsion.first, torsion.second) {
                return Err(ModelError::UnknownBody);
            }
            let law = [torsion.stiffness, torsion.damping];
            if !(finite(&law) && torsion.angle.finite() && law.iter().all(|x| *x >= T::ZERO)) {
                return Err(ModelError::BadTorsion(i));
            }
        }
        Ok(Model { torsions, ..self })
    }

    /// This model with other polygon contacts.
    ///
    /// # Errors
    /// See [`ModelError`].
    pub fn with_polygons(self, polygons: &'m [PolygonContact<'m, T>]) -> Result<Self, ModelError> {
        for (i, pair) in polygons.iter().enumerate() {
            if !known(self.bodies.len(), pair.first, pair.second) {
                return Err(ModelError::UnknownBody);
            }
            if !pair.is_sound() {
                return Err(ModelError::BadPolygonContact(i));
            }
        }
        Ok(Model { polygons, ..self })
    }

    /// The number of laws that a state and a workspace must have room for: three a joint, two a contact, four a contact
    /// of polygons.
    pub(crate) fn laws(&self) -> usize {
        3 * self.joints.len() + 2 * self.points()
    }

    /// Points at which the mechanism can touch: one a contact, two a contact of polygons.
    pub(super) fn points(&self) -> usize {
        self.contacts.len() + 2 * self.polygons.len()
    }

    /// What a point's laws are made of.
    pub(super) fn matter(&self, point: usize) -> Matter<T> {
        match self.contacts.get(point) {
            Some(contact) => contact.matter(),
            None => self.polygons[(point - self.contacts.len()) / 2].matter(),
        }
    }

    /// The law slots of a contact: its normal one, its tangential one.
    pub fn contact_laws(&self, contact: usize) -> [usize; 2] {
        let first = 3 * self.joints.len() + 2 * contact;
        [first, first + 1]
    }

    /// The law slots of a point, 0 or 1, of a contact of polygons: its normal one, its tangential one. The points are
    /// in the order in which they lie along t = (n_y, -n_x), n the outward normal of the second polygon.
    pub fn polygon_laws(&self, contact: usize, point: usize) -> [usize; 2] {
        self.contact_laws(self.contacts.len() + 2 * contact + point)
    }
}

/// Whether a and b are two of `bodies` bodies or the ground.
fn known(bodies: usize, a: usize, b: usize) -> bool {
    a != b && [a, b].iter().all(|&i| i == GROUND || i < bodies)
}

pub(super) fn finite<T: Scalar>(numbers: &[T]) -> bool {
    numbers.iter().all(|x| x.finite())
}

pub(super) fn unit<T: Scalar>(v: Vector<T>) -> bool {
    finite(&v) && (dot(v, v) - T::ONE).abs() < T::from_f64(UNIT)
}
