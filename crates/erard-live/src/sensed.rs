//! One key on its samples' clock: its drive and its notes. Without a heap, in either precision.

use erard_midi::{Crossing, Event, KeyNotes};
use moreau::Scalar;

use crate::drive::{BEYOND_M, Drive, Push, SensorKind};
use crate::limits::Limits;

/// A sensor nearer than this to its rest counts as being at rest, m; a key that leaves its rest is played from the
/// sample at which it did.
const REST_M: f64 = 0.15e-3;
/// A key leaves its rest after the last sample below this, m, as far back as samples are kept.
const BEGAN_M: f64 = 0.01e-3;
/// A key without samples for this time did not move meanwhile, s: the sender omitted it or stalled.
pub(crate) const GAP_S: f64 = 0.1;
/// The time between two samples before it is known, s.
const USUAL_PERIOD_S: f64 = 1e-3;
/// A key that is neither up nor down and does not move for this time is stuck, s.
const STUCK_S: f64 = 10.0;
/// A motion from the rest that stays below this is noise, m.
const FLUTTER_M: f64 = 0.5e-3;
/// Time for which a released key is followed, s.
pub(crate) const HOME_S: f64 = 1.0;
/// A stamp farther than this from its neighbours is wrong, s; a stream that is silent for longer has a gap.
pub const APART_S: f64 = 1.0;
/// The first key may have begun to move so long before a stream begins, s: a period.
pub(crate) const BEGINS_BEFORE_S: f64 = 0.01;

/// State at the end of an action's step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stepped<T> {
    /// Travel of the key's front, m.
    pub key_m: T,
    /// An impact in the step: its instant, s after the step's end (not positive), and the hammer's speed, m/s.
    pub hit: Option<(f64, T)>,
    /// Whether all numbers were finite; otherwise the action is unchanged.
    pub is_finite: bool,
}

/// The action of a key.
pub trait Steps<T> {
    /// Takes a step.
    fn step(&mut self, push: &Push<T>) -> Stepped<T>;
    /// Whether the last step changed nothing, so that without a push the next ones change nothing either.
    fn is_asleep(&self) -> bool;
    /// Place of the hand, m below the key's rest, and its speed, m/s.
    fn hand(&self) -> [T; 2];
    /// Lays the hand on the key, which it follows.
    fn lay_hand(&mut self);
}

/// Receives the events of a key.
pub trait Listen {
    /// A note begins or ends.
    fn note(&mut self, event: Event);
    /// A step has been taken up to an instant, s.
    fn stepped(&mut self, now_s: f64) {
        let _ = now_s;
    }
    /// Whether an event is expected, so that a key at rest must be stepped.
    fn waits(&self) -> bool {
        false
    }
    /// The key was released at an instant, s: no further event is expected.
    fn let_go(&mut self, at_s: f64) {
        let _ = at_s;
    }
}

/// Passes events on; releases were not seen.
struct Unseen<'a, L> {
    listen: &'a mut L,
    /// Instant at which the last note was ended, s.
    ended_s: f64,
}

impl<L: Listen> Unseen<'_, L> {
    fn end(&mut self, notes: &mut KeyNotes, time_s: f64) {
        if notes.end() {
            self.listen.note(Event::Off { time_s, release_m_per_s: None });
            self.ended_s = time_s;
        }
    }
}

impl<L: Listen> Listen for Unseen<'_, L> {
    fn note(&mut self, event: Event) {
        self.listen.note(match event {
            // A hammer that was on the string when its note was ended is reported when it leaves, and a damper when it
            // has landed: a key's events do not go back in time.
            Event::Off { time_s, .. } => Event::Off { time_s: time_s.max(self.ended_s), release_m_per_s: None },
            Event::On { time_s, hammer_speed_m_per_s } => {
                Event::On { time_s: time_s.max(self.ended_s), hammer_speed_m_per_s }
            }
        });
    }

    fn stepped(&mut self, now_s: f64) {
        self.listen.stepped(now_s);
    }

    fn waits(&self) -> bool {
        self.listen.waits()
    }

    fn let_go(&mut self, at_s: f64) {
        self.listen.let_go(at_s);
    }
}

impl<F: FnMut(Event)> Listen for F {
    fn note(&mut self, event: Event) {
        self(event);
    }
}

/// Counts of one key.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Counts {
    /// Steps that were limited.
    pub fast_steps: u64,
    /// Samples deeper than the key goes.
    pub deep_samples: u64,
    /// Motions from the rest in which the key was limited.
    pub fast_strokes: u32,
    /// Times without a sample while the key was off its rest.
    pub gaps: u32,
    /// Motions from the rest that were noise.
    pub flutters: u32,
    /// Number of times that the sensor stayed still between up and down.
    pub stuck: u32,
    /// Steps in which a number was not finite.
    pub non_finite: u64,
    /// The fastest hammer, m/s.
    pub fastest_m_per_s: f64,
}

/// A sample: instant, s, and value, m or N.
type At<T> = (f64, T);

/// The last samples, at most `W`.
#[derive(Debug, Clone)]
struct Ring<T, const W: usize> {
    kept: [At<T>; W],
    first: usize,
    count: usize,
}

impl<T: Scalar, const W: usize> Ring<T, W> {
    fn get(&self, index: usize) -> Option<At<T>> {
        (index < self.count).then(|| self.kept[(self.first + index) % W])
    }

    fn push(&mut self, sample: At<T>) {
        if self.count == W {
            (self.first, self.count) = ((self.first + 1) % W, W - 1);
        }
        self.kept[(self.first + self.count) % W] = sample;
        self.count += 1;
    }
}

/// One key. It keeps the last `W` samples at rest, because a press may have begun with them.
#[derive(Debug, Clone)]
pub struct SensedKey<T, const W: usize> {
    notes: KeyNotes,
    pub(crate) drive: Drive<T>,
    pub(crate) limits: Limits<T>,
    pub(crate) h: f64,
    /// Steps on the samples' clock.
    pub(crate) n: u64,
    pub(crate) last: Option<At<T>>,
    /// The sensed value at the end of the last step, unless the sensor was at rest.
    reached: Option<T>,
    waiting: Ring<T, W>,
    /// The usual time between two samples, s.
    pub(crate) period_s: f64,
    kind: SensorKind,
    /// In this way from the rest: its highest value, and whether it was limited.
    way: Option<(T, bool)>,
    /// Since when the value has been the same, s.
    same_since_s: f64,
    is_stuck: bool,
    /// What was counted.
    pub counts: Counts,
}

impl<T: Scalar, const W: usize> SensedKey<T, W> {
    /// At rest; steps of `step_s`, its damper set down at a travel of `damper_m`.
    pub fn new(kind: SensorKind, limits: Limits<T>, damper_m: f64, step_s: f64) -> Self {
        SensedKey {
            notes: KeyNotes::new(Crossing { damper_m }),
            drive: Drive::new(kind, limits),
            limits,
            h: step_s,
            n: 0,
            last: None,
            reached: None,
            waiting: Ring { kept: [(0.0, T::ZERO); W], first: 0, count: 0 },
            period_s: USUAL_PERIOD_S,
            kind,
            way: None,
            same_since_s: 0.0,
            is_stuck: false,
            counts: Counts::default(),
        }
    }

    /// The last sample's value, m or N.
    pub fn value(&self) -> T {
        self.last.map_or(T::ZERO, |(_, value)| value)
    }

    /// Whether its sensor is at rest.
    pub fn is_up(&self) -> bool {
        !self.is_pressed(self.value())
    }

    /// Instant up to which the key has been played, s on the samples' clock.
    pub fn now_s(&self) -> f64 {
        self.n as f64 * self.h
    }

    /// Takes a sample: instant, s, and value, m or N. Returns false and ignores the sample if it does not come after
    /// the last one.
    pub fn take(&mut self, to: At<T>, action: &mut impl Steps<T>, listen: &mut impl Listen) -> bool {
        let (t1, x1) = to;
        let mut from = self.last.unwrap_or((t1 - self.period_s, T::ZERO));
        if t1 <= from.0 {
            return false;
        }
        self.watch(from.1, to);
        let passed_s = t1 - from.0;
        if passed_s > GAP_S {
            self.counts.gaps += u32::from(self.is_pressed(from.1));
            from.0 = t1 - self.period_s;
        } else {
            self.period_s += 0.05 * (passed_s - self.period_s);
        }
        self.last = Some(to);
        match (self.is_pressed(from.1), self.is_pressed(x1)) {
            (false, false) => {
                self.waiting.push(from);
                self.rest(self.waiting.get(0).map_or(from.0, |(t, _)| t), action, listen);
            }
            (false, true) => {
                // The last of them at rest, or the first that is kept.
                let is_rest = |i: &usize| self.waiting.get(*i).is_some_and(|(_, x)| x < T::from_f64(BEGAN_M));
                let began = (0..self.waiting.count).rev().find(is_rest).unwrap_or(0);
                let mut before = self.waiting.get(began).unwrap_or(from);
                self.rest(before.0, action, listen);
                for i in began + 1..self.waiting.count {
                    let Some(next) = self.waiting.get(i) else { break };
                    self.play(before, next, action, listen);
                    before = next;
                }
                if self.waiting.count > 0 {
                    self.play(before, from, action, listen);
                }
                self.waiting.count = 0;
                self.play(from, to, action, listen);
            }
            (true, _) => self.play(from, to, action, listen),
        }
        true
    }

    /// Treats the sensor as being at rest from now on, and follows the key until it has come to rest. Its note ends
    /// now: nobody sees the key come up.
    pub fn let_go(&mut self, now_s: f64, action: &mut impl Steps<T>, listen: &mut impl Listen) {
        let from_s = now_s.max(self.now_s());
        let mut unseen = Unseen { listen, ended_s: f64::NEG_INFINITY };
        unseen.end(&mut self.notes, from_s);
        // A key that was let go before is followed no longer.
        let home_s = from_s.max(now_s + HOME_S);
        self.rest(home_s, action, &mut unseen);
        // Whatever holds the key down: no note is left.
        unseen.let_go(home_s);
        unseen.end(&mut self.notes, home_s);
        self.waiting.count = 0;
        self.last = self.last.map(|_| (from_s, T::ZERO));
        self.way = None;
    }

    /// Sets the clock of a key that was let go ahead to an instant, s. Nothing is simulated.
    pub fn jump(&mut self, to_s: f64) {
        self.n = self.n.max((to_s / self.h) as u64);
        (self.last, self.reached) = (None, None);
        self.same_since_s = to_s;
    }

    pub(crate) fn is_pressed(&self, value: T) -> bool {
        value > if self.kind == SensorKind::Force { T::ZERO } else { T::from_f64(REST_M) }
    }

    /// Detects sensors that are stuck or noisy.
    fn watch(&mut self, x0: T, (t1, x1): At<T>) {
        let flutter_m = T::from_f64(FLUTTER_M);
        if x1 != x0 {
            (self.same_since_s, self.is_stuck) = (t1, false);
        } else if self.kind != SensorKind::Force
            && x1 > flutter_m
            && x1 < self.limits.dip_m - flutter_m
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
                self.counts.flutters += u32::from(high < flutter_m && self.kind != SensorKind::Force);
                None
            }
            (None, false) => None,
        };
    }

    /// Plays until an instant, the sensor at rest.
    fn rest(&mut self, until_s: f64, action: &mut impl Steps<T>, listen: &mut impl Listen) {
        let until = (until_s / self.h) as u64;
        while self.n < until {
            if self.drive.is_away() && action.is_asleep() && !listen.waits() {
                (self.n, self.reached) = (until, None);
                break;
            }
            self.reached = None;
            self.step(None, action, listen);
        }
    }

    /// Plays from one sample to the next.
    fn play(&mut self, from: At<T>, to: At<T>, action: &mut impl Steps<T>, listen: &mut impl Listen) {
        let until = (to.0 / self.h + 1e-6) as u64;
        while self.n < until {
            // A step that begins before the segment does begins where the one before has ended.
            let start_s = self.now_s();
            let [start, end] = [start_s, start_s + self.h].map(|t| value_at(from, to, t));
            let start = self.reached.replace(end).unwrap_or(start);
            self.step(Some([start, end]), action, listen);
        }
        let deepest_m = self.limits.dip_m + T::from_f64(BEYOND_M);
        self.counts.deep_samples += u64::from(self.kind == SensorKind::Action && to.1 > deepest_m);
    }

    /// One step, from the sensed values at its start and its end, where the sensor is not at rest.
    #[inline(never)]
    fn step(&mut self, sensed: Option<[T; 2]>, action: &mut impl Steps<T>, listen: &mut impl Listen) {
        if sensed.is_some() && self.drive.begins() {
            action.lay_hand();
        }
        let (push, is_limited) = self.drive.push(sensed, T::from_f64(self.h), || action.hand());
        let after = action.step(&push);
        self.n += 1;
        let now_s = self.now_s();
        let hit = after.hit.map(|(after_s, speed)| [now_s + after_s, speed.to_f64()]);
        self.count(is_limited, after.is_finite, hit.map_or(0.0, |[_, speed]| speed));
        for event in self.notes.update(now_s, after.key_m.to_f64(), hit).into_iter().flatten() {
            listen.note(event);
        }
        listen.stepped(now_s);
    }

    fn count(&mut self, is_limited: bool, is_finite: bool, hammer_speed_m_per_s: f64) {
        let counts = &mut self.counts;
        counts.fast_steps += u64::from(is_limited);
        if let Some((_, was_limited)) = &mut self.way
            && is_limited
        {
            counts.fast_strokes += u32::from(!core::mem::replace(was_limited, true));
        }
        counts.non_finite += u64::from(!is_finite);
        counts.fastest_m_per_s = counts.fastest_m_per_s.max(hammer_speed_m_per_s);
    }
}

/// Linear interpolation between two samples; constant before and after them.
fn value_at<T: Scalar>((t0, x0): At<T>, (t1, x1): At<T>, t: f64) -> T {
    x0 + (x1 - x0) * T::from_f64(((t - t0) / (t1 - t0)).clamp(0.0, 1.0))
}
