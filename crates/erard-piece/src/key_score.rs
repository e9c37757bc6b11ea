//! One key through the whole piece.

use erard::Progress;
use erard::instrument::Instrument;
use erard_midi::Law;

use crate::error::PerformError;
use crate::hand::Hand;
use crate::key::Key;
use crate::moment::Moment;
use crate::note::Played;
use crate::options::Options;
use crate::press::{Before, LetGo, Pressed, Ready, STAYS_S, press};
use crate::release::release;
use crate::score::{Score, WrittenNote};
use crate::sink::Sink;
use crate::touches::Touches;

/// Time for which keys are simulated after the last note's end, s.
const TAIL_S: f64 = 1.0;
/// Interval at which rows are handed over then, s.
const BLOCK_S: f64 = 10.0;
/// Time that a key needs after a usual release, from the fall of its damper until it is at rest, s.
const HOME_S: f64 = 0.060;
/// Time after the fall of its damper within which a key's release is part of the next stroke, s: one that falls earlier
/// leaves the key at rest, whatever the hand does.
const NEAR_S: f64 = 0.2;
/// Longest time by which a hand lets a key go before the next stroke for the sake of that stroke, s.
const AHEAD_S: f64 = 0.45;

/// Shortest time between two strikes of a key, s: no action repeats 25 times a second, and the fastest players not two
/// thirds as often. A note sooner than that is not tried.
const SOONEST_S: f64 = 0.040;

/// The results of a key.
pub(crate) struct KeyPlayed {
    /// Its notes, with their numbers in the score, from 0.
    pub notes: Vec<(usize, Played)>,
    /// Notes kept for viewing.
    pub moments: Vec<Moment>,
    /// Steps taken, trials included, and the length of a step, s.
    pub steps: u64,
    pub step_s: f64,
}

/// The player of one key.
pub(crate) struct Player<'a, 'k> {
    key: Key<'k>,
    touches: Touches,
    law: &'a Law<'a>,
    notes: Vec<(usize, Played)>,
    /// The last one that was pressed, as an index.
    last: Option<usize>,
    /// Instant of the key's release, s, and its speed on the way up.
    off: (f64, Option<f64>),
    moments: Vec<Moment>,
    options: &'a Options,
    sink: &'a mut dyn Sink,
}

/// Plays these notes of a score, by their numbers, on one key.
pub(crate) fn play_key(
    (number, instrument, damper_m): (usize, &Instrument, f64),
    score: &Score<'_>,
    numbers: &[usize],
    options: &Options,
    sink: &mut dyn Sink,
    progress: &mut Progress<'_>,
) -> Result<KeyPlayed, PerformError> {
    let sound = options.sound.map(|heard| (heard, &options.knocks[..]));
    let key = Key::new(instrument, damper_m, &score.feet, options.row_s, sound)
        .map_err(|error| PerformError::Action { key: number, error })?;
    let mut player = Player {
        key,
        touches: Touches::default(),
        law: &score.law,
        notes: Vec::new(),
        last: None,
        off: (0.0, None),
        moments: Vec::new(),
        options,
        sink,
    };
    for (i, &note) in numbers.iter().enumerate() {
        let next_s = numbers.get(i + 1).map_or(f64::INFINITY, |&next| score.notes[next].on_s);
        player.play(note, score.notes[note], next_s, progress)?;
    }
    player.finish(score.duration_s + TAIL_S, progress)
}

impl Player<'_, '_> {
    /// Plays the next note.
    fn play(
        &mut self,
        number: usize,
        wanted: WrittenNote,
        next_s: f64,
        progress: &mut Progress<'_>,
    ) -> Result<(), PerformError> {
        let off = (wanted.off_s, wanted.release_m_per_s);
        if self.last.is_some() && wanted.on_s < self.key.now_s() + SOONEST_S {
            self.off = off;
            self.notes.push((number, Played::left_out(wanted, &self.key.posture())));
            return Ok(());
        }
        let guess = self.touches.guess(0, wanted.speed_m_per_s);
        let ready = self.make_ready(wanted.on_s - guess.takes_s, progress)?;
        if !matches!(ready, Ready::Held(_)) {
            let back_s = if guess.is_known { 1.25 * guess.takes_s + 0.015 } else { 1.5 * guess.takes_s + 0.05 };
            let from = self.key.step_at(wanted.on_s - back_s);
            self.key.advance(from, progress)?;
        }
        // Nobody goes back behind this, except for a release that is tried once more.
        if !matches!(ready, Ready::Near(_)) {
            self.key.flush_rows(self.sink, false)?;
        }
        let Pressed { played, start, posture } =
            press(&mut self.key, &mut self.touches, self.law, wanted, ready, next_s, progress)?;
        self.conclude(played.pressed_s, posture.was_checked);
        if let Hand::On { stroke, .. } = self.key.hand
            && self.is_of_interest(&played)
        {
            let (key, lift_m) = (wanted.key, self.key.lift_m());
            self.moments.push(Moment { note: number, key, start, stroke, pressed_s: played.pressed_s, lift_m });
        }
        self.off = off;
        self.last = Some(self.notes.len());
        self.notes.push((number, played));
        Ok(())
    }

    /// Releases the key for a hand that begins at an instant, s; where there is no time for that, the release becomes a
    /// part of the next stroke.
    fn make_ready(&mut self, begins_s: f64, progress: &mut Progress<'_>) -> Result<Ready, PerformError> {
        let Some(last) = self.last.map(|last| &self.notes[last].1) else { return Ok(Ready::Home) };
        let (off_s, release_m_per_s) = self.off;
        let struck_s = last.impact.map_or(self.key.now_s(), |[at_s, _]| at_s);
        let damped_s = off_s.max(struck_s + STAYS_S);
        if damped_s + NEAR_S <= begins_s {
            release(&mut self.key, &mut self.touches, off_s, release_m_per_s, progress)?;
            return Ok(Ready::Home);
        }
        let quick_s = self.touches.lag_s(crate::hand::Way::QUICK.within_s);
        let soonest = self.key.step_at(struck_s + STAYS_S).max(self.key.step_at(begins_s - AHEAD_S));
        let written = self.key.step_at(off_s - quick_s).max(soonest).max(self.key.now());
        // The key is held until then in any case.
        let earliest = soonest.min(written).max(self.key.now());
        self.key.advance(earliest, progress)?;
        let let_go = LetGo { written, earliest };
        if damped_s + HOME_S > begins_s {
            return Ok(Ready::Held(let_go));
        }
        self.key.flush_rows(self.sink, false)?;
        let mark = self.key.mark();
        let left = release(&mut self.key, &mut self.touches, off_s, release_m_per_s, progress)?;
        Ok(Ready::Near(Box::new(Before { mark, left, let_go })))
    }

    /// The result of the last note up to this instant, s, when the next hand begins or the piece ends.
    fn conclude(&mut self, until_s: f64, was_checked: bool) {
        let Some(last) = self.last.map(|last| &mut self.notes[last].1) else { return };
        let struck_s = last.impact.map_or(last.pressed_s, |[at_s, _]| at_s);
        let within = |[at_s, _]: &&[f64; 2]| *at_s > struck_s && *at_s < until_s;
        last.more_impacts = self.key.impacts.iter().filter(within).copied().collect();
        last.released = self.key.ups.iter().find(within).copied();
        last.checked = was_checked;
        self.key.forget_before(until_s);
    }

    /// Whether a note is kept for viewing: a few with faults, and a few without.
    fn is_of_interest(&self, played: &Played) -> bool {
        let is_wrong = |note: usize| self.notes.iter().any(|(n, played)| *n == note && !played.faults().is_empty());
        let wrong = self.moments.iter().filter(|moment| is_wrong(moment.note)).count();
        let right = self.moments.len() - wrong;
        if played.faults().is_empty() { right < self.options.moments } else { wrong < self.options.moments }
    }

    /// Releases the last note and plays on to the end, s.
    fn finish(mut self, end_s: f64, progress: &mut Progress<'_>) -> Result<KeyPlayed, PerformError> {
        if !self.key.hand.has_left() {
            let (off_s, speed) = self.off;
            release(&mut self.key, &mut self.touches, off_s, speed, progress)?;
        }
        // Block by block: nobody goes back any more.
        while self.key.now_s() < end_s {
            let to = self.key.step_at(end_s).min(self.key.now() + self.key.step_at(BLOCK_S));
            self.key.advance(to.max(self.key.now() + 1), progress)?;
            self.key.flush_rows(self.sink, false)?;
        }
        let was_checked = self.key.posture().was_checked;
        self.conclude(f64::INFINITY, was_checked);
        self.key.flush_rows(self.sink, true)?;
        let (steps, step_s) = (self.key.steps, self.key.h());
        Ok(KeyPlayed { notes: self.notes, moments: self.moments, steps, step_s })
    }
}
