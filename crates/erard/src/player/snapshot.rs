//! A player's state as plain data.

use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::instrument::Instrument;
use crate::mechanism::{Saved, Surfaces};

mod bytes;

pub use bytes::BYTES;

/// The version of [`Snapshot`] that this program writes, and the only one that it reads.
pub const VERSION: u32 = 1;

const BODIES: usize = 12;
const ZONES: usize = 32;

/// All that the steps of an [`crate::Action`] after an instant depend on, in plain numbers. It belongs to one instrument, which its digest
/// tells, and says nothing of the settings.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Snapshot {
    /// The state of the mechanism.
    #[serde(flatten)]
    pub mechanism: MechanismState,
    /// How strings that yield vibrate: none where the string is rigid, or was left out. It depends on the length of steps.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(super) strings: Vec<f64>,
}

/// All of a [`Snapshot`] but how strings that yield vibrate: of a size that is always the same, to be copied without allocating.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct MechanismState {
    /// See [`VERSION`].
    pub version: u32,
    /// Digest of the instrument's numbers.
    pub instrument: u64,
    /// The present instant, s, and what it is counted from: steps since an origin, s.
    pub time_s: f64,
    origin_s: f64,
    steps: u64,
    /// Absolute angles, rad, and angular velocities, rad/s; places beyond the instrument's bodies are zero.
    pub angle_rad: [f64; BODIES],
    /// See `angle_rad`.
    pub velocity_rad_s: [f64; BODIES],
    increment: [f64; BODIES],
    pivot_friction: [f64; BODIES],
    tangential: [f64; ZONES],
    side: [f64; ZONES],
    /// What the felts remember; a snapshot from before there were such felts has none.
    #[serde(default)]
    memory: [f64; ZONES],
    /// How far the pivots' and the zones' friction has grown at rest.
    #[serde(default)]
    pivot_rested: [f64; BODIES],
    /// See `pivot_rested`.
    #[serde(default)]
    rested: [f64; ZONES],
    rigid_force: f64,
    aimed_m: Option<f64>,
    flight: [Option<[f64; 3]>; 2],
}

/// Why a snapshot cannot be gone on from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum SnapshotError {
    /// Of another program.
    #[error("the snapshot is of version {0}; expected {VERSION}")]
    Version(u32),
    /// Of another instrument.
    #[error("the snapshot was taken of another instrument")]
    Instrument,
    /// A number is not finite.
    #[error("a number of the snapshot is not finite")]
    NotFinite,
    /// Bytes that are no snapshot: too few or too many, or they begin otherwise.
    #[error("{found} bytes are no snapshot; expected {BYTES} bytes that begin with `erardsav`")]
    NoSnapshot {
        /// How many there are.
        found: usize,
    },
    /// Bytes that were changed since they were written.
    #[error("the snapshot is damaged: its bytes do not add up")]
    Damaged,
}

impl Snapshot {
    /// How strings that yield vibrate, in numbers of theirs; none where they are at rest for all that is known.
    #[must_use]
    pub fn strings(&self) -> &[f64] {
        &self.strings
    }

    pub(crate) fn new(mechanism: MechanismState, surfaces: Option<&dyn Surfaces>) -> Self {
        let mut strings = Vec::with_capacity(surfaces.map_or(0, |surfaces| surfaces.numbers()));
        if let Some(surfaces) = surfaces {
            surfaces.save(&mut |number| strings.push(number));
        }
        Snapshot { mechanism, strings }
    }
}

impl MechanismState {
    pub(crate) fn new(instrument: u64, saved: Saved, aimed_m: Option<f64>) -> Self {
        let Saved { state, origin_s, steps, now_s, flight } = saved;
        MechanismState {
            version: VERSION,
            instrument,
            time_s: now_s,
            origin_s,
            steps,
            angle_rad: state.angle,
            velocity_rad_s: state.velocity,
            increment: state.increment,
            pivot_friction: state.pivot_friction,
            tangential: state.tangential,
            side: state.side,
            memory: state.memory,
            pivot_rested: state.pivot_rested,
            rested: state.rested,
            rigid_force: state.rigid_force,
            aimed_m,
            flight,
        }
    }

    /// What the mechanism goes on from, if this is of such an instrument and `strings` and all else is finite.
    pub(crate) fn open(&self, instrument: u64, strings: &[f64]) -> Result<(Saved, Option<f64>), SnapshotError> {
        if self.version != VERSION {
            return Err(SnapshotError::Version(self.version));
        }
        if self.instrument != instrument {
            return Err(SnapshotError::Instrument);
        }
        let lists: [&[f64]; 10] = [
            &self.angle_rad,
            &self.velocity_rad_s,
            &self.increment,
            &self.pivot_friction,
            &self.tangential,
            &self.side,
            &self.memory,
            &self.pivot_rested,
            &self.rested,
            strings,
        ];
        let single = [self.time_s, self.origin_s, self.rigid_force, self.aimed_m.unwrap_or(0.0)];
        let mut all = lists.into_iter().flatten().chain(&single).chain(self.flight.iter().flatten().flatten());
        if !all.all(|x| x.is_finite()) {
            return Err(SnapshotError::NotFinite);
        }
        let state = moreau::SavedState {
            angle: self.angle_rad,
            velocity: self.velocity_rad_s,
            increment: self.increment,
            pivot_friction: self.pivot_friction,
            tangential: self.tangential,
            side: self.side,
            rigid_force: self.rigid_force,
            memory: self.memory,
            pivot_rested: self.pivot_rested,
            rested: self.rested,
        };
        let MechanismState { origin_s, steps, time_s, flight, aimed_m, .. } = *self;
        Ok((Saved { state, origin_s, steps, now_s: time_s, flight }, aimed_m))
    }
}

/// FNV-1a over what the engine is given of an instrument: two with the same digest move alike.
pub(super) fn digest(instrument: &Instrument) -> u64 {
    let description = crate::assembly::describe::<f64>(instrument);
    let strings = if instrument.has_yielding_strings() { &instrument.strings[..] } else { &[] };
    // A float prints the shortest digits that read back as the same number.
    format!("{description:?}{strings:?}")
        .bytes()
        .fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3))
}
