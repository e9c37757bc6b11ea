//! Work and precision of fixed and of error-adaptive steps, for one press.

use moreau::Settings;

use super::impact::halvings;
use super::{Chart, ChartCurve, ChartPanel, Claim, Dash, Progress, ReproduceError, Section, Table};
use std::time::Instant;

use erard::instrument::Instrument;
use erard::player;
use erard::run::Run;
use erard::run::{Setup, simulate};
use erard::stroke::{ForceSeries, Touch};

/// Fixed steps: the first, s, and their number, each half of the one before. The last is 0.39 us.
const STEPS: (f64, i32) = (800e-6, 12);
/// Tolerances of adaptive steps.
const TOLERANCES: [f64; 8] = [3e-2, 1e-2, 3e-3, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7];
/// Duration of the press, s: the hammer then rests in its check.
const UNTIL_S: f64 = 0.12;
/// Shift of each run's start against the stroke, s, so that contacts meet its steps in other phases. No step of the
/// ladder is a multiple of it.
const PHASE_S: f64 = 8.563e-6;
const PHASES: u32 = 8;
/// Interval of compared rows, s.
const ROW_S: f64 = 2e-3;
/// Fixed steps of the reference, s: Richardson's extrapolation of two, of order one (see the text).
const REFERENCE_S: [f64; 2] = [0.2e-6, 0.1e-6];
const REFERENCE_ROW_S: f64 = 25e-6;
/// Precisions whose price is computed.
const WANTED: [f64; 2] = [1e-3, 1e-6];

/// Results of one press for the comparison.
struct Press {
    speed: f64,
    time_s: Vec<f64>,
    /// Angles and angular velocities of the bodies compared, rad and rad/s, row by row.
    motion: Vec<Vec<[f64; 2]>>,
    newton: f64,
    inner_steps: f64,
    rejected: f64,
    seconds: f64,
}

/// Bodies compared: key and hammer; an error if the instrument lacks them.
fn compared(instrument: &Instrument) -> Result<[usize; 2], ReproduceError> {
    let missing = |what: &str| ReproduceError::Instrument(format!("the instrument names no {what}"));
    Ok([instrument.roles.key.ok_or_else(|| missing("key"))?, instrument.roles.hammer.ok_or_else(|| missing("hammer"))?])
}

/// Kind of steps.
#[derive(Clone, Copy)]
enum Steps {
    Fixed(f64),
    Controlled(f64),
}

fn press(
    instrument: &Instrument,
    force: &ForceSeries,
    steps: Steps,
    row_s: f64,
    phase: u32,
    progress: &mut Progress,
) -> Result<Press, ReproduceError> {
    let (settings, tolerance) = match steps {
        Steps::Fixed(h) => (Settings::new(h), None),
        Steps::Controlled(tolerance) => (Settings::new(50e-6), Some(tolerance)),
    };
    let before = f64::from(phase) * PHASE_S;
    let setup = Setup {
        settings,
        start_s: -before,
        record_every: Some((row_s / settings.step).round().max(1.0) as u64),
        tolerance,
        ledger: false,
        ..Setup::new(UNTIL_S + before)
    };
    let started = Instant::now();
    let run = simulate(instrument, &player::force(force.drive()), &setup, progress)?;
    Ok(Press::of(&run, compared(instrument)?, started.elapsed().as_secs_f64()))
}

impl Press {
    fn of(run: &Run, bodies: [usize; 2], seconds: f64) -> Self {
        let (work, control) = (&run.work, run.work.control);
        let motion = bodies.map(|b| {
            let body = &run.bodies[b];
            body.angle_rad.iter().zip(&body.rate_rad_per_s).map(|(q, v)| [*q, *v]).collect()
        });
        Press {
            speed: run.events.hammer_speed_m_per_s().unwrap_or(f64::NAN),
            time_s: run.time_s.clone(),
            motion: motion.into(),
            newton: work.newton_iterations as f64,
            inner_steps: control.map_or(work.steps, |c| c.inner_steps) as f64,
            rejected: control.map_or(0, |c| c.rejected) as f64,
            seconds,
        }
    }

    /// This press and one with half its step, extrapolated to order two. Both have the same rows.
    fn extrapolated(self, finer: &Press) -> Self {
        let twice = |a: f64, b: f64| 2.0 * b - a;
        let motion = self
            .motion
            .iter()
            .zip(&finer.motion)
            .map(|(a, b)| a.iter().zip(b).map(|(a, b)| [twice(a[0], b[0]), twice(a[1], b[1])]).collect());
        Press { speed: twice(self.speed, finer.speed), motion: motion.collect(), ..self }
    }

    /// Angle of a compared body, between rows by the cubic through their angles and velocities.
    fn angle(&self, body: usize, t: f64) -> f64 {
        let i = self.time_s.partition_point(|x| *x <= t).clamp(1, self.time_s.len() - 1);
        let h = self.time_s[i] - self.time_s[i - 1];
        let s = (t - self.time_s[i - 1]) / h;
        let ([q0, v0], [q1, v1]) = (self.motion[body][i - 1], self.motion[body][i]);
        let r = 1.0 - s;
        r * r * (1.0 + 2.0 * s) * q0 + s * s * (3.0 - 2.0 * s) * q1 + h * s * r * (r * v0 - s * v1)
    }

    /// Largest difference of a compared body's angle from another press's, relative to that body's travel there.
    fn off(&self, other: &Press) -> f64 {
        let travel = |rows: &[[f64; 2]]| {
            let (low, high) =
                rows.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), r| (a.min(r[0]), b.max(r[0])));
            high - low
        };
        let bodies = 0..self.motion.len();
        let differences = bodies.flat_map(|b| {
            let travel = travel(&other.motion[b]);
            let rows = self.time_s.iter().zip(&self.motion[b]).filter(|(t, _)| **t >= 0.0);
            rows.map(move |(t, [q, _])| (q - other.angle(b, *t)).abs() / travel)
        });
        differences.fold(0.0, f64::max)
    }
}

/// Errors and work at one step or tolerance, over all phases.
struct Rung {
    label: String,
    /// Root mean squares of the relative error of the hammer's speed and of the largest error of a trajectory.
    errors: [f64; 2],
    newton: f64,
    inner_steps: f64,
    rejected: f64,
    /// Time of the least disturbed phase, s.
    seconds: f64,
}

fn rung(
    instrument: &Instrument,
    force: &ForceSeries,
    steps: Steps,
    exact: &Press,
    progress: &mut Progress,
) -> Result<Rung, ReproduceError> {
    let n = f64::from(PHASES);
    let mut rung = Rung {
        label: match steps {
            Steps::Fixed(h) => format!("{:.3} us", h * 1e6),
            Steps::Controlled(tolerance) => format!("{tolerance:e}"),
        },
        errors: [0.0; 2],
        newton: 0.0,
        inner_steps: 0.0,
        rejected: 0.0,
        seconds: f64::INFINITY,
    };
    for phase in 0..PHASES {
        let mut told = |share: f64| progress((f64::from(phase) + share) / n);
        let press = press(instrument, force, steps, ROW_S, phase, &mut told)?;
        rung.errors[0] += (press.speed / exact.speed - 1.0).powi(2) / n;
        rung.errors[1] += press.off(exact).powi(2) / n;
        rung.newton += press.newton / n;
        rung.inner_steps += press.inner_steps / n;
        rung.rejected += press.rejected / n;
        rung.seconds = rung.seconds.min(press.seconds);
    }
    rung.errors = rung.errors.map(f64::sqrt);
    Ok(rung)
}

/// Work at which an error falls below a wanted one for good, interpolated between two rungs linearly in logarithms;
/// `None` if the last one is above.
fn price(rungs: &[Rung], wanted: f64, error: usize, work: fn(&Rung) -> f64) -> Option<f64> {
    let above = rungs.iter().rposition(|r| r.errors[error] > wanted);
    let Some(i) = above else { return rungs.first().map(work) };
    let (a, b) = (&rungs[i], rungs.get(i + 1)?);
    let share = (a.errors[error] / wanted).ln() / (a.errors[error] / b.errors[error]).ln();
    Some(work(a) * (work(b) / work(a)).powf(share))
}

pub(super) fn section(instrument: &Instrument, progress: &mut Progress) -> Result<Section, ReproduceError> {
    let force = super::impact::own(instrument, "mf", Touch::Pressed)
        .and_then(|s| s.force)
        .ok_or_else(|| ReproduceError::Instrument("the built-in stroke mf cannot be read".into()))?;
    let mut told = |share: f64| progress(0.1 * share);
    let coarse = press(instrument, &force, Steps::Fixed(REFERENCE_S[0]), REFERENCE_ROW_S, 0, &mut told)?;
    let mut told = |share: f64| progress(0.1 + 0.2 * share);
    let fine = press(instrument, &force, Steps::Fixed(REFERENCE_S[1]), REFERENCE_ROW_S, 0, &mut told)?;
    let remainder = (fine.speed / coarse.speed - 1.0).abs();
    let exact = coarse.extrapolated(&fine);
    if !exact.speed.is_finite() {
        return Err(ReproduceError::Instrument("the stroke mf does not reach the string".into()));
    }
    let mut fixed = Vec::new();
    for (i, h) in halvings(STEPS.0, STEPS.1).into_iter().enumerate() {
        // The work doubles with every rung; adaptive steps take a third of the time.
        let (from, to) = (0.5_f64.powi(STEPS.1 - i as i32), 0.5_f64.powi(STEPS.1 - 1 - i as i32));
        let mut told = |share: f64| progress(0.3 + 0.4 * (from + share * (to - from)));
        fixed.push(rung(instrument, &force, Steps::Fixed(h), &exact, &mut told)?);
    }
    let mut controlled = Vec::new();
    for (i, tolerance) in TOLERANCES.into_iter().enumerate() {
        let all = TOLERANCES.len() as f64;
        let mut told = |share: f64| progress(0.7 + 0.3 * ((i as f64 + share) / all).powi(3));
        controlled.push(rung(instrument, &force, Steps::Controlled(tolerance), &exact, &mut told)?);
    }
    let mut section = Section {
        text: vec![
            format!(
                "One press, mf by force, from rest until {UNTIL_S} s, when the hammer rests in its check. Compared are the hammer's speed at the \
                 string and, every {:.0} ms, the angles of key and hammer: the largest difference at any instant, relative to that body's \
                 travel. Errors are root mean squares over {PHASES} runs that begin at other instants before the stroke: a single run's \
                 error depends on the phases at which its steps meet the contacts.",
                ROW_S * 1e3
            ),
            format!(
                "The reference is Richardson's extrapolation of fixed steps of {} and {} us, of first order as their errors are (see \
                 `scheme-order`); the two differ by {remainder:.1e} in the hammer's speed, which is about what can be told.",
                REFERENCE_S[0] * 1e6,
                REFERENCE_S[1] * 1e6
            ),
            "Work is counted in Newton iterations, those of rejected attempts included; each is one factorisation and one evaluation of all \
             zones. Seconds stand in the table."
                .into(),
        ],
        ..Section::default()
    };
    claims(&fixed, &controlled, &mut section);
    section.charts.push(chart(&fixed, &controlled));
    section.tables.push(prices("The price of a press, Newton iterations", &fixed, &controlled, |r| r.newton));
    let clock =
        "The price of a press, ms on the clock of this machine, this time, all that `press` records and books included";
    section.tables.push(Table { clock: true, ..prices(clock, &fixed, &controlled, |r| r.seconds * 1e3) });
    section.tables.push(rungs(&fixed, &controlled));
    Ok(section)
}

const NAMES: [&str; 2] = ["hammer speed", "trajectory"];

fn claims(fixed: &[Rung], controlled: &[Rung], section: &mut Section) {
    for wanted in WANTED {
        for (error, name) in NAMES.into_iter().enumerate() {
            let [a, b] = [fixed, controlled].map(|rungs| price(rungs, wanted, error, |r| r.newton));
            let told = |x: Option<f64>| x.map_or("not reached".into(), |x| format!("{x:.0} iterations"));
            let ratio = a.zip(b).map_or(String::new(), |(a, b)| format!("; fixed over adaptive: {:.2}", a / b));
            section.claims.push(Claim::new(
                "this program",
                format!("{name} right to {wanted:e} costs less with adaptive steps than with fixed ones"),
                format!("fixed {}, adaptive {}{ratio}", told(a), told(b)),
                b.is_some_and(|b| a.is_none_or(|a| b < a)),
            ));
        }
    }
    let off: Vec<f64> = TOLERANCES.into_iter().zip(controlled).map(|(t, r)| r.errors[0] / t).collect();
    let (least, most) = off.iter().fold((f64::INFINITY, 0.0_f64), |(a, b), x| (a.min(*x), b.max(*x)));
    section.claims.push(Claim::new(
        "this program",
        format!(
            "the hammer's speed is right to the tolerance, from {:e} to {:e}",
            TOLERANCES[0],
            TOLERANCES[TOLERANCES.len() - 1]
        ),
        format!("error over tolerance: {least:.2} to {most:.2}"),
        most <= 1.0,
    ));
}

fn chart(fixed: &[Rung], controlled: &[Rung]) -> Chart {
    let panel = |error: usize, y_label: &str| ChartPanel {
        y_label: y_label.into(),
        y_log: true,
        y_range: None,
        curves: [("fixed steps", fixed, 1), ("adaptive steps", controlled, 3)]
            .into_iter()
            .map(|(label, rungs, colour)| ChartCurve {
                label: label.into(),
                x: rungs.iter().map(|r| r.newton).collect(),
                y: rungs.iter().map(|r| r.errors[error]).collect(),
                colour,
                mark: Dash::Points,
            })
            .collect(),
    };
    Chart {
        title: "Work and precision of one press, fixed and adaptive steps".into(),
        caption: format!(
            "Fixed steps from {:.0} us, halved from point to point; adaptive ones at tolerances from {:e} to {:e}",
            STEPS.0 * 1e6,
            TOLERANCES[0],
            TOLERANCES[TOLERANCES.len() - 1]
        ),
        x_label: "Newton iterations of the press".into(),
        x_log: true,
        panels: vec![panel(0, "hammer speed, relative error"), panel(1, "trajectory, error over travel")],
    }
}

/// Table of the prices of precision, by a kind of work.
fn prices(caption: &str, fixed: &[Rung], controlled: &[Rung], work: fn(&Rung) -> f64) -> Table {
    let mut table = Table::new(caption, &["what", "right to", "fixed steps", "adaptive steps", "fixed over adaptive"]);
    for (error, name) in NAMES.into_iter().enumerate() {
        for exponent in 2..=6 {
            let wanted = 0.1_f64.powi(exponent);
            let [a, b] = [fixed, controlled].map(|rungs| price(rungs, wanted, error, work));
            let told =
                |x: Option<f64>| x.map_or("-".into(), |x| if x < 1e3 { format!("{x:.2}") } else { format!("{x:.0}") });
            let ratio = a.zip(b).map_or("-".into(), |(a, b)| format!("{:.2}", a / b));
            table.row([name.into(), format!("1e-{exponent}"), told(a), told(b), ratio]);
        }
    }
    table
}

fn rungs(fixed: &[Rung], controlled: &[Rung]) -> Table {
    let mut table = Table::new(
        "Errors and work of every rung (means over the phases), with the least time of a phase on the clock of this machine, this time",
        &["steps", "hammer speed", "trajectory", "inner steps", "rejected steps", "Newton iterations", "ms"],
    );
    table.clock = true;
    for (kind, rungs) in [("fixed", fixed), ("tolerance", controlled)] {
        for r in rungs {
            table.row([
                format!("{kind} {}", r.label),
                format!("{:.2e}", r.errors[0]),
                format!("{:.2e}", r.errors[1]),
                format!("{:.0}", r.inner_steps),
                format!("{:.0}", r.rejected),
                format!("{:.0}", r.newton),
                format!("{:.2}", r.seconds * 1e3),
            ]);
        }
    }
    table
}
