//! The command accepts and refuses the numbers that the C and the Python interface accept and refuse.

use crate::common::Folder;

/// Rows of `quantity, value, accepted`, which every front is held against.
const RANGES: &str = include_str!("../../../erard/tests/ranges.csv");

#[test]
fn numbers_are_refused_as_by_the_other_fronts() {
    let folder = Folder::new("ranges");
    let mut tried = 0;
    for row in RANGES.lines().skip(1) {
        let [quantity, value, accepted] = row.split(',').collect::<Vec<_>>().try_into().expect("three columns");
        let out = ["--out", "out", "--force"];
        let given = match quantity {
            "step_s" => {
                // The finest step of all, too, some hundred times.
                let duration = if value.parse().is_ok_and(|step_s: f64| step_s < 1e-6) { "1e-6" } else { "1e-3" };
                format!("press --dt {value} --force-step 5 --duration {duration}")
            }
            "duration_s" => format!("press --force-step 5 --duration {value}"),
            "force_n" => format!("press --force-step {value} --duration 1e-3"),
            "hammer_speed_m_per_s" => format!("press --hammer-speed {value}"),
            "key" => format!("press --instrument concert-grand:key={value} --force-step 5 --duration 1e-3"),
            "hammer_mass_factor" => format!("study --vary body.hammer.mass=x{value} --force-step 5 --duration 1e-3"),
            "let_off_turned_mm" => format!("study --vary let_off={value}mm --force-step 5 --duration 1e-3"),
            // The command steps nothing live.
            "live_force_n" | "live_position_m" | "live_speed_m_per_s" => continue,
            other => panic!("{other} is not tried on the command"),
        };
        let arguments: Vec<&str> = given.split(' ').chain(out).collect();
        let output = folder.erard(&arguments);
        let code = if accepted == "yes" { 0 } else { 2 };
        assert_eq!(output.status.code(), Some(code), "{row}: {}", String::from_utf8_lossy(&output.stderr));
        tried += 1;
    }
    assert!(tried > 30, "{tried}");
}

/// Texts of a study's values that the table refuses, and dead names, through the whole command.
#[test]
fn texts_are_refused_as_by_the_other_fronts() {
    let folder = Folder::new("typed");
    let mut tried = 0;
    for row in include_str!("../../../erard/tests/typed.tsv").lines().skip(1) {
        let [name, text, expected, _] = row.split('\t').collect::<Vec<_>>().try_into().expect("four columns");
        if let Some(told) = expected.strip_prefix("no ") {
            let said = folder.bad(&["study", &format!("--vary={name}={text}"), "--force-step", "5"]);
            let words = said.split_whitespace().collect::<Vec<_>>().join(" ");
            assert!(words.contains(told), "{row}: {said}");
            tried += 1;
        }
    }
    assert!(tried > 15, "{tried}");
}
