//! Work that takes long enough to be waited for: a bar on stderr.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::signals::Stop;

/// Work shorter than this shows no bar.
const PATIENCE: Duration = Duration::from_millis(400);

/// The bar that is shown, for the thread that ends the process.
#[derive(Debug, Clone, Default)]
pub(crate) struct Shown(Arc<Mutex<Option<ProgressBar>>>);

impl Shown {
    /// Takes the bar away.
    pub(crate) fn clear(&self) {
        if let Some(bar) = self.0.lock().unwrap_or_else(PoisonError::into_inner).take() {
            bar.finish_and_clear();
        }
    }

    fn set(&self, bar: &ProgressBar) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = Some(bar.clone());
    }
}

/// A bar that appears only when the work turns out to be long, and only on a terminal.
#[derive(Debug)]
pub struct Progress {
    start: Instant,
    bar: ProgressBar,
    stop: Stop,
    shown: Shown,
    is_quiet: bool,
}

impl Progress {
    /// A bar named after what is going on.
    pub(crate) fn new(what: &str, stop: &Stop, shown: &Shown, is_quiet: bool) -> Self {
        let bar = ProgressBar::with_draw_target(Some(1000), ProgressDrawTarget::hidden());
        let style = ProgressStyle::with_template("{msg} [{bar:40}] {percent:>3} % {eta} left");
        bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
        bar.set_message(what.to_owned());
        Progress { start: Instant::now(), bar, stop: stop.clone(), shown: shown.clone(), is_quiet }
    }

    /// The same for work of unknown length: it counts what was done.
    pub(crate) fn counting(self) -> Self {
        let style = ProgressStyle::with_template("{msg}, {elapsed}");
        self.bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
        self
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
        if self.bar.is_hidden() && self.start.elapsed() > PATIENCE && !self.stop.is_set() && !self.is_quiet {
            self.bar.set_draw_target(ProgressDrawTarget::stderr());
            self.shown.set(&self.bar);
        }
        self.bar.set_position((share * 1000.0) as u64);
        !self.stop.is_set()
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.shown.clear();
        self.bar.finish_and_clear();
    }
}
