//! Entries of the protocol sheet: all that a technician writes down about an action.

use serde::Serialize;

use super::blocked::BlockedRow;
use super::flight::Flights;
use super::range::{Loudness, midi_velocity};
use super::slow_loop::{SlowLoop, SlowWay};
use super::timing::Timing;
use super::weights::Touch;
use erard::player::RestKind;
use erard::trust::Warning;

pub(super) const MM_PER_M: f64 = 1e3;
const MS_PER_S: f64 = 1e3;
/// Largest number of points of a loop on the sheet.
const MAX_LOOP_POINTS: usize = 600;

/// Sheet of one action. Grams are gram-forces at the key front or on the scale, millimetres as a technician measures
/// them; `None` (JSON `null`) if the event did not happen or the part is missing.
#[derive(Debug, Clone, Serialize)]
#[allow(non_snake_case)]
#[non_exhaustive]
pub struct Sheet {
    /// Instrument name.
    pub instrument: String,
    /// How the action came to rest before it was measured.
    pub rest: RestKind,
    /// Key, 1 to 88, whose norms the values are compared with.
    pub norms_for_key: usize,
    /// Down-weight with the pedal down, by trial with weights, g.
    pub down_weight_g: Option<f64>,
    /// Up-weight, g.
    pub up_weight_g: Option<f64>,
    /// (D + U) / 2, g.
    pub balance_weight_g: Option<f64>,
    /// (D - U) / 2, g.
    pub friction_weight_g: Option<f64>,
    /// Touch weights with the dampers on the strings, by trial with weights.
    pub dampers_down: Option<TouchNumbers>,
    /// Touch weights with the pedal down, from the slow loop, as a cross-check.
    pub by_slow_loop: TouchNumbers,
    /// Weight of the key on the scale, g.
    pub front_weight_g: f64,
    /// Weight of the hammer on the scale, g.
    pub strike_weight_g: f64,
    /// Weight of the whippen on the scale, g.
    pub whippen_weight_g: f64,
    /// Grams at the front per gram over the capstan.
    pub key_ratio: f64,
    /// Friction contained in the balance weight, g: half of the excess of friction where D is decided over that where U
    /// is.
    pub friction_in_balance_g: Option<f64>,
    /// What springs at the whippen take off the balance weight, g; `None` without them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub assist_g: Option<f64>,
    /// R, by the equation of balance: (BW + FW + A - KR WW) / SW, with A for what springs take off.
    pub strike_weight_ratio_weights: Option<f64>,
    /// R from the two forces of the slow loop half-way, where friction cancels.
    pub strike_weight_ratio_weights_half_way: Option<f64>,
    /// Lever ratio by the geometry: mean of those at the two places that decide down-weight and up-weight.
    pub strike_weight_ratio_kinematics: f64,
    /// Lever ratio at rest.
    pub strike_weight_ratio_kinematics_at_rest: f64,
    /// Lever ratio half-way to where let-off begins.
    pub strike_weight_ratio_kinematics_half_way: f64,
    /// Lever ratio where let-off begins.
    pub strike_weight_ratio_kinematics_at_let_off: f64,
    /// Key travel to its bottom, mm.
    pub dip_mm: Option<f64>,
    /// Distance of hammer and string at rest, mm.
    pub blow_mm: Option<f64>,
    /// Key travel before the hammer moves, mm.
    pub lost_motion_mm: Option<f64>,
    /// Middle of the knuckle to the rear edge of the jack's top, mm.
    pub jack_position_mm: Option<f64>,
    /// Step from the jack's top up to the repetition lever's, mm.
    pub lever_height_mm: Option<f64>,
    /// Key travel at which jack or lever meets its stop, mm.
    pub let_off_begins_mm: Option<f64>,
    /// Distance of hammer and string where the hammer falls in a slow press, mm.
    pub let_off_mm: Option<f64>,
    /// Drop: fall of the hammer after let-off, mm.
    pub drop_mm: Option<f64>,
    /// Key travel left after let-off, mm.
    pub aftertouch_mm: Option<f64>,
    /// Distance of hammer and string in the check, mm.
    pub check_mm: Option<f64>,
    /// Rise of the hammer from the check by the repetition spring, mm.
    pub repetition_rise_mm: Option<f64>,
    /// Largest speed of that rise, m/s: the strength of the spring as judged by eye.
    pub repetition_spring_m_per_s: Option<f64>,
    /// Key travel when the damper starts, as a share of the dip.
    pub damper_start_share: Option<f64>,
    /// Effective mass at the key front, half-way to where let-off begins, pedal down, kg.
    pub effective_inertia_kg: f64,
    /// Share of the key in the effective inertia, kg.
    pub effective_inertia_key_kg: f64,
    /// Share of whippen, jack and repetition lever in the effective inertia, kg.
    pub effective_inertia_whippen_kg: f64,
    /// Share of the hammer in the effective inertia, kg.
    pub effective_inertia_hammer_kg: f64,
    /// Strokes per second with the key fully released.
    pub repetition_rate_hz: Option<f64>,
    /// Strokes per second with the key released to half its dip.
    pub repetition_rate_half_hz: Option<f64>,
    /// Force of the finger in the repetition, N.
    pub repetition_force_N: f64,
    /// Smallest constant force that sounds the note, N.
    pub softest_force_N: Option<f64>,
    /// Speed of the hammer when it is then let off, m/s.
    pub softest_let_off_speed_m_per_s: Option<f64>,
    /// Hammer speed that sqrt(2 a d) gives for the remaining flight, m/s.
    pub softest_fall_speed_m_per_s: Option<f64>,
    /// Fastest second impact after a soft first one with the key held, m/s; 0 without one.
    pub double_strike_m_per_s: Option<f64>,
    /// Let-off resistance felt by the finger, N: largest force in a slow press from the start of let-off to the bottom,
    /// less that before let-off.
    pub let_off_resistance_N: Option<f64>,
    /// Work of a slow press to the bottom and back, pedal down, mJ.
    pub loop_loss_mJ: f64,
    /// With the hammer blocked half-way: travel of the key's front from the first weight to the last, mm.
    pub blocked_front_mm: Option<f64>,
    /// With the hammer blocked half-way: travel of the capstan from the first weight to the last, mm.
    pub blocked_back_mm: Option<f64>,
    /// Bench test, weight by weight.
    pub blocked: Vec<BlockedRow>,
    /// Hammer speed against constant force.
    pub dynamic_range: Vec<Loudness>,
    /// Law from hammer speeds to MIDI velocities.
    pub midi_map: &'static str,
    /// Timing of built-in touches, played by a hand of 200 g.
    pub timing: Vec<TimingRow>,
    /// Force over travel, pedal down, to the bottom and back.
    pub hysteresis: LoopNumbers,
    /// Slow loop with the dampers on the strings.
    pub hysteresis_dampers_down: Option<LoopNumbers>,
    /// Effective mass through the stroke.
    pub inertia: InertiaNumbers,
    /// Values outside their usual ranges.
    pub flags: Vec<Flag>,
    /// Whether the presses of `timing` and `dynamic_range` have no warnings.
    pub trusted: bool,
    /// Doubts, press by press.
    pub warnings: Vec<Doubt>,
}

/// Reason why a press of the sheet cannot be trusted.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Doubt {
    /// Name of the press: `ff struck`, or `30 N`.
    pub during: String,
    /// The doubt.
    #[serde(flatten)]
    pub warning: Warning,
}

/// D, U, BW and F of one measurement, g.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct TouchNumbers {
    /// D.
    pub down_weight_g: Option<f64>,
    /// U.
    pub up_weight_g: Option<f64>,
    /// BW.
    pub balance_weight_g: Option<f64>,
    /// F.
    pub friction_weight_g: Option<f64>,
}

impl From<Touch> for TouchNumbers {
    fn from(touch: Touch) -> Self {
        TouchNumbers {
            down_weight_g: touch.down_weight_g,
            up_weight_g: touch.up_weight_g,
            balance_weight_g: touch.balance_weight_g(),
            friction_weight_g: touch.friction_weight_g(),
        }
    }
}

/// A slow loop: key travel (mm) and force (N), pressing and returning.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
#[allow(non_snake_case)]
pub struct LoopNumbers {
    /// Key travel of the press, mm.
    pub down_key_mm: Vec<f64>,
    /// Force of the press, N.
    pub down_force_N: Vec<f64>,
    /// Key travel of the return, mm.
    pub up_key_mm: Vec<f64>,
    /// Force of the return, N.
    pub up_force_N: Vec<f64>,
}

impl From<&SlowLoop> for LoopNumbers {
    fn from(slow: &SlowLoop) -> Self {
        let thin = |way: &SlowWay| {
            let every = way.key_m.len().div_ceil(MAX_LOOP_POINTS).max(1);
            let kept = |series: &[f64], factor: f64| series.iter().step_by(every).map(|x| x * factor).collect();
            (kept(&way.key_m, MM_PER_M), kept(&way.force_n, 1.0))
        };
        let ((down_key_mm, down), (up_key_mm, up)) = (thin(&slow.down), thin(&slow.up));
        LoopNumbers { down_key_mm, down_force_N: down, up_key_mm, up_force_N: up }
    }
}

/// Effective mass (kg) over key travel (mm).
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct InertiaNumbers {
    /// Key travel, mm.
    pub key_mm: Vec<f64>,
    /// Effective mass with the pedal down, kg.
    pub pedal_down_kg: Vec<f64>,
    /// Effective mass with the dampers on the strings, kg.
    pub dampers_down_kg: Vec<f64>,
}

/// Row of the timing sheet. Times are ms after key start; `None` if the event did not happen.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[allow(non_snake_case)]
pub struct TimingRow {
    /// Level, `pp` to `ff`.
    pub nuance: &'static str,
    /// Touch, `pressed` or `struck`.
    pub touch: &'static str,
    /// Largest force on the key, N.
    pub peak_force_N: f64,
    /// Start of the key after the finger's, ms.
    pub key_start_ms: Option<f64>,
    /// Time of the last push on the knuckle, ms.
    pub let_off_ms: Option<f64>,
    /// Time of the impact on the string, ms.
    pub hammer_contact_ms: Option<f64>,
    /// Time at which the key reaches its punching, ms.
    pub key_bottom_ms: Option<f64>,
    /// Time from the last push on the knuckle to the impact on the string, ms.
    pub free_flight_ms: Option<f64>,
    /// Flights of the hammer, from the last push and from its largest speed.
    pub flights: Option<Flights>,
    /// Hammer contact before key bottom, ms; negative if after it.
    pub hammer_before_bottom_ms: Option<f64>,
    /// Hammer speed at the string, m/s.
    pub hammer_speed_m_per_s: Option<f64>,
    /// MIDI velocity of that speed.
    pub midi_velocity: Option<u8>,
}

impl From<&Timing> for TimingRow {
    fn from(t: &Timing) -> Self {
        let ms = |s: Option<f64>| s.map(|s| s * MS_PER_S);
        let since = |event| ms(t.since_key_start(event));
        let e = &t.events;
        TimingRow {
            nuance: t.nuance,
            touch: t.touch_name(),
            peak_force_N: t.peak_force_n,
            key_start_ms: ms(e.key_start_s),
            let_off_ms: since(e.let_off_s),
            hammer_contact_ms: since(e.hammer_contact_s()),
            key_bottom_ms: since(e.key_bottom_s),
            free_flight_ms: ms(e.free_flight_s()),
            flights: t.flights,
            hammer_before_bottom_ms: ms(t.hammer_before_bottom_s()),
            hammer_speed_m_per_s: e.hammer_speed_m_per_s(),
            midi_velocity: e.hammer_speed_m_per_s().and_then(midi_velocity),
        }
    }
}

/// A value outside its usual range.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Flag {
    /// The line's key.
    pub key: &'static str,
    /// Message that describes the fault.
    pub message: String,
}
