//! Topology that mechanisms must share to be stepped in lanes.

use std::collections::BTreeMap;

use erard::assembly;

use erard::instrument::{Curve, Instrument};
use moreau::{Felt, FeltKind};

/// A zone without its numbers: its bodies, the kinds of its curve and felt, and whether it has friction.
type ZoneKind = (Option<usize>, Option<usize>, u8, FeltKind, bool);

/// An instrument without its numbers.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Topology {
    parents: Vec<Option<usize>>,
    zones: Vec<ZoneKind>,
    key: Option<usize>,
}

impl Topology {
    pub(crate) fn of(instrument: &Instrument) -> Self {
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
                    let felt: Felt<f64> = assembly::felt(&zone.felt);
                    (zone.disc_body, zone.curve_body, curve, felt.kind(), zone.friction_coefficient > 0.0)
                })
                .collect(),
            key: instrument.roles.key,
        }
    }
}

/// Groups places of one kind, at most `width` each; the last group of a kind may be smaller.
pub(super) fn groups<K: Ord>(kinds: impl Iterator<Item = (K, usize)>, width: usize) -> Vec<Vec<usize>> {
    let mut places: BTreeMap<K, Vec<usize>> = BTreeMap::new();
    for (kind, place) in kinds {
        places.entry(kind).or_default().push(place);
    }
    let mut groups: Vec<Vec<usize>> =
        places.values().flat_map(|places| places.chunks(width).map(<[usize]>::to_vec)).collect();
    groups.sort_unstable();
    groups
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_are_of_one_kind() {
        let kinds = [7, 7, 8, 7, 7, 7, 8];
        let of_width = |width| groups(kinds.into_iter().zip(0..), width);
        assert_eq!(of_width(4), [vec![0, 1, 3, 4], vec![2, 6], vec![5]]);
        assert_eq!(of_width(1).concat(), [0, 1, 2, 3, 4, 5, 6]);
    }

    #[test]
    fn numbers_are_not_topology() {
        let grand = Instrument::builtin("concert-grand").unwrap();
        let mut other = grand.clone();
        other
            .edit(|fields| {
                fields.bodies[0].mass_kg *= 2.0;
                fields.zones[0].felt.stiffness *= 2.0;
            })
            .unwrap();
        assert_eq!(Topology::of(&grand), Topology::of(&other));
        other.edit(|fields| fields.zones[0].felt.exponent = 1.7).unwrap();
        assert_ne!(Topology::of(&grand), Topology::of(&other));
        let mut other = grand.clone();
        other.edit(|fields| fields.zones[0].felt.loss = moreau::Loss::hunt_crossley(0.5)).unwrap();
        assert_ne!(Topology::of(&grand), Topology::of(&other));
    }
}
