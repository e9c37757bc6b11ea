//! `erard completions` and `erard man`: what shells and `man` want to know of this program.

use std::path::PathBuf;

use clap::Args;
use clap_complete::Shell;
use clap_mangen::Man as Page;

use crate::answer::Answer;
use crate::failure::Failure;
use crate::output::Output;
use crate::print_line;
use crate::session::Session;
use crate::suggest::meant;

/// Prints a script that completes `erard` commands in a shell.
#[derive(Debug, Args)]
pub(crate) struct Completions {
    /// Shell
    #[arg(value_enum)]
    shell: Shell,
}

impl Completions {
    /// Runs the command.
    pub(crate) fn run(&self) -> Result<Answer, Failure> {
        let mut script = Vec::new();
        clap_complete::generate(self.shell, &mut super::definition(), "erard", &mut script);
        Ok(Answer::text(String::from_utf8_lossy(&script)))
    }
}

/// Prints a manual page, or writes the pages of all commands into a folder.
#[derive(Debug, Args)]
pub(crate) struct Man {
    /// Command whose page to print [default: `erard` itself]
    #[arg(value_name = "COMMAND", conflicts_with = "out")]
    command: Option<String>,
    /// Write the pages of all commands into this folder: erard.1, erard-press.1 and so on
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Replace existing files of these names
    #[arg(long, requires = "out")]
    force: bool,
}

impl Man {
    /// Runs the command.
    pub(crate) fn run(&self, session: &mut Session) -> Result<Answer, Failure> {
        let mut program = super::definition();
        program.build();
        if let Some(folder) = &self.out {
            let pages: Vec<(String, clap::Command)> = std::iter::once(("erard.1".to_owned(), program.clone()))
                .chain(program.get_subcommands().filter(|c| c.get_name() != "help").map(|command| {
                    let name = format!("erard-{}", command.get_name());
                    (format!("{name}.1"), command.clone().display_name(name))
                }))
                .collect();
            let names: Vec<&str> = pages.iter().map(|(name, _)| name.as_str()).collect();
            let mut output = Output::files(session, folder, self.force, &names)?;
            for (name, command) in &pages {
                output.stage(session, name, |w| Page::new(command.clone()).render(w))?;
            }
            let written = output.commit(session)?;
            print_line!(session, "{written}");
            return Ok(Answer::table(session, None).files(&written));
        }
        let command = match &self.command {
            None => program,
            Some(name) => {
                let found = program.find_subcommand(name).cloned();
                let names: Vec<String> = program.get_subcommands().map(|one| one.get_name().to_owned()).collect();
                let found = found.ok_or_else(|| {
                    let known: Vec<&str> = names.iter().map(String::as_str).collect();
                    let meant = meant(name, known);
                    Failure::Usage(format!("there is no command `{name}`{meant}; `erard --help` lists them"))
                })?;
                found.display_name(format!("erard-{name}"))
            }
        };
        let mut page = Vec::new();
        Page::new(command).render(&mut page).map_err(Failure::Said)?;
        Ok(Answer::text(String::from_utf8_lossy(&page)))
    }
}
