//! The sound that `press --wav` writes, measured in the file as it is: partials where the formula has them, how they fall, and no clicks.

mod common;

use std::f64::consts::PI;

use common::Folder;
use erard::instrument::{Instrument, InstrumentFile};

const RATE_HZ: f64 = 48_000.0;

/// C4 with three strings in unison, so that no beats move the partials; nothing couples them.
fn unison() -> String {
    let text = Instrument::builtin_text("concert-grand-strings").unwrap();
    let lines = text.lines().filter(|line| !line.starts_with("detuned_cents"));
    lines.flat_map(|line| [line, "\n"]).collect()
}

/// Samples of a note that is struck and held for so long, of a full scale of 1.
fn note(folder: &Folder, duration: &str) -> Vec<f64> {
    folder.file("unison.toml", &unison());
    folder.good(&["--instrument", "unison.toml", "--force-step", "5", "--duration", duration, "--wav", "--out", "out"]);
    let reader = hound::WavReader::open(folder.0.join("out/note.wav")).unwrap();
    assert_eq!((reader.spec().sample_rate, reader.spec().channels, reader.spec().bits_per_sample), (48_000, 1, 16));
    reader.into_samples::<i16>().map(|sample| f64::from(sample.unwrap()) / 32_768.0).collect()
}

/// Amplitude and phase of what swings at a frequency, in a window of Hann squared from a sample on.
fn swing(samples: &[f64], from: usize, window: usize, hz: f64) -> [f64; 2] {
    let (mut re, mut im, mut sum) = (0.0, 0.0, 0.0);
    for (k, sample) in samples[from..from + window].iter().enumerate() {
        let weight = (0.5 - 0.5 * (2.0 * PI * k as f64 / window as f64).cos()).powi(2);
        let at = 2.0 * PI * hz * (from + k) as f64 / RATE_HZ;
        (re, im, sum) = (re + weight * sample * at.cos(), im - weight * sample * at.sin(), sum + weight);
    }
    [2.0 * re.hypot(im) / sum, im.atan2(re)]
}

/// The first ten partials lie within 0.1 cent of n f0 sqrt(1 + B n^2) with the file's f0 and B, and fall as b1 + b3 omega^2 says, to a twentieth.
#[test]
fn partials_of_the_file_are_where_the_formula_has_them() {
    let folder = Folder::for_command("press", "wav-partials");
    let samples = note(&folder, "2.2");
    let instrument = InstrumentFile::parse(&unison(), "unison.toml").map_err(|e| e.to_string()).unwrap().instrument;
    let string = &instrument.strings[0];
    let (from, window, lag) = (24_000, 24_000, 48_000);
    for n in 1..=10_u32 {
        let hz = string.ideal_hz() * f64::from(n) * (1.0 + string.inharmonicity() * f64::from(n * n)).sqrt();
        let [before, after] = [from, from + lag].map(|from| swing(&samples, from, window, hz));
        let turn = after[1] - before[1];
        let turn = turn - 2.0 * PI * (turn / (2.0 * PI)).round();
        let cents = 1200.0 * (1.0 + turn / (2.0 * PI * hz * lag as f64 / RATE_HZ)).log2();
        let t60_s = 6.0 * 10_f64.ln() / 2.0 * (lag as f64 / RATE_HZ) / (before[0] / after[0]).ln();
        let declared_s = 3.0 * 10_f64.ln() / string.decay_per_s(n);
        println!(
            "partial {n}: {hz:.3} Hz, {cents:+.4} cents, amplitude {:.1e}, T60 {t60_s:.2} s, by the file {declared_s:.2} s",
            before[0]
        );
        assert!(cents.abs() < 0.1, "partial {n}: {cents}");
        // The eighth is struck near a node and is as small as the steps of 16 bits.
        assert!(before[0] < 1e-3 || (t60_s / declared_s - 1.0).abs() < 0.05, "partial {n}: {t60_s} {declared_s}");
    }
}

/// The largest second difference in each millisecond, over what it is in the mean of the 20 before.
fn jumps(samples: &[f64]) -> f64 {
    let second: Vec<f64> = samples.windows(3).map(|s| (s[0] - 2.0 * s[1] + s[2]).abs()).collect();
    let tops: Vec<f64> = second.chunks_exact(48).map(|part| part.iter().copied().fold(0.0, f64::max)).collect();
    // 16 bits: two steps of rounding are no click.
    let step = 4.0 / 32_768.0;
    tops.windows(21).map(|t| t[20] / (t[..20].iter().sum::<f64>() / 20.0).max(step)).fold(0.0, f64::max)
}

/// After the blow nothing in the file is sharper than what is around it; a sample that is off by two hundredths of full scale would be.
#[test]
fn the_file_has_no_clicks() {
    let folder = Folder::for_command("press", "wav-clicks");
    let mut samples = note(&folder, "1.5");
    let peak = samples.iter().position(|s| s.abs() > 0.1).unwrap();
    let from = peak + 4800;
    let found = jumps(&samples[from..]);
    samples[from + 24_000] += 0.02;
    let clicked = jumps(&samples[from..]);
    println!("sharpest {found:.2} times its surroundings; with a click {clicked:.2}");
    assert!(found < 3.0 && clicked > 1.5 * found, "{found} {clicked}");
}
