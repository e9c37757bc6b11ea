//! The printed page: the person's numbers, the causes with their tests, what to measure next.

use maud::{Markup, html};

use super::Work;
use super::words::{
    assumed_key, explains, geometry, key, mark, percent, rows, uneven, usual, value, weigh_again, would_read,
};
use crate::paper::page;
use crate::table::Table;
use erard_workshop::diagnose::{BASIS, Diagnosis, Standing, common};
use erard_workshop::worklist::SECTION_ENDS;

const STYLE: &str = include_str!("../paper.css");

/// The page: of many keys a list first, then those with work, one after the other.
pub(crate) fn html(work: &Work<'_>) -> String {
    let page_header = work.page_header;
    let what = match work.found {
        [one] => key(one),
        found => format!("{} keys", found.len()),
    };
    let style = format!("{STYLE}@page{{size:{}}}section+section{{break-before:auto}}", page_header.paper);
    let body = html! {
        header {
            h1 { "Diagnosis: " (what) }
            dl {
                div { dt { "serial" } dd { (page_header.serial.as_deref().unwrap_or("")) } }
                div { dt { "date" } dd { (page_header.date.as_deref().unwrap_or("")) } }
                @if let Some(file) = work.file { div { dt { "readings" } dd { (file) } } }
            }
        }
        @if let Some(note) = &page_header.note { p.note { (note) } }
        @if let Some(line) = assumed_key(work) { p.note { (line) } }
        @if let [one] = work.found {
            div.one-page { (of_key(one, work)) }
        } @else {
            @for common in common(work.found, &SECTION_ENDS) { p.note { (common.sentence()) } }
            (list(work))
            @let uneven = uneven(work);
            @if !uneven.is_empty() {
                h2 { "Off the mean of two neighbours on either side, naturals and sharps apart" }
                @for text in &uneven { p { (text) } }
            }
            @for one in work.found.iter().filter(|one| one.is_work()) {
                h2 { (key(one)) }
                (of_key(one, work))
            }
        }
        footer.soft {
            "D and U are weighed with the pedal down: D is the least weight on the key's front with which the key, let go from rest, sinks slowly to let-off, U the largest that it lifts again from just before let-off. A reading is out (!) where it leaves its usual range by more than it may be off. " (BASIS)
        }
    };
    page(&format!("Diagnosis: {what}"), &style, &body)
}

fn list(work: &Work<'_>) -> Markup {
    let ticked = rows(work).into_iter().map(|row| row.into_iter().chain(["☐".to_owned()]));
    let heads = ["key", "note", "out of its range", "likeliest cause", "", "measure next", "done"];
    html! { div.wide { table.list { (Table::of(heads, ticked).html()) } } }
}

fn of_key(one: &Diagnosis, work: &Work<'_>) -> Markup {
    html! {
        section {
            (readings(one, work))
            @if let Some(why) = one.not_judged() { p.soft { "Not judged: " (why) "." } }
            @if one.is_work() {
                h2 { "To do, in this order" }
                table.list { tbody { @for (at, line) in one.to_do().iter().enumerate() {
                    tr { th scope="row" { (at + 1) } td { (line) } td.tick { "☐" } }
                } } }
            }
            h2 { (one.verdict()) }
            @if !one.causes.is_empty() {
                table.list {
                    thead { tr { td {} th { "cause" } th { "quick test" } th { "then" } th.tick { "done" } } }
                    tbody {
                        @for (rank, ranked) in one.causes.iter().enumerate() {
                            tr {
                                th scope="row" { (rank + 1) }
                                td {
                                    span.do { (ranked.cause.name) } ", " (percent(ranked.probability).replace(' ', "\u{a0}"))
                                    @let explained = explains(ranked, work.lengths);
                                    @if !explained.is_empty() { div.soft { "explains " (explained) } }
                                }
                                td { (ranked.cause.test) }
                                td {
                                    (ranked.cause.cure)
                                    @if let Some(after) = one.weigh_first(ranked) { ". First weigh again " (after) }
                                }
                                td.tick { "☐" }
                            }
                        }
                    }
                }
            }
            @for ranked in &one.withheld {
                p { "Not yet for " (ranked.cause.name) ": " (ranked.withheld.as_deref().unwrap_or_default()) "." }
            }
            @if let Some(question) = one.open_question() {
                @if !one.causes.is_empty() { p { (question) "." } }
                table.list {
                    thead { tr { th { "cause" } th { "quick test" } th.tick { "done" } } }
                    tbody { @for ranked in &one.undecided {
                        tr { td { (ranked.cause.name) } td { (ranked.cause.test) } td.tick { "☐" } }
                    } }
                }
            }
            @if !one.looks.is_empty() {
                h2 { "Ten seconds each" }
                table.list { tbody { @for look in &one.looks {
                    tr { td { span.do { (look.name) } } td { (look.test) } td { (look.cure) } td.tick { "☐" } }
                } } }
            }
            @if one.weigh_again { p { (weigh_again()) } }
            @if one.something_else > 0.05 {
                p.soft { "Something that is not in this list: " (percent(one.something_else)) "." }
            }
            @if let Some(next) = &one.next {
                h2 { "Measure next: " (next.label) }
                p { "How: " (next.how) "." }
                table {
                    thead { tr { th { "if it reads" } th { "then it is likely" } } }
                    tbody {
                        @for (number, causes) in would_read(next, work.lengths) {
                            tr { td.one { (number) } td { (causes) } }
                        }
                    }
                }
            }
            h2 { "What follows from the weights" }
            @for line in geometry(one) { p.soft { (line) } }
        }
    }
}

fn readings(one: &Diagnosis, work: &Work<'_>) -> Markup {
    html! {
        table {
            thead { tr { th { "reading" } th.n { "here" } td {} th.n { "usual" } } }
            tbody {
                @for line in &one.lines {
                    @let number = value(line.value, line.unit, line.decimals, work.lengths);
                    tr {
                        td { (line.label) }
                        @if line.standing == Standing::Out { td.n.out { (number) } } @else { td.n { (number) } }
                        td.one { (mark(line)) }
                        td.n.soft { (usual(line, work.lengths)) }
                    }
                }
            }
        }
    }
}
