//! What `erard diagnose` makes of its answers: text, table, page.

mod page;
mod words;

pub(crate) use page::html;
pub(crate) use words::{headlines, table, text, title};

use erard_workshop::diagnose::Diagnosis;

use crate::paper::PageHeader;
use crate::units::Lengths;

/// Answers with what belongs to their page.
#[derive(Debug)]
pub(crate) struct Work<'a> {
    /// The file of the readings; `None` where they were options.
    pub file: Option<&'a str>,
    /// Whether nobody named the key, so that another's usual ranges stand in.
    pub is_key_assumed: bool,
    /// The answers, a key each.
    pub found: &'a [Diagnosis],
    /// What stands at the head of the page.
    pub page_header: &'a PageHeader,
    /// How lengths are shown.
    pub lengths: Lengths,
}
