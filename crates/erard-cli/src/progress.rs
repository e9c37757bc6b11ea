//! Work that takes long enough to be waited for: a bar on stderr, and an end on request.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Work shorter than this shows no bar.
const PATIENCE: Duration = Duration::from_millis(400);

/// Whether the user has asked for an end (control-C).
static INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// From now on the first control-C lets the work end by itself and clean up; a second one ends the process at once.
pub fn listen_for_interrupts() {
    // Where no handler can be set, control-C ends the process, as it does by default.
    let _ = ctrlc::set_handler(|| {
        if INTERRUPTED.swap(true, Ordering::Relaxed) {
            std::process::exit(130);
        }
    });
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

    /// Says what is going on now.
    pub fn say(&mut self, what: &str) {
        if self.bar.message() != what {
            self.bar.set_message(what.to_owned());
        }
    }

    /// Shows the share that is done; false if the work should end.
    pub fn tell(&mut self, share: f64) -> bool {
        if self.bar.is_hidden() && self.start.elapsed() > PATIENCE {
            self.bar.set_draw_target(ProgressDrawTarget::stderr());
        }
        self.bar.set_position((share * 1000.0) as u64);
        !INTERRUPTED.load(Ordering::Relaxed)
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
