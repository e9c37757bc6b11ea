//! Equilibria of many variants of an instrument, found in lanes.

use erard::Progress;
use erard::gradient::Poses;
use erard::instrument::Instrument;
use erard::run::SimulationError;
use moreau::Settings;

use super::lanes::{self, Rested};
use super::topology::{Topology, groups};
use super::{Lanes, cores};
use crate::cores::{do_all, job};

/// Returns where the presses of these instruments start, undriven or under a finger at this depth, m; `None` for one
/// that finds no equilibrium.
///
/// # Errors
/// [`SimulationError::Interrupted`].
pub(crate) fn rests(
    instruments: &[Instrument],
    begins_at_m: f64,
    threads: usize,
    progress: &mut Progress<'_>,
) -> Result<Vec<Option<Poses>>, SimulationError> {
    if begins_at_m > 0.0 {
        return cores::map(instruments, threads, progress, |instrument, progress| {
            match Poses::of(instrument, begins_at_m, progress) {
                Err(SimulationError::Interrupted) => Err(SimulationError::Interrupted),
                found => Ok(found.ok()),
            }
        });
    }
    let lanes = Lanes::most().in_doubles();
    let together = groups(instruments.iter().map(Topology::of).zip(0..), lanes.count());
    let mut outcomes: Vec<Option<Vec<Rested>>> = together.iter().map(|_| None).collect();
    let work = together.iter().zip(&mut outcomes).map(|(group, outcome)| {
        let group: Vec<&Instrument> = group.iter().map(|&place| &instruments[place]).collect();
        let settings = Settings::new(group.first().map_or(50e-6, |one| one.usual_step_s()));
        job(outcome, move |progress| lanes::settle(&group, settings, lanes, progress))
    });
    do_all(work.collect(), threads, progress)?;
    let mut all = vec![None; instruments.len()];
    for (group, outcome) in together.iter().zip(outcomes) {
        for (place, rested) in group.iter().zip(outcome.into_iter().flatten()) {
            all[*place] = rested.ok().map(|at_rest| Poses { rest: at_rest.state, start: at_rest.state });
        }
    }
    Ok(all)
}
