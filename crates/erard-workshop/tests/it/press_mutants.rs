//! Property tests beyond the parser: instruments, strokes, keyboards and options are changed at random, and accepted
//! ones are PRESSED. Nothing panics, every number is finite, energy is bounded or the run says that it cannot be
//! trusted.
//!
//! Every mutant is made from one seed, which a failure prints: `ERARD_MUTANT=17 cargo test --release -p erard-workshop
//! --test it press_mutants` presses that one again and describes it. Some are pressed in every run of the tests, 500
//! accepted ones by the ignored test, and `ERARD_MUTANTS=20000 cargo test --release -p erard-workshop --test it
//! press_mutants -- --ignored` presses that many.

use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};

use crate::common::energy_audit::EnergyAudit;
use crate::common::mutants::numbers;
use erard::instrument::{Instrument, InstrumentFile};
use erard::keyboard::Keyboard;
use erard::one_dof;
use erard::player::equilibrium::EquilibriumError;
use erard::player::{self, Input};
use erard::run::Run;
use erard::run::{Setup, SimulationError, simulate, simulate_observed};
use erard::stroke::Series;
use erard_workshop::study::{Job, Workers, play_all};
use fastrand::Rng;
use moreau::{FrictionLaw, Settings, Solver};

const CLOCK: &str = include_str!("../../../erard-core/tests/instruments/escapement.toml");
/// Most steps of a run: far beyond the parser's last check; absurd mutants fail soon.
const STEPS: u64 = 1200;
/// Progress is asked every 512 steps: a search for the rest is interrupted after this many calls, as by Control-C.
const PATIENCE: u32 = 60;
/// The same limit for adaptive steps, which may be arbitrarily short.
const LONG_PATIENCE: u32 = 400;

/// Outcome of a mutant.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Fate {
    /// The file, the stroke or the options were refused.
    Refused,
    /// Accepted, but no equilibrium was found, or not in time.
    Restless,
    /// Accepted; adaptive steps needed more time than allowed.
    Long,
    /// Accepted; a number became infinite, which is reported.
    Infinite,
    /// Pressed, but cannot be trusted.
    Doubtful,
    /// Pressed, without warnings.
    Trusted,
}

/// Changes one to five numbers of a text: by a factor, by sign, to zero, to another number of the same text, or to an
/// absurd value.
fn mutated(text: &str, rng: &mut Rng) -> String {
    let mut text = text.to_owned();
    for _ in 0..rng.usize(1..=5) {
        let places = numbers(&text);
        if places.is_empty() {
            break;
        }
        let place = places[rng.usize(..places.len())].clone();
        let old: f64 = text[place.clone()].parse().unwrap_or_default();
        let new = match rng.u8(..10) {
            0..=4 => old * 10f64.powf(6.0 * rng.f64() - 3.0),
            5 => old * (0.8 + 0.4 * rng.f64()),
            6 => -old,
            7 => [0.0, 1.0, 1e-9, 1e9, 90.0, 1e4][rng.usize(..6)],
            _ => text[places[rng.usize(..places.len())].clone()].parse().unwrap_or_default(),
        };
        text.replace_range(place, &format!("{new:?}"));
    }
    // Thickness of felts and range of bodies are optional in a file.
    if rng.u8(..4) == 0 {
        text = text
            .lines()
            .filter(|l| !l.starts_with("thickness_mm") && !l.starts_with("turn_deg"))
            .collect::<Vec<_>>()
            .join("\n");
    }
    text
}

/// A random instrument, from a built-in one, a clock, or a key of a random keyboard; `None` if the reader refuses it.
fn instrument(rng: &mut Rng) -> Option<Instrument> {
    match rng.u8(..8) {
        0 => InstrumentFile::parse(&mutated(CLOCK, rng), "mutant.toml").ok().map(|file| file.instrument),
        1 => {
            let text = erard_keyboard(rng);
            let keyboard = Keyboard::parse(&text, "mutant.toml", Path::new("")).ok()?;
            keyboard.key(rng.usize(1..=88)).ok()
        }
        _ => {
            let names: Vec<&str> = Instrument::builtin_names().collect();
            let text = Instrument::builtin_text(names[rng.usize(..names.len())])?;
            let instrument = InstrumentFile::parse(&mutated(text, rng), "mutant.toml").ok()?.instrument;
            if rng.u8(..10) == 0 {
                one_dof::reduce(&instrument).ok().map(|reduced| reduced.instrument)
            } else {
                Some(instrument)
            }
        }
    }
}

/// A keyboard with arbitrary gradings.
fn erard_keyboard(rng: &mut Rng) -> String {
    let mut factor = |most: f64| 10f64.powf(most * (2.0 * rng.f64() - 1.0));
    let (mass, felt, arm) = (8.0 * factor(1.5) - 8.0, factor(3.0), factor(2.0));
    format!(
        "format = \"erard-keyboard/1\"\nname = \"Mutant\"\ninstrument = \"concert-grand\"\ninstrument_key = 40\n\
         [[added_mass]]\nname = \"head\"\nbody = \"hammer\"\nat_mm = [130, 18]\n\
         mass_g = [{{ key = 1, value = {mass:?} }}, {{ key = 40, value = 0 }}, {{ key = 88, value = {:?} }}]\n\
         [[factor]]\nname = \"felt\"\nnumbers = [\"zone.string.felt.stiffness_N_per_m_r\"]\n\
         factor = [{{ key = 1, value = {felt:?} }}, {{ key = 40, value = 1 }}, {{ key = 88, value = {:?} }}]\n\
         [[factor]]\nname = \"friction\"\nnumbers = [\"body.hammer.friction_torque_N_m\", \"body.key.mass_g\"]\n\
         factor = [{{ key = 40, value = 1 }}, {{ key = 88, value = {arm:?} }}]\n",
        -mass / 4.0,
        1.0 / felt
    )
}

/// A random stroke as the text of a CSV file, which its reader may refuse.
fn stroke(rng: &mut Rng) -> Option<Series> {
    let (force, position) = [(true, false), (false, true), (true, true)][rng.usize(..3)];
    let mut text = String::from("time_s");
    text += if force { ",force_N" } else { "" };
    text += if position { ",position_m\n" } else { "\n" };
    let rows = rng.usize(2..30);
    let (mut time_s, mut depth_m) = (0.0, 0.0_f64);
    let strength = 10f64.powf(5.0 * rng.f64() - 1.0);
    for _ in 0..rows {
        text += &format!("{time_s:?}");
        if force {
            text += &format!(",{:?}", strength * (rng.f64() - 0.1));
        }
        if position {
            text += &format!(",{depth_m:?}");
        }
        text.push('\n');
        time_s += 10f64.powf(3.0 * rng.f64() - 5.0);
        depth_m += (rng.f64() - 0.3) * if rng.u8(..20) == 0 { 0.3 } else { 2e-3 };
    }
    Series::read(text.as_bytes(), "mutant.csv").ok()
}

/// Random options, mostly valid.
fn setup(rng: &mut Rng) -> Setup {
    let step = if rng.bool() { 50e-6 } else { 10f64.powf(-5.5 + 2.6 * rng.f64()) };
    let mut settings = Settings { theta: [0.5, 0.5, 0.5, 0.6, 1.0, 0.49][rng.usize(..6)], ..Settings::new(step) };
    if rng.u8(..8) == 0 {
        settings.solver = Solver::ProjectedGaussSeidel;
    }
    if rng.u8(..8) == 0 {
        settings.friction =
            FrictionLaw::Regularised { pivot_width: 1e-3 + rng.f64(), sliding_width: 1e-4 + 0.1 * rng.f64() };
    }
    let steps = rng.u64(1..=STEPS);
    let tolerance = (rng.u8(..10) == 0).then(|| 10f64.powf(-8.0 + 8.0 * rng.f64()));
    Setup {
        settings,
        // Adaptive steps may be far shorter than requested.
        duration_s: if tolerance.is_some() { (steps as f64 * step).min(0.02) } else { steps as f64 * step },
        record_every: [None, Some(1), Some(7)][rng.usize(..3)],
        tolerance,
        ..Setup::new(1.0)
    }
}

/// Energy of all bodies and springs at a row, computed independently, J: kinetic, gravity, springs. Compressed felts
/// are left out.
fn energy_j(instrument: &Instrument, run: &Run, row: usize) -> f64 {
    let angle = |i: usize| run.bodies[i].angle_rad[row];
    let rate = |i: usize| run.bodies[i].rate_rad_per_s[row];
    let turned = |i: usize, [x, y]: [f64; 2]| {
        let (sin, cos) = angle(i).sin_cos();
        [cos * x - sin * y, sin * x + cos * y]
    };
    // Position and velocity of every pivot, parents first.
    let mut pivots: Vec<[[f64; 2]; 2]> = Vec::new();
    let mut energy = 0.0;
    for (i, body) in instrument.bodies.iter().enumerate() {
        let [place, velocity] = body.parent.map_or([body.pivot_m, [0.0; 2]], |p| {
            let [x, y] = turned(p, body.pivot_m);
            let [at, v] = pivots[p];
            [[at[0] + x, at[1] + y], [v[0] - rate(p) * y, v[1] + rate(p) * x]]
        });
        pivots.push([place, velocity]);
        let [x, y] = turned(i, body.center_of_mass_m);
        let w = rate(i);
        let v = [velocity[0] - w * y, velocity[1] + w * x];
        let own = body.inertia_kg_m2 - body.mass_kg * (x * x + y * y);
        energy += 0.5 * body.mass_kg * (v[0] * v[0] + v[1] * v[1]) + 0.5 * own * w * w;
        energy += body.mass_kg * instrument.gravity_m_per_s2 * (place[1] + y);
    }
    for spring in &instrument.springs {
        let parent = instrument.bodies[spring.body].parent;
        let drawn = instrument.bodies[spring.body].angle_rad - parent.map_or(0.0, |p| instrument.bodies[p].angle_rad);
        let wound = angle(spring.body) - parent.map_or(0.0, angle) - drawn;
        energy += 0.5 * spring.stiffness_n_m_per_rad * wound * wound - spring.torque_n_m * wound;
    }
    energy
}

/// Checks the guarantees for every run.
fn assert_sane(instrument: &Instrument, run: &Run) -> Fate {
    let rows = run.time_s.len();
    let series = run
        .bodies
        .iter()
        .flat_map(|b| [&b.angle_rad, &b.rate_rad_per_s])
        .chain(run.zones.iter().flat_map(|z| [&z.normal_n, &z.tangential_n]))
        .chain([&run.time_s, &run.force_n, &run.key_m, &run.hammer_rise_m]);
    for values in series {
        assert!(values.iter().all(|x| x.is_finite()), "a series is not finite");
        assert!(values.is_empty() || values.len() == rows, "series differ in length");
    }
    let events = &run.events;
    let told = [
        events.key_start_s,
        events.hammer_contact_s(),
        events.hammer_speed_m_per_s(),
        events.key_bottom_s,
        events.check_s,
    ];
    assert!(told.into_iter().flatten().all(f64::is_finite), "{events:?}");
    for warning in &run.warnings {
        assert!(warning.value.is_finite() && warning.bound.is_finite() && !warning.what.is_empty(), "{warning:?}");
        assert!(!warning.what.contains("NaN") && !warning.what.contains('\n'), "{warning}");
    }
    if !run.is_trusted() {
        return Fate::Doubtful;
    }
    // Without warnings, no body and spring ever holds more than the initial energy, the drive's work, and the felts'
    // initial energy: the energy balance must include it.
    let ledger = run.ledger.as_ref().expect("it was kept");
    let held = ledger.start.felt.max(0.0);
    let allowed = (ledger.drive_work_in + held).max(1e-6);
    let start = energy_j(instrument, run, 0);
    let scale = (0..rows).map(|row| energy_j(instrument, run, row).abs()).fold(start.abs(), f64::max);
    for row in 0..rows {
        let gained = energy_j(instrument, run, row) - start;
        assert!(
            gained <= allowed * 1.02 + 1e-9 * scale,
            "trusted, but at {} s {gained:e} J were gained and {allowed:e} J put in",
            run.time_s[row]
        );
    }
    assert!(run.work.unconverged_steps == 0 && ledger.smallest_term >= 0.0, "{:?}, {}", run.work, ledger.smallest_term);
    Fate::Trusted
}

/// Makes the mutant of a seed and presses it.
fn press(seed: u64) -> (Fate, Option<Instrument>) {
    let mut rng = Rng::with_seed(seed);
    let (Some(instrument), Some(series), setup) = (instrument(&mut rng), stroke(&mut rng), setup(&mut rng)) else {
        return (Fate::Refused, None);
    };
    let (force, position) = (series.force.as_ref(), series.position.as_ref());
    let drive: Box<player::Drive<'_>> = match (force, position, rng.u8(..3)) {
        (Some(force), None, _) | (Some(force), Some(_), 0) => Box::new(player::force(force.drive())),
        (_, Some(position), 1) => Box::new(player::rigid(position.drive())),
        (_, Some(position), _) => Box::new(player::motion(position.drive())),
        (None, None, _) => Box::new(|_| Input::Free),
    };
    let before = instrument.clone();
    let (mut asked, mut begun) = (0, false);
    let fate = match simulate(&instrument, drive.as_ref(), &setup, &mut |share| {
        asked += 1;
        begun |= share > 0.0;
        asked < if begun { LONG_PATIENCE } else { PATIENCE }
    }) {
        Ok(run) => assert_sane(&instrument, &run),
        Err(SimulationError::NonFinite { time_s }) => {
            assert!(time_s.is_finite());
            Fate::Infinite
        }
        Err(SimulationError::Equilibrium(EquilibriumError::NonFinite)) => Fate::Infinite,
        Err(SimulationError::Interrupted) if begun => {
            assert!(setup.tolerance.is_some(), "{STEPS} steps at most take no longer");
            Fate::Long
        }
        Err(SimulationError::Equilibrium(_) | SimulationError::Interrupted) => Fate::Restless,
        Err(_) => Fate::Refused,
    };
    assert_eq!(instrument, before, "what is read is not changed");
    (fate, Some(instrument))
}

/// Presses mutants until enough were accepted; the first violation ends it and names its seed.
fn press_all(wanted: u64) -> BTreeMap<Fate, u64> {
    let (next, accepted) = (AtomicU64::new(0), AtomicU64::new(0));
    let work = || {
        let mut fates: BTreeMap<Fate, u64> = BTreeMap::new();
        while accepted.load(Ordering::Relaxed) < wanted {
            let seed = next.fetch_add(1, Ordering::Relaxed);
            let fate = catch_unwind(AssertUnwindSafe(|| press(seed).0));
            let Ok(fate) = fate else { panic!("mutant {seed} breaks a promise: ERARD_MUTANT={seed} presses it again") };
            *fates.entry(fate).or_default() += 1;
            if fate != Fate::Refused {
                accepted.fetch_add(1, Ordering::Relaxed);
            }
        }
        fates
    };
    std::thread::scope(|scope| {
        let other = scope.spawn(work);
        let mut fates = work();
        let others = other.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
        for (fate, count) in others {
            *fates.entry(fate).or_default() += count;
        }
        fates
    })
}

fn asked(name: &str) -> Option<u64> {
    std::env::var(name).ok().and_then(|text| text.parse().ok())
}

#[test]
fn whatever_is_accepted_can_be_pressed() {
    match asked("ERARD_MUTANT") {
        Some(seed) => println!("{:#?}", press(seed)),
        None => can_be_pressed(30),
    }
}

#[test]
#[ignore = "ci: 120 mutants"]
fn whatever_of_many_is_accepted_can_be_pressed() {
    can_be_pressed(120);
}

mod nightly {
    use super::*;

    #[test]
    #[ignore = "nightly: 500 mutants, or as many as ERARD_MUTANTS says"]
    fn whatever_of_most_is_accepted_can_be_pressed() {
        can_be_pressed(asked("ERARD_MUTANTS").unwrap_or(500));
    }

    #[test]
    #[ignore = "nightly: 200 mutants, each alone and in lanes"]
    fn a_study_distrusts_what_many_presses_do() {
        distrusts_alike(0..200);
    }
}

fn can_be_pressed(wanted: u64) {
    let fates = press_all(wanted);
    println!("{fates:?}");
    let of = |fate| fates.get(&fate).copied().unwrap_or_default();
    // All kinds must occur, or the mutants are too tame or too wild for a test.
    assert!(of(Fate::Refused) > wanted / 20, "{fates:?}");
    assert!(of(Fate::Long) < wanted.div_ceil(50).max(2), "{fates:?}");
    assert!(of(Fate::Doubtful) > wanted / 20 && of(Fate::Trusted) > wanted / 20, "{fates:?}");
}

/// The same seed gives the same mutant with the same outcome.
#[test]
fn a_seed_names_a_mutant() {
    names_its_mutant(0..8);
}

#[test]
#[ignore = "ci: 40 mutants, each twice"]
fn every_seed_names_a_mutant() {
    names_its_mutant(0..40);
}

fn names_its_mutant(seeds: std::ops::Range<u64>) {
    for seed in seeds {
        assert_eq!(press(seed), press(seed), "{seed}");
    }
}

/// Lanes report the same warnings as a press: their energy balance is the engine's, recomputed from the ends of every
/// step. A balance kept from outside, in other arithmetic, agrees. Bounds are far from the usual values of runs.
#[test]
fn a_study_distrusts_what_a_press_does() {
    distrusts_alike(56..80);
}

fn distrusts_alike(seeds: std::ops::Range<u64>) {
    let count = seeds.end - seeds.start;
    let (mut compared, mut doubtful) = (0_u64, 0_u64);
    for seed in seeds {
        let mut rng = Rng::with_seed(1_000_000 + seed);
        let text = mutated(Instrument::builtin_text("concert-grand").unwrap(), &mut rng);
        let Ok(file) = InstrumentFile::parse(&text, "mutant.toml") else { continue };
        let force_n = 0.5 + 30.0 * rng.f64();
        let setup = Setup::new(0.08);
        let jobs = vec![Job { instrument: 0, stroke: Box::new(move |_| Input::Force(force_n)) }];
        let workers = Workers { threads: 1, ..Workers::all() };
        let instruments = [file.instrument];
        let played = play_all(&instruments, jobs, &setup, workers, &mut |_| true).unwrap().remove(0);
        let drive = player::force(|_| force_n);
        let mut audit = EnergyAudit::new(&instruments[0], &drive);
        let alone = simulate_observed(&instruments[0], &drive, &setup, &mut audit, &mut |_| true);
        let (Ok(played), Ok(alone)) = (played, alone) else { continue };
        let residual = erard::trust::energy_residual(alone.ledger.as_ref().unwrap());
        let lanes = played.energy_residual.unwrap();
        let kinds = |warnings: &[erard::trust::Warning]| {
            let mut kinds: Vec<_> = warnings.iter().map(|w| (w.kind, w.part.clone())).collect();
            // Where lanes round differently, chaotic motion diverges; so may the count of unconverged steps.
            kinds.retain(|(kind, _)| *kind != erard::trust::WarningKind::UnconvergedSteps);
            kinds
        };
        compared += 1;
        doubtful += u64::from(!alone.is_trusted());
        // Near the bound either may be on its other side.
        let outside = audit.residual();
        if [residual, lanes, outside].iter().any(|residual| (5e-3..2e-2).contains(residual)) {
            continue;
        }
        assert_eq!(kinds(&played.warnings), kinds(&alone.warnings), "{seed}: {residual:e} {lanes:e}");
        if residual < 5e-3 {
            assert!((residual - lanes).abs() < 2e-3, "{seed}: {residual:e} {lanes:e}");
            assert!((residual - outside).abs() < 2e-3, "{seed}: {residual:e} {outside:e}");
        }
    }
    println!("{compared} compared, {doubtful} doubtful");
    // 96 and 7 of 200.
    assert!(10 * compared > 3 * count && 40 * doubtful > count, "{compared} compared, {doubtful} doubtful");
}
