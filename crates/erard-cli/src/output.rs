//! What a command puts out: on standard output, and into a folder, where all files appear or none of them.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use crate::failure::Failure;

/// Prints a line on standard output. A reader that has gone away, as in `erard check FILE | head -1`, is no failure.
#[macro_export]
macro_rules! say {
    ($($text:tt)*) => {{
        use std::io::Write as _;
        let _ = writeln!(std::io::stdout(), $($text)*);
    }};
}

/// A folder that files are collected for. Nothing stands there under its own name before [`Output::commit`].
#[derive(Debug)]
pub struct Output {
    folder: PathBuf,
    staged: Vec<(PathBuf, PathBuf)>,
    /// Folders that did not exist before, outermost first: taken away again if nothing comes of it.
    made: Vec<PathBuf>,
}

impl Output {
    /// Makes sure that the folder exists and can be written to, before any long work.
    ///
    /// # Errors
    /// [`Failure::Write`].
    pub fn prepare(folder: &Path) -> Result<Self, Failure> {
        let mut made: Vec<PathBuf> = folder
            .ancestors()
            .take_while(|f| !f.as_os_str().is_empty() && !f.exists())
            .map(Path::to_path_buf)
            .collect();
        made.reverse();
        let output = Output { folder: folder.to_path_buf(), staged: Vec::new(), made };
        let refused = |source| Failure::Write { path: folder.to_path_buf(), source };
        fs::create_dir_all(folder).map_err(refused)?;
        let probe = output.beside(".writable");
        fs::write(&probe, b"").map_err(refused)?;
        fs::remove_file(&probe).map_err(refused)?;
        Ok(output)
    }

    fn beside(&self, name: &str) -> PathBuf {
        self.folder.join(format!(".{name}.{}.part", std::process::id()))
    }

    /// Writes a file beside its final name.
    ///
    /// # Errors
    /// [`Failure::Write`].
    pub fn stage(
        &mut self,
        name: &str,
        write: impl FnOnce(&mut dyn Write) -> std::io::Result<()>,
    ) -> Result<(), Failure> {
        let part = self.beside(name);
        let path = self.folder.join(name);
        self.staged.push((part.clone(), path.clone()));
        let refused = |source| Failure::Write { path: path.clone(), source };
        let mut file = std::io::BufWriter::new(fs::File::create(&part).map_err(refused)?);
        write(&mut file).and_then(|()| file.flush()).map_err(refused)
    }

    /// Gives all staged files their names; returns them.
    ///
    /// # Errors
    /// [`Failure::Write`].
    pub fn commit(mut self) -> Result<Vec<PathBuf>, Failure> {
        let staged = std::mem::take(&mut self.staged);
        self.made.clear();
        let mut written = Vec::new();
        for (part, path) in staged {
            fs::rename(&part, &path).map_err(|source| Failure::Write { path: path.clone(), source })?;
            written.push(path);
        }
        Ok(written)
    }
}

impl Drop for Output {
    fn drop(&mut self) {
        for (part, _) in &self.staged {
            let _ = fs::remove_file(part);
        }
        // Only empty folders can be removed so, and only those that this command made.
        for folder in self.made.iter().rev() {
            let _ = fs::remove_dir(folder);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is dropped before the commit leaves nothing behind, not even the folder.
    #[test]
    fn nothing_or_all() {
        let root = std::env::temp_dir().join(format!("erard-output-{}", std::process::id()));
        let folder = root.join("a/b");
        let mut output = Output::prepare(&folder).unwrap();
        output.stage("x.txt", |w| w.write_all(b"x")).unwrap();
        assert!(!folder.join("x.txt").exists());
        drop(output);
        assert!(!root.exists());

        let mut output = Output::prepare(&folder).unwrap();
        output.stage("x.txt", |w| w.write_all(b"x")).unwrap();
        output.commit().unwrap();
        assert_eq!(fs::read(folder.join("x.txt")).unwrap(), b"x");
        let mut output = Output::prepare(&folder).unwrap();
        output.stage("x.txt", |_| Err(std::io::Error::other("disk full"))).unwrap_err();
        drop(output);
        assert_eq!(fs::read(folder.join("x.txt")).unwrap(), b"x", "the old file is still whole");
        fs::remove_dir_all(&root).unwrap();
    }
}
