//! Timing of three real grands against loudness, pressed and struck, and of an instrument at the same hammer speeds.
//!
//! `validation/goebl-2005.csv` holds the published curves; the table's `[[curves]]` make rows of them
//! ([`Curves::rows`]).

use std::sync::LazyLock;

use serde::Deserialize;

use super::presses::{Drive, SimulatedPress};
use crate::measure::MeasureError;
use erard::Progress;
use erard::instrument::Instrument;
use erard::level::{HandKind, LevelError, MASS_KG, Reference};
use erard::run::{Run, Setup, SimulationError, press_by_hand};
use erard::stroke::Touch;
use moreau::Settings;

const CURVES: &str = include_str!("../../validation/goebl-2005.csv");
/// Hammer speeds, m/s. A hand is struck from the second one on.
pub(super) const LEVELS_M_PER_S: [f64; 7] = [0.5, 0.7, 0.9, 1.5, 2.0, 3.0, 5.0];
/// Step, s, and duration, s: the softest key is down before.
const STEP_S: f64 = 50e-6;
const DURATION_S: f64 = 0.4;
const MS_PER_S: f64 = 1e3;

/// A published curve: a v^b + c, ms.
struct Curve {
    grand: &'static str,
    touch: &'static str,
    quantity: &'static str,
    numbers: [f64; 3],
}

static GRANDS: LazyLock<Vec<Curve>> = LazyLock::new(|| {
    let rows = CURVES.lines().filter(|line| !line.starts_with('#')).skip(1);
    let curve = |line: &'static str| {
        let cells: Vec<&str> = line.split(',').collect();
        let [grand, touch, quantity, a, b, c] = cells[..] else { return None };
        Some(Curve { grand, touch, quantity, numbers: [a.parse().ok()?, b.parse().ok()?, c.parse().ok()?] })
    };
    rows.filter_map(curve).collect()
});

/// Names for rows, such as `travel_pressed_0_5_ms`.
pub(super) static NAMES: LazyLock<Vec<String>> = LazyLock::new(|| {
    let of = |quantity: Timing| cases().map(move |case| case.measure(quantity));
    Timing::ALL.into_iter().flat_map(of).collect()
});

/// A touch at a level.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Case {
    pub touch: Touch,
    pub speed_m_per_s: f64,
}

/// Pressed at all levels, and struck from the second one on.
pub(super) fn cases() -> impl Iterator<Item = Case> {
    let of = |touch: Touch, from: usize| {
        LEVELS_M_PER_S[from..].iter().map(move |&speed_m_per_s| Case { touch, speed_m_per_s })
    };
    of(Touch::Pressed, 0).chain(of(Touch::Struck, 1))
}

impl Case {
    pub fn measure(self, quantity: Timing) -> String {
        format!("{}_{}_{}_ms", quantity.name(), self.touch.name(), self.level())
    }

    pub fn level(self) -> String {
        self.speed_m_per_s.to_string().replace('.', "_")
    }
}

/// A timing that was published.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Timing {
    /// From finger-key contact or key start to hammer-string contact.
    Travel,
    /// From hammer-string contact to key bottom.
    KeyBottom,
    /// From the hammer's largest speed to hammer-string contact.
    FreeFlight,
}

impl Timing {
    /// All of them.
    pub const ALL: [Timing; 3] = [Timing::Travel, Timing::KeyBottom, Timing::FreeFlight];

    /// Name in the table of curves.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Timing::Travel => "travel",
            Timing::KeyBottom => "key_bottom",
            Timing::FreeFlight => "free_flight",
        }
    }
}

/// Published value of a grand at a hammer speed, m/s, in ms; `None` without a curve.
#[must_use]
pub fn published_ms(grand: &str, touch: Touch, quantity: Timing, speed_m_per_s: f64) -> Option<f64> {
    let of = |curve: &&Curve| curve.grand == grand && curve.touch == touch.name() && curve.quantity == quantity.name();
    let [a, b, c] = GRANDS.iter().find(of)?.numbers;
    Some(a * speed_m_per_s.powf(b) + c)
}

/// Names of the grands.
#[must_use]
pub fn grands() -> Vec<&'static str> {
    let mut names: Vec<&str> = GRANDS.iter().map(|curve| curve.grand).collect();
    names.dedup();
    names.truncate(names.iter().skip(1).position(|name| *name == names[0]).map_or(names.len(), |at| at + 1));
    names
}

/// Timing of an instrument at a level, beside published grands. Times in ms; `None` for what did not happen.
#[derive(Debug, Clone, PartialEq)]
pub struct BesideGrands {
    /// Pressed or struck.
    pub touch: Touch,
    /// Hammer speed, m/s.
    pub speed_m_per_s: f64,
    /// From key start to the string, ms.
    pub travel_ms: Option<f64>,
    /// From the hand's start to the string, ms.
    pub travel_of_hand_ms: Option<f64>,
    /// From the impact to key bottom, ms; negative if the key is down first.
    pub key_bottom_ms: Option<f64>,
    /// From the hammer's largest speed to the impact, ms.
    pub free_flight_ms: Option<f64>,
    /// From the last push of jack or lever at the knuckle to the impact, ms; shown, and compared with nothing.
    pub off_knuckle_ms: Option<f64>,
    /// Names of the grands with their travel, key bottom and free flight, ms.
    pub grands: Vec<(&'static str, [f64; 3])>,
}

impl BesideGrands {
    fn of(case: Case, instrument: &Instrument, run: Option<&Run>) -> Self {
        let Case { touch, speed_m_per_s } = case;
        let ms = |s: Option<f64>| s.map(|s| MS_PER_S * s);
        let press = run.map(|run| SimulatedPress::of(instrument, run, Drive::Constant(0.0)));
        let impact_s = run.and_then(|run| run.events.hammer_contact_s());
        let flight_s = run.zip(impact_s).map(|(run, impact_s)| impact_s - fastest_s(run, impact_s));
        let off_knuckle_s =
            run.zip(impact_s).and_then(|(run, impact_s)| Some(impact_s - off_knuckle_s(instrument, run, impact_s)?));
        let published = |grand: &'static str| {
            let at = |quantity| published_ms(grand, touch, quantity, speed_m_per_s).unwrap_or(f64::NAN);
            (grand, Timing::ALL.map(at))
        };
        BesideGrands {
            touch,
            speed_m_per_s,
            travel_ms: ms(press.and_then(|press| press.to_string_s)),
            travel_of_hand_ms: ms(impact_s),
            key_bottom_ms: ms(press.and_then(|press| press.hammer_ahead_s)),
            free_flight_ms: ms(flight_s),
            off_knuckle_ms: ms(off_knuckle_s),
            grands: grands().into_iter().map(published).collect(),
        }
    }
}

/// Instant of the hammer's largest speed up to an instant, s, in a run: where the published free flight begins.
#[must_use]
pub fn fastest_s(run: &Run, impact_s: f64) -> f64 {
    let until = run.time_s.partition_point(|&t| t <= impact_s);
    let speeds = &run.hammer_rise_m_per_s[..until];
    let fastest = (0..speeds.len()).max_by(|&a, &b| speeds[a].total_cmp(&speeds[b]));
    fastest.map_or(impact_s, |row| run.time_s[row])
}

/// Instant at which jack or lever last pushed the knuckle before the impact, s.
fn off_knuckle_s(instrument: &Instrument, run: &Run, impact_s: f64) -> Option<f64> {
    let until = run.time_s.partition_point(|&t| t < impact_s);
    let pushes = |row: &usize| instrument.roles.knuckle.iter().any(|&zone| run.zones[zone].normal_n[*row] > 0.0);
    (0..until).rev().find(pushes).map(|row| run.time_s[row])
}

/// Plays every touch at every level, by the built-in hands, which hold the key from the impact on.
pub(super) fn measure(instrument: &Instrument, progress: &mut Progress<'_>) -> Result<Vec<BesideGrands>, MeasureError> {
    let mut reference = match Reference::new(instrument, progress) {
        Ok(reference) => Some(reference),
        Err(LevelError::Action(error)) => return Err(SimulationError::from(error).into()),
        Err(LevelError::Interrupted) => return Err(SimulationError::Interrupted.into()),
        Err(_) => None,
    };
    let count = cases().count() as f64;
    let mut found = Vec::new();
    for (done, case) in cases().enumerate() {
        if !progress(done as f64 / count) {
            return Err(SimulationError::Interrupted.into());
        }
        let kind = HandKind::new(case.touch, MASS_KG);
        let hand = match reference.as_mut().map(|one| one.solve(kind, case.speed_m_per_s, &mut |_| true)) {
            Some(Ok(hand)) => Some(hand),
            Some(Err(LevelError::Action(error))) => return Err(SimulationError::from(error).into()),
            _ => None,
        };
        let setup =
            Setup { settings: Settings::new(STEP_S), record_every: Some(1), ledger: false, ..Setup::new(DURATION_S) };
        let run = hand.map(|hand| press_by_hand(instrument, &hand.held(), &setup, &mut |_| true)).transpose()?;
        found.push(BesideGrands::of(case, instrument, run.as_ref()));
    }
    Ok(found)
}

/// Value of one of [`NAMES`]; `None` for another name.
pub(super) fn value(name: &str, found: &[BesideGrands]) -> Option<Option<f64>> {
    found.iter().find_map(|one| {
        let case = Case { touch: one.touch, speed_m_per_s: one.speed_m_per_s };
        let values = [one.travel_ms, one.key_bottom_ms, one.free_flight_ms];
        Timing::ALL
            .into_iter()
            .zip(values)
            .find(|(quantity, _)| case.measure(*quantity) == name)
            .map(|(_, value)| value)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The curves at 2 m/s, computed by hand from the published numbers: 98.57 x 2^-0.7147 = 60.06.
    #[test]
    fn curves_are_those_of_the_paper() {
        assert_eq!(GRANDS.len(), 18);
        assert_eq!(grands(), ["Steinway C", "Yamaha Disklavier", "Boesendorfer SE290"]);
        let at = |grand, touch, quantity| published_ms(grand, touch, quantity, 2.0).unwrap();
        assert!((at("Steinway C", Touch::Pressed, Timing::Travel) - 60.06).abs() < 0.01);
        assert!((at("Boesendorfer SE290", Touch::Struck, Timing::KeyBottom) - 0.76).abs() < 0.01);
        assert!((at("Yamaha Disklavier", Touch::Struck, Timing::FreeFlight) - 2.02).abs() < 0.01);
    }
}
