//! What a mechanism of rigid bodies is: bodies, joints, springs, contacts. Immutable once made.

use core::fmt;

use crate::vector::{Vector, dot};
use crate::{GROUND, Scalar};

/// A rigid body. Its frame has the origin at its centre of mass; without a joint it is planar-free.
#[derive(Debug, Clone, Copy)]
pub struct Body<T> {
    /// Mass, kg.
    pub mass: T,
    /// Moment of inertia about the centre of mass, kg m2.
    pub inertia: T,
}

/// What a joint leaves free.
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
}

/// A joint between two bodies, or of a body with the ground. A tree's joint and the closure of a loop are the same thing.
#[derive(Debug, Clone, Copy)]
pub struct Joint<T> {
    /// Hinge or slide.
    pub kind: JointKind<T>,
    /// The first body, or [`GROUND`].
    pub first: usize,
    /// The point in the first body's frame (the world's for the ground), m.
    pub at_first: Vector<T>,
    /// The second body, or [`GROUND`].
    pub second: usize,
    /// The point in the second body's frame, m.
    pub at_second: Vector<T>,
    /// Dry friction: torque (hinge, N m) or force (slide, N).
    pub dry: T,
    /// Viscous friction, N m s or N s/m.
    pub viscous: T,
    /// A motor: the rate of the coordinate that the joint leaves, at the end of every step, rad/s or m/s. A body on a driven joint is
    /// moving ground. For a rate that varies, make the model anew: it borrows its parts and costs next to nothing.
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

/// The surface that a contact's disc meets, in its carrier's frame.
#[derive(Debug, Clone, Copy)]
pub enum Surface<T> {
    /// The half-plane behind a line.
    Line {
        /// A point of the line, m.
        point: Vector<T>,
        /// Outward unit normal.
        normal: Vector<T>,
    },
    /// A disc.
    Disc {
        /// Centre, m.
        center: Vector<T>,
        /// Radius, m.
        radius: T,
    },
}

/// A rigid unilateral contact: a disc (radius 0: a point) of one body against a surface of another.
#[derive(Debug, Clone, Copy)]
pub struct Contact<T> {
    /// Carrier of the disc, or [`GROUND`].
    pub disc_body: usize,
    /// Disc centre in its carrier's frame, m.
    pub center: Vector<T>,
    /// Disc radius, m.
    pub radius: T,
    /// Carrier of the surface, or [`GROUND`].
    pub surface_body: usize,
    /// The surface.
    pub surface: Surface<T>,
    /// Newton's coefficient of restitution, 0 to 1.
    pub restitution: T,
    /// Coulomb friction coefficient while slipping.
    pub kinetic: T,
    /// Friction coefficient up to which it sticks; at least the kinetic one.
    pub limit: T,
    /// Speed of the surface in its own frame (a belt), m/s, along t = (n_y, -n_x) with n the surface's outward normal.
    pub belt: T,
}

/// A mechanism. It borrows its parts, so that it needs neither heap nor sizes of its own.
#[derive(Debug, Clone, Copy)]
pub struct Model<'m, T> {
    pub(super) bodies: &'m [Body<T>],
    pub(super) joints: &'m [Joint<T>],
    pub(super) springs: &'m [Spring<T>],
    pub(super) contacts: &'m [Contact<T>],
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
    /// A number of this contact is not finite or out of its range.
    BadContact(usize),
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
        contacts: &'m [Contact<T>],
        gravity: Vector<T>,
    ) -> Result<Self, ModelError> {
        let known = |a: usize, b: usize| a != b && [a, b].iter().all(|&i| i == GROUND || i < bodies.len());
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
            if !contact_is_sound(contact) {
                return Err(ModelError::BadContact(i));
            }
        }
        if !finite(&gravity) {
            return Err(ModelError::BadGravity);
        }
        Ok(Model { bodies, joints, springs, contacts, gravity })
    }

    /// The number of laws that a state and a scratch must have room for: three a joint, two a contact.
    pub fn laws(&self) -> usize {
        3 * self.joints.len() + 2 * self.contacts.len()
    }

    /// The law slots of a contact: its normal one, its tangential one.
    pub fn contact_laws(&self, contact: usize) -> [usize; 2] {
        let first = 3 * self.joints.len() + 2 * contact;
        [first, first + 1]
    }
}

fn finite<T: Scalar>(numbers: &[T]) -> bool {
    numbers.iter().all(|x| x.finite())
}

fn unit<T: Scalar>(v: Vector<T>) -> bool {
    finite(&v) && (dot(v, v) - T::ONE).abs() < T::from_f64(UNIT)
}

fn contact_is_sound<T: Scalar>(contact: &Contact<T>) -> bool {
    let surface = match contact.surface {
        Surface::Line { point, normal } => finite(&point) && unit(normal),
        Surface::Disc { center, radius } => finite(&center) && radius.finite() && radius >= T::ZERO,
    };
    let c = contact;
    surface
        && finite(&[c.center[0], c.center[1], c.radius, c.restitution, c.kinetic, c.limit, c.belt])
        && c.radius >= T::ZERO
        && c.restitution >= T::ZERO
        && c.restitution <= T::ONE
        && c.kinetic >= T::ZERO
        && c.limit >= c.kinetic
}
