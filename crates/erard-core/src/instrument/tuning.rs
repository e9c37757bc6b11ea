//! Frequencies, losses and compliances of a string, from its parameters.

use core::f64::consts::PI;

use super::PianoString;

/// Density of steel wire, kg/m3.
pub(crate) const STEEL_DENSITY_KG_M3: f64 = 7850.0;
/// Young's modulus of steel wire, Pa.
pub(crate) const STEEL_YOUNG_PA: f64 = 2.02e11;
/// Frequency above which partials are left out of the force on the bridge, Hz: they are inaudible.
pub(crate) const REACH_HZ: f64 = 20e3;
/// Frequency above which partials across the blow are left out, Hz: their aftersound is inaudible.
const SIDE_REACH_HZ: f64 = 5e3;
/// Smallest number of partials that are stepped. A treble string has few below 20 kHz, and the static displacement by
/// the others would follow the felt's force half a step late.
const LEAST_MODES: u32 = 32;
/// Number of partials in a static compliance: the higher ones add less than a thousandth to it.
const STATIC_PARTIALS: u32 = 4000;

/// Bending stiffness of a round steel wire, N m2, from its diameter, m.
pub(crate) fn bending_stiffness(diameter_m: f64) -> f64 {
    let square = diameter_m * diameter_m;
    STEEL_YOUNG_PA * PI * square * square / 64.0
}

/// Returns the tension, N, that gives the first partial of a string a frequency, Hz. It is not positive if the bending
/// stiffness alone makes the frequency higher.
pub(crate) fn tension_for(frequency_hz: f64, length_m: f64, mass_kg_per_m: f64, bending_n_m2: f64) -> f64 {
    let square = length_m * length_m;
    // f^2 = f0^2 (1 + B) = (T + pi^2 EI / L^2) / (4 mu L^2).
    4.0 * mass_kg_per_m * square * frequency_hz * frequency_hz - PI * PI * bending_n_m2 / square
}

impl PianoString {
    /// Frequency f0 = sqrt(T/mu)/(2 L), Hz, of the first partial without bending stiffness.
    #[must_use]
    pub fn ideal_hz(&self) -> f64 {
        (self.tension_n / self.mass_kg_per_m).sqrt() / (2.0 * self.length_m)
    }

    /// Inharmonicity B of f_n = n f0 sqrt(1 + B n^2).
    #[must_use]
    pub fn inharmonicity(&self) -> f64 {
        PI * PI * self.bending_n_m2 / (self.tension_n * self.length_m * self.length_m)
    }

    /// Frequency of a partial, Hz, without losses (which lower it by less than a millionth).
    #[must_use]
    pub fn partial_hz(&self, n: u32) -> f64 {
        let n = f64::from(n);
        n * self.ideal_hz() * (1.0 + self.inharmonicity() * n * n).sqrt()
    }

    /// Decay rate of a partial's amplitude, 1/s.
    #[must_use]
    pub fn decay_per_s(&self, n: u32) -> f64 {
        let omega = 2.0 * PI * self.partial_hz(n);
        self.loss_per_s + self.loss_s * omega * omega
    }

    /// Mass of a mode, kg.
    #[must_use]
    pub fn modal_mass_kg(&self) -> f64 {
        0.5 * self.mass_kg_per_m * self.length_m
    }

    /// Number of partials below a frequency, Hz.
    #[must_use]
    pub fn partials_below(&self, hz: f64) -> u32 {
        (1..STATIC_PARTIALS).take_while(|&n| self.partial_hz(n) < hz).count() as u32
    }

    /// Number of partials that are stepped, at any length of step: those below 20 kHz, and at least 32.
    #[must_use]
    pub(crate) fn stepped(&self) -> u32 {
        self.partials_below(REACH_HZ).max(LEAST_MODES)
    }

    /// Number of partials across the blow that are stepped: those below 5 kHz of a string that moves sideways.
    #[must_use]
    pub(crate) fn stepped_sideways(&self) -> u32 {
        self.strike_angle_rad.map_or(0, |_| self.partials_below(SIDE_REACH_HZ).max(1))
    }

    /// The blow's direction: in the direction of the string's main motion, and across it.
    #[must_use]
    pub(crate) fn strike_direction(&self) -> [f64; 2] {
        self.strike_angle_rad.map_or([1.0, 0.0], |angle| [libm::cos(angle), libm::sin(angle)])
    }

    /// Shape of mode `n` (amplitude 1) at a place, m from the end opposite the bridge.
    #[must_use]
    pub(crate) fn shape(n: u32, place_m: f64, length_m: f64) -> f64 {
        libm::sin(f64::from(n) * PI * place_m / length_m)
    }

    /// Static compliance at the strike point of all modes beyond the first `n`, m/N.
    pub(crate) fn static_compliance_beyond(&self, n: u32) -> f64 {
        let of = |n: u32| {
            let (shape, omega) = (Self::shape(n, self.strike_m, self.length_m), 2.0 * PI * self.partial_hz(n));
            shape * shape / (self.modal_mass_kg() * omega * omega)
        };
        // The small terms first, for less rounding.
        (n + 1..=STATIC_PARTIALS.max(n + 1)).rev().map(of).sum()
    }

    /// Force on the bridge per metre of a mode's displacement, N/m: -(T u' - EI u''') at the string's end.
    pub(crate) fn bridge_n_per_m(&self, n: u32) -> f64 {
        let (wave, square) = (f64::from(n) * PI / self.length_m, f64::from(n) * f64::from(n));
        let slope = if n.is_multiple_of(2) { wave } else { -wave };
        -self.tension_n * (1.0 + self.inharmonicity() * square) * slope
    }
}
