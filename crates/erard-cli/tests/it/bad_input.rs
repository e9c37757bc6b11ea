//! Wrong input gets one message that says where and what, exit code 2, and nothing is written.

use std::io::Write;

use crate::common::Folder;

const GRAND: &str = include_str!("../../../erard-core/instruments/concert-grand.toml");

/// The concert grand with its first `what` replaced, and the line (from 1) where that stood.
fn damaged(what: &str, by: &str) -> (String, usize) {
    let at = GRAND.find(what).expect("the concert grand holds it");
    let line = GRAND[..at].matches('\n').count() + 1;
    (GRAND.replacen(what, by, 1), line)
}

/// Every part of a message must be there.
fn says(message: &str, parts: &[&str]) {
    assert!(message.starts_with("error: "), "{message}");
    for part in parts {
        assert!(message.contains(part), "expected {part:?} in {message}");
    }
}

#[test]
fn instruments() {
    let folder = Folder::new("bad-instruments");
    let cases: [(&str, &str, &[&str]); 6] = [
        ("mass_g = ", "mass = ", &["`body.key_back.mass`", "expected `mass_g`"]),
        (
            "mass_g = { value = 88.98",
            "mass_g = { value = -88.98",
            &["`body.key.mass_g.value`", "-88.98", "greater than 0"],
        ),
        (
            "mass_g = { value = 88.98",
            "mass_g = { value = nan",
            &["`body.key.mass_g.value`", "nan", "not a finite number"],
        ),
        ("mass_g = { value = 88.98", "mass_g = { value = \"heavy\"", &["`body.key.mass_g.value`", "heavy"]),
        ("body = \"lever\"\ncenter_mm", "body = \"leverr\"\ncenter_mm", &["no such body", "\"leverr\"", "`lever`"]),
        ("[[zone]]", "[[zone]", &["TOML"]),
    ];
    for (what, by, parts) in cases {
        let (text, line) = damaged(what, by);
        folder.file("damaged.toml", &text);
        for command in [&["press", "--instrument", "damaged.toml"][..], &["check", "damaged.toml"]] {
            let message = folder.bad(command);
            says(&message, &[&format!("damaged.toml:{line}:")]);
            if by != "[[zone]" {
                says(&message, parts);
            }
        }
    }
    folder.file("empty.toml", "");
    says(&folder.bad(&["press", "--instrument", "empty.toml"]), &["empty.toml", "empty"]);
    says(&folder.bad(&["press", "--instrument", "none.toml"]), &["none.toml", "cannot be read"]);
    says(&folder.bad(&["press", "--instrument", "upright"]), &["`upright`", "concert-grand"]);
}

#[test]
fn strokes() {
    let folder = Folder::new("bad-strokes");
    let cases: [(&str, &str, &[&str]); 9] = [
        ("empty", "", &["empty.csv", "empty", "time_s,force_N"]),
        ("text", "time_s,force_N\n0,1\n0.1,abc\n", &["text.csv:3:", "`force_N`", "`abc`"]),
        ("back", "time_s,force_N\n0,1\n0.1,2\n0.05,3\n", &["back.csv:4:", "`time_s`", "backwards", "0.05"]),
        ("twice", "time_s,force_N\n0,1\n0.1,2\n0.1,3\n", &["twice.csv:4:", "`time_s`", "0.1"]),
        ("one", "time_s,force_N\n0,1\n", &["one.csv:2:", "one row"]),
        ("other", "time_s,pressure\n0,1\n0.1,2\n", &["other.csv:1:", "`force_N`", "`position_m`"]),
        ("no-time", "force_N\n1\n2\n", &["no-time.csv:1:", "`time_s`"]),
        ("infinite", "time_s,force_N\n0,1\n0.1,inf\n", &["infinite.csv:3:", "`force_N`", "inf"]),
        ("short", "time_s,force_N\n0,1\n0.1\n", &["short.csv:3:"]),
    ];
    for (name, text, parts) in cases {
        let file = format!("{name}.csv");
        folder.file(&file, text);
        for command in ["press", "compare", "check"] {
            says(&folder.bad(&[command, &file]), parts);
        }
    }
    says(&folder.bad(&["press", "none.csv"]), &["none.csv", "cannot be read"]);
    folder.file("force.csv", "time_s,force_N\n0,1\n0.1,2\n");
    says(&folder.bad(&["press", "force.csv", "--drive", "motion"]), &["force.csv", "`position_m`"]);
}

/// Too many rows are refused.
#[test]
fn more_rows_than_are_read() {
    refuses_rows(5_000_001);
}

/// Ten million rows are refused while they are read, not after.
#[test]
#[ignore = "ci: ten million rows"]
fn ten_million_rows() {
    refuses_rows(10_000_000);
}

fn refuses_rows(rows: u32) {
    let folder = Folder::new("many-rows");
    let mut file = std::io::BufWriter::new(std::fs::File::create(folder.0.join("many.csv")).unwrap());
    writeln!(file, "time_s,force_N").unwrap();
    for i in 0..rows {
        writeln!(file, "{i}e-6,1").unwrap();
    }
    file.into_inner().unwrap();
    says(&folder.bad(&["press", "many.csv"]), &["many.csv:", "too many rows", "5000000"]);
}

#[test]
fn options() {
    let folder = Folder::new("bad-options");
    for (option, value) in [
        ("--dt", "0"),
        ("--dt", "-1"),
        ("--dt", "1"),
        ("--dt", "nan"),
        ("--theta", "0.3"),
        ("--theta", "2"),
        ("--tolerance", "0"),
        ("--tolerance", "-0.1"),
        ("--tolerance", "1e-12"),
        ("--tolerance", "1"),
        ("--tolerance", "nan"),
        ("--tolerance", "tight"),
        ("--duration", "0"),
        ("--duration", "-1"),
        ("--duration", "inf"),
        ("--force-step", "nan"),
        ("--force-step", "1e9"),
        ("--friction-width", "0"),
        ("--record-every", "0"),
        ("--solver", "guess"),
        ("--drive", "wind"),
        ("--model", "two-dof"),
        ("--stroke", "fff"),
    ] {
        says(&folder.bad(&["press", option, value]), &[option]);
    }
    for lift in ["-7mm", "11mm", "nan mm", "0s=0mm,later=7mm", ""] {
        says(
            &folder.bad(&["press", "--instrument", "concert-grand-strings", "--pedal", lift]),
            &["--pedal", "expected a lift"],
        );
    }
    says(&folder.bad(&["press", "--force-step", "2", "--stroke", "mf"]), &["--force-step", "--stroke"]);
    says(&folder.bad(&["draw", "--at", "-1"]), &["--at"]);
    says(&folder.bad(&["draw", "--at", "lunch"]), &["--at", "let-off"]);
    // Too weak a push to reach the string, let alone be checked.
    says(&folder.bad(&["draw", "--force-step", "0.1", "--at", "check"]), &["--at check", "no check"]);
}

/// A folder that cannot be one: below a file. What stands there stays.
#[test]
fn output_folders() {
    let folder = Folder::new("bad-output");
    folder.file("note.txt", "keep me");
    for out in ["note.txt", "note.txt/below"] {
        for command in [&["press"][..], &["draw"]] {
            let arguments: Vec<&str> = command.iter().copied().chain(["--out", out]).collect();
            says(&folder.bad(&arguments), &["note.txt", "cannot be written"]);
        }
    }
    assert_eq!(folder.read("note.txt"), "keep me");
}

/// A folder behind a loop of links is refused before anything is computed.
#[test]
#[cfg(unix)]
fn a_loop_of_links() {
    let folder = Folder::new("bad-links");
    for (from, to) in [("a", "b"), ("b", "a")] {
        std::os::unix::fs::symlink(from, folder.0.join(to)).unwrap();
    }
    for out in ["a", "a/b"] {
        let began = std::time::Instant::now();
        // Ten minutes of touch would take seconds.
        let message = folder.bad(&["press", "--force-step", "6", "--duration", "600", "--out", out]);
        says(&message, &[out, "links"]);
        assert!(began.elapsed().as_secs_f64() < 2.0, "{:?}", began.elapsed());
    }
}

/// A message names the option that was typed.
#[test]
fn the_option_that_was_typed() {
    let folder = Folder::new("bad-option-names");
    let message = folder.bad(&["press", "--force-step", "5N", "--against", "1e9N"]);
    says(&message, &["--against 1000000000"]);
    assert!(!message.contains("--force-step 1"), "{message}");
    says(&folder.bad(&["press", "--force-step", "1e9N"]), &["--force-step 1000000000"]);
}

/// A title of 60 000 letters or of 20 000 words costs no more than a short one.
#[test]
fn titles_without_end() {
    let folder = Folder::new("bad-titles");
    for title in ["x".repeat(60_000), "ab ".repeat(20_000)] {
        folder.file("long.csv", &format!("time_s,{title},force_N\n0,1,1\n0.1,1,5\n0.2,1,5\n"));
        let began = std::time::Instant::now();
        folder.good(&["check", "long.csv"]);
        assert!(began.elapsed().as_secs_f64() < 2.0, "{:?}", began.elapsed());
    }
}
