//! What a pianist's hand does with a key: the touches of the measurements, as a hand ([`Hand`]) and what its muscle
//! does.
//!
//! In the *pressed* touch the finger rests on the key before (Goebl, Bresin and Galembo 2005); a *struck* one is a
//! [`Hand`] that arrives with speed. A loud pressed touch is a force that rises; a soft one is a motion that is led,
//! because nobody plays pianissimo by dropping a weight on the key: a constant force that is small enough to play
//! softly leaves the key hanging at let-off. The path along which a hand is led is that of least jerk, as people's
//! hands move between two points (Flash and Hogan, The coordination of arm movements, J. Neurosci. 5 (1985) 1688, from
//! memory):
//!
//! ```text
//! x(t) = d (10 s^3 - 15 s^4 + 6 s^5),   s = t / T
//! ```
//!
//! All numbers of these touches are estimates and say so where they stand.

use std::f64::consts::PI;

use super::Run;
use super::setup::{Setup, SimulationError};
use super::simulation::simulate;
use crate::instrument::Instrument;
use crate::player::{Hand, Input};
use crate::progress::Progress;

/// How deep a hand is led, m below the key front's rest: a dip of 10 mm and a half more, so that muscle holds the key
/// down at the end.
const LED_DEPTH_M: f64 = 10.5e-3;
/// The finger of a struck touch, kg: the lightest of the published effective masses.
const STRUCK_KG: f64 = 0.1;
/// Its muscle's force for every m/s of its arrival, N s/m: fast fingers press on harder.
const STRUCK_N_S_M: f64 = 6.0;
/// A muscle relaxes within this time, s.
const RELAX_S: f64 = 0.100;
/// With what acceleration a hand whose muscle pressed leaves the key, m/s2. An estimate: it is 5 mm away after 30 ms.
const LEAVING_M_S2: f64 = 11.0;
/// How far a hand that was led goes above the key front's rest when it leaves, m.
const LEFT_M: f64 = 5e-3;

/// What the muscle of a hand does.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Muscle {
    /// A force that is there at once and stays.
    Steady {
        /// N.
        force_n: f64,
    },
    /// A force that rises from nothing at a constant rate, and stays at its height.
    Rises {
        /// How fast, N/s.
        rate_n_s: f64,
        /// How high, N.
        height_n: f64,
    },
    /// Its stiffness and damping lead the hand down along the path of least jerk.
    Leads {
        /// How deep, m below the key front's rest.
        depth_m: f64,
        /// How long that takes, s.
        duration_s: f64,
    },
}

/// A touch: a hand and what its muscle does.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HandStroke {
    /// The hand.
    pub hand: Hand,
    /// What its muscle does.
    pub muscle: Muscle,
    /// When its force begins to relax, s, and to what, N: half a cosine of 0.1 s. `None`: it does not. A hand that is
    /// led does not.
    pub relaxes: Option<[f64; 2]>,
    /// When it begins to leave, s, and within what time its force is gone, s (half a cosine); a hand that was led goes
    /// up along the path of least jerk within twice that. `None`: it stays.
    pub leaves: Option<[f64; 2]>,
}

impl HandStroke {
    /// The loud pressed touch: the finger rests on the key, and its muscle's force rises at this rate, N/s, without
    /// end. The hand is [`Hand::default`].
    #[must_use]
    pub fn pressed(rate_n_s: f64) -> Self {
        let hand = Hand::default();
        HandStroke { hand, muscle: Muscle::Rises { rate_n_s, height_n: f64::INFINITY }, relaxes: None, leaves: None }
    }

    /// The soft pressed touch: the finger rests on the key and is led down within so many s. The hand is
    /// [`Hand::default`].
    #[must_use]
    pub fn led(duration_s: f64) -> Self {
        let muscle = Muscle::Leads { depth_m: LED_DEPTH_M, duration_s };
        HandStroke { hand: Hand::default(), muscle, relaxes: None, leaves: None }
    }

    /// The struck touch: a finger with a share of the hand, 0.1 kg, arrives at the key with a speed, m/s, and its
    /// muscle presses on, by 6 N for every m/s: both estimates.
    #[must_use]
    pub fn struck(speed_m_s: f64) -> Self {
        let hand = Hand { mass_kg: STRUCK_KG, start_m_s: speed_m_s, ..Hand::default() };
        HandStroke { hand, muscle: Muscle::Steady { force_n: STRUCK_N_S_M * speed_m_s }, relaxes: None, leaves: None }
    }

    /// The same, relaxing from this instant on, s, to a force that holds the key, N.
    #[must_use]
    pub fn relaxing(self, at_s: f64, to_n: f64) -> Self {
        HandStroke { relaxes: Some([at_s, to_n]), ..self }
    }

    /// The same, relaxing to what holds the key as soon as the hammer is at the string: when that is, a run of so many
    /// s says. A touch that does not sound within them relaxes at their end.
    ///
    /// # Errors
    /// See [`SimulationError`].
    pub fn relaxing_at_the_blow(
        self,
        instrument: &Instrument,
        setup: &Setup,
        to_n: f64,
    ) -> Result<Self, SimulationError> {
        let short = Setup { record_every: None, ledger: false, ..*setup };
        let blow = press_by_hand(instrument, &self, &short, &mut |_| true)?.events.hammer_contact_s();
        Ok(self.relaxing(blow.unwrap_or(setup.duration_s), to_n))
    }

    /// The same, leaving from this instant on, s, its force gone within so many s.
    #[must_use]
    pub fn leaving(self, at_s: f64, within_s: f64) -> Self {
        HandStroke { leaves: Some([at_s, within_s]), ..self }
    }

    /// What the muscle does at an instant, s: a force, or a motion.
    #[must_use]
    pub fn input(&self, t: f64) -> Input {
        match self.muscle {
            Muscle::Steady { .. } | Muscle::Rises { .. } => Input::Force(self.let_go(t)),
            Muscle::Leads { depth_m, duration_s } => {
                let [x, v] = least_jerk(t / duration_s);
                let [up, up_v, back] = match self.leaves {
                    Some([at, within]) => {
                        let [up, up_v] = least_jerk((t - at) / (2.0 * within));
                        [up, up_v, 2.0 * within]
                    }
                    None => [0.0, 0.0, 1.0],
                };
                let way = depth_m + LEFT_M;
                Input::Motion {
                    position_m: depth_m * x - way * up,
                    velocity_m_s: depth_m * v / duration_s - way * up_v / back,
                }
            }
        }
    }

    /// The muscle's force, N; as the hand leaves it falls by half a cosine, to what lifts the hand, and rises no
    /// further.
    fn let_go(&self, t: f64) -> f64 {
        let Some([at, within]) = self.leaves else { return self.relaxed(t) };
        let held = self.relaxed(t.min(at));
        held - half_a_cosine((t - at) / within) * (held + LEAVING_M_S2 * self.hand.mass_kg)
    }

    /// The muscle's force as long as the hand stays, N.
    fn relaxed(&self, t: f64) -> f64 {
        let rises = |t: f64| match self.muscle {
            Muscle::Steady { force_n } => force_n,
            Muscle::Rises { rate_n_s, height_n } => (rate_n_s * t).min(height_n),
            Muscle::Leads { .. } => 0.0,
        };
        match self.relaxes {
            Some([at, to]) if t >= at => {
                let peak = rises(at);
                peak + (to - peak) * half_a_cosine((t - at) / RELAX_S)
            }
            _ => rises(t),
        }
    }
}

/// From 0 to 1 over a share of its time, smoothly.
fn half_a_cosine(share: f64) -> f64 {
    0.5 - 0.5 * libm::cos(PI * share.clamp(0.0, 1.0))
}

/// The path of least jerk from 0 to 1 and its slope at a share of its time, which is held between 0 and 1: velocity and
/// acceleration begin and end at nothing.
#[must_use]
pub fn least_jerk(s: f64) -> [f64; 2] {
    let s = s.clamp(0.0, 1.0);
    [s * s * s * (10.0 - 15.0 * s + 6.0 * s * s), 30.0 * s * s * (1.0 - s) * (1.0 - s)]
}

/// Simulates a touch: [`simulate`] with the hand and what its muscle does.
///
/// # Errors
/// See [`SimulationError`].
pub fn press_by_hand(
    instrument: &Instrument,
    gesture: &HandStroke,
    setup: &Setup,
    progress: &mut Progress<'_>,
) -> Result<Run, SimulationError> {
    let setup = Setup { hand: Some(gesture.hand), ..*setup };
    simulate(instrument, &|t| gesture.input(t), &setup, progress)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Between its ends the path has the slope that it says, and stands still at both ends.
    #[test]
    fn the_path_of_least_jerk_is_smooth() {
        for n in 1..100 {
            let s = f64::from(n) / 100.0;
            let by_difference = (least_jerk(s + 1e-6)[0] - least_jerk(s - 1e-6)[0]) / 2e-6;
            assert!((by_difference - least_jerk(s)[1]).abs() < 1e-8, "{s}");
        }
        assert_eq!([least_jerk(0.0), least_jerk(1.0)], [[0.0, 0.0], [1.0, 0.0]]);
        assert_eq!(least_jerk(0.5), [0.5, 1.875]);
    }

    /// Forces rise as said, and are gone, with what lifts the hand, when it has left.
    #[test]
    fn forces_rise_and_go() {
        let force = |gesture: &HandStroke, t| match gesture.input(t) {
            Input::Force(n) => n,
            other => panic!("{other:?}"),
        };
        let pressed = HandStroke::pressed(100.0).leaving(0.1, 0.03);
        assert!((force(&pressed, 0.05) - 5.0).abs() < 1e-12 && (force(&pressed, 0.1) - 10.0).abs() < 1e-12);
        assert!((force(&pressed, 0.115) - 0.5 * (10.0 - 0.2 * LEAVING_M_S2)).abs() < 1e-9);
        assert!((force(&pressed, 0.2) + 0.2 * LEAVING_M_S2).abs() < 1e-12);
        let struck = HandStroke::struck(0.5).relaxing(0.1, 2.0);
        assert!((force(&struck, 0.05) - 3.0).abs() < 1e-12 && (force(&struck, 0.15) - 2.5).abs() < 1e-12);
        assert!((force(&struck.leaving(0.3, 0.03), 0.3) - 2.0).abs() < 1e-12);
        match HandStroke::led(0.2).leaving(0.5, 0.03).input(0.6) {
            Input::Motion { position_m, .. } => assert!((position_m + LEFT_M).abs() < 1e-12),
            other => panic!("{other:?}"),
        }
    }
}
