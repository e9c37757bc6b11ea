//! Modal strings: stiff strings in their modes, each stepped exactly, under the hammer's felt.
//!
//! **A string** of length L, mass per length mu, tension T and bending stiffness EI on two rigid supports has the
//! modes sin(n pi x / L) with the mass m = mu L / 2 and, (S1) of the book,
//!
//! ```text
//! omega_n = 2 pi n f0 sqrt(1 + B n^2),   f0 = sqrt(T/mu) / (2 L),   B = pi^2 EI / (T L^2)
//! m (q'' + 2 sigma_n q' + omega_n^2 q) = sin(n pi x0 / L) F,   sigma_n = b1 + b3 omega_n^2
//! ```
//!
//! (H. Fletcher, *Normal vibration frequencies of a stiff piano string*, JASA 36 (1964) 203-209; the losses in the form
//! of A. Chaigne and A. Askenfelt, *Numerical simulations of piano strings*, JASA 95 (1994) 1112-1118).
//!
//! **A step.** The felt's force F holds for a step h. Each mode then moves exactly: with q_s = sin(...) F / (m omega^2)
//! where it would rest,
//!
//! ```text
//! (q - q_s, q') -> P (q - q_s, q'),   P = exp(-sigma h) [ c + sigma s, s ; -omega^2 s, c - sigma s ],   c = cos(w h), s = sin(w h)/w, w^2 = omega^2 - sigma^2
//! ```
//!
//! at every length of step: nothing can become unstable. The felt needs two numbers of the string: its position without
//! the felt's force, u_free, and its displacement per newton by the step's end, (S2) of the book, A = sum of sin^2 (1 -
//! P_11) / (m omega^2), without losses sin^2 (1 - cos(omega h)) / (m omega^2). The work of F on the modes is exactly F
//! times the displacement of the struck point, so that no energy is gained or lost between felt and string
//! (`crates/moreau/README.md`, "Compliant surfaces").
//!
//! **Which modes are stepped** does not depend on the step: those below 20 kHz, and 32 a string at least. The others
//! follow the force as a spring does: their static compliance is added to A. They store energy as the force changes,
//! and never return more than they stored. Those above 20 kHz are not part of the force on the bridge.
//!
//! **Steps are halved** while the hammer is near the strings, as often as its impact needs (`modal/parts.rs`).
//!
//! **Several strings** of a note are struck by one felt. The mean of their displacements compresses it, and it presses
//! each with an equal part of its force: u = sum u_i / N and F_i = F / N, with equal work, sum F_i du_i = F du. Strings
//! of one note differ by less than a cent, so that within an impact they move together. They are coupled only if the
//! bridge moves (`bridge.rs`); dampers lie on each by itself (`damping.rs`), and the pedal lifts them (`pedal.rs`).
//!
//! **Several places** on one string, the hammer's and the damper's, displace each other within a step by little: at 50
//! us a wave goes 16 mm. Their forces are found together ([`moreau_kernels::Surfaces::coupled`]), and with them what
//! rocks the dampers' felts and the mean displacement of a bridge that moves, which are linear in them (`damping.rs`,
//! `bridge.rs`): the energy balance closes exactly (`tests/it/dampers.rs`).

mod bridge;
mod damping;
mod modal;
mod pedal;
mod rows;
mod shape_probe;

pub use modal::Strings;
pub use pedal::{MAX_PEDAL_M, PEDAL_M_PER_S, Pedal, PedalError};
pub(crate) use rows::transition;
pub use shape_probe::ShapeProbe;

use crate::instrument::Instrument;

/// Usual steps, s.
pub(crate) const STEP_S: f64 = 50e-6;
/// Usual steps of an instrument whose strings sound, s.
const SOUNDING_STEP_S: f64 = 1.0 / 24e3;
/// Largest swing of a string toward the hammer, m: the engine does not test a hammer that is farther away. In a
/// fortissimo strings swing by 3 mm.
const EXCURSION_M: f64 = 5e-3;
/// Likewise toward the damper, which lies nearer to the end.
const DAMPER_EXCURSION_M: f64 = 3e-3;

/// The zones whose surfaces yield or are moved, and how far these may come toward the mechanism, m. None where the
/// string is rigid.
pub(crate) fn yielding_zones(instrument: &Instrument) -> Vec<(usize, f64)> {
    let Some(string) = instrument.roles.string.filter(|_| instrument.has_yielding_strings()) else {
        return Vec::new();
    };
    let dampers = instrument.strings.iter().filter_map(|one| one.damper).map(|felt| (felt.zone, DAMPER_EXCURSION_M));
    let pedal = instrument.roles.pedal.map(|zone| (zone, MAX_PEDAL_M));
    [(string, EXCURSION_M)].into_iter().chain(dampers).chain(pedal).collect()
}

/// Losses of the strings of a note, J. Their sum is the surfaces' loss of the ledger.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct StringLosses {
    /// By the strings' own damping.
    pub strings_j: f64,
    /// By the damping of a moving bridge: the work of the strings on it, less the energy that is still in its modes.
    pub bridge_j: f64,
    /// In dampers' felts that are rocked; what these lose as they are compressed is the loss of their contacts.
    pub rocking_j: f64,
}

impl StringLosses {
    /// All together, J.
    #[must_use]
    pub(crate) fn all_j(&self) -> f64 {
        self.kinds_j().iter().sum()
    }

    /// Strings, bridge, rocked felts, J.
    pub(crate) fn kinds_j(&self) -> [f64; 3] {
        [self.strings_j, self.bridge_j, self.rocking_j]
    }
}

impl std::ops::Sub for StringLosses {
    type Output = Self;

    fn sub(self, before: Self) -> Self {
        StringLosses {
            strings_j: self.strings_j - before.strings_j,
            bridge_j: self.bridge_j - before.bridge_j,
            rocking_j: self.rocking_j - before.rocking_j,
        }
    }
}

impl Instrument {
    /// Whether the hammer's string is modal: strings are described and not declared rigid.
    #[must_use]
    pub fn has_yielding_strings(&self) -> bool {
        self.roles.string.is_some() && !self.strings.is_empty() && !self.roles.rigid_string
    }

    /// The usual length of a step, s: 50 us; where strings sound 1/24 000 s, of which samples of sound are whole parts.
    #[must_use]
    pub fn usual_step_s(&self) -> f64 {
        if self.has_yielding_strings() { SOUNDING_STEP_S } else { STEP_S }
    }

    /// A copy of the instrument with a rigid string.
    #[must_use]
    pub fn with_rigid_string(&self) -> Self {
        let mut other = self.clone();
        other.fields.roles.rigid_string = true;
        other
    }
}
