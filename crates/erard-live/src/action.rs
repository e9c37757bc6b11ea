//! The action of `erard` under a sensed key.

use erard::player::{HandInput, Joints};
use erard::{Action, Input, StepOutcome};
use moreau::SiteHand;

use crate::drive::Push;
use crate::sensed::{Stepped, Steps};

/// Number of samples by which a press may begin before its sensor leaves its rest.
pub const REMEMBERED: usize = 64;

impl Steps<f64> for Action {
    fn step(&mut self, push: &Push<f64>) -> Stepped<f64> {
        let reading = Action::step(self, input(push));
        Stepped {
            key_m: reading.key_m,
            hit: reading.impact.map(|impact| (impact.time_s - self.time_s(), impact.hammer_speed_m_per_s)),
            is_finite: reading.outcome != StepOutcome::NonFinite,
        }
    }

    fn is_asleep(&self) -> bool {
        Action::is_asleep(self)
    }

    fn hand(&self) -> [f64; 2] {
        let now = self.reading();
        [now.hand_m, now.hand_m_per_s]
    }

    fn lay_hand(&mut self) {
        let now = self.reading();
        self.place_hand(now.key_m, now.key_m_per_s);
    }
}

/// The action's input of a push.
pub(crate) fn input(push: &Push<f64>) -> Input {
    match *push {
        Push::Free => Input::Free,
        Push::Force(force_n) => Input::Force(force_n),
        Push::Rigid { position_m, velocity_m_per_s } => Input::Rigid { position_m, velocity_m_per_s },
        Push::Hand(SiteHand { mass, force, stiffness, damping, position, velocity, compliance, retardation }) => {
            Input::Hand(HandInput {
                mass_kg: mass,
                force_n: force,
                stiffness_n_per_m: stiffness,
                damping_n_s_per_m: damping,
                position_m: position,
                velocity_m_per_s: velocity,
                joints: Joints { compliance_m_per_n: compliance, retardation_s: retardation },
            })
        }
    }
}
