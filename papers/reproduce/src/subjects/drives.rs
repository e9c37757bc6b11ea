//! [T12] figure 3: p and f, force-driven and motion-driven, six bodies compared with one degree of freedom.

use fastrand::Rng;
use moreau::Settings;

use super::impact::{Play, tell};
use super::{Chart, ChartCurve, ChartPanel, Claim, Dash, Progress, ReproduceError, Section, Table};
use erard::instrument::Instrument;
use erard::one_dof::reduce;
use erard::player::{self, Drive};
use erard::run::Run;
use erard::run::{Setup, simulate};
use erard::stroke::{Cursor, ForceSeries, PositionOf, PositionSeries, Series, Touch};
use erard_workshop::compare::{Errors, RATE_HZ};

/// Step of the reference runs, s; the models run at 50 us.
const REFERENCE_STEP_S: f64 = 6.25e-6;
/// Sampling of the reference series, s.
const SAMPLE_S: f64 = 0.5e-3;
/// Root mean square of added sensor noise, uniform: a load cell's, N, and a laser vibrometer's, m. Both assumed.
const FORCE_NOISE_N: f64 = 0.01;
const POSITION_NOISE_M: f64 = 0.02e-6;
/// Duration, s.
const DURATION_S: f64 = 0.35;

/// Sensor noise: uniform, with unit variance, the same every time.
struct Noise(Rng);

impl Noise {
    fn next(&mut self) -> f64 {
        (2.0 * self.0.f64() - 1.0) * 3.0_f64.sqrt()
    }
}

/// Step of the models, s: five of them make a row.
const STEP_S: f64 = 50e-6;
const ROW_STEPS: u64 = (1.0 / (RATE_HZ * STEP_S)) as u64;

/// A soft finger's stroke as sensors between finger and key would record it on the six-body model, run with a finer
/// step.
struct Reference {
    nuance: &'static str,
    force: ForceSeries,
    position: PositionSeries,
    /// On the common time axis: s, N, m.
    time_s: Vec<f64>,
    force_n: Vec<f64>,
    key_m: Vec<f64>,
    /// Number of rows before the key lands.
    way_down: usize,
}

impl Reference {
    fn new(instrument: &Instrument, nuance: &'static str) -> Result<Self, ReproduceError> {
        let every = (SAMPLE_S / REFERENCE_STEP_S).round() as u64;
        let settings = Settings::new(REFERENCE_STEP_S);
        let run = Play::Motion(nuance, Touch::Pressed).run(instrument, settings, DURATION_S, every)?;
        let mut noise = Noise(Rng::with_seed(0x9E37_79B9_7F4A_7C15));
        let force = run.force_n.iter().map(|f| (f + FORCE_NOISE_N * noise.next()).max(0.0)).collect();
        let position = run.key_m.iter().map(|y| y + POSITION_NOISE_M * noise.next()).collect();
        let bad = |e| ReproduceError::Instrument(format!("the reference run gives no series: {e}"));
        let force = ForceSeries::new(run.time_s.clone(), force).map_err(bad)?;
        let position = PositionSeries::new(run.time_s, position).map_err(bad)?;
        let landed =
            run.events.key_bottom_s.ok_or_else(|| ReproduceError::Instrument("the key does not land".into()))?;
        let time_s: Vec<f64> = (0..=(DURATION_S * RATE_HZ) as usize).map(|n| n as f64 / RATE_HZ).collect();
        let mut cursor = Cursor::default();
        let force_n = time_s.iter().map(|t| force.at(*t, &mut cursor)).collect();
        let key_m = time_s.iter().map(|t| position.at(*t, &mut cursor).0).collect();
        let way_down = time_s.partition_point(|t| *t < landed);
        Ok(Reference { nuance, force, position, time_s, force_n, key_m, way_down })
    }

    /// Result of a model: the key's position (m) if the force drives it, the force (N) if the key's motion does.
    fn outcome(&self, model: &Instrument, by_force: bool) -> Result<Vec<f64>, ReproduceError> {
        let (force, position) = (self.force.drive(), self.position.drive());
        let drive: &Drive<'_> = if by_force { &player::force(&force) } else { &player::rigid(&position) };
        let run = self.run(model, drive)?;
        Ok(if by_force { run.key_m } else { run.force_n })
    }

    /// Runs a model over the common time axis.
    fn run(&self, model: &Instrument, drive: &Drive<'_>) -> Result<Run, ReproduceError> {
        let duration_s = (self.time_s.len() - 1) as f64 / RATE_HZ;
        let setup = Setup { settings: Settings::new(STEP_S), record_every: Some(ROW_STEPS), ..Setup::new(duration_s) };
        Ok(simulate(model, drive, &setup, &mut |_| true)?)
    }

    fn own(&self, by_force: bool) -> &[f64] {
        if by_force { &self.key_m } else { &self.force_n }
    }
}

/// A model with its name and line style.
struct Compared {
    name: &'static str,
    instrument: Instrument,
    colour: usize,
    mark: Dash,
}

/// The one-degree-of-freedom model with inertia and viscous friction fitted to the force-driven positions of all
/// references: least sum of squared errors, each relative to its variance, by search along one parameter after the
/// other.
fn fitted(derived: &Instrument, references: &[Reference]) -> Result<Instrument, ReproduceError> {
    let with = |x: [f64; 2]| {
        let mut model = derived.clone();
        model
            .edit(|fields| {
                fields.bodies[0].inertia_kg_m2 *= x[0].exp();
                fields.bodies[0].viscous_n_m_s = x[1].exp();
            })
            .expect("numbers alone");
        model
    };
    let cost = |x: [f64; 2]| -> Result<f64, ReproduceError> {
        let model = with(x);
        let mut sum = 0.0;
        for r in references {
            sum += 1.0 - Errors::new(&r.key_m, &r.outcome(&model, true)?, 0).explained;
        }
        Ok(sum)
    };
    let ends = [(0.05_f64.ln(), 2.0_f64.ln()), (1e-4_f64.ln(), 1.0_f64.ln())];
    let mut best = [0.0, 1e-3_f64.ln()];
    for round in 0..3 {
        for k in 0..2 {
            // A grid over the whole range, then golden section around its best point.
            let at = |v: f64| {
                let mut x = best;
                x[k] = v;
                cost(x)
            };
            let cells = 12;
            let cell = (ends[k].1 - ends[k].0) / f64::from(cells);
            let (mut low, mut high) = (best[k] - cell, best[k] + cell);
            if round == 0 {
                let mut least = (f64::INFINITY, 0.0);
                for n in 0..=cells {
                    let v = ends[k].0 + f64::from(n) * cell;
                    let c = at(v)?;
                    if c < least.0 {
                        least = (c, v);
                    }
                }
                (low, high) = (least.1 - cell, least.1 + cell);
            }
            let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
            let (mut a, mut b) = (high - golden * (high - low), low + golden * (high - low));
            let (mut at_a, mut at_b) = (at(a)?, at(b)?);
            for _ in 0..14 {
                if at_a < at_b {
                    (high, b, at_b) = (b, a, at_a);
                    a = high - golden * (high - low);
                    at_a = at(a)?;
                } else {
                    (low, a, at_a) = (a, b, at_b);
                    b = low + golden * (high - low);
                    at_b = at(b)?;
                }
            }
            best[k] = 0.5 * (low + high);
        }
    }
    Ok(with(best))
}

pub(super) fn section(instrument: &Instrument, progress: &mut Progress) -> Result<Section, ReproduceError> {
    let mut section = Section {
        text: vec![
            format!(
                "The measured series of [T12] are not published. A run of the six-body model under a moving soft finger, with a step of {} us, sampled every {} ms, with \
                 sensor noise of {FORCE_NOISE_N} N and {} um added, stands in for them, here and in every figure below. That the six-body \
                 model comes near it is therefore a check of the procedure, of noise and of the step, not of the model; what the \
                 one-degree-of-freedom model misses is the papers' point and does not depend on that.",
                REFERENCE_STEP_S * 1e6,
                SAMPLE_S * 1e3,
                POSITION_NOISE_M * 1e6
            ),
            "One degree of freedom stands twice: derived from the six bodies by virtual power at rest, and with inertia and viscous friction \
             fitted to the force-driven positions, as an experimenter would who has only the key."
                .into(),
            "Motion-driven means here that the key's own measured motion is imposed on the key, and the force that this takes comes out. The \
             way down ends where the reference's key lands."
                .into(),
            "Whose motion it is decides. What [T12] and [T13] call the position is taken to be the key's, which is what a sensor below or above \
             a key sees; the fingertip is ahead of it by F/k, a fifth of a millimetre for 4 N. A key's trace that is played as a fingertip's \
             comes that much late, and a model that is right then seems to miss the force. The last table plays the same trace in all three ways."
                .into(),
        ],
        ..Section::default()
    };
    let references = [Reference::new(instrument, "p")?, Reference::new(instrument, "f")?];
    tell(progress, 0.2)?;
    let derived = reduce(instrument)?.instrument;
    let fitted = fitted(&derived, &references)?;
    tell(progress, 0.8)?;
    let key = |m: &Instrument| (m.bodies[0].inertia_kg_m2, m.bodies[0].viscous_n_m_s);
    section.text.push(format!(
        "Derived: {:.3e} kg m2, {:.1e} N m s. Fitted: {:.3e} kg m2, {:.1e} N m s.",
        key(&derived).0,
        key(&derived).1,
        key(&fitted).0,
        key(&fitted).1
    ));
    let models = [
        Compared { name: "six bodies", instrument: instrument.clone(), colour: 1, mark: Dash::Dashed },
        Compared { name: "one, derived", instrument: derived, colour: 0, mark: Dash::Solid },
        Compared { name: "one, fitted", instrument: fitted, colour: 4, mark: Dash::Solid },
    ];
    let mut table = Table::new(
        "What each model misses of the reference",
        &[
            "nuance",
            "drive",
            "model",
            "over",
            "rms",
            "of range",
            "largest",
            "explained",
            "10-50 Hz missed",
            "50-200 Hz missed",
        ],
    );
    for reference in &references {
        let mut panels = Vec::new();
        for by_force in [true, false] {
            let mut curves =
                vec![curve(reference, "reference (stand-in)", reference.own(by_force), by_force, 6, Dash::Solid)];
            // Of the whole stroke and of the press down, by model.
            let mut explained = [[f64::NAN; 3]; 2];
            for (k, model) in models.iter().enumerate() {
                let ours = reference.outcome(&model.instrument, by_force)?;
                for (part, rows) in [reference.time_s.len(), reference.way_down].into_iter().enumerate() {
                    let e = Errors::new(&reference.own(by_force)[..rows], &ours[..rows], 0);
                    explained[part][k] = e.explained;
                    table.row(cells(reference.nuance, by_force, model.name, &e, part == 0));
                }
                curves.push(curve(reference, model.name, &ours, by_force, model.colour, model.mark));
            }
            claims(reference.nuance, by_force, &explained, &mut section);
            let y_label = if by_force { "force-driven: key (mm)" } else { "motion-driven: force (N)" };
            // One degree of freedom is far out of range, and would flatten all other curves.
            let y_range = (!by_force).then(|| range(&reference.force_n));
            panels.push(ChartPanel { y_label: y_label.into(), y_log: false, y_range, curves });
        }
        section.charts.push(Chart {
            title: format!("{}: what comes out when the force, and when the motion, is given", reference.nuance),
            caption: "Reference: a run of the six-body model with a finer step and added sensor noise, in place of the unpublished \
                      measurement. What leaves the lower panel stands in the table"
                .into(),
            x_label: "time (ms)".into(),
            x_log: false,
            panels,
        });
    }
    section.tables.push(table);
    section.tables.push(whose(instrument, &references)?);
    Ok(section)
}

/// Plays the key's trace of each reference in its possible meanings, and returns how much of the force the six bodies
/// explain.
fn whose(instrument: &Instrument, references: &[Reference]) -> Result<Table, ReproduceError> {
    let mut table = Table::new(
        "Whose position it is: the key's trace, played on the six bodies in three ways",
        &["nuance", "played as", "rms of the force", "explained"],
    );
    for reference in references {
        let series = Series {
            force: Some(reference.force.clone()),
            position: Some(reference.position.clone()),
            hammer_head: None,
            hammer_speed: None,
        };
        let fingertip = series
            .position_of(PositionOf::Fingertip, PositionOf::Key, &instrument.finger)
            .map_err(|e| ReproduceError::Instrument(format!("the reference gives no fingertip: {e}")))?
            .ok_or_else(|| ReproduceError::Instrument("the reference has no force".into()))?;
        for (name, position, rigid) in [
            ("the key's, imposed on it", &reference.position, true),
            ("the fingertip's, made from it (key + F/k)", &fingertip, false),
            ("the fingertip's, taken as it is", &reference.position, false),
        ] {
            let position = position.drive();
            let drive: &Drive<'_> = if rigid { &player::rigid(&position) } else { &player::motion(&position) };
            let ours = reference.run(instrument, drive)?.force_n;
            let e = Errors::new(&reference.force_n, &ours, 0);
            table.row(vec![
                reference.nuance.into(),
                name.into(),
                format!("{:.3} N", e.rms),
                format!("{:.2} %", 100.0 * e.explained),
            ]);
        }
    }
    Ok(table)
}

fn curve(r: &Reference, label: &str, y: &[f64], by_force: bool, colour: usize, mark: Dash) -> ChartCurve {
    let factor = if by_force { 1e3 } else { 1.0 };
    let (x, y) = (r.time_s.iter().map(|t| t * 1e3).collect(), y.iter().map(|y| y * factor).collect());
    ChartCurve { label: label.into(), x, y, colour, mark }
}

fn cells(nuance: &str, by_force: bool, model: &str, e: &Errors, whole: bool) -> Vec<String> {
    let (factor, unit) = if by_force { (1e3, "mm") } else { (1.0, "N") };
    let band = |i: usize| format!("{:.0} %", 100.0 * e.bands[i].error_rms / e.bands[i].measured_rms);
    vec![
        nuance.into(),
        if by_force { "force".into() } else { "motion".into() },
        model.into(),
        if whole { "whole stroke".into() } else { "way down".into() },
        format!("{:.4} {unit}", e.rms * factor),
        format!("{:.2} %", 100.0 * e.rms_of_range),
        format!("{:.3} {unit}", e.largest * factor),
        format!("{:.2} %", 100.0 * e.explained),
        band(1),
        band(2),
    ]
}

fn claims(nuance: &str, by_force: bool, explained: &[[f64; 3]; 2], section: &mut Section) {
    let told = |e: &[f64; 3]| {
        let [six, derived, fitted] = e.map(|e| 100.0 * e);
        format!("six bodies {six:.2} %, one degree of freedom {derived:.2} % derived and {fitted:.2} % fitted")
    };
    let [whole, down] = explained;
    if by_force {
        for (part, e) in [("on the way down", down), ("over the whole stroke, key bottom and after included", whole)] {
            section.claims.push(Claim::new(
                "[T12] fig. 3, left",
                format!(
                    "{nuance}, force-driven, {part}: both models (of one degree of freedom the fitted) follow the key's position closely, more \
                     than 95 % of its variance"
                ),
                format!("of the position's variance is explained: {}", told(e)),
                e[0] > 0.95 && e[2] > 0.95,
            ));
        }
        section.claims.push(Claim::new(
            "this program",
            format!(
                "{nuance}, force-driven: one degree of freedom needs no fit, the derived one follows as closely (95 %)"
            ),
            format!("{:.2} % on the way down, {:.2} % over the whole stroke", 100.0 * down[1], 100.0 * whole[1]),
            down[1] > 0.95 && whole[1] > 0.95,
        ));
    } else {
        section.claims.push(Claim::new(
            "[T12] fig. 3, right",
            format!(
                "{nuance}, motion-driven: one degree of freedom misses the force's structure (less than 80 % of its variance, derived and \
                 fitted), the whole mechanism has it (more than 90 %)"
            ),
            format!("of the force's variance is explained: {}; on the way down alone: {}", told(whole), told(down)),
            [whole, down].iter().all(|e| e[0] > 0.9 && e[1] < 0.8 && e[2] < 0.8),
        ));
    }
}

/// The range of a series, extended by its width on either side.
fn range(y: &[f64]) -> (f64, f64) {
    let (low, high) = y.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), y| (a.min(*y), b.max(*y)));
    (low - (high - low), high + (high - low))
}
