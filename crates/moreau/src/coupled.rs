//! Felts that press the same external subsystem within a step, e.g. a hammer's and a damper's on one string. Their
//! forces are solved for together.
//!
//! Let r_i be the compression rate of felt i without displacement of its surface. Then F_i = P_i(r_i - sum_j a_ij F_j),
//! where a = A/h between the zones is symmetric and positive definite, and the laws P increase. So the forces minimise
//! a convex function, sum P*_i(F_i) + F a F / 2 - r F. Iterating over the felts, each time solving the scalar equation
//! of [`crate::surface::solve`], converges to the minimum from any start (README, "Compliant surfaces").

use crate::linear::gauss_jordan;
use crate::model::Model;
use crate::osnsp::System;
use crate::real::{Mask, Real};
use crate::settings::Settings;
use crate::surface::COUPLED;
use crate::timing::Timing;
use crate::workspace::{Contacts, Workspace};

/// Largest number of sweeps over the felts. A hammer and a damper take about ten.
const ROUNDS: u32 = 256;

/// Forces of the felts, N, and -dF/d(rate) of each one alone, N s/m.
struct Found<T> {
    forces: [T; COUPLED],
    slopes: [T; COUPLED],
}

/// Solves for the forces of the coupled zones, at rates that differ from those of the last evaluation by the given
/// amounts, m/s. Afterwards each surface holds the velocity that the other zones' forces add to it. Returns `None`, and
/// changes nothing, if there is nothing to couple.
fn solve<T: Real, const B: usize, const Z: usize>(
    model: &Model<T, B, Z>,
    timing: &Timing<T>,
    takes_part: impl Fn(&Contacts<T, B, Z>, usize) -> bool,
    more: impl Fn(&Contacts<T, B, Z>, usize) -> T,
    contacts: &mut Contacts<T, B, Z>,
) -> Option<Found<T>> {
    let (zero, count) = (T::ZERO, contacts.coupled.count);
    let part: [bool; COUPLED] = core::array::from_fn(|i| i < count && takes_part(contacts, contacts.coupled.zone[i]));
    // Dampers on strings that do not feel each other, say.
    let alone = |i: usize| {
        let tied = (0..count).any(|j| part[j] && zero.lt(contacts.coupled.mobility[i][j].abs()).any());
        !tied && !zero.lt(contacts.coupled.from_others[i].abs()).any()
    };
    if (0..count).all(|i| !part[i] || alone(i)) {
        return None;
    }
    let more: [T; COUPLED] =
        core::array::from_fn(|i| if part[i] { more(contacts, contacts.coupled.zone[i]) } else { zero });
    let press = |contacts: &Contacts<T, B, Z>, i: usize, forces: &[T; COUPLED]| {
        let z = contacts.coupled.zone[i];
        let shift = contacts.coupled.others(i, forces) - contacts.coupled.from_others[i];
        contacts.states[z].pressed_at(&model.compiled[z], timing, more[i] - shift, &contacts.surfaces[z])
    };
    let (mut forces, mut slopes) = ([zero; COUPLED], [zero; COUPLED]);
    for i in (0..count).filter(|i| part[*i]) {
        let z = contacts.coupled.zone[i];
        [forces[i], slopes[i]] =
            contacts.states[z].pressed_at(&model.compiled[z], timing, more[i], &contacts.surfaces[z]);
    }
    let displaced =
        |i: usize| zero.lt((contacts.coupled.others(i, &forces) - contacts.coupled.from_others[i]).abs()).any();
    if !(0..count).any(displaced) {
        return None;
    }
    for _ in 0..ROUNDS {
        let (mut change, mut largest) = (zero, zero);
        for i in (0..count).filter(|i| part[*i]) {
            let before = forces[i];
            [forces[i], slopes[i]] = press(contacts, i, &forces);
            change = change.max((forces[i] - before).abs());
            largest = largest.max(forces[i]);
        }
        if change.le(T::from_f64(8.0) * T::EPSILON * largest).all() {
            break;
        }
    }
    for i in 0..count {
        let z = contacts.coupled.zone[i];
        let added = contacts.coupled.others(i, &forces);
        let shift = added - contacts.coupled.from_others[i];
        contacts.coupled.from_others[i] = added;
        contacts.surfaces[z].drift += shift;
        contacts.surfaces[z].offset += timing.h_theta * shift;
        contacts.states[z].rate -= shift;
        contacts.states[z].compression -= timing.h_theta * shift;
    }
    Some(Found { forces, slopes })
}

/// Replaces the forces that each felt has found alone by the coupled forces, also in the linearised step.
///
/// With s_i = -dF_i/dr_i of each alone, dF = (diag(1/s) + a)^-1 dr: a row of one zone then acts on another's force.
#[cold]
#[inline(never)]
pub(crate) fn press_coupled<T: Real, const B: usize, const Z: usize, const N: usize>(
    model: &Model<T, B, Z>,
    timing: &Timing<T>,
    near: &[usize],
    w: &[T; B],
    contacts: &mut Contacts<T, B, Z>,
    system: &mut System<T, B, N>,
) {
    let (zero, count) = (T::ZERO, contacts.coupled.count);
    // A zone that the others press into reach takes part, too; but its slip would have no row yet.
    let takes_part = |contacts: &Contacts<T, B, Z>, z: usize| {
        let touched = contacts.touched[..contacts.touched_count].contains(&z);
        near.contains(&z) && contacts.states[z].in_reach.any() && (touched || !model.compiled[z].slides)
    };
    let Some(Found { forces, slopes }) = solve(model, timing, takes_part, |_, _| zero, contacts) else {
        for i in 0..count {
            contacts.surfaces[contacts.coupled.zone[i]].shared = false;
        }
        return;
    };
    let tangents = tangents(&contacts.coupled.mobility, &slopes);
    let mut rows = [[zero; B]; COUPLED];
    for i in 0..count {
        let z = contacts.coupled.zone[i];
        let touched = contacts.touched[..contacts.touched_count].contains(&z);
        contacts.surfaces[z].shared = zero.lt(forces[i]).any();
        if !touched && !contacts.surfaces[z].shared {
            continue;
        }
        let (support, contact) = (&model.supports[z], &mut contacts.states[z]);
        let before = if touched { [contact.force, contact.tangent] } else { [zero; 2] };
        (contact.force, contact.tangent) = (forces[i], timing.h_theta * tangents[i][i]);
        let more = [contact.force - before[0], contact.tangent - before[1]];
        support.add_term(&mut system.a, &mut system.b, &contact.row, more[1], -(timing.step * more[0]), w);
        support.spread(&contact.row, T::ONE, &mut rows[i]);
        if !touched {
            contacts.touch(z);
        }
    }
    for i in 0..count {
        for j in 0..i {
            add_pair([&rows[i], &rows[j]], timing.h_theta * tangents[i][j], w, system);
        }
    }
}

/// Adds to the linearised step the coupling between the force of one zone and the rate of another: A += t (x^T y + y^T
/// x), b += t (x^T y + y^T x) w.
fn add_pair<T: Real, const B: usize, const N: usize>(
    [x, y]: [&[T; B]; 2],
    tangent: T,
    w: &[T; B],
    system: &mut System<T, B, N>,
) {
    let (mut of_x, mut of_y) = (T::ZERO, T::ZERO);
    for k in 0..B {
        of_x = of_x.add_product(x[k], w[k]);
        of_y = of_y.add_product(y[k], w[k]);
    }
    for k in 0..B {
        system.b[k] += tangent * (x[k] * of_y + y[k] * of_x);
        system.a.diagonal[k] += T::from_f64(2.0) * tangent * x[k] * y[k];
        for l in 0..k {
            system.a.below[k][l] += tangent * (x[k] * y[l] + y[k] * x[l]);
        }
    }
}

/// Returns (diag(1/s) + a)^-1, N s/m, with zero rows where s is zero. The matrix is positive semidefinite.
fn tangents<T: Real>(mobility: &[[T; COUPLED]; COUPLED], slopes: &[T; COUPLED]) -> [[T; COUPLED]; COUPLED] {
    let (zero, mut inverse) = (T::ZERO, [[T::ZERO; COUPLED]; COUPLED]);
    // (1 + s a) x = s; s a has a zero diagonal, and the matrix is that of a positive definite one times s.
    let mut matrix = [[zero; COUPLED]; COUPLED];
    for i in 0..COUPLED {
        for j in 0..COUPLED {
            matrix[i][j] = slopes[i] * mobility[i][j];
        }
        matrix[i][i] += T::ONE;
        inverse[i][i] = slopes[i];
    }
    gauss_jordan(&mut matrix, &mut inverse);
    inverse
}

/// Solves for the forces at the velocities at the step's end, with the same equations, for the touched zones.
#[cold]
#[inline(never)]
pub(crate) fn settle<T: Real, const B: usize, const Z: usize, const N: usize>(
    model: &Model<T, B, Z>,
    settings: &Settings<T>,
    workspace: &mut Workspace<T, B, Z, N>,
) {
    let timing = Timing::new(settings.step, settings.theta);
    let Workspace { contacts, correction, .. } = workspace;
    let touched = |contacts: &Contacts<T, B, Z>, z: usize| {
        contacts.touched[..contacts.touched_count].contains(&z) && contacts.active[z].any()
    };
    let more = |contacts: &Contacts<T, B, Z>, z: usize| {
        timing.theta * model.supports[z].product(&contacts.states[z].row, correction)
    };
    solve(model, &timing, touched, more, contacts);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against the inverse of diag(1/s) + a, worked out by multiplying back; a felt that does not push has no part in
    /// it.
    #[test]
    fn the_tangents_are_the_inverse() {
        let mobility = [[0.0, 0.3, -0.2, 0.1], [0.3, 0.0, 0.05, 0.0], [-0.2, 0.05, 0.0, 0.02], [0.1, 0.0, 0.02, 0.0]];
        let slopes = [0.5, 1.2, 2.0, 0.0];
        let found: [[f64; COUPLED]; COUPLED] = tangents(&mobility, &slopes);
        for i in 0..3 {
            for j in 0..3 {
                let back: f64 =
                    (0..3).map(|k| (if i == k { 1.0 / slopes[i] } else { mobility[i][k] }) * found[k][j]).sum();
                assert!((back - f64::from(u8::from(i == j))).abs() < 1e-14, "{i} {j}: {back}");
                assert!((found[i][j] - found[j][i]).abs() < 1e-15);
            }
        }
        assert_eq!(found[3], [0.0; COUPLED]);
        assert!((0..4).all(|i| found[i][3] == 0.0));
    }
}
