//! [T13]'s felt law, equilibrium under friction, the finger's softness and the run time.

use moreau::{
    Body, ContactCurve, Description, FrictionLaw, GROUND, Pose, Settings, SiteInput, Solver, State, Workspace, Zone,
    step,
};

use super::convergence::WIDTHS;
use super::impact::{NEIGHBOURS, Play, halvings, impact, regularised, tell};
use super::{Chart, ChartCurve, ChartPanel, Claim, Dash, Progress, ReproduceError, Section, Table, small};
use erard::instrument::Instrument;
use erard::stroke::Touch;

/// Mass thrown at the felt, kg, on an arm so long that its path is straight, m.
const THROWN_KG: f64 = 0.010;
const ARM_M: f64 = 100.0;

/// Force over compression of the felt in the string's zone, hit at three speeds.
pub(super) fn felt(instrument: &Instrument, _: &mut Progress) -> Result<Section, ReproduceError> {
    let index = instrument.roles.string.unwrap_or(0);
    let zone =
        instrument.zones.get(index).ok_or_else(|| ReproduceError::Instrument("the instrument has no zone".into()))?;
    let felt = zone.felt;
    let mut table = Table::new(
        "A mass of 10 g thrown at the felt",
        &["speed", "largest force", "largest compression", "speed after", "energy lost"],
    );
    let (mut curves, mut lost) = (Vec::new(), Vec::new());
    for (i, speed) in [0.5, 1.0, 2.0].into_iter().enumerate() {
        let hit = throw(felt, speed)?;
        let largest = |x: &[f64]| x.iter().copied().fold(0.0, f64::max);
        let loss = 1.0 - (hit.after / speed).powi(2);
        lost.push(loss);
        table.row([
            format!("{speed} m/s"),
            format!("{:.2} N", largest(&hit.force)),
            format!("{:.4} mm", 1e3 * largest(&hit.compression)),
            format!("{:.4} m/s", hit.after),
            format!("{:.2} %", 100.0 * loss),
        ]);
        curves.push(ChartCurve {
            label: format!("{speed} m/s"),
            x: hit.compression.iter().map(|g| g * 1e3).collect(),
            y: hit.force,
            colour: i + 1,
            mark: [Dash::Solid, Dash::Dashed, Dash::Dotted][i],
        });
    }
    let told = lost.iter().map(|l| format!("{:.1} %", 100.0 * l)).collect::<Vec<_>>().join(", ");
    Ok(Section {
        text: vec![format!(
            "F = k g^r + b g^2 dg/dt with {}'s k = {:e}, r = {}, b = {:e} (SI), clamped at zero: as published the law would pull before \
             separation when r > 2. Its closed forms stand in the textbook problems 5 and 6.",
            zone.label,
            felt.stiffness,
            felt.exponent,
            felt.loss.numbers()[0]
        )],
        claims: vec![Claim::new(
            "[T13]",
            "loading and unloading run along different curves, and the loop grows with the speed",
            format!("energy lost {told} at 0.5, 1 and 2 m/s"),
            lost.windows(2).all(|l| 0.0 < l[0] && l[0] < l[1]),
        )],
        charts: vec![Chart {
            title: "The felt's force over its compression".into(),
            caption: format!(
                "{}, hit by 10 g at three speeds; up along the upper branch, back along the lower",
                zone.label
            ),
            x_label: "compression (mm)".into(),
            x_log: false,
            panels: vec![ChartPanel { y_label: "force (N)".into(), y_log: false, y_range: None, curves }],
        }],
        tables: vec![table],
        ..Section::default()
    })
}

struct Hit {
    compression: Vec<f64>,
    force: Vec<f64>,
    after: f64,
}

fn throw(felt: erard::instrument::Felt, speed: f64) -> Result<Hit, ReproduceError> {
    let body =
        Body { mass: THROWN_KG, center_of_mass: [0.0, -ARM_M], inertia: THROWN_KG * ARM_M * ARM_M, ..Body::inert() };
    let zone = Zone {
        disc_body: 0,
        center: [0.0, -ARM_M],
        radius: 0.0,
        curve_body: GROUND,
        curve: ContactCurve::Line { point: [0.0, 0.0], normal: [-1.0, 0.0] },
        felt: erard::assembly::felt(&felt),
        friction: None,
    };
    let description = Description { bodies: &[body], zones: &[zone], ..Description::default() };
    let model = description.compile::<1, 1>().map_err(erard::run::SimulationError::from)?;
    let settings = Settings { tolerance: 1e-12, ..Settings::new(2e-6) };
    let mut state = State::at_rest([0.0]);
    state.velocity = [speed / ARM_M];
    let mut workspace = Workspace::<f64, 1, 1, 2>::new();
    let (mut compression, mut force) = (vec![0.0], vec![0.0]);
    for _ in 0..50_000 {
        let before = Pose::of(&model, &state.angle).compression(&model, 0);
        step(&model, &settings, &SiteInput::Free, &mut state, &mut workspace);
        let after = Pose::of(&model, &state.angle).compression(&model, 0);
        // The step's force belongs to its middle.
        compression.push(0.5 * (before + after));
        force.push(workspace.contact(&model, &settings, 0).map_or(0.0, |c| c.force));
        if after <= 0.0 && state.velocity[0] < 0.0 {
            break;
        }
    }
    Ok(Hit { compression, force, after: -state.velocity[0] * ARM_M })
}

/// Equilibrium and held note under dry and under regularised friction.
pub(super) fn rest(instrument: &Instrument, progress: &mut Progress) -> Result<Section, ReproduceError> {
    let mut laws = vec![("set-valued".to_owned(), FrictionLaw::SetValued)];
    laws.extend(WIDTHS.map(|w| (format!("tanh, {w} rad/s"), regularised(w))));
    let mut table = Table::new(
        "Rest for a minute, and the note held with 12 N from 1 s to 10 s, at 50 us",
        &[
            "friction",
            "drift at rest (rad)",
            "largest friction torque left (N m)",
            "hammer's drift in the check (rad)",
            "unconverged steps",
            "Newton iterations per step",
            "largest step with 1 %",
        ],
    );
    let hammer = instrument.roles.hammer.unwrap_or(0);
    let (mut curves, mut at_rest, mut held) = (Vec::new(), Vec::new(), Vec::new());
    let mut torques = Vec::new();
    let mut by_pivot = Table::new("Friction torque of each pivot after a minute of rest (N m)", &["friction"]);
    by_pivot.header.extend(instrument.bodies.iter().map(|b| b.name.clone()));
    let exact = impact(instrument, Play::Stroke("mf", Touch::Pressed), Settings::new(3.125e-6 / 4.0), 0.06)?;
    for (i, (name, friction)) in laws.iter().enumerate() {
        let from = i as f64 / laws.len() as f64;
        let mut told = |share: f64| progress(from + share / laws.len() as f64);
        let settings = Settings { friction: *friction, ..Settings::new(50e-6) };
        let rest = Play::Free.run_told(instrument, settings, 60.0, 1000, &mut |s| told(0.7 * s))?;
        let note = Play::Force(12.0).run_told(instrument, settings, 10.0, 200, &mut |s| told(0.7 + 0.2 * s))?;
        let drift = rest.bodies.iter().map(|b| departure(&b.angle_rad, 0)).fold(0.0, f64::max);
        let first = note.time_s.partition_point(|&t| t < 1.0);
        let caught = departure(&note.bodies[hammer].angle_rad, first);
        let torque = rest.final_pivot_friction_n_m.iter().fold(0.0_f64, |m, f| m.max(f.abs()));
        torques.push(torque);
        let cells = rest.final_pivot_friction_n_m.iter().take(instrument.bodies.len()).map(|f| format!("{f:+.1e}"));
        by_pivot.row(std::iter::once(name.clone()).chain(cells));
        let largest = largest_step(instrument, *friction, exact.speed)?;
        table.row([
            name.clone(),
            small(drift),
            small(torque),
            small(caught),
            format!("{} of {}", note.work.unconverged_steps, note.work.steps),
            format!("{:.2}", note.work.newton_iterations as f64 / note.work.steps as f64),
            largest.map_or("none tried".into(), |h| format!("{:.2} us", h * 1e6)),
        ]);
        at_rest.push(drift);
        held.push(caught);
        let start = note.hammer_rise_m[first];
        curves.push(ChartCurve {
            label: name.clone(),
            x: note.time_s[first..].to_vec(),
            y: note.hammer_rise_m[first..].iter().map(|y| (y - start) * 1e3).collect(),
            colour: [1, 2, 3, 5][i % 4],
            mark: [Dash::Solid, Dash::Dashed, Dash::Dotted, Dash::Dashed][i % 4],
        });
    }
    let list = |x: &[f64]| x.iter().map(|d| format!("{d:.1e}")).collect::<Vec<_>>().join(", ");
    Ok(Section {
        text: vec![
            "Nothing at all drives the action for a minute; then a note is held with 12 N. The regularised law is tanh(u / width) in place of \
             the set-valued sign; widths are at the pivots, and a tenth in m/s at sliding contacts. \"Largest step with 1 %\" is the largest of \
             400, 200, ... 3.125 us from which on every smaller one converges in all steps and has the hammer speed of a pressed mf within 1 %, at eight \
             phases each."
                .into(),
        ],
        claims: vec![
            Claim::new(
                "[T12]",
                "dry friction leaves friction forces at rest and holds without any drift",
                format!(
                    "drift {} rad in 60 s, {} rad in the check; largest torque held {} N m",
                    small(at_rest[0]),
                    small(held[0]),
                    small(torques[0])
                ),
                at_rest[0] == 0.0 && held[0] == 0.0 && torques[0] > 1e-4,
            ),
            Claim::new(
                "[T12]",
                "regularised friction creeps at any width, and in the end no friction force is left",
                format!(
                    "drift in 60 s {} rad; in the check {} rad; largest torque left {} N m",
                    list(&at_rest[1..]),
                    list(&held[1..]),
                    list(&torques[1..])
                ),
                at_rest[1..].iter().chain(&held[1..]).all(|d| *d > 1e-6)
                    && torques[1..].iter().all(|t| *t < 1e-6 * torques[0]),
            ),
        ],
        charts: vec![Chart {
            title: "The held note: what the caught hammer does from 1 s on".into(),
            caption: "Strike point against where it was at 1 s; 12 N on the key, 50 us".into(),
            x_label: "time (s)".into(),
            x_log: false,
            panels: vec![ChartPanel { y_label: "strike point (mm)".into(), y_log: false, y_range: None, curves }],
        }],
        tables: vec![table, by_pivot],
        ..Section::default()
    })
}

/// Largest departure of a series from its value at a row.
fn departure(series: &[f64], from: usize) -> f64 {
    series[from..].iter().fold(0.0, |m: f64, q| m.max((q - series[from]).abs()))
}

/// Finds the largest step below which a pressed mf is right.
fn largest_step(
    instrument: &Instrument,
    friction: FrictionLaw<f64>,
    speed: f64,
) -> Result<Option<f64>, ReproduceError> {
    let mut largest = None;
    for h in halvings(400e-6, 8).into_iter().rev() {
        // At every phase: at a single one a coarse step may be right by chance.
        for k in 0..NEIGHBOURS {
            let settings = Settings { friction, ..Settings::new(h * (1.0 - f64::from(k) / 64.0)) };
            let b = impact(instrument, Play::Stroke("mf", Touch::Pressed), settings, 0.06)?;
            if (b.speed / speed - 1.0).abs().is_nan() || (b.speed / speed - 1.0).abs() > 0.01 || b.unconverged > 0 {
                return Ok(largest);
            }
        }
        largest = Some(h);
    }
    Ok(largest)
}

/// Effect of the finger's softness: the same motion through fingers of several stiffnesses.
pub(super) fn finger(instrument: &Instrument, progress: &mut Progress) -> Result<Section, ReproduceError> {
    let own = instrument.finger;
    let mut table = Table::new(
        "mf and f, by the finger's motion",
        &["stroke", "finger, N/m", "hammer speed (m/s)", "contact (ms)", "peak force (N)"],
    );
    let factors = [0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0];
    let (mut speed_curves, mut force_curves) = (Vec::new(), Vec::new());
    let mut spans = Vec::new();
    for (i, nuance) in ["mf", "f"].into_iter().enumerate() {
        let (mut speeds, mut forces) = (Vec::new(), Vec::new());
        for (k, factor) in factors.into_iter().enumerate() {
            tell(progress, (i * factors.len() + k) as f64 / (2 * factors.len()) as f64)?;
            let mut soft = instrument.clone();
            soft.edit(|fields| fields.finger.stiffness_n_per_m = own.stiffness_n_per_m * factor)
                .expect("numbers alone");
            // The same share of critical damping against the same key.
            soft.edit(|fields| fields.finger.damping_n_s_per_m = own.damping_n_s_per_m * factor.sqrt())
                .expect("numbers alone");
            let play = Play::Motion(nuance, Touch::Pressed);
            let run = play.run(&soft, Settings::new(50e-6), 0.4, u64::MAX)?;
            let told = |x: Option<f64>, digits: usize| x.map_or("-".into(), |x| format!("{x:.digits$}"));
            table.row([
                play.label(),
                format!("{:.0}", soft.finger.stiffness_n_per_m),
                told(run.events.hammer_speed_m_per_s(), 4),
                told(run.events.hammer_contact_s().map(|t| t * 1e3), 2),
                format!("{:.2}", run.peak_force_n),
            ]);
            speeds.push(run.events.hammer_speed_m_per_s().unwrap_or(f64::NAN));
            forces.push(run.peak_force_n);
        }
        let stiffness: Vec<f64> = factors.iter().map(|f| f * own.stiffness_n_per_m).collect();
        let curve = |y: Vec<f64>| ChartCurve {
            label: nuance.into(),
            x: stiffness.clone(),
            y,
            colour: i + 1,
            mark: Dash::Points,
        };
        spans.push(format!("{nuance} {:.2} to {:.2} m/s", speeds[0], speeds[factors.len() - 1]));
        speed_curves.push(curve(speeds));
        force_curves.push(curve(forces));
    }
    let extremes = |y: &[f64]| y.iter().fold((f64::INFINITY, 0.0_f64), |(a, b), x| (a.min(*x), b.max(*x)));
    let spread: Vec<f64> =
        force_curves.iter().map(|c| extremes(&c.y)).map(|(least, most)| most / least - 1.0).collect();
    Ok(Section {
        text: vec![format!(
            "Between the moving finger's bone and the key sits the fingertip, a spring ({} N/m as shipped) and a damper that only push.",
            own.stiffness_n_per_m
        )],
        claims: vec![Claim::new(
            "[T13]",
            "the finger's softness is part of the experiment: the same motion through another finger gives other forces (by more than 10 %)",
            format!(
                "peak force varies by {}; hammer speed from the softest to the stiffest: {}",
                spread.iter().map(|s| format!("{:.0} %", 100.0 * s)).collect::<Vec<_>>().join(" and "),
                spans.join(", ")
            ),
            spread.iter().all(|s| *s > 0.1),
        )],
        charts: vec![Chart {
            title: "Hammer speed and peak force over the finger's stiffness".into(),
            caption: "The same motion of the finger each time".into(),
            x_label: "stiffness (N/m)".into(),
            x_log: true,
            panels: vec![
                ChartPanel { y_label: "hammer (m/s)".into(), y_log: false, y_range: None, curves: speed_curves },
                ChartPanel { y_label: "peak force (N)".into(), y_log: false, y_range: None, curves: force_curves },
            ],
        }],
        tables: vec![table],
        ..Section::default()
    })
}

/// Elapsed over simulated time.
pub(super) fn run_time(instrument: &Instrument, progress: &mut Progress) -> Result<Section, ReproduceError> {
    let mut table = Table::new(
        "One second of a pressed mf, on the clock of this machine, this time: the best of five, with recording and ledger",
        &["friction", "solver", "step, us", "seconds per second", "times faster than real time"],
    );
    table.clock = true;
    let set = FrictionLaw::SetValued;
    let ways = [
        ("set-valued", "active set", set, Solver::ActiveSet, 50e-6),
        ("set-valued", "projected Gauss-Seidel", set, Solver::ProjectedGaussSeidel, 50e-6),
        ("tanh, 0.1 rad/s", "-", regularised(0.1), Solver::ActiveSet, 50e-6),
        ("tanh, 0.001 rad/s", "-", regularised(0.001), Solver::ActiveSet, 50e-6),
        ("set-valued", "active set", set, Solver::ActiveSet, 10e-6),
    ];
    let mut faster = true;
    for (i, (law, name, friction, solver, h)) in ways.into_iter().enumerate() {
        let mut best = f64::INFINITY;
        for _ in 0..5 {
            tell(progress, i as f64 / ways.len() as f64)?;
            let settings = Settings { friction, solver, ..Settings::new(h) };
            best = best.min(impact(instrument, Play::Stroke("mf", Touch::Pressed), settings, 1.0)?.of_real_time);
        }
        if i == 0 {
            faster = best < 1.0;
        }
        table.row([
            law.into(),
            name.into(),
            format!("{:.0}", h * 1e6),
            format!("{best:.4}"),
            format!("{:.1}", 1.0 / best),
        ]);
    }
    Ok(Section {
        text: vec!["Compare `cargo bench -p erard-bench --bench press`, the engine alone.".into()],
        claims: vec![Claim::new(
            "[T13]",
            "[T13] needed 20 times real time; here a note takes less than real time",
            if faster {
                "less than real time at 50 us; how much less stands in the table"
            } else {
                "more than real time"
            },
            faster,
        )],
        tables: vec![table],
        ..Section::default()
    })
}
