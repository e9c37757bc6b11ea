//! Felts with a set-valued loss, F = k g^r (1 + eta Sign(dg/dt)): their laws in the one-step problem.
//!
//! A mechanism without such felts pays nothing for it. The law acts along the zone's row G: u = G w, |p| <= h eta k
//! g^r, with p opposing u at the step's end. If dg/dt reverses within a step, such a law would do the work p (u0 +
//! u1)/2, of either sign. There the sign is replaced by its mean over a step with linear u, (u0 + u1)/(|u0| + |u1|), so
//! that the work is never a gain (README, "Dry felts").

use crate::felt::TINY;
use crate::model::Model;
use crate::real::{Mask, Real};
use crate::settings::Settings;
use crate::state::State;
use crate::workspace::{Contacts, DryFelts, LawSource, Problem, Workspace};

/// Prepares a step before its first iteration.
#[cold]
#[inline(never)]
pub(crate) fn begin<T: Real, const B: usize, const Z: usize, const N: usize>(
    model: &Model<T, B, Z>,
    state: &State<T, B, Z>,
    workspace: &mut Workspace<T, B, Z, N>,
) {
    for &z in model.dry_zones() {
        workspace.dry.force[z] = state.memory[z][0];
        workspace.dry.before[z] = state.memory[z][0];
        workspace.dry.side[z] = T::ZERO;
        workspace.dry.reversing[z] = T::Mask::splat(false);
        workspace.dry.law[z] = T::Mask::splat(false);
    }
}

/// Adds the felts' laws to the linearised step. Coulomb's laws are already there, and get their share of the felts' dry
/// forces.
#[cold]
#[inline(never)]
pub(crate) fn assemble<T: Real, const B: usize, const Z: usize, const N: usize>(
    model: &Model<T, B, Z>,
    settings: &Settings<T>,
    first: bool,
    w0: &[T; B],
    w: &[T; B],
    workspace: &mut Workspace<T, B, Z, N>,
) {
    let h = settings.step;
    let Workspace { contacts, problem, dry, .. } = workspace;
    let Contacts { states, active, touched, touched_count, .. } = contacts;
    let Problem { system, impulses, guess, sources, .. } = problem;
    for n in 0..system.count {
        if let LawSource::Zone(z) = sources[n] {
            let pressed = active[z].and(T::ZERO.lt(states[z].force));
            let share = T::only(pressed, h * model.compiled[z].friction * dry.force[z]);
            system.sliding[n].bound += T::only(T::Mask::splat(model.compiled[z].dry), share);
            dry.before[z] = dry.force[z];
        }
    }
    let mut n = system.count;
    for &z in touched[..*touched_count].iter().filter(|&&z| model.compiled[z].dry) {
        let (contact, support, eta) = (&states[z], &model.supports[z], model.compiled[z].eta);
        let pressed = active[z].and(T::ZERO.lt(contact.force));
        let (u0, u1) = (support.product(&contact.row, w0), support.product(&contact.row, w));
        let bound = eta * contact.force;
        let reversing = dry.reversing[z].and(pressed);
        if reversing.any() {
            let (sign, slope) = mean_sign(u0, u1, settings.theta);
            let force = T::only(reversing, bound * sign);
            let tangent = T::only(reversing, eta * sign * contact.tangent + h * bound * slope);
            support.add_term(&mut system.a, &mut system.b, &contact.row, tangent, -(h * force), w);
            dry.force[z] = T::select(reversing, force, dry.force[z]);
            dry.tangent[z] = tangent;
        }
        dry.law[z] = pressed.and(reversing.not());
        if !dry.law[z].any() || n >= N {
            continue;
        }
        sources[n] = LawSource::Felt(z);
        let share = T::only(dry.law[z], T::ONE);
        let law = &mut system.sliding[n];
        let gradient = share * eta * contact.tangent;
        support.spread(&contact.row, share, &mut law.row);
        support.spread(&contact.row, gradient, &mut law.slope);
        law.target = T::ZERO;
        law.bound = (share * h * bound).sub_product(gradient, u1);
        law.rigid = false;
        // In the first iteration a felt is expected to go on as it goes, or as it is predicted to.
        let moves = settings.solver_tolerance.lt(u0.abs());
        let way = T::select(T::ZERO.lt(u1.abs()), u1, u0);
        let predicted = T::only(moves, T::select(T::ZERO.lt(way), -T::ONE, T::ONE));
        guess.sliding[n] = share * if first { predicted } else { dry.side[z] };
        guess.open[n] = dry.law[z].not();
        impulses.sliding[n] = -(share * h * dry.force[z]);
        n += 1;
    }
    system.count = n;
}

/// The mean of u's sign over a step, weighted as its work is, and its slope in u1.
#[inline(always)]
fn mean_sign<T: Real>(u0: T, u1: T, theta: T) -> (T, T) {
    let (one, two) = (T::ONE, T::from_f64(2.0));
    let turned = (u0 * u1).lt(T::ZERO);
    let (before, after) = ((one - theta) * u0, theta * u1);
    let size = (before.abs() + after.abs()).max(T::from_f64(TINY));
    let straight = T::select(T::ZERO.lt(u0), one, -one);
    let sign = T::select(turned, (before + after) / size, straight);
    (sign, T::only(turned, two * theta * before.abs() / (size * size)))
}

/// Finds, after the solver, the felts that reverse within the step. Returns the lanes in which the error of the
/// iteration is not yet small.
#[cold]
#[inline(never)]
pub(crate) fn unsettled<T: Real, const B: usize, const Z: usize, const N: usize>(
    model: &Model<T, B, Z>,
    settings: &Settings<T>,
    w0: &[T; B],
    next: &[T; B],
    workspace: &mut Workspace<T, B, Z, N>,
) -> T::Mask {
    let (h, still) = (settings.step, settings.solver_tolerance);
    let Workspace { contacts, problem, dry, correction, .. } = workspace;
    let Contacts { states, touched, touched_count, slip_row, .. } = contacts;
    let DryFelts { force, before, tangent, side, reversing, law } = dry;
    let mut again = T::Mask::splat(false);
    let mut impulse = [T::ZERO; B];
    for &z in touched[..*touched_count].iter().filter(|&&z| model.compiled[z].dry) {
        let (contact, support) = (&states[z], &model.supports[z]);
        let (u0, u1) = (support.product(&contact.row, w0), support.product(&contact.row, next));
        let change = support.product(&contact.row, correction);
        // The linear part of what has changed in a felt that reverses; the rest is what was left out.
        let turned = reversing[z].and(law[z].not());
        if turned.any() {
            force[z] += T::only(turned, tangent[z] * change / h);
            let size = (u0.abs() + u1.abs()).max(T::from_f64(TINY));
            let part = (change / size).abs();
            let left = T::from_f64(4.0) * h * model.compiled[z].eta * contact.force * part * part.max(part * part);
            for (k, j) in support.joints() {
                impulse[j] += T::only(turned, left * contact.row[k].abs());
            }
        }
        let slides = T::ZERO.lt(side[z].abs());
        // The law's force is -p/h: it gives energy where it goes with the path of u.
        let against = (u0 * u1).lt(T::ZERO).and(slides).or(slides.not().and((force[z] * u0).lt(T::ZERO)));
        let turns = law[z].and(against).and(still.lt(u0.abs())).and(settings.theta.lt(T::ONE));
        reversing[z] = reversing[z].or(turns);
        again = again.or(turns);
        if model.compiled[z].slides {
            let left = h * model.compiled[z].friction * (force[z] - before[z]).abs();
            for (k, j) in support.joints() {
                impulse[j] += left * slip_row[z][k].abs();
            }
        }
    }
    for i in 0..B {
        let allowed = settings.tolerance * problem.system.a.diagonal[i] * (T::ONE + next[i].abs());
        again = again.or(impulse[i].le(allowed).not());
    }
    again
}

/// Adds the felts' dry forces regularised by tanh(u / width).
#[cold]
#[inline(never)]
pub(crate) fn regularised<T: Real, const B: usize, const Z: usize, const N: usize>(
    model: &Model<T, B, Z>,
    settings: &Settings<T>,
    width: T,
    w: &[T; B],
    workspace: &mut Workspace<T, B, Z, N>,
) {
    let h = settings.step;
    let Workspace { kinematics, contacts, problem, dry, .. } = workspace;
    let (a, b) = (&mut problem.system.a, &mut problem.system.b);
    for &z in contacts.touched[..contacts.touched_count].iter().filter(|&&z| model.compiled[z].dry) {
        let (contact, support) = (&contacts.states[z], &model.supports[z]);
        let t = (support.product(&contact.row, &kinematics.joint_velocity) / width).tanh();
        let bound = T::only(contacts.active[z], model.compiled[z].eta * contact.force);
        let tangent = h * settings.theta * bound / width * (T::ONE - t * t);
        dry.force[z] = bound * t;
        dry.law[z] = T::Mask::splat(false);
        support.add_term(a, b, &contact.row, tangent, -(h * bound * t), w);
    }
}
