//! How long work reports how far it is, and how it is cancelled.

/// Called now and then during long work with the share that is done, 0 to 1, and asked whether to go on: work that it
/// answers with false ends, and reports an interruption. Work that does not know its share says 0.
pub type Progress<'a> = dyn FnMut(f64) -> bool + 'a;

/// Every so many steps the caller is asked whether to go on: well below a tenth of a second.
pub(crate) const ASK_EVERY: u64 = 512;
