//! Which rows of a run become frames of the page.

use erard::run::Run;

/// Most frames that a page carries: a megabyte or two of data for the grand.
pub(crate) const MAX_FRAMES: usize = 6000;

/// Rows of the run, ascending, at most about `most` of them.
///
/// A long run is sampled at equal steps of what happens rather than of time: the sum of how far every series has moved,
/// each against the way it goes in all. Impacts and felts that open and close so get their frames, a key at rest few.
/// Time takes part too, so that nothing rests for too long; the first and last row, the row of every series' extremes
/// and the rows next to the given instants are always there.
pub(crate) fn choose(run: &Run, instants: &[f64], most: usize) -> Vec<usize> {
    let rows = run.time_s.len();
    if rows <= most {
        return (0..rows).collect();
    }
    let mut activity = vec![0.0; rows];
    let mut always = vec![0, rows - 1];
    // a quarter of the frames goes to time itself
    let others = 1.0 + run.bodies.len() as f64 + 0.5 * run.zones.len() as f64;
    add(&mut activity, &mut always, others / 3.0, run.time_s.iter().copied());
    add(&mut activity, &mut always, 1.0, run.force_n.iter().copied());
    for body in &run.bodies {
        add(&mut activity, &mut always, 1.0, body.angle_rad.iter().copied());
    }
    for zone in &run.zones {
        // the root lets weights count beside impacts
        add(&mut activity, &mut always, 0.5, zone.normal_n.iter().map(|force| force.max(0.0).sqrt()));
    }
    for instant in instants {
        let row = run.time_s.partition_point(|t| t < instant).min(rows - 1);
        always.extend(row.saturating_sub(1)..=(row + 1).min(rows - 1));
    }
    for row in 1..rows {
        activity[row] += activity[row - 1];
    }
    let total = activity[rows - 1];
    let wanted = most.saturating_sub(always.len()).max(2);
    let mut chosen = always;
    let mut row = 0;
    for index in 0..wanted {
        let level = total * index as f64 / (wanted - 1) as f64;
        while row + 1 < rows && activity[row] < level {
            row += 1;
        }
        chosen.push(row);
    }
    chosen.sort_unstable();
    chosen.dedup();
    chosen
}

/// Adds one series' movement to every row's activity, `weight` in all, and its extremes to the rows that are kept.
fn add(activity: &mut [f64], always: &mut Vec<usize>, weight: f64, values: impl Iterator<Item = f64> + Clone) {
    let mut variation = 0.0;
    let mut previous = None;
    let (mut low, mut high) = ((0, f64::INFINITY), (0, f64::NEG_INFINITY));
    for (row, value) in values.clone().enumerate().filter(|(_, value)| value.is_finite()) {
        variation += f64::abs(value - previous.unwrap_or(value));
        previous = Some(value);
        if value < low.1 {
            low = (row, value);
        }
        if value > high.1 {
            high = (row, value);
        }
    }
    if variation <= 0.0 {
        return;
    }
    always.extend([low.0, high.0]);
    let mut previous = None;
    for (value, sum) in values.zip(activity.iter_mut()).filter(|(value, _)| value.is_finite()) {
        *sum += weight * f64::abs(value - previous.unwrap_or(value)) / variation;
        previous = Some(value);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drawing::fixture::two_levers_run;

    #[test]
    fn short_runs_keep_every_row() {
        assert_eq!(choose(&two_levers_run(50), &[], 6000).len(), 50);
        assert!(choose(&two_levers_run(0), &[], 6000).is_empty());
    }

    /// One row of contact among forty thousand keeps its frame and both neighbours.
    #[test]
    fn a_contact_of_one_row_keeps_its_frames() {
        let run = two_levers_run(40_000);
        let chosen = choose(&run, &[run.events.hammer_contact_s().unwrap()], 500);
        assert!(chosen.len() <= 500 && chosen.len() > 300, "{}", chosen.len());
        assert!(chosen.is_sorted() && chosen[0] == 0 && chosen[chosen.len() - 1] == 39_999);
        for row in 19_999..=20_001 {
            assert!(chosen.contains(&row), "{row}");
        }
    }

    #[test]
    fn nothing_rests_for_too_long() {
        let chosen = choose(&two_levers_run(40_000), &[], 500);
        let longest = chosen.windows(2).map(|pair| pair[1] - pair[0]).max().unwrap();
        assert!(longest < 400, "{longest}");
    }
}
