//! An observer of the largest turns of bodies and compressions of felts.

use crate::instrument::Instrument;
use crate::mechanism::Readout;

/// The largest of a quantity so far, and when.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Furthest {
    /// In the quantity's own unit.
    pub value: f64,
    /// s.
    pub time_s: f64,
}

impl Furthest {
    const NOT_YET: Self = Furthest { value: 0.0, time_s: 0.0 };

    /// Keeps a larger value.
    fn up(&mut self, value: f64, time_s: f64) {
        if value > self.value {
            *self = Furthest { value, time_s };
        }
    }

    /// Keeps a smaller value.
    fn down(&mut self, value: f64, time_s: f64) {
        if value < self.value {
            *self = Furthest { value, time_s };
        }
    }
}

/// Largest turns of the bodies of an instrument, and largest compressions of its felts, over every step.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Extremes {
    /// Lowest (at most 0) and highest (at least 0) angle of each body against its parent, from as drawn, rad
    /// counter-clockwise.
    pub turned: Vec<[Furthest; 2]>,
    /// Deepest compression of each zone, m, at least 0.
    pub deepest: Vec<Furthest>,
    /// That angle of every body at the first instant, rad; empty before it.
    pub first: Vec<f64>,
    /// Parent of every body, and its angle as drawn relative to the parent, rad.
    hinges: Vec<(Option<usize>, f64)>,
}

impl Extremes {
    /// Nothing has moved yet.
    #[must_use]
    pub fn new(instrument: &Instrument) -> Self {
        let drawn = |body: usize| instrument.bodies[body].angle_rad;
        let hinges = instrument.bodies.iter().map(|b| (b.parent, b.angle_rad - b.parent.map_or(0.0, drawn)));
        Extremes {
            turned: vec![[Furthest::NOT_YET; 2]; instrument.bodies.len()],
            deepest: vec![Furthest::NOT_YET; instrument.zones.len()],
            first: Vec::new(),
            hinges: hinges.collect(),
        }
    }

    /// After a step that ended at `time_s`.
    pub(crate) fn observe(&mut self, time_s: f64, now: &Readout<'_>) {
        self.note_angles(time_s, now.angles);
        for (deepest, contact) in self.deepest.iter_mut().zip(now.contacts) {
            if let Some(contact) = contact {
                deepest.up(contact.compression, time_s);
            }
        }
    }

    /// Absolute angles of the bodies at an instant, rad.
    pub fn note_angles(&mut self, time_s: f64, angles: &[f64]) {
        let is_first = self.first.is_empty();
        for ((turned, (parent, drawn)), angle) in self.turned.iter_mut().zip(&self.hinges).zip(angles) {
            // A parent precedes its children.
            let by = angle - parent.map_or(0.0, |parent| angles[parent]) - drawn;
            if is_first {
                self.first.push(by);
            }
            turned[0].down(by, time_s);
            turned[1].up(by, time_s);
        }
    }

    /// The compressions of the zones at an instant, m, in the instrument's order; negative where a zone is open.
    pub fn note_compressions(&mut self, time_s: f64, compressions_m: impl Iterator<Item = f64>) {
        for (deepest, compression_m) in self.deepest.iter_mut().zip(compressions_m) {
            deepest.up(compression_m, time_s);
        }
    }
}
