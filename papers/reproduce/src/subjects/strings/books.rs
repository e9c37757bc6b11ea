//! Check for energy gains: the energy balance of whole notes, and of a hammer that stays on the strings.

use erard::instrument::Instrument;
use erard::mechanism::{open_ledger, update_energies};
use erard::stroke::{NUANCES, Touch};
use moreau::Settings;

use super::super::impact::{Play, tell};
use super::super::{Claim, Progress, ReproduceError, Section};
use super::head;
use erard_workshop::first_impact::STEP_S;

/// Largest unexplained share of the work.
const RESIDUAL: f64 = 1e-4;
/// Speed at which the head falls on the strings, m/s; a weight of 2 N keeps it there.
const FALLS_M_PER_S: f64 = 2.0;
const GRAVITY_M_PER_S2: f64 = 225.0;
/// Steps for this, s, and duration, s.
const STEPS_S: [f64; 3] = [20e-6, 50e-6, 200e-6];
const STAYS_S: f64 = 1.0;

/// Adds the claims.
pub(super) fn add(grand: &Instrument, section: &mut Section, progress: &mut Progress) -> Result<(), ReproduceError> {
    let mut told = Vec::new();
    let (mut worst, mut least) = (0.0_f64, 0.0_f64);
    for (n, nuance) in NUANCES.into_iter().enumerate() {
        tell(progress, 0.1 * n as f64)?;
        let run = Play::Stroke(nuance, Touch::Pressed).run(grand, Settings::new(STEP_S), 1.0, u64::MAX)?;
        let Some(ledger) = &run.ledger else { continue };
        let residual = ledger.residual_relative();
        told.push(format!("{nuance} {residual:.1e}"));
        worst = if residual.is_nan() { f64::INFINITY } else { worst.max(residual) };
        least = least.min(ledger.smallest_term);
    }
    section.claims.push(Claim::new(
        "this program",
        "the energy balance of a whole note with strings and dampers, a second long at 50 us, closes to 1e-4 of the work, and no loss is negative",
        told.join(", "),
        told.len() == NUANCES.len() && worst < RESIDUAL && least >= 0.0,
    ));
    let falling = head::falling(grand, GRAVITY_M_PER_S2)?;
    let mut told = Vec::new();
    let mut holds = true;
    for (n, step_s) in STEPS_S.into_iter().enumerate() {
        tell(progress, 0.5 + n as f64 / 6.0)?;
        let mut head = head::thrown(&falling, step_s, -FALLS_M_PER_S)?;
        let mut ledger = open_ledger(head.as_mut());
        let (mut lost, mut won) = (0.0, 0.0_f64);
        for _ in 0..(STAYS_S / step_s) as usize {
            head.step(&moreau::SiteInput::Free);
            head.record_energy(&mut ledger);
            won = won.max(lost - ledger.surface);
            lost = ledger.surface;
        }
        update_energies(head.as_ref(), &mut ledger);
        let residual = ledger.residual_relative();
        told.push(format!("{:.0} us: {residual:.1e}, {:.2} mJ lost in the strings", 1e6 * step_s, 1e3 * lost));
        // Losses are differences of work and energy: their rounding is no gain.
        holds &= residual < RESIDUAL && won < 1e-15 && ledger.smallest_term >= 0.0 && lost > 0.0;
    }
    section.claims.push(Claim::new(
        "this program",
        "a hammer that is kept on the strings for a second gains no energy from them: in no step do they give back what they had lost, and the balance closes to 1e-4",
        told.join("; "),
        holds,
    ));
    Ok(())
}
