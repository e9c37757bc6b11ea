//! Many strokes in lanes and on several cores give the same results as each of them alone.

use std::f64::consts::PI;
use std::sync::LazyLock;

use crate::common::{grand, tremolo};
use erard::instrument::Instrument;
use erard::one_dof;
use erard::parameter::{Parameter, ParameterChange};
use erard::player;
use erard::run::Run;
use erard::run::{Setup, SimulationError, simulate};
use erard_workshop::compare::Which;
use erard_workshop::study::{
    Axis, Grid, Job, JobResult, Lanes, Played, Sampling, Source, Stroke, Workers, play_all, sample_all,
};
use moreau::{Elastoplastic, Settings};

/// Variants of the grand as in a study, another action, and models of other sizes.
fn instruments() -> Vec<Instrument> {
    let mut all: Vec<Instrument> = [-0.4e-3, 0.0, 0.3e-3, 0.6e-3, 0.9e-3]
        .into_iter()
        .map(|by| {
            let mut variant = grand();
            let screw = variant.screw("let_off").expect("the grand has it");
            assert!(variant.turn(screw, by));
            variant
        })
        .collect();
    all.push(Instrument::builtin("steinway-o").expect("built in"));
    all.push(one_dof::reduce(&grand()).expect("has a key").instrument);
    let mut larger = grand();
    while larger.zones.len() <= 14 {
        larger.edit(|fields| fields.zones.push(fields.zones[0].clone())).unwrap();
    }
    all.push(larger);
    all
}

/// A stroke made anew each time, because a study consumes it: forces, a finger's motion from rest and from half-way, an
/// imposed motion.
fn stroke(kind: usize, strength: f64) -> Stroke<'static> {
    match kind {
        0 => Box::new(player::force(move |t| if t < 0.15 { strength } else { 0.0 })),
        1 => Box::new(player::motion(move |t| tremolo(0.0, 0.009, strength, t))),
        2 => Box::new(player::motion(move |t| tremolo(0.004, 0.009, strength, t))),
        _ => Box::new(player::rigid(move |t| {
            let w = PI * strength;
            [0.004 * (1.0 - (w * t).cos()), 0.004 * w * (w * t).sin()]
        })),
    }
}

/// Instrument, kind of stroke, and strength of each job: ordered so that neighbours differ.
fn plan() -> Vec<(usize, usize, f64)> {
    let mut plan = Vec::new();
    for (k, strength) in [3.0, 5.0, 8.0].into_iter().enumerate() {
        plan.extend((0..8).map(|instrument| (instrument, 0, strength + 0.1 * instrument as f64)));
        plan.extend([(k, 1, 4.0 + k as f64), (5, 2, 6.0 + k as f64), (k + 1, 3, 3.0 + k as f64)]);
    }
    plan
}

fn jobs(plan: &[(usize, usize, f64)]) -> Vec<Job<'static>> {
    plan.iter().map(|&(instrument, kind, strength)| Job { instrument, stroke: stroke(kind, strength) }).collect()
}

/// Newton's iteration runs to its end: a run reports the forces of its last iteration, lanes compute theirs from the
/// states.
const SETUP: fn() -> Setup = || Setup {
    settings: Settings { tolerance: 1e-10, ..Settings::new(50e-6) },
    record_every: Some(u64::MAX),
    ..Setup::new(0.25)
};

fn study(plan: &[(usize, usize, f64)], workers: Workers) -> Vec<JobResult> {
    play_all(&instruments(), jobs(plan), &SETUP(), workers, &mut |_| true).expect("nobody interrupts")
}

/// These threads, with the available lanes.
fn threads(threads: usize) -> Workers {
    Workers { threads, ..Workers::all() }
}

fn played(results: Vec<JobResult>) -> Vec<Played> {
    results.into_iter().map(|result| result.expect("plays")).collect()
}

/// The events of a study are those of `simulate`. Lanes and scalars sum in the same order, so that only rounding
/// differs; impacts and releases amplify it, and times inherit it through the speeds there.
#[test]
fn a_study_gives_what_simulate_gives() {
    let plan = plan();
    for lanes in Lanes::here().filter(|lanes| !lanes.is_single()) {
        let apart = compare(lanes, &plan, &RUNS);
        assert!(apart.seconds < 1e-9 && apart.speed < 1e-7 && apart.rise_m < 1e-9, "{apart:?}");
    }
}

/// In single precision, too, except for its own rounding: angles are known to 3e-8 rad, which is 4 nm at the string.
#[test]
fn in_single_precision_the_same_to_its_rounding() {
    let plan = plan();
    for lanes in Lanes::here().filter(|lanes| lanes.is_single()) {
        let apart = compare(lanes, &plan, &RUNS);
        assert!(apart.seconds < 1e-4 && apart.speed < 1e-3 && apart.rise_m < 1e-5, "{apart:?}");
    }
}

/// Felts with an internal state, and friction that grows at rest, are the same in lanes; the lanes' energy balance
/// closes like the engine's.
#[test]
fn what_is_remembered_is_remembered_in_lanes() {
    // The elastoplastic one. The set-valued loss does not converge in every step of a whole action (`felt_laws.rs` has
    // the number); Stulov's felt and friction that grows at rest are not tested in lanes yet.
    let laws: [fn(&mut erard::instrument::InstrumentFields); 1] = [|i| {
        for felt in i.zones.iter_mut().map(|zone| &mut zone.felt) {
            felt.loss = Elastoplastic { damping: felt.loss.viscous(1.0, 0.0), eta: 0.3, slip: 0.2 }.into();
        }
    }];
    for (k, law) in laws.into_iter().enumerate() {
        let instruments: Vec<Instrument> = (0..4)
            .map(|n| {
                let mut instrument = grand();
                instrument.edit(|fields| fields.zones[0].felt.stiffness *= 1.0 + 0.1 * f64::from(n)).unwrap();
                instrument.edit(law).unwrap();
                instrument
            })
            .collect();
        let jobs = (0..4).map(|instrument| Job { instrument, stroke: stroke(0, 6.0) }).collect();
        let workers = Workers { threads: 1, ..Workers::all() };
        let together = played(play_all(&instruments, jobs, &SETUP(), workers, &mut |_| true).expect("plays"));
        for (instrument, played) in instruments.iter().zip(&together) {
            let run = alone(instrument, 0, 6.0);
            assert_eq!((played.unconverged_steps, run.work.unconverged_steps), (0, 0), "{k}");
            let (a, b) = (&played.events.impacts, &run.events.impacts);
            assert_eq!(a.len(), b.len(), "{k}");
            assert!(
                !b.is_empty() && (a[0].hammer_speed_m_per_s / b[0].hammer_speed_m_per_s - 1.0).abs() < 1e-7,
                "{k}: {a:?} {b:?}"
            );
            let own = run.ledger.as_ref().expect("kept").residual_relative();
            println!("{k}: residual {:?} beside the lanes, {own:.1e} by the engine", played.energy_residual);
            assert!(
                played.energy_residual.is_some_and(|residual| residual < 1e-3),
                "{k}: {:?}",
                played.energy_residual
            );
        }
    }
}

/// The plan by `simulate`, one job after the other.
static RUNS: LazyLock<Vec<Run>> = LazyLock::new(|| {
    let instruments = instruments();
    plan().iter().map(|&(instrument, kind, strength)| alone(&instruments[instrument], kind, strength)).collect()
});

/// One job by `simulate`.
fn alone(instrument: &Instrument, kind: usize, strength: f64) -> Run {
    let own = stroke(kind, strength);
    let setup = Setup { record_every: Some(1), ..SETUP() };
    simulate(instrument, own.as_ref(), &setup, &mut |_| true).expect("plays")
}

/// Largest differences between a study's strokes and single runs: of times, of hammer speeds (relative), of rises.
#[derive(Debug)]
struct Apart {
    seconds: f64,
    speed: f64,
    rise_m: f64,
}

fn compare(lanes: Lanes, plan: &[(usize, usize, f64)], runs: &[Run]) -> Apart {
    let together = played(study(plan, Workers { threads: 2, lanes }));
    let (mut apart, mut strikes, mut checks) = (Apart { seconds: 0.0, speed: 0.0, rise_m: 0.0 }, 0, 0);
    for ((&(instrument, kind, strength), played), run) in plan.iter().zip(&together).zip(runs) {
        assert_eq!(played.unconverged_steps, run.work.unconverged_steps);
        let highest = run.hammer_rise_m.iter().fold(0.0_f64, |a, b| a.max(*b));
        apart.rise_m = apart.rise_m.max((played.highest_m - highest).abs());
        let (a, b) = (&played.events, &run.events);
        assert_eq!(a.impacts.len(), b.impacts.len(), "{instrument} {kind} {strength}");
        let instants = |e: &erard::run::Events| {
            [e.key_start_s, e.toe_contact_s, e.let_off_s, e.hammer_contact_s(), e.key_bottom_s, e.check_s]
        };
        for (x, y) in instants(a).into_iter().zip(instants(b)) {
            assert_eq!(x.is_some(), y.is_some(), "{instrument} {kind} {strength}: {a:?} {b:?}");
            apart.seconds = apart.seconds.max((x.unwrap_or(0.0) - y.unwrap_or(0.0)).abs());
        }
        for (x, y) in a.impacts.iter().zip(&b.impacts) {
            apart.seconds = apart.seconds.max((x.time_s - y.time_s).abs());
            apart.speed = apart.speed.max((x.hammer_speed_m_per_s / y.hammer_speed_m_per_s - 1.0).abs());
        }
        strikes += b.impacts.len();
        checks += usize::from(b.check_s.is_some());
    }
    println!("{lanes:?}: {strikes} strikes, {checks} checks; {apart:?}");
    assert!(strikes >= 15 && checks >= 5, "the study strikes and checks: {strikes}, {checks}");
    apart
}

/// The number of threads does not change the results.
#[test]
fn the_same_bits_with_several_threads() {
    same_bits_with_threads([Lanes::most()], &[3]);
}

#[test]
#[ignore = "ci: one study on one, two and three threads"]
fn the_same_bits_with_any_number_of_threads() {
    same_bits_with_threads(Lanes::here(), &[2, 3]);
}

fn same_bits_with_threads(widths: impl IntoIterator<Item = Lanes>, numbers: &[usize]) {
    let plan = plan();
    assert!(plan.len() % 2 == 1, "the last groups are not full");
    for lanes in widths {
        let alone = played(study(&plan, Workers { threads: 1, lanes }));
        for &threads in numbers {
            assert_eq!(played(study(&plan, Workers { threads, lanes })), alone, "{threads} threads, {lanes:?}");
        }
    }
}

/// A job is the same to rounding with any neighbours: here in the opposite order.
#[test]
fn the_order_does_not_matter() {
    let plan = plan();
    let mut backwards = plan.clone();
    backwards.reverse();
    let (a, b) = (played(study(&plan, threads(2))), played(study(&backwards, threads(2))));
    for (a, b) in a.iter().zip(b.iter().rev()) {
        assert_eq!(a.events.impacts.len(), b.events.impacts.len());
        for (x, y) in a.events.impacts.iter().zip(&b.events.impacts) {
            assert!(
                (x.time_s - y.time_s).abs() < 1e-9
                    && (x.hammer_speed_m_per_s / y.hammer_speed_m_per_s - 1.0).abs() < 1e-7
            );
        }
    }
}

/// A force that is NaN, when the action stands as well, in every kind of lanes; a spring without bounds: the job
/// reports it, and its neighbours get the same bits as beside a job that does not fail.
#[test]
fn a_job_that_fails_fails_alone() {
    for lanes in [Lanes::One, Lanes::Four, Lanes::EightSingle] {
        fails_alone(Workers { threads: 2, lanes });
    }
}

fn fails_alone(workers: Workers) {
    let mut instruments = vec![grand(); 3];
    let mut explosive = grand();
    explosive.edit(|fields| fields.zones.iter_mut().for_each(|zone| zone.felt.stiffness = 1e300)).unwrap();
    instruments.push(explosive);
    let job = |instrument, force: fn(f64) -> f64| Job { instrument, stroke: Box::new(player::force(force)) };
    let go = |jobs| play_all(&instruments, jobs, &SETUP(), workers, &mut |_| true).expect("nobody interrupts");
    let good = go(vec![job(0, |_| 4.0), job(1, |_| 5.0), job(2, |_| 6.0)]);
    let some =
        go(vec![job(0, |_| 4.0), job(1, |t| if t > 0.1 { f64::NAN } else { 5.0 }), job(2, |_| 6.0), job(3, |_| 5.0)]);
    match &some[1] {
        Err(SimulationError::NonFinite { time_s }) => assert!((*time_s - 0.1).abs() < 1e-4, "{time_s}"),
        other => panic!("{other:?}"),
    }
    assert!(matches!(some[3], Err(SimulationError::Equilibrium(_))), "{:?}", some[3]);
    for i in [0, 2] {
        assert_eq!(good[i].as_ref().ok(), some[i].as_ref().ok(), "job {i}");
        assert!(good[i].is_ok());
    }
}

#[test]
fn nothing_to_do_a_wrong_setup_and_an_interruption() {
    let instruments = instruments();
    assert!(play_all(&instruments, Vec::new(), &SETUP(), threads(2), &mut |_| true).expect("nothing fails").is_empty());
    let wrong = Setup { duration_s: -1.0, ..SETUP() };
    assert!(matches!(
        play_all(&instruments, jobs(&plan()), &wrong, threads(2), &mut |_| true),
        Err(SimulationError::Duration { .. })
    ));
    assert!(matches!(
        play_all(&instruments, jobs(&plan()), &SETUP(), threads(2), &mut |_| false),
        Err(SimulationError::Interrupted)
    ));
}

/// Samples in lanes, or from runs where lanes cannot sample, are the run's own rows, to rounding of their size, and
/// times are the same as without samples.
#[test]
fn samples_are_the_rows_of_the_run() {
    let every = 20;
    for (kind, columns) in [
        (0, &["force_N", "key_m", "hammer_rise_m", "hammer_rad", "key_rad_per_s"][..]),
        (1, &["key_m", "force_N", "string_N"]),
        (3, &["hammer_rise_m", "hammer_rise_m_per_s", "hammer_rad_per_s"]),
    ] {
        let instruments = [grand(), Instrument::builtin("steinway-o").expect("built in")];
        let plan = [(0, kind, 5.0), (1, kind, 6.0), (0, kind, 4.0)];
        let sampling = Sampling::of(&instruments[0], columns, every).expect("they are there");
        let sampled = sample_all(&instruments, jobs(&plan), &SETUP(), Some(&sampling), threads(2), &mut |_| true)
            .expect("no interrupt");
        let plain = play_all(&instruments, jobs(&plan), &SETUP(), threads(1), &mut |_| true).expect("no interrupt");
        for (job, (played, plain)) in plan.iter().zip(sampled.into_iter().zip(plain)) {
            let (played, plain) = (played.expect("it plays"), plain.expect("it plays"));
            assert_eq!(played.events.impacts.len(), plain.events.impacts.len());
            let setup = Setup { record_every: Some(1), ..SETUP() };
            let run =
                simulate(&instruments[job.0], stroke(job.1, job.2).as_ref(), &setup, &mut |_| true).expect("plays");
            let all = run.columns();
            assert_eq!(played.samples.len(), columns.len());
            for (name, values) in columns.iter().zip(&played.samples) {
                let (_, own) = all.iter().find(|(known, _)| known == name).expect("a column of the run");
                let own: Vec<f64> = own.iter().step_by(every as usize).copied().collect();
                assert_eq!(values.len(), own.len(), "{name}");
                let size = own.iter().fold(1e-12, |a: f64, b| a.max(b.abs()));
                // A run's force is the mean of two steps: at its ends there is one, and where the force jumps (0.15 s)
                // it is half-way.
                let jumps = |row: &usize| *name == "force_N" && [0, 150, own.len() - 1].contains(row);
                let rows = (0..own.len()).filter(|row| !jumps(row));
                let worst = rows.map(|row| (values[row] - own[row]).abs()).fold(0.0, f64::max);
                assert!(worst <= 1e-6 * size, "{name} of {job:?}: {worst:e} of {size:e}");
            }
        }
    }
    let unknown = Sampling::of(&grand(), &["hammer_mm"], 1).unwrap_err().to_string();
    assert!(unknown.contains("`hammer_mm`") && unknown.contains("hammer_rise_m"), "{unknown}");
}

/// Combinations come in the order of the axes, the last fastest; some of them are those of all, to the bit; a variant
/// that fails says why; what was changed before stays changed.
#[test]
fn a_grid_plays_every_combination() {
    let instrument = grand();
    let text = Instrument::builtin_text("concert-grand").expect("built in");
    let mass = instrument.bodies.iter().find(|body| body.name == "hammer").expect("a hammer").mass_kg;
    let lighter = vec![("body.key.mass".to_owned(), ParameterChange::Text("x0.9".to_owned()))];
    let source = Source::Text { text: text.to_owned(), changes: lighter };
    let axes = [
        Axis::of_values("body.hammer.mass_g", vec![1e3 * mass, -1.0], &instrument, &source).expect("a number"),
        Axis::of_values("let_off", vec![1e-4, 2e-4], &instrument, &source).expect("a screw"),
        Axis::of_forces(vec![4.0, 6.0]),
    ];
    let (stroke, setup) = (erard::stroke::Stroke::constant(String::new(), 0.0), Setup::new(0.05));
    let grid = Grid {
        instrument: &instrument,
        source: &source,
        model: Which::Action,
        axes: &axes,
        lines: &[],
        rest: erard::player::RestKind::AsPlayed,
        stroke: &stroke,
        each: None,
        setup: &setup,
        workers: threads(2),
    };
    let rows = grid.play(&mut |_| true).expect("played");
    assert_eq!((rows.len(), &rows[5].values[..]), (8, &[-1.0, 1e-4, 6.0][..]));
    assert_eq!(grid.play_rows(1..6, &mut |_| true).expect("played"), rows[1..6]);
    for (row, failed) in rows.iter().zip([false, false, false, false, true, true, true, true]) {
        assert_eq!(row.error().is_some_and(|error| error.contains("mass_g")), failed, "{row:?}");
    }
    let mut own = instrument.clone();
    let key = Parameter::named(&own, "body.key.mass").expect("a mass").1;
    let screw = own.screw("let_off").expect("a screw");
    assert!(key.vary(&mut own, 0.9).is_ok() && own.turn(screw, 2e-4));
    let alone = simulate(&own, &player::force(|_| 6.0), &setup, &mut |_| true).expect("played");
    let played = rows[3].outcome.as_ref().expect("played");
    let [found, wanted] = [&played.events, &alone.events].map(|events| events.key_start_s.expect("it moves"));
    assert!((found - wanted).abs() < 1e-9, "{found} {wanted}");
    assert!(matches!(grid.play(&mut |_| false), Err(SimulationError::Interrupted)));
    assert!(Axis::of_values("let_of", vec![0.0], &instrument, &source).is_err());
}

/// A job of an instrument that does not exist is refused before anything is played.
#[test]
fn a_job_needs_its_instrument() {
    let job = Job { instrument: 2, stroke: stroke(0, 5.0) };
    let instruments = [grand(), grand()];
    let error = play_all(&instruments, vec![job], &SETUP(), threads(1), &mut |_| true).unwrap_err();
    assert_eq!(error.to_string(), "found instrument 2, expected one of 2, counted from 0");
}
