//! Touch and control: how much of the mechanism a finger can feel, and how well it controls the impact; numbers for the
//! papers' two remarks.
//!
//! **The fine structure of the force.** The whole action and one degree of freedom are driven by the same prescribed
//! key motion; the difference of their forces is the mechanism's contribution to the touch beyond inertia and weight.
//! Its spectrum is compared with what fingers feel:
//!
//! - two steady forces are distinguished when they differ by about 7 % (Pang, Tan and Durlach, Manual discrimination of
//!   force using active finger motion, Percept. Psychophys. 49 (1991) 531, its abstract: 2.5 to 10 N);
//! - a steady vibration is felt from about 0.1 um at 250 Hz, four times as much for every octave below, down to 40 Hz,
//!   and with a smaller slope below that (Verrillo, J. Acoust. Soc. Am. 77 (1985) 225, a large contactor; from memory).
//!   Through the fingertip's own stiffness that is a force. Active pressing lowers these thresholds (Papetti,
//!   Järveläinen, Giordano, Schiesser, Fröhlich, IEEE Trans. Haptics 10 (2017) 113, its abstract), a transient of some
//!   tens of milliseconds raises them: an estimate.
//!
//! **The scatter of the impact.** A touch never repeats exactly. How much of its scatter appears in the hammer's speed
//! and time?

use std::f64::consts::PI;

use fastrand::Rng;
use moreau::Settings;
use rustfft::FftPlanner;
use rustfft::num_complex::Complex;

use super::impact::tell;
use super::{Chart, ChartCurve, ChartPanel, Claim, Dash, Progress, ReproduceError, Section, Table};
use erard::instrument::Instrument;
use erard::one_dof::{OneDof, reduce};
use erard::player::{self};
use erard::run::Run;
use erard::run::press_by_hand;
use erard::run::{Setup, simulate};
use erard::stroke::HandStroke;
use erard::stroke::PositionSeries;

/// Step, s.
const STEP_S: f64 = 50e-6;
/// The smallest distinguishable difference of a force, as a share (Pang, Tan and Durlach 1991).
const FORCE_JND: f64 = 0.07;
/// Threshold of vibration, m root mean square, at the most sensitive frequency of the skin, Hz (Verrillo 1985, from
/// memory).
const FELT_M: f64 = 0.1e-6;
const MOST_SENSITIVE_HZ: f64 = 250.0;
/// Lower end of the slope, Hz.
const SLOPE_FROM_HZ: f64 = 40.0;
/// Durations of led hands, s: p to mf.
const WITHIN_S: [f64; 3] = [0.2, 0.12, 0.08];
/// Third-octave bands: of 1 kHz times 10^(n/10).
const BANDS: std::ops::RangeInclusive<i32> = -17..=0;

/// Threshold amplitude of a steady vibration, m root mean square.
fn felt_m(hz: f64) -> f64 {
    FELT_M * (MOST_SENSITIVE_HZ / hz.clamp(SLOPE_FROM_HZ, MOST_SENSITIVE_HZ)).powi(2)
}

/// Difference of the forces under one motion.
struct FineStructure {
    within_s: f64,
    speed_m_per_s: f64,
    time_s: Vec<f64>,
    whole_n: Vec<f64>,
    one_n: Vec<f64>,
    /// Rows of the press: from where the key moves to where it lands.
    down: std::ops::Range<usize>,
    /// First row in which the key meets the damper, the lever its drop screw, or the jack's toe its button.
    met: usize,
}

impl FineStructure {
    fn new(instrument: &Instrument, one: &Instrument, within_s: f64) -> Result<Self, ReproduceError> {
        let setup =
            Setup { settings: Settings::new(STEP_S), record_every: Some(1), ..Setup::new(2.0 * within_s + 0.1) };
        let played = press_by_hand(instrument, &HandStroke::led(within_s), &setup, &mut |_| true)?;
        let missing =
            || ReproduceError::Instrument(format!("a hand that is led down within {within_s} s does not sound"));
        let (Some(start), Some(landed), Some(speed_m_per_s)) =
            (played.events.key_start_s, played.events.key_bottom_s, played.events.hammer_speed_m_per_s())
        else {
            return Err(missing());
        };
        let position = PositionSeries::new(played.time_s.clone(), played.key_m.clone()).map_err(|_| missing())?;
        let under = |model: &Instrument| -> Result<Run, ReproduceError> {
            Ok(simulate(model, &player::rigid(position.drive()), &setup, &mut |_| true)?)
        };
        let (whole, one) = (under(instrument)?, under(one)?);
        let row = |t: f64| whole.time_s.partition_point(|&time| time < t);
        let down = row(start)..row(landed);
        let others = played
            .zones
            .iter()
            .filter(|zone| ["key_damper", "drop_screw", "let_off_button"].contains(&zone.name.as_str()));
        let first = others.filter_map(|zone| zone.normal_n.iter().position(|&normal| normal > 0.0)).min();
        let met = first.unwrap_or(down.end);
        Ok(FineStructure {
            within_s,
            speed_m_per_s,
            time_s: whole.time_s,
            whole_n: whole.force_n,
            one_n: one.force_n,
            down,
            met,
        })
    }

    fn difference(&self) -> Vec<f64> {
        self.down.clone().map(|row| self.whole_n[row] - self.one_n[row]).collect()
    }

    /// Root mean square of the difference during the press in each band, N. The mean is removed before a Hann window,
    /// whose loss of power is corrected.
    fn bands(&self) -> Vec<(f64, f64)> {
        let difference = self.difference();
        let count = difference.len();
        let mean = difference.iter().sum::<f64>() / count as f64;
        let mut spectrum: Vec<Complex<f64>> = difference
            .iter()
            .enumerate()
            .map(|(n, d)| {
                let window = 0.5 - 0.5 * (2.0 * PI * (n as f64 + 0.5) / count as f64).cos();
                Complex::new((d - mean) * window / 0.375_f64.sqrt(), 0.0)
            })
            .collect();
        FftPlanner::new().plan_fft_forward(count).process(&mut spectrum);
        let line_hz = 1.0 / (count as f64 * STEP_S);
        BANDS
            .filter_map(|n| {
                let centre = 1000.0 * 10f64.powf(f64::from(n) / 10.0);
                let edge = 10f64.powf(0.05);
                let within = |k: &usize| (centre / edge..centre * edge).contains(&(*k as f64 * line_hz));
                let lines: Vec<f64> = (1..count / 2).filter(within).map(|k| 2.0 * spectrum[k].norm_sqr()).collect();
                // In a short touch the low bands contain no line of the spectrum.
                (!lines.is_empty()).then(|| (centre, lines.iter().sum::<f64>().sqrt() / count as f64))
            })
            .collect()
    }
}

/// [T12]: is the fine structure of the force felt?
pub(super) fn fine_structure(instrument: &Instrument, progress: &mut Progress) -> Result<Section, ReproduceError> {
    let one = reduce(instrument)?.instrument;
    let softness = instrument.finger.stiffness_n_per_m;
    let mut section = Section {
        text: vec![
            "A hand of 0.2 kg leads the whole action's key down smoothly, along the path of least jerk, through the fingertip's softness; then the key of \
             both models is led along exactly the motion that came of it. What differs between the forces that this takes is the fine structure: what the \
             mechanism adds to weight and inertia. Most of it \
             comes from where the key meets the damper: that and the screws of lever and jack jolt the key, and one degree of freedom takes all its inertia along \
             where felts are compressed."
                .into(),
            format!(
                "For comparison, what fingers feel: two steady forces are distinguished if they differ by about {:.0} % (Pang, Tan and Durlach 1991). A steady vibration is \
                 felt from about 0.1 um root mean square on at 250 Hz, growing with the square of the period below (Verrillo 1985, from memory), here \
                 through the fingertip's {:.0} N/mm. Active pressing lowers these thresholds (Papetti et al. 2017), and so short a time raises them: the \
                 comparison is an estimate, to a factor of about three.",
                FORCE_JND * 100.0,
                softness * 1e-3
            ),
        ],
        ..Section::default()
    };
    let mut table = Table::new(
        "The difference on the way down, root mean square, and the shares of it",
        &[
            "stroke",
            "force of the whole action (N)",
            "of the difference (N)",
            "share",
            "felt bands of 18",
            "most above its threshold",
        ],
    );
    let mut panels = Vec::new();
    let mut shares = Vec::new();
    for (n, within_s) in WITHIN_S.into_iter().enumerate() {
        tell(progress, n as f64 / 3.0)?;
        let found = FineStructure::new(instrument, &one, within_s)?;
        let rms = |values: &[f64]| (values.iter().map(|x| x * x).sum::<f64>() / values.len() as f64).sqrt();
        let whole = rms(&found.whole_n[found.down.clone()]);
        let all = found.difference();
        let [difference, before] =
            [&all[..], &all[..found.met.clamp(found.down.start + 1, found.down.end) - found.down.start]].map(rms);
        let bands = found.bands();
        let above = |(hz, force): &(f64, f64)| force / (softness * felt_m(*hz));
        let felt = bands.iter().filter(|band| above(band) > 1.0).count();
        let most = bands.iter().max_by(|a, b| above(a).total_cmp(&above(b))).copied().unwrap_or_default();
        table.row([
            format!("led down within {:.0} ms: {:.2} m/s", 1e3 * found.within_s, found.speed_m_per_s),
            format!("{whole:.2}"),
            format!("{before:.2}"),
            format!("{difference:.2}"),
            format!("{:.0} %", 100.0 * difference / whole),
            format!("{felt} of {}", bands.len()),
            format!("{:.0} dB at {:.0} Hz", 20.0 * above(&most).log10(), most.0),
        ]);
        shares.push((difference / whole, above(&most)));
        if n == 1 {
            let time = |row: usize| 1e3 * (found.time_s[row] - found.time_s[found.down.start]);
            let curve = |label: &str, values: &[f64], colour, mark| ChartCurve {
                label: label.into(),
                x: found.down.clone().map(time).collect(),
                y: found.down.clone().map(|row| values[row]).collect(),
                colour,
                mark,
            };
            section.charts.push(Chart {
                title: format!("The force of one motion, {:.0} ms", 1e3 * found.within_s),
                caption: "The key is led alike in both models, from where it starts to where it lands".into(),
                x_label: "time after the key starts (ms)".into(),
                x_log: false,
                panels: vec![ChartPanel {
                    y_label: "force (N)".into(),
                    y_log: false,
                    y_range: None,
                    curves: vec![
                        curve("whole action", &found.whole_n, 1, Dash::Solid),
                        curve("one degree of freedom", &found.one_n, 0, Dash::Dashed),
                    ],
                }],
            });
        }
        let curve = |label: &str, y: Vec<f64>, colour, mark| ChartCurve {
            label: label.into(),
            x: bands.iter().map(|(hz, _)| *hz).collect(),
            y,
            colour,
            mark,
        };
        panels.push(ChartPanel {
            y_label: format!("{:.0} ms: force (N rms)", 1e3 * found.within_s),
            y_log: true,
            y_range: None,
            curves: vec![
                curve("difference in third octaves", bands.iter().map(|(_, f)| f.max(1e-6)).collect(), 1, Dash::Points),
                curve(
                    "felt from here on (estimate)",
                    bands.iter().map(|(hz, _)| softness * felt_m(*hz)).collect(),
                    2,
                    Dash::Dashed,
                ),
            ],
        });
    }
    let least_share = shares.iter().map(|s| s.0).fold(f64::INFINITY, f64::min);
    let least_above = shares.iter().map(|s| s.1).fold(f64::INFINITY, f64::min);
    section.claims.push(Claim::new(
        "[T12]",
        "the force of the whole mechanism has a fine structure that one degree of freedom has not; a finger feels it",
        format!(
            "the difference is at least {:.0} % of the force ({:.0} % can be distinguished), and at least {:.0} dB above the threshold of vibration in its strongest band",
            100.0 * least_share,
            100.0 * FORCE_JND,
            20.0 * least_above.log10()
        ),
        // The thresholds are known to a factor of three.
        least_share > FORCE_JND && least_above > 3.0,
    ));
    section.tables.push(table);
    section.charts.push(Chart {
        title: "The fine structure of the force".into(),
        caption: "Force of the whole action less that of one degree of freedom under the same motion, on the way down"
            .into(),
        x_label: "frequency (Hz)".into(),
        x_log: true,
        panels,
    });
    Ok(section)
}

/// Number of touches of a kind.
const TOUCHES: usize = 64;
/// Relative scatter of the rate of force, and of the hand's mass. Both assumed.
const SCATTER: f64 = 0.05;
/// Rates of force, N/s: soft to loud.
const RATES_N_S: [f64; 3] = [40.0, 150.0, 600.0];

/// An impact: time after the force begins to rise, s, and speed, m/s.
#[derive(Clone, Copy)]
struct Hit {
    at_s: f64,
    speed_m_per_s: f64,
}

/// Model that is played: an action, or one degree of freedom, whose hammer moves with the key.
enum Model<'a> {
    Action(&'a Instrument),
    /// With the travel of the strike point per metre of the key's front, and its distance to the string, m.
    OneDegree {
        one: &'a Instrument,
        ratio: f64,
        way_m: f64,
    },
}

impl Model<'_> {
    fn hit(&self, gesture: &HandStroke) -> Result<Option<(Hit, f64)>, ReproduceError> {
        let setup = Setup { settings: Settings::new(STEP_S), record_every: Some(1), ..Setup::new(0.35) };
        match self {
            Model::Action(instrument) => {
                let run = press_by_hand(instrument, gesture, &setup, &mut |_| true)?;
                let (Some(at_s), Some(speed_m_per_s)) =
                    (run.events.hammer_contact_s(), run.events.hammer_speed_m_per_s())
                else {
                    return Ok(None);
                };
                let row = run.time_s.partition_point(|&t| t < at_s).min(run.time_s.len() - 1);
                Ok(Some((Hit { at_s, speed_m_per_s }, run.hammer_rise_m[row] - run.hammer_rise_m[0])))
            }
            Model::OneDegree { one, ratio, way_m } => {
                let run = press_by_hand(one, gesture, &setup, &mut |_| true)?;
                let depth = way_m / ratio;
                let Some(row) = run.key_m.iter().position(|&y| y >= depth).filter(|&row| row > 0) else {
                    return Ok(None);
                };
                let (below, above) = (run.key_m[row - 1], run.key_m[row]);
                let at_s = run.time_s[row - 1] + STEP_S * (depth - below) / (above - below);
                Ok(Some((Hit { at_s, speed_m_per_s: ratio * (above - below) / STEP_S }, *way_m)))
            }
        }
    }
}

/// A touch with normal scatter, from uniform numbers (Box and Muller).
fn touch(rate_n_s: f64, rng: &mut Rng) -> HandStroke {
    let [u, v] = [1.0 - rng.f64(), rng.f64()];
    let radius = SCATTER * (-2.0 * u.ln()).sqrt();
    let (sin, cos) = (2.0 * PI * v).sin_cos();
    let mut gesture = HandStroke::ramped(rate_n_s * (1.0 + radius * cos));
    gesture.hand.mass_kg *= 1.0 + radius * sin;
    gesture
}

/// [T13]: "remarkably accurate control of the hammer velocity and the impact time".
pub(super) fn scatter(instrument: &Instrument, progress: &mut Progress) -> Result<Section, ReproduceError> {
    let Some(hammer) = instrument.roles.hammer else {
        return Err(ReproduceError::Instrument("there is no hammer".into()));
    };
    let weighing = |factor: f64| {
        let mut other = instrument.clone();
        other
            .edit(|fields| {
                fields.bodies[hammer].mass_kg *= factor;
                fields.bodies[hammer].inertia_kg_m2 *= factor;
            })
            .expect("numbers alone");
        other
    };
    let (heavier, lighter) = (weighing(1.3), weighing(0.7));
    let OneDof { instrument: one, ratios, .. } = reduce(instrument)?;
    let rigid = instrument.locked();
    let length = |[x, y]: [f64; 2]| x.hypot(y);
    let ratio = match rigid.roles.hammer {
        Some(body) => ratios[body].abs() * length(rigid.roles.hammer_strike_point_m) / length(rigid.roles.key_front_m),
        None => return Err(ReproduceError::Instrument("there is no hammer".into())),
    };
    let mut table = Table::new(
        format!("Scatter of {TOUCHES} pressed touches, standard deviations"),
        &[
            "force rises by",
            "what is played",
            "hammer (m/s)",
            "its scatter",
            "instant (ms)",
            "its scatter (ms)",
            "key stroke's share",
        ],
    );
    let mut section = Section {
        text: vec![format!(
            "A hand of 0.2 kg presses with a force that rises steadily; rate and mass scatter by {:.0} % each (normal, independent; assumed), alike for all \
             that is played. The instant counts from where the force begins to rise. One degree of freedom has no escapement: its hammer goes with the key, \
             by the leverage at rest, until it has gone as far as the action's hammer goes to the string.",
            100.0 * SCATTER
        )],
        ..Section::default()
    };
    let mut worst_gain: f64 = 0.0;
    let mut worst_share: f64 = 0.0;
    for (n, rate_n_s) in RATES_N_S.into_iter().enumerate() {
        let Some((_, way_m)) = Model::Action(instrument).hit(&HandStroke::ramped(rate_n_s))? else { continue };
        let models = [
            ("the action", Model::Action(instrument)),
            ("hammer 30 % heavier", Model::Action(&heavier)),
            ("hammer 30 % lighter", Model::Action(&lighter)),
            ("one degree of freedom", Model::OneDegree { one: &one, ratio, way_m }),
        ];
        for (m, (name, model)) in models.iter().enumerate() {
            // The same touches for all.
            let mut rng = Rng::with_seed(n as u64);
            let mut hits = Vec::new();
            for k in 0..TOUCHES {
                let of_model = (m as f64 + k as f64 / TOUCHES as f64) / models.len() as f64;
                tell(progress, (n as f64 + of_model) / RATES_N_S.len() as f64)?;
                hits.extend(model.hit(&touch(rate_n_s, &mut rng))?.map(|(hit, _)| hit));
            }
            let [speed, speed_sd] = statistics(hits.iter().map(|hit| hit.speed_m_per_s));
            let [at, at_sd] = statistics(hits.iter().map(|hit| hit.at_s));
            if m == 0 {
                worst_gain = worst_gain.max(speed_sd / speed / SCATTER);
                worst_share = worst_share.max(at_sd / at);
            }
            let sounding = if hits.len() < TOUCHES { format!(" ({} sound)", hits.len()) } else { String::new() };
            table.row([
                format!("{rate_n_s} N/s"),
                format!("{name}{sounding}"),
                format!("{speed:.2}"),
                format!("{:.1} %", 100.0 * speed_sd / speed),
                format!("{:.1}", 1e3 * at),
                format!("{:.2}", 1e3 * at_sd),
                format!("{:.1} %", 100.0 * at_sd / at),
            ]);
        }
    }
    section.claims.push(Claim::new(
        "[T13]",
        "the action gives remarkably accurate control of the hammer's speed and of the instant of impact",
        format!(
            "a touch that scatters by {:.0} % scatters the speed by at most {:.1} % and the instant by at most {:.1} % of its delay",
            100.0 * SCATTER,
            100.0 * worst_gain * SCATTER,
            100.0 * worst_share
        ),
        worst_gain < 1.0 && worst_share < SCATTER,
    ));
    section.tables.push(table);
    Ok(section)
}

/// Mean and standard deviation.
fn statistics(values: impl Iterator<Item = f64> + Clone) -> [f64; 2] {
    let count = values.clone().count() as f64;
    let mean = values.clone().sum::<f64>() / count;
    let square: f64 = values.map(|x| (x - mean) * (x - mean)).sum();
    [mean, (square / (count - 1.0)).sqrt()]
}

#[cfg(test)]
mod tests {
    use super::*;
    use erard::stroke::Muscle;

    /// A sine of known amplitude has its root mean square in its band, and nowhere else.
    #[test]
    fn a_sine_lies_in_its_band() {
        let count = 4000;
        let time_s: Vec<f64> = (0..count).map(|n| n as f64 * STEP_S).collect();
        let whole_n = time_s.iter().map(|t| 3.0 + 0.2 * (2.0 * PI * 200.0 * t).sin()).collect();
        let found = FineStructure {
            within_s: 0.1,
            speed_m_per_s: 1.0,
            one_n: vec![1.0; count],
            time_s,
            whole_n,
            down: 0..count,
            met: count,
        };
        for (hz, force) in found.bands() {
            let expected = if (178.0..224.0).contains(&hz) { 0.2 / 2f64.sqrt() } else { 0.0 };
            assert!((force - expected).abs() < 1e-3, "{hz} Hz: {force}");
        }
    }

    #[test]
    fn touches_scatter_by_what_is_said() {
        let mut rng = Rng::with_seed(1);
        let touches: Vec<HandStroke> = (0..4000).map(|_| touch(100.0, &mut rng)).collect();
        let rate = |gesture: &HandStroke| match gesture.muscle {
            Muscle::Rises { rate_n_s, .. } => rate_n_s,
            _ => f64::NAN,
        };
        let [mean, sd] = statistics(touches.iter().map(rate));
        assert!((mean - 100.0).abs() < 0.3 && (sd - 5.0).abs() < 0.2, "{mean} {sd}");
        let [mean, sd] = statistics(touches.iter().map(|gesture| gesture.hand.mass_kg));
        assert!((mean - 0.2).abs() < 6e-4 && (sd - 0.01).abs() < 4e-4, "{mean} {sd}");
    }
}
