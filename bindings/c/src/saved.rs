//! Words of eight bytes, little-endian, written and read one after the other, and their check sum.

pub struct Writer<'a>(core::slice::ChunksExactMut<'a, u8>);

impl<'a> Writer<'a> {
    pub fn new(bytes: &'a mut [u8]) -> Self {
        Writer(bytes.chunks_exact_mut(8))
    }

    pub fn word(&mut self, word: u64) {
        if let Some(place) = self.0.next() {
            for (byte, value) in place.iter_mut().zip(word.to_le_bytes()) {
                *byte = value;
            }
        }
    }

    pub fn number(&mut self, number: f64) {
        self.word(number.to_bits());
    }

    pub fn numbers(&mut self, numbers: &[f64]) {
        for number in numbers {
            self.number(*number);
        }
    }

    /// Words that are bytes already.
    pub fn bytes(&mut self, bytes: &[u8]) {
        let mut read = Reader::new(bytes);
        for _ in 0..bytes.len() / 8 {
            self.word(read.word());
        }
    }
}

/// Writes the check sum of all bytes but the last eight into these.
pub fn seal(bytes: &mut [u8]) {
    let (sum, at) = (check_sum(bytes), bytes.len().saturating_sub(8));
    if let Some((_, place)) = bytes.split_at_mut_checked(at) {
        Writer::new(place).word(sum);
    }
}

pub struct Reader<'a>(core::slice::ChunksExact<'a, u8>);

impl<'a> Reader<'a> {
    pub fn new(bytes: &'a [u8]) -> Self {
        Reader(bytes.chunks_exact(8))
    }

    pub fn word(&mut self) -> u64 {
        let word = self.0.next().and_then(|bytes| bytes.first_chunk());
        word.map_or(0, |bytes| u64::from_le_bytes(*bytes))
    }

    pub fn numbers<const K: usize>(&mut self) -> [f64; K] {
        let mut numbers = [0.0; K];
        self.fill(&mut numbers);
        numbers
    }

    pub fn fill(&mut self, numbers: &mut [f64]) {
        for place in numbers {
            *place = f64::from_bits(self.word());
        }
    }
}

/// FNV-1a over all but the last eight bytes.
pub fn check_sum(bytes: &[u8]) -> u64 {
    let (all, _) = bytes.split_at(bytes.len().saturating_sub(8));
    all.iter().fold(0xcbf2_9ce4_8422_2325, |sum, byte| (sum ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01b3))
}
