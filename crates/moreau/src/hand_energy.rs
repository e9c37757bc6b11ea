//! Energy balance of a hand: work of the muscle, and where it goes.

use crate::hand::SiteHand;
use crate::model::Model;
use crate::real::Scalar;
use crate::settings::Settings;
use crate::state::State;
use crate::workspace::Workspace;

/// Energy balance of a hand over one run: running totals, J. `muscle_work` equals the hand's kinetic energy gained,
/// plus the energy that its fingertip stores and loses, plus the work of the fingertip on the mechanism
/// ([`crate::Ledger::drive_work`]).
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct HandEnergy {
    /// Work of the muscle on the hand, signed.
    pub muscle_work: f64,
    /// Present kinetic energy of the hand minus that at the start.
    pub kinetic_gain: f64,
    /// Energy stored in the springs of fingertip and joints now; zero unless the finger pushes.
    pub fingertip_stored: f64,
    /// Energy lost in the dampers of fingertip and joints, less the energy that their law creates when they begin to
    /// push before they touch.
    pub fingertip_loss: f64,
    /// Work of the fingertip on the mechanism in the steps driven by a hand.
    pub work: f64,
}

impl HandEnergy {
    /// Returns the work of the muscle that the other terms do not account for, J. It falls with the step.
    pub fn residual(&self) -> f64 {
        self.muscle_work - self.kinetic_gain - self.fingertip_stored - self.fingertip_loss - self.work
    }

    /// Records one step driven by a hand. `hand_before`: the hand's position, m, and velocity, m/s, before the step;
    /// `velocity_before`: the absolute angular velocities before it, rad/s; `after` and `workspace`: state and
    /// workspace after it.
    #[allow(clippy::too_many_arguments)]
    pub fn record<T: Scalar, const B: usize, const Z: usize, const N: usize>(
        &mut self,
        model: &Model<T, B, Z>,
        settings: &Settings<T>,
        hand: &SiteHand<T>,
        hand_before: &[T; 2],
        velocity_before: &[T; B],
        after: &State<T, B, Z>,
        workspace: &Workspace<T, B, Z, N>,
    ) {
        let Some(site) = &model.site else { return };
        let (h, mean) = (settings.step.to_f64(), |u| settings.at_theta(u));
        let place = [hand_before[0].to_f64(), after.hand[0].to_f64()];
        let speed = [hand_before[1].to_f64(), after.hand[1].to_f64()];
        let [finger_stiffness, finger_damping] = hand.finger(site.stiffness, site.damping).map(T::to_f64);
        let [mass, muscle, stiffness, damping, toward, toward_speed, ..] = hand.numbers().map(T::to_f64);
        let muscle = muscle + stiffness * (toward - mean(place)) + damping * (toward_speed - mean(speed));
        self.muscle_work += muscle * mean(speed) * h;
        self.kinetic_gain += 0.5 * mass * (speed[1] * speed[1] - speed[0] * speed[0]);
        let joints = [velocity_before, &after.velocity].map(|v| model.tree.relative(v));
        let driven = workspace.drive_velocity(model, settings, &joints);
        let force = workspace.drive.force.to_f64();
        self.work += force * driven * h;
        let rate = mean(speed) - driven;
        let pressed = place[1] - model.site_position(&after.angle).to_f64();
        let held = |pressed: f64| 0.5 * finger_stiffness * pressed * pressed;
        if force > 0.0 {
            // The damper pushes from d v / k before the touch on, with the spring stretched: what that holds comes from
            // nowhere.
            let onset = if self.fingertip_stored > 0.0 { 0.0 } else { held(pressed - h * rate) };
            self.fingertip_loss += finger_damping * rate * rate * h - onset;
            self.fingertip_stored = held(pressed);
        } else {
            // What no longer pushes relaxes by itself.
            self.fingertip_loss += core::mem::take(&mut self.fingertip_stored);
        }
    }
}
