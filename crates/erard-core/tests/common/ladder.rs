//! Errors of an impact against a run with a much smaller step.
//!
//! A felt is touched at some phase between two instants of the grid, and the error of a single run depends on that
//! phase: two runs with steps of 50 and 49 us have errors that differ by a factor. The root mean square over steps that
//! are nearly the same, with phases that are not, is what follows a law.

use erard::instrument::Instrument;
use moreau::Settings;

use super::Play;

/// Steps that an error is averaged over: h, and 1/64, 2/64 ... less.
pub const NEIGHBOURS: u32 = 8;

/// An impact on the string.
#[derive(Debug, Clone, Copy)]
pub struct FirstImpact {
    /// Speed of the strike point, m/s.
    pub speed: f64,
    /// Instant, s.
    pub contact: f64,
    /// Newton iterations per step.
    pub newton: f64,
    /// Steps that did not converge.
    pub unconverged: u64,
}

/// The first impact of a run.
pub fn impact(instrument: &Instrument, play: &Play, settings: Settings<f64>, duration_s: f64) -> FirstImpact {
    let run = play.run_every(instrument, settings, duration_s, Some(u64::MAX));
    FirstImpact {
        speed: run.events.hammer_speed_m_per_s().expect("the string is struck"),
        contact: run.events.hammer_contact_s().expect("the string is struck"),
        newton: run.work.newton_iterations as f64 / run.work.steps as f64,
        unconverged: run.work.unconverged_steps,
    }
}

/// One rung: errors at a step.
#[derive(Debug, Clone, Copy)]
pub struct Rung {
    /// h, s.
    pub step: f64,
    /// The run at exactly h.
    pub impact: FirstImpact,
    /// Relative error of its hammer speed, signed.
    pub speed_error: f64,
    /// Error of its contact instant, s, signed.
    pub contact_error: f64,
    /// Root mean square of the relative speed error over the neighbouring steps.
    pub speed_rms: f64,
    /// The largest one.
    pub speed_worst: f64,
    /// Root mean square of the contact error, s.
    pub contact_rms: f64,
}

/// Errors at steps h, h/2, h/4 ... against a run with `reference` steps per smallest step.
pub fn ladder(
    instrument: &Instrument,
    play: &Play,
    theta: f64,
    steps: &[f64],
    reference: f64,
    until: f64,
) -> Vec<Rung> {
    let go = |step: f64| impact(instrument, play, Settings { theta, ..Settings::new(step) }, until);
    let finest = steps.iter().fold(f64::INFINITY, |a, b| a.min(*b));
    let exact = go(finest / reference);
    let error = |b: &FirstImpact| (b.speed / exact.speed - 1.0, b.contact - exact.contact);
    let rung = |&step: &f64| {
        let own = go(step);
        let (mut speed, mut contact, mut worst) = (0.0, 0.0, 0.0_f64);
        for k in 0..NEIGHBOURS {
            let (v, t) = error(&go(step * (1.0 - f64::from(k) / 64.0)));
            speed += v * v;
            contact += t * t;
            worst = worst.max(v.abs());
        }
        let n = f64::from(NEIGHBOURS);
        let (speed_error, contact_error) = error(&own);
        Rung {
            step,
            impact: own,
            speed_error,
            contact_error,
            speed_rms: (speed / n).sqrt(),
            speed_worst: worst,
            contact_rms: (contact / n).sqrt(),
        }
    };
    steps.iter().map(rung).collect()
}

/// `count` steps from `first` on, each half of the one before, s.
pub fn halvings(first: f64, count: i32) -> Vec<f64> {
    (0..count).map(|k| first * 0.5_f64.powi(k)).collect()
}
