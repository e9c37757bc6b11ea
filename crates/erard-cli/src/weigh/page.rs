//! The work list on paper.

use maud::{Markup, html};

use super::Work;
use super::table::{remarks, rows};
use crate::paper::{page, picture};
use crate::table::Table;

const STYLE: &str = include_str!("../paper.css");

/// The page: head, list, remarks, figure.
pub(crate) fn html(work: &Work<'_>, figure: &str) -> String {
    let headed = work.headed;
    let title = format!("{}: work list", work.name);
    let leads = "td:nth-child(13){font-weight:600;white-space:nowrap}td:nth-child(12){white-space:nowrap}";
    let style = format!("{STYLE}{leads}@page{{size:{}}}", headed.paper);
    let body = html! {
        header {
            h1 { "Work list: " (work.name) }
            dl {
                div { dt { "serial" } dd { (headed.serial.as_deref().unwrap_or("")) } }
                div { dt { "date" } dd { (headed.date.as_deref().unwrap_or("")) } }
                div { dt { "weighed" } dd { (work.file) } }
            }
        }
        @if let Some(note) = &headed.note { p.note { (note) } }
        p.aim { (remarks(work).first().map_or("", String::as_str)) }
        div.wide { (list(work)) }
        @for remark in remarks(work).iter().skip(1) { p.soft { (remark) } }
        p.soft {
            "Weights in grams, inertia in kilograms at the key's front; places of leads count from the balance pin, in front of it where nothing \
             else is said; a capstan goes forward to the player. Inertia is an estimate: the hammer's from its strike weight and ratio, \
             the key's and the whippen's from the keyboard's model."
        }
        figure {
            (picture("Strike weight, front weight, balance weight, friction weight, ratio and inertia over the keyboard", figure))
        }
    };
    page(&title, &style, &body)
}

/// The work list: what the printed table has, and a box to tick.
fn list(work: &Work<'_>) -> Markup {
    let weighed =
        ["key", "note", "ratio", "friction", "balance weight", "inertia", "hammer", "aim", "front weight", "aim"];
    let heads = weighed.into_iter().chain(["or: hammer", "or: capstan", "leads", "done"]);
    let ticked = rows(work).into_iter().map(|row| row.into_iter().chain(["☐".to_owned()]));
    html! { table.list { (Table::of(heads, ticked).html()) } }
}
