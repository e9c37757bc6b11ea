//! Joints, springs and contacts as rows: the velocity that a law speaks of, linear in the velocities of two bodies. The
//! impulse of the law acts along the same row.

use super::model::{Joint, JointKind, Model};
use super::placement::{Placement, Twist, placed};
use moreau::vector::{Vector, cross, dot, scale, sub};
use moreau::{GROUND, Scalar};

/// u = first . v_first + second . v_second, in (x, y, angle).
#[derive(Debug, Clone, Copy)]
pub(super) struct Row<T> {
    pub bodies: [usize; 2],
    pub parts: [Twist<T>; 2],
}

impl<T: Scalar> Row<T> {
    /// The row of nothing.
    pub(crate) fn none() -> Self {
        Row { bodies: [GROUND; 2], parts: [[T::ZERO; 3]; 2] }
    }

    /// Velocity of `second` minus that of `first`, both at the world's point `at`, along `direction`.
    pub(crate) fn relative(
        places: &[Placement<T>],
        first: usize,
        second: usize,
        at: Vector<T>,
        direction: Vector<T>,
    ) -> Self {
        Self::between(places, [first, second], [at, at], direction)
    }

    /// The same with a point of its own for each body.
    pub(crate) fn between(
        places: &[Placement<T>],
        bodies: [usize; 2],
        at: [Vector<T>; 2],
        direction: Vector<T>,
    ) -> Self {
        let part = |k: usize, d: Vector<T>| [d[0], d[1], cross(sub(at[k], placed(places, bodies[k]).at), d)];
        Row { bodies, parts: [part(0, scale(direction, -T::ONE)), part(1, direction)] }
    }

    /// Angular velocity of `second` minus that of `first`.
    pub(crate) fn turning(first: usize, second: usize) -> Self {
        let z = T::ZERO;
        Row { bodies: [first, second], parts: [[z, z, -T::ONE], [z, z, T::ONE]] }
    }

    /// u of these velocities.
    pub(crate) fn velocity(&self, v: &[Twist<T>]) -> T {
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
    pub(crate) fn push(&self, model: &Model<'_, T>, p: T, v: &mut [Twist<T>]) {
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

    /// Adds row^T p to momenta.
    pub(crate) fn add(&self, p: T, momentum: &mut [Twist<T>]) {
        for (&body, part) in self.bodies.iter().zip(&self.parts) {
            if body != GROUND {
                for (x, y) in momentum[body].iter_mut().zip(part) {
                    *x += *y * p;
                }
            }
        }
    }

    /// row_i M^-1 row_j^T: the Delassus matrix's entry.
    pub(crate) fn coupling(&self, other: &Row<T>, model: &Model<'_, T>) -> T {
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
    /// The two equalities; a slot has one.
    pub closed: [Row<T>; 2],
    /// Violation, m or rad.
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
        JointKind::Slot { axis } => {
            let axis = first.turn(axis);
            let normal = [-axis[1], axis[0]];
            JointRows {
                closed: [Row::relative(places, a, b, at[1], normal), Row::none()],
                open: [dot(normal, apart), T::ZERO],
                free: Row::relative(places, a, b, at[1], axis),
            }
        }
    }
}
