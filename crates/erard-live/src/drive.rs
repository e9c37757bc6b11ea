//! Conversion of samples to the drive of a key in each step.

use moreau::{Scalar, SiteHand};

use crate::limits::{CEILING_N, Limits};

/// Kind of keyboard that carries the sensors.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SensorKind {
    /// The key of a real action, which moves with its hammer. Its motion is prescribed.
    Action,
    /// A switch or controller, which the finger moves without inertia. A hand with mass follows its depth, with at most
    /// 60 N.
    Light,
    /// A force on the key's front.
    Force,
}

/// Time within which a key reaches its sensed position after its sensor has come to rest or left its rest, s. A key
/// that was limited goes there at its largest allowed speed.
const SETTLES_S: f64 = 0.02;
/// The hand on a light device. Its muscle is stiffer than a pianist's, because only the device's position is known. It
/// reaches the ceiling of force at a lag of 3 mm. Estimates.
const HAND_KG: f64 = 0.2;
const STIFF_N_PER_M: f64 = 20e3;
const DAMPED_N_S_PER_M: f64 = 90.0;
/// Largest speed of the hand, m/s: 60 N do not accelerate hand and key beyond it within a dip.
const HAND_M_PER_S: f64 = 1.0;
/// A sensed key is driven no deeper than this below its dip, m.
pub(crate) const BEYOND_M: f64 = 0.5e-3;
/// A key driven to its rest is released when it is nearer than this, m.
const LET_GO_M: f64 = 1e-6;
/// A hand whose device is at rest leaves the key after this time, s.
const LEAVES_S: f64 = 0.2;

/// The drive of a key in a step: forces in N, positions in m from the key front's rest, both positive downward. The
/// numbers of a force or of a hand apply at the step's middle, those of a prescribed motion at its end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Push<T> {
    /// Nothing touches it.
    Free,
    /// A force on its front.
    Force(T),
    /// Its front's motion, prescribed.
    Rigid {
        /// m.
        position_m: T,
        /// m/s.
        velocity_m_per_s: T,
    },
    /// A hand.
    Hand(SiteHand<T>),
}

/// The drive of one key.
#[derive(Debug, Clone)]
pub(crate) struct Drive<T> {
    kind: SensorKind,
    limits: Limits<T>,
    /// Position to which the key is driven, m.
    led_m: T,
    /// Whether the key lags behind because it was limited.
    is_behind: bool,
    /// How long the device has been at rest, s.
    rested_s: T,
}

impl<T: Scalar> Drive<T> {
    pub(crate) fn new(kind: SensorKind, limits: Limits<T>) -> Self {
        let mut limits = limits;
        if kind == SensorKind::Light {
            limits.key_m_per_s = limits.key_m_per_s.min(T::from_f64(HAND_M_PER_S));
        }
        Drive { kind, limits, led_m: T::ZERO, is_behind: false, rested_s: T::from_f64(LEAVES_S) }
    }

    /// Whether nothing drives the key while the sensed value stays at 0.
    pub(crate) fn is_away(&self) -> bool {
        match self.kind {
            SensorKind::Action => self.led_m == T::ZERO,
            SensorKind::Light => self.rested_s >= T::from_f64(LEAVES_S),
            SensorKind::Force => true,
        }
    }

    /// Whether the hand must be placed on the key before the first step of a press.
    pub(crate) fn begins(&self) -> bool {
        self.kind == SensorKind::Light && self.is_away()
    }

    /// The push of a step of `h` seconds from the sensed values, m or N, at its start and its end; `None` while the
    /// sensor is at rest. `hand` gives the hand's place, m, and its speed, m/s. Also returns whether the push was
    /// limited because the hammer would have been too fast.
    pub(crate) fn push(&mut self, sensed: Option<[T; 2]>, h: T, hand: impl FnOnce() -> [T; 2]) -> (Push<T>, bool) {
        let zero = T::ZERO;
        let [start, end] = sensed.unwrap_or([zero; 2]).map(|value| value.max(zero));
        let half = T::from_f64(0.5);
        if self.kind == SensorKind::Force {
            let force_n = half * (start + end);
            let is_limited = force_n > self.limits.force_n;
            let force_n = force_n.max(zero).min(self.limits.force_n);
            return (if force_n > zero { Push::Force(force_n) } else { Push::Free }, is_limited);
        }
        let deepest_m = self.limits.dip_m + T::from_f64(BEYOND_M);
        let [start, end] = [start, end].map(|m| m.min(deepest_m));
        self.rested_s = if sensed.is_some() { zero } else { self.rested_s + h };
        let off_m = self.led_m - start;
        let wanted_m = if self.is_behind { end } else { end + off_m * (T::ONE - h / T::from_f64(SETTLES_S)) };
        let [up_m, down_m] = [self.limits.up_m_per_s * h, self.limits.key_m_per_s * h];
        let from_m = self.led_m;
        let is_limited = wanted_m - from_m > down_m;
        self.led_m = from_m + (wanted_m - from_m).max(-up_m).min(down_m);
        let near_m = T::from_f64(LET_GO_M);
        self.is_behind = self.led_m != wanted_m && (wanted_m - self.led_m).abs() > near_m;
        if sensed.is_none() && self.led_m < near_m {
            self.led_m = zero;
        }
        let velocity_m_per_s = (self.led_m - from_m) / h;
        let push = match self.kind {
            SensorKind::Light if self.is_away() => Push::Free,
            SensorKind::Light => follow([half * (from_m + self.led_m), velocity_m_per_s], hand()),
            _ if sensed.is_none() && self.led_m == zero && from_m == zero => Push::Free,
            _ => Push::Rigid { position_m: self.led_m, velocity_m_per_s },
        };
        (push, is_limited)
    }
}

/// A hand whose muscle follows a place, m, and its speed, m/s, with at most [`CEILING_N`], from where it is.
fn follow<T: Scalar>([position, velocity]: [T; 2], [hand_m, hand_m_per_s]: [T; 2]) -> Push<T> {
    let (stiffness, damping, z) = (T::from_f64(STIFF_N_PER_M), T::from_f64(DAMPED_N_S_PER_M), T::ZERO);
    let muscle_n = stiffness * (position - hand_m) + damping * (velocity - hand_m_per_s);
    let (mass, ceiling_n) = (T::from_f64(HAND_KG), T::from_f64(CEILING_N));
    let follows = SiteHand { mass, force: z, stiffness, damping, position, velocity, compliance: z, retardation: z };
    Push::Hand(if muscle_n.abs() > ceiling_n {
        let force = if muscle_n > z { ceiling_n } else { -ceiling_n };
        SiteHand { force, stiffness: z, damping: z, position: z, velocity: z, ..follows }
    } else {
        follows
    })
}
