//! Where a command's results go.

use std::path::{Path, PathBuf};

use clap::Args;

use crate::failure::Failure;
use crate::output::Output;

/// What the default folder of every command begins with. It is the whole name for `press`.
const DEFAULT: &str = "erard-out";

/// Where results go. The default folder is the command's own: see `with_default_folders`.
#[derive(Debug, Args)]
pub struct OutOptions {
    /// Output folder
    #[arg(id = "out", long = "out", value_name = "DIR", default_value = DEFAULT)]
    folder: PathBuf,
    /// Replace what stands in the way there: results of another command, or files that this command did not write
    #[arg(long)]
    force: bool,
}

impl OutOptions {
    /// The folder as it was asked for.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Makes sure, before any long work, that results of this command can be written; `certain` are the files that will come in any case.
    pub fn prepare(&self, command: &'static str, certain: &[&str]) -> Result<Output, Failure> {
        Output::results(&self.folder, command, self.force, certain)
    }
}

/// Gives every subcommand that writes results a default folder of its own: `erard-out` to `press`, `erard-out-NAME` to the others.
pub(crate) fn with_default_folders(program: clap::Command) -> clap::Command {
    program.mut_subcommands(|subcommand| {
        let own = match subcommand.get_name() {
            "press" => return subcommand,
            name => format!("{DEFAULT}-{name}"),
        };
        subcommand.mut_args(|arg| {
            let is_folder = arg.get_id() == "out" && !arg.get_default_values().is_empty();
            if is_folder { arg.default_value(own.clone()) } else { arg }
        })
    })
}
