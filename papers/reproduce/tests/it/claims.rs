//! What `erard-reproduce` claims, as far as it takes seconds: verdicts on the shipped grand must not change unnoticed.

use erard::instrument::Instrument;
use erard::run::SimulationError;
use erard_reproduce::subjects::{ReproduceError, Section, subjects};

fn grand() -> Instrument {
    Instrument::builtin("concert-grand-rigid").expect("the built-in grand reads")
}

fn section(name: &str) -> Section {
    let subject = subjects().into_iter().find(|s| s.name == name).expect("a subject of this name");
    (subject.run)(&grand(), &mut |_| true).expect("it can be computed")
}

/// Claims of the papers (and of this program about itself) that hold on the shipped instrument.
#[test]
fn claims_hold() {
    hold(&["paper2-felt", "paper3-levers", "released-key", "laid-weight"]);
}

/// The picture of a key let go has six recorded releases and the model's, from their landing on, and a band of the
/// sensor's 0.2 mm around the recorded; in each of these the key comes back twice.
#[test]
fn recorded_and_modelled_keys_begin_with_their_landing() {
    let section = section("released-key");
    let chart = section.charts.last().unwrap();
    let [whole, near] = &chart.panels[..] else { panic!("{} panels", chart.panels.len()) };
    assert_eq!((whole.curves.len(), near.curves.len()), (7, 9));
    for curve in &whole.curves {
        let landing = curve.x.iter().position(|ms| ms.abs() < 1e-9).unwrap();
        assert!(curve.y[landing] < 0.5 && curve.y[..landing].iter().all(|mm| *mm >= 0.5), "{}", curve.label);
        assert!(curve.x[0] >= -30.0 - 1e-9 && curve.y[0] > 5.0, "{}: {}", curve.label, curve.y[0]);
    }
    let (recorded, [high, low]) = (&near.curves[..6], &near.curves[7..]) else { panic!("no band") };
    for row in 0..high.y.len() {
        let heights = recorded.iter().map(|curve| curve.y[row]);
        let [least, most] = heights.fold([f64::INFINITY, 0.0], |[a, b], y| [a.min(y), b.max(y)]);
        assert!((high.y[row] - most - 0.2).abs() < 1e-9 && (least - low.y[row] - 0.2).abs() < 1e-9, "row {row}");
    }
    let rows = &section.tables.last().unwrap().rows;
    let [recorded @ .., model] = &rows[..] else { panic!("no rows") };
    assert!(recorded.len() == 6 && recorded.iter().all(|row| row[1] == "2"), "{recorded:?}");
    assert_eq!(model[0], "modelled");
}

/// What a lying key changes, and what it leaves open: it comes back once, not twice, no hold explains the first
/// millimetre of a recorded release, and lead above the balance pin does not tell it from a nailed one.
#[test]
#[ignore = "ci: a slow subject of the report"]
fn a_lying_key_returns_less_and_still_starts_too_slowly() {
    assert_eq!(on_the_grand("lying-key"), [true, false, true, true, true, false, false]);
}

/// What heel and knuckles give back. The spread of the file leaves out what gives back most: whoever changes it changes
/// `docs/notes/evidence.md`.
#[test]
fn the_spread_of_the_train_leaves_out_what_gives_back_most() {
    assert_eq!(on_the_grand("train-loss"), [true, true, true, true, false, false]);
}

/// Which claims of a subject hold on the grand that bends.
fn on_the_grand(name: &str) -> Vec<bool> {
    let grand = Instrument::builtin("concert-grand").expect("the built-in grand reads");
    let subject = subjects().into_iter().find(|s| s.name == name).expect("a subject of this name");
    (subject.run)(&grand, &mut |_| true).expect("it can be computed").claims.iter().map(|c| c.holds).collect()
}

// Slow subjects, one test each: they run side by side.

#[test]
#[ignore = "ci: a slow subject of the report"]
fn claims_of_transfer_functions_hold() {
    hold(&["paper1-transfer"]);
}

#[test]
#[ignore = "ci: a slow subject of the report"]
fn claims_of_the_finger_hold() {
    hold(&["paper2-finger"]);
}

#[test]
#[ignore = "ci: a slow subject of the report"]
fn claims_of_the_struck_hand_hold() {
    hold(&["struck-hand"]);
}

fn hold(names: &[&str]) {
    for &name in names {
        for claim in section(name).claims {
            // Gauss-Seidel may need more sweeps than it has in a step of a hundred thousand; the report counts them.
            if name == "scheme-solvers" && claim.source == "this program" {
                continue;
            }
            assert!(claim.holds, "{name}: {}: {}", claim.says, claim.measured);
        }
    }
}

/// Adaptive steps cost less at 1e-6, for the hammer's speed and for the trajectory, and keep to their tolerance. (At
/// 1e-3 they do not pay, or hardly; the report says.)
#[test]
#[ignore = "ci: a convergence study"]
fn controlled_steps_pay_at_high_precision() {
    let claims = section("scheme-control").claims;
    let kept: Vec<_> = claims.iter().filter(|c| !c.says.contains("1e-3 costs")).collect();
    assert_eq!((claims.len(), kept.len()), (5, 3));
    for claim in kept {
        assert!(claim.holds, "{}: {}", claim.says, claim.measured);
    }
}

/// [T12] figure 3, right: motion-driven, one degree of freedom misses what the whole mechanism has, derived or fitted.
/// (How closely it follows when force-driven depends on the instrument's numbers; the report says.)
#[test]
fn motion_driven_reveals() {
    let claims = section("paper1-drives").claims;
    let right: Vec<_> = claims.iter().filter(|c| c.source.ends_with("right")).collect();
    assert_eq!((claims.len(), right.len()), (8, 2));
    for claim in right {
        assert!(claim.holds, "{}: {}", claim.says, claim.measured);
    }
}

/// Every subject ends on request, with the error that becomes exit code 130.
#[test]
fn work_can_be_ended() {
    for subject in subjects() {
        let mut asked = 0;
        let result = (subject.run)(&grand(), &mut |_| {
            asked += 1;
            false
        });
        match result {
            Err(ReproduceError::Simulation(SimulationError::Interrupted)) => {}
            // Those that take a fraction of a second do not ask.
            Ok(_) => assert!(asked == 0 && subject.weight <= 2.0, "{}", subject.name),
            Err(error) => panic!("{}: {error}", subject.name),
        }
    }
}

/// The same numbers every time, but for what is said to be on the clock.
#[test]
fn sections_are_the_same_each_time() {
    assert_eq!(section("paper3-levers"), section("paper3-levers"));
    let names: Vec<&str> = subjects().iter().map(|s| s.name).collect();
    let mut sorted = names.clone();
    sorted.sort_unstable();
    sorted.dedup();
    assert_eq!(sorted.len(), names.len(), "names are unique");
}

#[test]
#[ignore = "ci: two subjects, each twice"]
fn slow_sections_are_the_same_each_time() {
    for name in ["paper1-drives", "paper1-transfer"] {
        assert_eq!(section(name), section(name), "{name}");
    }
}

mod nightly {
    use super::*;

    #[test]
    #[ignore = "nightly: eight subjects of the report"]
    fn claims_of_the_slowest_subjects_hold() {
        hold(&["paper1-fine-structure", "touch-scatter", "scheme-energy", "scheme-solvers", "strings"]);
        // A greater loss moves the order of events by more than 0.2 ms; `docs/notes/evidence.md` says so.
        assert_eq!(super::on_the_grand("train-felts"), [true, false]);
        hold(&["what-gives", "events"]);
    }

    /// Claims about strings. Two do not hold, which `docs/notes/strings.md` explains: how C4's contact shortens, and
    /// how long bass strings ring under their dampers. Whoever mends one changes that note.
    #[test]
    #[ignore = "nightly: four subjects of strings"]
    fn claims_about_strings() {
        for (name, claims, missed) in [
            ("strings-energy", 4, None),
            ("contact", 3, Some("KTH lectures")),
            ("dampers", 3, Some("general experience")),
            ("strings-aftersound", 1, None),
        ] {
            let found = section(name).claims;
            assert_eq!(found.len(), claims, "{name}");
            for claim in found {
                assert_eq!(claim.holds, Some(claim.source) != missed, "{name}: {}: {}", claim.says, claim.measured);
            }
        }
    }
}

/// What the papers leave for later says what is true today: of strings, bends, recordings and estimates it is looked
/// up, and every subject that it names exists.
#[test]
fn what_is_left_for_later_is_looked_up() {
    let section = section("outlook");
    let rows = &section.tables[0].rows;
    let row = |what: &str| rows.iter().find(|row| row[0].contains(what)).unwrap_or_else(|| panic!("{what}"));
    let has_strings = Instrument::builtin("concert-grand-strings").unwrap().has_yielding_strings();
    assert!(has_strings && row("the string's own motion")[3].contains("concert-grand-strings"));
    assert_eq!(row("the string's own motion")[2], "as an option");
    // The recordings are of key and hammer.
    assert!(row("measured force")[2] == "tool only" && row("measured force")[3].contains("0 of 6"), "{rows:?}");
    let estimates: Vec<usize> = row("identified")[3].split(' ').filter_map(|word| word.parse().ok()).collect();
    assert!(estimates[0] > 10 && estimates[0] <= estimates[1] && row("identified")[2] == "no", "{rows:?}");
    for key in ["dry_loss", "relaxed", "bushing_N_per_m", "static_friction_ratio", "dwell_s"] {
        assert!(row("hysteresis")[3].contains(key), "{key}: {rows:?}");
    }
    let known: Vec<&str> = subjects().iter().map(|subject| subject.name).collect();
    let mut named = 0;
    for how in rows.iter().map(|row| &row[3]) {
        for asked in how.split("--only ").skip(1) {
            for name in asked.split('`').next().unwrap().split(',') {
                assert!(known.contains(&name), "{name}: {known:?}");
                named += 1;
            }
        }
    }
    assert!(named >= 8, "{named}");
}
