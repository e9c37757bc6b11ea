//! Least squares within bounds: a reflective trust region, scaled by the distance to the bounds and by the Jacobian's
//! columns.
//!
//! Branch, Coleman and Li, "A subspace, interior, and conjugate gradient method for large-scale bound-constrained
//! minimization problems", SIAM J. Sci. Comput. 21 (1999), with the steps, scales and stopping rules of SciPy
//! (`least_squares(method="trf", x_scale="jac")`), so that both agree. The trust-region subproblem is solved as in More
//! (1978). Robust losses are weighted as in Triggs and others, "Bundle adjustment: a modern synthesis" (1999).

use crate::dense::{Columns, Svd, dot, norm, svd, times};

/// Loss function of the squared residuals.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Loss {
    /// z.
    #[default]
    Linear,
    /// 2 (sqrt(1 + z) - 1): quadratic in small residuals, linear in large ones.
    SoftL1,
    /// Quadratic in residuals up to 1, linear beyond.
    Huber,
    /// ln(1 + z): large residuals hardly count.
    Cauchy,
}

impl Loss {
    /// The loss of a squared residual z, and its first two derivatives.
    fn of(self, z: f64) -> [f64; 3] {
        match self {
            Loss::Linear => [z, 1.0, 0.0],
            Loss::Huber if z <= 1.0 => [z, 1.0, 0.0],
            Loss::Huber => [2.0 * z.sqrt() - 1.0, z.powf(-0.5), -0.5 * z.powf(-1.5)],
            Loss::SoftL1 => {
                let t = 1.0 + z;
                [2.0 * (t.sqrt() - 1.0), t.powf(-0.5), -0.5 * t.powf(-1.5)]
            }
            Loss::Cauchy => {
                let t = 1.0 + z;
                [t.ln(), 1.0 / t, -1.0 / (t * t)]
            }
        }
    }

    pub(super) fn cost(self, residuals: &[f64]) -> f64 {
        0.5 * residuals.iter().map(|f| self.of(f * f)[0]).sum::<f64>()
    }

    /// Rescales residuals and Jacobian to a linear least-squares problem with the loss's gradient and, as far as it is
    /// positive, its curvature.
    fn weighted(self, residuals: &mut [f64], jacobian: &mut [Vec<f64>]) {
        if self == Loss::Linear {
            return;
        }
        for (row, f) in residuals.iter_mut().enumerate() {
            let z = *f * *f;
            let [_, first, second] = self.of(z);
            let scale = (first + 2.0 * second * z).max(f64::EPSILON).sqrt();
            *f *= first / scale;
            jacobian.iter_mut().for_each(|column| column[row] *= scale);
        }
    }
}

/// A least-squares problem.
pub trait LeastSquares {
    /// Error that ends the solution early.
    type Error;

    /// Residuals at a point; not finite where it cannot be evaluated.
    ///
    /// # Errors
    /// An error that ends the solution.
    fn residuals(&mut self, x: &[f64]) -> Result<Vec<f64>, Self::Error>;

    /// Derivatives of the residuals, column by column.
    ///
    /// # Errors
    /// An error that ends the solution.
    fn jacobian(&mut self, x: &[f64]) -> Result<Columns, Self::Error>;
}

/// Why the solver ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Ended {
    /// The gradient is below the tolerance.
    Gradient,
    /// The sum of squares no longer falls.
    Cost,
    /// The step is below the tolerance.
    Step,
    /// The sum of squares no longer falls, and the step is below the tolerance.
    CostAndStep,
    /// The largest number of evaluations was reached.
    Evaluations,
}

impl Ended {
    /// The reason in words.
    pub(crate) fn words(self) -> &'static str {
        match self {
            Ended::Gradient => "the gradient has vanished",
            Ended::Cost => "the sum of squares no longer falls",
            Ended::Step => "the steps have vanished",
            Ended::CostAndStep => "neither the sum of squares nor the parameters move any more",
            Ended::Evaluations => "ended after the most steps that it may take",
        }
    }
}

/// Result of the solver.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Solved {
    /// End point.
    pub x: Vec<f64>,
    /// Unweighted residuals there.
    pub residuals: Vec<f64>,
    /// Half the sum of the losses.
    pub cost: f64,
    /// Evaluations of the residuals, without those for Jacobians.
    pub evaluations: usize,
    /// Reason why it ended.
    pub ended: Ended,
}

/// Tolerance of the gradient (absolute), and of cost and step (relative).
const TOLERANCE: f64 = 1e-8;

/// Minimises half the sum of the losses from a point within the bounds, with at most `max_evaluations` evaluations of
/// the residuals.
///
/// # Errors
/// Errors of the problem.
///
/// # Panics
/// If the number of bounds differs from the number of parameters.
pub(crate) fn solve<P: LeastSquares + ?Sized>(
    problem: &mut P,
    start: &[f64],
    bounds: (&[f64], &[f64]),
    loss: Loss,
    max_evaluations: usize,
) -> Result<Solved, P::Error> {
    let count = start.len();
    assert!(bounds.0.len() == count && bounds.1.len() == count, "a lower and an upper bound for every parameter");
    let mut x = inside(start, bounds, 1e-10);
    let mut f = problem.residuals(&x)?;
    let mut evaluations = 1;
    let mut cost = loss.cost(&f);
    let (mut weighted, mut jacobian) = (f.clone(), problem.jacobian(&x)?);
    loss.weighted(&mut weighted, &mut jacobian);
    let mut gradient: Vec<f64> = jacobian.iter().map(|column| dot(column, &weighted)).collect();
    let mut sizes: Vec<f64> =
        jacobian.iter().map(|column| norm(column)).map(|size| if size == 0.0 { 1.0 } else { size }).collect();
    let (first, _) = distances(&x, &gradient, bounds, &sizes);
    let begun: Vec<f64> = (0..count).map(|k| x[k] * sizes[k] / first[k].sqrt()).collect();
    let mut radius = Some(norm(&begun)).filter(|radius| *radius > 0.0).unwrap_or(1.0);
    let mut damping = 0.0;
    let ended = loop {
        let slope =
            largest(&(0..count).map(|k| gradient[k] * distance(&x, &gradient, bounds, k).0).collect::<Vec<_>>());
        if slope < TOLERANCE {
            break Ended::Gradient;
        }
        if evaluations >= max_evaluations {
            break Ended::Evaluations;
        }
        let (apart, turns) = distances(&x, &gradient, bounds, &sizes);
        let d: Vec<f64> = (0..count).map(|k| apart[k].sqrt() / sizes[k]).collect();
        let curvature: Vec<f64> = (0..count).map(|k| gradient[k] * turns[k] / sizes[k]).collect();
        let model = Model {
            gradient: (0..count).map(|k| d[k] * gradient[k]).collect(),
            jacobian: jacobian.iter().zip(&d).map(|(column, d)| column.iter().map(|x| x * d).collect()).collect(),
            curvature,
        };
        let factors = svd(&model.with_curvature());
        let theta = (1.0 - slope).max(0.995);
        let (mut fallen, mut done) = (-1.0, None);
        let mut new = (x.clone(), f.clone(), cost);
        while fallen <= 0.0 && evaluations < max_evaluations {
            let hat = region(&factors, &model.gradient, f.len(), radius, &mut damping);
            let (step, hat, predicted) = choose(&model, &x, &d, hat, radius, bounds, theta);
            let moved: Vec<f64> = x.iter().zip(&step).map(|(x, by)| x + by).collect();
            let moved = inside(&moved, bounds, 0.0);
            let residuals = problem.residuals(&moved)?;
            evaluations += 1;
            let length = norm(&hat);
            if residuals.iter().any(|f| !f.is_finite()) {
                radius = 0.25 * length;
                continue;
            }
            let now = loss.cost(&residuals);
            fallen = cost - now;
            let ratio = if predicted > 0.0 { fallen / predicted } else { f64::from(predicted == 0.0 && fallen == 0.0) };
            let narrowed = if ratio < 0.25 {
                0.25 * length
            } else if ratio > 0.75 && length > 0.95 * radius {
                2.0 * radius
            } else {
                radius
            };
            new = (moved, residuals, now);
            let flat = fallen < TOLERANCE * cost && ratio > 0.25;
            let short = norm(&step) < TOLERANCE * (TOLERANCE + norm(&x));
            done = match (flat, short) {
                (true, true) => Some(Ended::CostAndStep),
                (true, false) => Some(Ended::Cost),
                (false, true) => Some(Ended::Step),
                (false, false) => None,
            };
            if done.is_some() {
                break;
            }
            damping *= radius / narrowed;
            radius = narrowed;
        }
        if fallen > 0.0 {
            (x, f, cost) = new;
            if let Some(ended) = done {
                break ended;
            }
            (weighted, jacobian) = (f.clone(), problem.jacobian(&x)?);
            loss.weighted(&mut weighted, &mut jacobian);
            gradient = jacobian.iter().map(|column| dot(column, &weighted)).collect();
            for (size, column) in sizes.iter_mut().zip(&jacobian) {
                *size = size.max(norm(column));
            }
        } else if let Some(ended) = done {
            break ended;
        }
    };
    Ok(Solved { x, residuals: f, cost, evaluations, ended })
}

/// Moves a point into the bounds, by a share of their size (with share 0, by the smallest number) away from them.
fn inside(x: &[f64], (low, high): (&[f64], &[f64]), share: f64) -> Vec<f64> {
    let into = |k: usize, x: f64| {
        let (low, high) = (low[k], high[k]);
        let margin = |bound: f64| if bound.is_finite() { share * bound.abs().max(1.0) } else { 0.0 };
        let moved = if x - low <= margin(low).min(high - x) || x <= low {
            if share == 0.0 { low.next_up() } else { low + margin(low) }
        } else if high - x <= margin(high) || x >= high {
            if share == 0.0 { high.next_down() } else { high - margin(high) }
        } else {
            x
        };
        if moved < low || moved > high { 0.5 * (low + high) } else { moved }
    };
    x.iter().enumerate().map(|(k, x)| into(k, *x)).collect()
}

/// Distance to the bound that the negative gradient points to, and its derivative; 1 and 0 where there is no bound.
fn distance(x: &[f64], gradient: &[f64], (low, high): (&[f64], &[f64]), k: usize) -> (f64, f64) {
    if gradient[k] < 0.0 && high[k].is_finite() {
        (high[k] - x[k], -1.0)
    } else if gradient[k] > 0.0 && low[k].is_finite() {
        (x[k] - low[k], 1.0)
    } else {
        (1.0, 0.0)
    }
}

/// Distances of all parameters, scaled by their sizes.
fn distances(x: &[f64], gradient: &[f64], bounds: (&[f64], &[f64]), sizes: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let scaled = |k: usize| {
        let (apart, turns) = distance(x, gradient, bounds, k);
        (if turns == 0.0 { apart } else { apart * sizes[k] }, turns)
    };
    (0..x.len()).map(scaled).unzip()
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |most, value| value.abs().max(most))
}

/// Quadratic model of the sum of squares about a point, in scaled parameters.
struct Model {
    gradient: Vec<f64>,
    jacobian: Columns,
    /// Contribution of the bounds to the diagonal of the Hessian.
    curvature: Vec<f64>,
}

impl Model {
    /// The Jacobian with the square roots of the curvature below it.
    fn with_curvature(&self) -> Columns {
        let count = self.curvature.len();
        let below = |k: usize| (0..count).map(move |row| if row == k { self.curvature[k].sqrt() } else { 0.0 });
        self.jacobian.iter().enumerate().map(|(k, column)| column.iter().copied().chain(below(k)).collect()).collect()
    }

    /// Coefficients of the model along a line from a point: a t^2 + b t + c.
    fn along(&self, from: &[f64], way: &[f64]) -> [f64; 3] {
        let (at, moved) = (times(&self.jacobian, from), times(&self.jacobian, way));
        let curved = |a: &[f64], b: &[f64]| (0..a.len()).map(|k| a[k] * self.curvature[k] * b[k]).sum::<f64>();
        [
            0.5 * (dot(&moved, &moved) + curved(way, way)),
            dot(&self.gradient, way) + dot(&at, &moved) + curved(from, way),
            0.5 * (dot(&at, &at) + curved(from, from)) + dot(&self.gradient, from),
        ]
    }

    /// Change of the model by a step.
    fn value(&self, step: &[f64]) -> f64 {
        self.along(step, step)[2]
    }
}

/// The model's step within the radius (More 1978). `damping` is the start of the search, and its result.
fn region(factors: &Svd, gradient: &[f64], rows: usize, radius: f64, damping: &mut f64) -> Vec<f64> {
    let (s, v) = (&factors.values, &factors.directions);
    // s u'f; the left singular vectors u themselves are not needed.
    let along: Vec<f64> = v.iter().map(|direction| dot(direction, gradient)).collect();
    let step = |by: &dyn Fn(usize) -> f64| {
        let shares: Vec<f64> = (0..s.len()).map(|k| -along[k] / by(k)).collect();
        times(v, &shares)
    };
    let regular = rows >= s.len() && s[s.len() - 1] > f64::EPSILON * rows as f64 * s[0];
    if regular {
        let whole = step(&|k| s[k] * s[k]);
        if norm(&whole) <= radius {
            *damping = 0.0;
            return whole;
        }
    }
    let beyond = |damping: f64| {
        let parts = || (0..s.len()).map(|k| (along[k], s[k] * s[k] + damping));
        let length = parts().map(|(a, b)| (a / b).powi(2)).sum::<f64>().sqrt();
        (length - radius, -parts().map(|(a, b)| a * a / b.powi(3)).sum::<f64>() / length)
    };
    let mut upper = norm(&along) / radius;
    let mut lower = if regular {
        let (value, slope) = beyond(0.0);
        -value / slope
    } else {
        0.0
    };
    let between = |lower: f64, upper: f64| (0.001 * upper).max((lower * upper).sqrt());
    if !regular && *damping == 0.0 {
        *damping = between(lower, upper);
    }
    for _ in 0..10 {
        if *damping < lower || *damping > upper {
            *damping = between(lower, upper);
        }
        let (value, slope) = beyond(*damping);
        if value < 0.0 {
            upper = *damping;
        }
        let ratio = value / slope;
        lower = lower.max(*damping - ratio);
        *damping -= (value + radius) * ratio / radius;
        if value.abs() < 0.01 * radius {
            break;
        }
    }
    let found = step(&|k| s[k] * s[k] + *damping);
    let length = norm(&found);
    found.iter().map(|x| x * radius / length).collect()
}

/// Returns the best of three steps within bounds and radius: the model's, cut at the bounds; this one reflected at the
/// first bound; steepest descent. Returns the step, the step in scaled parameters, and the decrease of the model.
fn choose(
    model: &Model,
    x: &[f64],
    d: &[f64],
    mut hat: Vec<f64>,
    radius: f64,
    bounds: (&[f64], &[f64]),
    theta: f64,
) -> (Vec<f64>, Vec<f64>, f64) {
    let outer = |hat: &[f64]| -> Vec<f64> { hat.iter().zip(d).map(|(p, d)| p * d).collect() };
    let scaled = |a: &[f64], by: f64| -> Vec<f64> { a.iter().map(|a| a * by).collect() };
    let sum = |a: &[f64], b: &[f64]| -> Vec<f64> { a.iter().zip(b).map(|(a, b)| a + b).collect() };
    let step = outer(&hat);
    let is_inside = (0..x.len()).all(|k| (bounds.0[k]..=bounds.1[k]).contains(&(x[k] + step[k])));
    if is_inside {
        let falls = -model.value(&hat);
        return (step, hat, falls);
    }
    let (stride, hits) = stride(x, &step, bounds);
    let mut turned: Vec<f64> = hat.iter().zip(&hits).map(|(p, hit)| if *hit { -p } else { *p }).collect();
    hat = scaled(&hat, stride);
    let on_bound = sum(x, &scaled(&step, stride));
    let to_radius = to_radius(&hat, &turned, radius);
    let to_bound = self::stride(&on_bound, &outer(&turned), bounds).0;
    let far = to_bound.min(to_radius);
    let (least, most) = if far > 0.0 {
        ((1.0 - theta) * stride / far, if far == to_bound { theta * to_bound } else { to_radius })
    } else {
        (0.0, -1.0)
    };
    let mut reflected = f64::INFINITY;
    if least <= most {
        let (t, value) = lowest(model.along(&hat, &turned), least, most);
        turned = sum(&scaled(&turned, t), &hat);
        reflected = value;
    }
    hat = scaled(&hat, theta);
    let straight = model.value(&hat);
    let mut down = scaled(&model.gradient, -1.0);
    let to_radius = radius / norm(&down);
    let to_bound = self::stride(x, &outer(&down), bounds).0;
    let most = if to_bound < to_radius { theta * to_bound } else { to_radius };
    let [a, b, _] = model.along(&vec![0.0; x.len()], &down);
    let (t, downhill) = lowest([a, b, 0.0], 0.0, most);
    down = scaled(&down, t);
    let (hat, value) = if straight < reflected && straight < downhill {
        (hat, straight)
    } else if reflected < straight && reflected < downhill {
        (turned, reflected)
    } else {
        (down, downhill)
    };
    (outer(&hat), hat, -value)
}

/// Largest multiple of a step within the bounds, and the bounds reached by it.
fn stride(x: &[f64], step: &[f64], (low, high): (&[f64], &[f64])) -> (f64, Vec<bool>) {
    let to = |k: usize| match step[k] {
        0.0 => f64::INFINITY,
        by => ((low[k] - x[k]) / by).max((high[k] - x[k]) / by),
    };
    let all: Vec<f64> = (0..x.len()).map(to).collect();
    let least = all.iter().copied().fold(f64::INFINITY, f64::min);
    let hits = all.iter().zip(step).map(|(far, by)| *far == least && *by != 0.0).collect();
    (least, hits)
}

/// Multiple of `way` from a point within the radius to the radius.
fn to_radius(from: &[f64], way: &[f64], radius: f64) -> f64 {
    let (a, b, c) = (dot(way, way), dot(from, way), dot(from, from) - radius * radius);
    if a == 0.0 {
        return 0.0;
    }
    let root = (b * b - a * c).max(0.0).sqrt();
    let q = -(b + root.copysign(b));
    let (one, other) = (q / a, c / q);
    if one.is_nan() || other.is_nan() { 0.0 } else { one.max(other) }
}

/// Minimum of a parabola between two ends: place and value.
fn lowest([a, b, c]: [f64; 3], low: f64, high: f64) -> (f64, f64) {
    let middle = if a == 0.0 { low } else { -0.5 * b / a };
    let candidates = [low, high, if low < middle && middle < high { middle } else { low }];
    let value = |t: f64| t * (a * t + b) + c;
    candidates
        .into_iter()
        .map(|t| (t, value(t)))
        .fold((low, f64::INFINITY), |best, one| if one.1 < best.1 { one } else { best })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::convert::Infallible;

    struct Problem<F, J>(F, J);

    impl<F: Fn(&[f64]) -> Vec<f64>, J: Fn(&[f64]) -> Columns> LeastSquares for Problem<F, J> {
        type Error = Infallible;

        fn residuals(&mut self, x: &[f64]) -> Result<Vec<f64>, Infallible> {
            Ok(self.0(x))
        }

        fn jacobian(&mut self, x: &[f64]) -> Result<Columns, Infallible> {
            Ok(self.1(x))
        }
    }

    const FREE: ([f64; 2], [f64; 2]) = ([f64::NEG_INFINITY; 2], [f64::INFINITY; 2]);

    fn solved(
        mut problem: Problem<impl Fn(&[f64]) -> Vec<f64>, impl Fn(&[f64]) -> Columns>,
        start: &[f64],
        bounds: (&[f64], &[f64]),
        loss: Loss,
        max_evaluations: usize,
    ) -> Solved {
        solve(&mut problem, start, bounds, loss, max_evaluations).unwrap_or_else(|never| match never {})
    }

    fn rosenbrock(start: [f64; 2], low: [f64; 2], high: [f64; 2], max_evaluations: usize) -> Solved {
        let problem = Problem(
            |x: &[f64]| vec![10.0 * (x[1] - x[0] * x[0]), 1.0 - x[0]],
            |x: &[f64]| vec![vec![-20.0 * x[0], -1.0], vec![10.0, 0.0]],
        );
        solved(problem, &start, (&low, &high), Loss::Linear, max_evaluations)
    }

    fn near(found: &[f64], known: &[f64], tolerance: f64) {
        for (found, known) in found.iter().zip(known) {
            assert!((found - known).abs() <= tolerance * known.abs().max(1e-3), "{found} {known}");
        }
    }

    /// Rosenbrock's valley: its minimum is known, and so is its lowest point on a bound that cuts it off. SciPy 1.17
    /// takes as many evaluations, and ends for the same reason.
    #[test]
    fn rosenbrock_s_valley_with_and_without_bounds() {
        let found = rosenbrock([-2.0, 1.0], FREE.0, FREE.1, 200);
        near(&found.x, &[1.0, 1.0], 1e-9);
        assert_eq!((found.evaluations, found.ended), (20, Ended::Gradient));
        // Up to x = 1/2: the valley is y = x^2, and the cost is (1 - 1/2)^2 / 2.
        let found = rosenbrock([-1.2, 1.0], [-2.0; 2], [0.5, 2.0], 200);
        near(&found.x, &[0.5, 0.25], 1e-8);
        near(&[found.cost], &[0.125], 1e-8);
        assert_eq!((found.evaluations, found.ended), (18, Ended::Cost));
        // From y = 3/2 on: 200 x^3 - 299 x - 1 = 0 (d/dx of half the squares), whose largest root is SciPy's own
        // example.
        for (start, x) in [([2.0, 2.0], 1.224_370_749), ([-2.0, 1.6], -1.221_026_243)] {
            let found = rosenbrock(start, [f64::NEG_INFINITY, 1.5], FREE.1, 200);
            near(&found.x, &[x, 1.5], 1e-8);
            assert_eq!((found.evaluations, found.ended), (9, Ended::Cost));
            let x = found.x[0];
            assert!((200.0 * x.powi(3) - 299.0 * x - 1.0).abs() < 1e-4);
        }
        let cut = rosenbrock([-2.0, 1.0], FREE.0, FREE.1, 3);
        assert_eq!((cut.evaluations, cut.ended), (3, Ended::Evaluations));
        near(&cut.x, &[-1.636_164_717_334_608, 2.394_868_607_531_044], 1e-12);
    }

    /// The monomolecular data Misra1a of NIST's statistical reference data sets: certified to eleven digits, from both
    /// its starts.
    #[test]
    fn misra_s_data() {
        const DATA: [[f64; 2]; 14] = [
            [10.07, 77.6],
            [14.73, 114.9],
            [17.94, 141.1],
            [23.93, 190.8],
            [29.61, 239.9],
            [35.18, 289.0],
            [40.02, 332.8],
            [44.82, 378.4],
            [50.76, 434.8],
            [55.05, 477.3],
            [61.01, 536.8],
            [66.40, 593.1],
            [75.47, 689.1],
            [81.78, 760.0],
        ];
        let problem = || {
            Problem(
                |b: &[f64]| DATA.iter().map(|[y, x]| b[0] * (1.0 - (-b[1] * x).exp()) - y).collect::<Vec<_>>(),
                |b: &[f64]| {
                    let decay = |x: f64| (-b[1] * x).exp();
                    vec![
                        DATA.iter().map(|[_, x]| 1.0 - decay(*x)).collect(),
                        DATA.iter().map(|[_, x]| b[0] * x * decay(*x)).collect(),
                    ]
                },
            )
        };
        for (start, evaluations) in [([500.0, 1e-4], 23), ([250.0, 5e-4], 6)] {
            let found = solved(problem(), &start, (&[0.0, 0.0], &[1000.0, 1.0]), Loss::Linear, 200);
            near(&found.x, &[2.389_421_291_8e2, 5.501_564_318_1e-4], 1e-8);
            near(&[2.0 * found.cost], &[1.245_513_889_4e-1], 1e-10);
            assert_eq!(found.evaluations, evaluations, "as SciPy 1.17");
        }
        // The first parameter ends at its bound, as in SciPy.
        let found = solved(problem(), &[150.0, 5e-4], (&[0.0, 0.0], &[200.0, 1.0]), Loss::Linear, 200);
        near(&found.x, &[200.0, 6.790_593_778e-4], 1e-9);
        near(&[found.cost], &[1.667_222_941], 1e-9);
    }

    /// Two outliers among twelve samples of a decay, 2 + 3 exp(-0.8 t): results and numbers of evaluations as in SciPy
    /// for every loss. Robust losses come near the truth; plain squares do not.
    #[test]
    fn outliers_count_for_less() {
        const OFF: [f64; 12] = [0.1, -0.2, 0.15, 0.05, -0.1, 3.0, 0.12, -0.07, -2.5, 0.03, 0.09, -0.11];
        let known = [
            (Loss::Linear, [0.677_091_893, 4.073_663_027, 0.278_202_728], 315.843_549_354, 12),
            (Loss::SoftL1, [1.957_485_586, 3.086_925_756, 0.754_530_713], 36.889_780_175, 10),
            (Loss::Huber, [1.968_137_451, 3.074_838_277, 0.764_644_684], 38.218_643_564, 22),
            (Loss::Cauchy, [1.993_547_680, 3.088_970_796, 0.790_340_390], 7.688_407_151, 18),
        ];
        for (loss, x, cost, evaluations) in known {
            let problem = Problem(
                |p: &[f64]| {
                    let of = |(k, off): (usize, &f64)| {
                        let t = 0.5 * k as f64;
                        (p[0] + p[1] * (-p[2] * t).exp() - (2.0 + 3.0 * (-0.8 * t).exp() + off)) / 0.15
                    };
                    OFF.iter().enumerate().map(of).collect::<Vec<_>>()
                },
                |p: &[f64]| {
                    let column = |of: &dyn Fn(f64) -> f64| (0..12).map(|k| of(0.5 * k as f64) / 0.15).collect();
                    vec![column(&|_| 1.0), column(&|t| (-p[2] * t).exp()), column(&|t| -p[1] * t * (-p[2] * t).exp())]
                },
            );
            let found = solved(problem, &[1.0; 3], (&[0.0; 3], &[10.0; 3]), loss, 200);
            near(&found.x, &x, 2e-6);
            near(&[found.cost], &[cost], 1e-8);
            assert_eq!(found.evaluations, evaluations, "{loss:?}");
        }
    }

    /// Steps with residuals that are not finite are rejected; an error ends the solution.
    #[test]
    fn what_is_not_finite_is_not_gone_to() {
        let problem =
            Problem(|x: &[f64]| vec![if x[0] > 2.0 { f64::NAN } else { x[0] - 1.9 }], |_: &[f64]| vec![vec![0.2]]);
        let found = solved(problem, &[1.0], (&[-10.0], &[10.0]), Loss::Linear, 200);
        near(&found.x, &[1.9], 1e-3);
        struct Ends;
        impl LeastSquares for Ends {
            type Error = &'static str;
            fn residuals(&mut self, x: &[f64]) -> Result<Vec<f64>, &'static str> {
                if x[0] == 0.5 { Ok(vec![1.0]) } else { Err("interrupted") }
            }
            fn jacobian(&mut self, _: &[f64]) -> Result<Columns, &'static str> {
                Ok(vec![vec![1.0]])
            }
        }
        assert_eq!(solve(&mut Ends, &[0.5], (&[0.0], &[1.0]), Loss::Linear, 9), Err("interrupted"));
    }
}
