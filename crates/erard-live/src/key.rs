//! One key: its action on the stream's clock, what drives it, and its notes.

use std::collections::VecDeque;

use erard::instrument::Instrument;
use erard::player::ActionError;
use erard::{Action, Outcome, Settings};
use erard_midi::{Crossing, Event as NoteEvent, KeyNotes};

use crate::ahead::{Announced, Foreseen, look};
use crate::drive::{BEYOND_M, Drive, SensorKind};
use crate::limits::Limits;
use crate::report::ERRORS;

/// Nearer to its rest a sensor counts as being at rest, m; a key that leaves it is played from where it did.
const REST_M: f64 = 0.15e-3;
/// It left its rest after the last sample below this, m, at most so many samples before.
const BEGAN_M: f64 = 0.01e-3;
const REMEMBERED: usize = 64;
/// A key of which nothing came for so long did not move meanwhile, s: the sender left it out, or stalled.
const GAP_S: f64 = 0.1;
/// The time between two samples before it is known, s.
const USUAL_PERIOD_S: f64 = 1e-3;
/// Impacts are foreseen so far ahead at most, s.
const HORIZON_S: f64 = 6e-3;
/// Not more often, s.
const LOOK_EVERY_S: f64 = 0.5e-3;
/// The key goes on as over the last samples that span so long at least, s: over less, the last digit of a sensor of 12
/// bits is a hundredth of a loud key's speed and more.
const SLOPE_S: f64 = 0.999e-3;
/// Slower hammers are not looked after, m/s.
const RISES_M_PER_S: f64 = 0.1;
/// Looks agree if what is foreseen, changing on as since the last one, will have changed by less than this at the
/// impact: s, and a share of the speed. Half of the errors that are allowed. They are believed once they have agreed
/// for [`SLOPE_S`]: what changes passes through values where it stands still.
const SETTLED: [f64; 2] = [0.5 * ERRORS[0], 0.5 * ERRORS[1]];
/// A key that does not move for so long although it is neither up nor down is stuck, s.
const STUCK_S: f64 = 10.0;
/// A way from the rest that ends again below this is noise, m.
const FLUTTER_M: f64 = 0.5e-3;
/// After letting a key go it is followed for so long, s.
const HOME_S: f64 = 1.0;

/// What comes of a key.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Told {
    /// The hammer met the string: when, s, how fast, m/s.
    Struck(f64, f64),
    /// It will.
    Announced(f64, f64),
    /// It was announced and met it: announced and true, each when, s, and how fast, m/s; and when that was known, s.
    Kept([f64; 2], [f64; 2], f64),
    /// It was announced and did not: when that is known, s.
    False(f64),
    /// The key set its damper down: when, s, how fast it came up, m/s.
    Released(f64, f64),
}

/// What was counted of a key.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Counts {
    /// Steps that were limited, and deeper than the key goes.
    pub fast_steps: u64,
    pub deep_samples: u64,
    /// Ways from the rest in which the key was limited.
    pub fast_strokes: u64,
    /// Times without a sample while the key was off its rest.
    pub gaps: u64,
    /// Ways from the rest that were noise.
    pub flutters: u64,
    /// Times the sensor stood still between up and down.
    pub stuck: u64,
    /// Steps in which a number was not finite.
    pub non_finite: u64,
    pub fastest_m_per_s: f64,
}

pub(crate) struct Key {
    action: Action,
    notes: KeyNotes,
    drive: Drive,
    pub limits: Limits,
    h: f64,
    /// Steps on the stream's clock.
    n: u64,
    /// The last sample: when, s, and what, m or N.
    last: Option<[f64; 2]>,
    /// Samples at rest that may turn out to be a key's first way, played as soon as they do.
    waiting: VecDeque<[f64; 2]>,
    /// The last samples, over [`SLOPE_S`]; empty unless impacts are foreseen.
    recent: VecDeque<[f64; 2]>,
    /// The usual time between two, s.
    pub period_s: f64,
    ahead: bool,
    kind: SensorKind,
    announced: Option<Announced>,
    /// The last look: when, and what it found: when and how fast.
    looked: Option<(f64, Option<[f64; 2]>)>,
    /// Since when all looks agree, s.
    agreed_since_s: Option<f64>,
    /// In this way from the rest: its highest value, and whether it was limited.
    way: Option<(f64, bool)>,
    /// Since when the value has been the same, s.
    same_since_s: f64,
    is_stuck: bool,
    pub counts: Counts,
}

impl Key {
    pub(crate) fn new(
        instrument: &Instrument,
        limits: Limits,
        damper_m: f64,
        kind: SensorKind,
        ahead: bool,
    ) -> Result<Self, ActionError> {
        let action = Action::with(instrument, Settings::new(instrument.usual_step_s()))?;
        Ok(Key {
            h: action.settings().step,
            action,
            notes: KeyNotes::new(Crossing { damper_m }),
            drive: Drive::new(kind, limits),
            limits,
            n: 0,
            last: None,
            waiting: VecDeque::with_capacity(REMEMBERED),
            recent: VecDeque::new(),
            period_s: USUAL_PERIOD_S,
            ahead,
            kind,
            announced: None,
            looked: None,
            agreed_since_s: None,
            way: None,
            same_since_s: 0.0,
            is_stuck: false,
            counts: Counts::default(),
        })
    }

    /// The last sample's value, m or N.
    pub(crate) fn value(&self) -> f64 {
        self.last.map_or(0.0, |[_, value]| value)
    }

    /// Whether its sensor is at rest.
    pub(crate) fn is_up(&self) -> bool {
        !self.is_pressed(self.value())
    }

    /// Takes a sample: when, s, and what, m or N. False if it does not come after the last one: it is left out.
    pub(crate) fn take(&mut self, to: [f64; 2], tell: &mut dyn FnMut(Told)) -> bool {
        let [t1, x1] = to;
        let mut from = self.last.unwrap_or([t1 - self.period_s, 0.0]);
        if t1 <= from[0] {
            return false;
        }
        self.watch(from, to);
        let passed_s = t1 - from[0];
        if passed_s > GAP_S {
            self.counts.gaps += u64::from(self.is_pressed(from[1]));
            from[0] = t1 - self.period_s;
            self.recent.clear();
        } else {
            self.period_s += 0.05 * (passed_s - self.period_s);
        }
        self.last = Some(to);
        match (self.is_pressed(from[1]), self.is_pressed(x1)) {
            (false, false) => {
                if self.waiting.len() == REMEMBERED {
                    self.waiting.pop_front();
                }
                self.waiting.push_back(from);
                self.rest(self.waiting.front().map_or(from[0], |[t, _]| *t), tell);
            }
            (false, true) => {
                let began = self.waiting.iter().rposition(|[_, x]| *x < BEGAN_M).unwrap_or(0);
                let way: Vec<[f64; 2]> = self.waiting.drain(..).skip(began).chain([from, to]).collect();
                self.rest(way[0][0], tell);
                way.windows(2).for_each(|pair| self.play(pair[0], pair[1], tell));
            }
            (true, _) => self.play(from, to, tell),
        }
        if self.ahead {
            if self.recent.back().is_none_or(|[t, _]| *t < from[0]) {
                self.recent.push_back(from);
            }
            self.recent.push_back(to);
            while self.recent.get(1).is_some_and(|[t, _]| *t <= to[0] - SLOPE_S) {
                self.recent.pop_front();
            }
            if self.is_pressed(x1) {
                self.foresee(self.recent[0], to, tell);
            }
        }
        true
    }

    /// Whatever is sensed is taken to be at rest from now on; the key is followed until it is home.
    pub(crate) fn let_go(&mut self, now_s: f64, tell: &mut dyn FnMut(Told)) {
        let from_s = now_s.max(self.n as f64 * self.h);
        self.rest(from_s + HOME_S, tell);
        // Whatever holds the key down: no note is left.
        if self.announced.take().is_some() {
            tell(Told::False(from_s + HOME_S));
        }
        if self.notes.end() {
            tell(Told::Released(from_s + HOME_S, 0.0));
        }
        self.waiting.clear();
        self.recent.clear();
        self.last = self.last.map(|_| [from_s, 0.0]);
        self.way = None;
    }

    fn is_pressed(&self, value: f64) -> bool {
        value > if self.kind == SensorKind::Force { 0.0 } else { REST_M }
    }

    /// Takes notice of sensors that are stuck or noisy.
    fn watch(&mut self, [_, x0]: [f64; 2], [t1, x1]: [f64; 2]) {
        if x1 != x0 {
            (self.same_since_s, self.is_stuck) = (t1, false);
        } else if self.kind != SensorKind::Force
            && x1 > FLUTTER_M
            && x1 < self.limits.dip_m - FLUTTER_M
            && t1 - self.same_since_s > STUCK_S
            && !self.is_stuck
        {
            self.is_stuck = true;
            self.counts.stuck += 1;
        }
        self.way = match (self.way, self.is_pressed(x1)) {
            (None, true) => Some((x1, false)),
            (Some((high, limited)), true) => Some((high.max(x1), limited)),
            (Some((high, _)), false) => {
                self.counts.flutters += u64::from(high < FLUTTER_M && self.kind != SensorKind::Force);
                None
            }
            (None, false) => None,
        };
    }

    /// Plays until an instant, the sensor at rest.
    fn rest(&mut self, until_s: f64, tell: &mut dyn FnMut(Told)) {
        let until = (until_s / self.h) as u64;
        while self.n < until {
            if self.drive.is_away() && self.action.rests() && self.announced.is_none() {
                self.n = until;
                break;
            }
            self.step(None, tell);
        }
    }

    /// Plays from one sample to the next.
    fn play(&mut self, from: [f64; 2], to: [f64; 2], tell: &mut dyn FnMut(Told)) {
        let until = (to[0] / self.h + 1e-6) as u64;
        while self.n < until {
            let start_s = self.n as f64 * self.h;
            self.step(Some([start_s, start_s + self.h].map(|t| value_at(from, to, t))), tell);
        }
        self.counts.deep_samples += u64::from(self.kind == SensorKind::Action && to[1] > self.limits.dip_m + BEYOND_M);
    }

    /// One step, from the sensed values at its start and its end, where the sensor is not at rest.
    fn step(&mut self, sensed: Option<[f64; 2]>, tell: &mut dyn FnMut(Told)) {
        if sensed.is_some() && self.drive.begins() {
            let now = self.action.reading();
            self.action.place_hand(now.key_m, now.key_m_per_s);
        }
        let (input, is_limited) = self.drive.input(sensed, self.h, &self.action.reading());
        let reading = self.action.step(input);
        self.n += 1;
        let now_s = self.n as f64 * self.h;
        self.count(is_limited, reading.outcome, reading.impact.map_or(0.0, |hit| hit.hammer_speed_m_per_s));
        let hit = reading.impact.map(|i| [now_s + (i.time_s - self.action.time_s()), i.hammer_speed_m_per_s]);
        for event in self.notes.update(now_s, reading.key_m, hit).into_iter().flatten() {
            tell(match event {
                NoteEvent::On { time_s, hammer_m_per_s } => match self.announced.take() {
                    Some(Announced { hit, known_s }) => Told::Kept(hit, [time_s, hammer_m_per_s], known_s),
                    None => Told::Struck(time_s, hammer_m_per_s),
                },
                NoteEvent::Off { time_s, release_m_per_s } => Told::Released(time_s, release_m_per_s),
            });
        }
        if self.announced.is_some_and(|announced| announced.is_false(now_s)) {
            self.announced = None;
            tell(Told::False(now_s));
        }
    }

    fn count(&mut self, is_limited: bool, outcome: Outcome, hammer_m_per_s: f64) {
        let counts = &mut self.counts;
        counts.fast_steps += u64::from(is_limited);
        if let Some((_, was_limited)) = &mut self.way
            && is_limited
        {
            counts.fast_strokes += u64::from(!std::mem::replace(was_limited, true));
        }
        counts.non_finite += u64::from(outcome == Outcome::NonFinite);
        counts.fastest_m_per_s = counts.fastest_m_per_s.max(hammer_m_per_s);
    }

    /// Looks ahead, the key going on as over its last samples.
    fn foresee(&mut self, from: [f64; 2], to: [f64; 2], tell: &mut dyn FnMut(Told)) {
        let (now, now_s) = (self.action.reading(), self.n as f64 * self.h);
        let rises = now.hammer_m_per_s > RISES_M_PER_S;
        let near = rises && now.hammer_m + 1.5 * now.hammer_m_per_s * HORIZON_S > self.limits.blow_m;
        let is_soon = self.looked.is_some_and(|(at_s, _)| now_s < at_s + LOOK_EVERY_S);
        if !near || self.announced.is_some() {
            (self.looked, self.agreed_since_s) = (None, None);
            return;
        }
        if is_soon {
            return;
        }
        let found = self.look(from, to).map(|f| [now_s + f.in_s, f.hammer_m_per_s]);
        if let (Some((at_s, Some([t0, v0]))), Some([t1, v1])) = (self.looked, found)
            && let times = (t1 - now_s) / (now_s - at_s)
            && (t1 - t0).abs() * times < SETTLED[0]
            && (v1 / v0 - 1.0).abs() * times < SETTLED[1]
        {
            let since_s = *self.agreed_since_s.get_or_insert(at_s);
            if now_s - since_s >= SLOPE_S {
                self.announced = Some(Announced { hit: [t1, v1], known_s: now_s });
                tell(Told::Announced(t1, v1));
            }
        } else {
            self.agreed_since_s = None;
        }
        self.looked = Some((now_s, found));
    }

    fn look(&mut self, from: [f64; 2], to: [f64; 2]) -> Option<Foreseen> {
        let (mut drive, h, n) = (self.drive.clone(), self.h, self.n);
        look(&mut self.action, HORIZON_S, &mut |step, action| {
            let start_s = (n + u64::from(step) - 1) as f64 * h;
            let ends = [start_s, start_s + h].map(|t| value_beyond(from, to, t));
            drive.input(Some(ends), h, &action.reading()).0
        })
    }
}

/// Straight between two samples; before and after them as they are.
fn value_at([t0, x0]: [f64; 2], [t1, x1]: [f64; 2], t: f64) -> f64 {
    x0 + (x1 - x0) * ((t - t0) / (t1 - t0)).clamp(0.0, 1.0)
}

/// The same, going on after the second.
fn value_beyond([t0, x0]: [f64; 2], [t1, x1]: [f64; 2], t: f64) -> f64 {
    x0 + (x1 - x0) * ((t - t0) / (t1 - t0)).max(0.0)
}
