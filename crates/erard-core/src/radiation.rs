//! What a plate radiates, soundboard or key bed, as it is heard at two places before it, without a room: an estimate.
//!
//! **How loud a mode is.** A mode of effective mass M that moves the place of the force at v has the kinetic energy M
//! v^2 / 2, which is that of the whole plate: of a mass mu per area it moves with S u^2 = M v^2 / mu in the mean over
//! its area S. It radiates P = sigma rho c S u^2 into half the space, which at a distance d makes p^2 / (rho c) = P /
//! (2 pi d^2),
//!
//! ```text
//! p = g v,   g = (rho c / d) sqrt(sigma M / (2 pi mu))
//! ```
//!
//! **Coincidence.** Below the frequency f_c at which a plate's bending waves are as fast as sound, neighbouring parts
//! that move against each other cancel: sigma = f^2 / (f^2 + f_c^2), which rises by 6 dB an octave and then is 1.
//!
//! **Two places.** What a mode sends to a place has a sign and a size that depend on its shape: sqrt(2) cos phi, with a
//! random phase phi. Two places that are apart by less than a wavelength hear nearly the same phase.
//!
//! What is left out: the lid, the room, and what radiation takes from a mode, which is a part of its loss factor.

use std::f64::consts::{PI, SQRT_2};

use crate::instrument::{BridgeMode, Random};

/// Impedance of air at 20 degrees, kg/(m2 s), and the speed of sound in it, m/s.
const AIR_KG_PER_M2_S: f64 = 413.0;
const SOUND_M_PER_S: f64 = 343.0;
/// How far from the plate the places are, and from each other, m.
const DISTANCE_M: f64 = 1.0;
const APART_M: f64 = 0.5;

/// A plate that radiates.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Plate {
    /// Mass per area, kg/m2.
    pub kg_per_m2: f64,
    /// Coincidence, Hz.
    pub coincidence_hz: f64,
}

/// A soundboard: 9 kg with ribs and bridges over some 1.3 m2, and its coincidence (K. Ege and X. Boutillon, an
/// upright).
pub(crate) const BOARD: Plate = Plate { kg_per_m2: 7.0, coincidence_hz: 1800.0 };

impl Plate {
    /// Share of a plane wave's power that a mode radiates.
    fn efficiency(self, hz: f64) -> f64 {
        let square = hz * hz;
        square / (square + self.coincidence_hz * self.coincidence_hz)
    }

    /// Sound pressure at the two places per velocity of each mode at the place of the force, Pa s/m.
    pub(crate) fn gains(self, modes: &[BridgeMode]) -> Vec<[f64; 2]> {
        modes.iter().map(|mode| self.gain(mode)).collect()
    }

    fn gain(self, mode: &BridgeMode) -> [f64; 2] {
        let mut random = Random::named(&mode.name, 0);
        let (phase, share) = (2.0 * PI * random.part(), random.part() - 0.5);
        let half = PI * mode.frequency_hz * APART_M * share / SOUND_M_PER_S;
        let power = self.efficiency(mode.frequency_hz) * mode.mass_kg / (2.0 * PI * self.kg_per_m2);
        let gain = AIR_KG_PER_M2_S / DISTANCE_M * power.sqrt();
        [-half, half].map(|side| gain * SQRT_2 * libm::cos(phase + side))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::instrument::Instrument;
    use crate::knocks;

    /// The part of a mode's loss factor that is what it radiates, to both sides: P = omega eta M v^2.
    fn loss_factor(plate: Plate, hz: f64) -> f64 {
        2.0 * plate.efficiency(hz) * AIR_KG_PER_M2_S / (2.0 * PI * hz * plate.kg_per_m2)
    }

    /// The shipped board and the key bed radiate less than they lose, at every mode; and the mean square of what their
    /// modes send to the two places is that of an even radiation into half the space.
    #[test]
    fn plates_radiate_a_part_of_what_they_lose() {
        let instrument = Instrument::builtin("concert-grand-strings").unwrap();
        let modes = &instrument.bridge_modes;
        radiates_a_part(BOARD, modes);
        radiates_a_part(knocks::BED, &knocks::modes());
        // Low modes are heard alike on both sides, high ones are not.
        let gains = BOARD.gains(modes);
        let alike = |from: f64, to: f64| {
            let band = modes.iter().zip(&gains).filter(|(mode, _)| (from..to).contains(&mode.frequency_hz));
            let [lr, ll, rr] = band.fold([0.0; 3], |[lr, ll, rr], (_, [l, r])| [lr + l * r, ll + l * l, rr + r * r]);
            lr / (ll * rr).sqrt()
        };
        let [low, high] = [alike(40.0, 200.0), alike(2000.0, 6000.0)];
        assert!(low > 0.9 && high < 0.7, "{low} {high}");
    }

    fn radiates_a_part(plate: Plate, modes: &[BridgeMode]) {
        let gains = plate.gains(modes);
        let (mut even, mut heard) = (0.0, [0.0; 2]);
        for (mode, gain) in modes.iter().zip(&gains) {
            let radiated = loss_factor(plate, mode.frequency_hz);
            assert!(radiated < mode.loss_factor, "{}: {radiated}", mode.name);
            let [left, right] = gain.map(|g| g * g / mode.mass_kg / plate.efficiency(mode.frequency_hz));
            even += AIR_KG_PER_M2_S * AIR_KG_PER_M2_S / (2.0 * PI * plate.kg_per_m2);
            heard = [heard[0] + left, heard[1] + right];
        }
        for heard in heard {
            assert!((heard / even - 1.0).abs() < 0.25, "{}", heard / even);
        }
    }
}
