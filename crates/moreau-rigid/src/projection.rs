//! Position correction of joints. After a step the placements move to where every joint is closed, by as little as
//! possible in the metric of the mass matrix (Newton's method). Coordinates that a motor drives keep their values.

use super::eliminate::eliminate;
use super::model::Model;
use super::placement::{Placement, Twist};
use super::rows::{Row, joint_rows};
use super::state::State;
use moreau::Scalar;

/// Corrections; from a step's end one or two suffice.
const CORRECTIONS: u32 = 12;
/// Equalities of at most so many joints are corrected at once; more are done joint by joint, in turn.
const JOINTS: usize = 16;

/// Closes every joint to `tolerance` (m, rad); false if that was not reached.
pub(super) fn close_joints<T: Scalar, const B: usize>(
    model: &Model<'_, T>,
    q: &mut [Placement<T>; B],
    tolerance: T,
    motors_hold: bool,
) -> bool {
    for correction in 0..CORRECTIONS {
        // The first one always: whether an opening is just below the tolerance or just above must not decide where the
        // bodies are, or a step's iteration goes back and forth between the two.
        if (correction > 0 || model.joints.is_empty()) && largest_opening(model, q) <= tolerance {
            return true;
        }
        for some in model.joints.chunks(JOINTS) {
            let mut rows = [Row::none(); 3 * JOINTS];
            let mut open = [T::ZERO; 3 * JOINTS];
            let mut m = 0;
            for joint in some {
                let at = joint_rows(joint, q);
                for (row, by) in at.closed.into_iter().zip(at.open) {
                    (rows[m], open[m]) = (row, -by);
                    m += 1;
                }
                if motors_hold && joint.rate.is_some() {
                    rows[m] = at.free;
                    m += 1;
                }
            }
            let mut a = [[T::ZERO; 3 * JOINTS]; 3 * JOINTS];
            for i in 0..m {
                for j in 0..m {
                    a[i][j] = rows[i].coupling(&rows[j], model);
                }
            }
            let mut push = [T::ZERO; 3 * JOINTS];
            eliminate(&mut a, &mut open, &mut push, m);
            let mut by: [Twist<T>; B] = [[T::ZERO; 3]; B];
            for (row, p) in rows.iter().zip(push).take(m) {
                row.push(model, p, &mut by);
            }
            for (place, d) in q.iter_mut().zip(&by) {
                place.at[0] += d[0];
                place.at[1] += d[1];
                place.angle += d[2];
            }
        }
    }
    largest_opening(model, q) <= tolerance
}

fn largest_opening<T: Scalar>(model: &Model<'_, T>, q: &[Placement<T>]) -> T {
    model.joints.iter().fold(T::ZERO, |most, joint| {
        let open = joint_rows(joint, q).open;
        most.max(open[0].abs()).max(open[1].abs())
    })
}

impl<T: Scalar, const B: usize, const N: usize> State<T, B, N> {
    /// Returns the constraint drift: the largest opening of a joint of the model, m or rad. Infinite if the state has
    /// no room for the model's bodies.
    pub fn drift(&self, model: &Model<'_, T>) -> T {
        if model.bodies.len() > B {
            return T::ONE / T::ZERO;
        }
        largest_opening(model, &self.placement)
    }

    /// Closes all joints from approximate placements, to `tolerance` (m, rad), and removes the velocities that violate
    /// the joints. Returns false, and leaves the state unchanged, if they do not close.
    pub fn assemble(&mut self, model: &Model<'_, T>, tolerance: T) -> bool {
        let mut q = self.placement;
        if model.bodies.len() > B || !close_joints(model, &mut q, tolerance, false) {
            return false;
        }
        self.placement = q;
        for some in model.joints.chunks(JOINTS) {
            let mut rows = [Row::none(); 2 * JOINTS];
            for (k, joint) in some.iter().enumerate() {
                [rows[2 * k], rows[2 * k + 1]] = joint_rows(joint, &q).closed;
            }
            let m = 2 * some.len();
            let mut a = [[T::ZERO; 2 * JOINTS]; 2 * JOINTS];
            let mut rhs = [T::ZERO; 2 * JOINTS];
            for i in 0..m {
                rhs[i] = -rows[i].velocity(&self.velocity);
                for j in 0..m {
                    a[i][j] = rows[i].coupling(&rows[j], model);
                }
            }
            let mut push = [T::ZERO; 2 * JOINTS];
            eliminate(&mut a, &mut rhs, &mut push, m);
            for (row, p) in rows.iter().zip(push).take(m) {
                row.push(model, p, &mut self.velocity);
            }
        }
        true
    }
}
