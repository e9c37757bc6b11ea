//! Springs and dampers at the step's end: Newton's method on the regular forces, A = M + sum of gamma r^T r.

use super::forces::{along_spring, spring_ends};
use super::model::Model;
use super::placement::{Placement, Twist};
use super::rows::{Row, joint_rows};
use moreau::vector::dot;
use moreau::{GROUND, Scalar};

/// A = M - h dQ/dv1 without what would make it indefinite, factored as L D L^T (L's diagonal is one, in the lower half;
/// D on the diagonal).
#[derive(Debug, Clone)]
pub(super) struct Implicit<T, const B: usize> {
    a: [[[[T; 3]; 3]; B]; B],
    /// Whether there is anything but M.
    pub present: bool,
}

impl<T: Scalar, const B: usize> Implicit<T, B> {
    pub(crate) fn new() -> Self {
        Implicit { a: [[[[T::ZERO; 3]; 3]; B]; B], present: false }
    }

    /// Linearises at these placements and velocities of the theta point, theta h^2 theta of displacement and theta h of
    /// velocity per velocity at the step's end.
    pub(crate) fn renew(&mut self, model: &Model<'_, T>, h: T, theta: T, q: &[Placement<T>; B], v: &[Twist<T>; B]) {
        let dampers = model.joints.iter().any(|joint| T::ZERO < joint.viscous);
        self.present = dampers || !model.springs.is_empty() || !model.torsions.is_empty();
        if !self.present {
            return;
        }
        self.a = [[[[T::ZERO; 3]; 3]; B]; B];
        for (i, body) in model.bodies.iter().enumerate() {
            for (k, m) in [body.mass, body.mass, body.inertia].into_iter().enumerate() {
                self.a[i][i][k][k] = m;
            }
        }
        let (place, speed) = (theta * theta * h * h, theta * h);
        for spring in model.springs {
            let ends = spring_ends(spring, q);
            self.add(&along_spring(spring, q, ends.direction), place * spring.stiffness + speed * spring.damping);
            // The force's direction turns with the ends, its levers turn with the bodies. Only what draws back is taken
            // in.
            let force = spring.stiffness * (ends.length - spring.length)
                + spring.damping * along_spring(spring, q, ends.direction).velocity(v);
            if T::ZERO < ends.length {
                let across = [-ends.direction[1], ends.direction[0]];
                let turning = (place * force / ends.length).max(T::ZERO);
                self.add(&along_spring(spring, q, across), turning);
            } else {
                // Ends on one place: a spring without length of its own draws back whichever way they part.
                let alike = if spring.length == T::ZERO { place * spring.stiffness } else { T::ZERO };
                for direction in [[T::ONE, T::ZERO], [T::ZERO, T::ONE]] {
                    self.add(&along_spring(spring, q, direction), alike);
                }
            }
            for (k, body, sign) in [(0, spring.first, T::ONE), (1, spring.second, -T::ONE)] {
                if body != GROUND {
                    let lever = sign * force * dot(ends.arms[k], ends.direction);
                    self.a[body][body][2][2] += (place * lever).max(T::ZERO);
                }
            }
        }
        for torsion in model.torsions {
            let row = Row::turning(torsion.first, torsion.second);
            self.add(&row, place * torsion.stiffness + speed * torsion.damping);
        }
        for joint in model.joints {
            if T::ZERO < joint.viscous {
                self.add(&joint_rows(joint, q).free, speed * joint.viscous);
            }
        }
        self.factor(model.bodies.len());
    }

    /// A += gamma row^T row.
    fn add(&mut self, row: &Row<T>, gamma: T) {
        for (&a, x) in row.bodies.iter().zip(&row.parts) {
            for (&b, y) in row.bodies.iter().zip(&row.parts) {
                if a != GROUND && b != GROUND {
                    for i in 0..3 {
                        for j in 0..3 {
                            self.a[a][b][i][j] += gamma * x[i] * y[j];
                        }
                    }
                }
            }
        }
    }

    fn at(&self, i: usize, j: usize) -> T {
        self.a[i / 3][j / 3][i % 3][j % 3]
    }

    fn factor(&mut self, bodies: usize) {
        let n = 3 * bodies;
        for j in 0..n {
            let pivot = self.at(j, j);
            for i in j + 1..n {
                let below = self.at(i, j);
                if below == T::ZERO {
                    continue;
                }
                let l = below / pivot;
                for k in j + 1..=i {
                    // The upper half holds the rows as they were: A_jk before division.
                    let t = self.at(j, k);
                    self.a[i / 3][k / 3][i % 3][k % 3] -= l * t;
                }
                self.a[i / 3][j / 3][i % 3][j % 3] = l;
            }
            // What is right of the next pivot mirrors what is below it.
            if j + 1 < n {
                for k in j + 2..n {
                    self.a[(j + 1) / 3][k / 3][(j + 1) % 3][k % 3] = self.at(k, j + 1);
                }
            }
        }
    }

    /// Solves A x = x in place, x a momentum first and a velocity then.
    pub(crate) fn solve(&self, bodies: usize, x: &mut [Twist<T>; B]) {
        let n = 3 * bodies;
        for i in 0..n {
            let mut s = x[i / 3][i % 3];
            for j in 0..i {
                s -= self.at(i, j) * x[j / 3][j % 3];
            }
            x[i / 3][i % 3] = s;
        }
        for i in (0..n).rev() {
            let mut s = x[i / 3][i % 3] / self.at(i, i);
            for j in i + 1..n {
                s -= self.at(j, i) * x[j / 3][j % 3];
            }
            x[i / 3][i % 3] = s;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Body, Torsion};

    /// Three bodies in a chain of torsion springs: A x = b with the tridiagonal A written out.
    #[test]
    fn solves_a_chain() {
        let bodies = [Body { mass: 2.0, inertia: 1.0 }; 3];
        let spring = |first, second, stiffness| Torsion { first, second, stiffness, damping: 0.0, angle: 0.0 };
        let torsions = [spring(GROUND, 0, 5.0), spring(0, 1, 7.0), spring(1, 2, 11.0), spring(0, 2, 3.0)];
        let model = Model::new(&bodies, &[], &[], &[], [0.0; 2]).unwrap().with_torsions(&torsions).unwrap();
        let mut implicit = Implicit::<f64, 3>::new();
        let q = [Placement::origin(); 3];
        implicit.renew(&model, 2.0, 1.0, &q, &[[0.0; 3]; 3]);
        let x = [0.3, -0.7, 1.1];
        let k = [[15.0, -7.0, -3.0], [-7.0, 18.0, -11.0], [-3.0, -11.0, 14.0]];
        let mut b = [[0.0; 3]; 3];
        for i in 0..3 {
            b[i] = [2.0, 4.0, x[i] + (0..3).map(|j| 4.0 * k[i][j] * x[j]).sum::<f64>()];
        }
        implicit.solve(3, &mut b);
        for i in 0..3 {
            assert!((b[i][0] - 1.0).abs() + (b[i][1] - 2.0).abs() + (b[i][2] - x[i]).abs() < 1e-13, "{b:?}");
        }
    }
}
