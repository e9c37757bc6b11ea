//! Books what a running action's energy does.

use moreau::Ledger;

use crate::mechanism::Mechanism;

/// An observer that keeps the energy ledger of an action: opened where it is, told of every step, closed at the end.
#[derive(Debug, Clone)]
pub struct LedgerBook {
    ledger: Ledger,
    rested: bool,
}

impl LedgerBook {
    /// Opens the books here.
    pub fn open(mechanism: &mut dyn Mechanism) -> Self {
        LedgerBook { ledger: mechanism.open_ledger(), rested: false }
    }

    /// After every step.
    pub fn look(&mut self, mechanism: &dyn Mechanism) {
        let rests = mechanism.rests();
        // A step that was left out has nothing to book, nor has one that changed nothing after another.
        if !(self.rested && rests) {
            mechanism.book(&mut self.ledger);
        }
        self.rested = rests;
    }

    /// The books up to here.
    pub fn close(mut self, mechanism: &dyn Mechanism) -> Ledger {
        mechanism.take_stock(&mut self.ledger);
        self.ledger
    }
}
