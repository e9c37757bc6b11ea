//! Bench tests that distinguish places of friction: the key alone, a gauge at a flange, swings of a hammer.

use erard::IndexError;
use erard::grand::{Anatomy, Parts, strike_weight_g};
use erard::instrument::Instrument;

use crate::measure::MeasureError;

/// Arms at which flanges are gauged, m: a hammer's as in Renner's manual; a whippen's is our own.
const HAMMER_ARM_M: f64 = 0.023;
const WHIPPEN_ARM_M: f64 = 0.025;
/// Place of the strike weight, m.
const STRIKE_ARM_M: f64 = 0.130;
/// Largest friction of a flange that still moves, at 23 mm, gf: an estimate.
const MOST_G: f64 = 20.0;
/// Largest number of swings counted.
const MAX_SWINGS: u32 = 60;

/// Friction by place, gf.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bench {
    /// The key alone on its pins, at its front: half the difference of the weights that make it sink and rise.
    pub key_alone_g: f64,
    /// The hammer's pin, at 23 mm.
    pub hammer_g: f64,
    /// The whippen's pin, at 25 mm.
    pub whippen_g: f64,
    /// Number of times the hammer passes its lowest point when it is let go level.
    pub swings: u32,
}

impl Bench {
    /// Computes the friction from the dry torques of an instrument's pins over the arms.
    ///
    /// # Errors
    /// If the instrument is no grand action.
    pub fn of(instrument: &Instrument) -> Result<Self, MeasureError> {
        let anatomy = Anatomy::find(instrument)?;
        let torque = |body: usize| -> Result<f64, IndexError> {
            Ok(instrument.bodies[instrument.first_piece(body)?].friction_torque_n_m)
        };
        let grams = |torque_n_m: f64, arm_m: f64| 1e3 * torque_n_m / (arm_m * instrument.gravity_m_per_s2);
        let rigid = instrument.locked();
        let hammer_g = grams(torque(anatomy.hammer)?, HAMMER_ARM_M);
        Ok(Bench {
            key_alone_g: grams(torque(anatomy.key)?, instrument.roles.key_front_m[0].abs()),
            hammer_g,
            whippen_g: grams(torque(anatomy.whippen)?, WHIPPEN_ARM_M),
            swings: passes(hammer_g, strike_weight_g(&rigid, &Parts::of(&rigid)?)?),
        })
    }
}

/// Returns how often a hammer that is released level passes its lowest point, with a friction at 23 mm from its pin
/// (gf) and a strike weight (g).
///
/// A pendulum of moment M under a dry torque c: on each half swing the energy falls by c times the angle, so that its
/// turning points satisfy cos b - cos a = (c / M) (a + b), and it stays where sin a < c / M. (Without air drag.)
#[must_use]
pub fn passes(friction_g: f64, strike_weight_g: f64) -> u32 {
    let share = friction_g * HAMMER_ARM_M / (strike_weight_g * STRIKE_ARM_M);
    let mut from = std::f64::consts::FRAC_PI_2;
    for pass in 0..MAX_SWINGS {
        // It passes the lowest point if the energy lasts that far; bisection gives the next turning point.
        if 1.0 - libm::cos(from) <= share * from || libm::sin(from) <= share {
            return pass;
        }
        let [mut low, mut high] = [0.0, from];
        for _ in 0..60 {
            let to = 0.5 * (low + high);
            if libm::cos(to) - libm::cos(from) > share * (from + to) { low = to } else { high = to }
        }
        from = 0.5 * (low + high);
    }
    MAX_SWINGS
}

/// Step of the frictions that are compared with a count of swings, gf.
const STEP_G: f64 = 0.05;

/// Least and largest friction at 23 mm, gf, with which a hammer passes its lowest point so often; `None` if none does.
fn frictions(strike_weight_g: f64, is_counted: impl Fn(u32) -> bool) -> Option<[f64; 2]> {
    let grid = (1..=1000).map(|n| STEP_G * f64::from(n));
    let fits: Vec<f64> = grid.filter(|g| is_counted(passes(*g, strike_weight_g))).collect();
    Some([*fits.first()?, *fits.last()?])
}

/// Range of the friction at 23 mm, gf, of a hammer that passes its lowest point so often, lowest first.
pub(super) fn friction_of_swings(swings: f64, strike_weight_g: f64) -> [f64; 2] {
    let of = |count: f64| frictions(strike_weight_g, |passes| (f64::from(passes) - count).abs() < 0.5);
    // The count may be off by one swing, and the pendulum model by a quarter; a flange that still moves has no more
    // than a heavy case of the table.
    let low = of((swings + 1.0).min(f64::from(MAX_SWINGS))).map_or(STEP_G, |[low, _]| low);
    let high = of((swings - 1.0).max(0.0)).map_or(MOST_G, |[_, high]| high);
    [0.75 * low, (1.25 * high).min(MOST_G)]
}

/// Range of the friction at 23 mm, gf, of hammers whose swings lie in a range, by the pendulum; `None` if none do.
pub(super) fn sound_friction([least, most]: [f64; 2], strike_weight_g: f64) -> Option<[f64; 2]> {
    frictions(strike_weight_g, |passes| (least..=most).contains(&f64::from(passes)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// D. Stanwood, Pianotech list, 18 December 2002, gauge at 32 mm: strike weight 10 g, 2.5 gf, 8 swings, and 7.0 gf,
    /// 4 swings; strike weight 8 g, 2 gf, 8 swings, and 4 gf, 4 swings. The pendulum makes 11, 3, 11 and 5 of them: it
    /// has no air drag, and a gauge at rest reads more than a pin in motion.
    #[test]
    fn swings_that_were_counted() {
        for (strike_g, at_32_mm, counted, by_pendulum) in
            [(10.0, 2.5, 8, 11), (10.0, 7.0, 4, 3), (8.0, 2.0, 8, 11), (8.0, 4.0, 4, 5)]
        {
            let found = passes(at_32_mm * 32.0 / 23.0, strike_g);
            assert_eq!(found, by_pendulum, "{strike_g} {at_32_mm}");
            assert!(found.abs_diff(counted) <= 3, "{strike_g} {at_32_mm}: {found}, counted {counted}");
        }
        assert_eq!(passes(100.0, 9.0), 0);
        let [low, high] = friction_of_swings(5.0, 9.0);
        assert!(low < high && passes(low, 9.0) >= 5 && passes(high, 9.0) <= 5, "{low} {high}");
        let [low, high] = sound_friction([4.0, 9.0], 9.0).unwrap();
        assert!((passes(low, 9.0), passes(high, 9.0)) == (9, 4) && passes(high + 0.05, 9.0) == 3, "{low} {high}");
    }
}
