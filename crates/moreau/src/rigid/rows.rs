//! Joints and contacts as rows: the velocity that a law speaks of, linear in the velocities of two bodies. The impulse of the
//! law acts along the same row.

use super::model::{Contact, Joint, JointKind, Model, Surface};
use super::state::{Placement, Twist, placed};
use crate::vector::{Vector, add, cross, dot, scale, sub};
use crate::{GROUND, Scalar};

/// u = first . v_first + second . v_second, in (x, y, angle).
#[derive(Debug, Clone, Copy)]
pub(super) struct Row<T> {
    bodies: [usize; 2],
    parts: [Twist<T>; 2],
}

impl<T: Scalar> Row<T> {
    /// The row of nothing.
    pub fn none() -> Self {
        Row { bodies: [GROUND; 2], parts: [[T::ZERO; 3]; 2] }
    }

    /// Velocity of `second` minus that of `first`, both at the world's point `at`, along `direction`.
    fn relative(places: &[Placement<T>], first: usize, second: usize, at: Vector<T>, direction: Vector<T>) -> Self {
        Self::between(places, [first, second], [at, at], direction)
    }

    /// The same with a point of its own for each body.
    fn between(places: &[Placement<T>], bodies: [usize; 2], at: [Vector<T>; 2], direction: Vector<T>) -> Self {
        let part = |k: usize, d: Vector<T>| [d[0], d[1], cross(sub(at[k], placed(places, bodies[k]).at), d)];
        Row { bodies, parts: [part(0, scale(direction, -T::ONE)), part(1, direction)] }
    }

    /// Angular velocity of `second` minus that of `first`.
    fn turning(first: usize, second: usize) -> Self {
        let z = T::ZERO;
        Row { bodies: [first, second], parts: [[z, z, -T::ONE], [z, z, T::ONE]] }
    }

    /// u of these velocities.
    pub fn velocity(&self, v: &[Twist<T>]) -> T {
        let mut u = T::ZERO;
        for (&body, part) in self.bodies.iter().zip(&self.parts) {
            if body != GROUND {
                for (x, y) in part.iter().zip(&v[body]) {
                    u += *x * *y;
                }
            }
        }
        u
    }

    /// Adds M^-1 row^T p to a velocity (or, with p a length, to a displacement).
    pub fn push(&self, model: &Model<'_, T>, p: T, v: &mut [Twist<T>]) {
        for (&body, part) in self.bodies.iter().zip(&self.parts) {
            if body != GROUND {
                let b = &model.bodies[body];
                let mass = [b.mass, b.mass, b.inertia];
                for ((x, y), m) in v[body].iter_mut().zip(part).zip(mass) {
                    *x += *y * p / m;
                }
            }
        }
    }

    /// row_i M^-1 row_j^T: the Delassus matrix's entry.
    pub fn coupling(&self, other: &Row<T>, model: &Model<'_, T>) -> T {
        let mut sum = T::ZERO;
        for (&a, x) in self.bodies.iter().zip(&self.parts) {
            for (&b, y) in other.bodies.iter().zip(&other.parts) {
                if a == b && a != GROUND {
                    let body = &model.bodies[a];
                    sum += (x[0] * y[0] + x[1] * y[1]) / body.mass + x[2] * y[2] / body.inertia;
                }
            }
        }
        sum
    }
}

/// The rows of a joint, what it is open, and its free coordinate's row.
pub(super) struct JointRows<T> {
    /// The two equalities.
    pub closed: [Row<T>; 2],
    /// What they are violated by, m or rad.
    pub open: [T; 2],
    /// The coordinate that friction acts on.
    pub free: Row<T>,
}

/// A joint at these placements.
pub(super) fn joint_rows<T: Scalar>(joint: &Joint<T>, places: &[Placement<T>]) -> JointRows<T> {
    let (a, b) = (joint.first, joint.second);
    let (first, second) = (placed(places, a), placed(places, b));
    let at = [first.point(joint.at_first), second.point(joint.at_second)];
    let apart = sub(at[1], at[0]);
    match joint.kind {
        JointKind::Hinge => {
            let along = |d: Vector<T>| Row::between(places, [a, b], at, d);
            JointRows {
                closed: [along([T::ONE, T::ZERO]), along([T::ZERO, T::ONE])],
                open: apart,
                free: Row::turning(a, b),
            }
        }
        JointKind::Slide { axis, angle } => {
            let axis = first.turn(axis);
            let normal = [-axis[1], axis[0]];
            // Axis and normal turn with the first body, so that its velocity counts where the second one's point is.
            JointRows {
                closed: [Row::relative(places, a, b, at[1], normal), Row::turning(a, b)],
                open: [dot(normal, apart), second.angle - first.angle - angle],
                free: Row::relative(places, a, b, at[1], axis),
            }
        }
    }
}

/// A contact at these placements.
pub(super) struct ContactRows<T> {
    /// Distance, m, positive apart.
    pub distance: T,
    /// Its rate.
    pub normal: Row<T>,
    /// Velocity of the disc's material along t = (n_y, -n_x), against the surface's carrier.
    pub tangential: Row<T>,
}

/// A contact at these placements.
pub(super) fn contact_rows<T: Scalar>(contact: &Contact<T>, places: &[Placement<T>]) -> ContactRows<T> {
    let carrier = placed(places, contact.surface_body);
    let center = placed(places, contact.disc_body).point(contact.center);
    let (normal, distance) = match contact.surface {
        Surface::Line { point, normal } => {
            let n = carrier.turn(normal);
            (n, dot(n, sub(center, carrier.point(point))) - contact.radius)
        }
        Surface::Disc { center: other, radius } => {
            let line = sub(center, carrier.point(other));
            let length = dot(line, line).sqrt();
            // Two discs on one centre have no direction; any will do.
            let n = if T::ZERO < length { scale(line, T::ONE / length) } else { [T::ZERO, T::ONE] };
            (n, length - radius - contact.radius)
        }
    };
    let at = add(center, scale(normal, -contact.radius));
    let row = |d: Vector<T>| Row::relative(places, contact.surface_body, contact.disc_body, at, d);
    ContactRows { distance, normal: row(normal), tangential: row([normal[1], -normal[0]]) }
}
