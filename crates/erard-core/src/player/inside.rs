//! Pin reactions, accelerations and the flow of energy in a run.

use super::Observer;
use super::losses::LossRecorder;
use super::reactions::ReactionRecorder;
use crate::mechanism::Mechanism;

/// Observers of the forces and losses inside; none by default.
#[derive(Debug, Default)]
pub struct Inside {
    /// Pins and accelerations.
    pub reactions: Option<ReactionRecorder>,
    /// Losses.
    pub losses: Option<LossRecorder>,
}

impl Observer for Inside {
    fn begin(&mut self, time_s: f64, mechanism: &dyn Mechanism) {
        if let Some(reactions) = &mut self.reactions {
            reactions.begin(time_s, mechanism);
        }
        if let Some(losses) = &mut self.losses {
            losses.begin(time_s, mechanism);
        }
    }

    fn step(&mut self, time_s: f64, row: bool, mechanism: &dyn Mechanism) {
        if let Some(reactions) = &mut self.reactions {
            reactions.step(time_s, row, mechanism);
        }
        if let Some(losses) = &mut self.losses {
            losses.step(time_s, row, mechanism);
        }
    }
}
