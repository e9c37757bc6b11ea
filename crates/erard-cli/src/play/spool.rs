//! Rows and sound of a performance, on disk until all keys are played: so much is not held.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufReader, BufWriter, Read, Seek, SeekFrom, Write};
use std::sync::{Mutex, PoisonError};

use erard::knocks::KeyBed;
use erard_piece::{Block, COLUMNS, RATE_HZ, Sample, Sink};

use erard_figures::made_by::MadeBy;

use crate::table::RowGroups;
use crate::wav::Gain;

/// Rows of a group in Parquet.
const GROUP: usize = 1 << 16;

/// What two files hold of a key: rows, and sound.
struct Spooled {
    rows: File,
    sound: File,
}

/// The files of all keys.
#[derive(Default)]
pub(crate) struct Spools(Mutex<BTreeMap<usize, Spooled>>);

/// Writes one key's.
struct Spool(Spooled);

impl Sink for Spool {
    fn take(&mut self, block: Block) -> io::Result<()> {
        let mut bytes = Vec::new();
        match block {
            Block::Rows(rows) => {
                rows.iter().flatten().for_each(|x| bytes.extend_from_slice(&x.to_le_bytes()));
                self.0.rows.write_all(&bytes)
            }
            Block::Sound { from, samples } => {
                bytes.extend_from_slice(&from.to_le_bytes());
                bytes.extend_from_slice(&(samples.len() as u64).to_le_bytes());
                for Sample { strings: [left, right], knocks_n } in samples {
                    [left, right, knocks_n].iter().for_each(|x| bytes.extend_from_slice(&x.to_le_bytes()));
                }
                self.0.sound.write_all(&bytes)
            }
        }
    }
}

impl Spools {
    /// What takes a key's rows and sound; `file` makes files.
    pub(crate) fn sink(&self, key: usize, file: &dyn Fn() -> io::Result<File>) -> io::Result<Box<dyn Sink>> {
        let [rows, sound] = [file()?, file()?];
        let own = Spooled { rows: rows.try_clone()?, sound: sound.try_clone()? };
        self.0.lock().unwrap_or_else(PoisonError::into_inner).insert(key, Spooled { rows, sound });
        Ok(Box::new(Spool(own)))
    }

    /// The rows of all keys, and their sound.
    pub(crate) fn rows_and_sound(self) -> (Rows, Sound) {
        let keys = self.0.into_inner().unwrap_or_else(PoisonError::into_inner);
        let (rows, sounds) = keys.into_iter().map(|(key, spooled)| ((key, spooled.rows), spooled.sound)).unzip();
        (Rows(rows), Sound(sounds))
    }
}

/// The rows of all keys.
pub(crate) struct Rows(Vec<(usize, File)>);

impl Rows {
    /// As Parquet, key after key.
    pub(crate) fn write(self, made_by: &MadeBy, writer: &mut dyn Write) -> io::Result<()> {
        let names: Vec<&str> = std::iter::once("key").chain(COLUMNS).collect();
        let mut groups = RowGroups::new("actions", made_by, &names, writer)?;
        for (key, mut file) in self.0 {
            let bytes = file.seek(SeekFrom::End(0))?;
            file.rewind()?;
            let mut left = bytes as usize / (8 * COLUMNS.len());
            let mut file = BufReader::with_capacity(1 << 16, file);
            while left > 0 {
                let count = left.min(GROUP);
                let mut columns: Vec<Vec<f64>> = COLUMNS.iter().map(|_| Vec::with_capacity(count)).collect();
                for _ in 0..count {
                    for column in &mut columns {
                        let mut number = [0; 8];
                        file.read_exact(&mut number)?;
                        column.push(f64::from_le_bytes(number));
                    }
                }
                groups.group(key as i32, &columns)?;
                left -= count;
            }
        }
        groups.finish()
    }
}

/// The sound of each key.
pub(crate) struct Sound(Vec<File>);

/// The sound of all keys together, mixed on disk.
pub(crate) struct Mixed {
    file: File,
    /// Its samples.
    pub samples: u64,
    /// The largest of them, N or Pa.
    pub peak: f64,
    /// Samples that the gain limits.
    pub limited: u64,
}

/// One key's sound, stretch by stretch.
struct Stretches {
    file: BufReader<File>,
    /// First sample and length of the present stretch; none is left after the last.
    now: Option<[u64; 2]>,
}

impl Stretches {
    fn new(mut file: File) -> io::Result<Self> {
        file.rewind()?;
        let mut stretches = Stretches { file: BufReader::with_capacity(1 << 16, file), now: None };
        stretches.turn()?;
        Ok(stretches)
    }

    fn turn(&mut self) -> io::Result<()> {
        let mut numbers = [[0; 8]; 2];
        self.now = match self.file.read_exact(&mut numbers[0]) {
            Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => None,
            Err(error) => return Err(error),
            Ok(()) => {
                self.file.read_exact(&mut numbers[1])?;
                Some(numbers.map(u64::from_le_bytes))
            }
        };
        Ok(())
    }

    /// Adds what it has of the samples from one on: two channels, and what knocks.
    fn add(&mut self, from: u64, to: &mut [[f64; 3]]) -> io::Result<()> {
        let end = from + to.len() as u64;
        while let Some([first, length]) = self.now {
            if first >= end {
                break;
            }
            let part = (end - first).min(length);
            for n in 0..part {
                for sum in &mut to[(first + n - from) as usize] {
                    let mut number = [0; 4];
                    self.file.read_exact(&mut number)?;
                    *sum += f64::from(f32::from_le_bytes(number));
                }
            }
            self.now = Some([first + part, length - part]);
            if part == length {
                self.turn()?;
            }
        }
        Ok(())
    }
}

impl Sound {
    /// Mixes all keys, second by second, in the order of the keys; they knock on one bed.
    pub(crate) fn mix(self, file: File, gain: Gain) -> io::Result<Mixed> {
        let mut keys = self.0.into_iter().map(Stretches::new).collect::<io::Result<Vec<_>>>()?;
        let mut out = BufWriter::new(file);
        let mut bed = KeyBed::new(f64::from(RATE_HZ));
        let (mut samples, mut peak, mut limited) = (0_u64, 0.0_f64, 0_u64);
        while keys.iter().any(|key| key.now.is_some()) {
            let mut second = vec![[0.0; 3]; RATE_HZ as usize];
            for key in &mut keys {
                key.add(samples, &mut second)?;
            }
            for [left, right, knocks_n] in &second {
                let knocks = bed.step(*knocks_n);
                for sample in [left + knocks[0], right + knocks[1]] {
                    peak = peak.max(sample.abs());
                    limited += u64::from(gain.limits(sample));
                    out.write_all(&sample.to_le_bytes())?;
                }
            }
            samples += second.len() as u64;
        }
        Ok(Mixed { file: out.into_inner().map_err(io::IntoInnerError::into_error)?, samples, peak, limited })
    }
}

impl Mixed {
    /// `spool` is a file for the encoded sound until it is whole.
    pub(crate) fn write_wav(mut self, gain: Gain, spool: File, writer: &mut dyn Write) -> io::Result<()> {
        self.file.rewind()?;
        let mut file = BufReader::new(self.file);
        let mut number = || {
            let mut number = [0; 8];
            file.read_exact(&mut number).map(|()| f64::from_le_bytes(number))
        };
        let mut samples = (0..self.samples).map(|_| Ok([number()?, number()?]));
        crate::wav::write_long(self.samples, self.peak, gain, &mut samples, spool, writer)
    }
}
