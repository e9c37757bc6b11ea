//! `erard keyboard`, and keys of a keyboard in the place of instruments, as a user has them.

use crate::common::Folder;

/// A keyboard around the built-in grand: hammers alone.
const MINE: &str = r#"format = "erard-keyboard/1"
name = "Mine"
instrument = "grand.toml"
instrument_key = 40

[[added_mass]]
name = "hammer head"
body = "hammer"
at_mm = [70, 18]
mass_g = [{ key = 1, value = 2 }, { key = 40, value = 0 }, { key = 88, value = -3 }]
"#;

/// A keyboard whose highest key is too heavy in front to come up: it cannot be weighed.
pub(crate) const STUCK: &str = r#"format = "erard-keyboard/1"
name = "Stuck"
instrument = "grand.toml"
instrument_key = 40

[[added_mass]]
name = "leads"
body = "key"
at_mm = [-100, 0]
mass_g = [{ key = 40, value = 0 }, { key = 88, value = 300 }]
"#;

/// A keyboard whose highest string is out of the hammer's reach.
const FAR: &str = r#"format = "erard-keyboard/1"
name = "Far"
instrument = "grand.toml"
instrument_key = 40

[[shift]]
name = "strings"
points = ["zone.string.line.point_mm"]
direction = [0, 1]
by_mm = [{ key = 40, value = 0 }, { key = 88, value = 150 }]
"#;

fn with_mine(test: &str) -> Folder {
    let folder = Folder::new(&format!("keyboard-{test}"));
    folder.file("grand.toml", erard::instrument::Instrument::builtin_text("concert-grand").unwrap());
    folder.file("mine.toml", MINE);
    folder
}

/// Two keys of a keyboard file: a table, a figure as SVG and PNG, and the same numbers on standard output.
#[test]
fn weighed_keys_are_written() {
    let folder = with_mine("weighed");
    let said = folder.good(&["keyboard", "mine.toml", "--every", "87", "--out", "keys"]);
    let table = folder.read("keys/keyboard.csv");
    let rows: Vec<Vec<&str>> = table.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(rows[0][..4], ["key", "note", "hammer_mass_g", "strike_weight_g"]);
    assert_eq!(
        rows.iter().skip(1).map(|row| (row[0], row[1], row[2])).collect::<Vec<_>>(),
        [("1", "A0", "13.2"), ("88", "C8", "8.2")]
    );
    // The strike weight grows by what is added at the place where it is weighed: 8.7 g + 2 g, 8.7 g - 3 g.
    let strike = |row: &[&str]| row[3].parse::<f64>().unwrap();
    assert!((strike(&rows[1]) - strike(&rows[2]) - 5.0).abs() < 1e-3, "{table}");
    assert!(said.starts_with("Mine - 88 keys, 2 of them weighed") && said.contains("down-weight"), "{said}");
    let svg = folder.read("keys/keyboard.svg");
    assert!(svg.contains("down-weight") && svg.contains("hammer (g)") && svg.contains("number of the key"), "{svg}");
    assert!(std::fs::read(folder.0.join("keys/keyboard.png")).unwrap().starts_with(b"\x89PNG"));
}

/// Treble keys that cannot be weighed, or never strike, are rows with their reasons; the others stand.
#[test]
fn a_key_that_cannot_be_weighed_is_a_row_with_its_reason() {
    let folder = with_mine("failed");
    folder.file("stuck.toml", STUCK);
    folder.file("far.toml", FAR);
    for (name, reason) in [("stuck.toml", "the slowly pressed key travels"), ("far.toml", "does not reach the string")]
    {
        let output =
            folder.erard(&["keyboard", name, "--every", "87", "--json", "--out", name.trim_end_matches(".toml")]);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success() && Folder::words(&said).contains("key 88: "), "{said}");
        let answer: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        let table = &answer["table"];
        assert!(table["error"][0].is_null() && table["down_weight_g"][0].is_number(), "{table}");
        assert!(table["error"][1].as_str().unwrap().contains(reason), "{table}");
        assert!(table["mf_hammer_speed_m_per_s"][1].is_null() && table["trusted"][1] == 0, "{table}");
    }
    assert!(folder.read("stuck/keyboard.csv").lines().nth(2).unwrap().starts_with("88,C8,,"));
    let told = folder.good(&["measure", "stuck.toml:key=40,88", "--only", "key_ratio", "--out", "sheets"]);
    assert!(told.contains("failed: cannot be measured"), "{told}");
    let rows: serde_json::Value = serde_json::from_str(&folder.read("sheets/measure.json")).unwrap();
    assert!(rows[0]["error"].is_null() && rows[0]["key_ratio"].is_number(), "{rows}");
    assert!(
        rows[1]["error"].as_str().unwrap().contains("slowly pressed key") && rows[1]["key_ratio"].is_null(),
        "{rows}"
    );
    assert!(folder.read("sheets/measure.csv").lines().nth(2).unwrap().starts_with("88,,"));
    // Where nothing can be weighed nothing is written.
    let none = folder.bad(&["measure", "stuck.toml:key=88,88", "--only", "key_ratio", "--out", "none"]);
    assert!(none.contains("slowly pressed key") && !folder.0.join("none").exists(), "{none}");
}

/// `--key` prints an instrument file and writes nothing; the file is the key.
#[test]
fn a_key_is_an_instrument_file() {
    let folder = with_mine("file");
    let before = folder.names();
    let text = folder.good(&["keyboard", "mine.toml", "--key", "1"]);
    assert_eq!(folder.names(), before);
    folder.file("one.toml", &text);
    let checked = folder.good(&["check", "one.toml"]);
    assert!(checked.contains("\"Mine, key 1 (A0)\"") && checked.contains("10.7 g"), "{checked}");
    for (instrument, out) in [("one.toml", "a"), ("mine.toml:key=1", "b"), ("grand.toml", "c")] {
        folder.good(&["press", "--instrument", instrument, "--force-step", "5", "--duration", "0.1", "--out", out]);
    }
    assert_eq!(folder.read("a/run.csv"), folder.read("b/run.csv"));
    assert_ne!(folder.read("a/run.csv"), folder.read("c/run.csv"));
}

#[test]
#[ignore = "ci: presses 88 keys"]
fn a_sound_keyboard_is_called_sound() {
    let folder = with_mine("sound");
    let said = folder.good_words(&["check", "mine.toml"]);
    assert!(said.contains("a keyboard, \"Mine\"") && said.contains("all 88 keys are sound"), "{said}");
}

/// A file is checked with all its keys.
#[test]
fn keyboards_are_checked() {
    let folder = with_mine("checked");
    // 30 g less at 131 mm: the hammer's inertia of 1.4e-4 kg m2 is used up by 8.1 g, at key 40 + 48 x 8.1 / 30.
    folder.file("mine.toml", &MINE.replace("value = -3", "value = -30"));
    let said = folder.bad(&["check", "mine.toml"]);
    assert!(said.contains("mine.toml, key 53") && said.contains("body.hammer.inertia_kg_m2"), "{said}");
}

/// One clear error, code 2, nothing written.
#[test]
fn wrong_input_is_told() {
    let folder = with_mine("wrong");
    folder.file("broken.toml", &MINE.replace("at_mm = [70, 18]", "at_mm = 130"));
    let cases: [(&[&str], &str); 11] = [
        (
            &["keyboard", "nobody"],
            "there is no file and no built-in keyboard `nobody` (built in: concert-grand, heavy-touch, concert-grand-strings)",
        ),
        (&["keyboard", "nobody.toml"], "nobody.toml: cannot be read"),
        (&["keyboard", "grand.toml"], "belongs to an instrument, and a keyboard is expected here"),
        (&["keyboard", "broken.toml"], "broken.toml:9:9: `added_mass.hammer head.at_mm`"),
        (&["keyboard", "--key", "0"], "expected a number from 1 to 88, or a note from A0 to C8"),
        (&["keyboard", "--every", "0"], "expected a whole number from 1 to 87"),
        (
            &["press", "--instrument", "mine.toml"],
            "mine.toml: is a keyboard; expected an instrument. Name one of its keys: mine.toml:key=40",
        ),
        (
            &["press", "--instrument", "mine.toml:key=C9"],
            "found key `C9`; expected a number from 1 to 88, or a note from A0 to C8",
        ),
        (&["measure", "concert-grand:key=0"], "found key `0`"),
        (&["measure", "steinway-o:key=1"], "there is no file and no built-in keyboard `steinway-o`"),
        (&["regulate", "nobody.toml:key=3"], "nobody.toml: cannot be read"),
    ];
    for (arguments, expected) in cases {
        let said = folder.bad(arguments);
        assert!(said.starts_with("error: ") && said.contains(expected), "{arguments:?}: {said}");
    }
}

/// Control-C: exit code 130, and nothing is left behind.
#[cfg(unix)]
#[test]
fn interrupted_it_leaves_nothing() {
    let folder = with_mine("interrupted");
    let before = folder.names();
    let mut child = folder.command(&["keyboard", "mine.toml", "--every", "1", "--out", "keys"]).spawn().unwrap();
    // A folder to write in is made when the work begins.
    while folder.names() == before {
        assert!(child.try_wait().unwrap().is_none(), "it ended before it could be interrupted");
        std::thread::sleep(std::time::Duration::from_millis(2));
    }
    let kill = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(kill.success());
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert_eq!(folder.names(), before);
}

/// Two keyboards: both tables as each would be alone, the second less the first, both in one figure, and a page with a
/// row for every key.
#[test]
#[ignore = "ci: two keyboards of 88 keys"]
fn two_keyboards_beside_each_other() {
    beside_each_other(&[("mine.toml", 2)]);
}

/// Some of them are played alone, too.
fn beside_each_other(alone: &[(&str, usize)]) {
    let folder = with_mine("pair");
    let said = folder.good(&["keyboard", "concert-grand", "mine.toml", "--every", "87", "--out", "both"]);
    assert!(said.contains("1: Concert grand\n2: Mine\n") && said.contains("2 - 1"), "{said}");
    for &(keyboard, number) in alone {
        folder.good(&["keyboard", keyboard, "--every", "87", "--out", "alone"]);
        assert_eq!(folder.read("alone/keyboard.csv"), folder.read(&format!("both/keyboard-{number}.csv")));
    }
    let cells = |name: &str| -> Vec<Vec<String>> {
        folder.read(name).lines().map(|line| line.split(',').map(str::to_owned).collect()).collect()
    };
    let [first, second, difference] = ["both/keyboard-1.csv", "both/keyboard-2.csv", "both/difference.csv"].map(cells);
    let all: serde_json::Value = serde_json::from_str(&folder.read("both/keyboard.json")).unwrap();
    assert_eq!(all["names"], serde_json::json!(["Concert grand", "Mine"]));
    assert_eq!(difference.len(), 3);
    let mut differ = 0;
    for row in 1..3 {
        assert_eq!(difference[row][..2], first[row][..2]);
        for column in 2..difference[0].len() {
            assert_eq!(difference[0][column], first[0][column]);
            let number = |table: &[Vec<String>]| table[row][column].parse::<f64>().unwrap();
            let expected = number(&second) - number(&first);
            assert!((number(&difference) - expected).abs() <= 1e-9, "{row} {column}");
            assert_eq!(all["difference"][&difference[0][column]][row - 1].as_f64(), Some(number(&difference)));
            differ += usize::from(expected.abs() > 0.1);
        }
    }
    assert!(differ > 4, "these keyboards differ: {difference:?}");
    let page = folder.read("both/keyboard.html");
    assert_eq!(page.matches("<tr>").count(), 4, "two rows of headings and one for every key");
    assert!(page.contains(">Mine<") && page.contains("data:image/svg+xml;base64,"));
    let svg = folder.read("both/keyboard.svg");
    assert!(svg.contains("Concert grand beside Mine") && svg.contains("front weight (g)"));
    for one in [["--key", "3"], ["--measured", "both/keyboard-1.csv"]] {
        assert!(folder.bad(&[&["keyboard", "concert-grand", "mine.toml"][..], &one].concat()).contains("one keyboard"));
    }
    // The same one twice differs in nothing.
    folder.good(&["keyboard", "mine.toml", "mine.toml", "--every", "87", "--out", "same"]);
    let same = cells("same/difference.csv");
    assert!(same[1..].iter().all(|row| row[2..].iter().all(|cell| cell == "0")), "{same:?}");
    assert!(folder.read("same/keyboard.html").contains("Mine, second"));
}

mod nightly {
    use super::*;

    #[test]
    #[ignore = "nightly: one keyboard more"]
    fn two_keyboards_beside_each_other_are_as_each_alone() {
        beside_each_other(&[("concert-grand", 1), ("mine.toml", 2)]);
    }
}
