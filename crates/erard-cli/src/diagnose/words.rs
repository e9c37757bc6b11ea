//! Answers as text and as a table.

use std::fmt::Write as _;

use erard::keyboard::note_name;
use erard_workshop::diagnose::{
    BASIS, Band, Diagnosis, Judged, Ranked, Standing, Suggestion, WEIGH_AGAIN_G, common, explained_as, joined,
};
use erard_workshop::digits::{plain, signed};
use erard_workshop::worklist::SECTION_ENDS;
use serde_json::Value;

use super::Work;
use crate::table::{Table, USUAL, wrapped};
use crate::units::Lengths;

/// A value with its unit, lengths as the ruler shows them.
pub(super) fn value(value: Option<f64>, unit: &str, decimals: usize, lengths: Lengths) -> String {
    match value {
        None => "none".to_owned(),
        Some(mm) if unit == "mm" => lengths.text(mm, decimals),
        Some(value) => format!("{} {unit}", plain(value, decimals)).trim_end().to_owned(),
    }
}

/// A usual range.
pub(super) fn usual(line: &Judged, lengths: Lengths) -> String {
    let number = |x: f64| {
        if line.unit == "mm" { lengths.number(x, line.decimals) } else { format!("{x:.*}", line.decimals) }
    };
    match line.usual {
        None => String::new(),
        Some([low, high]) if low.is_infinite() => format!("to {}", number(high)),
        Some([low, high]) if high.is_infinite() => format!("from {}", number(low)),
        Some([low, high]) => format!("{}-{}", number(low), number(high)),
    }
}

/// The mark after a reading.
pub(super) fn mark(line: &Judged) -> &'static str {
    match line.standing {
        Standing::Out => "!",
        Standing::Doubtful => "? take it again",
        Standing::NotJudged(_) => "not judged",
        Standing::Inside | Standing::NoRange => "",
    }
}

/// The name and number of a key.
pub(super) fn key(diagnosis: &Diagnosis) -> String {
    format!("{} (key {})", note_name(diagnosis.key), diagnosis.key)
}

/// A share as whole per cents.
pub(super) fn percent(share: f64) -> String {
    match (100.0 * share).round() {
        p if p < 1.0 => "under 1 %".to_owned(),
        p if p > 99.0 => "over 99 %".to_owned(),
        p => format!("{p:.0} %"),
    }
}

/// What a cause explains: `let-off +2.1 mm, drop -0.3 mm`.
pub(super) fn explains(ranked: &Ranked, lengths: Lengths) -> String {
    let one = |(name, by): &(&'static str, f64)| {
        let (label, unit, decimals) = explained_as(name);
        if unit == "mm" {
            format!("{label} {}", lengths.signed(*by, decimals))
        } else {
            format!("{label} {} {unit}", signed(*by, decimals)).trim_end().to_owned()
        }
    };
    ranked.explains.iter().map(one).collect::<Vec<_>>().join(", ")
}

/// The likeliest combinations of causes, and what the suggested reading would be under each.
pub(super) fn would_read(next: &Suggestion, lengths: Lengths) -> Vec<(String, String)> {
    let told = next.would_read.iter().map(|(causes, number)| {
        (format!("about {}", value(Some(*number), next.unit, next.decimals, lengths)), joined(causes))
    });
    told.collect()
}

/// Whose usual ranges hold where nobody named the key.
pub(super) fn assumed_key(work: &Work<'_>) -> Option<String> {
    let one = work.found.first().filter(|_| work.is_key_assumed)?;
    Some(format!("No key was named: usual ranges are those of {}. Name yours with --key.", key(one)))
}

/// What follows from the weights, a line each. A note tells what is missing where nothing follows.
pub(super) fn geometry(diagnosis: &Diagnosis) -> Vec<String> {
    let of = &diagnosis.geometry;
    let line = |name: &str, band: Option<Band>, unit: &str| {
        band.map(|Band { low, high }| format!("{name}: {low:.2} to {high:.2} {unit}").trim_end().to_owned())
    };
    let results = [line("leverage", of.ratio, ""), line("inertia at the key", of.inertia_kg, "kg")];
    results.into_iter().flatten().chain(of.notes.iter().cloned()).collect()
}

/// What is diagnosed.
pub(crate) fn title(work: &Work<'_>) -> String {
    match work.found {
        [one] => format!("{} - diagnosis of your readings", key(one)),
        found => {
            let ill = found.iter().filter(|one| one.is_work()).count();
            format!("{} - {} keys, {ill} of them with work", work.file.unwrap_or(""), found.len())
        }
    }
}

/// Keys with work that are named first.
const FIRST_KEYS: usize = 6;

/// The first lines: what is out, which causes come first, and what to measure next.
pub(crate) fn headlines(answer: &Value) -> Vec<String> {
    let text = |value: &Value| value.as_str().unwrap_or_default().to_owned();
    let list = |value: &Value| value.as_array().cloned().unwrap_or_default();
    let keys = list(&answer["keys"]);
    let out_of_range = |key: &Value| {
        let readings = list(&key["readings"]);
        let out = readings.iter().filter(|reading| reading["standing"] == "out");
        let one = |reading: &Value| {
            let decimals = reading["decimals"].as_u64().and_then(|n| usize::try_from(n).ok()).unwrap_or(1);
            let label = text(&reading["label"]);
            let label = label.split(" (").next().unwrap_or_default().to_owned();
            let value = reading["value"].as_f64().map_or("none".to_owned(), |value| plain(value, decimals));
            format!("{label} {value} {}", text(&reading["unit"])).trim_end().to_owned()
        };
        out.map(one).collect::<Vec<_>>().join(", ")
    };
    let cause =
        |cause: &Value| format!("{}, {}", text(&cause["name"]), percent(cause["probability"].as_f64().unwrap_or(0.0)));
    let mut lines = Vec::new();
    if let [one] = &keys[..] {
        let out = out_of_range(one);
        if !out.is_empty() {
            lines.push(format!("Out of range: {out}."));
        }
        let causes = list(&one["causes"]);
        let verdict = text(&one["verdict"]);
        let stop = if causes.is_empty() && !verdict.ends_with('.') { "." } else { "" };
        let stop = if causes.is_empty() { stop } else { ":" };
        lines.push(format!("{verdict}{stop}"));
        lines.extend(
            (1..).zip(&causes).map(|(at, one)| format!("  {at}. {}; test: {}", cause(one), text(&one["test"]))),
        );
        if let Some(open) = one["open_question"].as_str().filter(|open| *open != verdict) {
            lines.push(format!("{open}."));
        }
        if one["weigh_again"] == true {
            lines.push(weigh_again());
        }
        if let Some(next) = one["measure_next"].as_object() {
            lines.push(format!("Measure next: {} ({}).", text(&next["label"]), text(&next["how"])));
        }
        if answer["is_key_assumed"] == true {
            let key = format!("{} (key {})", text(&one["note"]), one["key"]);
            lines.push(format!("No key was named: usual ranges are those of {key}. Name yours with --key."));
        }
        return lines;
    }
    let common = list(&answer["common"]);
    for one in &common {
        let count = |value: &Value| value.as_array().map_or_else(|| value.to_string(), |all| all.len().to_string());
        let (keys, of) = (count(&one["keys"]), count(&one["of"]));
        lines.push(format!(
            "{keys} of {of} keys with work say the same, so that the cause is one: {}.",
            text(&one["name"])
        ));
    }
    let ill: Vec<&Value> = keys.iter().filter(|key| key["is_work"] == true).collect();
    for key in ill.iter().take(FIRST_KEYS) {
        let first = list(&key["causes"]).first().map_or_else(|| "undecided".to_owned(), cause);
        lines.push(format!("{} (key {}): {}; {first}", text(&key["note"]), key["key"], out_of_range(key)));
    }
    if ill.len() > FIRST_KEYS {
        lines.push(format!("and {} more keys", ill.len() - FIRST_KEYS));
    }
    lines
}

/// The answers for people, below their title.
pub(crate) fn text(work: &Work<'_>) -> String {
    let mut out = match work.found {
        [one] => of_one(one, work.lengths),
        found => of_many(found, work),
    };
    if let Some(assumed) = assumed_key(work) {
        let _ = writeln!(out);
        line(&mut out, 2, &assumed);
    }
    out
}

fn line(out: &mut String, indent: usize, text: &str) {
    for part in wrapped(text, USUAL - indent) {
        let _ = writeln!(out, "{:indent$}{part}", "");
    }
}

fn of_one(one: &Diagnosis, lengths: Lengths) -> String {
    let mut out = String::new();
    let rows = one.lines.iter().map(|line| {
        [
            line.label.to_owned(),
            value(line.value, line.unit, line.decimals, lengths),
            usual(line, lengths),
            mark(line).to_owned(),
        ]
    });
    out += &Table::of(["reading", "here", "usual", ""], rows).to_string();
    if let Some(why) = one.not_judged() {
        line(&mut out, 2, &format!("Not judged: {why}."));
    }
    let _ = writeln!(out);
    let has_list = !one.causes.is_empty();
    line(
        &mut out,
        2,
        &format!(
            "{}{}",
            one.verdict(),
            if has_list {
                ":"
            } else if one.is_work() {
                "."
            } else {
                ""
            }
        ),
    );
    for (rank, ranked) in one.causes.iter().enumerate() {
        line(&mut out, 2, &format!("{}. {}, {}", rank + 1, ranked.cause.name, percent(ranked.probability)));
        let again = one.weigh_first(ranked).map_or(String::new(), |after| format!("weigh again {after}"));
        for (what, text) in [
            ("explains", explains(ranked, lengths)),
            ("test", ranked.cause.test.clone()),
            ("then", ranked.cause.cure.clone()),
            ("first", again),
        ] {
            if !text.is_empty() {
                line(&mut out, 5, &format!("{what}: {text}"));
            }
        }
    }
    for ranked in &one.withheld {
        let why = ranked.withheld.as_deref().unwrap_or_default();
        line(&mut out, 2, &format!("Not yet for {}: {why}.", ranked.cause.name));
    }
    if one.is_work() && !one.undecided.is_empty() {
        if has_list {
            line(&mut out, 2, &format!("{}.", one.open_question().unwrap_or_default()));
        }
        for ranked in &one.undecided {
            line(&mut out, 5, &format!("{}: {}", ranked.cause.name, ranked.cause.test));
        }
    }
    if !one.looks.is_empty() {
        line(&mut out, 2, "Ten seconds each:");
        for look in &one.looks {
            let then = if one.is_look { format!("; then {}", look.cure) } else { String::new() };
            line(&mut out, 5, &format!("{}: {}{then}", look.name, look.test));
        }
    }
    if one.weigh_again {
        line(&mut out, 2, &weigh_again());
    }
    if one.something_else > 0.05 {
        line(&mut out, 2, &format!("Something that is not in this list: {}.", percent(one.something_else)));
    }
    if let Some(next) = &one.next {
        let _ = writeln!(out);
        line(&mut out, 2, &format!("Measure next: {} ({}).", next.label, next.how));
        for (number, causes) in would_read(next, lengths) {
            line(&mut out, 5, &format!("{number}: {causes}"));
        }
    }
    let _ = writeln!(out);
    for text in geometry(one) {
        line(&mut out, 2, &text);
    }
    if one.is_work() {
        line(&mut out, 2, BASIS);
    }
    out
}

/// What friction does to the weights.
pub(super) fn weigh_again() -> String {
    format!("Friction is over {WEIGH_AGAIN_G:.0} g: ease it and weigh again before leverage, hammers and leads.")
}

/// What is named first of a key, with its probability.
fn first(one: &Diagnosis) -> (String, String) {
    match (one.looks.first().filter(|_| one.is_look), one.causes.first()) {
        (Some(look), _) => (look.name.clone(), String::new()),
        (None, Some(ranked)) => (ranked.cause.name.clone(), percent(ranked.probability)),
        (None, None) if one.is_work() => ("undecided".to_owned(), String::new()),
        (None, None) => ("no work".to_owned(), String::new()),
    }
}

/// What is out, in a word each.
fn out_of_range(one: &Diagnosis, lengths: Lengths) -> String {
    let out = one.lines.iter().filter(|line| line.standing == Standing::Out);
    let word = |line: &Judged| {
        let label = line.label.split(" (").next().unwrap_or(line.label);
        format!("{label} {}", value(line.value, line.unit, line.decimals, lengths))
    };
    out.map(word).collect::<Vec<_>>().join(", ")
}

pub(super) fn rows(work: &Work<'_>) -> Vec<[String; 6]> {
    let row = |one: &Diagnosis| {
        let (cause, probability) = first(one);
        [
            one.key.to_string(),
            note_name(one.key),
            out_of_range(one, work.lengths),
            cause,
            probability,
            one.next.as_ref().map_or(String::new(), |next| next.label.to_owned()),
        ]
    };
    work.found.iter().map(row).collect()
}

fn of_many(found: &[Diagnosis], work: &Work<'_>) -> String {
    let mut out = String::new();
    for common in common(found, &SECTION_ENDS) {
        line(&mut out, 2, &common.sentence());
        let _ = writeln!(out);
    }
    for [key, note, out_of, cause, percent, next] in rows(work) {
        if out_of.is_empty() {
            continue;
        }
        line(&mut out, 2, &format!("{note} (key {key}): {out_of}"));
        let comma = if percent.is_empty() { "" } else { ", " };
        line(&mut out, 5, &format!("{cause}{comma}{percent}"));
        if !next.is_empty() {
            line(&mut out, 5, &format!("measure next: {next}"));
        }
    }
    let uneven = uneven(work);
    if !uneven.is_empty() {
        let _ = writeln!(out);
        line(&mut out, 2, "Off the mean of two neighbours on either side, naturals and sharps apart:");
        uneven.iter().for_each(|text| line(&mut out, 5, text));
    }
    let _ = writeln!(out);
    line(&mut out, 2, "All causes of every key, with their tests: diagnosis.html and diagnosis.json.");
    line(&mut out, 2, BASIS);
    out
}

/// Readings that are off their neighbours' by more than two readings may be, a line for each key that has some.
pub(super) fn uneven(work: &Work<'_>) -> Vec<String> {
    let of = |one: &Diagnosis| {
        let off = |line: &Judged| {
            let off = line.off_neighbours().filter(|_| line.is_uneven())?;
            let label = line.label.split(" (").next().unwrap_or(line.label);
            let by = match line.unit {
                "mm" => work.lengths.signed(off, line.decimals),
                unit => format!("{} {unit}", signed(off, line.decimals)).trim_end().to_owned(),
            };
            Some(format!("{label} {by}"))
        };
        let all: Vec<String> = one.lines.iter().filter_map(off).collect();
        (!all.is_empty()).then(|| format!("{} (key {}): {}", note_name(one.key), one.key, all.join(", ")))
    };
    work.found.iter().filter_map(of).collect()
}

/// diagnosis.csv: a row for each key.
pub(crate) fn table(work: &Work<'_>) -> Table<'static> {
    let found = work.found;
    let of = |name: &'static str| {
        found.iter().map(move |one| one.lines.iter().find(|line| line.name == name).and_then(|line| line.value))
    };
    let first =
        |text: fn(&Ranked) -> String| found.iter().map(move |one| one.causes.first().map_or(String::new(), text));
    Table::default()
        .optional("key", found.iter().map(|one| Some(one.key as f64)))
        .words("note", found.iter().map(|one| note_name(one.key)))
        .optional("balance_weight_g", of("balance_weight_g"))
        .optional("friction_weight_g", of("friction_weight_g"))
        .words(
            "out",
            found.iter().map(|one| {
                let out = one.lines.iter().filter(|line| line.standing == Standing::Out);
                out.map(|line| line.name).collect::<Vec<_>>().join(" ")
            }),
        )
        .words(
            "off_neighbours",
            found.iter().map(|one| {
                let off = one.lines.iter().filter(|line| line.is_uneven());
                let one = |line: &Judged| Some(format!("{}={}", line.name, rounded(line.off_neighbours()?)));
                off.filter_map(one).collect::<Vec<_>>().join(" ")
            }),
        )
        .words("cause", first(|ranked| ranked.cause.key.clone()))
        .optional("probability", found.iter().map(|one| one.causes.first().map(|ranked| rounded(ranked.probability))))
        .words("measure_next", found.iter().map(|one| one.next.as_ref().map_or("", |next| next.name)))
}

fn rounded(x: f64) -> f64 {
    (x * 1e3).round() / 1e3
}
