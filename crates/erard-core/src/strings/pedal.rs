//! The rail that the sustain pedal lifts, and with it the dampers: a rigid surface with prescribed motion.

use std::str::FromStr;

use moreau::Surface;
use thiserror::Error;

use crate::parameter::{Bare, Quantity};

/// Largest lift of the rail, m.
pub const MAX_PEDAL_M: f64 = 10e-3;
/// Speed at which it follows its target, m/s: a stamping foot moves it by 10 mm in 20 ms. Without the limit a jump of
/// the target would hit the dampers like a hammer.
pub const PEDAL_M_PER_S: f64 = 0.5;

/// Where the rail is, m above its place with the pedal up.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Rail {
    pub lift_m: f64,
    pub aim_m: f64,
}

impl Rail {
    /// Sets its target, clamped to its range; NaN changes nothing.
    pub(crate) fn aim(&mut self, lift_m: f64) {
        if !lift_m.is_nan() {
            self.aim_m = lift_m.clamp(0.0, MAX_PEDAL_M);
        }
    }

    pub(crate) fn moves(&self) -> bool {
        self.lift_m != self.aim_m
    }

    /// Its position after a step.
    pub(crate) fn after(&self, step_s: f64) -> f64 {
        let most_m = PEDAL_M_PER_S * step_s;
        let left_m = self.aim_m - self.lift_m;
        if left_m.abs() <= most_m { self.aim_m } else { self.lift_m + most_m.copysign(left_m) }
    }

    /// What the lever's felt meets: the rail comes toward it.
    pub(crate) fn surface(&self, step_s: f64) -> Surface<f64> {
        Surface { displacement: -self.lift_m, free: -self.after(step_s), compliance: 0.0 }
    }
}

/// Most instants of a [`Pedal`].
const MAX_INSTANTS: usize = 16;

/// How the sustain pedal's rail is moved over a run: its lift at some instants, straight lines between them, constant
/// before and after.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pedal {
    /// s, and m.
    points: [[f64; 2]; MAX_INSTANTS],
    count: usize,
}

/// Why a text is no [`Pedal`].
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum PedalError {
    /// Not a lift.
    #[error("pedal `{found}`: expected a lift from 0 to {} mm, e.g. 7mm, or instants with lifts, e.g. 0s=0mm,0.5s=7mm", 1e3 * MAX_PEDAL_M)]
    Lift {
        /// Found text.
        found: String,
    },
    /// Instants in no order.
    #[error("pedal: the instants are not in order at `{found}`; expected ascending seconds")]
    Order {
        /// Found text.
        found: String,
    },
    /// Too many.
    #[error("the pedal has {found} instants; expected at most {MAX_INSTANTS}")]
    Many {
        /// Number of instants.
        found: usize,
    },
}

impl Default for Pedal {
    fn default() -> Self {
        Pedal::held(0.0)
    }
}

impl Pedal {
    /// One that is held so far down that its rail is lifted so far, m.
    #[must_use]
    pub fn held(lift_m: f64) -> Self {
        let mut points = [[0.0; 2]; MAX_INSTANTS];
        points[0][1] = lift_m;
        Pedal { points, count: 1 }
    }

    /// The lift at an instant, m.
    #[must_use]
    pub(crate) fn lift_m(&self, time_s: f64) -> f64 {
        let points = &self.points[..self.count];
        let after = points.partition_point(|[t, _]| *t <= time_s);
        let before = after.checked_sub(1).map(|i| points[i]);
        match (before, points.get(after)) {
            (Some([t0, a]), Some([t1, b])) => a + (b - a) * (time_s - t0) / (t1 - t0),
            (Some([_, lift_m]), None) | (None, Some(&[_, lift_m])) => lift_m,
            (None, None) => 0.0,
        }
    }

    /// Whether the pedal is ever moved or held down.
    #[must_use]
    pub(crate) fn is_used(&self) -> bool {
        self.points[..self.count].iter().any(|[_, lift_m]| *lift_m != 0.0)
    }
}

impl FromStr for Pedal {
    type Err = PedalError;

    fn from_str(text: &str) -> Result<Self, PedalError> {
        let wrong = |found: &str| PedalError::Lift { found: found.trim().to_owned() };
        let lift = |part: &str| {
            Quantity::Length
                .read(part, Bare::In("mm"))
                .ok()
                .filter(|m| (0.0..=MAX_PEDAL_M).contains(m))
                .ok_or_else(|| wrong(part))
        };
        if !text.contains('=') {
            return Ok(Pedal::held(lift(text)?));
        }
        // Between semicolons, commas are decimal.
        let parts: Vec<&str> = text.split(if text.contains(';') { ';' } else { ',' }).collect();
        if parts.len() > MAX_INSTANTS {
            return Err(PedalError::Many { found: parts.len() });
        }
        let mut points = [[0.0; 2]; MAX_INSTANTS];
        for (i, part) in parts.iter().enumerate() {
            let (time, to) = part.split_once('=').ok_or_else(|| wrong(part))?;
            let time_s = Quantity::Time.read(time, Bare::Si).map_err(|_| wrong(part))?;
            points[i] = [time_s, lift(to)?];
            if i > 0 && points[i][0] <= points[i - 1][0] {
                return Err(PedalError::Order { found: part.trim().to_owned() });
            }
        }
        Ok(Pedal { points, count: parts.len() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pedals_are_read() {
        let held: Pedal = "3.5mm".parse().unwrap();
        assert!(held.is_used() && [-1.0, 0.0, 9.0].map(|t| held.lift_m(t)) == [3.5e-3; 3]);
        let moved: Pedal = "0.5s=0mm, 1s=8 mm,2=2mm".parse().unwrap();
        for (t, mm) in [(0.0, 0.0), (0.5, 0.0), (0.75, 4.0), (1.0, 8.0), (1.5, 5.0), (3.0, 2.0)] {
            assert!((1e3 * moved.lift_m(t) - mm).abs() < 1e-12, "{t}");
        }
        assert!(!Pedal::default().is_used());
        assert_eq!("3".parse::<Pedal>().unwrap(), "3,0 mm".parse().unwrap());
        assert_eq!("0,5s=0;1s=8mm".parse::<Pedal>().unwrap(), "500ms=0mm,1s=0.8cm".parse().unwrap());
        for wrong in ["", "3cm", "-1mm", "11mm", "nan mm", "0s=1mm,0s=2mm", "0s=1mm,2mm", "xs=1mm"] {
            assert!(wrong.parse::<Pedal>().is_err(), "{wrong}");
        }
    }
}
