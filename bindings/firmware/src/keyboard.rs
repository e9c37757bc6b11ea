//! The keyboard of the recorded scan. Written by `.ci/regenerate firmware`: do not edit.

use erard_live::converter::Stops;
use erard_live::Limits;

/// Keys of the scan, its instants, and the time between them, s.
pub const KEYS: usize = 10;
pub const FRAMES: usize = 2200;
pub const PERIOD_S: f64 = 0.001;
/// Readings at a key's stops, and the sensed travel between them, m.
pub(crate) const STOPS: Stops = Stops { rest: 3500.0, pressed: 700.0 };
pub(crate) const TRAVEL_M: f64 = 0.009620857533906487;
/// The sensors' law: shares of the reading's range and of the travel.
pub(crate) static POINTS: [[f64; 2]; 5] = [[0.0, 0.0], [0.25, 0.32], [0.5, 0.58], [0.75, 0.8], [1.0, 1.0]];
/// What a key may be asked for.
pub(crate) const LIMITS: Limits = Limits { key_m_per_s: 1.8914832180063552, force_n: f64::INFINITY, up_m_per_s: 0.26097699284058323, dip_m: 0.009620857533906487, blow_m: 0.04681859888482037 };
