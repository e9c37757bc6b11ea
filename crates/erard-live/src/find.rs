//! Finds the largest inputs of a key by trial presses.

use erard::instrument::Instrument;
use erard::player::ActionError;
use erard::{Action, Input, Reading, Settings, Snapshot};

use crate::drive::SensorKind;
use crate::limits::{Limits, MAX_HAMMER_M_PER_S};

/// Ranges of the search for the limits: m/s and N.
const SPEEDS_M_PER_S: [f64; 2] = [0.2, 4.0];
const FORCES_N: [f64; 2] = [5.0, 500.0];
/// Number of ratios of these that are tried first.
const SCANNED: i32 = 20;
/// Relative accuracy of a limit.
const CLOSE: f64 = 2e-3;
/// A press that has not thrown the hammer after this time does not, s.
const PATIENCE_S: f64 = 0.1;
/// Force, N, and time, s, with which a key is held to find its dip.
const HELD_N: f64 = 5.0;
const HELD_S: f64 = 0.4;
/// Force that throws the hammer to its string, N.
const PRESSED_N: f64 = 10.0;

impl Limits<f64> {
    /// Finds the limits by pressing; `None` where no press throws the hammer to a string. The search covers only the
    /// inputs that a sensor of this kind can produce: the speed stays unlimited where forces are sensed, the force
    /// where positions are.
    ///
    /// # Errors
    /// [`ActionError`].
    pub fn find(instrument: &Instrument, kind: SensorKind) -> Result<Option<Self>, ActionError> {
        let mut bench = Bench::of(instrument)?;
        let (dip_m, up_m_per_s) = bench.held_and_let_go();
        let led = |v: f64| {
            move |t: f64| {
                let is_on = v * t < dip_m;
                Input::Rigid { position_m: (v * t).min(dip_m), velocity_m_per_s: if is_on { v } else { 0.0 } }
            }
        };
        let Some((_, blow_m)) = bench.impact(&led(0.5)) else { return Ok(None) };
        let mut speed = |input: &dyn Fn(f64) -> Input| bench.impact(input).map_or(0.0, |(speed, _)| speed);
        let (mut key_m_per_s, mut force_n) = (f64::INFINITY, f64::INFINITY);
        match kind {
            SensorKind::Force => force_n = largest(FORCES_N, &mut |force| speed(&|_| Input::Force(force))),
            SensorKind::Action | SensorKind::Light => key_m_per_s = largest(SPEEDS_M_PER_S, &mut |v| speed(&led(v))),
        }
        Ok(Some(Limits { key_m_per_s, force_n, up_m_per_s, dip_m, blow_m }))
    }
}

/// Dip of a key under 5 N, m: the travel of its front between its two stops.
///
/// # Errors
/// [`ActionError`].
pub fn dip_m(instrument: &Instrument) -> Result<f64, ActionError> {
    Ok(Bench::of(instrument)?.held_and_let_go().0)
}

/// Rise of the hammer from its rest to its string, m; `None` where no press throws it there.
///
/// # Errors
/// [`ActionError`].
pub fn blow_m(instrument: &Instrument) -> Result<Option<f64>, ActionError> {
    let mut bench = Bench::of(instrument)?;
    let pressed = |_: f64| Input::Force(PRESSED_N);
    Ok(bench.impact(&pressed).map(|(_, blow_m)| blow_m))
}

/// A key that is tried, each time from its rest.
struct Bench {
    action: Action,
    rest: Snapshot,
    h: f64,
}

impl Bench {
    fn of(instrument: &Instrument) -> Result<Self, ActionError> {
        let action = Action::with(instrument, Settings::new(instrument.usual_step_s()))?;
        let (rest, h) = (action.save(), action.settings().step);
        Ok(Bench { action, rest, h })
    }

    /// Plays for a time, s, or until `ends` returns true.
    fn play(&mut self, seconds: f64, input: &dyn Fn(f64) -> Input, ends: &mut dyn FnMut(f64, &Reading) -> bool) {
        let Bench { action, rest, h } = self;
        // A snapshot of this very action.
        let _ = action.restore(rest);
        for n in 1..=(seconds / *h) as u32 {
            let t = f64::from(n) * *h;
            if ends(t, &action.step(input(t))) {
                break;
            }
        }
    }

    /// The first impact: how fast the hammer is, m/s, and how high above its rest, m.
    fn impact(&mut self, input: &dyn Fn(f64) -> Input) -> Option<(f64, f64)> {
        let mut found = None;
        self.play(PATIENCE_S, input, &mut |_, reading| {
            found = reading.impact.map(|impact| (impact.hammer_speed_m_per_s, reading.hammer_rise_m));
            found.is_some()
        });
        found
    }

    /// Position of the key held at its bottom, m, and its largest speed on the way up after release, m/s.
    fn held_and_let_go(&mut self) -> (f64, f64) {
        let let_go = |t: f64| if t < HELD_S { Input::Force(HELD_N) } else { Input::Free };
        let (mut dip_m, mut up_m_per_s) = (0.0, 0.0_f64);
        self.play(HELD_S + PATIENCE_S, &let_go, &mut |t, reading| {
            if t < HELD_S {
                dip_m = reading.key_m;
            }
            up_m_per_s = up_m_per_s.max(-reading.key_m_per_s);
            false
        });
        (dip_m, up_m_per_s)
    }
}

/// The largest number for which the hammer stays within the limit, by bisection in ratios; for a hammer that never
/// reaches the limit, the number that makes it fastest.
fn largest([least, most]: [f64; 2], fastest: &mut dyn FnMut(f64) -> f64) -> f64 {
    let ratio = (most / least).powf(1.0 / f64::from(SCANNED));
    let (mut best, mut at, mut low, mut high) = (0.0, least, least, most);
    for k in 0..=SCANNED {
        let number = least * ratio.powi(k);
        let speed = fastest(number);
        if speed > MAX_HAMMER_M_PER_S {
            high = number;
            break;
        }
        if speed > best {
            (best, at) = (speed, number);
        }
        if k == SCANNED {
            return at;
        }
        low = number;
    }
    while high / low > 1.0 + CLOSE {
        let middle = (low * high).sqrt();
        if fastest(middle) <= MAX_HAMMER_M_PER_S { low = middle } else { high = middle }
    }
    low
}
