//! The folders that a session has begun to write: what [`crate::output`] stages results in, for the thread that ends
//! the process.

use std::fs;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Name of the file that is locked while the process of a stage lives.
pub(crate) const LOCK: &str = "lock";

/// Stages of a session, and the folders made for them: for the thread that ends the process. Held while one is made, so
/// that whoever clears up knows of all that stand; and from then on for ever, so that no other is made.
#[derive(Debug, Clone, Default)]
pub(crate) struct Stages(Arc<Mutex<Vec<PathBuf>>>);

impl Stages {
    /// Clears what the session has begun to write. For its end: whoever still writes then finds that there is no
    /// folder.
    pub(crate) fn clear(&self) {
        let mut open = self.open();
        let folders = std::mem::take(&mut *open);
        // Never given back.
        std::mem::forget(open);
        let (stages, made): (Vec<_>, Vec<_>) = folders.into_iter().partition(|folder| folder.join(LOCK).exists());
        for stage in stages {
            // A file that is created meanwhile is in the way once or twice.
            for _ in 0..20 {
                if fs::remove_dir_all(&stage).is_ok() || !stage.exists() {
                    break;
                }
                std::thread::sleep(std::time::Duration::from_millis(2));
            }
        }
        remove_empty(&made);
    }

    /// The folders, to be changed by nobody else meanwhile.
    pub(crate) fn open(&self) -> MutexGuard<'_, Vec<PathBuf>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Only empty folders can be removed so.
pub(crate) fn remove_empty(made: &[PathBuf]) {
    for folder in made.iter().rev() {
        let _ = fs::remove_dir(folder);
    }
}
