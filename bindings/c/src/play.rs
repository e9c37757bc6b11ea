//! An action in play: everything that may be called in real time. Nothing here allocates, locks, calls the system or
//! uses a clock.

use erard::player::{MechanismState, SNAPSHOT_MARK};
use erard::saved::{Lists, Writer};
use erard::{Action, Input, Settings, SnapshotError, StepOutcome};

use crate::reading::{ERARD_MAX_ADVANCE_S, ErardInput, ErardReading};
use crate::status::ErardStatus;

/// Share of a step that may be missing from a time that still counts as whole.
const NEARLY: f64 = 1e-6;

/// An action, its rest, and its last reading.
pub(crate) struct Play {
    pub action: Action,
    rest: MechanismState,
    /// Room for the state of modal strings before several steps.
    strings: Box<[u8]>,
    pub reading: ErardReading,
    /// Requested time not yet stepped, s: less than a step.
    owed_s: f64,
    /// Whether a step has begun and not ended, as after a panic.
    under_way: bool,
    pub zones: usize,
}

impl Play {
    pub(crate) fn new(action: Action, zones: usize) -> Self {
        let (rest, strings) = (action.mechanism_state(), vec![0; save_strings(&action, &mut [])].into());
        let mut play =
            Play { action, rest, strings, reading: ErardReading::default(), owed_s: 0.0, under_way: false, zones };
        play.look();
        play
    }

    /// Reads the present positions and speeds.
    fn look(&mut self) {
        let now = self.action.reading();
        self.reading = ErardReading {
            time_s: self.action.time_s(),
            key_m: now.key_m,
            key_m_per_s: now.key_m_per_s,
            hammer_rise_m: now.hammer_rise_m,
            hammer_rise_m_per_s: now.hammer_rise_m_per_s,
            hand_m: now.hand_m,
            hand_m_per_s: now.hand_m_per_s,
            ..self.reading
        };
    }

    /// Places the hand.
    pub fn place_hand(&mut self, position_m: f64, velocity_m_per_s: f64) {
        self.action.place_hand(position_m, velocity_m_per_s);
        self.look();
    }

    /// Takes one step. The input has been checked.
    #[inline(never)]
    pub(crate) fn step(&mut self, input: Input) -> ErardStatus {
        if self.under_way {
            return ErardStatus::Internal;
        }
        self.under_way = true;
        let before = self.reading.impact_count;
        let status = self.one(input);
        self.under_way = false;
        if status as i32 >= 0 {
            self.reading.new_impact_count = self.reading.impact_count.wrapping_sub(before);
            self.reading.finger_force_mean_n = self.reading.finger_force_n;
        }
        status
    }

    /// Takes as many steps as fit into `dt_s`; the rest counts for the next call.
    #[inline(never)]
    pub(crate) fn advance(&mut self, dt_s: f64, input: &ErardInput) -> ErardStatus {
        if !dt_s.is_finite() {
            return ErardStatus::NotFinite;
        }
        if !(0.0..=ERARD_MAX_ADVANCE_S).contains(&dt_s) {
            return ErardStatus::Range;
        }
        let first = match input.checked() {
            Err(status) => return status,
            Ok(_) if self.under_way => return ErardStatus::Internal,
            Ok(first) => first,
        };
        let h = self.action.settings().step;
        let owed_s = self.owed_s + dt_s;
        // Not negative, and at most a million.
        let steps = (owed_s / h + NEARLY) as u64;
        if steps == 0 {
            (self.owed_s, self.reading.new_impact_count) = (owed_s, 0);
            return ErardStatus::Ok;
        }
        let (before, read) = (self.action.mechanism_state(), self.reading);
        save_strings(&self.action, &mut self.strings);
        self.under_way = true;
        let (mut sum, mut impacts, mut status) = (0.0, 0, ErardStatus::Ok);
        for n in 0..steps {
            let one = self.one(first.later(n as f64 * h, h));
            if (one as i32) < 0 {
                // As if nothing had happened.
                let strings = Lists::read(&self.strings, SNAPSHOT_MARK);
                let restored = strings
                    .map(|strings| self.action.restore_from(&before, &|name, number| strings.each(name, number)));
                self.reading = read;
                self.under_way = !matches!(restored, Ok(Ok(())));
                return one;
            }
            if one == ErardStatus::IterationLimit {
                status = one;
            }
            sum += self.reading.finger_force_n;
            impacts += u32::from(self.action.impact().is_some());
        }
        self.under_way = false;
        self.owed_s = (owed_s - steps as f64 * h).max(0.0);
        self.reading.finger_force_mean_n = sum / steps as f64;
        self.reading.new_impact_count = impacts;
        status
    }

    /// Takes one step and its reading, without the parts for a whole call.
    #[inline]
    fn one(&mut self, input: Input) -> ErardStatus {
        let now = self.action.step(input);
        let status = match now.outcome {
            StepOutcome::Converged => ErardStatus::Ok,
            StepOutcome::IterationLimit => ErardStatus::IterationLimit,
            // Action and reading are unchanged.
            StepOutcome::NonFinite => return ErardStatus::NotFinite,
            StepOutcome::TooManyLaws => return ErardStatus::Internal,
        };
        let reading = &mut self.reading;
        if let Some(impact) = now.impact {
            (reading.impact_time_s, reading.hammer_speed_m_per_s) = (impact.time_s, impact.hammer_speed_m_per_s);
            reading.impact_count = reading.impact_count.wrapping_add(1);
        }
        reading.time_s = self.action.time_s();
        (reading.key_m, reading.key_m_per_s) = (now.key_m, now.key_m_per_s);
        (reading.hammer_rise_m, reading.hammer_rise_m_per_s) = (now.hammer_rise_m, now.hammer_rise_m_per_s);
        (reading.finger_force_n, reading.string_n) = (now.finger_force_n, now.string_n);
        (reading.hand_m, reading.hand_m_per_s) = (now.hand_m, now.hand_m_per_s);
        status
    }

    /// Returns to the initial state.
    #[inline(never)]
    pub(crate) fn reset(&mut self) -> ErardStatus {
        let Play { action, rest, .. } = self;
        // Without lists the strings are at rest.
        if action.restore_from(rest, &|_, _| 0).is_err() {
            return ErardStatus::Internal;
        }
        (self.reading, self.owed_s, self.under_way) = (ErardReading::default(), 0.0, false);
        self.look();
        ErardStatus::Ok
    }

    /// Number of bytes that [`Play::save`] writes.
    pub(crate) fn saved_bytes(&self) -> usize {
        self.save(&mut [])
    }

    /// Writes all that the following steps and readings depend on. Returns its number of bytes.
    #[inline(never)]
    pub(crate) fn save(&self, bytes: &mut [u8]) -> usize {
        let mut out = Writer::new(bytes, SNAPSHOT_MARK);
        self.write(&mut out);
        out.seal()
    }

    /// Writes its lists: a snapshot's, and those of the interface.
    pub(crate) fn write(&self, out: &mut Writer<'_>) {
        self.action.mechanism_state().write(out);
        self.action.save_strings(&mut |name, numbers| out.list(name, numbers));
        out.number("step_s", self.action.settings().step);
        out.number("owed_s", self.owed_s);
        let mut reading = self.reading;
        reading_lists(&mut reading, &mut |name, number| out.number(name, *number));
    }

    /// Restores a saved state.
    #[inline(never)]
    pub(crate) fn restore(&mut self, bytes: &[u8]) -> ErardStatus {
        match Lists::read(bytes, SNAPSHOT_MARK) {
            Ok(lists) => self.read(&lists),
            Err(_) => ErardStatus::Saved,
        }
    }

    /// Restores the state from these lists. A snapshot alone has the present step length, no pending time and no
    /// impact.
    pub(crate) fn read(&mut self, lists: &Lists<'_>) -> ErardStatus {
        let step_s = self.action.settings().step;
        if lists.number("step_s").is_some_and(|saved_s| saved_s != step_s) {
            return ErardStatus::Foreign;
        }
        let owed_s = lists.number("owed_s").unwrap_or(0.0);
        if !(0.0..=step_s).contains(&owed_s) {
            return ErardStatus::Saved;
        }
        let state = MechanismState::read(lists);
        if let Err(error) = self.action.restore_from(&state, &|name, number| lists.each(name, number)) {
            return status_of(error);
        }
        (self.owed_s, self.under_way) = (owed_s, false);
        self.reading = ErardReading::default();
        self.look();
        reading_lists(&mut self.reading, &mut |name, number| {
            if let Some(saved) = lists.number(name) {
                *number = saved;
            }
        });
        ErardStatus::Ok
    }

    /// Normal forces of the contact zones in the last step, N.
    #[inline(never)]
    pub(crate) fn contacts(&self, out: &mut [f64]) {
        let forces = (0..self.zones).filter_map(|zone| self.action.contact_force(zone).ok());
        out.iter_mut().zip(forces).for_each(|(place, force_n)| *place = force_n);
    }
}

/// Writes the state of modal strings alone. Returns its number of bytes.
fn save_strings(action: &Action, bytes: &mut [u8]) -> usize {
    let mut out = Writer::new(bytes, SNAPSHOT_MARK);
    action.save_strings(&mut |name, numbers| out.list(name, numbers));
    out.seal()
}

/// Names and numbers of a reading in a saved state.
fn reading_lists(reading: &mut ErardReading, number: &mut dyn FnMut(&'static str, &mut f64)) {
    let ErardReading {
        struct_size: _,
        reserved: _,
        time_s,
        key_m,
        key_m_per_s,
        finger_force_n,
        finger_force_mean_n,
        hammer_rise_m,
        hammer_rise_m_per_s,
        string_n,
        hand_m,
        hand_m_per_s,
        impact_time_s,
        hammer_speed_m_per_s,
        impact_count,
        new_impact_count,
    } = reading;
    number("read_time_s", time_s);
    number("read_key_m", key_m);
    number("read_key_m_per_s", key_m_per_s);
    number("read_finger_N", finger_force_n);
    number("read_finger_mean_N", finger_force_mean_n);
    number("read_hammer_m", hammer_rise_m);
    number("read_hammer_m_per_s", hammer_rise_m_per_s);
    number("read_string_N", string_n);
    number("read_hand_m", hand_m);
    number("read_hand_m_per_s", hand_m_per_s);
    number("read_impact_time_s", impact_time_s);
    number("read_hammer_speed_m_per_s", hammer_speed_m_per_s);
    for (name, count) in [("read_impact_count", impact_count), ("read_new_impact_count", new_impact_count)] {
        let mut float = f64::from(*count);
        number(name, &mut float);
        *count = float as u32;
    }
}

/// Status of a refused snapshot.
pub(crate) fn status_of(error: SnapshotError) -> ErardStatus {
    match error {
        SnapshotError::Instrument | SnapshotError::Settings { .. } => ErardStatus::Foreign,
        SnapshotError::NotFinite => ErardStatus::NotFinite,
        SnapshotError::Key(_) => ErardStatus::NoSuch,
        _ => ErardStatus::Saved,
    }
}

/// The usual settings with this step.
pub(crate) fn settings(step_s: f64) -> Settings<f64> {
    Settings::new(step_s)
}
