//! A command line by chance.

use clap::Arg;
use fastrand::Rng;
use serde_json::Value;

use super::world::{INPUTS, OUTPUTS};

/// A command line.
#[derive(Clone)]
pub struct Line {
    pub arguments: Vec<String>,
}

/// What makes a command quick enough to come to its end; a command that is not here is attacked without.
const SHORT: &[(&str, &[&str])] = &[
    ("press", &["--duration", "0.01"]),
    ("study", &["--vary", "let_off=0mm,0.1mm", "--duration", "0.005"]),
    ("keyboard", &["--every", "87"]),
    ("fit", &["concert-grand-rigid", "in/good.csv", "--parameters", "body.hammer.mass", "--restarts", "0"]),
    ("compare", &["in/good.csv", "--no-pictures"]),
    ("regulate", &["in/good.toml", "--let-off", "2mm"]),
    ("check", &["in/good.toml"]),
    ("scan", &["--cases", "half-stroke", "--keys", "40", "--keyboard", "concert-grand", "--no-scatter"]),
];

/// Numbers and words that no option waits for.
const NUMBERS: [&str; 22] = [
    "0",
    "-0",
    "1",
    "-1",
    "1e308",
    "1e400",
    "-1e-400",
    "nan",
    "inf",
    "-inf",
    "5e7",
    "1e-300",
    "0x10",
    "18446744073709551616",
    "2mm",
    "-3mm",
    "5N",
    "1/8",
    "1..2:3",
    "let_off=0mm..1e9mm:99999999",
    "force=-5",
    "force=nan,1e400",
];
const WORDS: [&str; 12] = [
    "",
    " ",
    "-",
    "--",
    "*",
    "concert-grand:key=89",
    "concert-grand:key=1..1000",
    "concert-grand:sample=-1",
    "\u{1b}[31mred",
    "é\u{202e}x",
    "a=b=c",
    "body.hammer.mass=1e99",
];

/// What the name of a value says where a file is meant.
const FILES: [&str; 14] = [
    "FILE",
    "CSV",
    "RECORDING",
    "NAME",
    "INSTRUMENT",
    "KEYBOARD",
    "MID",
    "WAV",
    "TOML",
    "STREAM",
    "READINGS",
    "STROKE",
    "MEASURED",
    "FOLDER",
];

impl Line {
    /// The line of a seed: the same every time.
    pub fn of(seed: u64) -> Self {
        let mut rng = Rng::with_seed(seed);
        let mut program = erard_cli::command::definition();
        program.build();
        // The studio serves until it is ended.
        let skipped = ["help", "studio"];
        let mut commands: Vec<&clap::Command> =
            program.get_subcommands().filter(|command| !skipped.contains(&command.get_name())).collect();
        // What has become a program of its own only says so: seldom.
        if rng.u8(..) > 20 {
            commands.retain(|command| !command.is_hide_set());
        }
        let command = commands[rng.usize(..commands.len())];
        let name = command.get_name();
        let mut arguments = vec![name.to_owned()];
        if rng.u8(..) < 180
            && let Some((_, short)) = SHORT.iter().find(|(own, _)| *own == name)
        {
            arguments.extend(short.iter().map(|one| (*one).to_owned()));
        }
        let known: Vec<&Arg> = command.get_arguments().filter(|one| one.get_id() != "help").collect();
        for _ in 0..rng.usize(..4).saturating_sub(1) {
            if !known.is_empty() {
                give(known[rng.usize(..known.len())], &mut arguments, &mut rng);
            }
        }
        for (id, chance) in [("out", 160), ("out_file", 160), ("force", 110)] {
            let own = known.iter().find(|one| one.get_id() == id && one.get_long().is_some());
            if let Some(own) = own.filter(|_| rng.u8(..) < chance) {
                give(own, &mut arguments, &mut rng);
            }
        }
        if rng.u8(..) < 90 {
            arguments.push("--json".into());
        }
        Line { arguments }
    }

    /// Every option of every command with every hostile value, as the program describes itself, and every name of the
    /// register with every number: the lines in order, each with a word on its trial.
    pub fn swept() -> Vec<(String, Self)> {
        let mut program = erard_cli::command::definition();
        program.build();
        let mut lines = Vec::new();
        let skipped = ["help", "studio"];
        for command in program.get_subcommands().filter(|one| !skipped.contains(&one.get_name()) && !one.is_hide_set())
        {
            let name = command.get_name();
            let short = SHORT.iter().find(|(own, _)| *own == name).map_or(&[][..], |(_, short)| short);
            for arg in command.get_arguments().filter(|one| one.get_id() != "help") {
                let option = arg.get_long().map(|long| format!("--{long}"));
                // What makes the command short, without this option and its value, and without files where one is
                // tried.
                let mut arguments = vec![name.to_owned()];
                let mut is_own = false;
                for one in short {
                    let is_value = !one.starts_with("--");
                    if option.is_none() && is_value && arguments.last().is_none_or(|last| !last.starts_with("--")) {
                        continue;
                    }
                    is_own = if is_value { is_own } else { option.as_deref() == Some(*one) };
                    if !is_own {
                        arguments.push((*one).to_owned());
                    }
                }
                arguments.push("--json".into());
                let with = |value: Option<&str>| {
                    let mut arguments = arguments.clone();
                    match (&option, value) {
                        (Some(option), Some(value)) => arguments.push(format!("{option}={value}")),
                        (Some(option), None) => arguments.push(option.clone()),
                        (None, value) => arguments.push(value.unwrap_or_default().to_owned()),
                    }
                    let what = format!("{name} {}", option.as_deref().unwrap_or(arg.get_id().as_str()));
                    (what, Line { arguments })
                };
                if !arg.get_action().takes_values() {
                    lines.push(with(None));
                    continue;
                }
                let long = "9".repeat(100_000);
                let values = NUMBERS.iter().chain(&WORDS).chain(&INPUTS).chain(&OUTPUTS).copied().chain([&long[..]]);
                lines.extend(values.map(|value| with(Some(value))));
            }
        }
        let grand = erard::Instrument::builtin("concert-grand-rigid").unwrap();
        for (name, _) in erard::parameter::Parameter::all(&grand) {
            for value in NUMBERS {
                let played =
                    ["study", "--instrument=concert-grand-rigid", "--force-step=5", "--duration=0.002", "--json"];
                let arguments = played.iter().map(|one| (*one).to_owned()).chain([format!("--vary={name}={value}")]);
                lines.push((name.clone(), Line { arguments: arguments.collect() }));
            }
        }
        lines
    }

    /// As it is printed.
    pub fn shown(&self) -> String {
        self.arguments.iter().map(|one| format!("{one:.60?} ")).collect()
    }

    fn has(&self, option: &str) -> bool {
        self.arguments.iter().take_while(|one| *one != "--").any(|one| one == option)
    }

    /// Whether the answer is wanted as JSON.
    pub fn wants_json(&self) -> bool {
        self.has("--json")
    }

    /// Whether it may replace what stands in the way.
    pub fn may_force(&self) -> bool {
        self.has("--force")
    }

    /// Whether the program only shows its help or version.
    pub fn asks_for_help(&self) -> bool {
        ["--help", "-h", "--help-all", "--version", "-V"].iter().any(|option| self.has(option))
    }

    /// The command.
    pub fn command(&self) -> &str {
        &self.arguments[0]
    }

    /// The schema of its answer.
    pub fn schema(&self, answer: &Value) -> &str {
        match self.command() {
            "study" if self.has("--sensitivities") => "study-sensitivities",
            "press" if answer.get("runs").is_some() => "press-two",
            "measure" if answer.get("bands").is_some() => "measure-bands",
            "measure" if answer["instruments"][0].get("timing").is_some() => "measure-two",
            "measure" if answer.get("instruments").is_some() => "measure-many",
            "study" if answer.get("failed_samples").is_some() => "study-bands",
            "validate" if answer.get("failed_samples").is_some() => "validate-bands",
            "keyboard" if answer.get("names").is_some() => "keyboard-two",
            "kinematics" if self.has("--list") => "list",
            "kinematics" if self.has("--check-file") => "check",
            _ if answer.get("text").is_some() => "text",
            own => own,
        }
    }
}

/// Gives an argument, with a value by chance where it takes one.
fn give(arg: &Arg, arguments: &mut Vec<String>, rng: &mut Rng) {
    if let Some(long) = arg.get_long() {
        arguments.push(format!("--{long}"));
    }
    if !arg.get_action().takes_values() {
        return;
    }
    let names = arg.get_value_names().unwrap_or_default();
    let asks = |what: &[&str]| what.iter().any(|what| names.iter().any(|name| name.to_uppercase().contains(what)));
    let pick = |from: &[&str], rng: &mut Rng| from[rng.usize(..from.len())].to_owned();
    let own: Vec<String> = arg.get_possible_values().iter().map(|one| one.get_name().to_owned()).collect();
    let value = match rng.u8(..100) {
        0..60 if ["out", "out_file"].iter().any(|id| arg.get_id() == *id) || asks(&["DIR"]) => pick(&OUTPUTS, rng),
        0..60 if asks(&FILES) => pick(&INPUTS, rng),
        0..60 if !own.is_empty() => own[rng.usize(..own.len())].clone(),
        0..80 => pick(&NUMBERS, rng),
        80..86 => pick(&INPUTS, rng),
        86..98 => pick(&WORDS, rng),
        _ => "9".repeat(100_000),
    };
    // As clap wants a value that begins like an option.
    match arguments.last_mut() {
        Some(last) if arg.get_long().is_some() && rng.bool() => last.push_str(&format!("={value}")),
        _ => arguments.push(value),
    }
}
