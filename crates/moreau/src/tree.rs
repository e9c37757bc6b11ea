//! The tree of hinges, and the change between absolute angular velocities v (what a state holds) and relative ones w =
//! v - v_parent (what a joint sees).
//!
//! In relative velocities a pivot's friction acts on one number, and everything hinged on the ground is unchanged.
//!
//! The functions write all entries at once, through masks of a parent's children. An entry that is changed alone and
//! then read together with its neighbour would stall the processor's store buffer, which costs more than the
//! arithmetic.

use crate::description::{Body, GROUND};
use crate::real::{Real, Scalar, join_all};
use crate::vector::Vector;

/// What is hinged on what, and where.
#[derive(Debug, Clone)]
pub(crate) struct Tree<T, const B: usize> {
    /// Parent of each body; [`GROUND`] for a body hinged on the ground.
    pub parent: [usize; B],
    /// The bodies that are hinged on another body, parents first.
    hinged: [usize; B],
    hinged_count: usize,
    /// The bodies that others are hinged on, ascending.
    parents: [Parent<T, B>; B],
    parent_count: usize,
    /// The bodies that are hinged on one that is hinged itself, parents first.
    beyond: [usize; B],
    beyond_count: usize,
    /// The bodies that are hinged on another parent than the first, parents first.
    elsewhere: [usize; B],
    elsewhere_count: usize,
    /// Pivots in the parent's frame, m.
    pub pivot: [Vector<T>; B],
    /// x and y of the pivots on other bodies, in the parent's frame, and of the pivots on the ground; zero for the
    /// others.
    pub link: [[T; B]; 2],
    pub root: [[T; B]; 2],
}

/// A body that others are hinged on: 1 for each of them, and for itself.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Parent<T, const B: usize> {
    pub body: usize,
    pub children: [T; B],
    pub own: [T; B],
}

impl<T: Real, const B: usize> Tree<T, B> {
    /// Of as many trees as there are lanes, which must hang together in the same way.
    pub(crate) fn of_lanes<'a, S: Scalar + 'a>(tree: impl Fn(usize) -> &'a Tree<S, B>) -> Self {
        let first = tree(0);
        Tree {
            parent: first.parent,
            hinged: first.hinged,
            hinged_count: first.hinged_count,
            parents: core::array::from_fn(|i| Parent {
                body: first.parents[i].body,
                children: join_all(|lane| tree(lane).parents[i].children),
                own: join_all(|lane| tree(lane).parents[i].own),
            }),
            parent_count: first.parent_count,
            beyond: first.beyond,
            beyond_count: first.beyond_count,
            elsewhere: first.elsewhere,
            elsewhere_count: first.elsewhere_count,
            pivot: core::array::from_fn(|i| join_all(|lane| tree(lane).pivot[i])),
            link: [join_all(|lane| tree(lane).link[0]), join_all(|lane| tree(lane).link[1])],
            root: [join_all(|lane| tree(lane).root[0]), join_all(|lane| tree(lane).root[1])],
        }
    }

    /// The bodies that are hinged on another body, parents first.
    #[inline(always)]
    pub(crate) fn hinged(&self) -> &[usize] {
        &self.hinged[..self.hinged_count]
    }

    /// The bodies that are hinged on another parent than the first, parents first.
    #[inline(always)]
    pub(crate) fn elsewhere(&self) -> &[usize] {
        &self.elsewhere[..self.elsewhere_count]
    }

    /// Whether a body is hinged on one that is hinged itself.
    #[inline(always)]
    pub(crate) fn is_deep(&self) -> bool {
        self.beyond_count > 0
    }

    /// Calls `pair` with every body, each of its ancestors beyond its parent, and the ancestor's child on the way.
    #[inline(always)]
    pub(crate) fn beyond_parents(&self, mut pair: impl FnMut(usize, usize, usize)) {
        for &i in &self.beyond[..self.beyond_count] {
            let mut branch = self.parent[i];
            while self.parent[branch] < B {
                pair(i, self.parent[branch], branch);
                branch = self.parent[branch];
            }
        }
    }

    /// The bodies that others are hinged on, parents first.
    #[inline(always)]
    pub(crate) fn parents(&self) -> &[Parent<T, B>] {
        &self.parents[..self.parent_count]
    }

    /// Whether a body turns with a joint.
    pub(crate) fn carries(&self, joint: usize, body: usize) -> bool {
        let mut i = body;
        while i < B && i != joint {
            i = self.parent[i];
        }
        i == joint
    }

    /// w from v.
    #[inline(always)]
    pub(crate) fn relative(&self, v: &[T; B]) -> [T; B] {
        let [first, further @ ..] = self.parents() else { return *v };
        let (speed, mut w) = (v[first.body], *v);
        for i in 0..B {
            w[i] = w[i].sub_product(first.children[i], speed);
        }
        if further.is_empty() { w } else { relative_beyond(further, *v, w) }
    }

    /// v from w.
    #[inline(always)]
    pub(crate) fn absolute(&self, w: &[T; B], v: &mut [T; B]) {
        let [first, further @ ..] = self.parents() else {
            *v = *w;
            return;
        };
        // The first of the parents is hinged on the ground.
        let speed = w[first.body];
        for i in 0..B {
            v[i] = w[i].add_product(first.children[i], speed);
        }
        if !further.is_empty() {
            *v = absolute_beyond(further, *v);
        }
    }

    /// Takes generalised forces for absolute velocities to relative ones: a joint carries everything beyond it.
    /// `on_parent` is what acts on each body's parent because of it, besides.
    #[inline(always)]
    pub(crate) fn row_to_joints(&self, row: &mut [T; B], on_parent: &[T; B]) {
        let [first, further @ ..] = self.parents() else { return };
        if !further.is_empty() {
            *row = carried_beyond(further, *row, *on_parent);
        }
        carry(first, row, on_parent);
    }

    /// The inverse of [`Tree::row_to_joints`].
    pub(crate) fn row_to_angles(&self, row: &mut [T; B]) {
        for &i in self.hinged() {
            let t = row[i];
            row[self.parent[i]] -= t;
        }
    }
}

impl<T: Scalar, const B: usize> Tree<T, B> {
    /// Of bodies that have been checked; there are at most B.
    pub(crate) fn of(bodies: &[Body<T>]) -> Self {
        let zero = [T::ZERO; B];
        let mut tree = Tree {
            parent: [GROUND; B],
            hinged: [0; B],
            hinged_count: 0,
            parents: [Parent { body: 0, children: zero, own: zero }; B],
            parent_count: 0,
            beyond: [0; B],
            beyond_count: 0,
            elsewhere: [0; B],
            elsewhere_count: 0,
            pivot: [[T::ZERO; 2]; B],
            link: [zero; 2],
            root: [zero; 2],
        };
        for (i, body) in bodies.iter().enumerate() {
            tree.parent[i] = body.parent;
            tree.pivot[i] = body.pivot;
            let place = if body.parent == GROUND { &mut tree.root } else { &mut tree.link };
            (place[0][i], place[1][i]) = (body.pivot[0], body.pivot[1]);
            if body.parent != GROUND {
                tree.hinged[tree.hinged_count] = i;
                tree.hinged_count += 1;
                if bodies[body.parent].parent != GROUND {
                    tree.beyond[tree.beyond_count] = i;
                    tree.beyond_count += 1;
                }
            }
        }
        for body in 0..bodies.len() {
            let mut parent = Parent { body, children: zero, own: zero };
            parent.own[body] = T::ONE;
            for i in body + 1..B {
                parent.children[i] = if tree.parent[i] == body { T::ONE } else { T::ZERO };
            }
            if parent.children.contains(&T::ONE) {
                tree.parents[tree.parent_count] = parent;
                tree.parent_count += 1;
            }
        }
        for i in 0..tree.hinged_count {
            let body = tree.hinged[i];
            if tree.parent[body] != tree.parents[0].body {
                tree.elsewhere[tree.elsewhere_count] = body;
                tree.elsewhere_count += 1;
            }
        }
        tree
    }
}

/// A parent's share in [`Tree::row_to_joints`].
#[inline(always)]
fn carry<T: Real, const B: usize>(parent: &Parent<T, B>, row: &mut [T; B], on_parent: &[T; B]) {
    let mut sum = T::ZERO;
    for i in 0..B {
        sum = sum.add_product(parent.children[i], row[i] + on_parent[i]);
    }
    for i in 0..B {
        row[i] = row[i].add_product(parent.own[i], sum);
    }
}

// What follows is for mechanisms with more than one parent. Arrays go in and out by value: the compiler keeps in memory
// what a loop changes in place, and would then do so for the usual case, too.

#[inline(always)]
fn relative_beyond<T: Real, const B: usize>(parents: &[Parent<T, B>], v: [T; B], mut w: [T; B]) -> [T; B] {
    for parent in parents {
        for i in 0..B {
            w[i] = w[i].sub_product(parent.children[i], v[parent.body]);
        }
    }
    w
}

#[inline(always)]
fn absolute_beyond<T: Real, const B: usize>(parents: &[Parent<T, B>], mut v: [T; B]) -> [T; B] {
    for parent in parents {
        let speed = v[parent.body];
        for i in 0..B {
            v[i] = v[i].add_product(parent.children[i], speed);
        }
    }
    v
}

#[inline(always)]
fn carried_beyond<T: Real, const B: usize>(parents: &[Parent<T, B>], mut row: [T; B], on_parent: [T; B]) -> [T; B] {
    for parent in parents.iter().rev() {
        carry(parent, &mut row, &on_parent);
    }
    row
}
