//! Sound as a WAV file.

use std::fs::File;
use std::io::{self, BufWriter, Cursor, Error, Seek, Write};
use std::str::FromStr;

use erard::knocks::Knock;
use erard::run::{Heard, RATE_HZ, Sound};
use hound::{SampleFormat, WavSpec, WavWriter};

/// Force on the bridge, N, that is a full scale of sound, the same for all notes, and in the studio: three keys struck
/// as loud as can be reach it together.
pub(crate) const FULL_SCALE_N: f64 = 150.0;
/// Likewise sound pressure, Pa: four times that of one key at a fortissimo.
pub(crate) const FULL_SCALE_PA: f64 = 10.0;
/// The largest sample of a sound that is scaled by its peak, of a full scale of 1.
const PEAK: f64 = 0.9;
/// Channels of a file.
const CHANNELS: u16 = 2;

/// The knocks that are heard in a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct KnockList(pub Vec<Knock>);

impl FromStr for KnockList {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "all" => return Ok(KnockList(Knock::ALL.to_vec())),
            "none" => return Ok(KnockList(Vec::new())),
            _ => {}
        }
        let named = |name: &str| {
            let names = Knock::ALL.map(Knock::name).join(", ");
            let found = Knock::ALL.into_iter().find(|one| one.name() == name.trim());
            found.ok_or_else(|| format!("`{name}`; expected all, none, or some of {names}"))
        };
        text.split(',').map(named).collect::<Result<_, _>>().map(KnockList)
    }
}

/// How loud a file of a sound is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Gain {
    heard: Heard,
    /// Whether the sound's largest sample is [`PEAK`] of full scale. Otherwise full scale is the same for all sounds;
    /// what is beyond is limited to it.
    by_peak: bool,
}

impl Gain {
    pub(crate) fn new(heard: Heard, by_peak: bool) -> Self {
        Gain { heard, by_peak }
    }

    /// Full scale, N or Pa.
    fn full_scale(self) -> f64 {
        if self.heard == Heard::Pressure { FULL_SCALE_PA } else { FULL_SCALE_N }
    }

    /// Whether a sample, N or Pa, is beyond full scale.
    pub(crate) fn limits(self, sample: f64) -> bool {
        !self.by_peak && sample.abs() > self.full_scale()
    }

    /// Numbers in the file a newton or pascal, of a sound whose largest sample is `peak`.
    fn factor(self, peak: f64) -> f64 {
        let full = f64::from(i16::MAX);
        match self.by_peak {
            false => full / self.full_scale(),
            true if peak > 0.0 => full * PEAK / peak,
            true => 0.0,
        }
    }

    /// What is said of samples that were limited; nothing where there are none.
    pub(crate) fn limited(self, file: &str, samples: u64) -> Option<String> {
        let are = if samples == 1 { "sample is" } else { "samples are" };
        let (full, unit) = (self.full_scale(), self.heard.unit());
        (samples > 0).then(|| format!("warning: {file}: {samples} {are} beyond full scale, {full} {unit}, and limited to it; --wav-peak scales the whole sound instead"))
    }
}

/// Writes a sound: two channels, 48 kHz, 16 bit, which everything reads. (Float comes out as an extended format, which
/// not everything does.)
///
/// # Errors
/// Of the writer.
pub(crate) fn write(sound: &Sound, gain: Gain, out: &mut dyn Write) -> io::Result<()> {
    let mut bytes = Cursor::new(Vec::with_capacity(64 + 4 * sound.samples.len()));
    encode(gain.factor(sound.peak()), &mut sound.samples.iter().map(|sample| Ok(*sample)), &mut bytes)?;
    out.write_all(bytes.get_ref())
}

/// Writes a sound of so many samples that is too long to be held, as [`write`] does: `peak` is its largest, N or Pa,
/// either way, and `spool` a file for it until it is whole. A file of this kind holds 6 h at most.
///
/// # Errors
/// Of the writer and the spool, and where it is too long.
pub(crate) fn write_long(
    samples: u64,
    peak: f64,
    gain: Gain,
    sound: &mut dyn Iterator<Item = io::Result<[f64; 2]>>,
    spool: File,
    out: &mut dyn Write,
) -> io::Result<()> {
    if samples >= u64::from(u32::MAX - 44) / 4 {
        return Err(Error::other("longer than a WAV file can be, 6 h"));
    }
    let mut spooled = BufWriter::new(spool);
    encode(gain.factor(peak), sound, &mut spooled)?;
    let mut spool = spooled.into_inner().map_err(io::IntoInnerError::into_error)?;
    spool.rewind()?;
    io::copy(&mut spool, out).map(drop)
}

/// The head of the file tells its length, which is written last: hence a place that can be gone back in.
fn encode(
    factor: f64,
    sound: &mut dyn Iterator<Item = io::Result<[f64; 2]>>,
    to: &mut (impl Write + Seek),
) -> io::Result<()> {
    let spec =
        WavSpec { channels: CHANNELS, sample_rate: RATE_HZ, bits_per_sample: 16, sample_format: SampleFormat::Int };
    let mut writer = WavWriter::new(to, spec).map_err(Error::other)?;
    for sample in sound {
        for channel in sample? {
            writer.write_sample((factor * channel).round() as i16).map_err(Error::other)?;
        }
    }
    writer.finalize().map_err(Error::other)
}

#[cfg(test)]
mod tests {
    use super::*;

    const GAINS: [Gain; 4] = [
        Gain { heard: Heard::BridgeForce, by_peak: false },
        Gain { heard: Heard::BridgeForce, by_peak: true },
        Gain { heard: Heard::Pressure, by_peak: false },
        Gain { heard: Heard::Pressure, by_peak: true },
    ];

    /// A long one has the bytes of a short one.
    #[test]
    fn a_long_file_is_a_short_one() {
        let sound = Sound { samples: vec![[0.0, 1.0], [-2.0, 0.5], [1.0, 0.0], [0.125, -0.25]], ..Sound::default() };
        let spool = || tempfile::tempfile().unwrap();
        for gain in GAINS {
            let (mut short, mut long) = (Vec::new(), Vec::new());
            write(&sound, gain, &mut short).unwrap();
            let mut samples = sound.samples.iter().map(|sample| Ok(*sample));
            write_long(4, sound.peak(), gain, &mut samples, spool(), &mut long).unwrap();
            assert_eq!(short, long);
        }
        assert!(write_long(1 << 40, 1.0, GAINS[1], &mut std::iter::empty(), spool(), &mut Vec::new()).is_err());
    }

    #[test]
    fn a_file_says_what_was_heard() {
        let [force, by_peak, pressure, _] = GAINS;
        let heard = |samples: &[[f64; 2]], gain| {
            let mut bytes = Vec::new();
            write(&Sound { samples: samples.to_vec(), ..Sound::default() }, gain, &mut bytes).unwrap();
            let reader = hound::WavReader::new(&bytes[..]).unwrap();
            assert_eq!((reader.spec().sample_rate, reader.spec().channels), (48_000, 2));
            reader.into_samples().map(Result::unwrap).collect::<Vec<i16>>()
        };
        assert_eq!(heard(&[[0.0, -2.0], [1.0, 0.0]], by_peak), [0, -29490, 14745, 0]);
        assert_eq!(heard(&[[0.0; 2]; 3], by_peak), [0; 6]);
        // The same force is as loud in every note; what is beyond full scale stays at it.
        assert_eq!(heard(&[[0.0, -15.0], [150.0, -151.0]], force), [0, -3277, 32767, -32768]);
        assert_eq!(heard(&[[-1.0, 10.0], [10.1, -10.5]], pressure), [-3277, 32767, 32767, -32768]);
        assert!(force.limits(-151.0) && !force.limits(150.0) && !by_peak.limits(151.0));
        assert!(pressure.limits(10.1) && !pressure.limits(-10.0));
    }
}
