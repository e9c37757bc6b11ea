//! Between absolute angular velocities v (what a state holds) and relative ones w = v - v_parent (what a joint sees).
//!
//! In relative velocities a pivot's friction acts on one number, and everything hinged on the ground is unchanged.

use crate::Real;
use crate::model::Model;

/// w from v.
#[inline(always)]
pub(crate) fn relative<T: Real, const B: usize, const Z: usize>(model: &Model<T, B, Z>, v: &[T; B]) -> [T; B] {
    let mut w = *v;
    for &i in &model.hinged[..model.hinged_count] {
        w[i] -= v[model.parent[i]];
    }
    w
}

/// v from w.
#[inline(always)]
pub(crate) fn absolute<T: Real, const B: usize, const Z: usize>(model: &Model<T, B, Z>, w: &[T; B]) -> [T; B] {
    let mut v = *w;
    for &i in &model.hinged[..model.hinged_count] {
        let t = v[model.parent[i]];
        v[i] += t;
    }
    v
}

/// Generalised forces (or rows) for absolute velocities, taken to relative ones: a joint carries everything beyond it.
#[inline(always)]
pub(crate) fn row_to_joints<T: Real, const B: usize, const Z: usize>(model: &Model<T, B, Z>, row: &mut [T; B]) {
    for &i in model.hinged[..model.hinged_count].iter().rev() {
        let t = row[i];
        row[model.parent[i]] += t;
    }
}

/// The inverse of [`row_to_joints`].
pub(crate) fn row_to_angles<T: Real, const B: usize, const Z: usize>(model: &Model<T, B, Z>, row: &mut [T; B]) {
    for &i in &model.hinged[..model.hinged_count] {
        let t = row[i];
        row[model.parent[i]] -= t;
    }
}
