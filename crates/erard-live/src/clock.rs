//! The sender's clock, which is a claim.

use crate::sensed::APART_S;
use crate::stream::Sample;

/// So many samples of one stamp may wait for the next one: every key and pedal, and some twice.
const MOST: usize = 128;

/// What to do after a sample.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Taken {
    /// Nothing: it waits for its neighbour, or it is dropped.
    Waits,
    /// The sample is next.
    Next,
    /// The clock jumps to the first of these samples, ahead or back.
    Jump(Vec<Sample>),
}

/// Follows a clock. A stamp more than a second from the last one waits until the next comes: where that is near the
/// last one, the stamp was wrong; where it is near the stamp, and later, the clock has jumped. A sender of edges is
/// silent while nothing happens: its stamps ahead are believed.
#[derive(Debug, Clone, Default)]
pub(crate) struct Clock {
    /// Whether the sender is silent while nothing happens.
    is_sparse: bool,
    now_s: Option<f64>,
    /// The last instant before the header came again.
    before_s: Option<f64>,
    has_begun: bool,
    waiting: Vec<Sample>,
    /// Samples that were dropped.
    pub dropped: u64,
}

impl Clock {
    pub(crate) fn new(is_sparse: bool) -> Self {
        Clock { is_sparse, ..Clock::default() }
    }

    pub(crate) fn take(&mut self, sample: &Sample) -> Taken {
        let is_near = |other_s: f64| (sample.time_s - other_s).abs() <= APART_S;
        let Some(now_s) = self.now_s else {
            self.now_s = Some(sample.time_s);
            let is_first = !std::mem::replace(&mut self.has_begun, true);
            // A header in between, and the clock goes on.
            let goes_on = self.before_s.take().is_some_and(|before_s| is_near(before_s) && sample.time_s >= before_s);
            return if is_first || goes_on { Taken::Next } else { Taken::Jump(vec![*sample]) };
        };
        if is_near(now_s) || self.is_sparse && sample.time_s > now_s {
            self.now_s = Some(now_s.max(sample.time_s));
            self.drop_waiting();
            return Taken::Next;
        }
        match self.waiting.first().map(|first| first.time_s) {
            Some(first_s) if is_near(first_s) && sample.time_s > first_s => {
                self.now_s = Some(sample.time_s);
                let mut all = std::mem::take(&mut self.waiting);
                all.push(*sample);
                return Taken::Jump(all);
            }
            Some(first_s) if first_s == sample.time_s && self.waiting.len() < MOST => {}
            _ => self.drop_waiting(),
        }
        self.waiting.push(*sample);
        Taken::Waits
    }

    /// Begins a new clock with the next sample, unless its stamp follows the last one within a second.
    pub(crate) fn restart(&mut self) {
        self.drop_waiting();
        self.before_s = self.now_s.take().or(self.before_s);
    }

    /// Drops the samples that wait for a neighbour.
    pub(crate) fn drop_waiting(&mut self) {
        self.dropped += self.waiting.len() as u64;
        self.waiting.clear();
    }
}
