//! Reference of travels, and conversion of inputs to the engine's.

pub(crate) use moreau::RIGID_CORRECTION;
use moreau::SiteInput;

use super::input::{self, Drive};
use crate::instrument::Instrument;
use crate::mechanism::Observation;

/// [`RIGID_CORRECTION`] of a rigid drive's position error is taken back in this time where steps are of any length, s.
pub(crate) const RIGID_CORRECTION_S: f64 = 50e-6;

/// Rest positions from which travels are measured, m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rest {
    /// World coordinate of the key front along its drive (down).
    pub site_m: f64,
    /// Height of the hammer's strike point.
    pub head_m: f64,
}

impl Rest {
    /// The present positions of a mechanism.
    pub fn of(instrument: &Instrument, m: &(impl Observation + ?Sized)) -> Self {
        let head_m =
            instrument.roles.hammer.map_or(0.0, |h| m.point(Some(h), instrument.roles.hammer_strike_point_m)[1]);
        Rest { site_m: m.site_position(), head_m }
    }

    /// The engine's input for the step from t0, each number at the instant that the engine expects. `correction_s`: in
    /// what time [`RIGID_CORRECTION`] of a rigid drive's position error is taken back; `site_m`: where the driven point
    /// is.
    pub fn input(
        &self,
        drive: &Drive<'_>,
        t0: f64,
        h: f64,
        theta: f64,
        correction_s: f64,
        site_m: &dyn Fn() -> f64,
    ) -> SiteInput<f64> {
        let input = drive(t0 + theta * h);
        self.engine_input(&input, || {
            let behind = self.site_m + drive(t0).position_m() - site_m();
            let velocity = match drive(t0 + h) {
                input::Input::Rigid { velocity_m_per_s, .. } => velocity_m_per_s,
                _ => 0.0,
            };
            velocity + RIGID_CORRECTION * behind / correction_s
        })
    }

    /// Velocity at a step's end with which the key front is imposed, m/s: its own, and what takes back little by little
    /// how far the key is behind where the last step sent it (`aimed_m`, which becomes this step's). `site_m`: where
    /// the driven point is now; `h`: the step, s.
    #[inline]
    pub(crate) fn imposed(
        &self,
        [position_m, velocity_m_per_s]: [f64; 2],
        aimed_m: &mut Option<f64>,
        site_m: f64,
        h: f64,
    ) -> f64 {
        let aimed = aimed_m.unwrap_or(position_m - velocity_m_per_s * h);
        let behind_m = self.site_m + aimed - site_m;
        *aimed_m = position_m.is_finite().then_some(position_m);
        velocity_m_per_s + RIGID_CORRECTION * behind_m / h
    }

    /// The engine's input: travels count from here. `imposed` gives the key's velocity at the step's end where the
    /// motion is rigid, m/s.
    #[inline]
    pub(crate) fn engine_input(&self, input: &input::Input, imposed: impl FnOnce() -> f64) -> SiteInput<f64> {
        match *input {
            input::Input::Free => SiteInput::Free,
            input::Input::Force(force_n) => SiteInput::Force(force_n),
            input::Input::Motion { position_m, velocity_m_per_s } => {
                SiteInput::Motion { position: self.site_m + position_m, velocity: velocity_m_per_s }
            }
            input::Input::Rigid { .. } => SiteInput::Rigid { velocity: imposed() },
            input::Input::Hand(ref hand) => hand.engine_input(self.site_m),
        }
    }
}
