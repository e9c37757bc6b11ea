//! The same note on every machine: 5 N for a quarter of a second, let go for another.

use moreau::Scalar;

use crate::Grand;
use crate::fnv1a::{FNV1A, fnv1a};

/// Length of a step, s.
pub const STEP_S: f64 = 50e-6;
/// Steps of the note.
pub const STEPS: u32 = 10_000;
const FORCE_N: f64 = 5.0;

/// What was found.
#[derive(Debug, Clone, Copy)]
pub struct Note {
    /// Of all angles at the end, as doubles.
    pub digest: u64,
    /// The hammer's fastest upward turning, rad/s.
    pub fastest_rad_s: f64,
}

/// What a step took, for who counts.
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
        let force = T::from_f64(if n < STEPS / 2 { FORCE_N } else { 0.0 });
        each(&mut || {
            let report = grand.step_force(force);
            Work { step: n, newton: report.newton, solver: report.solver }
        });
        fastest = fastest.max(grand.hammer_rad_s().to_f64());
    }
    Note { digest: digest(grand), fastest_rad_s: fastest }
}

/// FNV-1a over the bits of all angles, as doubles.
pub fn digest<T: Scalar>(grand: &Grand<T>) -> u64 {
    fnv1a(FNV1A, grand.state.angle.iter().flat_map(|angle| angle.to_f64().to_bits().to_le_bytes()))
}
