//! Knocks: what the felts of the action make heard of the key bed and of the rails that stand on it. An estimate.
//!
//! Whatever a felt presses that does not move stands on the key bed: the punchings under the keys, the rails of let-off
//! buttons, drop screws and hammers, the rail that stops the dampers' levers and the one by which the pedal lifts them.
//! A felt's force F is known; it moves the modes of the bed and is not changed by them, for the bed yields by some 0.1
//! mm/s a newton, and felts are struck at 100 mm/s and more:
//!
//! ```text
//! M_k (q_k'' + eta_k w_k q_k' + w_k^2 q_k) = F,   p = sum g_k q_k'
//! ```
//!
//! with g_k as for a soundboard. A force that is constant within a sample moves a mode around its static
//! displacement F / (M w^2), exactly. So a force that does not change is silent, and the bed is one for all keys: it
//! hears by how much the sum of their forces changes.
//!
//! The bed is a plank of 45 mm of spruce, 1.4 m by 0.6 m, 450 kg/m3 (E 11 and 0.8 GPa along and across the grain): 20
//! kg/m2, bending stiffness D = sqrt(11 * 0.8) GPa (45 mm)^3 / 12 = 22 kN m. Hence its modal density (S / 2) sqrt(mu /
//! D) = 0.0125 / Hz, and its coincidence c^2 / (2 pi) sqrt(mu / D) = 560 Hz. Its loss factor, with all that stands on
//! it, is a guess. No measurement of a piano's key bed was found.
//!
//! Left out: what the pivots carry, where on the bed a key lies, and the noise of fingers. The felt of a damper knocks
//! against the strings, and is heard through them.

use std::f64::consts::PI;

use crate::instrument::{Band, BridgeMode, Instrument};
use crate::radiation::Plate;
use crate::strings::transition;

/// The bed (see above).
pub(crate) const BED: Plate = Plate { kg_per_m2: 20.0, coincidence_hz: 560.0 };
/// Its modes: from its lowest, a bar of its length with free ends, to where no felt excites any.
const BAND: Band =
    Band { hz: [80.0, 5000.0], modes_per_hz: 0.0125, mass_kg: 20.0 * 0.84, loss_factor: 0.05, horizontal: 0.0 };
/// Energy per kg below which a mode is still, J/kg: 1e-9 m/s, less than 1e-7 Pa. Decaying for ever, it would end in
/// numbers that are slow to compute with.
const STILL_J_PER_KG: f64 = 1e-18;

/// What knocks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Knock {
    /// Keys on their punchings, at rest and at the bottom.
    KeyBed,
    /// Jacks, levers and hammers on the rails of the action. (A hammer that falls back on its whippen is heard through
    /// key and key bed.)
    ActionRails,
    /// Levers of dampers on their stop and on the pedal's rail.
    DamperRail,
}

impl Knock {
    /// All of them.
    pub const ALL: [Self; 3] = [Knock::KeyBed, Knock::ActionRails, Knock::DamperRail];

    /// As it is typed, e.g. `key-bed`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Knock::KeyBed => "key-bed",
            Knock::ActionRails => "action-rails",
            Knock::DamperRail => "damper-rail",
        }
    }
}

/// The felts of an instrument that knock.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Knocks(Vec<usize>);

impl Knocks {
    /// The zones between moving parts and what does not move, but for strings, of the knocks that are asked for.
    #[must_use]
    pub fn of(instrument: &Instrument, knocks: &[Knock]) -> Self {
        let roles = &instrument.roles;
        let bodies = |index: usize| {
            let zone = &instrument.zones[index];
            match (zone.disc_body, zone.curve_body) {
                (Some(body), None) | (None, Some(body)) => Some(body),
                _ => None,
            }
        };
        let carries = |body: usize, part: Option<usize>| {
            std::iter::successors(part, |of| instrument.bodies[*of].parent).any(|one| one == body)
        };
        let of = |index: usize| {
            let damps =
                instrument.strings.iter().filter_map(|string| string.damper.as_ref()).any(|felt| felt.zone == index);
            let body = bodies(index).filter(|_| roles.string != Some(index) && !damps)?;
            Some(if carries(body, roles.key) {
                Knock::KeyBed
            } else if carries(body, roles.pedal.and_then(bodies)) {
                Knock::DamperRail
            } else {
                Knock::ActionRails
            })
        };
        Knocks((0..instrument.zones.len()).filter(|zone| of(*zone).is_some_and(|one| knocks.contains(&one))).collect())
    }

    /// The zones.
    pub(crate) fn zones(&self) -> &[usize] {
        &self.0
    }

    /// The sum of their forces, N, of each zone's.
    #[must_use]
    pub fn force_n(&self, of: impl Fn(usize) -> f64) -> f64 {
        self.0.iter().map(|zone| of(*zone)).sum()
    }
}

/// The key bed's modes.
pub(crate) fn modes() -> Vec<BridgeMode> {
    BAND.modes("key bed", 0)
}

/// A mode of the bed, around its static displacement.
#[derive(Debug, Clone)]
struct Moving {
    /// Displacement, m, and velocity, m/s.
    at: [f64; 2],
    /// Rows of what a sample makes of them.
    by: [[f64; 2]; 2],
    /// Static displacement per force, m/N.
    m_per_n: f64,
    /// rad/s.
    omega: f64,
    /// At two places, Pa s/m.
    gain: [f64; 2],
}

/// The key bed, as it is heard.
#[derive(Debug, Clone)]
pub struct KeyBed {
    modes: Vec<Moving>,
    is_still: bool,
    /// The force on it that was heard of last, N.
    force_n: Option<f64>,
}

impl KeyBed {
    /// At rest; it is stepped by samples of so many a second.
    #[must_use]
    pub fn new(rate_hz: f64) -> Self {
        let modes = modes();
        let h = 1.0 / rate_hz;
        let moving = |(mode, gain): (&BridgeMode, [f64; 2])| {
            let omega = 2.0 * PI * mode.frequency_hz;
            let [qq, qv, vq, vv] = transition(omega, 0.5 * mode.loss_factor * omega, h);
            let by = [[qq, qv], [vq, vv]];
            Moving { at: [0.0; 2], by, m_per_n: 1.0 / (mode.mass_kg * omega * omega), omega, gain }
        };
        KeyBed { modes: modes.iter().zip(BED.gains(&modes)).map(moving).collect(), is_still: true, force_n: None }
    }

    /// What is heard at the end of a sample in which this force is on the bed, N; the first one is on it since long:
    /// the pressure at two places, Pa.
    #[must_use]
    pub fn hear(&mut self, force_n: f64) -> [f64; 2] {
        let before_n = self.force_n.replace(force_n).unwrap_or(force_n);
        self.step(force_n - before_n)
    }

    /// The next force is on the bed since long; what it moves still is heard.
    pub fn forget(&mut self) {
        self.force_n = None;
    }

    /// What is heard at the end of a sample within which the force on the bed is larger than in the one before by this,
    /// N: the pressure at two places, Pa.
    #[must_use]
    pub fn step(&mut self, change_n: f64) -> [f64; 2] {
        let mut heard = [0.0; 2];
        if self.is_still && change_n == 0.0 {
            return heard;
        }
        self.is_still = true;
        for mode in &mut self.modes {
            let [q, v] = [mode.at[0] - mode.m_per_n * change_n, mode.at[1]];
            let [q, v] = mode.by.map(|[by_q, by_v]| by_q * q + by_v * v);
            let swing = mode.omega * q;
            if swing * swing + v * v < STILL_J_PER_KG {
                mode.at = [0.0; 2];
                continue;
            }
            self.is_still = false;
            mode.at = [q, v];
            heard.iter_mut().zip(mode.gain).for_each(|(heard, gain)| *heard += gain * v);
        }
        heard
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RATE_HZ: f64 = 48_000.0;

    fn named(instrument: &Instrument, knocks: &[Knock]) -> Vec<String> {
        Knocks::of(instrument, knocks).0.iter().map(|zone| instrument.zones[*zone].name.clone()).collect()
    }

    #[test]
    fn what_knocks_is_found_by_what_it_carries() {
        let instrument = Instrument::builtin("concert-grand-strings").unwrap();
        assert_eq!(named(&instrument, &[Knock::KeyBed]), ["key_front", "balance_rail", "key_back_rail"]);
        assert_eq!(named(&instrument, &[Knock::ActionRails]), ["let_off_button", "drop_screw"]);
        assert_eq!(named(&instrument, &[Knock::DamperRail]), ["damper_stop", "damper_tray"]);
        assert!(named(&instrument, &[]).is_empty());
        for name in ["concert-grand", "concert-grand-rigid", "steinway-o"] {
            let other = Instrument::builtin(name).unwrap();
            assert!(named(&other, &Knock::ALL).len() >= 3, "{name}");
        }
    }

    /// A force that swings for long moves the bed as its admittance says, sum of i w / (M (w_k^2 - w^2 + i eta w_k w)).
    #[test]
    fn a_swinging_force_is_heard_as_the_admittance_says() {
        for hz in [150.0, 440.0, 1300.0] {
            let omega = 2.0 * PI * hz;
            let (mut bed, mut before, mut sums) = (KeyBed::new(RATE_HZ), 0.0, [[0.0; 2]; 2]);
            for n in 0..48_000 {
                // The force of a sample is that of its middle.
                let force = libm::sin(omega * (f64::from(n) - 0.5) / RATE_HZ);
                let heard = bed.step(force - before);
                before = force;
                if n >= 24_000 {
                    let at = omega * f64::from(n) / RATE_HZ;
                    for (sum, heard) in sums.iter_mut().zip(heard) {
                        sum[0] += heard * libm::sin(at) / 12_000.0;
                        sum[1] += heard * libm::cos(at) / 12_000.0;
                    }
                }
            }
            let modes = modes();
            let mut expected = [[0.0; 2]; 2];
            for (mode, gain) in modes.iter().zip(BED.gains(&modes)) {
                let w = 2.0 * PI * mode.frequency_hz;
                let (spring, loss) = (w * w - omega * omega, mode.loss_factor * w * omega);
                let by = omega / (mode.mass_kg * (spring * spring + loss * loss));
                for (expected, gain) in expected.iter_mut().zip(gain) {
                    expected[0] += gain * by * loss;
                    expected[1] += gain * by * spring;
                }
            }
            for (found, expected) in sums.iter().zip(expected) {
                let off = (found[0] - expected[0]).hypot(found[1] - expected[1]);
                assert!(off < 0.01 * expected[0].hypot(expected[1]), "{hz} Hz: {found:?} {expected:?}");
            }
        }
    }

    /// A force that stays is silent after a second, to the bit, and costs nothing then.
    #[test]
    fn a_force_that_stays_is_silent() {
        let mut bed = KeyBed::new(RATE_HZ);
        let first = bed.step(20.0);
        assert!(first[0].abs() > 1e-4 && !bed.is_still, "{first:?}");
        let heard: Vec<[f64; 2]> = (0..96_000).map(|_| bed.step(0.0)).collect();
        assert!(bed.is_still && heard.last() == Some(&[0.0; 2]));
    }
}
