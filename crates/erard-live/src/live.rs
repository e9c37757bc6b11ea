//! The keys of a piano, played by a stream.

use std::collections::BTreeSet;

use erard::Progress;
use erard::damper::DamperHeights;
use erard::instrument::Instrument;
use erard::keyboard::KEYS;
use erard_midi::{Law, ReleaseLaw, Velocity, message};
use erard_workshop::cores;

use crate::clock::{Clock, Taken};
use crate::contacts::{ContactKey, ContactLaw};
use crate::drive::SensorKind;
use crate::error::LiveError;
use crate::hammers::HammerKey;
use crate::key::{Key, KeyEvent};
use crate::limits::Limits;
use crate::profile::{Converter, Profile, Sensed};
use crate::quality::{Seen, expected_error_counts};
use crate::report::{Leads, Report};
use crate::sensed::{APART_S, BEGINS_BEFORE_S};
use crate::stream::{Of, Sample, SensorUnit};

/// The samples of a key come neither faster nor slower, s.
const SPACING_S: [f64; 2] = [10e-6, 0.2];
/// A sensor that has left its rest by a small amount this often is noisy.
const NOISY: u64 = 20;

/// Settings for playing a stream.
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// Kind of keyboard that carries the sensors.
    pub sensor: SensorKind,
    /// SensorUnit of the stream's numbers.
    pub quantity: SensorUnit,
    /// Distance of the sensed place from the key's pivot, m, on either side of it; `None` at the key's front.
    pub sensor_at_m: Option<f64>,
    /// The device's own travel, m, if it differs from that of a key; it is mapped to the key's dip.
    pub travel_m: Option<f64>,
    /// Whether impacts are announced in advance.
    pub ahead: bool,
    /// Keys that the stream moves, from 1, where that is known in advance; all keys if `None`. Samples of other keys
    /// are ignored and counted as uncalibrated.
    pub moved: Option<BTreeSet<usize>>,
    /// Number of threads that prepare the keys.
    pub threads: usize,
}

/// Event of a stream, to be sent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Event {
    /// A note-on.
    On {
        /// The key, from 1.
        key: usize,
        /// Instant at which its hammer meets the string, s on the stream's clock.
        time_s: f64,
        /// The instant up to which the stream is known, s: later than the impact, or earlier where it is announced.
        known_s: f64,
        /// Total speed of the hammer at the impact, m/s.
        hammer_speed_m_per_s: f64,
        /// This speed as a velocity.
        velocity: Velocity,
    },
    /// A note-off.
    Off {
        /// The key, from 1.
        key: usize,
        /// When, s.
        time_s: f64,
        /// Release velocity of the key; `None` where nobody saw it come up: the stream ended, stalled or has a gap, or
        /// an announced impact did not happen.
        release: Option<Velocity>,
    },
    /// A pedal.
    Pedal {
        /// Its controller.
        controller: u8,
        /// When, s.
        time_s: f64,
        /// 0 to 127.
        value: u8,
    },
}

/// The keys of a piano, played by a stream: samples in, notes out.
pub struct Live {
    /// From the lowest; `None` for a key that the stream does not move.
    keys: Vec<Option<Key>>,
    converters: Vec<Option<Converter<f64, Vec<[f64; 2]>>>>,
    /// Contacts of all keys, from the lowest.
    contacts: Option<(ContactLaw, Vec<ContactKey>)>,
    /// Sensed hammers, from the lowest; empty if others are sensed.
    hammers: Vec<Option<HammerKey<Vec<[f64; 2]>>>>,
    /// Ratio of each key: travel of its front per travel of the sensed place.
    front_per_sensed: Vec<f64>,
    pedals: [(u8, erard_midi::Pedal); 3],
    options: Options,
    begins_s: Option<f64>,
    clock: Clock,
    /// What is added to the stream's instants, s, so that they ascend over a new clock.
    shift_s: f64,
    now_s: f64,
    /// Lowest and highest travel of a key's front, m, or force, N.
    extremes: [f64; 2],
    seen: Seen,
    leads: Leads,
    report: Report,
}

impl Live {
    /// Prepares the keys of a keyboard that the stream moves; `instruments` are all its keys from the lowest. With a
    /// profile readings are converted by it. `progress` receives the share of keys that are done, and ends the work by
    /// returning false.
    ///
    /// # Errors
    /// [`LiveError`].
    pub fn new(
        instruments: &[Instrument],
        profile: Option<&Profile>,
        options: Options,
        progress: &mut Progress<'_>,
    ) -> Result<Self, LiveError> {
        if instruments.is_empty() || instruments.len() > KEYS {
            return Err(LiveError::Count { found: instruments.len() });
        }
        let contacts = profile.and_then(|profile| match &profile.sensed {
            Sensed::Contacts(law) => Some((**law, vec![ContactKey::new(); instruments.len()])),
            _ => None,
        });
        let hammers = profile.filter(|profile| matches!(profile.sensed, Sensed::Hammers(_)));
        let hammers: Vec<_> =
            hammers.iter().flat_map(|profile| (1..=instruments.len()).map(|key| profile.hammer(key))).collect();
        // The table of contacts was made of an action before, and a hammer is sensed itself.
        let instruments = if contacts.is_some() || !hammers.is_empty() { &[] } else { instruments };
        let silent: Vec<Instrument> = instruments.iter().map(|one| one.with_rigid_string().with_held_key()).collect();
        let moved: Vec<usize> =
            (1..=silent.len()).filter(|key| options.moved.as_ref().is_none_or(|moved| moved.contains(key))).collect();
        let dampers = DamperHeights::new(&silent);
        let found = cores::map(&moved, options.threads, progress, |&key, _| {
            let limits =
                Limits::find(&silent[key - 1], options.sensor).map_err(|error| LiveError::Action { key, error })?;
            Ok::<_, LiveError>((limits.ok_or(LiveError::Silent { key })?, dampers.of(key)?))
        })?;
        let mut keys: Vec<Option<Key>> = silent.iter().map(|_| None).collect();
        for (key, (limits, damper_m)) in moved.into_iter().zip(found) {
            let one = Key::new(&silent[key - 1], limits, damper_m, options.sensor, options.ahead);
            keys[key - 1] = Some(one.map_err(|error| LiveError::Action { key, error })?);
        }
        let converters = (1..=keys.len()).map(|key| profile.and_then(|profile| profile.converter(key))).collect();
        let front = |one: &Instrument| options.sensor_at_m.map_or(1.0, |at_m| (one.roles.key_front_m[0] / at_m).abs());
        let front_per_sensed = silent.iter().map(front).collect();
        let pedal = |controller: u8| (controller, erard_midi::Pedal::up());
        Ok(Live {
            keys,
            converters,
            front_per_sensed,
            pedals: [pedal(message::SUSTAIN), pedal(message::SOSTENUTO), pedal(message::SOFT)],
            options,
            begins_s: None,
            clock: Clock::new(contacts.is_some()),
            contacts,
            hammers,
            shift_s: 0.0,
            now_s: 0.0,
            extremes: [f64::INFINITY, f64::NEG_INFINITY],
            seen: Seen::default(),
            leads: Leads::default(),
            report: Report::default(),
        })
    }

    /// Largest inputs of a key, from 1.
    #[must_use]
    pub fn limits(&self, key: usize) -> Option<Limits> {
        self.keys.get(key.checked_sub(1)?)?.as_ref().map(|key| *key.limits())
    }

    /// Beginning of the stream, s on its own clock.
    #[must_use]
    pub fn begins_s(&self) -> f64 {
        self.begins_s.unwrap_or(0.0)
    }

    /// Whether no key is pressed, so that the stream may pause.
    #[must_use]
    pub fn are_up(&self) -> bool {
        self.keys.iter().flatten().all(Key::is_up) && self.hammers.iter().flatten().all(HammerKey::is_up)
    }

    /// Whether the sender is silent while nothing happens, so that its silence is no fault.
    #[must_use]
    pub fn is_sparse(&self) -> bool {
        self.contacts.is_some()
    }

    /// Takes a sample and returns the resulting events. A stamp more than a second from its neighbours is dropped.
    /// Where the stream has a gap of more than a second, or its clock begins anew, held notes end, and nothing is
    /// simulated meanwhile; instants go on a second after the last ones where a new clock goes back.
    pub fn take(&mut self, sample: &Sample, give: &mut dyn FnMut(Event)) {
        match self.clock.take(sample) {
            Taken::Waits => {}
            Taken::Next => self.take_next(sample, give),
            Taken::Jump(samples) => {
                samples.first().into_iter().for_each(|first| self.jump(first.time_s, give));
                samples.iter().for_each(|sample| self.take_next(sample, give));
            }
        }
    }

    /// Begins a new clock with the next sample, for the sender has begun anew; unless that sample's stamp follows the
    /// last one within a second.
    pub fn restart(&mut self) {
        self.clock.restart();
    }

    /// Jumps to an instant of the stream, s.
    fn jump(&mut self, to_s: f64, give: &mut dyn FnMut(Event)) {
        self.end_notes(give);
        let time_s = to_s - self.begins_s() + self.shift_s;
        let next_s = self.now_s + APART_S;
        if time_s < next_s {
            self.report.new_clocks += 1;
            self.shift_s += next_s + BEGINS_BEFORE_S - time_s;
        } else {
            self.report.stream_gaps += 1;
        }
        let time_s = time_s.max(next_s + BEGINS_BEFORE_S);
        self.keys.iter_mut().flatten().for_each(|key| key.jump(time_s - BEGINS_BEFORE_S));
    }

    fn take_next(&mut self, sample: &Sample, give: &mut dyn FnMut(Event)) {
        let begins_s = *self.begins_s.get_or_insert(sample.time_s - BEGINS_BEFORE_S);
        let time_s = sample.time_s - begins_s + self.shift_s;
        if time_s < 0.0 {
            self.report.out_of_order += 1;
            return;
        }
        let goes_back = time_s < self.now_s;
        self.now_s = self.now_s.max(time_s);
        self.after_bounces(give);
        match sample.of {
            Of::Pedal(controller) => {
                self.report.samples += 1;
                let own = self.pedals.iter_mut().find(|(own, _)| *own == controller);
                if let Some(value) = own.and_then(|(_, pedal)| pedal.update(sample.value)) {
                    give(Event::Pedal { controller, time_s: begins_s + time_s, value });
                }
            }
            Of::Key(number) | Of::Release(number) if !self.hammers.is_empty() => {
                let is_head = matches!(sample.of, Of::Key(_));
                self.take_hammer(number, is_head, time_s, sample.value, give);
            }
            Of::Release(_) => self.report.uncalibrated += 1,
            Of::Key(number) => self.take_key(number, time_s, sample.value, give),
            // Contacts have been taken to stay as they were until now: notes of an earlier edge would go back.
            Of::Contact(..) if goes_back => self.report.out_of_order += 1,
            Of::Contact(number, contact) => self.take_edge(number, contact, time_s, sample.value > 0.0, give),
        }
    }

    /// Takes a reading of a hammer, or of the sensor that sees its release.
    fn take_hammer(&mut self, number: usize, is_head: bool, time_s: f64, value: f64, give: &mut dyn FnMut(Event)) {
        let Live { hammers, leads, report, begins_s, .. } = self;
        let Some(Some(hammer)) = hammers.get_mut(number - 1) else {
            report.uncalibrated += 1;
            return;
        };
        let begins_s = begins_s.unwrap_or(0.0);
        let is_taken = {
            let mut tell = teller(number, begins_s, begins_s + time_s, leads, report, give);
            let mut send = |event| tell(KeyEvent::of(event));
            if is_head { hammer.take(time_s, value, &mut send) } else { hammer.take_release(time_s, value, &mut send) }
        };
        match is_taken {
            true => report.samples += 1,
            false if is_head || hammer.sees_release() => report.out_of_order += 1,
            false => report.uncalibrated += 1,
        }
    }

    /// Takes the edge of a key's contact, from 0.
    fn take_edge(&mut self, number: usize, contact: usize, time_s: f64, is_made: bool, give: &mut dyn FnMut(Event)) {
        let Live { contacts, leads, report, begins_s, .. } = self;
        let own = contacts.as_mut().filter(|(law, _)| contact < law.count);
        let Some((law, key)) = own.and_then(|(law, keys)| Some((law, keys.get_mut(number - 1)?))) else {
            report.uncalibrated += 1;
            return;
        };
        report.samples += 1;
        let begins_s = begins_s.unwrap_or(0.0);
        let mut tell = teller(number, begins_s, begins_s + time_s, leads, report, give);
        key.take(law, (contact, time_s, is_made), &mut |event| tell(KeyEvent::of(event)));
    }

    /// Contacts that stayed changed after their bounces.
    fn after_bounces(&mut self, give: &mut dyn FnMut(Event)) {
        let Live { contacts, leads, report, begins_s, now_s, .. } = self;
        let (begins_s, now_s) = (begins_s.unwrap_or(0.0), *now_s);
        let Some((law, keys)) = contacts else { return };
        for (index, key) in keys.iter_mut().enumerate() {
            let mut tell = teller(index + 1, begins_s, begins_s + now_s, leads, report, give);
            key.until(law, now_s, &mut |event| tell(KeyEvent::of(event)));
        }
    }

    fn take_key(&mut self, number: usize, time_s: f64, value: f64, give: &mut dyn FnMut(Event)) {
        let Some(value) = self.sensed(number, time_s, value) else {
            self.report.uncalibrated += 1;
            return;
        };
        let Live { keys, leads, report, seen, begins_s, extremes: [low, high], .. } = self;
        (*low, *high) = (low.min(value), high.max(value));
        let Some(key) = keys[number - 1].as_mut() else { return };
        let (before, begins_s) = (key.value(), begins_s.unwrap_or(0.0));
        if !key.take([time_s, value], &mut teller(number, begins_s, begins_s + time_s, leads, report, give)) {
            report.out_of_order += 1;
            return;
        }
        report.samples += 1;
        if value != before {
            seen.take(key.period_s(), value - before);
        }
    }

    /// A value as travel of the key's front, m, or force, N; `None` where there is no calibration for it.
    fn sensed(&mut self, number: usize, time_s: f64, value: f64) -> Option<f64> {
        let key = self.keys.get(number - 1)?.as_ref()?;
        let travel_m = match self.options.quantity {
            SensorUnit::Newtons | SensorUnit::Contacts => return Some(value),
            SensorUnit::Millimetres => 1e-3 * value,
            SensorUnit::Raw | SensorUnit::Pressure => self.converters[number - 1].as_mut()?.travel_m(time_s, value),
        };
        let own_m = match self.options.quantity {
            SensorUnit::Millimetres => self.options.travel_m,
            _ => self.converters[number - 1].as_ref().map(Converter::whole_m),
        };
        Some(match (self.options.sensor, own_m) {
            (SensorKind::Light, Some(own_m)) => travel_m * key.limits().dip_m / own_m,
            _ => travel_m * self.front_per_sensed[number - 1],
        })
    }

    /// Ends the stream: releases all keys and ends sounding notes.
    pub fn let_go(&mut self, give: &mut dyn FnMut(Event)) {
        self.clock.drop_waiting();
        self.end_notes(give);
        let ends_s = self.begins_s() + self.now_s;
        for (controller, pedal) in &mut self.pedals {
            if let Some(value) = pedal.update(0.0) {
                give(Event::Pedal { controller: *controller, time_s: ends_s, value });
            }
        }
    }

    /// Releases all keys, whose notes end.
    fn end_notes(&mut self, give: &mut dyn FnMut(Event)) {
        let Live { keys, contacts, hammers, leads, report, begins_s, now_s, .. } = self;
        let begins_s = begins_s.unwrap_or(0.0);
        for (index, key) in contacts.iter_mut().flat_map(|(_, keys)| keys.iter_mut().enumerate()) {
            let mut tell = teller(index + 1, begins_s, begins_s + *now_s, leads, report, give);
            key.let_go(*now_s, &mut |event| tell(KeyEvent::of(event)));
        }
        for (index, hammer) in hammers.iter_mut().enumerate() {
            let Some(hammer) = hammer else { continue };
            let mut tell = teller(index + 1, begins_s, begins_s + *now_s, leads, report, give);
            hammer.let_go(*now_s, &mut |event| tell(KeyEvent::of(event)));
        }
        for (index, key) in keys.iter_mut().enumerate() {
            let Some(key) = key else { continue };
            key.let_go(*now_s, &mut teller(index + 1, begins_s, begins_s + *now_s, leads, report, give));
        }
    }

    /// Handles a stalled sender: calls [`Live::let_go`] and counts it.
    pub fn stalled(&mut self, give: &mut dyn FnMut(Event)) {
        self.report.stalls += 1;
        self.let_go(give);
    }

    /// Why there is no note, where there is none; `dip_m` is a key's dip, m.
    fn silence(&self, dip_m: f64) -> Option<String> {
        let [low, high] = self.extremes;
        if self.report.note_ons > 0 {
            return None;
        }
        if self.report.samples == 0 || self.clock.dropped > self.report.samples {
            return self.nothing_taken();
        }
        if self.contacts.is_some() {
            return Some(self.silent_contacts());
        }
        if let Some(why) = self.wrong_unit_of_time() {
            return Some(why);
        }
        if !self.hammers.is_empty() {
            return Some(self.silent_hammers());
        }
        if low > high {
            return None;
        }
        let is_mm = self.options.quantity == SensorUnit::Millimetres;
        let [low_mm, high_mm, dip_mm] = [low, high, dip_m].map(|m| 1e3 * m);
        let up_mm = -low_mm;
        Some(match self.options.quantity {
            SensorUnit::Newtons if high <= 0.0 && low < 0.0 => {
                format!("forces go to {low:.1} N: is the sign inverted? A force downward is positive")
            }
            SensorUnit::Newtons => format!("no force threw a hammer to its string; the largest is {high:.2} N"),
            _ if high_mm < 0.3 * dip_mm && up_mm > 0.3 * dip_mm => format!(
                "keys move {up_mm:.1} mm above their rest: is the sign inverted? Travel is positive as the key goes down"
            ),
            _ if is_mm && (3.0..30.0).contains(&(1e3 * high_mm)) => {
                format!("the largest travel is {high_mm:.4} mm: are these metres? Expected mm, to {dip_mm:.1}")
            }
            _ if high_mm > 1.5 * dip_mm => format!(
                "keys move past their stops, to {high_mm:.1} mm of {dip_mm:.1}: is that the unit, and is it calibrated?"
            ),
            _ if high_mm < 0.75 * dip_mm => {
                format!("no key goes deep enough: the largest travel is {high_mm:.2} mm of {dip_mm:.1}")
            }
            _ => {
                format!("no key goes down fast enough to throw its hammer to the string; the deepest, {high_mm:.1} mm")
            }
        })
    }

    /// Why no sample was taken, where there are any.
    fn nothing_taken(&self) -> Option<String> {
        let Report { uncalibrated, out_of_order, .. } = self.report;
        match (self.clock.dropped, uncalibrated, out_of_order) {
            (0, 0, 0) => None,
            (0, 0, count) => Some(format!("none of {count} samples comes after the one before it")),
            (0, count, _) => Some(format!("none of {count} samples is of a key or contact that the calibration has")),
            (count, ..) => Some(format!(
                "the stamps of {count} samples lie more than a second from their neighbours: is the time in \
                 milliseconds or microseconds?"
            )),
        }
    }

    /// What the time between samples says of its unit, if it is none of a sensor's.
    fn wrong_unit_of_time(&self) -> Option<String> {
        let keys = self.keys.iter().flatten().filter(|key| key.is_sensed()).count()
            + self.hammers.iter().flatten().filter(|hammer| hammer.is_sensed()).count();
        if keys == 0 {
            return None;
        }
        let each_s = (self.now_s - BEGINS_BEFORE_S) * keys as f64 / self.report.samples as f64;
        let [fastest_s, slowest_s] = SPACING_S;
        let is_many = self.report.samples >= 20 * keys as u64;
        (is_many && !(fastest_s..=slowest_s).contains(&each_s)).then(|| {
            let (of, them) = if each_s < fastest_s { (1e6 * each_s, "us") } else { (1e3 * each_s, "ms") };
            format!("the samples of a key come {of:.1} {them} apart: is the time in milliseconds or microseconds?")
        })
    }

    /// Why contacts gave no note.
    fn silent_contacts(&self) -> String {
        let counts = || self.contacts.iter().flat_map(|(_, keys)| keys).map(|key| key.counts);
        let sum = |of: fn(&crate::contacts::ContactCounts) -> u64| counts().map(|one| of(&one)).sum::<u64>();
        if sum(|one| one.swapped) > 0 {
            "lower contacts close before upper ones: is contact 1 the one that closes first?".into()
        } else if sum(|one| one.untimed) > 0 {
            "the lowest contact closes, and none above it: are contacts missing, or numbered from below?".into()
        } else if sum(|one| one.slow) > 0 {
            "no key comes to its lowest contact fast enough to throw a hammer to its string".into()
        } else {
            "no key comes to its lowest contact; has the device as many contacts as its profile?".into()
        }
    }

    /// Why sensed hammers gave no note.
    fn silent_hammers(&self) -> String {
        let nearest = |(at, one): (usize, &Option<HammerKey<_>>)| Some((one.as_ref()?.counts.nearest_m, at + 1));
        let all = self.hammers.iter().enumerate().filter_map(nearest);
        let Some((nearest_m, key)) = all.min_by(|a, b| a.0.total_cmp(&b.0)) else {
            return "no hammer has stops".into();
        };
        match 1e3 * nearest_m {
            below_mm if below_mm > 2.0 => format!(
                "no hammer comes near its stop: the highest, that of key {key}, stays {below_mm:.1} mm below it; is the \
                 sign inverted, or the profile that of keys?"
            ),
            _ => "no hammer comes to its stop with a speed: all turn at the let-off".into(),
        }
    }

    /// Counts of the stream so far.
    #[must_use]
    pub fn report(&self) -> Report {
        let keys = || self.keys.iter().enumerate().filter_map(|(i, key)| Some((i + 1, key.as_ref()?)));
        let counts = || keys().map(|(_, key)| key.counts());
        let sum = |of: &dyn Fn(&crate::sensed::Counts) -> u64| counts().map(|c| of(&c)).sum::<u64>();
        let which = |is: &dyn Fn(&crate::sensed::Counts) -> bool| -> Vec<usize> {
            keys().filter(|(_, key)| is(&key.counts())).map(|(number, _)| number).collect()
        };
        let contacts = |of: &dyn Fn(&crate::contacts::ContactCounts) -> u64| {
            self.contacts.iter().flat_map(|(_, keys)| keys).map(|key| of(&key.counts)).sum::<u64>()
        };
        let heads = || self.hammers.iter().flatten();
        let converters = || self.converters.iter().flatten();
        let drifts = || converters().map(|one| (one.drift(), one.beyond())).chain(heads().map(HammerKey::drift));
        let dip_m = keys().next().map_or(0.0, |(_, key)| key.limits().dip_m);
        let rate_hz = self.seen.rate_hz();
        let bits = self.seen.bits(dip_m).filter(|_| self.options.quantity != SensorUnit::Newtons);
        Report {
            duration_s: self.now_s,
            dropped_stamps: self.clock.dropped,
            steps: keys().map(|(_, key)| key.steps).sum(),
            silence: self.silence(dip_m),
            lifts: heads().map(|one| one.counts.lifts).sum(),
            bounces: contacts(&|c| c.bounces),
            untimed_strokes: contacts(&|c| c.untimed),
            slow_strokes: contacts(&|c| c.slow),
            swapped_contacts: contacts(&|c| c.swapped),
            fast_strokes: contacts(&|c| c.fast),
            limited_strokes: sum(&|c| u64::from(c.fast_strokes)),
            limited_steps: sum(&|c| c.fast_steps),
            deep_samples: sum(&|c| c.deep_samples),
            gaps: sum(&|c| u64::from(c.gaps)),
            stuck_keys: which(&|c| c.stuck > 0),
            noisy_keys: which(&|c| u64::from(c.flutters) >= NOISY),
            non_finite_steps: sum(&|c| c.non_finite),
            fastest_hammer_m_per_s: counts()
                .map(|c| c.fastest_m_per_s)
                .chain(heads().map(|one| one.counts.fastest_m_per_s))
                .fold(0.0, f64::max),
            rate_hz,
            bits,
            expected_error_counts: bits.zip(rate_hz).map(|(bits, rate)| expected_error_counts(bits, rate)),
            largest_drift: drifts().map(|(drift, _)| drift.abs()).fold(0.0, f64::max),
            drifts_beyond: drifts().map(|(_, beyond)| beyond).sum(),
            ahead: if self.options.ahead { self.leads.table() } else { Vec::new() },
            ..self.report.clone()
        }
    }
}

/// Receives the events of a key, counts them and passes them on.
fn teller<'a>(
    key: usize,
    begins_s: f64,
    known_s: f64,
    leads: &'a mut Leads,
    report: &'a mut Report,
    give: &'a mut dyn FnMut(Event),
) -> impl FnMut(KeyEvent) + 'a {
    move |told| {
        let on = |time_s: f64, hammer_speed_m_per_s: f64| Event::On {
            key,
            time_s: begins_s + time_s,
            known_s,
            hammer_speed_m_per_s,
            velocity: Law::GOEBL.velocity(hammer_speed_m_per_s),
        };
        let off = |time_s: f64, m_per_s: Option<f64>| Event::Off {
            key,
            time_s: begins_s + time_s,
            release: m_per_s.map(|m_per_s| ReleaseLaw::USUAL.velocity(m_per_s)),
        };
        match told {
            KeyEvent::Struck(time_s, speed) => {
                leads.struck(speed);
                report.note_ons += 1;
                give(on(time_s, speed));
            }
            KeyEvent::Announced(time_s, speed) => {
                report.note_ons += 1;
                give(on(time_s, speed));
            }
            KeyEvent::Kept(told, hit, known_s) => leads.kept(told, hit, known_s),
            KeyEvent::False(time_s) => {
                report.false_announcements += 1;
                report.note_offs += 1;
                give(off(time_s, None));
            }
            KeyEvent::Released(time_s, speed) => {
                report.note_offs += 1;
                report.unseen_releases += u64::from(speed.is_none());
                give(off(time_s, speed));
            }
        }
    }
}
