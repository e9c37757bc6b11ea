//! Model of a mechanism of rigid bodies: bodies, joints, springs, contacts. Immutable.

use core::fmt;

use super::contact::{Contact, Matter, PolygonContact};
use moreau::vector::{Vector, dot};
use moreau::{GROUND, Scalar};

/// Rigid body. The origin of its frame is its centre of mass; without a joint it moves freely in the plane.
#[derive(Debug, Clone, Copy)]
pub struct Body<T> {
    /// Mass, kg.
    pub mass: T,
    /// Moment of inertia about the centre of mass, kg m2.
    pub inertia: T,
}

/// Kind of a joint.
#[derive(Debug, Clone, Copy)]
pub enum JointKind<T> {
    /// The two points coincide; the bodies rotate freely about them.
    Hinge,
    /// The second body's point slides on a line through the first body's point; the angle between the bodies is
    /// constant.
    Slide {
        /// Unit direction of the line, in the first body's frame.
        axis: Vector<T>,
        /// Angle of the second body minus that of the first, rad.
        angle: T,
    },
    /// A pin in a straight slot: the second body's point stays on a line through the first body's point; both bodies
    /// rotate freely. Friction and motor act on the pin's motion along the slot. To end the slot, add a contact of the
    /// pin with a line on the first body.
    Slot {
        /// Unit direction of the slot, in the first body's frame.
        axis: Vector<T>,
    },
}

/// Joint between two bodies, or between a body and the ground. A joint that closes a loop is defined like any other.
#[derive(Debug, Clone, Copy)]
pub struct Joint<T> {
    /// Kind: hinge, slide or slot.
    pub kind: JointKind<T>,
    /// The first body, or [`GROUND`].
    pub first: usize,
    /// Point in the first body's frame (the world's for the ground), m.
    pub at_first: Vector<T>,
    /// The second body, or [`GROUND`].
    pub second: usize,
    /// Point in the second body's frame (the world's for the ground), m.
    pub at_second: Vector<T>,
    /// Dry friction: torque (hinge, N m) or force (slide and slot, N).
    pub dry: T,
    /// Viscous friction coefficient: N m s (hinge) or N s/m (slide and slot).
    pub viscous: T,
    /// Velocity of a motor: the rate of the joint's free coordinate at the end of every step, rad/s or m/s; `None`
    /// without a motor. A body on a driven joint is moving ground. For a variable rate, build a new model for each
    /// step: it borrows its parts and costs almost nothing.
    pub rate: Option<T>,
}

/// Straight spring between two points, with a damper in parallel. It pulls with the force `stiffness (distance -
/// length)`.
#[derive(Debug, Clone, Copy)]
pub struct Spring<T> {
    /// The first body, or [`GROUND`].
    pub first: usize,
    /// Point in the first body's frame, m.
    pub at_first: Vector<T>,
    /// The second body, or [`GROUND`].
    pub second: usize,
    /// Point in the second body's frame, m.
    pub at_second: Vector<T>,
    /// Stiffness, N/m.
    pub stiffness: T,
    /// Damping, N s/m.
    pub damping: T,
    /// Length without force, m.
    pub length: T,
}

/// Torsion spring with a damper in parallel. The moment on the first body is `stiffness (phi_2 - phi_1 - angle) +
/// damping (rate)`; the opposite moment acts on the second.
#[derive(Debug, Clone, Copy)]
pub struct Torsion<T> {
    /// The first body, or [`GROUND`].
    pub first: usize,
    /// The second body, or [`GROUND`].
    pub second: usize,
    /// Stiffness, N m/rad.
    pub stiffness: T,
    /// Damping, N m s/rad.
    pub damping: T,
    /// Angle of the second body minus that of the first at which the moment is zero, rad.
    pub angle: T,
}

/// Model of a mechanism. It borrows its parts, so that it needs neither heap nor size parameters.
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

/// Error: a model could not be built.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ModelError {
    /// A joint, spring or contact refers to a body that does not exist, or to the same body twice.
    UnknownBody,
    /// A number of this body is not finite, or its mass or inertia is not positive.
    BadBody(usize),
    /// A number of this joint is not finite, its axis is not a unit vector, or its dry or viscous friction is negative.
    BadJoint(usize),
    /// A number of this spring is not finite, or its stiffness, damping or length is negative.
    BadSpring(usize),
    /// A number of this torsion spring is not finite, or its stiffness or damping is negative.
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
    /// Checks the parts of a mechanism and builds a model. `gravity` is the acceleration in the world, m/s2.
    ///
    /// # Errors
    /// Returns the first fault ([`ModelError`]); numbers that are not finite are rejected.
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

    /// Returns this model with other torsion springs.
    ///
    /// # Errors
    /// Returns the first fault ([`ModelError`]).
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

    /// Returns this model with other polygon contacts.
    ///
    /// # Errors
    /// Returns the first fault ([`ModelError`]).
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

    /// Returns the law indices of a contact: the normal law and the tangential law.
    pub fn contact_laws(&self, contact: usize) -> [usize; 2] {
        let first = 3 * self.joints.len() + 2 * contact;
        [first, first + 1]
    }

    /// Returns the law indices of a point, 0 or 1, of a polygon contact: the normal law and the tangential law. The
    /// points are ordered along t = (n_y, -n_x), where n is the outward normal of the second polygon.
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
