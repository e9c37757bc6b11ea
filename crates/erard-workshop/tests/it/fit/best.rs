//! No result is worse than the best point ever played, neither the start nor a point that a solver passed.

use erard_workshop::fit::{
    Columns, DoubtKind, FitResult, FittedChannel, LeastSquares, Solution, Solver, TrustRegion, fit_by,
};

use super::*;

/// Runs another solver and records its points.
struct Recorder {
    inner: TrustRegion,
    points: Vec<Vec<f64>>,
}

struct Recorded<'a>(&'a mut dyn LeastSquares<Error = FitError>, &'a mut Vec<Vec<f64>>);

impl LeastSquares for Recorded<'_> {
    type Error = FitError;

    fn residuals(&mut self, x: &[f64]) -> Result<Vec<f64>, FitError> {
        self.1.push(x.to_vec());
        self.0.residuals(x)
    }

    fn jacobian(&mut self, x: &[f64]) -> Result<Columns, FitError> {
        self.0.jacobian(x)
    }
}

impl Solver for Recorder {
    fn solve(
        &mut self,
        problem: &mut dyn LeastSquares<Error = FitError>,
        from: &[f64],
        bounds: (&[f64], &[f64]),
        loss: Loss,
        max_evaluations: usize,
    ) -> Result<Solution, FitError> {
        self.inner.solve(&mut Recorded(problem, &mut self.points), from, bounds, loss, max_evaluations)
    }
}

/// Passes some points, and always ends at another one.
struct Astray {
    by: Vec<Vec<f64>>,
    end: Vec<f64>,
}

impl Solver for Astray {
    fn solve(
        &mut self,
        problem: &mut dyn LeastSquares<Error = FitError>,
        _: &[f64],
        _: (&[f64], &[f64]),
        _: Loss,
        _: usize,
    ) -> Result<Solution, FitError> {
        for point in &self.by {
            problem.residuals(point)?;
        }
        let residuals = problem.residuals(&self.end)?;
        Ok(Solution::new(self.end.clone(), &residuals, "went astray".to_owned()))
    }
}

/// Negative log-likelihood of points, computed here: independent normal noise of every channel, known or, if unknown,
/// with the deviation that maximises the likelihood.
fn against(problem: &Problem, noise: &NoiseModel, points: &[Vec<f64>]) -> Vec<f64> {
    let all = simulator(problem).residuals(noise, points).unwrap();
    let rows: Vec<usize> = problem.blocks().iter().map(|block| problem.recordings()[block.recording].rows()).collect();
    let of = |residuals: &Vec<f64>| {
        let mut first = 0;
        let mut sum = 0.0;
        for (k, count) in rows.iter().enumerate() {
            let squares: f64 = residuals[first..first + count].iter().map(|x| (x * noise.sigma[k]).powi(2)).sum();
            first += count;
            sum += match noise.known_noise[k] {
                Some(noise) => 0.5 * squares / (noise * noise),
                None => 0.5 * *count as f64 * (squares / *count as f64).ln(),
            };
        }
        sum
    };
    all.iter().map(of).collect()
}

/// In whole fits, with known and unknown noise, from one start and from several: no point that the solver tried,
/// including the start, is better than the result.
fn nothing_is_better(noise_told: &[bool], restarts: usize) {
    let data = [recorded(&varied(&[("body.hammer.mass", 1.05), ("body.key.friction", 0.8)]), "mf", 0, NOISE, 0.0)];
    for &told in noise_told {
        let vary = ["body.hammer.mass", "body.key.friction"];
        let mut asks = asks(&vary);
        if !told {
            asks.sigma.clear();
        }
        asks.plan.restarts = restarts;
        let (problem, mut noise) = problem(&data, &asks).unwrap();
        if !told {
            noise = all_unknown(noise);
        }
        let mut recorder = Recorder { inner: TrustRegion, points: Vec::new() };
        let found = fit_by(&mut simulator(&problem), &noise, &asks.plan, &mut recorder).unwrap();
        assert!(recorder.points.len() > 20, "{}", recorder.points.len());
        let start: Vec<f64> = problem.parameters().iter().map(|one| one.to_solver(1.0)).collect();
        recorder.points.push(start);
        let result = against(&problem, &found.noise, std::slice::from_ref(&found.point))[0];
        let tried = against(&problem, &found.noise, &recorder.points);
        let least = tried.iter().copied().filter(|x| x.is_finite()).fold(f64::INFINITY, f64::min);
        assert!(result <= least + 1e-9 * least.abs(), "{told}: {result} {least}");
        assert!(result < tried[tried.len() - 1], "{told}: {result}");
    }
}

#[test]
fn no_result_is_worse_than_the_best_point_ever_evaluated() {
    nothing_is_better(&[false], 0);
}

#[test]
#[ignore = "ci: a fit whose noise is known, and two from several starts"]
fn nor_with_restarts() {
    nothing_is_better(&[true], 0);
    nothing_is_better(&[true, false], 3);
}

fn astray(data: &[Recording], restarts: usize, by: Vec<Vec<f64>>, end: f64) -> (FitResult, Problem) {
    let mut asks = asks(&["body.hammer.mass"]);
    asks.columns = Some(vec!["hammer_rise_m".to_owned()]);
    asks.sigma = vec![("force_N".to_owned(), 0.0)];
    asks.plan.restarts = restarts;
    let (problem, noise) = problem(data, &asks).unwrap();
    let end = vec![problem.parameters()[0].to_solver(end)];
    let found = fit_by(&mut simulator(&problem), &all_unknown(noise), &asks.plan, &mut Astray { by, end }).unwrap();
    (found, problem)
}

/// A fit that begins 291 um off and whose solver ends 1804 um off ends where it began, with or without restarts,
/// although noise estimated from the residuals makes chi2 1 at both points.
#[test]
fn a_fit_from_291_um_does_not_end_at_1804() {
    let data = [recorded(&varied(&[("body.hammer.mass", 1.0166)]), "mf", 0, NOISE, 0.0)];
    for restarts in [0, 2] {
        let (found, problem) = astray(&data, restarts, Vec::new(), 1.125);
        let channel = &found.channels[0];
        let far = [problem.parameters()[0].to_solver(1.125)];
        let far = simulator(&problem).curves(&found.noise, &far).unwrap();
        let off = |curve: &erard_workshop::fit::Channel| {
            let squares = curve.fitted.iter().zip(&curve.measured).map(|(a, b)| (a - b).powi(2));
            (squares.sum::<f64>() / curve.fitted.len() as f64).sqrt()
        };
        println!("{} {} {}", channel.rms_at_start, channel.rms, off(&far[0]));
        assert!((1700e-6..1900e-6).contains(&off(&far[0])), "the solver's end: {}", off(&far[0]));
        assert!((280e-6..300e-6).contains(&channel.rms_at_start), "{channel:?}");
        assert!(channel.rms <= channel.rms_at_start * (1.0 + 1e-12), "{channel:?}");
        assert!((found.chi2_reduced - 1.0).abs() < 0.01, "{}", found.chi2_reduced);
    }
}

/// A start that is the best point is the result, to the bit.
#[test]
fn the_start_is_a_candidate() {
    let data = [recorded(&file().instrument, "mf", 0, [0.0; 3], 0.0)];
    let (found, problem) = astray(&data, 0, Vec::new(), 1.3);
    assert_eq!(found.point, [problem.parameters()[0].to_solver(1.0)]);
    let [start, end] = [found.channels[0].rms_at_start, found.channels[0].rms];
    assert!((end / start - 1.0).abs() < 1e-12, "{start} {end}");
}

/// A point that a solver only passes is the result if it is the best.
#[test]
fn what_a_solver_passes_by_is_a_candidate() {
    let data = [recorded(&varied(&[("body.hammer.mass", 1.05)]), "mf", 0, NOISE, 0.0)];
    let truth = 1.05_f64.ln();
    let (found, _) = astray(&data, 0, vec![vec![truth], vec![truth + 0.2]], 2.0);
    assert_eq!(found.point, [truth]);
    assert!((found.channels[0].rms / NOISE[2] - 1.0).abs() < 0.2, "{:?}", found.channels[0]);
}

mod nightly {
    use super::*;

    /// Fits from ten starts, up to a factor of two and 0.8 mm of the screw away. Prints the rms residuals of key and
    /// hammer at the start and at the end. A fit that does not find the truth reports a misfit.
    #[test]
    #[ignore = "nightly: ten fits of four parameters, with restarts"]
    fn from_ten_far_starts() {
        let (vary, data) = (names(), both_strokes());
        let mut found_from = 0;
        println!("| start | key um | hammer um | found | doubts |\n|---|---|---|---|---|");
        for seed in 0..10 {
            let mut rng = Rng::with_seed(seed);
            let mut asks = quiet(&vary);
            let start = |name: &&'static str| {
                let away = 2.0 * rng.f64() - 1.0;
                ((*name).to_owned(), if LET_OFF.0.contains(name) { 0.8e-3 * away } else { away.exp2() })
            };
            asks.plan.start = vary.iter().map(start).collect();
            let found = fit(&data, &asks).unwrap();
            // Of both strokes together.
            let rms = |column: &str, of: &dyn Fn(&FittedChannel) -> f64| {
                let squares: Vec<f64> = found
                    .channels
                    .iter()
                    .filter(|one| one.title.starts_with(column))
                    .map(|one| of(one).powi(2))
                    .collect();
                (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
            };
            let [key, hammer] = ["key_m", "hammer_rise_m"]
                .map(|column| [rms(column, &|one| one.rms_at_start), rms(column, &|one| one.rms)]);
            let is_true =
                TRUE.iter().zip(&found.x).zip(&found.std).all(|(((_, truth), x), std)| (x - truth).abs() < 4.0 * std);
            let doubts: Vec<&str> = found.doubts.iter().map(|doubt| doubt.kind.name()).collect();
            let starts = asks.plan.start.iter().map(|(name, x)| match LET_OFF.0.contains(&name.as_str()) {
                true => format!("{:.2} mm", 1e3 * x),
                false => format!("{x:.3}"),
            });
            let starts: Vec<String> = starts.collect();
            println!(
                "| {} | {:.0} to {:.1} | {:.0} to {:.1} | {is_true} | {} |",
                starts.join(", "),
                1e6 * key[0],
                1e6 * key[1],
                1e6 * hammer[0],
                1e6 * hammer[1],
                doubts.join(", ")
            );
            assert!(is_true || found.doubts.iter().any(|doubt| doubt.kind == DoubtKind::Misfit), "{found:?}");
            assert!(!is_true || (key[1] < 1.1 * NOISE[1] && hammer[1] < 1.1 * NOISE[2]), "{key:?} {hammer:?}");
            found_from += usize::from(is_true);
        }
        assert!(found_from >= 9, "{found_from} of 10");
    }
}
