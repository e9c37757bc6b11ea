//! A velocity, whatever its number of bits.

/// A velocity of a note in counts of MIDI 1.0, 0 to 127, with the fractions that additional bits can express. By a
/// logarithmic law one count is 2.8 % of hammer speed.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub struct Velocity(f64);

/// The most counts.
const MAX_VELOCITY: f64 = 127.0;
/// Counts of MIDI 1.0 above which MIDI 2.0 spreads values wider: its centre.
const CENTRE: f64 = 64.0;

impl Velocity {
    /// A velocity of this many counts, clamped to 0 and 127; NaN becomes 0.
    #[must_use]
    pub fn new(counts: f64) -> Self {
        Velocity(if counts > 0.0 { counts.min(MAX_VELOCITY) } else { 0.0 })
    }

    /// From the seven bits of MIDI 1.0; larger numbers are cut off.
    #[must_use]
    pub fn of_seven_bits(value: u8) -> Self {
        Velocity::new(f64::from(value))
    }

    /// From fourteen bits: the message's seven above, those of controller 88 below.
    #[must_use]
    pub fn of_fourteen_bits(value: u16) -> Self {
        Velocity::new(f64::from(value) / 128.0)
    }

    /// From the sixteen bits of MIDI 2.0.
    #[must_use]
    pub fn of_sixteen_bits(value: u16) -> Self {
        let value = f64::from(value);
        let centre = f64::from(0x8000_u16);
        let above = (value - centre) * ((MAX_VELOCITY - CENTRE) / (f64::from(u16::MAX) - centre));
        Velocity::new(if value <= centre { value / 512.0 } else { CENTRE + above })
    }

    /// Counts, 0 to 127.
    #[must_use]
    pub fn counts(self) -> f64 {
        self.0
    }

    /// The nearest of the seven bits of a note-on, 1 to 127: with 0 it would be a note-off.
    #[must_use]
    pub fn seven_bits(self) -> u8 {
        // At most 127.
        (libm::round(self.0) as u8).max(1)
    }

    /// The nearest of fourteen bits, at least 128: the upper seven are never 0 in a note-on [CA-031].
    #[must_use]
    pub fn fourteen_bits(self) -> u16 {
        (libm::round(self.0 * 128.0) as u16).clamp(128, 0x3FFF)
    }

    /// The nearest of the sixteen bits of MIDI 2.0. Seven bits that are scaled up so (0 to 0, 64 to the centre, 127 to
    /// the largest) are those of its translation, to its rounding [M2-115-U, "min-center-max"]. 0 is a velocity there,
    /// and no note-off.
    #[must_use]
    pub fn sixteen_bits(self) -> u16 {
        let centre = f64::from(0x8000_u16);
        let above = (self.0 - CENTRE) * ((f64::from(u16::MAX) - centre) / (MAX_VELOCITY - CENTRE));
        libm::round(if self.0 <= CENTRE { self.0 * 512.0 } else { centre + above }) as u16
    }
}
