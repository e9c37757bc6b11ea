//! The page.

use erard::keyboard::note_name;
use erard_workshop::measure::norms::lines;
use erard_workshop::regulate::{CAPSTAN_THREAD_M, SMALL_THREAD_M};
use erard_workshop::worklist::ReadingQuantity;
use maud::{Markup, html};

use super::{AdvisedInstrument, ORDER, beyond, in_the_end, left, tasks};
use crate::measure::headlines::{READ_AGAIN, STAYS_OUT};
use crate::measure::{shown, usual};
use crate::paper::{page, picture};
use crate::table::Table;
use crate::units::Lengths;

const STYLE: &str = include_str!("../paper.css");

/// Both columns of numbers alike.
const COLUMNS: &str = "@media screen and (min-width:40rem){.pair{grid-template-columns:1fr 1fr}}@media print{.pair{grid-template-columns:1fr 1fr}}";

/// A line of the sheet: which of the protocol's, and what the bench calls it.
type Value = (&'static str, &'static str);

const TOUCH: [Value; 5] = [
    ("down_weight_g", "down-weight"),
    ("up_weight_g", "up-weight"),
    ("balance_weight_g", "balance weight"),
    ("friction_weight_g", "friction"),
    ("effective_inertia_kg", "inertia at the key"),
];
const PARTS: [Value; 4] = [
    ("strike_weight_g", "hammer (strike weight)"),
    ("front_weight_g", "key front weight"),
    ("whippen_weight_g", "whippen weight"),
    ("strike_weight_ratio_weights", "leverage R"),
];
const REGULATION: [Value; 11] = [
    ("dip_mm", "dip"),
    ("blow_mm", "blow"),
    ("jack_position_mm", "jack position"),
    ("lever_height_mm", "lever height"),
    ("let_off_mm", "let-off"),
    ("drop_mm", "drop"),
    ("aftertouch_mm", "aftertouch"),
    ("check_mm", "checking distance"),
    ("repetition_spring_m_per_s", "rise from the check"),
    ("damper_start_share", "damper start"),
    ("lost_motion_mm", "lost motion"),
];
const PLAYING: [Value; 3] = [
    ("repetition_rate_half_hz", "repetition, key half up"),
    ("repetition_rate_hz", "repetition, key fully up"),
    ("softest_force_N", "softest touch that sounds"),
];

/// A page for every action.
pub(crate) fn html(all: &[AdvisedInstrument<'_>]) -> String {
    let names: Vec<&str> = all.iter().map(|one| one.measured.label.as_str()).collect();
    let paper = all.first().map_or("A4", |one| one.page_header.paper);
    let title = format!("{}: technician's sheet", names.join(", "));
    let style = format!("{STYLE}@page{{size:{paper}}}section+section{{break-before:page}}{COLUMNS}");
    page(&title, &style, &html! { @for one in all { (sheet(one)) } })
}

fn sheet(one: &AdvisedInstrument<'_>) -> Markup {
    let (measured, page_header) = (one.measured, one.page_header);
    let out = measured.sheet.flags.len();
    html! {
        section.one-page {
            header {
                h1 { (measured.label) }
                dl {
                    div { dt { "serial" } dd { (page_header.serial.as_deref().unwrap_or("")) } }
                    div { dt { "date" } dd { (page_header.date.as_deref().unwrap_or("")) } }
                }
            }
            @if let Some(note) = &page_header.note { p.note { (note) } }
            p.soft {
                "Usual ranges are those of " (note_name(measured.sheet.norms_for_key))
                " (key " (measured.sheet.norms_for_key) "). "
                @if out == 0 { "Nothing is out of it." } @else { "Values outside are marked !" }
            }
            div.pair {
                div { (values("Touch", &TOUCH, one)) (values("On the scale", &PARTS, one)) (values("Playing", &PLAYING, one)) }
                div { (values("Regulation", &REGULATION, one)) }
            }
            h2 { "To do, " (ORDER) }
            (to_do(one))
            figure.action {
                (picture(&format!("{}, at rest", measured.label), &one.drawing))
            }
            footer.soft {
                "How D and U are taken: pedal down, the weight on the key's front. D is the least with which the key, let go from rest, sinks slowly to let-off, \
                 U the largest that it lifts again from just before let-off; its speed must not help it. Damper start is a share of the dip. \
                 Leverage R, the strike-weight ratio: balance weight and front weight, less whippen weight times key ratio, over strike weight. "
                "Measured in simulation of this file, as on the bench. Turns are estimates: " (pitch(CAPSTAN_THREAD_M, one.lengths))
                " a turn for capstans, let-off and dampers (as a 10-24 machine screw, which Nossaman uses for dampers, Caut list 2007), "
                (pitch(SMALL_THREAD_M, one.lengths)) " for the small screws; give a turn, read the line, and turn on or back until it reads what is said above, or well inside its range. Sources of the usual ranges, all values and the curves: measure.html, the appendix."
            }
        }
    }
}

fn pitch(metres: f64, lengths: Lengths) -> String {
    lengths.text(metres * 1e3, 2)
}

fn values(heading: &str, values: &[Value], one: &AdvisedInstrument<'_>) -> Markup {
    let sheet = &one.measured.sheet;
    let found = |key: &str| lines().find(|line| line.key == key);
    let after = |key: &str| ReadingQuantity::ALL.into_iter().find(|quantity| quantity.key() == key);
    let has_after = !one.list.items.is_empty() && values.iter().any(|(key, _)| after(key).is_some());
    html! {
        table {
            thead { tr { th { (heading) } th.n { "here" } @if has_after { th.n { "after" } } th.n { "usual" } } }
            tbody {
                @for (line, name) in values.iter().filter_map(|(key, name)| Some((found(key)?, name))) {
                    @let value = shown(line, (line.value)(sheet), one.lengths);
                    tr {
                        td { (name) }
                        @if line.is_out(sheet) { td.n.out { (value) " !" } } @else { td.n { (value) } }
                        @if has_after {
                            @match after(line.key) {
                                Some(quantity) => {
                                    @let text = shown(line, one.list.after.get(quantity), one.lengths);
                                    @if one.list.is_out(quantity, &one.list.after) { td.n.out { (text) " !" } } @else { td.n { (text) } }
                                }
                                None => { td.n {} }
                            }
                        }
                        td.n.soft { (usual(line, sheet.norms_for_key, one.lengths)) }
                    }
                }
            }
        }
    }
}

fn to_do(one: &AdvisedInstrument<'_>) -> Markup {
    let tasks = tasks(one);
    let only_flags = tasks.is_empty() && !one.measured.sheet.flags.is_empty();
    html! {
        @if tasks.is_empty() {
            p { @if only_flags { "Nothing to turn: see the marks above." } @else { "Nothing." } }
        } @else {
            @let rows = tasks.into_iter().enumerate().flat_map(|(index, task)| {
                let number = (index + 1).to_string();
                let line = [number, task.what, task.by, task.for_, "☐".to_owned()];
                let or = task.instead.map(|instead| [String::new(), "or instead".to_owned(), instead, String::new(), String::new()]);
                let then = task.then.map(|then| [String::new(), "then".to_owned(), then, String::new(), "☐".to_owned()]);
                std::iter::once(line).chain(or).chain(then)
            });
            table.list { (Table::of(["", "what", "how far", "for", "done"], rows).html()) }
        }
        @if let Some(in_the_end) = in_the_end(&one.list) {
            p.soft { "In the end: " (in_the_end) "." }
        }
        @for heading in [READ_AGAIN, STAYS_OUT] {
            @for line in left(&one.list, heading, one.lengths) {
                p.soft { (heading) ": " (line.why) "." }
            }
        }
        @for line in beyond(&one.measured.sheet) {
            p.soft { "Not by this list: " (line) "." }
        }
    }
}
