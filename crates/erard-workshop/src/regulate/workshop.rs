//! The action with its screws, and its measurements since they were last turned.

use super::{Goal, RegulateError};
use crate::distances::{DistanceError, Distances, Protocol, Trial};
use erard::instrument::Instrument;
use erard::player::{AtRest, RestKind, RestPose};

pub(super) struct Workshop<'a> {
    pub instrument: Instrument,
    kind: RestKind,
    /// Where it rests since a screw was last turned.
    rest: Option<RestPose>,
    protocol: Protocol,
    distances: Distances,
    /// Trials that are still valid: no screw has been turned since.
    fresh: Vec<Trial>,
    /// Trials made so far.
    pub simulations: u32,
    /// Returns whether to go on; called now and then.
    go_on: &'a mut dyn FnMut(u32) -> bool,
}

impl<'a> Workshop<'a> {
    pub(crate) fn new(action: &dyn AtRest, protocol: Protocol, go_on: &'a mut dyn FnMut(u32) -> bool) -> Self {
        Workshop {
            instrument: action.instrument().clone(),
            kind: action.kind(),
            rest: None,
            protocol,
            distances: Distances::default(),
            fresh: Vec::new(),
            simulations: 0,
            go_on,
        }
    }

    /// Returns the present value of a goal.
    pub(crate) fn value(&mut self, goal: Goal) -> Result<Option<f64>, DistanceError> {
        self.make(goal.trial())?;
        Ok(goal.of(&self.distances))
    }

    /// Returns all present distances.
    pub(crate) fn all(&mut self) -> Result<Distances, RegulateError> {
        for trial in Trial::ALL {
            self.make(trial)?;
        }
        Ok(self.distances)
    }

    fn make(&mut self, trial: Trial) -> Result<(), DistanceError> {
        if !self.fresh.contains(&trial) {
            self.simulations += 1;
            let simulations = self.simulations;
            let go_on = &mut *self.go_on;
            let progress = &mut |_| go_on(simulations);
            let rest = match self.rest.take() {
                Some(rest) => rest,
                None => RestPose::of(&self.instrument, self.kind, progress)?,
            };
            let rest = self.rest.insert(rest);
            trial.run(rest, &self.protocol, &mut self.distances, progress)?;
            self.fresh.push(trial);
        }
        Ok(())
    }

    pub(crate) fn setting(&self, screw: usize) -> f64 {
        self.instrument.screws[screw].setting
    }

    /// Turns a screw to a setting, rounded as in a file; earlier measurements become invalid.
    pub(crate) fn turn(&mut self, screw: usize, setting: f64) {
        let setting = self.instrument.screws[screw].action.rounded(setting);
        if setting != self.setting(screw) && self.instrument.turn(screw, setting) {
            self.forget();
        }
    }

    /// The action is no longer what was measured.
    fn forget(&mut self) {
        self.fresh.clear();
        self.rest = None;
    }

    /// Returns the settings of all screws.
    pub(crate) fn settings(&self) -> Vec<f64> {
        self.instrument.screws.iter().map(|screw| screw.setting).collect()
    }

    /// Turns all screws back to these settings.
    pub(crate) fn restore(&mut self, settings: &[f64]) {
        for (screw, &setting) in settings.iter().enumerate() {
            if setting != self.setting(screw) && self.instrument.turn(screw, setting) {
                self.forget();
            }
        }
    }
}
