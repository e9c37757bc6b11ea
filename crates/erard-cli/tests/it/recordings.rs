//! Recordings as laboratories have them: understood, prepared, compared, in one command.

use std::fmt::Write as _;
use std::path::Path;
use std::sync::LazyLock;

use crate::common::Folder;
use serde_json::Value;

/// What is put into the synthetic recording, in SI units.
const FORCE_NOISE_N: f64 = 0.03;
const POSITION_NOISE_M: f64 = 15e-6;
const FORCE_OFFSET_N: f64 = 0.21;
const POSITION_OFFSET_M: f64 = -1.3e-3;
const REST_S: f64 = 0.1;
const RATE_HZ: f64 = 20e3;
/// A gram's weight, N.
const GRAM_N: f64 = 9.806_65e-3;

/// Normal noise: the sum of twelve uniform numbers of a linear congruential generator.
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> f64 {
        let mut uniform = || {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (self.0 >> 11) as f64 / (1_u64 << 53) as f64
        };
        (0..12).map(|_| uniform()).sum::<f64>() - 6.0
    }
}

/// Time, force and key position of a run that `press` made with a fine step, sampled at 20 kHz, after a rest.
fn played() -> Vec<[f64; 3]> {
    static PLAYED: LazyLock<Vec<[f64; 3]>> = LazyLock::new(play);
    PLAYED.clone()
}

fn play() -> Vec<[f64; 3]> {
    let folder = Folder::new("recordings-played");
    folder.good(&["press", "--stroke", "f", "--drive", "force", "--dt", "1e-5", "--record-every", "5", "--out", "run"]);
    let table = folder.read("run/run.csv");
    let rest = (REST_S * RATE_HZ) as usize;
    let mut rows: Vec<[f64; 3]> = (0..rest).map(|n| [n as f64 / RATE_HZ, 0.0, 0.0]).collect();
    for line in table.lines().skip(1) {
        let cells: Vec<f64> = line.split(',').take(3).map(|cell| cell.parse().unwrap()).collect();
        rows.push([cells[0] + REST_S, cells[1], cells[2]]);
    }
    rows
}

/// The same as a laboratory would hand it over: milliseconds, millimetres, gram-force, semicolons, decimal commas,
/// offsets and noise.
fn handed_over(rows: &[[f64; 3]], sign: f64) -> String {
    let mut noise = Noise(1);
    let mut text = String::from("% rig 3, key 40\nTime (ms);Displacement (mm);F [gf]\n");
    for [t, f, y] in rows {
        let f = f + FORCE_OFFSET_N + FORCE_NOISE_N * noise.next();
        let y = sign * y + POSITION_OFFSET_M + POSITION_NOISE_M * noise.next();
        let row = format!("{:.3};{:.5};{:.4}\n", t * 1e3, y * 1e3, f / GRAM_N);
        text.push_str(&row.replace('.', ","));
    }
    text
}

fn report(folder: &Folder) -> Value {
    serde_json::from_str(&folder.read("erard-out-compare/compare.json")).unwrap()
}

fn explained(report: &Value, drive: &str, model: &str, quantity: &str) -> Option<f64> {
    let findings = report["findings"].as_array().unwrap();
    let found = findings.iter().find(|f| f["drive"] == drive && f["model"] == model && f["quantity"] == quantity);
    found.and_then(|f| f["errors"]["explained"].as_f64())
}

fn of<'a>(report: &'a Value, channel: &str) -> &'a Value {
    report["preparation"].as_array().unwrap().iter().find(|c| c["channel"] == channel).unwrap()
}

/// Noise, offsets, decimal commas and millimetres, compared in one command: offsets and noise are found as they were
/// put in, and the model that made it explains it under every drive, up to where its noise begins and not beyond.
#[test]
fn a_laboratory_s_recording_in_one_command() {
    let folder = Folder::new("recordings-lab");
    let rows = played();
    folder.file("lab.csv", &handed_over(&rows, 1.0));
    let said = folder.good(&["compare", "lab.csv"]);
    let found = report(&folder);
    for (channel, offset, noise) in
        [("force", FORCE_OFFSET_N, FORCE_NOISE_N), ("position", POSITION_OFFSET_M, POSITION_NOISE_M)]
    {
        let told = of(&found, channel);
        let near = |key: &str, wanted: f64, share: f64| {
            let value = told[key].as_f64().unwrap();
            assert!((value / wanted - 1.0).abs() < share, "{channel}: {key} is {value}, put in was {wanted}");
        };
        near("zero", offset, 0.01);
        near("noise_rms", noise, 0.1);
        near("rest_until_s", REST_S, 0.05);
        let tells = told["tells_to_Hz"].as_f64().unwrap();
        assert!((50.0..1000.0).contains(&tells) && told["low_pass_Hz"] == told["tells_to_Hz"], "{channel}: {tells} Hz");
    }
    for (drive, quantity) in [("force", "position"), ("motion", "force"), ("rigid", "force")] {
        let share = explained(&found, drive, "action", quantity).unwrap();
        assert!(share > 0.99 && share <= 1.0, "{drive}: {share}\n{said}");
    }
    // No share of what lies beyond is computed or printed.
    let told_to = found["findings"][0]["told_to_Hz"].as_f64().unwrap();
    for finding in found["findings"].as_array().unwrap() {
        for band in finding["errors"]["bands"].as_array().unwrap() {
            assert_eq!(band["told"].as_bool(), Some(band["to_Hz"].as_f64().unwrap() <= told_to));
        }
    }
    let by_frequency: Vec<&str> = said.lines().skip_while(|line| !line.contains("200-1000")).skip(1).collect();
    let by_frequency = &by_frequency[..by_frequency.iter().position(|line| line.trim().is_empty()).unwrap()];
    assert_eq!(by_frequency.len(), 6, "{said}");
    let untold = |line: &&str| line.split_whitespace().rev().take(2).all(|cell| cell == "-");
    assert!(by_frequency.iter().all(untold), "{said}");
    assert!(said.contains(&format!("up to {told_to:.0} Hz")), "{said}");
    // The conclusion comes first; how the recording was prepared, last. No line is wider than a terminal.
    let place = |words: &str| said.find(words).unwrap_or_else(|| panic!("{words}: {said}"));
    assert!(
        place("Variance explained") < place("driven by force") && place("driven by force") < place("zero:"),
        "{said}"
    );
    assert!(said.lines().all(|line| line.chars().count() <= 100), "{said}");
    // A part of each share is the rest before the touch, in the numbers too.
    let words = said.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(
        words.contains("of the variance) the action explains") && words.contains("without the rest before the touch"),
        "{said}"
    );
    let rest = &found["findings"][0]["errors"]["rest"];
    let number = |key: &str| rest[key].as_f64().unwrap();
    assert!((0.05..1.0).contains(&number("share_of_variance")) && number("explained_without") > 0.98, "{rest}");
    // The way up ends where the key is down.
    let whole_s = rows.last().unwrap()[0];
    folder.good(&["compare", "lab.csv", "--way-up", "--drive", "rigid", "--model", "action", "--no-pictures"]);
    let table = folder.read("erard-out-compare/compare.csv");
    let last: f64 = table.lines().last().unwrap().split(',').next().unwrap().parse().unwrap();
    assert!(last > REST_S && last < 0.8 * whole_s, "{last} of {whole_s}");

    // What is chosen is compared, and nothing else; pictures can be left out, and go with the run before.
    folder.good(&["compare", "lab.csv", "--drive", "rigid", "--model", "action", "--no-pictures"]);
    assert_eq!(report(&folder)["findings"].as_array().unwrap().len(), 1);
    assert!(!folder.0.join("erard-out-compare/compare.png").exists());
    assert!(
        folder
            .bad(&["compare", "lab.csv", "--columns", "force=none", "--drive", "force"])
            .contains("does not allow the chosen drives")
    );
}

/// What is wrong with a trace is noticed and said.
#[test]
#[ignore = "ci: a comparison for each fault"]
fn traces_that_are_wrong_are_noticed() {
    let folder = Folder::new("recordings-wrong");
    let rows = played();
    folder.file("up.csv", &handed_over(&rows, -1.0));
    let quick = ["--drive", "force", "--model", "action", "--no-pictures"];
    let compare = |arguments: &[&str]| folder.good(&[&["compare"], arguments, &quick[..]].concat());
    let said = compare(&["up.csv"]);
    assert!(said.contains("looks inverted") && said.contains("moves against"), "{said}");
    let said = folder.good(&["check", "up.csv"]);
    assert!(said.contains("the position goes up") && said.contains("looks inverted"), "{said}");
    // Turned, it is what it was.
    let said = compare(&["up.csv", "--invert", "position"]);
    assert!(!said.contains("looks inverted"), "{said}");
    assert!(explained(&report(&folder), "force", "action", "position").unwrap() > 0.99);

    folder.file("lab.csv", &handed_over(&rows, 1.0));
    let said = compare(&["lab.csv", "--zero", "off"]);
    assert!(said.contains("no zero was taken") && said.contains("position begins at -1."), "{said}");
    // A clean one without its beginning: the model tells.
    let clean = |late_s: f64, off_m: f64| {
        let mut text = String::from("time_s,force_N,position_m\n");
        let late = (late_s * RATE_HZ) as usize;
        for (n, [t, f, _]) in rows.iter().enumerate().skip(2000) {
            let [_, _, y] = rows[n - late];
            let _ = writeln!(text, "{t},{f},{}", y + off_m);
        }
        text
    };
    folder.file("off.csv", &clean(0.0, 1e-3));
    let said = compare(&["off.csv"]);
    let by = "the measured position differs from the simulated one by a constant +1.0";
    assert!(Folder::words(&said).contains(by), "{said}");
    folder.file("late.csv", &clean(0.004, 0.0));
    let said = compare(&["late.csv"]);
    let words = Folder::words(&said);
    assert!(words.contains("comes 4.0") && words.contains("earlier than measured"), "{said}");
    let said = compare(&["late.csv", "--delay", "position=4ms"]);
    assert!(!Folder::words(&said).contains("one clock"), "{said}");
    assert!(explained(&report(&folder), "force", "action", "position").unwrap() > 0.9999);
    for (option, value) in [
        ("--delay", "position=4"),
        ("--delay", "key=4ms"),
        ("--invert", "time"),
        ("--low-pass", "0"),
        ("--order", "11"),
    ] {
        let said = folder.bad(&["compare", "late.csv", option, value]);
        assert!(said.contains(option) && said.contains("expected"), "{option} {value}: {said}");
    }
    assert!(folder.bad(&["compare", "late.csv", "--low-pass", "12000"]).contains("20000 samples per second"));
    assert!(folder.bad(&["press", "--zero", "off"]).contains("need a stroke file"));
}

/// With `--zero off` every number of a recording stays as it is; with `--zero rest` the mean of the rest before the
/// touch is taken away, whatever it is. Where nothing is said, it is taken from what shows noise: a computed file has
/// no sensor.
#[test]
fn the_zero_is_left_where_it_is_not_wanted() {
    let folder = Folder::new("recordings-zero");
    let force = |t: f64| FORCE_OFFSET_N + 5.0 * ((t - REST_S) / 0.03).clamp(0.0, 1.0);
    let rows = (0..500).map(|n| f64::from(n) * 1e-3).map(|t| format!("{t},{}\n", force(t)));
    folder.file("lab.csv", &format!("time_s,force_N\n{}", rows.collect::<String>()));
    let first = |arguments: &[&str]| {
        let common = ["press", "lab.csv", "--low-pass", "off", "--duration", "0.05"];
        folder.good(&[&common, arguments].concat());
        let table = folder.read("erard-out/run.csv");
        let title = table.lines().next().unwrap().split(',').position(|title| title == "force_N").unwrap();
        table.lines().nth(1).unwrap().split(',').nth(title).unwrap().parse::<f64>().unwrap()
    };
    assert!((first(&[]) - FORCE_OFFSET_N).abs() < 1e-12);
    assert!(first(&["--zero", "rest"]).abs() < 1e-12);
    assert!((first(&["--zero", "off"]) - FORCE_OFFSET_N).abs() < 1e-12);
    let said = folder.bad(&["press", "lab.csv", "--zero", "on"]);
    assert!(said.contains("--zero") && said.contains("rest") && said.contains("off"), "{said}");
}

/// A run's own tables are strokes, the same ones; a key's trace gives the fingertip's where force was recorded too.
#[test]
#[ignore = "ci: runs compared with themselves, driven in every way"]
fn runs_are_strokes() {
    let folder = Folder::new("recordings-runs");
    folder.good(&[
        "press",
        "--stroke",
        "f",
        "--drive",
        "force",
        "--dt",
        "1e-5",
        "--record-every",
        "20",
        "--out",
        "run",
    ]);
    for file in ["run/run.csv", "run/run.parquet"] {
        let said = folder.good(&["check", file]);
        assert!(said.contains("`key_m`, in m, the key's") && said.contains("hammer_rise_m"), "{said}");
    }
    let speed = |arguments: &[&str]| {
        folder.good(&[&["press"], arguments].concat());
        let summary: Value = serde_json::from_str(&folder.read("erard-out/summary.json")).unwrap();
        summary["hammer_speed_m_per_s"].as_f64().unwrap()
    };
    let force = speed(&["run/run.csv"]);
    assert_eq!(force, speed(&["run/run.parquet"]));
    // Rigidly and through the fingertip the same blow as by the force that made it; read as the fingertip's, the key's
    // trace lags.
    let [motion, rigid, misread] =
        [&["--drive", "motion"][..], &["--drive", "rigid"], &["--drive", "motion", "--position", "fingertip"]]
            .map(|drive| speed(&[&["run/run.csv"], drive].concat()));
    assert!((motion / force - 1.0).abs() < 0.005, "{motion} {force}");
    assert!((rigid / force - 1.0).abs() < 0.005, "{rigid} {force}");
    assert!((misread / force - 1.0).abs() > 0.01, "{misread} {force}");
    // The other way round: imposed on the key, a fingertip's trace gives the key's first.
    folder.good(&["press", "run/run.parquet", "--columns", "position=key_m", "--drive", "rigid"]);

    // The key's alone is played as the key's own, and the fingertip's not as the key's.
    let table = folder.read("run/run.csv");
    let part: Vec<String> = table.lines().map(|l| [0, 2].map(|k| l.split(',').nth(k).unwrap()).join(",")).collect();
    folder.file("key.csv", &part.join("\n"));
    folder.good(&["press", "key.csv"]);
    assert!(folder.read("erard-out/summary.json").contains("\"drive\": \"rigid\""));
    folder.good(&["press", "key.csv", "--position", "fingertip"]);
    assert!(folder.read("erard-out/summary.json").contains("\"drive\": \"motion\""));
    let said = folder.bad(&["press", "key.csv", "--position", "fingertip", "--drive", "rigid"]);
    assert!(said.contains("needs the key's position"), "{said}");
}

/// Zstandard, as PyArrow 26 writes it: pages of both versions of the format, plain and by dictionary, several in a
/// column. Damaged, it is refused.
#[test]
fn zstandard_is_read() {
    let folder = Folder::new("recordings-zstandard");
    let rows = (0..300).map(|i| {
        let force = 5.0 * ((f64::from(i) - 40.0) / 30.0).clamp(0.0, 1.0);
        format!("{},{}\n", f64::from(i) * 1e-3, (force * 1e3).round() / 1e3)
    });
    folder.file("plain.csv", &format!("time_s,force_N\n{}", rows.collect::<String>()));
    let speed = |file: &str| {
        folder.good(&["press", file, "--duration", "0.25"]);
        let summary: Value = serde_json::from_str(&folder.read("erard-out/summary.json")).unwrap();
        summary["hammer_speed_m_per_s"].as_f64().unwrap()
    };
    let plain = speed("plain.csv");
    for name in ["pages-1.parquet", "pages-2.parquet"] {
        let stored = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/zstandard").join(name);
        let mut bytes = std::fs::read(stored).unwrap();
        std::fs::write(folder.0.join(name), &bytes).unwrap();
        assert_eq!(plain, speed(name), "{name}");
        let frame = bytes.windows(4).position(|four| four == [0x28, 0xb5, 0x2f, 0xfd]).expect("a frame of Zstandard");
        bytes[frame] = 0;
        std::fs::write(folder.0.join(name), &bytes).unwrap();
        let said = folder.bad(&["check", name]);
        assert!(said.contains(name) && said.contains("Parquet"), "{said}");
    }
}

/// A key that was measured behind its balance pin is compared there; a run would drive its front, and says so.
#[test]
fn the_back_of_a_key_is_compared() {
    let folder = Folder::new("recordings-back");
    let recorded = concat!(env!("CARGO_MANIFEST_DIR"), "/../erard-core/recordings/kawai-kg-3c-struck-1.csv");
    folder.file("struck.csv", &std::fs::read_to_string(recorded).unwrap());
    let arguments = ["compare", "struck.csv", "--drive", "rigid", "--model", "action", "--no-pictures", "--out"];
    let compared = |name: &str, position: &[&str]| {
        folder.good(&[&arguments[..], &[name], position].concat());
        let told: Value = serde_json::from_str(&folder.read(&format!("{name}/compare.json"))).unwrap();
        assert_eq!(told["position_of"], position.last().copied().unwrap_or("key"));
        folder.read(&format!("{name}/compare.csv"))
    };
    // The hammer moves otherwise.
    assert_ne!(compared("back", &["--position", "key-back"]), compared("front", &[]));
    for command in ["press", "draw"] {
        let said = folder.bad(&[command, "struck.csv", "--position", "key-back"]);
        assert!(
            said.contains("struck.csv") && said.contains("key's back") && said.contains("`erard compare`"),
            "{said}"
        );
    }
}

/// Damaged Parquet is refused with the file's name, and units that are not known with those that are.
#[test]
fn what_cannot_be_read() {
    let folder = Folder::new("recordings-bad");
    folder.good(&["press", "--duration", "0.01", "--out", "run"]);
    let whole = std::fs::read(folder.0.join("run/run.parquet")).unwrap();
    for (name, bytes) in [
        ("cut.parquet", &whole[..whole.len() / 2]),
        ("head.parquet", &whole[..4]),
        ("tail.parquet", &[&whole[..40], &whole[whole.len() - 8..]].concat()),
    ] {
        std::fs::write(folder.0.join(name), bytes).unwrap();
        for command in ["check", "press", "compare"] {
            let said = folder.bad(&[command, name]);
            assert!(said.contains(name) && said.contains("Parquet"), "{said}");
        }
    }
    folder.file("volts.csv", "time_s,Force (V)\n0,0\n1,1\n");
    let said = folder.bad(&["check", "volts.csv"]);
    assert!(said.contains("`V`") && said.contains("N, mN, cN, daN, kN, gf, kgf, lbf, ozf, dyn"), "{said}");
    folder.file("x.csv", "t,x,y\n0,0,1\n1,1,2\n");
    let said = folder.bad(&["check", "x.csv", "--columns", "time=t:s,position=x"]);
    assert!(said.contains("`x`") && said.contains("m, dm, cm, mm, um, nm, in, mil, ft"), "{said}");
    let said = folder.good(&["check", "x.csv", "--columns", "time=t:s,position=x:mm"]);
    assert!(said.contains("`x`, in mm") && said.contains("columns not used: `y`"), "{said}");
    // A column that is not used is named, and what to type for it reads it.
    folder.file("more.csv", "time_s,force_N,laser,room (C)\n0,0,0,20\n0.001,1,1,20\n0.002,2,2,20\n");
    let said = folder.good(&["check", "more.csv"]);
    assert!(said.contains("columns not used: `laser`, `room (C)`"), "{said}");
    assert!(said.contains("--columns 'position=laser:mm'"), "{said}");
    let said = folder.good(&["check", "more.csv", "--columns", "position=laser:mm"]);
    assert!(said.contains("`laser`, in mm") && said.contains("columns not used: `room (C)`"), "{said}");
    let said = folder.bad(&["check", "x.csv", "--columns", "weight=x"]);
    assert!(said.contains("--columns") && said.contains("Displacement (mm)"), "{said}");
}

/// What is said of columns belongs to the second stroke where that alone is a file, to both where both are, and each
/// can have its own.
#[test]
fn a_second_stroke_has_columns_too() {
    let folder = Folder::new("recordings-against");
    folder.file("a.csv", "when (ms),push (gf)\n0,0\n40,500\n200,500\n");
    folder.file("b.csv", "t (ms),weight (gf)\n0,0\n30,400\n200,400\n");
    let titles = |time: &str, force: &str| format!("time={time},force={force}");
    let (a, b) = (titles("when (ms)", "push (gf)"), titles("t (ms)", "weight (gf)"));
    let strokes = |arguments: &[&str]| -> serde_json::Value {
        folder.good(&[&["press", "--duration", "0.1", "--out", "out"], arguments].concat());
        serde_json::from_str(&folder.read("out/summary.json")).unwrap()
    };
    let peak = |both: &serde_json::Value, run: usize| both["runs"][run]["peak_force_N"].as_f64().unwrap();
    // 500 and 400 gram-forces.
    let newtons = [4.903_325, 3.922_66];
    let found = strokes(&["--stroke", "mf", "--against", "b.csv", "--columns", &b]);
    assert!((peak(&found, 1) - newtons[1]).abs() < 1e-6, "{}", peak(&found, 1));
    let found = strokes(&["a.csv", "--columns", &a, "--against", "b.csv", "--against-columns", &b]);
    for (run, newtons) in newtons.into_iter().enumerate() {
        assert!((peak(&found, run) - newtons).abs() < 1e-6, "{run}");
    }
    let found = strokes(&["a.csv", "--columns", &a, "--against", "a.csv"]);
    assert!((peak(&found, 1) - newtons[0]).abs() < 1e-6);
    // Options of recordings without a recording are refused as before.
    assert!(folder.bad(&["press", "--against", "f", "--columns", &a, "--out", "none"]).contains("need a stroke file"));
}

/// Summary and force of a run under a recorded position alone.
fn pressed(folder: &Folder, arguments: &[&str]) -> (Value, Vec<f64>) {
    folder.good(&[&["press"], arguments, &["--out", "pressed", "--force"]].concat());
    let force = |line: &str| line.split(',').nth(1).unwrap().parse().unwrap();
    let force_n = folder.read("pressed/run.csv").lines().skip(1).map(force).collect();
    (serde_json::from_str(&folder.read("pressed/summary.json")).unwrap(), force_n)
}

/// Rows of time and position, m.
fn positions(rows: &[[f64; 3]], mut at: impl FnMut(f64) -> f64) -> String {
    let mut text = String::from("time_s,position_m\n");
    for [t, _, y] in rows {
        let _ = writeln!(text, "{t},{:.9}", at(*y));
    }
    text
}

/// A position without a rest that begins off its zero: the warning says what to type, and what is typed undoes it.
#[test]
fn what_a_warning_says_of_a_zero_can_be_typed() {
    let folder = Folder::new("recordings-zero");
    let rows = played();
    let moving = &rows[(REST_S * RATE_HZ) as usize + 300..];
    let begins_m = moving[0][2];
    folder.file("true.csv", &positions(moving, |y| y - begins_m));
    folder.file("off.csv", &positions(moving, |y| y - begins_m + 0.4e-3));
    let said = Folder::words(&folder.good(&["check", "off.csv"]));
    let typed = said.split("--zero ").nth(1).and_then(|rest| rest.split(' ').next()).unwrap();
    assert_eq!(typed, "position=0.4000mm");
    let quick = ["--duration", "0.15", "--record-every", "1"];
    let [right, off, zeroed] = [&["true.csv"][..], &["off.csv"], &["off.csv", "--zero", typed]]
        .map(|arguments| pressed(&folder, &[arguments, &quick].concat()).0["hammer_speed_m_per_s"].as_f64().unwrap());
    assert!((zeroed - right).abs() < 1e-6 && (off - right).abs() > 0.01, "{right} {off} {zeroed}");
    let said = folder.bad(&["press", "off.csv", "--zero", "hammer=1mm"]);
    assert!(said.contains("--zero hammer: off.csv does not have this channel"), "{said}");
}

/// What a run says that its force is worth under a recorded key is how far it is from the force under the true motion.
#[test]
fn a_recorded_key_says_what_its_force_is_worth() {
    let folder = Folder::new("recordings-worth");
    let rows = played();
    let mut noise = Noise(5);
    folder.file("true.csv", &positions(&rows, |y| y));
    folder.file("noisy.csv", &positions(&rows, |y| y + 2e-6 * noise.next()));
    // One filter for both: what a filter takes from the motion is no noise.
    let quick = ["--duration", "0.25", "--record-every", "1", "--low-pass", "1000"];
    let right_n = pressed(&folder, &[&["true.csv"], &quick[..]].concat()).1;
    let by_force = pressed(&folder, &["--stroke", "f", "--drive", "force", "--duration", "0.05"]).0;
    assert_eq!(by_force["force_worth"], Value::Null);
    let (noisy, force_n) = pressed(&folder, &[&["noisy.csv"], &quick[..]].concat());
    let worth = |key: &str| noisy["force_worth"][key].as_f64().unwrap();
    assert!((worth("position_noise_m") - 2e-6).abs() < 0.2e-6, "{noisy}");
    let rest = (REST_S * RATE_HZ) as usize;
    let off: Vec<f64> = right_n.iter().zip(&force_n).skip(rest).map(|(a, b)| (a - b).abs()).collect();
    let rms = (off.iter().map(|x| x * x).sum::<f64>() / off.len() as f64).sqrt();
    let ratio = rms / worth("force_rms_N");
    assert!((0.5..2.0).contains(&ratio), "{rms} N off, {} N said", worth("force_rms_N"));
    let within = off.iter().filter(|x| **x <= worth("force_within_95_N")).count() as f64 / off.len() as f64;
    assert!(within > 0.8, "{within}");
}

/// A computed force, 5 N for 0.1 s and then 8 N, has no sensor whose zero could be 5 N: it plays as it is, the run says
/// so, and names the option for the other case.
#[test]
fn a_computed_force_has_no_zero() {
    let folder = Folder::new("recordings-computed");
    let rows = (0..300).map(|n| format!("{},{}\n", f64::from(n) * 1e-3, if n < 100 { 5 } else { 8 }));
    folder.file("force.csv", &format!("time_s,force_N\n{}", rows.collect::<String>()));
    let output = folder.erard(&["press", "force.csv"]);
    let said = Folder::words(&String::from_utf8(output.stderr).unwrap());
    assert!(said.contains("computed, not measured") && said.contains("--zero force=5.0000N"), "{said}");
    let summary: Value = serde_json::from_str(&folder.read("erard-out/summary.json")).unwrap();
    let speed = summary["hammer_speed_m_per_s"].as_f64().unwrap();
    assert!(speed > 2.0, "{speed}");
    folder.good(&["press", "force.csv", "--zero", "force=5N"]);
    let summary: Value = serde_json::from_str(&folder.read("erard-out/summary.json")).unwrap();
    assert!(summary["hammer_speed_m_per_s"].as_f64().is_none_or(|zeroed| zeroed < 0.9 * speed), "{summary}");
}

/// What was done to a recording stands in the results of every command that plays it, as in `compare.json`: its zero,
/// the clock on which it was resampled, its low-pass. A computed force was left alone, and that stands there, too.
#[test]
fn results_hold_what_was_done_to_a_recording() {
    let folder = Folder::new("recordings-preparation");
    let mut noise = Noise(3);
    let force = |t: f64| if t < 0.1 { 0.0 } else { 6.0 * ((t - 0.1) / 0.02).min(1.0) };
    // A clock of 4 kHz whose instants are up to a third of a step late.
    let text: String = (0..1200).fold("time_s,force_N\n".into(), |mut text, n| {
        let t = (f64::from(n) + 0.33 * f64::from(n % 7) / 6.0) / 4000.0;
        let _ = writeln!(text, "{t:.7},{:.6}", force(t) + 0.12 + 0.02 * noise.next());
        text
    });
    folder.file("noisy.csv", &text);
    let rows = (0..300).map(|n| format!("{},{}\n", f64::from(n) * 1e-3, if n < 100 { 5 } else { 8 }));
    folder.file("computed.csv", &format!("time_s,force_N\n{}", rows.collect::<String>()));
    let json = |name: &str| -> Value { serde_json::from_str(&folder.read(name)).unwrap() };
    let of = |name: &str| -> Value {
        let made_by = json(name)["made_by"].clone();
        let sources = made_by["sources"].as_array().unwrap();
        sources.iter().find(|source| source["kind"] == "recording").unwrap()["preparation"].clone()
    };
    let output = folder.erard(&["press", "noisy.csv", "--duration", "0.2", "--out", "run"]);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success() && said.contains("resampled: evenly at") && said.contains("low-pass"), "{said}");
    let study = ["study", "noisy.csv", "--vary", "let_off=+0mm,0.1mm", "--duration", "0.2", "--out", "study"];
    folder.good(&study);
    folder.good(&["compare", "noisy.csv", "--model", "one-dof", "--no-pictures", "--out", "compared"]);
    let done = of("run/summary.json");
    assert_eq!(done, of("run/run.csv-metadata.json"));
    assert_eq!(done, of("study/study.csv-metadata.json"));
    assert_eq!(done, json("compared/compare.json")["preparation"]);
    let [channel] = &done.as_array().unwrap()[..] else { panic!("{done}") };
    // The mean of some 400 samples of rest is off by a twentieth of their noise; allow four times that.
    let zero = channel["zero"].as_f64().unwrap();
    assert!((zero - 0.12).abs() < 4.0 * 0.02 / 20.0, "{channel}");
    // The deviation of 400 samples scatters by 3.5 %; allow four times that. Straight lines would average it to 0.8.
    let noise_n = channel["noise_rms"].as_f64().unwrap();
    assert!((0.86 * 0.02..1.14 * 0.02).contains(&noise_n), "{channel}");
    // The even clock is as fine as the usual step: six of seven are longer than the mean.
    let rate_hz = channel["resampled_Hz"].as_f64().unwrap();
    let usual_hz = 4000.0 / (1.0 + 0.33 / 6.0);
    assert!((rate_hz - usual_hz).abs() < 0.01 * usual_hz, "{channel}");
    assert!(channel["low_pass_Hz"].as_f64().is_some_and(|hz| hz < 0.5 * rate_hz), "{channel}");
    folder.good(&["press", "computed.csv", "--duration", "0.2", "--out", "computed"]);
    let done = of("computed/summary.json");
    for key in ["zero", "resampled_Hz", "low_pass_Hz"] {
        assert!(done[0][key].is_null(), "{key}: {done}");
    }
}
