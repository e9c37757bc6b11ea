//! `erard kinematics` as a user runs it: what it writes, and what it says when it cannot.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use serde_json::{Value, json};

use crate::common::Folder;
use crate::common::schema::faults;

const COLUMNS: &str = "case,key_mm,key_rad,whippen_rad,hammer_rad,s1_mm,s2_mm,capstan_sliding_mm,knuckle_sliding_mm,\
                       hammer_mm,leverage";
const MOVES: [&str; 4] = ["--move", "capstan=-10mm", "--move", "knuckle=-3mm"];

/// Rows by case, in order: key_mm, key_rad, ... as in the header.
fn rows(folder: &Path) -> BTreeMap<String, Vec<Vec<f64>>> {
    let text = fs::read_to_string(folder.join("kinematics.csv")).unwrap();
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some(COLUMNS));
    let mut cases = BTreeMap::<String, Vec<Vec<f64>>>::new();
    for line in lines {
        let (case, numbers) = line.split_once(',').unwrap();
        cases.entry(case.to_owned()).or_default().push(numbers.split(',').map(|n| n.parse().unwrap()).collect());
    }
    cases
}

fn column(name: &str) -> usize {
    COLUMNS.split(',').position(|column| column == name).unwrap() - 1
}

fn values(rows: &[Vec<f64>], name: &str) -> Vec<f64> {
    rows.iter().map(|row| row[column(name)]).collect()
}

fn most(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |most, x| x.abs().max(most))
}

fn summary(folder: &Path) -> Value {
    serde_json::from_str(&fs::read_to_string(folder.join("summary.json")).unwrap()).unwrap()
}

/// A linkage file of bare numbers.
const C7F: &str = r#"kind = "three-lever"
[lengths_mm]
L1 = 205.23
L2 = 28.32
L3 = -63.00
L4 = 16.18
L5 = 44.50
L6 = 92.80
L7 = -48.37
L8 = 18.0
L9 = 9.8
L10 = 63.60
[key]
front_mm = 265.0
rest_deg = 90.0
[hammer]
head_mm = [130.0, 48.0]
"#;

/// An independent solution gave leverage 6.27 / 5.61 / 5.13 / 4.75 at key 1.25 / 3.25 / 5.25 / 7.25 mm, as head rise
/// over key travel in steps of 1 mm, and 0.07 mm and 0.82 mm of sliding: the table has each to its last digit, from the
/// built-in set and from a file.
#[test]
fn the_known_numbers() {
    let folder = Folder::for_command("kinematics", "known");
    folder.file("c7f.toml", C7F);
    for levers in ["c7f-like", "c7f.toml"] {
        folder.good(&[levers, "--from-travel", "0.75", "--to-travel", "7.75", "--steps", "7"]);
        let out = folder.0.join("erard-out-kinematics");
        let unmoved = &rows(&out)["unmoved"];
        let [key, head, leverage] = ["key_mm", "hammer_mm", "leverage"].map(|name| values(unmoved, name));
        for (step, expected) in [(0, 6.27), (2, 5.61), (4, 5.13), (6, 4.75)] {
            let ratio = (head[step + 1] - head[step]) / (key[step + 1] - key[step]);
            println!("key {:.2} mm: leverage {ratio:.4}", 0.5 * (key[step] + key[step + 1]));
            assert!((ratio - expected).abs() < 0.005, "{ratio} {expected}");
            assert!(leverage[step] > ratio && ratio > leverage[step + 1], "it falls through the step");
        }
        let millimetres = fs::read(out.join("kinematics.csv")).unwrap();
        folder.good(&[levers, "--from-travel", "0.075 cm", "--to-travel", "7.75mm", "--steps", "7"]);
        assert_eq!(fs::read(out.join("kinematics.csv")).unwrap(), millimetres, "units may be typed");
        folder.good(&[levers]);
        let (rows, summary) = (rows(&out), summary(&out));
        let unmoved = &rows["unmoved"];
        assert_eq!(unmoved.len(), 201);
        let sliding = [most(&values(unmoved, "capstan_sliding_mm")), most(&values(unmoved, "knuckle_sliding_mm"))];
        println!("sliding {sliding:?} mm");
        assert!((sliding[0] - 0.07).abs() < 0.005 && (sliding[1] - 0.82).abs() < 0.005);
        let case = &summary["cases"][0];
        assert!((case["capstan_sliding_mm"].as_f64().unwrap() - sliding[0]).abs() < 1e-4);
        assert!((case["knuckle_sliding_mm"].as_f64().unwrap() - sliding[1]).abs() < 1e-4);
        assert!((case["lever_arm_product"].as_f64().unwrap() - 5.27).abs() < 0.005);
        assert!(case["largest_residual"].as_f64().unwrap() < 1e-12);
        // The columns are what they say: slidings are changes of S1 and S2, k grows from its rest.
        let first = &unmoved[0];
        for row in unmoved {
            for (place, sliding) in [("s1_mm", "capstan_sliding_mm"), ("s2_mm", "knuckle_sliding_mm")] {
                let change = row[column(place)] - first[column(place)];
                assert!((change - row[column(sliding)]).abs() < 1e-9);
            }
            let turned = row[column("key_rad")] - std::f64::consts::FRAC_PI_2;
            assert!((turned * 265.0 - row[column("key_mm")]).abs() < 1e-9);
        }
        assert!((first[column("s1_mm")] + 142.23).abs() < 0.01 && (first[column("s2_mm")] - 79.09).abs() < 0.01);
    }
}

/// The papers' claims, with lengths and with an instrument's discs: leverage falls through the stroke in all three
/// cases, is lower with the capstan 10 mm toward the player, higher with the knuckle 3 mm in; the capstan slides far
/// less than the knuckle. Figures and summary are there.
#[test]
fn three_cases() {
    let folder = Folder::for_command("kinematics", "cases");
    for (levers, figures) in [
        (&["c7f-like"][..], &["sliding", "leverage"][..]),
        (&["steinway-o-like"], &["sliding", "leverage"]),
        (&["--instrument", "concert-grand"], &["sliding", "leverage", "leverage-dynamics"]),
        (&[], &["sliding", "leverage", "leverage-dynamics"]),
    ] {
        let printed = folder.good(&[levers, &MOVES].concat());
        assert!(printed.contains("as it is") && printed.contains("capstan −10 mm"), "{printed}");
        let out = folder.0.join("erard-out-kinematics");
        let cases = rows(&out);
        let names: Vec<&str> = cases.keys().map(String::as_str).collect();
        assert_eq!(names, ["capstan=-10mm", "knuckle=-3mm", "unmoved"]);
        let leverage = |case: &str| values(&cases[case], "leverage");
        for case in &names {
            assert!(leverage(case).windows(2).all(|two| two[1] < two[0]), "{levers:?} {case}: it falls");
            let sliding = ["capstan_sliding_mm", "knuckle_sliding_mm"].map(|name| most(&values(&cases[*case], name)));
            println!("{levers:?} {case}: sliding {sliding:?} mm");
            assert!(sliding[0] < 0.3 * sliding[1], "{levers:?} {case} {sliding:?}");
        }
        for ((capstan, knuckle), unmoved) in
            leverage("capstan=-10mm").iter().zip(leverage("knuckle=-3mm")).zip(leverage("unmoved"))
        {
            assert!(*capstan < 0.9 * unmoved && knuckle > 1.1 * unmoved, "{levers:?}");
        }
        for figure in figures {
            let svg = fs::read_to_string(out.join(format!("{figure}.svg"))).unwrap();
            assert!(svg.starts_with("<svg") && svg.contains("mm)") && !svg.contains("NaN"));
            assert!(fs::read(out.join(format!("{figure}.png"))).unwrap().starts_with(b"\x89PNG"));
        }
        fs::remove_dir_all(&out).unwrap();
    }
}

/// Regulation keeps the hammer's rest; without it the hammer rests lower when the knuckle moves in.
#[test]
fn regulation() {
    let folder = Folder::for_command("kinematics", "regulation");
    let rest = |arguments: &[&str]| {
        folder.good(arguments);
        let cases = rows(&folder.0.join("erard-out-kinematics"));
        ["unmoved", "knuckle=-3mm"].map(|case| cases[case][0][column("hammer_rad")])
    };
    let [unmoved, moved] = rest(&["c7f-like", "--move", "knuckle=-3mm"]);
    assert!((unmoved - moved).abs() < 1e-12);
    let [unmoved, moved] = rest(&["c7f-like", "--move", "knuckle=-3mm", "--no-regulate"]);
    assert!(moved < unmoved - 0.05);
    assert_eq!(summary(&folder.0.join("erard-out-kinematics"))["regulated"], false);
}

/// The slow press of the same instrument's dynamic model agrees within 2 %, from half a millimetre of key travel to the
/// jack's contact with its button at 5.5 mm.
#[test]
fn dynamics() {
    let folder = Folder::for_command("kinematics", "dynamics");
    let printed = folder.good(&["--instrument", "concert-grand-rigid", "--out", "here"]);
    assert!(printed.contains("A slow press of the dynamic model has the same leverage within"), "{printed}");
    let dynamics = &summary(&folder.0.join("here"))["dynamics"];
    println!("{dynamics}");
    assert!(dynamics["largest_deviation"].as_f64().unwrap() < 0.02);
    assert!(dynamics["from_key_mm"].as_f64().unwrap() < 0.6 && dynamics["to_key_mm"].as_f64().unwrap() > 5.0);
}

/// The papers' equations (1) to (4), in print and as LaTeX, and nothing is written.
#[test]
fn equations() {
    let folder = Folder::for_command("kinematics", "equations");
    let paper = [
        "L2 cos k - L3 cos w - L4 sin w - S1 sin k - L1 = 0",
        "L2 sin k - L3 sin w + L4 cos w + S1 cos k - L5 = 0",
        "L8 cos h - L7 sin w + L9 sin h + S2 cos w - L6 = 0",
        "L8 sin h + L7 cos w - L9 cos h + S2 sin w + L10 = 0",
    ];
    for arguments in [&["--equations"][..], &["c7f-like", "--equations"]] {
        let printed = folder.good(arguments);
        assert!(paper.iter().all(|equation| printed.contains(equation)), "{printed}");
    }
    let instrument = folder.good(&["--instrument", "concert-grand", "--equations"]);
    assert!(instrument.contains("C1 cos k - C2 sin k") && !instrument.contains(paper[0]), "{instrument}");
    let latex = folder.good(&["c7f-like", "--equations", "--latex"]);
    assert!(latex.starts_with("\\begin{align}") && latex.contains("L_{2} \\cos k"), "{latex}");
    let answer: Value = serde_json::from_str(&folder.good(&["c7f-like", "--equations", "--json"])).unwrap();
    assert!(paper.iter().all(|equation| answer["text"].as_str().unwrap().contains(equation)), "{answer}");
    assert!(!folder.0.join("erard-out-kinematics").exists());
}

/// Pressed farther than the levers reach, the command names the key position, keeps what it has and ends with code 1:
/// files are written.
#[test]
fn unreachable() {
    let folder = Folder::for_command("kinematics", "unreachable");
    let output = folder.erard(&["c7f-like", "--to-travel", "60", "--steps", "60", "--move", "capstan=-10mm"]);
    let told = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1));
    assert!(told.contains("unmoved: the levers stop at key 41.636 mm of 60 mm"), "{told}");
    assert!(told.contains("capstan=-10mm: the levers stop at key 50.9"), "{told}");
    let out = folder.0.join("erard-out-kinematics");
    let cases = rows(&out);
    assert_eq!((cases["unmoved"].len(), cases["capstan=-10mm"].len()), (42, 51));
    assert!(out.join("leverage.png").exists());
    assert!((summary(&out)["cases"][0]["stopped_at_key_mm"].as_f64().unwrap() - 41.636).abs() < 1e-3);
    fs::remove_dir_all(&out).unwrap();

    // A case that cannot even rest is reported, and the others are kept.
    let output = folder.erard(&["c7f-like", "--move", "jack-height=150mm", "--move", "knuckle=-3mm"]);
    let told = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1));
    assert!(
        told.contains("jack-height=150mm: the levers stop at key 0.000 mm, at rest: the knuckle contact"),
        "{told}"
    );
    let names: Vec<String> = rows(&out).into_keys().collect();
    assert_eq!(names, ["knuckle=-3mm", "unmoved"]);
    fs::remove_dir_all(&out).unwrap();

    // Levers that cannot rest at all leave nothing.
    folder.file("far.toml", &C7F.replace("L2 = 28.32", "L2 = 200"));
    let told = folder.bad(&["far.toml"]);
    assert!(told.contains("far.toml: the capstan contact cannot be made"), "{told}");
}

/// Wrong arguments: one message, code 2, nothing written.
#[test]
fn bad_arguments() {
    let folder = Folder::for_command("kinematics", "arguments");
    for (arguments, told) in [
        (&["--move", "pedal=1mm"][..], "unknown part `pedal`"),
        (&["--move", "capstan=-10"], "without a unit; type for example `-10mm`"),
        (&["--move", "capstan=nanmm"], "expected a length"),
        (&["--move", "capstan=1mm", "--move", "capstan=1.0mm"], "given twice"),
        (&["--steps", "0"], "--steps 0: expected a number from 1"),
        (&["--steps", "-5"], "--steps -5: expected a number from 1"),
        (&["--from-travel", "5", "--to-travel", "3"], "expected --to-travel to be larger"),
        (&["--from-travel", "3", "--to-travel", "3"], "expected --to-travel to be larger"),
        (&["--from-travel", "NaN"], "expected a length"),
        (&["--to-travel", "inf"], "expected a length"),
        (&["--to-travel", "2m"], "--to-travel 2000: expected a number of at most 1000 mm"),
        (&["--to-travel", "ten"], "invalid value 'ten'"),
        (&["--from-travel", "9"], "let-off, 5.74 mm"),
        (&["c7f-like", "--instrument", "concert-grand"], "cannot be used with"),
        (&["concert-grand"], "`concert-grand` is an instrument: --instrument concert-grand"),
        (&["d-like"], "no built-in linkage `d-like` (built in: c7f-like, steinway-o-like)"),
        (&["nowhere.toml"], "nowhere.toml: cannot be read"),
        (&["--instrument", "c7f-like"], "no built-in instrument `c7f-like`"),
        (&["--equations", "--to-travel", "5"], "cannot be used with"),
        (&["--latex"], "--equations"),
    ] {
        let error = folder.bad(arguments);
        assert!(error.contains(told), "{arguments:?}: {error}");
        assert!(!error.contains("panicked"), "{error}");
    }
    folder.file("taken", "a file where a folder should be");
    let error = folder.bad(&["c7f-like", "--out", "taken/here"]);
    assert!(error.contains("cannot be written"), "{error}");
}

/// Wrong files: the file, the line and the key are named.
#[test]
fn bad_files() {
    let folder = Folder::for_command("kinematics", "files");
    for (text, told) in [
        (C7F.replace("L7 = -48.37\n", ""), &["bad.toml:2:1", "`lengths_mm.L7`", "missing", "a length in mm"][..]),
        (C7F.replace("L7 = -48.37", "L7 = \"-48.37\""), &["bad.toml:9", "`lengths_mm.L7`", "a number"]),
        (C7F.replace("L7 = -48.37", "L7 = nan"), &["`lengths_mm.L7`", "not a finite number"]),
        (C7F.replace("L7 = -48.37", "L7 = 1e9"), &["`lengths_mm.L7`", "too large"]),
        (C7F.replace("L7 = -48.37", "L7 = "), &["bad.toml:9", "`L7`", "no value"]),
        (C7F.replace("L10 = 63.60", "L10 = 63.60\nL11 = 1"), &["`lengths_mm.L11`", "unknown key"]),
        (C7F.replace("front_mm = 265.0", "front_mm = -265.0"), &["`key.front_mm`", "must not be negative"]),
        (C7F.replace("front_mm = 265.0", "front = 265.0"), &["`key.front`", "expected `front_mm`"]),
        (C7F.replace("[130.0, 48.0]", "[130.0]"), &["`hammer.head_mm`", "two numbers"]),
        (C7F.replace("three-lever", "four-lever"), &["bad.toml:1:8", "`kind`", "\"three-lever\""]),
        (C7F.replace("kind = \"three-lever\"\n", ""), &["`kind` is missing", "three-lever"]),
        (C7F.replace("[hammer]\nhead_mm = [130.0, 48.0]\n", ""), &["`hammer` is missing", "a table [hammer]"]),
        (format!("{C7F}[regulation]\nlet_off_mm = 50\n"), &["`regulation.let_off_mm`", "below the blow, 46 mm"]),
        (String::new(), &["bad.toml: the file is empty", "kind = \"three-lever\""]),
        ("\u{0}\u{1}".to_owned(), &["bad.toml:1"]),
        ("format = \"erard-instrument/1\"\n".to_owned(), &["belongs to an instrument"]),
    ] {
        folder.file("bad.toml", &text);
        let error = folder.bad(&["bad.toml"]);
        assert!(told.iter().all(|told| error.contains(told)), "{told:?}: {error}");
    }
    fs::write(folder.0.join("bad.toml"), b"kind = \"\xff\"").unwrap();
    assert!(folder.bad(&["bad.toml"]).contains("not UTF-8"));
    folder.file(
        "clock.toml",
        "format = \"erard-instrument/1\"\nname = \"clock\"\ngravity_m_s2 = 9.81\n[[body]]\nname = \"key\"\npivot_mm = [0, 0]\n\
         mass_g = 1\ninertia_kg_m2 = 1e-6\ncenter_of_mass_mm = [0, -1]\n[roles]\nkey = \"key\"\nkey_front_mm = [-10, 0]\n\
         [finger]\nstiffness_N_per_m = 1e4\ndamping_N_s_per_m = 1\n",
    );
    let error = folder.bad(&["--instrument", "clock.toml"]);
    assert!(error.contains("the instrument has no three levers: `roles` names no hammer"), "{error}");
}

/// The answers with `--json` have what the schema requires, of the types that it says, and name the program's own
/// command and the file that they were made from.
#[test]
fn answers_have_their_schema() {
    let folder = Folder::for_command("kinematics", "json");
    let home = concat!(env!("CARGO_MANIFEST_DIR"), "/schemas/kinematics.schema.json");
    let schema: Value = serde_json::from_str(&fs::read_to_string(home).unwrap()).unwrap();
    for arguments in
        [&["--steps", "20"][..], &["--instrument", "concert-grand", "--steps", "20", "--move", "capstan=-5mm"]]
    {
        let answer: Value = serde_json::from_str(&folder.good(&[arguments, &["--json"]].concat())).unwrap();
        let mut fields = answer.clone();
        let written = fields.as_object_mut().unwrap().remove("written").unwrap();
        assert_eq!(fields, summary(&folder.0.join("erard-out-kinematics")));
        assert!(written.as_array().unwrap().contains(&json!("erard-out-kinematics/summary.json")), "{written}");
        let mut found = Vec::new();
        faults(&answer, &schema, "", &mut found);
        assert!(found.is_empty(), "{arguments:?}: {found:#?}");
        faults(&Value::Object(serde_json::Map::new()), &schema, "", &mut found);
        assert!(!found.is_empty(), "{arguments:?}: an empty object conforms");
        let made_by = &answer["made_by"];
        assert!(made_by["command"].as_str().unwrap().starts_with("erard kinematics "), "{made_by}");
        let source = &made_by["sources"][0];
        assert!(source["name"].as_str().unwrap().starts_with("Concert grand"), "{source}");
        assert_eq!(source["sha256"].as_str().map(str::len), Some(64), "{source}");
    }
    let units = folder.read("erard-out-kinematics/kinematics.csv-metadata.json");
    assert!(units.contains("knuckle_sliding_mm") && units.contains("sha256"), "{units}");
}

/// What is built in is listed, printed as the file that it is, and checked; the project's own files are sound.
#[test]
fn built_in_linkages() {
    let folder = Folder::for_command("kinematics", "list");
    let listed = folder.good(&["--list"]);
    for name in ["c7f-like", "steinway-o-like"] {
        assert!(listed.contains(name), "{listed}");
        folder.file("it.toml", &folder.good(&[name, "--print"]));
        for asked in
            [name, "it.toml", &format!("{}/../erard-kinematics/linkages/{name}.toml", env!("CARGO_MANIFEST_DIR"))]
        {
            let said = folder.good(&[asked, "--check-file"]).split_whitespace().collect::<Vec<_>>().join(" ");
            assert!(said.contains("a linkage") && said.contains("reach each other at rest"), "{said}");
        }
    }
    let answer: Value = serde_json::from_str(&folder.good(&["--list", "--json"])).unwrap();
    assert_eq!(answer["built_in"][0]["kind"], "linkage", "{answer}");
    let answer: Value = serde_json::from_str(&folder.good(&["c7f-like", "--check-file", "--json"])).unwrap();
    assert_eq!(answer["kind"], "linkage", "{answer}");
    assert_eq!(folder.names(), ["it.toml"]);
    assert!(folder.bad(&["it.toml", "--print"]).contains("built in: c7f-like"));
    assert!(folder.bad(&["--check-file"]).contains("LINKAGE.toml"));
}

/// Results of another command are not replaced, and neither are one's own where there is nothing to show.
#[test]
fn nothing_is_lost() {
    let folder = Folder::for_command("kinematics", "lost");
    let press = folder.any_command(&["press", "--duration", "0.005"]).output().unwrap();
    assert!(press.status.success(), "{}", String::from_utf8_lossy(&press.stderr));
    folder.good(&["c7f-like", "--steps", "5"]);
    folder.good(&["c7f-like", "--steps", "6"]);
    let before = [folder.read("erard-out/summary.json"), folder.read("erard-out-kinematics/summary.json")];
    let error = folder.bad(&["c7f-like", "--out", "erard-out"]);
    assert!(error.contains("summary.json: is a result of `erard press`"), "{error}");
    assert!(folder.bad(&["--from-travel", "999", "--to-travel", "1000"]).contains("no pose is reached"));
    assert_eq!(before, [folder.read("erard-out/summary.json"), folder.read("erard-out-kinematics/summary.json")]);
}

/// Files over their limits and devices without end are refused after the limit is read, and so are more poses than can
/// be held, with the option that helps.
#[cfg(target_os = "linux")]
#[test]
fn limits() {
    let folder = Folder::for_command("kinematics", "limits");
    fs::File::create(folder.0.join("big.toml")).unwrap().set_len(3 << 30).unwrap();
    for arguments in [&["big.toml"][..], &["--instrument", "/dev/zero"]] {
        assert!(folder.bad(arguments).contains("larger than 4 MiB"), "{arguments:?}");
    }
    let error = folder.bad(&["c7f-like", "--steps", "1000000", "--move", "capstan=1mm", "--move", "knuckle=1mm"]);
    assert!(error.contains("--steps") && error.contains("666666"), "{error}");
}

/// A pipe is read once.
#[cfg(unix)]
#[test]
fn a_pipe() {
    use std::io::Write;
    use std::process::Stdio;
    let folder = Folder::for_command("kinematics", "pipe");
    let mut child = folder.command(&["/dev/stdin"]).stdin(Stdio::piped()).stdout(Stdio::null()).spawn().unwrap();
    child.stdin.take().unwrap().write_all(C7F.as_bytes()).unwrap();
    assert!(child.wait().unwrap().success());
}

/// Control-C while levers are computed, tables written and figures drawn: code 130, nothing left.
#[cfg(unix)]
#[test]
fn control_c_is_heard() {
    use std::process::{Command, Stdio};
    let folder = Folder::for_command("kinematics", "control-c");
    for delay_ms in [100, 500, 900] {
        let mut command = folder.command(&["c7f-like", "--steps", "1000000"]);
        let mut child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        crate::common::signals::until_it_listens(&mut child);
        std::thread::sleep(std::time::Duration::from_millis(delay_ms));
        assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
        assert_eq!(child.wait().unwrap().code(), Some(130), "after {delay_ms} ms");
        assert!(folder.names().is_empty(), "after {delay_ms} ms: {:?}", folder.names());
    }
}
