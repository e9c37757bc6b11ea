//! Samples along many strokes.

use erard::instrument::Instrument;
use erard::run::Run;
use moreau_kernels::EveryBody;
use thiserror::Error;

/// Columns of a run's table to sample, and the number of steps between samples.
#[derive(Debug, Clone, PartialEq)]
pub struct Sampling {
    every: u64,
    columns: Vec<(String, Column)>,
}

/// Error for an unknown column.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("there is no column `{name}`; expected {}", .known.join(", "))]
#[non_exhaustive]
pub struct SamplingError {
    /// The unknown name.
    pub name: String,
    /// The known names.
    pub known: Vec<String>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Column {
    /// Finger force, travel of the key front or strike point, or the strike point's speed, by index in [`TRAVELS`].
    Travel(usize),
    Angle(usize),
    Rate(usize),
    /// Known from a run only.
    OfRun,
}

const FORCE: usize = 0;
const TRAVELS: [&str; 4] = ["force_N", "key_m", "hammer_rise_m", "hammer_rise_m_per_s"];
const HEAD: [usize; 2] = [2, 3];

impl Sampling {
    /// Samples these columns of [`Run::columns`], one row every `every` steps, the first at the start. Bodies and zones
    /// are those of an instrument; all played instruments must have the same.
    ///
    /// # Errors
    /// [`SamplingError`].
    pub fn of(instrument: &Instrument, columns: &[&str], every: u64) -> Result<Self, SamplingError> {
        let mut known: Vec<(String, Column)> =
            TRAVELS.iter().enumerate().map(|(i, name)| ((*name).to_owned(), Column::Travel(i))).collect();
        for (i, body) in instrument.bodies.iter().enumerate() {
            known.push((format!("{}_rad", body.name), Column::Angle(i)));
            known.push((format!("{}_rad_per_s", body.name), Column::Rate(i)));
        }
        for (_, body) in instrument.lying() {
            known.push((format!("{}_lift_m", instrument.bodies[body].name), Column::OfRun));
        }
        for zone in &instrument.zones {
            known.push((format!("{}_N", zone.name), Column::OfRun));
            if zone.friction_coefficient > 0.0 {
                known.push((format!("{}_tangential_N", zone.name), Column::OfRun));
            }
        }
        let find = |name: &&str| {
            known.iter().find(|(known, _)| known == name).cloned().ok_or_else(|| SamplingError {
                name: (*name).to_owned(),
                known: known.iter().map(|(name, _)| name.clone()).collect(),
            })
        };
        Ok(Sampling { every: every.max(1), columns: columns.iter().map(find).collect::<Result<_, _>>()? })
    }

    /// Whether lanes can sample all columns: the force of a motion, and contact forces, they cannot.
    pub(super) fn is_seen_in_lanes(&self, by_force: bool) -> bool {
        self.columns.iter().all(|(_, column)| match column {
            Column::Travel(FORCE) => by_force,
            Column::OfRun => false,
            _ => true,
        })
    }

    /// Returns the samples of a run that recorded every step.
    pub(super) fn of_run(&self, run: &Run) -> Vec<Vec<f64>> {
        let all = run.columns();
        let values = |name: &String| all.iter().find(|(known, _)| known == name).map_or(&[][..], |(_, values)| values);
        self.columns
            .iter()
            .map(|(name, _)| values(name).iter().step_by(self.every as usize).copied().collect())
            .collect()
    }
}

/// Samples collected during a stroke.
pub(super) struct Sampled<'a> {
    sampling: &'a Sampling,
    columns: Vec<Vec<f64>>,
    has_hammer: bool,
}

impl<'a> Sampled<'a> {
    pub(crate) fn new(sampling: &'a Sampling, instrument: &Instrument) -> Self {
        Sampled {
            sampling,
            columns: vec![Vec::new(); sampling.columns.len()],
            has_hammer: instrument.roles.hammer.is_some(),
        }
    }

    /// Whether a row is due after this number of steps.
    pub(crate) fn is_row(&self, steps: u64) -> bool {
        steps.is_multiple_of(self.sampling.every)
    }

    /// Whether the strike point's speed is sampled.
    pub(crate) fn has_speed(&self) -> bool {
        self.has_hammer && self.sampling.columns.iter().any(|(_, column)| *column == Column::Travel(HEAD[1]))
    }

    pub(crate) fn push(&mut self, travels: [f64; 4], angles: &EveryBody, velocities: &EveryBody) {
        for ((_, column), values) in self.sampling.columns.iter().zip(&mut self.columns) {
            match *column {
                Column::Travel(i) if HEAD.contains(&i) && !self.has_hammer => {}
                Column::Travel(i) => values.push(travels[i]),
                Column::Angle(i) => values.push(angles[i]),
                Column::Rate(i) => values.push(velocities[i]),
                Column::OfRun => {}
            }
        }
    }

    pub(crate) fn into_columns(self) -> Vec<Vec<f64>> {
        self.columns
    }
}
