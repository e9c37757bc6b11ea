//! One press, described step by step.

use erard_core::level::{DURATION_S, HandKind, MASS_KG, Reference, named};
use erard_core::mechanism::Halving;
use erard_core::run::{simulate, simulate_from};
use erard_core::strings::Pedal;
use erard_core::stroke::{Stroke, Touch, constant_force_fault};
use erard_core::{Hand, Input, Instrument, Run, Settings, Setup, Snapshot};

use crate::Error;

/// What plays the key.
enum Played<'a> {
    /// Nothing has been said yet.
    Nothing,
    /// A stroke.
    Stroke(&'a Stroke),
    /// A constant force, N.
    Force(f64),
    /// The hand that reaches the hammer speed of a level, by its name.
    Level(String),
    /// The hand that reaches a hammer speed, m/s.
    HammerSpeed(f64),
    /// A function of time.
    Drive(Box<dyn Fn(f64) -> Input + 'a>),
}

/// One press of a key, from rest to the end of its duration: what plays it, and how it is simulated.
///
/// Of [`force`](Press::force), [`level`](Press::level), [`hammer_speed`](Press::hammer_speed),
/// [`stroke`](Press::stroke) and [`drive`](Press::drive) the last one counts. The rest is optional; without it the run
/// is that of the command `erard press`, to the bit.
///
/// ```
/// use erard::{HandKind, Instrument, Press, Touch};
///
/// let grand = Instrument::builtin("concert-grand")?;
/// let struck = Press::new(&grand).hammer_speed(2.0).hand_kind(HandKind::new(Touch::Struck, 0.2)).run()?;
/// let speed_m_per_s = struck.events.hammer_speed_m_per_s().expect("it sounds");
/// assert!((speed_m_per_s / 2.0 - 1.0).abs() < 2e-3);
/// # Ok::<(), erard::Error>(())
/// ```
#[must_use = "a press is simulated by `run`"]
pub struct Press<'a> {
    instrument: &'a Instrument,
    played: Played<'a>,
    kind: Option<HandKind>,
    hand: Option<Hand>,
    duration_s: Option<f64>,
    start_s: Option<f64>,
    settings: Option<Settings<f64>>,
    record_every: Option<u64>,
    tolerance: Option<f64>,
    halving: Halving,
    ledger: bool,
    pedal: Pedal,
    from: Option<&'a Snapshot>,
    progress: Box<dyn FnMut(f64) -> bool + 'a>,
}

impl<'a> Press<'a> {
    /// A press on an instrument; what plays it is still to be said.
    pub fn new(instrument: &'a Instrument) -> Self {
        Press {
            instrument,
            played: Played::Nothing,
            kind: None,
            hand: None,
            duration_s: None,
            start_s: None,
            settings: None,
            record_every: None,
            tolerance: None,
            halving: Halving::Auto,
            ledger: true,
            pedal: Pedal::default(),
            from: None,
            progress: Box::new(|_| true),
        }
    }

    /// A constant force on the key front from the start on, N, down positive; 0.6 s unless [`duration`](Press::duration)
    /// says otherwise.
    pub fn force(self, force_n: f64) -> Self {
        Press { played: Played::Force(force_n), ..self }
    }

    /// A hand whose hammer meets the string with the speed of a level: `pp` (0.5 m/s), `p`, `mf`, `f` or `ff` (5 m/s).
    /// It holds the key, and leaves it after half a second; 1 s.
    pub fn level(self, name: impl Into<String>) -> Self {
        Press { played: Played::Level(name.into()), ..self }
    }

    /// As [`level`](Press::level), with a hammer speed at the string, m/s.
    pub fn hammer_speed(self, speed_m_per_s: f64) -> Self {
        Press { played: Played::HammerSpeed(speed_m_per_s), ..self }
    }

    /// A stroke: a recording, a built-in force curve or a hand, from its first instant, for its duration.
    pub fn stroke(self, stroke: &'a Stroke) -> Self {
        Press { played: Played::Stroke(stroke), ..self }
    }

    /// Any drive: the input of the key over time, s. It needs a [`duration`](Press::duration).
    pub fn drive(self, input: impl Fn(f64) -> Input + 'a) -> Self {
        Press { played: Played::Drive(Box::new(input)), ..self }
    }

    /// The hand that plays a level or a hammer speed: its touch, mass and joints. Without it: pressed, 0.2 kg.
    pub fn hand_kind(self, kind: HandKind) -> Self {
        Press { kind: Some(kind), ..self }
    }

    /// A hand between stroke and key: a force is its muscle's, and its muscle follows a motion. Not for a level, which
    /// finds its own.
    pub fn hand(self, hand: Hand) -> Self {
        Press { hand: Some(hand), ..self }
    }

    /// Simulated time, s.
    pub fn duration(self, duration_s: f64) -> Self {
        Press { duration_s: Some(duration_s), ..self }
    }

    /// First instant, on the stroke's own clock, s.
    pub fn start(self, start_s: f64) -> Self {
        Press { start_s: Some(start_s), ..self }
    }

    /// Step, solver and law of friction. Without it: [`Settings::new`] with the instrument's usual step.
    pub fn settings(self, settings: Settings<f64>) -> Self {
        Press { settings: Some(settings), ..self }
    }

    /// Steps per row of the series. Without it: one, or as many as keep them below 200 000 rows.
    pub fn record_every(self, steps: u64) -> Self {
        Press { record_every: Some(steps), ..self }
    }

    /// Adaptive steps: the error that each may have, 1e-9 to 0.1. Rows stay where they are.
    pub fn tolerance(self, tolerance: f64) -> Self {
        Press { tolerance: Some(tolerance), ..self }
    }

    /// Halvings of the steps near modal strings.
    pub fn halving(self, halving: Halving) -> Self {
        Press { halving, ..self }
    }

    /// Leaves out the energy balance, and with it the warning that it does not close. It saves time.
    pub fn without_energy_balance(self) -> Self {
        Press { ledger: false, ..self }
    }

    /// Motion of the sustain pedal, of an instrument that has its rail.
    pub fn pedal(self, pedal: Pedal) -> Self {
        Press { pedal, ..self }
    }

    /// Starts from a saved state of the same instrument and settings instead of from rest, in steps of fixed length.
    /// Times count from [`start`](Press::start), whatever the state's. Not for a level, which is found from rest.
    pub fn restore(self, state: &'a Snapshot) -> Self {
        Press { from: Some(state), ..self }
    }

    /// A function that receives the share done now and then, 0 to 1, and ends the press by returning false.
    pub fn progress(self, progress: impl FnMut(f64) -> bool + 'a) -> Self {
        Press { progress: Box::new(progress), ..self }
    }

    /// Simulates it.
    ///
    /// # Errors
    /// [`Error::Press`]: nothing plays, a drive has no duration, or two settings contradict each other.
    /// [`Error::Level`], [`Error::Driving`]: what plays cannot be found or cannot drive. [`Error::Run`]: a number is
    /// out of range, there is no rest, a number became infinite, or `progress` ended it. Doubts are no errors:
    /// [`Run::is_trusted`].
    pub fn run(mut self) -> Result<Run, Error> {
        self.check()?;
        let found = self.found()?;
        let stroke = match &self.played {
            Played::Stroke(stroke) => Some(*stroke),
            _ => found.as_ref(),
        };
        let setup = Setup {
            settings: self.settings.unwrap_or_else(|| Settings::new(self.instrument.usual_step_s())),
            start_s: self.start_s.or(stroke.map(|stroke| stroke.start_s)).unwrap_or(0.0),
            record_every: self.record_every,
            tolerance: self.tolerance,
            halving: self.halving,
            ledger: self.ledger,
            pedal: self.pedal,
            hand: self.hand.or(stroke.and_then(Stroke::hand)),
            ..Setup::new(self.duration_s.or(stroke.map(|stroke| stroke.duration_s)).unwrap_or_default())
        };
        let inputs = stroke.map(|stroke| stroke.inputs(&self.instrument.finger)).transpose()?;
        let drive: &dyn Fn(f64) -> Input = match (&inputs, &self.played) {
            (Some(inputs), _) => inputs,
            (None, Played::Drive(drive)) => drive,
            (None, _) => unreachable!("checked above"),
        };
        Ok(match self.from {
            None => simulate(self.instrument, drive, &setup, &mut self.progress)?,
            Some(state) => simulate_from(self.instrument, state, drive, &setup, &mut self.progress)?,
        })
    }

    /// The stroke of a force, a level or a hammer speed.
    fn found(&mut self) -> Result<Option<Stroke>, Error> {
        let (title, speed_m_per_s) = match &self.played {
            Played::Force(force_n) => {
                if let Some(fault) = constant_force_fault(*force_n) {
                    let expected = fault.trim_start_matches("expected ").to_owned();
                    return Err(Error::Press { fault: format!("a constant force of {force_n} N"), expected });
                }
                return Ok(Some(Stroke::constant(format!("{force_n} N"), *force_n)));
            }
            Played::Level(name) => match named(name) {
                Some(speed_m_per_s) => (name.clone(), speed_m_per_s),
                None => {
                    let expected = "pp, p, mf, f or ff, or a `hammer_speed`".into();
                    return Err(Error::Press { fault: format!("there is no level `{name}`"), expected });
                }
            },
            Played::HammerSpeed(speed_m_per_s) => (format!("{speed_m_per_s} m/s"), *speed_m_per_s),
            Played::Nothing | Played::Stroke(_) | Played::Drive(_) => return Ok(None),
        };
        let kind = self.kind.unwrap_or_else(|| HandKind::new(Touch::Pressed, MASS_KG));
        let mut reference = Reference::new(self.instrument, &mut self.progress)?;
        let hand = reference.solve(kind, speed_m_per_s, &mut self.progress)?.whole();
        Ok(Some(Stroke::by_hand(title, hand, DURATION_S)))
    }

    /// What is missing, and what contradicts itself.
    fn check(&self) -> Result<(), Error> {
        let wrong = |fault: &str, expected: &str| Err(Error::Press { fault: fault.into(), expected: expected.into() });
        let is_level = matches!(self.played, Played::Level(_) | Played::HammerSpeed(_));
        let has_own_hand = is_level || matches!(self.played, Played::Stroke(stroke) if stroke.hand().is_some());
        if matches!(self.played, Played::Nothing) {
            return wrong("nothing plays the key", "`force`, `level`, `hammer_speed`, `stroke` or `drive`");
        }
        if matches!(self.played, Played::Drive(_)) && self.duration_s.is_none() {
            return wrong("a drive has no end of its own", "a `duration`");
        }
        if self.hand.is_some() && has_own_hand {
            return wrong("what plays has a hand of its own, and `hand` gives another", "one of them");
        }
        if self.kind.is_some() && !is_level {
            return wrong("`hand_kind` without a level", "`level` or `hammer_speed` with it, or `hand`");
        }
        if self.from.is_some() && is_level {
            return wrong("a level is found from rest, and the press starts from a saved state", "one of them");
        }
        if self.from.is_some() && self.tolerance.is_some() {
            return wrong("adaptive steps from a saved state", "one of `tolerance` and `restore`");
        }
        Ok(())
    }
}
