//! A released key, let go and led up: time home, speed, humps after it has landed, and its hammer coming home.
//!
//! Recorded releases give the same numbers (`recordings/releases.py`, `recordings/hammers.py`). Their sensor sat behind
//! the balance pin and was calibrated at the front, so the model's travel is that of the key's back, over the lever
//! ratio.

use moreau::Settings;

use crate::measure::MeasureError;
use erard::Progress;
use erard::instrument::Instrument;
use erard::player::{Action, Input};
use erard::stroke::{HandStroke, Muscle};

/// Step, s.
const STEP_S: f64 = 50e-6;
/// Force with which the key is held in the rows of `validate`, N.
pub const HELD_N: f64 = 5.0;
/// Time until which it is held, and time in which a key let go loses the force, s.
const HELD_S: f64 = 0.4;
const GONE_S: f64 = 2e-3;
/// A hand that leads up: rate of its force, N/s, and time in which the force vanishes, s.
const RISE_N_S: f64 = 100.0;
const LEAVES_S: f64 = 0.03;
/// Time after which recording ends, s: the hammer has bounced twice.
const FOLLOWED_S: f64 = 0.45;
/// Place of the sensor behind the balance pin, m: at the damper. An estimate; without a lift of the key it has no
/// effect.
const SENSOR_M: f64 = 0.235;
/// Rise from the held position at which a key has left it, m, and travel below which it is home, m.
const LEFT_M: f64 = 1e-3;
const HOME_M: f64 = 0.5e-3;
/// Way over which the speed upward is taken, m below rest.
const SPEED_M: [f64; 2] = [9e-3, 4e-3];
/// A hump lies above the first of these and reaches the second, m; its top lasts while the key is within the third of
/// its largest.
const HUMP_M: f64 = 0.2e-3;
const TOP_M: f64 = 0.3e-3;
const FLAT_M: f64 = 0.1e-3;
/// Humps that begin later after the key has landed do not count, s.
const HUMPS_S: f64 = 0.05;

/// A hump of the key after it has landed: time of its top after that, s, and height, m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hump {
    /// Time from the landing to the middle of the top, s.
    pub top_s: f64,
    /// Largest travel, m below rest.
    pub height_m: f64,
}

/// A release. SI units; `None` for what did not happen.
#[derive(Debug, Clone, PartialEq)]
pub struct Release {
    /// Time from leaving the held position to home.
    pub home_s: Option<f64>,
    /// Speed upward from 9 to 4 mm below rest, m/s.
    pub speed_m_per_s: Option<f64>,
    /// Largest travel between coming home and being home again.
    pub rebound_m: Option<f64>,
    /// Humps after landing; `None` if the key does not come home.
    pub humps: Option<Vec<Hump>>,
    /// Largest rise of the key's pivot from the drawn place after it was let go; `None` if it is nailed to its pin.
    pub lift_m: Option<f64>,
    /// Rise of the hammer's strike point as the key is let go: where the check holds it, or the lever. Without meaning
    /// if there is no hammer.
    pub held_hammer_m: f64,
    /// How long the hammer is below its place of rest as it comes home, how long above, below and above again.
    pub hammer_s: [Option<f64>; 4],
}

/// The two kinds of release.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Releases {
    pub let_go: Release,
    pub led_up: Release,
}

/// Releases a key that is held with a force, N, and loses it within 2 ms.
///
/// # Errors
/// See [`MeasureError`].
pub fn let_go(instrument: &Instrument, held_n: f64, progress: &mut Progress<'_>) -> Result<Release, MeasureError> {
    Ok(let_go_course(instrument, held_n, progress)?.release())
}

/// Course of the release that [`let_go`] measures.
///
/// # Errors
/// See [`MeasureError`].
pub fn let_go_course(
    instrument: &Instrument,
    held_n: f64,
    progress: &mut Progress<'_>,
) -> Result<Course, MeasureError> {
    let force = |t: f64| Input::Force(held_n * (1.0 - (t - HELD_S) / GONE_S).clamp(0.0, 1.0));
    Course::of(instrument, None, &force, progress)
}

pub(super) fn measure(instrument: &Instrument, progress: &mut Progress<'_>) -> Result<Releases, MeasureError> {
    let muscle = Muscle::Rises { rate_n_s: RISE_N_S, height_n: HELD_N };
    let hand = HandStroke { muscle, ..HandStroke::ramped(RISE_N_S) }.leaving(HELD_S, LEAVES_S);
    let led_up = |t: f64| hand.hand.input(&hand.input(t)).unwrap_or(Input::Free);
    Ok(Releases {
        let_go: let_go(instrument, HELD_N, progress)?,
        led_up: Course::of(instrument, Some(&hand), &led_up, progress)?.release(),
    })
}

/// Course of a release from the end of the hold on, one row a step.
#[derive(Debug, Clone, PartialEq)]
pub struct Course {
    /// Travel of the key's back, at the front, m.
    key_m: Vec<f64>,
    /// Rise of the hammer, m.
    hammer_m: Vec<f64>,
    /// Largest rise of the key's pivot, m; `None` if it is nailed.
    lift_m: Option<f64>,
}

impl Course {
    fn of(
        instrument: &Instrument,
        hand: Option<&HandStroke>,
        input: &dyn Fn(f64) -> Input,
        progress: &mut Progress<'_>,
    ) -> Result<Self, MeasureError> {
        let settings = Settings::new(STEP_S);
        let theta = settings.theta;
        let mut action = Action::with_progress(instrument, settings, progress)?;
        if let Some(HandStroke { hand, .. }) = hand {
            action.place_hand(hand.start_m, hand.start_m_per_s);
        }
        let back = instrument.roles.key.map(|key| instrument.first_piece(key)).transpose()?;
        let lever = instrument.roles.key_front_m[0] / -SENSOR_M;
        // The back is a body of this action.
        let at = |action: &Action| action.point(back, [SENSOR_M, 0.0]).map_or(f64::NAN, |[_, y]| y * lever);
        let rest_m = at(&action);
        let pin = instrument.lying().find(|(_, body)| Some(*body) == back);
        let pivot = |action: &Action| action.point(back, [0.0; 2]).map_or(f64::NAN, |[_, y]| y);
        // The arm of the pin is level as drawn.
        let drawn_m = pin.map_or(0.0, |(arm, _)| instrument.bodies[arm].pivot_m[1]);
        let mut course = Course { key_m: Vec::new(), hammer_m: Vec::new(), lift_m: pin.map(|_| 0.0) };
        let mut step = 0_u64;
        action.play(progress, &mut |action| {
            let t = step as f64 * STEP_S;
            if t >= HELD_S {
                course.key_m.push(at(action) - rest_m);
                course.hammer_m.push(action.reading().hammer_rise_m);
                course.lift_m = course.lift_m.map(|most| most.max(pivot(action) - drawn_m));
            }
            step += 1;
            (t < HELD_S + FOLLOWED_S).then(|| input(t + theta * STEP_S))
        })?;
        Ok(course)
    }

    /// Rows in which the key has left where it was held, and in which it is home.
    fn left_and_home(&self) -> [Option<usize>; 2] {
        let from = |row: usize, below_m: f64| Some(row + self.key_m.get(row..)?.iter().position(|y| *y < below_m)?);
        let left = self.key_m.first().and_then(|held_m| from(0, held_m - LEFT_M));
        [left, left.and_then(|left| from(left, HOME_M))]
    }

    /// Returns the travel of the key's back, as at the front, as pairs of time after its landing, s, and travel, m;
    /// nothing if it does not land.
    #[must_use]
    pub fn travel(&self) -> Vec<[f64; 2]> {
        let [_, Some(home)] = self.left_and_home() else { return Vec::new() };
        let after_s = |row: usize| (row as f64 - home as f64) * STEP_S;
        self.key_m.iter().enumerate().map(|(row, y)| [after_s(row), *y]).collect()
    }

    /// Measures the release.
    #[must_use]
    pub fn release(&self) -> Release {
        let key = &self.key_m;
        let [left, home] = self.left_and_home();
        let rebound_m = home.map(|home| {
            let back = key[home..].iter().skip_while(|y| **y < HOME_M).take_while(|y| **y >= HOME_M);
            back.copied().fold(0.0, f64::max)
        });
        Release {
            home_s: left.zip(home).map(|(left, home)| (home - left) as f64 * STEP_S),
            speed_m_per_s: self.speed_m_per_s(),
            rebound_m,
            humps: home.map(|home| humps(&key[home..])),
            lift_m: self.lift_m,
            held_hammer_m: self.hammer_m.first().copied().unwrap_or(f64::NAN),
            hammer_s: self.hammer_s(),
        }
    }

    fn speed_m_per_s(&self) -> Option<f64> {
        let [low_m, high_m] = SPEED_M;
        let left = self.key_m.iter().rposition(|y| *y >= low_m)? + 1;
        let up = left + self.key_m[left..].iter().position(|y| *y < high_m)?;
        let instant = |row: usize, at_m: f64| {
            let [before, after] = [self.key_m[row - 1], self.key_m[row]];
            (row as f64 - 1.0 + (before - at_m) / (before - after)) * STEP_S
        };
        Some((low_m - high_m) / (instant(up, high_m) - instant(left, low_m)))
    }

    /// Times between the first five instants at which the hammer passes the place where it comes to rest.
    fn hammer_s(&self) -> [Option<f64>; 4] {
        let rest_m = self.hammer_m.last().copied().unwrap_or(0.0);
        let above = |row: usize| self.hammer_m[row] > rest_m;
        let passes = (1..self.hammer_m.len()).filter(|row| above(*row) != above(row - 1));
        let rows: Vec<usize> = passes.take(5).collect();
        std::array::from_fn(|n| rows.get(n..n + 2).map(|pair| (pair[1] - pair[0]) as f64 * STEP_S))
    }
}

/// Humps of a key that has landed in the first row.
fn humps(key_m: &[f64]) -> Vec<Hump> {
    let mut found = Vec::new();
    let mut row = key_m.iter().position(|y| *y <= HUMP_M).unwrap_or(key_m.len());
    while row < key_m.len() && (row as f64) * STEP_S < HUMPS_S {
        let rows = key_m[row..].iter().take_while(|y| **y > HUMP_M).count();
        let hump = &key_m[row..row + rows];
        let height_m = hump.iter().copied().fold(0.0, f64::max);
        if height_m >= TOP_M {
            let is_top = |y: &f64| *y >= height_m - FLAT_M;
            let first = hump.iter().position(is_top).unwrap_or(0);
            let last = hump.iter().rposition(is_top).unwrap_or(0);
            found.push(Hump { top_s: (row as f64 + 0.5 * (first + last) as f64) * STEP_S, height_m });
        }
        row += rows + 1;
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two sines are two humps with their tops in the middle; one that stays under the sensor's resolution is none.
    #[test]
    fn humps_are_counted() {
        let row = |n: usize| n as f64 * STEP_S;
        let bow = |n: usize, from_s: f64, height_m: f64| {
            let share = (row(n) - from_s) / 0.02;
            if (0.0..1.0).contains(&share) { height_m * (std::f64::consts::PI * share).sin() } else { 0.0 }
        };
        let key: Vec<f64> =
            (0..2000).map(|n| bow(n, 0.0, 0.5e-3) + bow(n, 0.03, 1.5e-3) + bow(n, 0.06, 2e-3)).collect();
        let [first, second] = humps(&key)[..] else { panic!("{:?}", humps(&key)) };
        assert!((first.top_s - 0.01).abs() < 1e-4 && (first.height_m - 0.5e-3).abs() < 1e-6, "{first:?}");
        assert!((second.top_s - 0.04).abs() < 1e-4 && (second.height_m - 1.5e-3).abs() < 1e-6, "{second:?}");
        assert!(humps(&vec![0.19e-3; 1000]).is_empty());
        let low: Vec<f64> = (0..2000).map(|n| bow(n, 0.0, 0.25e-3)).collect();
        assert!(humps(&low).is_empty());
    }
}
