//! Balancing a keyboard: leads, hammers and capstans from a technician's weights, key by key.
//!
//! Statics by Stanwood's equation of balance (D. C. Stanwood, The New Touchweight Metrology, PTG Journal, June 1996),
//!
//! BW + FW + A = KR WW + R SW
//!
//! with balance weight BW = (D + U) / 2, friction weight F = (D - U) / 2, front weight FW, key ratio KR, whippen weight
//! WW, strike weight SW, strike-weight ratio R, and A, what springs at the whippen or magnets take off: `equation`.
//! Measured weights: `measured`, from tables with a row for each key: `rows`; the conditions of a weighing:
//! `conditions`. Curves over the keyboard: `smooth`; keys that differ from their neighbours: `neighbours`. Available
//! leads: `leads`. Work that reaches the target, key by key: `plan`. Its check in the dynamic model: `check`.
//!
//! Grams are gram-forces at the key front or on the scale, as in the trade; millimetres along the key count from its
//! balance pin, positive toward the player.

mod check;
mod conditions;
mod equation;
mod leads;
mod measured;
mod model;
mod neighbours;
mod plan;
mod rows;
mod smooth;

pub use check::{Checked, check};

pub(crate) use conditions::{Conditions, PLACES_MM, UNTAPPED_G, USUAL_PLACE_MM, yes_or_no};
pub use equation::Parts;
pub(crate) use equation::{WeightFault, WeightReadings};
pub(crate) use leads::lead_work;
pub use leads::{LEADS_G, Lead, LeadChoice, LeadWork, moved_inertia_g};
pub(crate) use measured::{ASSIST_LIMITS_G, BALANCE_LIMITS_G, FRICTION_LIMITS_G};
pub use measured::{MeasuredKey, read, unused_columns};
pub use model::KeyModel;
pub(crate) use model::add_mass;
pub use neighbours::Apart;
pub(crate) use neighbours::median;
pub use plan::{
    AFTERTOUCH_PER_CAPSTAN, BalancedKey, Bound, Curves, LEAST_BALANCE_G, MOST_CAPSTAN_MM, Plan, Remedy, Target,
    Withheld, plan,
};
pub use rows::MeasuredError;
pub(crate) use rows::rows_of_keys;
pub use smooth::smooth;
