//! Texts that took long to make, in the user's cache folder. Losing them changes no result; what cannot be read or
//! written there is made anew.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;
use std::time::Duration;

use sha2::{Digest, Sha256};

use crate::identity::hex;

/// Age at which what a killed program left of a text is cleared away.
const STALE: Duration = Duration::from_secs(3600);

/// Digest of the program itself: another program makes other texts.
static PROGRAM: LazyLock<Option<Vec<u8>>> = LazyLock::new(|| {
    let bytes = fs::read(std::env::current_exe().ok()?).ok()?;
    Some(Sha256::digest(&bytes).to_vec())
});

/// The user's cache folder for this program: what the system's rules say.
fn folder() -> Option<PathBuf> {
    let of = |name: &str| std::env::var_os(name).map(PathBuf::from).filter(|path| path.is_absolute());
    let folder = if cfg!(windows) {
        of("LOCALAPPDATA")
    } else if cfg!(target_os = "macos") {
        of("HOME").map(|home| home.join("Library").join("Caches"))
    } else {
        of("XDG_CACHE_HOME").or_else(|| of("HOME").map(|home| home.join(".cache")))
    };
    folder.map(|folder| folder.join("erard"))
}

/// The cache file for a result of these texts.
fn place(kind: &str, of: &[&str]) -> Option<PathBuf> {
    let mut digest = Sha256::new();
    digest.update(PROGRAM.as_ref()?);
    for text in [kind].iter().chain(of) {
        digest.update((text.len() as u64).to_le_bytes());
        digest.update(text.as_bytes());
    }
    let name = hex(&digest.finalize());
    Some(folder()?.join(format!("{kind}-{}", &name[..40])))
}

/// What was kept, if it is whole.
pub(crate) fn get(kind: &str, of: &[&str]) -> Option<String> {
    let kept = fs::read_to_string(place(kind, of)?).ok()?;
    let (sum, text) = kept.split_once('\n')?;
    (sum == checksum(text)).then(|| text.to_owned())
}

fn checksum(text: &str) -> String {
    hex(&Sha256::digest(text))
}

/// Removes the parts of texts that killed programs left. One that is being written is younger.
fn clear(folder: &Path) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        let is_part = entry.path().extension().is_some_and(|extension| extension == "part");
        let written = || entry.metadata().and_then(|data| data.modified()).ok()?.elapsed().ok();
        if is_part && written().is_some_and(|ago| ago > STALE) {
            drop(fs::remove_file(entry.path()));
        }
    }
}

/// Keeps a text. It appears whole or not at all, so that an interrupted program leaves no part of one.
pub(crate) fn put(kind: &str, of: &[&str], text: &str) {
    let Some(place) = place(kind, of) else { return };
    let Some(folder) = place.parent() else { return };
    clear(folder);
    let part = place.with_extension(format!("{}.part", std::process::id()));
    let kept = fs::create_dir_all(folder)
        .and_then(|()| fs::write(&part, checksum(text) + "\n" + text))
        .and_then(|()| fs::rename(&part, &place));
    if kept.is_err() {
        drop(fs::remove_file(part));
    }
}
