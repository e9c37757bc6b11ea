//! The sources of a session's results: the program, the command, and the files and built-in data that it was made
//! from.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::fmt::Write;

use clap::{ArgMatches, Command};
use erard_figures::made_by::{MadeBy, Source};
use serde_json::Value;
use sha2::{Digest, Sha256};

use crate::table::{MAX_WIDTH, wrapped};

/// The commit that the program was built from, where that was known; a `+`: changed since.
pub(crate) const COMMIT: Option<&str> = option_env!("ERARD_COMMIT");

/// The version, with the commit where it is known.
pub fn version() -> String {
    let commit = COMMIT.map_or(String::new(), |commit| format!(" ({commit})"));
    format!("{}{commit}", env!("CARGO_PKG_VERSION"))
}

/// Options that say where results go and how they are reported, not what they are; with a value, or without.
const ELSEWHERE: [(&str, bool); 7] = [
    ("out", true),
    ("out-file", true),
    ("force", false),
    ("quiet", false),
    ("json", false),
    ("full", false),
    ("bibtex", false),
];

/// The command line, and what was read.
#[derive(Debug, Default)]
pub struct Provenance {
    command: String,
    /// All options.
    options: BTreeMap<String, Vec<String>>,
    /// What was read, in its order.
    sources: Vec<Source>,
}

impl Provenance {
    /// Remembers the command that was asked for.
    pub(crate) fn remember(&mut self, arguments: &[OsString], definition: &Command, matches: &ArgMatches) {
        let mut command = definition.get_name().to_owned();
        let mut skip = false;
        for argument in arguments.iter().skip(1).map(|argument| argument.to_string_lossy()) {
            if std::mem::take(&mut skip) {
                continue;
            }
            let option = argument
                .strip_prefix("--")
                .map(|rest| rest.split_once('=').map_or((rest, false), |(name, _)| (name, true)));
            if let Some((_, takes_value)) =
                ELSEWHERE.iter().find(|(name, _)| option.is_some_and(|(own, _)| own == *name))
            {
                skip = *takes_value && option.is_some_and(|(_, has_value)| !has_value);
                continue;
            }
            command.push(' ');
            command.push_str(&quoted(&argument));
        }
        let mut options = BTreeMap::new();
        // A program without subcommands is its own.
        let chosen = match matches.subcommand() {
            Some((name, matches)) => definition.find_subcommand(name).map(|definition| (definition, matches)),
            None => Some((definition, matches)),
        };
        if let Some((definition, matches)) = chosen {
            for argument in definition.get_arguments() {
                let id = argument.get_id().as_str();
                if ELSEWHERE.iter().any(|(name, _)| name.replace('-', "_") == id) {
                    continue;
                }
                if let Ok(Some(values)) = matches.try_get_raw(id) {
                    options.insert(id.to_owned(), values.map(|value| value.to_string_lossy().into_owned()).collect());
                }
            }
        }
        (self.command, self.options) = (command, options);
    }

    /// Remembers what results are made from; `file` as it was given, `bytes` as they were read.
    pub fn used(&mut self, kind: &str, name: &str, file: Option<&str>, bytes: &[u8]) {
        self.push(kind, name, file, Some(hex(&Sha256::digest(bytes))));
    }

    /// The same of something that has no bytes, such as a constant force.
    pub(crate) fn used_without_file(&mut self, kind: &str, name: &str) {
        self.push(kind, name, None, None);
    }

    /// The same of a file that was hashed while it was read.
    pub(crate) fn used_hashed(&mut self, kind: &str, name: &str, file: &str, hash: Sha256) {
        self.push(kind, name, Some(file), Some(hex(&hash.finalize())));
    }

    fn push(&mut self, kind: &str, name: &str, file: Option<&str>, sha256: Option<String>) {
        let file = file.map(str::to_owned);
        let source = Source { kind: kind.into(), name: name.into(), file, sha256, preparation: None };
        if !self.sources.iter().any(|own| Source { preparation: None, ..own.clone() } == source) {
            self.sources.push(source);
        }
    }

    /// Remembers what was done to a recording that was read, by its name. A recording that was prepared in two ways
    /// stands there twice.
    pub(crate) fn prepared(&mut self, name: &str, preparation: Value) {
        let is_own = |source: &Source| source.kind == "recording" && source.name == name;
        if self.sources.iter().any(|source| is_own(source) && source.preparation.as_ref() == Some(&preparation)) {
            return;
        }
        let Some(first) = self.sources.iter_mut().find(|source| is_own(source)) else { return };
        if first.preparation.is_none() {
            first.preparation = Some(preparation);
        } else {
            let again = Source { preparation: Some(preparation), ..first.clone() };
            self.sources.push(again);
        }
    }

    /// How the results are made again: the command, the version, and a digest of what they were made from.
    pub(crate) fn repeated(&self) -> String {
        let version = version().replace(['(', ')'], "");
        let digest = self.digest().map_or(String::new(), |digest| format!(", digest {digest}"));
        let made = format!("(erard {version}{digest})");
        // Two blanks keep a line unfolded, so that it can be copied into a shell.
        let whole = format!("Repeat:  {}  {made}", self.command);
        if whole.chars().count() <= MAX_WIDTH {
            return whole;
        }
        // A break within quotes would be one in the word.
        const HELD: char = '\u{e000}';
        let mut is_quoted = false;
        let held = self.command.chars().map(|c| {
            is_quoted ^= c == '\'';
            if c == ' ' && is_quoted { HELD } else { c }
        });
        let words = wrapped(&held.collect::<String>(), MAX_WIDTH - 12);
        format!("Repeat:  {}\n  {made}", words.join(" \\\n           ").replace(HELD, " "))
    }

    /// The first signs of a digest of all that was read; `None` if nothing was.
    fn digest(&self) -> Option<String> {
        let digests: Vec<&str> = self.sources.iter().filter_map(|source| source.sha256.as_deref()).collect();
        let all = match digests[..] {
            [] => return None,
            [one] => one.to_owned(),
            _ => hex(&Sha256::digest(digests.join("\n"))),
        };
        Some(all[..12].to_owned())
    }

    /// A BibTeX entry for the program as it made the answer. `CITATION.cff` has the same title and authors.
    pub(crate) fn bibtex(&self) -> String {
        let commit = COMMIT.map(|commit| format!("commit {commit}"));
        let command = format!("\\texttt{{{}}}", in_latex(&self.command));
        let digest = self.digest().map(|digest| format!("digest {digest}"));
        let note = commit.into_iter().chain([command]).chain(digest).collect::<Vec<_>>().join(", ");
        format!(
            "@software{{erard,\n  author  = {{{{The Erard developers}}}},\n  title   = {{Erard: a simulator of the grand \
             piano action}},\n  version = {{{}}},\n  note    = {{{note}}}\n}}",
            env!("CARGO_PKG_VERSION")
        )
    }

    /// What makes the results now.
    pub(crate) fn made_by(&self) -> MadeBy {
        MadeBy {
            program: "erard".into(),
            version: env!("CARGO_PKG_VERSION").into(),
            commit: COMMIT.map(str::to_owned),
            command: self.command.clone(),
            options: self.options.clone(),
            sources: self.sources.clone(),
        }
    }
}

/// A word as a shell takes it.
fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || "-_./:=,@%+#".contains(c);
    if !word.is_empty() && !word.starts_with('#') && word.chars().all(plain) {
        return word.to_owned();
    }
    format!("'{}'", word.replace('\'', "'\\''"))
}

/// A text as LaTeX prints it.
fn in_latex(text: &str) -> String {
    let escaped = |c: char| match c {
        '\\' => "\\textbackslash{}".to_owned(),
        '~' => "\\textasciitilde{}".to_owned(),
        '^' => "\\textasciicircum{}".to_owned(),
        // Two dashes in a row would be one.
        '-' => "-{}".to_owned(),
        '#' | '$' | '%' | '&' | '_' | '{' | '}' => format!("\\{c}"),
        c => c.to_string(),
    };
    text.chars().map(escaped).collect()
}

pub(crate) fn hex(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |mut text, byte| {
        // Writing to a string does not fail.
        let _ = write!(text, "{byte:02x}");
        text
    })
}

/// A result with what made it in it, by the ending of its name; of other kinds as it is.
pub(crate) fn stamped(made_by: &MadeBy, name: &str, bytes: Vec<u8>) -> Vec<u8> {
    let text = |stamp: &dyn Fn(&str) -> String| match std::str::from_utf8(&bytes) {
        Ok(text) => stamp(text).into_bytes(),
        Err(_) => bytes.clone(),
    };
    match name.rsplit_once('.').map(|(_, ending)| ending) {
        Some("svg") => text(&|svg| made_by.in_svg(svg)),
        Some("html") => text(&|html| made_by.in_html(html)),
        Some("json") => text(&|json| made_by.in_json(json)),
        Some("png") => made_by.in_png(&bytes),
        _ => bytes,
    }
}

/// Whether a result of this name carries what made it.
pub(crate) fn is_stamped(name: &str) -> bool {
    [".svg", ".html", ".json", ".png"].iter().any(|ending| name.ends_with(ending))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_quoted_as_a_shell_needs_it() {
        for (word, wanted) in [
            ("mf", "mf"),
            ("a b", "'a b'"),
            ("it's", "'it'\\''s'"),
            ("", "''"),
            ("F [gf]", "'F [gf]'"),
            ("#1", "'#1'"),
            ("x.csv", "x.csv"),
        ] {
            assert_eq!(quoted(word), wanted);
        }
    }

    /// FIPS 180-4's example.
    #[test]
    fn the_digest_is_sha_256() {
        let abc = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!(hex(&Sha256::digest(b"abc")), abc);
    }
}
