//! A released key: time to return home, and rebound from its felt.
//!
//! Recorded releases also give these two numbers (`recordings/releases.py`).

use moreau::Settings;

use erard::instrument::Instrument;
use erard::player;
use erard::run::{Run, Setup, SimulationError, simulate};

/// Step, s.
const STEP_S: f64 = 50e-6;
/// Force of the finger, N; time until which it holds, and time in which it vanishes, s.
const HELD_N: f64 = 5.0;
const HELD_S: f64 = 0.4;
const GONE_S: f64 = 2e-3;
/// Time after which recording ends, s.
const FOLLOWED_S: f64 = 0.3;
/// Rise from the held position at which a key has left it, m, and travel below which it is home, m.
const LEFT_M: f64 = 1e-3;
const HOME_M: f64 = 0.5e-3;

/// A release; `None` if the key does not come home.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Release {
    /// Time from leaving the held position to home, s.
    pub home_s: Option<f64>,
    /// Largest travel between coming home and being home again, m.
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
