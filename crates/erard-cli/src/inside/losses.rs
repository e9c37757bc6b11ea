//! Losses as a table and as JSON.

use erard::instrument::Instrument;
use erard::player::Losses;
use serde::Serialize;

use crate::table::Table;

/// Where the energy went, largest loss first.
#[derive(Debug, Serialize)]
#[allow(non_snake_case)]
pub(crate) struct LossReport {
    instrument: String,
    /// Sum of all, J.
    pub total_J: f64,
    /// Pins, contacts and modal strings.
    pub losses: Vec<Loss>,
}

/// One pin or contact, or what yields under the contacts: the strings, their bridge, dampers' felts where they are
/// rocked.
#[derive(Debug, Serialize)]
#[allow(non_snake_case)]
pub(crate) struct Loss {
    /// The body of a pin, or the zone; of what yields `strings`, `bridge` or `rocking`.
    pub name: String,
    /// `pin`, `contact` or, of all that yields under the contacts, `strings`.
    pub kind: &'static str,
    /// For people.
    pub label: String,
    /// Of a pin: by dry friction; of a contact: by sliding, J.
    pub dry_J: f64,
    /// Of a pin: by viscous friction; of a contact: in the felt; of strings, bridge and rocked felts: all, J.
    pub viscous_or_felt_J: f64,
    /// Both, J.
    pub loss_J: f64,
    /// Of all losses.
    pub share: f64,
    /// Its place among the instrument's pins, contacts and strings.
    #[serde(skip)]
    pub place: usize,
}

impl LossReport {
    /// Of a run.
    pub(crate) fn new(instrument: &Instrument, losses: &Losses) -> Self {
        let all = losses.by_size();
        let total: f64 = all.iter().map(erard::player::Loss::all_j).sum();
        let of = |loss: erard::player::Loss| Loss {
            dry_J: loss.dry_j,
            viscous_or_felt_J: loss.viscous_or_felt_j,
            loss_J: loss.all_j(),
            share: if total > 0.0 { loss.all_j() / total } else { 0.0 },
            name: loss.name,
            kind: loss.kind,
            label: loss.label,
            place: loss.place,
        };
        LossReport { instrument: instrument.name.clone(), total_J: total, losses: all.into_iter().map(of).collect() }
    }

    /// For people: what loses anything, and all of it.
    pub(crate) fn table(&self) -> Table<'static> {
        let heads = ["where the energy goes", "friction mJ", "felt, oil mJ", "all mJ", "share"];
        let row = |label: &str, joules: [f64; 3], share: f64| {
            let [dry, felt, all] = joules.map(|j| format!("{:.3}", j * 1e3));
            [label.to_owned(), dry, felt, all, format!("{:.1} %", share * 100.0)]
        };
        let each = self.losses.iter().filter(|loss| loss.loss_J > 0.0);
        let each = each.map(|l| row(&l.label, [l.dry_J, l.viscous_or_felt_J, l.loss_J], l.share));
        let of = |part: fn(&Loss) -> f64| self.losses.iter().map(part).sum::<f64>();
        let all = row("all", [of(|l| l.dry_J), of(|l| l.viscous_or_felt_J), self.total_J], 1.0);
        Table::of(heads, each.chain([all]))
    }
}
