//! A snapshot as bytes: for C, for pickles, for files. The same on every machine.

use super::{BODIES, MechanismState, Snapshot, SnapshotError, VERSION, ZONES};

const MARK: [u8; 8] = *b"erardsav";
/// Numbers of eight bytes between the head and the check sum.
const WORDS: usize = 1 + 3 + 5 * BODIES + 4 * ZONES + 1 + 2 + 2 * 4;

/// How many bytes a snapshot takes without its strings: a mark, the version, the numbers, and a check sum.
pub const BYTES: usize = MARK.len() + 8 + 8 * WORDS + 8;

impl Snapshot {
    /// The snapshot as bytes, little-endian, the same on every machine: those of [`MechanismState::to_bytes`], and behind them how strings that yield
    /// vibrate, if there are any.
    #[must_use]
    pub fn to_vec(&self) -> Vec<u8> {
        let mut bytes = self.mechanism.to_bytes().to_vec();
        if !self.strings.is_empty() {
            let from = bytes.len();
            bytes.extend(self.strings.iter().flat_map(|number| number.to_bits().to_le_bytes()));
            let sum = check_sum(&bytes[from..]);
            bytes.extend(sum.to_le_bytes());
        }
        bytes
    }

    /// The snapshot that such bytes are. Whether it belongs to an instrument is seen when it is restored. Bytes of a [`MechanismState`] are one
    /// whose strings are at rest.
    ///
    /// # Errors
    /// [`SnapshotError::NoSnapshot`], [`SnapshotError::Version`], [`SnapshotError::Damaged`], [`SnapshotError::NotFinite`].
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, SnapshotError> {
        let (own, behind) = bytes.split_at_checked(BYTES).unwrap_or((bytes, &[]));
        let mechanism = MechanismState::from_bytes(own)?;
        let no_snapshot = SnapshotError::NoSnapshot { found: bytes.len() };
        let Some((behind, sum)) = behind.split_at_checked(behind.len().saturating_sub(8)) else {
            return Err(no_snapshot);
        };
        if !behind.len().is_multiple_of(8) || !(sum.is_empty() || sum.len() == 8) {
            return Err(no_snapshot);
        }
        if !sum.is_empty() && word(sum) != check_sum(behind) {
            return Err(SnapshotError::Damaged);
        }
        let strings: Vec<f64> = behind.chunks_exact(8).map(|bytes| f64::from_bits(word(bytes))).collect();
        mechanism.open(mechanism.instrument, &strings)?;
        Ok(Snapshot { mechanism, strings })
    }
}

impl MechanismState {
    /// The state as so many bytes, little-endian, the same on every machine. Does not allocate.
    #[must_use]
    pub fn to_bytes(&self) -> [u8; BYTES] {
        let mut bytes = [0; BYTES];
        let mut out = Out { places: bytes.chunks_exact_mut(8) };
        out.word(u64::from_le_bytes(MARK));
        out.word(u64::from(self.version));
        out.word(self.instrument);
        out.number(self.time_s);
        out.number(self.origin_s);
        out.word(self.steps);
        for list in [&self.angle_rad, &self.velocity_rad_s, &self.increment, &self.pivot_friction] {
            out.numbers(list);
        }
        out.numbers(&self.tangential);
        out.numbers(&self.side);
        out.numbers(&self.memory);
        out.numbers(&self.pivot_rested);
        out.numbers(&self.rested);
        out.number(self.rigid_force);
        out.word(u64::from(self.aimed_m.is_some()));
        out.number(self.aimed_m.unwrap_or(0.0));
        for sample in &self.flight {
            out.word(u64::from(sample.is_some()));
            out.numbers(&sample.unwrap_or([0.0; 3]));
        }
        let sum = check_sum(&bytes[..BYTES - 8]);
        bytes[BYTES - 8..].copy_from_slice(&sum.to_le_bytes());
        bytes
    }

    /// The state that such bytes are. Whether it belongs to an instrument is seen when it is restored. Does not allocate.
    ///
    /// # Errors
    /// [`SnapshotError::NoSnapshot`], [`SnapshotError::Version`], [`SnapshotError::Damaged`], [`SnapshotError::NotFinite`].
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, SnapshotError> {
        let no_snapshot = SnapshotError::NoSnapshot { found: bytes.len() };
        if bytes.get(..8) != Some(&MARK[..]) {
            return Err(no_snapshot);
        }
        let version = bytes.get(8..16).map_or(0, word);
        if version != u64::from(VERSION) {
            return Err(SnapshotError::Version(u32::try_from(version).unwrap_or(u32::MAX)));
        }
        let Some((all, sum)) = bytes.split_at_checked(BYTES - 8).filter(|(_, sum)| sum.len() == 8) else {
            return Err(no_snapshot);
        };
        if word(sum) != check_sum(all) {
            return Err(SnapshotError::Damaged);
        }
        let mut read = In { places: all[16..].chunks_exact(8) };
        let state = MechanismState {
            version: VERSION,
            instrument: read.word(),
            time_s: read.number(),
            origin_s: read.number(),
            steps: read.word(),
            angle_rad: read.numbers(),
            velocity_rad_s: read.numbers(),
            increment: read.numbers(),
            pivot_friction: read.numbers(),
            tangential: read.numbers(),
            side: read.numbers(),
            memory: read.numbers(),
            pivot_rested: read.numbers(),
            rested: read.numbers(),
            rigid_force: read.number(),
            aimed_m: {
                let is_there = read.word() != 0;
                Some(read.number()).filter(|_| is_there)
            },
            flight: core::array::from_fn(|_| {
                let is_there = read.word() != 0;
                Some(read.numbers()).filter(|_| is_there)
            }),
        };
        state.open(state.instrument, &[])?;
        Ok(state)
    }
}

/// FNV-1a.
fn check_sum(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |sum, byte| (sum ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01b3))
}

fn word(bytes: &[u8]) -> u64 {
    bytes.try_into().map_or(0, u64::from_le_bytes)
}

struct Out<'a> {
    places: core::slice::ChunksExactMut<'a, u8>,
}

impl Out<'_> {
    fn word(&mut self, word: u64) {
        if let Some(place) = self.places.next() {
            place.copy_from_slice(&word.to_le_bytes());
        }
    }

    fn number(&mut self, number: f64) {
        self.word(number.to_bits());
    }

    fn numbers(&mut self, numbers: &[f64]) {
        numbers.iter().for_each(|number| self.number(*number));
    }
}

struct In<'a> {
    places: core::slice::ChunksExact<'a, u8>,
}

impl In<'_> {
    fn word(&mut self) -> u64 {
        self.places.next().map_or(0, word)
    }

    fn number(&mut self) -> f64 {
        f64::from_bits(self.word())
    }

    fn numbers<const K: usize>(&mut self) -> [f64; K] {
        core::array::from_fn(|_| self.number())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Action, Input, Instrument};

    fn pressed() -> MechanismState {
        let mut action = Action::new(&Instrument::builtin("concert-grand-rigid").unwrap()).unwrap();
        for n in 0..700 {
            action.step(Input::Rigid { position_m: f64::from(n) * 1e-5, velocity_m_s: 0.2 });
        }
        action.mechanism_state()
    }

    /// Every number is read back as it was, and every place of the bytes is one of them.
    #[test]
    fn bytes_and_back() {
        let snapshot = pressed();
        assert!(snapshot.aimed_m.is_some() && snapshot.flight.iter().all(Option::is_some));
        assert!(snapshot.side.iter().any(|s| *s != 0.0));
        let bytes = snapshot.to_bytes();
        assert_eq!(MechanismState::from_bytes(&bytes), Ok(snapshot));
        let none = MechanismState { aimed_m: None, flight: [None, Some([1.0, 2.0, 3.0])], ..snapshot };
        assert_eq!(MechanismState::from_bytes(&none.to_bytes()), Ok(none));
        let broken = MechanismState { rigid_force: f64::NAN, ..snapshot };
        assert_eq!(MechanismState::from_bytes(&broken.to_bytes()), Err(SnapshotError::NotFinite));
        let filled = Out { places: [0_u8; BYTES].chunks_exact_mut(8) }.places.len();
        assert_eq!(filled, 2 + WORDS + 1);
    }

    /// Whatever bit is turned, and wherever the bytes are cut off: an error.
    #[test]
    fn what_is_no_snapshot_is_refused() {
        let good = pressed().to_bytes();
        for n in 0..BYTES {
            let mut bad = good;
            bad[n] ^= 1 << (n % 8);
            let error = Snapshot::from_bytes(&bad).unwrap_err();
            match n {
                0..8 => assert_eq!(error, SnapshotError::NoSnapshot { found: BYTES }),
                8..16 => assert!(matches!(error, SnapshotError::Version(_)), "{n}: {error}"),
                _ => assert_eq!(error, SnapshotError::Damaged, "{n}"),
            }
            assert!(Snapshot::from_bytes(&good[..n]).is_err());
        }
        let longer: Vec<u8> = good.iter().copied().chain([0]).collect();
        assert_eq!(Snapshot::from_bytes(&longer), Err(SnapshotError::NoSnapshot { found: BYTES + 1 }));
    }
}
