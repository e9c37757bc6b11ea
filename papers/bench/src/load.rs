//! The load of the batch: many grands at once.

use std::f64::consts::TAU;

use moreau::{Settings, SiteInput, State, StepOutcome};
use moreau_kernels::{Lanes, OwnedDescription, WorkspaceOfSix};

use super::grand::{GrandModel, MF_N, STEP_S, STEPS, described, group, instrument, steps_of_six};
use erard::run::SimulationError;
use erard_workshop::cores;

/// Grands that are played one after the other, or side by side in lanes.
pub struct Load {
    grands: Vec<OwnedDescription>,
    settings: Settings<f64>,
    /// The force on the key at every step, N, again and again.
    forces_n: Vec<f64>,
    /// Where in it each grand begins.
    begins: Vec<usize>,
    steps: u64,
}

/// Goes through the forces of a grand. They are looked up, so that what is timed is the steps.
struct Cursor(usize);

impl Cursor {
    #[inline(always)]
    fn next(&mut self, forces_n: &[f64]) -> SiteInput<f64> {
        let force = forces_n[self.0];
        self.0 = if self.0 + 1 == forces_n.len() { 0 } else { self.0 + 1 };
        SiteInput::Force(force)
    }
}

/// Grands of a group, whatever lanes they are played in: as many as the widest lanes hold.
pub const MAX_LANES: usize = 16;

/// Strokes a second of the tremolo.
const TREMOLO_HZ: f64 = 8.0;
/// Its strongest force, N: fortissimo.
const TREMOLO_N: f64 = 20.0;

impl Load {
    /// A parameter study: the same second of a note on so many groups of grands whose hammers are of different weight,
    /// by up to 20 % either way, and whose knuckles are of different stiffness. The lanes of a group do nearly the same
    /// at the same time.
    pub fn parameter_study(groups: usize, steps: u64) -> Self {
        // Settling takes its time: the groups are alike.
        let count = MAX_LANES;
        let varied = |i: usize| {
            let mut varied = instrument();
            let x = i as f64 / (count - 1) as f64 - 0.5;
            if let Some(hammer) = varied.roles.hammer {
                varied
                    .edit(|fields| {
                        fields.bodies[hammer].mass_kg *= 1.0 + 0.4 * x;
                        fields.bodies[hammer].inertia_kg_m2 *= 1.0 + 0.4 * x;
                    })
                    .expect("numbers alone");
            }
            for knuckle in varied.roles.knuckle.clone() {
                varied.edit(|fields| fields.zones[knuckle].felt.stiffness *= 1.0 - x).expect("numbers alone");
            }
            described(&varied).expect("a varied grand comes to rest")
        };
        let varied: Vec<_> = (0..count).map(varied).collect();
        let grands: Vec<_> = varied.iter().cycle().take(groups * MAX_LANES).cloned().collect();
        let note = |n| if n < STEPS / 2 { MF_N } else { 0.0 };
        let begins = vec![0; grands.len()];
        Load { grands, settings: Settings::new(STEP_S), forces_n: (0..STEPS).map(note).collect(), begins, steps }
    }

    /// A fortissimo tremolo: grands that are alike, each in another phase of its strokes, so that the lanes of a group
    /// are never in contact with the same felts.
    pub fn tremolo(groups: usize, steps: u64) -> Self {
        let count = groups * MAX_LANES;
        let period = (1.0 / (TREMOLO_HZ * STEP_S)).round();
        let force = |n: usize| 0.5 * TREMOLO_N * (1.0 - (TAU * n as f64 / period).cos());
        // The golden section spreads the phases, also those of neighbours.
        let phase = |i: usize| (0.618_033_988_749_895 * i as f64).fract();
        Load {
            grands: vec![described(&instrument()).expect("the grand comes to rest"); count],
            settings: Settings::new(STEP_S),
            forces_n: (0..period as usize).map(force).collect(),
            begins: (0..count).map(|i| (phase(i) * period) as usize).collect(),
            steps,
        }
    }

    /// Number of its groups of [`MAX_LANES`].
    pub(crate) fn groups(&self) -> usize {
        self.grands.len() / MAX_LANES
    }

    /// Steps that playing so many of its groups takes, of all their grands.
    pub(crate) fn count(&self, groups: usize) -> f64 {
        (groups * MAX_LANES) as f64 * self.steps as f64
    }

    /// Plays the grands of so many groups one after the other; returns the sum of the last angles, so that nothing can
    /// be left out.
    ///
    /// # Panics
    /// If a number becomes infinite; so do the others.
    pub(crate) fn one_by_one(&self, groups: usize) -> f64 {
        let mut sum = 0.0;
        for (i, grand) in self.grands.iter().take(groups * MAX_LANES).enumerate() {
            let model: GrandModel = grand.model().expect("of the grand's size");
            let (mut state, mut workspace) = (State::at_rest(grand.first_angles()), WorkspaceOfSix::new());
            let mut cursor = Cursor(self.begins[i]);
            let mut inputs = (0..self.steps).map(|_| cursor.next(&self.forces_n));
            let finite = steps_of_six(&model, &self.settings, &mut inputs, &mut state, &mut workspace);
            assert!(finite, "a number became infinite");
            sum += state.angle.iter().sum::<f64>();
        }
        sum
    }

    /// Plays so many groups one after the other, each in lanes; as `Load::one_by_one`.
    pub fn in_lanes(&self, groups: usize, lanes: Lanes) -> f64 {
        (0..groups).map(|g| self.play_group(g, lanes)).sum()
    }

    /// Plays all groups, each in lanes, on so many threads.
    ///
    /// # Panics
    /// If a thread dies.
    pub(crate) fn on_cores(&self, lanes: Lanes, threads: usize) -> f64 {
        let groups: Vec<usize> = (0..self.groups()).collect();
        let sums = cores::map(&groups, threads, &mut |_| true, |g, _| Ok(self.play_group(*g, lanes)));
        sums.map_err(|error: SimulationError| error).expect("nobody interrupts").into_iter().sum()
    }

    /// Plays a group, in as many parts as its grands need lanes.
    fn play_group(&self, g: usize, lanes: Lanes) -> f64 {
        let width = lanes.count();
        let mut sum = 0.0;
        for first in (g * MAX_LANES..(g + 1) * MAX_LANES).step_by(width) {
            let grands: Vec<&OwnedDescription> = self.grands[first..first + width].iter().collect();
            let mut group = group(&grands, &self.settings, lanes);
            let (mut inputs, mut outcomes) = ([SiteInput::Free; MAX_LANES], [StepOutcome::Converged; MAX_LANES]);
            let mut cursors: [Cursor; MAX_LANES] =
                core::array::from_fn(|i| Cursor(self.begins.get(first + i).copied().unwrap_or(0)));
            for _ in 0..self.steps {
                for (input, cursor) in inputs[..width].iter_mut().zip(&mut cursors) {
                    *input = cursor.next(&self.forces_n);
                }
                group.step(&inputs[..width], &mut outcomes[..width]);
                assert!(outcomes[..width].iter().all(|&outcome| outcome != StepOutcome::NonFinite));
            }
            let (mut angles, mut velocities) = ([0.0; 12], [0.0; 12]);
            for i in 0..width {
                group.motion(i, &mut angles, &mut velocities);
                sum += angles.iter().sum::<f64>();
            }
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All ways of playing a load do the same work. (How near lanes are to a mechanism alone is tested elsewhere; here
    /// what Newton's tolerance of 1e-5 rad/s may make of 200 angles in 20 ms would go unseen.)
    #[test]
    fn all_ways_lead_to_the_same_poses() {
        for load in [Load::parameter_study(2, 400), Load::tremolo(2, 400)] {
            let sum = load.one_by_one(2);
            assert!(sum.is_finite() && (sum - load.one_by_one(1)).abs() > 1e-3);
            for lanes in [Lanes::One, Lanes::Four] {
                assert!((load.in_lanes(2, lanes) - sum).abs() < 4e-5, "{lanes:?}");
                assert!((load.on_cores(lanes, 2) - sum).abs() < 4e-5, "{lanes:?}");
            }
        }
    }
}
