//! A finger that follows a path on a key: what `erard scan` plays, and what contacts are calibrated with.

use erard::player::{Hand, Joints};
use erard::stroke::least_jerk;

/// A finger with a part of the hand, and the muscle that drives it, kg, N/m, N s/m. Estimates: it follows a path of 10
/// Hz, and deviates by 0.8 mm under 5 N.
pub const FINGER: Hand = Hand {
    mass_kg: 0.1,
    stiffness_n_per_m: 6000.0,
    damping_n_s_per_m: 35.0,
    start_m: 0.0,
    start_m_per_s: 0.0,
    joints: Joints::STIFF,
};

/// A piece of a finger's path, of least jerk: its duration, s, and its final depth, m below the key front's rest.
pub type Leg = [f64; 2];

/// Prescribed position of the finger `t` s after the start of a path from a depth, m, and its speed, m/s, both down
/// positive.
#[must_use]
pub fn place(from_m: f64, path: &[Leg], t: f64) -> [f64; 2] {
    let (mut from_s, mut from_m) = (0.0, from_m);
    for &[takes_s, to_m] in path {
        if t < from_s + takes_s {
            let [x, v] = least_jerk((t - from_s) / takes_s);
            return [from_m + (to_m - from_m) * x, (to_m - from_m) * v / takes_s];
        }
        (from_s, from_m) = (from_s + takes_s, to_m);
    }
    [from_m, 0.0]
}
