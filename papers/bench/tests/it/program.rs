//! `erard-bench` as a user runs it. Times themselves are never asserted: they belong to the machine.

use serde_json::Value;

use crate::common::Folder;
use crate::common::schema::faults;

/// What a reader of the JSON may rely on.
const NUMBERS: [&str; 48] = [
    "step_ns_median",
    "step_ns_spread",
    "real_time_factor",
    "press_ms_median",
    "press_ms_spread",
    "press_real_time_factor",
    "kinematics_pose_ns_median",
    "kinematics_pose_ns_spread",
    "cores",
    "lanes",
    "batch_speedup_per_core",
    "batch_speedup_all_cores",
    "batch_one_by_one_ns_median",
    "batch_lanes_ns_median",
    "batch_all_cores_ns_median",
    "batch_one_by_one_ns_spread",
    "batch_lanes_ns_spread",
    "batch_all_cores_ns_spread",
    "batch_tremolo_speedup_per_core",
    "batch_tremolo_speedup_all_cores",
    "study_stroke_ms_median",
    "study_stroke_ms_spread",
    "steps_timed",
    "step_ns_p50",
    "step_ns_p99",
    "step_ns_p9999",
    "step_ns_max",
    "group_steps_timed",
    "group_step_ns_p50",
    "group_step_ns_p9999",
    "group_step_ns_max",
    "newton_iterations_max",
    "keyboard_real_time_factor",
    "keyboard_ticks_timed",
    "keyboard_tick_ns_p50",
    "keyboard_tick_ns_p99",
    "keyboard_tick_ns_p9999",
    "keyboard_tick_ns_max",
    "keyboard_awake_mean",
    "keyboard_awake_max",
    "keyboard_all_keys_real_time_factor",
    "keyboard_asleep_tick_ns_p50",
    "press_bare_step_ns_median",
    "press_over_bare_steps",
    "press_over_bare_steps_not_left_out",
    "keyboard_key_step_ns_median",
    "keyboard_key_over_bare_step",
    "keyboard_all_keys_over_bare_step",
];

/// The JSON is alone on standard output, has every key, and every number is finite and positive (a spread may be zero).
/// What follows from the definitions holds: percentiles ascend, a factor is a step over its time.
#[test]
fn json_has_every_number() {
    let folder = Folder::new("bench-json");
    let report: Value = serde_json::from_str(&folder.short(&["--quick", "--json"])).expect("nothing but JSON");
    let number = |name: &str| report[name].as_f64().unwrap_or_else(|| panic!("{name}: {report}"));
    for name in NUMBERS {
        let value = number(name);
        assert!(value.is_finite() && value >= 0.0 && (value > 0.0 || name.ends_with("_spread")), "{name}: {value}");
    }
    let home = concat!(env!("CARGO_MANIFEST_DIR"), "/schemas/bench.schema.json");
    let schema: Value = serde_json::from_str(&std::fs::read_to_string(home).unwrap()).unwrap();
    let mut found = Vec::new();
    faults(&report, &schema, "", &mut found);
    assert!(found.is_empty(), "{found:#?}");
    assert!(report["made_by"]["command"].as_str().unwrap().starts_with("erard-bench"), "{report}");
    assert_eq!(number("unconverged_steps"), 0.0);
    assert!(report["instruction_sets"].is_array());
    let ascends = ["step_ns_p50", "step_ns_p99", "step_ns_p9999", "step_ns_max"].map(number);
    assert!(ascends.is_sorted(), "{ascends:?}");
    assert!((number("real_time_factor") * number("step_ns_median") / 50_000.0 - 1.0).abs() < 1e-12);
    let ratio = number("batch_one_by_one_ns_median") / number("batch_lanes_ns_median");
    assert!((number("batch_speedup_per_core") / ratio - 1.0).abs() < 1e-12);
    assert!(folder.names().is_empty(), "nothing is written");
}

#[test]
#[ignore = "ci: all benchmarks once more"]
fn the_table_names_what_was_timed() {
    let folder = Folder::new("bench-table");
    let table = folder.short(&["--quick"]);
    for part in [
        "step",
        "press",
        "kinematics",
        "batch",
        "tremolo",
        "study",
        "keyboard",
        "single steps",
        "x real time",
        "x its bare steps",
        "99.99 %",
    ] {
        assert!(table.contains(part), "{part}: {table}");
    }
}

#[test]
fn wrong_options() {
    let folder = Folder::new("bench-wrong");
    assert!(folder.bad(&["--slow"]).contains("--slow"));
    assert!(folder.bad(&["concert-grand"]).contains("concert-grand"));
    assert!(folder.bad(&["--json=yes"]).contains("--json"));
}

/// Control-C: exit code 130, and no half of a report.
#[cfg(unix)]
#[test]
fn interrupted() {
    let folder = Folder::new("bench-interrupted");
    let mut command = folder.command(&["--json"]);
    let mut child = command.stdout(std::process::Stdio::piped()).stderr(std::process::Stdio::piped()).spawn().unwrap();
    crate::common::signals::until_it_listens(&mut child);
    std::thread::sleep(std::time::Duration::from_millis(300));
    let killed = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(killed.success());
    assert_eq!(child.wait().unwrap().code(), Some(130));
    let output = child.wait_with_output().unwrap();
    assert!(output.stdout.is_empty());
    assert!(String::from_utf8_lossy(&output.stderr).contains("interrupted"));
}
