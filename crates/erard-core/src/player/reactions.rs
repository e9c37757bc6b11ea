//! Reactions of the pins in both components, and angular accelerations.
//!
//! The engine's coordinates are angles, so that no pin force appears in its equations. Newton's and Euler's laws give
//! them back, body by body from the leaves of the tree to the ground: with the acceleration of each centre of mass from
//! the step's velocities, and all other forces (felts, friction, weight, the finger) as they acted in the step, the
//! remainder of m a is the pin's force. This does not need the moments about the pins, which serve as a check:
//! [`Reactions::moment_n_m`] is the residual of Euler's law.

use moreau::vector::{add, cross, sub};

use super::Observer;
use super::motion::Motion;
use crate::grand::KEY_DOWN;
use crate::instrument::{Instrument, Vec2};
use crate::mechanism::Mechanism;

/// An observer of a running action. It needs the start and then every step.
///
/// With adaptive steps it observes both halves of every step. The second half arrives at velocities that
/// were combined with those of the whole step to a higher order: they differ from what its forces alone made of them by
/// no more than the tolerance, which is within the error of the accelerations that follow from them
/// ([`Reactions::moment_n_m`] shows how much).
#[derive(Debug, Clone)]
pub struct Reactions {
    instrument: Instrument,
    motion: Motion,
    pin_n: Vec<Vec2>,
    moment_n_m: Vec<f64>,
    /// Forces on each body except the pins', N, and their moments about its pin, N m.
    force: Vec<Vec2>,
    moment: Vec<f64>,
    /// Accelerations of the pins, m/s2.
    pivot_acceleration: Vec<Vec2>,
}

impl Reactions {
    /// Begins at an action that does not move. Its mechanism must keep its contacts
    /// ([`moreau_kernels::Stepping::keeps_contacts`]), as that of a run does.
    #[must_use]
    pub fn open(instrument: &Instrument, mechanism: &dyn Mechanism) -> Self {
        let count = instrument.bodies.len();
        let mut reactions = Reactions {
            instrument: instrument.clone().without_outlines(),
            motion: Motion::still(instrument, mechanism),
            pin_n: vec![[0.0; 2]; count],
            moment_n_m: vec![0.0; count],
            force: vec![[0.0; 2]; count],
            moment: vec![0.0; count],
            pivot_acceleration: vec![[0.0; 2]; count],
        };
        reactions.balance(mechanism);
        reactions
    }

    /// After every step. Does not allocate.
    pub fn observe(&mut self, mechanism: &dyn Mechanism) {
        self.motion.observe(&self.instrument, mechanism);
        self.balance(mechanism);
    }

    /// Force of each body's pin on the body in the last step, N, in the world frame (x to the back, y up): what its
    /// parent, or the ground, does to it.
    #[must_use]
    pub fn pin_n(&self) -> &[Vec2] {
        &self.pin_n
    }

    /// Mean absolute angular acceleration of each body over the last step, rad/s2, counter-clockwise.
    #[must_use]
    pub fn acceleration_rad_per_s2(&self) -> &[f64] {
        &self.motion.acceleration
    }

    /// The residual of Euler's law about each body's pin in the last step, N m: inertia less all moments, those of its
    /// riders' pins among them. Zero but for what the step's Newton iteration left and for the pose that its inertia
    /// was taken at.
    #[must_use]
    pub fn moment_n_m(&self) -> &[f64] {
        &self.moment_n_m
    }

    /// All forces except the pins', and the results that follow from them.
    fn balance(&mut self, m: &dyn Mechanism) {
        self.apply(m);
        let Reactions { instrument, motion, pin_n, moment_n_m, force, moment, pivot_acceleration } = self;
        let bodies = &instrument.bodies;
        for (i, body) in bodies.iter().enumerate() {
            pivot_acceleration[i] = body.parent.map_or([0.0; 2], |parent| {
                let arm = sub(motion.pivot(i), motion.pivot(parent));
                add(pivot_acceleration[parent], accelerated(motion, parent, arm))
            });
        }
        pin_n.fill([0.0; 2]);
        moment_n_m.fill(0.0);
        // Riders come after what they ride on.
        for (i, body) in bodies.iter().enumerate().rev() {
            let center = motion.turned(i, body.center_of_mass_m);
            let acceleration = add(pivot_acceleration[i], accelerated(motion, i, center));
            // So far the riders' pins, which push back.
            let riders = pin_n[i];
            pin_n[i] = [0, 1].map(|axis| body.mass_kg * acceleration[axis] - force[i][axis] + riders[axis]);
            let inertia =
                body.inertia_kg_m2 * motion.acceleration[i] + body.mass_kg * cross(center, pivot_acceleration[i]);
            moment_n_m[i] += inertia - moment[i];
            if let Some(parent) = body.parent {
                pin_n[parent] = add(pin_n[parent], pin_n[i]);
                moment_n_m[parent] += cross(sub(motion.pivot(i), motion.pivot(parent)), pin_n[i]);
            }
        }
    }

    /// Forces on the bodies and their moments about the bodies' pins.
    fn apply(&mut self, m: &dyn Mechanism) {
        let Reactions { instrument, motion, force, moment, .. } = self;
        let bodies = &instrument.bodies;
        for (i, body) in bodies.iter().enumerate() {
            force[i] = [0.0, -body.mass_kg * instrument.gravity_m_per_s2];
            moment[i] = cross(motion.turned(i, body.center_of_mass_m), force[i]);
        }
        let mut turn = |body: usize, torque: f64| {
            moment[body] += torque;
            if let Some(parent) = bodies[body].parent {
                moment[parent] -= torque;
            }
        };
        let relative = |values: &[f64], body: usize| values[body] - bodies[body].parent.map_or(0.0, |p| values[p]);
        for (i, body) in bodies.iter().enumerate() {
            turn(i, m.readout().pivot_friction[i] - body.viscous_n_m_s * relative(&motion.rate, i));
        }
        for spring in &instrument.springs {
            let drawn = |body: usize| bodies[body].angle_rad;
            let reference = drawn(spring.body) - bodies[spring.body].parent.map_or(0.0, drawn);
            let bent = relative(&motion.angle, spring.body) - reference;
            turn(spring.body, spring.torque_n_m - spring.stiffness_n_m_per_rad * bent);
        }
        let mut push = |body: Option<usize>, point: Vec2, by: Vec2| {
            if let Some(body) = body {
                force[body] = add(force[body], by);
                moment[body] += cross(sub(point, motion.pivot(body)), by);
            }
        };
        for ((zone, contact), tangential) in
            instrument.zones.iter().zip(m.readout().contacts).zip(m.readout().tangential_forces)
        {
            let Some(contact) = contact else { continue };
            let [nx, ny] = contact.normal;
            // The tangent is the normal turned clockwise by a quarter turn.
            let by = [contact.force * nx + tangential * ny, contact.force * ny - tangential * nx];
            push(zone.disc_body, contact.point, by);
            push(zone.curve_body, contact.point, by.map(|f| -f));
        }
        if let Some(key) = instrument.roles.key {
            let front = add(motion.pivot(key), motion.turned(key, instrument.roles.key_front_m));
            push(Some(key), front, KEY_DOWN.map(|d| d * m.readout().output.drive_n));
        }
    }
}

/// Acceleration of a point of a body against the body's own pivot, m/s2.
fn accelerated(motion: &Motion, body: usize, arm: Vec2) -> Vec2 {
    let (alpha, omega) = (motion.acceleration[body], motion.rate[body]);
    [-alpha * arm[1] - omega * omega * arm[0], alpha * arm[0] - omega * omega * arm[1]]
}

/// One pin's series, with the rows of the run that it was recorded beside; forces and accelerations are centred on the
/// rows' instants as a run's forces are.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PinSeries {
    /// The body's name.
    pub name: String,
    /// Angular acceleration of the body, rad/s2, counter-clockwise.
    pub acceleration_rad_per_s2: Vec<f64>,
    /// Force of the pin on the body toward the back of the piano, N.
    pub pin_x_n: Vec<f64>,
    /// Upward, N.
    pub pin_y_n: Vec<f64>,
}

/// Records pin reactions and accelerations during a run.
#[derive(Debug, Clone)]
pub struct ReactionRecorder {
    instrument: Instrument,
    reactions: Option<Reactions>,
    bodies: Vec<PinSeries>,
    /// The last row's forces are those of a step of this length, s, and wait for those of the step after it.
    pending: Option<f64>,
}

impl ReactionRecorder {
    /// A recorder for the pins of an instrument.
    #[must_use]
    pub fn new(instrument: &Instrument) -> Self {
        let series = |name: &String| PinSeries { name: name.clone(), ..PinSeries::default() };
        ReactionRecorder {
            instrument: instrument.clone().without_outlines(),
            reactions: None,
            bodies: instrument.bodies.iter().map(|body| series(&body.name)).collect(),
            pending: None,
        }
    }

    /// The series, body by body.
    #[must_use]
    pub fn into_series(self) -> Vec<PinSeries> {
        self.bodies
    }

    fn write(&mut self, row: bool, step_s: f64) {
        let Some(reactions) = &self.reactions else { return };
        // Forces belong to the middles of their steps: the mean, where the steps are equal.
        let share = self.pending.map(|before| before / (before + step_s));
        for ((series, [x, y]), acceleration) in
            self.bodies.iter_mut().zip(reactions.pin_n()).zip(reactions.acceleration_rad_per_s2())
        {
            let new = [*x, *y, *acceleration];
            let all = [&mut series.pin_x_n, &mut series.pin_y_n, &mut series.acceleration_rad_per_s2];
            for (values, new) in all.into_iter().zip(new) {
                if let Some((share, last)) = share.zip(values.last_mut()) {
                    *last = (1.0 - share) * *last + share * new;
                }
                if row {
                    values.push(new);
                }
            }
        }
        self.pending = row.then_some(step_s);
    }
}

impl Observer for ReactionRecorder {
    fn begin(&mut self, _: f64, mechanism: &dyn Mechanism) {
        self.reactions = Some(Reactions::open(&self.instrument, mechanism));
        self.write(true, mechanism.readout().last_step_s);
    }

    fn step(&mut self, _: f64, row: bool, mechanism: &dyn Mechanism) {
        if let Some(reactions) = &mut self.reactions {
            reactions.observe(mechanism);
        }
        self.write(row, mechanism.readout().last_step_s);
    }
}
