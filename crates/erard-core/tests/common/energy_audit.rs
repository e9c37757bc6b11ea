//! An energy balance kept from outside: from nothing but the angles and velocities at the ends of steps, the friction
//! that acted, and the instrument's own numbers. It uses none of the engine's arithmetic; tests compare it with
//! [`moreau::Ledger`].

use erard::grand::KEY_DOWN;
use erard::instrument::{Curve, Felt, Instrument, Vec2};
use erard::mechanism::Mechanism;
use erard::player::rest::Rest;
use erard::player::{Drive, Observer};
use erard::trust::LEAST_TURNOVER_J;
use moreau::{Hereditary, Loss, MEMORY, SavedState, SiteInput};

/// A state of any size.
type State = SavedState<f64, 12, 32>;

/// A mechanism at the end of a step.
#[derive(Debug, Clone, Default)]
struct Moment {
    /// Of every body: cosine and sine, pivot in the world, m, its velocity, m/s, and the angular velocity, rad/s.
    bodies: Vec<Placement>,
    /// Of every zone: compression, m, and slip, m/s (0 where there is no friction or no touch).
    zones: Vec<[f64; 2]>,
    /// What every felt remembers ([`moreau::State::memory`]).
    memory: Vec<[f64; MEMORY]>,
    /// The driven point along its direction, m, and its speed, m/s.
    site: [f64; 2],
    /// The hand, m and m/s.
    hand: [f64; 2],
}

#[derive(Debug, Clone, Copy, Default)]
struct Placement {
    angle: f64,
    turn: Vec2,
    pivot: Vec2,
    pivot_velocity: Vec2,
    rate: f64,
}

impl Placement {
    /// What does not move.
    const GROUND: Self =
        Placement { angle: 0.0, turn: [1.0, 0.0], pivot: [0.0; 2], pivot_velocity: [0.0; 2], rate: 0.0 };

    /// A direction of the body's frame, in the world.
    fn turned(&self, [x, y]: Vec2) -> Vec2 {
        let [c, s] = self.turn;
        [c * x - s * y, s * x + c * y]
    }

    fn point(&self, point: Vec2) -> Vec2 {
        add(self.pivot, self.turned(point))
    }

    /// Velocity of what is fixed to the body at a place of the world.
    fn velocity(&self, at: Vec2) -> Vec2 {
        let [x, y] = sub(at, self.pivot);
        add(self.pivot_velocity, [-self.rate * y, self.rate * x])
    }
}

/// Where a function is looked at for its integral over a step, as shares of it: 1/2 -+ 1/(2 sqrt 3).
const GAUSS: [f64; 2] = [0.211_324_865_405_187_13, 0.788_675_134_594_812_9];

fn add(a: Vec2, b: Vec2) -> Vec2 {
    [a[0] + b[0], a[1] + b[1]]
}

fn sub(a: Vec2, b: Vec2) -> Vec2 {
    [a[0] - b[0], a[1] - b[1]]
}

fn dot(a: Vec2, b: Vec2) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

/// An observer that keeps the energy balance of a run.
pub struct EnergyAudit<'a> {
    instrument: &'a Instrument,
    drive: &'a Drive<'a>,
    rest: Option<Rest>,
    start_j: f64,
    work_j: f64,
    work_in_j: f64,
    /// Losses of every pin by dry and by viscous friction, J.
    pub pins_j: Vec<[f64; 2]>,
    /// Losses of every zone in its felt and by sliding, J.
    pub zones_j: Vec<[f64; 2]>,
    before: Moment,
    now: Moment,
}

impl Observer for EnergyAudit<'_> {
    fn begin(&mut self, _: f64, m: &dyn Mechanism) {
        let state = m.save().state;
        self.rest = Some(Rest::of(self.instrument, m));
        self.place(&state.angle, &state.velocity, &state.memory);
        self.start_j = self.stored_j();
        self.before = self.now.clone();
    }

    fn step(&mut self, time_s: f64, _: bool, m: &dyn Mechanism) {
        let (h, theta) = (m.readout().last_step_s, m.readout().stepping.settings.theta);
        // Of an imposed motion the force is asked for, not the velocity.
        let input = self.rest.unwrap().input(self.drive, time_s - h, h, theta, h, &|| 0.0);
        self.book(h, theta, &input, &m.save().state);
    }
}

impl<'a> EnergyAudit<'a> {
    /// Of a run with this drive.
    pub fn new(instrument: &'a Instrument, drive: &'a Drive<'a>) -> Self {
        EnergyAudit {
            instrument,
            drive,
            rest: None,
            start_j: 0.0,
            work_j: 0.0,
            work_in_j: 0.0,
            pins_j: vec![[0.0; 2]; instrument.bodies.len()],
            zones_j: vec![[0.0; 2]; instrument.zones.len()],
            before: Moment::default(),
            now: Moment::default(),
        }
    }

    /// Everything lost, J: in dry and viscous pins, in felts and by sliding.
    pub fn lost_j(&self) -> [f64; 4] {
        let sum = |of: &[[f64; 2]], k: usize| of.iter().map(|lost| lost[k]).sum::<f64>();
        [sum(&self.pins_j, 0), sum(&self.pins_j, 1), sum(&self.zones_j, 0), sum(&self.zones_j, 1)]
    }

    /// Books a step that ended in such a state, under an input of the engine's.
    fn book(&mut self, h: f64, theta: f64, input: &SiteInput<f64>, after: &State) {
        std::mem::swap(&mut self.before, &mut self.now);
        self.place(&after.angle, &after.velocity, &after.memory);
        self.now.hand = after.hand;
        let at_theta = |before: f64, after: f64| (1.0 - theta) * before + theta * after;
        let [place, speed] = [0, 1].map(|k| at_theta(self.before.site[k], self.now.site[k]));
        let finger = &self.instrument.finger;
        let force = match *input {
            SiteInput::Free => 0.0,
            SiteInput::Force(force) => force,
            SiteInput::Motion { position, velocity } => {
                let push = finger.stiffness_n_per_m * (position - place);
                (push + finger.damping_n_s_per_m * (velocity - speed)).max(0.0)
            }
            SiteInput::Rigid { .. } => after.rigid_force,
            // What the muscle does and the hand does not take is the fingertip's.
            SiteInput::Hand(hand) => {
                let [[x0, v0], [x1, v1]] = [self.before.hand, self.now.hand];
                let (x, v) = (at_theta(x0, x1), at_theta(v0, v1));
                hand.force + hand.stiffness * (hand.position - x) + hand.damping * (hand.velocity - v)
                    - hand.mass * (v1 - v0) / h
            }
        };
        let work = force * speed * h;
        self.work_j += work;
        self.work_in_j += work.max(0.0);
        for (i, body) in self.instrument.bodies.iter().enumerate() {
            let rate = |moment: &Moment| moment.bodies[i].rate - body.parent.map_or(0.0, |p| moment.bodies[p].rate);
            let [before, now] = [rate(&self.before), rate(&self.now)];
            let middle = at_theta(before, now);
            self.pins_j[i][0] += after.pivot_friction[i].abs() * path(before, now) * h;
            self.pins_j[i][1] += body.viscous_n_m_s * middle * middle * h;
        }
        for (z, zone) in self.instrument.zones.iter().enumerate() {
            let ([compression_before, slip_before], [compression, slip]) = (self.before.zones[z], self.now.zones[z]);
            let memory = [&self.before.memory[z], &self.now.memory[z]];
            self.zones_j[z][0] += lost_with_memory_j(&zone.felt, [compression_before, compression], memory);
            if compression_before.max(compression) > 0.0 && zone.felt.loss.viscous(1.0, 1.0) > 0.0 {
                let rate = (compression - compression_before) / h;
                // Two points of Gauss: a felt may begin or end to be touched within the step.
                for share in GAUSS {
                    let deep = compression_before + share * (compression - compression_before);
                    if deep > 0.0 {
                        let dry = 0.5 * memory.map(|memory| dry_n(&zone.felt, deep, memory)).iter().sum::<f64>();
                        self.zones_j[z][0] += 0.5 * loss_n(&zone.felt, deep, rate, dry) * rate * h;
                    }
                }
            }
            self.zones_j[z][1] += after.tangential[z].abs() * path(slip_before, slip) * h;
        }
    }

    /// The residual of the energy balance, as [`erard::trust::energy_residual`] does.
    pub fn residual(&self) -> f64 {
        let lost_j: f64 = self.lost_j().iter().sum();
        let left = self.stored_j() - self.start_j - self.work_j + lost_j;
        left.abs() / self.work_in_j.max(lost_j).max(LEAST_TURNOVER_J)
    }

    fn place(&mut self, angles: &[f64], velocities: &[f64], memory: &[[f64; MEMORY]]) {
        let Self { instrument, now, .. } = self;
        now.bodies.clear();
        now.memory.clear();
        now.memory.extend_from_slice(&memory[..instrument.zones.len()]);
        for (body, (&angle, &rate)) in instrument.bodies.iter().zip(angles.iter().zip(velocities)) {
            let parent = body.parent.map_or(Placement::GROUND, |parent| now.bodies[parent]);
            let (sin, cos) = libm::sincos(angle);
            let pivot = parent.point(body.pivot_m);
            let pivot_velocity = parent.velocity(pivot);
            now.bodies.push(Placement { angle, turn: [cos, sin], pivot, pivot_velocity, rate });
        }
        let on = |bodies: &[Placement], body: Option<usize>| body.map_or(Placement::GROUND, |body| bodies[body]);
        now.zones.clear();
        for zone in &instrument.zones {
            let (disc, curve) = (on(&now.bodies, zone.disc_body), on(&now.bodies, zone.curve_body));
            let center = disc.point(zone.disc_center_m);
            let (compression, normal, out) = touch(&zone.curve, &curve, center, zone.disc_radius_m);
            let slip = if zone.friction_coefficient > 0.0 && compression > -1e-3 {
                // The point of the curve under the disc's centre; the tangent is the normal turned clockwise.
                let at = sub(center, [normal[0] * out, normal[1] * out]);
                dot([normal[1], -normal[0]], sub(disc.velocity(at), curve.velocity(at)))
            } else {
                0.0
            };
            now.zones.push([compression, slip]);
        }
        now.site = instrument.roles.key.map_or([0.0; 2], |key| {
            let body = now.bodies[key];
            let at = body.point(instrument.roles.key_front_m);
            [dot(KEY_DOWN, at), dot(KEY_DOWN, body.velocity(at))]
        });
    }

    /// Energy stored now, J.
    fn stored_j(&self) -> f64 {
        let Self { instrument, now, .. } = self;
        let mut energy = 0.0;
        for (body, placed) in instrument.bodies.iter().zip(&now.bodies) {
            let center = placed.point(body.center_of_mass_m);
            let velocity = placed.velocity(center);
            let [x, y] = body.center_of_mass_m;
            let about_center = body.inertia_kg_m2 - body.mass_kg * (x * x + y * y);
            energy += 0.5 * body.mass_kg * dot(velocity, velocity) + 0.5 * about_center * placed.rate * placed.rate;
            energy += body.mass_kg * instrument.gravity_m_per_s2 * center[1];
        }
        for spring in &instrument.springs {
            let parent = instrument.bodies[spring.body].parent;
            let drawn =
                instrument.bodies[spring.body].angle_rad - parent.map_or(0.0, |p| instrument.bodies[p].angle_rad);
            let turned = now.bodies[spring.body].angle - parent.map_or(0.0, |p| now.bodies[p].angle) - drawn;
            energy += 0.5 * spring.stiffness_n_m_per_rad * turned * turned - spring.torque_n_m * turned;
        }
        for ((zone, [compression, _]), memory) in instrument.zones.iter().zip(&now.zones).zip(&now.memory) {
            energy += held_j(&zone.felt, *compression, memory);
            if *compression > 0.0 {
                let power = zone.felt.exponent + 1.0;
                energy += zone.felt.stiffness * libm::pow(*compression, power) / power;
            }
        }
        energy
    }
}

/// Compression, the normal out of the curve in the world, and how far the disc's centre is from the curve along it.
fn touch(curve: &Curve, body: &Placement, center: Vec2, radius: f64) -> (f64, Vec2, f64) {
    let around = |middle: Vec2, own: f64| {
        let [x, y] = sub(center, middle);
        let distance = (x * x + y * y).sqrt();
        let normal = if distance > 0.0 { [x / distance, y / distance] } else { [0.0, 1.0] };
        (radius + own - distance, normal, distance - own)
    };
    match *curve {
        Curve::Line { point_m, normal } => {
            let normal = body.turned(normal);
            let out = dot(normal, sub(center, body.point(point_m)));
            (radius - out, normal, out)
        }
        Curve::Segment { from_m, to_m, rounding_m } => {
            let (from, to) = (body.point(from_m), body.point(to_m));
            let along = sub(to, from);
            let share = (dot(along, sub(center, from)) / dot(along, along)).clamp(0.0, 1.0);
            around(add(from, [share * along[0], share * along[1]]), rounding_m)
        }
        Curve::Disc { center_m, radius_m } => around(body.point(center_m), radius_m),
    }
}

/// The part of a felt's force that is lost, N; what the clamp at zero leaves of it where the felt opens fast.
fn loss_n(felt: &Felt, compression: f64, rate: f64, dry: f64) -> f64 {
    let elastic = felt.stiffness * libm::pow(compression, felt.exponent);
    let loss = match felt.loss {
        Loss::HuntCrossley(law) => elastic * law.rate,
        Loss::Quadratic(law) => law.damping * compression * compression,
        Loss::Elastoplastic(law) => law.damping * compression * compression,
        Loss::Iwan(law) => law.damping * compression * compression,
        _ => 0.0,
    };
    (loss * rate).max(-elastic - dry)
}

/// x = g^m, m = (r + 1)/2.
fn x(felt: &Felt, compression: f64) -> f64 {
    libm::pow(compression.max(0.0), 0.5 * (felt.exponent + 1.0))
}

/// The constants of the springs in series with sliders, per x^2, and the stretch at which each gives, as a part of x.
fn sliders(felt: &Felt) -> Vec<[f64; 2]> {
    let spring = |eta: f64, slip: f64| [eta * felt.stiffness / (0.5 * (felt.exponent + 1.0) * slip), slip];
    match &felt.loss {
        Loss::Elastoplastic(law) => vec![spring(law.eta, law.slip)],
        Loss::Iwan(law) => [0.25, 0.5, 0.75, 1.0].map(|part| spring(0.25 * law.eta, part * law.slip)).to_vec(),
        _ => Vec::new(),
    }
}

/// The force of the sliders' springs, N.
fn dry_n(felt: &Felt, compression: f64, memory: &[f64; MEMORY]) -> f64 {
    let m = 0.5 * (felt.exponent + 1.0);
    let pull: f64 = sliders(felt).iter().zip(memory).map(|([spring, _], stretch)| spring * stretch).sum();
    pull * m * libm::pow(compression, m - 1.0)
}

/// Where a hereditary felt's own surface is, and the compression with which its memory would be at rest.
fn surface_and_rest(felt: &Felt, law: &Hereditary<f64>, memory: f64) -> [f64; 2] {
    let quick = felt.stiffness / (1.0 - law.relaxed);
    [quick, quick * law.relaxed].map(|k| libm::pow(memory / k, 1.0 / felt.exponent))
}

/// The energy that a felt's memory holds, J.
fn held_j(felt: &Felt, compression: f64, memory: &[f64; MEMORY]) -> f64 {
    match &felt.loss {
        Loss::Elastoplastic(_) | Loss::Iwan(_) => {
            sliders(felt).iter().zip(memory).map(|([spring, _], stretch)| 0.5 * spring * stretch * stretch).sum()
        }
        Loss::Hereditary(law) if felt.stiffness > 0.0 => {
            let memory = memory[0];
            let (quick, power) = (felt.stiffness / (1.0 - law.relaxed), felt.exponent + 1.0);
            let [surface, rest] = surface_and_rest(felt, law, memory);
            let g = compression.max(surface);
            let relaxing = law.relaxed * felt.exponent * quick * libm::pow(rest, power) / power;
            quick * libm::pow(g, power) / power - memory * g + relaxing
                - felt.stiffness * libm::pow(compression.max(0.0), power) / power
        }
        _ => 0.0,
    }
}

/// What a felt with memory has lost in a step, J, given compressions and memories before and after.
fn lost_with_memory_j(
    felt: &Felt,
    [compression_before, compression]: [f64; 2],
    [all_before, all_after]: [&[f64; MEMORY]; 2],
) -> f64 {
    let (before, after) = (all_before[0], all_after[0]);
    match &felt.loss {
        Loss::Elastoplastic(_) | Loss::Iwan(_) => {
            let way = x(felt, compression) - x(felt, compression_before);
            let each = sliders(felt).into_iter().zip(all_before.iter().zip(all_after));
            each.map(|([spring, slip], (before, after))| {
                // How far the slider went, and the mean of its force, which follows its bound.
                let slid = way - (after - before);
                let along = slip * slid.signum();
                let mean = after - 0.5 * along * slid / (1.0 - along);
                spring * mean.abs() * slid.abs()
            })
            .sum()
        }
        Loss::SetValued(_) => after * (compression.max(0.0) - compression_before.max(0.0)),
        // The force that relaxes times the way that the felt is behind.
        Loss::Hereditary(law) if felt.stiffness > 0.0 => {
            let behind = |compression: f64, memory: f64| {
                let [surface, rest] = surface_and_rest(felt, law, memory);
                compression.max(surface) - rest
            };
            0.5 * (behind(compression_before, before) + behind(compression, after)) * (after - before)
        }
        _ => 0.0,
    }
}

/// Mean of |u| over a step in which u runs linearly.
fn path(before: f64, now: f64) -> f64 {
    if before * now >= 0.0 {
        (before + now).abs() / 2.0
    } else {
        (before * before + now * now) / (2.0 * (before - now).abs())
    }
}
