//! The numbers of a run: printed, and as `summary.json`.

use std::fmt;

use erard::run::Run;
use erard::run::Setup;
use erard::trust::Warning;
use moreau::Ledger;
use serde::Serialize;

/// The numbers of a run. `None` (JSON `null`) is what did not happen.
#[derive(Debug, Clone, Serialize)]
#[allow(non_snake_case)]
pub(crate) struct Summary {
    /// Instrument name.
    pub instrument: String,
    /// `action` or `one-dof`.
    pub model: String,
    /// `force`, `motion` or `rigid`.
    pub drive: String,
    /// Step, s.
    pub dt_s: f64,
    /// Theta.
    pub theta: f64,
    /// One-step solver.
    pub solver: String,
    /// Simulated time, s.
    pub duration_s: f64,
    /// Steps taken.
    pub steps: u64,
    /// Steps that did not converge.
    pub unconverged_steps: u64,
    /// Where the error was controlled: how, and with what work.
    pub control: Option<Control>,
    /// Newton iterations per step.
    pub newton_iterations_per_step: f64,
    /// Simulated over elapsed time.
    pub real_time_factor: f64,
    /// Speed of the strike point at the string, m/s.
    pub hammer_speed_m_s: Option<f64>,
    /// The key front leaves its rest, s.
    pub key_start_s: Option<f64>,
    /// The jack's toe meets the let-off button, s.
    pub toe_contact_s: Option<f64>,
    /// The knuckle is pushed for the last time, s.
    pub let_off_s: Option<f64>,
    /// The hammer meets the string, s.
    pub hammer_contact_s: Option<f64>,
    /// The key meets its front punching, s.
    pub key_bottom_s: Option<f64>,
    /// The tail meets the back check, s.
    pub check_s: Option<f64>,
    /// From let-off to the string, s.
    pub free_flight_s: Option<f64>,
    /// Largest finger force, N.
    pub peak_force_N: f64,
    /// Energy that the books do not explain, over the work put in.
    pub energy_residual_relative: f64,
    /// Work of the drive, J.
    pub drive_work_J: f64,
    /// Lost in dry pivots, viscous pivots, felts and sliding contacts, J.
    pub dissipated_J: Dissipated,
    /// The smallest dissipation of any kind in any step, J: friction never gives energy.
    pub smallest_dissipation_J: f64,
    /// Dry friction torque of each pivot at the end, N m.
    pub final_pivot_friction_N_m: Vec<f64>,
    /// Every blow on the string.
    pub strikes: Vec<StrikeReport>,
    /// Whether nothing speaks against the numbers.
    pub trusted: bool,
    /// What does.
    pub warnings: Vec<Warning>,
}

/// Control of the error.
#[derive(Debug, Clone, Copy, Serialize)]
pub(crate) struct Control {
    /// Error allowed in a step, relative to 1 rad/s + |velocity|.
    pub tolerance: f64,
    /// Steps taken, of two halves each.
    pub accepted_steps: u64,
    /// Attempts rejected.
    pub rejected_steps: u64,
    /// Inner steps of all attempts.
    pub inner_steps: u64,
    /// Steps taken in which no friction law changed, and whole and halves were combined.
    pub extrapolated_steps: u64,
    /// Steps whose error is beyond the tolerance because they are the smallest.
    pub steps_beyond_tolerance: u64,
    /// Shortest step, s, but for those that a row's instant cut off.
    pub smallest_step_s: f64,
    /// Longest step, s.
    pub largest_step_s: f64,
}

/// Where energy went.
#[derive(Debug, Clone, Copy, Serialize)]
pub(crate) struct Dissipated {
    /// J.
    pub pivot_dry: f64,
    /// J.
    pub pivot_viscous: f64,
    /// J.
    pub felt: f64,
    /// J.
    pub coulomb: f64,
    /// By strings that yield, J.
    pub strings: f64,
}

/// One strike of the hammer on the string.
#[derive(Debug, Clone, Copy, Serialize)]
pub(crate) struct StrikeReport {
    /// s.
    pub time_s: f64,
    /// m/s.
    pub speed_m_s: f64,
}

/// A number of a summary by its name, with its unit.
type Event = (&'static str, &'static str, fn(&Summary) -> Option<f64>);

impl Summary {
    /// What differs from piano to piano.
    pub(crate) const EVENTS: [Event; 9] = [
        ("hammer_speed_m_s", "m/s", |s| s.hammer_speed_m_s),
        ("key_start_ms", "ms", |s| Some(1e3 * s.key_start_s?)),
        ("let_off_ms", "ms", |s| Some(1e3 * s.let_off_s?)),
        ("hammer_contact_ms", "ms", |s| Some(1e3 * s.hammer_contact_s?)),
        ("key_bottom_ms", "ms", |s| Some(1e3 * s.key_bottom_s?)),
        ("check_ms", "ms", |s| Some(1e3 * s.check_s?)),
        ("free_flight_ms", "ms", |s| Some(1e3 * s.free_flight_s?)),
        ("peak_force_N", "N", |s| Some(s.peak_force_N)),
        ("drive_work_mJ", "mJ", |s| Some(1e3 * s.drive_work_J)),
    ];

    /// The numbers of a run that took so long by the clock, s; `names`: of the model, of the drive and of the solver.
    pub(crate) fn new(run: &Run, setup: &Setup, names: [&str; 3], elapsed_s: f64) -> Self {
        let [model, drive, solver] = names;
        let (e, w) = (&run.events, &run.work);
        let ledger = run.ledger.as_ref();
        let booked = |of: fn(&Ledger) -> f64| ledger.map_or(f64::NAN, of);
        let control = setup.tolerance.zip(w.control).map(|(tolerance, c)| Control {
            tolerance,
            accepted_steps: c.accepted,
            rejected_steps: c.rejected,
            inner_steps: c.inner_steps,
            extrapolated_steps: c.extrapolated,
            steps_beyond_tolerance: c.beyond_tolerance,
            smallest_step_s: c.shortest_s.min(c.longest_s),
            largest_step_s: c.longest_s,
        });
        Summary {
            instrument: run.instrument.clone(),
            model: model.into(),
            drive: drive.into(),
            dt_s: setup.settings.step,
            theta: setup.settings.theta,
            solver: solver.into(),
            duration_s: setup.duration_s,
            steps: w.steps,
            unconverged_steps: w.unconverged_steps,
            control,
            newton_iterations_per_step: w.newton_iterations as f64 / control.map_or(w.steps, |c| c.inner_steps) as f64,
            real_time_factor: setup.duration_s / elapsed_s.max(1e-9),
            hammer_speed_m_s: e.hammer_speed_m_s(),
            key_start_s: e.key_start_s,
            toe_contact_s: e.toe_contact_s,
            let_off_s: e.let_off_s,
            hammer_contact_s: e.hammer_contact_s(),
            key_bottom_s: e.key_bottom_s,
            check_s: e.check_s,
            free_flight_s: e.free_flight_s(),
            peak_force_N: run.peak_force_n,
            energy_residual_relative: ledger.map_or(f64::NAN, Ledger::residual_relative),
            drive_work_J: booked(|l| l.drive_work),
            dissipated_J: Dissipated {
                pivot_dry: booked(|l| l.pivot_dry),
                pivot_viscous: booked(|l| l.pivot_viscous),
                felt: booked(|l| l.felt_damping),
                coulomb: booked(|l| l.coulomb),
                strings: booked(|l| l.surface),
            },
            smallest_dissipation_J: booked(|l| l.smallest_term),
            final_pivot_friction_N_m: run.final_pivot_friction_n_m.clone(),
            strikes: e
                .impacts
                .iter()
                .map(|s| StrikeReport { time_s: s.time_s, speed_m_s: s.hammer_speed_m_s })
                .collect(),
            trusted: run.is_trusted(),
            warnings: run.warnings.clone(),
        }
    }

    /// Name and value with unit, as printed.
    pub(crate) fn lines(&self) -> Vec<(String, String)> {
        let ms = |t: Option<f64>| t.map_or("-".to_owned(), |t| format!("{:.2} ms", t * 1e3));
        let mut lines = vec![
            (
                "hammer speed at the string",
                self.hammer_speed_m_s.map_or("- (the string is not reached)".to_owned(), |v| format!("{v:.3} m/s")),
            ),
            ("key start", ms(self.key_start_s)),
            ("jack toe at let-off button", ms(self.toe_contact_s)),
            ("let-off", ms(self.let_off_s)),
            ("hammer contact", ms(self.hammer_contact_s)),
            ("free flight", ms(self.free_flight_s)),
            ("key bottom", ms(self.key_bottom_s)),
            ("check", ms(self.check_s)),
            ("peak finger force", format!("{:.2} N", self.peak_force_N)),
            ("energy residual", format!("{:.1e} of the work put in", self.energy_residual_relative)),
            ("steps", self.steps_line()),
            ("unconverged steps", format!("{}", self.unconverged_steps)),
            ("real-time factor", format!("{:.0}", self.real_time_factor)),
        ];
        if self.strikes.len() > 1 {
            lines.insert(5, ("blows on the string", self.strikes.len().to_string()));
        }
        if self.model == "one-dof" {
            let keep = ["key start", "key bottom", "peak finger force"];
            lines.retain(|(name, _)| {
                keep.contains(name) || name.contains("steps") || name.contains("energy") || name.contains("factor")
            });
        }
        lines.into_iter().map(|(name, value)| (name.to_owned(), value)).collect()
    }

    fn steps_line(&self) -> String {
        match &self.control {
            None => format!("{} of {} us", self.steps, (self.dt_s * 1e9).round() / 1e3),
            Some(c) => format!(
                "{} of {:.3} to {:.0} us, in halves; {} more rejected",
                c.accepted_steps,
                c.smallest_step_s * 1e6,
                c.largest_step_s * 1e6,
                c.rejected_steps
            ),
        }
    }
}

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (name, value) in self.lines() {
            writeln!(f, "  {name:<28}{value}")?;
        }
        Ok(())
    }
}
