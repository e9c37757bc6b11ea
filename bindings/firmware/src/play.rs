//! Two notes, the same on every machine: 5 N for a quarter of a second, let go for another; then the same by a hand,
//! whose muscle lifts it off.

use moreau::Scalar;

use crate::Grand;
use crate::fnv1a::{FNV1A, fnv1a};

/// Length of a step, s.
pub const STEP_S: f64 = 50e-6;
/// Steps of both notes.
pub const STEPS: u32 = 20_000;
const FORCE_N: f64 = 5.0;
const LIFTING_N: f64 = -1.0;
const HAND_KG: f64 = 0.2;

/// The readings of one note.
#[derive(Debug, Clone, Copy)]
pub struct Note {
    /// Of all angles and of the hand's place at the end, as doubles.
    pub digest: u64,
    /// The hammer's fastest upward turning, rad/s.
    pub fastest_rad_per_s: f64,
}

/// Work of a step, for callers that count.
#[derive(Debug, Clone, Copy, Default)]
pub struct Work {
    /// Which, from 0.
    pub step: u32,
    /// Newton iterations.
    pub newton: u32,
    /// Active sets, summed over them.
    pub solver: u32,
}

/// Plays the note; `each` brackets every step: it is given the step to take, and what the step took afterwards.
pub fn play<T: Scalar>(grand: &mut Grand<T>, each: &mut dyn FnMut(&mut dyn FnMut() -> Work)) -> Note {
    let mut fastest = 0.0_f64;
    for n in 0..STEPS {
        let down = n % (STEPS / 2) < STEPS / 4;
        each(&mut || {
            let report = if n < STEPS / 2 {
                grand.step_force(T::from_f64(if down { FORCE_N } else { 0.0 }))
            } else {
                grand.step_hand(T::from_f64(HAND_KG), T::from_f64(if down { FORCE_N } else { LIFTING_N }))
            };
            Work { step: n, newton: report.newton, solver: report.solver }
        });
        fastest = fastest.max(grand.hammer_rad_per_s().to_f64());
    }
    Note { digest: digest(grand), fastest_rad_per_s: fastest }
}

/// FNV-1a over the bits of all angles and of the hand's place, as doubles.
pub fn digest<T: Scalar>(grand: &Grand<T>) -> u64 {
    let numbers = grand.state.angle.iter().chain(grand.state.hand.first());
    fnv1a(FNV1A, numbers.flat_map(|number| number.to_f64().to_bits().to_le_bytes()))
}
