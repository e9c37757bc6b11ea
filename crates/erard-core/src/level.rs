//! Levels: the hammer speed at the string that a musician means by pp, p, mf, f or ff, and the hand that reaches it on
//! an instrument.
//!
//! A touch has one number that makes it louder ([`Touch::pressed`](HandStroke::pressed): the muscle's force;
//! [`struck`](HandStroke::struck): the speed of arrival). [`Reference::solve`] brackets it from below and closes the
//! bracket by false position (the Illinois rule, M. Dowell and P. Jarratt, BIT 11 (1971) 168) until the hammer's speed
//! is right to [`CLOSE`]. Every trial ends at the impact. Only additions, multiplications, divisions and the engine's
//! own functions are used, so that the hand has the same bits on every target.

use moreau::Settings;
use thiserror::Error;

use crate::instrument::Instrument;
use crate::mechanism::Impact;
use crate::player::{Action, ActionError, AtRest, Hand, HandError, Joints, RestPose, Snapshot, SnapshotError};
use crate::progress::{ASK_EVERY, Progress};
use crate::stroke::{HandStroke, Touch};

/// Names of levels and their hammer speeds at the string, m/s: equal ratios from 0.5 (pp) to 5 (ff), with mp, which has
/// no name here, between p and mf.
pub const LEVELS: [(&str, f64); 5] = [("pp", 0.5), ("p", 0.79), ("mf", 1.99), ("f", 3.15), ("ff", 5.0)];
/// A level is reached when the hammer's speed is right to this share.
pub const CLOSE: f64 = 1e-3;
/// Default mass of a hand, kg.
pub const MASS_KG: f64 = 0.2;
/// Force that holds the key down after the impact, N. An estimate.
pub const HOLD_N: f64 = 3.0;
/// The hand leaves the key at this instant, s, its force gone within [`RELEASE_S`].
pub const LET_GO_S: f64 = 0.5;
/// Time within which the force vanishes, s.
pub const RELEASE_S: f64 = 0.030;
/// Duration of a stroke with its release, s.
pub const DURATION_S: f64 = 1.0;

/// Time after which a stroke that has not sounded counts as silent, s: twice the longest published key stroke.
const PATIENCE_S: f64 = 0.4;
/// Fall of the hammer before an impact after which a stroke counts as silent, m.
const FALLEN_M: f64 = 5e-3;
/// The forces of a pressed hand, N. 100 N within [`crate::stroke::RISE_S`] are 50 N after 20 ms, which Timmermans and
/// Fisette (Machines 8 (2020) 76) ask of an actuator that is to play as a pianist does.
pub const FORCES_N: [f64; 2] = [0.2, 100.0];
/// The speeds with which a struck hand arrives, m/s. An estimate: faster than any finger.
pub(crate) const ARRIVALS_M_PER_S: [f64; 2] = [0.02, 5.0];
/// A bracket grows by this factor.
const GROWS: f64 = 1.4;
/// A bracket this narrow, as a ratio, without the speed in it contains a jump.
const NARROW: f64 = 1.0 + 1e-6;

/// The hammer speed of a level by its name, m/s.
#[must_use]
pub fn named(name: &str) -> Option<f64> {
    LEVELS.iter().find(|(known, _)| *known == name).map(|(_, speed_m_per_s)| *speed_m_per_s)
}

/// A hand that plays a level.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Solved {
    /// Stroke of the hand. It presses on after the impact.
    pub stroke: HandStroke,
    /// The impact.
    pub impact: Impact,
    /// The touch's number: the muscle's force, N, or the speed of arrival, m/s.
    pub louder: f64,
    /// Number of strokes that were tried.
    pub trials: u32,
}

impl Solved {
    /// The stroke that holds the key after the impact and never releases it.
    #[must_use]
    pub fn held(&self) -> HandStroke {
        self.stroke.holding(self.impact.time_s, HOLD_N)
    }

    /// The stroke that holds the key and leaves it at [`LET_GO_S`], its force gone within [`RELEASE_S`].
    #[must_use]
    pub fn whole(&self) -> HandStroke {
        self.held().leaving(LET_GO_S, RELEASE_S)
    }
}

/// Why there is no hand for a level.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum LevelError {
    /// The speed is no number that a hammer can have.
    #[error("a hammer speed of {found} m/s; expected a number from {} to {} m/s", SPEEDS_M_PER_S[0], SPEEDS_M_PER_S[1])]
    Speed {
        /// m/s.
        found: f64,
    },
    /// The mass is out of range, say.
    #[error(transparent)]
    Hand(#[from] HandError),
    /// The speed of arrival is no hand's.
    #[error("a hand that arrives with {found} m/s; expected a number from {} to {} m/s", ARRIVALS_M_PER_S[0], ARRIVALS_M_PER_S[1])]
    Arrival {
        /// m/s.
        found: f64,
    },
    /// The instrument has no key, no hammer or no string: there is no speed at the string.
    #[error("{instrument}: the hammer never reaches a string; expected an action with key, hammer and string")]
    Silent {
        /// Name of the instrument.
        instrument: String,
    },
    /// No hand of this kind reaches the speed.
    #[error(
        "{instrument}: no {touch} hand of {grams} g reaches {wanted} m/s; it reaches {} to {} m/s", .range[0], .range[1]
    )]
    OutOfReach {
        /// The instrument's name.
        instrument: String,
        /// The touch's name.
        touch: &'static str,
        /// The hand's mass, g.
        grams: f64,
        /// m/s.
        wanted: f64,
        /// The softest and the loudest hammer speed, m/s, to four digits.
        range: [f64; 2],
    },
    /// The speed lies in a jump: a little more of the touch's number, and the hammer is faster by a step.
    #[error(
        "{instrument}: no {touch} hand of {grams} g reaches {wanted} m/s: the hammer's speed jumps from {} to {} m/s", .nearest[0], .nearest[1]
    )]
    Jump {
        /// The instrument's name.
        instrument: String,
        /// The touch's name.
        touch: &'static str,
        /// The hand's mass, g.
        grams: f64,
        /// m/s.
        wanted: f64,
        /// On both sides of the jump, m/s.
        nearest: [f64; 2],
    },
    /// The instrument cannot be played.
    #[error(transparent)]
    Action(#[from] ActionError),
    /// A bug: the rest belongs to another action.
    #[error(transparent)]
    Rest(#[from] SnapshotError),
    /// A number became infinite.
    #[error("at {time_s:.6} s a number became infinite")]
    NonFinite {
        /// s.
        time_s: f64,
    },
    /// The caller asked to stop.
    #[error("interrupted")]
    Interrupted,
}

/// Range of hammer speeds, m/s: slower hammers do not reach a string, and no piano's are faster.
pub(crate) const SPEEDS_M_PER_S: [f64; 2] = [0.01, 20.0];

/// A touch with the mass of its hand, without the number that makes it louder.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HandKind {
    /// Pressed or struck.
    pub touch: Touch,
    /// The hand's mass, kg.
    pub mass_kg: f64,
    /// Joints of its finger.
    pub joints: Joints,
}

impl HandKind {
    /// A touch by a hand of this mass, kg, with the joints of the built-in touch.
    #[must_use]
    pub fn new(touch: Touch, mass_kg: f64) -> Self {
        HandKind { touch, mass_kg, joints: touch.joints() }
    }

    /// The stroke with this number: the muscle's force, N, or the speed of arrival, m/s.
    #[must_use]
    pub(crate) fn stroke(&self, louder: f64) -> HandStroke {
        let stroke = match self.touch {
            Touch::Pressed => HandStroke::pressed(self.mass_kg, louder),
            Touch::Struck => HandStroke::struck(self.mass_kg, louder),
        };
        HandStroke { hand: Hand { joints: self.joints, ..stroke.hand }, ..stroke }
    }

    /// The numbers between which a hand plays.
    #[must_use]
    pub(crate) fn ends(&self) -> [f64; 2] {
        match self.touch {
            Touch::Pressed => FORCES_N,
            Touch::Struck => ARRIVALS_M_PER_S,
        }
    }

    /// Where the bracket begins: half of what work and momentum ask of a key that is as heavy as 0.3 kg at its front,
    /// weighs 0.5 N and turns the hammer 5.5 times as fast. It moves the number of trials only.
    fn begins(&self, speed_m_per_s: f64) -> f64 {
        let key_m_per_s = speed_m_per_s / 5.5;
        let full = match self.touch {
            Touch::Pressed => 0.5 + (self.mass_kg + 0.3) * key_m_per_s * key_m_per_s / (2.0 * 8e-3),
            Touch::Struck => key_m_per_s * (self.mass_kg + 0.3) / self.mass_kg,
        };
        let [least, most] = self.ends();
        (0.5 * full).clamp(least, most)
    }
}

/// An instrument at rest on which hands are tried, in steps of its usual length.
pub struct Reference {
    instrument: String,
    action: Action,
    rest: Snapshot,
}

/// A trial: the touch's number and the hammer's speed, m/s; 0 where it does not sound.
type Trial = [f64; 2];

impl Reference {
    /// An instrument that comes to rest.
    ///
    /// # Errors
    /// See [`LevelError`].
    pub fn new(instrument: &Instrument, progress: &mut Progress<'_>) -> Result<Self, LevelError> {
        Reference::check(instrument)?;
        let action = Action::with_progress(instrument, Settings::new(instrument.usual_step_s()), progress)?;
        Ok(Reference { instrument: instrument.name.clone(), rest: action.save(), action })
    }

    /// [`Reference::new`] at a rest that has been found before.
    ///
    /// # Errors
    /// See [`LevelError`].
    pub fn at_rest(rest: &RestPose) -> Result<Self, LevelError> {
        let instrument = rest.instrument();
        Reference::check(instrument)?;
        let action = rest.action(Settings::new(instrument.usual_step_s()))?;
        Ok(Reference { instrument: instrument.name.clone(), rest: action.save(), action })
    }

    /// Whether an instrument can sound.
    fn check(instrument: &Instrument) -> Result<(), LevelError> {
        let roles = &instrument.roles;
        match (roles.key, roles.hammer, roles.string) {
            (Some(_), Some(_), Some(_)) => Ok(()),
            _ => Err(LevelError::Silent { instrument: instrument.name.clone() }),
        }
    }

    /// The first impact of a stroke; `None` where it does not sound.
    ///
    /// # Errors
    /// [`LevelError::Hand`], [`LevelError::NonFinite`], [`LevelError::Interrupted`], [`LevelError::Rest`].
    pub fn impact(&mut self, stroke: &HandStroke, progress: &mut Progress<'_>) -> Result<Option<Impact>, LevelError> {
        stroke.hand.check()?;
        self.action.restore(&self.rest)?;
        self.action.begin_at(0.0);
        self.action.place_hand(stroke.hand.start_m, stroke.hand.start_m_per_s);
        let Settings { step: h, theta, .. } = *self.action.settings();
        let mut highest_m: f64 = 0.0;
        for n in 0..(PATIENCE_S / h) as u64 {
            if n.is_multiple_of(ASK_EVERY) && !progress(0.0) {
                return Err(LevelError::Interrupted);
            }
            let t = n as f64 * h;
            let reading = self.action.step(stroke.hand.input(&stroke.input(t + theta * h))?);
            if reading.outcome == moreau::StepOutcome::NonFinite {
                return Err(LevelError::NonFinite { time_s: t });
            }
            if reading.impact.is_some() {
                return Ok(reading.impact);
            }
            highest_m = highest_m.max(reading.hammer_rise_m);
            if reading.hammer_rise_m < highest_m - FALLEN_M {
                return Ok(None);
            }
        }
        Ok(None)
    }

    /// The hand whose hammer meets the string at a speed, m/s.
    ///
    /// # Errors
    /// See [`LevelError`].
    pub fn solve(
        &mut self,
        kind: HandKind,
        speed_m_per_s: f64,
        progress: &mut Progress<'_>,
    ) -> Result<Solved, LevelError> {
        if !(SPEEDS_M_PER_S[0]..=SPEEDS_M_PER_S[1]).contains(&speed_m_per_s) {
            return Err(LevelError::Speed { found: speed_m_per_s });
        }
        kind.stroke(kind.ends()[0]).hand.check()?;
        let mut search = Search { reference: self, kind, wanted: speed_m_per_s, trials: 0, progress };
        match search.bracket()? {
            Bracket::Found(solved) => Ok(solved),
            Bracket::Between(low, high) => search.close(low, high),
            Bracket::Beyond => Err(search.out_of_reach()?),
        }
    }

    /// The struck hand with the mass and the joints of `kind` that arrives with a speed, m/s, without a search for the
    /// hammer speed. A silent one begins to hold the key after the longest time of a trial.
    ///
    /// # Errors
    /// See [`LevelError`]: [`LevelError::Arrival`], and none of a level.
    pub fn strike(
        &mut self,
        kind: HandKind,
        speed_m_per_s: f64,
        progress: &mut Progress<'_>,
    ) -> Result<Solved, LevelError> {
        if !(ARRIVALS_M_PER_S[0]..=ARRIVALS_M_PER_S[1]).contains(&speed_m_per_s) {
            return Err(LevelError::Arrival { found: speed_m_per_s });
        }
        let stroke = HandKind { touch: Touch::Struck, ..kind }.stroke(speed_m_per_s);
        let impact = self.impact(&stroke, progress)?.unwrap_or(Impact {
            time_s: PATIENCE_S,
            hammer_speed_m_per_s: 0.0,
            hammer_speed_normal_m_per_s: 0.0,
        });
        Ok(Solved { stroke, impact, louder: speed_m_per_s, trials: 1 })
    }

    /// The softest and the loudest stroke of a kind of hand: the softest to a thousandth of its number, the loudest of
    /// those tried on the way down from the strongest in ratios of 1.4.
    ///
    /// # Errors
    /// See [`LevelError`]; [`LevelError::Silent`] where the strongest does not sound.
    pub fn range(&mut self, kind: HandKind, progress: &mut Progress<'_>) -> Result<[Solved; 2], LevelError> {
        kind.stroke(kind.ends()[0]).hand.check()?;
        let mut search = Search { reference: self, kind, wanted: SPEEDS_M_PER_S[0], trials: 0, progress };
        search.range()
    }
}

/// A search for one level.
struct Search<'a, 'p> {
    reference: &'a mut Reference,
    kind: HandKind,
    wanted: f64,
    trials: u32,
    progress: &'a mut Progress<'p>,
}

/// What came of a search for a bracket.
enum Bracket {
    /// A trial was close enough.
    Found(Solved),
    /// Below and at or above the speed.
    Between(Trial, Trial),
    /// The whole family lies on one side.
    Beyond,
}

impl Search<'_, '_> {
    /// One trial.
    fn play(&mut self, louder: f64) -> Result<(Trial, Option<Solved>), LevelError> {
        let stroke = self.kind.stroke(louder);
        let impact = self.reference.impact(&stroke, self.progress)?;
        self.trials += 1;
        let solved = impact.map(|impact| Solved { stroke, impact, louder, trials: self.trials });
        Ok(([louder, impact.map_or(0.0, |impact| impact.hammer_speed_m_per_s)], solved))
    }

    /// A trial that is close enough.
    fn is_close(&self, [_, speed]: Trial) -> bool {
        (speed - self.wanted).abs() <= CLOSE * self.wanted
    }

    /// Starts at the estimate from work and momentum, and goes down until a trial is below the speed, or up until one
    /// is above it.
    fn bracket(&mut self) -> Result<Bracket, LevelError> {
        let [least, most] = self.kind.ends();
        let (mut trial, mut solved) = self.play(self.kind.begins(self.wanted))?;
        let rises = trial[1] < self.wanted;
        loop {
            if let Some(solved) = solved.filter(|_| self.is_close(trial)) {
                return Ok(Bracket::Found(solved));
            }
            let [louder, _] = trial;
            if louder == if rises { most } else { least } {
                return Ok(Bracket::Beyond);
            }
            let next = if rises { (louder * GROWS).min(most) } else { (louder / GROWS).max(least) };
            let (tried, found) = self.play(next)?;
            match rises {
                true if tried[1] >= self.wanted && !self.is_close(tried) => return Ok(Bracket::Between(trial, tried)),
                false if tried[1] < self.wanted && !self.is_close(tried) => return Ok(Bracket::Between(tried, trial)),
                _ => (trial, solved) = (tried, found),
            }
        }
    }

    /// Closes a bracket. Where the lower end does not sound yet, by halves; else by false position.
    fn close(&mut self, mut low: Trial, mut high: Trial) -> Result<Solved, LevelError> {
        // Weights of the ends' errors, halved where an end stays (Illinois).
        let mut weights = [1.0, 1.0];
        while high[0] > low[0] * NARROW {
            let [below, above] = [weights[0] * (self.wanted - low[1]), weights[1] * (high[1] - self.wanted)];
            let share = if low[1] > 0.0 { (below / (below + above)).clamp(0.02, 0.98) } else { 0.5 };
            let (trial, solved) = self.play(low[0] + share * (high[0] - low[0]))?;
            if let Some(solved) = solved.filter(|_| self.is_close(trial)) {
                return Ok(solved);
            }
            if trial[1] < self.wanted {
                (low, weights) = (trial, [1.0, 0.5 * weights[1]]);
            } else {
                (high, weights) = (trial, [0.5 * weights[0], 1.0]);
            }
        }
        if low[1] > 0.0 {
            let nearest = [low, high].map(|[_, speed]| digits(speed));
            let (instrument, touch, grams) = self.names();
            return Err(LevelError::Jump { instrument, touch, grams, wanted: self.wanted, nearest });
        }
        Err(self.out_of_reach()?)
    }

    /// The range of speeds of this kind of hand.
    fn range(&mut self) -> Result<[Solved; 2], LevelError> {
        let [least, most] = self.kind.ends();
        let Some(loudest) = self.play(most)?.1 else {
            return Err(LevelError::Silent { instrument: self.reference.instrument.clone() });
        };
        // Down until it sounds no longer, then by halves. A hand that arrives too fast throws the hammer off the jack:
        // the loudest is not the fastest.
        let (mut softest, mut silent, mut loudest) = (loudest, None, loudest);
        while silent.is_none() && softest.louder > least {
            let louder = (softest.louder / GROWS).max(least);
            match self.play(louder)?.1 {
                Some(solved) => {
                    softest = solved;
                    if solved.impact.hammer_speed_m_per_s > loudest.impact.hammer_speed_m_per_s {
                        loudest = solved;
                    }
                }
                None => silent = Some(louder),
            }
        }
        while let Some(below) = silent
            && softest.louder > below * (1.0 + CLOSE)
        {
            let louder = 0.5 * (below + softest.louder);
            match self.play(louder)?.1 {
                Some(solved) => softest = solved,
                None => silent = Some(louder),
            }
        }
        Ok([softest, loudest])
    }

    fn names(&self) -> (String, &'static str, f64) {
        let HandKind { touch, mass_kg, .. } = self.kind;
        (self.reference.instrument.clone(), touch.name(), digits(mass_kg * 1e3))
    }

    fn out_of_reach(&mut self) -> Result<LevelError, LevelError> {
        let range = self.range()?.map(|solved| digits(solved.impact.hammer_speed_m_per_s));
        let (instrument, touch, grams) = self.names();
        Ok(LevelError::OutOfReach { instrument, touch, grams, wanted: self.wanted, range })
    }
}

/// To three decimals.
fn digits(value: f64) -> f64 {
    (value * 1e3).round() / 1e3
}
