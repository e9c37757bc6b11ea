//! Every kind of doubt about a fit is reported, and a good fit has none.

use erard_workshop::fit::{DoubtKind, LeastSquares, Solution, Solver, fit_by};

use super::*;

fn kinds(found: &FitResult) -> Vec<DoubtKind> {
    let mut kinds: Vec<DoubtKind> = found.doubts.iter().map(|doubt| doubt.kind).collect();
    kinds.dedup();
    kinds
}

/// The recording up to 3 ms after the first impact.
fn until_the_impact(mut recording: Recording) -> Recording {
    let hammer = &recording.channels[2].values;
    let highest = hammer.iter().fold(0.0, |most: f64, x| most.max(*x));
    let rows = hammer.iter().position(|x| *x == highest).unwrap() + 12;
    recording.time_s.truncate(rows);
    recording.channels.iter_mut().for_each(|channel| channel.values.truncate(rows));
    recording
}

fn heavier_until_the_impact() -> Recording {
    let [whole] = heavier();
    until_the_impact(whole)
}

fn said(found: &FitResult, kind: DoubtKind) -> &str {
    let doubt = found.doubts.iter().find(|doubt| doubt.kind == kind);
    doubt.map(|doubt| doubt.text.as_str()).unwrap_or_else(|| panic!("{kind:?} is not among {:?}", found.doubts))
}

/// The model that made the data, known noise, and data up to the impact: nothing is doubtful.
#[test]
fn a_good_fit_has_none() {
    let found = fit(&[heavier_until_the_impact()], &quiet(&["body.hammer.mass"])).unwrap();
    assert_eq!(found.doubts, []);
    assert!((found.x[0] - 1.05).abs() < 4.0 * found.std[0], "{} {}", found.x[0], found.std[0]);
}

/// The recorded grand has a capstan felt half as stiff, and only the hammer's mass is fitted.
#[test]
fn misfit_beyond_the_noise() {
    let other = varied(&[("zone.capstan_heel.stiffness", 0.5)]);
    let data = until_the_impact(recorded(&other, "mf", 0, NOISE, 0.0));
    let mut asks = quiet(&["body.hammer.mass"]);
    asks.plan.restarts = 0;
    let found = fit(&[data], &asks).unwrap();
    assert_eq!(kinds(&found)[0], DoubtKind::Misfit, "{:?}", found.doubts);
    let text = said(&found, DoubtKind::Misfit);
    assert!(text.starts_with("key_m differs from the model by ") && text.contains("um rms; its noise exp"), "{text}");
}

/// A hammer whose mass is outside the bounds.
#[test]
fn a_parameter_at_its_bound() {
    let mut asks = quiet(&["body.hammer.mass"]);
    asks.bounds = vec![("body.hammer.mass".to_owned(), [0.5, 1.03])];
    asks.plan.restarts = 0;
    let found = fit(&[heavier_until_the_impact()], &asks).unwrap();
    assert_eq!(said(&found, DoubtKind::Bound), "body.hammer.mass ended at its upper bound");
}

/// Bounds that allow only hammers too heavy for this touch, while the recorded one reached the string.
#[test]
fn a_hammer_that_never_reaches_the_string() {
    let data = until_the_impact(recorded(&file().instrument, "mf", 0, NOISE, 0.0));
    let mut asks = quiet(&["body.hammer.mass"]);
    asks.bounds = vec![("body.hammer.mass".to_owned(), [8.0, 12.0])];
    asks.plan = Plan { start: vec![("body.hammer.mass".to_owned(), 10.0)], restarts: 0, ..Plan::default() };
    let found = fit(&[data], &asks).unwrap();
    assert_eq!(kinds(&found)[0], DoubtKind::NoImpact, "{:?}", found.doubts);
    assert!(said(&found, DoubtKind::NoImpact).contains("in the fitted model it never does"));
}

/// A solver that stays at its start.
struct Idle;

impl Solver for Idle {
    fn solve(
        &mut self,
        problem: &mut dyn LeastSquares<Error = FitError>,
        from: &[f64],
        _: (&[f64], &[f64]),
        _: Loss,
        _: usize,
    ) -> Result<Solution, FitError> {
        Ok(Solution::new(from.to_vec(), &problem.residuals(from)?, "did nothing".to_owned()))
    }
}

/// A solver that stays at its start ends at as many points as it has starts.
#[test]
fn restarts_that_disagree() {
    let asks = quiet(&["body.hammer.mass"]);
    let (problem, noise) = problem(&[heavier_until_the_impact()], &asks).unwrap();
    let found = fit_by(&mut simulator(&problem), &noise, &asks.plan, &mut Idle).unwrap();
    let text = said(&found, DoubtKind::Restarts);
    assert!(text.starts_with("6 starts led to different results"), "{text}");
}

/// Data beyond the impact: following the advice removes the doubt.
#[test]
fn data_beyond_the_impact() {
    let [whole] = heavier();
    let mut asks = quiet(&["body.hammer.mass"]);
    asks.plan.restarts = 0;
    let found = fit(std::slice::from_ref(&whole), &asks).unwrap();
    let text = said(&found, DoubtKind::BeyondImpact).to_owned();
    let (_, advice) = text.split_once("fit only its first ").unwrap();
    let seconds: f64 = advice.trim_end_matches(" s").parse().unwrap();
    let rows = whole.time_s.partition_point(|t| *t <= whole.time_s[0] + seconds);
    let mut short = whole;
    short.time_s.truncate(rows);
    short.channels.iter_mut().for_each(|channel| channel.values.truncate(rows));
    let found = fit(&[short], &asks).unwrap();
    assert_eq!(found.doubts, []);
    assert!((found.x[0] - 1.05).abs() < 4.0 * found.std[0], "{} {}", found.x[0], found.std[0]);
}

/// At 1 kHz the noise of the force cannot be read, nor that of the key from data without noise.
#[test]
fn noise_that_is_not_known() {
    let mut coarse = heavier_until_the_impact();
    coarse.time_s = coarse.time_s.into_iter().step_by(4).collect();
    for channel in &mut coarse.channels {
        channel.values = std::mem::take(&mut channel.values).into_iter().step_by(4).collect();
    }
    let smooth = until_the_impact(recorded(&varied(&[("body.hammer.mass", 1.05)]), "mf", 0, [0.0; 3], 0.0));
    for (data, text) in [
        (coarse, "the noise of force_N, which drives the model, is unknown and taken as zero"),
        (smooth, "the noise of key_m is unknown and estimated from the residuals"),
    ] {
        let mut asks = asks(&["body.hammer.mass"]);
        asks.sigma.clear();
        asks.plan.restarts = 0;
        let found = fit(&[data], &asks).unwrap();
        let said = said(&found, DoubtKind::NoiseUnknown);
        assert!(said.starts_with(text), "{said}");
        assert_eq!(found.chi2().is_none(), text.contains("estimated"));
    }
}

/// If noise is estimated from the residuals, chi2 is 1 and shows no misfit, but residuals that are not noise are
/// correlated: those of noise-free data made with shorter steps, in which a friction with hardly any effect would be
/// many of its errors off. White noise is not correlated.
#[test]
fn misfit_that_passes_for_noise() {
    let other = varied(&[("body.key.friction", 0.7)]);
    let (stroke, _) = Stroke::curve("p", Touch::Pressed, None).unwrap().unwrap();
    let inputs = stroke.inputs(&other.finger).unwrap();
    let setup = Setup { record_every: Some(1), settings: Settings::new(5e-6), ..Setup::new(0.06) };
    let run = simulate(&other, inputs.as_ref(), &setup, &mut |_| true).unwrap();
    let table = |noise: [f64; 2]| {
        let mut rng = Rng::with_seed(3);
        let mut text = String::from("time_s,force_N,key_m,hammer_rise_m\n");
        for row in (0..run.time_s.len()).step_by(50) {
            let [key, hammer] = noise.map(|sigma| sigma * normal(&mut rng));
            let (key, hammer) = (run.key_m[row] + key, run.hammer_rise_m[row] + hammer);
            text += &format!("{},{},{key},{hammer}\n", run.time_s[row], run.force_n[row]);
        }
        Recording::read(text.as_bytes(), "synthetic", &Columns::default()).unwrap()
    };
    for (noise, is_noise) in [([0.0, 0.0], false), ([NOISE[1], NOISE[2]], true)] {
        let mut asks = quiet(&["body.key.friction"]);
        asks.sigma = vec![("force_N".to_owned(), 0.0)];
        asks.plan.restarts = 0;
        let (problem, noise) = problem(&[table(noise)], &asks).unwrap();
        let found = erard_workshop::fit::fit(&mut simulator(&problem), &all_unknown(noise), &asks.plan).unwrap();
        println!("{:?} {:?} {:?}", found.x, found.std, found.doubts);
        let follows = found.doubts.iter().any(|doubt| doubt.text.contains("are correlated"));
        assert_eq!(follows, !is_noise, "{:?}", found.doubts);
    }
}
