//! Strokes: the player's force or motion over time.
//!
//! Time in seconds, force in newtons, position in metres; force and position are positive downward (pushing), position
//! is counted from the key's rest. [`PositionOf`] says whether it is the position of the key's front or of the
//! fingertip.
//!
//! A [`Recording`] is a laboratory's table with known columns and units; a [`Series`] can drive a key.

mod builtin;
mod columns;
mod csv_file;
mod driving;
mod error;
mod fingertip;
mod force;
mod hand_stroke;
mod position;
mod recording;
mod rows;
mod speed;

use std::cell::Cell;

pub use builtin::{NUANCES, Touch};
pub use columns::{Column, Columns, ColumnsError, Layout, PositionOf, ROLES, Role};
pub use driving::{DrivingError, Prescribed, Stroke};
pub use error::StrokeError;
pub use force::ForceSeries;
pub use hand_stroke::{HOLDS_S, HandStroke, Leave, Muscle, RISE_S, Relax, STRUCK_JOINTS, STRUCK_N_S_M, least_jerk};
pub use position::PositionSeries;
pub use recording::{Channel, Dialect, Gaps, MAX_ROWS, Recording};
pub use rows::MAX_BYTES;
pub use speed::SpeedSeries;

/// Largest force, N: a finger plays fortissimo with less than 50.
pub const MAX_FORCE_N: f64 = crate::player::MAX_FORCE_N;

/// Returns the fault of a constant force, N, if there is one: it must be from 0 to [`MAX_FORCE_N`].
#[must_use]
pub fn constant_force_fault(force_n: f64) -> Option<String> {
    if (0.0..=MAX_FORCE_N).contains(&force_n) {
        return None;
    }
    let why = if force_n < 0.0 { ": a finger pushes the key down, and cannot pull it up" } else { "" };
    Some(format!("expected a number from 0 to {MAX_FORCE_N} N{why}"))
}

/// Largest position, m: a key dips by 0.01.
pub const MAX_POSITION_M: f64 = 1.0;

/// A stroke as sampled: a force, a position, or both, each over its own instants.
///
/// Read one with [`Series::load`] or [`Series::parse`], or build the interpolants from samples.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// Interpolated force, when the series has one.
    pub force: Option<ForceSeries>,
    /// Interpolated position, when the series has one.
    pub position: Option<PositionSeries>,
    /// Interpolated rise of the hammer's strike point from rest, up positive, when it was measured too: it drives
    /// nothing.
    pub hammer_head: Option<PositionSeries>,
    /// Interpolated speed of the hammer's strike point, up positive, when it was measured: it drives nothing.
    pub hammer_speed: Option<SpeedSeries>,
}

impl Series {
    /// The stroke up to an instant, s: the samples before it, and one at it.
    ///
    /// # Errors
    /// [`SampleError`] if the result would be empty.
    pub fn first(&self, duration_s: f64) -> Result<Self, SampleError> {
        let end_s = self.start_s() + duration_s;
        if end_s >= self.end_s() {
            return Ok(self.clone());
        }
        let begun = |times: &[f64], values: &[f64], last: f64| {
            let count = times.partition_point(|&t| t < end_s - SHORTEST_STEP_S);
            ([&times[..count], &[end_s]].concat(), [&values[..count], &[last]].concat())
        };
        let path = |series: &Option<PositionSeries>| {
            let path = |s: &PositionSeries| {
                let (times, values) = begun(s.times_s(), s.positions_m(), s.at(end_s, &mut Cursor::default()).0);
                PositionSeries::new(times, values)
            };
            series.as_ref().map(path).transpose()
        };
        let force = |s: &ForceSeries| {
            let (times, values) = begun(s.times_s(), s.forces_n(), s.at(end_s, &mut Cursor::default()));
            ForceSeries::new(times, values)
        };
        let speed = |s: &SpeedSeries| {
            let (times, values) = begun(s.times_s(), s.speeds_m_per_s(), s.at(end_s, &mut Cursor::default()));
            SpeedSeries::new(times, values)
        };
        Ok(Self {
            force: self.force.as_ref().map(force).transpose()?,
            position: path(&self.position)?,
            hammer_head: path(&self.hammer_head)?,
            hammer_speed: self.hammer_speed.as_ref().map(speed).transpose()?,
        })
    }

    /// The stroke's first instant, s: of the force or the position, whichever begins first.
    pub fn start_s(&self) -> f64 {
        self.driving()
            .map(|times| times[0])
            .fold(None, |a: Option<f64>, t| Some(a.map_or(t, |a| a.min(t))))
            .unwrap_or(0.0)
    }

    /// The force with which it begins, N; 0 where none was recorded.
    fn begins_with_n(&self) -> f64 {
        self.force.as_ref().map_or(0.0, |force| force.at(self.start_s(), &mut Cursor::default()))
    }

    /// The stroke's last instant, s.
    pub fn end_s(&self) -> f64 {
        let last = self.driving().map(|times| times[times.len() - 1]);
        last.fold(None, |a: Option<f64>, t| Some(a.map_or(t, |a| a.max(t)))).unwrap_or(0.0)
    }

    /// The sampled instants, s, increasing: of the force, or of the position where there is no force.
    pub fn times_s(&self) -> &[f64] {
        self.driving().next().unwrap_or(&[])
    }

    /// The instants of what can drive. An interpolant has two or more.
    fn driving(&self) -> impl Iterator<Item = &[f64]> {
        let force = self.force.as_ref().map(ForceSeries::times_s);
        force.into_iter().chain(self.position.as_ref().map(PositionSeries::times_s))
    }
}

/// Where the last evaluation of a series was: evaluating at times that move on (or back) little by little then costs no
/// search. One cursor per evaluating run; any cursor gives the same values, only not as fast.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Cursor(usize);

impl Cursor {
    /// A series at instants that move on: it keeps the cursor.
    fn kept<T>(at: impl Fn(f64, &mut Cursor) -> T) -> impl Fn(f64) -> T {
        let last = Cell::new(Cursor::default());
        move |t_s| {
            let mut cursor = last.get();
            let value = at(t_s, &mut cursor);
            last.set(cursor);
            value
        }
    }

    /// The interval `[times[i], times[i + 1]]` that contains `t`, which lies within the series; `times` has two entries
    /// or more.
    fn seek(&mut self, times: &[f64], t: f64) -> usize {
        let last = times.len() - 2;
        let mut i = self.0.min(last);
        // A few neighbours first, as a run goes; then by bisection, as a jump does.
        for _ in 0..4 {
            if i < last && t >= times[i + 1] {
                i += 1;
            } else if i > 0 && t < times[i] {
                i -= 1;
            } else {
                break;
            }
        }
        let inside = (i == 0 || times[i] <= t) && (i == last || t < times[i + 1]);
        if !inside {
            i = times.partition_point(|&time| time <= t).saturating_sub(1).min(last);
        }
        self.0 = i;
        i
    }
}

/// Why samples cannot be interpolated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SampleError {
    /// One sample says nothing about motion.
    #[error("a series needs two samples or more")]
    TooFew,
    /// Times and values do not pair up.
    #[error("as many values as times are needed")]
    UnequalLengths,
    /// A time or value is not finite, or so large that interpolating it overflows; the index of the sample.
    #[error("sample {0} is not a finite number within range")]
    NotFinite(usize),
    /// Time does not increase; the index of the later sample.
    #[error("time does not increase at sample {0}")]
    NotIncreasing(usize),
}

/// Checks what both interpolants need.
fn check_samples(times_s: &[f64], values: &[f64]) -> Result<(), SampleError> {
    if times_s.len() != values.len() {
        return Err(SampleError::UnequalLengths);
    }
    if times_s.len() < 2 {
        return Err(SampleError::TooFew);
    }
    // Far above any stroke; squares and quotients of these still fit.
    let sane = |x: f64| x.abs() <= 1e9;
    for (i, (&t, &value)) in times_s.iter().zip(values).enumerate() {
        if !sane(t) || !sane(value) {
            return Err(SampleError::NotFinite(i));
        }
        // Closer than a picosecond, slopes lose their meaning.
        if i > 0 && t - times_s[i - 1] < SHORTEST_STEP_S {
            return Err(SampleError::NotIncreasing(i));
        }
    }
    Ok(())
}

/// Shortest time between two samples, s.
pub(crate) const SHORTEST_STEP_S: f64 = 1e-12;

#[cfg(test)]
mod tests {
    use super::*;

    /// The beginning of a stroke is the stroke there, and nothing after it.
    #[test]
    fn a_beginning() {
        let text =
            "time_s,force_N,position_m,hammer_rise_m\n1,0,0,0\n2,4,0.001,0.01\n3,8,0.002,0.02\n11,8,0.002,0.02\n";
        let whole = Series::parse(text, "test").unwrap();
        let first = whole.first(1.5).unwrap();
        assert_eq!(first.times_s(), [1.0, 2.0, 2.5]);
        let at = |s: &Series| s.force.as_ref().unwrap().at(2.5, &mut Cursor::default());
        assert_eq!(at(&first), at(&whole));
        assert_eq!(first.hammer_head.unwrap().positions_m()[..2], [0.0, 0.01]);
        assert_eq!(whole.first(10.0).unwrap(), whole);
        assert_eq!(whole.first(1e-13), Err(SampleError::TooFew));
        let two = Series::parse("time_s,force_N\n0,0\n10000,1\n", "test").unwrap().first(250.0).unwrap();
        assert_eq!(two.times_s(), [0.0, 250.0]);
    }
}
