//! The command-line reference as a page of the book, from the commands' own definitions.

use std::fmt::Write;

use clap::Arg;

/// The page in Markdown: every command and option that `--help` lists, in the same order and words.
pub fn markdown(mut program: clap::Command) -> String {
    program.build();
    let mut page = String::from(
        "# Command-line reference\n\n\
         <!-- Written by `.ci/regenerate cli`: do not edit. -->\n\n",
    );
    paragraph(&mut page, &about(&program));
    paragraph(
        &mut page,
        "With this page you can look up every command and option; `erard COMMAND --help-all` prints the same. Exit codes: 0 done, \
         2 wrong input or usage, 130 interrupted, 1 anything else: goals that cannot be met, a doubtful fit, a failure.",
    );
    section(&mut page, &mut program);
    page.truncate(page.trim_end().len());
    page.push('\n');
    page
}

/// Appends a section for each subcommand.
fn section(page: &mut String, parent: &mut clap::Command) {
    for command in parent.get_subcommands_mut() {
        if command.is_hide_set() || command.get_name() == "help" {
            continue;
        }
        let name = command.get_bin_name().unwrap_or(command.get_name()).to_owned();
        paragraph(page, &format!("## {name}"));
        paragraph(page, &escape(&about(command)));
        let usage = command.render_usage().to_string();
        paragraph(page, &format!("```text\n{}\n```", usage.trim_start_matches("Usage:").trim()));

        let shown =
            |arg: &&Arg| !arg.is_hide_set() && !["help", "help-all", "version"].contains(&arg.get_id().as_str());
        let (positional, options): (Vec<&Arg>, Vec<&Arg>) =
            command.get_arguments().filter(shown).partition(|arg| arg.is_positional());
        for (title, list) in [("Arguments", positional), ("Options", options)] {
            if !list.is_empty() {
                paragraph(page, &format!("### {title} of {name}"));
                list.iter().for_each(|arg| item(page, arg));
                page.push('\n');
            }
        }
        if let Some(after) = command.get_after_long_help().or(command.get_after_help()) {
            paragraph(page, &below(&after.to_string()));
        }
        section(page, command);
    }
}

/// The text below a command's options. Lines that begin with two spaces are examples: a block.
fn below(text: &str) -> String {
    let mut out = String::new();
    let mut in_block = false;
    for line in text.lines() {
        let example = line.strip_prefix("  ");
        if example.is_some() != in_block {
            if in_block {
                out.push_str("```\n");
            } else {
                out.push_str(if out.ends_with("\n\n") { "```text\n" } else { "\n```text\n" });
            }
            in_block = !in_block;
        }
        out.push_str(&example.map_or_else(|| escape(line), str::to_owned));
        out.push('\n');
    }
    if in_block {
        out.push_str("```\n");
    }
    out
}

/// What a command is for, at length where it says so.
fn about(command: &clap::Command) -> String {
    command.get_long_about().or(command.get_about()).map(ToString::to_string).unwrap_or_default()
}

fn paragraph(page: &mut String, text: &str) {
    page.push_str(text.trim());
    page.push_str("\n\n");
}

/// One argument or option: how it is written, what it means, its default, its values.
fn item(page: &mut String, arg: &Arg) {
    let help = arg.get_long_help().or(arg.get_help()).map(ToString::to_string).unwrap_or_default();
    let mut line = format!("- `{}`", written(arg));
    for (before, text) in [(": ", escape(&help)), ("; default ", default(arg))] {
        if !text.is_empty() {
            line += &format!("{before}{text}");
        }
    }
    // Writing to a string does not fail.
    let _ = writeln!(page, "{line}");
    if !arg.get_action().takes_values() {
        return;
    }
    for value in arg.get_possible_values().iter().filter(|v| !v.is_hide_set()) {
        if let Some(help) = value.get_help() {
            let _ = writeln!(page, "  - `{}`: {}", value.get_name(), escape(&help.to_string()));
        }
    }
}

/// `-o, --out <DIR>`, `--labels`, `[STROKE.csv]`.
fn written(arg: &Arg) -> String {
    let value = || {
        let names = arg.get_value_names().unwrap_or_default();
        names.iter().map(|name| format!("<{name}>")).collect::<Vec<_>>().join(" ")
    };
    if arg.is_positional() {
        let value = value();
        return if arg.is_required_set() { value } else { format!("[{}]", value.trim_matches(['<', '>'])) };
    }
    let short = arg.get_short().map(|c| format!("-{c}"));
    let long = arg.get_long().map(|name| format!("--{name}"));
    let names = short.into_iter().chain(long).collect::<Vec<_>>().join(", ");
    if arg.get_action().takes_values() { format!("{names} {}", value()) } else { names }
}

fn default(arg: &Arg) -> String {
    if !arg.get_action().takes_values() || arg.is_hide_default_value_set() {
        return String::new();
    }
    let values = arg.get_default_values().iter().map(|v| format!("`{}`", v.to_string_lossy()));
    values.collect::<Vec<_>>().join(", ")
}

/// Text in which only backticks mean something.
fn escape(text: &str) -> String {
    let mut out = String::new();
    for (i, piece) in text.split('`').enumerate() {
        if i > 0 {
            out.push('`');
        }
        if i % 2 == 1 {
            out.push_str(piece);
            continue;
        }
        for c in piece.chars() {
            if matches!(c, '<' | '>' | '*' | '\\' | '[' | ']') {
                out.push('\\');
            }
            out.push(c);
        }
    }
    out
}
