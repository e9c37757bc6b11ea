//! What a desk expects of a command: lists, completions, manual pages, quiet, refusals that explain, and a README that
//! needs no files.

use crate::common::Folder;

#[test]
fn what_is_built_in() {
    let folder = Folder::new("desk-list");
    let listed = folder.good(&["list"]);
    for name in ["concert-grand", "steinway-o", "heavy-touch", "mf-pressed", "ff-struck", "keyboards"] {
        assert!(listed.contains(name), "{name}: {listed}");
    }
    printed_they_are_checked(
        &folder,
        &[("concert-grand", "an instrument"), ("c7f-like", "a linkage"), ("mf-struck", "a stroke")],
    );
    let said = folder.bad(&["list", "upright"]);
    assert!(said.contains("`upright`") && said.contains("steinway-o"), "{said}");
}

/// Each of them, printed, is the file that it is.
fn printed_they_are_checked(folder: &Folder, known: &[(&str, &str)]) {
    for &(name, kind) in known {
        let text = folder.good(&["list", name]);
        let file = if kind == "a stroke" { "it.csv" } else { "it.toml" };
        folder.file(file, &text);
        assert!(folder.good(&["check", file]).contains(kind), "{name}");
        // And by its name, without a file.
        assert!(folder.good(&["check", name]).contains(kind), "{name}");
    }
}

/// How many files a folder below `crates` holds, each of which the check knows.
fn checked(folder: &Folder, home: &str, kind: &str) -> usize {
    let crates = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut files = 0;
    for entry in std::fs::read_dir(crates.join(home)).unwrap() {
        let path = entry.unwrap().path();
        // Curves that rows are made of, and the words about them: `erard` reads neither as a file of its own.
        if home.ends_with("validation") && path.extension().is_none_or(|e| e != "toml") {
            continue;
        }
        let kind = if path.ends_with("usual.toml") { "usual ranges" } else { kind };
        let kind = if path.ends_with("cases.toml") { "published pianos" } else { kind };
        let kind = if path.extension().is_some_and(|e| e == "json") { "a JSON Schema" } else { kind };
        let said = folder.good_words(&["check", path.to_str().unwrap()]);
        assert!(said.contains(kind), "{}: {said}", path.display());
        files += 1;
    }
    files
}

/// Keyboards that the project ships, with their schema.
const KEYBOARDS: usize = 4;

/// Everything that the project ships, but for keyboards, and what it writes.
#[test]
fn check_knows_every_format() {
    let folder = Folder::new("desk-check");
    let files: usize = [
        ("erard-core/instruments", "an instrument"),
        ("erard-kinematics/linkages", "a linkage"),
        ("erard-core/strokes", "a stroke"),
        ("erard-workshop/validation", "published measurements"),
    ]
    .map(|(home, kind)| checked(&folder, home, kind))
    .iter()
    .sum();
    assert!(files >= 19 - KEYBOARDS, "only {files} files");
    folder.good(&["press", "--duration", "0.02", "--out", "run"]);
    assert!(folder.good(&["check", "run/summary.json"]).contains("erard press --duration 0.02"));
    for (name, text, part) in [
        ("a.json", "{}", "unknown kind of JSON"),
        ("b.json", "{", "is not JSON"),
        ("c.toml", "format = \"erard-published/2\"\n", "groups"),
        ("d.toml", "format = \"erard-usual/1\"\n[usual.dip_mm]\nsource = \"s\"\n", "expected `at_least` or `at_most`"),
        ("e.toml", "format = \"erard-cases/2\"\ncase = []\n", "expected `erard-cases/1`"),
    ] {
        folder.file(name, text);
        let said = folder.bad(&["check", name]);
        assert!(said.contains(part) && said.contains(name), "{said}");
    }
    assert!(folder.bad(&["check", "a.xyz"]).contains("erard list"));
}

#[test]
fn completions_and_manual_pages() {
    let folder = Folder::new("desk-man");
    for (shell, part) in [("bash", "complete -F _erard"), ("zsh", "#compdef erard"), ("fish", "complete -c erard")] {
        let script = folder.good(&["completions", shell]);
        assert!(script.contains(part) && script.contains("low-pass"), "{shell}");
    }
    let page = folder.good(&["man"]);
    assert!(page.contains(".TH erard 1") && page.contains("completions"), "{page}");
    let page = folder.good(&["man", "press"]);
    assert!(page.contains("erard\\-press") && page.contains("\\-\\-touch"), "{page}");
    assert!(folder.bad(&["man", "lunch"]).contains("`lunch`"));
    let written = folder.good(&["man", "--out", "pages"]);
    assert!(written.contains("erard-compare.1"), "{written}");
    assert_eq!(written.split(',').count(), std::fs::read_dir(folder.0.join("pages")).unwrap().count());
}

/// bash itself completes what the script promises.
#[cfg(target_os = "linux")]
#[test]
fn bash_completes() {
    let folder = Folder::new("desk-bash");
    folder.file("erard.bash", &folder.good(&["completions", "bash"]));
    let script = "source erard.bash; COMP_WORDS=(erard compare --low); COMP_CWORD=2; _erard erard --low compare; echo \"${COMPREPLY[@]}\"";
    let output = std::process::Command::new("bash").args(["-c", script]).current_dir(&folder.0).output().unwrap();
    assert_eq!(String::from_utf8(output.stdout).unwrap().trim(), "--low-pass", "{:?}", output.stderr);
}

#[test]
fn quiet() {
    let folder = Folder::new("desk-quiet");
    let output = folder.erard(&["press", "--duration", "0.02", "--quiet"]);
    assert!(output.status.success() && output.stdout.is_empty() && output.stderr.is_empty());
    assert!(folder.0.join("erard-out/run.csv").exists());
    let said = folder.bad(&["--quiet", "press", "--dt", "7"]);
    assert!(said.contains("--dt"), "{said}");
}

/// A finger cannot pull.
#[test]
fn a_pull_is_refused_with_the_reason() {
    let folder = Folder::new("desk-pull");
    let said = folder.bad(&["press", "--force-step", "-3"]);
    assert!(
        said.contains("--force-step -3") && said.contains("from 0 to 10000 N") && said.contains("pushes"),
        "{said}"
    );
}

/// Words of a command line of the documentation, and the file that its output goes to.
fn words(line: &str) -> (Vec<String>, Option<String>) {
    let (mut words, mut word, mut quoted) = (Vec::new(), String::new(), false);
    for c in line.chars() {
        match c {
            '"' => quoted = !quoted,
            '#' if !quoted && word.is_empty() => break,
            c if c.is_whitespace() && !quoted => {
                if !word.is_empty() {
                    words.push(std::mem::take(&mut word));
                }
            }
            c => word.push(c),
        }
    }
    words.extend(Some(word).filter(|word| !word.is_empty()));
    let into = words.iter().position(|word| word == ">").map(|at| words.split_off(at)[1].clone());
    (words, into)
}

/// Replaces `FOLDER/*.EXTENSION` by the files of that kind, as a shell does.
fn expanded(folder: &Folder, word: String) -> Vec<String> {
    let Some((below, kind)) = word.split_once("/*.") else { return vec![word] };
    let entries = std::fs::read_dir(folder.0.join(below)).unwrap().map(|entry| entry.unwrap().file_name());
    let names = entries.map(|name| format!("{below}/{}", name.into_string().unwrap()));
    let mut names: Vec<String> = names.filter(|name| name.ends_with(&format!(".{kind}"))).collect();
    names.sort();
    assert!(!names.is_empty(), "{word}: no such file");
    names
}

/// Runs command lines one after the other in a folder, as a shell reads them: a backslash goes on, a comment is
/// nothing. What takes long is shortened: the test shows that the lines need nothing else.
fn run_lines(folder: &Folder, lines: &str) -> usize {
    let mut played = 0;
    let lines = lines.replace("\\\n", " ");
    for line in lines.lines().filter(|line| !line.trim().is_empty() && !line.starts_with('#')) {
        let line = line.strip_prefix("cargo run --release -- ").map_or(line.to_owned(), |rest| format!("erard {rest}"));
        let (mut words, into) = words(&line);
        let program = words.remove(0);
        assert!(program.starts_with("erard"), "not a command of ours: {line}");
        let shortened = match (program.as_str(), words.first().map(String::as_str)) {
            ("erard-bench", _) => &["--quick"][..],
            (_, Some("keyboard")) if !words.contains(&"--measured".to_owned()) => &["--every", "40"],
            _ => &[],
        };
        words.extend(shortened.iter().map(|word| (*word).to_owned()));
        let words: Vec<String> = words.into_iter().flat_map(|word| expanded(folder, word)).collect();
        let words: Vec<&str> = words.iter().map(String::as_str).collect();
        let said = match program.as_str() {
            "erard" => folder.good(&words),
            program => {
                let output = folder.beside(program, &words).output().unwrap();
                assert!(output.status.success(), "{line}: {}", String::from_utf8_lossy(&output.stderr));
                String::from_utf8(output.stdout).unwrap()
            }
        };
        assert!(!said.is_empty(), "{line}");
        if let Some(into) = into {
            folder.file(&into, &said);
        }
        played += 1;
    }
    played
}

mod nightly {
    use super::*;

    /// Every recipe of the book, one after the other, in a folder with pieces and two recorded notes.
    #[test]
    #[ignore = "nightly: some forty commands, one after the other"]
    fn an_empty_folder_is_enough_for_the_recipes() {
        let folder = Folder::new("desk-recipes");
        with_pieces(&folder, "pieces");
        std::fs::create_dir(folder.0.join("my-notes")).unwrap();
        for name in ["A0.wav", "C4.wav"] {
            std::fs::write(folder.0.join("my-notes").join(name), crate::listen::two_stages(0.3)).unwrap();
        }
        let page = include_str!("../../../../book/src/commands.md");
        let blocks = page.split("```sh,no_run\n").skip(1).map(|after| after.split("```").next().unwrap());
        let played: usize = blocks.map(|block| run_lines(&folder, block)).sum();
        assert!(played > 30, "{played} lines");
    }

    /// A miss ends with code 1 where that is asked for, and everything is written all the same.
    #[test]
    #[ignore = "nightly: two validations and a subject of the papers"]
    fn misses_can_fail() {
        let folder = Folder::new("desk-misses");
        // Heavy on purpose: rows are missed.
        let arguments = ["validate", "--instrument", "heavy-touch"];
        let said = folder.good(&arguments);
        assert!(!said.contains(" 0 missed"), "{said}");
        let output = folder.erard(&[&arguments[..], &["--fail-on-miss"]].concat());
        assert_eq!(output.status.code(), Some(1));
        let error = String::from_utf8(output.stderr).unwrap();
        assert!(error.contains(" rows missed: "), "{error}");
        assert!(folder.0.join("erard-out-validate/validate.json").exists());
    }

    #[test]
    #[ignore = "nightly: keyboards of 88 keys"]
    fn check_knows_keyboards() {
        let files = checked(&Folder::new("desk-check-keyboards"), "erard-core/keyboards", "a keyboard");
        assert!(files >= KEYBOARDS, "only {files} files");
    }

    #[test]
    #[ignore = "nightly: a keyboard of 88 keys, twice"]
    fn a_built_in_keyboard_is_checked() {
        printed_they_are_checked(&Folder::new("desk-list-keyboard"), &[("keyboard:concert-grand", "a keyboard")]);
    }
}

/// The pieces of the clone, in the folder that the commands name.
fn with_pieces(folder: &Folder, home: &str) {
    let pieces = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../erard-piece/pieces");
    std::fs::create_dir_all(folder.0.join(home)).unwrap();
    for name in ["gymnopedie.mid", "hanon.mid"] {
        std::fs::copy(pieces.join(name), folder.0.join(home).join(name)).unwrap();
    }
}

/// The README's first command and its six others, in a folder that holds the pieces and a recording only.
#[test]
#[ignore = "ci: a measurement and a validation"]
fn an_empty_folder_is_enough_for_the_readme() {
    let folder = Folder::new("desk-readme");
    // Where they really are: a checkout without symbolic links has no folder `pieces`.
    with_pieces(&folder, "crates/erard-piece/pieces");
    let recordings = "crates/erard-core/recordings";
    std::fs::create_dir_all(folder.0.join(recordings)).unwrap();
    let recording = format!("{recordings}/kawai-kg-3c-medium.csv");
    let own = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(&recording);
    std::fs::copy(own, folder.0.join(&recording)).unwrap();
    let readme = include_str!("../../../../README.md");
    let mut blocks = readme.split("```sh\n").skip(1).map(|after| after.split("```").next().unwrap());
    let first = blocks.next().unwrap();
    assert!(first.contains("\ncargo test --release "), "{first}");
    let played = run_lines(&folder, first.lines().next().unwrap()) + run_lines(&folder, blocks.next().unwrap());
    assert_eq!(played, 7);
}

/// A number that was changed under its note is marked in the pictures, too: of a pose, of a run, and of two; elsewhere
/// nothing is.
#[test]
fn notes_that_became_untrue_are_marked_in_pictures() {
    let folder = Folder::new("desk-changed");
    let name = "zone.capstan_heel.disc.center_mm";
    let text = erard::instrument::Instrument::builtin_text("concert-grand").unwrap();
    let found = erard::instrument::numbers_at(text, name).unwrap();
    folder.file("moved.toml", &erard::instrument::with_numbers(text, &[(name, 0, found[0] - 10.0)]).unwrap());
    folder.file("same.toml", text);
    for (instrument, marked) in [("moved.toml", true), ("same.toml", false), ("concert-grand", false)] {
        let given = ["--instrument", instrument, "--out", "it"];
        folder.good(&[&["draw"][..], &given].concat());
        folder.good(&[&["press", "--duration", "0.05", "--force"][..], &given].concat());
        for file in ["it/action.svg", "it/run.html"] {
            let picture = folder.read(file);
            assert_eq!(picture.contains("<circle class=\"mark\""), marked, "{instrument} {file}");
            assert_eq!(picture.contains(name), marked, "{instrument} {file}");
        }
    }
    folder.good(&[
        "press",
        "--duration",
        "0.05",
        "--instrument",
        "same.toml",
        "--instrument",
        "moved.toml",
        "--out",
        "two",
    ]);
    let page = folder.read("two/run.html");
    assert_eq!(page.matches("<circle class=\"mark\"").count(), 1);
    assert!(page.contains("id=\"beside\""), "side by side is offered");
}

/// An option takes the same kind of value in every command that has it. Goals of `regulate` show an example instead,
/// and `compare` runs several drives and models.
#[test]
fn an_option_means_the_same_in_every_command() {
    let mut program = erard_cli::command::definition();
    program.build();
    let mut known = std::collections::BTreeMap::<String, (String, Vec<String>)>::new();
    for command in program.get_subcommands().filter(|command| command.get_name() != "regulate") {
        for option in command.get_arguments() {
            let Some(long) = option.get_long() else { continue };
            let takes = option.get_action().takes_values();
            let names = option.get_value_names().filter(|_| takes).unwrap_or_default();
            // Several of a kind are of that kind.
            let kind = |name: &str| name.split(',').next().unwrap_or_default().trim_end_matches('S').to_owned();
            let kinds: Vec<String> = names.iter().map(|name| kind(name)).collect();
            let command = command.get_name().to_owned();
            let (first, known) = known.entry(long.to_owned()).or_insert_with(|| (command.clone(), kinds.clone()));
            assert_eq!(*known, kinds, "--{long} of {first} and of {command}");
        }
    }
}

/// The name that an option has in another command is refused; the message names a similar one of this command.
#[test]
fn an_option_of_another_command_is_refused_with_the_own_one() {
    let folder = Folder::new("desk-options");
    for (arguments, own) in [
        (&["play", "x.mid", "--against", "heavy-touch"][..], "--against-keyboard"),
        (&["play", "x.mid", "--record-every", "1"], "--record-interval"),
        (&["live", "x.csv", "--out", "x.mid"], "--out-file"),
        (&["regulate", "--out", "x.toml"], "--out-file"),
        (&["kinematics", "--from", "1"], "--from-travel"),
        (&["kinematics", "--to", "9"], "--to-travel"),
        (&["kinematics", "c7f-like", "--check"], "--check-file"),
        (&["keyboard", "--measured", "x.csv", "--leads", "14"], "--lead-masses"),
    ] {
        let said = folder.bad(arguments);
        assert!(said.contains("unexpected argument") && said.contains(own), "{arguments:?}: {said}");
    }
    // These are too far from the own name for a suggestion.
    for arguments in [
        ["live", "x.csv", "--bits", "14"],
        ["live", "x.csv", "--port", "synth"],
        ["calibrate", "x.csv", "--law", "hall"],
        ["fit", "concert-grand", "x.csv", "--vary"],
    ] {
        assert!(folder.bad(&arguments).contains("unexpected argument"), "{arguments:?}");
    }
}
