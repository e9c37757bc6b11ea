//! Errors under noise that is correlated in time: 95 % intervals by correlation time, length of the recordings and
//! whether the noise is given; their lengths beside those of generalised least squares with the true covariance; and
//! recordings too short for any error.

use erard_workshop::fit::DoubtKind;

use super::*;

/// Correlation times, s: white, and what filters, integrators and drifts make.
const TIMES_S: [f64; 4] = [0.0, 0.4e-3, 2.4e-3, 12e-3];
/// Lengths of the two recordings, p and f, s.
const LENGTHS_S: [f64; 2] = [62e-3, 0.12];
/// Samples per second.
const RATE_HZ: f64 = 4000.0;
/// The 95 % point of the chi-squared distribution with four degrees of freedom.
const JOINT_95: f64 = 9.4877;
/// Independent parameters that the four are worth: they depend on each other.
const INDEPENDENT: f64 = 2.7;
/// Largest median length of an interval, over that of generalised least squares with the true covariance.
const LONGEST: f64 = 1.5;

/// One cell: noise, recordings, knowledge.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Cell {
    time_s: f64,
    length_s: f64,
    is_given: bool,
}

impl Cell {
    /// How far the logarithm of the number of independent samples lies above that of ten a parameter, in deviations of
    /// its estimate: the logarithm of a correlation time scatters as the correlation from sample to sample does, by
    /// sqrt((1 - rho^2) / n) of n samples (Bartlett, J. R. Stat. Soc. Suppl. 8 (1946)), and two columns are estimated.
    fn margin(&self) -> f64 {
        let samples = 4.0 * self.length_s * RATE_HZ;
        if self.time_s == 0.0 {
            return f64::INFINITY;
        }
        let own = (-1.0 / (RATE_HZ * self.time_s)).exp();
        let independent = samples * (1.0 - own) / (1.0 + own);
        let scatter = ((1.0 - own * own) / (samples / 2.0)).sqrt() / (own * -own.ln()) / 2.0_f64.sqrt();
        (independent / (10.0 * TRUE.len() as f64)).ln() / scatter
    }
}

/// Counts of one cell.
#[derive(Debug, Default)]
struct Counts {
    fits: usize,
    refused: usize,
    within: [usize; 4],
    joint: usize,
    /// Half widths of the intervals over those of generalised least squares.
    lengths: [Vec<f64>; 4],
    pulls: [Vec<f64>; 4],
}

/// The strokes p and f on the true grand without noise: time, force, key, hammer.
fn clean(length_s: f64) -> [Vec<[f64; 4]>; 2] {
    let truth = varied(&TRUE);
    ["p", "f"].map(|nuance| {
        let (stroke, _) = Stroke::curve(nuance, Touch::Pressed, None).unwrap().unwrap();
        let inputs = stroke.inputs(&truth.finger).unwrap();
        let setup = Setup { record_every: Some(1), ..Setup::new(length_s) };
        let run = simulate(&truth, inputs.as_ref(), &setup, &mut |_| true).unwrap();
        let end_s = run.events.hammer_contact_s().map_or(length_s, |s| s + 3e-3);
        let rows = (0..run.time_s.len()).step_by(5).filter(|row| run.time_s[*row] <= end_s);
        rows.map(|row| [run.time_s[row], run.force_n[row], run.key_m[row], run.hammer_rise_m[row]]).collect()
    })
}

/// Noise of a process whose correlation falls as exp(-t / time_s).
fn noise(rows: usize, sigma: f64, time_s: f64, rng: &mut Rng) -> Vec<f64> {
    let own = if time_s > 0.0 { (-1.0 / (RATE_HZ * time_s)).exp() } else { 0.0 };
    let mut last = normal(rng);
    let mut next = |n: usize| {
        if n > 0 {
            last = own * last + (1.0 - own * own).sqrt() * normal(rng);
        }
        sigma * last
    };
    (0..rows).map(&mut next).collect()
}

/// The strokes as noisy sensors see them.
fn noisy(clean: &[Vec<[f64; 4]>; 2], time_s: f64, seed: u64) -> [Recording; 2] {
    let mut rng = Rng::with_seed(seed);
    clean.each_ref().map(|rows| {
        let [key, hammer] = [NOISE[1], NOISE[2]].map(|sigma| noise(rows.len(), sigma, time_s, &mut rng));
        let mut text = String::from("time_s,force_N,key_m,hammer_rise_m\n");
        for ([time, force, key_m, hammer_m], (key, hammer)) in rows.iter().zip(key.iter().zip(&hammer)) {
            text += &format!("{time},{force},{},{}\n", key_m + key, hammer_m + hammer);
        }
        Recording::read(text.as_bytes(), "synthetic", &Columns::default()).unwrap()
    })
}

/// Inverse of a symmetric positive definite matrix, by Gauss and Jordan.
fn inverse(matrix: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let n = matrix.len();
    let mut rows: Vec<Vec<f64>> =
        (0..n).map(|i| matrix[i].iter().copied().chain((0..n).map(|j| f64::from(i == j))).collect()).collect();
    for i in 0..n {
        let pivot = rows[i][i];
        rows[i].iter_mut().for_each(|x| *x /= pivot);
        let own = rows[i].clone();
        for (_, row) in rows.iter_mut().enumerate().filter(|(k, _)| *k != i) {
            let by = row[i];
            row.iter_mut().zip(&own).for_each(|(x, y)| *x -= by * y);
        }
    }
    rows.into_iter().map(|row| row[n..].to_vec()).collect()
}

/// Half widths of the 95 % intervals of generalised least squares with the true covariance, as in `FitResult::x`.
fn best_half_widths(clean: &[Vec<[f64; 4]>; 2], time_s: f64) -> Vec<f64> {
    let names = names();
    let (problem, mut noise) = problem(&noisy(clean, time_s, 0), &quiet(&names)).unwrap();
    noise.correlation_time_s.fill(time_s);
    let truth: Vec<f64> = problem.parameters().iter().zip(TRUE).map(|(one, (_, x))| one.to_solver(x)).collect();
    let columns = by_differences(&mut simulator(&problem), &noise, None, &truth, DIFFERENCES[1]).unwrap();
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let normal: Vec<Vec<f64>> = columns.iter().map(|a| columns.iter().map(|b| product(a, b)).collect()).collect();
    let covariance = inverse(&normal);
    (0..TRUE.len())
        .map(|k| {
            let slope = if TRUE[k].0 == "let_off" { 1e-3 } else { TRUE[k].1 };
            1.96 * slope * covariance[k][k].sqrt()
        })
        .collect()
}

/// Fits `count` recordings of a cell.
fn counted(cell: Cell, seeds: std::ops::Range<u64>) -> Counts {
    let (clean, names) = (clean(cell.length_s), names());
    let best = best_half_widths(&clean, cell.time_s);
    let mut counts = Counts::default();
    for seed in seeds {
        let mut asks = quiet(&names);
        asks.plan.restarts = 0;
        let (problem, mut noise) = problem(&noisy(&clean, cell.time_s, seed), &asks).unwrap();
        if !cell.is_given {
            noise = all_unknown(noise);
        }
        let found = erard_workshop::fit::fit(&mut simulator(&problem), &noise, &asks.plan).unwrap();
        counts.fits += 1;
        if !found.has_errors() {
            counts.refused += 1;
            let doubt = found.doubts.iter().find(|doubt| doubt.kind == DoubtKind::TooShort).unwrap();
            assert!(doubt.text.contains(" s of recording would do"), "{}", doubt.text);
            continue;
        }
        let off: Vec<f64> = found.x.iter().zip(TRUE).map(|(x, (_, truth))| x - truth).collect();
        for k in 0..off.len() {
            counts.within[k] += usize::from(off[k].abs() <= found.half_width_95[k]);
            counts.lengths[k].push(found.half_width_95[k] / best[k]);
            counts.pulls[k].push(off[k] / found.std[k]);
        }
        let inverse = inverse(&found.cov);
        let square: f64 = (0..off.len())
            .flat_map(|i| (0..off.len()).map(move |j| (i, j)))
            .map(|(i, j)| off[i] * inverse[i][j] * off[j])
            .sum();
        counts.joint += usize::from(square <= JOINT_95);
    }
    counts
}

fn median(values: &[f64]) -> f64 {
    let mut values = values.to_vec();
    values.sort_unstable_by(f64::total_cmp);
    values[values.len() / 2]
}

/// What is wrong with a cell, whose counts are printed, and the shares of its intervals that hold the truth. With
/// errors in it, its intervals hold as often as they should, within `deviations` of the binomial distribution, and are
/// no longer than they may; without, its fits refuse an error. Within three deviations of the limit the estimate
/// decides, and most fits are on the right side of it; elsewhere all are.
fn wrong(cell: Cell, seeds: std::ops::Range<u64>, deviations: f64) -> (Vec<String>, Vec<f64>) {
    let counts = counted(cell, seeds);
    let answered = counts.fits - counts.refused;
    // One text, because cells are counted beside one another.
    let mut text = format!("{cell:?}: {} fits, {} without errors\n", counts.fits, counts.refused);
    let (mut wrong, mut shares) = (Vec::new(), Vec::new());
    let margin = cell.margin();
    let odd = if margin > 0.0 { counts.refused } else { answered };
    if odd > if margin.abs() > 3.0 { 0 } else { counts.fits / 2 } {
        wrong.push(format!("{cell:?}: {odd} of {} on the other side of the limit", counts.fits));
    }
    if margin < 0.0 {
        print!("{text}");
        return (wrong, shares);
    }
    let scatter = (0.95 * 0.05 / answered as f64).sqrt();
    for (k, (name, _)) in TRUE.iter().enumerate() {
        let share = counts.within[k] as f64 / answered as f64;
        shares.push(share);
        let length = median(&counts.lengths[k]);
        let rms = (counts.pulls[k].iter().map(|x| x * x).sum::<f64>() / answered as f64).sqrt();
        text += &format!("  {name}: {:.1} % within, length {length:.2}, pulls {rms:.2} rms\n", 100.0 * share);
        if (share - 0.95).abs() > deviations * scatter || length > LONGEST {
            wrong.push(format!("{cell:?}, {name}: {share:.3}, {length:.2}"));
        }
    }
    println!("{text}  all four: {:.1} % within", 100.0 * counts.joint as f64 / answered as f64);
    (wrong, shares)
}

/// Nothing is wrong with a cell.
fn check(cell: Cell, seeds: std::ops::Range<u64>, deviations: f64) {
    let (wrong, _) = wrong(cell, seeds, deviations);
    assert!(wrong.is_empty(), "{wrong:#?}");
}

fn cells() -> impl Iterator<Item = Cell> {
    let all = TIMES_S.into_iter().flat_map(|time_s| LENGTHS_S.into_iter().map(move |length_s| (time_s, length_s)));
    all.flat_map(|(time_s, length_s)| [true, false].map(|is_given| Cell { time_s, length_s, is_given }))
}

/// Twelve fits without correlation, and as many with it: the correlation is estimated where it is, and only there.
#[test]
fn correlation_is_found_where_it_is() {
    let (clean, names) = (clean(0.12), names());
    for (time_s, found_s) in [(0.0, 0.0..1e-9), (2.4e-3, 1.2e-3..4.8e-3)] {
        for seed in 0..3 {
            let mut asks = quiet(&names);
            asks.plan.restarts = 0;
            let found = fit(&noisy(&clean, time_s, seed), &asks).unwrap();
            for channel in &found.channels {
                let own_s = channel.correlation_time_s;
                assert!(found_s.contains(&own_s), "{time_s}, {seed}, {}: {own_s}", channel.title);
            }
            assert!(found.doubts.is_empty(), "{time_s}, {seed}: {:?}", found.doubts);
            assert!((0.8..1.25).contains(&found.chi2_reduced), "{time_s}, {seed}: {}", found.chi2_reduced);
        }
    }
}

/// What 62 ms of white noise do to a fit is linear: the fit is one step of Gauss and Newton from the truth, to a tenth
/// of a standard deviation, and without noise it is the truth. So drive, start, curvature and the window's end bias
/// nothing, and pulls of a few recordings that are 1.3 or 1.4 rms are chance: the four parameters depend on each other,
/// as [`INDEPENDENT`] ones would, so that over ten recordings the rms of their pulls scatters by 0.14.
#[test]
fn fits_of_62_ms_are_linear_and_unbiased() {
    let (clean, names) = (clean(62e-3), names());
    for seed in 0..3 {
        let mut asks = quiet(&names);
        asks.plan.restarts = 0;
        let recordings = match seed {
            0 => clean.each_ref().map(|rows| {
                let rows = rows.iter().map(|[time, force, key, hammer]| format!("{time},{force},{key},{hammer}\n"));
                let text = format!("time_s,force_N,key_m,hammer_rise_m\n{}", rows.collect::<String>());
                Recording::read(text.as_bytes(), "synthetic", &Columns::default()).unwrap()
            }),
            _ => noisy(&clean, 0.0, seed),
        };
        let (problem, noise) = problem(&recordings, &asks).unwrap();
        let mut simulator = simulator(&problem);
        let found = erard_workshop::fit::fit(&mut simulator, &noise, &asks.plan).unwrap();
        let truth: Vec<f64> = problem.parameters().iter().zip(TRUE).map(|(one, (_, x))| one.to_solver(x)).collect();
        let columns = by_differences(&mut simulator, &noise, None, &truth, DIFFERENCES[1]).unwrap();
        let residuals = simulator.residuals(&noise, std::slice::from_ref(&truth)).unwrap().remove(0);
        let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let normal: Vec<Vec<f64>> = columns.iter().map(|a| columns.iter().map(|b| product(a, b)).collect()).collect();
        let covariance = inverse(&normal);
        for k in 0..TRUE.len() {
            let std = covariance[k][k].sqrt();
            let step: f64 = (0..TRUE.len()).map(|j| -covariance[k][j] * product(&columns[j], &residuals)).sum();
            let moved = found.point[k] - truth[k];
            assert!((moved - step).abs() < 0.1 * std, "{seed}, {}: {moved} {step} {std}", names[k]);
            assert!(seed > 0 || moved.abs() < 0.02 * std, "{}: {moved} {std}", names[k]);
        }
    }
}

/// An estimate of the friction two deviations below the truth. The slopes there promise smaller errors than those at
/// the truth, because the model bends; the interval's end is played, and moves out. The let-off's does not bend.
#[test]
fn intervals_reach_as_far_as_a_model_that_bends_asks() {
    let (clean, names) = (clean(62e-3), names());
    let mut asks = quiet(&names);
    asks.plan.restarts = 0;
    let (problem, noise) = problem(&noisy(&clean, 0.4e-3, 1035), &asks).unwrap();
    let found = erard_workshop::fit::fit(&mut simulator(&problem), &all_unknown(noise), &asks.plan).unwrap();
    let wide: Vec<f64> = found.half_width_95.iter().zip(&found.std).map(|(half, std)| half / std).collect();
    println!("{:?}, {wide:?} standard deviations", found.x);
    assert!((1.96..2.1).contains(&wide[3]) && wide[1] > 1.05 * wide[3], "{wide:?}");
}

/// Noise so slow that 62 ms are a few samples: no error, and how long a recording would do.
#[test]
fn too_short_a_recording_has_no_errors() {
    check(Cell { time_s: 12e-3, length_s: 62e-3, is_given: true }, 0..2, 0.0);
}

/// 100 recordings of the cell in which intervals held least often before their ends were played: correlated noise of
/// unknown size, on recordings so short that the model bends over their errors. It takes 75 s of processor time; all
/// cells are the nightly test's.
#[test]
#[ignore = "ci: 100 fits of four parameters"]
fn intervals_hold_under_correlated_noise() {
    check(Cell { time_s: 0.4e-3, length_s: 62e-3, is_given: false }, 0..100, 3.0);
}

mod nightly {
    use super::*;

    /// Deviations of the binomial distribution beyond which one of 24 right shares lies once in twenty times.
    const ONE_OF_24: f64 = 3.08;

    /// 400 recordings of every cell whose noise is given or not, each with noise of its own: the same noise in all
    /// cells would repeat one chance. All are counted, then what is wrong is named; no share alone, and not their mean,
    /// which shows a smaller bias. `ERARD_COVERAGE` requests fewer.
    fn every_cell(is_given: bool) {
        let asked = std::env::var("ERARD_COVERAGE").ok();
        let each = asked.map_or(400, |each| each.parse().expect("ERARD_COVERAGE is a number of recordings"));
        let (mut wrong, mut shares) = (Vec::new(), Vec::new());
        for (k, cell) in cells().enumerate().filter(|(_, cell)| cell.is_given == is_given) {
            let from = 10_000 * (k as u64 + 1);
            let (own, counted) = super::wrong(cell, from..from + each, ONE_OF_24);
            wrong.extend(own);
            shares.extend(counted);
        }
        let mean = shares.iter().sum::<f64>() / shares.len() as f64;
        let independent = each as f64 * shares.len() as f64 / TRUE.len() as f64 * INDEPENDENT;
        let scatter = (0.95 * 0.05 / independent).sqrt();
        println!("all cells: {:.2} % within, give or take {:.2}", 100.0 * mean, 100.0 * scatter);
        if (mean - 0.95).abs() > 2.576 * scatter {
            wrong.push(format!("all cells: {mean:.4}"));
        }
        assert!(wrong.is_empty(), "{wrong:#?}");
    }

    #[test]
    #[ignore = "nightly: 3200 fits of four parameters"]
    fn intervals_hold_where_the_noise_is_given() {
        every_cell(true);
    }

    #[test]
    #[ignore = "nightly: 3200 fits of four parameters"]
    fn intervals_hold_where_the_noise_is_not_given() {
        every_cell(false);
    }
}
