//! Faults put into every call by which results are written: an error, or a signal of every kind. Whatever happens, the
//! old results stand there or the new ones, and the next run clears up.
//!
//! The calls are found and disturbed by strace, where it is there and may trace. A few are disturbed in every run of
//! the tests, a fifth of them by the ignored test, and every one of them by that with `ERARD_FAULTS=all`.
#![cfg(target_os = "linux")]

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

use crate::common::Folder;
use crate::not_run::not_run;

const ERARD: &str = env!("CARGO_BIN_EXE_erard");
/// Calls by which the file system is changed. Those for threads and the terminal stay as they are.
const CALLS: &str = "mkdir,openat,write,fsync,rename,renameat,renameat2,unlink,unlinkat,rmdir,chmod,fchmod,flock";

/// The command under strace with one injection.
fn traced(folder: &Folder, inject: &[String], out: &str, dt: &str) -> Command {
    let mut command = Command::new("strace");
    command.args(["-f", "-q", "-o", "trace"]).args(inject);
    command.args([ERARD, "press", "--duration", "0.002", "--dt", dt, "--out", out]);
    command.current_dir(&folder.0).stdout(Stdio::null()).stderr(Stdio::null());
    command
}

/// Steps by the summary, and rows by the table: those of one run agree.
fn run(folder: &Folder, out: &str) -> (u64, u64) {
    let summary: serde_json::Value = serde_json::from_str(&folder.read(&format!("{out}/summary.json"))).unwrap();
    (summary["steps"].as_u64().unwrap(), folder.read(&format!("{out}/run.csv")).lines().count() as u64 - 2)
}

fn leftovers(folder: &Path) -> usize {
    let names = fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap());
    names.filter(|name| name.ends_with(".part")).count()
}

#[test]
fn a_call_fails() {
    calls_fail(&["shared"], 80);
}

#[test]
#[ignore = "ci: some twenty-five faults"]
fn calls_of_all_kinds_fail() {
    calls_fail(&["own", "shared"], 10);
}

mod nightly {
    #[test]
    #[ignore = "nightly: some fifty faults"]
    fn every_call_fails_once() {
        super::calls_fail(&["own", "shared"], 5);
    }
}

/// Disturbs one of so many calls, and five times as many of those that rename.
fn calls_fail(folders: &[&str], of: usize) {
    let folder = Folder::new("faults");
    let old = ["-e".to_owned(), format!("trace={CALLS}")];
    match traced(&folder, &old, "own", "5e-5").status() {
        Ok(status) if status.success() => {}
        other => {
            not_run(&format!("no strace that may trace ({other:?})"));
            return;
        }
    }
    // Among files of the user's, where results are renamed one by one.
    fs::create_dir(folder.0.join("shared")).unwrap();
    folder.file("shared/mine", "mine");
    folder.good(&["press", "--duration", "0.002", "--out", "shared"]);
    let all = std::env::var("ERARD_FAULTS").is_ok_and(|which| which == "all");
    let (mut tried, mut new) = (0, 0);
    for &out in folders {
        assert!(traced(&folder, &old, out, "5e-5").status().unwrap().success());
        // The calls that concern the results, by their number among calls of the same name.
        let trace = folder.read("trace");
        let mut counts = std::collections::BTreeMap::<&str, usize>::new();
        let mut points = Vec::new();
        for line in trace.lines() {
            let Some(call) = line.split_whitespace().nth(1).and_then(|call| call.split('(').next()) else { continue };
            let Some(call) = CALLS.split(',').find(|known| *known == call) else { continue };
            let number = counts.entry(call).or_default();
            *number += 1;
            if line.contains(".part") || (call == "fsync") || (call == "write" && !line.contains("write(1")) {
                points.push((call, *number));
            }
        }
        assert!(points.len() > 20, "{points:?} {trace}");
        for (index, (call, number)) in points.into_iter().enumerate() {
            // Every call takes minutes. Of the others than renames a fifth is enough to see that nothing is lost.
            let of = if call.starts_with("rename") { of / 5 } else { of };
            if !(all || index.is_multiple_of(of)) {
                continue;
            }
            let faults = ["error=ENOSPC", "error=EIO", "signal=KILL", "signal=TERM", "signal=INT", "signal=HUP"];
            // All faults take turns; the renames suffer the hardest one too.
            let turn = faults[index % faults.len()];
            let chosen = if all && call.starts_with("rename") { vec![turn, "signal=KILL"] } else { vec![turn] };
            for fault in chosen {
                let inject = ["-e".to_owned(), format!("inject={call}:{fault}:when={number}")];
                traced(&folder, &inject, out, "1e-4").status().unwrap();
                tried += 1;
                let what = format!("{out}: {call} {number} {fault}");
                if fault == "signal=KILL" && leftovers(&folder.0.join(out)) > 0 {
                    // The next run finishes or undoes before it does its own.
                    let output = folder.erard(&[
                        "press",
                        "--duration",
                        "0.002",
                        "--dt",
                        "1e-4",
                        "--out",
                        out,
                        "--drive",
                        "rigid",
                    ]);
                    assert!(output.status.success(), "{what}: {}", String::from_utf8_lossy(&output.stderr));
                }
                let (steps, rows) = run(&folder, out);
                assert_eq!(steps, rows, "{what}");
                new += u32::from(steps == 20);
                folder.good(&["press", "--duration", "0.002", "--dt", "5e-5", "--out", out]);
                assert_eq!(run(&folder, out), (40, 40), "{what}");
                assert_eq!(leftovers(&folder.0) + leftovers(&folder.0.join(out)), 0, "{what}");
            }
        }
    }
    assert_eq!(folder.read("shared/mine"), "mine");
    assert_eq!(folder.names(), ["own", "shared", "trace"]);
    println!("{tried} faults; after {new} of them stood the new results");
}

/// A disk of any size too small: the old results stay, and there is room again.
#[test]
fn a_full_disk() {
    disk_is_full("0 100");
}

#[test]
#[ignore = "ci: disks of seven sizes"]
fn full_disks_of_any_size() {
    disk_is_full("0 8 40 100 200 300 400");
}

/// With so many KiB left.
fn disk_is_full(sizes: &str) {
    let folder = Folder::new("full-disk");
    fs::create_dir(folder.0.join("disk")).unwrap();
    // In a world of its own, where a small disk may be mounted.
    let script = format!(
        "mount -t tmpfs -o size=900k tmpfs disk || exit 77\n\
         '{ERARD}' press --duration 0.002 --out disk/x || exit 1\n\
         cksum disk/x/* disk/x/.erard.json > before\n\
         for kib in {sizes}; do\n\
           free=$(df -k --output=avail disk | tail -1)\n\
           dd if=/dev/zero of=disk/filler bs=1k count=$((free > kib ? free - kib : 0)) 2> /dev/null\n\
           '{ERARD}' press --duration 0.01 --out disk/x 2> said; code=$?\n\
           rm disk/filler\n\
           [ $code = 2 ] && grep -q 'No space left' said || {{ echo $kib $code; cat said; exit 2; }}\n\
           cksum disk/x/* disk/x/.erard.json | cmp - before || exit 3\n\
           [ -z \"$(find disk -name '*.part')\" ] || exit 4\n\
         done"
    );
    let mut command = Command::new("unshare");
    command.args(["--user", "--map-root-user", "--mount", "bash", "-c", &script]).current_dir(&folder.0);
    match command.output() {
        Ok(output) if output.status.success() => {}
        Ok(output)
            if output.status.code() == Some(77) || String::from_utf8_lossy(&output.stderr).contains("unshare") =>
        {
            not_run("no disk may be mounted");
        }
        Ok(output) => panic!("{output:?}"),
        Err(error) => not_run(&format!("no unshare: {error}")),
    }
}
