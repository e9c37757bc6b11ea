//! Supporting joints: the joints on which a relative motion depends.

use crate::description::Zone;
use crate::linear::Symmetric;
use crate::real::{Real, Scalar, join};
use crate::tree::Tree;
use crate::vector::{Vector, dot, sub};

/// The joints that a zone's compression (or a driven point's velocity) depends on: those that carry one of its two
/// bodies and not the other. Rows are stored for these joints only, in this order: entry k of a row belongs to
/// `joint[k]`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Support<T, const B: usize> {
    count: usize,
    /// Supporting joints, ascending.
    joint: [usize; B],
    /// +1 for joints that carry the curve, -1 for the disc.
    sign: [T; B],
    /// The longest lever that an entry of the row can have in any pose, m.
    lever: [T; B],
}

impl<T: Scalar, const B: usize> Support<T, B> {
    /// The joints between a point of a body and the ground.
    pub(crate) fn of_point(tree: &Tree<T, B>, body: usize, point: Vector<T>) -> Self {
        let mut support = Support::empty();
        for j in 0..B {
            if tree.carries(j, body) {
                support.push(j, T::ONE, extent(tree, body, point, j));
            }
        }
        support
    }

    /// The joints that a zone's compression depends on, and their longest levers about the disc's centre.
    pub(crate) fn of_zone(tree: &Tree<T, B>, zone: &Zone<T>) -> Self {
        let mut support = Support::empty();
        for j in 0..B {
            match (tree.carries(j, zone.curve_body), tree.carries(j, zone.disc_body)) {
                (false, true) => support.push(j, -T::ONE, extent(tree, zone.disc_body, zone.center, j)),
                (true, false) => support.push(j, T::ONE, distance(tree, j, zone)),
                _ => {}
            }
        }
        support
    }

    /// Appends a joint; joints must come in ascending order.
    fn push(&mut self, joint: usize, sign: T, lever: T) {
        (self.joint[self.count], self.sign[self.count], self.lever[self.count]) = (joint, sign, lever);
        self.count += 1;
    }
}

/// The farthest that a point of a body can be from the pivot of a joint that carries it, m: all links stretched.
fn extent<T: Scalar, const B: usize>(tree: &Tree<T, B>, body: usize, point: Vector<T>, joint: usize) -> T {
    let (mut sum, mut i) = (length(point), body);
    while i < B && i != joint {
        sum += length(tree.pivot[i]);
        i = tree.parent[i];
    }
    sum
}

/// The farthest that a zone's disc can be from the pivot of a joint that carries its curve, m.
fn distance<T: Scalar, const B: usize>(tree: &Tree<T, B>, joint: usize, zone: &Zone<T>) -> T {
    // A point in the frame of the ground, and how far what hangs on it reaches.
    let anchor = |body: usize, point: Vector<T>| {
        let (mut at, mut reach, mut i) = (point, T::ZERO, body);
        while i < B {
            reach += length(at);
            at = tree.pivot[i];
            i = tree.parent[i];
        }
        (at, reach)
    };
    let (disc, disc_reach) = anchor(zone.disc_body, zone.center);
    let (pivot, pivot_reach) = anchor(tree.parent[joint], tree.pivot[joint]);
    length(sub(disc, pivot)) + disc_reach + pivot_reach
}

fn length<T: Real>(a: Vector<T>) -> T {
    dot(a, a).sqrt()
}

impl<T: Real, const B: usize> Support<T, B> {
    /// No joint at all.
    pub(crate) fn empty() -> Self {
        Support { count: 0, joint: [0; B], sign: [T::ZERO; B], lever: [T::ZERO; B] }
    }

    /// The same joints with the levers of as many models as there are lanes.
    pub(crate) fn of_lanes<'a, S: Scalar + 'a>(support: impl Fn(usize) -> &'a Support<S, B>) -> Self {
        let first = support(0);
        let mut joined = Support { count: first.count, joint: first.joint, ..Support::empty() };
        for k in 0..first.count {
            joined.sign[k] = join(|lane| support(lane).sign[k]);
            joined.lever[k] = join(|lane| support(lane).lever[k]);
        }
        joined
    }

    /// The joints with their places in a row.
    #[inline(always)]
    pub(crate) fn joints(&self) -> impl DoubleEndedIterator<Item = (usize, usize)> + '_ {
        self.joint[..self.count].iter().copied().enumerate()
    }

    /// Sign of an entry.
    #[inline(always)]
    pub(crate) fn sign(&self, entry: usize) -> T {
        self.sign[entry]
    }

    /// The longest lever of an entry, m.
    #[inline(always)]
    pub(crate) fn lever(&self, entry: usize) -> T {
        self.lever[entry]
    }

    /// The first K entries of a row. Entries beyond the row's own must be zero.
    #[inline(always)]
    pub(crate) fn entries<const K: usize>(&self, row: &[T; B]) -> Row<T, K> {
        Row { joint: core::array::from_fn(|k| self.joint[k]), entry: core::array::from_fn(|k| row[k]) }
    }

    /// Number of entries of a row.
    #[inline(always)]
    pub(crate) fn count(&self) -> usize {
        self.count
    }

    /// row . w.
    #[inline(always)]
    pub(crate) fn product(&self, row: &[T; B], w: &[T; B]) -> T {
        let mut sum = T::ZERO;
        for (k, j) in self.joints() {
            sum = sum.add_product(row[k], w[j]);
        }
        sum
    }

    /// A multiple of the row, with an entry for every joint.
    #[inline(always)]
    pub(crate) fn spread(&self, row: &[T; B], factor: T, dense: &mut [T; B]) {
        *dense = [T::ZERO; B];
        for (k, j) in self.joints() {
            dense[j] = factor * row[k];
        }
    }

    /// [`Row::add_term`] for a row of any length.
    #[inline(always)]
    pub(crate) fn add_term(&self, a: &mut Symmetric<T, B>, b: &mut [T; B], row: &[T; B], tangent: T, p: T, w: &[T; B]) {
        match self.count {
            1 => self.entries::<1>(row).add_term(a, b, tangent, p, w),
            2 => self.entries::<2>(row).add_term(a, b, tangent, p, w),
            3 => self.entries::<3>(row).add_term(a, b, tangent, p, w),
            _ => self.add_long_term(a, b, row, tangent, p, w),
        }
    }

    /// The same for a row that is not written out: as many rounds as it has entries.
    #[inline(always)]
    fn add_long_term(&self, a: &mut Symmetric<T, B>, b: &mut [T; B], row: &[T; B], tangent: T, p: T, w: &[T; B]) {
        let total = p.add_product(tangent, self.product(row, w));
        for (k, i) in self.joints() {
            b[i] = b[i].add_product(row[k], total);
            let t = tangent * row[k];
            a.diagonal[i] = a.diagonal[i].add_product(t, row[k]);
            for (l, j) in self.joints().take(k) {
                a.below[i][j] = a.below[i][j].add_product(t, row[l]);
            }
        }
    }
}

/// A row with K entries. The compiler knows the number, so the row stays in registers.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Row<T, const K: usize> {
    /// The joints, ascending; any one where the entry is zero for good.
    pub joint: [usize; K],
    pub entry: [T; K],
}

impl<T: Real, const K: usize> Row<T, K> {
    /// row . w.
    #[inline(always)]
    pub(crate) fn product<const B: usize>(&self, w: &[T; B]) -> T {
        let mut sum = self.entry[0] * w[self.joint[0]];
        for k in 1..K {
            sum = sum.add_product(self.entry[k], w[self.joint[k]]);
        }
        sum
    }

    /// Adds a force along the row (impulse p, tangent = -dp/d(row . w)) to the linearised step: A += tangent row^T row,
    /// b += row^T (p + tangent row . w).
    #[inline(always)]
    pub(crate) fn add_term<const B: usize>(
        &self,
        a: &mut Symmetric<T, B>,
        b: &mut [T; B],
        tangent: T,
        p: T,
        w: &[T; B],
    ) {
        let total = p.add_product(tangent, self.product(w));
        for k in 0..K {
            let i = self.joint[k];
            b[i] = b[i].add_product(self.entry[k], total);
            let t = tangent * self.entry[k];
            a.diagonal[i] = a.diagonal[i].add_product(t, self.entry[k]);
            for l in 0..k {
                let entry = &mut a.below[i][self.joint[l]];
                *entry = entry.add_product(t, self.entry[l]);
            }
        }
    }
}
