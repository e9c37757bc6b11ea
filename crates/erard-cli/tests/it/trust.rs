//! A run that cannot be trusted says so, wherever its numbers go; one that can says nothing.

use crate::common::Folder;
use serde_json::Value;

/// The grand with a line of a zone replaced.
fn grand_with(zone: &str, key: &str, value: &str) -> String {
    let text = erard::Instrument::builtin_text("concert-grand").unwrap();
    let from = text.find(&format!("[[zone]]\nname = \"{zone}\"")).unwrap();
    let at = from + text[from..].find(&format!("\n{key} = ")).unwrap() + 1;
    let end = at + text[at..].find('\n').unwrap();
    format!("{}{key} = {value}{}", &text[..at], &text[end..])
}

/// Standard error and the summary of a press that goes through.
fn press(folder: &Folder, arguments: &[&str]) -> (String, Value) {
    let output = folder.erard(&[&["press", "--out", "out"], arguments].concat());
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{arguments:?}: {said}");
    (said, serde_json::from_str(&folder.read("out/summary.json")).unwrap())
}

fn kinds(summary: &Value) -> Vec<&str> {
    summary["warnings"].as_array().unwrap().iter().map(|w| w["kind"].as_str().unwrap()).collect()
}

/// The README's presses: nothing on standard error, `trusted`, no warning on the page.
#[test]
fn the_readme_s_first_press_is_trusted() {
    are_trusted(&[&[], &["--model", "one-dof", "--duration", "0.1"]]);
}

#[test]
#[ignore = "ci: all presses of the README"]
fn presses_of_the_readme_are_trusted() {
    are_trusted(&[
        &[],
        &["--stroke", "ff", "--touch", "struck"],
        &["--force-step", "0.8", "--duration", "1"],
        &["--tolerance", "1e-6"],
        &["--model", "one-dof"],
    ]);
}

fn are_trusted(presses: &[&[&str]]) {
    let folder = Folder::new("trust-readme");
    for &arguments in presses {
        let (said, summary) = press(&folder, arguments);
        assert!(said.is_empty(), "{arguments:?}: {said}");
        assert_eq!((summary["trusted"].as_bool(), kinds(&summary).len()), (Some(true), 0), "{arguments:?}");
        assert!(!folder.read("out/run.html").contains("cannot be trusted"), "{arguments:?}");
    }
}

/// What passed in silence once.
#[test]
fn runs_that_cannot_be_trusted_say_so() {
    let folder = Folder::new("trust-doubtful");
    folder.file("linear.toml", &grand_with("string", "exponent", "1"));
    folder.file("far.toml", &grand_with("string", "point_mm", "[251, -10000]"));
    for (arguments, kind) in [
        (&["--instrument", "linear.toml"][..], "energy_residual"),
        (&["--theta", "1", "--dt", "1e-3", "--stroke", "ff"], "energy_residual"),
        (&["--force-step", "10000"], "felt_beyond_thickness"),
    ] {
        let (said, summary) = press(&folder, arguments);
        assert!(said.contains("warning: this run cannot be trusted: "), "{arguments:?}: {said}");
        assert_eq!(summary["trusted"].as_bool(), Some(false), "{arguments:?}");
        assert!(kinds(&summary).contains(&kind), "{arguments:?}: {:?}", kinds(&summary));
        for warning in summary["warnings"].as_array().unwrap() {
            assert!(
                warning["value"].is_number() && warning["bound"].is_number() && warning["unit"].is_string(),
                "{warning}"
            );
            assert!(said.contains(warning["what"].as_str().unwrap()), "{warning}: {said}");
        }
        let page = folder.read("out/run.html");
        assert!(page.contains("This run cannot be trusted"), "{arguments:?}");
    }
    // The hammer begins ten metres within its string: that is no doubt, but an error.
    let said = folder.bad(&["press", "--instrument", "far.toml"]);
    assert!(said.contains("flies apart"), "{said}");
}

/// The instants of every row, whether it is to be trusted, and what of its energy is not explained.
#[test]
fn a_study_has_a_column_for_it() {
    let folder = Folder::new("trust-study");
    let study = |dt: &str| {
        let output = folder.erard(&[
            "study",
            "--vary",
            "force=2,30",
            "--duration",
            "0.15",
            "--dt",
            dt,
            "--theta",
            "1",
            "--out",
            "out",
        ]);
        assert!(output.status.success());
        let table = folder.read("out/study.csv");
        let mut rows = table.lines().map(|line| line.split(',').map(str::to_owned).collect::<Vec<_>>());
        let head = rows.next().unwrap();
        let place = |name: &str| head.iter().position(|column| column == name).unwrap();
        let [trusted, residual] = ["trusted", "energy_residual_relative"].map(place);
        let rows: Vec<(String, f64)> = rows.map(|row| (row[trusted].clone(), row[residual].parse().unwrap())).collect();
        (rows, String::from_utf8(output.stderr).unwrap())
    };
    let (rows, said) = study("1e-3");
    assert!(rows.iter().all(|(trusted, residual)| trusted == "0" && *residual > 0.01), "{rows:?}");
    assert!(said.contains("2 of 2 strokes") && said.contains("energy"), "{said}");
    let output = folder.erard(&["study", "--vary", "let_off=-0.5mm..0.5mm:5", "--force-step", "5", "--out", "five"]);
    assert!(output.status.success() && output.stderr.is_empty(), "{}", String::from_utf8_lossy(&output.stderr));
    let said = folder.bad(&["study", "--vary", "back_check_angle=1e9"]);
    assert!(said.contains("back_check_angle") && said.contains("at most 90 degrees either way"), "{said}");
}

/// One key of 88 whose parts weigh a fifty-thousandth: its hammer meets the string with more than 100 m/s, once "all
/// 88 keys are sound".
#[test]
#[ignore = "ci: a keyboard of 88 keys"]
fn a_key_at_a_hundred_metres_a_second() {
    let folder = Folder::new("trust-fast");
    let base = erard::instrument::Instrument::builtin("steinway-o").unwrap();
    let numbers: Vec<String> = base
        .bodies
        .iter()
        .enumerate()
        .filter(|(body, _)| !base.is_arm(*body))
        .flat_map(|(_, body)| ["mass_g", "inertia_kg_m2"].map(|key| format!("\"body.{}.{key}\"", body.name)))
        .collect();
    folder.file(
        "fast.toml",
        &format!(
            "format = \"erard-keyboard/1\"\nname = \"Fast\"\ninstrument = \"steinway-o\"\ninstrument_key = 40\n[[factor]]\n\
             name = \"light\"\nnumbers = [{}]\nfactor = [{{ key = 87, value = 1 }}, {{ key = 88, value = 2e-5 }}]\n",
            numbers.join(", ")
        ),
    );
    let output = folder.erard(&["check", "fast.toml"]);
    let (told, said) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success() && Folder::words(&told).contains("1 of the 88 keys cannot be trusted"), "{told}");
    let blow = said.lines().find(|line| line.contains("the hammer reaches the string with")).unwrap();
    let speed = blow.split("reaches the string with ").nth(1).unwrap().split(' ').next().unwrap();
    assert!(speed.parse::<f64>().unwrap() >= 100.0 && blow.contains("key 88"), "{blow}");
}

/// Mutants from end to end: the command presses what it accepts, touches nothing that it reads and leaves nothing
/// behind.
#[test]
#[ignore = "ci: 24 mutants"]
fn mutants_touch_nothing_and_leave_nothing_behind() {
    let folder = Folder::new("trust-mutants");
    let (mut pressed, mut refused) = (0, 0);
    for seed in 0..24_u64 {
        let mut rng = fastrand::Rng::with_seed(seed);
        let zones = ["string", "check", "capstan_heel", "let_off_button", "key_front"];
        let (key, value) = match rng.u8(..4) {
            0 => ("stiffness_N_per_m_r", format!("{:e}", 10f64.powf(24.0 * rng.f64()))),
            1 => ("exponent", format!("{:?}", 0.8 + 6.0 * rng.f64())),
            2 => ("damping_N_s_per_m3", format!("{:e}", 10f64.powf(24.0 * rng.f64()))),
            _ => ("thickness_mm", format!("{:?}", 10f64.powf(4.0 * rng.f64() - 2.0))),
        };
        let text = grand_with(zones[rng.usize(..zones.len())], key, &value);
        let stroke = format!("time_s,force_N\n0,{:?}\n0.03,{:?}\n", 20.0 * rng.f64(), 10f64.powf(4.0 * rng.f64()));
        folder.file("mutant.toml", &text);
        folder.file("mutant.csv", &stroke);
        let output =
            folder.erard(&["press", "mutant.csv", "--instrument", "mutant.toml", "--out", "out", "--duration", "0.05"]);
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(!said.contains("panicked"), "{seed}: {said}");
        assert_eq!((folder.read("mutant.toml"), folder.read("mutant.csv")), (text, stroke), "{seed}");
        match output.status.code() {
            Some(0) => {
                pressed += 1;
                let summary: Value = serde_json::from_str(&folder.read("out/summary.json")).unwrap();
                assert_eq!(summary["trusted"].as_bool(), Some(kinds(&summary).is_empty()), "{seed}");
                assert_eq!(!said.contains("cannot be trusted: "), kinds(&summary).is_empty(), "{seed}: {said}");
                let table = folder.read("out/run.csv");
                let numbers = table.lines().skip(1).flat_map(|line| line.split(','));
                assert!(
                    numbers.filter(|n| !n.is_empty()).all(|n| n.parse::<f64>().is_ok_and(f64::is_finite)),
                    "{seed}"
                );
            }
            Some(2) => {
                refused += 1;
                assert!(said.lines().any(|line| line.starts_with("error: ")), "{seed}: {said}");
            }
            code => panic!("{seed}: {code:?}: {said}"),
        }
        let left: Vec<String> = folder.names().into_iter().filter(|name| name != "out").collect();
        assert_eq!(left, ["mutant.csv", "mutant.toml"], "{seed}");
    }
    println!("{pressed} pressed, {refused} refused");
    assert!(pressed > 6 && refused > 1, "{pressed} pressed, {refused} refused");
}

mod nightly {
    use super::*;

    /// Springs and felts that are absurd in the treble, and nobody calls that sound.
    #[test]
    #[ignore = "nightly: three keyboards of 88 keys"]
    fn a_keyboard_with_an_absurd_key_is_not_sound() {
        let folder = Folder::new("trust-keyboard");
        let keyboard = |numbers: &str, factor: &str| {
            format!(
                "format = \"erard-keyboard/1\"\nname = \"Mine\"\ninstrument = \"concert-grand\"\ninstrument_key = 40\n[[factor]]\n\
                 name = \"far\"\nnumbers = [{numbers}]\nfactor = [{{ key = 40, value = 1 }}, {{ key = 88, value = {factor} }}]\n"
            )
        };
        folder.file("good.toml", &keyboard("\"zone.string.felt.stiffness_N_per_m_r\"", "1.5"));
        let output = folder.erard(&["check", "good.toml"]);
        assert!(
            output.stderr.is_empty()
                && Folder::words(&String::from_utf8_lossy(&output.stdout)).contains("all 88 keys are sound")
        );
        for (numbers, factor) in [
            ("\"spring.repetition.torque_N_m\"", "3e4"),
            ("\"zone.capstan_heel.felt.stiffness_N_per_m_r\", \"zone.string.felt.stiffness_N_per_m_r\"", "1e-6"),
        ] {
            folder.file("absurd.toml", &keyboard(numbers, factor));
            let output = folder.erard(&["check", "absurd.toml"]);
            let (told, said) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
            let told = Folder::words(&told);
            assert!(output.status.success() && !told.contains("are sound"), "{numbers}: {told}");
            assert!(told.contains("of the 88 keys cannot be trusted"), "{numbers}: {told}");
            assert!(said.contains("warning: ") && said.contains("the worst, key "), "{numbers}: {said}");
        }
    }
}
