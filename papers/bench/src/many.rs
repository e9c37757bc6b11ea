//! Many actions: one after the other, in lanes, and in lanes on all cores.

use std::hint::black_box;

use moreau::Settings;
use moreau_kernels::{Lanes, Size};
use serde_json::{Value, json};

use super::grand::MF_N;
use super::{Effort, Load, MAX_LANES, STEP_S, Timed, Times, in_turn, instrument};
use erard::Progress;
use erard::player::Input;
use erard::run::Setup;
use erard_workshop::cores;
use erard_workshop::study::{Job, Workers, play_all};

/// The most lanes of doubles that are compiled for the action that is timed, of six bodies.
pub(crate) fn most() -> Lanes {
    Size::Six.lanes(Lanes::most())
}

/// Measures; `None` where `progress` ended the work.
pub(crate) fn measure(effort: &Effort, progress: &mut Progress<'_>) -> Option<Value> {
    let groups = effort.groups_per_core * cores::count();
    let load = Load::parameter_study(groups, effort.steps);
    let study = load_times(&load, effort.rounds, &mut |share| progress(0.4 * share))?;
    let tremolo = Load::tremolo(groups, effort.steps);
    let tremolo = load_times(&tremolo, effort.rounds, &mut |share| progress(0.4 + 0.4 * share))?;
    let stroke = strokes(groups * MAX_LANES, effort, &mut |share| progress(0.8 + 0.2 * share))?;
    let single = Lanes::most_single();
    Some(json!({
        "cores": cores::count(),
        "lanes": most().count(),
        "batch_speedup_per_core": study.speedup_per_core(),
        "batch_speedup_all_cores": study.speedup_all_cores(),
        "batch_four_lanes_speedup_per_core": study.speedup(Lanes::Four),
        "batch_single_lanes": single.is_single().then(|| single.count()),
        "batch_single_speedup_per_core": study.speedup(single).filter(|_| single.is_single()),
        "batch_one_by_one_ns_median": study.one_by_one.median,
        "batch_one_by_one_ns_spread": study.one_by_one.spread(),
        "batch_lanes_ns_median": study.most_lanes().median,
        "batch_lanes_ns_spread": study.most_lanes().spread(),
        "batch_all_cores_ns_median": study.all_cores.median,
        "batch_all_cores_ns_spread": study.all_cores.spread(),
        "batch_tremolo_speedup_per_core": tremolo.speedup_per_core(),
        "batch_tremolo_speedup_all_cores": tremolo.speedup_all_cores(),
        "study_stroke_ms_median": stroke.median * 1e-6,
        "study_stroke_ms_spread": stroke.spread(),
    }))
}

/// Times of a step of one grand of a load, ns.
#[derive(Debug, Clone, PartialEq)]
pub struct LoadTimes {
    /// One grand after the other.
    pub one_by_one: Times,
    /// In lanes on one core: all kinds that there are. Without any, a group one by one.
    pub lanes: Vec<(Lanes, Times)>,
    /// In the most lanes of doubles, on all cores.
    pub all_cores: Times,
}

impl LoadTimes {
    /// In some lanes, on one core.
    pub(crate) fn of(&self, lanes: Lanes) -> Option<Times> {
        self.lanes.iter().find(|(kind, _)| *kind == lanes).map(|(_, times)| *times)
    }

    /// Some lanes over one after the other, on one core.
    pub(crate) fn speedup(&self, lanes: Lanes) -> Option<f64> {
        self.of(lanes).map(|times| self.one_by_one.median / times.median)
    }

    /// In the most lanes of doubles, on one core.
    pub(crate) fn most_lanes(&self) -> Times {
        self.of(most()).unwrap_or(self.one_by_one)
    }

    /// The most lanes of doubles over one after the other, on one core.
    pub(crate) fn speedup_per_core(&self) -> f64 {
        self.one_by_one.median / self.most_lanes().median
    }

    /// The most lanes on all cores over one after the other on one core.
    pub(crate) fn speedup_all_cores(&self) -> f64 {
        self.one_by_one.median / self.all_cores.median
    }
}

/// Times a load in all ways, in turn; `None` where `progress` ended the work.
pub fn load_times(load: &Load, rounds: usize, progress: &mut Progress<'_>) -> Option<LoadTimes> {
    let most = most();
    let compiled = |lanes: &Lanes| Size::Six.lanes(*lanes) == *lanes;
    let some = Lanes::here().filter(compiled).filter(|lanes| *lanes != Lanes::One || most == Lanes::One);
    let kinds: Vec<Lanes> = some.collect();
    // On one core one group says as much as all of them, and on a machine of many cores sooner.
    let mut subjects = vec![Timed {
        count: load.count(1),
        go: Box::new(|| {
            black_box(load.one_by_one(1));
        }),
    }];
    for &lanes in &kinds {
        subjects.push(Timed {
            count: load.count(1),
            go: Box::new(move || {
                black_box(load.in_lanes(1, lanes));
            }),
        });
    }
    subjects.push(Timed {
        count: load.count(load.groups()),
        go: Box::new(|| {
            black_box(load.on_cores(most, cores::count()));
        }),
    });
    let times = in_turn(rounds, &mut subjects, progress)?;
    let [one_by_one, lanes @ .., all_cores] = &times[..] else { return None };
    let lanes = kinds.into_iter().zip(lanes.iter().copied()).collect();
    Some(LoadTimes { one_by_one: *one_by_one, lanes, all_cores: *all_cores })
}

/// Times a stroke of a study on all cores: forces around a mezzo forte on one instrument.
fn strokes(count: usize, effort: &Effort, progress: &mut Progress<'_>) -> Option<Times> {
    let instruments = vec![instrument(); count];
    let duration_s = 0.5 * effort.steps as f64 * STEP_S;
    let setup = Setup { settings: Settings::new(STEP_S), ledger: false, ..Setup::new(duration_s) };
    let job = |i: usize| {
        let force = MF_N * (0.8 + 0.4 * i as f64 / count as f64);
        let held_s = 0.6 * duration_s;
        Job { instrument: i, stroke: Box::new(move |t| Input::Force(if t < held_s { force } else { 0.0 })) }
    };
    let mut subject = [Timed {
        count: count as f64,
        go: Box::new(|| {
            let jobs = (0..count).map(job).collect();
            black_box(play_all(&instruments, jobs, &setup, Workers::all(), &mut |_| true).expect("plays"));
        }),
    }];
    in_turn(effort.rounds, &mut subject, progress)?.pop()
}
