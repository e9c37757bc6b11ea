//! What `erard keyboard --weigh` makes of a plan: the work list as text, table, page and figure.

mod figure;
mod page;
mod table;

pub(crate) use figure::weighed_svg;
pub(crate) use page::html;
pub(crate) use table::{report, table, text};

use erard_workshop::balance::{Checked, Lead, LeadWork, Plan};

use crate::paper::Headed;
use crate::units::Lengths;

/// A plan with what belongs to its pages.
#[derive(Debug)]
pub(crate) struct Work<'a> {
    /// What is weighed: the keyboard's name and the table's.
    pub name: &'a str,
    /// The table's name.
    pub file: &'a str,
    /// The plan.
    pub plan: &'a Plan,
    /// The sample that was checked.
    pub checked: &'a [Checked],
    /// What stands at the head of the page.
    pub headed: &'a Headed,
    /// How lengths are shown.
    pub lengths: Lengths,
}

/// Keys whose hammers are off the target by more than this are said, g: what hammers of one set scatter by.
const HAMMER_OFF_G: f64 = 0.3;

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

/// What a move of the capstan is, in words.
fn capstan_text(by_mm: f64, lengths: Lengths) -> String {
    let way = if by_mm < 0.0 { "back" } else { "forward" };
    format!("{} {way}", lengths.text(by_mm.abs(), 1))
}
