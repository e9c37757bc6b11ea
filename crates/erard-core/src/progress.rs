//! Progress reports and cancellation of long work.

/// Called regularly during long work with the share that is done, 0 to 1. If it returns false, the work ends and
/// reports an interruption. Work that does not know its share passes 0.
pub type Progress<'a> = dyn FnMut(f64) -> bool + 'a;

/// Number of steps between calls: well below a tenth of a second.
pub(crate) const ASK_EVERY: u64 = 512;
