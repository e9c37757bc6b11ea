//! Search for a note's hand: hands are tried on the key in its real state until the hammer meets the string at the
//! written instant with the written speed.

use erard::level::HOLD_N;
use erard::{Progress, Snapshot};
use erard_midi::Law;

use crate::error::PerformError;
use crate::hand::Way;
use crate::key::{Key, Mark, Posture};
use crate::note::{Played, Reason};
use crate::release::Left;
use crate::score::WrittenNote;
use crate::seek::{self, CLOSE, Seek};
use crate::touches::{FORCES_N, Guess, RISES_S, Touches};

/// Error below which a note is good enough: counts of velocity and milliseconds together.
const GOOD: f64 = 1.0;
/// An instant is right within this, s.
const CLOSE_S: f64 = 0.2e-3;
/// Number of trials from one starting hand; from others, or when the note has to be late, there are as many again.
const TRIALS: u32 = 14;
const AGAIN: u32 = 8;
/// Delay with which a note that is farther off is tried again, s.
const LATER_S: [f64; 4] = [0.010, 0.020, 0.040, 0.080];
/// A key that was struck so shortly before is tried from one hand only, s: no action repeats 15 times a second.
const HOPELESS_S: f64 = 0.065;
/// So often.
const FEW: u32 = 5;
/// Number of trials of a note after which no more releases are tried.
const MOST: u32 = 120;
/// Fall from its highest point after which a hammer no longer meets the string, m.
const FALLEN_M: f64 = 5e-3;
/// Swing of the string under the felt, from side to side, above which it shifts the impact of a soft note, m.
const SOUNDS_M: f64 = 1e-4;
/// It rises when it is faster, m/s.
const RISES_M_PER_S: f64 = 0.05;
/// Time after an immediate release at which the key is home and the jack rests under the knuckle, s. An estimate; where
/// the key is slower, the trials find out.
const HOME_AGAIN_S: f64 = 0.070;
/// Longer times before a stroke at which the hand lets go where that is better for it, s, and how. Between them the
/// key, the hammer and the stack rebound: some times and ways suit a stroke. The last ones are as long as there is
/// time.
const LEADS: [(f64, Way); 12] = [
    (0.085, Way::QUICK),
    (0.1, Way::QUICK),
    (0.115, Way::QUICK),
    (0.13, Way::USUAL),
    (0.15, Way::USUAL),
    (0.17, Way::USUAL),
    (0.2, Way::USUAL),
    (0.2, Way::QUICK),
    (0.23, Way::USUAL),
    (0.27, Way::USUAL),
    (0.32, Way::USUAL),
    (0.32, Way::QUICK),
];
/// Time for which a hand stays on a key that it has played, s. An estimate: the hammer is in the check by then.
pub(crate) const STAYS_S: f64 = 0.020;

/// The state of a key before a stroke.
pub(crate) enum Ready {
    /// Its hand left it long ago.
    Home,
    /// Its hand left it as written, and it may not be at rest yet.
    Near(Box<Before>),
    /// It is held: the release is part of the stroke.
    Held(LetGo),
}

/// The time before a release.
pub(crate) struct Before {
    pub mark: Mark,
    /// How the hand left the key.
    pub left: Left,
    /// How it may.
    pub let_go: LetGo,
}

/// The release of the previous note, if it is part of this stroke. The note shall be silent when it ends; the hand may
/// let go earlier.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LetGo {
    /// The step in which the hand would leave as written.
    pub written: u64,
    /// It does not leave earlier.
    pub earliest: u64,
}

/// One trial.
struct Trial {
    rise: usize,
    force_n: f64,
    on_s: f64,
    /// How the hand left the key before, if that is part of the stroke.
    left: Option<Left>,
    begins: u64,
    posture: Posture,
    impact: Option<[f64; 2]>,
    /// Swing of its string under the felt before the press, from side to side, m.
    swing_m: f64,
    /// Whether there was no time to begin earlier.
    hurried: bool,
    start: Snapshot,
}

impl Trial {
    /// Its error: counts of velocity and milliseconds.
    fn cost(&self, wanted: &WrittenNote) -> f64 {
        match self.impact {
            Some([at_s, speed]) => {
                25.0 * (speed / wanted.speed_m_per_s).log2().abs() + 1e3 * (at_s - wanted.on_s).abs()
            }
            None => f64::INFINITY,
        }
    }

    fn is_close(&self, wanted: &WrittenNote) -> bool {
        self.impact.is_some_and(|[at_s, speed]| {
            let in_time = (at_s - self.on_s).abs() <= CLOSE_S || (self.hurried && at_s > self.on_s);
            (speed / wanted.speed_m_per_s).ln().abs() <= CLOSE && in_time
        })
    }
}

/// A note's hand, before its release.
pub(crate) struct Pressed {
    pub played: Played,
    /// State of the key when the hand began.
    pub start: Snapshot,
    /// Condition of the key at that moment.
    pub posture: Posture,
}

/// The search for one note's hand.
struct Search<'a, 'k, 'p, 'q> {
    key: &'a mut Key<'k>,
    touches: &'a mut Touches,
    law: &'a Law<'a>,
    wanted: WrittenNote,
    let_go: Option<LetGo>,
    /// Time before a stroke at which the hand lets go at the latest, s, and how.
    lead: (f64, Way),
    mark: Mark,
    trials: u32,
    best: Option<Trial>,
    /// Whether the best is the last one that was played.
    is_last: bool,
    /// Whether the loudest hand is too soft.
    is_loudest: bool,
    /// Nothing is played after this step.
    until: u64,
    progress: &'p mut Progress<'q>,
}

/// Plays a note from the key's present state. Afterwards the key is in its state at the impact, or at the instant where
/// it should have been. `next_s`: instant of the key's next note.
pub(crate) fn press(
    key: &mut Key<'_>,
    touches: &mut Touches,
    law: &Law<'_>,
    wanted: WrittenNote,
    ready: Ready,
    next_s: f64,
    progress: &mut Progress<'_>,
) -> Result<Pressed, PerformError> {
    let mark = key.mark();
    let (let_go, before) = match ready {
        Ready::Home => (None, None),
        Ready::Near(before) => (None, Some(before)),
        Ready::Held(let_go) => (Some(let_go), None),
    };
    let mut search = Search {
        key,
        touches,
        law,
        wanted,
        let_go,
        lead: (HOME_AGAIN_S, Way::QUICK),
        mark,
        trials: 0,
        best: None,
        is_last: true,
        is_loudest: false,
        until: u64::MAX,
        progress,
    };
    let first = search.first_rise();
    if let_go.is_some_and(|let_go| wanted.on_s < let_go.earliest as f64 * search.key.h() + HOPELESS_S - STAYS_S) {
        search.seek(search.guess(first), first, wanted.on_s, FEW)?;
        return search.finish();
    }
    for rise in first..RISES_S.len() {
        let most = if rise == first { TRIALS } else { AGAIN };
        // A quicker muscle is louder, and leaves the key more time to come home.
        search.is_loudest = search.seek(search.guess(rise), rise, wanted.on_s, most)?;
        if search.is_good() || (let_go.is_none() && !search.is_loudest) {
            break;
        }
    }
    if let_go.is_some() {
        search.seek_again()?;
    }
    search.leave_earlier(before)?;
    for later_s in LATER_S {
        // So late and right would be no better.
        let cost = search.best.as_ref().map_or(f64::INFINITY, |best| best.cost(&wanted));
        if cost < 1e3 * later_s + GOOD || wanted.on_s + later_s + STAYS_S > next_s {
            break;
        }
        search.seek(search.guess(first), first, wanted.on_s + later_s, AGAIN)?;
    }
    search.finish()
}

impl Search<'_, '_, '_, '_> {
    fn guess(&self, rise: usize) -> Guess {
        let speed = self.wanted.speed_m_per_s;
        if self.let_go.is_some() { self.touches.guess_moving(rise, speed) } else { self.touches.guess(rise, speed) }
    }

    /// The slowest muscle with which the key can be home before.
    fn first_rise(&self) -> usize {
        let Some(LetGo { earliest, .. }) = self.let_go else { return 0 };
        let last = RISES_S.len() - 1;
        let fits = |rise: &usize| {
            let takes_s = self.guess(*rise).takes_s;
            self.key.step_at(self.wanted.on_s - takes_s - HOME_AGAIN_S) >= earliest
        };
        (0..last).find(fits).unwrap_or(last)
    }

    fn is_good(&self) -> bool {
        self.best.as_ref().is_some_and(|best| best.cost(&self.wanted) < GOOD)
    }

    /// On a moving key the search may get stuck. It then starts again from other hands until one is good: the hand from
    /// rest, a stronger one, and the best so far.
    fn seek_again(&mut self) -> Result<(), PerformError> {
        let rise = RISES_S.len() - 1;
        let home = self.touches.guess(rise, self.wanted.speed_m_per_s);
        for stronger in [1.0, 1.5] {
            if !self.is_good() {
                let hand = Guess { force_n: stronger * home.force_n, takes_s: home.takes_s / stronger.sqrt(), ..home };
                self.seek(hand, rise, self.wanted.on_s, AGAIN)?;
            }
        }
        if let Some(best) = &self.best
            && best.impact.is_some()
            && !self.is_good()
        {
            let takes_s = best.on_s - best.begins as f64 * self.key.h();
            let (hand, rise) = (Guess { force_n: best.force_n, takes_s, is_known: true }, best.rise);
            self.seek(hand, rise, self.wanted.on_s, AGAIN)?;
        }
        Ok(())
    }

    /// Lets the key go earlier than written where the note is not good otherwise.
    fn leave_earlier(&mut self, before: Option<Box<Before>>) -> Result<(), PerformError> {
        // A key at rest whose string sounds is no better for it.
        let sounds = |best: &Trial| best.posture.was_home() && best.swing_m > SOUNDS_M;
        if self.is_good() || self.best.as_ref().is_some_and(sounds) {
            return Ok(());
        }
        if let Some(before) = before {
            let Before { mark, left, let_go } = *before;
            self.best.iter_mut().for_each(|best| best.left = Some(left));
            (self.mark, self.let_go) = (mark, Some(let_go));
        }
        let Some(LetGo { written, earliest }) = self.let_go else { return Ok(()) };
        let mut tried = Vec::new();
        for lead in LEADS {
            self.lead = lead;
            for rise in 0..RISES_S.len() {
                let guess = self.touches.guess(rise, self.wanted.speed_m_per_s);
                let leaves = self.key.step_at(self.wanted.on_s - guess.takes_s - lead.0).clamp(earliest, written);
                if tried.contains(&(rise, leaves, lead.1)) || self.trials > MOST {
                    continue;
                }
                tried.push((rise, leaves, lead.1));
                self.is_loudest = self.seek(guess, rise, self.wanted.on_s, AGAIN)?;
                if self.is_good() {
                    return Ok(());
                }
                // A quicker muscle is louder, and where there is no more time it leaves the key more of it.
                if !self.is_loudest && leaves > earliest {
                    break;
                }
            }
        }
        Ok(())
    }

    /// Tries hands of a rise time for an instant, s, from one on. Returns whether the loudest of them is too soft.
    fn seek(&mut self, guess: Guess, rise: usize, on_s: f64, most: u32) -> Result<bool, PerformError> {
        let wanted = self.wanted.speed_m_per_s;
        let mut hand = seek::Hand { force_n: guess.force_n, takes_s: guess.takes_s };
        let (mut seek, mut is_loudest) = (Seek::new(wanted, RISES_S[rise]), false);
        for _ in 0..most {
            let trial = self.play(rise, hand.force_n, on_s, hand.takes_s, None)?;
            let begins_s = trial.begins as f64 * self.key.h();
            // A hand that lets a held key go, and presses it after a fixed time, finds it in the same state whenever.
            let lead = self.key.step_at(self.lead.0);
            let is_alike = trial.left.is_some_and(|left| left.leaves + lead == trial.begins);
            let found = seek::Outcome {
                tried: hand,
                struck: trial.impact.map(|[at_s, speed]| [at_s - begins_s, speed]),
                late_s: trial.impact.map_or(0.0, |[at_s, _]| at_s - on_s),
                is_alike: is_alike || trial.posture.was_home(),
            };
            let is_close = trial.is_close(&self.wanted);
            is_loudest = hand.force_n >= FORCES_N[1] && trial.impact.is_some_and(|[_, speed]| speed < wanted);
            self.keep(trial);
            if is_close {
                return Ok(false);
            }
            match seek.next(&found) {
                Some(next) => hand = next,
                None => break,
            }
        }
        Ok(is_loudest)
    }

    fn keep(&mut self, trial: Trial) {
        let cost = trial.cost(&self.wanted);
        // Of two that do not sound the first: it was in time.
        self.is_last = self.best.as_ref().is_none_or(|best| cost < best.cost(&self.wanted));
        if self.is_last {
            self.best = Some(trial);
        }
    }

    /// One trial, from the mark; the hand leaves the key before as given, or as late as it may.
    fn play(
        &mut self,
        rise: usize,
        force_n: f64,
        on_s: f64,
        takes_s: f64,
        left: Option<Left>,
    ) -> Result<Trial, PerformError> {
        let Search { key, progress, .. } = self;
        if self.trials > 0 {
            key.back_to(&self.mark)?;
        }
        self.trials += 1;
        let mut floor = key.now();
        let mut begins = key.step_at(on_s - takes_s);
        let as_late = |LetGo { written, earliest }: LetGo| {
            let leaves = written.min(begins.saturating_sub(key.step_at(self.lead.0))).max(earliest).max(key.now());
            Left { leaves, way: self.lead.1 }
        };
        let left = left.or_else(|| self.let_go.map(as_late));
        if let Some(Left { leaves, way }) = left {
            key.advance(leaves, progress)?;
            key.hand.leave(leaves, key.h(), way);
            floor = leaves + 1;
        }
        let hurried = begins < floor;
        begins = begins.max(floor);
        key.advance(begins, progress)?;
        let (posture, before) = (key.posture(), key.impacts.len());
        key.touch(force_n, RISES_S[rise]);
        let start = key.snapshot();
        let until = self.until.min(begins + key.step_at(1.8 * takes_s + 0.06));
        let (mut rises, mut highest_m) = (false, f64::NEG_INFINITY);
        let mut swing_m = [f64::INFINITY, f64::NEG_INFINITY];
        while key.now() < until && key.impacts.len() == before {
            let string_m = key.string_m();
            swing_m = [swing_m[0].min(string_m), swing_m[1].max(string_m)];
            let now = key.step(progress)?;
            rises |= now.hammer_rise_m_per_s > RISES_M_PER_S;
            if rises {
                highest_m = highest_m.max(now.hammer_rise_m);
                if now.hammer_rise_m < highest_m - FALLEN_M {
                    break;
                }
            }
        }
        let impact = key.impacts.get(before).copied();
        if let Some([at_s, speed]) = impact
            && posture.was_home()
            && posture.jack_is_back
        {
            self.touches.learn(rise, force_n, at_s - begins as f64 * key.h(), speed);
        }
        let swing_m = (swing_m[1] - swing_m[0]).max(0.0);
        Ok(Trial { rise, force_n, on_s, left, begins, posture, impact, swing_m, hurried, start })
    }

    /// The best trial is the note.
    fn finish(mut self) -> Result<Pressed, PerformError> {
        let Some(mut best) = self.best.take() else { return Err(PerformError::Nothing) };
        if best.impact.is_none() {
            // The hand does not wait for what does not come.
            self.until = self.key.step_at(best.on_s).max(best.begins + 1);
        }
        if !self.is_last || best.impact.is_none() {
            let takes_s = best.on_s - best.begins as f64 * self.key.h();
            best = self.play(best.rise, best.force_n, best.on_s, takes_s, best.left)?;
        }
        let (wanted, key) = (self.wanted, self.key);
        let pressed_s = best.begins as f64 * key.h();
        if let (Some(_), Some([at_s, speed])) = (self.let_go, best.impact)
            && best.cost(&wanted) < GOOD
        {
            self.touches.learn_moving(best.rise, best.force_n, at_s - pressed_s, speed);
        }
        let mut played = Played::new(wanted, pressed_s, best.force_n, &best.posture).with_impact(best.impact, self.law);
        played.trials = self.trials;
        if best.hurried && best.impact.is_none_or(|[at_s, _]| at_s > wanted.on_s) {
            played.reasons.push(Reason::NoTime);
        }
        if best.swing_m > SOUNDS_M {
            played.reasons.push(Reason::StringSounds { swing_m: best.swing_m });
        }
        match best.impact {
            // From another state another hand may be louder.
            Some([_, reached_m_per_s]) if self.is_loudest && best.posture.was_home() => {
                played.reasons.push(Reason::TooLoud { reached_m_per_s });
            }
            _ if best.force_n <= 1.001 * FORCES_N[0] => played.reasons.push(Reason::TooSoft),
            _ => {}
        }
        let hold_n = if best.impact.is_some() { HOLD_N } else { HOLD_N.min(best.force_n) };
        key.hand.hold(key.now(), key.h(), hold_n);
        Ok(Pressed { played, start: best.start, posture: best.posture })
    }
}
