//! A step in outputs: positions, velocities and accelerations of the bodies at its theta point.

use crate::instrument::{Instrument, Placement, Vec2};
use crate::mechanism::Mechanism;

/// The last step of a mechanism, worked out from angles and velocities before and after it. Absolute angles, rad, and
/// so on; world frame.
#[derive(Debug, Clone)]
pub(super) struct Motion {
    /// Length of the step, s.
    step_s: f64,
    /// Angular velocities before and after the step.
    velocity: [Vec<f64>; 2],
    /// Angles and angular velocities at the theta point, where the step's forces acted.
    pub angle: Vec<f64>,
    pub rate: Vec<f64>,
    /// Mean angular acceleration over the step, rad/s2.
    pub acceleration: Vec<f64>,
    /// The bodies at the theta point.
    placed: Vec<Placement>,
    /// Angles after the step.
    after: Vec<f64>,
}

impl Motion {
    /// Standing still where a mechanism is.
    pub(crate) fn still(instrument: &Instrument, m: &dyn Mechanism) -> Self {
        let count = instrument.bodies.len();
        let mut motion = Motion {
            step_s: m.readout().last_step_s,
            velocity: [m.readout().velocities.to_vec(), m.readout().velocities.to_vec()],
            angle: vec![0.0; count],
            rate: vec![0.0; count],
            acceleration: vec![0.0; count],
            placed: Vec::with_capacity(count),
            after: m.readout().angles.to_vec(),
        };
        motion.place(instrument, 0.0);
        motion
    }

    /// After a step.
    pub(crate) fn observe(&mut self, instrument: &Instrument, m: &dyn Mechanism) {
        let theta = m.readout().stepping.settings.theta;
        self.step_s = m.readout().last_step_s;
        let [before, now] = &mut self.velocity;
        std::mem::swap(before, now);
        now.copy_from_slice(m.readout().velocities);
        self.place(instrument, theta);
        self.after.copy_from_slice(m.readout().angles);
    }

    /// Works out the theta point of the step from `after` (where the last one ended), whose velocities stand in
    /// `velocity`.
    fn place(&mut self, instrument: &Instrument, theta: f64) {
        let h = self.step_s;
        for i in 0..instrument.bodies.len() {
            let (v0, v1) = (self.velocity[0][i], self.velocity[1][i]);
            self.rate[i] = (1.0 - theta) * v0 + theta * v1;
            self.angle[i] = self.after[i] + theta * h * self.rate[i];
            self.acceleration[i] = (v1 - v0) / h;
        }
        instrument.place(&self.angle, &mut self.placed);
    }

    /// A body's pivot, m.
    pub(crate) fn pivot(&self, body: usize) -> Vec2 {
        self.placed[body].pivot_m
    }

    /// A direction of a body's frame, in the world.
    pub(crate) fn turned(&self, body: usize, direction: Vec2) -> Vec2 {
        self.placed[body].direction_to_world(direction)
    }
}
