//! Blows of constant forces: when the key is down and when the hammer is there, from the softest to the loudest.

use erard::instrument::Instrument;
use erard::player;
use erard::run::Run;
use erard::simulation::{Setup, SimulationError, simulate};
use erard_workshop::measure::MeasureError;
use moreau::Settings;

/// Step, s.
const STEP_S: f64 = 50e-6;
/// A blow is over after this time, s: twice the slowest published.
const DURATION_S: f64 = 0.5;
/// The forces of published playing, N: 0.5 starts a key, 15 is ff, and 35 is more than any.
const FORCES_N: [f64; 2] = [0.3, 35.0];
/// A force is found when it is known to this share.
const CLOSE: f64 = 1e-3;
/// A key that has gone so far has started, m: past the cloths on which it breathes.
const STARTED_M: f64 = 1e-3;
/// Forces of the curve against loudness, from the softest to the largest.
const POINTS: usize = 25;
/// Hammer speeds of the marks mf and f, m/s: equal ratios from pp, 0.5, to ff, 5 (see the published table).
const MF_M_S: f64 = 1.99;
const F_M_S: f64 = 3.15;
/// The key stroke that a published f has, s.
const F_STROKE_S: f64 = 0.025;

/// One blow of a key pressed with a constant force. SI units; `None` did not happen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PressedBlow {
    /// The constant force, N.
    pub force_n: f64,
    /// From key start to key bottom, s.
    pub key_stroke_s: Option<f64>,
    /// From key start to the hammer on the string, s.
    pub to_string_s: Option<f64>,
    /// How long before key bottom the hammer meets the string, s; negative: after it.
    pub hammer_ahead_s: Option<f64>,
    /// Speed of the hammer at the string, m/s.
    pub hammer_speed_m_s: Option<f64>,
    /// Largest speed of the key front before the hammer meets the string, m/s.
    pub key_speed_m_s: f64,
    /// How long the hammer touches the string the first time, s.
    pub contact_s: Option<f64>,
    /// Farthest travel of the key front, m.
    pub deepest_m: f64,
}

/// What blows show. Forces that are not found are `None`.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Loudness {
    /// Smallest force that starts the key, N.
    pub starting_force_n: Option<f64>,
    /// Constant force of a key stroke of 20 ms, N.
    pub force_of_a_20_ms_stroke_n: Option<f64>,
    /// The softest that sounds and reaches key bottom.
    pub softest: Option<PressedBlow>,
    /// At 0.8, 15 and 35 N.
    pub at_0_8_n: PressedBlow,
    pub at_15_n: PressedBlow,
    pub at_35_n: PressedBlow,
    /// At the hammer speeds of the marks.
    pub mf: Option<PressedBlow>,
    pub f: Option<PressedBlow>,
    /// At the key stroke of a published f.
    pub f_by_stroke: Option<PressedBlow>,
    /// Hammer speed where hammer and key bottom come together, m/s.
    pub crossover_m_s: Option<f64>,
    /// The curve against loudness.
    pub blows: Vec<PressedBlow>,
}

/// One blow of a constant force.
fn blow(
    instrument: &Instrument,
    force_n: f64,
    going: &mut dyn FnMut() -> bool,
) -> Result<PressedBlow, SimulationError> {
    let setup = Setup {
        settings: Settings::new(STEP_S),
        start_s: 0.0,
        duration_s: DURATION_S,
        record_every: None,
        tolerance: None,
        ledger: true,
    };
    let run = simulate(instrument, &player::force(|_| force_n), &setup, &mut |_| going())?;
    Ok(PressedBlow::of(instrument, &run, force_n))
}

impl PressedBlow {
    /// What a run shows; `force_n` is its label.
    pub(super) fn of(instrument: &Instrument, run: &Run, force_n: f64) -> Self {
        let e = &run.events;
        let between = |from: Option<f64>, to: Option<f64>| Some(to? - from?);
        let until = run.time_s.partition_point(|&t| t < e.hammer_contact_s.unwrap_or(f64::INFINITY));
        let speeds = run.key_m[..until].windows(2).zip(run.time_s.windows(2));
        let key_speed_m_s = speeds.map(|(y, t)| (y[1] - y[0]) / (t[1] - t[0])).fold(0.0, f64::max);
        let string = instrument.roles.string.map(|zone| &run.zones[zone].normal_n[until.min(run.time_s.len())..]);
        let contact_s = string.filter(|_| e.hammer_contact_s.is_some()).map(|normal| {
            // The row of the first touch may still be without force.
            let first = normal.iter().position(|n| *n > 0.0).unwrap_or(0);
            let rows = normal[first..].iter().take_while(|n| **n > 0.0).count();
            rows as f64 * run.work.record_every as f64 * STEP_S
        });
        PressedBlow {
            force_n,
            key_stroke_s: between(e.key_start_s, e.key_bottom_s),
            to_string_s: between(e.key_start_s, e.hammer_contact_s),
            hammer_ahead_s: between(e.hammer_contact_s, e.key_bottom_s),
            hammer_speed_m_s: e.hammer_speed_m_s,
            key_speed_m_s,
            contact_s,
            deepest_m: run.key_m.iter().copied().fold(0.0, f64::max),
        }
    }

    /// Sounds, and goes all the way.
    fn whole(&self) -> bool {
        self.hammer_ahead_s.is_some()
    }
}

/// The smallest force from which on `holds`, by bisection on the logarithm; `None` when it does not hold at the largest.
fn smallest_force(
    instrument: &Instrument,
    holds: &dyn Fn(&PressedBlow) -> bool,
    going: &mut dyn FnMut() -> bool,
) -> Result<Option<f64>, SimulationError> {
    let [mut low, mut high] = FORCES_N;
    if !holds(&blow(instrument, high, going)?) {
        return Ok(None);
    }
    while high / low > 1.0 + CLOSE {
        let middle = (low * high).sqrt();
        if holds(&blow(instrument, middle, going)?) {
            high = middle;
        } else {
            low = middle;
        }
    }
    Ok(Some(high))
}

/// All that the table asks about.
pub(super) fn measure(
    instrument: &Instrument,
    progress: &mut dyn FnMut(f64) -> bool,
) -> Result<Loudness, MeasureError> {
    // Counted in blows: six searches of about 13, the curve and three more.
    const BLOWS: f64 = 6.0 * 13.0 + POINTS as f64 + 6.0;
    let mut done = 0.0;
    let mut going = || {
        done += 1.0 / (1.0 + (DURATION_S / STEP_S / 8192.0).floor());
        progress((done / BLOWS).min(1.0))
    };
    let search = |holds: &dyn Fn(&PressedBlow) -> bool,
                  going: &mut dyn FnMut() -> bool|
     -> Result<Option<PressedBlow>, MeasureError> {
        match smallest_force(instrument, holds, going)? {
            Some(force) => Ok(Some(blow(instrument, force, going)?)),
            None => Ok(None),
        }
    };
    let speed = |at_least: f64| move |b: &PressedBlow| b.hammer_speed_m_s.is_some_and(|v| v >= at_least);
    let stroke = |at_most: f64| move |b: &PressedBlow| b.key_stroke_s.is_some_and(|t| t <= at_most);
    let starting = search(&|b| b.deepest_m > STARTED_M, &mut going)?;
    let softest = search(&PressedBlow::whole, &mut going)?;
    let quick = search(&stroke(0.020), &mut going)?;
    let f_by_stroke = search(&stroke(F_STROKE_S), &mut going)?;
    let (mf, f) = (search(&speed(MF_M_S), &mut going)?, search(&speed(F_M_S), &mut going)?);
    let from = softest.map_or(FORCES_N[0], |b| b.force_n);
    let mut blows = Vec::new();
    for n in 0..POINTS {
        let share = n as f64 / (POINTS - 1) as f64;
        blows.push(blow(instrument, from * (FORCES_N[1] / from).powf(share), &mut going)?);
    }
    let at_35_n = blow(instrument, FORCES_N[1], &mut going)?;
    Ok(Loudness {
        starting_force_n: starting.map(|b| b.force_n),
        force_of_a_20_ms_stroke_n: quick.map(|b| b.force_n),
        softest,
        at_0_8_n: blow(instrument, 0.8, &mut going)?,
        at_15_n: blow(instrument, 15.0, &mut going)?,
        at_35_n,
        mf,
        f,
        f_by_stroke,
        crossover_m_s: crossover(&blows),
        blows,
    })
}

/// Hammer speed at which the last change from hammer first to key bottom first lies, m/s: by linear interpolation.
fn crossover(blows: &[PressedBlow]) -> Option<f64> {
    let points: Vec<[f64; 2]> = blows.iter().filter_map(|b| Some([b.hammer_speed_m_s?, b.hammer_ahead_s?])).collect();
    let last = points.windows(2).rev().find(|pair| pair[0][1] > 0.0 && pair[1][1] <= 0.0)?;
    let [[slow, ahead], [fast, behind]] = [last[0], last[1]];
    Some(slow + (fast - slow) * ahead / (ahead - behind))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(speed: f64, ahead: f64) -> PressedBlow {
        PressedBlow {
            force_n: 1.0,
            key_stroke_s: None,
            to_string_s: None,
            hammer_ahead_s: Some(ahead),
            hammer_speed_m_s: Some(speed),
            key_speed_m_s: 0.0,
            contact_s: None,
            deepest_m: 0.0,
        }
    }

    /// A straight line through zero at 2.5 m/s is found to rounding; one that does not change its sign has no crossover.
    #[test]
    fn a_line_crosses_where_it_does() {
        let line: Vec<PressedBlow> = [1.0, 2.0, 3.0, 4.0].iter().map(|v| at(*v, 1e-3 * (2.5 - v))).collect();
        assert!((crossover(&line).unwrap() - 2.5).abs() < 1e-12);
        assert_eq!(crossover(&line[..2]), None);
    }
}
