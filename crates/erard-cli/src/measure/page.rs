//! The sheets as one page that opens from disk and prints well: nothing is fetched, and there is no script.

use erard_figures::drawing::at_night;
use erard_workshop::measure::norms::{GROUPS, Line, ratios_compared};
use erard_workshop::measure::range::MIDI_MAP;

use super::figures::Drawn;
use super::shown;
use super::table::usual_of;
use super::{Measured, doubts};
use crate::paper::{PageHeader, page, picture};
use crate::table::Table;
use crate::units::Lengths;
use maud::{Markup, html};

const STYLE: &str = include_str!("page.css");

/// Sections of the page and their headings, in their order.
const HEADINGS: [(&str, &str); 5] = [
    ("measures", "Measures"),
    ("timing", "Timing sheet"),
    ("flight", "Free flight"),
    ("bench", "At the bench"),
    ("pictures", "Pictures"),
];

/// The page: what is out of its range first, then the tables, then the pictures.
pub(crate) fn html(
    measured: &[Measured],
    drawings: &[Drawn],
    figures: &[Drawn],
    page_header: &PageHeader,
    lengths: Lengths,
) -> String {
    let names: Vec<&str> = measured.iter().map(|one| one.label.as_str()).collect();
    let title = names.join(" beside ");
    let several = measured.len() > 1;
    let body = html! {
        div.indexed {
            nav.index aria-label="Contents" {
                @for (id, heading) in HEADINGS { a href={ "#" (id) } { (heading) } }
            }
            div {
                h1 { (title) }
                @if page_header.serial.is_some() || page_header.date.is_some() {
                    p {
                        @if let Some(serial) = &page_header.serial { "Serial " (serial) ". " }
                        @if let Some(date) = &page_header.date { (date) }
                    }
                }
                @if let Some(note) = &page_header.note { p { (note) } }
                p.soft {
                    "Protocol sheet. Everything is measured in simulation, in the way in which a technician measures it. \
                     Grams on the key are gram weights on the key front."
                }
                @for one in measured { (flags(one, several)) }
                (table(measured, lengths))
                div id="timing" { @for one in measured { (timing(one, several)) } }
                div id="flight" { @for one in measured { (flight(one, several)) } }
                div id="bench" { @for one in measured { (bench(one, several)) } }
                h2 id="pictures" { "Pictures" }
                @for drawn in drawings { (captioned(drawn, "action", &at_night(&drawn.picture.svg()))) }
                @for drawn in figures { (captioned(drawn, "plot", &drawn.picture.svg())) }
            }
        }
    };
    page(&format!("{title}: protocol sheet"), &format!("{STYLE}{}", on_every_page(&title, page_header)), &body)
}

/// A style that prints the action's name, and what else identifies it, at the head of every page.
fn on_every_page(title: &str, page_header: &PageHeader) -> String {
    let words = [Some(title), page_header.serial.as_deref(), page_header.date.as_deref()];
    let words = words.into_iter().flatten().collect::<Vec<_>>().join(" - ");
    // A string of a style sheet, inside an element that ends at its first `</`: everything but letters, digits and
    // blanks by its code.
    let mut quoted = String::new();
    for c in words.chars() {
        if c.is_alphanumeric() || c == ' ' {
            quoted.push(c);
        } else {
            // The blank ends the code.
            quoted += &format!("\\{:06x} ", u32::from(c));
        }
    }
    format!("@page{{size:{};margin-top:18mm;@top-left{{content:\"{quoted}\";font-size:9pt}}}}", page_header.paper)
}

fn flags(one: &Measured, named: bool) -> Markup {
    let whose = html! { @if named { (one.label) ": " } };
    html! {
        @if one.sheet.flags.is_empty() {
            p { (whose) "All readings are in their usual range." }
        } @else {
            p.out { (whose) "Out of the usual range:" }
            ul.flags { @for flag in &one.sheet.flags { li { (flag.message) } } }
        }
        @if !one.sheet.trusted {
            p.out { (whose) "This measurement cannot be trusted:" }
            ul.flags { @for doubt in doubts(&one.sheet) { li { (doubt) } } }
        }
    }
}

fn table(measured: &[Measured], lengths: Lengths) -> Markup {
    let is_shown =
        |line: &&Line| line.norm().is_some() || measured.iter().any(|one| (line.value)(&one.sheet).is_some());
    html! {
        h2 id="measures" { "Measures" }
        div.wide tabindex="0" role="region" aria-label="Measures" { table.sourced[measured.len() == 1] {
            thead {
                tr {
                    td {}
                    @for one in measured { th scope="col" { (one.label) } }
                    th scope="col" { "usual" }
                    th.source scope="col" { "source" }
                }
            }
            tbody {
                @for group in GROUPS.iter() {
                    tr.group { th colspan=(measured.len() + 3) scope="rowgroup" { (group.heading) } }
                    @for line in group.page_lines().filter(is_shown) { (row(line, measured, lengths)) }
                }
            }
        } }
        p.soft {
            "R, the strike-weight ratio, is the weight on the key's front that balances a gram at the hammer's head. The \
             usual range is R's. The lever ratios check it: without friction they are R, each at its place."
        }
        @for one in measured {
            @if let Some(compared) = ratios_compared(&one.sheet) {
                p.soft { @if measured.len() > 1 { (one.label) ": " } (compared) }
            }
        }
    }
}

fn row(line: &Line, measured: &[Measured], lengths: Lengths) -> Markup {
    html! {
        tr {
            th scope="row" { (line.label) }
            @for one in measured {
                @let value = shown(line, (line.value)(&one.sheet), lengths);
                // Colour alone says nothing on a grey print.
                @if line.is_out(&one.sheet) { td.out { (value) " !" } } @else { td { (value) } }
            }
            td { (usual_of(line, measured, lengths)) }
            td.source { (line.norm().map_or("", |norm| &norm.source)) }
        }
    }
}

fn captioned(drawn: &Drawn, class: &str, svg: &str) -> Markup {
    html! { figure class=(class) { (picture(&drawn.alt, svg)) figcaption { (drawn.alt) } } }
}

/// A heading, what the numbers are, and a table of one action.
fn section(heading: &str, note: &Markup, table: &Table<'_>, one: &Measured, named: bool) -> Markup {
    html! {
        h2 { (heading) @if named { ": " (one.label) } }
        p.soft { (note) }
        div.wide tabindex="0" role="region" aria-label={ (heading) ", " (one.label) } { table { (table.html()) } }
    }
}

fn timing(one: &Measured, named: bool) -> Markup {
    let note = html! { "Milliseconds after key start; built-in touches, a hand of 200 g. " (MIDI_MAP) };
    section("Timing sheet", &note, &super::table::timing(one), one, named)
}

fn flight(one: &Measured, named: bool) -> Markup {
    let note = html! {
        "From the last push on the knuckle, and from the head's largest speed, to the string, along the string's \
         normal. Behind each time: what the way would take at the speed with which the head meets the string."
    };
    section("Free flight", &note, &super::table::flight(one), one, named)
}

fn bench(one: &Measured, named: bool) -> Markup {
    let note = html! {
        "The hammer is blocked half-way to the string and weights are laid on the key. Travel from the first weight \
         on: of the key's front down, of the capstan up."
    };
    section("At the bench", &note, &super::table::bench(one), one, named)
}
