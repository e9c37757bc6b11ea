//! Pose of all bodies: the kinematic tree, evaluated once per Newton iteration.

use crate::real::{Real, sin_cos};
use crate::support::Support;
use crate::tree::Tree;
use crate::vector::{Vector, add, cross, sub};

/// Rotations and pivots of all bodies at one configuration.
#[derive(Debug, Clone)]
pub struct Pose<T, const B: usize> {
    pub(crate) cos: [T; B],
    pub(crate) sin: [T; B],
    /// Pivots in the world.
    pub(crate) pivot_x: [T; B],
    pub(crate) pivot_y: [T; B],
    /// From the parent's pivot to this one's, in the world; zero for a body hinged on the ground.
    pub(crate) arm_x: [T; B],
    pub(crate) arm_y: [T; B],
    /// First moments about the pivots, in the world (README, "Inertia").
    pub(crate) moment_x: [T; B],
    pub(crate) moment_y: [T; B],
}

impl<T: Real, const B: usize> Pose<T, B> {
    pub(crate) fn new() -> Self {
        let zero = [T::ZERO; B];
        Pose {
            cos: [T::ONE; B],
            sin: zero,
            pivot_x: zero,
            pivot_y: zero,
            arm_x: zero,
            arm_y: zero,
            moment_x: zero,
            moment_y: zero,
        }
    }

    /// Places every body for the given absolute angles, parents first. `moment`: x and y of the first moments in the
    /// bodies' frames.
    #[inline(always)]
    pub(crate) fn place(&mut self, tree: &Tree<T, B>, moment: [&[T; B]; 2], angle: &[T; B]) {
        sin_cos(angle, &mut self.sin, &mut self.cos);
        let [moment_x, moment_y] = moment;
        for i in 0..B {
            let (c, s) = (self.cos[i], self.sin[i]);
            self.moment_x[i] = (c * moment_x[i]).sub_product(s, moment_y[i]);
            self.moment_y[i] = (s * moment_x[i]).add_product(c, moment_y[i]);
        }
        let ([link_x, link_y], [root_x, root_y]) = (&tree.link, &tree.root);
        let [first, ..] = tree.parents() else {
            (self.pivot_x, self.pivot_y) = (*root_x, *root_y);
            (self.arm_x, self.arm_y) = ([T::ZERO; B], [T::ZERO; B]);
            return;
        };
        // The first of the parents is hinged on the ground.
        let (c, s) = (self.cos[first.body], self.sin[first.body]);
        let (x, y) = (root_x[first.body], root_y[first.body]);
        for i in 0..B {
            self.arm_x[i] = first.children[i] * (c * link_x[i]).sub_product(s, link_y[i]);
            self.arm_y[i] = first.children[i] * (s * link_x[i]).add_product(c, link_y[i]);
            self.pivot_x[i] = (root_x[i] + self.arm_x[i]).add_product(first.children[i], x);
            self.pivot_y[i] = (root_y[i] + self.arm_y[i]).add_product(first.children[i], y);
        }
        // A pivot is carried along by its parent's. Body by body: nothing reads these entries together before the zones
        // have been looked at.
        for &i in tree.elsewhere() {
            let [link_x, link_y] = &tree.link;
            let parent = tree.parent[i];
            let (c, s) = (self.cos[parent], self.sin[parent]);
            let (x, y) = (self.pivot_x[parent], self.pivot_y[parent]);
            let arm_x = (c * link_x[i]).sub_product(s, link_y[i]);
            let arm_y = (s * link_x[i]).add_product(c, link_y[i]);
            (self.arm_x[i], self.arm_y[i]) = (arm_x, arm_y);
            (self.pivot_x[i], self.pivot_y[i]) = (arm_x + x, arm_y + y);
        }
    }

    /// From the parent's pivot to a body's, in the world.
    #[inline(always)]
    pub(crate) fn arm(&self, body: usize) -> Vector<T> {
        [self.arm_x[body], self.arm_y[body]]
    }

    /// A direction of a body's frame, in the world.
    #[inline(always)]
    pub(crate) fn rotate(&self, body: usize, a: Vector<T>) -> Vector<T> {
        if body < B {
            let (c, s) = (self.cos[body], self.sin[body]);
            [(c * a[0]).sub_product(s, a[1]), (s * a[0]).add_product(c, a[1])]
        } else {
            a
        }
    }

    /// Returns a point of a body's frame (or of the ground) in the world, m.
    #[inline(always)]
    pub fn point(&self, body: usize, a: Vector<T>) -> Vector<T> {
        if body < B { add(self.pivot(body), self.rotate(body, a)) } else { a }
    }

    /// Pivot of a body in the world, m.
    #[inline(always)]
    pub(crate) fn pivot(&self, body: usize) -> Vector<T> {
        [self.pivot_x[body], self.pivot_y[body]]
    }

    /// The row that maps relative velocities to `n . velocity(x)`, for the supporting joints: each turns x about its
    /// pivot.
    #[inline(always)]
    pub(crate) fn turning_row(&self, support: &Support<T, B>, x: Vector<T>, n: Vector<T>, row: &mut [T; B]) {
        for (k, j) in support.joints() {
            row[k] = support.sign(k) * self.turning(j, x, n);
        }
    }

    /// `n . velocity(x)` of what turns about a joint with 1 rad/s.
    #[inline(always)]
    pub(crate) fn turning(&self, joint: usize, x: Vector<T>, n: Vector<T>) -> T {
        cross(sub(x, self.pivot(joint)), n)
    }
}
