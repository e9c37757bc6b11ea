//! Sound as a WAV file.

use std::fs::File;
use std::io::{self, BufWriter, Cursor, Error, Seek, Write};

use erard::run::{RATE_HZ, Sound};
use hound::{SampleFormat, WavSpec, WavWriter};

/// Force on the bridge, N, that is a full scale of sound, the same for all notes, and in the studio: three keys struck
/// as loud as can be reach it together.
pub(crate) const FULL_SCALE_N: f64 = 150.0;
/// The largest sample of a sound that is scaled by its peak, of a full scale of 1.
const PEAK: f64 = 0.9;

/// How loud a file is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Gain {
    /// [`FULL_SCALE_N`] is full scale; what is beyond is limited to it.
    Fixed,
    /// The sound's largest sample is [`PEAK`] of full scale.
    Peak,
}

impl Gain {
    pub(crate) fn new(by_peak: bool) -> Self {
        if by_peak { Gain::Peak } else { Gain::Fixed }
    }

    /// Forces beyond full scale, N.
    pub(crate) fn limits(self, n: f64) -> bool {
        self == Gain::Fixed && n.abs() > FULL_SCALE_N
    }

    /// Samples a newton, of a sound whose largest force is `peak_n`, N.
    fn per_n(self, peak_n: f64) -> f64 {
        let full = f64::from(i16::MAX);
        match self {
            Gain::Fixed => full / FULL_SCALE_N,
            Gain::Peak if peak_n > 0.0 => full * PEAK / peak_n,
            Gain::Peak => 0.0,
        }
    }
}

/// What is said of samples that a file's fixed gain has limited; nothing where there are none.
pub(crate) fn limited(file: &str, samples: u64) -> Option<String> {
    let are = if samples == 1 { "sample is" } else { "samples are" };
    (samples > 0).then(|| format!("warning: {file}: {samples} {are} beyond full scale, {FULL_SCALE_N} N, and limited to it; --wav-peak scales the whole sound instead"))
}

/// Writes a sound: one channel, 48 kHz, 16 bit, which everything reads. (Float comes out as an extended format, which
/// not everything does.)
///
/// # Errors
/// Of the writer.
pub(crate) fn write(sound: &Sound, gain: Gain, out: &mut dyn Write) -> io::Result<()> {
    let mut bytes = Cursor::new(Vec::with_capacity(64 + 2 * sound.bridge_n.len()));
    encode(gain.per_n(sound.peak_n()), &mut sound.bridge_n.iter().map(|n| Ok(*n)), &mut bytes)?;
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
    gain: Gain,
    bridge_n: &mut dyn Iterator<Item = io::Result<f64>>,
    spool: File,
    out: &mut dyn Write,
) -> io::Result<()> {
    if samples >= u64::from(u32::MAX - 44) / 2 {
        return Err(Error::other("longer than a WAV file can be, 12 h"));
    }
    let mut spooled = BufWriter::new(spool);
    encode(gain.per_n(peak_n), bridge_n, &mut spooled)?;
    let mut spool = spooled.into_inner().map_err(io::IntoInnerError::into_error)?;
    spool.rewind()?;
    io::copy(&mut spool, out).map(drop)
}

/// The head of the file tells its length, which is written last: hence a place that can be gone back in.
fn encode(
    per_n: f64,
    bridge_n: &mut dyn Iterator<Item = io::Result<f64>>,
    to: &mut (impl Write + Seek),
) -> io::Result<()> {
    let spec = WavSpec { channels: 1, sample_rate: RATE_HZ, bits_per_sample: 16, sample_format: SampleFormat::Int };
    let mut writer = WavWriter::new(to, spec).map_err(Error::other)?;
    for n in bridge_n {
        writer.write_sample((per_n * n?).round() as i16).map_err(Error::other)?;
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
        let spool = || tempfile::tempfile().unwrap();
        for gain in [Gain::Fixed, Gain::Peak] {
            let (mut short, mut long) = (Vec::new(), Vec::new());
            write(&sound, gain, &mut short).unwrap();
            let mut samples = sound.bridge_n.iter().map(|n| Ok(*n));
            write_long(4, sound.peak_n(), gain, &mut samples, spool(), &mut long).unwrap();
            assert_eq!(short, long);
        }
        assert!(write_long(1 << 40, 1.0, Gain::Peak, &mut std::iter::empty(), spool(), &mut Vec::new()).is_err());
    }

    #[test]
    fn a_file_says_what_was_heard() {
        let heard = |bridge_n: &[f64], gain| {
            let mut bytes = Vec::new();
            write(&Sound { bridge_n: bridge_n.to_vec() }, gain, &mut bytes).unwrap();
            let reader = hound::WavReader::new(&bytes[..]).unwrap();
            assert_eq!((reader.spec().sample_rate, reader.spec().channels), (48_000, 1));
            reader.into_samples().map(Result::unwrap).collect::<Vec<i16>>()
        };
        assert_eq!(heard(&[0.0, -2.0, 1.0], Gain::Peak), [0, -29490, 14745]);
        assert_eq!(heard(&[0.0; 3], Gain::Peak), [0; 3]);
        // The same force is as loud in every note; what is beyond full scale stays at it.
        assert_eq!(heard(&[0.0, -15.0, 150.0, -151.0], Gain::Fixed), [0, -3277, 32767, -32768]);
        assert_eq!(heard(&[-15.0], Gain::Fixed), [-3277]);
        assert!(Gain::Fixed.limits(-151.0) && !Gain::Fixed.limits(150.0) && !Gain::Peak.limits(151.0));
    }
}
