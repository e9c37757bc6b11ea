//! What `erard keyboard --measured` makes of a keyboard that was weighed: the readings, the work list by operation, as
//! text, table, page and figure.

mod figure;
mod lists;
mod page;
mod table;
mod text;

pub(crate) use figure::weighed_picture;
pub(crate) use page::html;
pub(crate) use table::{again, report, table};
pub(crate) use text::{again_text, text};

use erard_workshop::balance::{Checked, Lead, LeadWork, MeasuredKey, Remedy};
use erard_workshop::digits::signed;
use erard_workshop::worklist::KeyboardList;

use crate::paper::PageHeader;
use crate::units::Lengths;

/// A list with what belongs to its pages.
#[derive(Debug)]
pub(crate) struct Work<'a> {
    /// The keyboard whose model stands in where nothing was weighed.
    pub name: &'a str,
    /// The table's name.
    pub file: &'a str,
    /// What to do.
    pub list: &'a KeyboardList,
    /// The sample that was checked.
    pub checked: &'a [Checked],
    /// The keys weighed again on copies on which the list was carried out, where that was asked for.
    pub again: Option<&'a [MeasuredKey]>,
    /// What stands at the head of the page.
    pub page_header: &'a PageHeader,
    /// How lengths are shown.
    pub lengths: Lengths,
}

/// A usual lead, g: for examples of front weight.
const LEAD_G: f64 = 14.0;

/// Farthest place of a usual lead, as a share of the way from the balance pin to the key's front.
const FARTHEST_LEAD: f64 = 0.75;

/// Front weight where nobody said which leads are there, in words. `front_mm` is from the balance pin to the key's
/// front.
pub(crate) fn front_weight_text(by_g: f64, front_mm: f64, lengths: Lengths) -> String {
    if by_g > 0.0 {
        return format!("put {by_g:.1} g of front weight in");
    }
    // As few usual leads as are that much where leads stand.
    let leads = (-by_g / (LEAD_G * FARTHEST_LEAD)).ceil().max(1.0);
    let place = lengths.text(10.0 * (-by_g * front_mm / (leads * LEAD_G) / 10.0).round(), 0);
    let as_much = match leads {
        1.0 => format!("a {LEAD_G:.0} g lead at {place} from the pin is as much"),
        leads => format!("{leads:.0} leads of {LEAD_G:.0} g at {place} from the pin are as much"),
    };
    format!("take {:.1} g of front weight out: move leads toward the pin or take some out ({as_much})", -by_g)
}

/// Weight of a hammer, in words.
pub(crate) fn hammer_text(by_g: f64) -> String {
    if by_g < 0.0 { format!("take {:.1} g off", -by_g) } else { format!("add {by_g:.1} g") }
}

/// What is done to a key's leads, in words.
pub(crate) fn leads_text(work: &LeadWork, lengths: Lengths) -> String {
    if work.put.is_empty() && work.out.is_empty() {
        return "leave".to_owned();
    }
    let place = |lead: &Lead| {
        let side = if lead.at_mm < 0.0 { " behind the pin" } else { "" };
        format!("{}{side}", lengths.text(lead.at_mm.abs(), 0))
    };
    let list = |leads: &[Lead]| {
        let each = leads.iter().map(|lead| format!("{} g at {}", lead.mass_g, place(lead)));
        each.collect::<Vec<_>>().join(" + ")
    };
    let (moves, out, new) = work.moved();
    let moves = moves.iter().map(|[from, to]| format!("move {} g from {} to {}", from.mass_g, place(from), place(to)));
    let mut words: Vec<String> = moves.collect();
    if !out.is_empty() {
        words.push(format!("out {}", list(&out)));
    }
    if !new.is_empty() {
        words.push(format!("in {}", list(&new)));
    }
    words.join("; ")
}

/// A remedy, in words.
fn remedy_text(remedy: &Remedy, lengths: Lengths) -> String {
    match remedy {
        Remedy::Leads(leads) => format!("leads {}", leads_text(leads, lengths)),
        Remedy::Strike(by_g) => format!("strike weight {} g", signed(*by_g, 1)),
        Remedy::Capstan(by_mm) => format!("capstan {}", capstan_text(*by_mm, lengths)),
        Remedy::Assist(by_g) => format!("springs or magnets {} g", signed(*by_g, 1)),
    }
}

/// What a move of the capstan is, in words.
fn capstan_text(by_mm: f64, lengths: Lengths) -> String {
    let way = if by_mm < 0.0 { "back" } else { "forward" };
    format!("{} {way}", lengths.text(by_mm.abs(), 1))
}
