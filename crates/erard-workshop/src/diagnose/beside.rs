//! Readings of a key beside those of its neighbours.

use erard::keyboard::is_sharp;

use super::report::Diagnosis;

/// Neighbours on either side whose mean is taken, and how near they must be: an octave.
const ON_A_SIDE: usize = 2;
const NEAR_KEYS: usize = 12;

/// Sets in every line of a table of keys the mean of its neighbours: the nearest two keys on either side with the same
/// reading, naturals beside naturals and sharps beside sharps. A line with fewer than two neighbours keeps none.
/// `found` is in ascending order of keys.
pub(super) fn set(found: &mut [Diagnosis]) {
    let values: Vec<Vec<(&'static str, f64)>> =
        found.iter().map(|one| one.lines.iter().filter_map(|line| Some((line.name, line.value?))).collect()).collect();
    let keys: Vec<usize> = found.iter().map(|one| one.key).collect();
    for (at, one) in found.iter_mut().enumerate() {
        let key = one.key;
        let is_beside = |other: &usize| {
            let (own, near) = (is_sharp(keys[*other]) == is_sharp(key), keys[*other].abs_diff(key) <= NEAR_KEYS);
            keys[*other] != key && own && near
        };
        for line in &mut one.lines {
            let of = |other: usize| values[other].iter().find(|(name, _)| *name == line.name).map(|(_, value)| *value);
            let below = (0..at).rev().filter(is_beside).filter_map(of).take(ON_A_SIDE);
            let above = (at + 1..keys.len()).filter(is_beside).filter_map(of).take(ON_A_SIDE);
            let all: Vec<f64> = below.chain(above).collect();
            line.neighbours = (all.len() > 1).then(|| all.iter().sum::<f64>() / all.len() as f64);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::entry::Known;
    use super::super::report::diagnose_all;

    /// By hand: naturals of let-off 1.5, 1.7, 2.0, 1.6 and 1.4 mm, and a sharp between them of 3.0 mm that does not
    /// count: the middle one is 0.45 mm above the mean of the other four, 1.55 mm.
    #[test]
    fn the_mean_of_the_neighbours_by_hand() {
        let of = |key: usize, let_off: f64| {
            let mut known = Known::default();
            known.set("let_off_mm", Some(let_off));
            (key, known)
        };
        let keys = [of(40, 1.5), of(42, 1.7), of(43, 3.0), of(44, 2.0), of(45, 1.6), of(47, 1.4), of(68, 1.0)];
        let found = diagnose_all(&keys, &mut |_| true);
        let beside = |key: usize| found.iter().find(|one| one.key == key).unwrap().lines[0].neighbours;
        assert!((beside(44).unwrap() - 1.55).abs() < 1e-12);
        // At the end two neighbours are enough, of one side; one sharp and one far key have none.
        assert!((beside(40).unwrap() - 1.85).abs() < 1e-12 && beside(43).is_none() && beside(68).is_none());
        assert!(
            (found.iter().find(|one| one.key == 44).unwrap().lines[0].off_neighbours().unwrap() - 0.45).abs() < 1e-12
        );
    }
}
