//! Regular forces: gravity, loads, springs, and viscous friction of joints; and stored energies.

use super::model::{Model, Spring, Torsion};
use super::placement::{Placement, Twist, placed};
use super::rows::{Row, joint_rows};
use super::state::State;
use moreau::vector::{dot, scale, sub};
use moreau::{GROUND, Scalar};

/// v0 + M^-1 h Q at the theta point: the velocities without any law's impulse.
pub(super) fn regular_impulse<T: Scalar, const B: usize>(
    model: &Model<'_, T>,
    h: T,
    loads: &[[T; 3]],
    v0: &[Twist<T>; B],
    q: &[Placement<T>; B],
    v: &[Twist<T>; B],
) -> [Twist<T>; B] {
    let mut free = *v0;
    for (i, body) in model.bodies.iter().enumerate() {
        for k in 0..2 {
            free[i][k] += h * model.gravity[k];
        }
        if let Some(load) = loads.get(i) {
            for (k, m) in [body.mass, body.mass, body.inertia].into_iter().enumerate() {
                free[i][k] += h * load[k] / m;
            }
        }
    }
    for spring in model.springs {
        let ends = spring_ends(spring, q);
        let row = along_spring(spring, q, ends.direction);
        let pull = spring.stiffness * (ends.length - spring.length) + spring.damping * row.velocity(v);
        row.push(model, -(h * pull), &mut free);
    }
    for torsion in model.torsions {
        let row = Row::turning(torsion.first, torsion.second);
        let moment = torsion.stiffness * twist(torsion, q) + torsion.damping * row.velocity(v);
        row.push(model, -(h * moment), &mut free);
    }
    for joint in model.joints {
        if T::ZERO < joint.viscous {
            let row = joint_rows(joint, q).free;
            row.push(model, -(h * joint.viscous * row.velocity(v)), &mut free);
        }
    }
    free
}

/// Where a spring is.
pub(super) struct Ends<T> {
    /// From the first to the second end, a unit vector; zero if they coincide.
    pub direction: [T; 2],
    /// Their distance, m.
    pub length: T,
    /// The ends' places against the centres of mass.
    pub arms: [[T; 2]; 2],
}

pub(super) fn spring_ends<T: Scalar>(spring: &Spring<T>, q: &[Placement<T>]) -> Ends<T> {
    let carriers = [placed(q, spring.first), placed(q, spring.second)];
    let ends = [carriers[0].point(spring.at_first), carriers[1].point(spring.at_second)];
    let line = sub(ends[1], ends[0]);
    let length = dot(line, line).sqrt();
    let direction = if T::ZERO < length { scale(line, T::ONE / length) } else { [T::ZERO; 2] };
    Ends { direction, length, arms: core::array::from_fn(|k| sub(ends[k], carriers[k].at)) }
}

/// Velocity of a spring's second end minus that of its first, along a direction.
pub(super) fn along_spring<T: Scalar>(spring: &Spring<T>, q: &[Placement<T>], direction: [T; 2]) -> Row<T> {
    let at = [placed(q, spring.first).point(spring.at_first), placed(q, spring.second).point(spring.at_second)];
    Row::between(q, [spring.first, spring.second], at, direction)
}

/// By how much a torsion spring is turned from where it has no moment, rad.
fn twist<T: Scalar>(torsion: &Torsion<T>, q: &[Placement<T>]) -> T {
    placed(q, torsion.second).angle - placed(q, torsion.first).angle - torsion.angle
}

/// Stored energies of a mechanism, J.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Energies<T> {
    /// Kinetic energy 1/2 v.Mv.
    pub kinetic: T,
    /// Gravitational energy, zero at the world's origin.
    pub gravity: T,
    /// Energy of springs and torsion springs.
    pub springs: T,
}

impl<T: Scalar> Energies<T> {
    /// Returns the energies of a state. Bodies for which the state has no room are left out, with their springs.
    pub fn of<const B: usize, const N: usize>(model: &Model<'_, T>, state: &State<T, B, N>) -> Self {
        let half = T::from_f64(0.5);
        let mut e = Energies { kinetic: T::ZERO, gravity: T::ZERO, springs: T::ZERO };
        for ((body, place), v) in model.bodies.iter().zip(&state.placement).zip(&state.velocity) {
            e.kinetic += half * (body.mass * (v[0] * v[0] + v[1] * v[1]) + body.inertia * v[2] * v[2]);
            e.gravity += -(body.mass * dot(model.gravity, place.at));
        }
        let known = |body: usize| body == GROUND || body < B;
        for spring in model.springs {
            if known(spring.first) && known(spring.second) {
                let stretch = spring_ends(spring, &state.placement).length - spring.length;
                e.springs += half * spring.stiffness * stretch * stretch;
            }
        }
        for torsion in model.torsions {
            if known(torsion.first) && known(torsion.second) {
                let turned = twist(torsion, &state.placement);
                e.springs += half * torsion.stiffness * turned * turned;
            }
        }
        e
    }

    /// Returns the sum of all energies, J.
    pub fn total(&self) -> T {
        self.kinetic + self.gravity + self.springs
    }
}
