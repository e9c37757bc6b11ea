//! Regular forces: gravity, loads, springs, viscous friction of joints. And the energies that they store.

use super::model::{Model, Spring};
use super::rows::joint_rows;
use super::state::{Placement, State, Twist, placed};
use crate::vector::{cross, dot, scale, sub};
use crate::{GROUND, Scalar};

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
        let (pull, direction, arms) = tension(spring, q, v);
        for (k, body, sign) in [(0, spring.first, T::ONE), (1, spring.second, -T::ONE)] {
            if body != GROUND {
                let (b, force) = (&model.bodies[body], scale(direction, sign * pull * h));
                free[body][0] += force[0] / b.mass;
                free[body][1] += force[1] / b.mass;
                free[body][2] += cross(arms[k], force) / b.inertia;
            }
        }
    }
    for joint in model.joints {
        if T::ZERO < joint.viscous {
            let row = joint_rows(joint, q).free;
            row.push(model, -(h * joint.viscous * row.velocity(v)), &mut free);
        }
    }
    free
}

type Pull<T> = (T, [T; 2], [[T; 2]; 2]);

/// Tension of a spring, its direction from the first to the second end, and the ends' arms.
fn tension<T: Scalar>(spring: &Spring<T>, q: &[Placement<T>], v: &[Twist<T>]) -> Pull<T> {
    let bodies = [spring.first, spring.second];
    let ends = [placed(q, bodies[0]).point(spring.at_first), placed(q, bodies[1]).point(spring.at_second)];
    let line = sub(ends[1], ends[0]);
    let length = dot(line, line).sqrt();
    let direction = if T::ZERO < length { scale(line, T::ONE / length) } else { [T::ZERO; 2] };
    let arms: [[T; 2]; 2] = core::array::from_fn(|k| sub(ends[k], placed(q, bodies[k]).at));
    let mut rate = T::ZERO;
    for (k, sign) in [-T::ONE, T::ONE].into_iter().enumerate() {
        if bodies[k] != GROUND {
            let w = v[bodies[k]];
            let end = [w[0] - w[2] * arms[k][1], w[1] + w[2] * arms[k][0]];
            rate += sign * dot(end, direction);
        }
    }
    (spring.stiffness * (length - spring.length) + spring.damping * rate, direction, arms)
}

/// Energies that a mechanism stores, J.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Energies<T> {
    /// 1/2 v.Mv.
    pub kinetic: T,
    /// In gravity, zero at the world's origin.
    pub gravity: T,
    /// In the springs.
    pub springs: T,
}

impl<T: Scalar> Energies<T> {
    /// Of a state; bodies that the state has no place for are left out, with their springs.
    pub fn of<const B: usize, const N: usize>(model: &Model<'_, T>, state: &State<T, B, N>) -> Self {
        let half = T::from_f64(0.5);
        let mut e = Energies { kinetic: T::ZERO, gravity: T::ZERO, springs: T::ZERO };
        for ((body, place), v) in model.bodies.iter().zip(&state.placement).zip(&state.velocity) {
            e.kinetic += half * (body.mass * (v[0] * v[0] + v[1] * v[1]) + body.inertia * v[2] * v[2]);
            e.gravity += -(body.mass * dot(model.gravity, place.at));
        }
        let at_rest = [[T::ZERO; 3]; B];
        let known = |body: usize| body == GROUND || body < B;
        for spring in model.springs {
            if T::ZERO < spring.stiffness && known(spring.first) && known(spring.second) {
                let pull = tension(spring, &state.placement, &at_rest).0;
                e.springs += half * pull * pull / spring.stiffness;
            }
        }
        e
    }

    /// All of it.
    pub fn total(&self) -> T {
        self.kinetic + self.gravity + self.springs
    }
}
