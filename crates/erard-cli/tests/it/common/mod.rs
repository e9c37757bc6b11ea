//! Running the command as a user does, in a folder of its own.

#![allow(dead_code, reason = "every test file uses a part of it")]

pub mod schema;
#[cfg(unix)]
pub mod signals;
pub mod tree;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::atomic::{AtomicUsize, Ordering};

/// A folder of its own for a test, gone at its end.
pub struct Folder(pub PathBuf, Option<&'static str>);

impl Folder {
    /// An empty one.
    pub fn new(test: &str) -> Self {
        Self::of(test, None)
    }

    /// An empty one where every argument belongs to one subcommand.
    pub fn for_command(command: &'static str, test: &str) -> Self {
        Self::of(&format!("{command}-{test}"), Some(command))
    }

    fn of(test: &str, command: Option<&'static str>) -> Self {
        #[cfg(unix)]
        signals::as_at_a_terminal();
        // Tests of several modules run side by side in one process, and some have the same name.
        static FOLDERS: AtomicUsize = AtomicUsize::new(0);
        let number = FOLDERS.fetch_add(1, Ordering::Relaxed);
        let folder = std::env::temp_dir().join(format!("erard-{test}-{}-{number}", std::process::id()));
        let _ = fs::remove_dir_all(&folder);
        fs::create_dir_all(&folder).unwrap();
        Folder(folder, command)
    }

    /// Puts a file into it.
    pub fn file(&self, name: &str, text: &str) {
        fs::write(self.0.join(name), text).unwrap();
    }

    /// A file of it.
    pub fn read(&self, name: &str) -> String {
        fs::read_to_string(self.0.join(name)).unwrap()
    }

    /// The command, with this folder as its working directory.
    pub fn command(&self, arguments: &[&str]) -> Command {
        self.any_command(&[self.1.as_slice(), arguments].concat())
    }

    /// The program with these arguments, whatever subcommand the folder is for.
    pub fn any_command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(crate::PROGRAM);
        command.current_dir(&self.0).args(arguments);
        // The user's own cache is not touched.
        command.env("XDG_CACHE_HOME", concat!(env!("CARGO_TARGET_TMPDIR"), "/cache"));
        command
    }

    /// A program of another package, built beside what the tests run.
    pub fn beside(&self, program: &str, arguments: &[&str]) -> Command {
        let program = Path::new(crate::PROGRAM).with_file_name(format!("{program}{}", std::env::consts::EXE_SUFFIX));
        assert!(program.exists(), "{}: `cargo build --release --workspace` builds it", program.display());
        let mut command = Command::new(program);
        command.current_dir(&self.0).args(arguments);
        command
    }

    /// Runs the command.
    pub fn erard(&self, arguments: &[&str]) -> Output {
        self.command(arguments).output().unwrap()
    }

    /// Runs what must succeed; standard output.
    pub fn good(&self, arguments: &[&str]) -> String {
        self.short(&[&["--full"], arguments].concat())
    }

    /// Runs what must work; the first lines of its answer.
    pub fn short(&self, arguments: &[&str]) -> String {
        let output = self.erard(arguments);
        assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    }

    /// What [`Folder::good`] prints, unfolded: in words with one blank between them.
    pub fn good_words(&self, arguments: &[&str]) -> String {
        self.good(arguments).split_whitespace().collect::<Vec<_>>().join(" ")
    }

    /// Runs what must fail with code 2 and leave the folder as it was; standard error.
    pub fn bad(&self, arguments: &[&str]) -> String {
        let before = self.names();
        let output = self.erard(arguments);
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {said}");
        assert!(output.stdout.is_empty(), "{arguments:?}");
        assert_eq!(self.names(), before, "{arguments:?}");
        said
    }

    /// Words of an output, however they are folded.
    pub fn words(output: &str) -> String {
        output.split_whitespace().collect::<Vec<_>>().join(" ")
    }

    /// Names of its files and folders, sorted.
    pub fn names(&self) -> Vec<String> {
        let mut names: Vec<String> =
            fs::read_dir(&self.0).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}
