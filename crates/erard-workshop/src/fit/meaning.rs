//! Bench quantities for fitted parameters with misleading names.

use erard::grand::{Parts, strike_weight_g};
use erard::instrument::Instrument;
use erard::player::AtRest;

use super::{FitError, FitResult, Meaning, Simulator};
use crate::distances::{Distances, Protocol, Trial};

/// Reads a bench quantity; `None` if the instrument does not have it.
type Reading = fn(&Instrument) -> Option<f64>;
/// Misleading names: explanation, quantity read instead, its unit and reading.
const NAMES: [(&str, &str, &str, &str, Reading); 2] = [
    ("body.hammer.mass", "the mass beyond the shank's hinge", "strike weight", "g", strike_weight),
    ("let_off", "the place of a screw", "distance of hammer and string at let-off (below 0 it blocks)", "mm", let_off),
];

/// Strike weight, g.
fn strike_weight(instrument: &Instrument) -> Option<f64> {
    let rigid = instrument.locked();
    Parts::of(&rigid).and_then(|parts| strike_weight_g(&rigid, &parts)).ok()
}

/// Let-off distance on a slow key, mm.
fn let_off(instrument: &Instrument) -> Option<f64> {
    let mut distances = Distances::default();
    let rest = instrument.pose(&mut |_| true).ok()?;
    Trial::SlowKey.run(&rest, &Protocol::default(), &mut distances, &mut |_| true).ok()?;
    distances.let_off_m.map(|m| 1e3 * m)
}

/// Returns the bench quantities of the fitted parameters, without those that the instrument does not have.
///
/// # Errors
/// An interruption.
pub(super) fn meanings(simulator: &mut Simulator<'_>, found: &FitResult) -> Result<Vec<Meaning>, FitError> {
    let problem = simulator.problem();
    let mut meanings = Vec::new();
    for (name, explanation, quantity, unit, read) in NAMES {
        let Some(k) = problem.parameters().iter().position(|one| one.name == name) else { continue };
        simulator.report()?;
        let mut above = found.point.clone();
        above[k] += found.solver_cov[k][k].sqrt();
        let Some(fitted) = problem.instrument_at(&found.point) else { continue };
        // Beyond a bound there may be no instrument.
        let above = problem.instrument_at(&above);
        if let (Some(before), Some(value)) = (read(problem.instrument()), read(&fitted)) {
            let std = above.and_then(|above| read(&above)).map_or(f64::NAN, |above| (above - value).abs());
            meanings.push(Meaning { name: name.to_owned(), explanation, quantity, unit, before, value, std });
        }
    }
    Ok(meanings)
}
