//! Work that takes long enough to be waited for: a bar on stderr.

use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::{say, signals};

/// Work shorter than this shows no bar.
const PATIENCE: Duration = Duration::from_millis(400);

/// The bar that is shown, for the handler that ends the process.
static SHOWN: Mutex<Option<ProgressBar>> = Mutex::new(None);

/// Takes the bar away.
pub(crate) fn clear() {
    if let Some(bar) = SHOWN.lock().unwrap_or_else(PoisonError::into_inner).take() {
        bar.finish_and_clear();
    }
}

/// A bar that appears only when the work turns out to be long, and only on a terminal.
#[derive(Debug)]
pub struct Progress {
    start: Instant,
    bar: ProgressBar,
}

impl Progress {
    /// A bar named after what is going on.
    pub fn new(what: &str) -> Self {
        let bar = ProgressBar::with_draw_target(Some(1000), ProgressDrawTarget::hidden());
        let style = ProgressStyle::with_template("{msg} [{bar:40}] {percent:>3} % {eta} left");
        bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
        bar.set_message(what.to_owned());
        Progress { start: Instant::now(), bar }
    }

    /// A bar for work of unknown length: it counts what was done.
    pub(crate) fn counting(what: &str) -> Self {
        let progress = Progress::new(what);
        let style = ProgressStyle::with_template("{msg}, {elapsed}");
        progress.bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
        progress
    }

    /// Shows how far it is, in words; false if the work should end.
    pub(crate) fn counted(&mut self, words: impl FnOnce() -> String) -> bool {
        if !self.bar.is_hidden() {
            self.bar.set_message(words());
        }
        self.tell(0.0)
    }

    /// Says what is going on now.
    pub fn say(&mut self, what: &str) {
        if self.bar.message() != what {
            self.bar.set_message(what.to_owned());
        }
    }

    /// Shows the share that is done; false if the work should end.
    pub fn tell(&mut self, share: f64) -> bool {
        if self.bar.is_hidden() && self.start.elapsed() > PATIENCE && !signals::ending() && !say::is_quiet() {
            self.bar.set_draw_target(ProgressDrawTarget::stderr());
            *SHOWN.lock().unwrap_or_else(PoisonError::into_inner) = Some(self.bar.clone());
        }
        self.bar.set_position((share * 1000.0) as u64);
        !signals::ending()
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        clear();
        self.bar.finish_and_clear();
    }
}
