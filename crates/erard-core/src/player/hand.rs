//! A hand behind the fingertip: a mass that muscle moves, at the end of a finger whose joints may yield.
//!
//! A prescribed force does not depend on the key's motion, and nothing stops a prescribed motion. A hand has inertia:
//! it arrives with speed, its force rises above its muscle's when the key stops it, and it may lift off. This is the
//! coupled pianist that \[T13\] names as future work. The engine solves hand and key in one step; [`moreau::SiteHand`]
//! has the equations.

use super::Input;

/// Joints of a finger, in series with the flesh of its fingertip, which is the instrument's `[finger]`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Joints {
    /// Compliance at the fingertip, m/N; 0 (the default) for stiff joints.
    pub compliance_m_per_n: f64,
    /// Retardation time, s: damping over stiffness. Without effect if the joints are stiff.
    pub retardation_s: f64,
}

impl Joints {
    /// Joints that do not yield: the flesh alone is the finger.
    pub const STIFF: Joints = Joints { compliance_m_per_n: 0.0, retardation_s: 0.0 };
}

/// A hand, as the fingertip feels it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hand {
    /// Effective mass at the fingertip, kg. An estimate: 0.1 to 0.3, the finger alone to the hand with a part of the
    /// forearm.
    pub mass_kg: f64,
    /// Stiffness with which muscle holds the hand on its way, N/m. Only where the stroke is a motion. An estimate.
    pub stiffness_n_per_m: f64,
    /// Damping of the muscle toward the stroke's velocity, N s/m. Only where the stroke is a motion. An estimate.
    pub damping_n_s_per_m: f64,
    /// Initial position of the fingertip, m below the key front's rest; negative in the air.
    pub start_m: f64,
    /// Its velocity then, m/s, down positive.
    pub start_m_per_s: f64,
    /// Joints of the finger.
    pub joints: Joints,
}

impl Default for Hand {
    /// 0.2 kg on the key, at rest; muscle of 1500 N/m and 14 N s/m, which damps the hand by 0.4 of the critical
    /// damping; stiff joints.
    fn default() -> Self {
        Hand {
            mass_kg: 0.2,
            stiffness_n_per_m: 1500.0,
            damping_n_s_per_m: 14.0,
            start_m: 0.0,
            start_m_per_s: 0.0,
            joints: Joints::STIFF,
        }
    }
}

impl Hand {
    /// The input of a step in which muscle does this: a force, a motion that stiffness and damping follow, nothing, or
    /// what a hand's input says, with this hand's mass and joints.
    /// Numbers belong to the step's theta point.
    ///
    /// # Errors
    /// [`HandError::Stroke`]: the muscle cannot impose a motion on the key.
    pub fn input(&self, muscle: &Input) -> Result<Input, HandError> {
        let Hand { mass_kg, stiffness_n_per_m, damping_n_s_per_m, joints, .. } = *self;
        let free = HandInput { mass_kg, joints, ..HandInput::default() };
        Ok(Input::Hand(match *muscle {
            Input::Free => free,
            Input::Force(force_n) => HandInput { force_n, ..free },
            Input::Motion { position_m, velocity_m_per_s } => {
                HandInput { stiffness_n_per_m, damping_n_s_per_m, position_m, velocity_m_per_s, ..free }
            }
            Input::Hand(muscle) => HandInput { mass_kg, joints, ..muscle },
            Input::Rigid { .. } => return Err(HandError::Stroke),
        }))
    }

    /// Checks the numbers; the error names the number, what was found and what is expected.
    ///
    /// # Errors
    /// The first number that is not sound.
    pub fn check(&self) -> Result<(), HandError> {
        let bad = |what, found: f64, from: f64, to: f64| HandError::Number { what, found, from, to };
        for (what, found, from, to) in [
            ("mass, kg", self.mass_kg, 1e-3, 1e2),
            ("stiffness of the muscle, N/m", self.stiffness_n_per_m, 0.0, 1e7),
            ("damping of the muscle, N s/m", self.damping_n_s_per_m, 0.0, 1e5),
            ("place, m", self.start_m, -1.0, 1.0),
            ("speed, m/s", self.start_m_per_s, -20.0, 20.0),
            ("compliance of the joints, m/N", self.joints.compliance_m_per_n, 0.0, 0.1),
            ("retardation time of the joints, s", self.joints.retardation_s, 0.0, 1.0),
        ] {
            if !(from..=to).contains(&found) {
                return Err(bad(what, found, from, to));
            }
        }
        Ok(())
    }
}

/// Why a hand cannot press.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum HandError {
    /// A number out of range.
    #[error("the hand's {what}, is {found}; expected a number from {from} to {to}")]
    Number {
        /// Quantity with its unit.
        what: &'static str,
        /// The value found.
        found: f64,
        /// The smallest.
        from: f64,
        /// The largest.
        to: f64,
    },
    /// The input of the muscle is neither a force nor a motion.
    #[error("a hand follows a force or a motion; found a motion imposed on the key")]
    Stroke,
}

/// A hand, and the input of its muscle in one step. Positions in m below the key front's rest; forces and
/// velocities positive downward. The numbers of the muscle belong to the step's theta point. [`Hand::input`] makes it
/// of a hand and the input of its muscle.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct HandInput {
    /// Effective mass at the fingertip, kg; above zero.
    pub mass_kg: f64,
    /// Force of the muscle, N.
    pub force_n: f64,
    /// Stiffness with which muscle holds the hand at `position_m`, N/m; 0 where it does not.
    pub stiffness_n_per_m: f64,
    /// Damping of the muscle toward `velocity_m_per_s`, N s/m.
    pub damping_n_s_per_m: f64,
    /// Position at which the muscle holds the hand, m.
    pub position_m: f64,
    /// The velocity that goes with it, m/s.
    pub velocity_m_per_s: f64,
    /// Joints of the finger.
    pub joints: Joints,
}

impl HandInput {
    /// The engine's, where positions count from a place of the world, m.
    #[inline]
    pub(crate) fn engine_input(&self, rest_m: f64) -> moreau::SiteInput<f64> {
        moreau::SiteInput::Hand(moreau::SiteHand {
            mass: self.mass_kg,
            force: self.force_n,
            stiffness: self.stiffness_n_per_m,
            damping: self.damping_n_s_per_m,
            position: rest_m + self.position_m,
            velocity: self.velocity_m_per_s,
            compliance: self.joints.compliance_m_per_n,
            retardation: self.joints.retardation_s,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Action, Instrument};
    use moreau::Settings;

    const H_S: f64 = 25e-6;

    /// A key on a spring, its front 0.2 m from its pivot, with a linear fingertip.
    const KEY: &str = r#"
        format = "erard-instrument/1"
        name = "A key"
        gravity_m_s2 = 0
        finger = { stiffness_N_per_m = 2e4, damping_N_s_per_m = 0 }
        roles = { key = "key", key_front_mm = [-200, 0] }
        [[body]]
        name = "key"
        pivot_mm = [0, 0]
        mass_g = 100
        inertia_kg_m2 = 2e-3
        center_of_mass_mm = [0, 0]
        [[spring]]
        name = "return"
        body = "key"
        torque_N_m = 0
        stiffness_N_m_per_rad = 400
    "#;

    /// The same, with the hand as a body: 0.2 kg at the end of an arm of five metres, pressed down by 0.6 N, on a felt
    /// of exponent 1.
    const WITH_A_BODY: &str = r#"
        [[body]]
        name = "hand"
        pivot_mm = [-5200, 0]
        mass_g = 200
        inertia_kg_m2 = 5.0
        center_of_mass_mm = [5000, 0]
        [[spring]]
        name = "muscle"
        body = "hand"
        torque_N_m = -3
        stiffness_N_m_per_rad = 0
        [[zone]]
        name = "fingertip"
        disc = { body = "hand", center_mm = [5000, 0] }
        line = { body = "key", point_mm = [-200, 0], normal = [0, 1] }
        felt = { stiffness_N_per_m_r = STIFFNESS, exponent = 1 }
    "#;

    fn pressed(hand: Hand, stroke: impl Fn(f64) -> Input, seconds: f64) -> (Vec<f64>, Vec<f64>, [f64; 2]) {
        pressed_in_steps(hand, stroke, seconds, H_S)
    }

    fn pressed_in_steps(
        hand: Hand,
        stroke: impl Fn(f64) -> Input,
        seconds: f64,
        h: f64,
    ) -> (Vec<f64>, Vec<f64>, [f64; 2]) {
        let key = Instrument::parse(KEY, "key").unwrap();
        let mut action = Action::as_drawn(&key, Settings::new(h)).unwrap();
        action.place_hand(hand.start_m, hand.start_m_per_s);
        let (mut key_m, mut finger_force_n) = (Vec::new(), Vec::new());
        for n in 0..(seconds / h).round() as usize {
            let reading = action.step(hand.input(&stroke((n as f64 + 0.5) * h)).unwrap());
            key_m.push(reading.key_m);
            finger_force_n.push(reading.finger_force_n);
        }
        let reading = action.reading();
        (key_m, finger_force_n, [reading.hand_m, reading.hand_m_per_s])
    }

    /// The hand that the step eliminates moves the key as one does that is a body of the mechanism: by a fingertip of
    /// 20 N/mm, and with joints of 5 N/mm behind it by 4 N/mm.
    #[test]
    fn it_is_a_body_of_its_own() {
        it_is_the_body(Joints::STIFF, "2e4");
        it_is_the_body(Joints { compliance_m_per_n: 0.2e-3, retardation_s: 0.0 }, "4e3");
    }

    fn it_is_the_body(joints: Joints, stiffness: &str) {
        let hand = Hand { joints, ..Hand::default() };
        let (key_m, finger_force_n, _) = pressed(hand, |_| Input::Force(0.6), 0.03);
        let with_a_body = WITH_A_BODY.replace("STIFFNESS", stiffness);
        let both = Instrument::parse(&format!("{KEY}{with_a_body}"), "both").unwrap();
        let mut action = Action::as_drawn(&both, Settings::new(H_S)).unwrap();
        let (mut largest_m, mut off_m, mut largest_n, mut off_n): (f64, f64, f64, f64) = (0.0, 0.0, 0.0, 0.0);
        for (a, force) in key_m.iter().zip(&finger_force_n) {
            let b = action.step(Input::Free).key_m;
            (largest_m, off_m) = (largest_m.max(b.abs()), off_m.max((a - b).abs()));
            let other = action.contact_force(0).unwrap();
            (largest_n, off_n) = (largest_n.max(other), off_n.max((force - other).abs()));
        }
        // The arc of five metres and the turning of the key's surface are what is left.
        assert!(largest_m > 1e-4 && off_m < 1e-5 * largest_m, "{off_m:.1e} of {largest_m:.1e} m");
        assert!(largest_n > 0.9 && off_n < 1e-5 * largest_n, "{off_n:.1e} of {largest_n:.1e} N");
    }

    /// A hand that has not met the key yet falls as its muscle says: m v' = F, exactly, and toward a target as a damped
    /// oscillator, to h^2.
    #[test]
    fn in_the_air_it_is_a_mass_on_muscle() {
        let hand = Hand { start_m: -0.5, start_m_per_s: 0.3, ..Hand::default() };
        let (_, finger_force_n, [x, v]) = pressed(hand, |_| Input::Force(1.5), 0.1);
        let (t, a) = (0.1, 1.5 / 0.2);
        assert!(finger_force_n.iter().all(|n| *n == 0.0));
        assert!((x - (-0.5 + 0.3 * t + 0.5 * a * t * t)).abs() < 1e-12 && (v - (0.3 + a * t)).abs() < 1e-12);

        let hand = Hand { start_m: -0.5, ..Hand::default() };
        let still = |_| Input::Motion { position_m: -0.4, velocity_m_per_s: 0.0 };
        let (_, _, [x, v]) = pressed(hand, still, 0.05);
        let (decay, own) = (14.0 / 0.4, 1500.0 / 0.2);
        let w = f64::sqrt(own - decay * decay);
        let (s, c) = (w * 0.05).sin_cos();
        let e = (-decay * 0.05_f64).exp();
        assert!((x - (-0.4 - 0.1 * e * (c + decay / w * s))).abs() < 1e-6, "{x}");
        assert!((v - 0.1 * e * own / w * s).abs() < 1e-4, "{v}");
    }

    /// Second order, as without a hand: while the fingertip stays on the key a quarter of the error is left when the
    /// step is halved.
    #[test]
    fn it_converges_with_the_square_of_the_step() {
        let at = |h: f64| {
            pressed_in_steps(Hand::default(), |t| Input::Force(6.0 * (60.0 * t).sin()), 0.005, h).0.pop().unwrap()
        };
        let truth = at(1e-6);
        let errors = [200e-6, 100e-6, 50e-6].map(|h| (at(h) - truth).abs());
        for pair in errors.windows(2) {
            assert!((3.8..4.2).contains(&(pair[0] / pair[1])), "{errors:?}");
        }
    }

    #[test]
    fn what_a_hand_cannot_do_is_said() {
        let hand = Hand::default();
        let rigid = Input::Rigid { position_m: 0.0, velocity_m_per_s: 0.0 };
        assert_eq!(hand.input(&rigid).unwrap_err(), HandError::Stroke);
        let heavy = HandInput { mass_kg: 9.0, force_n: 1.0, ..HandInput::default() };
        assert_eq!(hand.input(&Input::Hand(heavy)).unwrap(), Input::Hand(HandInput { mass_kg: 0.2, ..heavy }));
        let nothing = Hand { mass_kg: f64::NAN, ..hand };
        assert!(nothing.check().unwrap_err().to_string().contains("mass"));
        for (compliance_m_per_n, retardation_s) in [(-1e-3, 0.0), (0.0, -1.0), (f64::NAN, 0.0), (0.2, 0.0)] {
            let loose = Hand { joints: Joints { compliance_m_per_n, retardation_s }, ..hand };
            assert!(loose.check().unwrap_err().to_string().contains("of the joints"));
        }
    }
}
