//! What a command reads it does not write over; what it writes appears whole or not at all; what belongs to others
//! stays.

use std::fs;
use std::process::Output;

use crate::common::Folder;
use crate::common::tree::look;

const GRAND: &str = include_str!("../../../erard-core/instruments/concert-grand.toml");
const STROKE: &str = "time_s,force_N\n0,0\n0.01,3\n0.02,3\n";
const SHORT: [&str; 3] = ["press", "--duration", "0.005"];

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Fails with code 2, and not a byte is another.
fn refused(folder: &Folder, arguments: &[&str], why: &str) {
    let before = look(&folder.0);
    let message = folder.bad(arguments);
    assert!(message.contains(why), "{arguments:?}: {message}");
    assert_eq!(look(&folder.0), before, "{arguments:?}");
}

/// An output that is one of the inputs: by its name, through links of either kind, with `--force` too.
#[test]
fn an_input_is_never_replaced() {
    let reads = "is an input of this command";
    let folder = Folder::new("inputs");
    folder.file("run.csv", STROKE);
    for force in [&[][..], &["--force"]] {
        let with = |arguments: &[&'static str]| [arguments, force].concat();
        refused(&folder, &with(&["press", "run.csv", "--out", "."]), reads);
    }
    folder.file("compare.csv", STROKE);
    refused(&folder, &["compare", "compare.csv", "--out", "."], reads);
    folder.file("action.svg", GRAND);
    refused(&folder, &["draw", "--instrument", "action.svg", "--out", ".", "--force"], reads);
    // Results of an earlier run that the new one would take away.
    let own = Folder::new("inputs-stale");
    own.good(&["study", "--vary", "let_off=0mm,0.1mm", "--duration", "0.005", "--out", "s"]);
    fs::write(own.0.join("s/study.svg"), STROKE).unwrap();
    let values = (0..9).map(|i| format!("{i}.5")).collect::<Vec<_>>().join(",");
    let many = format!("capstan_height=0mm,{values}");
    let before = look(&own.0);
    let output = own.erard(&[
        "study",
        "s/study.svg",
        "--vary",
        "let_off=0mm,0.1mm",
        "--vary",
        &many,
        "--duration",
        "0.005",
        "--out",
        "s",
    ]);
    assert_eq!(output.status.code(), Some(2), "{}", said(&output));
    assert!(said(&output).contains(reads), "{}", said(&output));
    assert_eq!(look(&own.0), before);
    #[cfg(unix)]
    {
        let folder = Folder::new("inputs-links");
        folder.file("stroke.csv", STROKE);
        std::os::unix::fs::symlink("stroke.csv", folder.0.join("run.csv")).unwrap();
        refused(&folder, &["press", "stroke.csv", "--out", ".", "--force"], reads);
        fs::remove_file(folder.0.join("run.csv")).unwrap();
        fs::hard_link(folder.0.join("stroke.csv"), folder.0.join("run.csv")).unwrap();
        refused(&folder, &["press", "stroke.csv", "--out", ".", "--force"], reads);
        fs::remove_file(folder.0.join("stroke.csv")).unwrap();
        std::os::unix::fs::symlink("run.csv", folder.0.join("stroke.csv")).unwrap();
        refused(&folder, &["press", "stroke.csv", "--out", ".", "--force"], reads);
    }
    // The base of a keyboard is read too.
    let keys = Folder::new("inputs-keyboard");
    keys.file("key.toml", GRAND);
    let keyboard = include_str!("../../../erard-core/keyboards/concert-grand.toml");
    keys.file("keys.toml", &keyboard.replacen("instrument = \"concert-grand\"", "instrument = \"key.toml\"", 1));
    refused(
        &keys,
        &["regulate", "keys.toml:key=40", "--dip", "10mm", "--out-file", "key.toml", "--force"],
        "is the input instrument",
    );
}

/// With a folder in the way of one result all of the old ones stay, and nothing half done with them.
#[test]
fn all_results_or_none() {
    let folder = Folder::new("all-or-none");
    folder.good(&SHORT);
    fs::remove_file(folder.0.join("erard-out/run.html")).unwrap();
    fs::create_dir(folder.0.join("erard-out/run.html")).unwrap();
    refused(&folder, &SHORT, "run.html: is a folder");
}

/// Every command has a folder of its own unless told otherwise, and none touches another's; the same command again
/// replaces its own.
#[test]
fn results_of_different_commands() {
    let folder = Folder::new("commands");
    folder.good(&SHORT);
    let summary = folder.read("erard-out/summary.json");
    folder.good(&["draw"]);
    assert_eq!(folder.read("erard-out/summary.json"), summary);
    assert!(folder.read("erard-out-draw/action.svg").starts_with("<svg"));
    folder.good(&SHORT);
    folder.good(&["draw", "--at", "20"]);
    // A figure belongs to its table.
    let study = |more: &[&str]| {
        folder.good(&[&["study", "--vary", "let_off=-0.1mm,0mm", "--duration", "0.005"], more].concat());
        folder.0.join("erard-out-study/study.svg").exists()
    };
    assert!(study(&[]));
    assert!(!study(&["--vary", "drop=-0.3mm,-0.2mm,-0.1mm,0mm,0.1mm,0.2mm,0.3mm,0.4mm"]));
    let mut names = folder.names();
    names.retain(|name| !name.starts_with("erard-out"));
    assert_eq!(names, Vec::<String>::new());
}

/// What a killed run left is cleared away by the next one, in every kind of folder.
#[test]
fn what_a_killed_run_left() {
    let folder = Folder::new("left");
    folder.good(&[&SHORT[..], &["--out", "own"]].concat());
    folder.file("note", "mine");
    folder.good(&[&SHORT[..], &["--out", "."]].concat());
    let before = (folder.names(), folder.read("run.csv"));
    for out in ["own", "new/er", "."] {
        let long = ["press", "--duration", "100000", "--out", out];
        let mut child = folder.command(&long).spawn().unwrap();
        let stages = || {
            let below = [folder.0.clone(), folder.0.join("new")];
            let names = below.into_iter().filter_map(|f| fs::read_dir(f).ok()).flatten();
            names.filter(|e| e.as_ref().unwrap().file_name().to_string_lossy().ends_with(".part")).count()
        };
        while stages() == 0 {
            assert!(child.try_wait().unwrap().is_none());
            std::thread::sleep(std::time::Duration::from_millis(2));
        }
        child.kill().unwrap();
        child.wait().unwrap();
        assert_eq!((stages(), folder.read("run.csv")), (1, before.1.clone()));
        folder.good(&[&SHORT[..], &["--out", out]].concat());
        assert_eq!(stages(), 0, "{out}");
        let _ = fs::remove_dir_all(folder.0.join("new"));
        assert_eq!(folder.names(), before.0);
    }
}

/// A name that somebody could foresee is not written to, wherever it leads.
#[cfg(unix)]
#[test]
fn links_are_not_followed() {
    let folder = Folder::new("followed");
    folder.file("precious", "mine");
    fs::create_dir(folder.0.join("out")).unwrap();
    for name in ["run.csv", ".erard.json", "summary.json"] {
        std::os::unix::fs::symlink("../precious", folder.0.join("out").join(name)).unwrap();
    }
    refused(&folder, &[&SHORT[..], &["--out", "out"]].concat(), "was not written by");
    folder.good(&[&SHORT[..], &["--out", "out", "--force"]].concat());
    assert_eq!(folder.read("precious"), "mine");
    assert!(!folder.0.join("out/run.csv").symlink_metadata().unwrap().is_symlink());
}

/// What does not arrive on standard output is an error; a reader that has read enough is none; an error that cannot be
/// told is no crash.
#[cfg(target_os = "linux")]
#[test]
fn standard_output() {
    let folder = Folder::new("full-device");
    let full = || fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    for arguments in [&["keyboard", "--key", "5"][..], &["check", "a.toml"], &["--help"], &["press", "--help"], &SHORT]
    {
        folder.file("a.toml", GRAND);
        let output = folder.command(arguments).stdout(full()).output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(said(&output).contains("standard output cannot be written: No space left"), "{}", said(&output));
    }
    for arguments in [&["check", "none.toml"][..], &["press", "--dt", "7"], &["nonsense"]] {
        let output = folder.command(arguments).stderr(full()).output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: no panic");
    }
}

/// A file without room leaves the old results: a limit of its size, a full disk.
#[cfg(unix)]
#[test]
fn no_room() {
    let folder = Folder::new("no-room");
    folder.good(&SHORT);
    let before = look(&folder.0);
    let limited = format!("ulimit -f 20; exec '{}' press", env!("CARGO_BIN_EXE_erard"));
    let output = std::process::Command::new("bash").args(["-c", &limited]).current_dir(&folder.0).output().unwrap();
    assert_eq!(output.status.code(), Some(2), "{}", said(&output));
    assert!(said(&output).contains("erard-out/run.csv: cannot be written"), "{}", said(&output));
    assert_eq!(look(&folder.0), before);
    assert_eq!(folder.names(), ["erard-out"]);
}

/// Pipes are read once, whatever they hold.
#[cfg(unix)]
#[test]
fn pipes() {
    use std::io::Write;
    let folder = Folder::new("pipes");
    for (arguments, text) in [
        (&["press", "--duration", "0.005", "--instrument", "/dev/stdin"][..], GRAND),
        (&["press", "--duration", "0.005", "/dev/stdin"], STROKE),
        (&["compare", "/dev/stdin", "--out", "compare"], STROKE),
    ] {
        let mut child = folder
            .command(arguments)
            .stdin(std::process::Stdio::piped())
            .stderr(std::process::Stdio::piped())
            .spawn()
            .unwrap();
        child.stdin.take().unwrap().write_all(text.as_bytes()).unwrap();
        let output = child.wait_with_output().unwrap();
        assert!(output.status.success(), "{arguments:?}: {}", said(&output));
    }
    let status = std::process::Command::new("mkfifo").arg(folder.0.join("fifo.toml")).status().unwrap();
    assert!(status.success());
    let writer = folder.0.join("fifo.toml");
    let writing = std::thread::spawn(move || fs::write(writer, GRAND).unwrap());
    assert!(folder.good(&["check", "fifo.toml"]).contains("an instrument"));
    writing.join().unwrap();
}
