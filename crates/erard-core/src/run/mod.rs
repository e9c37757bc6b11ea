//! One key press from rest to the end of its duration, and its results: series, events and the energy balance.
//!
//! [`simulate`] prepares an action and hands it to the loop over steps in `run_loop.rs`.

mod run_loop;
mod setup;
mod simulation;
mod sound;

pub use setup::{MAX_ROWS, MAX_ROWS_ASKED, Setup, SimulationError, TOLERANCES};
pub use simulation::{press, press_by_hand, simulate, simulate_at_rest, simulate_from, simulate_observed};
pub use sound::{Heard, RATE_HZ, Sound, sound};

pub use crate::events::Events;
pub use crate::player::{BodySeries, ControlWork, StringSeries, Work, ZoneSeries};

use std::fmt::Write as _;

use moreau::Ledger;

use crate::parameter::Quantity;
use crate::trust::{Extremes, Warning};

/// Motion of a pivot along its pin, of a body that lies on a zone ([`crate::instrument::Bushing::Pin`]).
#[derive(Debug, Clone, Default)]
pub struct LiftSeries {
    /// Name of the body that lies.
    pub name: String,
    /// Name of the body that represents its pin.
    pub pin: String,
    /// Rise of its pivot from the drawn place, m, up positive. At rest it is near zero: the body presses on its zone.
    pub lift_m: Vec<f64>,
}

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
    pub hammer_rise_m: Vec<f64>,
    /// Speed of the hammer's strike point, m/s, up positive; empty when the model has no hammer.
    pub hammer_rise_m_per_s: Vec<f64>,
    /// One series per body.
    pub bodies: Vec<BodySeries>,
    /// One series per zone.
    pub zones: Vec<ZoneSeries>,
    /// Lifts of the pivots that lie on a zone; empty where none does.
    pub lifts: Vec<LiftSeries>,
    /// The strings, where they yield.
    pub strings: Option<StringSeries>,
    /// Instants.
    pub events: Events,
    /// Largest finger force of any step, N.
    pub peak_force_n: f64,
    /// Dry friction torque of every pivot at the end, N m.
    pub final_pivot_friction_n_m: Vec<f64>,
    /// The energy balance at the end, where it was kept.
    pub ledger: Option<Ledger>,
    /// Steps and iterations.
    pub work: Work,
    /// Largest angles of the bodies, rad, and largest compressions of the felts, m.
    pub extremes: Extremes,
    /// Reasons why the run cannot be trusted; empty without a warning.
    pub warnings: Vec<Warning>,
}

impl Run {
    /// Whether the run has no warnings ([`crate::trust`]).
    pub fn is_trusted(&self) -> bool {
        self.warnings.is_empty()
    }

    /// Name and values of every column of its table; a column without values (no hammer in the model) is empty. A name
    /// ends with the unit ([`column_unit`]).
    pub fn columns(&self) -> Vec<(String, &[f64])> {
        let mut columns: Vec<(String, &[f64])> = vec![
            ("time_s".into(), &self.time_s),
            ("force_N".into(), &self.force_n),
            ("key_m".into(), &self.key_m),
            ("hammer_rise_m".into(), &self.hammer_rise_m),
            ("hammer_rise_m_per_s".into(), &self.hammer_rise_m_per_s),
        ];
        for body in &self.bodies {
            columns.push((format!("{}_rad", body.name), &body.angle_rad));
            columns.push((format!("{}_rad_per_s", body.name), &body.rate_rad_per_s));
        }
        for lift in &self.lifts {
            columns.push((format!("{}_lift_m", lift.name), &lift.lift_m));
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

    /// Returns its table as text, the run.csv of a press: a line of [`Run::columns`]' names, then a line for each row.
    #[must_use]
    pub fn csv(&self) -> String {
        let columns = self.columns();
        let names: Vec<&str> = columns.iter().map(|(name, _)| name.as_str()).collect();
        let mut text = names.join(",");
        text.push('\n');
        for row in 0..self.time_s.len() {
            for (place, (_, values)) in columns.iter().enumerate() {
                if place > 0 {
                    text.push(',');
                }
                if let Some(value) = values.get(row) {
                    shortest(*value, &mut text);
                }
            }
            text.push('\n');
        }
        text
    }
}

/// Appends the shortest text that reads back as the same number.
pub fn shortest(x: f64, text: &mut String) {
    // Writing to a string does not fail.
    let _ = if x != 0.0 && (x.abs() < 1e-4 || x.abs() >= 1e9) { write!(text, "{x:e}") } else { write!(text, "{x}") };
}

/// The unit that a column's name ends with; `1` for a number without.
#[must_use]
pub fn column_unit(name: &str) -> &'static str {
    Quantity::of_name(name).map_or("1", |(_, unit)| unit.symbol)
}
