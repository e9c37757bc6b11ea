//! The command accepts and refuses the numbers that the C and the Python interface accept and refuse.

use crate::common::Folder;

/// Rows of `quantity, value, accepted`, which every front is held against.
const RANGES: &str = include_str!("../../../erard-core/tests/ranges.csv");

#[test]
fn numbers_are_refused_as_by_the_other_fronts() {
    let folder = Folder::new("ranges");
    let recorded = (0..60).map(|n| {
        let down = (f64::from(n - 20) / 20.0).clamp(0.0, 1.0);
        format!("{},{},{}\n", f64::from(n) * 1e-3, 5.0 * f64::from(n > 20), 0.005 * down)
    });
    folder.file("recorded.csv", &format!("time_s,force_N,key_m\n{}", recorded.collect::<String>()));
    let mut tried = 0;
    for row in RANGES.lines().skip(1) {
        let [quantity, value, accepted] = row.split(',').collect::<Vec<_>>().try_into().expect("three columns");
        let out = ["--out", "out", "--force"];
        // What was recorded: a force and a key that goes down, to the value that is tried.
        folder.file("force.csv", &format!("time_s,force_N\n0,0\n1e-3,0\n2e-3,0\n3e-3,{value}\n"));
        folder.file("key.csv", &format!("time_s,key_m\n0,0\n0.1,0\n0.2,0\n0.3,{value}\n"));
        let pressed = |option: &str| format!("press --force-step 5 --duration 1e-3 {option}");
        let played = |option: &str| format!("press recorded.csv --duration 1e-3 {option}");
        let fitted = "fit concert-grand-rigid recorded.csv --parameters body.hammer.mass --sigma force=0,position=1e-4 --no-pictures";
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
            "theta" => pressed(&format!("--theta {value}")),
            "tolerance" => pressed(&format!("--tolerance {value}")),
            "friction_width_rad_per_s" => pressed(&format!("--friction tanh --friction-width {value}")),
            "record_every" => pressed(&format!("--record-every {value}")),
            "hand_mass_kg" => pressed(&format!("--hand={value}kg")),
            "joints_mm_per_n" => pressed(&format!("--hand=200 --joints compliance={value}mm/N,time=8ms")),
            "joints_ms" => pressed(&format!("--hand=200 --joints compliance=0.2mm/N,time={value}ms")),
            "recorded_force_n" => "press force.csv --duration 3e-3".into(),
            "recorded_key_m" => "press key.csv --drive motion --duration 1e-3".into(),
            "low_pass_hz" => played(&format!("--low-pass {value}")),
            "delay_s" => played(&format!("--delay force={value}s")),
            "study_force_n" => format!("study --vary force=1,{value} --duration 1e-3"),
            "study_tolerance" => format!("study --vary force=1,2 --duration 1e-3 --tolerance {value}"),
            "drawn_at_s" => format!("draw --force-step 5 --at {value}s"),
            "kinematics_steps" => format!("kinematics c7f-like --steps {value}"),
            "measured_key" => format!("measure concert-grand --key {value} --only dip_mm"),
            "down_weight_g" => format!("diagnose --up-weight 20 --down-weight {value}"),
            "fit_restarts" => format!("{fitted} --max-evaluations 2 --restarts {value}"),
            "fit_evaluations" => format!("{fitted} --restarts 0 --max-evaluations {value}"),
            // The command steps nothing live.
            "live_force_n" | "live_position_m" | "live_speed_m_per_s" => continue,
            other => panic!("{other} is not tried on the command"),
        };
        let arguments: Vec<&str> = given.split(' ').chain(out).collect();
        let output = folder.erard(&arguments);
        // A fit of so few evaluations has its doubts, with exit code 1.
        let is_accepted = output.status.code().is_some_and(|code| code < 2);
        assert_eq!(is_accepted, accepted == "yes", "{row}: {}", String::from_utf8_lossy(&output.stderr));
        tried += 1;
    }
    assert!(tried > 90, "{tried}");
}

/// Texts of a study's values that the table refuses, and dead names, through the whole command.
#[test]
fn texts_are_refused_as_by_the_other_fronts() {
    let folder = Folder::new("typed");
    let mut tried = 0;
    for row in include_str!("../../../erard-core/tests/typed.tsv").lines().skip(1) {
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
