//! The loop over the steps of a run, from its rest to its end: `RunLoop::fixed` and `RunLoop::adaptive`. Both call [`Mechanism`], which solves the
//! equations at the top of [`moreau::step()`].

use moreau::{Accuracy, ControlledStep, Input, Outcome, Settings, StepReport};

use super::hand::MovingHand;
use super::recorder::Recorded;
use super::{Action, Drive, LedgerBook, PlayError, Recorder};
use crate::events::EventDetector;
use crate::instrument::Instrument;
use crate::mechanism::{Mechanism, Observation, StepOutput};
use crate::run::{ControlWork, Run, Work};
use crate::simulation::{LARGEST_STEP_S, MOST_ROWS, Setup, SimulationError};
use crate::trust::{Extremes, assess};

/// Smallest step of an error-controlled run, s: in the step in which friction reverses the error is friction times the part of the step
/// before, which is to be below the smallest tolerance. A few such steps do not spoil a sum of positions.
pub const SMALLEST_CONTROLLED_STEP_S: f64 = 1e-11;
/// How much of a rigid drive's position error is taken back per step, or in this time where steps are of any length, s.
pub(crate) const RIGID_CORRECTION: f64 = 0.1;
const RIGID_CORRECTION_S: f64 = 50e-6;

/// Called with the share done; ends the run by returning false.
type Progress<'a> = dyn FnMut(f64) -> bool + 'a;

/// A further observer of a run.
pub trait Observer {
    /// Where the run begins: the mechanism stands still, and this instant is its first row.
    fn begin(&mut self, time_s: f64, mechanism: &dyn Mechanism);
    /// After every step, which ends at `time_s`; `row`: this instant is a row of the run.
    fn step(&mut self, time_s: f64, row: bool, mechanism: &dyn Mechanism);
}

/// A run under way.
pub(crate) struct RunLoop<'a> {
    drive: &'a Drive<'a>,
    setup: &'a Setup,
    /// Steps of the setup's length, and every how many a row is kept.
    steps: u64,
    every: u64,
    rest: Rest,
    action: Action,
    /// Between stroke and key, where there is one.
    hand: Option<MovingHand>,
    observers: Observers<'a>,
    work: Work,
}

/// What observes every step.
struct Observers<'a> {
    detector: EventDetector,
    recorder: Recorder,
    ledger: Option<LedgerBook>,
    extremes: Extremes,
    peak_force_n: f64,
    rested: bool,
    further: Option<&'a mut dyn Observer>,
}

impl<'a> RunLoop<'a> {
    /// At the start: the action has come to rest.
    pub fn new(
        instrument: &Instrument,
        drive: &'a Drive<'a>,
        setup: &'a Setup,
        steps: u64,
        mut action: Action,
        mut further: Option<&'a mut dyn Observer>,
    ) -> Self {
        action.begin_at(setup.start_s);
        let every = setup.record_every.unwrap_or(1 + (steps - 1) / MOST_ROWS).max(1);
        let recorder = Recorder::new(instrument, (steps / every) as usize + 2, action.mechanism_mut());
        let ledger = setup.ledger.then(|| LedgerBook::open(action.mechanism_mut()));
        if let Some(further) = &mut further {
            further.begin(setup.start_s, action.mechanism());
        }
        let (detector, extremes) = (EventDetector::new(instrument), Extremes::new(instrument));
        let mut observers =
            Observers { detector, recorder, ledger, extremes, peak_force_n: 0.0, rested: false, further };
        let rest = action.rest();
        observers.observe(&rest, setup.start_s, true, action.output(), action.mechanism());
        let work = Work {
            steps: 0,
            unconverged_steps: 0,
            newton_iterations: 0,
            solver_iterations: 0,
            record_every: every,
            control: None,
        };
        RunLoop { drive, setup, steps, every, rest, action, hand: None, observers, work }
    }

    /// The same, with a hand that the stroke moves, and that the action has been fitted to.
    pub fn by_hand(self, hand: MovingHand) -> Self {
        RunLoop { hand: Some(hand), ..self }
    }

    /// The instant after so many steps of the setup's length, s.
    fn at(&self, n: u64) -> f64 {
        self.setup.start_s + n as f64 * self.setup.settings.step
    }

    /// Fixed steps: all of the same length.
    pub fn fixed(&mut self, progress: &mut Progress) -> Result<(), SimulationError> {
        let Settings { step: h, theta, .. } = self.setup.settings;
        let RunLoop { drive, setup, steps, every, rest, action, hand, observers, work } = self;
        let (drive, rest, steps, every, start_s) = (*drive, *rest, *steps, *every, setup.start_s);
        let (mut n, mut due, mut failed) = (0, every, None);
        let taken = std::cell::Cell::new(0_u64);
        let mut going = || progress(taken.get() as f64 / steps as f64);
        let played = action.play_engine(&mut going, &mut |action, last| {
            let t = start_s + n as f64 * h;
            if let Some(report) = last {
                work.count(report, 1);
                if let Some(hand) = hand {
                    hand.advance(action.output().drive_n);
                }
                let row = n == due || n == steps;
                due += if n == due { every } else { 0 };
                observers.step(&rest, t, row, action.output(), action.mechanism());
            }
            taken.set(n);
            if n == steps {
                return None;
            }
            n += 1;
            action.set_pedal(setup.pedal.lift_m(t + h));
            if let Some(hand) = hand {
                let free = hand.input(&drive(t + theta * h));
                return match free {
                    Ok(free) => Some(rest.engine_input(&free, || 0.0)),
                    Err(error) => {
                        failed = Some(error);
                        None
                    }
                };
            }
            Some(rest.input(drive, t, h, theta, h, &|| action.mechanism().site_position()))
        });
        match failed {
            Some(error) => Err(error.into()),
            None => played.map_err(SimulationError::from),
        }
    }

    /// Adaptive steps: from row to row, as long as their error allows.
    pub fn adaptive(&mut self, tolerance: f64, progress: &mut Progress) -> Result<(), SimulationError> {
        let Settings { step: h, theta, .. } = self.setup.settings;
        let accuracy = Accuracy::new(tolerance, SMALLEST_CONTROLLED_STEP_S, LARGEST_STEP_S);
        let mut control = ControlWork::none();
        let mut n = 0;
        while n < self.steps {
            let next = self.steps.min(n.saturating_add(self.every));
            let row_s = self.at(next);
            // What is left is counted down, so that the last step meets the row.
            let mut left = (next - n) as f64 * h;
            while left > 0.0 {
                if control.accepted.is_multiple_of(512) && !progress(n as f64 / self.steps as f64) {
                    return Err(SimulationError::Interrupted);
                }
                let (limit, t0) = (left, row_s - left);
                let (drive, rest, observers) = (self.drive, self.rest, &mut self.observers);
                let mut input = |from: f64, h: f64, site_m: &dyn Fn() -> f64| {
                    rest.input(drive, t0 + from, h, theta, RIGID_CORRECTION_S, site_m)
                };
                let ends = |after_s: f64| if after_s >= limit { row_s } else { t0 + after_s };
                let mut observe = |m: &dyn Mechanism| {
                    let now = m.readout();
                    let now_s = now.now_s;
                    observers.step(&rest, now_s, now_s == row_s, now.output, m);
                };
                let mechanism = self.action.mechanism_mut();
                let report = mechanism.controlled_step(&accuracy, limit, &ends, &mut input, &mut observe);
                if report.outcome == Outcome::NonFinite {
                    return Err(SimulationError::NonFinite { time_s: t0 });
                }
                let inner = StepReport { outcome: report.outcome, newton: report.newton, solver: report.solver };
                self.work.count(&inner, 2);
                control.count(&report, report.step >= limit);
                left = if report.step < limit { limit - report.step } else { 0.0 };
            }
            n = next;
        }
        self.work.control = Some(control);
        Ok(())
    }

    /// What the run leaves behind.
    pub fn finish(self, instrument: &Instrument) -> Run {
        let Observers { detector, recorder, ledger, extremes, peak_force_n, .. } = self.observers;
        let mechanism = self.action.mechanism();
        let Recorded { time_s, force_n, key_m, hammer_head_m, bodies, zones, strings } = recorder.finish();
        let ledger = ledger.map(|ledger| ledger.close(mechanism));
        let events = detector.finish();
        let warnings = assess(instrument, &extremes, &events, ledger.as_ref(), &self.work);
        Run {
            instrument: instrument.name.clone(),
            time_s,
            force_n,
            key_m,
            hammer_head_m,
            bodies,
            zones,
            strings,
            events,
            peak_force_n,
            final_pivot_friction_n_m: mechanism.readout().pivot_friction.to_vec(),
            ledger,
            work: self.work,
            extremes,
            warnings,
        }
    }
}

impl Observers<'_> {
    /// After a step.
    fn step(&mut self, rest: &Rest, time_s: f64, row: bool, output: &StepOutput, m: &dyn Mechanism) {
        self.peak_force_n = self.peak_force_n.max(output.drive_n);
        if let Some(ledger) = &mut self.ledger {
            ledger.observe(m);
        }
        if let Some(further) = &mut self.further {
            further.step(time_s, row, m);
        }
        self.observe(rest, time_s, row, output, m);
    }

    fn observe(&mut self, rest: &Rest, time_s: f64, row: bool, output: &StepOutput, m: &dyn Mechanism) {
        let rested = std::mem::replace(&mut self.rested, m.readout().rests);
        let (key_m, hammer_m) = (output.site_m - rest.site_m, output.point_m[1] - rest.head_m);
        if rested && self.rested {
            self.detector.stood(time_s);
            self.recorder.stood();
        } else {
            self.extremes.observe(time_s, m);
            self.detector.observe(time_s, key_m, hammer_m, output.impact, m);
            self.recorder.step(m);
        }
        if row {
            self.recorder.row(time_s, key_m, hammer_m, m);
        }
    }
}

impl Work {
    /// Counts what one call of the engine did.
    fn count(&mut self, report: &StepReport, steps: u64) {
        self.unconverged_steps += u64::from(report.outcome == Outcome::IterationLimit);
        self.steps += steps;
        self.newton_iterations += u64::from(report.newton);
        self.solver_iterations += u64::from(report.solver);
    }
}

impl ControlWork {
    fn none() -> Self {
        ControlWork {
            accepted: 0,
            rejected: 0,
            inner_steps: 0,
            extrapolated: 0,
            beyond_tolerance: 0,
            shortest_s: f64::INFINITY,
            longest_s: 0.0,
        }
    }

    /// Counts a step; `cut`: it ended because a row was due.
    fn count(&mut self, step: &ControlledStep<f64>, cut: bool) {
        self.accepted += 1;
        self.rejected += u64::from(step.rejected);
        self.inner_steps += u64::from(step.inner);
        self.extrapolated += u64::from(step.extrapolated);
        self.beyond_tolerance += u64::from(step.error > 1.0);
        if !cut {
            self.shortest_s = self.shortest_s.min(step.step);
        }
        self.longest_s = self.longest_s.max(step.step);
    }
}

impl From<PlayError> for SimulationError {
    fn from(error: PlayError) -> Self {
        match error {
            PlayError::Interrupted => SimulationError::Interrupted,
            PlayError::NonFinite { time_s } => SimulationError::NonFinite { time_s },
        }
    }
}

/// What travels are measured from, m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rest {
    /// World coordinate of the key front along its drive (down).
    pub site_m: f64,
    /// Height of the hammer's strike point.
    pub head_m: f64,
}

impl Rest {
    /// Where a mechanism is now.
    pub fn of(instrument: &Instrument, m: &(impl Observation + ?Sized)) -> Self {
        let head_m = instrument.roles.hammer.map_or(0.0, |h| m.point(Some(h), instrument.roles.hammer_head_m)[1]);
        Rest { site_m: m.site_position(), head_m }
    }

    /// The engine's input for the step from t0, each number at the instant that the engine expects.
    /// `correction_s`: in what time [`RIGID_CORRECTION`] of a rigid drive's position error is taken back; `site_m`: where the driven point is.
    pub fn input(
        &self,
        drive: &Drive<'_>,
        t0: f64,
        h: f64,
        theta: f64,
        correction_s: f64,
        site_m: &dyn Fn() -> f64,
    ) -> Input<f64> {
        let input = drive(t0 + theta * h);
        self.engine_input(&input, || {
            let behind = self.site_m + drive(t0).position_m() - site_m();
            let velocity = match drive(t0 + h) {
                super::Input::Rigid { velocity_m_s, .. } => velocity_m_s,
                _ => 0.0,
            };
            velocity + RIGID_CORRECTION * behind / correction_s
        })
    }

    /// The engine's input: travels count from here. `imposed` gives the key's velocity at the step's end where the motion is rigid, m/s.
    #[inline]
    pub fn engine_input(&self, input: &super::Input, imposed: impl FnOnce() -> f64) -> Input<f64> {
        match *input {
            super::Input::Free => Input::Free,
            super::Input::Force(force_n) => Input::Force(force_n),
            super::Input::Motion { position_m, velocity_m_s } => {
                Input::Motion { position: self.site_m + position_m, velocity: velocity_m_s }
            }
            super::Input::Rigid { .. } => Input::Rigid { velocity: imposed() },
        }
    }
}
