//! Two keyboards beside each other: both tables, what differs, both in one figure and on one page.

use erard_figures::Picture;
use erard_figures::figure::{COINCIDE, Dash, Panel, Trace};
use erard_workshop::digits::{plain, signed};
use erard_workshop::weighing::WeighedKey;
use maud::{Markup, html};
use serde_json::{Value, json};

use super::{COLUMNS, TRUSTED, numbers, over_the_keys, samples};
use crate::failure::Failure;
use crate::output::Output;
use crate::paper::{self, picture};
use crate::session::Session;
use crate::table::Table;

const STYLE: &str = include_str!("../paper.css");

/// What is written.
pub(crate) const FILES: [&str; 7] = [
    "keyboard.json",
    "keyboard-1.csv",
    "keyboard-2.csv",
    "difference.csv",
    "keyboard.svg",
    "keyboard.png",
    "keyboard.html",
];

/// A keyboard, and its keys as weighed.
#[derive(Debug)]
pub(crate) struct Side {
    /// Name; two keyboards of one name are distinguished by their order.
    pub name: String,
    /// The same keys of both.
    pub weighed: Vec<WeighedKey>,
}

/// What is compared: its place among the numbers of a key, its name, unit and decimals.
struct Quantity {
    index: usize,
    name: &'static str,
    unit: &'static str,
    decimals: usize,
}

const fn grams(index: usize, name: &'static str) -> Quantity {
    Quantity { index, name, unit: "g", decimals: 1 }
}

const QUANTITIES: [Quantity; 8] = [
    grams(0, "hammer mass"),
    grams(1, "strike weight"),
    grams(2, "front weight"),
    grams(3, "down-weight"),
    grams(4, "up-weight"),
    grams(5, "balance weight"),
    grams(6, "friction weight"),
    Quantity { index: 7, name: "speed at mf", unit: "m/s", decimals: 3 },
];

/// Both names, distinguished.
pub(crate) fn names([a, b]: [&str; 2]) -> [String; 2] {
    if a == b { [format!("{a}, first"), format!("{b}, second")] } else { [a.to_owned(), b.to_owned()] }
}

/// A quantity of the first, of the second, and the second less the first; not a number where a trial found none.
fn values(quantity: &Quantity, sides: &[Side; 2], at: usize) -> [f64; 3] {
    let [a, b] = [0, 1].map(|side: usize| numbers(&sides[side].weighed[at])[quantity.index]);
    [a, b, b - a]
}

/// A number as it is printed; a difference has its sign, unless it rounds to nothing.
fn shown(value: f64, decimals: usize, is_difference: bool) -> String {
    if !value.is_finite() {
        return "-".to_owned();
    }
    if is_difference { signed(value, decimals) } else { plain(value, decimals) }
}

/// Quantities of the first lines, by their place among the numbers of a key.
const FIRST: [usize; 5] = [3, 6, 1, 2, 7];

/// The first lines: how far the second keyboard is from the first, on average and at most.
pub(crate) fn headlines(sides: &[Side; 2]) -> Vec<String> {
    let line = |quantity: &Quantity| {
        let Quantity { name, unit, decimals, .. } = quantity;
        let known: Vec<(usize, [f64; 3])> = (0..sides[0].weighed.len())
            .map(|at| (at, values(quantity, sides, at)))
            .filter(|(_, [.., difference])| difference.is_finite())
            .collect();
        let most = known.iter().max_by(|(_, [.., a]), (_, [.., b])| a.abs().total_cmp(&b.abs()));
        let Some((at, [first, second, difference])) = most else {
            return format!("{name}: unknown.");
        };
        if plain(*difference, *decimals) == plain(0.0, *decimals) {
            return format!("{name}: no difference.");
        }
        let mean = known.iter().map(|(_, [.., difference])| difference).sum::<f64>() / known.len() as f64;
        format!(
            "{name}: the second has {} {unit} on average; most at {}, {} and {} {unit}.",
            shown(mean, *decimals, true),
            sides[0].weighed[*at].note,
            plain(*first, *decimals),
            plain(*second, *decimals)
        )
    };
    FIRST.iter().filter_map(|index| QUANTITIES.iter().find(|quantity| quantity.index == *index)).map(line).collect()
}

/// Sample notes as text.
pub(crate) fn text(sides: &[Side; 2]) -> String {
    let places = samples(&sides[0].weighed);
    let row = |name: &str, which: &str, unit: &str, cell: &dyn Fn(usize) -> String| {
        let cells = places.iter().map(|&at| cell(at));
        [name, which].map(str::to_owned).into_iter().chain(cells).chain([unit.to_owned()]).collect::<Vec<_>>()
    };
    let mut rows = vec![row("note", "", "", &|at| sides[0].weighed[at].note.clone())];
    for quantity in &QUANTITIES {
        for (which, label) in ["1", "2", "2 - 1"].into_iter().enumerate() {
            let name = if which == 0 { quantity.name } else { "" };
            let cell = |at: usize| shown(values(quantity, sides, at)[which], quantity.decimals, which == 2);
            rows.push(row(name, label, quantity.unit, &cell));
        }
    }
    let mut out = Table::of(row("key", "", "", &|at| sides[0].weighed[at].key.to_string()), rows).to_string();
    if places.len() < sides[0].weighed.len() {
        let (shown, all) = (places.len(), sides[0].weighed.len());
        out += &format!("\n  {shown} of {all} keys; keyboard.html and difference.csv hold every one\n");
    }
    out
}

/// Names of the columns that differ: all numbers but whether a key is trusted.
fn columns() -> impl Iterator<Item = (usize, &'static str)> {
    COLUMNS[2..2 + TRUSTED].iter().copied().enumerate()
}

/// The second less the first, key by key.
fn difference(sides: &[Side; 2]) -> Table<'static> {
    let keys = Table::default()
        .optional("key", sides[0].weighed.iter().map(|one| Some(one.key as f64)))
        .words("note", sides[0].weighed.iter().map(|one| one.note.clone()));
    columns().fold(keys, |table, (index, name)| {
        let pairs = sides[0].weighed.iter().zip(&sides[1].weighed);
        table.optional(name, pairs.map(|(a, b)| Some(numbers(b)[index] - numbers(a)[index])))
    })
}

fn json_of(sides: &[Side; 2]) -> Value {
    let [first, second] = sides;
    json!({
        "names": [first.name, second.name],
        "keyboards": [super::table(&first.weighed).json(), super::table(&second.weighed).json()],
        "difference": difference(sides).json(),
    })
}

/// Every quantity of both over the number of the key; where both nearly coincide, their difference below.
fn figure(sides: &[Side; 2]) -> Picture {
    let keys: Vec<f64> = sides[0].weighed.iter().map(|one| one.key as f64).collect();
    let mut panels = Vec::new();
    for quantity in &QUANTITIES {
        let all: Vec<[f64; 3]> = (0..keys.len()).map(|at| values(quantity, sides, at)).collect();
        let curve = |label: &str, which: usize, colour, dash| {
            Trace::new(label, &keys, all.iter().map(|three| three[which]).collect::<Vec<f64>>(), colour, dash)
        };
        let both = vec![curve(&sides[0].name, 0, 0, Dash::Solid), curve(&sides[1].name, 1, 1, Dash::Dashed)];
        panels.push(Panel::new(quantity.name, quantity.unit, 122.0, both));
        let span = |range: std::ops::Range<usize>| {
            let numbers = || all.iter().flat_map(|three| &three[range.clone()]).copied().filter(|x| x.is_finite());
            [numbers().fold(f64::INFINITY, f64::min), numbers().fold(f64::NEG_INFINITY, f64::max)]
        };
        let ([low, high], [least, most]) = (span(0..2), span(2..3));
        let largest = least.abs().max(most.abs());
        if largest.is_finite() && largest > 0.0 && largest < COINCIDE * (high - low) {
            let name = format!("{}, second \u{2212} first", quantity.name);
            let difference = vec![curve("difference", 2, 6, Dash::Solid)];
            panels.push(Panel::new(name, quantity.unit, 122.0, difference));
        }
    }
    over_the_keys(format!("{} beside {}", sides[0].name, sides[1].name), panels)
}

/// The page: both figures, and a row for every key.
fn page(sides: &[Side; 2], figure: &str) -> String {
    let title = format!("{} beside {}", sides[0].name, sides[1].name);
    let body = html! {
        header {
            h1 { (title) }
            dl {
                div { dt { "1" } dd { (sides[0].name) } }
                div { dt { "2" } dd { (sides[1].name) } }
            }
        }
        figure {
            (picture("Weights and hammer speeds of both keyboards over the number of the key; the table below holds the numbers", figure))
        }
        div.wide tabindex="0" role="region" aria-label="Every key" { (table(sides)) }
        p.soft {
            "Touch weights as measured in a slow loop, dampers lifted. Hammer speed: pressed once with a mezzo forte."
        }
    };
    paper::page(&title, &format!("{STYLE}@page{{size:A4 landscape}}body{{max-width:75rem}}"), &body)
}

fn table(sides: &[Side; 2]) -> Markup {
    html! {
        table.list {
            thead {
                tr {
                    th rowspan="2" scope="col" { "key" }
                    th rowspan="2" scope="col" { "note" }
                    @for quantity in &QUANTITIES {
                        th.n colspan="3" scope="colgroup" { (quantity.name) " (" (quantity.unit) ")" }
                    }
                }
                tr {
                    @for _ in &QUANTITIES {
                        th.n scope="col" { "1" } th.n scope="col" { "2" } th.n scope="col" { "2 \u{2212} 1" }
                    }
                }
            }
            tbody {
                @for (at, key) in sides[0].weighed.iter().enumerate() {
                    tr {
                        td.n { (key.key) }
                        td { (key.note) }
                        @for quantity in &QUANTITIES {
                            @for (which, value) in values(quantity, sides, at).into_iter().enumerate() {
                                td.n.do[which == 2] { (shown(value, quantity.decimals, which == 2)) }
                            }
                        }
                    }
                }
            }
        }
    }
}

/// Stages both tables, the differences, the figure and the page.
///
/// # Errors
/// [`Failure::Write`].
pub(crate) fn write(session: &Session, sides: &[Side; 2], output: &mut Output) -> Result<Value, Failure> {
    let picture = figure(sides);
    let page = page(sides, &picture.svg());
    let report = json_of(sides);
    output.json(session, "keyboard.json", &report)?;
    output.table(session, "keyboard-1.csv", &super::table(&sides[0].weighed))?;
    output.table(session, "keyboard-2.csv", &super::table(&sides[1].weighed))?;
    output.table(session, "difference.csv", &difference(sides))?;
    output.figure(session, "keyboard", &picture)?;
    output.text(session, "keyboard.html", &page)?;
    Ok(report)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A difference has its sign; what rounds to nothing has none, and what nobody found is a stroke.
    #[test]
    fn differences_have_signs() {
        for (value, wanted) in [(0.26, "+0.3"), (-0.26, "-0.3"), (0.01, "0.0"), (-0.01, "0.0"), (f64::NAN, "-")] {
            assert_eq!(shown(value, 1, true), wanted);
        }
        assert_eq!((shown(12.34, 1, false).as_str(), shown(-0.004, 2, false).as_str()), ("12.3", "0.00"));
        assert_eq!(names(["a", "a"]), ["a, first", "a, second"]);
    }
}
