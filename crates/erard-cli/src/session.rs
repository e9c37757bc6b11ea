//! What a command works in. A program makes one session, and hands it to its command; whatever the work reads, prints
//! or writes goes through it.

use crate::identity::Provenance;
use crate::inputs::Inputs;
use crate::live::Sounding;
use crate::printer::{OutputMode, Printer};
use crate::progress::{Progress, Shown};
use crate::signals::Stop;
use crate::stages::Stages;

/// One run of a command: its inputs, where its results come from, where its words go, and what is cleared away when it
/// is ended from outside.
pub struct Session {
    /// Standard output and standard error.
    pub printer: Printer,
    /// The command, and what its results are made from.
    pub provenance: Provenance,
    /// Files that were opened for reading.
    pub inputs: Inputs,
    pub(crate) stop: Stop,
    pub(crate) stages: Stages,
    pub(crate) sounding: Sounding,
    bar: Shown,
}

impl Session {
    /// A session on the standard streams of this process.
    pub fn new(mode: OutputMode) -> Self {
        Session::with(Printer::standard(mode))
    }

    /// A session that prints nothing on standard output.
    #[cfg(test)]
    pub(crate) fn silent() -> Self {
        Session::with(Printer::silent())
    }

    fn with(printer: Printer) -> Self {
        Session {
            printer,
            provenance: Provenance::default(),
            inputs: Inputs::default(),
            stop: Stop::default(),
            stages: Stages::default(),
            sounding: Sounding::default(),
            bar: Shown::default(),
        }
    }

    /// A bar named after what is going on.
    pub fn progress(&self, what: &str) -> Progress {
        Progress::new(what, &self.stop, &self.bar, self.printer.is_quiet())
    }

    /// A bar for work of unknown length: it counts what was done.
    pub(crate) fn counting_progress(&self, what: &str) -> Progress {
        self.progress(what).counting()
    }

    /// Clears away what this session has begun, from another thread.
    pub(crate) fn cleaner(&self) -> impl FnOnce() + Send + use<> {
        let (bar, sounding, stages) = (self.bar.clone(), self.sounding.clone(), self.stages.clone());
        move || {
            bar.clear();
            sounding.silence();
            stages.clear();
        }
    }
}
