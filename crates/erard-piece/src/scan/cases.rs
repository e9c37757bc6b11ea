//! Motions of a finger that mislead simple algorithms, played on the simulated actions of a keyboard.

use erard::Progress;
use erard::damper::DamperHeights;
use erard::instrument::Instrument;
use erard_live::blow_m;
use erard_live::finger::Leg;
use erard_workshop::cores;

use super::finger;
use super::sensor::Scans;
use super::truth::{Truth, Window};
use crate::error::PerformError;

/// Time after a case at which key and hammer are at rest, s.
const TAIL_S: f64 = 0.5;
/// Depth to which a finger goes that presses a key to its bottom, m: a dip of 10 mm and 0.5 mm more.
const BOTTOM_M: f64 = 10.5e-3;
/// Height to which a finger goes that leaves the key, m above its rest.
const LEFT_M: f64 = -8e-3;
/// Misadjustment of an action whose soft notes strike twice: excess of the repetition spring's torque, as a share, and
/// excess distance of the back check from the hammer, m. Estimates with which they do.
const BRISK: f64 = 0.6;
const FAR_M: f64 = 3e-3;

/// A motion of a finger.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Case {
    /// Plain strokes to the bottom, from soft to loud.
    Stroke,
    /// A key that is let go before it has reached the bottom.
    Staccato,
    /// A key that is pressed part of its way, not to the let-off, and let back.
    HalfStroke,
    /// A key that is pressed to the bottom too slowly to sound.
    SilentPress,
    /// A stroke, and a release so slow that the jack resets on the way.
    SlowRelease,
    /// That release, stopped where the jack has reset, and another stroke from there.
    Repress,
    /// A stroke from a key that has come up only a little.
    ShallowRepress,
    /// A finger that trembles on a key that it holds near the let-off.
    Trembling,
    /// Soft strokes on an action whose repetition spring is too brisk and whose back check is too far: the hammer
    /// strikes twice.
    Bobbling,
    /// Repetitions at the limit of the double escapement.
    Trill,
}

impl Case {
    /// All of them, in the order in which they are played.
    pub const ALL: [Case; 10] = [
        Case::Stroke,
        Case::Staccato,
        Case::HalfStroke,
        Case::SilentPress,
        Case::SlowRelease,
        Case::Repress,
        Case::ShallowRepress,
        Case::Trembling,
        Case::Bobbling,
        Case::Trill,
    ];

    /// Name in files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Case::Stroke => "stroke",
            Case::Staccato => "staccato",
            Case::HalfStroke => "half-stroke",
            Case::SilentPress => "silent-press",
            Case::SlowRelease => "slow-release",
            Case::Repress => "repress",
            Case::ShallowRepress => "shallow-repress",
            Case::Trembling => "trembling",
            Case::Bobbling => "bobbling",
            Case::Trill => "trill",
        }
    }

    /// Number of times it is played on a key, each time differently.
    fn times(self) -> usize {
        match self {
            Case::Stroke => 6,
            Case::HalfStroke | Case::Repress | Case::ShallowRepress | Case::Bobbling | Case::Trill => 3,
            Case::Staccato | Case::SilentPress | Case::SlowRelease | Case::Trembling => 2,
        }
    }

    /// The finger's path. `step` counts the times that it is played, from 0.
    fn path(self, step: usize, random: &mut fastrand::Rng) -> Vec<Leg> {
        let mut between = |from: f64, to: f64| from + random.f64() * (to - from);
        // In turn from slow to fast, or from shallow to deep.
        let share = (step as f64 + between(0.0, 1.0)) / self.times() as f64;
        let along = |from: f64, to: f64| from * (to / from).powf(share);
        let stroke = |down_s: f64| vec![[down_s, BOTTOM_M], [0.25, BOTTOM_M]];
        let leaving = [0.10, LEFT_M];
        let mut path = match self {
            Case::Stroke => stroke(along(0.25, 0.03)),
            Case::Staccato => vec![[along(0.10, 0.05), between(8e-3, 9.5e-3)]],
            Case::HalfStroke => {
                let deep_m = along(3e-3, 7.5e-3);
                vec![[between(0.10, 0.30), deep_m], [between(0.02, 0.2), deep_m], [0.20, 0.0]]
            }
            Case::SilentPress => vec![[along(2.5, 1.2), BOTTOM_M], [0.2, BOTTOM_M]],
            Case::SlowRelease => [stroke(between(0.06, 0.12)), vec![[along(2.5, 0.8), 0.0]]].concat(),
            Case::Repress => {
                let up_m = between(3e-3, 5e-3);
                let again = [[between(0.8, 1.5), up_m], [0.1, up_m]];
                [stroke(between(0.06, 0.12)), again.to_vec(), stroke(between(0.04, 0.10))].concat()
            }
            Case::ShallowRepress => {
                let up_m = BOTTOM_M - along(1.5e-3, 4e-3);
                [stroke(between(0.06, 0.12)), vec![[between(0.08, 0.3), up_m]], stroke(between(0.04, 0.08))].concat()
            }
            Case::Trembling => {
                let (at_m, by_m, half_s) = (between(7e-3, 9e-3), between(0.5e-3, 1.0e-3), between(0.05, 0.08));
                let swing = |k: usize| [half_s, at_m + if k.is_multiple_of(2) { by_m } else { -by_m }];
                [stroke(between(0.06, 0.12)), vec![[0.3, at_m]], (0..14).map(swing).collect()].concat()
            }
            Case::Bobbling => stroke(along(0.25, 0.12)),
            Case::Trill => {
                let (half_s, up_m) = (0.5 / along(7.0, 13.0), between(3e-3, 6e-3));
                (0..20).map(|k: usize| [half_s, if k.is_multiple_of(2) { BOTTOM_M } else { up_m }]).collect()
            }
        };
        path.push(leaving);
        path
    }
}

/// The action on which soft notes strike twice.
fn brisk(instrument: &Instrument) -> Instrument {
    let mut brisk = instrument.clone();
    for (name, by) in [("repetition_spring", BRISK), ("back_check", FAR_M)] {
        let Some(screw) = brisk.screw(name) else { continue };
        let turned = &brisk.screws[screw];
        let by = match turned.action {
            erard::instrument::ScrewAction::Spring { spring } => by * brisk.springs[spring].torque_n_m.abs(),
            _ => -by,
        };
        let setting = turned.setting + by;
        let _ = brisk.turn(screw, setting);
    }
    brisk
}

/// Plays cases one after the other on each of these keys, by a finger that follows a path; every key begins at an
/// instant, s. A path depends on the seed, the key, the case and how often it was played. `scans` takes the keys'
/// motion. `progress` receives the share of keys that are done, and ends the work by returning false.
///
/// # Errors
/// See [`PerformError`].
pub fn play_cases(
    instruments: &[Instrument],
    (keys, cases): (&[usize], &[Case]),
    begins_s: f64,
    seed: u64,
    scans: &Scans,
    threads: usize,
    progress: &mut Progress<'_>,
) -> Result<Truth, PerformError> {
    let dampers = DamperHeights::new(instruments);
    let played = cores::map(keys, threads, progress, |&key, progress| {
        let instrument = instruments.get(key - 1).ok_or(PerformError::NoInstrument { key })?;
        let (damper_m, sampler) = (dampers.of(key)?, scans.sampler(key));
        let (mut truth, mut from_s) = (Truth::default(), begins_s);
        let brisk = brisk(instrument);
        // Its hammer rests elsewhere below the same string, and a sensor of hammers sees that.
        let lifted_m = if scans.are_hammers() && cases.contains(&Case::Bobbling) {
            let blow_m = |of: &Instrument| {
                Ok::<_, PerformError>(blow_m(of).map_err(|error| PerformError::Action { key, error })?.unwrap_or(0.0))
            };
            blow_m(instrument)? - blow_m(&brisk)?
        } else {
            0.0
        };
        for &case in cases {
            let mut random = fastrand::Rng::with_seed(seed << 16 ^ (case as u64) << 8 ^ key as u64);
            for step in 0..case.times() {
                let path = case.path(step, &mut random);
                let own = (key, truth.windows.len(), damper_m);
                let action = if case == Case::Bobbling { (&brisk, lifted_m) } else { (instrument, 0.0) };
                let (strikes, to_s) = finger::play(action, [from_s, TAIL_S], &path, own, &sampler, progress)?;
                truth.windows.push(Window { key, case: case.name(), from_s, to_s });
                truth.strikes.extend(strikes);
                from_s = to_s;
            }
        }
        Ok::<_, PerformError>(truth)
    })?;
    let mut all = Truth::default();
    played.into_iter().for_each(|truth| all.add(truth));
    Ok(all)
}
