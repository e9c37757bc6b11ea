//! `erard press --reactions` and `--losses`, as a user runs them.

use crate::common::Folder;
use serde_json::Value;

/// The columns of a CSV file by name.
fn column(text: &str, name: &str) -> Vec<f64> {
    let mut lines = text.lines();
    let at = lines.next().unwrap().split(',').position(|one| one == name).unwrap_or_else(|| panic!("no column {name}"));
    lines.map(|line| line.split(',').nth(at).unwrap().parse().unwrap()).collect()
}

/// Off by default. On, every body has three columns more, and the others are the same to the byte; at rest the hammer's
/// pin and what else holds the hammer carry its weight; a figure shows them.
#[test]
fn reactions_are_columns_and_curves() {
    let folder = Folder::new("inside-reactions");
    let press = ["press", "--stroke", "f", "--duration", "0.1", "--out"];
    folder.good(&[&press[..], &["plain"]].concat());
    folder.good(&[&press[..], &["inside", "--reactions"]].concat());
    let (plain, inside) = (folder.read("plain/run.csv"), folder.read("inside/run.csv"));
    assert!(!plain.contains("_pin_x_N") && !folder.0.join("plain/reactions.svg").exists());
    for (short, long) in plain.lines().zip(inside.lines()) {
        assert!(long.starts_with(short) && long.split(',').count() == short.split(',').count() + 27);
    }
    // Newton's second law of the damper before it is touched: its weight, its rest's push and its pin's.
    let damper = erard::instrument::Instrument::builtin("concert-grand").unwrap();
    let weight = damper.bodies.iter().find(|body| body.name == "damper").unwrap().mass_kg * damper.gravity_m_per_s2;
    let up =
        column(&inside, "damper_pin_y_N")[0] + column(&inside, "damper_rest_N")[0] + column(&inside, "key_damper_N")[0];
    assert!((up - weight).abs() < 1e-6 * weight, "{up} {weight}");
    // The acceleration is what the angular velocity changes by.
    let (rate, alpha, time) =
        (column(&inside, "hammer_rad_per_s"), column(&inside, "hammer_rad_per_s2"), column(&inside, "time_s"));
    let step = time[1] - time[0];
    for n in 1..time.len() - 1 {
        let mean = (rate[n + 1] - rate[n - 1]) / (2.0 * step);
        assert!((alpha[n] - mean).abs() <= 1e-6 * (1.0 + mean.abs()), "{n}: {} {mean}", alpha[n]);
    }
    let svg = folder.read("inside/reactions.svg");
    assert!(svg.contains("pin, up (N)") && svg.contains("acceleration") && !svg.contains("NaN"));
}

/// A hand goes with adaptive steps, reactions, losses and sound: all of them in one press each with a rigid string and
/// with strings, which take fixed steps. The losses add up with the hand's own.
#[test]
fn a_hand_goes_with_all_that_looks_inside() {
    let folder = Folder::new("inside-hand");
    let press = ["press", "--hand=200", "--stroke", "mf", "--duration", "0.1", "--reactions", "--losses", "--out"];
    for (out, more) in
        [("rigid", &["--tolerance", "1e-3"][..]), ("strings", &["--instrument", "concert-grand-strings", "--wav"])]
    {
        let said = folder.good(&[&press[..], &[out], more].concat());
        assert!(said.contains("driven by a hand") && said.contains("where the energy goes"), "{said}");
        let table = folder.read(&format!("{out}/run.csv"));
        for name in ["hammer_pin_y_N", "force_N"] {
            let forces = column(&table, name);
            assert!(forces.iter().all(|x| x.is_finite()) && forces.iter().any(|x| *x != 0.0), "{out}: {name}");
        }
        adds_up(&folder, out);
    }
    assert!(folder.0.join("strings/note.wav").metadata().unwrap().len() > 1000);
}

/// The table of losses adds up to the summary's, part by part; where the error is controlled, too.
#[test]
#[ignore = "ci: losses of several runs"]
fn losses_add_up() {
    let folder = Folder::new("inside-losses");
    for controlled in [&[][..], &["--tolerance", "1e-6"]] {
        let press = ["press", "--stroke", "mf", "--losses", "--reactions", "--out", "press"];
        let said = folder.good(&[&press[..], controlled].concat());
        assert!(said.contains("where the energy goes"), "{said}");
        let table = folder.read("press/run.csv");
        assert!(column(&table, "hammer_pin_y_N").iter().all(|force| force.is_finite()), "{controlled:?}");
        adds_up(&folder, "press");
    }
    // With strings their own losses and those of each damper's felt stand among the others.
    folder.good(&[
        "press",
        "--stroke",
        "mf",
        "--losses",
        "--instrument",
        "concert-grand-strings",
        "--out",
        "press",
        "--force",
    ]);
    adds_up(&folder, "press");
    let losses: Value = serde_json::from_str(&folder.read("press/losses.json")).unwrap();
    let parts = losses["losses"].as_array().unwrap();
    let of = |name: &str| parts.iter().find(|one| one["name"] == name).unwrap()["loss_J"].as_f64().unwrap();
    assert!(of("strings") > 1e-4 && of("damper_left") > 1e-5 && of("rocking") > 0.0);
    // What the bridge takes stands by itself.
    println!("{} {} {} J", of("strings"), of("bridge"), of("rocking"));
    assert!(of("bridge") > 0.1 * of("strings"));
    // One that stands still takes nothing.
    let still = erard::instrument::Instrument::builtin_text("concert-grand-strings")
        .unwrap()
        .replace("\n[roles]\n", "\n[roles]\nrigid_bridge = true\n");
    std::fs::write(folder.0.join("still.toml"), still).unwrap();
    folder.good(&["press", "--stroke", "mf", "--losses", "--instrument", "still.toml", "--out", "press", "--force"]);
    adds_up(&folder, "press");
    let losses: Value = serde_json::from_str(&folder.read("press/losses.json")).unwrap();
    let parts = losses["losses"].as_array().unwrap();
    let of = |name: &str| parts.iter().find(|one| one["name"] == name).unwrap()["loss_J"].as_f64().unwrap();
    assert!(of("strings") > 0.0 && of("rocking") > 0.0 && !parts.iter().any(|one| one["name"] == "bridge"));
}

fn adds_up(folder: &Folder, out: &str) {
    let losses: Value = serde_json::from_str(&folder.read(&format!("{out}/losses.json"))).unwrap();
    let summary: Value = serde_json::from_str(&folder.read(&format!("{out}/summary.json"))).unwrap();
    let parts = losses["losses"].as_array().unwrap();
    let sum = |kind: &str, part: &str| -> f64 {
        parts.iter().filter(|one| one["kind"] == kind).map(|one| one[part].as_f64().unwrap()).sum()
    };
    for (kind, part, booked) in [
        ("pin", "dry_J", "pivot_dry"),
        ("pin", "viscous_or_felt_J", "pivot_viscous"),
        ("contact", "viscous_or_felt_J", "felt"),
        ("contact", "dry_J", "coulomb"),
        ("strings", "viscous_or_felt_J", "strings"),
    ] {
        let booked = summary["dissipated_J"][booked].as_f64().unwrap_or(0.0);
        assert!((sum(kind, part) - booked).abs() <= 1e-5 * booked, "{kind} {part}: {} {booked}", sum(kind, part));
    }
    let shares: f64 = parts.iter().map(|one| one["share"].as_f64().unwrap()).sum();
    assert!((shares - 1.0).abs() < 1e-9);
    let svg = folder.read(&format!("{out}/losses.svg"));
    assert!(svg.contains("lost so far (mJ)"), "areas stand on a linear axis");
    assert!(svg.contains("<polygon") && svg.contains("all others") && !svg.contains("NaN"));
}

/// Arrows of the pins: in the picture of a pose, and on the page of a run that recorded them; elsewhere none.
#[test]
fn pins_are_drawn() {
    let folder = Folder::new("inside-pins");
    folder.good(&["draw", "--at", "let-off", "--forces", "--out", "plain"]);
    folder.good(&["draw", "--at", "let-off", "--forces", "--reactions", "--out", "pins"]);
    let arrows = |name: &str, kind: &str| folder.read(name).matches(&format!("<path class=\"arrow {kind}\"")).count();
    assert_eq!(arrows("plain/action.svg", "pin"), 0);
    let grand = erard::instrument::Instrument::builtin("concert-grand").unwrap();
    let drawn = arrows("pins/action.svg", "pin");
    assert!(drawn >= 4 && drawn <= grand.bodies.len(), "{drawn}");
    assert_eq!(arrows("pins/action.svg", "contact"), arrows("plain/action.svg", "contact"));
    for (more, shown) in [(&[][..], false), (&["--reactions"], true)] {
        folder.good(&[&["press", "--duration", "0.05", "--out", "run"][..], more].concat());
        assert_eq!(folder.read("run/run.html").contains("id=\"pin-forces\""), shown);
    }
}

/// Sound under a name of one's own, and under note.wav where none is given: 48 kHz, with C4 in it. A folder, another
/// ending and a stroke's file are no names.
#[test]
fn sound_is_written_under_a_name() {
    let folder = Folder::new("inside-wav");
    let press = |duration_s| {
        ["press", "--instrument", "concert-grand-strings", "--duration", duration_s, "--out", "press", "--wav"]
    };
    let said = folder.good(&[&press("0.6")[..], &["mine.wav"]].concat());
    assert!(said.contains("mine.wav is the sound pressure 1 m before the board"), "{said}");
    let mut reader = hound::WavReader::open(folder.0.join("press/mine.wav")).unwrap();
    assert_eq!((reader.spec().sample_rate, reader.spec().channels), (48_000, 2));
    let samples: Vec<f64> = reader.samples::<i16>().map(|s| f64::from(s.unwrap())).collect();
    // A full scale is 10 Pa for all notes; scaled by its peak, the same sound is at 0.9 of it. The page plays the file.
    let largest = |samples: &[f64]| samples.iter().fold(0.0, |most: f64, x| most.max(x.abs())) / 32_767.0;
    let peak_pa: f64 =
        said.split("without a room, ").nth(1).and_then(|rest| rest.split(' ').next()).unwrap().parse().unwrap();
    assert!((10.0 * largest(&samples) - peak_pa).abs() < 2e-3, "{} {peak_pa}", 10.0 * largest(&samples));
    // A forte a metre before a piano is as loud as 80 to 100 dB: 0.2 to 2 Pa.
    let loud = samples.iter().map(|x| (10.0 * x / 32_767.0).powi(2)).sum::<f64>() / samples.len() as f64;
    println!("peak {peak_pa} Pa, {:.1} dB over the file", 10.0 * (loud / 4e-10).log10());
    let page = std::fs::read_to_string(folder.0.join("press/run.html")).unwrap();
    assert!(
        page.contains("<audio controls preload=\"none\" src=\"mine.wav\">") && page.contains("media-src 'self' file:")
    );
    folder.good(&[&press("0.6")[..], &["scaled.wav", "--wav-peak", "--force"]].concat());
    let scaled = hound::WavReader::open(folder.0.join("press/scaled.wav")).unwrap();
    let scaled: Vec<f64> = scaled.into_samples::<i16>().map(|s| f64::from(s.unwrap())).collect();
    assert!((largest(&scaled) - 0.9).abs() < 1e-4, "{}", largest(&scaled));
    let said = folder.bad(&["press", "--instrument", "concert-grand-strings", "--wav-peak"]);
    assert!(said.contains("--wav"), "{said}");
    // The last fifth of a second in Hann's window, so that what falls does not spread, against sines of both phases: C4
    // stands out from what lies a semitone beside it.
    let left: Vec<f64> = samples.iter().step_by(2).copied().collect();
    let right: Vec<f64> = samples.iter().skip(1).step_by(2).copied().collect();
    assert!(left != right && largest(&right) > 0.1 * largest(&left), "two places hear two things");
    let tail = &left[left.len() - 9600..];
    let part = |hz: f64| {
        let sum = |phase: f64| -> f64 {
            let turn = |n: usize| std::f64::consts::TAU * hz * n as f64 / 48e3 + phase;
            let window = |n: usize| 1.0 - (std::f64::consts::TAU * n as f64 / tail.len() as f64).cos();
            tail.iter().enumerate().map(|(n, x)| x * window(n) * turn(n).sin()).sum()
        };
        sum(0.0).hypot(sum(0.25 * std::f64::consts::TAU))
    };
    let c4_hz = 261.63;
    for beside_hz in [c4_hz * 0.944, c4_hz * 1.059] {
        assert!(part(c4_hz) > 10.0 * part(beside_hz), "{} {}", part(c4_hz), part(beside_hz));
    }
    folder.good(&[&press("0.1")[..], &["--force"]].concat());
    assert!(folder.0.join("press/note.wav").exists());
    for name in ["sub/note.wav", "stroke.csv", ".wav"] {
        let said = folder.bad(&[&press("0.6")[..], &[name]].concat());
        assert!(said.contains("expected a file name that ends in .wav"), "{said}");
    }
}
