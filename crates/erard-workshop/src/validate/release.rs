//! A key let go: how long it takes home, and how far it comes back from its felt.
//!
//! Recorded releases give these two numbers, too (`recordings/releases.py`).

use moreau::Settings;

use erard::instrument::Instrument;
use erard::player;
use erard::run::{Run, Setup, SimulationError, simulate};

/// Step, s.
const STEP_S: f64 = 50e-6;
/// The finger's force, N; until when it holds, and within what time it is gone, s.
const HELD_N: f64 = 5.0;
const HELD_S: f64 = 0.4;
const GONE_S: f64 = 2e-3;
/// How long the key is followed, s.
const FOLLOWED_S: f64 = 0.3;
/// The key has left where it was held when it is so far above it, m, and is home when it is so far below its rest, m.
const LEFT_M: f64 = 1e-3;
const HOME_M: f64 = 0.5e-3;

/// A release; `None` where the key does not come home.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Release {
    /// Time from leaving the held position to home, s.
    pub home_s: Option<f64>,
    /// The largest travel after it came home until it is home again, m.
    pub rebound_m: Option<f64>,
}

pub(super) fn measure(instrument: &Instrument) -> Result<Release, SimulationError> {
    let force = |t: f64| HELD_N * (1.0 - (t - HELD_S) / GONE_S).clamp(0.0, 1.0);
    let setup = Setup {
        settings: Settings::new(STEP_S),
        record_every: Some(1),
        ledger: false,
        ..Setup::new(HELD_S + FOLLOWED_S)
    };
    Ok(Release::of(&simulate(instrument, &player::force(force), &setup, &mut |_| true)?))
}

impl Release {
    fn of(run: &Run) -> Self {
        let held = run.time_s.partition_point(|&t| t < HELD_S);
        let travel = &run.key_m[held..];
        let above = travel[0] - LEFT_M;
        let left = travel.iter().position(|key| *key < above);
        let home = left.and_then(|left| Some(left + travel[left..].iter().position(|key| *key < HOME_M)?));
        let rebound_m = home.map(|home| {
            let back = travel[home..].iter().skip_while(|key| **key < HOME_M).take_while(|key| **key >= HOME_M);
            back.copied().fold(0.0, f64::max)
        });
        let home_s = left.zip(home).map(|(left, home)| run.time_s[held + home] - run.time_s[held + left]);
        Release { home_s, rebound_m }
    }
}
