//! Presses from the softest to the loudest: times of key bottom and of the impact.
//!
//! Five protocols, fixed before any parameter of an instrument was changed for them:
//!
//! - *constant*: a force that acts at once and stays. Nobody plays like this; it is the simplest drive.
//! - *ramped*: a force that rises within 10 ms by half a cosine and stays. Under a step, the front of a flexible key
//!   trembles, and its largest speed is that of the trembling.
//! - *struck*: a hand of 0.2 kg arrives with a speed, and its muscle continues to press ([`HandStroke::struck`]).
//! - *pressed*: a hand of 0.2 kg rests on the key, and its muscle's force rises within 40 ms and stays, to the end of
//!   the run ([`HandStroke::pressed`]). The loudest is that of 100 N: 50 N within 20 ms, which Timmermans and Fisette
//!   (Machines 8 (2020) 76) ask of an actuator that is to play as a pianist does.
//! - *led*: the same hand moves to 10.5 mm below the key's rest along the path of least jerk, by a muscle of 1500 N/m
//!   and 14 N s/m, and stays there ([`HandStroke::led`]). The slowest that sounds is the softest.
//!
//! Key bottom is the first touch of the front punching, and the key starts when its front is 0.1 mm down
//! ([`erard::events`]). Accelerometers show key bottom at the key's largest deceleration, a millisecond or more later.

use std::f64::consts::PI;

use crate::measure::MeasureError;
use erard::Progress;
use erard::instrument::Instrument;
use erard::level::{FORCES_N as HAND_FORCES_N, HandKind, LevelError, MASS_KG, Reference, Solved};
use erard::player::{self};
use erard::run::{Run, Setup, SimulationError, press_by_hand, simulate};
use erard::stroke::{HandStroke, Touch};
use moreau::Settings;

/// Step, s.
const STEP_S: f64 = 50e-6;
/// Duration of a press, s: twice the slowest published.
const DURATION_S: f64 = 0.5;
/// Range of forces in published playing, N: 0.5 starts a key, 15 is ff, and 35 is more than any.
const FORCES_N: [f64; 2] = [0.3, 35.0];
/// Slowest and quickest led stroke, s: twice the longest published key stroke, and one that no led hand can follow.
const SLOWEST_S: f64 = 0.5;
const QUICKEST_S: f64 = 0.02;
/// Rise time of a ramped force, s.
const RAMP_S: f64 = 0.010;
/// Fortissimo: the force given by one paper, N, and the hammer speed given by others, m/s.
const FF_FORCE_N: f64 = 15.0;
const FF_LEAST_M_PER_S: f64 = 4.5;
/// Relative tolerance of a force found by bisection.
const CLOSE: f64 = 1e-3;
/// Travel at which a key has started, m: beyond the compression of its cloths.
const STARTED_M: f64 = 1e-3;
/// Number of forces in the curve against loudness, from the softest to the largest.
const POINTS: usize = 25;
/// Hammer speeds of the levels, m/s: equal ratios from pp, 0.5, to ff, 5 (see the published table).
pub(super) const PP_M_PER_S: f64 = 0.5;
pub(super) const FF_M_PER_S: f64 = 5.0;
pub(super) const MF_M_PER_S: f64 = 1.99;
const P_M_PER_S: f64 = 0.79;
const F_M_PER_S: f64 = 3.15;
/// Published duration of an f key stroke, s.
const F_STROKE_S: f64 = 0.025;

/// Drive of the key.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Drive {
    /// Constant force, N, from the start.
    Constant(f64),
    /// Force, N, that rises within 10 ms and stays.
    Ramped(f64),
    /// Hand that arrives at this speed, m/s ([`HandStroke::struck`]).
    Struck(f64),
    /// Hand whose muscle's force rises to this, N ([`HandStroke::pressed`]).
    Pressed(f64),
    /// Hand that moves down within this time, s ([`HandStroke::led`]).
    Led(f64),
}

/// Simulated press. SI units; `None` for events that did not happen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SimulatedPress {
    /// Drive of the key.
    pub drive: Drive,
    /// Time from key start to key bottom, s. Key bottom is the first touch of the front punching.
    pub key_stroke_s: Option<f64>,
    /// Time from key start to the impact on the string, s.
    pub to_string_s: Option<f64>,
    /// Time from the impact to key bottom, s; negative if the key is down first.
    pub hammer_ahead_s: Option<f64>,
    /// Speed of the hammer at the string, m/s.
    pub hammer_speed_m_per_s: Option<f64>,
    /// Largest speed of the key front before the impact, m/s.
    pub key_speed_m_per_s: f64,
    /// Largest force of the finger before the impact, N.
    pub peak_n: f64,
    /// Duration of the first contact of hammer and string, s.
    pub contact_s: Option<f64>,
    /// Farthest travel of the key front, m.
    pub deepest_m: f64,
}

/// Results of the presses. Drives that were not found are `None`.
#[derive(Debug, Clone, PartialEq)]
pub struct Loudness {
    /// Smallest force that starts the key, N.
    pub starting_force_n: Option<f64>,
    /// Constant force of a key stroke of 20 ms, N.
    pub force_of_a_20_ms_stroke_n: Option<f64>,
    /// Press with the softest constant force that sounds and reaches key bottom.
    pub softest: Option<SimulatedPress>,
    /// Press under 0.8 N.
    pub at_0_8_n: SimulatedPress,
    /// Press under 15 N.
    pub at_15_n: SimulatedPress,
    /// Press under 35 N.
    pub at_35_n: SimulatedPress,
    /// Press under a force that rises to 15 N.
    pub ramped_15_n: SimulatedPress,
    /// Smallest force with such a rise for a hammer speed of 4.5 m/s, N.
    pub force_for_ff_n: Option<f64>,
    /// Press with the constant force for the hammer speed of mf.
    pub mf: Option<SimulatedPress>,
    /// Press with the constant force for the hammer speed of f.
    pub f: Option<SimulatedPress>,
    /// Press with the constant force for the published duration of an f key stroke.
    pub f_by_stroke: Option<SimulatedPress>,
    /// Hammer speed at which impact and key bottom coincide under constant forces, m/s.
    pub crossover_m_per_s: Option<f64>,
    /// Curve of constant forces against loudness.
    pub constant_force: Vec<SimulatedPress>,
    /// Results of hands.
    pub by_hand: ByHand,
}

/// Presses by hands.
#[derive(Debug, Clone, PartialEq)]
pub struct ByHand {
    /// Led as slowly as still sounds.
    pub softest: Option<SimulatedPress>,
    /// Led, at the hammer speed of pp.
    pub pp: Option<SimulatedPress>,
    /// Pressed, with the published duration of an f key stroke.
    pub f_by_stroke: Option<SimulatedPress>,
    /// Pressed, at the hammer speed of ff.
    pub ff: Option<SimulatedPress>,
    /// Struck, at the hammer speeds of pp, p, mf and ff.
    pub struck: [Option<SimulatedPress>; 4],
    /// Pressed as fast as a hand can.
    pub loudest: SimulatedPress,
    /// Hammer speed at which impact and key bottom coincide, pressed, m/s.
    pub crossover_m_per_s: Option<f64>,
    /// The curve of pressed touches against loudness.
    pub pressed: Vec<SimulatedPress>,
}

/// Simulates one press.
fn press(
    instrument: &Instrument,
    drive: Drive,
    progress: &mut Progress<'_>,
) -> Result<SimulatedPress, SimulationError> {
    let setup = Setup { settings: Settings::new(STEP_S), ..Setup::new(DURATION_S) };
    let run = match drive {
        Drive::Constant(force_n) => simulate(instrument, &player::force(|_| force_n), &setup, progress)?,
        Drive::Ramped(force_n) => {
            let rises = |t: f64| force_n * (0.5 - 0.5 * libm::cos(PI * (t / RAMP_S).clamp(0.0, 1.0)));
            simulate(instrument, &player::force(rises), &setup, progress)?
        }
        Drive::Struck(m_per_s) => press_by_hand(instrument, &HandStroke::struck(MASS_KG, m_per_s), &setup, progress)?,
        Drive::Pressed(force_n) => press_by_hand(instrument, &HandStroke::pressed(MASS_KG, force_n), &setup, progress)?,
        Drive::Led(duration_s) => press_by_hand(instrument, &HandStroke::led(duration_s), &setup, progress)?,
    };
    Ok(SimulatedPress::of(instrument, &run, drive))
}

impl SimulatedPress {
    /// Makes the results of a run.
    pub(super) fn of(instrument: &Instrument, run: &Run, drive: Drive) -> Self {
        let e = &run.events;
        let between = |from: Option<f64>, to: Option<f64>| Some(to? - from?);
        let until = run.time_s.partition_point(|&t| t < e.hammer_contact_s().unwrap_or(f64::INFINITY));
        let speeds = run.key_m[..until].windows(2).zip(run.time_s.windows(2));
        let key_speed_m_per_s = speeds.map(|(y, t)| (y[1] - y[0]) / (t[1] - t[0])).fold(0.0, f64::max);
        let peak_n = run.force_n[..until].iter().copied().fold(0.0, f64::max);
        let string = instrument.roles.string.map(|zone| &run.zones[zone].normal_n[until.min(run.time_s.len())..]);
        let contact_s = string.filter(|_| e.hammer_contact_s().is_some()).map(|normal| {
            // The first row of contact may still be without force.
            let first = normal.iter().position(|n| *n > 0.0).unwrap_or(0);
            let rows = normal[first..].iter().take_while(|n| **n > 0.0).count();
            rows as f64 * run.work.record_every as f64 * STEP_S
        });
        SimulatedPress {
            drive,
            key_stroke_s: between(e.key_start_s, e.key_bottom_s),
            to_string_s: between(e.key_start_s, e.hammer_contact_s()),
            hammer_ahead_s: between(e.hammer_contact_s(), e.key_bottom_s),
            hammer_speed_m_per_s: e.hammer_speed_m_per_s(),
            key_speed_m_per_s,
            peak_n,
            contact_s,
            deepest_m: run.key_m.iter().copied().fold(0.0, f64::max),
        }
    }

    /// Whether the key sounds and reaches its bottom.
    fn whole(&self) -> bool {
        self.hammer_ahead_s.is_some()
    }
}

/// A family of drives from soft to loud, by one parameter with its range.
struct Family {
    drive: fn(f64) -> Drive,
    ends: [f64; 2],
}

const CONSTANT: Family = Family { drive: Drive::Constant, ends: FORCES_N };
const RAMPED: Family = Family { drive: Drive::Ramped, ends: FORCES_N };
const PRESSED: Family = Family { drive: Drive::Pressed, ends: HAND_FORCES_N };
/// By the inverse of the duration, 1/s, so that larger is louder.
const LED: Family = Family { drive: |per_s| Drive::Led(1.0 / per_s), ends: [1.0 / SLOWEST_S, 1.0 / QUICKEST_S] };

/// Finds the family's smallest parameter from which on `holds` is true, by bisection on the logarithm, and returns its
/// press; `None` if it is false at the largest.
fn smallest(
    instrument: &Instrument,
    family: &Family,
    holds: &dyn Fn(&SimulatedPress) -> bool,
    progress: &mut Progress<'_>,
) -> Result<Option<SimulatedPress>, SimulationError> {
    let [mut low, mut high] = family.ends;
    let mut found = press(instrument, (family.drive)(high), progress)?;
    if !holds(&found) {
        return Ok(None);
    }
    while high / low > 1.0 + CLOSE {
        let middle = (low * high).sqrt();
        let tried = press(instrument, (family.drive)(middle), progress)?;
        if holds(&tried) {
            (high, found) = (middle, tried);
        } else {
            low = middle;
        }
    }
    Ok(Some(found))
}

/// Finds the hand of a touch with this hammer speed; `None` if there is none.
pub(super) fn hand_at(
    instrument: &Instrument,
    touch: Touch,
    speed_m_per_s: f64,
    progress: &mut Progress<'_>,
) -> Result<Option<Solved>, SimulationError> {
    let solved = Reference::new(instrument, progress)
        .and_then(|mut reference| reference.solve(HandKind::new(touch, MASS_KG), speed_m_per_s, progress));
    match solved {
        Ok(solved) => Ok(Some(solved)),
        Err(LevelError::Interrupted) => Err(SimulationError::Interrupted),
        Err(LevelError::Action(error)) => Err(error.into()),
        Err(_) => Ok(None),
    }
}

/// Returns the press of the struck hand with this hammer speed; `None` if there is none. Searched from below: a hand
/// that arrives too fast throws the hammer off the jack, and is softer.
fn struck_at(
    instrument: &Instrument,
    speed_m_per_s: f64,
    progress: &mut Progress<'_>,
) -> Result<Option<SimulatedPress>, SimulationError> {
    // The search does not count as progress: its trials end at the impact.
    let Some(found) = hand_at(instrument, Touch::Struck, speed_m_per_s, &mut |_| true)? else { return Ok(None) };
    press(instrument, Drive::Struck(found.louder), progress).map(Some)
}

/// Returns the presses of a family from a parameter to its end, in equal ratios.
fn curve(
    instrument: &Instrument,
    family: &Family,
    from: f64,
    progress: &mut Progress<'_>,
) -> Result<Vec<SimulatedPress>, SimulationError> {
    let share = |n: usize| n as f64 / (POINTS - 1) as f64;
    (0..POINTS)
        .map(|n| press(instrument, (family.drive)(from * (family.ends[1] / from).powf(share(n))), progress))
        .collect()
}

/// Simulates all presses needed by the table.
pub fn measure(instrument: &Instrument, progress: &mut Progress<'_>) -> Result<Loudness, MeasureError> {
    // Number of presses: eleven searches of about 13, two curves and five more.
    const PRESSES: f64 = 11.0 * 13.0 + 2.0 * POINTS as f64 + 5.0;
    let mut done = 0.0;
    let progress = &mut |_: f64| {
        done += 1.0 / (1.0 + (DURATION_S / STEP_S / 8192.0).floor());
        progress((done / PRESSES).min(1.0))
    };
    let speed = |at_least: f64| move |b: &SimulatedPress| b.hammer_speed_m_per_s.is_some_and(|v| v >= at_least);
    let stroke = |at_most: f64| move |b: &SimulatedPress| b.key_stroke_s.is_some_and(|t| t <= at_most);
    let starting = smallest(instrument, &CONSTANT, &|b| b.deepest_m > STARTED_M, progress)?;
    let softest = smallest(instrument, &CONSTANT, &SimulatedPress::whole, progress)?;
    let quick = smallest(instrument, &CONSTANT, &stroke(0.020), progress)?;
    let f_by_stroke = smallest(instrument, &CONSTANT, &stroke(F_STROKE_S), progress)?;
    let mf = smallest(instrument, &CONSTANT, &speed(MF_M_PER_S), progress)?;
    let f = smallest(instrument, &CONSTANT, &speed(F_M_PER_S), progress)?;
    let force = |found: &Option<SimulatedPress>| match found {
        Some(SimulatedPress { drive: Drive::Constant(force_n) | Drive::Ramped(force_n), .. }) => Some(*force_n),
        _ => None,
    };
    let constant_force = curve(instrument, &CONSTANT, force(&softest).unwrap_or(FORCES_N[0]), progress)?;
    let pressed = curve(instrument, &PRESSED, HAND_FORCES_N[0], progress)?;
    let mut struck = [None; 4];
    for (one, speed_m_per_s) in struck.iter_mut().zip([PP_M_PER_S, P_M_PER_S, MF_M_PER_S, FF_M_PER_S]) {
        *one = struck_at(instrument, speed_m_per_s, progress)?;
    }
    let ramped = smallest(instrument, &RAMPED, &speed(FF_LEAST_M_PER_S), progress)?;
    let by_hand = ByHand {
        struck,
        softest: smallest(instrument, &LED, &SimulatedPress::whole, progress)?,
        pp: smallest(instrument, &LED, &speed(PP_M_PER_S), progress)?,
        f_by_stroke: smallest(instrument, &PRESSED, &stroke(F_STROKE_S), progress)?,
        ff: smallest(instrument, &PRESSED, &speed(FF_M_PER_S), progress)?,
        loudest: press(instrument, Drive::Pressed(HAND_FORCES_N[1]), progress)?,
        crossover_m_per_s: crossover(&pressed),
        pressed,
    };
    Ok(Loudness {
        starting_force_n: force(&starting),
        force_of_a_20_ms_stroke_n: force(&quick),
        softest,
        at_0_8_n: press(instrument, Drive::Constant(0.8), progress)?,
        at_15_n: press(instrument, Drive::Constant(FF_FORCE_N), progress)?,
        ramped_15_n: press(instrument, Drive::Ramped(FF_FORCE_N), progress)?,
        force_for_ff_n: force(&ramped),
        at_35_n: press(instrument, Drive::Constant(FORCES_N[1]), progress)?,
        mf,
        f,
        f_by_stroke,
        crossover_m_per_s: crossover(&constant_force),
        constant_force,
        by_hand,
    })
}

/// Hammer speed at the last change from hammer first to key bottom first, m/s, by linear interpolation.
fn crossover(presses: &[SimulatedPress]) -> Option<f64> {
    let points: Vec<[f64; 2]> =
        presses.iter().filter_map(|b| Some([b.hammer_speed_m_per_s?, b.hammer_ahead_s?])).collect();
    let last = points.windows(2).rev().find(|pair| pair[0][1] > 0.0 && pair[1][1] <= 0.0)?;
    let [[slow, ahead], [fast, behind]] = [last[0], last[1]];
    Some(slow + (fast - slow) * ahead / (ahead - behind))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(speed: f64, ahead: f64) -> SimulatedPress {
        SimulatedPress {
            drive: Drive::Constant(1.0),
            key_stroke_s: None,
            to_string_s: None,
            hammer_ahead_s: Some(ahead),
            hammer_speed_m_per_s: Some(speed),
            key_speed_m_per_s: 0.0,
            peak_n: 0.0,
            contact_s: None,
            deepest_m: 0.0,
        }
    }

    /// A straight line through zero at 2.5 m/s is found to rounding; one without change of sign has no crossover.
    #[test]
    fn a_line_crosses_where_it_does() {
        let line: Vec<SimulatedPress> = [1.0, 2.0, 3.0, 4.0].iter().map(|v| at(*v, 1e-3 * (2.5 - v))).collect();
        assert!((crossover(&line).unwrap() - 2.5).abs() < 1e-12);
        assert_eq!(crossover(&line[..2]), None);
    }
}
