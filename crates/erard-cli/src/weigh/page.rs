//! The work list on paper.

use maud::html;

use super::Work;
use super::lists::{nothing_to_do, readings, remarks, sections, stays};
use super::table::checked_lines;
use crate::paper::{page, picture};

const STYLE: &str = include_str!("../paper.css");

/// The page: head, the list operation by operation with boxes to tick, remarks, readings, figure.
pub(crate) fn html(work: &Work<'_>, figure: &str) -> String {
    let page_header = work.page_header;
    let title = format!("{}: work list", work.file);
    let phone = "@media screen and (max-width:40rem){.wide table.list{min-width:34rem}}";
    let style = format!("{STYLE}{phone}@page{{size:{}}}", page_header.paper);
    let sections = sections(work);
    let body = html! {
        header {
            h1 { "Work list: " (work.file) }
            dl {
                div { dt { "serial" } dd { (page_header.serial.as_deref().unwrap_or("")) } }
                div { dt { "date" } dd { (page_header.date.as_deref().unwrap_or("")) } }
                div { dt { "not weighed: as in" } dd { (work.name) } }
            }
        }
        @if let Some(note) = &page_header.note { p.note { (note) } }
        @for remark in remarks(work) { p { (remark) } }
        @if let Some(nothing) = nothing_to_do(work) { p { (nothing) } }
        @for (at, section) in sections.iter().enumerate() {
            h2 { (at + 1) ". " (section.heading) }
            div.wide { table.list { (section.table(work, Some(("done", "☐"))).html()) } }
        }
        @for line in stays(work) { p { (line) } }
        h2 { "As weighed" }
        div.wide { table.list { (readings(work).html()) } }
        p.soft { "! out of its usual range; ? by less than a reading may be off; ^ sticks out from its neighbours" }
        @for line in checked_lines(work) { p.soft { (line) } }
        p.soft {
            "D is the least weight with which the key, let go from rest, sinks slowly to let-off; U is the largest that it lifts again from just before let-off; pedal down. BW = (D + U)/2, F = (D - U)/2. \
             Weights in grams, at the key's front; places of leads count from the balance pin, in front of it where nothing \
             else is said; a capstan moves towards the player. Hammer and capstan are alternatives to the leads: do one of the three. Inertia is an estimate: the hammer's from its \
             strike weight and ratio, the key's and the whippen's from the keyboard's model."
        }
        figure {
            (picture("Strike weight, front weight, balance weight, friction weight, ratio and inertia over the keyboard", figure))
        }
    };
    page(&title, &style, &body)
}
