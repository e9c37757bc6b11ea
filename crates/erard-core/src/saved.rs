//! Saved states as bytes: lists of numbers by name, the same bytes on every machine, read and written without
//! allocating.
//!
//! | bytes | content |
//! |---|---|
//! | 8 | mark: the kind of state |
//! | 8 | [`VERSION`] of this layout |
//! | 32 and more, for each list | its name in 24 bytes, filled up with zeros; how many words follow; these words of 8 bytes |
//! | 8 | check sum: [`fnv1a`] over all bytes before |
//!
//! Words are little-endian. A reader passes over lists that it does not know, and a list that is absent leaves its
//! default in force. A program may therefore read states of later and of earlier programs; the version changes with the
//! layout only.

use thiserror::Error;

pub use crate::fnv1a::{FNV1A, fnv1a};

/// The version of the layout that this program writes, and the only one that it reads.
pub const VERSION: u32 = 2;

/// Why bytes cannot be read as a saved state.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum Unreadable {
    /// The bytes begin with another mark, or are too few.
    #[error("the bytes are not a saved state of this kind")]
    Mark,
    /// Another layout.
    #[error("the saved state is of version {0}; expected {VERSION}")]
    Version(u32),
    /// The bytes were changed or cut off.
    #[error("the saved state is damaged: wrong checksum")]
    Damaged,
}

const WORD: usize = 8;
/// A name and a count.
const HEAD: usize = 4 * WORD;

/// A list's name in words, which are compared one by one: no call of the system's library.
type Name = [u64; 3];

fn words_of(name: &str) -> Name {
    let mut words = [0; 3];
    for (place, byte) in name.bytes().enumerate() {
        if let Some(word) = words.get_mut(place / WORD) {
            *word |= u64::from(byte) << (8 * (place % WORD));
        }
    }
    words
}

/// Writes a state into bytes, or counts how many it takes.
pub struct Writer<'a> {
    bytes: &'a mut [u8],
    at: usize,
}

impl<'a> Writer<'a> {
    /// Writes into `bytes`; what has no room there is counted only, so that a writer of no bytes measures.
    pub fn new(bytes: &'a mut [u8], mark: [u8; 8]) -> Self {
        let mut out = Writer { bytes, at: 0 };
        out.put(u64::from_le_bytes(mark));
        out.put(u64::from(VERSION));
        out
    }

    fn set(&mut self, at: usize, word: u64) {
        if let Some(place) = self.bytes.get_mut(at..at + WORD) {
            for (byte, value) in place.iter_mut().zip(word.to_le_bytes()) {
                *byte = value;
            }
        }
    }

    fn put(&mut self, word: u64) {
        self.set(self.at, word);
        self.at += WORD;
    }

    /// A list of lists: what `write` writes. It is read by [`Lists::groups`].
    pub fn group(&mut self, name: &str, write: impl FnOnce(&mut Self)) {
        debug_assert!(name.len() <= 3 * WORD, "{name}");
        for word in words_of(name) {
            self.put(word);
        }
        let count_at = self.at;
        self.put(0);
        write(self);
        self.set(count_at, (self.at.saturating_sub(count_at + WORD) / WORD) as u64);
    }

    /// A list of numbers.
    pub fn list(&mut self, name: &str, numbers: &mut dyn Iterator<Item = f64>) {
        self.group(name, |out| numbers.for_each(|number| out.put(number.to_bits())));
    }

    /// One number.
    pub fn number(&mut self, name: &str, number: f64) {
        self.word(name, number.to_bits());
    }

    /// One whole number of 64 bits.
    pub fn word(&mut self, name: &str, word: u64) {
        self.group(name, |out| out.put(word));
    }

    /// Ends the state with its check sum. Returns how many bytes it takes.
    pub fn seal(mut self) -> usize {
        let sum = fnv1a(FNV1A, self.bytes.iter().take(self.at).copied());
        self.put(sum);
        self.at
    }
}

/// The lists of a state.
#[derive(Debug, Clone, Copy)]
pub struct Lists<'a> {
    bytes: &'a [u8],
}

impl<'a> Lists<'a> {
    /// The lists of a state, whose check sum is right.
    ///
    /// # Errors
    /// [`Unreadable`].
    pub fn read(bytes: &'a [u8], mark: [u8; 8]) -> Result<Self, Unreadable> {
        let (found, rest) = bytes.split_first_chunk::<WORD>().ok_or(Unreadable::Mark)?;
        if *found != mark {
            return Err(Unreadable::Mark);
        }
        let (version, rest) = rest.split_first_chunk().ok_or(Unreadable::Damaged)?;
        let version = u64::from_le_bytes(*version);
        if version != u64::from(VERSION) {
            return Err(Unreadable::Version(u32::try_from(version).unwrap_or(u32::MAX)));
        }
        let (lists, sum) = rest.split_last_chunk().ok_or(Unreadable::Damaged)?;
        let summed = bytes.iter().take(bytes.len().saturating_sub(WORD)).copied();
        let lists = Lists { bytes: lists };
        let whole = lists.iter().map(|(_, words)| HEAD + words.len()).sum::<usize>() == lists.bytes.len();
        if u64::from_le_bytes(*sum) != fnv1a(FNV1A, summed) || !whole {
            return Err(Unreadable::Damaged);
        }
        Ok(lists)
    }

    /// Names and words.
    fn iter(&self) -> impl Iterator<Item = (Name, &'a [u8])> + use<'a> {
        let mut left = self.bytes;
        std::iter::from_fn(move || {
            let (a, rest) = first_word(left)?;
            let (b, rest) = first_word(rest)?;
            let (c, rest) = first_word(rest)?;
            let (count, rest) = first_word(rest)?;
            let count = usize::try_from(count).ok()?.checked_mul(WORD)?;
            let (words, rest) = rest.split_at_checked(count)?;
            left = rest;
            Some(([a, b, c], words))
        })
    }

    fn named(&self, name: &str) -> impl Iterator<Item = &'a [u8]> + use<'a> {
        let [a, b, c] = words_of(name);
        self.iter().filter(move |([x, y, z], _)| *x == a && *y == b && *z == c).map(|(_, words)| words)
    }

    fn find(&self, name: &str) -> &'a [u8] {
        self.named(name).next().unwrap_or_default()
    }

    fn words(&self, name: &str) -> impl Iterator<Item = u64> + use<'a> {
        let word = |bytes: &[u8]| bytes.first_chunk().map_or(0, |bytes| u64::from_le_bytes(*bytes));
        self.find(name).chunks_exact(WORD).map(word)
    }

    /// Passes every number of a list on with its index. Returns how many there are: none if the list is absent.
    pub fn each(&self, name: &str, number: &mut dyn FnMut(usize, f64)) -> usize {
        let mut count = 0;
        for word in self.words(name) {
            number(count, f64::from_bits(word));
            count += 1;
        }
        count
    }

    /// Fills places with the numbers of a list. Where it has none, they stay as they are.
    pub fn fill(&self, name: &str, places: &mut [f64]) {
        for (place, word) in places.iter_mut().zip(self.words(name)) {
            *place = f64::from_bits(word);
        }
    }

    /// A single number; `None` where it is absent.
    #[must_use]
    pub fn number(&self, name: &str) -> Option<f64> {
        self.word(name).map(f64::from_bits)
    }

    /// A single whole number; `None` where it is absent.
    #[must_use]
    pub fn word(&self, name: &str) -> Option<u64> {
        self.words(name).next()
    }

    /// The lists of lists of one name, in their order.
    pub fn groups(&self, name: &str) -> impl Iterator<Item = Lists<'a>> + use<'a> {
        self.named(name).map(|words| Lists { bytes: words })
    }

    /// The names that begin so, with their numbers. Allocates.
    #[must_use]
    pub(crate) fn beginning(&self, with: &str) -> std::collections::BTreeMap<String, Vec<f64>> {
        let mut found = std::collections::BTreeMap::new();
        for (name, _) in self.iter() {
            let bytes = name.into_iter().flat_map(u64::to_le_bytes).take_while(|byte| *byte != 0).collect();
            if let Some(name) = String::from_utf8(bytes).ok().filter(|name| name.starts_with(with)) {
                let numbers = self.words(&name).map(f64::from_bits).collect();
                found.insert(name, numbers);
            }
        }
        found
    }
}

fn first_word(bytes: &[u8]) -> Option<(u64, &[u8])> {
    let (word, rest) = bytes.split_first_chunk()?;
    Some((u64::from_le_bytes(*word), rest))
}

#[cfg(test)]
mod tests {
    use super::*;

    const MARK: [u8; 8] = *b"erardtst";

    fn write(bytes: &mut [u8]) -> usize {
        let mut out = Writer::new(bytes, MARK);
        out.list("angles", &mut [1.0, -2.0].into_iter());
        for key in [7, 8] {
            out.group("key", |out| out.word("number", key));
        }
        out.number("a_name_of_24_bytes_fully", 3.0);
        out.seal()
    }

    /// What is written is what is read; what is not there leaves defaults in force; counting and writing agree.
    #[test]
    fn lists_are_read_by_name() {
        let mut bytes = vec![0; write(&mut [])];
        assert_eq!(write(&mut bytes), bytes.len());
        let lists = Lists::read(&bytes, MARK).unwrap();
        let mut places = [9.0; 3];
        lists.fill("angles", &mut places);
        lists.fill("nothing", &mut places);
        assert_eq!(places, [1.0, -2.0, 9.0]);
        assert_eq!((lists.number("a_name_of_24_bytes_fully"), lists.number("nothing")), (Some(3.0), None));
        let keys: Vec<Option<u64>> = lists.groups("key").map(|key| key.word("number")).collect();
        assert_eq!(keys, [Some(7), Some(8)]);
        assert_eq!(lists.beginning("an"), [("angles".to_owned(), vec![1.0, -2.0])].into());
    }

    /// Whatever bit is turned, and wherever the bytes are cut off: an error.
    #[test]
    fn damage_is_found() {
        let mut good = vec![0; write(&mut [])];
        write(&mut good);
        for n in 0..good.len() {
            let mut bad = good.clone();
            bad[n] ^= 1 << (n % 8);
            let error = Lists::read(&bad, MARK).unwrap_err();
            match n {
                0..8 => assert_eq!(error, Unreadable::Mark, "{n}"),
                8..16 => assert!(matches!(error, Unreadable::Version(_)), "{n}: {error}"),
                _ => assert_eq!(error, Unreadable::Damaged, "{n}"),
            }
            assert!(Lists::read(&good[..n], MARK).is_err(), "{n}");
        }
    }

    /// The published values of FNV-1a.
    #[test]
    fn the_check_sum_is_fnv_1a() {
        assert_eq!(fnv1a(FNV1A, *b""), 0xcbf2_9ce4_8422_2325);
        assert_eq!(fnv1a(FNV1A, *b"a"), 0xaf63_dc4c_8601_ec8c);
        assert_eq!(fnv1a(FNV1A, *b"foobar"), 0x8594_4171_f739_67e8);
    }
}
