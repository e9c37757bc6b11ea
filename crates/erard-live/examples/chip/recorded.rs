//! Ten keys of the built-in grand, pressed by hands, as a scanner with a converter of 12 bits reads them.

use erard::level::LEVELS;
use erard_live::profile::Stops;
use erard_live::sensor::FixedLaw;
use erard_live::{Limits, SensorKind};

use crate::press::{GRAND, Press};

/// Keys.
pub const KEYS: usize = 10;
/// Scans.
pub const FRAMES: usize = 2200;
/// Time between two of them, s.
pub const PERIOD_S: f64 = 1e-3;
/// Readings at the stops.
pub const STOPS: Stops = Stops { rest: 3500.0, pressed: 700.0 };
/// The sensors' law: shares of the reading's range and of the travel.
pub const POINTS: [[f64; 2]; 5] = [[0.0, 0.0], [0.25, 0.32], [0.5, 0.58], [0.75, 0.8], [1.0, 1.0]];
/// A press takes so long, s: its hand leaves the key after 0.5 s.
const PRESS_S: f64 = 0.9;

/// What its key may be asked for.
pub fn limits() -> Limits {
    Limits::find(&GRAND, SensorKind::Light).expect("it can be played").expect("it strikes")
}

/// The ten ways at an instant, m: a chord of all keys at all levels within 30 ms, then five of them again one after the
/// other, and a key that goes half-way down, slowly, and up again.
fn ways(presses: &[Press], t: f64) -> [f64; KEYS] {
    std::array::from_fn(|k| {
        let chord_s = 0.06 + 3e-3 * k as f64;
        let again_s = 1.05 + 0.06 * k as f64;
        match (t < 1.0, k) {
            (true, _) => presses[k % presses.len()].at(t - chord_s),
            (false, 0..5) if t - again_s < PRESS_S => presses[(k + 3) % presses.len()].at(t - again_s),
            (false, 7) if (1.1..2.1).contains(&t) => 5e-3 * (std::f64::consts::PI * (t - 1.1)).sin().powi(2),
            _ => 0.0,
        }
    })
}

/// What a converter of 12 bits reads at a travel, m, with noise of a count either way.
pub fn read(x_m: f64, travel_m: f64, random: &mut fastrand::Rng) -> u16 {
    let share = x_m / travel_m;
    let end = (1..POINTS.len() - 1).find(|&i| share <= POINTS[i][1]).unwrap_or(POINTS.len() - 1);
    let ([r0, y0], [r1, y1]) = (POINTS[end - 1], POINTS[end]);
    let range = r0 + (share - y0) * (r1 - r0) / (y1 - y0);
    let exact = STOPS.rest + range * (STOPS.pressed - STOPS.rest) + 2.0 * random.f64() - 1.0;
    exact.round().clamp(0.0, 4095.0) as u16
}

/// The scan: for each instant, a millisecond after the one before, the readings of all keys, two bytes each, the lower
/// one first.
pub fn scan() -> Vec<u8> {
    let presses = LEVELS.map(|(_, speed)| Press::to(speed));
    assert!(presses.iter().all(|press| press.impacts.len() == 1), "a hammer strikes once");
    let (travel_m, mut random) = (limits().dip_m, fastrand::Rng::with_seed(1));
    (1..=FRAMES)
        .flat_map(|frame| ways(&presses, frame as f64 * PERIOD_S))
        .flat_map(|x_m| read(x_m, travel_m, &mut random).to_le_bytes())
        .collect()
}

/// `keyboard.rs`: the sensors, what a key may be asked for, how the scan is read.
pub fn keyboard() -> String {
    let Limits { key_m_per_s, up_m_per_s, dip_m, blow_m, .. } = limits();
    let law = FixedLaw::Table { points: const { &POINTS } };
    law.check().expect("it rises");
    format!(
        "//! The keyboard of the recorded scan. Written by `.ci/regenerate firmware`: do not edit.\n\n\
         use erard_live::converter::Stops;\nuse erard_live::Limits;\n\n\
         /// Keys of the scan, its instants, and the time between them, s.\npub const KEYS: usize = {KEYS};\n\
         pub const FRAMES: usize = {FRAMES};\npub const PERIOD_S: f64 = {PERIOD_S:?};\n\
         /// Readings at a key's stops, and the sensed travel between them, m.\n\
         pub(crate) const STOPS: Stops = Stops {{ rest: {:?}, pressed: {:?} }};\n\
         pub(crate) const TRAVEL_M: f64 = {dip_m:?};\n\
         /// The sensors' law: shares of the reading's range and of the travel.\n\
         pub(crate) static POINTS: [[f64; 2]; {}] = {POINTS:?};\n\
         /// What a key may be asked for.\n\
         pub(crate) const LIMITS: Limits = Limits {{ key_m_per_s: {key_m_per_s:?}, force_n: f64::INFINITY, \
         up_m_per_s: {up_m_per_s:?}, dip_m: {dip_m:?}, blow_m: {blow_m:?} }};\n",
        STOPS.rest,
        STOPS.pressed,
        POINTS.len()
    )
}
