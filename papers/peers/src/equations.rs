//! Equations of motion in absolute angles, with friction regularised by tanh: a plain stiff ordinary differential
//! equation. Written from the exported mechanism alone; it shares no code with Erard's engine.
//!
//! A point of a body is the sum of one rotated arm per body of its chain (each pivot, then the point itself), so that
//! its velocity is the sum of v_a perp(arm_a) and its acceleration that of (dv_a/dt) perp(arm_a) - v_a^2 arm_a.
//! D'Alembert's principle on every centre of mass gives M dv/dt = Q.

use crate::mechanism::{Curve, Mechanism, Zone};
use crate::number::Number;

/// Whether the sizes match. A state has the bodies' angles, then their angular velocities: S is 2 B everywhere, which
/// the compiler cannot derive.
pub(crate) const fn is_size(bodies: usize, states: usize) -> bool {
    states == 2 * bodies
}

type Vector<T> = [T; 2];

/// Widths of tanh(u / width), which represents the set-valued sign.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Widths {
    /// Width at the pivots, rad/s.
    pub pivot: f64,
    /// Width at the sliding contacts, m/s.
    pub sliding: f64,
}

/// The mechanism, prepared for evaluation.
pub(crate) struct Equations<'a, const B: usize, const S: usize> {
    mechanism: &'a Mechanism,
    widths: Widths,
    parent: [Option<usize>; B],
    spring_torque: [f64; B],
    spring_stiffness: [f64; B],
}

/// Pose and velocities of the bodies.
struct Pose<T, const B: usize> {
    sin: [T; B],
    cos: [T; B],
    pivot: [Vector<T>; B],
    pivot_velocity: [Vector<T>; B],
    rate: [T; B],
}

fn dot<T: Number>(a: Vector<T>, b: Vector<T>) -> T {
    a[0] * b[0] + a[1] * b[1]
}

fn cross<T: Number>(a: Vector<T>, b: Vector<T>) -> T {
    a[0] * b[1] - a[1] * b[0]
}

fn add<T: Number>(a: Vector<T>, b: Vector<T>) -> Vector<T> {
    [a[0] + b[0], a[1] + b[1]]
}

fn sub<T: Number>(a: Vector<T>, b: Vector<T>) -> Vector<T> {
    [a[0] - b[0], a[1] - b[1]]
}

fn scale<T: Number>(a: Vector<T>, s: T) -> Vector<T> {
    [a[0] * s, a[1] * s]
}

fn fixed<T: Number>(a: [f64; 2]) -> Vector<T> {
    a.map(T::constant)
}

impl<T: Number, const B: usize> Pose<T, B> {
    #[inline(always)]
    fn of<const S: usize>(mechanism: &Mechanism, y: &[T; S]) -> Self {
        let o = [T::constant(0.0); 2];
        let zero = [T::constant(0.0); B];
        let mut pose = Pose { sin: zero, cos: zero, pivot: [o; B], pivot_velocity: [o; B], rate: zero };
        for (i, body) in mechanism.bodies.iter().enumerate() {
            (pose.sin[i], pose.cos[i]) = y[i].sin_cos();
            pose.rate[i] = y[B + i];
            pose.pivot[i] = pose.point(body.parent, body.pivot_m);
            pose.pivot_velocity[i] = pose.velocity(body.parent, pose.pivot[i]);
        }
        pose
    }

    /// Rotates a direction fixed in a body.
    #[inline(always)]
    fn turn(&self, body: Option<usize>, a: [f64; 2]) -> Vector<T> {
        body.map_or(fixed(a), |i| {
            let (s, c) = (self.sin[i], self.cos[i]);
            [c.times(a[0]) - s.times(a[1]), s.times(a[0]) + c.times(a[1])]
        })
    }

    /// Position of a point fixed in a body.
    #[inline(always)]
    fn point(&self, body: Option<usize>, a: [f64; 2]) -> Vector<T> {
        body.map_or(fixed(a), |i| add(self.pivot[i], self.turn(body, a)))
    }

    /// Velocity of the point of a body that is now at x.
    #[inline(always)]
    fn velocity(&self, body: Option<usize>, x: Vector<T>) -> Vector<T> {
        body.map_or(fixed([0.0; 2]), |i| {
            let [ax, ay] = sub(x, self.pivot[i]);
            let [ux, uy] = self.pivot_velocity[i];
            [ux - self.rate[i] * ay, uy + self.rate[i] * ax]
        })
    }
}

impl<'a, const B: usize, const S: usize> Equations<'a, B, S> {
    const SIZE: () = assert!(is_size(B, S), "a state is two numbers for every body");

    /// Makes the equations of a mechanism.
    pub(crate) fn new(mechanism: &'a Mechanism, widths: Widths) -> Self {
        let () = Self::SIZE;
        let (mut spring_torque, mut spring_stiffness) = ([0.0; B], [0.0; B]);
        for s in &mechanism.springs {
            spring_torque[s.body] += s.torque + s.stiffness * s.reference_rad;
            spring_stiffness[s.body] += s.stiffness;
        }
        let parent = std::array::from_fn(|i| mechanism.bodies[i].parent);
        Equations { mechanism, widths, parent, spring_torque, spring_stiffness }
    }

    /// Returns the state at rest.
    pub(crate) fn rest(&self) -> [f64; S] {
        std::array::from_fn(|i| self.mechanism.bodies.get(i).map_or(0.0, |b| b.rest_angle_rad))
    }

    /// dy/dt under a finger force, N.
    pub(crate) fn rates<T: Number>(&self, force: f64, y: &[T; S]) -> [T; S] {
        let pose = Pose::<_, B>::of(self.mechanism, y);
        let (mut mass, mut torque) = self.inertia(&pose);
        self.pivots(y, &mut torque);
        let finger = &self.mechanism.finger;
        let at = pose.point(Some(finger.body), finger.point_m);
        self.push(&pose, Some(finger.body), at, fixed(finger.direction.map(|d| force * d)), &mut torque);
        for zone in &self.mechanism.zones {
            self.felt(zone, &pose, &mut torque);
        }
        self.divide(&mut mass, &mut torque);
        std::array::from_fn(|i| if i < B { y[B + i] } else { torque[i - B] })
    }

    /// Returns the mass matrix (lower triangle), and the weights with the centrifugal terms of the arms.
    #[inline(always)]
    fn inertia<T: Number>(&self, pose: &Pose<T, B>) -> ([[T; B]; B], [T; B]) {
        let mut mass = [[T::constant(0.0); B]; B];
        let mut torque = [T::constant(0.0); B];
        for (i, body) in self.mechanism.bodies.iter().enumerate() {
            let [gx, gy] = body.center_of_mass_m;
            let about_center = body.inertia_kg_m2 - body.mass_kg * (gx * gx + gy * gy);
            mass[i][i] += T::constant(about_center);
            // Chain from the body down to the ground, and its arms.
            let mut chain = [(i, pose.turn(Some(i), body.center_of_mass_m)); B];
            let (mut length, mut child) = (1, i);
            while let Some(carrier) = self.parent[child] {
                chain[length] = (carrier, pose.turn(Some(carrier), self.mechanism.bodies[child].pivot_m));
                length += 1;
                child = carrier;
            }
            for (k, &(a, arm)) in chain[..length].iter().enumerate() {
                torque[a] -= arm[0].times(body.mass_kg * self.mechanism.gravity_m_s2);
                mass[a][a] += dot(arm, arm).times(body.mass_kg);
                for &(b, other) in &chain[k + 1..length] {
                    // a is further out than b.
                    mass[a][b] += dot(arm, other).times(body.mass_kg);
                    let turn = cross(arm, other).times(body.mass_kg);
                    torque[a] += turn * pose.rate[b] * pose.rate[b];
                    torque[b] -= turn * pose.rate[a] * pose.rate[a];
                }
            }
        }
        (mass, torque)
    }

    /// Adds springs and friction of the pivots.
    #[inline(always)]
    fn pivots<T: Number>(&self, y: &[T; S], torque: &mut [T; B]) {
        for (i, body) in self.mechanism.bodies.iter().enumerate() {
            let (mut angle, mut rate) = (y[i], y[B + i]);
            if let Some(p) = self.parent[i] {
                angle -= y[p];
                rate -= y[B + p];
            }
            let spring = T::constant(self.spring_torque[i]) - angle.times(self.spring_stiffness[i]);
            let dry = rate.times(1.0 / self.widths.pivot).tanh().times(body.dry_friction);
            let on_body = spring - dry - rate.times(body.viscous_friction);
            torque[i] += on_body;
            if let Some(p) = self.parent[i] {
                torque[p] -= on_body;
            }
        }
    }

    /// Adds a force at the point of a body that is now at x.
    #[inline(always)]
    fn push<T: Number>(
        &self,
        pose: &Pose<T, B>,
        body: Option<usize>,
        x: Vector<T>,
        force: Vector<T>,
        torque: &mut [T; B],
    ) {
        let (mut body, mut tip) = (body, x);
        while let Some(i) = body {
            torque[i] += cross(sub(tip, pose.pivot[i]), force);
            tip = pose.pivot[i];
            body = self.parent[i];
        }
    }

    /// Returns the distance from a zone's disc to its curve, the curve's normal there and the disc's centre.
    #[inline(always)]
    fn distance<T: Number>(zone: &Zone, pose: &Pose<T, B>) -> (T, Vector<T>, Vector<T>) {
        let center = pose.point(zone.disc.body, zone.disc.center_m);
        let to_point = |on: Vector<T>, radius: f64| {
            let away = sub(center, on);
            let distance = dot(away, away).sqrt();
            (distance - T::constant(radius), [away[0] / distance, away[1] / distance])
        };
        let (distance, normal) = match zone.curve {
            Curve::Line { point_m, normal } => {
                let normal = pose.turn(zone.curve_body, normal);
                (dot(sub(center, pose.point(zone.curve_body, point_m)), normal), normal)
            }
            Curve::Segment { from_m, to_m, rounding_m } => {
                let from = pose.point(zone.curve_body, from_m);
                let along = pose.turn(zone.curve_body, [to_m[0] - from_m[0], to_m[1] - from_m[1]]);
                let share = dot(sub(center, from), along) / dot(along, along);
                let share = match share.value() {
                    s if s <= 0.0 => T::constant(0.0),
                    s if s >= 1.0 => T::constant(1.0),
                    _ => share,
                };
                to_point(add(from, scale(along, share)), rounding_m)
            }
            Curve::Disc { center_m, radius_m } => to_point(pose.point(zone.curve_body, center_m), radius_m),
        };
        (distance, normal, center)
    }

    /// Adds one felt, with Coulomb friction.
    #[inline(always)]
    fn felt<T: Number>(&self, zone: &Zone, pose: &Pose<T, B>, torque: &mut [T; B]) {
        let (distance, normal, center) = Self::distance(zone, pose);
        let compression = T::constant(zone.disc.radius_m) - distance;
        if compression.value() <= 0.0 {
            return;
        }
        let closing = |x| dot(normal, sub(pose.velocity(zone.curve_body, x), pose.velocity(zone.disc.body, x)));
        let square = compression * compression;
        let elastic = match zone.felt.exponent {
            2.0 => square,
            2.5 => square * compression.sqrt(),
            3.0 => square * compression,
            r => compression.powf(r),
        };
        let pressure = elastic.times(zone.felt.stiffness) + square.times(zone.felt.damping) * closing(center);
        if pressure.value() <= 0.0 {
            return;
        }
        let at = sub(center, scale(normal, distance));
        let mut force = scale(normal, pressure);
        if zone.friction_coefficient > 0.0 {
            let tangent = [normal[1], -normal[0]];
            let slip = dot(tangent, sub(pose.velocity(zone.disc.body, at), pose.velocity(zone.curve_body, at)));
            let drag = slip.times(1.0 / self.widths.sliding).tanh() * pressure.times(-zone.friction_coefficient);
            force = add(force, scale(tangent, drag));
        }
        self.push(pose, zone.disc.body, at, force, torque);
        self.push(pose, zone.curve_body, at, [-force[0], -force[1]], torque);
    }

    /// torque <- M^-1 torque, by the factorisation L^T D L without fill-in outside the tree (Featherstone, 2005).
    #[inline(always)]
    fn divide<T: Number>(&self, mass: &mut [[T; B]; B], torque: &mut [T; B]) {
        for k in (0..B).rev() {
            let mut up = self.parent[k];
            while let Some(i) = up {
                let share = mass[k][i] / mass[k][k];
                let mut further = Some(i);
                while let Some(j) = further {
                    let product = share * mass[k][j];
                    mass[i][j] -= product;
                    further = self.parent[j];
                }
                mass[k][i] = share;
                up = self.parent[i];
            }
        }
        for k in (0..B).rev() {
            let mut up = self.parent[k];
            while let Some(i) = up {
                let product = mass[k][i] * torque[k];
                torque[i] -= product;
                up = self.parent[i];
            }
        }
        for k in 0..B {
            torque[k] = torque[k] / mass[k][k];
            let mut up = self.parent[k];
            while let Some(i) = up {
                let product = mass[k][i] * torque[i];
                torque[k] -= product;
                up = self.parent[i];
            }
        }
    }

    /// Distance of the strike point beyond its contact with the string, m.
    pub(crate) fn beyond_string(&self, y: &[f64; S]) -> f64 {
        let strike = &self.mechanism.strike;
        let at = Pose::<_, B>::of(self.mechanism, y).point(Some(strike.body), strike.point_m);
        dot(at, strike.direction) - strike.meets_m
    }

    /// Speed of the strike point, m/s.
    pub(crate) fn hammer_speed(&self, y: &[f64; S]) -> f64 {
        let (strike, pose) = (&self.mechanism.strike, Pose::<_, B>::of(self.mechanism, y));
        let [x, y] = pose.velocity(Some(strike.body), pose.point(Some(strike.body), strike.point_m));
        x.hypot(y)
    }
}

#[cfg(test)]
mod tests;
