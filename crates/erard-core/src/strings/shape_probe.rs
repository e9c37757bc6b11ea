//! The shape of a string, as a probe.

use super::modal::Strings;
use super::rows::WIDE;
use crate::instrument::PianoString;

/// How far from the striking point the string is looked at, m: toward the nearer end, and away from it. What a picture
/// of the action shows.
const SEEN_M: [f64; 2] = [0.10, 0.07];
/// At how many places.
const PLACES: usize = 35;

/// A table that turns the modes of one string into its shape; of the length of steps at which it was made.
#[derive(Debug, Clone)]
pub struct ShapeProbe {
    /// For each place and mode: the mode's place in the blocks, and its displacement there.
    table: Vec<Vec<(usize, f64)>>,
}

impl Strings {
    /// The probed string: the middle one.
    fn looked_at(&self) -> usize {
        self.strings().len() / 2
    }

    /// The places at which [`Strings::shape_probe`] looks, m from the striking point, away from the nearer end.
    #[must_use]
    pub fn probe_places_m(&self) -> Vec<f64> {
        let string = &self.strings()[self.looked_at()];
        let [from, to] = [(-string.strike_m).max(-SEEN_M[0]), (string.length_m - string.strike_m).min(SEEN_M[1])];
        (0..PLACES).map(|i| from + (to - from) * i as f64 / (PLACES - 1) as f64).collect()
    }

    /// A probe of the strings' shape there. Allocates.
    #[must_use]
    pub fn shape_probe(&self) -> ShapeProbe {
        let index = self.looked_at();
        let string = &self.strings()[index];
        let at = |place_m: f64| {
            let modes = self.vertical_modes_of(index);
            modes.map(|(n, at)| (at, PianoString::shape(n, string.strike_m + place_m, string.length_m))).collect()
        };
        ShapeProbe { table: self.probe_places_m().into_iter().map(at).collect() }
    }
}

impl ShapeProbe {
    /// The displacements now, m, away from the hammer.
    pub fn read(&self, strings: &Strings, to: &mut [f32]) {
        for (row, place) in self.table.iter().zip(to) {
            let shape: f64 = row.iter().map(|(at, shape)| shape * strings.mode_m(at / WIDE, at % WIDE)).sum();
            *place = shape as f32;
        }
    }
}
