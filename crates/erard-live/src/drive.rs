//! From samples to what drives a key in each step.

use erard::player::Hand;
use erard::{Input, Reading};

use crate::limits::{CEILING_N, Limits};

/// Kind of keyboard that carries the sensors.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SensorKind {
    /// The key of a real action, which moves as it does with hammer and all: its motion is prescribed.
    Action,
    /// A switch or controller, which the finger moves without inertia: a hand with mass follows its depth, with at most
    /// 60 N.
    Light,
    /// A force on the key's front.
    Force,
}

/// A key that is not quite where it is sensed, because its sensor has come to rest or has left it, comes there within
/// this time, s; one that was limited, at its greatest speed.
const SETTLES_S: f64 = 0.02;
/// The hand on a light device: its muscle follows more stiffly than a pianist's, for the device is all that is known of
/// it. It asks for the ceiling where it is 3 mm behind. Estimates.
const STIFF_N_PER_M: f64 = 20e3;
const DAMPED_N_S_PER_M: f64 = 90.0;
/// It is not asked for more, m/s: 60 N do not bring a hand and a key there within a dip.
const HAND_M_PER_S: f64 = 1.0;
/// A sensed key is not led deeper beyond its dip, m.
pub(crate) const BEYOND_M: f64 = 0.5e-3;
/// Nearer to its rest a key that is led there is let go, m.
const LET_GO_M: f64 = 1e-6;
/// A hand whose device is at rest leaves the key after this time, s.
const LEAVES_S: f64 = 0.2;

/// The drive of one key.
#[derive(Debug, Clone)]
pub(crate) struct Drive {
    kind: SensorKind,
    limits: Limits,
    /// Where the key is led, m.
    led_m: f64,
    /// Whether it is behind, because it was limited.
    is_behind: bool,
    /// How long the device has been at rest, s.
    rested_s: f64,
}

impl Drive {
    pub(crate) fn new(kind: SensorKind, limits: Limits) -> Self {
        let mut limits = limits;
        if kind == SensorKind::Light {
            limits.key_m_per_s = limits.key_m_per_s.min(HAND_M_PER_S);
        }
        Drive { kind, limits, led_m: 0.0, is_behind: false, rested_s: LEAVES_S }
    }

    /// Whether it leaves the key alone as long as the sensed value stays at 0.
    pub(crate) fn is_away(&self) -> bool {
        match self.kind {
            SensorKind::Action => self.led_m == 0.0,
            SensorKind::Light => self.rested_s >= LEAVES_S,
            SensorKind::Force => true,
        }
    }

    /// Whether the hand has to be laid on the key before a step in which it is pressed.
    pub(crate) fn begins(&self) -> bool {
        self.kind == SensorKind::Light && self.is_away()
    }

    /// The input of a step of `h` seconds from the sensed values, m or N, at its start and its end; `None` while the
    /// sensor is at rest. With it, whether it was limited, for the hammer would have been too fast.
    pub(crate) fn input(&mut self, sensed: Option<[f64; 2]>, h: f64, before: &Reading) -> (Input, bool) {
        let [start, end] = sensed.unwrap_or_default().map(|value| value.max(0.0));
        if self.kind == SensorKind::Force {
            let force_n = 0.5 * (start + end);
            let is_limited = force_n > self.limits.force_n;
            let force_n = force_n.clamp(0.0, self.limits.force_n);
            return (if force_n > 0.0 { Input::Force(force_n) } else { Input::Free }, is_limited);
        }
        let deepest_m = self.limits.dip_m + BEYOND_M;
        let [start, end] = [start, end].map(|m| m.min(deepest_m));
        self.rested_s = if sensed.is_some() { 0.0 } else { self.rested_s + h };
        let off_m = self.led_m - start;
        let wanted_m = if self.is_behind { end } else { end + off_m * (1.0 - h / SETTLES_S) };
        let [up_m, down_m] = [self.limits.up_m_per_s * h, self.limits.key_m_per_s * h];
        let from_m = self.led_m;
        let is_limited = wanted_m - from_m > down_m;
        self.led_m = from_m + (wanted_m - from_m).clamp(-up_m, down_m);
        self.is_behind = self.led_m != wanted_m && (wanted_m - self.led_m).abs() > LET_GO_M;
        if sensed.is_none() && self.led_m < LET_GO_M {
            self.led_m = 0.0;
        }
        let velocity_m_per_s = (self.led_m - from_m) / h;
        let input = match self.kind {
            SensorKind::Light if self.is_away() => Input::Free,
            SensorKind::Light => hand([0.5 * (from_m + self.led_m), velocity_m_per_s], before),
            _ if sensed.is_none() && self.led_m == 0.0 && from_m == 0.0 => Input::Free,
            _ => Input::Rigid { position_m: self.led_m, velocity_m_per_s },
        };
        (input, is_limited)
    }
}

/// A hand whose muscle follows a place, m, and its speed, m/s, with at most [`CEILING_N`].
fn hand([position_m, velocity_m_per_s]: [f64; 2], before: &Reading) -> Input {
    let hand = Hand { stiffness_n_per_m: STIFF_N_PER_M, damping_n_s_per_m: DAMPED_N_S_PER_M, ..Hand::default() };
    let muscle_n = hand.stiffness_n_per_m * (position_m - before.hand_m)
        + hand.damping_n_s_per_m * (velocity_m_per_s - before.hand_m_per_s);
    let muscle = if muscle_n.abs() > CEILING_N {
        Input::Force(CEILING_N.copysign(muscle_n))
    } else {
        Input::Motion { position_m, velocity_m_per_s }
    };
    // A hand refuses a motion that is imposed on the key only.
    hand.input(&muscle).unwrap_or(Input::Free)
}
