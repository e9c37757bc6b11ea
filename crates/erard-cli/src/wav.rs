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

#[cfg(test)]
mod tests {
    use super::*;

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
