//! An observer of the number and the length of the steps of impacts on strings.

use crate::instrument::Instrument;
use crate::mechanism::Readout;

/// Time without contact after which a hammer has left the strings, s: waves separate the two for shorter times.
const APART_S: f64 = 2e-3;

/// Steps of the loudest impact on modal strings; it observes every step.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Struck {
    /// The contact under way.
    now: Option<Contact>,
    /// The one with the largest force so far.
    loudest: Option<Contact>,
    sounds: bool,
}

/// A hammer on its strings.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Contact {
    /// Largest force, N.
    pub peak_n: f64,
    /// Steps that pressed.
    pub steps: u32,
    /// The longest of them, s.
    pub longest_s: f64,
    /// Beginning of the contact, s.
    pub since_s: f64,
    /// End of its last step with a force, s.
    last_s: f64,
}

impl Struck {
    /// Nothing has been struck yet.
    pub(crate) fn new(instrument: &Instrument) -> Self {
        Struck { sounds: instrument.has_yielding_strings(), ..Struck::default() }
    }

    /// After a step that ended at `time_s`.
    pub(crate) fn observe(&mut self, time_s: f64, now: &Readout<'_>) {
        if !self.sounds {
            return;
        }
        let force_n = now.output.zone_n;
        if force_n > 0.0 {
            let contact = self.now.get_or_insert(Contact { since_s: time_s, ..Contact::default() });
            contact.steps += 1;
            contact.peak_n = contact.peak_n.max(force_n);
            contact.longest_s = contact.longest_s.max(now.last_step_s);
            contact.last_s = time_s;
        } else if self.now.is_some_and(|contact| time_s > contact.last_s + APART_S) {
            self.loudest = self.loudest();
            self.now = None;
        }
    }

    /// The contact with the largest force.
    pub(super) fn loudest(&self) -> Option<Contact> {
        let both = [self.loudest, self.now].into_iter().flatten();
        both.max_by(|a, b| a.peak_n.total_cmp(&b.peak_n))
    }
}
