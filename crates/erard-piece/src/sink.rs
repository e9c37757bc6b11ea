//! Sinks: they take rows and sound as they are made.

use std::io;

/// The columns of a row, in this order: SI units, key, finger and pedal rail as an action's reading has them; forces
/// are those of the row's last step.
pub const COLUMNS: [&str; 9] = [
    "time_s",
    "key_m",
    "key_m_per_s",
    "finger_force_N",
    "hammer_rise_m",
    "hammer_rise_m_per_s",
    "string_N",
    "bridge_N",
    "pedal_m",
];

/// Rows of one key, or a stretch of its sound.
#[derive(Debug, Clone, PartialEq)]
pub enum Block {
    /// Rows in the order of time.
    Rows(Vec<[f64; COLUMNS.len()]>),
    /// What is heard ([`Options::sound`](crate::Options::sound)), [`RATE_HZ`](crate::RATE_HZ) samples a second, from a
    /// sample's number on, counted from the performance's beginning.
    Sound {
        /// Number of the first sample.
        from: u64,
        /// The samples.
        samples: Vec<Sample>,
    },
}

/// A sample of a key's sound.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Sample {
    /// Two channels of its strings: pressure, Pa, or force on the bridge less what lies on it at rest, N.
    pub strings: [f32; 2],
    /// By how much the force of what knocks is larger than in the sample before it, N. Between two blocks of samples it
    /// stays. The key bed, which is one for all keys, makes it heard ([`erard::knocks::KeyBed`]).
    pub knocks_n: f32,
}

/// Takes the blocks of one key in the order of time, a few thousand rows at a time.
pub trait Sink: Send {
    /// Takes a block.
    ///
    /// # Errors
    /// An error of what it writes to.
    fn take(&mut self, block: Block) -> io::Result<()>;
}

/// Takes everything and keeps nothing.
#[derive(Debug, Clone, Copy, Default)]
pub struct Silence;

impl Sink for Silence {
    fn take(&mut self, _: Block) -> io::Result<()> {
        Ok(())
    }
}
