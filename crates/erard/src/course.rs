//! A run from its rest to its end: steps of one length, or as long as their error allows.

use std::time::Instant;

use moreau::{Accuracy, ControlledStep, Input, Outcome, Settings};

use crate::events::Watch;
use crate::instrument::Instrument;
use crate::mechanism::Mechanism;
use crate::recorder::Recorder;
use crate::run::{ControlWork, Run, Work};
use crate::sight::{Visible, head_height};
use crate::simulation::{Drive, LARGEST_STEP_S, MOST_ROWS, Setup, SimulationError};

/// Smallest step of an error-controlled run, s: in the step in which friction reverses the error is friction times the part of the step
/// before, which is to be below the smallest tolerance. A few such steps do not spoil a sum of positions.
pub const SMALLEST_CONTROLLED_STEP_S: f64 = 1e-11;
/// How much of a rigid drive's position error is taken back per step, or in this time where steps are of any length, s.
const RIGID_CORRECTION: f64 = 0.1;
const RIGID_CORRECTION_S: f64 = 50e-6;

/// Told the share done; ends the run by returning false.
type Progress<'a> = dyn FnMut(f64) -> bool + 'a;

/// A run under way.
pub struct Course<'a> {
    drive: &'a Drive<'a>,
    setup: &'a Setup,
    /// Steps of the setup's length, and every how many a row is kept.
    steps: u64,
    every: u64,
    m: Box<dyn Mechanism>,
    observer: Observer<'a>,
    work: Work,
    started: Instant,
}

/// What looks on after every step.
struct Observer<'a> {
    instrument: &'a Instrument,
    rest: Rest,
    watch: Watch,
    recorder: Recorder,
    peak_force_n: f64,
}

impl<'a> Course<'a> {
    /// At the start: the mechanism has come to rest, and its ledger is open.
    pub fn new(
        instrument: &'a Instrument,
        drive: &'a Drive<'a>,
        setup: &'a Setup,
        steps: u64,
        rest: Rest,
        m: Box<dyn Mechanism>,
    ) -> Self {
        let every = setup.record_every.unwrap_or(1 + (steps - 1) / MOST_ROWS).max(1);
        let recorder = Recorder::new(instrument, (steps / every) as usize + 2);
        let mut observer = Observer { instrument, rest, watch: Watch::new(instrument), recorder, peak_force_n: 0.0 };
        observer.look(setup.start_s, true, m.as_ref());
        let work = Work {
            steps: 0,
            unconverged_steps: 0,
            newton_iterations: 0,
            solver_iterations: 0,
            real_time_factor: 0.0,
            record_every: every,
            control: None,
        };
        Course { drive, setup, steps, every, m, observer, work, started: Instant::now() }
    }

    /// The instant after so many steps of the setup's length, s.
    fn at(&self, n: u64) -> f64 {
        self.setup.start_s + n as f64 * self.setup.settings.step
    }

    /// All steps of the same length.
    pub fn fixed(&mut self, progress: &mut Progress) -> Result<(), SimulationError> {
        let Settings { step: h, theta, .. } = self.setup.settings;
        for n in 0..self.steps {
            if n % 8192 == 0 && !progress(n as f64 / self.steps as f64) {
                return Err(SimulationError::Interrupted);
            }
            let (t0, t1) = (self.at(n), self.at(n + 1));
            let input = self.observer.rest.input(self.drive, t0, h, theta, h, &|| self.m.site_position());
            let report = self.m.step(&input);
            self.work.count(report.outcome, 1, report.newton, report.solver, t0)?;
            let row = (n + 1) % self.every == 0 || n + 1 == self.steps;
            self.observer.step(t1, row, self.m.as_ref());
        }
        Ok(())
    }

    /// From row to row in steps as long as their error allows.
    pub fn controlled(&mut self, tolerance: f64, progress: &mut Progress) -> Result<(), SimulationError> {
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
                if control.accepted.is_multiple_of(1024) && !progress(n as f64 / self.steps as f64) {
                    return Err(SimulationError::Interrupted);
                }
                let (limit, t0) = (left, row_s - left);
                let (drive, observer) = (self.drive, &mut self.observer);
                let rest = observer.rest;
                let mut input = |from: f64, h: f64, site_m: &dyn Fn() -> f64| {
                    rest.input(drive, t0 + from, h, theta, RIGID_CORRECTION_S, site_m)
                };
                let mut look = |after_s: f64, m: &dyn Mechanism| {
                    let row = after_s >= limit;
                    observer.step(if row { row_s } else { t0 + after_s }, row, m);
                };
                let report = self.m.controlled_step(&accuracy, limit, &mut input, &mut look);
                self.work.count(report.outcome, 2, report.newton, report.solver, t0)?;
                control.count(&report, report.step >= limit);
                left = if report.step < limit { limit - report.step } else { 0.0 };
            }
            n = next;
        }
        self.work.control = Some(control);
        Ok(())
    }

    /// What the run leaves behind.
    pub fn finish(mut self) -> Run {
        let Observer { instrument, watch, recorder, peak_force_n, .. } = self.observer;
        let simulated_s = self.steps as f64 * self.setup.settings.step;
        self.work.real_time_factor = simulated_s / self.started.elapsed().as_secs_f64().max(1e-9);
        Run {
            instrument: instrument.name.clone(),
            time_s: recorder.time_s,
            force_n: recorder.force_n,
            key_m: recorder.key_m,
            hammer_head_m: recorder.hammer_head_m,
            bodies: recorder.bodies,
            zones: recorder.zones,
            events: watch.finish(),
            peak_force_n,
            final_pivot_friction_n_m: self.m.pivot_friction().to_vec(),
            ledger: self.m.ledger(),
            work: self.work,
        }
    }
}

impl Observer<'_> {
    /// After a step.
    fn step(&mut self, time_s: f64, row: bool, m: &dyn Mechanism) {
        self.peak_force_n = self.peak_force_n.max(m.drive_force());
        self.look(time_s, row, m);
    }

    fn look(&mut self, time_s: f64, row: bool, m: &dyn Mechanism) {
        let key_m = m.site_position() - self.rest.site_m;
        let hammer_m = head_height(self.instrument, m) - self.rest.head_m;
        self.watch.look(time_s, key_m, hammer_m, m);
        self.recorder.step(m);
        if row {
            self.recorder.row(time_s, key_m, hammer_m, m);
        }
    }
}

impl Work {
    /// Counts what one call of the engine did from an instant on.
    fn count(
        &mut self,
        outcome: Outcome,
        steps: u64,
        newton: u32,
        solver: u32,
        time_s: f64,
    ) -> Result<(), SimulationError> {
        match outcome {
            Outcome::Converged => {}
            Outcome::IterationLimit => self.unconverged_steps += 1,
            Outcome::NonFinite | Outcome::TooManyLaws => return Err(SimulationError::NonFinite { time_s }),
        }
        self.steps += steps;
        self.newton_iterations += u64::from(newton);
        self.solver_iterations += u64::from(solver);
        Ok(())
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

/// What travels are measured from.
#[derive(Debug, Clone, Copy)]
pub struct Rest {
    pub site_m: f64,
    pub head_m: f64,
}

impl Rest {
    /// Where a mechanism is now.
    pub fn of(instrument: &Instrument, m: &dyn Visible) -> Self {
        Rest { site_m: m.site_position(), head_m: head_height(instrument, m) }
    }

    /// The engine's input for the step from t0, each number at the instant that the engine expects.
    /// `correction_s`: in what time [`RIGID_CORRECTION`] of a rigid drive's position error is taken back; `site_m`: where the driven point is.
    pub fn input(
        &self,
        drive: &Drive,
        t0: f64,
        h: f64,
        theta: f64,
        correction_s: f64,
        site_m: &dyn Fn() -> f64,
    ) -> Input<f64> {
        let t_theta = t0 + theta * h;
        match drive {
            Drive::Free => Input::Free,
            Drive::Force(force) => Input::Force(force(t_theta)),
            Drive::Motion(position) => {
                let [y, velocity] = position(t_theta);
                Input::Motion { position: self.site_m + y, velocity }
            }
            Drive::Rigid(position) => {
                let behind = self.site_m + position(t0)[0] - site_m();
                Input::Rigid { velocity: position(t0 + h)[1] + RIGID_CORRECTION * behind / correction_s }
            }
        }
    }
}
