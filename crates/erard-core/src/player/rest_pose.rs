//! Rest as a technician finds it: the pose after a moderate blow and its release.
//!
//! Dry friction holds an action wherever it came to rest, so every static quantity depends on how it got there. A
//! drawing is no such way: the hammer that settles from the angles in a file keeps half a millimetre that the first
//! blow takes away. [`RestPose`] is the one place where that pose is found.

use std::borrow::Cow;

use moreau::Settings;
use serde::Serialize;

use super::equilibrium::{self, EquilibriumError};
use super::{Action, ActionError, Input, PlayError, Snapshot};
use crate::instrument::Instrument;
use crate::progress::Progress;

/// Force of the blow on the key front, N, applied at once and held: about mf, the medium blow of the trade's trials.
pub const BLOW_N: f64 = 4.0;
/// Time for which the force acts, s: the hammer hangs in the check, and the key has stopped bouncing on its punching.
pub const HELD_S: f64 = 0.15;
/// Time in which the finger then lets the key up, s: its force falls evenly to zero.
pub const LET_UP_S: f64 = 0.05;

/// How an action comes to rest before it is measured.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum RestKind {
    /// Played once and released: what a technician reads.
    #[default]
    AsPlayed,
    /// Settled from the angles in the instrument file, where runs start ([`Action::new`]).
    AsDrawn,
}

/// What rests: an instrument, which is then played first, or a [`RestPose`] that has been found before.
pub trait AtRest: Sync {
    /// The instrument.
    fn instrument(&self) -> &Instrument;

    /// How it comes to rest.
    fn kind(&self) -> RestKind;

    /// The pose. `progress` ends the search by returning false.
    ///
    /// # Errors
    /// See [`ActionError`]; [`EquilibriumError::Interrupted`].
    fn pose(&self, progress: &mut Progress<'_>) -> Result<Cow<'_, RestPose>, ActionError>;
}

impl AtRest for Instrument {
    fn instrument(&self) -> &Instrument {
        self
    }

    fn kind(&self) -> RestKind {
        RestKind::AsPlayed
    }

    fn pose(&self, progress: &mut Progress<'_>) -> Result<Cow<'_, RestPose>, ActionError> {
        RestPose::of(self, RestKind::AsPlayed, progress).map(Cow::Owned)
    }
}

impl AtRest for RestPose {
    fn instrument(&self) -> &Instrument {
        &self.instrument
    }

    fn kind(&self) -> RestKind {
        self.kind
    }

    fn pose(&self, _: &mut Progress<'_>) -> Result<Cow<'_, RestPose>, ActionError> {
        Ok(Cow::Borrowed(self))
    }
}

/// An instrument with the pose in which its action rests: found once, started from as often as wanted.
#[derive(Debug, Clone)]
pub struct RestPose {
    instrument: Instrument,
    kind: RestKind,
    state: Snapshot,
}

impl RestPose {
    /// Finds the pose. It is the same for every step and solver with which the action is played afterwards. An
    /// instrument without a key rests as drawn.
    ///
    /// # Errors
    /// See [`ActionError`]; [`EquilibriumError::Interrupted`] when `progress` returns false.
    pub fn of(instrument: &Instrument, kind: RestKind, progress: &mut Progress<'_>) -> Result<Self, ActionError> {
        let mut action = Action::with_progress(instrument, equilibrium::settings(), progress)?;
        if kind == RestKind::AsPlayed {
            play(&mut action, instrument, progress)?;
        }
        Ok(RestPose { instrument: instrument.clone(), kind, state: action.save() })
    }

    /// The pose after one more blow, from this one.
    ///
    /// # Errors
    /// As [`RestPose::of`].
    pub fn played_again(&self, progress: &mut Progress<'_>) -> Result<Self, ActionError> {
        let mut action = self.action(equilibrium::settings())?;
        play(&mut action, &self.instrument, progress)?;
        Ok(RestPose { instrument: self.instrument.clone(), kind: RestKind::AsPlayed, state: action.save() })
    }

    /// The pose of another instrument that is played, or drawn, as this one.
    ///
    /// # Errors
    /// As [`RestPose::of`].
    pub fn of_variant(&self, other: &Instrument, progress: &mut Progress<'_>) -> Result<Self, ActionError> {
        RestPose::of(other, self.kind, progress)
    }

    /// The pose to which an instrument with the same bodies settles from this one: something was taken away, or put in
    /// the way, after the blow.
    ///
    /// # Errors
    /// As [`RestPose::of`].
    pub fn changed(&self, other: &Instrument, progress: &mut Progress<'_>) -> Result<Self, ActionError> {
        let mut action = Action::as_drawn(other, equilibrium::settings())?;
        action.put(self.action(equilibrium::settings())?.angles());
        action.settle(other, Input::Free, progress)?;
        Ok(RestPose { instrument: other.clone(), kind: self.kind, state: action.save() })
    }

    /// An action in this pose, from which its travels are measured, at 0 s.
    ///
    /// # Errors
    /// A step out of range.
    pub fn action(&self, settings: Settings<f64>) -> Result<Action, ActionError> {
        Action::check_step(settings.step)?;
        let mut action = Action::as_drawn(&self.instrument, equilibrium::settings())?;
        // The state is that of this instrument and of these settings.
        let _ = action.restore(&self.state);
        action.set_settings(settings);
        action.set_reference_pose(&self.instrument);
        Ok(action)
    }
}

/// The blow, its release, and the way to rest; a force on the key, nothing else. Without a key nothing is played.
fn play(action: &mut Action, instrument: &Instrument, progress: &mut Progress<'_>) -> Result<(), EquilibriumError> {
    if instrument.roles.key.is_none() {
        return Ok(());
    }
    let own = *action.settings();
    let settings = Settings::new(own.step);
    action.set_settings(settings);
    let steps = ((HELD_S + LET_UP_S) / settings.step).round() as u64;
    let mut times = (0..steps).map(|n| (n as f64 + settings.theta) * settings.step);
    let force = |t: f64| BLOW_N * (1.0 - (t - HELD_S) / LET_UP_S).clamp(0.0, 1.0);
    let played = action.play(progress, &mut |_| times.next().map(|t| Input::Force(force(t))));
    action.set_settings(own);
    played.map_err(|error| match error {
        PlayError::Interrupted => EquilibriumError::Interrupted,
        PlayError::NonFinite { .. } => EquilibriumError::NonFinite,
    })?;
    action.settle(instrument, Input::Free, progress)?;
    Ok(())
}
