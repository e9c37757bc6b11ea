//! Pressed against struck at equal loudness, with the hands that play mf on this instrument ([`erard::level`]); and the
//! return of the damper after a hand has left.
//!
//! Release: a hand presses with 100 N/s up to 5 N and holds; after a quarter of a second it leaves, its force vanishing
//! within 30 ms ([`HandStroke::leaving`]). The key is released when the finger's force reaches zero.

use moreau::Settings;

use super::presses::{Drive, MF_M_PER_S, SimulatedPress, hand_at};
use crate::measure::MeasureError;
use erard::Progress;
use erard::grand::Anatomy;
use erard::instrument::Instrument;
use erard::run::{Run, Setup, SimulationError, press_by_hand};
use erard::stroke::{HandStroke, Muscle, Touch};

/// Step, s.
const STEP_S: f64 = 50e-6;
/// Duration, s: the hammer reaches the string before.
const DURATION_S: f64 = 0.4;
/// The released hand: rate of force, N/s, force held, N, start and duration of its leaving, s.
const RISE_N_S: f64 = 100.0;
const HELD_N: f64 = 5.0;
const LEAVES_S: [f64; 2] = [0.25, 0.03];
/// Averaging time of the key's speed, s: removes the trembling of fingertip and felts.
const MEAN_S: f64 = 1e-3;

/// Results of the two touches; `None` if one of them does not sound.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Touches {
    /// Lead of the struck key's impact over the pressed key's, counted from key start, s; positive if it is sooner.
    pub struck_sooner_s: Option<f64>,
    /// Key travel at which the struck key is slowest after its first surge, m.
    pub plateau_m: Option<f64>,
    /// Time from the release of the key until its damper is on the string, s; `None` without a damper.
    pub release_to_damper_s: Option<f64>,
}

pub(super) fn measure(instrument: &Instrument, progress: &mut Progress<'_>) -> Result<Touches, MeasureError> {
    let release_to_damper_s = release_to_damper(instrument)?;
    let played = [Touch::Pressed, Touch::Struck].map(|touch| mezzo_forte(instrument, touch, progress));
    let [pressed, struck] = played;
    let (Some(pressed), Some(struck)) = (pressed?, struck?) else {
        return Ok(Touches { struck_sooner_s: None, plateau_m: None, release_to_damper_s });
    };
    let to_string = |run: &Run| SimulatedPress::of(instrument, run, Drive::Constant(0.0)).to_string_s;
    let struck_sooner_s = to_string(&pressed).zip(to_string(&struck)).map(|(a, b)| a - b);
    Ok(Touches { struck_sooner_s, plateau_m: plateau(&struck), release_to_damper_s })
}

/// Plays mf by a hand; `None` if no hand does.
fn mezzo_forte(
    instrument: &Instrument,
    touch: Touch,
    progress: &mut Progress<'_>,
) -> Result<Option<Run>, SimulationError> {
    let Some(found) = hand_at(instrument, touch, MF_M_PER_S, progress)? else { return Ok(None) };
    let setup = Setup { settings: Settings::new(STEP_S), ..Setup::new(DURATION_S) };
    press_by_hand(instrument, &found.held(), &setup, progress).map(Some)
}

/// Time from the release of the key until its damper touches its rest, s.
fn release_to_damper(instrument: &Instrument) -> Result<Option<f64>, MeasureError> {
    let Some(damper) = Anatomy::find(instrument)?.damper else { return Ok(None) };
    let hand = HandStroke::ramped(RISE_N_S);
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

/// Key travel at the slowest instant between the first surge of the key and the impact, m; `None` if the key does not
/// slow down by a tenth.
fn plateau(run: &Run) -> Option<f64> {
    let until = run.time_s.partition_point(|&t| t < run.events.hammer_contact_s().unwrap_or(0.0));
    let wide = (MEAN_S / STEP_S) as usize;
    let speed: Vec<f64> = run.key_m[..until].windows(wide + 1).map(|y| (y[wide] - y[0]) / MEAN_S).collect();
    // The first surge ends where the speed falls below nine tenths of the fastest so far.
    let mut fastest = 0.0_f64;
    let over = speed.iter().position(|v| {
        fastest = fastest.max(*v);
        *v < 0.9 * fastest
    })?;
    // The minimum after it ends where the speed has risen by a tenth again.
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
