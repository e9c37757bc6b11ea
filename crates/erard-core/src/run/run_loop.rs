//! The loop over the steps of a run, from its rest to its end: `RunLoop::fixed` and `RunLoop::adaptive`. Both call
//! [`Mechanism`], which solves the equations at the top of [`moreau::step()`].

use moreau::{Accuracy, Settings, StepOutcome, StepReport};

use crate::events::EventDetector;
use crate::instrument::Instrument;
use crate::mechanism::{MAX_STEP_S, Mechanism, Readout, StepOutput};
use crate::player::rest::{RIGID_CORRECTION_S, Rest};
use crate::player::{Action, BodySeries, ControlWork, Drive, LedgerBook, Observer, Recorded, Recorder, Work};
use crate::progress::{ASK_EVERY, Progress};
use crate::trust::{Extremes, Struck, assess};

use super::setup::{MAX_ROWS, Setup, SimulationError};
use super::{LiftSeries, Run};

/// Smallest step of an error-controlled run, s: in the step in which friction reverses the error is friction times the
/// part of the step before, which is to be below the smallest tolerance. A few such steps do not spoil a sum of
/// positions.
pub(crate) const SMALLEST_CONTROLLED_STEP_S: f64 = 1e-11;

/// A run under way.
pub(crate) struct RunLoop<'a> {
    drive: &'a Drive<'a>,
    setup: &'a Setup,
    /// Steps of the setup's length, and the number of steps per row.
    steps: u64,
    every: u64,
    rest: Rest,
    action: Action,
    observers: Observers<'a>,
    work: Work,
}

/// Observers of every step.
struct Observers<'a> {
    detector: EventDetector,
    recorder: Recorder,
    ledger: Option<LedgerBook>,
    extremes: Extremes,
    struck: Struck,
    peak_force_n: f64,
    rested: bool,
    further: Option<&'a mut dyn Observer>,
}

impl<'a> RunLoop<'a> {
    /// At the start: the action has come to rest.
    pub(crate) fn new(
        instrument: &Instrument,
        drive: &'a Drive<'a>,
        setup: &'a Setup,
        steps: u64,
        mut action: Action,
        mut further: Option<&'a mut dyn Observer>,
    ) -> Self {
        action.begin_at(setup.start_s);
        let every = setup.record_every.unwrap_or(1 + (steps - 1) / MAX_ROWS).max(1);
        let recorder = Recorder::new(instrument, (steps / every) as usize + 2, action.mechanism_mut());
        let ledger = setup.ledger.then(|| LedgerBook::open(action.mechanism_mut()));
        if let Some(further) = &mut further {
            further.begin(setup.start_s, action.mechanism());
        }
        let (detector, extremes) = (EventDetector::new(instrument), Extremes::new(instrument));
        let struck = Struck::new(instrument);
        let mut observers =
            Observers { detector, recorder, ledger, extremes, struck, peak_force_n: 0.0, rested: false, further };
        let rest = action.rest();
        observers.observe(&rest, setup.start_s, true, action.mechanism(), &action.mechanism().readout());
        let work = Work {
            steps: 0,
            unconverged_steps: 0,
            newton_iterations: 0,
            solver_iterations: 0,
            record_every: every,
            control: None,
        };
        RunLoop { drive, setup, steps, every, rest, action, observers, work }
    }

    /// The instant after a number of steps of the setup's length, s.
    fn at(&self, n: u64) -> f64 {
        self.setup.start_s + n as f64 * self.setup.settings.step
    }

    /// Fixed steps: all of the same length, some of them taken in parts where strings sound.
    pub(crate) fn fixed(&mut self, progress: &mut Progress<'_>) -> Result<(), SimulationError> {
        let Settings { step: h, theta, .. } = self.setup.settings;
        let RunLoop { drive, setup, steps, every, rest, action, observers, work } = self;
        let (drive, rest, steps, every, start_s) = (*drive, *rest, *steps, *every, setup.start_s);
        let mut due = every;
        for n in 0..steps {
            if n.is_multiple_of(ASK_EVERY) && !progress(n as f64 / steps as f64) {
                return Err(SimulationError::Interrupted);
            }
            let (t0, t1) = (start_s + n as f64 * h, start_s + (n + 1) as f64 * h);
            if setup.pedal.is_used() {
                action.set_pedal(setup.pedal.lift_m(t1));
            }
            let row = n + 1 == due || n + 1 == steps;
            let mechanism = action.mechanism_mut();
            let mut parts = 0_u32;
            let mut input = |from_s: f64, part_s: f64, site_m: &dyn Fn() -> f64| {
                rest.input(drive, t0 + from_s, part_s, theta, part_s, site_m)
            };
            let report = mechanism.step_in_parts(&mut input, &mut |m, last| {
                parts += 1;
                let now_s = if last { t1 } else { t0 + f64::from(parts) * m.readout().last_step_s };
                observers.step(&rest, now_s, row && last, m);
            });
            if report.outcome == StepOutcome::NonFinite {
                // It is where it was, and when.
                return Err(SimulationError::NonFinite { time_s: action.time_s() });
            }
            work.count(&report, u64::from(parts));
            due += if n + 1 == due { every } else { 0 };
        }
        Ok(())
    }

    /// Adaptive steps: from row to row, as long as their error allows.
    pub(crate) fn adaptive(&mut self, tolerance: f64, progress: &mut Progress<'_>) -> Result<(), SimulationError> {
        let Settings { step: h, theta, .. } = self.setup.settings;
        let accuracy = Accuracy::new(tolerance, SMALLEST_CONTROLLED_STEP_S, MAX_STEP_S);
        let mut control = ControlWork::none();
        let mut n = 0;
        while n < self.steps {
            let next = self.steps.min(n.saturating_add(self.every));
            let row_s = self.at(next);
            // What is left is counted down, so that the last step meets the row.
            let mut left = (next - n) as f64 * h;
            while left > 0.0 {
                if control.accepted.is_multiple_of(ASK_EVERY) && !progress(n as f64 / self.steps as f64) {
                    return Err(SimulationError::Interrupted);
                }
                let (limit, t0) = (left, row_s - left);
                let (drive, rest, observers) = (self.drive, self.rest, &mut self.observers);
                let mut input = |from: f64, h: f64, site_m: &dyn Fn() -> f64| {
                    rest.input(drive, t0 + from, h, theta, RIGID_CORRECTION_S, site_m)
                };
                let ends = |after_s: f64| if after_s >= limit { row_s } else { t0 + after_s };
                let mut observe = |m: &dyn Mechanism| {
                    let now_s = m.readout().now_s;
                    observers.step(&rest, now_s, now_s == row_s, m);
                };
                let mechanism = self.action.mechanism_mut();
                let report = mechanism.controlled_step(&accuracy, limit, &ends, &mut input, &mut observe);
                if report.outcome == StepOutcome::NonFinite {
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

    /// The results of the run.
    pub(crate) fn finish(self, instrument: &Instrument) -> Run {
        let Observers { detector, recorder, ledger, extremes, struck, peak_force_n, .. } = self.observers;
        let mechanism = self.action.mechanism();
        let Recorded { time_s, force_n, key_m, hammer_rise_m, hammer_rise_m_per_s, bodies, zones, strings } =
            recorder.finish();
        let ledger = ledger.map(|ledger| ledger.close(mechanism));
        let events = detector.finish();
        let warnings = assess(instrument, &extremes, &struck, &events, ledger.as_ref(), &self.work);
        Run {
            instrument: instrument.name.clone(),
            time_s,
            force_n,
            key_m,
            hammer_rise_m,
            hammer_rise_m_per_s,
            lifts: lifts(instrument, &bodies),
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

/// Lifts of the pivots that slide along a pin, from the recorded angles of their arms.
fn lifts(instrument: &Instrument, bodies: &[BodySeries]) -> Vec<LiftSeries> {
    let drawn_rad = |body: usize| instrument.bodies[body].angle_rad;
    let of = |(arm, lying): (usize, usize)| {
        let carrier = instrument.bodies[arm].parent;
        let from_rad = drawn_rad(arm) - carrier.map_or(0.0, drawn_rad);
        let lift_m = bodies[arm].angle_rad.iter().enumerate().map(|(row, angle)| {
            let carrier_rad = carrier.map_or(0.0, |carrier| bodies[carrier].angle_rad[row]);
            instrument.lift_m(arm, angle - carrier_rad - from_rad)
        });
        let name = |body: usize| instrument.bodies[body].name.clone();
        LiftSeries { name: name(lying), pin: name(arm), lift_m: lift_m.collect() }
    };
    instrument.lying().map(of).collect()
}

impl Observers<'_> {
    /// After a step.
    fn step(&mut self, rest: &Rest, time_s: f64, row: bool, m: &dyn Mechanism) {
        // Once for all that observe: it is put together anew each time.
        let now = m.readout();
        self.peak_force_n = self.peak_force_n.max(now.output.drive_n);
        if let Some(ledger) = &mut self.ledger {
            ledger.observe(now.rests, m);
        }
        if let Some(further) = &mut self.further {
            further.step(time_s, row, m);
        }
        self.observe(rest, time_s, row, m, &now);
    }

    fn observe(&mut self, rest: &Rest, time_s: f64, row: bool, m: &dyn Mechanism, now: &Readout<'_>) {
        let rested = std::mem::replace(&mut self.rested, now.rests);
        let StepOutput { site_m, point_m, impact, .. } = *now.output;
        let (key_m, hammer_rise_m) = (site_m - rest.site_m, point_m[1] - rest.head_m);
        if rested && self.rested {
            self.detector.unchanged(time_s);
            self.recorder.unchanged();
        } else {
            self.extremes.observe(time_s, now);
            self.extremes.note_travels(time_s, key_m, hammer_rise_m);
            self.struck.observe(time_s, now);
            self.detector.observe(time_s, key_m, hammer_rise_m, impact, m);
            if let (Some(impact), Some(ledger)) = (impact, &self.ledger) {
                self.extremes.note_blow(&impact, ledger.given(m));
            }
            self.recorder.step(now);
        }
        if row {
            self.recorder.row(time_s, key_m, hammer_rise_m, now);
        }
    }
}
