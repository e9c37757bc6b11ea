//! Memory is bounded by what is promised, and what goes beyond it is refused before the work begins.

use std::fs;

use crate::common::Folder;

/// Address space that a command may take where it has to refuse, KiB: the program itself and a file at its limit.
#[cfg(target_os = "linux")]
const ROOM_KIB: u32 = 700 * 1024;

/// Runs within that room; what it says on standard error. Code 2 is expected.
#[cfg(target_os = "linux")]
fn refused(folder: &Folder, arguments: &str) -> String {
    let command = format!("ulimit -v {ROOM_KIB}; exec '{}' {arguments}", env!("CARGO_BIN_EXE_erard"));
    let output = std::process::Command::new("bash").args(["-c", &command]).current_dir(&folder.0).output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{arguments}: {said}");
    said
}

/// Files over their limits, and devices without end: refused after the limit is read.
#[cfg(target_os = "linux")]
#[test]
fn files() {
    let folder = Folder::new("limits-files");
    let sparse = fs::File::create(folder.0.join("big.toml")).unwrap();
    sparse.set_len(3 << 30).unwrap();
    folder.file("comments.toml", &"#\n".repeat(25 << 20));
    for arguments in [
        "check big.toml",
        "check comments.toml",
        "press --instrument comments.toml",
        "press --instrument /dev/zero",
        "keyboard big.toml",
        "regulate big.toml",
        "measure big.toml:key=3",
    ] {
        let said = refused(&folder, arguments);
        assert!(said.contains("larger than 4 MiB"), "{arguments}: {said}");
    }
    let said = refused(&folder, "press /dev/zero");
    assert!(said.contains("this is not a table"), "{said}");
    assert_eq!(folder.names(), ["big.toml", "comments.toml"]);
}

/// A file at its limit is read, and what is said of it stays short.
#[cfg(target_os = "linux")]
#[test]
fn a_file_at_its_limit() {
    let folder = Folder::new("limits-at");
    folder.file("comments.toml", &"#\n".repeat((4 << 20) / 2 - 1));
    assert!(refused(&folder, "check comments.toml").contains("`format`"));
    folder.file("line.toml", &format!("format = \"{}\"\n", "x".repeat(2_000_000)));
    let said = refused(&folder, "check line.toml");
    assert!(said.contains("line.toml:1:") && said.len() < 1000, "{} characters", said.len());
    let name = format!("name = \"{}\"\n", "x".repeat(200));
    let grand = include_str!("../../../erard-core/instruments/concert-grand.toml");
    let own = grand.lines().find(|line| line.starts_with("name = ")).unwrap();
    folder.file("name.toml", &grand.replacen(own, name.trim(), 1));
    assert!(refused(&folder, "check name.toml").contains("too long for a name"));
}

/// Runs that would keep more than can be held say so before they start, with the option that helps.
#[cfg(target_os = "linux")]
#[test]
fn rows() {
    let folder = Folder::new("limits-rows");
    folder.file("long.csv", "time_s,force_N\n0,0\n10000,1\n");
    for (arguments, parts) in [
        ("press --duration 1e6 --record-every 1", ["--record-every", "20000"]),
        ("press --duration 60 --record-every 1", ["--record-every", "every 2 steps or more"]),
        ("compare long.csv", ["long.csv", "--duration 250"]),
        ("study --vary let_off=0..1:2000 --vary drop=0..1:2000", ["2000000", "fewer values"]),
    ] {
        let said = refused(&folder, arguments);
        assert!(parts.iter().all(|part| said.contains(part)), "{arguments}: {said}");
    }
    assert_eq!(folder.names(), ["long.csv"]);
    let told = folder.good(&["check", "long.csv"]);
    assert!(told.contains("`--duration 250`"), "{told}");
    let told = folder.good(&["compare", "long.csv", "--duration", "0.1"]);
    assert!(told.contains("driven by force"), "{told}");
}

/// Control characters from files and arguments reach neither stream as they are.
#[cfg(unix)]
#[test]
fn nothing_steers_the_terminal() {
    let folder = Folder::new("limits-steers");
    let grand = include_str!("../../../erard-core/instruments/concert-grand.toml");
    let name = grand.lines().find(|line| line.starts_with("name = ")).unwrap();
    let raw = |output: std::process::Output| {
        assert_eq!(output.status.code(), Some(2));
        [output.stdout, output.stderr].concat().contains(&0x1b)
    };
    folder.file("name.toml", &grand.replacen(name, "name = \"a\\u001b[31m\"", 1));
    let said = folder.bad(&["press", "--instrument", "name.toml"]);
    assert!(said.contains("control character"), "{said}");
    folder.file("raw.toml", "name = \u{1b}[31m\n");
    assert!(!raw(folder.erard(&["check", "raw.toml"])));
    folder.file("raw.csv", "time_s,\u{1b}[31mforce_lbf\n0,0\n1,1\n");
    assert!(!raw(folder.erard(&["check", "raw.csv"])));
    for arguments in [
        &["check", "\u{1b}[31m.toml"][..],
        &["press", "\u{1b}[31m.csv"],
        &["press", "--instrument", "\u{1b}[31m"],
        &["press", "--dt", "\u{1b}[31m"],
        &["study", "--vary", "\u{1b}[31m=1"],
        &["\u{1b}[31m"],
    ] {
        assert!(!raw(folder.erard(arguments)), "{arguments:?}");
    }
    // Where the work is done all the same, the path is shown by its code.
    folder.file("\u{1b}[31m.csv", "time_s,force_N\n0,0\n0.01,1\n");
    let printed = folder.good(&["press", "\u{1b}[31m.csv", "--duration", "0.005", "--out", "\u{1b}out"]);
    assert!(!printed.contains('\u{1b}') && printed.contains("\\u{1b}"), "{printed}");
}

/// A keyboard that points outside its folder shows nothing of what stands there.
#[test]
fn keyboards_do_not_show_other_files() {
    let folder = Folder::new("limits-keyboard");
    folder.file("secret", "password = hunter2\n");
    fs::create_dir(folder.0.join("keys")).unwrap();
    let keyboard = include_str!("../../../erard-core/keyboards/concert-grand.toml");
    let pointing = |to: &str| keyboard.replacen("instrument = \"concert-grand\"", &format!("instrument = \"{to}\""), 1);
    folder.file("keys/out.toml", &pointing("../secret"));
    folder.file("keys/in.toml", &pointing("secret"));
    let said = folder.bad(&["check", "keys/out.toml"]);
    assert!(!said.contains("hunter2") && !said.contains("password"), "{said}");
    assert!(said.contains("`instrument`") && said.contains("erard check"), "{said}");
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("../secret", folder.0.join("keys/secret")).unwrap();
        let said = folder.bad(&["check", "keys/in.toml"]);
        assert!(!said.contains("hunter2") && !said.contains("password"), "{said}");
        fs::remove_file(folder.0.join("keys/secret")).unwrap();
    }
    // Beside the keyboard it is its author's own.
    folder.file("keys/secret", "password = 5\n");
    assert!(folder.bad(&["check", "keys/in.toml"]).contains("password"));
    // Elsewhere too it may be used.
    folder.file("grand.toml", include_str!("../../../erard-core/instruments/concert-grand.toml"));
    folder.file("keys/out.toml", &pointing("../grand.toml"));
    assert!(folder.good(&["keyboard", "keys/out.toml", "--key", "88"]).contains("key 88"));
}

#[test]
#[ignore = "ci: all 88 keys"]
fn keyboards_with_an_instrument_elsewhere_are_checked() {
    let folder = Folder::new("limits-keyboard-elsewhere");
    let keyboard = include_str!("../../../erard-core/keyboards/concert-grand.toml");
    fs::create_dir(folder.0.join("keys")).unwrap();
    folder.file("grand.toml", include_str!("../../../erard-core/instruments/concert-grand.toml"));
    let pointing = keyboard.replacen("instrument = \"concert-grand\"", "instrument = \"../grand.toml\"", 1);
    folder.file("keys/out.toml", &pointing);
    assert!(folder.good(&["check", "keys/out.toml"]).contains("88"));
}

/// Numbers below zero are reported as numbers of their option.
#[test]
fn negative_numbers() {
    let folder = Folder::new("limits-negative");
    folder.file("stroke.csv", "time_s,force_N\n0,0\n1,1\n");
    for arguments in [
        &["press", "--record-every", "-1"][..],
        &["press", "--friction-width", "-1"],
        &["press", "--dt", "-1"],
        &["keyboard", "--every", "-1"],
        &["keyboard", "--key", "-1"],
        &["compare", "--duration", "-1", "stroke.csv"],
    ] {
        let said = folder.bad(arguments);
        assert!(said.contains(arguments[1]) && said.contains("-1") && !said.contains("unexpected argument"), "{said}");
    }
}

/// Peak memory of a command, MiB, as the system counted it when the command had its answer or its error and could not
/// end: both go to a pipe that is full.
#[cfg(target_os = "linux")]
fn peak_mib(folder: &Folder, arguments: &[&str]) -> f64 {
    use rustix::fs::OFlags;
    use std::io::Write;
    use std::os::{fd::AsRawFd, unix::fs::OpenOptionsExt};
    let (answer, full) = std::io::pipe().unwrap();
    let filling = fs::OpenOptions::new()
        .write(true)
        .custom_flags(OFlags::NONBLOCK.bits() as i32)
        .open(format!("/proc/self/fd/{}", full.as_raw_fd()));
    let mut filling = filling.unwrap();
    while filling.write(&[b'.'; 4096]).is_ok() {}
    let mut child = folder.command(arguments).stdout(full.try_clone().unwrap()).stderr(full).spawn().unwrap();
    let own = format!("/proc/{}", child.id());
    let asleep = || {
        let threads = fs::read_dir(format!("{own}/task")).unwrap();
        let mut states = threads.map(|thread| fs::read_to_string(thread.unwrap().path().join("stat")));
        states.all(|stat| stat.is_ok_and(|stat| stat.contains(") S ")))
    };
    // The command waits for nothing but this pipe: when its threads all sleep for a tenth of a second, it has answered.
    let mut quiet = 0;
    while quiet < 20 {
        std::thread::sleep(std::time::Duration::from_millis(5));
        quiet = if asleep() { quiet + 1 } else { 0 };
        assert!(child.try_wait().unwrap().is_none(), "{arguments:?} ended without its answer");
    }
    let told = fs::read_to_string(format!("{own}/status")).unwrap();
    let line = told.lines().find_map(|line| line.strip_prefix("VmHWM:")).unwrap();
    let peak: f64 = line.trim().trim_end_matches(" kB").parse().unwrap();
    drop((filling, answer));
    child.wait().unwrap();
    peak / 1024.0
}

/// Memory grows in proportion to what is read: of inputs of n, 2 n and 4 n the last step costs twice the first, and a
/// byte of the input costs no more than is said here.
#[cfg(target_os = "linux")]
#[test]
#[ignore = "ci: reads files of up to 64 MiB"]
fn memory_is_linear_in_the_input() {
    use std::fmt::Write;
    let recording = |rows: usize| {
        let mut text = String::from("time_s,force_N,key_m\n");
        for n in 0..rows {
            let _ = writeln!(
                text,
                "{:.5},{:.4},{:.7}",
                n as f64 * 1e-4,
                5.0 + (n % 7) as f64 * 0.01,
                (n % 100) as f64 * 1e-5
            );
        }
        text
    };
    let grand = include_str!("../../../erard-core/instruments/concert-grand.toml");
    let instrument =
        |bytes: usize| format!("{grand}\n{}", "# a remark of forty letters, as there are\n".repeat(bytes / 42));
    let weights = |rows: usize| {
        let row = |n: usize| format!("{},{},{}\n", 1 + n % 88, 50 + n % 5, 20 + n % 3);
        format!("key,down_weight_g,up_weight_g\n{}", (0..rows).map(row).collect::<String>())
    };
    let folder = Folder::new("limits-linear");
    // What it is, how to read it, its size at n, and the most bytes that one of its bytes may cost. The weights are
    // refused: every key stands in them many times.
    type Make<'a> = &'a dyn Fn(usize) -> String;
    let cases: [(&str, &str, Make<'_>, usize, f64); 3] = [
        ("rows.csv", "check", &recording, 400_000, 8.0),
        ("grand.toml", "check", &instrument, 1_000_000, 10.0),
        ("weights.csv", "check", &weights, 300_000, 8.0),
    ];
    for (name, command, make, size, most) in cases {
        let of = |times: usize| {
            folder.file(name, &make(size * times));
            let bytes = fs::metadata(folder.0.join(name)).unwrap().len() as f64;
            (bytes / f64::from(1 << 20), peak_mib(&folder, &[command, name]))
        };
        let [(one, a), (two, b), (four, c)] = [1, 2, 4].map(of);
        println!("{name}: {one:.1}, {two:.1} and {four:.1} MiB take {a:.0}, {b:.0} and {c:.0} MiB");
        let each = (c - a) / (four - one);
        assert!(each < most, "{name}: {each:.1} bytes for one");
        // An allocator gives memory in steps; 8 MiB are not counted.
        assert!(
            c - b < 2.5 * (b - a) + 8.0,
            "{name}: {a:.0}, {b:.0} and {c:.0} MiB for {one:.1}, {two:.1} and {four:.1}"
        );
    }
}
