//! Requests to end are heard at once, whatever is going on, and leave nothing half done.
#![cfg(unix)]

use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use crate::common::Folder;
use crate::common::signals::until_it_listens;

/// A request that was heard ends the process within this time, however busy the machine is: none of the commands here
/// would be over by then. How long it takes on an idle machine, some hundredths of a second, is not for a test to say.
const HEARD: Duration = Duration::from_secs(8);

fn send(signal: &str, to: i64) {
    assert!(Command::new("kill").args([signal, "--", &to.to_string()]).status().unwrap().success());
}

fn ended(child: &mut Child, what: &str) -> ExitStatus {
    let asked = Instant::now();
    while asked.elapsed() < HEARD {
        if let Some(status) = child.try_wait().unwrap() {
            return status;
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    child.kill().unwrap();
    panic!("{what}: not ended after {HEARD:?}");
}

/// A mill in the water, which finds no rest.
fn mill() -> String {
    let wheel = |n: u32| {
        format!(
            "{{ name = \"wheel{n}\", pivot_mm = [{n}, 0], mass_g = 1, inertia_kg_m2 = 1e-3, center_of_mass_mm = [0, 0] }}"
        )
    };
    let spring = |n: u32| {
        format!("{{ name = \"water{n}\", body = \"wheel{n}\", torque_N_m = 1e-4, stiffness_N_m_per_rad = 0 }}")
    };
    let list = |of: &dyn Fn(u32) -> String| (1..=8).map(of).collect::<Vec<_>>().join(", ");
    format!(
        "format = \"erard-instrument/1\"\nname = \"A mill\"\ngravity_m_s2 = 9.81\nbody = [{}]\nspring = [{}]\n\
         finger = {{ stiffness_N_per_m = 1e4, damping_N_s_per_m = 1 }}\nroles = {{ key = \"wheel1\", key_front_mm = [1, 0] }}\n",
        list(&wheel),
        list(&spring)
    )
}

/// Control-C while a rest is sought, while files are written, while many cores work: code
/// 130, nothing left.
#[test]
fn control_c_is_heard() {
    heard(false);
}

#[test]
#[ignore = "ci: Control-C at many moments of ten commands"]
fn control_c_is_heard_everywhere() {
    heard(true);
}

/// At one moment of each command, or at all.
fn heard(everywhere: bool) {
    let folder = Folder::new("control-c");
    folder.file("mill.toml", &mill());
    folder.file("mf.csv", include_str!("../../../erard-core/recordings/heavier-mf.csv"));
    let before = folder.names();
    for (arguments, delays_ms) in [
        (&["press", "--drive", "force", "--instrument", "mill.toml"][..], &[30_u64][..]),
        (&["press", "--duration", "100000"], &[50, 300]),
        (&["press", "--duration", "20", "--record-every", "1"], &[800, 1500, 2000]),
        (&["study", "--vary", "let_off=-1mm..1mm:100000"], &[300]),
        (&["measure"], &[200]),
        // Strokes are prepared, played side by side, and with derivatives.
        (&["fit", "concert-grand", "mf.csv", "--parameters", "body.hammer.mass"], &[100, 500]),
        (
            &["fit", "concert-grand", "mf.csv", "--parameters", "body.hammer.mass", "--jacobian", "gradient"],
            &[400, 900],
        ),
    ] {
        for &delay_ms in delays_ms.iter().take(if everywhere { delays_ms.len() } else { 1 }) {
            let mut child = folder.command(arguments).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
            until_it_listens(&mut child);
            std::thread::sleep(Duration::from_millis(delay_ms));
            if let Some(status) = child.try_wait().unwrap() {
                // A fast machine had finished: then there is nothing to interrupt. A mill finds no rest.
                assert!(delay_ms > 20, "{arguments:?}: {status}");
            } else {
                send("-INT", i64::from(child.id()));
                let status = ended(&mut child, &format!("{arguments:?} after {delay_ms} ms"));
                // A fit that has ended may have doubts.
                let done = status.success() || arguments[0] == "fit" && status.code() == Some(1);
                assert!(status.code() == Some(130) || done, "{arguments:?}: {status}");
            }
            let names = folder.names();
            assert!(names.iter().all(|name| !name.starts_with('.')), "{arguments:?} after {delay_ms} ms: {names:?}");
            for name in names.iter().filter(|name| !before.contains(name)) {
                // It was done before it was heard.
                std::fs::remove_dir_all(folder.0.join(name)).unwrap();
            }
        }
    }
}

/// Other requests end it as they end any program, and leave nothing either.
#[test]
fn polite_kills() {
    let folder = Folder::new("kills");
    for (signal, number) in [("-TERM", 15), ("-HUP", 1), ("-XCPU", 24)] {
        let mut child = folder.command(&["press", "--duration", "100000"]).stderr(Stdio::null()).spawn().unwrap();
        while folder.names().is_empty() {
            assert!(child.try_wait().unwrap().is_none());
            std::thread::sleep(Duration::from_millis(2));
        }
        send(signal, i64::from(child.id()));
        assert_eq!(ended(&mut child, signal).signal(), Some(number));
        assert_eq!(folder.names(), Vec::<String>::new(), "{signal}");
    }
}

/// What was ignored from the start stays so: `nohup`.
#[cfg(target_os = "linux")]
#[test]
fn hanging_up_is_ignored_where_that_was_asked_for() {
    let folder = Folder::new("nohup");
    let command = format!("trap '' HUP; exec '{}' press --duration 100000", env!("CARGO_BIN_EXE_erard"));
    let mut child =
        Command::new("bash").args(["-c", &command]).current_dir(&folder.0).stderr(Stdio::null()).spawn().unwrap();
    while folder.names().is_empty() {
        std::thread::sleep(Duration::from_millis(2));
    }
    send("-HUP", i64::from(child.id()));
    std::thread::sleep(Duration::from_millis(200));
    assert!(child.try_wait().unwrap().is_none(), "it goes on");
    send("-TERM", i64::from(child.id()));
    assert_eq!(ended(&mut child, "SIGTERM").signal(), Some(15));
}

/// A shell that plays one stroke after another ends with the first that is interrupted, and says 130.
#[cfg(target_os = "linux")]
#[test]
fn a_loop_in_a_shell_stops() {
    let folder = Folder::new("loop");
    let press = format!("'{}' press --duration 100000", env!("CARGO_BIN_EXE_erard"));
    let mut shell = Command::new("bash")
        .args(["-c", &format!("for n in 1 2 3; do {press}; echo $? >> codes; done")])
        .current_dir(&folder.0)
        .stderr(Stdio::null())
        .process_group(0)
        .spawn()
        .unwrap();
    while folder.names().is_empty() {
        std::thread::sleep(Duration::from_millis(2));
    }
    // As a terminal does: to all of the group.
    send("-INT", -i64::from(shell.id()));
    ended(&mut shell, "the loop");
    assert!(!folder.0.join("codes").exists());
    // To the command alone: the shell goes on, with the code.
    let script = format!("{press} & sleep 0.5; kill -TERM $!; wait $!; echo $? > codes");
    let status =
        Command::new("bash").args(["-c", &script]).current_dir(&folder.0).stderr(Stdio::null()).status().unwrap();
    assert!(status.success());
    assert_eq!(folder.read("codes").trim(), "143");
}

/// Asked twice in a row, and at every moment of a short run: the old results or the new ones, all of them.
#[test]
fn asked_again_and_at_any_moment() {
    at_moments(4, 60);
}

#[test]
#[ignore = "ci: sixty moments"]
fn asked_again_and_at_many_moments() {
    at_moments(60, 5);
}

fn at_moments(rounds: u64, apart_ms: u64) {
    let folder = Folder::new("again");
    let short = |dt: &'static str| ["press", "--duration", "0.02", "--dt", dt];
    folder.good(&short("5e-5"));
    let rows = |folder: &Folder| {
        let steps = folder.read("erard-out/summary.json");
        let steps: serde_json::Value = serde_json::from_str(&steps).unwrap();
        (steps["steps"].as_u64().unwrap(), folder.read("erard-out/run.csv").lines().count() as u64 - 2)
    };
    let mut seen = [0, 0];
    for round in 0..rounds {
        let dt = if round.is_multiple_of(2) { "1e-4" } else { "5e-5" };
        let mut child = folder.command(&short(dt)).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        std::thread::sleep(Duration::from_millis(apart_ms * round));
        let signal = ["-INT", "-TERM", "-HUP", "-KILL"][round as usize % 4];
        // What has ended by itself needs none.
        if child.try_wait().unwrap().is_none() {
            for _ in 0..2 {
                let _ = Command::new("kill").args([signal, &child.id().to_string()]).stderr(Stdio::null()).status();
            }
        }
        child.wait().unwrap();
        let (steps, rows) = rows(&folder);
        assert_eq!(steps, rows, "round {round}: of one run");
        seen[usize::from(steps == 200)] += 1;
        let names = folder.names();
        assert!(names.len() <= 2, "at most what one killed run left: {names:?}");
    }
    folder.good(&short("5e-5"));
    assert_eq!(folder.names(), ["erard-out"], "what was left is cleared");
    println!("{seen:?}");
}
