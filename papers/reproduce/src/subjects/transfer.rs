//! The mechanism as a filter: from force to displacement and back, identified from a broad-band tremble of the finger.
//!
//! The finger presses slowly, so that pivots and contacts slide in one direction, with a small added tremble. The
//! difference from the same press without it is the response: at every frequency, H = sum conj(dF) dy / sum |dF|^2 over
//! several trembles.

use std::f64::consts::{PI, TAU};

use moreau::Settings;
use rustfft::FftPlanner;
use rustfft::num_complex::Complex;

use super::impact::tell;
use super::{Chart, ChartCurve, ChartPanel, Claim, Dash, Progress, ReproduceError, Section, Table};
use erard::instrument::Instrument;
use erard::one_dof::reduce;
use erard::player;
use erard::run::Run;
use erard::run::{Setup, simulate};

/// Step, s, and sampling interval.
const STEP_S: f64 = 50e-6;
/// Speed of the slow press, m/s.
const SPEED_M_PER_S: f64 = 0.02;
/// Travel of the finger, m.
const DEPTH_M: f64 = 9.0e-3;
/// Length of the windows, s; half of it is 1 mm of key travel.
const WINDOW_S: f64 = 0.1;
/// Amplitude of the tremble, m (root mean square), and its band, Hz.
const TREMBLE_M: f64 = 2e-6;
const BAND_HZ: (f64, f64) = (20.0, 2000.0);
/// Number of trembles.
const TREMBLES: usize = 6;
/// Centres of the windows: key travel of the slow finger, m.
const PLACES_M: [f64; 3] = [2.0e-3, 4.5e-3, 7.0e-3];
/// Band in which slopes are read, Hz.
const SLOPE_HZ: (f64, f64) = (300.0, 1500.0);
/// The models differ if their ratio exceeds this factor (3 dB).
const PART: f64 = 1.412_537_544_622_754_4;

/// A response at one place: frequencies, Hz, and displacement over force, m/N.
struct Response {
    frequency: Vec<f64>,
    admittance: Vec<Complex<f64>>,
}

/// A tremble: a sum of cosines of equal amplitudes, ten hertz apart, with phases of a deterministic generator.
struct Tremble {
    phases: Vec<f64>,
}

impl Tremble {
    fn new(seed: u64) -> Self {
        let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
        let count = ((BAND_HZ.1 - BAND_HZ.0) / 10.0) as usize + 1;
        let mut next = || {
            state ^= state >> 12;
            state ^= state << 25;
            state ^= state >> 27;
            TAU * (state.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 11) as f64 / (1u64 << 53) as f64
        };
        Tremble { phases: (0..count).map(|_| next()).collect() }
    }

    /// Position and velocity at all times of a run's steps, from 0 on, by rotating each cosine.
    fn series(&self, instants: usize, dt: f64) -> Vec<[f64; 2]> {
        let amplitude = TREMBLE_M * (2.0 / self.phases.len() as f64).sqrt();
        let mut out = vec![[0.0; 2]; instants];
        for (k, &phase) in self.phases.iter().enumerate() {
            let w = TAU * (BAND_HZ.0 + 10.0 * k as f64);
            let turn = Complex::from_polar(1.0, w * dt);
            let mut z = Complex::from_polar(amplitude, phase);
            for at in &mut out {
                at[0] += z.re;
                at[1] -= w * z.im;
                z *= turn;
            }
        }
        out
    }
}

/// The slow press with or without a tremble; forces are read in the middle of steps, so the tremble is tabulated there.
fn press(instrument: &Instrument, tremble: Option<&Tremble>) -> Result<Run, ReproduceError> {
    let duration_s = DEPTH_M / SPEED_M_PER_S;
    let instants = (duration_s / STEP_S).ceil() as usize + 2;
    let table = tremble.map(|t| t.series(instants, STEP_S));
    let finger = |t: f64| {
        // The speed rises over the first 20 ms.
        let rise = 0.02;
        let (mut y, mut v) = if t < rise {
            (
                0.5 * SPEED_M_PER_S * (t - rise / PI * (PI * t / rise).sin()),
                0.5 * SPEED_M_PER_S * (1.0 - (PI * t / rise).cos()),
            )
        } else {
            (SPEED_M_PER_S * (t - 0.5 * rise), SPEED_M_PER_S)
        };
        if let Some(table) = &table {
            let n = ((t / STEP_S).floor().max(0.0) as usize).min(table.len() - 1);
            y += table[n][0];
            v += table[n][1];
        }
        [y, v]
    };
    let settings = Settings { tolerance: 1e-11, ..Settings::new(STEP_S) };
    let setup = Setup { settings, record_every: Some(1), ..Setup::new(duration_s) };
    Ok(simulate(instrument, &player::motion(&finger), &setup, &mut |_| true)?)
}

/// Responses at all places.
fn responses(instrument: &Instrument, progress: &mut Progress) -> Result<Vec<Response>, ReproduceError> {
    let slow = press(instrument, None)?;
    let samples = (WINDOW_S / STEP_S).round() as usize;
    let mut sums = vec![(vec![Complex::new(0.0, 0.0); samples], vec![0.0; samples]); PLACES_M.len()];
    let mut planner = FftPlanner::new();
    let fft = planner.plan_fft_forward(samples);
    for k in 0..TREMBLES {
        tell(progress, (k + 1) as f64 / (TREMBLES + 1) as f64)?;
        let trembling = press(instrument, Some(&Tremble::new(k as u64 + 1)))?;
        for (place, sum) in PLACES_M.iter().zip(&mut sums) {
            let first = ((place / SPEED_M_PER_S - 0.5 * WINDOW_S) / STEP_S).round() as usize;
            let spectrum = |a: &[f64], b: &[f64]| {
                let hann = |n: usize| 0.5 * (1.0 - (TAU * n as f64 / samples as f64).cos());
                let mut z: Vec<Complex<f64>> =
                    (0..samples).map(|n| Complex::new((a[first + n] - b[first + n]) * hann(n), 0.0)).collect();
                fft.process(&mut z);
                z
            };
            let (y, f) = (spectrum(&trembling.key_m, &slow.key_m), spectrum(&trembling.force_n, &slow.force_n));
            for n in 0..samples {
                sum.0[n] += f[n].conj() * y[n];
                sum.1[n] += f[n].norm_sqr();
            }
        }
    }
    let bin = 1.0 / WINDOW_S;
    Ok(sums
        .into_iter()
        .map(|(cross, own)| {
            let used = (0..samples / 2).filter(|n| (BAND_HZ.0..=BAND_HZ.1).contains(&(*n as f64 * bin)));
            let (frequency, admittance) = used.map(|n| (n as f64 * bin, cross[n] / own[n])).unzip();
            Response { frequency, admittance }
        })
        .collect())
}

impl Response {
    /// Slope of |H| in the slope band, dB per decade, by least squares.
    fn slope(&self) -> f64 {
        let points: Vec<(f64, f64)> = self
            .frequency
            .iter()
            .zip(&self.admittance)
            .filter(|(f, _)| (SLOPE_HZ.0..=SLOPE_HZ.1).contains(*f))
            .map(|(f, h)| (f.log10(), 20.0 * h.norm().log10()))
            .collect();
        let n = points.len() as f64;
        let (mx, my) = (points.iter().map(|p| p.0).sum::<f64>() / n, points.iter().map(|p| p.1).sum::<f64>() / n);
        points.iter().map(|(x, y)| (x - mx) * (y - my)).sum::<f64>()
            / points.iter().map(|(x, _)| (x - mx).powi(2)).sum::<f64>()
    }

    /// Effective mass at the top of the slope band, at the key's front, kg: 1 / (w^2 |H|).
    fn mass(&self) -> f64 {
        let n = self.frequency.partition_point(|f| *f < SLOPE_HZ.1).min(self.frequency.len() - 1);
        1.0 / ((TAU * self.frequency[n]).powi(2) * self.admittance[n].norm())
    }

    /// Frequencies at which two responses differ by more than 3 dB: the lowest, the highest, and their share of the
    /// band.
    fn parts_from(&self, other: &Response) -> Option<(f64, f64, f64)> {
        let apart: Vec<f64> = self
            .frequency
            .iter()
            .zip(self.admittance.iter().zip(&other.admittance))
            .filter(|(_, (a, b))| {
                let ratio = a.norm() / b.norm();
                !(1.0 / PART..=PART).contains(&ratio)
            })
            .map(|(f, _)| *f)
            .collect();
        Some((*apart.first()?, *apart.last()?, apart.len() as f64 / self.frequency.len() as f64))
    }
}

pub(super) fn section(instrument: &Instrument, progress: &mut Progress) -> Result<Section, ReproduceError> {
    let one = reduce(instrument)?.instrument;
    let six = responses(instrument, &mut |share| progress(0.8 * share))?;
    let one = responses(&one, &mut |share| progress(0.8 + 0.2 * share))?;
    let mut section = Section {
        text: vec![format!(
            "A soft finger presses at {} mm/s and trembles by {} um (rms, {} to {} Hz, {TREMBLES} times) on top. Displacement of the key over \
             force of the finger, and its inverse, in Hann windows of {} ms around {} mm of travel; slopes by least squares from {} to {} Hz.",
            SPEED_M_PER_S * 1e3,
            TREMBLE_M * 1e6,
            BAND_HZ.0,
            BAND_HZ.1,
            WINDOW_S * 1e3,
            PLACES_M.map(|p| format!("{}", p * 1e3)).join(", "),
            SLOPE_HZ.0,
            SLOPE_HZ.1
        )],
        ..Section::default()
    };
    let mut table = Table::new(
        "Slopes at high frequency, where the models part by more than 3 dB, and the mass that moves at 1500 Hz, as felt at the key's front",
        &[
            "key",
            "six bodies, y/F",
            "one, y/F",
            "six bodies, F/y",
            "one, F/y",
            "part from",
            "to",
            "share of the bins",
            "six bodies move",
            "one moves",
        ],
    );
    let mut slopes = Vec::new();
    let mut parted = 0;
    for ((place, a), b) in PLACES_M.iter().zip(&six).zip(&one) {
        let (sa, sb) = (a.slope(), b.slope());
        slopes.extend([sa, sb]);
        let apart = a.parts_from(b);
        parted += usize::from(apart.is_some());
        let db = |s: f64| format!("{s:+.1} dB/decade");
        let hz = |f: Option<f64>| f.map_or("-".into(), |f| format!("{f:.0} Hz"));
        table.row([
            format!("{} mm", place * 1e3),
            db(sa),
            db(sb),
            db(-sa),
            db(-sb),
            hz(apart.map(|a| a.0)),
            hz(apart.map(|a| a.1)),
            apart.map_or("0 %".into(), |a| format!("{:.0} %", 100.0 * a.2)),
            format!("{:.0} g", 1e3 * a.mass()),
            format!("{:.0} g", 1e3 * b.mass()),
        ]);
    }
    let worst = slopes.iter().fold(0.0_f64, |m, s| m.max((s + 40.0).abs()));
    section.claims.push(Claim::new(
        "[T12]",
        "from force to displacement the mechanism is a second-order low-pass: -40 dB per decade at high frequency, within 4 dB",
        format!("slopes {}", slopes.iter().map(|s| format!("{s:+.1}")).collect::<Vec<_>>().join(", ")),
        worst < 4.0,
    ));
    section.claims.push(Claim::new(
        "[T12]",
        "from displacement to force it is a second-order high-pass, +40 dB per decade: what force-driven simulation hides, \
         motion-driven reveals",
        format!(
            "the inverse of the above; between {} and {} Hz the same difference weighs {:.0} dB more in the force than in the displacement",
            SLOPE_HZ.0,
            SLOPE_HZ.1,
            -2.0 * slopes.iter().sum::<f64>() / slopes.len() as f64 * (SLOPE_HZ.1 / SLOPE_HZ.0).log10()
        ),
        worst < 4.0,
    ));
    section.claims.push(Claim::new(
        "[T12]",
        "one degree of freedom and the whole mechanism part in a band of frequencies, at every point of the stroke",
        format!("by more than 3 dB at {parted} of {} places; see the table", PLACES_M.len()),
        parted == PLACES_M.len(),
    ));
    section.tables.push(table);
    for (inverse, title, unit) in
        [(false, "From force to displacement", "|y/F| (um/N)"), (true, "From displacement to force", "|F/y| (N/mm)")]
    {
        let panels = PLACES_M
            .iter()
            .zip(six.iter().zip(&one))
            .map(|(place, (a, b))| {
                let curve = |r: &Response, label: &str, colour, mark| ChartCurve {
                    label: label.into(),
                    x: r.frequency.clone(),
                    y: r.admittance.iter().map(|h| if inverse { 1e-3 / h.norm() } else { 1e6 * h.norm() }).collect(),
                    colour,
                    mark,
                };
                ChartPanel {
                    y_label: format!("{} mm: {unit}", place * 1e3),
                    y_log: true,
                    y_range: None,
                    curves: vec![
                        curve(a, "six bodies", 1, Dash::Solid),
                        curve(b, "one degree of freedom", 0, Dash::Dashed),
                    ],
                }
            })
            .collect();
        section.charts.push(Chart {
            title: title.into(),
            caption: "Small broad-band motion of the finger during a slow press, at three points of the stroke".into(),
            x_label: "frequency (Hz)".into(),
            x_log: true,
            panels,
        });
    }
    Ok(section)
}
