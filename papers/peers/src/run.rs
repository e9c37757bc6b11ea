//! Runs of the mechanism by diffsol's solvers.

use std::time::Instant;

use diffsol::{DiffsolError, NalgebraLU, NalgebraMat, OdeBuilder, OdeEquations, OdeSolverMethod, OdeSolverStopReason};

use crate::equations::{Equations, Widths};
use crate::mechanism::Mechanism;
use crate::number::Dual;

type Matrix = NalgebraMat<f64>;
type Solver = NalgebraLU<f64>;

/// Solver of diffsol.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Method {
    /// Variable-order backward differentiation formulas.
    Bdf,
    /// An explicit-first-stage diagonally implicit Runge-Kutta method of order 3(4).
    Esdirk34,
    /// TR-BDF2.
    TrBdf2,
}

impl Method {
    /// Name in the tables.
    pub fn name(self) -> &'static str {
        match self {
            Method::Bdf => "BDF",
            Method::Esdirk34 => "ESDIRK34",
            Method::TrBdf2 => "TR-BDF2",
        }
    }
}

/// Settings of a run.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Setup {
    /// The solver.
    pub method: Method,
    /// Relative tolerance; the absolute ones are [`ANGLE_TOLERANCE`] and [`RATE_TOLERANCE`] times it.
    pub tolerance: f64,
    /// Regularisation.
    pub widths: Widths,
}

/// rad per unit of relative tolerance: a felt is compressed by 1e-4 m at an arm of 0.1 m.
pub(crate) const ANGLE_TOLERANCE: f64 = 1e-3;
/// rad/s per unit of relative tolerance: a twentieth of the hammer's rate at mf.
pub(crate) const RATE_TOLERANCE: f64 = 1.0;

/// Result of a run.
#[derive(Debug, Clone)]
pub(crate) struct Run<const S: usize> {
    /// Speed of the strike point at the string, m/s, and time, s.
    pub strike: Option<[f64; 2]>,
    /// States at the requested times.
    pub states: Vec<[f64; S]>,
    /// Wall-clock time of the solution, building the problem included, s.
    pub seconds: f64,
    /// Accepted steps.
    pub steps: usize,
}

/// Solves from rest to the last of `instants` under a force on the key.
///
/// # Errors
/// Errors of diffsol, in words.
pub(crate) fn run<const B: usize, const S: usize>(
    mechanism: &Mechanism,
    setup: &Setup,
    force: &dyn Fn(f64) -> f64,
    instants: &[f64],
) -> Result<Run<S>, String> {
    let start = Instant::now();
    let equations = Equations::<B, S>::new(mechanism, setup.widths);
    let state = |y: &[f64]| -> [f64; S] { std::array::from_fn(|i| y[i]) };
    let absolute = |i: usize| if i < B { ANGLE_TOLERANCE } else { RATE_TOLERANCE };
    let mut problem = OdeBuilder::<Matrix>::new()
        .rtol(setup.tolerance)
        .atol((0..S).map(|i| setup.tolerance * absolute(i)))
        .h0(1e-5)
        .rhs_implicit(
            |y: &[f64], _p: &[f64], t: f64, rates: &mut [f64]| {
                rates.copy_from_slice(&equations.rates(force(t), &state(y)));
            },
            |y: &[f64], _p: &[f64], t: f64, v: &[f64], out: &mut [f64]| {
                let along = std::array::from_fn(|i| Dual { value: y[i], slope: v[i] });
                out.copy_from_slice(&equations.rates(force(t), &along).map(|x| x.slope));
            },
        )
        .init(|_p: &[f64], _t: f64, y: &mut [f64]| y.copy_from_slice(&equations.rest()), S)
        .root(|y: &[f64], _p: &[f64], _t: f64, beyond: &mut [f64]| beyond[0] = equations.beyond_string(&state(y)), 1)
        .build()
        .map_err(|e| e.to_string())?;
    // With narrow friction laws Newton's method fails now and then; the solver then shortens its step, as often as
    // needed.
    problem.ode_options.max_nonlinear_solver_failures = usize::MAX;
    problem.ode_options.max_error_test_failures = usize::MAX;
    let solved = match setup.method {
        Method::Bdf => problem.bdf::<Solver>().and_then(|s| follow(s, &equations, instants)),
        Method::Esdirk34 => problem.esdirk34::<Solver>().and_then(|s| follow(s, &equations, instants)),
        Method::TrBdf2 => problem.tr_bdf2::<Solver>().and_then(|s| follow(s, &equations, instants)),
    };
    let (strike, states, steps) = solved.map_err(|e| e.to_string())?;
    Ok(Run { strike, states, seconds: start.elapsed().as_secs_f64(), steps })
}

type Followed<const S: usize> = (Option<[f64; 2]>, Vec<[f64; S]>, usize);

/// Steps to the end, detects the blow, and keeps the states at the given times.
fn follow<'a, E, M, const B: usize, const S: usize>(
    mut solver: M,
    equations: &Equations<'_, B, S>,
    instants: &[f64],
) -> Result<Followed<S>, DiffsolError>
where
    E: OdeEquations<T = f64> + 'a,
    E::V: std::ops::Index<usize, Output = f64>,
    M: OdeSolverMethod<'a, E>,
{
    let kept = |y: &E::V| -> [f64; S] { std::array::from_fn(|i| y[i]) };
    let mut strike = None;
    let mut states = Vec::with_capacity(instants.len());
    while states.len() < instants.len() {
        let reason = solver.step()?;
        if let (OdeSolverStopReason::RootFound(t, _), None) = (reason, strike) {
            strike = Some([equations.hammer_speed(&kept(&solver.interpolate(t)?)), t]);
        }
        while let Some(&instant) = instants.get(states.len()).filter(|&&t| t <= solver.state().t) {
            states.push(kept(&solver.interpolate(instant)?));
        }
    }
    Ok((strike, states, solver.get_statistics().number_of_steps))
}
