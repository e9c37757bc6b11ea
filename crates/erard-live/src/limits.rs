//! Largest inputs of a key, chosen so that no hammer goes faster than 8 m/s.

use moreau::Scalar;

/// No hammer goes faster at the string, m/s: 127 counts of the usual law, above what players reach (6.8 m/s).
pub const MAX_HAMMER_M_PER_S: f64 = 8.0;
/// The largest force of a hand on a key, N.
pub(crate) const CEILING_N: f64 = 60.0;

/// Largest inputs of a key.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits<T = f64> {
    /// The speed of its front, m/s, at which the hammer reaches [`MAX_HAMMER_M_PER_S`] if the key is suddenly
    /// driven down from its rest at that speed; if the hammer never does, the speed that throws it fastest. A key that
    /// is driven faster throws it no faster.
    pub key_m_per_s: T,
    /// The force, N, with this effect if it starts suddenly.
    pub force_n: T,
    /// Largest speed of the front when the key is let go, m/s, up positive: it is not pulled up faster.
    pub up_m_per_s: T,
    /// Dip under 5 N, m.
    pub dip_m: T,
    /// Rise of the hammer from rest to its string, m.
    pub blow_m: T,
}

impl Limits<f64> {
    /// The same in other numbers.
    #[must_use]
    pub fn to<T: Scalar>(&self) -> Limits<T> {
        let t = T::from_f64;
        Limits {
            key_m_per_s: t(self.key_m_per_s),
            force_n: t(self.force_n),
            up_m_per_s: t(self.up_m_per_s),
            dip_m: t(self.dip_m),
            blow_m: t(self.blow_m),
        }
    }
}
