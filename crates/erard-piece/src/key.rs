//! One key's action through the whole piece: its clock, its sleep, its hand and pedals, and its recorded rows.

use erard::grand::Anatomy;
use erard::instrument::Instrument;
use erard::knocks::{Knock, Knocks};
use erard::player::ActionError;
use erard::run::Heard;
use erard::{Action, Progress, Reading, Settings, Snapshot, StepOutcome};

use crate::error::PerformError;
use crate::hand::Hand;
use crate::score::{FULL_PEDAL_M, PedalMove};
use crate::sink::{Block, COLUMNS, Sample, Sink};

/// Samples of sound a second.
pub const RATE_HZ: u32 = 48_000;
/// A key is home within this travel, m.
pub(crate) const HOME_M: f64 = 0.5e-3;
/// Travel of a hammer that has not met its string yet, m. After an impact the real travel is known.
const USUAL_BLOW_M: f64 = 47e-3;
/// A jack turned farther than this from its place under the knuckle is not back, rad: a millimetre at its tip.
const JACK_RAD: f64 = 0.02;
/// Largest variation of a sleeping key's force on the bridge, N: 80 dB below a mezzo forte.
const QUIET_N: f64 = 1e-3;
/// Largest angular velocity of a sleeping key's bodies, rad/s.
const QUIET_RAD_PER_S: f64 = 0.02;
/// Time within these limits after which a key sleeps, s.
const QUIET_S: f64 = 0.02;
/// The pedal does not act on a sleeping key. Its rail moves to the pedal's position this long before its next hand, s:
/// five times the rail's time for its whole travel.
const WAKES_S: f64 = 0.08;
/// A key counts as being at rest if it has been ready for this time, s: its hand then acts as from rest.
const READY_S: f64 = 0.020;
/// Number of steps between tests whether the key has become quiet: not a multiple of any partial's period.
const QUIET_EVERY: u64 = 7;
/// Number of rows in a block.
const BLOCK: usize = 4096;
/// Largest number of rows that freely ringing strings are advanced at once.
const RINGING_ROWS: u64 = 1000;
/// Number of steps between questions to the caller whether to go on.
const ASK_EVERY: u64 = 512;

/// The parts that determine the condition of a key.
#[derive(Debug, Clone, Copy)]
struct Senses {
    /// The jack, what carries it, and the angle between them at rest, rad.
    jack: Option<(usize, usize, f64)>,
    check: Option<usize>,
    /// Travel of the key's front at which it sets its damper down, m.
    damper_m: f64,
}

/// A row of [`COLUMNS`].
fn row(at_s: f64, now: &Reading, heard_n: f64, rail_m: Option<f64>) -> [f64; COLUMNS.len()] {
    let Reading { key_m, key_m_per_s, finger_force_n, hammer_rise_m, hammer_rise_m_per_s, string_n, .. } = *now;
    [
        at_s,
        key_m,
        key_m_per_s,
        finger_force_n,
        hammer_rise_m,
        hammer_rise_m_per_s,
        string_n,
        heard_n,
        rail_m.unwrap_or(0.0),
    ]
}

/// Values kept from step to step.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Watch {
    /// The last step in which the key was not home, or the hammer not below the check.
    unready: Option<u64>,
    /// Whether the back check has caught the hammer since it struck.
    checked: bool,
    /// Height of the hammer at its string, m.
    blow_m: f64,
    key_m: f64,
    rail_m: f64,
    /// Last target of the rail, m.
    sent_m: f64,
    caught: bool,
    next_foot: usize,
    /// Force of what knocks, N, once a step has been taken.
    bed_n: Option<f64>,
    /// Smallest and largest force on the bridge since `since`, N.
    swing_n: [f64; 2],
    since: u64,
    quiet: bool,
}

/// Condition of a key when a hand begins to press it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Posture {
    pub key_m: f64,
    pub hammer_rise_m: f64,
    pub jack_is_back: bool,
    pub was_checked: bool,
    /// Key home and hammer below the check for this long, s.
    pub ready_s: f64,
}

impl Posture {
    /// Whether the key had been home, and the hammer below the check, for long enough.
    pub(crate) fn was_home(&self) -> bool {
        self.ready_s >= READY_S
    }
}

/// A state that can be restored.
pub(crate) struct Mark {
    snapshot: Snapshot,
    n: u64,
    hand: Hand,
    watch: Watch,
    impacts: usize,
    ups: usize,
    rows: usize,
    sounds: (usize, usize),
}

/// A key that is played.
pub(crate) struct Key<'a> {
    action: Action,
    senses: Senses,
    watch: Watch,
    feet: &'a [(f64, PedalMove)],
    n: u64,
    h: f64,
    theta: f64,
    pub hand: Hand,
    /// Every impact: instant, s, and speed, m/s.
    pub impacts: Vec<[f64; 2]>,
    /// Every release at which the key set its damper down: instant, s, and speed of the front, m/s.
    pub ups: Vec<[f64; 2]>,
    row_every: u64,
    rows: Vec<[f64; COLUMNS.len()]>,
    /// Sound, if requested: first sample and samples.
    sounds: Option<Vec<(u64, Vec<Sample>)>>,
    heard: Heard,
    knocks: Knocks,
    at_rest_n: f64,
    /// Steps taken, trials included.
    pub steps: u64,
}

impl<'a> Key<'a> {
    /// A key at rest. With `sound`, in steps of a sample.
    pub(crate) fn new(
        instrument: &Instrument,
        damper_m: f64,
        feet: &'a [(f64, PedalMove)],
        row_s: f64,
        sound: Option<(Heard, &[Knock])>,
    ) -> Result<Self, ActionError> {
        let sounds = sound.is_some() && instrument.has_yielding_strings();
        let step_s = if sounds { 1.0 / f64::from(RATE_HZ) } else { instrument.usual_step_s() };
        let action = Action::with(instrument, Settings::new(step_s))?;
        let anatomy = Anatomy::find(instrument).ok();
        let jack = anatomy.and_then(|parts| {
            let carrier = instrument.bodies[parts.jack].parent?;
            let angles = action.angles();
            Some((parts.jack, carrier, angles[parts.jack] - angles[carrier]))
        });
        let senses = Senses { jack, check: instrument.roles.check, damper_m };
        let (heard, asked) = sound.unwrap_or_default();
        let knocks = Knocks::of(instrument, if heard == Heard::Pressure { asked } else { &[] });
        let watch = Watch {
            unready: None,
            checked: true,
            blow_m: USUAL_BLOW_M,
            key_m: 0.0,
            rail_m: 0.0,
            sent_m: 0.0,
            caught: false,
            next_foot: 0,
            bed_n: None,
            swing_n: [f64::INFINITY, f64::NEG_INFINITY],
            since: 0,
            quiet: true,
        };
        let Settings { step: h, theta, .. } = *action.settings();
        Ok(Key {
            at_rest_n: bridge_n(&action),
            action,
            senses,
            watch,
            feet,
            n: 0,
            h,
            theta,
            hand: Hand::Away,
            impacts: Vec::new(),
            ups: Vec::new(),
            row_every: ((row_s / h).round() as u64).max(1),
            rows: Vec::new(),
            sounds: sounds.then(Vec::new),
            heard,
            knocks,
            steps: 0,
        })
    }

    pub(crate) fn now(&self) -> u64 {
        self.n
    }

    pub(crate) fn now_s(&self) -> f64 {
        self.n as f64 * self.h
    }

    pub(crate) fn h(&self) -> f64 {
        self.h
    }

    /// The first step that ends after an instant, s.
    pub(crate) fn step_at(&self, time_s: f64) -> u64 {
        (time_s / self.h).max(0.0).round() as u64
    }

    pub(crate) fn reading(&self) -> Reading {
        self.action.reading()
    }

    pub(crate) fn damper_m(&self) -> f64 {
        self.senses.damper_m
    }

    /// Lift that the key's rail is sent to, m.
    pub(crate) fn lift_m(&self) -> f64 {
        if self.watch.caught { FULL_PEDAL_M } else { self.watch.rail_m }
    }

    pub(crate) fn snapshot(&self) -> Snapshot {
        self.action.save()
    }

    /// Places a hand on the key, moving with it, and lets it press from now on.
    pub(crate) fn touch(&mut self, force_n: f64, rise_s: f64) {
        let now = self.action.reading();
        self.action.place_hand(now.key_m, now.key_m_per_s);
        self.hand = Hand::pressing(force_n, rise_s, self.n);
    }

    pub(crate) fn posture(&self) -> Posture {
        let now = self.action.reading();
        let angles = self.action.angles();
        let off = self.senses.jack.map_or(0.0, |(jack, carrier, rest)| (angles[jack] - angles[carrier] - rest).abs());
        let ready_s = self.watch.unready.map_or(f64::INFINITY, |last| self.n.saturating_sub(last) as f64 * self.h);
        Posture {
            key_m: now.key_m,
            hammer_rise_m: now.hammer_rise_m,
            jack_is_back: off < JACK_RAD,
            was_checked: self.watch.checked,
            ready_s,
        }
    }

    /// The string's displacement under the felt, m; 0 where strings are rigid.
    pub(crate) fn string_m(&self) -> f64 {
        self.action.strings().map_or(0.0, |strings| strings.displacement_m())
    }

    pub(crate) fn mark(&self) -> Mark {
        let sounds = self.sounds.as_ref().map_or((0, 0), |all| (all.len(), all.last().map_or(0, |(_, s)| s.len())));
        Mark {
            snapshot: self.action.save(),
            n: self.n,
            hand: self.hand,
            watch: self.watch,
            impacts: self.impacts.len(),
            ups: self.ups.len(),
            rows: self.rows.len(),
            sounds,
        }
    }

    pub(crate) fn back_to(&mut self, mark: &Mark) -> Result<(), PerformError> {
        self.action.restore(&mark.snapshot)?;
        (self.n, self.hand, self.watch) = (mark.n, mark.hand, mark.watch);
        self.impacts.truncate(mark.impacts);
        self.ups.truncate(mark.ups);
        self.rows.truncate(mark.rows);
        if let Some(sounds) = &mut self.sounds {
            sounds.truncate(mark.sounds.0);
            if let Some((_, last)) = sounds.last_mut() {
                last.truncate(mark.sounds.1);
            }
        }
        Ok(())
    }

    /// Advances to a step. A quiet key sleeps.
    pub(crate) fn advance(&mut self, to: u64, progress: &mut Progress<'_>) -> Result<(), PerformError> {
        while self.n < to {
            match self.sleeps_until(to) {
                Some(wakes) => {
                    self.n = wakes;
                    if self.can_skip() {
                        self.follow_feet();
                    }
                }
                None if self.rings(to) => {}
                None => drop(self.step(progress)?),
            }
        }
        Ok(())
    }

    /// Whether nothing touches the key and it is inaudible.
    fn can_skip(&self) -> bool {
        self.hand == Hand::Away && self.watch.quiet
    }

    /// The step until which its next steps would change nothing audible; `None`: it is awake.
    fn sleeps_until(&self, to: u64) -> Option<u64> {
        if !(self.is_left_alone() && (self.can_skip() || self.action.is_asleep())) {
            return None;
        }
        let foot = self.next_foot(to);
        let early = to.saturating_sub(self.step_at(WAKES_S));
        let wakes = match self.can_skip() {
            true if early > self.n => early,
            // As long as no pedal has moved it may sleep on.
            _ if self.watch.sent_m == self.lift_m() => foot,
            _ => self.n,
        };
        (wakes > self.n).then_some(wakes)
    }

    /// Whether hand and pedal are constant until a foot next moves.
    fn is_left_alone(&self) -> bool {
        self.rail_m().is_none_or(|now_m| now_m == self.watch.sent_m) && self.hand.is_steady(self.n, self.h)
    }

    /// Present lift of the pedal's rail, m; `None` without a rail.
    fn rail_m(&self) -> Option<f64> {
        self.action.strings().and_then(|strings| strings.pedal_m())
    }

    /// The step at which a foot moves next, at most `to`.
    fn next_foot(&self, to: u64) -> u64 {
        self.feet.get(self.watch.next_foot).map_or(to, |(at_s, _)| self.step_at(*at_s)).min(to)
    }

    /// Advances freely ringing strings from row to row while the rest of the key is still; returns whether it did.
    fn rings(&mut self, to: u64) -> bool {
        let begins = self.n.is_multiple_of(self.row_every) && self.watch.sent_m == self.lift_m();
        if !(begins && self.sounds.is_none() && self.is_left_alone()) {
            return false;
        }
        let rows = (self.next_foot(to).saturating_sub(self.n) / self.row_every).min(RINGING_ROWS);
        let now = self.action.reading();
        let (n, h, row_every, at_rest_n) = (self.n, self.h, self.row_every, self.at_rest_n);
        let mut rung = 0;
        let Key { action, rows: kept, .. } = self;
        let rang = rows > 0
            && action.ring(rows, row_every as f64 * h, &mut |strings| {
                rung += 1;
                let heard_n = strings.bridge_n() - at_rest_n;
                kept.push(row((n + rung * row_every) as f64 * h, &now, heard_n, strings.pedal_m()));
            });
        if rang {
            self.n += rows * row_every;
            self.record_rest(&now);
            self.wake();
            self.watch.quiet = self.action.strings().is_none_or(|strings| 2.0 * strings.largest_bridge_n() < QUIET_N);
        }
        rang
    }

    /// One step.
    pub(crate) fn step(&mut self, progress: &mut Progress<'_>) -> Result<Reading, PerformError> {
        if self.steps.is_multiple_of(ASK_EVERY) && !progress(0.0) {
            return Err(PerformError::interrupted());
        }
        self.move_feet();
        let input = self.hand.input(self.n, self.h, self.theta)?;
        let reading = self.action.step(input);
        if reading.outcome == StepOutcome::NonFinite {
            return Err(PerformError::NotFinite { time_s: self.now_s() });
        }
        self.n += 1;
        self.steps += 1;
        self.observe(&reading);
        Ok(reading)
    }

    /// Applies the pedal motions up to now.
    fn follow_feet(&mut self) {
        while let Some((at_s, foot)) = self.feet.get(self.watch.next_foot)
            && self.step_at(*at_s) <= self.n
        {
            self.watch.next_foot += 1;
            match *foot {
                PedalMove::Sustain(lift_m) => self.watch.rail_m = lift_m,
                PedalMove::Sostenuto(true) => {
                    self.watch.caught =
                        self.watch.key_m > self.senses.damper_m || self.watch.rail_m > 0.5 * FULL_PEDAL_M;
                }
                PedalMove::Sostenuto(false) => self.watch.caught = false,
            }
        }
    }

    fn move_feet(&mut self) {
        self.follow_feet();
        if self.watch.sent_m != self.lift_m() {
            self.watch.sent_m = self.lift_m();
            self.action.set_pedal(self.watch.sent_m);
            self.wake();
        }
    }

    /// Notes that the key is no longer quiet.
    fn wake(&mut self) {
        self.watch.quiet = false;
        self.watch.since = self.n;
        self.watch.swing_n = [f64::INFINITY, f64::NEG_INFINITY];
    }

    fn observe(&mut self, reading: &Reading) {
        let now_s = self.now_s();
        if let Some(impact) = reading.impact {
            self.impacts.push([now_s + (impact.time_s - self.action.time_s()), impact.hammer_speed_m_per_s]);
            (self.watch.checked, self.watch.blow_m) = (false, reading.hammer_rise_m);
        }
        self.record_rest(reading);
        if !self.watch.checked
            && self.senses.check.is_some_and(|zone| self.action.contact_force(zone).is_ok_and(|force_n| force_n > 0.0))
        {
            self.watch.checked = true;
        }
        let (before_m, at_m) = (self.watch.key_m, self.senses.damper_m);
        if before_m > at_m && reading.key_m <= at_m {
            let share = (reading.key_m - at_m) / (reading.key_m - before_m);
            self.ups.push([now_s - share * self.h, (before_m - reading.key_m) / self.h]);
        }
        self.watch.key_m = reading.key_m;
        let is_due = self.n.is_multiple_of(self.row_every);
        if is_due || self.sounds.is_some() {
            let heard_n = bridge_n(&self.action) - self.at_rest_n;
            if is_due {
                self.rows.push(row(now_s, reading, heard_n, self.rail_m()));
            }
            if let Some(sounds) = &mut self.sounds {
                let strings = match self.heard {
                    Heard::BridgeForce => [heard_n; 2],
                    heard => self.action.strings().map_or([0.0; 2], |strings| heard.now(strings)),
                };
                let bed_n = bed_n(&self.knocks, &self.action);
                let before_n = self.watch.bed_n.replace(bed_n).unwrap_or(bed_n);
                let sample = Sample { strings: strings.map(|x| x as f32), knocks_n: (bed_n - before_n) as f32 };
                // The sample that ends with this step.
                match sounds.last_mut() {
                    Some((from, samples)) if *from + samples.len() as u64 == self.n => samples.push(sample),
                    _ => sounds.push((self.n, vec![sample])),
                }
            }
        }
        if self.n.is_multiple_of(QUIET_EVERY) {
            self.record_sound();
        }
    }

    /// Updates the condition of key and hammer.
    fn record_rest(&mut self, reading: &Reading) {
        if reading.key_m > HOME_M || reading.hammer_rise_m > 0.5 * self.watch.blow_m {
            self.watch.unready = Some(self.n);
        }
    }

    /// Whether it has been quiet for long enough.
    fn record_sound(&mut self) {
        let now_n = bridge_n(&self.action);
        let Watch { swing_n: [least, most], .. } = &mut self.watch;
        (*least, *most) = (least.min(now_n), most.max(now_n));
        let moves = self.action.velocities().iter().any(|rate| rate.abs() > QUIET_RAD_PER_S);
        if moves || *most - *least > QUIET_N {
            self.wake();
        } else if (self.n - self.watch.since.min(self.n)) as f64 * self.h > QUIET_S {
            self.watch.quiet = true;
        }
    }

    /// Hands over complete blocks of rows, or `all` rows. The state cannot be restored to an instant before the rows
    /// that were handed over.
    pub(crate) fn flush_rows(&mut self, sink: &mut dyn Sink, all: bool) -> Result<(), PerformError> {
        if !self.rows.is_empty() && (all || self.rows.len() >= BLOCK) {
            sink.take(Block::Rows(std::mem::take(&mut self.rows)))?;
        }
        let samples = |sounds: &[(u64, Vec<Sample>)]| sounds.iter().map(|(_, one)| one.len()).sum::<usize>();
        if let Some(sounds) = &mut self.sounds
            && (all || samples(sounds) >= 16 * BLOCK)
        {
            for (from, samples) in sounds.drain(..) {
                sink.take(Block::Sound { from, samples })?;
            }
        }
        Ok(())
    }

    /// Forgets the impacts and releases before an instant, s.
    pub(crate) fn forget_before(&mut self, time_s: f64) {
        self.impacts.retain(|[at_s, _]| *at_s >= time_s);
        self.ups.retain(|[at_s, _]| *at_s >= time_s);
    }
}

fn bridge_n(action: &Action) -> f64 {
    action.strings().map_or(0.0, |strings| strings.bridge_n())
}

fn bed_n(knocks: &Knocks, action: &Action) -> f64 {
    knocks.force_n(|zone| action.contact_force(zone).unwrap_or_default())
}
