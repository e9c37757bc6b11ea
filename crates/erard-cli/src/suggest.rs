//! What a name that nothing has was probably meant for: a name spelt nearly so, or a thing of another kind with what to
//! type instead. Every name that a user types is answered by this module.

use clap::error::{ContextKind, ContextValue, ErrorKind};
use erard::instrument::Instrument;
use erard::key::{key_named, note_name};
use erard::keyboard::Keyboard;
use erard::parameter::{Parameter, canonical_name};
use erard::stroke::{NUANCES, Touch};
use erard_kinematics::LinkageFile;
use erard_workshop::measure::norms::lines;

/// The commands by what they are for, as the help lists them.
pub(crate) const GROUPS: [(&str, &[&str]); 5] = [
    ("Play", &["press", "play", "studio", "draw"]),
    ("In the workshop", &["measure", "diagnose", "regulate", "keyboard"]),
    ("Research", &["study", "compare", "fit", "validate", "listen", "kinematics"]),
    ("Build", &["live", "calibrate", "scan", "fmu"]),
    ("Files and this program", &["list", "check", "completions", "man", "help"]),
];

/// Names at least so similar (Jaro-Winkler, 0 to 1) are suggested.
const SIMILAR: f64 = 0.84;
/// At most so many.
const MOST: usize = 3;
/// Words of those who want to cite a result.
const CITING: [&str; 5] = ["cite", "citation", "citing", "bibtex", "reference"];
/// Words for pianos that are no grands.
const UPRIGHTS: [&str; 5] = ["upright", "pianino", "klavier", "piano-droit", "vertical"];

/// The known names most similar to one, at most three, the nearest first. A name that continues what was typed counts
/// as similar, whatever its length.
pub(crate) fn near<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Vec<&'a str> {
    let plain = |name: &str| name.to_lowercase().replace(['_', '.', ' ', ':'], "-");
    let typed = plain(&canonical_name(name));
    let likeness = |known: &str| {
        let own = plain(known);
        let continues = typed.len() > 2 && (own.starts_with(&typed) || own.contains(&format!("-{typed}")));
        let joined = own.replace('-', "") == typed.replace('-', "");
        if continues || joined { 1.0 } else { strsim::jaro_winkler(&typed, &own) }
    };
    let mut all: Vec<(f64, &str)> = known.into_iter().map(|known| (likeness(known), known)).collect();
    all.retain(|(likeness, _)| *likeness >= SIMILAR);
    all.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.len().cmp(&b.1.len())));
    all.dedup_by_key(|(_, name)| *name);
    all.into_iter().take(MOST).map(|(_, name)| name).collect()
}

/// The end of a message on a name that nothing of `known` has: `; did you mean ...?`, what else the name is, or
/// nothing.
pub(crate) fn meant<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    let near = near(name, known);
    match (what_it_is(name), &near[..]) {
        (Some(other), _) => format!("; {other}"),
        (None, []) => String::new(),
        (None, near) => format!("; did you mean {}?", quoted(near)),
    }
}

/// Names in backticks: `a`, `b` or `c`.
pub(crate) fn quoted(names: &[&str]) -> String {
    let all: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
    match &all[..] {
        [others @ .., last] if !others.is_empty() => format!("{} or {last}", others.join(", ")),
        _ => all.concat(),
    }
}

/// What a name is that was typed where something else is expected, and what to type instead.
pub(crate) fn what_it_is(name: &str) -> Option<String> {
    let name = name.trim();
    let lower = name.to_lowercase();
    if CITING.contains(&lower.as_str()) {
        return Some("--bibtex with any command prints a BibTeX entry that cites its answer".to_owned());
    }
    if UPRIGHTS.iter().any(|word| lower.contains(word)) {
        return Some("Erard has grands only so far: an upright's hammer returns by springs".to_owned());
    }
    if NUANCES.contains(&name) {
        return Some(format!("`{name}` is a level: --stroke {name}"));
    }
    if let Some((level, touch)) = name.split_once('-')
        && NUANCES.contains(&level)
        && [Touch::Pressed, Touch::Struck].iter().any(|one| one.name() == touch)
    {
        return Some(format!("`{name}` is a stroke: --stroke {level} --touch {touch}"));
    }
    if let Some(key) = key_named(name) {
        let note = note_name(key);
        return Some(format!("`{name}` is a key: concert-grand:key={note}, or --key {note}"));
    }
    if let Some(note) = german(name) {
        return Some(format!("the German {name} is {note} here: concert-grand:key={note}, or --key {note}"));
    }
    if Instrument::builtin_names().any(|one| one == name) {
        return Some(format!("`{name}` is an instrument: --instrument {name}"));
    }
    if Keyboard::builtin_names().any(|one| one == name) {
        return Some(format!("`{name}` is a keyboard: erard keyboard {name}"));
    }
    if LinkageFile::builtin_names().any(|one| one == name) {
        return Some(format!("`{name}` is a linkage: erard kinematics {name}"));
    }
    if GROUPS.iter().flat_map(|(_, commands)| *commands).any(|one| *one == name) {
        return Some(format!("`{name}` is a command: erard {name} --help"));
    }
    if let Some(line) = lines().find(|line| line.key == name) {
        return Some(format!("`{name}` is a quantity: erard measure --only {}", line.key));
    }
    let grand = Instrument::builtin("concert-grand").ok()?;
    let parameters = Parameter::all(&grand);
    let parameter = parameters.iter().find(|(own, _)| *own == canonical_name(name))?;
    Some(format!("`{name}` is a parameter: erard study --vary {}=...", parameter.0))
}

/// The note that a German name means: H is B.
pub(crate) fn german(name: &str) -> Option<String> {
    let octave = name.strip_prefix(['H', 'h'])?;
    key_named(&format!("B{octave}")).map(note_name)
}

/// Adds to the error of the arguments what an unknown command or option was probably meant for, where the parser has no
/// suggestion: what a word is, or the commands that have the option.
pub(crate) fn complete(error: &mut clap::Error, definition: &clap::Command) {
    let (invalid, known) = match error.kind() {
        ErrorKind::InvalidSubcommand => (ContextKind::InvalidSubcommand, ContextKind::SuggestedSubcommand),
        ErrorKind::UnknownArgument => (ContextKind::InvalidArg, ContextKind::SuggestedArg),
        _ => return,
    };
    let Some(ContextValue::String(found)) = error.get(invalid).cloned() else { return };
    // What a word is goes before a name that is only spelt like it.
    let is_word = CITING.contains(&found.as_str());
    if is_word {
        error.remove(known);
    }
    if error.get(known).is_some() {
        return;
    }
    let of_readings = error.get(ContextKind::Usage).is_some_and(|usage| usage.to_string().contains("erard diagnose"));
    let tip = match found.strip_prefix("--") {
        Some(option) => {
            let has = |one: &&clap::Command| one.get_arguments().any(|arg| arg.get_long() == Some(option));
            let commands: Vec<&str> = definition.get_subcommands().filter(has).map(clap::Command::get_name).collect();
            (!commands.is_empty()).then(|| format!("`{found}` is an option of {}", quoted(&commands)))
        }
        None if of_readings && found.parse::<f64>().is_ok() => {
            Some("readings are options: --down-weight 58 --up-weight 18".to_owned())
        }
        None => what_it_is(&found),
    };
    if let Some(tip) = tip {
        error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![tip.into()]));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_nearly_right_is_answered_by_the_right_one() {
        let instruments = || Instrument::builtin_names();
        for (typed, wanted) in [
            ("steinway", "steinway-o"),
            ("concert_grand", "concert-grand"),
            ("heavytouch", "heavy-touch"),
            ("concrt-grand", "concert-grand"),
        ] {
            assert_eq!(near(typed, instruments()).first(), Some(&wanted), "{typed}");
        }
        let keys = || lines().map(|line| line.key);
        for (typed, wanted) in
            [("downweight", "down_weight_g"), ("let_off", "let_off_mm"), ("inertia", "effective_inertia_kg")]
        {
            assert!(near(typed, keys()).contains(&wanted), "{typed}: {:?}", near(typed, keys()));
        }
        assert!(near("xyzzy", instruments()).is_empty() && near("xyzzy", keys()).is_empty());
    }

    #[test]
    fn a_name_of_another_kind_is_answered_by_what_to_type() {
        for (typed, wanted) in [
            ("C4", "concert-grand:key=C4"),
            ("40", "concert-grand:key=C4"),
            ("H4", "concert-grand:key=B4"),
            ("upright", "grands only so far"),
            ("mf", "--stroke mf"),
            ("pp-struck", "--stroke pp --touch struck"),
            ("heavy-touch", "--instrument heavy-touch"),
            ("c7f-like", "erard kinematics c7f-like"),
            ("measure", "erard measure --help"),
            ("dip_mm", "erard measure --only dip_mm"),
            ("let_off", "erard study --vary let_off="),
        ] {
            let found = what_it_is(typed).unwrap_or_default();
            assert!(found.contains(wanted), "{typed}: {found}");
        }
        assert_eq!(what_it_is("xyzzy"), None);
    }
}
