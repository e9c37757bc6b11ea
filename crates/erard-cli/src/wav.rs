//! Sound as a WAV file.

use std::fs::File;
use std::io::{self, BufWriter, Cursor, Error, Seek, Write};

use erard::run::{RATE_HZ, Sound};
use hound::{SampleFormat, WavSpec, WavWriter};

/// The largest sample, of a full scale of 1.
const PEAK: f64 = 0.9;

/// Writes a sound, its peak scaled to `PEAK`: one channel, 48 kHz, 16 bit, which everything reads. (Float comes out as
/// an extended format, which not everything does.)
///
/// # Errors
/// Of the writer.
pub(crate) fn write(sound: &Sound, out: &mut dyn Write) -> io::Result<()> {
    let mut bytes = Cursor::new(Vec::with_capacity(64 + 2 * sound.bridge_n.len()));
    encode(sound.peak_n(), &mut sound.bridge_n.iter().map(|n| Ok(*n)), &mut bytes)?;
    out.write_all(bytes.get_ref())
}

/// Writes a sound of so many samples that is too long to be held, as [`write`] does: `peak_n` is its largest force, N,
/// either way, and `spool` a file for it until it is whole. A file of this kind holds 12 h at most.
///
/// # Errors
/// Of the writer and the spool, and where it is too long.
pub(crate) fn write_long(
    samples: u64,
    peak_n: f64,
    bridge_n: &mut dyn Iterator<Item = io::Result<f64>>,
    spool: File,
    out: &mut dyn Write,
) -> io::Result<()> {
    if samples >= u64::from(u32::MAX - 44) / 2 {
        return Err(Error::other("longer than a WAV file can be, 12 h"));
    }
    let mut spooled = BufWriter::new(spool);
    encode(peak_n, bridge_n, &mut spooled)?;
    let mut spool = spooled.into_inner().map_err(io::IntoInnerError::into_error)?;
    spool.rewind()?;
    io::copy(&mut spool, out).map(drop)
}

/// The head of the file tells its length, which is written last: hence a place that can be gone back in.
fn encode(
    peak_n: f64,
    bridge_n: &mut dyn Iterator<Item = io::Result<f64>>,
    to: &mut (impl Write + Seek),
) -> io::Result<()> {
    let spec = WavSpec { channels: 1, sample_rate: RATE_HZ, bits_per_sample: 16, sample_format: SampleFormat::Int };
    let scale = if peak_n > 0.0 { f64::from(i16::MAX) * PEAK / peak_n } else { 0.0 };
    let mut writer = WavWriter::new(to, spec).map_err(Error::other)?;
    for n in bridge_n {
        writer.write_sample((scale * n?).round() as i16).map_err(Error::other)?;
    }
    writer.finalize().map_err(Error::other)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A long one has the bytes of a short one.
    #[test]
    fn a_long_file_is_a_short_one() {
        let sound = Sound { bridge_n: vec![0.0, -2.0, 1.0, 0.125] };
        let (mut short, mut long) = (Vec::new(), Vec::new());
        write(&sound, &mut short).unwrap();
        let spool = || tempfile::tempfile().unwrap();
        write_long(4, sound.peak_n(), &mut sound.bridge_n.iter().map(|n| Ok(*n)), spool(), &mut long).unwrap();
        assert_eq!(short, long);
        assert!(write_long(1 << 40, 1.0, &mut std::iter::empty(), spool(), &mut Vec::new()).is_err());
    }

    #[test]
    fn a_file_says_what_was_heard() {
        let mut bytes = Vec::new();
        write(&Sound { bridge_n: vec![0.0, -2.0, 1.0] }, &mut bytes).unwrap();
        let mut reader = hound::WavReader::new(&bytes[..]).unwrap();
        assert_eq!((reader.spec().sample_rate, reader.spec().channels), (48_000, 1));
        let samples: Vec<i16> = reader.samples().map(Result::unwrap).collect();
        assert_eq!(samples, [0, -29490, 14745]);
        let mut silent = Vec::new();
        write(&Sound { bridge_n: vec![0.0; 3] }, &mut silent).unwrap();
        assert!(hound::WavReader::new(&silent[..]).unwrap().into_samples::<i16>().all(|s| s.unwrap() == 0));
    }
}
