//! The outputs of `erard play`: tables, a page, sound.

pub(crate) mod page;
pub(crate) mod report;
pub(crate) mod spool;

use erard_piece::{Performance, Score};

/// A score played on a keyboard.
pub(crate) struct Side {
    /// The keyboard's name.
    pub name: String,
    pub performance: Performance,
    /// How long it took by the clock, s.
    pub elapsed_s: f64,
    /// Notes that have a page of their own, by their number from 0, and its name.
    pub pages: Vec<(usize, String)>,
    /// The file of its sound, if there is one, and what is said of samples that its gain has limited.
    pub heard: Option<(String, Option<String>)>,
}

/// A piece and who played it.
pub(crate) struct Played<'a> {
    /// The file's name.
    pub piece: &'a str,
    pub score: &'a Score<'a>,
    pub threads: usize,
    /// One keyboard, or two.
    pub sides: Vec<Side>,
}

impl Side {
    /// What stands before the ending of this side's files: nothing for one keyboard, `-1` and `-2` for two.
    pub(crate) fn mark(index: usize, count: usize) -> String {
        if count > 1 { format!("-{}", index + 1) } else { String::new() }
    }
}
