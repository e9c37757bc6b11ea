//! Named laws between hammer speed and velocity.

use crate::Velocity;

/// Relation between hammer speed at the string, m/s, and velocity. Every law rises with speed, and is exact in both
/// directions unless it is cut off at 0 or 127 counts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Law<'a> {
    /// `counts = at_one + per_octave log2(v)`, v in m/s.
    Logarithmic {
        /// Counts at 1 m/s.
        at_one: f64,
        /// Counts for twice the speed, positive.
        per_octave: f64,
    },
    /// `counts = 127 v / full`.
    Linear {
        /// The speed of 127 counts, m/s, positive.
        full_m_per_s: f64,
    },
    /// A table of your own points, with straight lines between them in counts and the logarithm of the speed; the first
    /// and the last line continue beyond the ends.
    Table(Table<'a>),
}

/// Points of a law: hammer speed, m/s, and counts, both ascending. Made by [`Law::table`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Table<'a>(&'a [[f64; 2]]);

/// A fault in a table.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum LawError {
    /// There are fewer than two points.
    TooFew,
    /// A point, from 0, has a speed that is not positive and finite, or counts that are not within 0 to 127.
    OutOfRange(usize),
    /// A point, from 0, does not lie above the one before it, in speed and in counts.
    NotAscending(usize),
}

impl core::fmt::Display for LawError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            LawError::TooFew => f.write_str("expected at least two points"),
            LawError::OutOfRange(i) => {
                write!(f, "point {}: expected a speed above 0 m/s and a velocity of 0 to 127", i + 1)
            }
            LawError::NotAscending(i) => {
                write!(f, "point {}: expected more speed and more velocity than before", i + 1)
            }
        }
    }
}

impl core::error::Error for LawError {}

impl<'a> Law<'a> {
    /// The convention of a Bösendorfer SE290: 52 + 25 log2(v). Its recordings agree with an accelerometer at the hammer
    /// to 14 % of the speed, for velocities of 20 to 120 [Goebl, *The Role of Timing and Intensity in the Production
    /// and Perception of Melody in Expressive Piano Performance*, TR-2003-28, eq. 3.2].
    pub const GOEBL: Law<'static> = Law::Logarithmic { at_one: 52.0, per_octave: 25.0 };

    /// Makes a law from your own points: hammer speed, m/s, and counts.
    ///
    /// # Errors
    /// [`LawError`]: fewer than two points, a number out of range, or points that do not rise.
    pub fn table(points: &'a [[f64; 2]]) -> Result<Self, LawError> {
        if points.len() < 2 {
            return Err(LawError::TooFew);
        }
        for (i, &[speed, counts]) in points.iter().enumerate() {
            if !(speed > 0.0 && speed.is_finite() && (0.0..=127.0).contains(&counts)) {
                return Err(LawError::OutOfRange(i));
            }
            if i > 0 && !(points[i - 1][0] < speed && points[i - 1][1] < counts) {
                return Err(LawError::NotAscending(i));
            }
        }
        Ok(Law::Table(Table(points)))
    }

    /// The velocity of a hammer speed, m/s; a speed that is not positive has none, which is 0 counts.
    #[must_use]
    pub fn velocity(&self, speed_m_per_s: f64) -> Velocity {
        // What is not a number is not positive.
        if speed_m_per_s > 0.0 { Velocity::new(self.counts(speed_m_per_s)) } else { Velocity::new(0.0) }
    }

    fn counts(&self, speed: f64) -> f64 {
        match *self {
            Law::Logarithmic { at_one, per_octave } => at_one + per_octave * libm::log2(speed),
            Law::Linear { full_m_per_s } => 127.0 * speed / full_m_per_s,
            Law::Table(Table(points)) => {
                let [from, to] = piece(points, |point| speed <= point[0]);
                let share = libm::log2(speed / from[0]) / libm::log2(to[0] / from[0]);
                from[1] + share * (to[1] - from[1])
            }
        }
    }

    /// The hammer speed of a velocity, m/s.
    #[must_use]
    pub fn speed_m_per_s(&self, velocity: Velocity) -> f64 {
        let counts = velocity.counts();
        match *self {
            Law::Logarithmic { at_one, per_octave } => libm::exp2((counts - at_one) / per_octave),
            Law::Linear { full_m_per_s } => full_m_per_s * counts / 127.0,
            Law::Table(Table(points)) => {
                let [from, to] = piece(points, |point| counts <= point[1]);
                let share = (counts - from[1]) / (to[1] - from[1]);
                from[0] * libm::exp2(share * libm::log2(to[0] / from[0]))
            }
        }
    }
}

/// The ends of the segment that holds a value: the first one whose end is not below it, else the last. A table has at
/// least two points.
fn piece(points: &[[f64; 2]], is_below: impl Fn(&[f64; 2]) -> bool) -> [[f64; 2]; 2] {
    let last = points.len() - 1;
    let end = (1..last).find(|&i| is_below(&points[i])).unwrap_or(last);
    [points[end - 1], points[end]]
}

/// Relation between the speed of a rising key as its damper is set down and the release velocity.
///
/// No publication was found that assigns speeds to release velocities. This law is a convention of this project: in
/// proportion to the speed of the key's front, with 64 for 0.2 m/s, which is about the speed of a key that is let go.
/// 64 is also what a sender that measures nothing sends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReleaseLaw {
    /// The speed of 64 counts, m/s at the key's front, upward, positive.
    pub usual_m_per_s: f64,
}

impl ReleaseLaw {
    /// The convention of this project.
    pub const USUAL: ReleaseLaw = ReleaseLaw { usual_m_per_s: 0.2 };

    /// The release velocity of a speed, m/s at the key's front, upward positive.
    #[must_use]
    pub fn velocity(&self, speed_m_per_s: f64) -> Velocity {
        Velocity::new(64.0 * speed_m_per_s / self.usual_m_per_s)
    }

    /// The speed of a release velocity, m/s.
    #[must_use]
    pub fn speed_m_per_s(&self, velocity: Velocity) -> f64 {
        self.usual_m_per_s * velocity.counts() / 64.0
    }
}
