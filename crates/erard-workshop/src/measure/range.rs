//! Dynamic range, from the softest note that reaches the string to the loudest: hammer speed against force on the key.

use erard::IndexError;
use moreau::Settings;

use super::MeasureError;
use erard::Progress;
use erard::grand::{Parts, falling_moment_n_m};
use erard::instrument::Instrument;
use erard::player::{Action, AtRest, Input, RestPose, Snapshot, force};
use erard::run::Run;
use erard::run::{Setup, simulate_at_rest};
use erard::trust::Warning;

/// Step, s.
const STEP_S: f64 = 50e-6;
/// A press that has not sounded within this time does not, s: the slowest published ones take 0.25 s.
const PATIENCE_S: f64 = 0.8;
/// Constant forces on the key, N: from the smallest that starts it to beyond the largest published for a fortissimo.
pub(crate) const FORCES_N: [f64; 14] = [0.6, 0.7, 0.8, 1.0, 1.4, 2.0, 2.8, 4.0, 5.6, 8.0, 11.0, 15.0, 22.0, 30.0];
/// Range of forces in the search for a second impact, N: from the softest that sounds to where every impact is checked.
pub(crate) const DOUBLE_STRIKE_N: [f64; 2] = [0.7, 1.3];
/// Number of steps between them.
const DOUBLE_STRIKES: u32 = 12;
/// Speed of a second impact that is hardly heard, m/s. Our own estimate: no number is published.
pub const HARDLY_HEARD_M_PER_S: f64 = 0.15;
/// Largest force in the search for the softest note, N.
const MAX_SOFT_N: f64 = 10.0;
const CLOSE_N: f64 = 2e-4;

/// Hammer speed under a constant force.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Loudness {
    /// Constant force on the key front, from rest, N.
    #[serde(rename = "force_N")]
    pub force_n: f64,
    /// Speed of the strike point at the string, m/s; `None` if it does not reach it.
    pub hammer_speed_m_per_s: Option<f64>,
    /// Hammer speed as MIDI velocity; see `midi_velocity`.
    pub midi_velocity: Option<u8>,
    /// Reasons why the press cannot be trusted.
    #[serde(skip)]
    pub warnings: Vec<Warning>,
}

/// The softest note that reaches the string.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Softest {
    /// The constant force, N.
    pub force_n: f64,
    /// Flight of the hammer; `None` if jack and lever pushed until the impact.
    pub flight: Option<SoftFlight>,
}

/// The flight of the softest note.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SoftFlight {
    /// Speed of the strike point at its last push, m/s.
    pub let_off_speed_m_per_s: f64,
    /// Distance of the flight, m.
    pub flight_m: f64,
    /// Duration of the flight, s.
    pub flight_s: f64,
    /// Hammer speed that a fall through that distance would give: sqrt(2 a d), m/s; see `fall_m_per_s2`.
    pub fall_speed_m_per_s: f64,
}

/// MIDI velocity of a hammer speed (m/s): 52 + 25 log2(speed), from 1 to 127.
///
/// The law by which W. Goebl, The Role of Timing and Intensity in the Production and Perception of Melody in Expressive
/// Piano Performance (thesis, University of Graz, 2003, section 3.7, eq. 3.2) converted hammer speeds of a Bösendorfer
/// SE290 to MIDI velocities. Other instruments have others: it is declared, not measured.
#[must_use]
pub(crate) fn midi_velocity(speed_m_per_s: f64) -> Option<u8> {
    (speed_m_per_s > 0.0).then(|| (52.0 + 25.0 * speed_m_per_s.log2()).round().clamp(1.0, 127.0) as u8)
}

/// Description of that map.
pub const MIDI_MAP: &str = "MIDI velocity = 52 + 25 log2(hammer speed in m/s), Goebl 2003 (Bösendorfer SE290)";

/// Deceleration of the strike point in free rise with the shank level, along its arc, m/s2: moments of weight and pivot
/// friction over the inertia about the pin. The hammer is one rigid body ([`Instrument::locked`]).
///
/// # Errors
/// There is no such body.
pub(crate) fn fall_m_per_s2(instrument: &Instrument, hammer: usize) -> Result<f64, IndexError> {
    let moment_n_m = falling_moment_n_m(instrument, hammer)?;
    let body = &instrument.bodies[hammer];
    let [along, above] = instrument.roles.hammer_strike_point_m;
    Ok(moment_n_m / body.inertia_kg_m2 * along.hypot(above))
}

/// Hammer speed at each of [`FORCES_N`]; `each` receives the number done.
///
/// # Errors
/// See [`MeasureError`].
pub(crate) fn speed_against_force(
    action: &dyn AtRest,
    progress: &mut Progress<'_>,
) -> Result<Vec<Loudness>, MeasureError> {
    let rest = action.pose(progress)?;
    FORCES_N
        .into_iter()
        .map(|force_n| {
            let run = press(&rest, force_n, true, progress)?;
            let hammer_speed_m_per_s = run.events.hammer_speed_m_per_s();
            let midi_velocity = hammer_speed_m_per_s.and_then(midi_velocity);
            Ok(Loudness { force_n, hammer_speed_m_per_s, midi_velocity, warnings: run.warnings })
        })
        .collect()
}

/// Returns the fastest impact after the first under soft constant forces, m/s: the repetition spring throws the hammer
/// back at the string while the key is held (double striking). 0 if each of `DOUBLE_STRIKE_N` sounds once.
///
/// # Errors
/// See [`MeasureError`].
pub fn double_strike(action: &dyn AtRest, progress: &mut Progress<'_>) -> Result<f64, MeasureError> {
    let rest = action.pose(progress)?;
    let [from, to] = DOUBLE_STRIKE_N;
    let mut fastest = 0.0;
    for n in 0..=DOUBLE_STRIKES {
        let force_n = from + (to - from) * f64::from(n) / f64::from(DOUBLE_STRIKES);
        let run = press(&rest, force_n, false, progress)?;
        fastest = run.events.impacts.iter().skip(1).map(|impact| impact.hammer_speed_m_per_s).fold(fastest, f64::max);
    }
    Ok(fastest)
}

/// Finds the smallest constant force from rest with which the hammer reaches the string, by bisection; `None` if 10 N
/// do not suffice.
///
/// # Errors
/// See [`MeasureError`].
pub fn softest(action: &dyn AtRest, progress: &mut Progress<'_>) -> Result<Option<Softest>, MeasureError> {
    let instrument = action.instrument();
    let parts = Parts::of(instrument)?;
    let pose = action.pose(progress)?;
    let mut action = pose.action(Settings::new(STEP_S))?;
    let rest = action.save();
    let (mut low, mut high) = (0.0, MAX_SOFT_N);
    if !reaches(&mut action, &rest, high, progress)? {
        return Ok(None);
    }
    while high - low > CLOSE_N {
        let middle = 0.5 * (low + high);
        if reaches(&mut action, &rest, middle, progress)? { high = middle } else { low = middle }
    }
    let run = press(&pose, high, false, progress)?;
    let (Some(off), Some(contact)) = (run.events.let_off_s, run.events.hammer_contact_s()) else {
        return Ok(Some(Softest { force_n: high, flight: None }));
    };
    let row = |t: f64| run.time_s.partition_point(|&time| time < t).min(run.time_s.len() - 1);
    let rigid = instrument.locked();
    let rigid_hammer = Parts::of(&rigid)?.hammer;
    let [along, above] = rigid.roles.hammer_strike_point_m;
    let flight_m = run.hammer_rise_m[row(contact)] - run.hammer_rise_m[row(off)];
    // The head moves along its part's arc about the centre pin; its rocking on a bending shank is not part of its
    // flight.
    let rate = run.bodies[instrument.first_piece(parts.hammer)?].rate_rad_per_s[row(off)];
    let flight = SoftFlight {
        let_off_speed_m_per_s: rate.abs() * along.hypot(above),
        flight_m,
        flight_s: contact - off,
        fall_speed_m_per_s: (2.0 * fall_m_per_s2(&rigid, rigid_hammer)? * flight_m.max(0.0)).sqrt(),
    };
    Ok(Some(Softest { force_n: high, flight: Some(flight) }))
}

/// Whether the hammer reaches the string under a constant force from rest.
fn reaches(
    action: &mut Action,
    rest: &Snapshot,
    force_n: f64,
    progress: &mut Progress<'_>,
) -> Result<bool, MeasureError> {
    // The snapshot is this action's own.
    let _ = action.restore(rest);
    let mut steps = 0..=(PATIENCE_S / STEP_S).round() as u64;
    let mut reached = false;
    action.play(progress, &mut |action| {
        reached = steps.next()? > 0 && action.impact().is_some();
        (!reached).then_some(Input::Force(force_n))
    })?;
    Ok(reached)
}

fn press(rest: &RestPose, force_n: f64, ledger: bool, progress: &mut Progress<'_>) -> Result<Run, MeasureError> {
    let setup = Setup { settings: Settings::new(STEP_S), record_every: Some(1), ledger, ..Setup::new(PATIENCE_S) };
    Ok(simulate_at_rest(rest, &force(|_| force_n), &setup, &mut |_| progress(0.0))?)
}
