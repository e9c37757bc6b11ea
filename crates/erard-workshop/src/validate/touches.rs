//! Pressed against struck at equal loudness: the built-in mf strokes, the struck one scaled until its hammer is as
//! fast; and how soon the damper is back after a hand has left.
//!
//! The release: a hand presses with 100 N/s up to 5 N and holds; after a quarter of a second it leaves, its force gone
//! within 30 ms ([`HandStroke::leaving`]). The key is released when the finger pushes no longer.

use moreau::Settings;

use super::blows::{Drive, PressedBlow};
use crate::measure::MeasureError;
use erard::Progress;
use erard::grand::Anatomy;
use erard::instrument::Instrument;
use erard::player::{self};
use erard::run::Run;
use erard::run::{HandStroke, Muscle, press_by_hand};
use erard::run::{Setup, SimulationError, simulate};
use erard::stroke::{ForceSeries, Series, Touch};

/// Step, s.
const STEP_S: f64 = 50e-6;
/// The strokes let the key go later than this, s.
const DURATION_S: f64 = 0.3;
/// The struck stroke's forces are scaled within these factors.
const SCALES: [f64; 2] = [0.3, 3.0];
/// Bisections: equal speeds to a thousandth.
const HALVINGS: usize = 14;
/// The released hand: N/s, N, s and s.
const RISE_N_S: f64 = 100.0;
const HELD_N: f64 = 5.0;
const LEAVES_S: [f64; 2] = [0.25, 0.03];
/// The key's speed is a mean over this time, s: the fingertip's and the felts' trembling goes out of it.
const MEAN_S: f64 = 1e-3;

/// What the two touches show; `None` where one of them does not sound.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Touches {
    /// How much sooner the struck key's hammer is at the string, from key start, s.
    pub struck_sooner_s: Option<f64>,
    /// Key travel at which the struck key is slowest after its first surge, m.
    pub plateau_m: Option<f64>,
    /// From the release of the key to its damper on the string, s; `None` without a damper.
    pub release_to_damper_s: Option<f64>,
}

pub(super) fn measure(instrument: &Instrument, progress: &mut Progress<'_>) -> Result<Touches, MeasureError> {
    let mut done = 0.0;
    let mut play = |touch: Touch, scale: f64| -> Result<Run, SimulationError> {
        done += 1.0;
        if !progress(done / (HALVINGS + 3) as f64) {
            return Err(SimulationError::Interrupted);
        }
        run(instrument, touch, scale)
    };
    let pressed = play(Touch::Pressed, 1.0)?;
    let release_to_damper_s = release_to_damper(instrument)?;
    let Some(speed) = pressed.events.hammer_speed_m_s() else {
        return Ok(Touches { struck_sooner_s: None, plateau_m: None, release_to_damper_s });
    };
    let [mut low, mut high] = SCALES;
    for _ in 0..HALVINGS {
        let middle = (low * high).sqrt();
        if play(Touch::Struck, middle)?.events.hammer_speed_m_s().is_some_and(|v| v >= speed) {
            high = middle;
        } else {
            low = middle;
        }
    }
    let struck = play(Touch::Struck, high)?;
    let to_string = |run: &Run| PressedBlow::of(instrument, run, Drive::Constant(0.0)).to_string_s;
    let struck_sooner_s = to_string(&pressed).zip(to_string(&struck)).map(|(a, b)| a - b);
    Ok(Touches { struck_sooner_s, plateau_m: plateau(&struck), release_to_damper_s })
}

fn run(instrument: &Instrument, touch: Touch, scale: f64) -> Result<Run, SimulationError> {
    let series = Series::builtin("mf", touch).and_then(|series| series.force);
    let own = series.as_ref().map(ForceSeries::drive);
    let force = |t: f64| scale * own.as_ref().map_or(0.0, |own| own(t));
    let setup = Setup { settings: Settings::new(STEP_S), ..Setup::new(DURATION_S) };
    simulate(instrument, &player::force(&force), &setup, &mut |_| true)
}

/// From the release of the key to its damper on what it rests on, s.
fn release_to_damper(instrument: &Instrument) -> Result<Option<f64>, MeasureError> {
    let Some(damper) = Anatomy::find(instrument)?.damper else { return Ok(None) };
    let hand = HandStroke::pressed(RISE_N_S);
    let hand = HandStroke { muscle: Muscle::Rises { rate_n_s: RISE_N_S, height_n: HELD_N }, ..hand }
        .leaving(LEAVES_S[0], LEAVES_S[1]);
    let setup = Setup { settings: Settings::new(STEP_S), record_every: Some(1), ..Setup::new(2.0 * LEAVES_S[0]) };
    let run = press_by_hand(instrument, &hand, &setup, &mut |_| true)?;
    let left = run.time_s.partition_point(|&t| t < LEAVES_S[0]);
    let Some(released) = (left..run.time_s.len()).find(|&row| run.force_n[row] <= 0.0) else {
        return Ok(None);
    };
    let rests_on = instrument.zones.iter().position(|zone| {
        let sides = [zone.disc_body, zone.curve_body];
        sides.contains(&Some(damper)) && sides.contains(&None)
    });
    let felt = rests_on.map(|zone| &run.zones[zone].normal_n[released..]);
    let down = felt.and_then(|normal| normal.iter().position(|n| *n > 0.0));
    Ok(down.map(|rows| run.time_s[released + rows] - run.time_s[released]))
}

/// Key travel at the slowest instant between the first surge of the key and the hammer's blow, m; `None` where the key
/// does not slow down by a tenth.
fn plateau(run: &Run) -> Option<f64> {
    let until = run.time_s.partition_point(|&t| t < run.events.hammer_contact_s().unwrap_or(0.0));
    let wide = (MEAN_S / STEP_S) as usize;
    let speed: Vec<f64> = run.key_m[..until].windows(wide + 1).map(|y| (y[wide] - y[0]) / MEAN_S).collect();
    // The first surge: from where on it gets slower than nine tenths of the fastest so far.
    let mut fastest = 0.0_f64;
    let over = speed.iter().position(|v| {
        fastest = fastest.max(*v);
        *v < 0.9 * fastest
    })?;
    // The valley behind it ends where the key has gained a tenth again.
    let (mut slowest, mut at) = (f64::INFINITY, over);
    for (row, v) in speed.iter().enumerate().skip(over) {
        if *v < slowest {
            (slowest, at) = (*v, row);
        } else if *v > 1.1 * slowest {
            break;
        }
    }
    Some(run.key_m[at + wide / 2])
}
