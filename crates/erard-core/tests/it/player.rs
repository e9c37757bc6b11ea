//! The player from outside: readings, impacts, snapshots, bad inputs, sizes.

use crate::common::{Play, USUAL_STEP_S, grand, rigid_grand};
use erard::player::{MechanismState, SNAPSHOT_MARK};
use erard::saved::{Lists, Unreadable, Writer};
use erard::stroke::{Cursor, Series, Touch};
use erard::{Action, FrictionLaw, Impact, Input, Instrument, Settings, Snapshot, SnapshotError, Solver, StepOutcome};

/// The force of the mf stroke at the middle of a step.
fn mf() -> impl Fn(u64) -> Input {
    let series = Series::builtin("mf", Touch::Pressed).and_then(|s| s.force).expect("built in");
    move |n| Input::Force(series.at(n as f64 * USUAL_STEP_S + 0.5 * USUAL_STEP_S, &mut Cursor::default()))
}

/// The concert grand with bending parts, as the benchmarks count it.
fn bending(bodies: usize) -> Instrument {
    let path = format!("{}/tests/bending/{bodies}-bodies.toml", env!("CARGO_MANIFEST_DIR"));
    Instrument::load(std::path::Path::new(&path)).expect("it reads")
}

/// Stepped from outside, the action is the one that a run plays: key, hammer and impacts to the bit, forces to the mean
/// of two steps.
#[test]
fn readings_are_a_runs_rows() {
    let run = Play::Stroke("mf", Touch::Pressed).run_every(&grand(), Settings::new(USUAL_STEP_S), 0.2, Some(1));
    let (mut action, force) = (Action::new(&grand()).unwrap(), mf());
    let (mut impacts, mut before_n) = (Vec::new(), None);
    for n in 0..4000 {
        let reading = action.step(force(n));
        let row = n as usize + 1;
        assert_eq!(reading.key_m.to_bits(), run.key_m[row].to_bits(), "row {row}");
        assert_eq!(reading.hammer_rise_m.to_bits(), run.hammer_rise_m[row].to_bits(), "row {row}");
        if let Some(before_n) = before_n.replace(reading.finger_force_n) {
            let centred: f64 = 0.5 * before_n + 0.5 * reading.finger_force_n;
            assert!((centred - run.force_n[row - 1]).abs() < 1e-12, "row {row}");
        }
        impacts.extend(action.impact());
    }
    assert!(!impacts.is_empty());
    assert_eq!(impacts, run.events.impacts);
    assert_eq!(Some(impacts[0].hammer_speed_m_per_s), run.events.hammer_speed_m_per_s());
}

/// The speeds of a reading are the derivatives of its places: by central differences of 50 us, whose own error is the
/// third derivative's.
#[test]
fn speeds_are_derivatives() {
    let (mut action, force) = (Action::new(&grand()).unwrap(), mf());
    let readings: Vec<_> = (0..1000).map(|n| action.step(force(n))).collect();
    let slope = |a: f64, b: f64| (b - a) / (2.0 * USUAL_STEP_S);
    let mut worst = [0.0_f64; 2];
    for three in readings.windows(3) {
        worst[0] = worst[0].max((slope(three[0].key_m, three[2].key_m) - three[1].key_m_per_s).abs());
        worst[1] =
            worst[1].max((slope(three[0].hammer_rise_m, three[2].hammer_rise_m) - three[1].hammer_rise_m_per_s).abs());
    }
    println!("{worst:?} m/s");
    assert!(worst[0] < 1e-3 && worst[1] < 1e-2, "{worst:?}");
    assert!(readings.iter().any(|r| r.hammer_rise_m_per_s > 1.0));
}

/// A snapshot taken one step before an impact, restored in another action: the same impact and, many steps later, the
/// same bits.
#[test]
fn a_snapshot_goes_on_to_the_bit() {
    goes_on_to_the_bit(100_000);
}

#[test]
#[ignore = "ci: a million steps"]
fn a_snapshot_goes_on_to_the_bit_for_long() {
    goes_on_to_the_bit(1_000_000);
}

fn goes_on_to_the_bit(steps: u64) {
    let grand = grand();
    let (mut probe, force) = (Action::new(&grand).unwrap(), mf());
    let blow_step = (0..4000).find(|&n| {
        probe.step(force(n));
        probe.impact().is_some()
    });
    let at = blow_step.expect("mf strikes");
    let mut first = Action::new(&grand).unwrap();
    for n in 0..at {
        first.step(force(n));
    }
    let snapshot = first.save();
    // Through text and back: it is data.
    let text = serde_json::to_string(&snapshot).unwrap();
    let read: Snapshot = serde_json::from_str(&text).unwrap();
    assert_eq!(read, snapshot);
    let mut second = Action::new(&grand).unwrap();
    second.step(Input::Force(30.0));
    second.restore(&read).unwrap();
    assert_eq!(second.time_s(), first.time_s());
    for n in at..at + steps {
        // A tremolo after the stroke, so that it never rests for long.
        let input = if n < 4000 { force(n) } else { Input::Force(if n / 2000 % 2 == 0 { 9.0 } else { 0.0 }) };
        let (a, b) = (first.step(input), second.step(input));
        if n == at {
            assert_eq!(first.impact(), second.impact());
            assert!(first.impact().is_some());
        }
        if n % 1000 == 0 || n == at {
            assert_eq!(a, b, "step {n}");
        }
    }
    let bits = |action: &Action| -> Vec<u64> {
        action.angles().iter().chain(action.velocities()).map(|x| x.to_bits()).collect()
    };
    assert_eq!(bits(&first), bits(&second));
    assert_eq!(format!("{:?}", first.save()), format!("{:?}", second.save()));
}

/// A state in bytes whose force of a rigid drive is no number: the list that is read is the first of its name.
fn with_a_number_that_is_not_finite(state: &MechanismState) -> Vec<u8> {
    let write = |bytes: &mut [u8]| {
        let mut out = Writer::new(bytes, SNAPSHOT_MARK);
        out.number("rigid_force_N", f64::NAN);
        state.write(&mut out);
        out.seal()
    };
    let mut bytes = vec![0; write(&mut [])];
    write(&mut bytes);
    bytes
}

/// A snapshot knows the step, theta, solver and friction that it belongs to: others are refused, both are named, and
/// nothing changes. A state of an earlier program does not say, and goes on.
#[test]
fn a_snapshot_refuses_other_settings() {
    let (grand, usual) = (grand(), Settings::new(USUAL_STEP_S));
    let mut action = Action::with(&grand, usual).unwrap();
    for _ in 0..500 {
        action.step(Input::Force(5.0));
    }
    let own = action.save();
    let regularised = FrictionLaw::Regularised { pivot_width: 0.1, sliding_width: 0.01 };
    for (settings, named) in [
        (Settings { step: 20e-6, ..usual }, "steps of 0.00005 s"),
        (Settings { theta: 0.75, ..usual }, "theta 0.75"),
        (Settings { solver: Solver::ProjectedGaussSeidel, ..usual }, "projected-gauss-seidel"),
        (Settings { friction: regularised, ..usual }, "tanh of widths 0.1 rad/s and 0.01 m/s"),
    ] {
        let mut other = Action::with(&grand, settings).unwrap();
        let before = other.save();
        let error = other.restore(&own).unwrap_err();
        assert!(matches!(error, SnapshotError::Settings { .. }), "{error}");
        let told = error.to_string();
        assert!(
            told.contains("steps of 0.00005 s, theta 0.5, solver active-set, friction set-valued; expected"),
            "{told}"
        );
        assert!(told.contains(named), "{told}");
        assert_eq!(other.save(), before);
        // Without the list.
        let mut text = serde_json::to_value(&own).unwrap();
        text.as_object_mut().unwrap().remove("settings").unwrap();
        let earlier: Snapshot = serde_json::from_value(text).unwrap();
        other.restore(&earlier).unwrap();
        assert_eq!(other.angles(), action.angles());
    }
}

/// A snapshot of another instrument, of another version or with a number that is not finite is refused, and nothing
/// changes.
#[test]
fn snapshots_that_do_not_fit_are_refused() {
    let (grand, other) = (grand(), Instrument::builtin("heavy-touch").unwrap());
    let mut action = Action::new(&grand).unwrap();
    for _ in 0..500 {
        action.step(Input::Force(5.0));
    }
    let (own, before) = (action.save(), format!("{:?}", action.save()));
    let foreign = Action::new(&other).unwrap().save();
    assert_eq!(action.restore(&foreign), Err(SnapshotError::Instrument));
    let mut broken = own.to_vec();
    broken[8] = 7;
    assert_eq!(Snapshot::from_bytes(&broken), Err(SnapshotError::Unreadable(Unreadable::Version(7))));
    let mut text = serde_json::to_value(&own).unwrap();
    text["version"] = 7.into();
    assert!(serde_json::from_value::<Snapshot>(text).unwrap_err().to_string().contains("version 7"));
    let broken = with_a_number_that_is_not_finite(&own.mechanism);
    assert_eq!(Snapshot::from_bytes(&broken), Err(SnapshotError::NotFinite));
    let lists = Lists::read(&broken, SNAPSHOT_MARK).unwrap();
    assert_eq!(action.restore_from(&MechanismState::read(&lists), &|_, _| 0), Err(SnapshotError::NotFinite));
    assert_eq!(format!("{:?}", action.save()), before);
}

/// What is not finite ends at the door: the reading says so, the action is where it was, and it plays on.
#[test]
fn bad_inputs_leave_the_action_as_it_was() {
    let bad = [
        Input::Force(f64::NAN),
        Input::Force(f64::INFINITY),
        Input::Motion { position_m: f64::NAN, velocity_m_per_s: 0.0 },
        Input::Motion { position_m: 0.0, velocity_m_per_s: f64::NEG_INFINITY },
        Input::Rigid { position_m: f64::NAN, velocity_m_per_s: 0.0 },
        Input::Rigid { position_m: 0.0, velocity_m_per_s: f64::NAN },
    ];
    for bad in bad {
        let mut action = Action::new(&grand()).unwrap();
        for _ in 0..300 {
            action.step(Input::Force(5.0));
        }
        let before: Vec<f64> = action.angles().to_vec();
        let reading = action.step(bad);
        assert_eq!(reading.outcome, StepOutcome::NonFinite, "{bad:?}");
        assert_eq!(action.angles(), before, "{bad:?}");
        let next = action.step(Input::Force(5.0));
        assert_eq!(next.outcome, StepOutcome::Converged, "{bad:?}");
        assert!(next.key_m.is_finite() && next.finger_force_n.is_finite());
        let rigid = action.step(Input::Rigid { position_m: next.key_m, velocity_m_per_s: 0.0 });
        assert_eq!(rigid.outcome, StepOutcome::Converged, "{bad:?}");
    }
}

/// Neither a step with everything read, nor saving and restoring take memory from the heap.
#[test]
fn nothing_allocates() {
    let mut action = Action::new(&grand()).unwrap();
    let force = mf();
    let (mut sum, mut impacts) = (0.0, 0);
    let counted = allocation_counter::measure(|| {
        for n in 0..20_000 {
            let r = action.step(force(n));
            sum += r.key_m + r.key_m_per_s + r.finger_force_n + r.hammer_rise_m + r.hammer_rise_m_per_s + r.string_n;
            sum += action.angles()[0]
                + action.velocities()[1]
                + action.contact_force(3).unwrap()
                + action.tangential_force(3).unwrap();
            impacts += usize::from(action.impact().is_some());
            if n % 1000 == 500 {
                let snapshot = action.save();
                action.restore(&snapshot).expect("its own");
            }
        }
    });
    assert!(sum.is_finite() && impacts > 0);
    assert_eq!((counted.count_total, counted.bytes_total), (0, 0), "{counted:?}");
}

/// Seven, eight and nine bodies play: the hammer strikes, every step converges, the energy balance closes.
#[test]
fn larger_sizes_play() {
    for bodies in [7, 8, 9] {
        let instrument = bending(bodies);
        assert_eq!(instrument.bodies.len(), bodies);
        let run = Play::Stroke("mf", Touch::Pressed).run(&instrument, Settings::new(USUAL_STEP_S), 0.5);
        let ledger = run.ledger.expect("it is kept");
        println!("{bodies} bodies: {:?}, residual {:.1e}", run.events.impacts, ledger.residual_relative());
        let Some(Impact { hammer_speed_m_per_s: speed_m_per_s, .. }) = run.events.impacts.first().copied() else {
            panic!("{bodies} strikes")
        };
        assert!((0.5..4.0).contains(&speed_m_per_s), "{bodies}: {speed_m_per_s}");
        assert_eq!(run.work.unconverged_steps, 0, "{bodies}");
        assert!(ledger.residual_relative() < 1e-3, "{bodies}: {}", ledger.residual_relative());
    }
}

/// The hammer's speed is reported in total and along the string's normal, over a rigid string and over one that sounds.
/// The normal is vertical, so that the part along it is how fast the head rises, read in the step before.
#[test]
fn the_hammers_speed_is_reported_in_total_and_along_the_normal() {
    for name in ["concert-grand", "concert-grand-rigid", "concert-grand-strings"] {
        let instrument = erard::Instrument::builtin(name).unwrap();
        let mut action = Action::new(&instrument).unwrap();
        let (mut before, mut found) = (action.reading(), None);
        for _ in 0..10_000 {
            let now = action.step(Input::Force(5.0));
            found = action.impact();
            if found.is_some() {
                break;
            }
            before = now;
        }
        let Impact { hammer_speed_m_per_s: total, hammer_speed_normal_m_per_s: normal, .. } =
            found.expect("it strikes");
        println!("{name}: {total:.4} m/s, {normal:.4} along the normal, {:.4} of it", normal / total);
        assert!(
            (normal / before.hammer_rise_m_per_s - 1.0).abs() < 3e-3,
            "{name}: {normal} {}",
            before.hammer_rise_m_per_s
        );
        // The head is 48 mm above the line from the pin, at 130 mm along it.
        assert!((normal / total - 130.0 / 130.0_f64.hypot(48.0)).abs() < 0.01, "{name}: {}", normal / total);
    }
}

/// A file whose laws, bodies or zones do not fit the largest size is an error, never a law left out.
#[test]
fn what_does_not_fit_is_an_error() {
    let mut too_many = rigid_grand();
    let body = too_many.bodies[5].clone();
    too_many.edit(|fields| fields.bodies.extend(std::iter::repeat_n(body, 10))).unwrap();
    let error = Action::new(&too_many).map(|_| ()).unwrap_err().to_string();
    assert!(error.contains("16") && error.contains("12"), "{error}");
}
