//! One pose of a stroke, and its lever arms.

/// Pose of the levers in a stroke. Metres, radians.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StrokePose {
    /// Travel of the key's front from rest, along its arc, positive down.
    pub key: f64,
    /// Direction of the key surface's normal; grows as the key goes down.
    pub k: f64,
    /// Whippen angle.
    pub w: f64,
    /// Hammer shank angle.
    pub h: f64,
    /// Position of the capstan's contact along the key (from the key's pivot, toward the player).
    pub s1: f64,
    /// Position of the knuckle's contact along the whippen (from its pivot, toward the player).
    pub s2: f64,
    /// Sliding between capstan and heel since rest, m: the change of `s1` less the length that a disc has rolled (a
    /// contact point without a radius only slides).
    pub capstan_sliding: f64,
    /// Sliding between knuckle and jack since rest, m: likewise, with `s2`.
    pub knuckle_sliding: f64,
    /// Vertical rise of the strike point from rest, toward the string.
    pub head_rise: f64,
    /// Upward speed of the strike point over the speed of the key's front.
    pub leverage: f64,
    /// Speed of the strike point along its arc over the speed of the key's front.
    pub arc_leverage: f64,
    /// Derivative dw/dk of the whippen angle by the key angle.
    pub whippen_ratio: f64,
    /// Derivative dh/dk of the hammer angle by the key angle.
    pub hammer_ratio: f64,
    /// Largest closure residual over the largest length.
    pub residual: f64,
    /// Newton steps for this pose.
    pub iterations: usize,
}

/// The six classical lever arms: straight distances from a pivot, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LeverArms {
    /// Distance from key pivot to the point where the finger presses.
    pub key_front: f64,
    /// Distance from key pivot to capstan contact.
    pub key_back: f64,
    /// Distance from whippen pivot to heel (capstan) contact.
    pub whippen_heel: f64,
    /// Distance from whippen pivot to jack (knuckle) contact.
    pub whippen_jack: f64,
    /// Distance from hammer pivot to knuckle contact.
    pub hammer_knuckle: f64,
    /// Distance from hammer pivot to strike point.
    pub hammer_head: f64,
}

impl LeverArms {
    /// Returns key back / key front x whippen jack / heel x hammer head / knuckle: the technician's overall ratio
    /// (Overs; Delacour). It assumes that every force is perpendicular to its arm, so that it only approximates the
    /// leverage.
    #[must_use]
    pub fn product(&self) -> f64 {
        self.key_back / self.key_front
            * (self.whippen_jack / self.whippen_heel)
            * (self.hammer_head / self.hammer_knuckle)
    }
}
