//! A player's state as plain data.
//!
//! Its numbers are lists with names, in bytes ([`crate::saved`]) and in text alike. Names belong to the format: they do
//! not follow the fields of Rust types. An absent list means what its default says, zero or none; a list that is not
//! known is passed over.

use std::collections::BTreeMap;
use std::fmt;

use moreau::{FrictionLaw, SavedState, Settings, Solver};
use serde::de::{Error, IgnoredAny, MapAccess, Visitor};
use serde::ser::SerializeMap;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use thiserror::Error;

use crate::identity::{BODIES, Identity};
use crate::index::IndexError;
use crate::mechanism::{Saved, Surfaces, TellNumbers};
use crate::saved::{Lists, Unreadable, VERSION, Writer};

/// First bytes of a saved state.
pub const MARK: [u8; 8] = *b"erardsav";

/// What the names of the strings' lists begin with.
const STRINGS: &str = "string_";

/// Everything that the steps of an [`crate::Action`] after an instant depend on, in plain numbers. It belongs to one
/// instrument, identified by its digest, and to the settings of its steps.
#[derive(Debug, Clone, PartialEq)]
pub struct Snapshot {
    /// The state of the mechanism.
    pub mechanism: MechanismState,
    /// State of the modal strings; empty where the string is rigid, or was left out.
    strings: BTreeMap<String, Vec<f64>>,
}

/// A [`Snapshot`] without the vibration of modal strings, of fixed size, so that copying it does not allocate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MechanismState {
    instrument: u64,
    settings: StepSettings,
    /// Bodies and zones are in the order of their names; places beyond the instrument's are zero.
    saved: Saved,
    aimed_m: Option<f64>,
}

/// The settings that a state belongs to, as numbers: step, s; theta; solver; law of friction, and its two widths. A
/// step of zero means that the state does not say, as those written before states had settings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepSettings([f64; 6]);

impl StepSettings {
    const UNKNOWN: StepSettings = StepSettings([0.0; 6]);

    /// Whether a state of these settings may go on with others.
    fn allow(self, own: StepSettings) -> bool {
        self == own || self.0[0] == 0.0
    }
}

impl From<&Settings<f64>> for StepSettings {
    fn from(settings: &Settings<f64>) -> Self {
        let solver = match settings.solver {
            Solver::ActiveSet => 0.0,
            Solver::ProjectedGaussSeidel => 1.0,
        };
        let (friction, widths) = match settings.friction {
            FrictionLaw::SetValued => (0.0, [0.0; 2]),
            FrictionLaw::Regularised { pivot_width, sliding_width } => (1.0, [pivot_width, sliding_width]),
        };
        StepSettings([settings.step, settings.theta, solver, friction, widths[0], widths[1]])
    }
}

impl fmt::Display for StepSettings {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [step, theta, solver, friction, pivot, sliding] = self.0;
        let solver = if solver == 0.0 { "active-set" } else { "projected-gauss-seidel" };
        write!(f, "steps of {step} s, theta {theta}, solver {solver}, ")?;
        match friction {
            0.0 => f.write_str("friction set-valued"),
            _ => write!(f, "friction tanh of widths {pivot} rad/s and {sliding} m/s"),
        }
    }
}

/// Why a run cannot continue from a snapshot.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[non_exhaustive]
pub enum SnapshotError {
    /// The state belongs to another instrument.
    #[error("the snapshot belongs to another instrument")]
    Instrument,
    /// The state belongs to other settings of the steps.
    #[error("the snapshot belongs to other settings: {saved}; expected {own}")]
    Settings {
        /// Settings of the state.
        saved: StepSettings,
        /// Settings of the action.
        own: StepSettings,
    },
    /// There is no such key to continue.
    #[error(transparent)]
    Key(#[from] IndexError),
    /// A number is not finite.
    #[error("a number of the snapshot is not finite")]
    NotFinite,
    /// Bytes that are not a snapshot, or are of another version, or damaged.
    #[error(transparent)]
    Unreadable(#[from] Unreadable),
}

impl Snapshot {
    pub(crate) fn new(mechanism: MechanismState, surfaces: Option<&dyn Surfaces>) -> Self {
        let mut strings = BTreeMap::new();
        if let Some(surfaces) = surfaces {
            surfaces.save(&mut |name, numbers| {
                strings.insert(name.to_owned(), numbers.collect());
            });
        }
        Snapshot { mechanism, strings }
    }

    /// The snapshot as bytes, the same on every machine ([`crate::saved`]).
    #[must_use]
    pub fn to_vec(&self) -> Vec<u8> {
        let write = |bytes: &mut [u8]| {
            let mut out = Writer::new(bytes, MARK);
            self.mechanism.write(&mut out);
            for (name, numbers) in &self.strings {
                out.list(name, &mut numbers.iter().copied());
            }
            out.seal()
        };
        let mut bytes = vec![0; write(&mut [])];
        write(&mut bytes);
        bytes
    }

    /// Reads a snapshot from bytes. Restoring checks whether it belongs to the instrument. Without the strings' lists
    /// its strings are at rest.
    ///
    /// # Errors
    /// [`SnapshotError::Unreadable`], [`SnapshotError::NotFinite`].
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, SnapshotError> {
        let lists = Lists::read(bytes, MARK)?;
        let (mechanism, strings) = (MechanismState::read(&lists), lists.beginning(STRINGS));
        let finite = mechanism.is_finite() && strings.values().flatten().all(|number| number.is_finite());
        if finite { Ok(Snapshot { mechanism, strings }) } else { Err(SnapshotError::NotFinite) }
    }

    /// Reads the numbers of one of the strings' lists.
    pub(crate) fn each(&self, name: &str, number: &mut TellNumbers<'_>) -> usize {
        let numbers = self.strings.get(name).map_or(&[][..], |numbers| numbers);
        numbers.iter().enumerate().for_each(|(index, x)| number(index, *x));
        numbers.len()
    }
}

impl MechanismState {
    pub(crate) fn new(identity: &Identity, settings: &Settings<f64>, mut saved: Saved, aimed_m: Option<f64>) -> Self {
        saved.state = saved.state.reordered(&identity.bodies, &identity.zones);
        MechanismState { instrument: identity.digest, settings: settings.into(), saved, aimed_m }
    }

    /// Nothing known of an instrument: the default of every list.
    fn absent() -> Self {
        let state = SavedState::at_rest([0.0; BODIES]);
        let saved = Saved { state, origin_s: 0.0, steps: 0, now_s: 0.0, flight: [None; 2] };
        MechanismState { instrument: 0, settings: StepSettings::UNKNOWN, saved, aimed_m: None }
    }

    /// Digest of the instrument's numbers ([`crate::Instrument::digest`]).
    #[must_use]
    pub fn instrument(&self) -> u64 {
        self.instrument
    }

    /// The instant, s.
    #[must_use]
    pub fn time_s(&self) -> f64 {
        self.saved.now_s
    }

    /// Every number but the digest: the one list of names, by which states are written, read and checked. What may be
    /// absent (a finger's aim, a sample of the flight) has a number before it that is 1 if it is there.
    fn lists(&mut self, list: &mut dyn FnMut(&'static str, &mut [f64])) {
        let MechanismState { instrument: _, settings, saved, aimed_m } = self;
        let Saved { state, origin_s, steps, now_s, flight } = saved;
        let SavedState {
            angle,
            velocity,
            increment,
            pivot_friction,
            tangential,
            side,
            rigid_force,
            hand,
            memory,
            pivot_rested,
            rested,
        } = state;
        list("settings", &mut settings.0);
        list("angle_rad", angle);
        list("velocity_rad_s", velocity);
        list("increment_rad_s", increment);
        list("pivot_friction_N_m", pivot_friction);
        list("tangential_N", tangential);
        list("side", side);
        list("rigid_force_N", std::slice::from_mut(rigid_force));
        list("hand_m_and_m_per_s", hand);
        list("felt_memory", memory.as_flattened_mut());
        list("pivot_rested", pivot_rested);
        list("zone_rested", rested);
        list("time_s", std::slice::from_mut(now_s));
        list("origin_s", std::slice::from_mut(origin_s));
        // Whole numbers up to 2^53 are floats.
        let mut count = [*steps as f64];
        list("steps", &mut count);
        *steps = count[0] as u64;
        optional("aimed_m", aimed_m.map(|aimed_m| [aimed_m]), list, |found| *aimed_m = found.map(|[aimed_m]| aimed_m));
        let [first, second] = flight;
        optional("flight", *first, list, |found| *first = found);
        optional("flight_before", *second, list, |found| *second = found);
    }

    /// Writes its lists.
    pub fn write(&self, out: &mut Writer<'_>) {
        out.word("instrument", self.instrument);
        let mut copy = *self;
        copy.lists(&mut |name, numbers| out.list(name, &mut numbers.iter().copied()));
    }

    /// Reads its lists. Whether it belongs to an instrument and is finite is seen when it is restored.
    #[must_use]
    pub fn read(lists: &Lists<'_>) -> Self {
        let mut state = MechanismState { instrument: lists.word("instrument").unwrap_or(0), ..Self::absent() };
        state.lists(&mut |name, places| lists.fill(name, places));
        state
    }

    fn is_finite(&self) -> bool {
        let (mut copy, mut finite) = (*self, true);
        copy.lists(&mut |_, numbers| finite &= numbers.iter().all(|number| number.is_finite()));
        finite
    }

    /// What the mechanism goes on from, if this is of such an instrument and such settings, and finite.
    pub(crate) fn open(
        &self,
        identity: &Identity,
        settings: &Settings<f64>,
    ) -> Result<(Saved, Option<f64>), SnapshotError> {
        if self.instrument != identity.digest {
            return Err(SnapshotError::Instrument);
        }
        if !self.is_finite() {
            return Err(SnapshotError::NotFinite);
        }
        let own = settings.into();
        if !self.settings.allow(own) {
            return Err(SnapshotError::Settings { saved: self.settings, own });
        }
        let mut saved = self.saved;
        saved.state = saved.state.reordered(&places(&identity.bodies), &places(&identity.zones));
        Ok((saved, self.aimed_m))
    }
}

/// A list of numbers that may be absent, with a 1 before it if it is there.
fn optional<const K: usize>(
    name: &'static str,
    numbers: Option<[f64; K]>,
    list: &mut dyn FnMut(&'static str, &mut [f64]),
    set: impl FnOnce(Option<[f64; K]>),
) {
    let mut all = [0.0; 4];
    if let ([is_there, places @ ..], Some(numbers)) = (&mut all, numbers) {
        *is_there = 1.0;
        for (k, place) in places.iter_mut().enumerate() {
            if let Some(number) = numbers.get(k) {
                *place = *number;
            }
        }
    }
    list(name, all.get_mut(..=K).unwrap_or_default());
    let [is_there, rest @ ..] = all;
    set((is_there != 0.0).then(|| rest.first_chunk().copied()).flatten());
}

/// Where in an order each index stands.
fn places<const K: usize>(order: &[usize; K]) -> [usize; K] {
    let mut places = [0; K];
    for (place, index) in order.iter().enumerate() {
        if let Some(of_index) = places.get_mut(*index) {
            *of_index = place;
        }
    }
    places
}

/// Whether every number is finite of the lists that surfaces would save.
pub(crate) fn strings_are_finite(
    surfaces: &dyn Surfaces,
    each: &dyn Fn(&str, &mut TellNumbers<'_>) -> usize,
) -> Result<(), SnapshotError> {
    let mut finite = true;
    surfaces.save(&mut |name, _| {
        each(name, &mut |_, number| finite &= number.is_finite());
    });
    if finite { Ok(()) } else { Err(SnapshotError::NotFinite) }
}

impl Serialize for Snapshot {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("version", &VERSION)?;
        map.serialize_entry("instrument", &self.mechanism.instrument)?;
        let (mut copy, mut result) = (self.mechanism, Ok(()));
        copy.lists(&mut |name, numbers| {
            if result.is_ok() {
                result = map.serialize_entry(name, &*numbers);
            }
        });
        result?;
        for (name, numbers) in &self.strings {
            map.serialize_entry(name, numbers)?;
        }
        map.end()
    }
}

impl<'de> Deserialize<'de> for Snapshot {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(Named)
    }
}

struct Named;

/// A list of a later version may be anything.
#[derive(Deserialize)]
#[serde(untagged)]
enum Entry {
    Numbers(Vec<f64>),
    Other(IgnoredAny),
}

impl<'de> Visitor<'de> for Named {
    type Value = Snapshot;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a snapshot: lists of numbers by name")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Snapshot, A::Error> {
        let (mut mechanism, mut strings) = (MechanismState::absent(), BTreeMap::new());
        while let Some(name) = map.next_key::<String>()? {
            match name.as_str() {
                "version" => {
                    let version = map.next_value()?;
                    if version != VERSION {
                        return Err(A::Error::custom(Unreadable::Version(version)));
                    }
                }
                "instrument" => mechanism.instrument = map.next_value()?,
                _ => {
                    if let Entry::Numbers(numbers) = map.next_value()? {
                        strings.insert(name, numbers);
                    }
                }
            }
        }
        mechanism.lists(&mut |name, places| {
            let numbers = strings.remove(name).unwrap_or_default();
            places.iter_mut().zip(numbers).for_each(|(place, number)| *place = number);
        });
        strings.retain(|name, _| name.starts_with(STRINGS));
        Ok(Snapshot { mechanism, strings })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Action, Input, Instrument};

    fn pressed() -> Snapshot {
        let mut action = Action::new(&Instrument::builtin("concert-grand-rigid").unwrap()).unwrap();
        for n in 0..700 {
            action.step(Input::Rigid { position_m: f64::from(n) * 1e-5, velocity_m_per_s: 0.2 });
        }
        action.save()
    }

    /// Every number is read back as it was, and every list is one that is written.
    #[test]
    fn bytes_and_back() {
        let snapshot = pressed();
        let own = &snapshot.mechanism;
        assert!(own.aimed_m.is_some() && own.saved.flight.iter().all(Option::is_some));
        assert!(own.saved.state.side.iter().any(|side| *side != 0.0));
        assert_eq!(Snapshot::from_bytes(&snapshot.to_vec()), Ok(snapshot.clone()));
        let mut none = snapshot.clone();
        (none.mechanism.aimed_m, none.mechanism.saved.flight) = (None, [None, Some([1.0, 2.0, 3.0])]);
        assert_eq!(Snapshot::from_bytes(&none.to_vec()), Ok(none.clone()));
        // Every place of every list has a number of its own.
        let (mut all, mut counted) = (none.clone(), 1.0);
        all.mechanism.lists(&mut |_, numbers| {
            for number in numbers {
                *number = counted;
                counted += 1.0;
            }
        });
        assert_eq!(counted, 1.0 + f64::from(6 + 5 * 12 + 3 * 32 + 4 * 32 + 4 + 2 + 2 + 2 * 4));
        assert_eq!(Snapshot::from_bytes(&all.to_vec()), Ok(all));
        let mut broken = snapshot;
        broken.mechanism.saved.state.rigid_force = f64::NAN;
        assert_eq!(Snapshot::from_bytes(&broken.to_vec()), Err(SnapshotError::NotFinite));
    }

    /// A state of a later program has lists more, in bytes and in text; that of an earlier one lacks some, which are
    /// then zero or none.
    #[test]
    fn a_list_more_and_a_list_fewer() {
        let snapshot = pressed();
        let write = |without: &str, more: bool| {
            let write = |bytes: &mut [u8]| {
                let mut out = Writer::new(bytes, MARK);
                out.word("instrument", snapshot.mechanism.instrument);
                let mut copy = snapshot.mechanism;
                copy.lists(&mut |name, numbers| {
                    if more {
                        out.list("of_a_later_program", &mut [f64::NAN, 2.0].into_iter());
                    }
                    if name != without {
                        out.list(name, &mut numbers.iter().copied());
                    }
                });
                out.seal()
            };
            let mut bytes = vec![0; write(&mut [])];
            write(&mut bytes);
            Snapshot::from_bytes(&bytes).unwrap()
        };
        let text = |change: &dyn Fn(&mut serde_json::Map<String, serde_json::Value>)| {
            let mut text = serde_json::to_value(&snapshot).unwrap();
            change(text.as_object_mut().unwrap());
            serde_json::from_value::<Snapshot>(text).unwrap()
        };
        assert_eq!(write("", true), snapshot);
        let more = |text: &mut serde_json::Map<String, serde_json::Value>| {
            text.insert("of_a_later_program".to_owned(), serde_json::json!({ "a": [1, "b"] }));
        };
        assert_eq!(text(&more), snapshot);
        let mut names = Vec::new();
        let mut copy = snapshot.mechanism;
        copy.lists(&mut |name, _| names.push(name));
        assert_eq!(names.len(), 18);
        for name in names {
            let mut expected = snapshot.clone();
            expected.mechanism.lists(&mut |found, numbers| {
                if found == name {
                    numbers.fill(0.0);
                }
            });
            assert_ne!((expected == snapshot, name), (true, "angle_rad"));
            assert_eq!(write(name, false), expected, "{name}");
            assert_eq!(text(&|text| drop(text.remove(name).unwrap())), expected, "{name}");
        }
    }
}
