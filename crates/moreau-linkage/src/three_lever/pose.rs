//! One pose of a stroke, and its lever arms.

/// One pose of a stroke. Metres, radians.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StrokePose {
    /// Travel of the key's front since rest, along its arc, down positive.
    pub key: f64,
    /// Direction of the key surface's normal; grows as the key goes down.
    pub k: f64,
    /// Whippen.
    pub w: f64,
    /// Hammer shank.
    pub h: f64,
    /// Place of the capstan's contact along the key (from the key's pivot, toward the player).
    pub s1: f64,
    /// Place of the knuckle's contact along the whippen (from its pivot, toward the player).
    pub s2: f64,
    /// Sliding of capstan and heel along each other since rest, m: the change of `s1`,
    /// less what a disc has rolled (a contact point without a radius only slides).
    pub capstan_sliding: f64,
    /// Sliding of knuckle and jack, with `s2`.
    pub knuckle_sliding: f64,
    /// Rise of the strike point since rest, straight up, toward the string.
    pub head_rise: f64,
    /// Upward speed of the strike point over the speed of the key's front.
    pub leverage: f64,
    /// Speed of the strike point along its arc over the speed of the key's front.
    pub arc_leverage: f64,
    /// dw/dk: whippen angle over key angle, first order.
    pub whippen_ratio: f64,
    /// dh/dk: hammer angle over key angle, first order.
    pub hammer_ratio: f64,
    /// Largest closure residual over the largest length.
    pub residual: f64,
    /// Newton steps the pose took.
    pub iterations: usize,
}

/// The six classical lever arms (m): straight distances from a pivot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LeverArms {
    /// Key pivot to where the finger presses.
    pub key_front: f64,
    /// Key pivot to capstan contact.
    pub key_back: f64,
    /// Whippen pivot to heel (capstan) contact.
    pub whippen_heel: f64,
    /// Whippen pivot to jack (knuckle) contact.
    pub whippen_jack: f64,
    /// Hammer pivot to knuckle contact.
    pub hammer_knuckle: f64,
    /// Hammer pivot to strike point.
    pub hammer_head: f64,
}

impl LeverArms {
    /// key back / key front x whippen jack / heel x hammer head / knuckle: the
    /// technician's overall ratio (Overs; Delacour). It takes every force as
    /// square to its arm, so it is not the leverage, only near it.
    #[must_use]
    pub fn product(&self) -> f64 {
        self.key_back / self.key_front
            * (self.whippen_jack / self.whippen_heel)
            * (self.hammer_head / self.hammer_knuckle)
    }
}
