//! Between absolute angular velocities v (what a state holds) and relative ones w = v - v_parent (what a joint sees).
//!
//! In relative velocities a pivot's friction acts on one number, and everything hinged on the ground is unchanged.
//!
//! All entries are written at once, through masks of a parent's children: an entry changed alone and read again together with
//! its neighbour would stall the processor's store buffer, which costs more than the arithmetic.

use crate::Real;
use crate::model::Model;

/// A body that others are hinged on: 1 for each of them, and for itself.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Parent<T, const B: usize> {
    pub body: usize,
    pub children: [T; B],
    pub own: [T; B],
}

/// w from v.
#[inline(always)]
pub(crate) fn relative<T: Real, const B: usize, const Z: usize>(model: &Model<T, B, Z>, v: &[T; B]) -> [T; B] {
    let [first, further @ ..] = model.parents() else { return *v };
    let (speed, mut w) = (v[first.body], *v);
    for i in 0..B {
        w[i] = w[i].sub_product(first.children[i], speed);
    }
    if further.is_empty() { w } else { relative_beyond(further, *v, w) }
}

/// v from w.
#[inline(always)]
pub(crate) fn absolute<T: Real, const B: usize, const Z: usize>(model: &Model<T, B, Z>, w: &[T; B], v: &mut [T; B]) {
    let [first, further @ ..] = model.parents() else {
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

/// Generalised forces for absolute velocities, taken to relative ones: a joint carries everything beyond it. `on_parent`: what acts
/// on each body's parent because of it, besides.
#[inline(always)]
pub(crate) fn row_to_joints<T: Real, const B: usize, const Z: usize>(
    model: &Model<T, B, Z>,
    row: &mut [T; B],
    on_parent: &[T; B],
) {
    let [first, further @ ..] = model.parents() else { return };
    if !further.is_empty() {
        *row = carried_beyond(further, *row, *on_parent);
    }
    carry(first, row, on_parent);
}

/// A parent's share in [`row_to_joints`].
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

// What follows is for mechanisms with more than one parent. Arrays go in and out by value: what a loop changes in place, the compiler keeps
// in memory for the usual case, too.

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

/// The inverse of [`row_to_joints`].
pub(crate) fn row_to_angles<T: Real, const B: usize, const Z: usize>(model: &Model<T, B, Z>, row: &mut [T; B]) {
    for &i in &model.hinged[..model.hinged_count] {
        let t = row[i];
        row[model.parent[i]] -= t;
    }
}
