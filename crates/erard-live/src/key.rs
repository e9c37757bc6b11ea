//! One key of a stream: its action, and impacts that are announced in advance.

use std::collections::VecDeque;

use erard::instrument::Instrument;
use erard::player::ActionError;
use erard::{Action, Settings};
use erard_midi::Event;

use crate::action::{REMEMBERED, input};
use crate::ahead::{Announced, Foreseen, look};
use crate::drive::SensorKind;
use crate::limits::Limits;
use crate::report::ERRORS;
use crate::sensed::{Counts, GAP_S, Listen, SensedKey, Steps};

/// Largest lead of a predicted impact, s.
const HORIZON_S: f64 = 6e-3;
/// Smallest interval between two predictions, s.
const LOOK_EVERY_S: f64 = 0.5e-3;
/// Shortest span of the last samples from which the key's motion is continued, s: over a shorter one, the last digit of
/// a 12-bit sensor is a hundredth or more of a loud key's speed.
const SLOPE_S: f64 = 0.999e-3;
/// Impacts of slower hammers are not predicted, m/s.
const RISES_M_PER_S: f64 = 0.1;
/// Two predictions agree if the prediction, extrapolated from its last change, changes by less than this until the
/// impact: s, and a share of the speed. These are half of the allowed errors. Predictions are trusted once they have
/// agreed for [`SLOPE_S`], because a changing prediction may be stationary for a moment.
const SETTLED: [f64; 2] = [0.5 * ERRORS[0], 0.5 * ERRORS[1]];

/// An event of a key.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum KeyEvent {
    /// The hammer met the string: instant, s, and speed, m/s.
    Struck(f64, f64),
    /// The hammer will meet the string.
    Announced(f64, f64),
    /// An announced impact happened: the announced and the true one, each with instant, s, and speed, m/s; and the
    /// instant of the announcement, s.
    Kept([f64; 2], [f64; 2], f64),
    /// An announced impact did not happen: instant at which this is known, s.
    False(f64),
    /// The key set its damper down: instant, s, and speed on its way up, m/s, where it was seen.
    Released(f64, Option<f64>),
}

impl KeyEvent {
    /// An event that was not announced.
    pub(crate) fn of(event: Event) -> Self {
        match event {
            Event::On { time_s, hammer_speed_m_per_s } => KeyEvent::Struck(time_s, hammer_speed_m_per_s),
            Event::Off { time_s, release_m_per_s } => KeyEvent::Released(time_s, release_m_per_s),
        }
    }
}

/// Compares impacts with their announcements.
struct Announcing<'a> {
    announced: &'a mut Option<Announced>,
    steps: &'a mut u64,
    tell: &'a mut dyn FnMut(KeyEvent),
}

impl Listen for Announcing<'_> {
    fn note(&mut self, event: Event) {
        (self.tell)(match event {
            Event::On { time_s, hammer_speed_m_per_s } => match self.announced.take() {
                Some(Announced { hit, known_s }) => KeyEvent::Kept(hit, [time_s, hammer_speed_m_per_s], known_s),
                None => KeyEvent::Struck(time_s, hammer_speed_m_per_s),
            },
            Event::Off { time_s, release_m_per_s } => KeyEvent::Released(time_s, release_m_per_s),
        });
    }

    fn stepped(&mut self, now_s: f64) {
        *self.steps += 1;
        if self.announced.is_some_and(|announced| announced.is_false(now_s)) {
            self.let_go(now_s);
        }
    }

    fn waits(&self) -> bool {
        self.announced.is_some()
    }

    fn let_go(&mut self, at_s: f64) {
        if self.announced.take().is_some() {
            (self.tell)(KeyEvent::False(at_s));
        }
    }
}

pub(crate) struct Key {
    action: Action,
    sensed: SensedKey<f64, REMEMBERED>,
    ahead: bool,
    /// The last samples, over [`SLOPE_S`]; empty unless impacts are foreseen.
    recent: VecDeque<[f64; 2]>,
    announced: Option<Announced>,
    /// The last prediction: its instant, and the predicted instant and speed.
    looked: Option<(f64, Option<[f64; 2]>)>,
    /// Instant since when all predictions agree, s.
    agreed_since_s: Option<f64>,
    /// Steps taken.
    pub(crate) steps: u64,
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
            sensed: SensedKey::new(kind, limits, damper_m, action.settings().step),
            action,
            ahead,
            recent: VecDeque::new(),
            announced: None,
            looked: None,
            agreed_since_s: None,
            steps: 0,
        })
    }

    /// The last sample's value, m or N.
    pub(crate) fn value(&self) -> f64 {
        self.sensed.value()
    }

    /// Whether there was a sample of it.
    pub(crate) fn is_sensed(&self) -> bool {
        self.sensed.last.is_some()
    }

    /// Whether its sensor is at rest.
    pub(crate) fn is_up(&self) -> bool {
        self.sensed.is_up()
    }

    pub(crate) fn limits(&self) -> &Limits {
        &self.sensed.limits
    }

    /// The usual time between two samples, s.
    pub(crate) fn period_s(&self) -> f64 {
        self.sensed.period_s
    }

    pub(crate) fn counts(&self) -> Counts {
        self.sensed.counts
    }

    /// Takes a sample: instant, s, and value, m or N. Returns false and ignores the sample if it does not come after
    /// the last one.
    pub(crate) fn take(&mut self, to: [f64; 2], tell: &mut dyn FnMut(KeyEvent)) -> bool {
        let [t1, x1] = to;
        let (last, period_s) = (self.sensed.last, self.sensed.period_s);
        let mut listen = Announcing { announced: &mut self.announced, steps: &mut self.steps, tell };
        if !self.sensed.take((t1, x1), &mut self.action, &mut listen) {
            return false;
        }
        if self.ahead {
            let (mut t0, x0) = last.unwrap_or((t1 - period_s, 0.0));
            if t1 - t0 > GAP_S {
                t0 = t1 - period_s;
                self.recent.clear();
            }
            if self.recent.back().is_none_or(|[t, _]| *t < t0) {
                self.recent.push_back([t0, x0]);
            }
            self.recent.push_back(to);
            while self.recent.get(1).is_some_and(|[t, _]| *t <= to[0] - SLOPE_S) {
                self.recent.pop_front();
            }
            if self.sensed.is_pressed(x1) {
                self.foresee(self.recent[0], to, tell);
            }
        }
        true
    }

    /// Treats the sensor as being at rest from now on, and follows the key until it has come to rest.
    pub(crate) fn let_go(&mut self, now_s: f64, tell: &mut dyn FnMut(KeyEvent)) {
        let mut listen = Announcing { announced: &mut self.announced, steps: &mut self.steps, tell };
        self.sensed.let_go(now_s, &mut self.action, &mut listen);
        self.recent.clear();
    }

    /// Sets the clock of a key that was let go ahead to an instant, s.
    pub(crate) fn jump(&mut self, to_s: f64) {
        self.sensed.jump(to_s);
        (self.looked, self.agreed_since_s) = (None, None);
    }

    /// Predicts the impact, continuing the key's motion from its last samples.
    fn foresee(&mut self, from: [f64; 2], to: [f64; 2], tell: &mut dyn FnMut(KeyEvent)) {
        let (now, now_s) = (self.action.reading(), self.sensed.now_s());
        let rises = now.hammer_rise_m_per_s > RISES_M_PER_S;
        let near = rises && now.hammer_rise_m + 1.5 * now.hammer_rise_m_per_s * HORIZON_S > self.limits().blow_m;
        let is_soon = self.looked.is_some_and(|(at_s, _)| now_s < at_s + LOOK_EVERY_S);
        if !near || self.announced.is_some() {
            (self.looked, self.agreed_since_s) = (None, None);
            return;
        }
        if is_soon {
            return;
        }
        let found = self.look(from, to).map(|f| [now_s + f.in_s, f.hammer_speed_m_per_s]);
        if let (Some((at_s, Some([t0, v0]))), Some([t1, v1])) = (self.looked, found)
            && let times = (t1 - now_s) / (now_s - at_s)
            && (t1 - t0).abs() * times < SETTLED[0]
            && (v1 / v0 - 1.0).abs() * times < SETTLED[1]
        {
            let since_s = *self.agreed_since_s.get_or_insert(at_s);
            if now_s - since_s >= SLOPE_S {
                self.announced = Some(Announced { hit: [t1, v1], known_s: now_s });
                tell(KeyEvent::Announced(t1, v1));
            }
        } else {
            self.agreed_since_s = None;
        }
        self.looked = Some((now_s, found));
    }

    fn look(&mut self, from: [f64; 2], to: [f64; 2]) -> Option<Foreseen> {
        let (mut drive, h, n) = (self.sensed.drive.clone(), self.sensed.h, self.sensed.n);
        look(&mut self.action, HORIZON_S, &mut |step, action| {
            let start_s = (n + u64::from(step) - 1) as f64 * h;
            let ends = [start_s, start_s + h].map(|t| value_beyond(from, to, t));
            input(&drive.push(Some(ends), h, || action.hand()).0)
        })
    }
}

/// Linear extrapolation through two samples; constant before the first.
fn value_beyond([t0, x0]: [f64; 2], [t1, x1]: [f64; 2], t: f64) -> f64 {
    x0 + (x1 - x0) * ((t - t0) / (t1 - t0)).max(0.0)
}
