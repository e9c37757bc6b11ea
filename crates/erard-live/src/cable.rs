//! How long bytes queue for a DIN cable.

/// A byte's time on a cable of 31 250 bits a second, s: a start bit, eight, a stop bit.
pub const BYTE_S: f64 = 10.0 / 31_250.0;

/// A DIN cable that sends one byte after the other.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Cable {
    free_s: f64,
    /// The longest time from an instant to the end of its last byte, s.
    pub longest_s: f64,
    /// Bytes that were sent.
    pub bytes: u64,
}

impl Cable {
    /// Takes a number of bytes that come at an instant, s; returns the instant at which the last one has arrived, s.
    pub fn send(&mut self, at_s: f64, bytes: usize) -> f64 {
        self.free_s = self.free_s.max(at_s) + bytes as f64 * BYTE_S;
        self.longest_s = self.longest_s.max(self.free_s - at_s);
        self.bytes += bytes as u64;
        self.free_s
    }
}
