//! What is played, and the engine playing it.

use std::time::Instant;

use erard::instrument::Instrument;
use erard::mechanism::mechanism;
use erard::stroke::{Cursor, ForceSeries, Series, Touch};
use erard::{assembly, equilibrium};
use moreau::{Input, Model, Outcome, Scratch, Settings, State, step};

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

/// One timed run.
pub struct Played {
    /// Speed of the strike point at the string, m/s, and the instant, s.
    pub strike: Option<[f64; 2]>,
    /// The striking body's angle at the asked instants, rad.
    pub angles_rad: Vec<f64>,
    pub seconds: f64,
    pub steps: u64,
}

impl Action {
    /// Lets the instrument come to rest.
    pub fn new(instrument: Instrument) -> Result<Self, Box<dyn std::error::Error>> {
        let mut settled = mechanism(&instrument, Settings::new(equilibrium::STEP_S))?;
        equilibrium::settle(settled.as_mut(), &Input::Free)?;
        let rest = settled.angles().to_vec();
        let stroke =
            Series::builtin("mf", Touch::Pressed).and_then(|s| s.force).ok_or("the mf stroke is not built in")?;
        let strike = strike(&instrument, &rest)?;
        let model = assembly::assemble(&instrument)?;
        Ok(Action { instrument, rest, stroke, strike, model })
    }

    /// Plays from rest to the last of `instants` at a fixed step, the engine only.
    pub fn play(&self, settings: &Settings<f64>, force: impl Fn(f64) -> f64, instants: &[f64]) -> Played {
        let Settings { step: h, theta, .. } = *settings;
        let steps = (instants.last().copied().unwrap_or(0.0) / h).ceil() as u64;
        let start = Instant::now();
        let mut state = State::at_rest(std::array::from_fn(|i| self.rest[i]));
        let mut scratch = Scratch::<f64, B, Z, N>::new();
        let (mut strike, mut angles_rad) = (None, Vec::with_capacity(instants.len()));
        let Strike { body, radius_m, angle_rad } = self.strike;
        for n in 0..steps {
            let (t, angle, velocity) = (n as f64 * h, state.angle[body], state.velocity[body]);
            let report = step(&self.model, settings, &Input::Force(force(t + theta * h)), &mut state, &mut scratch);
            assert_ne!(report.outcome, Outcome::NonFinite, "at {t} s");
            let moved = state.angle[body] - angle;
            if strike.is_none() && angle <= angle_rad && state.angle[body] > angle_rad {
                let share = (angle_rad - angle) / moved;
                let rate = velocity + share * (state.velocity[body] - velocity);
                strike = Some([radius_m * rate.abs(), t + share * h]);
            }
            while let Some(&instant) = instants.get(angles_rad.len()).filter(|&&instant| instant <= t + h) {
                angles_rad.push(angle + moved * (instant - t) / h);
            }
        }
        Played { strike, angles_rad, seconds: start.elapsed().as_secs_f64(), steps }
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
