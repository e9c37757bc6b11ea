//! An observer of the largest turns of bodies and compressions of felts.

use super::LEAST_TURNOVER_J;
use crate::instrument::Instrument;
use crate::mechanism::{Impact, Readout};

/// The largest of a quantity so far, and when.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
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

/// An impact of the hammer, and what it can have come from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Blow {
    /// Total speed of the strike point, m/s.
    pub speed_m_per_s: f64,
    /// What finger, springs, felts and heights had given, J.
    pub given_j: f64,
    /// s.
    pub time_s: f64,
}

impl Blow {
    /// Least mass that can have this speed with all the energy, kg, doubled and inverted.
    fn takes(&self) -> f64 {
        self.speed_m_per_s * self.speed_m_per_s / self.given_j.max(LEAST_TURNOVER_J)
    }

    /// Highest speed that the energy can give to the end of a uniform rod of this mass, m/s: it moves as a third of the
    /// rod would. A hammer is heavier at its end.
    #[must_use]
    pub fn at_most_m_per_s(&self, mass_kg: f64) -> f64 {
        (6.0 * self.given_j.max(LEAST_TURNOVER_J) / mass_kg).sqrt()
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
    /// How far the key's front rose above its rest, and the strike point fell below its own, m, at most 0.
    pub beyond_rest: [Furthest; 2],
    /// The impact that took the largest share of all energy given up to it, if the energy balance is kept.
    pub blow: Option<Blow>,
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
            beyond_rest: [Furthest::NOT_YET; 2],
            blow: None,
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

    /// The key front's travel down and the strike point's rise at an instant, m from rest.
    pub fn note_travels(&mut self, time_s: f64, key_m: f64, hammer_rise_m: f64) {
        for (furthest, travel_m) in self.beyond_rest.iter_mut().zip([key_m, hammer_rise_m]) {
            furthest.down(travel_m, time_s);
        }
    }

    /// An impact of the hammer, and all energy given up to it, J ([`moreau::Ledger::given`]).
    pub fn note_blow(&mut self, impact: &Impact, given_j: f64) {
        let blow = Blow { speed_m_per_s: impact.hammer_speed_m_per_s, given_j, time_s: impact.time_s };
        if self.blow.is_none_or(|most| blow.takes() > most.takes()) {
            self.blow = Some(blow);
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
