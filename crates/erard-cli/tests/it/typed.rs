//! Numbers as people type them, through the whole command: every spelling of one number gives the same files.

use crate::common::Folder;

/// The text of a file that the command writes with these arguments.
fn written(folder: &Folder, arguments: &[&str], name: &str) -> String {
    folder.good(arguments);
    let is_folder = |folder: &String| folder.starts_with("erard-");
    let out = folder.names().into_iter().find(is_folder).expect("the command writes a folder");
    folder.read(&format!("{out}/{name}"))
}

#[test]
fn spellings_of_one_number_give_one_run() {
    let folder = Folder::for_command("press", "typed");
    let short = ["--duration", "0.02"];
    let run = |arguments: &[&str]| written(&folder, &[&short[..], arguments].concat(), "run.csv");
    for (option, plain, spellings) in [
        ("--force-step", "5", &["5N", "5 N", "5,0N", "+5", "500cN", "5,0"][..]),
        ("--dt", "0.0001", &["0.1ms", "100us", "100 \u{b5}s", "0,1 ms", "1e-4s"]),
    ] {
        let own = run(&[option, plain]);
        for text in spellings {
            assert!(run(&[option, text]) == own, "{option} {text}");
        }
    }
    let own = run(&["--force-step", "5"]);
    assert!(run(&["--force-step", "500gf"]) != own, "grams are weighed by 9.80665 N/kg");
    let long = |duration: &str| written(&folder, &["--duration", duration, "--force-step", "5"], "run.csv");
    assert_eq!(long("20ms"), own);
    assert_eq!(long("20000 us"), own);
    let strings = Folder::for_command("press", "typed-pedal");
    let lifted = |pedal: &str| {
        let arguments =
            ["--instrument", "concert-grand-strings", "--force-step", "5", "--duration", "5ms", "--pedal", pedal];
        written(&strings, &arguments, "run.csv")
    };
    let own = lifted("7mm");
    for text in ["7", "7,0 mm", "7000um"] {
        assert!(lifted(text) == own, "{text}");
    }
}

#[test]
fn readings_are_typed_with_any_unit() {
    let folder = Folder::for_command("diagnose", "typed");
    let found = |arguments: &[&str]| {
        let text = written(&folder, arguments, "diagnosis.json");
        let json: serde_json::Value = serde_json::from_str(&text).unwrap();
        json["keys"].to_string()
    };
    let own = found(&["--down-weight", "58", "--up-weight", "18", "--dip", "10.16", "--blow", "47.625"]);
    assert!(own.contains("58"), "{own}");
    for arguments in [
        ["--down-weight", "58g", "--up-weight", "18 gf", "--dip", "0.4in", "--blow", "1.875in"],
        ["--dw", "58,0", "--uw", "0.018kg", "--key-dip", "10,16 mm", "--blow", "1 7/8\""],
        ["--d", "+58", "--u", "18.0", "--dip", "1.016 cm", "--blow", "1-7/8in"],
        // Balance weight and friction weight: D = BW + F, U = BW - F.
        ["--balance-weight", "38", "--friction-weight", "20g", "--dip", "0.4in", "--blow", "1.875in"],
        ["--bw", "38,0 g", "--f", "+20", "--dip", "0.4in", "--blow", "1.875in"],
        ["--bw", "0.038kg", "--d", "58", "--dip", "0.4in", "--blow", "1.875in"],
        ["--f", "20", "--uw", "18", "--dip", "0.4in", "--blow", "1.875in"],
    ] {
        assert_eq!(found(&arguments), own, "{arguments:?}");
    }
    // A reading with a sign is a value, whichever minus is typed.
    let below = found(&["--front-weight", "-8.6g"]);
    assert_eq!(found(&["--front-weight", "\u{2212}8,6"]), below);
}

#[test]
fn goals_are_typed_with_any_unit() {
    let folder = Folder::for_command("regulate", "typed");
    let error = |text: &str| folder.bad(&[&format!("dip={text}")]);
    for text in ["1/2", "1,500", "10g", "ten", ""] {
        assert!(error(text).contains("dip"), "{text}");
    }
}

/// What may mean two things is refused, with both to type; exit code 2, and nothing written.
#[test]
fn what_may_mean_two_things_is_refused() {
    for (command, arguments, told) in [
        ("press", &["--force-step", "1,500"][..], "may be 1.500 or 1500"),
        ("press", &["--force-step", "5mm"], "`mm` is not one of its units; expected N, mN"),
        ("press", &["--dt", "50"], "step"),
        ("press", &["--dt", "5m"], "`m` is not one of its units; expected s, ms, us"),
        ("press", &["--force-step", "1 MN"], "not one of its units"),
        ("press", &["--hammer-speed", "2 m"], "expected m/s"),
        ("diagnose", &["--dip", "1/2"], "`1/2in`"),
        ("diagnose", &["--dip", "10g"], "units: m, dm, cm, mm"),
        ("diagnose", &["--down-weight", "58mm"], "units: kg, g, oz, lb, N"),
        ("diagnose", &["--blow", "1,875"], "`1.875` or `1875`"),
        ("diagnose", &["--bw", "38"], "a balance weight BW of 38 g alone; expected the friction weight F"),
        ("diagnose", &["--f", "20"], "a friction weight F of 20 g alone; expected the balance weight BW"),
        ("diagnose", &["--d", "50", "--u", "26", "--bw", "30"], "expected 38 g, which follows from these"),
        ("diagnose", &["--bw", "38", "--f", "20", "--d", "50"], "a friction weight F of 20 g beside"),
        ("diagnose", &["--f", "-2", "--bw", "38"], "a number from 0 to 100 g"),
        (
            "keyboard",
            &["concert-grand", "--measured", "x.csv", "--lead-masses", "10mm"],
            "`mm` is not one of its units",
        ),
        ("draw", &["--at", "10 mm"], "milliseconds"),
        ("play", &["x.mid", "--from", "1 m"], "`m` is not one of its units"),
    ] {
        let folder = Folder::for_command(command, "typed-wrong");
        let error = folder.bad(arguments);
        assert!(error.contains(told), "{command} {arguments:?}: {error}");
        assert!(folder.names().is_empty(), "{command} {arguments:?}");
    }
}
