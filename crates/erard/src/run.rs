//! What one simulated key press leaves behind: the series, the events and the ledger.

use moreau::Ledger;

use crate::mechanism::Impact;
use crate::trust::{Extremes, Warning};

/// A recorded run. All series have the same length; SI units; key and force positive downward (pushing).
///
/// Angles and velocities are those at the row's instant; forces are the mean of the steps before and after it, which is
/// their value there to second order.
#[derive(Debug, Clone)]
pub struct Run {
    /// Instrument name.
    pub instrument: String,
    /// Time of each row, s.
    pub time_s: Vec<f64>,
    /// Finger force on the key, N, pushing positive.
    pub force_n: Vec<f64>,
    /// Travel of the key front from its rest, m, down positive.
    pub key_m: Vec<f64>,
    /// Rise of the hammer's strike point from its rest, m, up positive; empty when the model has no hammer.
    pub hammer_head_m: Vec<f64>,
    /// One series per body.
    pub bodies: Vec<BodySeries>,
    /// One series per zone.
    pub zones: Vec<ZoneSeries>,
    /// The strings, where they yield.
    pub strings: Option<StringSeries>,
    /// Instants.
    pub events: Events,
    /// Largest finger force of any step, N.
    pub peak_force_n: f64,
    /// Dry friction torque of every pivot at the end, N m.
    pub final_pivot_friction_n_m: Vec<f64>,
    /// The energy ledger at the end, where it was kept.
    pub ledger: Option<Ledger>,
    /// Steps and iterations.
    pub work: Work,
    /// How far the bodies turned, and how deep the felts were pressed.
    pub extremes: Extremes,
    /// Why the run is not to be trusted; empty if nothing speaks against it.
    pub warnings: Vec<Warning>,
}

impl Run {
    /// Whether nothing speaks against the run's numbers ([`crate::trust`]).
    pub fn is_trusted(&self) -> bool {
        self.warnings.is_empty()
    }

    /// Name and values of every column of its table; a column without values (no hammer in the model) is empty. A name ends with the unit
    /// ([`column_unit`]).
    pub fn columns(&self) -> Vec<(String, &[f64])> {
        let mut columns: Vec<(String, &[f64])> = vec![
            ("time_s".into(), &self.time_s),
            ("force_N".into(), &self.force_n),
            ("key_m".into(), &self.key_m),
            ("hammer_head_m".into(), &self.hammer_head_m),
        ];
        for body in &self.bodies {
            columns.push((format!("{}_rad", body.name), &body.angle_rad));
            columns.push((format!("{}_rad_per_s", body.name), &body.rate_rad_per_s));
        }
        for zone in &self.zones {
            columns.push((format!("{}_N", zone.name), &zone.normal_n));
            if zone.has_friction {
                columns.push((format!("{}_tangential_N", zone.name), &zone.tangential_n));
            }
        }
        if let Some(strings) = &self.strings {
            columns.push(("string_m".into(), &strings.displacement_m));
            columns.push(("bridge_N".into(), &strings.bridge_n));
        }
        columns
    }
}

/// What the endings of columns' names mean, the longer before the shorter.
const UNITS: [(&str, &str); 18] = [
    ("_rad_per_s2", "rad/s2"),
    ("_degrees", "deg"),
    ("_kg", "kg"),
    ("_ms", "ms"),
    ("_rad_per_s", "rad/s"),
    ("_m_per_s", "m/s"),
    ("_N_mm", "N mm"),
    ("_N_m", "N m"),
    ("_kg_m2", "kg m2"),
    ("_rad", "rad"),
    ("_deg", "deg"),
    ("_mm", "mm"),
    ("_Hz", "Hz"),
    ("_g", "g"),
    ("_J", "J"),
    ("_m", "m"),
    ("_s", "s"),
    ("_N", "N"),
];

/// The unit that a column's name ends with; `1` for a number without.
pub fn column_unit(name: &str) -> &'static str {
    UNITS.iter().find(|(ending, _)| name.ends_with(ending)).map_or("1", |(_, unit)| unit)
}

/// What strings that yield do.
#[derive(Debug, Clone, Default)]
pub struct StringSeries {
    /// Displacement under the hammer from a straight line, m, away from it; of several strings their mean. What a damper's weight displaces is in it.
    pub displacement_m: Vec<f64>,
    /// Force of all of them on the bridge, N, positive in the direction in which the hammer pushes.
    pub bridge_n: Vec<f64>,
    /// Places along the middle one of them, m from the striking point, away from the nearer end.
    pub places_m: Vec<f64>,
    /// Its displacement at these places, m, row after row.
    pub shape_m: Vec<f32>,
    /// Lift of the pedal's rail, m; empty where there is none.
    pub pedal_m: Vec<f64>,
}

/// One body's motion.
#[derive(Debug, Clone, Default)]
pub struct BodySeries {
    /// Body name.
    pub name: String,
    /// Absolute angle of the body's frame, rad, counter-clockwise.
    pub angle_rad: Vec<f64>,
    /// Absolute angular velocity, rad/s.
    pub rate_rad_per_s: Vec<f64>,
}

/// One zone's forces.
#[derive(Debug, Clone, Default)]
pub struct ZoneSeries {
    /// Zone name.
    pub name: String,
    /// Human label.
    pub label: String,
    /// Normal force, N, never negative.
    pub normal_n: Vec<f64>,
    /// Coulomb force on side A along the tangent (normal turned clockwise by 90 degrees), N; empty where the zone has no friction.
    pub tangential_n: Vec<f64>,
    /// Whether the zone has Coulomb friction.
    pub has_friction: bool,
    /// Contact point in the world and the outward unit normal of side B, `[x, y, nx, ny]`, m; valid where `normal_n > 0`.
    pub contact: Vec<[f32; 4]>,
}

/// Instants and speeds of one press; `None` where it did not happen. Seconds from the stroke's start.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Events {
    /// The key front leaves its rest.
    pub key_start_s: Option<f64>,
    /// The jack's toe meets the let-off button.
    pub toe_contact_s: Option<f64>,
    /// The knuckle is pushed for the last time before the string.
    pub let_off_s: Option<f64>,
    /// The key meets its front punching.
    pub key_bottom_s: Option<f64>,
    /// The tail meets the back check after the blow.
    pub check_s: Option<f64>,
    /// Every impact of the hammer on the string.
    pub impacts: Vec<Impact>,
}

impl Events {
    /// The first impact of the hammer on the string.
    pub fn first_impact(&self) -> Option<Impact> {
        self.impacts.first().copied()
    }

    /// Instant of the first impact, s.
    pub fn hammer_contact_s(&self) -> Option<f64> {
        self.first_impact().map(|impact| impact.time_s)
    }

    /// Total speed of the strike point at the first impact, m/s.
    pub fn hammer_speed_m_s(&self) -> Option<f64> {
        self.first_impact().map(|impact| impact.hammer_speed_m_s)
    }

    /// From let-off to the string, s.
    pub fn free_flight_s(&self) -> Option<f64> {
        Some(self.hammer_contact_s()? - self.let_off_s?)
    }

    /// From the blow to the key's bottom, s: negative where the key is down before the hammer strikes.
    pub fn key_bottom_after_blow_s(&self) -> Option<f64> {
        Some(self.key_bottom_s? - self.hammer_contact_s()?)
    }
}

/// How a run was made and what it cost.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Work {
    /// Steps taken; of controlled steps, their halves.
    pub steps: u64,
    /// Steps that reached an iteration limit.
    pub unconverged_steps: u64,
    /// Newton iterations, all steps and all attempts.
    pub newton_iterations: u64,
    /// Sweeps or active sets likewise.
    pub solver_iterations: u64,
    /// Every how many steps of the settings a row was recorded.
    pub record_every: u64,
    /// What the control of the error did, where there was one.
    pub control: Option<ControlWork>,
}

/// Steps whose error was controlled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ControlWork {
    /// Controlled steps taken, of two halves each.
    pub accepted: u64,
    /// Attempts rejected.
    pub rejected: u64,
    /// Inner steps of all attempts, three each.
    pub inner_steps: u64,
    /// Controlled steps in which whole and halves were combined to a higher order.
    pub extrapolated: u64,
    /// Steps at the smallest length whose error is beyond the tolerance.
    pub beyond_tolerance: u64,
    /// Shortest controlled step, s; not where a row's instant cut it off.
    pub shortest_s: f64,
    /// Longest one, s.
    pub longest_s: f64,
}
