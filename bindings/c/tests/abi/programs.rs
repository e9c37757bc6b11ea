//! Programs in plain C, in C++, and built by CMake: compiled without a warning, run, and looked at.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::not_run::not_run;

use erard::{Action, Input, Instrument};

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// A library that was built with these tests.
pub(crate) fn library(name: &str) -> PathBuf {
    let test = std::env::current_exe().expect("it has a path");
    let library = test.parent().expect("a folder").join(name);
    assert!(library.exists(), "{} is not there", library.display());
    library
}

pub(crate) fn has(tool: &str) -> bool {
    let is_there = Command::new(tool).arg("--version").output().is_ok_and(|output| output.status.success());
    if !is_there {
        not_run(&format!("no {tool}"));
    }
    is_there
}

pub(crate) fn run(command: &mut Command) -> String {
    let output = command.output().expect("it runs");
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(
        output.status.success(),
        "{command:?}: {}\n{said}{}",
        output.status,
        String::from_utf8_lossy(&output.stderr)
    );
    said
}

/// The examples.
const EXAMPLES: [&str; 3] = ["press", "haptic", "keyboard"];

/// Compiles the examples against the static library or the shared one into one program, for linking takes longest: its
/// argument says which example it runs.
fn compiled(folder: &Path, shared: bool, flags: &[&str]) -> PathBuf {
    let cc = |more: &[&str]| {
        let mut cc = Command::new("cc");
        cc.args(["-std=c99", "-O1", "-Wall", "-Wextra", "-Werror", "-pedantic"]).args(flags).args(more);
        cc
    };
    let declared: String = EXAMPLES.iter().map(|name| format!("int {name}_main(void);\n")).collect();
    let chosen: String = EXAMPLES
        .iter()
        .map(|name| format!("    if (count == 2 && !strcmp(names[1], \"{name}\")) return {name}_main();\n"))
        .collect();
    let driver = folder.join("driver.c");
    let main = format!("int main(int count, char **names) {{\n{chosen}    return 100;\n}}\n");
    std::fs::write(&driver, format!("#include <string.h>\n{declared}{main}")).expect("written");
    let mut link = cc(&[]);
    link.arg(driver);
    for name in EXAMPLES {
        let object = folder.join(format!("{name}-{shared}.o"));
        let mut compile = cc(&["-c", &format!("-Dmain={name}_main")]);
        compile.arg("-I").arg(root().join("include")).arg(root().join("examples").join(format!("{name}.c")));
        run(compile.arg("-o").arg(&object));
        link.arg(object);
    }
    if shared {
        // The name that it is looked for by.
        let found = folder.join("liberard.so.1");
        let _ = std::os::unix::fs::symlink(library("liberard_c.so"), &found);
        link.arg(&found).arg(format!("-Wl,-rpath,{}", folder.display()));
    } else {
        link.arg(library("liberard_c.a")).args(["-lpthread", "-ldl"]);
    }
    let program = folder.join(format!("examples-{shared}"));
    run(link.args(["-lm", "-o"]).arg(&program));
    program
}

/// The number behind a word of a line.
fn number_after(text: &str, word: &str) -> f64 {
    let rest = text.split_once(word).unwrap_or_else(|| panic!("`{word}` is not in: {text}")).1;
    let end = rest.trim_start().find([' ', ',', '\n']).unwrap_or(rest.trim_start().len());
    rest.trim_start()[..end].parse().unwrap_or_else(|_| panic!("no number after `{word}`: {text}"))
}

/// The examples, against the static library and the shared one.
#[test]
fn the_examples_in_c() {
    if !has("cc") {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let [fixed, shared] = [false, true].map(|shared| compiled(folder.path(), shared, &[]));
    let said = |program: &Path, name: &str| run(Command::new(program).arg(name));
    for program in [&fixed, &shared] {
        presses(&said(program, "press"));
    }
    sounds_a_note(&said(&fixed, "haptic"));
    sounds_three_notes(&said(&shared, "keyboard"));
}

/// The press: the impact and the last place are the native library's, to the bit.
fn presses(said: &str) {
    let mut action = Action::new(&Instrument::builtin("concert-grand").unwrap()).unwrap();
    let (mut impact, mut last) = (None, None);
    for n in 0..10_000 {
        last = Some(action.step(Input::Force(if n < 5000 { 5.0 } else { 0.0 })));
        impact = action.impact().or(impact);
    }
    assert_eq!(number_after(said, " with ").to_bits(), impact.unwrap().hammer_speed_m_per_s.to_bits(), "{said}");
    assert_eq!(number_after(said, "ends at ").to_bits(), last.unwrap().key_m.to_bits(), "{said}");
}

/// The haptic loop at 1 kHz sounds a note, stays bounded, and ends still, held by the finger. Its coupling of 500 N/m
/// gives 12 mm under 6 N.
fn sounds_a_note(said: &str) {
    assert!(number_after(said, "force ") < 60.0 && number_after(said, "deepest ") < 24.0, "{said}");
    assert!(said.starts_with("1 impacts"), "{said}");
    // At its end it gives back what the finger presses.
    assert!((number_after(said, "mm and ") - 6.0).abs() < 0.5, "{said}");
}

/// The list of events sounds its three notes.
fn sounds_three_notes(said: &str) {
    let keys: Vec<f64> =
        said.lines().filter(|line| line.starts_with("key ")).map(|l| number_after(l, "key ")).collect();
    assert_eq!(keys.len(), 3, "{said}");
    assert!(keys[0] == 40.0 && keys.contains(&44.0) && keys.contains(&47.0), "{said}");
}

/// The same under the sanitizers: what C passes, what it gets, and that everything is given back.
#[test]
#[ignore = "ci: every example once more, under the sanitizers"]
fn sanitized() {
    if !has("cc") {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let probe = folder.path().join("probe.c");
    std::fs::write(&probe, "int main(void) { return 0; }").expect("written");
    let flags = ["-fsanitize=address,undefined", "-fno-sanitize-recover=all", "-g"];
    let linked = Command::new("cc").args(flags).arg(&probe).arg("-o").arg(folder.path().join("probe")).output();
    if !linked.is_ok_and(|output| output.status.success()) {
        not_run("the C compiler has no sanitizers");
        return;
    }
    let program = compiled(folder.path(), false, &flags);
    for name in EXAMPLES {
        let mut example = Command::new(&program);
        run(example.arg(name).env("ASAN_OPTIONS", "detect_leaks=1:detect_stack_use_after_return=1"));
    }
}

/// `make` of the installer, with what these tests are linked with as what is built.
fn make(prefix: &Path, arguments: &[&str]) {
    let mut make = Command::new("make");
    make.arg("-C").arg(root()).args(arguments).env_remove("MAKEFLAGS");
    make.arg(format!("BUILT={}", library("liberard_c.so").parent().expect("a folder").display()));
    run(make.arg(format!("PREFIX={}", prefix.display())));
}

/// The words that pkg-config answers for a library below a prefix.
fn config(prefix: &Path, name: &str, what: &[&str]) -> Vec<String> {
    let mut config = Command::new("pkg-config");
    config.args(what).arg(name).env("PKG_CONFIG_PATH", prefix.join("lib/pkgconfig"));
    run(&mut config).split_whitespace().map(str::to_owned).collect()
}

/// The shell lines of a file's first block behind some words.
fn shell_lines(path: &str, after: &str) -> String {
    let text = std::fs::read_to_string(root().join(path)).expect("it reads");
    let rest = text.split_once(after).unwrap_or_else(|| panic!("{path}: no `{after}`")).1;
    let (_, block) = rest.split_once("```").expect("a block");
    block.split_once('\n').expect("lines").1.split_once("```").expect("its end").0.to_owned()
}

/// The lines of the README install the library and press a key from a clean folder, with nothing set that helps.
#[test]
fn the_lines_that_install_work() {
    lines_install(&[("README.md", "## Install")]);
}

#[test]
#[ignore = "ci: installs the library once more"]
fn the_lines_of_the_book_install_too() {
    lines_install(&[("../../book/src/builders.md", "# In a machine of your own")]);
}

/// The first block of each text behind some words.
fn lines_install(texts: &[(&str, &str)]) {
    if !(has("make") && has("cc") && has("pkg-config")) {
        return;
    }
    for (path, after) in texts {
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::create_dir(folder.path().join("bindings")).expect("made");
        std::os::unix::fs::symlink(root(), folder.path().join("bindings/c")).expect("linked");
        let lines = shell_lines(path, after);
        let mut sh = Command::new("sh");
        sh.args(["-e", "-c", &lines]).current_dir(folder.path()).env("HOME", folder.path());
        for helps in ["LD_LIBRARY_PATH", "PKG_CONFIG_PATH", "MAKEFLAGS", "CARGO_TARGET_DIR"] {
            sh.env_remove(helps);
        }
        let said = run(sh.env("BUILT", library("liberard_c.so").parent().expect("a folder")));
        assert_eq!(said.matches("impact at").count(), lines.matches("./press").count(), "{path}: {said}");
        assert!(said.contains("impact at"), "{path}: {said}");
    }
}

/// Installed like a library: found by pkg-config and by CMake, shared and static, also where the folder was moved; two
/// of them beside each other; and taken away again.
#[test]
#[ignore = "ci: installs two libraries; the README's lines are tried in every run"]
fn installed() {
    if !(has("make") && has("cc") && has("pkg-config")) {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let (first, prefix, build) =
        (folder.path().join("usr"), folder.path().join("moved here"), folder.path().join("build"));
    make(&first, &["install"]);
    make(&first, &["install", "NAME=erard-rt"]);
    std::fs::rename(&first, &prefix).expect("moved");
    assert!(prefix.join(format!("lib/liberard.so.{}", erard_c::ERARD_ABI)).exists());
    assert_eq!(config(&prefix, "erard-rt", &["--libs-only-l"]), ["-lerard-rt"]);
    assert_eq!(config(&prefix, "erard", &["--modversion"]), [env!("CARGO_PKG_VERSION")]);
    // Words with a space come in pieces: the compiler gets the folder by another name.
    let plain = folder.path().join("plain");
    std::os::unix::fs::symlink(&prefix, &plain).expect("linked");
    let program = folder.path().join("press");
    let mut cc = Command::new("cc");
    cc.arg(root().join("examples/press.c")).args(config(&plain, "erard", &["--cflags", "--libs"]));
    run(cc.arg("-o").arg(&program));
    let mut press = Command::new(&program);
    let expected = run(press.env("LD_LIBRARY_PATH", prefix.join("lib")));
    assert!(expected.contains("impact at"), "{expected}");

    if has("cmake") {
        let mut configure = Command::new("cmake");
        configure.arg("-S").arg(root().join("examples/cmake")).arg("-B").arg(&build);
        run(configure.arg(format!("-DCMAKE_PREFIX_PATH={}", prefix.display())));
        run(Command::new("cmake").arg("--build").arg(&build));
        for name in ["press", "press-static"] {
            assert_eq!(run(&mut Command::new(build.join(name))), expected, "{name}");
        }
    }
    make(&prefix, &["uninstall"]);
    assert!(prefix.join("include/erard.h").exists(), "the other library's headers stay");
    make(&prefix, &["uninstall-rt"]);
    assert!(!prefix.join("include/erard.h").exists());
    let left: Vec<_> = std::fs::read_dir(prefix.join("lib")).unwrap().map(|e| e.unwrap().file_name()).collect();
    assert!(left.iter().all(|name| !name.to_string_lossy().starts_with("liberard")), "{left:?}");
}

mod nightly {
    use super::*;

    /// MB that the shared library may take, and the archive.
    const LARGEST_MB: [f64; 2] = [6.0, 26.0];

    /// The library for control loops, built and installed under its own name: small, without the workshop, and with the
    /// same bits as the native library.
    #[test]
    #[ignore = "nightly: compiles the player once more"]
    fn the_library_for_control_loops() {
        if !(has("make") && has("cc") && has("pkg-config")) {
            return;
        }
        let folder = tempfile::tempdir().expect("a folder");
        let prefix = folder.path().join("usr");
        let mut make = Command::new("make");
        make.arg("-C").arg(root()).args(["install-rt", &format!("PREFIX={}", prefix.display())]);
        run(make.env_remove("MAKEFLAGS"));
        let bytes = |name: &str| std::fs::read(prefix.join("lib").join(name)).expect("installed");
        for (name, largest) in ["liberard-rt.so.1", "liberard-rt.a"].into_iter().zip(LARGEST_MB) {
            let mb = bytes(name).len() as f64 * 1e-6;
            println!("{name}: {mb:.1} MB");
            assert!(mb < largest, "{name}: {mb} MB");
        }
        let shared = bytes("liberard-rt.so.1");
        let has_name = |name: &[u8]| shared.windows(name.len()).any(|window| window == name);
        assert!(has_name(b"erard_keyboard_step") && has_name(b"liberard-rt.so.1"));
        assert!(!has_name(b"erard_instrument_measure") && !has_name(b"fmi2DoStep"));
        let archive = config(&prefix, "erard-rt", &["--variable=archive"]);
        let said = |name: &str, linked: &[String]| {
            let program = folder.path().join("program");
            let mut cc = Command::new("cc");
            cc.arg(root().join("examples").join(name)).args(config(&prefix, "erard-rt", &["--cflags"])).args(linked);
            run(cc.args(["-lpthread", "-ldl", "-lm", "-o"]).arg(&program));
            run(&mut Command::new(&program))
        };
        presses(&said("press.c", &archive));
        sounds_three_notes(&said("keyboard.c", &archive));
        let mut shared = config(&prefix, "erard-rt", &["--libs"]);
        shared.push(format!("-Wl,-rpath,{}", prefix.join("lib").display()));
        presses(&said("press.c", &shared));
    }
}

const PLUS_PLUS: &str = r#"
#include <erard.hpp>
#include <cstdio>
int main() {
    auto heavy = erard::Instrument::builtin("heavy-touch");
    double light = heavy.get("body.hammer.inertia_kg_m2");
    heavy.vary("body.hammer.mass", "*1.05");
    if (!(heavy.get("body.hammer.inertia_kg_m2") / light > 1.049)) return 13;
    heavy.set("body.hammer.mass_g", heavy.get("body.hammer.mass_g") + 0.5);
    erard::Action action(heavy);
    ErardReading r{};
    std::vector<unsigned char> saved;
    for (int n = 0; n < 2000; n++) {
        if (n == 400) saved = action.save();
        if (action.force(9.0, r) < 0) return 1;
    }
    double first = r.hammer_speed_m_per_s;
    if (action.restore(saved) < 0) return 2;
    for (int n = 400; n < 2000; n++) if (action.force(9.0, r) < 0) return 3;
    if (r.impact_count != 1 || r.hammer_speed_m_per_s != first || !(first > 0)) return 4;
    try {
        heavy.set("body.hammer.mass_g", -1);
        return 5;
    } catch (const erard::Error &e) {
        if (e.status != ERARD_STATUS_FILE) return 6;
        std::puts(e.what());
    }
    erard::Keyboard keyboard;
    ErardInput press{};
    press.kind = ERARD_INPUT_FORCE;
    press.force_n = 8.0;
    if (keyboard.drive(40, press) < 0) return 7;
    ErardImpact impacts[4];
    std::size_t count = 0;
    if (keyboard.step(2000, impacts, 4, count) < 0 || count != 1 || impacts[0].key != 40) return 8;
    auto strung = erard::Keyboard::builtin("concert-grand-strings", 1.0 / 24000);
    if (strung.set_pedal(0.007) < 0 || strung.drive(40, press) < 0 || strung.step(1600, impacts, 4, count) < 0) return 9;
    double heard = strung.bridge_force(40);
    auto kept = strung.save();
    if (count != 1 || heard == 0.0 || strung.bridge_force(41) == heard) return 10;
    if (strung.step(100, impacts, 4, count) < 0 || strung.bridge_force(40) == heard) return 11;
    if (strung.restore(kept) < 0 || strung.read(40, r) < 0 || strung.bridge_force(40) != heard) return 12;
    return 0;
}
"#;

#[test]
fn in_c_plus_plus() {
    if !has("c++") {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let (source, program) = (folder.path().join("page.cpp"), folder.path().join("page"));
    std::fs::write(&source, PLUS_PLUS).expect("written");
    let mut cpp = Command::new("c++");
    cpp.args(["-std=c++17", "-Wall", "-Wextra", "-Werror", "-pedantic", "-I"]).arg(root().join("include"));
    run(cpp.arg(&source).arg(library("liberard_c.a")).args(["-lpthread", "-ldl", "-lm", "-o"]).arg(&program));
    let said = run(&mut Command::new(program));
    assert!(said.contains("mass_g"), "{said}");
    assert!(std::fs::read_to_string(root().join("include/erard.hpp")).unwrap().lines().count() < 180, "a page or two");
}
