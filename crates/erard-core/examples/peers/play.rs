//! The strokes that are played, and the engine playing them.

use std::time::Instant;

use erard_core::assembly;
use erard_core::instrument::{Curve, Instrument};
use erard_core::stroke::{Cursor, ForceSeries, Series, Touch};
use moreau::{
    Accuracy, Controller, Model, Settings, SiteInput, State, StepDoubling, StepOutcome, Workspace, controlled_step,
    step,
};
use moreau_kernels::Lanes;
use moreau_kernels::{OwnedDescription, Saved, SideBySide, Size, Stepping, side_by_side};

/// The stroke whose hammer speed is compared is the mf, pressed, that belongs to the instrument, its force times each
/// of these: a single blow may be met by luck, a row of them is not.
pub const SCALES: [f64; 9] = [0.88, 0.91, 0.94, 0.97, 1.0, 1.03, 1.06, 1.09, 1.12];
/// All of them have struck, and left the string again or nearly, at this instant, s: of the rigid grand's stroke, and
/// of a hand's on one that bends.
const BLOW_S: [f64; 2] = [0.06, 0.09];
/// The note that is held: a constant force, N, looked at from one instant to another, s.
pub const HOLD_N: f64 = 12.0;
pub const HOLD_S: [f64; 2] = [1.0, 10.0];

/// An instrument at rest, ready to be played, in the engine of its size.
pub struct Action<const B: usize, const Z: usize, const N: usize> {
    pub instrument: Instrument,
    /// Absolute angles at rest, rad.
    pub rest: Vec<f64>,
    /// The mf stroke, and how long it is simulated, s.
    pub stroke: ForceSeries,
    pub press_s: f64,
    pub strike: Strike,
    links: Vec<Link>,
    description: OwnedDescription,
    model: Model<f64, B, Z>,
}

/// The point of the hammer that meets the string.
#[derive(Debug, Clone, Copy)]
pub struct Strike {
    pub body: usize,
    /// In the body's frame.
    pub point_m: [f64; 2],
    /// Toward the string, in the world, of length 1.
    pub direction: [f64; 2],
    /// The point's coordinate in that direction when it meets the string, m.
    pub meets_m: f64,
    /// The hammer's centre pin's coordinate in that direction, m.
    pin_m: f64,
    /// The point's distance from the pin, m.
    pub radius_m: f64,
}

impl Strike {
    /// Coordinate of the point in the string's direction, its rate, m/s, and the point's speed, m/s.
    #[inline(always)]
    fn now(&self, links: &[Link], angle: &[f64], velocity: &[f64]) -> [f64; 3] {
        // A point of a chain is the sum of one turned arm for each of its bodies.
        let [mut along, mut x, mut y] = [self.pin_m, 0.0, 0.0];
        for link in links {
            let (sin, cos) = angle[link.body].sin_cos();
            let [ax, ay] = [cos * link.arm_m[0] - sin * link.arm_m[1], sin * link.arm_m[0] + cos * link.arm_m[1]];
            along += ax * self.direction[0] + ay * self.direction[1];
            x -= velocity[link.body] * ay;
            y += velocity[link.body] * ax;
        }
        [along, x * self.direction[0] + y * self.direction[1], x.hypot(y)]
    }
}

/// A body of the chain that carries the strike point, and its arm: to the next one's pivot, at last to the point.
#[derive(Debug, Clone, Copy)]
pub struct Link {
    body: usize,
    arm_m: [f64; 2],
}

/// Instruments side by side in the processor's lanes.
pub type Together = Box<dyn SideBySide>;

/// One timed run.
pub struct Played {
    /// Speed of the strike point at the string, m/s, and the instant, s.
    pub strike: Option<[f64; 2]>,
    /// The striking body's angle at the asked instants, rad.
    pub angles_rad: Vec<f64>,
    pub seconds: f64,
    pub steps: u64,
}

/// A blow in steps of any lengths.
#[derive(Debug, Clone, Copy, Default)]
pub struct Walked {
    /// Speed of the strike point at the string, m/s, and the instant, s.
    pub strike: Option<[f64; 2]>,
    pub seconds: f64,
    pub steps: u64,
    /// Newton iterations and active sets of all steps.
    pub newton: u64,
    pub sets: u64,
}

/// How long steps are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Steps {
    /// All as long, s.
    Fixed(f64),
    /// The same, with Newton's tolerance loosened to [`LOOSE`].
    Loose(f64),
    /// The same, but for those that would change no bit.
    FixedOrRest(f64),
    /// As long as an error allows.
    Controlled(f64),
}

impl Steps {
    /// The engine's settings; adaptive steps begin with the longest.
    pub fn settings(self) -> Settings<f64> {
        match self {
            Steps::Fixed(h) | Steps::FixedOrRest(h) => Settings::new(h),
            Steps::Loose(h) => loose(h),
            Steps::Controlled(_) => Settings::new(MAX_STEP_S),
        }
    }
}

/// A tolerance of Newton's method that moves the errors of long steps by less than a twentieth (`steps` shows it), and
/// saves them a quarter of their iterations. The engine's usual one is 1e-5.
pub const LOOSE: f64 = 1e-2;

/// Settings of steps of h seconds with that tolerance.
pub fn loose(h: f64) -> Settings<f64> {
    Settings { tolerance: LOOSE, ..Settings::new(h) }
}

/// Limits of adaptive steps and their first attempt, s.
const SMALLEST_STEP_S: f64 = 1e-8;
const MAX_STEP_S: f64 = 1e-3;
const FIRST_STEP_S: f64 = 50e-6;

/// Newton iterations for the instant at which the string is met: a flight within a step is almost straight.
const NEWTON: usize = 4;

/// How a speed changes, at the end of a step: found from two steps, of second order.
#[derive(Debug, Clone, Copy, Default)]
struct Rate {
    /// Mean over the last step, m/s2.
    mean: f64,
    /// At its end, m/s2.
    now: f64,
    /// Its own rate, m/s3.
    jerk: f64,
}

impl Rate {
    /// After a step over which its mean was `mean`; `steps_s` are the step before and this one.
    #[inline(always)]
    fn next(&self, mean: f64, steps_s: [f64; 2]) -> Rate {
        let jerk = (mean - self.mean) * 2.0 / (steps_s[0] + steps_s[1]);
        Rate { mean, now: mean + 0.5 * steps_s[1] * jerk, jerk }
    }

    /// The speed `t` later, that is `speed` now.
    fn after(&self, speed: f64, t: f64) -> f64 {
        speed + t * (self.now + 0.5 * t * self.jerk)
    }

    /// Its mean until then.
    fn mean(&self, speed: f64, t: f64) -> f64 {
        speed + t * (0.5 * self.now + t * self.jerk / 6.0)
    }
}

/// Looks out for the blow and for the instants at which the angle is asked for.
struct Watch<'a> {
    strike: Strike,
    links: &'a [Link],
    found: Option<[f64; 2]>,
    /// What the strike point does now: [`Strike::now`].
    now: [f64; 3],
    /// Rates of the last two of these, now: m/s2, and their own rates over the last two steps, m/s3.
    rates: [Rate; 2],
    /// The last step, s.
    step_s: f64,
    /// Angle and angular velocity of what strikes, now.
    turn: [f64; 2],
    instants: &'a [f64],
    angles_rad: Vec<f64>,
}

impl<'a> Watch<'a> {
    /// From a start at rest.
    fn new<const B: usize>(strike: Strike, links: &'a [Link], angles: &[f64; B], instants: &'a [f64]) -> Self {
        let angles_rad = Vec::with_capacity(instants.len());
        let (now, turn) = (strike.now(links, angles, &[0.0; B]), [angles[strike.body], 0.0]);
        Watch { strike, links, found: None, now, rates: [Rate::default(); 2], step_s: 0.0, turn, instants, angles_rad }
    }

    /// A step of h from t on has been taken. Within it the angle is the cubic through angles and velocities at both
    /// ends; but the string is met as if the flight went on as in the two steps before: at the step's end the string
    /// has pushed already. Both speeds are continued, for the head turns in its flight: at 2 m/s and a radius of 0.13 m
    /// by 15 rad/s, which changes their ratio by a thousandth in 200 us.
    #[inline(always)]
    fn look(&mut self, t: f64, h: f64, angle: &[f64], velocity: &[f64]) {
        let (before, now) = (self.now, self.strike.now(self.links, angle, velocity));
        let meets_m = self.strike.meets_m;
        if self.found.is_none() && before[0] <= meets_m && now[0] > meets_m {
            let ([along, speed], left_m) = (self.rates, meets_m - before[0]);
            let mut flight_s = left_m / before[1];
            for _ in 0..NEWTON {
                let missed_m = flight_s * along.mean(before[1], flight_s) - left_m;
                flight_s -= missed_m / along.after(before[1], flight_s);
            }
            self.found = Some([speed.after(before[2], flight_s), t + flight_s]);
        }
        let ([q0, v0], [q1, v1]) = (self.turn, [angle[self.strike.body], velocity[self.strike.body]]);
        let at = |s: f64| {
            let (a, b) = (v0 * h - (q1 - q0), (q1 - q0) - v1 * h);
            q0 + s * (q1 - q0) + s * (1.0 - s) * ((1.0 - s) * a + s * b)
        };
        while let Some(&instant) = self.instants.get(self.angles_rad.len()).filter(|&&instant| instant <= t + h) {
            self.angles_rad.push(at((instant - t) / h));
        }
        for (rate, k) in self.rates.iter_mut().zip([1, 2]) {
            *rate = rate.next((now[k] - before[k]) / h, [self.step_s, h]);
        }
        (self.now, self.step_s, self.turn) = (now, h, [q1, v1]);
    }
}

impl<const B: usize, const Z: usize, const N: usize> Action<B, Z, N> {
    /// Lets the instrument come to rest.
    pub fn new(instrument: Instrument) -> Result<Self, Box<dyn std::error::Error>> {
        let rest = erard_core::Action::new(&instrument)?.angles().to_vec();
        let bends = instrument.has_bends();
        let mf = if bends { Series::builtin("mf", Touch::Pressed) } else { Series::rigid("mf", Touch::Pressed) };
        let stroke = mf.and_then(|s| s.force).ok_or("the mf stroke is not built in")?;
        let press_s = BLOW_S[usize::from(bends)];
        let (strike, links) = strike(&instrument)?;
        let (description, model) = (assembly::describe(&instrument), assembly::assemble(&instrument)?);
        Ok(Action { instrument, rest, stroke, press_s, strike, links, description, model })
    }

    /// Plays from rest to the last of `instants`, the engine only, in the given steps.
    pub fn play(&self, steps: Steps, force: impl Fn(f64) -> f64, instants: &[f64]) -> Played {
        let end = instants.last().copied().unwrap_or(0.0);
        let theta = Settings::<f64>::new(1e-3).theta;
        let input = |t: f64, h: f64| SiteInput::Force(force(t + theta * h));
        let mut start = Instant::now();
        let mut state = State::at_rest(std::array::from_fn(|i| self.rest[i]));
        let mut watch = Watch::new(self.strike, &self.links, &state.angle, instants);
        let (mut taken, settings) = (0, steps.settings());
        match steps {
            Steps::Fixed(h) | Steps::FixedOrRest(h) | Steps::Loose(h) => {
                let rests = matches!(steps, Steps::FixedOrRest(_));
                // The step that everybody has, compiled in `moreau-kernels`; assembled before the clock starts, as in a
                // batch.
                let none = moreau_kernels::Probes::default();
                let mut engine = moreau_kernels::mechanism(&self.description, &none, settings, None)
                    .expect("the model was assembled before");
                engine.restore(&Saved { state: state.save().sized(), ..engine.save() });
                engine.configure(Stepping { may_rest: rests, ..*engine.readout().stepping });
                start = Instant::now();
                for n in 0..(end / h).ceil() as u64 {
                    let t = n as f64 * h;
                    let report = engine.step(&input(t, h)).report;
                    assert_ne!(report.outcome, StepOutcome::NonFinite, "at {t} s");
                    let now = engine.readout();
                    watch.look(t, h, now.angles, now.velocities);
                    taken += 1;
                }
                state.angle.copy_from_slice(&engine.readout().angles[..B]);
            }
            Steps::Controlled(tolerance) => {
                let accuracy = Accuracy::new(tolerance, SMALLEST_STEP_S, MAX_STEP_S);
                let mut controller = Controller::<f64, Z>::new(FIRST_STEP_S);
                let mut halves = StepDoubling::<f64, B, Z, N>::new(&settings);
                let mut t = 0.0;
                while t < end - SMALLEST_STEP_S {
                    let drive = |from: f64, h: f64, _: &State<f64, B, Z>| input(t + from, h);
                    let (model, limit) = (&self.model, end - t);
                    let did = controlled_step(
                        model,
                        &settings,
                        &accuracy,
                        &mut controller,
                        limit,
                        drive,
                        &mut state,
                        &mut halves,
                    );
                    assert_ne!(did.outcome, StepOutcome::NonFinite, "at {t} s");
                    watch.look(t, did.step, &state.angle, &state.velocity);
                    t += did.step;
                    taken += u64::from(did.inner);
                }
            }
        }
        let Watch { found, mut angles_rad, .. } = watch;
        if angles_rad.len() < instants.len() {
            angles_rad.push(state.angle[self.strike.body]);
        }
        Played { strike: found, angles_rad, seconds: start.elapsed().as_secs_f64(), steps: taken }
    }

    /// Plays a blow in steps whose lengths `length` gives, from the instant of each, the length of the one before, s,
    /// and how far its velocities were from their prediction: the largest difference, as a part of 1 rad/s +
    /// |velocity|.
    pub fn play_in(
        &self,
        settings: &Settings<f64>,
        scale: f64,
        length: &mut dyn FnMut(f64, f64, f64) -> f64,
    ) -> Walked {
        let force = self.force(scale);
        let start = Instant::now();
        let mut state = State::at_rest(std::array::from_fn(|i| self.rest[i]));
        let mut watch = Watch::new(self.strike, &self.links, &state.angle, &[]);
        let mut workspace = Workspace::<f64, B, Z, N>::new();
        let (mut walked, mut t, mut before, mut missed) = (Walked::default(), 0.0, 0.0, 0.0);
        while t < self.press_s {
            let h = length(t, before, missed).min(self.press_s - t).max(SMALLEST_STEP_S);
            if before > 0.0 && before != h {
                state.increment.iter_mut().for_each(|increment| *increment *= h / before);
            }
            let settings = Settings { step: h, ..*settings };
            let predicted = state.increment;
            let input = SiteInput::Force(force(t + settings.theta * h));
            let did = step(&self.model, &settings, &input, &mut state, &mut workspace);
            assert_ne!(did.outcome, StepOutcome::NonFinite, "at {t} s");
            watch.look(t, h, &state.angle, &state.velocity);
            missed = (0..B)
                .map(|i| (state.increment[i] - predicted[i]).abs() / (1.0 + state.velocity[i].abs()))
                .fold(0.0, f64::max);
            (t, before) = (t + h, h);
            walked.steps += 1;
            walked.newton += u64::from(did.newton);
            walked.sets += u64::from(did.solver);
        }
        Walked { strike: watch.found, seconds: start.elapsed().as_secs_f64(), ..walked }
    }

    /// The widest lanes up to these that this size has.
    pub fn lanes(&self, wanted: Lanes) -> Lanes {
        Size::of(&self.description).lanes(wanted)
    }

    /// As many instruments side by side as there are lanes, ready to be played.
    pub fn together(&self, settings: &Settings<f64>, lanes: Lanes) -> Together {
        let state = State::<f64, B, Z>::at_rest(std::array::from_fn(|i| self.rest[i])).save().sized();
        let count = lanes.count();
        side_by_side(&vec![&self.description; count], &vec![state; count], settings, lanes)
            .expect("the model was assembled before")
    }

    /// Plays blows side by side, of the stroke's force times the factor of each lane. Speed of the strike point at the
    /// string, m/s, and the instant, s.
    pub fn play_together(&self, mut group: Together, h: f64, scales: &[f64]) -> Vec<Option<[f64; 2]>> {
        let theta = Settings::<f64>::new(h).theta;
        let force = self.force(1.0);
        let (mut angles, mut velocities) = ([0.0; 12], [0.0; 12]);
        angles[..B].copy_from_slice(&self.rest);
        let mut watches: Vec<_> = scales.iter().map(|_| Watch::new(self.strike, &self.links, &angles, &[])).collect();
        let (mut inputs, mut outcomes) =
            (vec![SiteInput::Free; scales.len()], vec![StepOutcome::Converged; scales.len()]);
        for n in 0..(self.press_s / h).ceil() as u64 {
            let t = n as f64 * h;
            let force_n = force(t + theta * h);
            for (input, scale) in inputs.iter_mut().zip(scales) {
                *input = SiteInput::Force(scale * force_n);
            }
            group.step_or_rest(&inputs, &mut outcomes);
            assert!(!outcomes.contains(&StepOutcome::NonFinite), "at {t} s");
            for (lane, watch) in watches.iter_mut().enumerate() {
                group.motion(lane, &mut angles, &mut velocities);
                watch.look(t, h, &angles, &velocities);
            }
        }
        watches.into_iter().map(|watch| watch.found).collect()
    }

    /// The stroke's force times a factor, over time.
    pub fn force(&self, scale: f64) -> impl Fn(f64) -> f64 {
        let cursor = std::cell::Cell::new(Cursor::default());
        move |t| {
            let mut at = cursor.get();
            let force = scale * self.stroke.at(t, &mut at);
            cursor.set(at);
            force
        }
    }
}

/// The strike point and the chain that carries it, from the string's zone: a point on the hammer, a line on the ground.
fn strike(instrument: &Instrument) -> Result<(Strike, Vec<Link>), Box<dyn std::error::Error>> {
    let roles = &instrument.roles;
    let (Some(body), Some(string)) = (roles.hammer, roles.string) else {
        return Err(format!("{}: a blow needs the roles hammer and string", instrument.name).into());
    };
    let zone = &instrument.zones[string];
    let (Curve::Line { point_m, normal }, None, 0.0) = (zone.curve, zone.curve_body, zone.disc_radius_m) else {
        let found = format!(
            "{}: the string must be a straight line on the ground and the strike point a point",
            instrument.name
        );
        return Err(found.into());
    };
    let direction = normal.map(|n| -n);
    let meets_m = point_m[0] * direction[0] + point_m[1] * direction[1];
    let (mut links, mut arm_m, mut carrier) = (Vec::new(), roles.hammer_strike_point_m, Some(body));
    while let Some(body) = carrier {
        links.push(Link { body, arm_m });
        (arm_m, carrier) = (instrument.bodies[body].pivot_m, instrument.bodies[body].parent);
    }
    let pin_m = arm_m[0] * direction[0] + arm_m[1] * direction[1];
    let [x, y] = instrument.on_first_piece(body).expect("the hammer").to_world(roles.hammer_strike_point_m);
    let strike = Strike { body, point_m: roles.hammer_strike_point_m, direction, meets_m, pin_m, radius_m: x.hypot(y) };
    Ok((strike, links))
}
