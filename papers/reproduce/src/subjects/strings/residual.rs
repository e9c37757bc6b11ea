//! Residual of the energy balance of a note with strings, over the step.

use erard::instrument::{Instrument, InstrumentFields};
use erard::mechanism::{Halving, open_ledger, update_energies};
use erard::run::{Setup, press};
use erard::{Input, Settings};

use super::super::impact::{halvings, neighbouring, tell};
use super::super::{Claim, Progress, ReproduceError, Section, Table, builtin};
use super::head;

/// Instrument of this subject.
const NAME: &str = "concert-grand-strings";
/// The longest step, s, and number of steps: each half of the one before.
const LADDER: (f64, i32) = (1.0 / 24e3, 4);
/// Force on the key, N, mf; time of release, and end, s.
const FORCE_N: f64 = 4.0;
const HELD_S: f64 = 0.15;
const FOLLOWED_S: f64 = 0.3;
/// Tolerance of the solver: its residual is no error of the scheme.
const TOLERANCE: f64 = 1e-12;
/// Least expected order: the scheme is of second order on smooth motion, and of first order across contacts that open
/// and close.
const ORDER: f64 = 1.0;
/// Largest unexplained share of the work at the usual step; and share left by rounding and solver.
const RESIDUAL: f64 = 1e-4;
const ROUNDING: f64 = 1e-9;
/// Speed of a head alone, m/s, and its duration, s.
const HEAD_M_PER_S: f64 = 2.0;
const HEAD_S: f64 = 20e-3;
/// Change of the grand, and halving of steps.
type Way = (&'static str, fn(&mut InstrumentFields), Halving);
const WAYS: [Way; 3] = [
    ("halved near the string", |_| {}, Halving::Auto),
    ("rigid string", |grand| grand.roles.rigid_string = true, Halving::Never),
    ("felts without sliders", without_sliders, Halving::Auto),
];

/// Felts with a rate-dependent loss only.
fn without_sliders(grand: &mut InstrumentFields) {
    for zone in &mut grand.zones {
        zone.felt.loss = moreau::Loss::quadratic(zone.felt.loss.viscous(1.0, 0.0));
    }
}

pub(crate) fn section(_: &Instrument, progress: &mut Progress) -> Result<Section, ReproduceError> {
    let steps = halvings(LADDER.0, LADDER.1);
    let mut section = Section {
        text: vec![format!(
            "C4 with strings under {FORCE_N:.0} N, let go after {HELD_S} s and damped, {FOLLOWED_S} s together. The residual is what stored energy, work of the finger and all losses leave unexplained, as a share of the \
             work; root mean square over eight steps from h to h - 7/64 h. Orders by least squares. The last row is a head of 8.9 g alone, thrown at C4's strings at 2 m/s."
        )],
        ..Section::default()
    };
    let mut table =
        Table::new("Residual of the energy balance over the step h", &["steps", "h", "h/2", "h/4", "h/8", "order"]);
    for (n, (name, change, halving)) in WAYS.into_iter().enumerate() {
        let part = 1.0 / WAYS.len() as f64;
        tell(progress, part * n as f64)?;
        let mut grand = builtin(NAME)?;
        grand.edit(change)?;
        let mut residual = |_, step_s: f64| {
            let settings = Settings { tolerance: TOLERANCE, ..Settings::new(step_s) };
            let setup = Setup { settings, halving, record_every: Some(u64::MAX), ..Setup::new(FOLLOWED_S) };
            let drive = |t: f64| if t < HELD_S { Input::Force(FORCE_N) } else { Input::Free };
            let run = press(&grand, &drive, &setup)?;
            Ok([run.ledger.as_ref().map_or(f64::NAN, moreau::Ledger::residual_relative)])
        };
        let found = neighbouring(&steps, &mut residual, &mut |share| progress(part * (n as f64 + share)))?;
        let order = order(&steps, &found);
        table.row(row(name, &found, format!("{order:.2}")));
        section.claims.push(Claim::new(
            "this program",
            format!("{name}: the residual is below {RESIDUAL:.0e} at h = 1/24 000 s, and falls with an order of {ORDER:.0} at least"),
            format!("{:.1e} at h, order {order:.2}", found[0][0]),
            found[0][0] < RESIDUAL && order > ORDER,
        ));
    }
    let head = head::before(&builtin(NAME)?)?;
    let alone = neighbouring(&steps, &mut |_, step_s| Ok([of_a_head(&head, step_s)?]), &mut |_| true)?;
    table.row(row("a head alone at the strings", &alone, "-".into()));
    section.claims.push(Claim::new(
        "this program",
        "felt, hammer and strings of an impact lack nothing but rounding, at every step: what whole notes lack is the action's",
        alone.iter().map(|[e]| format!("{e:.1e}")).collect::<Vec<_>>().join(", "),
        alone.iter().all(|[e]| *e < ROUNDING),
    ));
    section.tables.push(table);
    Ok(section)
}

/// A row of the table.
fn row(name: &str, found: &[[f64; 1]], order: String) -> Vec<String> {
    let cells = found.iter().map(|[e]| format!("{e:.1e}"));
    [name.to_owned()].into_iter().chain(cells).chain([order]).collect()
}

/// Observed order over a ladder, by least squares.
fn order(steps: &[f64], found: &[[f64; 1]]) -> f64 {
    let points: Vec<[f64; 2]> = steps.iter().zip(found).map(|(h, [e])| [h.ln(), e.ln()]).collect();
    let mean = |axis: usize| points.iter().map(|p| p[axis]).sum::<f64>() / points.len() as f64;
    let (x, y) = (mean(0), mean(1));
    let (above, below) =
        points.iter().fold((0.0, 0.0), |(a, b), p| (a + (p[0] - x) * (p[1] - y), b + (p[0] - x) * (p[0] - x)));
    above / below
}

/// Residual of the energy balance of a head alone that strikes C4's strings, as a share of its energy.
fn of_a_head(head: &Instrument, step_s: f64) -> Result<f64, ReproduceError> {
    let mut m = head::thrown(head, step_s, HEAD_M_PER_S)?;
    let mut ledger = open_ledger(m.as_mut());
    for _ in 0..(HEAD_S / step_s) as usize {
        m.step(&moreau::SiteInput::Free);
        m.record_energy(&mut ledger);
    }
    update_energies(m.as_ref(), &mut ledger);
    Ok(ledger.residual().abs() / (0.5 * head.bodies[0].inertia_kg_m2 * HEAD_M_PER_S * HEAD_M_PER_S))
}
