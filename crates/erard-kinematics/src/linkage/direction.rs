//! Constant directions: exact quarter turns, plus named angles.

use std::ops::{Add, Neg};

use super::description::{AngleId, Constant};

/// Constant direction in a body's frame, as an angle counter-clockwise from its x axis: a number of quarter turns plus
/// a sum of named constant angles.
///
/// Quarter turns are stored separately because they decide whether an equation shows a sine or a cosine, and because
/// cos 90° must be exactly 0, not 6e-17.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Direction {
    pub(crate) quarters: u8,
    /// Sorted by angle, no zero factors: equal directions compare equal.
    pub(crate) named: Vec<(AngleId, i32)>,
}

impl Direction {
    /// Direction along the x axis.
    pub const X: Direction = Direction::quarter(0);
    /// Direction along the y axis.
    pub const Y: Direction = Direction::quarter(1);
    /// Against the x axis.
    pub(crate) const MINUS_X: Direction = Direction::quarter(2);
    /// Direction against the y axis.
    pub const MINUS_Y: Direction = Direction::quarter(3);

    /// `n` quarter turns counter-clockwise from the x axis.
    #[must_use]
    pub(crate) const fn quarter(n: u8) -> Direction {
        Direction { quarters: n % 4, named: Vec::new() }
    }

    pub(crate) fn at(angle: AngleId) -> Direction {
        Direction { quarters: 0, named: vec![(angle, 1)] }
    }

    /// Cosine and sine, given the values of the named angles.
    pub(crate) fn cos_sin(&self, angles: &[Constant]) -> [f64; 2] {
        let turn: f64 = (self.named.iter()).map(|&(id, factor)| f64::from(factor) * angles[id.0].value).sum();
        let (s, c) = turn.sin_cos();
        match self.quarters {
            0 => [c, s],
            1 => [-s, c],
            2 => [-c, -s],
            _ => [s, -c],
        }
    }
}

impl Add for Direction {
    type Output = Direction;

    fn add(mut self, other: Direction) -> Direction {
        self.quarters = (self.quarters + other.quarters) % 4;
        for (id, factor) in other.named {
            match self.named.binary_search_by_key(&id, |&(known, _)| known) {
                Ok(at) => {
                    self.named[at].1 += factor;
                    if self.named[at].1 == 0 {
                        self.named.remove(at);
                    }
                }
                Err(at) => self.named.insert(at, (id, factor)),
            }
        }
        self
    }
}

impl Neg for Direction {
    type Output = Direction;

    fn neg(mut self) -> Direction {
        self.quarters = (4 - self.quarters) % 4;
        for (_, factor) in &mut self.named {
            *factor = -*factor;
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sum and its opposite cancel exactly, named angles included: no tolerance.
    #[test]
    fn a_direction_and_its_opposite_cancel() {
        let d = Direction::Y + Direction::at(AngleId(3)) + Direction::at(AngleId(1));
        assert_eq!(d.clone() + -d, Direction::X);
    }

    /// Quarter turns are exact: the four axes have components 0 and ±1, no rounding.
    #[test]
    fn axes_are_exact() {
        assert_eq!(Direction::Y.cos_sin(&[]), [0.0, 1.0]);
        assert_eq!(Direction::MINUS_X.cos_sin(&[]), [-1.0, 0.0]);
        assert_eq!(Direction::MINUS_Y.cos_sin(&[]), [0.0, -1.0]);
    }
}
