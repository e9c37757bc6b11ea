//! Where long steps lose accuracy, and what they cost: errors of the hammer speed and of the impact's instant by length
//! of step, by Newton's tolerance, and by the part of the stroke that is refined.

use moreau::Settings;

use super::play::{Action, LOOSE, SCALES, Walked, loose};

/// Step of the reference, s.
const FINEST_S: f64 = 0.1e-6;
const STEPS_S: [f64; 9] = [50e-6, 100e-6, 200e-6, 300e-6, 350e-6, 400e-6, 500e-6, 700e-6, 1000e-6];
const TOLERANCES: [f64; 4] = [1e-5, 1e-4, 1e-3, 1e-2];
/// Steps whose errors are looked for in windows of the stroke, s, and how much finer they are there.
const COARSE_S: [f64; 3] = [100e-6, 200e-6, 400e-6];
const FINER: f64 = 64.0;
/// Length of a window, s.
const WINDOW_S: f64 = 5e-3;

/// Plays all blows in steps whose lengths are a function of the instant.
type PlayAll<'a> = &'a dyn Fn(&Settings<f64>, &dyn Fn(f64) -> f64) -> Vec<Walked>;

/// Errors of all blows: relative, of the hammer speed, and of the impact's instant, s.
#[derive(Default)]
struct Errors {
    speed: Vec<f64>,
    instant_s: Vec<f64>,
}

impl Errors {
    fn of(blows: &[Walked], reference: &[Walked]) -> Self {
        let mut errors = Errors::default();
        for (blow, reference) in blows.iter().zip(reference) {
            let [v, t] = blow.strike.unwrap_or([f64::NAN; 2]);
            let [v0, t0] = reference.strike.unwrap_or([f64::NAN; 2]);
            errors.speed.push(v / v0 - 1.0);
            errors.instant_s.push(t - t0);
        }
        errors
    }

    /// Of the hammer speed, rms and mean; of the instant, the mean in us.
    fn columns(&self) -> String {
        let Errors { speed, instant_s } = self;
        format!("{:>9.2e} {:>9.2e} {:>8.2}", rms(speed), mean(speed), mean(instant_s) * 1e6)
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn rms(values: &[f64]) -> f64 {
    mean(&values.iter().map(|x| x * x).collect::<Vec<_>>()).sqrt()
}

/// Prints the tables.
pub fn where_errors_arise<const B: usize, const Z: usize, const N: usize>(action: &Action<B, Z, N>) {
    let all = |settings: &Settings<f64>, length: &dyn Fn(f64) -> f64| -> Vec<Walked> {
        SCALES.iter().map(|&scale| action.play_in(settings, scale, &mut |t, _, _| length(t))).collect()
    };
    let reference = all(&Settings { tolerance: 1e-9, ..Settings::new(FINEST_S) }, &|_| FINEST_S);
    let impact_s = reference[4].strike.map_or(f64::NAN, |strike| strike[1]);
    println!("impact at {:.2} ms, {:.3} m/s", impact_s * 1e3, reference[4].strike.map_or(f64::NAN, |strike| strike[0]));
    println!("\nby step and Newton's tolerance: error of the hammer speed (rms, mean), of the instant (us, mean)");
    println!(
        "{:>8} {:>9} {:>9} {:>9} {:>8} {:>7} {:>8} {:>8}",
        "step us", "tolerance", "rms", "mean", "us", "steps", "newton", "sets"
    );
    for tolerance in TOLERANCES {
        for h in STEPS_S {
            let blows = all(&Settings { tolerance, ..Settings::new(h) }, &|_| h);
            let errors = Errors::of(&blows, &reference);
            let per = |count: fn(&Walked) -> u64| {
                blows.iter().map(count).sum::<u64>() as f64 / blows.iter().map(|b| b.steps).sum::<u64>() as f64
            };
            println!(
                "{:>8.0} {tolerance:>9.0e} {} {:>7} {:>8.2} {:>8.2}",
                h * 1e6,
                errors.columns(),
                blows[4].steps,
                per(|b| b.newton),
                per(|b| b.sets),
            );
        }
    }
    for h in COARSE_S {
        println!("\nsteps of {:.0} us, in one window {FINER} times finer: window (ms), rms, mean, us", h * 1e6);
        let coarse = Errors::of(&all(&Settings::new(h), &|_| h), &reference);
        println!("{:>7} {:>7} {}", "-", "-", coarse.columns());
        for n in 0..(action.press_s / WINDOW_S).round() as u32 {
            let [from, until] = [n, n + 1].map(|n| f64::from(n) * WINDOW_S);
            if from > impact_s + 2.0 * WINDOW_S {
                break;
            }
            let blows = all(&Settings::new(h), &|t| if t + 1e-9 >= from && t + 1e-9 < until { h / FINER } else { h });
            println!("{:>7.0} {:>7.0} {}", from * 1e3, until * 1e3, Errors::of(&blows, &reference).columns());
        }
    }
    adaptive(action, &all, &reference, impact_s);
}

/// Prints what longer steps where nothing happens would gain: chosen by somebody who knows where that is, and by an
/// estimate that costs nothing, how far the velocities were from their prediction; beside fixed steps, with Newton's
/// tolerance loosened.
fn adaptive<const B: usize, const Z: usize, const N: usize>(
    action: &Action<B, Z, N>,
    all: PlayAll<'_>,
    reference: &[Walked],
    impact_s: f64,
) {
    println!("\nwork of a blow: error of the hammer speed (rms), steps, Newton iterations, active sets, us");
    let show = |name: String, blows: &[Walked]| {
        let errors = Errors::of(blows, reference);
        let mut seconds: Vec<f64> = blows.iter().map(|blow| blow.seconds).collect();
        seconds.sort_by(f64::total_cmp);
        let Walked { steps, newton, sets, .. } = blows[blows.len() / 2];
        let us = seconds[seconds.len() / 2] * 1e6;
        println!("{name:<36} {:>9.2e} {steps:>6} {newton:>6} {sets:>6} {us:>6.0}", rms(&errors.speed));
    };
    for h in [300e-6, 350e-6, 400e-6] {
        show(format!("{:.0} us", h * 1e6), &all(&Settings::new(h), &|_| h));
        show(format!("{:.0} us, Newton {LOOSE:e}", h * 1e6), &all(&loose(h), &|_| h));
    }
    for [early, near, late] in [[1e-3, 200e-6, 500e-6], [1e-3, 300e-6, 500e-6], [1e-3, 400e-6, 700e-6]] {
        let length = |t: f64| match t - impact_s {
            before if before < -16e-3 => early,
            until if until < 1e-3 => near,
            _ => late,
        };
        let name = [early, near, late].map(|h| format!("{:.0}", h * 1e6)).join(", ");
        show(format!("known in advance: {name} us"), &all(&loose(near), &length));
    }
    for most in [500e-6, 700e-6, 1e-3] {
        for wanted in [0.01, 0.03, 0.1, 0.3] {
            // The difference grows with the square of the step.
            let mut length = |_: f64, before: f64, missed: f64| {
                let factor = (wanted / missed.max(1e-12)).sqrt().clamp(0.2, 1.5);
                if before == 0.0 { 100e-6 } else { (before * factor).clamp(25e-6, most) }
            };
            let play = |&scale: &f64| action.play_in(&loose(100e-6), scale, &mut length);
            let blows: Vec<Walked> = SCALES.iter().map(play).collect();
            show(format!("missed by {wanted}, at most {:.0} us", most * 1e6), &blows);
        }
    }
}
