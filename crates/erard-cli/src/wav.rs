//! Sound as a WAV file.

use std::io::{Cursor, Error, Write};

use erard::run::{RATE_HZ, Sound};
use hound::{SampleFormat, WavSpec, WavWriter};

/// The largest sample, of a full scale of 1.
const PEAK: f64 = 0.9;

/// Writes a sound, its peak scaled to `PEAK`: one channel, 48 kHz, 16 bit, which everything reads. (Float comes out as
/// an extended format, which not everything does.)
///
/// # Errors
/// Of the writer.
pub(crate) fn write(sound: &Sound, out: &mut dyn Write) -> std::io::Result<()> {
    let spec = WavSpec { channels: 1, sample_rate: RATE_HZ, bits_per_sample: 16, sample_format: SampleFormat::Int };
    let scale = if sound.peak_n() > 0.0 { f64::from(i16::MAX) * PEAK / sound.peak_n() } else { 0.0 };
    // The head of the file tells its length, which is written last.
    let mut bytes = Cursor::new(Vec::with_capacity(64 + 2 * sound.bridge_n.len()));
    let mut writer = WavWriter::new(&mut bytes, spec).map_err(Error::other)?;
    for n in &sound.bridge_n {
        writer.write_sample((scale * n).round() as i16).map_err(Error::other)?;
    }
    writer.finalize().map_err(Error::other)?;
    out.write_all(bytes.get_ref())
}

/// Writes a sound of so many samples that is too long to be held, as [`write`] does: `peak_n` is its largest force, N,
/// either way. A file of this kind holds 12 h at most.
///
/// # Errors
/// Of the writer, and where it is too long.
pub(crate) fn write_long(
    samples: u64,
    peak_n: f64,
    bridge_n: &mut dyn Iterator<Item = std::io::Result<f64>>,
    out: &mut dyn Write,
) -> std::io::Result<()> {
    let bytes = u32::try_from(2 * samples).ok().filter(|bytes| *bytes < u32::MAX - 44);
    let bytes = bytes.ok_or_else(|| Error::other("longer than a WAV file can be, 12 h"))?;
    let scale = if peak_n > 0.0 { f64::from(i16::MAX) * PEAK / peak_n } else { 0.0 };
    let mut head = Vec::with_capacity(44);
    for (name, words) in [
        (b"RIFF", &[bytes + 36][..]),
        (b"WAVE", &[]),
        // One channel of integers; bytes a second; bytes a sample, and bits.
        (b"fmt ", &[16, 1 << 16 | 1, RATE_HZ, 2 * RATE_HZ, 16 << 16 | 2]),
        (b"data", &[bytes]),
    ] {
        head.extend_from_slice(name);
        words.iter().for_each(|word| head.extend_from_slice(&word.to_le_bytes()));
    }
    out.write_all(&head)?;
    for n in bridge_n {
        out.write_all(&((scale * n?).round() as i16).to_le_bytes())?;
    }
    Ok(())
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
        write_long(4, sound.peak_n(), &mut sound.bridge_n.iter().map(|n| Ok(*n)), &mut long).unwrap();
        assert_eq!(short, long);
        assert!(write_long(1 << 40, 1.0, &mut std::iter::empty(), &mut Vec::new()).is_err());
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
