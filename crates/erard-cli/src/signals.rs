//! Requests to end: Control-C, a terminal that goes away, a polite kill, a limit of time.
//!
//! They are heard by a thread of their own, so that nothing that computes, reads or writes need ask. Files appear all
//! at once or not at all (`crate::output`), so that it can end the process at any instant but that one: it waits for
//! it, clears away what was begun, and ends the process as the signal would have.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use crate::printer::aside;

/// Exit code after Control-C.
pub(crate) const INTERRUPTED: u8 = 130;

/// What the work and the thread that ends the process know of each other.
#[derive(Debug, Clone, Default)]
pub(crate) struct Stop(Arc<Shared>);

#[derive(Debug, Default)]
struct Shared {
    /// Held while files change their names, and by whoever ends the process.
    undisturbed: Mutex<()>,
    is_set: AtomicBool,
}

impl Stop {
    /// Nobody ends the process while this is held, but with SIGKILL.
    pub(crate) fn hold(&self) -> MutexGuard<'_, ()> {
        self.0.undisturbed.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Whether the process is about to end.
    #[must_use]
    pub(crate) fn is_set(&self) -> bool {
        self.0.is_set.load(Ordering::Relaxed)
    }

    /// Leaves the last word to who ends the process, where somebody does: what fails now fails because of it.
    pub(crate) fn yield_to_the_end(&self) {
        while self.is_set() {
            std::thread::park();
        }
    }
}

/// From now on requests to end are heard; `clear` clears up before the process ends.
pub(crate) fn listen(stop: Stop, clear: impl FnOnce() + Send + 'static) {
    // Where nothing can be set up, they end the process as they do by default, and the next command clears up.
    let _ = listening::start(stop, Box::new(clear));
}

/// What clears up.
type Clear = Box<dyn FnOnce() + Send>;

/// Clears up and says why.
fn clean_up(stop: &Stop, clear: Clear, why: &str) {
    stop.0.is_set.store(true, Ordering::Relaxed);
    // Never given back.
    std::mem::forget(stop.hold());
    clear();
    aside(format!("error: {why}"));
}

#[cfg(unix)]
mod listening {
    use std::sync::Arc;
    use std::sync::atomic::AtomicBool;
    use std::time::Duration;

    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM, SIGXCPU, SIGXFSZ};
    use signal_hook::iterator::Signals;
    use signal_hook::low_level::emulate_default_handler;

    use super::{Clear, INTERRUPTED, Stop, clean_up};

    /// How long an exchange of files may take before a second request ends the process all the same.
    const PATIENCE: Duration = Duration::from_secs(5);

    pub(crate) fn start(stop: Stop, clear: Clear) -> std::io::Result<()> {
        // A write beyond the limit of a file's size is an error like any other, and not the end.
        signal_hook::flag::register(SIGXFSZ, Arc::new(AtomicBool::new(false)))?;
        let ignored = ignored();
        // What was ignored from the start stays so: `nohup` does that, and shells to what runs in the background.
        let heard = [SIGINT, SIGTERM, SIGHUP, SIGXCPU].into_iter().filter(|signal| !ignored.contains(signal));
        let mut signals = Signals::new(heard)?;
        std::thread::Builder::new().name("signals".into()).spawn(move || {
            let Some(signal) = signals.forever().next() else { return };
            std::thread::spawn(move || {
                std::thread::sleep(PATIENCE);
                end(signal);
            });
            let why = match signal {
                SIGINT => "interrupted",
                SIGTERM => "ended by request (SIGTERM)",
                SIGHUP => "the terminal has gone (SIGHUP)",
                _ => "the limit of processor time is reached (SIGXCPU)",
            };
            clean_up(&stop, clear, why);
            end(signal);
        })?;
        Ok(())
    }

    /// Ends the process as the signal would have. After Control-C a shell ends its loop only if its command was ended
    /// by the signal, and then shows 130; all others read that from the exit code.
    fn end(signal: i32) -> ! {
        if signal != SIGINT || a_shell_waits() {
            // Does not return.
            let _ = emulate_default_handler(signal);
        }
        std::process::exit(i32::from(INTERRUPTED))
    }

    fn a_shell_waits() -> bool {
        const SHELLS: [&str; 10] = ["sh", "bash", "dash", "zsh", "ksh", "mksh", "ash", "busybox", "fish", "tcsh"];
        let parent = std::os::unix::process::parent_id();
        match std::fs::read_to_string(format!("/proc/{parent}/comm")) {
            Ok(name) => SHELLS.contains(&name.trim()),
            // Where nobody can tell: at a terminal there is one as a rule.
            Err(_) => std::io::IsTerminal::is_terminal(&std::io::stderr()),
        }
    }

    /// Signals that this process was told to ignore by who started it. Where that cannot be known, SIGHUP is taken for
    /// one.
    fn ignored() -> Vec<i32> {
        let Ok(status) = std::fs::read_to_string("/proc/self/status") else { return vec![SIGHUP] };
        let mask = status.lines().find_map(|line| u64::from_str_radix(line.strip_prefix("SigIgn:")?.trim(), 16).ok());
        let mask = mask.unwrap_or(0);
        [SIGINT, SIGTERM, SIGHUP, SIGXCPU].into_iter().filter(|signal| mask >> (signal - 1) & 1 == 1).collect()
    }
}

#[cfg(not(unix))]
mod listening {
    use super::{Clear, INTERRUPTED, Stop, clean_up};

    pub(crate) fn start(stop: Stop, clear: Clear) -> Result<(), ctrlc::Error> {
        let mut clear = Some(clear);
        ctrlc::set_handler(move || {
            clean_up(&stop, clear.take().unwrap_or_else(|| Box::new(|| ())), "interrupted");
            std::process::exit(i32::from(INTERRUPTED));
        })
    }
}
