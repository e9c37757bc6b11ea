//! What `--help` prints: the common options of a command first, two examples at the end. The rest is `--help-all`.

use std::ffi::OsString;
use std::fmt::Write;

use clap::{Arg, ArgAction, Command};

use crate::suggest::GROUPS;

/// What a short help prints of a command.
struct Short {
    command: &'static str,
    /// Options that most users need, without their dashes, the first ones first.
    common: &'static [&'static str],
    /// Two commands that can be typed, each with what it does.
    examples: [(&'static str, &'static str); 2],
}

const fn short(
    command: &'static str,
    common: &'static [&'static str],
    examples: [(&'static str, &'static str); 2],
) -> Short {
    Short { command, common, examples }
}

/// The short help of every command.
const SHORT: [Short; 22] = [
    short(
        "press",
        &["instrument", "stroke", "touch", "hammer-speed", "force-step", "against", "losses", "wav", "bands", "out"],
        [
            ("erard press --stroke pp --touch struck", "a soft note, the finger moving as it arrives"),
            ("erard press --against f", "a medium and a loud note on one page"),
        ],
    ),
    short(
        "play",
        &["keyboard", "against-keyboard", "from", "to", "wav", "out"],
        [
            ("erard play piece.mid", "which notes of the piece are lost, and why"),
            ("erard play piece.mid --from 12 --to 20 --against-keyboard heavy-touch", "on two keyboards"),
        ],
    ),
    short(
        "live",
        &["keyboard", "calibration", "sensor", "travel", "rate", "ahead", "out-file", "midi-port"],
        [
            ("erard live stream.csv --calibration mine.toml --out-file take.mid", "a recorded stream as MIDI"),
            ("erard live --sensor light --travel 4 --out-file notes.pipe", "standard input, light keys"),
        ],
    ),
    short(
        "measure",
        &["sheet", "only", "key", "leads", "inches", "bands", "out"],
        [
            ("erard measure concert-grand:key=88", "the top key's protocol sheet"),
            ("erard measure heavy-touch --sheet", "what to turn, and by how much"),
        ],
    ),
    short(
        "diagnose",
        &[
            "key",
            "down-weight",
            "up-weight",
            "strike-weight",
            "front-weight",
            "dip",
            "blow",
            "let-off",
            "drop",
            "aftertouch",
            "check",
            "repetition-spring",
            "hammer-swings",
            "out",
        ],
        [
            ("erard diagnose --down-weight 58 --up-weight 18", "from two readings of middle C"),
            ("erard diagnose --key F2 --down-weight 60 --up-weight 30 --hammer-swings 2", "another key"),
        ],
    ),
    short(
        "regulate",
        &["dip", "blow", "let-off", "drop", "check", "repetition-spring", "norms", "priority", "out-file"],
        [
            ("erard regulate heavy-touch", "what is out of range goes to the trade's norm"),
            ("erard regulate --let-off 1.2mm --drop 1.5mm", "two goals; the rest stays"),
        ],
    ),
    short(
        "keyboard",
        &["every", "key", "measured", "target", "hammers", "lead-masses", "out"],
        [
            ("erard keyboard concert-grand --key C4 > c4.toml", "one key as an instrument file"),
            ("erard keyboard --measured weights.csv --hammers", "a work list for a real piano"),
        ],
    ),
    short(
        "study",
        &["vary", "instrument", "stroke", "touch", "measure", "sensitivities", "bands", "rows", "out"],
        [
            ("erard study --vary let_off=-1mm..1mm:41", "the let-off screw, 1 mm down to 1 mm up"),
            ("erard study --vary body.hammer.mass=x0.9,x1,x1.1 --measure down_weight_g", "three hammers"),
        ],
    ),
    short(
        "compare",
        &["instrument", "drive", "model", "columns", "duration", "way-up", "out"],
        [
            ("erard compare recording.csv", "against both models, by every drive it allows"),
            ("erard compare recording.csv --drive rigid --way-up", "driven by the key, up to the string"),
        ],
    ),
    short(
        "fit",
        &["parameters", "bounds", "sigma", "drive", "compare", "duration", "columns", "out"],
        [
            ("erard fit concert-grand recording.csv --parameters let_off,body.hammer.mass", "two parameters"),
            ("erard fit mine.toml a.csv b.csv --parameters zone.string.stiffness", "over two recordings"),
        ],
    ),
    short(
        "validate",
        &["instrument", "cases", "sound", "bands", "out"],
        [
            ("erard validate", "the concert grand against published values"),
            ("erard validate --cases judge", "diagnoses of published pianos"),
        ],
    ),
    short(
        "listen",
        &["key", "out"],
        [
            ("erard listen my-notes/*.wav", "each note is named by its file"),
            ("erard listen soft.wav loud.wav --key C4", "two recordings of one key"),
        ],
    ),
    short(
        "kinematics",
        &["instrument", "move", "no-regulate", "equations", "list", "out"],
        [
            ("erard kinematics c7f-like", "three levers by their lengths"),
            ("erard kinematics --move capstan=-10mm", "the capstan 10 mm to the player"),
        ],
    ),
    short(
        "draw",
        &["instrument", "at", "labels", "forces", "stroke", "out"],
        [
            ("erard draw --labels", "the action at rest, its parts named"),
            ("erard draw --at let-off --forces", "as the jack escapes, with the contact forces"),
        ],
    ),
    short(
        "check",
        &["columns", "position", "zero", "low-pass"],
        [
            ("erard check mine.toml", "an instrument: is it sound, what is in it"),
            ("erard check recording.csv", "a recording: columns, units, ranges"),
        ],
    ),
    short(
        "list",
        &[],
        [
            ("erard list strokes", "the built-in strokes alone"),
            ("erard list concert-grand > mine.toml", "an instrument to edit"),
        ],
    ),
    short(
        "fmu",
        &["keyboard", "out-file", "library"],
        [
            ("erard fmu concert-grand", "one key, for a simulator"),
            ("erard fmu --keyboard concert-grand-strings", "88 keys in one unit"),
        ],
    ),
    short(
        "scan",
        &["cases", "keys", "keyboard", "bits", "rate", "noise", "out"],
        [
            ("erard scan piece.mid --cases", "a piece, then motions that mislead"),
            ("erard scan --cases half-stroke,repress --keys C2,C4 --bits 8,12", "two of them, two converters"),
        ],
    ),
    short(
        "calibrate",
        &["travel", "sensor-law", "hammers", "contacts", "out-file"],
        [
            ("erard calibrate readings.csv --travel 10 --out-file mine.toml", "sensors that read the keys"),
            ("erard calibrate --contacts 3,6.5", "keys with two contacts"),
        ],
    ),
    short(
        "studio",
        &["port", "no-open"],
        [("erard studio", "opens the page in the browser"), ("erard studio --port 0 --no-open", "prints its address")],
    ),
    short(
        "completions",
        &[],
        [("erard completions bash > erard.bash", "for bash"), ("erard completions fish > erard.fish", "for fish")],
    ),
    short(
        "man",
        &["out"],
        [("erard man press | man -l -", "one page"), ("erard man --out man1", "the pages of all commands")],
    ),
];

/// Options of recordings, which have a heading of their own.
const RECORDINGS: [&str; 7] = ["columns", "position", "zero", "invert", "delay", "low_pass", "order"];
/// Options of every command; the last ones in a list.
const GLOBAL: [&str; 6] = ["full", "json", "quiet", "bibtex", "help", "help-all"];
/// The heading of options that are not common.
const MORE: &str = "More options";

/// The program with a short help for `--help` and all of it for `--help-all`.
pub(super) fn arranged(program: Command) -> Command {
    let option = |id: &'static str, action: ArgAction, help: &'static str| {
        Arg::new(id).long(id).action(action).global(true).help(help)
    };
    let program = program
        .disable_help_flag(true)
        .arg(option("help", ArgAction::HelpShort, "Print the common options and two examples").short('h'))
        .arg(option("help-all", ArgAction::HelpLong, "Print all options, the method and the files"))
        .mut_args(|arg| match GLOBAL.iter().position(|id| arg.get_id() == id) {
            Some(at) => arg.display_order(900 + at),
            None => arg,
        })
        .mut_subcommands(|command| match SHORT.iter().find(|short| short.command == command.get_name()) {
            Some(short) => short.arrange(command),
            None => command,
        });
    let template =
        format!("{{about}}\n\n{{usage-heading}} {{usage}}\n{}\nOptions:\n{{options}}{{after-help}}", groups(&program));
    program.help_template(template).after_help(
        "Examples:\n  erard press                        plays one note; then open erard-out/run.html\n  erard measure heavy-touch --sheet  what to turn on an action, and by how much\n\nThe options of a command, with examples: erard help press",
    )
}

/// The arguments, with `erard help press` as `erard press --help`.
pub(super) fn as_option(arguments: Vec<OsString>) -> Vec<OsString> {
    match &arguments[..] {
        [program, help, rest @ ..] if help == "help" && rest.len() < 2 => {
            std::iter::once(program).chain(rest).cloned().chain(["--help".into()]).collect()
        }
        _ => arguments,
    }
}

/// The commands in their groups, a line each.
fn groups(program: &Command) -> String {
    let mut text = String::new();
    for (group, commands) in GROUPS {
        // Writing to a string does not fail.
        let _ = writeln!(text, "\n{group}:");
        for name in commands {
            let about = match program.find_subcommand(name) {
                Some(command) => command.get_about().map(ToString::to_string).unwrap_or_default(),
                None if *name == "help" => "Prints the help of a command: erard help COMMAND".to_owned(),
                None => continue,
            };
            let _ = writeln!(text, "  {name:<12} {about}");
        }
    }
    text
}

impl Short {
    /// The place of an option among the common ones.
    fn place(&self, arg: &Arg) -> Option<usize> {
        self.common.iter().position(|name| arg.get_long() == Some(name))
    }

    /// Shows the common options first, and hides the others from the short help.
    fn arrange(&self, command: Command) -> Command {
        let all = command.get_arguments().filter(|arg| !arg.is_positional() && !arg.is_hide_set()).count();
        let is_longer = all > self.common.len() || command.get_after_help().is_some();
        let examples = self.examples();
        let long = match command.get_after_help().map(ToString::to_string) {
            Some(text) if text.starts_with("Examples:") => text,
            Some(text) => format!("{examples}\n{text}"),
            None => examples.clone(),
        };
        let rest = format!("\nAll options, the method and the files: erard {} --help-all", self.command);
        command
            .after_long_help(long)
            .after_help(format!(
                "{}{}",
                examples.trim_end(),
                if is_longer { format!("\n{rest}") } else { String::new() }
            ))
            .mut_args(|arg| match self.place(&arg) {
                _ if arg.is_positional() => arg,
                Some(at) => arg.display_order(at).help_heading(None::<&'static str>),
                None => {
                    let heading = arg.get_help_heading().map(str::to_owned);
                    let is_own = RECORDINGS.iter().any(|id| arg.get_id() == id);
                    let own = heading.filter(|heading| is_own || heading != "Recordings");
                    arg.hide_short_help(true).help_heading(own.unwrap_or_else(|| MORE.to_owned()))
                }
            })
    }

    fn examples(&self) -> String {
        let widest = self.examples.iter().map(|(typed, _)| typed.len()).max().unwrap_or(0);
        let line = |(typed, does): &(&str, &str)| {
            // One below the other where they do not fit beside each other.
            if widest + does.len() > 92 {
                format!("  {typed}\n      {does}\n")
            } else {
                format!("  {typed:<widest$}  {does}\n")
            }
        };
        format!("Examples:\n{}", self.examples.iter().map(line).collect::<String>())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::command::definition;

    fn help(arguments: &[&str]) -> String {
        definition().try_get_matches_from(arguments).expect_err("a help").to_string()
    }

    /// Every command has a short help and stands in one group; what the tables name exists.
    #[test]
    fn every_command_is_in_the_tables() {
        let mut program = definition();
        program.build();
        for command in program.get_subcommands().filter(|command| !command.is_hide_set()) {
            let name = command.get_name();
            let groups = GROUPS.iter().flat_map(|(_, commands)| *commands).filter(|one| **one == name);
            assert_eq!(groups.count(), 1, "{name}");
            let Some(short) = SHORT.iter().find(|short| short.command == name) else {
                assert_eq!(name, "help");
                continue;
            };
            for option in short.common {
                let is_one = command.get_arguments().any(|arg| arg.get_long() == Some(option));
                assert!(is_one, "{name} --{option}");
            }
        }
    }

    /// A help fits a screen: under 60 lines, no line over 100 characters. It ends with two commands that can be typed,
    /// and with the way to the rest.
    #[test]
    fn a_short_help_is_short() {
        for short in &SHORT {
            let name = short.command;
            let text = help(&["erard", name, "--help"]);
            assert_eq!(text, help(&["erard", name, "-h"]), "{name}");
            assert!(text.lines().count() < 60, "{name}: {} lines", text.lines().count());
            assert!(text.lines().all(|line| line.chars().count() <= 100), "{name}: {text}");
            assert!(text.contains("\nExamples:\n"), "{name}: {text}");
            for (typed, _) in short.examples {
                assert!(text.contains(typed), "{name}: {text}");
                let words = typed.split(" > ").next().unwrap().split(" | ").next().unwrap().split_whitespace();
                if let Err(error) = definition().try_get_matches_from(words) {
                    panic!("{typed}: {error}");
                }
            }
        }
        let text = help(&["erard", "--help"]);
        assert!(text.lines().count() < 60 && text.lines().all(|line| line.chars().count() <= 100), "{text}");
        for (group, commands) in GROUPS {
            assert!(text.contains(&format!("\n{group}:\n")), "{text}");
            assert!(commands.iter().all(|name| text.contains(&format!("\n  {name} "))), "{group}: {text}");
        }
    }

    /// `--help-all` has every option that is not hidden, the common ones first.
    #[test]
    fn all_options_are_in_the_long_help() {
        let mut program = definition();
        program.build();
        for short in &SHORT {
            let text = help(&["erard", short.command, "--help-all"]);
            let command = program.find_subcommand(short.command).unwrap();
            for arg in command.get_arguments().filter(|arg| !arg.is_hide_set()) {
                let Some(long) = arg.get_long() else { continue };
                assert!(text.contains(&format!("--{long}")), "{} --{long}", short.command);
            }
            let places = short
                .common
                .iter()
                .map(|option| text.find(&format!("  --{option}")).or(text.find(&format!(", --{option}"))));
            let places: Vec<usize> = places.map(|place| place.expect("an option")).collect();
            assert!(places.is_sorted(), "{}: {text}", short.command);
        }
    }

    #[test]
    fn words_that_are_no_command_and_options_of_others_are_explained() {
        for (typed, wanted) in [
            (&["erard", "C4"][..], "concert-grand:key=C4"),
            (&["erard", "mf"], "--stroke mf"),
            (&["erard", "press", "--vary", "let_off=0"], "`--vary` is an option of `study`"),
            (&["erard", "pres"], "a similar subcommand exists: 'press'"),
            (&["erard", "cite"], "--bibtex with any command"),
            (&["erard", "diagnose", "58", "18"], "readings are options: --down-weight 58 --up-weight 18"),
            (&["erard", "press", "--instrumnt", "x"], "a similar argument exists: '--instrument'"),
        ] {
            let mut error = definition().try_get_matches_from(typed).expect_err("an error");
            crate::suggest::complete(&mut error, &definition());
            let told = error.to_string();
            assert!(told.contains(wanted) && told.matches("tip:").count() == 1, "{typed:?}: {told}");
            assert_eq!(error.exit_code(), 2);
        }
    }
}
