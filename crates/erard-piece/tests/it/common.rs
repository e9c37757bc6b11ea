//! Keyboards, pieces, and sinks that keep what they are given.

use std::collections::BTreeMap;
use std::io;
use std::sync::{Arc, LazyLock, Mutex};

use erard::instrument::Instrument;
use erard::keyboard::Keyboard;
use erard_midi::file::{Note, PedalChange, Piece, Remarks};
use erard_midi::{Law, Velocity};
use erard_piece::{Block, Options, Performance, Score, Silence, Sink, perform};

fn keys(name: &str) -> Vec<Instrument> {
    Keyboard::builtin(name).unwrap().instruments().unwrap()
}

/// The keyboard that pieces are played on.
pub static STRINGS: LazyLock<Vec<Instrument>> = LazyLock::new(|| keys("concert-grand-strings"));
/// Those actions before rigid strings: cheaper.
pub static RIGID: LazyLock<Vec<Instrument>> = LazyLock::new(|| keys("concert-grand"));
/// An action that is slow to repeat.
pub static HEAVY: LazyLock<Vec<Instrument>> = LazyLock::new(|| keys("heavy-touch"));

/// A note: key, beginning and end, s, and velocity.
pub fn note(key: usize, start_s: f64, end_s: f64, velocity: u8) -> Note {
    Note { key, start_s, end_s, velocity: Velocity::of_seven_bits(velocity), release: None }
}

/// A change of a pedal: instant, s, controller, value.
pub fn foot(time_s: f64, controller: u8, value: u8) -> PedalChange {
    PedalChange { time_s, controller, value }
}

pub fn score(notes: Vec<Note>, pedals: Vec<PedalChange>) -> Score<'static> {
    let mut notes = notes;
    notes.sort_by(|a, b| a.start_s.total_cmp(&b.start_s).then(a.key.cmp(&b.key)));
    Score::of(&Piece { notes, pedals, remarks: Remarks::default() }, &Law::GOEBL)
}

pub fn piece(name: &str) -> Score<'static> {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("pieces").join(name);
    Score::of(&erard_midi::file::read(&std::fs::read(path).unwrap()).unwrap(), &Law::GOEBL)
}

pub fn played(score: &Score<'_>, keys: &[Instrument], options: &Options) -> Performance {
    perform(score, keys, options, &|_| Ok(Box::new(Silence)), &mut |_| true).unwrap()
}

/// The blocks of all keys.
#[derive(Clone, Default)]
pub struct Kept(Arc<Mutex<BTreeMap<usize, Vec<Block>>>>);

struct Keeps(Kept, usize);

impl Sink for Keeps {
    fn take(&mut self, block: Block) -> io::Result<()> {
        self.0.0.lock().unwrap().entry(self.1).or_default().push(block);
        Ok(())
    }
}

impl Kept {
    pub fn blocks(&self) -> BTreeMap<usize, Vec<Block>> {
        self.0.lock().unwrap().clone()
    }

    /// The rows of a key.
    pub fn rows(&self, key: usize) -> Vec<[f64; 9]> {
        let blocks = self.blocks();
        let rows = blocks[&key].iter().filter_map(|block| match block {
            Block::Rows(rows) => Some(rows.clone()),
            Block::Sound { .. } => None,
        });
        rows.flatten().collect()
    }
}

pub fn kept(score: &Score<'_>, keys: &[Instrument], options: &Options) -> (Performance, Kept) {
    let kept = Kept::default();
    let sinks = |key: usize| -> io::Result<Box<dyn Sink>> { Ok(Box::new(Keeps(kept.clone(), key))) };
    (perform(score, keys, options, &sinks, &mut |_| true).unwrap(), kept)
}
