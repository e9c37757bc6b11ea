//! Short answers: the first lines of every command, and what `--full` adds. Files and JSON are the same with both.

use std::fs;

use serde_json::Value;

use crate::common::Folder;

/// Commands that take a moment, with what their first lines say.
const QUICK: [(&[&str], &[&str]); 10] = [
    (&["press"], &["The hammer meets the string at", "m/s", "The finger pushes with at most", "back check"]),
    (&["press", "--duration", "0.005"], &["The hammer does not reach the string: the key did not go down to let-off."]),
    (&["press", "--against", "pp"], &["hammer speed at the string", "difference"]),
    (
        &["diagnose", "--down-weight", "58", "--up-weight", "18"],
        &["Out of range: friction weight 20.0 g.", "Measure next: hammer flange", "No key was named"],
    ),
    (&["kinematics"], &["leverage at rest", "leverage at let-off", "A slow press of the dynamic model"]),
    (
        &["study", "--vary", "let_off=-0.1mm..0.1mm:10", "--vary", "body.hammer.mass=x0.9,x1", "--duration", "0.1"],
        &["across: body.hammer.mass_factor", "0.9"],
    ),
    (&["check", "concert-grand"], &["9 bodies, 4 springs, 17 contact zones, 12 screws.", "numbers has a source."]),
    (&["check", "mf-pressed"], &["sampled every", "columns used"]),
    (&["keyboard", "--every", "87"], &["From A0 to C8 the down-weight goes from", "Friction weight:"]),
    (
        &["keyboard", "concert-grand", "heavy-touch", "--every", "87"],
        &["down-weight: the second has +", "g on average; most at A0,", "speed at mf: the second has"],
    ),
];

/// Every file of a folder but for the pictures, which are made of the same numbers.
fn files(folder: &Folder) -> Vec<(String, Vec<u8>)> {
    let mut all = Vec::new();
    for out in folder.names().iter().filter(|name| name.starts_with("erard-out")) {
        for entry in fs::read_dir(folder.0.join(out)).unwrap() {
            let path = entry.unwrap().path();
            if path.extension().is_some_and(|end| end != "png") {
                all.push((path.display().to_string(), fs::read(&path).unwrap()));
            }
        }
    }
    all.sort();
    all
}

/// An answer is short and says what `--full` adds; with `--full` it is longer and says nothing of it. Both give the
/// command that repeats it, and write the same bytes.
#[test]
fn the_first_lines_are_few_and_the_rest_is_a_word_away() {
    let folder = Folder::new("short");
    for (arguments, says) in QUICK {
        let short = folder.short(arguments);
        let written = files(&folder);
        let lines = short.lines().count();
        assert!((5..=17).contains(&lines), "{arguments:?}: {lines} lines\n{short}");
        assert!(short.lines().all(|line| line.chars().count() <= 100), "{short}");
        let words = short.replace(" \\\n", " ");
        let words = words.split_whitespace().collect::<Vec<_>>().join(" ");
        says.iter().for_each(|text| assert!(words.contains(text), "{arguments:?}: {text}\n{short}"));
        let repeat = format!("Repeat: erard {}", arguments.join(" "));
        assert!(words.contains(&repeat) && words.contains(env!("CARGO_PKG_VERSION")), "{arguments:?}: {short}");
        let full = folder.good(arguments);
        assert!(full.lines().count() > lines, "{arguments:?}: {full}");
        assert_eq!([&short, &full].map(|text| text.contains("More: --full adds")), [true, false], "{arguments:?}");
        assert!(full.contains("Repeat:  erard "), "{full}");
        assert_eq!(files(&folder), written, "{arguments:?}");
    }
}

/// The answer as JSON is the same, and nothing else is printed beside it.
#[test]
fn json_does_not_know_how_long_an_answer_is() {
    let folder = Folder::new("short-json");
    let json = |arguments: &[&str]| serde_json::from_str::<Value>(&folder.short(arguments)).expect("JSON");
    let command = ["press", "--json", "--duration", "0.005"];
    let [short, full] = [json(&command), json(&[&["--full"][..], &command].concat())];
    assert!(short.is_object() && short == full, "{short}\n{full}");
    assert_eq!(folder.short(&["press", "--quiet", "--duration", "0.005"]), "");
}

/// The numbers of the first lines are those of the JSON.
#[test]
fn the_first_lines_are_the_numbers_of_the_answer() {
    let folder = Folder::new("short-numbers");
    let short = folder.short(&["press"]);
    let answer: Value = serde_json::from_str(&folder.read("erard-out/summary.json")).unwrap();
    let number = |key: &str| answer[key].as_f64().unwrap();
    for (value, decimals) in [
        (number("hammer_speed_m_per_s"), 2),
        (1e3 * (number("hammer_contact_s") - number("key_start_s")), 1),
        (1e3 * number("free_flight_s"), 1),
        (number("peak_force_N"), 1),
    ] {
        assert!(short.contains(&format!(" {value:.decimals$} ")), "{value}: {short}");
    }
}

/// The digest is that of what was read: another instrument has another, and a file has its own.
#[test]
fn the_repeat_line_names_what_was_read() {
    let folder = Folder::new("short-repeat");
    let repeat = |arguments: &[&str]| {
        let text = folder.short(arguments).split_whitespace().collect::<Vec<_>>().join(" ");
        let at = text.find("Repeat: ").expect("a line to repeat it");
        text[at..].split(')').next().unwrap().to_owned()
    };
    let [own, again] = [repeat(&["draw"]), repeat(&["draw", "--out", "elsewhere"])];
    assert_eq!(own, again);
    assert_ne!(own, repeat(&["draw", "--instrument", "heavy-touch"]).replace(" --instrument heavy-touch", ""));
}

/// Names of another kind, or nearly right, are answered by what to type: code 2, and nothing is written.
#[test]
fn a_wrong_name_is_answered_by_the_right_one() {
    let folder = Folder::new("suggested");
    for (arguments, says) in [
        (&["press", "--instrument", "steinway"][..], "did you mean `steinway-o`?"),
        (&["press", "--instrument", "upright"], "grands only so far"),
        (&["measure", "C4"], "concert-grand:key=C4"),
        (&["press", "mf"], "--stroke mf"),
        (&["press", "heavy-touch"], "--instrument heavy-touch"),
        (&["list", "stroks"], "did you mean `strokes`?"),
        (&["draw", "--at", "letoff"], "did you mean `let-off`?"),
        (&["diagnose", "58", "18"], "readings are options: --down-weight 58"),
        (&["cite"], "--bibtex with any command"),
        (&["list", "press"], "erard press --help"),
        (&["man", "pres"], "did you mean `press`?"),
        (&["measure", "--only", "downweight"], "did you mean `down_weight_g`"),
        (&["keyboard", "steinway-o"], "`steinway-o` is an instrument"),
        (&["kinematics", "c7f"], "did you mean `c7f-like`?"),
        (&["keyboard", "--key", "H4"], "the German H4 is B4 here"),
        (&["validate", "--cases", "judges"], "did you mean `judge`?"),
        (&["press", "--vary", "let_off=0"], "`--vary` is an option of `study`"),
        (&["C4"], "concert-grand:key=C4"),
    ] {
        let told = folder.bad(arguments);
        assert!(told.contains(says), "{arguments:?}: {told}");
    }
    let strokes = folder.short(&["list", "strokes"]);
    assert!(strokes.contains("mf-struck") && !strokes.contains("heavy-touch"), "{strokes}");
}
