//! Suitable loss for the felts of an action: an experiment with the four available laws.
//!
//! The felts of the instrument, except the hammer's on the string, get another loss in place of b g^2 dg/dt or beside
//! it. Questions: whether a slow contact loses energy, whether a held action keeps vibrating, the effects on an impact
//! and on the released key, and the work.

use moreau::{Elastoplastic, Loss, SetValued, Settings};
use moreau_conformance::thrown_back;

use super::impact::{Play, tell};
use super::{Claim, Progress, ReproduceError, Section, Table};
use erard::instrument::{Felt, Instrument};
use erard::player::{Action, Input};
use erard::stroke::Touch;

/// eta and s of the dry losses.
pub(super) const ETA: f64 = 0.3;
pub(super) const SLIP: f64 = 0.2;
/// Usual step, s.
const STEP_S: f64 = 50e-6;

/// A loss, by name.
struct Law {
    name: &'static str,
    give: fn(&mut Felt),
}

const LAWS: [Law; 5] = [
    Law { name: "b g^2 dg/dt (the papers')", give: |_| {} },
    Law { name: "none", give: |felt| felt.loss = Loss::none() },
    Law { name: "set-valued", give: |felt| felt.loss = SetValued { eta: ETA }.into() },
    Law { name: "elastoplastic", give: |felt| felt.loss = dry(0.0) },
    Law { name: "b and elastoplastic", give: |felt| felt.loss = dry(felt.loss.viscous(1.0, 0.0)) },
];

/// Dry loss with slip, beside b.
fn dry(damping: f64) -> Loss<f64> {
    Elastoplastic { damping, eta: ETA, slip: SLIP }.into()
}

/// The instrument with this loss in its felts, except the string's.
fn with(instrument: &Instrument, law: &Law) -> Instrument {
    let mut other = instrument.clone();
    other
        .edit(|fields| {
            for (z, zone) in fields.zones.iter_mut().enumerate() {
                if Some(z) != instrument.roles.string && !matches!(zone.felt.loss, Loss::HuntCrossley(_)) {
                    (law.give)(&mut zone.felt);
                }
            }
        })
        .expect("numbers alone");
    other
}

/// Rocking of the hammer on its felts at rest, after a push of micrometres: frequency, Hz, and the share of its swing
/// left after a quarter of a second. The pivots' dry friction would stop it with any felts, and is therefore removed.
fn rocking(instrument: &Instrument) -> Result<Option<[f64; 2]>, ReproduceError> {
    let mut free = instrument.clone();
    free.edit(|fields| {
        for body in &mut fields.bodies {
            body.friction_torque_n_m *= 1e-6;
            body.viscous_n_m_s = 0.0;
        }
        for zone in &mut fields.zones {
            zone.friction_coefficient = 0.0;
        }
    })
    .expect("numbers alone");
    let Some(hammer) = free.roles.hammer else { return Ok(None) };
    let failed = |error: &dyn std::fmt::Display| ReproduceError::Instrument(error.to_string());
    let mut action = Action::with(&free, Settings::new(STEP_S)).map_err(|error| failed(&error))?;
    action.add_velocity(hammer, 2e-3).map_err(|error| failed(&error))?;
    let (mut before, mut turns, mut swings) = (2e-3, Vec::new(), [0.0_f64; 2]);
    for n in 0..(0.3 / STEP_S) as u32 {
        let time_s = f64::from(n + 1) * STEP_S;
        action.step(Input::Free);
        let now = action.velocities()[hammer];
        if before > 0.0 && now <= 0.0 {
            turns.push(time_s - STEP_S * now / (now - before));
        }
        for (swing, window) in swings.iter_mut().zip([0.0..0.05, 0.25..0.3]) {
            if window.contains(&time_s) {
                *swing = swing.max(now.abs());
            }
        }
        before = now;
    }
    let frequency = match turns.as_slice() {
        [first, .., last] if turns.len() >= 2 => (turns.len() - 1) as f64 / (last - first),
        _ => 0.0,
    };
    Ok(Some([frequency, swings[1] / swings[0]]))
}

/// Travel of the key after it has first come back to rest, mm, with the finger gone.
fn key_rebound_mm(run: &erard::run::Run, released_s: f64) -> f64 {
    let rows = run.time_s.iter().zip(&run.key_m).filter(|(t, _)| **t > released_s);
    let (mut back, mut most) = (false, 0.0_f64);
    for (_, key) in rows {
        back |= *key < 0.1e-3;
        if back {
            most = most.max(*key);
        }
    }
    1e3 * most
}

/// Speed of rebound over speed of arrival on a felt with a dry loss alone, eta and s, at any speed: closed form.
pub(super) fn restitution([eta, slip]: [f64; 2]) -> f64 {
    (1.0 - 2.0 * eta * (1.0 - slip) / ((1.0 + slip) * (1.0 + eta))).sqrt()
}

pub(super) fn section(instrument: &Instrument, progress: &mut Progress) -> Result<Section, ReproduceError> {
    let mut section = Section {
        text: vec![format!(
            "The papers' loss vanishes with the speed. A dry loss does not: a slider whose bound is eta k g^r, eta = {ETA}, set-valued, or through a spring that \
             gives by s = {SLIP} of g^((r+1)/2) before the slider slips."
        )],
        ..Section::default()
    };
    let mut rebounds = Table::new(
        "Speed of rebound over speed of arrival, 10 g on a felt with k = 5e7, r = 2, h = 5 us; closed form of the dry ones last",
        &["loss", "0.02 m/s", "0.1 m/s", "0.5 m/s", "2 m/s", "closed form"],
    );
    let dry = |slip: f64| restitution([ETA, slip]);
    let (mut worst, mut quadratic) = (0.0_f64, [0.0; 2]);
    for (name, loss, exact) in [
        ("b g^2 dg/dt, b = 3e7", Loss::quadratic(3e7), None),
        ("set-valued", Loss::SetValued(SetValued { eta: ETA }), Some(dry(0.0))),
        ("elastoplastic", Loss::Elastoplastic(Elastoplastic { damping: 0.0, eta: ETA, slip: SLIP }), Some(dry(SLIP))),
    ] {
        let found = [0.02, 0.1, 0.5, 2.0].map(|speed| thrown_back(speed, 5e7, 2.0, loss, 5e-6));
        match exact {
            Some(exact) => worst = found.iter().fold(worst, |worst, e| worst.max((e - exact).abs())),
            None => quadratic = [found[0], found[3]],
        }
        let closed = exact.map_or_else(String::new, |e| format!("{e:.4}"));
        rebounds.row(
            [name.to_owned()].into_iter().chain(found.map(|e| format!("{e:.4}"))).chain([closed]).collect::<Vec<_>>(),
        );
    }
    section.claims.push(Claim::new(
        "this program",
        "a dry loss is the same at every speed, the papers' is not",
        format!(
            "dry: within {worst:.0e} of the closed form from 0.02 to 2 m/s; the papers': {:.3} and {:.3}",
            quadratic[0], quadratic[1]
        ),
        worst < 1e-3 && quadratic[0] > 0.98 && quadratic[1] < 0.7,
    ));
    section.tables.push(rebounds);
    let mut table = Table::new(
        "The action with such felts, the string's excepted; 50 us. Rocking: the hammer on its felts at rest, pushed by micrometres, pivots without friction",
        &[
            "loss",
            "rocking (Hz)",
            "left of it after 0.25 s",
            "8 N: hammer (m/s)",
            "lost in felts (mJ)",
            "key falls again (mm)",
            "energy residual",
            "Newton iterations a step",
            "not converged",
        ],
    );
    let (mut rocks, mut unconverged) = (Vec::new(), 0);
    for (i, law) in LAWS.iter().enumerate() {
        tell(progress, i as f64 / LAWS.len() as f64)?;
        let other = with(instrument, law);
        let rocking = rocking(&other)?;
        let run = Play::Stroke("f", Touch::Struck).run(&other, Settings::new(STEP_S), 1.0, 4)?;
        let Some(ledger) = &run.ledger else { continue };
        let released =
            run.time_s.iter().zip(&run.force_n).filter(|(_, f)| **f > 0.1).map(|(t, _)| *t).fold(0.0, f64::max);
        unconverged += run.work.unconverged_steps;
        let [frequency, left] = rocking.unwrap_or([f64::NAN; 2]);
        rocks.push([frequency, left]);
        table.row([
            law.name.to_owned(),
            format!("{frequency:.1}"),
            format!("{left:.2}"),
            run.events.hammer_speed_m_per_s().map_or_else(String::new, |speed| format!("{speed:.3}")),
            format!("{:.2}", 1e3 * ledger.felt_damping),
            format!("{:.2}", key_rebound_mm(&run, released)),
            format!("{:.0e}", ledger.residual_relative()),
            format!("{:.3}", run.work.newton_iterations as f64 / run.work.steps as f64),
            format!("{} of {}", run.work.unconverged_steps, run.work.steps),
        ]);
    }
    let [_, none, locked, slipping, _] = rocks[..] else { return Ok(section) };
    section.claims.push(Claim::new(
        "this program",
        "a set-valued loss locks what the felts hold; through a spring it goes on rocking",
        format!(
            "left of the rocking after 0.25 s: {:.2} set-valued, {:.2} elastoplastic ({:.0} Hz, {:.0} Hz without a loss)",
            locked[1], slipping[1], slipping[0], none[0]
        ),
        locked[1] < 0.01 && slipping[1] > 0.5 && slipping[0] >= none[0],
    ));
    section.claims.push(Claim::new(
        "this program",
        "no step is left unconverged with any of them",
        format!("{unconverged} steps"),
        unconverged == 0,
    ));
    section.tables.push(table);
    Ok(section)
}
