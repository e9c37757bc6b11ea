//! Energy losses of every pin and every contact.
//!
//! The engine's ledger sums these losses over all pins and all contacts ([`moreau::Ledger`]); this module keeps them
//! separately.

use super::Observer;
use crate::instrument::{Instrument, InstrumentFields};
use crate::mechanism::Mechanism;
use crate::strings::{StringLosses, Strings};
use moreau::LossIn;

/// Losses of one pin so far, J.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct PinLoss {
    /// By dry friction.
    pub dry_j: f64,
    /// By viscous friction.
    pub viscous_j: f64,
}

/// Losses of one contact so far, J.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ContactLoss {
    /// In the felt.
    pub felt_j: f64,
    /// By sliding.
    pub sliding_j: f64,
}

/// Losses of a pin, a contact or the strings, with its name.
#[derive(Debug, Clone, PartialEq)]
pub struct Loss {
    /// The body of a pin, or the zone; for modal strings `strings`, `bridge` or `rocking`.
    pub name: String,
    /// `pin`, `contact` or, for modal strings, `strings`.
    pub kind: &'static str,
    /// For people.
    pub label: String,
    /// Pins: dry friction. Contacts: sliding friction. J.
    pub dry_j: f64,
    /// Pins: viscous friction. Contacts: felt. Strings, bridge and rocked felts: all losses. J.
    pub viscous_or_felt_j: f64,
    /// Its place among the instrument's pins and contacts.
    pub place: usize,
}

impl Loss {
    /// Sum of both, J.
    #[must_use]
    pub fn all_j(&self) -> f64 {
        self.dry_j + self.viscous_or_felt_j
    }
}

/// An observer that sums losses. It needs the start of an action and then every step, of any length (with adaptive
/// steps both halves of each).
#[derive(Debug, Clone)]
pub struct Losses {
    instrument: Instrument,
    pins: Vec<PinLoss>,
    contacts: Vec<ContactLoss>,
    /// Losses of modal strings up to the start of the energy balance, and since, J.
    strings_before: StringLosses,
    strings: StringLosses,
    /// See [`Strings::bears`].
    bears: [bool; 2],
}

/// Losses of modal strings since they were made.
fn lost_in_strings(mechanism: &dyn Mechanism) -> StringLosses {
    Strings::under(mechanism).map_or(StringLosses::default(), Strings::losses)
}

impl Losses {
    /// Starts the energy balance where an action stands. Its mechanism must keep its contacts
    /// ([`moreau_kernels::Stepping::keeps_contacts`]), as that of a run does.
    #[must_use]
    pub fn open(instrument: &Instrument, mechanism: &dyn Mechanism) -> Self {
        Losses {
            instrument: instrument.clone().without_outlines(),
            pins: vec![PinLoss::default(); instrument.bodies.len()],
            contacts: vec![ContactLoss::default(); instrument.zones.len()],
            strings_before: lost_in_strings(mechanism),
            strings: StringLosses::default(),
            bears: Strings::under(mechanism).map_or([false; 2], Strings::bears),
        }
    }

    /// After every step. Does not allocate.
    pub fn observe(&mut self, m: &dyn Mechanism) {
        self.strings = lost_in_strings(m) - self.strings_before;
        let Losses { pins, contacts, .. } = self;
        m.each_loss(&mut |loss_in, loss_j| {
            let account = match loss_in {
                LossIn::DryPivot(body) => pins.get_mut(body).map(|pin| &mut pin.dry_j),
                LossIn::ViscousPivot(body) => pins.get_mut(body).map(|pin| &mut pin.viscous_j),
                LossIn::Felt(zone) => contacts.get_mut(zone).map(|contact| &mut contact.felt_j),
                LossIn::Sliding(zone) => contacts.get_mut(zone).map(|contact| &mut contact.sliding_j),
            };
            // The engine has more places than the instrument has pins.
            if let Some(account) = account {
                *account += loss_j;
            }
        });
    }

    /// Losses of each body's pin so far.
    #[must_use]
    pub fn pins(&self) -> &[PinLoss] {
        &self.pins
    }

    /// Losses of each contact so far.
    #[must_use]
    pub fn contacts(&self) -> &[ContactLoss] {
        &self.contacts
    }

    /// Losses of modal strings so far: in the strings, in a moving bridge, and in rocked damper felts; zero with rigid
    /// strings.
    #[must_use]
    pub fn strings(&self) -> StringLosses {
        self.strings
    }

    /// Losses of modal strings so far, total, J.
    #[must_use]
    pub fn strings_j(&self) -> f64 {
        self.strings.all_j()
    }

    /// Pins, contacts and modal strings, the largest loss first.
    #[must_use]
    pub fn by_size(&self) -> Vec<Loss> {
        let InstrumentFields { bodies, zones, .. } = &*self.instrument;
        let pins = bodies.iter().zip(&self.pins).map(|(body, loss)| Loss {
            name: body.name.clone(),
            kind: "pin",
            label: format!("{} of the {}", if body.is_bend { "bending" } else { "pin" }, body.name),
            dry_j: loss.dry_j,
            viscous_or_felt_j: loss.viscous_j,
            place: 0,
        });
        let contacts = zones.iter().zip(&self.contacts).map(|(zone, loss)| Loss {
            name: zone.name.clone(),
            kind: "contact",
            label: zone.label.clone(),
            dry_j: loss.sliding_j,
            viscous_or_felt_j: loss.felt_j,
            place: 0,
        });
        let [on_bridge, damped] = self.bears;
        let yielding = [
            ("strings", "strings", self.strings.strings_j, self.instrument.has_yielding_strings()),
            ("bridge", "bridge", self.strings.bridge_j, on_bridge),
            ("rocking", "dampers' felts, rocked", self.strings.rocking_j, damped),
        ];
        let yielding = yielding.into_iter().map(|(name, label, lost_j, is_there)| {
            is_there.then(|| Loss {
                name: name.to_owned(),
                kind: "strings",
                label: label.to_owned(),
                dry_j: 0.0,
                viscous_or_felt_j: lost_j,
                place: 0,
            })
        });
        let all = pins.chain(contacts).map(Some).chain(yielding).enumerate();
        let mut all: Vec<Loss> = all.filter_map(|(place, loss)| loss.map(|loss| Loss { place, ..loss })).collect();
        all.sort_by(|a, b| b.all_j().total_cmp(&a.all_j()));
        all
    }
}

/// Writes losses down while a run goes on.
#[derive(Debug, Clone)]
pub struct LossRecorder {
    instrument: Instrument,
    losses: Option<Losses>,
    /// Losses of each pin, then each contact, and then strings, bridge and rocked felts up to every row, J.
    rows: Vec<Vec<f64>>,
}

/// Strings, bridge, rocked felts.
const YIELDING: usize = 3;

impl LossRecorder {
    /// A recorder for the pins and contacts of an instrument.
    #[must_use]
    pub fn new(instrument: &Instrument) -> Self {
        LossRecorder {
            instrument: instrument.clone().without_outlines(),
            losses: None,
            rows: vec![Vec::new(); instrument.bodies.len() + instrument.zones.len() + YIELDING],
        }
    }

    /// Total losses; `None` before the run.
    #[must_use]
    pub fn losses(&self) -> Option<&Losses> {
        self.losses.as_ref()
    }

    /// Losses of each body's pin up to every row, J.
    #[must_use]
    pub fn pin_rows(&self) -> &[Vec<f64>] {
        &self.rows[..self.instrument.bodies.len()]
    }

    /// Losses of each contact up to every row, J.
    #[must_use]
    pub fn contact_rows(&self) -> &[Vec<f64>] {
        let first = self.instrument.bodies.len();
        &self.rows[first..first + self.instrument.zones.len()]
    }

    /// Losses up to every row: of modal strings, of the bridge, of rocked felts, J.
    #[must_use]
    pub fn string_rows(&self) -> &[Vec<f64>] {
        &self.rows[self.rows.len() - YIELDING..]
    }

    fn row(&mut self) {
        let Some(losses) = &self.losses else { return };
        let pins = losses.pins.iter().map(|pin| pin.dry_j + pin.viscous_j);
        let contacts = losses.contacts.iter().map(|contact| contact.felt_j + contact.sliding_j);
        let all = pins.chain(contacts).chain(losses.strings.kinds_j());
        self.rows.iter_mut().zip(all).for_each(|(row, lost)| row.push(lost));
    }
}

impl Observer for LossRecorder {
    fn begin(&mut self, _: f64, mechanism: &dyn Mechanism) {
        self.losses = Some(Losses::open(&self.instrument, mechanism));
        self.row();
    }

    fn step(&mut self, _: f64, row: bool, mechanism: &dyn Mechanism) {
        if let Some(losses) = &mut self.losses {
            losses.observe(mechanism);
        }
        if row {
            self.row();
        }
    }
}
