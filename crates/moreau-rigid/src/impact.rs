//! Stronge's impact law, integrated in the space of impulses.
//!
//! Each closing contact is a spring. Its impulse grows during compression, and the work of the normal impulse is
//! stored; during restitution it returns e squared of this work. Coulomb friction acts at every instant of the impact,
//! and joints stay closed. Between events (slip stops or begins; a contact begins restitution, ends it, or begins to
//! close) the velocities are linear in the impulses. The work is therefore exact, and no impact creates energy. A
//! single contact needs no spring stiffness: its events are found exactly. Several simultaneous contacts share their
//! impulses as springs of equal stiffness would, in short increments.

use super::mixed::{Law, Limits, Mode, Problem};
use super::model::Model;
use super::placement::Twist;
use super::workspace::Workspace;
use moreau::Scalar;

/// Most increments; after them the step's other laws end the impact without restitution.
const INCREMENTS: u32 = 500;
/// Part of the stiffest contact's time (its inverse angular frequency) that an increment of several contacts takes.
const PART: f64 = 0.1;

/// What an impact did.
#[derive(Debug, Clone, Copy)]
pub(super) struct Impact<T> {
    /// Increments in the space of impulses.
    pub increments: u32,
    /// Change of the kinetic energy, J.
    pub energy: T,
    /// Whether it came to its end.
    pub ended: bool,
}

/// A law of a contact point during the impact.
#[derive(Debug, Clone, Copy)]
struct Point<T> {
    /// Its normal and its tangential law.
    laws: [usize; 2],
    restitution: T,
    kinetic: T,
    limit: T,
    /// Work taken and not given back yet, in terms of what was taken, J.
    stored: T,
    /// Sign of the slip; zero while it sticks.
    slip: T,
    /// Growth of its normal impulse.
    rate: T,
}

/// Passes the impact of the contacts whose normal law in `workspace.problem` is in force. `workspace.rows` are the rows
/// at its pose, `v` the velocities before, and after; `p` receives the impulses. Speeds below `tolerance` are none.
pub(super) fn collide<T: Scalar, const B: usize, const N: usize>(
    model: &Model<'_, T>,
    tolerance: T,
    v: &mut [Twist<T>; B],
    p: &mut [T; N],
    workspace: &mut Workspace<T, B, N>,
) -> Impact<T> {
    let mut impact = Impact { increments: 0, energy: T::ZERO, ended: false };
    let Workspace { rows, problem, reduced, .. } = workspace;
    let n = problem.count;
    *p = [T::ZERO; N];
    let mut u = [T::ZERO; N];
    for i in 0..n {
        if problem.law[i] != Law::Absent {
            u[i] = rows[i].velocity(v);
            for j in 0..n {
                problem.delassus[i][j] =
                    if problem.law[j] == Law::Absent { T::ZERO } else { rows[i].coupling(&rows[j], model) };
            }
        }
    }
    let mut points: [Option<Point<T>>; N] = [None; N];
    let mut fastest = T::ZERO;
    for (c, point) in points.iter_mut().enumerate().take(model.points()) {
        let laws = model.contact_laws(c);
        if problem.law[laws[0]] == Law::Absent {
            continue;
        }
        let matter = model.matter(c);
        u[laws[1]] -= matter.belt;
        let slip = sign(u[laws[1]], tolerance);
        let (restitution, kinetic, limit) = (matter.restitution, matter.kinetic, matter.limit);
        *point = Some(Point { laws, restitution, kinetic, limit, stored: T::ZERO, slip, rate: T::ZERO });
        let row = (0..model.points()).fold(T::ZERO, |sum, k| {
            let other = model.contact_laws(k)[0];
            if problem.law[other] == Law::Absent { sum } else { sum + problem.delassus[laws[0]][other].abs() }
        });
        fastest = fastest.max(row);
    }
    // With springs of stiffness one: an increment of time.
    let part = if T::ZERO < fastest { T::from_f64(PART) / fastest.sqrt() } else { T::ZERO };
    let nothing = tolerance * T::from_f64(1e-3);
    let (mut mode, mut rate) = ([Mode::Hold; N], [T::ZERO; N]);
    while impact.increments < INCREMENTS {
        impact.increments += 1;
        let near = points.iter().flatten().filter(|c| T::ZERO < c.stored || u[c.laws[0]] <= tolerance).count();
        let pushing = points.iter().flatten().any(|c| T::ZERO < c.stored || u[c.laws[0]] < -tolerance);
        if !pushing {
            impact.ended = true;
            break;
        }
        let crowd = near > 1;
        for c in points.iter_mut().flatten() {
            let closing = -u[c.laws[0]];
            c.rate = if !(T::ZERO < c.stored || closing > tolerance) {
                T::ZERO
            } else if crowd {
                // The spring's force in the middle of the increment; it unloads steeper, by 1/e2, than it was loaded.
                let force = (c.stored + c.stored).sqrt();
                let steep = if T::ZERO < closing { T::ONE } else { T::ONE / (c.restitution * c.restitution) };
                (force + T::from_f64(0.5) * part * steep * closing).max(T::from_f64(0.5) * force)
            } else {
                T::ONE
            };
            if c.rate == T::ZERO {
                // Nothing presses it: others may move it.
                c.slip = sign(u[c.laws[1]], tolerance);
            }
        }
        if !rates(problem, reduced, &mut points, &mut mode, &mut rate) {
            break;
        }
        let mut du = [T::ZERO; N];
        for i in 0..n {
            if problem.law[i] != Law::Absent {
                du[i] = (0..n).fold(T::ZERO, |sum, j| sum + problem.delassus[i][j] * rate[j]);
            }
        }
        let most = if crowd { part } else { T::ONE / T::ZERO };
        let s = until_event(&points, &u, &du, tolerance, most);
        if !s.finite() {
            break;
        }
        for c in points.iter_mut().flatten() {
            let [normal, tangential] = c.laws;
            let half = T::from_f64(0.5) * s;
            let work = rate[normal] * s * (u[normal] + half * du[normal]);
            impact.energy += work + rate[tangential] * s * (u[tangential] + half * du[tangential]);
            let after = u[normal] + s * du[normal];
            // An event ends each increment that would close first and part then.
            let closes = u[normal] + half * du[normal] < T::ZERO;
            let taken =
                if closes || c.restitution == T::ZERO { -work } else { -(work / (c.restitution * c.restitution)) };
            let rounding = T::from_f64(64.0) * T::EPSILON * (c.stored + taken.abs());
            c.stored += taken;
            if c.stored <= rounding || (c.restitution == T::ZERO && after >= -nothing) {
                c.stored = T::ZERO;
            }
            // What an event was found for happens exactly.
            if closes && after >= -nothing {
                u[normal] = -(s * du[normal]);
            }
            if c.slip != T::ZERO && c.slip * (u[tangential] + s * du[tangential]) <= nothing {
                c.slip = T::ZERO;
                u[tangential] = -(s * du[tangential]);
            }
        }
        for i in 0..n {
            u[i] += s * du[i];
            p[i] += s * rate[i];
        }
    }
    for i in 0..n {
        if problem.law[i] != Law::Absent {
            rows[i].push(model, p[i], v);
        }
    }
    impact
}

fn sign<T: Scalar>(u: T, tolerance: T) -> T {
    if u > tolerance {
        T::ONE
    } else if u < -tolerance {
        -T::ONE
    } else {
        T::ZERO
    }
}

/// Growth of all impulses while the normal ones grow as told: what sticks has friction up to its limit, what slips all
/// of it, joints what keeps them closed. A convex problem, which has a solution.
fn rates<T: Scalar, const N: usize>(
    problem: &mut Problem<T, N>,
    reduced: &mut super::sweeps::Reduced<T, N>,
    points: &mut [Option<Point<T>>; N],
    mode: &mut [Mode; N],
    rate: &mut [T; N],
) -> bool {
    let laws = problem.law;
    let n = problem.count;
    for c in points.iter().flatten() {
        problem.law[c.laws[0]] = Law::Absent;
        problem.law[c.laws[1]] = Law::Absent;
    }
    // Friction of finite forces has no impulse.
    for law in &mut problem.law[..n] {
        if matches!(law, Law::Relay(_)) {
            *law = Law::Absent;
        }
    }
    let mut given = [T::ZERO; N];
    for c in points.iter().flatten() {
        given[c.laws[0]] = c.rate;
        if c.slip != T::ZERO {
            given[c.laws[1]] = -(c.slip * c.kinetic * c.rate);
        } else if T::ZERO < c.limit * c.rate {
            problem.law[c.laws[1]] = Law::Relay(c.limit * c.rate);
        }
    }
    let mut solved;
    loop {
        let mut scale = T::ZERO;
        for i in 0..n {
            problem.free[i] = (0..n).fold(T::ZERO, |sum, j| sum + problem.delassus[i][j] * given[j]);
            if problem.law[i] != Law::Absent {
                scale = scale.max(problem.free[i].abs());
            }
        }
        let limits = Limits {
            tolerance: T::from_f64(1e-12).max(T::EPSILON * T::from_f64(64.0)) * scale,
            guesses: 5_000,
            sweeps: 1_000,
        };
        // Impulses of the laws that are solved for; the given ones are in `free`.
        for i in 0..n {
            if problem.law[i] == Law::Absent {
                rate[i] = T::ZERO;
            }
        }
        solved = problem.solve(mode, rate, &limits, reduced).solved == super::mixed::Solved::Yes;
        // What stuck up to its limit and now begins to slip has kinetic friction.
        let mut any = false;
        for c in points.iter_mut().flatten() {
            let t = c.laws[1];
            if matches!((problem.law[t], mode[t]), (Law::Relay(_), Mode::Upper | Mode::Lower)) {
                c.slip = if mode[t] == Mode::Upper { -T::ONE } else { T::ONE };
                given[t] = -(c.slip * c.kinetic * c.rate);
                problem.law[t] = Law::Absent;
                any = true;
            }
        }
        if !any || !solved {
            break;
        }
    }
    for i in 0..n {
        rate[i] += given[i];
    }
    problem.law = laws;
    solved
}

/// How far the impulses grow until something changes, `most` at most.
fn until_event<T: Scalar, const N: usize>(
    points: &[Option<Point<T>>; N],
    u: &[T; N],
    du: &[T; N],
    tolerance: T,
    most: T,
) -> T {
    let mut s = most;
    let mut earlier = |x: T| {
        if x > T::ZERO && x < s {
            s = x;
        }
    };
    for c in points.iter().flatten() {
        let [n, t] = c.laws;
        if c.slip != T::ZERO && c.slip * du[t] < T::ZERO {
            earlier(-(u[t] / du[t]));
        }
        if u[n] < T::ZERO && du[n] > T::ZERO {
            // It begins to part.
            earlier(-(u[n] / du[n]));
        } else if u[n] > tolerance && du[n] < T::ZERO {
            // It begins to close.
            earlier(-(u[n] / du[n]));
        }
        if T::ZERO < c.stored && T::ZERO < c.rate && u[n] >= T::ZERO {
            // It has given back everything: rate (u s + du s2 / 2) = e2 stored.
            let rest = c.restitution * c.restitution * c.stored / c.rate;
            let root = u[n] * u[n] + (du[n] + du[n]) * rest;
            if root >= T::ZERO {
                earlier((rest + rest) / (u[n] + root.sqrt()));
            }
        }
    }
    s
}
