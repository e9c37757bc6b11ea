//! Prediction of impacts: steps a copy of the key's state ahead.

use erard::{Action, Input};

/// Time after an announced instant from which on a missing impact counts as false, s.
const FALSE_AFTER_S: f64 = 5e-3;

/// A predicted impact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Foreseen {
    /// Time from now, s.
    pub in_s: f64,
    /// Total speed of the hammer at the impact, m/s.
    pub hammer_speed_m_per_s: f64,
}

/// An impact that was announced.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Announced {
    /// Predicted instant, s, and hammer speed, m/s.
    pub hit: [f64; 2],
    /// Instant of the prediction, s.
    pub known_s: f64,
}

impl Announced {
    /// Whether the impact has not happened and can no longer happen.
    #[must_use]
    pub fn is_false(&self, now_s: f64) -> bool {
        now_s > self.hit[0] + FALSE_AFTER_S
    }
}

/// Steps the action ahead for at most this time, s, under inputs by their number from 1, and then restores its state to
/// the bit. `None`: no impact is predicted.
pub(crate) fn look(action: &mut Action, most_s: f64, input: &mut dyn FnMut(u32, &Action) -> Input) -> Option<Foreseen> {
    let (state, now_s, h) = (action.mechanism_state(), action.time_s(), action.settings().step);
    let mut found = None;
    for n in 1..=(most_s / h) as u32 {
        let input = input(n, action);
        let reading = action.step(input);
        if let Some(impact) = reading.impact {
            found = Some(Foreseen { in_s: impact.time_s - now_s, hammer_speed_m_per_s: impact.hammer_speed_m_per_s });
            break;
        }
        if reading.hammer_rise_m_per_s <= 0.0 {
            break;
        }
    }
    // A state of this very action; its strings are rigid.
    let _ = action.restore_from(&state, &|_, _| 0);
    found
}
