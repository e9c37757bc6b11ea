//! Books what a running action's energy does.

use moreau::Ledger;

use crate::mechanism::{Mechanism, open_ledger, take_stock};

/// An observer that keeps the energy ledger of an action: opened where it is, updated after every step, closed at the
/// end.
#[derive(Debug, Clone)]
pub struct LedgerBook {
    ledger: Ledger,
    rested: bool,
}

impl LedgerBook {
    /// Opens the ledger here.
    pub fn open(mechanism: &mut dyn Mechanism) -> Self {
        LedgerBook { ledger: open_ledger(mechanism), rested: false }
    }

    /// After every step.
    pub fn observe(&mut self, mechanism: &dyn Mechanism) {
        self.observe_at_rest(mechanism.readout().rests, mechanism);
    }

    /// The same for a caller that knows whether the step changed nothing.
    pub(crate) fn observe_at_rest(&mut self, rests: bool, mechanism: &dyn Mechanism) {
        // A step that was left out has nothing to book, nor has one that changed nothing after another.
        if !(self.rested && rests) {
            mechanism.book(&mut self.ledger);
        }
        self.rested = rests;
    }

    /// The ledger up to here.
    pub fn close(mut self, mechanism: &dyn Mechanism) -> Ledger {
        take_stock(mechanism, &mut self.ledger);
        self.ledger
    }
}
