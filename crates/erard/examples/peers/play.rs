//! What is played, and the engine playing it.

use std::time::Instant;

use erard::assembly;
use erard::instrument::Instrument;
use erard::stroke::{Cursor, ForceSeries, Series, Touch};
use moreau::{
    Accuracy, Controller, Halves, Input, Model, Outcome, Settings, Sleep, State, Workspace, controlled_step, step,
};
use moreau_lanes::{Group, Lanes};

/// The stroke whose hammer speed is compared is the built-in mf, pressed, its force times each of these: a single blow may be met by
/// luck, a row of them is not.
pub const SCALES: [f64; 9] = [0.88, 0.91, 0.94, 0.97, 1.0, 1.03, 1.06, 1.09, 1.12];
/// All of them have struck, and left the string again or nearly, at this instant, s.
pub const BLOW_S: f64 = 0.06;
/// The note that is held: a constant force, N, looked at from one instant to another, s.
pub const HOLD_N: f64 = 12.0;
pub const HOLD_S: [f64; 2] = [1.0, 10.0];

/// The grand's engine size.
const B: usize = 6;
const Z: usize = 14;
const N: usize = 10;

/// An instrument at rest, ready to be played.
pub struct Action {
    pub instrument: Instrument,
    /// Absolute angles at rest, rad.
    pub rest: Vec<f64>,
    /// The mf stroke.
    pub stroke: ForceSeries,
    pub strike: Strike,
    model: Model<f64, B, Z>,
}

/// What meets the string: a point of a body that is hinged on the ground.
#[derive(Debug, Clone, Copy)]
pub struct Strike {
    pub body: usize,
    /// Distance of the strike point from the pivot, m.
    pub radius_m: f64,
    /// The body's angle when it meets the string, rad.
    pub angle_rad: f64,
}

/// Instruments side by side in the processor's lanes.
pub type Together = Group<B, Z, N>;

/// One timed run.
pub struct Played {
    /// Speed of the strike point at the string, m/s, and the instant, s.
    pub strike: Option<[f64; 2]>,
    /// The striking body's angle at the asked instants, rad.
    pub angles_rad: Vec<f64>,
    pub seconds: f64,
    pub steps: u64,
}

/// How long steps are.
#[derive(Debug, Clone, Copy)]
pub enum Steps {
    /// All as long, s.
    Fixed(f64),
    /// The same, but for those that would change no bit.
    FixedOrRest(f64),
    /// As long as an error allows.
    Controlled(f64),
}

/// Limits of controlled steps and their first attempt, s.
const SMALLEST_STEP_S: f64 = 1e-8;
const LARGEST_STEP_S: f64 = 1e-3;
const FIRST_STEP_S: f64 = 50e-6;

/// Looks out for the blow and for the instants at which the angle is asked for.
struct Watch<'a> {
    strike: Strike,
    found: Option<[f64; 2]>,
    /// Angle and angular velocity of what strikes, now.
    now: [f64; 2],
    /// Its angular acceleration over the last step, rad/s2.
    slope: f64,
    instants: &'a [f64],
    angles_rad: Vec<f64>,
}

impl<'a> Watch<'a> {
    /// From a start at rest.
    fn new(strike: Strike, angle_rad: f64, instants: &'a [f64]) -> Self {
        let angles_rad = Vec::with_capacity(instants.len());
        Watch { strike, found: None, now: [angle_rad, 0.0], slope: 0.0, instants, angles_rad }
    }

    /// A step of h from t on has been taken. Within it the angle is the cubic through angles and velocities at both ends; but the string is
    /// met as if the step before went on, its acceleration unchanged: at the step's end the string has pushed already.
    #[inline(always)]
    fn look(&mut self, t: f64, h: f64, angle: f64, velocity: f64) {
        let ([q0, v0], [q1, v1]) = (self.now, [angle, velocity]);
        let Strike { radius_m, angle_rad, .. } = self.strike;
        if self.found.is_none() && q0 <= angle_rad && q1 > angle_rad {
            let left = angle_rad - q0;
            let v = (v0 * v0 + 2.0 * self.slope * left).max(0.0).sqrt();
            self.found = Some([radius_m * v, t + 2.0 * left / (v0 + v)]);
        }
        let at = |s: f64| {
            let (a, b) = (v0 * h - (q1 - q0), (q1 - q0) - v1 * h);
            q0 + s * (q1 - q0) + s * (1.0 - s) * ((1.0 - s) * a + s * b)
        };
        while let Some(&instant) = self.instants.get(self.angles_rad.len()).filter(|&&instant| instant <= t + h) {
            self.angles_rad.push(at((instant - t) / h));
        }
        (self.now, self.slope) = ([q1, v1], (v1 - v0) / h);
    }
}

impl Action {
    /// Lets the instrument come to rest.
    pub fn new(instrument: Instrument) -> Result<Self, Box<dyn std::error::Error>> {
        let rest = erard::Action::new(&instrument)?.angles().to_vec();
        let stroke =
            Series::builtin("mf", Touch::Pressed).and_then(|s| s.force).ok_or("the mf stroke is not built in")?;
        let strike = strike(&instrument, &rest)?;
        let model = assembly::assemble(&instrument)?;
        Ok(Action { instrument, rest, stroke, strike, model })
    }

    /// Plays from rest to the last of `instants`, the engine only, in the given steps.
    pub fn play(&self, steps: Steps, force: impl Fn(f64) -> f64, instants: &[f64]) -> Played {
        let end = instants.last().copied().unwrap_or(0.0);
        let theta = Settings::<f64>::new(1e-3).theta;
        let input = |t: f64, h: f64| Input::Force(force(t + theta * h));
        let start = Instant::now();
        let mut state = State::at_rest(std::array::from_fn(|i| self.rest[i]));
        let body = self.strike.body;
        let mut watch = Watch::new(self.strike, self.rest[body], instants);
        let mut taken = 0;
        match steps {
            Steps::Fixed(h) | Steps::FixedOrRest(h) => {
                let rests = matches!(steps, Steps::FixedOrRest(_));
                let (settings, mut workspace) = (Settings::new(h), Workspace::<f64, B, Z, N>::new());
                let mut repose = Sleep::awake();
                for n in 0..(end / h).ceil() as u64 {
                    let t = n as f64 * h;
                    let (model, input) = (&self.model, input(t, h));
                    let report = if rests {
                        repose.step(model, &settings, &input, &mut state, &mut workspace)
                    } else {
                        step(model, &settings, &input, &mut state, &mut workspace)
                    };
                    assert_ne!(report.outcome, Outcome::NonFinite, "at {t} s");
                    watch.look(t, h, state.angle[body], state.velocity[body]);
                    taken += 1;
                }
            }
            Steps::Controlled(tolerance) => {
                let settings = Settings::new(LARGEST_STEP_S);
                let accuracy = Accuracy::new(tolerance, SMALLEST_STEP_S, LARGEST_STEP_S);
                let mut controller = Controller::<f64, Z>::new(FIRST_STEP_S);
                let mut halves = Halves::<f64, B, Z, N>::new(&settings);
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
                    assert_ne!(did.outcome, Outcome::NonFinite, "at {t} s");
                    watch.look(t, did.step, state.angle[body], state.velocity[body]);
                    t += did.step;
                    taken += u64::from(did.inner);
                }
            }
        }
        let Watch { found, mut angles_rad, .. } = watch;
        if angles_rad.len() < instants.len() {
            angles_rad.push(state.angle[body]);
        }
        Played { strike: found, angles_rad, seconds: start.elapsed().as_secs_f64(), steps: taken }
    }

    /// As many instruments side by side as there are lanes, ready to be played in steps of h.
    pub fn together(&self, h: f64, lanes: Lanes) -> Together {
        let count = lanes.count();
        let states = vec![State::at_rest(std::array::from_fn(|i| self.rest[i])); count];
        Group::new(&vec![self.model.clone(); count], &states, &Settings::new(h), lanes)
    }

    /// Plays blows side by side, of the stroke's force times the factor of each lane. Speed of the strike point at the string, m/s, and the
    /// instant, s.
    pub fn play_together(&self, mut group: Together, h: f64, scales: &[f64]) -> Vec<Option<[f64; 2]>> {
        let (body, theta) = (self.strike.body, Settings::new(h).theta);
        let force = self.force(1.0);
        let mut watches: Vec<_> = scales.iter().map(|_| Watch::new(self.strike, self.rest[body], &[])).collect();
        let (mut inputs, mut outcomes) = (vec![Input::Free; scales.len()], vec![Outcome::Converged; scales.len()]);
        for n in 0..(BLOW_S / h).ceil() as u64 {
            let t = n as f64 * h;
            let force_n = force(t + theta * h);
            for (input, scale) in inputs.iter_mut().zip(scales) {
                *input = Input::Force(scale * force_n);
            }
            group.step_or_rest(&inputs, &mut outcomes);
            assert!(!outcomes.contains(&Outcome::NonFinite), "at {t} s");
            for (lane, watch) in watches.iter_mut().enumerate() {
                let (angle, velocity) = group.motion(lane);
                watch.look(t, h, angle[body], velocity[body]);
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

/// Finds the hammer's angle at the string by bisection on the string's gap.
fn strike(instrument: &Instrument, rest: &[f64]) -> Result<Strike, Box<dyn std::error::Error>> {
    let roles = &instrument.roles;
    let (Some(body), Some(string)) = (roles.hammer, roles.string) else {
        return Err(format!("{}: a blow needs the roles hammer and string", instrument.name).into());
    };
    if instrument.bodies[body].parent.is_some() || instrument.zones[string].curve_body.is_some() {
        return Err(format!(
            "{}: the hammer must be hinged on the ground and the string be fixed to it",
            instrument.name
        )
        .into());
    }
    let model: Model<f64, B, Z> = assembly::assemble(instrument)?;
    let gap = |angle: f64| {
        let angles = std::array::from_fn(|i| if i == body { angle } else { rest[i] });
        moreau::Pose::of(&model, &angles).gap(&model, string)
    };
    let [x, y] = roles.hammer_head_m;
    // It rises counter-clockwise, less than half a turn.
    let (mut below, mut above) = (rest[body], rest[body] + 1.5);
    if gap(below) > 0.0 || gap(above) <= 0.0 {
        return Err(format!("{}: the hammer does not reach the string", instrument.name).into());
    }
    for _ in 0..80 {
        let middle = 0.5 * (below + above);
        if gap(middle) > 0.0 { above = middle } else { below = middle }
    }
    Ok(Strike { body, radius_m: x.hypot(y), angle_rad: above })
}
