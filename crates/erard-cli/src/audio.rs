//! Sound files: WAV, and Ogg Vorbis.

use std::io::Cursor;

use hound::{SampleFormat, WavReader};
use lewton::inside_ogg::OggStreamReader;

/// Channels of samples, of a full scale of 1.
pub(crate) struct Audio {
    pub channels: Vec<Vec<f64>>,
    pub rate_hz: f64,
}

/// What is expected of a file, for messages.
const EXPECTED: &str = "expected WAV or Ogg Vorbis";
/// Beginnings of other kinds of sound files, for messages.
const OTHERS: [(&[u8], &str); 5] =
    [(b"fLaC", "FLAC"), (b"ID3", "MP3"), (b"FORM", "AIFF"), (b"RF64", "WAV of 64 bits"), (b"MThd", "a MIDI file")];
/// Most channels of a file.
const MAX_CHANNELS: usize = 64;

impl Audio {
    /// Decodes the bytes of a file.
    ///
    /// # Errors
    /// What is wrong with them, and what is expected.
    pub fn decode(bytes: &[u8]) -> Result<Self, String> {
        if bytes.is_empty() {
            return Err(format!("is empty; {EXPECTED}"));
        }
        if bytes.starts_with(b"RIFF") {
            return wav(bytes).map_err(|error| format!("is not a WAV file that can be read: {error}"));
        }
        if bytes.starts_with(b"OggS") {
            return ogg(bytes).map_err(|error| format!("is not Ogg Vorbis that can be read: {error}"));
        }
        let other = OTHERS.iter().find(|(begins, _)| bytes.starts_with(begins));
        Err(other.map_or_else(
            || format!("is no sound file; {EXPECTED}"),
            |(_, kind)| format!("is {kind}; {EXPECTED}: convert it"),
        ))
    }
}

fn wav(bytes: &[u8]) -> Result<Audio, String> {
    let mut reader = WavReader::new(bytes).map_err(|error| error.to_string())?;
    let spec = reader.spec();
    let count = usize::from(spec.channels);
    if !(1..=MAX_CHANNELS).contains(&count) {
        return Err(format!("{count} channels; expected 1 to {MAX_CHANNELS}"));
    }
    let samples: Result<Vec<f64>, hound::Error> = match spec.sample_format {
        SampleFormat::Float => reader.samples::<f32>().map(|sample| sample.map(f64::from)).collect(),
        SampleFormat::Int => {
            let full = f64::from(1_u32 << (spec.bits_per_sample.clamp(1, 32) - 1));
            reader.samples::<i32>().map(|sample| sample.map(|x| f64::from(x) / full)).collect()
        }
    };
    let samples = samples.map_err(|error| error.to_string())?;
    let channel = |of: usize| samples.iter().skip(of).step_by(count).copied().collect::<Vec<f64>>();
    let channels: Vec<Vec<f64>> = (0..count).map(channel).collect();
    if channels.iter().any(|one| one.len() != channels[0].len()) {
        return Err("its last sample lacks channels".into());
    }
    Ok(Audio { channels, rate_hz: f64::from(spec.sample_rate) })
}

fn ogg(bytes: &[u8]) -> Result<Audio, String> {
    let mut reader = OggStreamReader::new(Cursor::new(bytes)).map_err(|error| error.to_string())?;
    let rate_hz = f64::from(reader.ident_hdr.audio_sample_rate);
    let mut channels = vec![Vec::new(); usize::from(reader.ident_hdr.audio_channels)];
    while let Some(packet) = reader.read_dec_packet_generic::<Vec<Vec<f32>>>().map_err(|error| error.to_string())? {
        let is_chained = f64::from(reader.ident_hdr.audio_sample_rate) != rate_hz || packet.len() != channels.len();
        if is_chained {
            return Err("it holds several streams; expected one".into());
        }
        for (channel, samples) in channels.iter_mut().zip(packet) {
            channel.extend(samples.into_iter().map(f64::from));
        }
    }
    Ok(Audio { channels, rate_hz })
}

#[cfg(test)]
mod tests {
    use super::*;
    use hound::{WavSpec, WavWriter};

    fn written(spec: WavSpec, samples: &[i32]) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        let mut writer = WavWriter::new(&mut bytes, spec).unwrap();
        samples.iter().for_each(|sample| writer.write_sample(*sample).unwrap());
        writer.finalize().unwrap();
        bytes.into_inner()
    }

    /// Integers of every width and floats mean the same full scale, and channels come apart.
    #[test]
    fn full_scale_is_one_in_every_format() {
        for bits_per_sample in [8, 16, 24, 32] {
            let spec = WavSpec { channels: 2, sample_rate: 44_100, bits_per_sample, sample_format: SampleFormat::Int };
            let half = 1 << (bits_per_sample - 2);
            let audio = Audio::decode(&written(spec, &[half, -half, 0, half / 2])).unwrap();
            assert_eq!((audio.rate_hz, audio.channels), (44_100.0, vec![vec![0.5, 0.0], vec![-0.5, 0.25]]));
        }
        let spec = WavSpec { channels: 1, sample_rate: 8000, bits_per_sample: 32, sample_format: SampleFormat::Float };
        let mut bytes = Cursor::new(Vec::new());
        let mut writer = WavWriter::new(&mut bytes, spec).unwrap();
        writer.write_sample(0.25_f32).unwrap();
        writer.finalize().unwrap();
        assert_eq!(Audio::decode(&bytes.into_inner()).unwrap().channels, [[0.25]]);
    }

    #[test]
    fn what_is_no_sound_is_refused() {
        let spec = WavSpec { channels: 1, sample_rate: 8000, bits_per_sample: 16, sample_format: SampleFormat::Int };
        let whole = written(spec, &[1; 100]);
        for (bytes, said) in [
            (&b""[..], "is empty; expected WAV or Ogg Vorbis"),
            (b"fLaC....", "is FLAC; expected WAV or Ogg Vorbis: convert it"),
            (b"time_s,force_N", "is no sound file; expected WAV or Ogg Vorbis"),
            (b"RIFF", "is not a WAV file that can be read"),
            (&whole[..100], "is not a WAV file that can be read"),
            (b"OggS", "is not Ogg Vorbis that can be read"),
            (b"OggS\0\0 no such page", "is not Ogg Vorbis that can be read"),
        ] {
            let error = Audio::decode(bytes).err().unwrap();
            assert!(error.starts_with(said), "{error}");
        }
    }
}
