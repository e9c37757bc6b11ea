//! A step as it was taken, seen from outside: where bodies were at its theta point, how fast, and how they accelerated.

use crate::instrument::{Instrument, Vec2};
use crate::mechanism::Mechanism;

/// The last step of a mechanism, worked out from angles and velocities before and after it. Absolute angles, rad, and so on; world frame.
#[derive(Debug, Clone)]
pub(super) struct Motion {
    /// Length of the step, s.
    pub step_s: f64,
    /// Angular velocities before and after the step.
    pub velocity: [Vec<f64>; 2],
    /// Angles and angular velocities at the theta point, where the step's forces acted.
    pub angle: Vec<f64>,
    pub rate: Vec<f64>,
    /// Mean angular acceleration over the step, rad/s2.
    pub acceleration: Vec<f64>,
    /// Pivots at the theta point, m.
    pub pivot: Vec<Vec2>,
    /// Angles after the step.
    after: Vec<f64>,
}

impl Motion {
    /// Standing still where a mechanism is.
    pub fn still(instrument: &Instrument, m: &dyn Mechanism) -> Self {
        let count = instrument.bodies.len();
        let mut motion = Motion {
            step_s: m.readout().last_step_s,
            velocity: [vec![0.0; count], m.readout().velocities.to_vec()],
            angle: vec![0.0; count],
            rate: vec![0.0; count],
            acceleration: vec![0.0; count],
            pivot: vec![[0.0; 2]; count],
            after: m.readout().angles.to_vec(),
        };
        motion.velocity[0].copy_from_slice(m.readout().velocities);
        motion.place(instrument, 0.0);
        motion
    }

    /// After a step.
    pub fn observe(&mut self, instrument: &Instrument, m: &dyn Mechanism) {
        let theta = m.readout().stepping.settings.theta;
        self.step_s = m.readout().last_step_s;
        let [before, now] = &mut self.velocity;
        std::mem::swap(before, now);
        now.copy_from_slice(m.readout().velocities);
        self.place(instrument, theta);
        self.after.copy_from_slice(m.readout().angles);
    }

    /// Works out the theta point of the step from `after` (where the last one ended), whose velocities stand in `velocity`.
    fn place(&mut self, instrument: &Instrument, theta: f64) {
        let h = self.step_s;
        for i in 0..instrument.bodies.len() {
            let (v0, v1) = (self.velocity[0][i], self.velocity[1][i]);
            self.rate[i] = (1.0 - theta) * v0 + theta * v1;
            self.angle[i] = self.after[i] + theta * h * self.rate[i];
            self.acceleration[i] = (v1 - v0) / h;
        }
        for (i, body) in instrument.bodies.iter().enumerate() {
            self.pivot[i] = match body.parent {
                Some(parent) => add(self.pivot[parent], self.turned(parent, body.pivot_m)),
                None => body.pivot_m,
            };
        }
    }

    /// A direction of a body's frame, in the world.
    pub fn turned(&self, body: usize, [x, y]: Vec2) -> Vec2 {
        let (s, c) = libm::sincos(self.angle[body]);
        [c * x - s * y, s * x + c * y]
    }

    /// Velocity of a point of a body (`None`: of the ground) when the bodies turn at the given rates, m/s.
    pub fn velocity_at(&self, instrument: &Instrument, body: Option<usize>, point: Vec2, rate: &[f64]) -> Vec2 {
        let Some(body) = body else { return [0.0; 2] };
        let own = turning(rate[body], sub(point, self.pivot[body]));
        let carried = self.velocity_at(instrument, instrument.bodies[body].parent, self.pivot[body], rate);
        add(own, carried)
    }
}

pub(super) fn add(a: Vec2, b: Vec2) -> Vec2 {
    [a[0] + b[0], a[1] + b[1]]
}

pub(super) fn sub(a: Vec2, b: Vec2) -> Vec2 {
    [a[0] - b[0], a[1] - b[1]]
}

pub(super) fn dot(a: Vec2, b: Vec2) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

/// z component of a x b.
pub(super) fn cross(a: Vec2, b: Vec2) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

/// omega x r.
pub(super) fn turning(omega: f64, [x, y]: Vec2) -> Vec2 {
    [-omega * y, omega * x]
}
