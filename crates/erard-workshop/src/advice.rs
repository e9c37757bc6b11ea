//! What to do about what is out of the norm: which screw, which way and how far; which weights.

use thiserror::Error;

use crate::balance::{KeyModel, LEADS_G, LeadWork, lead_work};
use crate::distances::Protocol;
use crate::measure::norms::lines;
use crate::measure::{MeasureError, Sheet};
use crate::regulate::{Goal, RegulateError, Regulated, Specification, Status, regulate};
use erard::instrument::Instrument;

/// A balance weight and a ratio to aim at: the middle of 34 to 40 g, and of the 5.5 to 5.75 that Stanwood and Love call
/// ideal.
const BALANCE_G: f64 = 37.0;
const RATIO: f64 = 5.625;

/// What to do.
#[derive(Debug, Clone, Default)]
pub struct Advice {
    /// The screws turned until what is out of the norm is within it and all else is as it was; `None` where nothing is
    /// out that a screw sets.
    pub regulated: Option<Regulated>,
    /// What of [`Goal`]s was out.
    pub out: Vec<Goal>,
    /// Weights, in the order of work.
    pub weights: Vec<WeightWork>,
}

/// Work on weights and friction. Each stands by itself; after one, the key is weighed again.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum WeightWork {
    /// So much friction weight too much, g.
    Ease(f64),
    /// Friction weight below the usual range, by so much, g.
    Tighten(f64),
    /// A strike weight to be changed by so much, g, to the nearest that is usual.
    Hammer(f64),
    /// The capstan so far toward the player, mm, for a ratio of so much.
    Capstan(f64, f64),
    /// Leads for a balance weight of so much, g; `None` where no leads give it.
    Leads(Option<LeadWork>, f64),
}

/// Why no advice could be given.
#[derive(Debug, Error)]
pub enum AdviceError {
    /// The screws could not be tried.
    #[error(transparent)]
    Regulate(#[from] RegulateError),
    /// No model of the key's balance.
    #[error(transparent)]
    Measure(#[from] MeasureError),
}

/// The lines of the sheet that a goal of regulation sets.
const GOALS: [(&str, Goal, f64); 7] = [
    ("blow_mm", Goal::Blow, 1e-3),
    ("dip_mm", Goal::Dip, 1e-3),
    ("let_off_mm", Goal::LetOff, 1e-3),
    ("drop_mm", Goal::Drop, 1e-3),
    ("check_mm", Goal::Check, 1e-3),
    ("repetition_spring_m_s", Goal::Spring, 1.0),
    ("damper_start_share", Goal::Damper, 1.0),
];

/// Finds out what to do about a sheet's flags. What a screw sets is tried: the screws of an instrument's copy are
/// turned until what is out of the norm is at the trade's number, and what is within it is where it was. `progress`
/// receives the share that is done, and ends the work by returning false.
///
/// # Errors
/// See [`AdviceError`].
pub fn advise(
    instrument: &Instrument,
    sheet: &Sheet,
    progress: &mut dyn FnMut(&Status) -> bool,
) -> Result<Advice, AdviceError> {
    let (mut out, mut specification): (Vec<Goal>, Specification) = (Vec::new(), Vec::new());
    for (key, goal, factor) in GOALS {
        let Some(line) = lines().find(|line| line.key == key) else { continue };
        let has_screw = goal.screws().iter().any(|(name, _)| instrument.screw(name).is_some());
        let value = (line.value)(sheet);
        match (line.is_out(sheet), goal.norm(), value) {
            (true, Some(norm), _) => {
                out.push(goal);
                if has_screw {
                    specification.push((goal, norm));
                }
            }
            (false, _, Some(value)) if has_screw => specification.push((goal, value * factor)),
            _ => {}
        }
    }
    let turns = out.iter().any(|goal| specification.iter().any(|(asked, _)| asked == goal));
    let regulated =
        if turns { Some(regulate(instrument, &specification, &Protocol::default(), progress)?) } else { None };
    Ok(Advice { regulated, out, weights: weights(instrument, sheet)? })
}

/// Friction first, for it is in every other weight; then what throws the weight, and last the leads.
fn weights(instrument: &Instrument, sheet: &Sheet) -> Result<Vec<WeightWork>, MeasureError> {
    let beyond = |key: &str| -> Option<f64> {
        let line = lines().find(|line| line.key == key).filter(|line| line.is_out(sheet))?;
        let value = (line.value)(sheet)?;
        match line.range(sheet.norms_for_key) {
            [_, Some(high)] if value > high => Some(value - high),
            [Some(low), _] if value < low => Some(value - low),
            _ => None,
        }
    };
    let mut work = Vec::new();
    match beyond("friction_weight_g") {
        Some(by_g) if by_g > 0.0 => work.push(WeightWork::Ease(by_g)),
        Some(by_g) => work.push(WeightWork::Tighten(-by_g)),
        None => {}
    }
    work.extend(beyond("strike_weight_g").map(|by_g| WeightWork::Hammer(-by_g)));
    let model = KeyModel::of(instrument)?;
    if beyond("strike_weight_ratio_weights").is_some()
        && let Some(ratio) = sheet.strike_weight_ratio_weights
    {
        work.push(WeightWork::Capstan(model.capstan_move_mm(RATIO / ratio), RATIO));
    }
    let is_out = beyond("balance_weight_g").or(beyond("down_weight_g")).or(beyond("up_weight_g")).is_some();
    if is_out && let Some(balance_g) = sheet.balance_weight_g {
        work.push(WeightWork::Leads(lead_work(balance_g - BALANCE_G, model.key_front_mm, &LEADS_G, &[]), BALANCE_G));
    }
    Ok(work)
}
