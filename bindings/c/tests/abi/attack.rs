//! Calls by chance of every function of the header, also one that was added today: a program in plain C is written from
//! the header's own declarations, compiled and run. Whatever is given, the library answers with a code of its table and
//! words, refuses what is no number, leaves the action as it was where it refuses, and plays on.

use std::fmt::Write;
use std::process::Command;

use crate::programs::{has, library, run};

const HEADER: &str = include_str!("../../include/erard.h");
const HARNESS: &str = include_str!("attack.c");

/// Of how many calls, from seed 1 on.
const CALLS: u64 = 800;

/// A declaration: what is returned, the name, and types and names of the arguments.
struct Function {
    returns: String,
    name: String,
    arguments: Vec<(String, String)>,
}

/// All functions of the header.
fn functions() -> Vec<Function> {
    let mut plain = String::new();
    let mut rest = HEADER;
    while let Some((before, comment)) = rest.split_once("/*") {
        plain += before;
        rest = comment.split_once("*/").expect("a comment ends").1;
    }
    plain += rest;
    let lines: Vec<&str> = plain.lines().filter(|line| !line.starts_with('#')).collect();
    let flat = lines.join(" ").split_whitespace().collect::<Vec<_>>().join(" ");
    let declared = flat.split(';').filter_map(|one| {
        let (head, arguments) = one.trim().strip_suffix(')')?.split_once('(')?;
        let at = head.find("erard_")?;
        let returns = head[..at].rsplit(['{', '}']).next()?.trim().replace("extern \"C\"", "");
        let arguments = arguments.split(',').map(str::trim).filter(|one| *one != "void").map(|one| {
            let at = one.rfind([' ', '*']).expect("a type and a name") + 1;
            (one[..at].trim().to_owned(), one[at..].to_owned())
        });
        Some(Function {
            returns: returns.trim().to_owned(),
            name: head[at..].to_owned(),
            arguments: arguments.collect(),
        })
    });
    declared.collect()
}

/// Xorshift: the same everywhere.
struct Chance(u64);

impl Chance {
    fn of(seed: u64) -> Self {
        Chance(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1)
    }

    fn below(&mut self, n: usize) -> usize {
        for _ in 0..3 {
            self.0 ^= self.0 << 13;
            self.0 ^= self.0 >> 7;
            self.0 ^= self.0 << 17;
        }
        (self.0 % n as u64) as usize
    }

    fn one<'a>(&mut self, all: &[&'a str]) -> &'a str {
        all[self.below(all.len())]
    }
}

const NUMBERS: [&str; 18] = [
    "NAN",
    "INFINITY",
    "-INFINITY",
    "1e300",
    "-1e300",
    "1e9",
    "-1e9",
    "0.0",
    "-0.0",
    "-1.0",
    "1e-300",
    "5e-324",
    "1e-12",
    "0.001",
    "50e-6",
    "5.0",
    "1e6",
    "-1e-3",
];
const WHOLE: [&str; 9] = ["0", "1", "2", "40", "88", "89", "1000", "UINT32_MAX", "0x7fffffff"];
const PLACES: [&str; 6] = ["0", "1", "7", "1000", "SIZE_MAX", "SIZE_MAX / 2"];
/// Counts that fit the memory that is given.
const COUNTS: [&str; 5] = ["0", "1", "5", "64", "4096"];
const TEXTS: [&str; 12] = [
    "NULL",
    "\"\"",
    "\" \"",
    "\"x\"",
    "\"name\"",
    "\"\\xff\\xfe\"",
    "\"concert-grand-rigid\"",
    "\"let_off\"",
    "long_text",
    "\"let_off=1 mm,drop=nan\"",
    "\"body.hammer.mass_g\"",
    "\"{\\\"let_off\\\": 1e999}\"",
];

/// What makes an argument, and whether it is a number that is none.
fn argument(chance: &mut Chance, function: &Function, place: usize) -> String {
    let (kind, name) = &function.arguments[place];
    let is_free = function.name.ends_with("_free");
    let before = place.checked_sub(1).map(|place| function.arguments[place].0.as_str());
    match kind.as_str() {
        _ if is_free && kind.ends_with('*') => "NULL".to_owned(),
        "double" => chance.one(&NUMBERS).to_owned(),
        "uint32_t" | "int32_t" => chance.one(&WHOLE).to_owned(),
        "size_t" if before == Some("const char *") => format!("strlen_of(text_{})", place - 1),
        "size_t" if before == Some("void *") => {
            chance.one(&["sizeof more_memory", "sizeof more_memory", "64", "0"]).to_owned()
        }
        "size_t" if function.name == "erard_memory_new" => chance.one(&["0", "1", "64", "100000"]).to_owned(),
        "size_t" if before.is_some_and(|before| before.ends_with('*')) && name != "which" => {
            chance.one(&COUNTS).to_owned()
        }
        "size_t" => chance.one(&PLACES).to_owned(),
        "const char *" => format!("text_{place}"),
        "ErardStatus *" => chance.one(&["&status", "&status", "&status", "NULL"]).to_owned(),
        "size_t *" => chance.one(&["&count", "&count", "NULL"]).to_owned(),
        "ErardProgress" => chance.one(&["NULL", "stops", "stops_late"]).to_owned(),
        // Not the memory in which the board lies that is played.
        "void *" if name == "memory" => chance.one(&["more_memory", "more_memory", "more_memory", "NULL"]).to_owned(),
        "void *" => "NULL".to_owned(),
        "double *" | "const double *" => chance.one(&["doubles", "doubles", "NULL"]).to_owned(),
        "const double (*" => chance.one(&["pairs", "pairs", "NULL"]).to_owned(),
        "float *" | "const float *" => chance.one(&["floats", "floats", "NULL"]).to_owned(),
        "uint8_t *" | "const uint8_t *" => chance.one(&["bytes", "bytes", "NULL"]).to_owned(),
        object => {
            let object = object.trim_start_matches("const ").trim_start_matches("struct ");
            let known = match object {
                "ErardAction *" => "action",
                "ErardInstrument *" => "instrument",
                "ErardKeyboard *" => "keyboard",
                "ErardStroke *" => "stroke",
                "ErardEventDetector *" => "detector",
                "ErardReading *" => "readings",
                "ErardInput *" => "&input",
                "ErardImpact *" => "impacts",
                "ErardEvents *" => "&events",
                "ErardBoard *" => chance.one(&["board", "contact_board", "hammer_board"]),
                "ErardContacts *" => "&contacts",
                "ErardRelease *" => "&release",
                "ErardBoardSetup *" => "&setup",
                "ErardBoardKey *" => "&board_key",
                "ErardStops *" => "key_stops",
                _ => panic!("{}: say here how an argument of type `{kind}` is made", function.name),
            };
            chance.one(&[known, known, known, known, "NULL"]).to_owned()
        }
    }
}

/// `EventDetector` as functions have it: `event_detector`.
fn snake(object: &str) -> String {
    let mut name = String::new();
    for letter in object.chars() {
        if letter.is_uppercase() && !name.is_empty() {
            name.push('_');
        }
        name.extend(letter.to_lowercase());
    }
    name
}

/// The call of a seed as a case of the program.
fn case(all: &[Function], seed: u64) -> String {
    let mut chance = Chance::of(seed);
    // One after the other: none is left out by chance.
    let function = &all[seed as usize % all.len()];
    let mut text = format!("    case {seed}: {{\n");
    for (place, (kind, _)) in function.arguments.iter().enumerate() {
        if kind == "const char *" {
            let _ = writeln!(text, "        const char *text_{place} = {};", chance.one(&TEXTS));
        }
    }
    let given: Vec<String> =
        (0..function.arguments.len()).map(|place| argument(&mut chance, function, place)).collect();
    // The input's numbers are drawn, too.
    let mut bad = given.iter().any(|one| ["NAN", "INFINITY", "-INFINITY"].contains(&one.as_str()));
    let kind = chance.one(&["0", "1", "2", "3", "4", "5", "UINT32_MAX"]);
    let drawn: [&str; 8] = core::array::from_fn(|_| chance.one(&NUMBERS));
    let _ = writeln!(text, "        input = (ErardInput){{ sizeof input, {kind}, {} }};", drawn.join(", "));
    if function.name == "erard_status_text" {
        bad = false;
    }
    let call = format!("{}({})", function.name, given.join(", "));
    let _ = writeln!(text, "        shown = \"{}\";", call.replace('\\', "\\\\").replace('"', "\\\""));
    let told = given.iter().any(|one| one == "&status");
    let code = if told { "status" } else { "0" };
    let _ = match function.returns.as_str() {
        "void" => writeln!(text, "        {call};"),
        "ErardStatus" => writeln!(text, "        answered({call}, {});", i32::from(bad)),
        "uint32_t" | "size_t" | "double" => writeln!(text, "        (void){call};"),
        "const char *" => writeln!(text, "        (void){call};"),
        "uint8_t *" => writeln!(text, "        erard_memory_free({call}, {});", given[0]),
        "char *" => writeln!(
            text,
            "        char *found = {call};\n        made(found != NULL, {code}, {}, {});\n        erard_text_free(found);",
            i32::from(told),
            i32::from(bad)
        ),
        object => {
            let object = object.trim_start_matches("struct ").trim_end_matches([' ', '*']);
            let free = snake(object.strip_prefix("Erard").expect("an object of the library"));
            writeln!(
                text,
                "        struct {object} *found = {call};\n        made(found != NULL, {code}, {}, {});\n        \
                 erard_{free}_free(found);",
                i32::from(told),
                i32::from(bad)
            )
        }
    };
    text + "        break;\n    }\n"
}

#[test]
fn calls_by_chance() {
    attack(1..61);
}

#[test]
#[ignore = "ci: 740 more calls"]
fn more_calls_by_chance() {
    attack(61..CALLS + 1);
}

fn attack(seeds: std::ops::Range<u64>) {
    if !has("cc") {
        return;
    }
    let all = functions();
    let declared = HEADER.lines().filter(|line| {
        !line.starts_with([' ', '#', '/', '}']) && line.contains(" erard_")
            || line.starts_with("char *erard_")
            || line.starts_with("struct") && line.contains("*erard_")
            || line.starts_with("const char *erard_")
            || line.starts_with("uint8_t *erard_")
    });
    assert_eq!(all.len(), declared.count(), "every function of the header is read");
    let cases: String = seeds.clone().map(|seed| case(&all, seed)).collect();
    let folder = tempfile::tempdir().expect("a folder");
    let (source, program) = (folder.path().join("attack.c"), folder.path().join("attack"));
    let text = HARNESS.replace("/* CASES */", &cases);
    std::fs::write(&source, text).expect("written");
    let include = format!("{}/include", env!("CARGO_MANIFEST_DIR"));
    let mut cc = Command::new("cc");
    cc.args(["-std=c99", "-O0", "-Wall", "-Wextra", "-Werror", "-I"]).arg(include).arg(&source);
    // `.ci/sanitize` adds its sanitizer's.
    cc.args(std::env::var("ERARD_CC_FLAGS").iter().flat_map(|flags| flags.split_whitespace()));
    run(cc.arg(library("liberard_c.a")).args(["-lpthread", "-ldl", "-lm", "-o"]).arg(&program));
    let mut played = Command::new(&program);
    let said = run(played.arg(seeds.start.to_string()).arg(seeds.end.to_string()));
    let told: Vec<&str> = said.lines().filter(|line| !line.starts_with("at ")).collect();
    assert!(said.contains("ends: ") && said.contains(" 0 wrong"), "{}", told.join("\n"));
}
