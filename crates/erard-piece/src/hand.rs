//! The strokes of a hand on one key, one after the other.

use erard::player::{HandError, Input};
use erard::stroke::{HandStroke, Leave, Muscle};

/// Mass of the hand, kg: [`erard::level::MASS_KG`].
const MASS_KG: f64 = erard::level::MASS_KG;
/// Time after the end of its force at which a hand is away from the key, s: by then it has risen by 20 mm or more.
const AWAY_S: f64 = 0.1;
/// Time after which the force of a muscle that holds the key is constant, s.
const HELD_S: f64 = 0.12;

/// Release of a key by the hand.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Way {
    /// Time within which its force vanishes, s.
    pub within_s: f64,
}

impl Way {
    /// An unhurried release: [`erard::level::RELEASE_S`].
    pub(crate) const USUAL: Way = Way { within_s: erard::level::RELEASE_S };
    /// An immediate release.
    pub(crate) const QUICK: Way = Way { within_s: 2e-3 };
}

/// The drive of a key.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Hand {
    /// Nothing touches it.
    Away,
    /// A stroke that began at a step.
    On {
        /// Its instants count from there.
        stroke: HandStroke,
        /// The step.
        begins: u64,
    },
}

impl Hand {
    /// A hand that rests on the key at its present position and presses with a force, N, that rises within a time, s.
    pub(crate) fn pressing(force_n: f64, rise_s: f64, begins: u64) -> Self {
        let mut stroke = HandStroke::pressed(MASS_KG, force_n);
        stroke.muscle = Muscle::Swells { force_n, within_s: rise_s };
        Hand::On { stroke, begins }
    }

    /// From this step on it holds the key with a force, N.
    pub(crate) fn hold(&mut self, step: u64, h: f64, force_n: f64) {
        if let Hand::On { stroke, begins } = self {
            *stroke = stroke.holding((step - *begins) as f64 * h, force_n);
        }
    }

    /// From this step on it leaves the key.
    pub(crate) fn leave(&mut self, step: u64, h: f64, way: Way) {
        if let Hand::On { stroke, begins } = self {
            let at_s = (step - *begins) as f64 * h;
            // One that is away so soon lets the key go.
            let left = if way.within_s < 0.01 { stroke.letting_go(at_s) } else { stroke.leaving(at_s, way.within_s) };
            stroke.leaves = left.leaves.map(|leave| Leave { within_s: way.within_s, ..leave });
        }
    }

    /// Its input in a step.
    pub(crate) fn input(&mut self, step: u64, h: f64, theta: f64) -> Result<Input, HandError> {
        let Hand::On { stroke, begins } = self else { return Ok(Input::Free) };
        let t = ((step - *begins) as f64 + theta) * h;
        if stroke.leaves.is_some_and(|leave| t > leave.at_s + leave.within_s + AWAY_S) {
            *self = Hand::Away;
            return Ok(Input::Free);
        }
        stroke.hand.input(&stroke.input(t))
    }

    /// Whether its input is constant from this step on.
    pub(crate) fn is_steady(&self, step: u64, h: f64) -> bool {
        match self {
            Hand::Away => true,
            Hand::On { stroke, begins } => {
                let held = |at_s: f64| (step - *begins) as f64 * h > at_s + HELD_S;
                stroke.leaves.is_none() && stroke.relaxes.is_some_and(|relax| held(relax.at_s))
            }
        }
    }

    /// Whether it has left the key, or is leaving it.
    pub(crate) fn has_left(&self) -> bool {
        match self {
            Hand::Away => true,
            Hand::On { stroke, .. } => stroke.leaves.is_some(),
        }
    }
}
