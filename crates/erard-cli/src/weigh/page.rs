//! The work list on paper.

use maud::{Markup, html};

use super::table::remarks;
use super::{Work, capstan_text, leads_text};
use crate::paper::{page, picture};
use erard_workshop::balance::BalancedKey;

const STYLE: &str = include_str!("../paper.css");

/// The page: head, list, remarks, figure.
pub(crate) fn html(work: &Work<'_>, figure: &str) -> String {
    let headed = work.headed;
    let title = format!("{}: work list", work.name);
    let style = format!("{STYLE}@page{{size:{}}}", headed.paper.css());
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

fn list(work: &Work<'_>) -> Markup {
    html! {
        table.list {
            thead {
                tr {
                    th { "key" } th { "note" } th.n { "ratio" } th.n { "friction" } th.n { "balance weight" } th.n { "inertia" }
                    th.n { "hammer" } th.n { "aim" } th.n { "front weight" } th.n { "aim" }
                    th { "leads" } th.n { "or: hammer" } th { "or: capstan" } th { "done" }
                }
            }
            tbody { @for key in &work.plan.keys { (row(key, work)) } }
        }
    }
}

fn row(key: &BalancedKey, work: &Work<'_>) -> Markup {
    let number =
        |value: Option<f64>, decimals: usize| value.map_or(String::new(), |x| format!("{:.decimals$}", x + 0.0));
    let leads = key.leads.as_ref().map_or("not by leads".to_owned(), |leads| leads_text(leads, work.lengths));
    html! {
        tr {
            td.n { (key.measured.key) @if key.from_curves { " ~" } }
            td { (key.note) }
            td.n { (number(key.ratio, 2)) }
            td.n { (number(key.friction_weight_g, 1)) }
            td.n { (number(key.balance_weight_g, 1)) }
            td.n { (number(key.inertia_kg, 3)) }
            td.n { (number(key.strike_weight_g, 1)) }
            td.n { (number(key.target_strike_weight_g, 1)) }
            td.n { (number(key.measured.front_weight_g, 1)) }
            td.n { (number(key.target_front_weight_g, 1)) }
            td.do.one { (leads) }
            td.n { (key.strike_change_g.map_or(String::new(), |by| format!("{by:+.1}"))) }
            td.one { (key.capstan_move_mm.map_or(String::new(), |by| capstan_text(by, work.lengths))) }
            td.tick { "☐" }
        }
    }
}
