//! The stroke of a pianist's hand: a hand ([`Hand`]) and the force of its muscle, to the release of the key.
//!
//! The built-in touches ([`HandStroke::pressed`], [`HandStroke::struck`]) have one parameter that sets their loudness;
//! [`crate::level`] finds it for a hammer speed. Goebl, Bresin and Galembo (J. Acoust. Soc. Am. 118 (2005) 1154)
//! distinguish the two: in the *pressed* touch the finger first rests on the key, in the *struck* one it arrives with
//! speed. (H1) of the book:
//!
//! ```text
//! pressed:  F(t) = A (1 - cos(pi t / T)) / 2, then A;   the hand at rest on the key at first
//! struck:   F(t) = c v;                                 the hand arrives with the speed v
//! ```
//!
//! The joints of the finger are stiff in the pressed touch and yield in the struck one ([`STRUCK_JOINTS`]).
//!
//! T is the rise time of the muscle, which depends little on how loud the note is. After the impact the force changes
//! to the one that holds the key ([`HandStroke::relaxing`]); last comes the release ([`HandStroke::leaving`],
//! [`HandStroke::letting_go`]).
//!
//! A hand may also follow the path of least jerk downward, as people's hands move between two points (Flash and Hogan,
//! The coordination of arm movements, J. Neurosci. 5 (1985) 1688, from memory):
//!
//! ```text
//! x(t) = d (10 s^3 - 15 s^4 + 6 s^5),   s = t / T
//! ```
//!
//! The numbers of these touches are estimates and are marked as such, or were chosen by published travel times.

use std::f64::consts::PI;

use crate::player::{Hand, HandInput, Input, Joints};

/// Depth to which a hand is driven, m below the key front's rest: a dip of 10 mm and 0.5 mm more, so that muscle holds
/// the key down at the end.
const LED_DEPTH_M: f64 = 10.5e-3;
/// Within this time the muscle's force of a pressed touch rises, s. An estimate.
pub const RISE_S: f64 = 0.040;
/// The muscle's force of a struck touch for every m/s of its arrival, N s/m: fast hands press on harder. Chosen with
/// [`STRUCK_JOINTS`].
pub const STRUCK_N_S_M: f64 = 8.0;
/// Joints of the finger of a struck touch: 5 N/mm that yield within 8 ms. They and [`STRUCK_N_S_M`] were chosen by the
/// travel times of two grands at three hammer speeds (`erard-reproduce --only struck-hand`). With stiff joints the hand
/// throws the hammer off the jack.
pub const STRUCK_JOINTS: Joints = Joints { compliance_m_per_n: 0.2e-3, retardation_s: 8e-3 };
/// A muscle relaxes within this time, s.
const RELAX_S: f64 = 0.100;
/// A muscle that holds the key stiffens within this time, s. An estimate.
const STIFFENS_S: f64 = 0.010;
/// The time constant with which a muscle that holds the key brings its hand to rest, s: 14 N s/m for 0.2 kg. A heavier
/// hand includes more of the arm, with stronger muscles. An estimate.
pub const HOLDS_S: f64 = 1.0 / 70.0;
/// Acceleration with which a hand whose muscle pressed leaves the key, m/s2. An estimate: it is 5 mm away after 30 ms.
const LEAVING_M_PER_S2: f64 = 11.0;
/// Acceleration with which a hand lets the key go, m/s2: more than the 22 m/s2 with which a free key is home in 30 ms.
/// An estimate.
const LETTING_GO_M_PER_S2: f64 = 60.0;
/// Time within which the force vanishes in a letting-go, s.
const LETTING_GO_S: f64 = 2e-3;
/// Height above the key front's rest to which a hand on a path goes when it leaves, m.
const LEFT_M: f64 = 5e-3;

/// Action of a hand's muscle.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Muscle {
    /// A force that starts suddenly and stays constant.
    Steady {
        /// N.
        force_n: f64,
    },
    /// A force that rises from zero at a constant rate and then stays constant.
    Rises {
        /// Rate of the rise, N/s.
        rate_n_s: f64,
        /// Force at the end of the rise, N.
        height_n: f64,
    },
    /// A force that rises from zero by half a cosine and then stays constant.
    Swells {
        /// Force at the end of the rise, N.
        force_n: f64,
        /// Duration of the rise, s.
        within_s: f64,
    },
    /// Stiffness and damping that drive the hand down along the path of least jerk.
    Leads {
        /// End of the path, m below the key front's rest.
        depth_m: f64,
        /// Duration of the path, s.
        duration_s: f64,
    },
}

/// A touch: a hand and the action of its muscle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HandStroke {
    /// The hand.
    pub hand: Hand,
    /// Action of the muscle.
    pub muscle: Muscle,
    /// Relaxation of its force. `None`: none; the muscle of a hand that follows a path never relaxes.
    pub relaxes: Option<Relax>,
    /// Release of the key. `None`: the hand stays.
    pub leaves: Option<Leave>,
}

/// Hold of the key after the note.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Relax {
    /// When the force begins to relax, s: half a cosine of 0.1 s.
    pub at_s: f64,
    /// Final force, N.
    pub to_n: f64,
    /// Damping of the muscle, which stiffens within 10 ms from then on (half a cosine), N s/m: it slows down the hand
    /// whichever way it moves.
    pub damping_n_s_m: f64,
}

/// The release of the key.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Leave {
    /// Instant at which the hand begins to leave, s.
    pub at_s: f64,
    /// Time within which its force vanishes, s (half a cosine); a hand on a path goes up along the path of least jerk
    /// within twice this time.
    pub within_s: f64,
    /// Acceleration with which its muscle then lifts it, m/s2.
    pub lifts_m_per_s2: f64,
}

impl HandStroke {
    /// The pressed touch: a hand of this mass, kg, rests on the key, and its muscle's force rises to a force, N, within
    /// [`RISE_S`] by half a cosine.
    #[must_use]
    pub fn pressed(mass_kg: f64, force_n: f64) -> Self {
        let muscle = Muscle::Swells { force_n, within_s: RISE_S };
        HandStroke { hand: Hand { mass_kg, ..Hand::default() }, muscle, relaxes: None, leaves: None }
    }

    /// The struck touch: a hand of this mass, kg, arrives at the key with a speed, m/s, and its muscle presses by
    /// [`STRUCK_N_S_M`].
    #[must_use]
    pub fn struck(mass_kg: f64, speed_m_per_s: f64) -> Self {
        let hand = Hand { mass_kg, start_m_per_s: speed_m_per_s, joints: STRUCK_JOINTS, ..Hand::default() };
        HandStroke {
            hand,
            muscle: Muscle::Steady { force_n: STRUCK_N_S_M * speed_m_per_s },
            relaxes: None,
            leaves: None,
        }
    }

    /// A hand that rests on the key while its muscle's force rises at this rate, N/s, without end. The hand is
    /// [`Hand::default`].
    #[must_use]
    pub fn ramped(rate_n_s: f64) -> Self {
        let hand = Hand::default();
        HandStroke { hand, muscle: Muscle::Rises { rate_n_s, height_n: f64::INFINITY }, relaxes: None, leaves: None }
    }

    /// A hand that rests on the key and is driven down within this time, s. The hand is [`Hand::default`].
    #[must_use]
    pub fn led(duration_s: f64) -> Self {
        let muscle = Muscle::Leads { depth_m: LED_DEPTH_M, duration_s };
        HandStroke { hand: Hand::default(), muscle, relaxes: None, leaves: None }
    }

    /// This stroke, relaxing from this instant on, s, to a force that holds the key, N.
    #[must_use]
    pub fn relaxing(self, at_s: f64, to_n: f64) -> Self {
        HandStroke { relaxes: Some(Relax { at_s, to_n, damping_n_s_m: 0.0 }), ..self }
    }

    /// This stroke, relaxing from this instant on, s, to a force that holds the key, N, while the muscle stiffens, so
    /// that the hand comes to rest within [`HOLDS_S`].
    #[must_use]
    pub fn holding(self, at_s: f64, to_n: f64) -> Self {
        HandStroke { relaxes: Some(Relax { at_s, to_n, damping_n_s_m: self.hand.mass_kg / HOLDS_S }), ..self }
    }

    /// This stroke, leaving the key from this instant on, s; its force vanishes within this time, s.
    #[must_use]
    pub fn leaving(self, at_s: f64, within_s: f64) -> Self {
        HandStroke { leaves: Some(Leave { at_s, within_s, lifts_m_per_s2: LEAVING_M_PER_S2 }), ..self }
    }

    /// This stroke, letting the key go at this instant, s: its force is gone within 2 ms, and the hand leaves faster
    /// than the key comes up.
    #[must_use]
    pub fn letting_go(self, at_s: f64) -> Self {
        HandStroke { leaves: Some(Leave { at_s, within_s: LETTING_GO_S, lifts_m_per_s2: LETTING_GO_M_PER_S2 }), ..self }
    }

    /// Action of the muscle at an instant, s: a force, or a motion.
    #[must_use]
    pub fn input(&self, t: f64) -> Input {
        match self.muscle {
            Muscle::Steady { .. } | Muscle::Rises { .. } | Muscle::Swells { .. } => {
                let (force_n, damping_n_s_per_m) = (self.let_go(t), self.damping(t));
                if damping_n_s_per_m > 0.0 {
                    return Input::Hand(HandInput { force_n, damping_n_s_per_m, ..HandInput::default() });
                }
                Input::Force(force_n)
            }
            Muscle::Leads { depth_m, duration_s } => {
                let [x, v] = least_jerk(t / duration_s);
                let [up, up_v, back] = match self.leaves {
                    Some(Leave { at_s, within_s, .. }) => {
                        let [up, up_v] = least_jerk((t - at_s) / (2.0 * within_s));
                        [up, up_v, 2.0 * within_s]
                    }
                    None => [0.0, 0.0, 1.0],
                };
                let way = depth_m + LEFT_M;
                Input::Motion {
                    position_m: depth_m * x - way * up,
                    velocity_m_per_s: depth_m * v / duration_s - way * up_v / back,
                }
            }
        }
    }

    /// The muscle's force, N; as the hand leaves it falls by half a cosine, to what lifts the hand, and rises no
    /// further.
    fn let_go(&self, t: f64) -> f64 {
        let Some(Leave { at_s, within_s, lifts_m_per_s2 }) = self.leaves else { return self.relaxed(t) };
        let held = self.relaxed(t.min(at_s));
        held - half_a_cosine((t - at_s) / within_s) * (held + lifts_m_per_s2 * self.hand.mass_kg)
    }

    /// The muscle's force as long as the hand stays, N.
    fn relaxed(&self, t: f64) -> f64 {
        let rises = |t: f64| match self.muscle {
            Muscle::Steady { force_n } => force_n,
            Muscle::Rises { rate_n_s, height_n } => (rate_n_s * t).min(height_n),
            Muscle::Swells { force_n, within_s } => force_n * half_a_cosine(t / within_s),
            Muscle::Leads { .. } => 0.0,
        };
        match self.relaxes {
            Some(Relax { at_s, to_n, .. }) if t >= at_s => {
                let peak = rises(at_s);
                peak + (to_n - peak) * half_a_cosine((t - at_s) / RELAX_S)
            }
            _ => rises(t),
        }
    }

    /// The muscle's damping, N s/m.
    fn damping(&self, t: f64) -> f64 {
        let Some(Relax { at_s, damping_n_s_m, .. }) = self.relaxes else { return 0.0 };
        let left = self.leaves.map_or(0.0, |leave| half_a_cosine((t - leave.at_s) / leave.within_s));
        damping_n_s_m * half_a_cosine((t - at_s) / STIFFENS_S) * (1.0 - left)
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
        let swells = HandStroke::pressed(0.2, 4.0);
        assert!((force(&swells, 0.5 * RISE_S) - 2.0).abs() < 1e-12 && force(&swells, 1.0) == 4.0);
        assert_eq!(force(&swells, 0.0), 0.0);
        let pressed = HandStroke::ramped(100.0).leaving(0.1, 0.03);
        assert!((force(&pressed, 0.05) - 5.0).abs() < 1e-12 && (force(&pressed, 0.1) - 10.0).abs() < 1e-12);
        assert!((force(&pressed, 0.115) - 0.5 * (10.0 - 0.2 * LEAVING_M_PER_S2)).abs() < 1e-9);
        assert!((force(&pressed, 0.2) + 0.2 * LEAVING_M_PER_S2).abs() < 1e-12);
        let struck = HandStroke::struck(0.2, 0.5).relaxing(0.1, 2.0);
        assert!((force(&struck, 0.05) - 4.0).abs() < 1e-12 && (force(&struck, 0.15) - 3.0).abs() < 1e-12);
        assert!((force(&struck.leaving(0.3, 0.03), 0.3) - 2.0).abs() < 1e-12);
        let gone = struck.letting_go(0.3);
        assert!((force(&gone, 0.3) - 2.0).abs() < 1e-12);
        assert!((force(&gone, 0.302) + 0.2 * LETTING_GO_M_PER_S2).abs() < 1e-12);
        match HandStroke::led(0.2).leaving(0.5, 0.03).input(0.6) {
            Input::Motion { position_m, .. } => assert!((position_m + LEFT_M).abs() < 1e-12),
            other => panic!("{other:?}"),
        }
    }
}
