//! Share of fits with the truth inside the reported errors: over synthetic recordings of grands drawn up to 20 % away
//! from the start of the fit, for sets of one to four parameters, with known noise, noise estimated from the residuals,
//! and a load cell's noise on the drive, which is read from the recording.

use erard_workshop::fit::DoubtKind;

use super::*;

/// Sets: each has one parameter more than the one before.
const NAMES: [&str; 4] = ["body.hammer.mass", "zone.capstan_heel.stiffness", "body.key.friction", "let_off"];
/// Shares of a normal number within one and two standard deviations.
const SHARES: [f64; 2] = [0.6827, 0.9545];

/// Results for one parameter of one set: number of fits, and those with the truth within one and two errors.
#[derive(Debug, Default, Clone, Copy)]
struct Hits {
    fits: usize,
    within: [usize; 2],
}

/// Knowledge of the noise in the fit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Known {
    /// All noise is known; the drive has none.
    Told,
    /// No noise is known; the drive has none.
    Residuals,
    /// The noise of the compared channels. The driving force has noise, too; the fit estimates it from the recording.
    Drive,
}

/// A load cell's noise, N.
const LOAD_CELL: f64 = 0.02;

/// A stroke at mf of a grand, until 3 ms after the impact, as recorded by sensors.
fn short(instrument: &Instrument, seed: u64, step_s: f64, force_noise_n: f64) -> Recording {
    let (stroke, _) = Stroke::curve("mf", Touch::Pressed, None).unwrap().unwrap();
    let inputs = stroke.inputs(&instrument.finger).unwrap();
    let setup = Setup { record_every: Some(1), settings: Settings::new(step_s), ..Setup::new(0.12) };
    let run = simulate(instrument, inputs.as_ref(), &setup, &mut |_| true).unwrap();
    let end_s = run.events.hammer_contact_s().expect("it reaches the string") + 3e-3;
    let mut rng = Rng::with_seed(seed);
    let mut text = String::from("time_s,force_N,key_m,hammer_rise_m\n");
    for row in (0..run.time_s.len()).step_by((250e-6 / step_s).round() as usize) {
        if run.time_s[row] > end_s {
            break;
        }
        let [key, hammer] = [NOISE[1], NOISE[2]].map(|sigma| sigma * normal(&mut rng));
        let (key, hammer) = (run.key_m[row] + key, run.hammer_rise_m[row] + hammer);
        let force = if force_noise_n > 0.0 { force_noise_n * normal(&mut rng) } else { 0.0 };
        text += &format!("{},{},{key},{hammer}\n", run.time_s[row], run.force_n[row] + force);
    }
    Recording::read(text.as_bytes(), "synthetic", &Columns::default()).unwrap()
}

/// Draws a grand up to 20 % away: factors, and up to a fifth of a millimetre for the screw.
fn drawn(names: &[&'static str], rng: &mut Rng) -> Vec<(&'static str, f64)> {
    let of = |name: &&'static str| {
        let away = 0.2 * (2.0 * rng.f64() - 1.0);
        (*name, if *name == "let_off" { 1e-3 * away } else { 1.0 + away })
    };
    names.iter().map(of).collect()
}

/// Fits `each` recordings of every set; returns the hits by set and parameter.
fn covered(each: usize, known: Known) -> Vec<(usize, &'static str, Hits)> {
    let mut all = Vec::new();
    for count in 1..=NAMES.len() {
        let names = &NAMES[..count];
        let mut hits = vec![Hits::default(); count];
        for seed in 0..each as u64 {
            let seed = 10_000 * count as u64 + 2 * seed + u64::from(known == Known::Told);
            let truth = drawn(names, &mut Rng::with_seed(!seed));
            let (mut asks, noise_n) =
                if known == Known::Drive { (asks(names), LOAD_CELL) } else { (quiet(names), 0.0) };
            asks.plan.restarts = 0;
            let (problem, mut noise) = problem(&[short(&varied(&truth), seed, 50e-6, noise_n)], &asks).unwrap();
            if known == Known::Residuals {
                noise = all_unknown(noise);
            }
            let found = erard_workshop::fit::fit(&mut simulator(&problem), &noise, &asks.plan).unwrap();
            for (k, (_, truth)) in truth.iter().enumerate() {
                let off = (found.x[k] - truth).abs() / found.std[k];
                hits[k].fits += 1;
                for (within, errors) in hits[k].within.iter_mut().zip([1.0, 2.0]) {
                    *within += usize::from(off <= errors);
                }
            }
        }
        all.extend(names.iter().zip(hits).map(|(name, hits)| (count, *name, hits)));
    }
    for (count, name, Hits { fits, within }) in &all {
        let share = within.map(|n| 100.0 * n as f64 / *fits as f64);
        println!("{known:?}, {count} free, {name}: {:.1} % and {:.1} % of {fits}", share[0], share[1]);
    }
    all
}

/// Over all cases together the counts are those of normal errors: a binomial test at 1 %. Parameters of one fit depend
/// on each other, which makes the counts scatter more than the test allows for.
fn as_often_as_it_should(kinds: [(Known, usize); 3]) {
    let all = std::thread::scope(|scope| {
        kinds.map(|(known, each)| scope.spawn(move || covered(each, known))).map(|cases| cases.join().unwrap()).concat()
    });
    let fits: usize = all.iter().map(|(.., hits)| hits.fits).sum();
    for (k, share) in SHARES.into_iter().enumerate() {
        let within: usize = all.iter().map(|(.., hits)| hits.within[k]).sum();
        let (expected, scatter) = (share * fits as f64, (fits as f64 * share * (1.0 - share)).sqrt());
        println!("{within} of {fits}, {expected:.1} +- {scatter:.1} expected");
        assert!(
            (within as f64 - expected).abs() < 2.576 * scatter,
            "{within} of {fits}, {expected:.1} +- {scatter:.1}"
        );
    }
}

#[test]
#[ignore = "ci: 68 fits of one to four parameters"]
fn the_truth_lies_within_the_errors_as_often_as_it_should() {
    as_often_as_it_should([(Known::Told, 8), (Known::Residuals, 8), (Known::Drive, 1)]);
}

/// Data made with a tenth of the step are fitted without doubts, from 20 % away.
#[test]
fn data_of_shorter_steps_have_no_doubts() {
    let truth = [("body.hammer.mass", 1.2)];
    let found = fit(&[short(&varied(&truth), 3, 5e-6, 0.0)], &quiet(&["body.hammer.mass"])).unwrap();
    assert_eq!(found.doubts, []);
    assert!((found.x[0] - 1.2).abs() < 4.0 * found.std[0], "{} +- {}", found.x[0], found.std[0]);
}

/// Data of another model with flexible key and shank, fitted by rigid bodies: no coverage is claimed, and the misfit is
/// reported. Returns the number of fits that report it.
fn reported(seeds: std::ops::Range<u64>) -> usize {
    let mut reported = 0;
    for seed in seeds {
        let mut other = Instrument::builtin("concert-grand").unwrap();
        let all = Parameter::all(&other);
        for (name, by) in drawn(&NAMES[..2], &mut Rng::with_seed(seed)) {
            let (_, parameter) = all.iter().find(|(known, _)| known == name).unwrap();
            parameter.vary(&mut other, by).unwrap();
        }
        let mut asks = quiet(&NAMES[..2]);
        asks.plan.restarts = 0;
        let found = fit(&[short(&other, seed, 50e-6, 0.0)], &asks).unwrap();
        reported += usize::from(found.doubts.iter().any(|doubt| doubt.kind == DoubtKind::Misfit));
    }
    reported
}

#[test]
#[ignore = "ci: 4 fits to data of another model"]
fn misfit_of_another_model_is_reported() {
    assert_eq!(reported(0..4), 4);
}

mod nightly {
    use super::*;

    #[test]
    #[ignore = "nightly: 208 fits of one to four parameters"]
    fn the_truth_lies_within_the_errors_of_more_fits() {
        as_often_as_it_should([(Known::Told, 25), (Known::Residuals, 25), (Known::Drive, 2)]);
    }

    #[test]
    #[ignore = "nightly: 20 fits to data of another model"]
    fn misfit_of_another_model_is_reported_in_95_per_cent() {
        let reported = reported(0..20);
        assert!(reported >= 19, "{reported} of 20");
    }

    /// 1600 recordings, 400 of each set: by parameter, over the sets that contain it, within 4 points of 68 % and 2.5
    /// points of 95 %. `ERARD_COVERAGE` requests fewer recordings of each set; then three times the scatter of the
    /// counts is allowed if that is more.
    fn by_parameter(known: Known) {
        const EACH: usize = 400;
        let asked = std::env::var("ERARD_COVERAGE").ok();
        let each = asked.map_or(EACH, |each| each.parse().expect("ERARD_COVERAGE is a number of recordings"));
        let (all, mut beyond) = (covered(each, known), Vec::new());
        for name in NAMES {
            let own = || all.iter().filter(|(_, of, _)| *of == name).map(|(.., hits)| hits);
            let fits: usize = own().map(|hits| hits.fits).sum();
            for (k, (share, points)) in SHARES.into_iter().zip([0.04, 0.025]).enumerate() {
                let found = own().map(|hits| hits.within[k]).sum::<usize>() as f64 / fits as f64;
                let scatter = (share * (1.0 - share) / fits as f64).sqrt();
                let most = if each < EACH { f64::max(points, 3.0 * scatter) } else { points };
                println!("{known:?}, {name}: {:.1} % of {fits} within {} errors", 100.0 * found, k + 1);
                if (found - share).abs() >= most {
                    beyond.push(format!("{known:?}, {name}: {found:.3} of {fits}, {share} expected"));
                }
            }
        }
        assert!(beyond.is_empty(), "{beyond:#?}");
    }

    #[test]
    #[ignore = "nightly: 1600 fits"]
    fn coverage_by_parameter_with_known_noise() {
        by_parameter(Known::Told);
    }

    #[test]
    #[ignore = "nightly: 1600 fits"]
    fn coverage_by_parameter_with_unknown_noise() {
        by_parameter(Known::Residuals);
    }

    #[test]
    #[ignore = "nightly: 1600 fits that propagate the noise of the drive"]
    fn coverage_by_parameter_with_a_noisy_drive() {
        by_parameter(Known::Drive);
    }
}
