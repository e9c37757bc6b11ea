//! What must be alike for mechanisms to be stepped side by side.

use std::collections::BTreeMap;

use batch::WIDTH;
use moreau::Exponent;

use crate::instrument::{Curve, Instrument};

/// A zone but for its numbers: its bodies, its kind of curve and of exponent, whether it has friction.
type ZoneKind = (Option<usize>, Option<usize>, u8, u8, bool);

/// An instrument but for its numbers.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Topology {
    parents: Vec<Option<usize>>,
    zones: Vec<ZoneKind>,
    key: Option<usize>,
}

impl Topology {
    pub fn of(instrument: &Instrument) -> Self {
        Topology {
            parents: instrument.bodies.iter().map(|body| body.parent).collect(),
            zones: instrument
                .zones
                .iter()
                .map(|zone| {
                    let curve = match zone.curve {
                        Curve::Line { .. } => 0,
                        Curve::Segment { .. } => 1,
                        Curve::Disc { .. } => 2,
                    };
                    let exponent = match Exponent::new(zone.felt.exponent) {
                        Exponent::Two => 0,
                        Exponent::TwoAndHalf => 1,
                        Exponent::Three => 2,
                        Exponent::Other(_) => 3,
                    };
                    (zone.disc_body, zone.curve_body, curve, exponent, zone.friction_coefficient > 0.0)
                })
                .collect(),
            key: instrument.roles.key,
        }
    }
}

/// Groups of four places of one kind, as they come; the last group of a kind is filled up with its last place.
pub(super) fn fours<K: Ord>(kinds: impl Iterator<Item = (K, usize)>) -> Vec<[usize; WIDTH]> {
    let mut places: BTreeMap<K, Vec<usize>> = BTreeMap::new();
    for (kind, place) in kinds {
        places.entry(kind).or_default().push(place);
    }
    let four = |chunk: &[usize]| std::array::from_fn(|i| chunk[i.min(chunk.len() - 1)]);
    let mut groups: Vec<[usize; WIDTH]> = places.values().flat_map(|places| places.chunks(WIDTH).map(four)).collect();
    groups.sort_unstable();
    groups
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_are_of_one_kind_and_filled_up() {
        let kinds = [7, 7, 8, 7, 7, 7, 8];
        let groups = fours(kinds.into_iter().zip(0..));
        assert_eq!(groups, [[0, 1, 3, 4], [2, 6, 6, 6], [5, 5, 5, 5]]);
    }

    #[test]
    fn numbers_are_not_topology() {
        let grand = Instrument::builtin("concert-grand").unwrap();
        let mut other = grand.clone();
        other.bodies[0].mass_kg *= 2.0;
        other.zones[0].felt.stiffness *= 2.0;
        assert_eq!(Topology::of(&grand), Topology::of(&other));
        other.zones[0].felt.exponent = 1.7;
        assert_ne!(Topology::of(&grand), Topology::of(&other));
    }
}
