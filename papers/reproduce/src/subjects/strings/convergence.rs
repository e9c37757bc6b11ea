//! Convergence of an impact with the step, and its order: a head alone, and the whole action.

use erard::instrument::Instrument;
use erard::mechanism::Halving;
use erard::strings::Strings;
use erard::{Action, Input};
use moreau::Settings;

use super::super::impact::{halvings, neighbouring};
use super::super::{Chart, ChartCurve, ChartPanel, Claim, Dash, Progress, ReproduceError, Section, Table};
use super::head;

/// First step, s, and number of steps, each half of the one before; divisor of the smallest for the reference.
const LADDER: (f64, i32) = (100e-6, 6);
const REFERENCE: f64 = 4.0;
/// The largest steps, this many, give one order; the others, with the last of these, another.
const COARSE: usize = 4;
/// The step for which errors are reported.
const USUAL_STEP_S: f64 = 50e-6;
/// Speed of the head, m/s, and force on the key, N: mf.
const SPEED_M_PER_S: f64 = 2.0;
const FORCE_N: f64 = 4.0;
/// Time at which partials are measured, s: the head has left; the key of the action is at its bottom and the hammer in
/// the check.
const HEAD_S: f64 = 8e-3;
const ACTION_S: f64 = 0.1;
/// Highest partial compared, Hz.
const UP_TO_HZ: f64 = 5e3;
/// A contact lasts while the force is above this share of its peak.
const LEVEL: f64 = 0.1;
/// Least orders that count as second and as first: errors depend on the contacts' phases in the steps, and each is a
/// sum of several.
const SECOND_ORDER: f64 = 1.6;
const FIRST_ORDER: f64 = 0.7;

/// Errors at a step.
type Rung = (f64, [f64; 4]);

/// Quantities compared, in the order of [`Impact::errors`].
const QUANTITIES: [&str; 4] = ["contact time", "largest force", "return", "partials to 5 kHz"];

/// Results of an impact.
struct Impact {
    contact_s: f64,
    peak_n: f64,
    back_m_per_s: f64,
    /// Amplitudes of all strings' partials, m/s.
    partials: Vec<f64>,
}

impl Impact {
    /// From the force of every step, and the upward speed at the end of every step. Times are interpolated linearly
    /// between the steps' middles, the peak by a parabola through three, so that the result does not depend on the
    /// grid's phase.
    fn of(forces_n: &[f64], speeds_m_per_s: &[f64], step_s: f64, partials: Vec<f64>) -> Option<Impact> {
        let top = (1..forces_n.len() - 1).max_by(|&a, &b| forces_n[a].total_cmp(&forces_n[b]))?;
        let [a, b, c] = [forces_n[top - 1], forces_n[top], forces_n[top + 1]];
        let bend = a - 2.0 * b + c;
        let peak_n = if bend < 0.0 { b - (c - a) * (c - a) / (8.0 * bend) } else { b };
        let level = LEVEL * peak_n;
        // Counted in steps from the first one's middle.
        let crossing = |i: usize| i as f64 + (level - forces_n[i]) / (forces_n[i + 1] - forces_n[i]);
        let first = (0..top).find(|&i| forces_n[i] < level && forces_n[i + 1] >= level).map_or(0.0, crossing);
        let last = (top..forces_n.len() - 1).rev().find(|&i| forces_n[i] >= level && forces_n[i + 1] < level)?;
        let last = crossing(last);
        // A speed belongs to the end of its step, half a step after the middle.
        let before = (last - 0.5).floor().max(0.0) as usize;
        let share = last - 0.5 - before as f64;
        let back_m_per_s = -(speeds_m_per_s[before] + share * (speeds_m_per_s[before + 1] - speeds_m_per_s[before]));
        Some(Impact { contact_s: (last - first) * step_s, peak_n, back_m_per_s, partials })
    }

    /// Relative errors against an exact result.
    fn errors(&self, exact: &Impact) -> [f64; 4] {
        let norm = |of: &mut dyn Iterator<Item = f64>| of.map(|x| x * x).sum::<f64>().sqrt();
        let apart = norm(&mut self.partials.iter().zip(&exact.partials).map(|(a, b)| a - b));
        [
            (self.contact_s / exact.contact_s - 1.0).abs(),
            (self.peak_n / exact.peak_n - 1.0).abs(),
            (self.back_m_per_s / exact.back_m_per_s - 1.0).abs(),
            apart / norm(&mut exact.partials.iter().copied()),
        ]
    }
}

/// Amplitudes of all strings' partials up to 5 kHz, m/s, corrected for decay to a time `late_s` before now.
fn amplitudes(strings: &Strings, late_s: f64) -> Vec<f64> {
    let mut found = Vec::new();
    for (index, string) in strings.strings().iter().enumerate() {
        for n in 1..=string.partials_below(UP_TO_HZ) {
            let [q, v] = strings.partial(index, n).unwrap_or_default();
            let omega = 2.0 * std::f64::consts::PI * string.partial_hz(n);
            found.push(v.hypot(omega * q) * (string.decay_per_s(n) * late_s).exp());
        }
    }
    found
}

fn head_alone(head: &Instrument, step_s: f64) -> Result<Option<Impact>, ReproduceError> {
    let mut thrown = head::thrown(head, step_s, SPEED_M_PER_S)?;
    let steps = (HEAD_S / step_s).round();
    let (mut forces_n, mut speeds_m_per_s) = (Vec::new(), Vec::new());
    for _ in 0..steps as usize {
        thrown.step(&moreau::SiteInput::Free);
        forces_n.push(thrown.normal_force(0));
        speeds_m_per_s.push(thrown.readout().velocities[0]);
    }
    let partials = Strings::under(thrown.as_ref()).map(|strings| amplitudes(strings, steps * step_s - HEAD_S));
    Ok(partials.and_then(|partials| Impact::of(&forces_n, &speeds_m_per_s, step_s, partials)))
}

fn whole_action(grand: &Instrument, step_s: f64) -> Result<Option<Impact>, ReproduceError> {
    let mut action =
        Action::with(grand, Settings::new(step_s)).map_err(|error| ReproduceError::Simulation(error.into()))?;
    action.halve(Halving::Never);
    let steps = (ACTION_S / step_s).round();
    let (mut forces_n, mut speeds_m_per_s) = (Vec::new(), Vec::new());
    for _ in 0..steps as usize {
        let reading = action.step(Input::Force(FORCE_N));
        forces_n.push(reading.string_n);
        speeds_m_per_s.push(reading.hammer_rise_m_per_s);
    }
    let partials = action.strings().map(|strings| amplitudes(strings, steps * step_s - ACTION_S));
    Ok(partials.and_then(|partials| Impact::of(&forces_n, &speeds_m_per_s, step_s, partials)))
}

/// Errors at every step of the ladder, each the root mean square over eight nearly equal steps.
fn climb(
    play: &dyn Fn(f64) -> Result<Option<Impact>, ReproduceError>,
    progress: &mut Progress,
) -> Result<Vec<Rung>, ReproduceError> {
    let missing = || ReproduceError::Instrument("nothing sounds".into());
    let steps = halvings(LADDER.0, LADDER.1);
    let exact = play(steps[steps.len() - 1] / REFERENCE)?.ok_or_else(missing)?;
    let mut errors = |_, step_s: f64| Ok(play(step_s)?.ok_or_else(missing)?.errors(&exact));
    let errors = neighbouring(&steps, &mut errors, progress)?;
    Ok(steps.into_iter().zip(errors).collect())
}

/// Observed order over a ladder, by least squares, so that one small error by chance does not decide it.
fn order(rungs: &[Rung], quantity: usize) -> f64 {
    let points: Vec<[f64; 2]> = rungs.iter().map(|(step, errors)| [step.ln(), errors[quantity].ln()]).collect();
    let count = points.len() as f64;
    let mean = |axis: usize| points.iter().map(|p| p[axis]).sum::<f64>() / count;
    let (x, y) = (mean(0), mean(1));
    let (above, below) =
        points.iter().fold((0.0, 0.0), |(a, b), p| (a + (p[0] - x) * (p[1] - y), b + (p[0] - x) * (p[0] - x)));
    above / below
}

/// Orders of all quantities over the large steps, and over the small ones.
fn orders(rungs: &[Rung]) -> [[f64; 4]; 2] {
    [&rungs[..COARSE], &rungs[COARSE - 1..]].map(|part| [0, 1, 2, 3].map(|k| order(part, k)))
}

fn converges(rungs: &[Rung]) -> (String, bool) {
    let [coarse, fine] = orders(rungs);
    let us = |rung: &Rung| 1e6 * rung.0;
    let at_usual = rungs.iter().find(|(step, _)| (step / USUAL_STEP_S - 1.0).abs() < 1e-9);
    let one = |k: usize| {
        let error = at_usual.map_or(f64::NAN, |(_, errors)| errors[k]);
        format!("{} {:.1}, then {:.1} ({error:.1e} at 50 us)", QUANTITIES[k], coarse[k], fine[k])
    };
    let told: Vec<String> = (0..4).map(one).collect();
    let (from, knee, to) = (us(&rungs[0]), us(&rungs[COARSE - 1]), us(&rungs[rungs.len() - 1]));
    let holds = coarse.iter().all(|order| *order > SECOND_ORDER) && fine.iter().all(|order| *order > FIRST_ORDER);
    (format!("orders from {from:.0} to {knee:.1} us, then to {to:.1} us: {}", told.join("; ")), holds)
}

/// Share of an impact's energy lost by the scheme itself: from a head with lossless felt and strings.
fn taken(head: &Instrument, step_s: f64) -> Result<f64, ReproduceError> {
    let mut head = head.clone();
    head.edit(|fields| {
        fields.zones[0].felt.loss = moreau::Loss::none();
        fields.strings.iter_mut().for_each(|string| (string.loss_per_s, string.loss_s) = (0.0, 0.0));
    })
    .expect("numbers alone");
    let mut thrown = head::thrown(&head, step_s, SPEED_M_PER_S)?;
    for _ in 0..(HEAD_S / step_s).round() as usize {
        thrown.step(&moreau::SiteInput::Free);
    }
    let whole_j = 0.5 * head.bodies[0].inertia_kg_m2 * SPEED_M_PER_S * SPEED_M_PER_S;
    Ok(thrown.readout().surfaces.map_or(f64::NAN, |surfaces| surfaces.lost()) / whole_j)
}

/// Adds figure, table and claims.
pub(super) fn add(grand: &Instrument, section: &mut Section, progress: &mut Progress) -> Result<(), ReproduceError> {
    let head = head::before(grand)?;
    let alone = climb(&|step_s| head_alone(&head, step_s), &mut |share| progress(0.2 * share))?;
    let whole = climb(&|step_s| whole_action(grand, step_s), &mut |share| progress(0.2 + 0.8 * share))?;
    section.text.push(format!(
        "Convergence: steps from {:.0} to {:.2} us against a run with {REFERENCE:.0} times smaller steps than the smallest; root mean squares over eight steps that are nearly the same, for an error hangs on \
         how contacts lie between the steps (see `scheme-order`). A contact lasts while the force is above a tenth of its peak, the return is the speed with which it ends, and the partials are the amplitudes of \
         every string's up to 5 kHz {:.0} ms after a head alone has touched, and {ACTION_S} s after the key is pressed.",
        1e6 * LADDER.0,
        1e6 * LADDER.0 * 0.5_f64.powi(LADDER.1 - 1),
        1e3 * HEAD_S
    ));
    let (told, holds) = converges(&alone);
    section.claims.push(Claim::new(
        "this program",
        format!("a head alone, {SPEED_M_PER_S:.0} m/s at C4's strings: the second order, until what is left are the modes above 20 kHz, which follow the force half a step late: the first order"),
        told,
        holds,
    ));
    let (told, holds) = converges(&whole);
    section.claims.push(Claim::new(
        "this program",
        format!("the whole action, {FORCE_N:.0} N on the key: the second order and then the first, as a head alone"),
        told,
        holds,
    ));
    let steps = halvings(LADDER.0, LADDER.1);
    let lost = steps.iter().map(|step| taken(&head, *step)).collect::<Result<Vec<f64>, _>>()?;
    let told: Vec<String> =
        steps.iter().zip(&lost).map(|(step, lost)| format!("{lost:.1e} at {:.1} us", 1e6 * step)).collect();
    // In steps of 100 us the modes up to 20 kHz, which are included at any step, turn too far for any order.
    let halves = lost[1..].windows(2).all(|pair| pair[1] > 0.0 && pair[0] / pair[1] > f64::exp2(FIRST_ORDER));
    section.claims.push(Claim::new(
        "this program",
        "these modes give nothing and take little: B (F1 - F0)^2 / 2 a step with their static compliance B, the part of an impact's energy that a head, felt and strings without losses lose; it halves with the step from 50 us on",
        told.join(", "),
        halves,
    ));
    let curves = |rungs: &[Rung]| {
        let us = || rungs.iter().map(|(step, _)| 1e6 * step).collect::<Vec<f64>>();
        let mut curves: Vec<ChartCurve> = (0..4)
            .map(|k| ChartCurve {
                label: QUANTITIES[k].into(),
                x: us(),
                y: rungs.iter().map(|(_, errors)| errors[k]).collect(),
                colour: k + 1,
                mark: Dash::Points,
            })
            .collect();
        let largest = rungs.iter().flat_map(|(_, errors)| errors).fold(0.0, |a: f64, b| a.max(*b));
        for (label, power, mark) in [("first order", 1, Dash::Dotted), ("second order", 2, Dash::Dashed)] {
            let slope = |(step, _): &Rung| 2.0 * largest * (step / LADDER.0).powi(power);
            curves.push(ChartCurve {
                label: label.into(),
                x: us(),
                y: rungs.iter().map(slope).collect(),
                colour: 7,
                mark,
            });
        }
        curves
    };
    let panel = |what: &str, rungs: &[Rung]| ChartPanel {
        y_label: format!("{what}, relative error"),
        y_log: true,
        y_range: None,
        curves: curves(rungs),
    };
    section.charts.push(Chart {
        title: "An impact on strings converges".into(),
        caption: format!(
            "Errors over the length of the step: a head of 8.9 g that is thrown at C4's strings at {SPEED_M_PER_S:.0} m/s, and the whole action under {FORCE_N:.0} N (mf)."
        ),
        x_label: "step, us".into(),
        x_log: true,
        panels: vec![panel("head alone", &alone), panel("whole action", &whole)],
    });
    let mut table = Table::new(
        "Errors of an impact at each step, relative",
        &["what", "step, us", QUANTITIES[0], QUANTITIES[1], QUANTITIES[2], QUANTITIES[3]],
    );
    for (what, rungs) in [("head alone", &alone), ("whole action", &whole)] {
        for (step, errors) in rungs {
            let cells = errors.iter().map(|error| format!("{error:.1e}"));
            table.row([what.to_owned(), format!("{:.2}", 1e6 * step)].into_iter().chain(cells));
        }
    }
    section.tables.push(table);
    Ok(())
}
