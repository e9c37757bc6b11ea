//! Finds what a key may be asked for, by pressing.

use erard::instrument::Instrument;
use erard::player::ActionError;
use erard::{Action, Input, Settings, Snapshot};

use crate::limits::{LARGEST_HAMMER_M_PER_S, Limits};

/// Ranges in which the limits are looked for: m/s and N.
const SPEEDS_M_PER_S: [f64; 2] = [0.2, 4.0];
const FORCES_N: [f64; 2] = [5.0, 500.0];
/// So many ratios of them are tried first.
const SCANNED: i32 = 20;
/// A limit is known to this share.
const CLOSE: f64 = 2e-3;
/// A press that has not thrown the hammer after this time does not, s.
const PATIENCE_S: f64 = 0.1;
/// How a key's dip is found: it is held with a force, N, for a time, s.
const HELD_N: f64 = 5.0;
const HELD_S: f64 = 0.4;

impl Limits<f64> {
    /// Finds them by pressing; `None` where nothing throws the hammer to a string.
    ///
    /// # Errors
    /// [`ActionError`].
    pub fn find(instrument: &Instrument) -> Result<Option<Self>, ActionError> {
        let mut bench = Bench::of(instrument)?;
        let dip_m = bench.dip_m();
        let mut play = |seconds: f64, input: &dyn Fn(f64) -> Input, ends: bool| bench.play(seconds, input, ends);
        let let_go = |t: f64| if t < HELD_S { Input::Force(HELD_N) } else { Input::Free };
        let up_m_per_s = play(HELD_S + PATIENCE_S, &let_go, false).3;
        let led = |v: f64| {
            move |t: f64| {
                let is_on = v * t < dip_m;
                Input::Rigid { position_m: (v * t).min(dip_m), velocity_m_per_s: if is_on { v } else { 0.0 } }
            }
        };
        let (_, Some(blow_m), ..) = play(PATIENCE_S, &led(0.5), true) else { return Ok(None) };
        let key_m_per_s = largest(SPEEDS_M_PER_S, &mut |v| play(PATIENCE_S, &led(v), true).0);
        let force_n = largest(FORCES_N, &mut |force| play(PATIENCE_S, &|_| Input::Force(force), true).0);
        Ok(Some(Limits { key_m_per_s, force_n, up_m_per_s, dip_m, blow_m }))
    }
}

/// Dip of a key under 5 N, m: the travel of its front between its two stops.
///
/// # Errors
/// [`ActionError`].
pub fn dip_m(instrument: &Instrument) -> Result<f64, ActionError> {
    Ok(Bench::of(instrument)?.dip_m())
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

    /// The fastest hammer, m/s, how high it was at its first string, m, where the key was last, m, and how fast it came
    /// up at most, m/s. `ends`: with the first impact.
    fn play(&mut self, seconds: f64, input: &dyn Fn(f64) -> Input, ends: bool) -> (f64, Option<f64>, f64, f64) {
        let Bench { action, rest, h } = self;
        // A snapshot of this very action.
        let _ = action.restore(rest);
        let (mut fastest, mut struck_m, mut key_m, mut up) = (0.0_f64, None, 0.0, 0.0_f64);
        for n in 1..=(seconds / *h) as u32 {
            let reading = action.step(input(f64::from(n) * *h));
            (key_m, up) = (reading.key_m, up.max(-reading.key_m_per_s));
            if let Some(impact) = reading.impact {
                fastest = fastest.max(impact.hammer_speed_m_per_s);
                struck_m = struck_m.or(Some(reading.hammer_m));
                if ends {
                    break;
                }
            }
        }
        (fastest, struck_m, key_m, up)
    }

    fn dip_m(&mut self) -> f64 {
        self.play(HELD_S, &|_| Input::Force(HELD_N), false).2
    }
}

/// The largest number whose hammer stays within the limit, by bisection in ratios; of a hammer that never reaches it,
/// the number with which it is fastest.
fn largest([least, most]: [f64; 2], fastest: &mut dyn FnMut(f64) -> f64) -> f64 {
    let ratio = (most / least).powf(1.0 / f64::from(SCANNED));
    let (mut best, mut at, mut low, mut high) = (0.0, least, least, most);
    for k in 0..=SCANNED {
        let number = least * ratio.powi(k);
        let speed = fastest(number);
        if speed > LARGEST_HAMMER_M_PER_S {
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
        if fastest(middle) <= LARGEST_HAMMER_M_PER_S { low = middle } else { high = middle }
    }
    low
}
