//! Where a command's results go.

use std::path::{Path, PathBuf};

use clap::Args;

use crate::failure::Failure;
use crate::inputs::shown;
use crate::output::Output;
use crate::session::Session;

/// What the default folder of every command begins with. It is the whole name for `press`.
const DEFAULT: &str = "erard-out";

/// Where results go. The default folder is the command's own: see `with_default_folders`.
#[derive(Debug, Args)]
pub struct OutOptions {
    /// Output folder
    #[arg(id = "out", long = "out", value_name = "DIR", default_value = DEFAULT)]
    folder: PathBuf,
    /// Overwrite files in the output folder that this command did not write
    #[arg(long)]
    force: bool,
}

impl OutOptions {
    /// The folder as it was asked for.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Makes sure, before any long work, that results of this command can be written; `certain` are the files that will
    /// come in any case.
    pub fn prepare(&self, session: &Session, command: &'static str, certain: &[&str]) -> Result<Output, Failure> {
        Output::results(session, &self.folder, command, self.force, certain)
    }
}

/// Gives every subcommand that writes results a default folder of its own: `erard-out` to `press`, `erard-out-NAME` to
/// the others.
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

/// A file that belongs to the user, among others of theirs.
pub(crate) struct OwnFile {
    pub folder: PathBuf,
    pub name: String,
}

impl OwnFile {
    /// Where `--out-file` says; else here, named after the instrument with this `end`. `whose` file it is, messages
    /// say.
    ///
    /// # Errors
    /// [`Failure::Usage`] for a name that cannot be, or must not be replaced.
    pub(crate) fn of(
        session: &Session,
        out: Option<&Path>,
        asked: &str,
        end: &str,
        whose: &str,
        force: bool,
    ) -> Result<Self, Failure> {
        let named = || {
            let stem = Path::new(asked).file_stem().unwrap_or_default().to_string_lossy();
            PathBuf::from(format!("{}{end}", stem.replace([':', '='], "-")))
        };
        let file = out.map_or_else(named, Path::to_path_buf);
        let wrong = |why: &str| Err(Failure::Usage(format!("{}: {why}", shown(&file))));
        let extension = end.rsplit('.').next().unwrap_or_default();
        if file.is_dir() {
            return wrong(&format!("is a folder; expected a file name: --out-file names the {whose} file"));
        }
        if file.extension().is_none_or(|own| !own.eq_ignore_ascii_case(extension)) {
            return wrong(&format!("expected a name that ends in .{extension}"));
        }
        if session.inputs.is_one(&file) {
            return wrong("is the input instrument, which is never overwritten; name another file with --out-file");
        }
        if file.exists() && !force {
            return wrong("exists; name another file with --out-file, or add --force to replace it");
        }
        let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
        Ok(OwnFile { folder: folder.to_path_buf(), name })
    }
}
