//! A performance in words, as a table and as JSON.

use erard::keyboard::note_name;
use erard_midi::Law;
use erard_piece::{Fault, Performance, Played as Note, Reason, Score, Summary};
use serde_json::{Value, json};

use super::{Played, Side};
use crate::table::{Table, decimal};

/// So many notes that went wrong stand in `summary.json`, and so many are printed.
const LISTED: usize = 1000;
const PRINTED: usize = 12;

/// A note's faults, with commas; empty without one.
pub(super) fn faults(note: &Note) -> String {
    note.faults().into_iter().map(Fault::name).collect::<Vec<_>>().join(", ")
}

/// Why; empty where nothing went wrong.
pub(super) fn reasons(note: &Note) -> String {
    note.reasons().iter().map(ToString::to_string).collect::<Vec<_>>().join("; ")
}

/// All notes, a row each.
pub(crate) fn table(side: &Side) -> Table<'static> {
    let notes = &side.performance.notes;
    let number = |of: &dyn Fn(&Note) -> Option<f64>| notes.iter().map(of).collect::<Vec<_>>();
    Table::default()
        .optional("note", (1..=notes.len()).map(|n| Some(n as f64)))
        .optional("key", number(&|note| Some(note.wanted.key as f64)))
        .words("name", notes.iter().map(|note| note_name(note.wanted.key)))
        .optional("written_s", number(&|note| Some(note.wanted.on_s)))
        .optional("velocity", number(&|note| Some(note.wanted.velocity.counts())))
        .optional("wanted_m_per_s", number(&|note| Some(note.wanted.speed_m_per_s)))
        .optional("sounded_s", number(&|note| note.impact.map(|[at_s, _]| at_s)))
        .optional("hammer_speed_m_per_s", number(&|note| note.impact.map(|[_, speed]| speed)))
        .optional("late_ms", number(&|note| note.late_s().map(|late_s| 1e3 * late_s)))
        .optional("louder_by_counts", number(&|note| note.louder))
        .optional("pressed_s", number(&|note| Some(note.pressed_s)))
        .optional("force_N", number(&|note| Some(note.force_n)))
        .optional("written_off_s", number(&|note| Some(note.wanted.off_s)))
        .optional("off_s", number(&|note| note.released.map(|[at_s, _]| at_s)))
        .optional("release_m_per_s", number(&|note| note.released.map(|[_, speed]| speed)))
        .optional("further_impacts", number(&|note| Some(note.more_impacts.len() as f64)))
        .optional("from_home", number(&|note| Some(f64::from(u8::from(note.from_home)))))
        .optional("trials", number(&|note| Some(f64::from(note.trials))))
        .words("faults", notes.iter().map(faults))
        .words("reasons", notes.iter().map(reasons))
}

/// `summary.json`.
pub(crate) fn json(played: &Played<'_>) -> Value {
    let keyboards: Vec<Value> = played.sides.iter().map(|side| keyboard_json(side, played.score)).collect();
    json!({
        "piece": played.piece,
        "notes": played.score.notes.len(),
        "duration_s": played.score.duration_s,
        "shift_s": played.score.shift_s,
        "remarks": played.score.remarks,
        "threads": played.threads,
        "keyboards": keyboards,
        "differ": differing(played).into_iter().map(|note| note + 1).take(LISTED).collect::<Vec<_>>(),
    })
}

fn reasons_json(all: &Summary) -> serde_json::Map<String, Value> {
    let found = Reason::NAMES.iter().zip(all.reasons).filter(|(_, count)| *count > 0);
    found.map(|(name, count)| ((*name).to_owned(), count.into())).collect()
}

fn ceilings_json(performance: &Performance, law: &Law<'_>) -> Vec<Value> {
    let one = |(key, speed): (&usize, &f64)| {
        let velocity = law.velocity(*speed).counts();
        json!({"key": key, "name": note_name(*key), "hammer_speed_m_per_s": speed, "velocity": velocity})
    };
    performance.ceilings().iter().map(one).collect()
}

fn keyboard_json(side: &Side, score: &Score<'_>) -> Value {
    let all = side.performance.summary();
    let counts: serde_json::Map<String, Value> =
        Fault::ALL.iter().zip(all.faults).map(|(fault, count)| (fault.name().to_owned(), count.into())).collect();
    let wrong = side.performance.notes.iter().enumerate().filter(|(_, note)| !note.faults().is_empty());
    let listed = wrong.take(LISTED).map(|(n, note)| {
        json!({
            "note": n + 1,
            "key": note.wanted.key,
            "name": note_name(note.wanted.key),
            "written_s": note.wanted.on_s,
            "late_ms": note.late_s().map(|late_s| 1e3 * late_s),
            "louder_by_counts": note.louder,
            "faults": note.faults().into_iter().map(Fault::name).collect::<Vec<_>>(),
            "reasons": note.reasons().iter().map(ToString::to_string).collect::<Vec<_>>(),
        })
    });
    json!({
        "keyboard": side.name,
        "keys": side.performance.dampers.len(),
        "right": all.right,
        "faults": counts,
        "reasons": reasons_json(&all),
        "ceilings": ceilings_json(&side.performance, &score.law),
        "from_home": all.from_home,
        "largest_error_from_home": {"counts": all.home_errors[0], "ms": 1e3 * all.home_errors[1]},
        "largest_error_of_others": {"counts": all.other_errors[0], "ms": 1e3 * all.other_errors[1]},
        "wrong": listed.collect::<Vec<_>>(),
        "trials": all.trials,
        "steps": side.performance.steps,
        "step_s": side.performance.step_s,
    })
}

/// The notes, from 0, that are right on one of two keyboards and wrong on the other; none for one keyboard.
pub(super) fn differing(played: &Played<'_>) -> Vec<usize> {
    let [first, second] = &played.sides[..] else { return Vec::new() };
    let is_right = |side: &Side, n: usize| side.performance.notes[n].faults().is_empty();
    (0..played.score.notes.len()).filter(|&n| is_right(first, n) != is_right(second, n)).collect()
}

/// What became of the notes, a column for each keyboard.
pub(super) fn counts(played: &Played<'_>) -> Table<'static> {
    let all: Vec<Summary> = played.sides.iter().map(|side| side.performance.summary()).collect();
    let row = |name: &str, of: &dyn Fn(&Summary) -> String| {
        std::iter::once(name.to_owned()).chain(all.iter().map(of)).collect::<Vec<_>>()
    };
    let mut rows = vec![row("notes", &|one| one.notes.to_string()), row("as written", &|one| one.right.to_string())];
    let names = ["silent", "sounded twice", "late, > 2 ms", "early, > 2 ms", "soft, > 1 count", "loud, > 1 count"];
    for (index, name) in names.into_iter().enumerate() {
        rows.push(row(name, &|one| one.faults[index].to_string()));
    }
    for (index, name) in Reason::NAMES.into_iter().enumerate() {
        if all.iter().any(|one| one.reasons[index] > 0) {
            rows.push(row(&format!("why: {name}"), &|one| one.reasons[index].to_string()));
        }
    }
    rows.push(row("from home", &|one| one.from_home.to_string()));
    for (whose, home) in [("from home", true), ("others", false)] {
        let errors = |one: &Summary| if home { one.home_errors } else { one.other_errors };
        rows.push(row(&format!("{whose}: largest error, counts"), &|one| decimal(Some(errors(one)[0]), 2)));
        rows.push(row(&format!("{whose}: largest error, ms"), &|one| decimal(Some(1e3 * errors(one)[1]), 2)));
    }
    let heads = std::iter::once(String::new()).chain(played.sides.iter().map(|side| side.name.clone()));
    Table::of(heads, rows)
}

/// Notes that went wrong, at most so many, with reasons where there is room for them; of two keyboards those that are
/// wrong on either.
pub(super) fn wrong(played: &Played<'_>, most: usize, has_room: bool) -> (Table<'static>, usize) {
    let is_wrong = |n: &usize| played.sides.iter().any(|side| !side.performance.notes[*n].faults().is_empty());
    let all: Vec<usize> = (0..played.score.notes.len()).filter(is_wrong).collect();
    let rows = all.iter().take(most).map(|&n| {
        let wanted = &played.score.notes[n];
        let own = [(n + 1).to_string(), note_name(wanted.key), decimal(Some(wanted.on_s), 2)];
        let sides = played.sides.iter().map(|side| {
            let note = &side.performance.notes[n];
            match (faults(note), reasons(note)) {
                (faults, _) if faults.is_empty() => "as written".to_owned(),
                (faults, reasons) if reasons.is_empty() || !has_room => faults,
                (faults, reasons) => format!("{faults}: {reasons}"),
            }
        });
        own.into_iter().chain(sides).collect::<Vec<_>>()
    });
    let heads = ["note", "key", "s"].map(str::to_owned).into_iter().chain(match &played.sides[..] {
        [_] => vec!["what became of it".to_owned()],
        sides => sides.iter().map(|side| side.name.clone()).collect(),
    });
    (Table::of(heads, rows.collect::<Vec<_>>()), all.len())
}

/// Which speeds the hand reached at most, where notes ask for more; empty where none does.
fn ceilings(side: &Side, law: &Law<'_>) -> String {
    let found = side.performance.ceilings();
    let by_speed = |a: &(&usize, &f64), b: &(&usize, &f64)| a.1.total_cmp(b.1);
    let Some((low, high)) = found.iter().min_by(by_speed).zip(found.iter().max_by(by_speed)) else {
        return String::new();
    };
    let one = |(key, speed): (&usize, &f64)| {
        format!("{speed:.2} m/s, velocity {:.0}, {}", law.velocity(*speed).counts(), note_name(*key))
    };
    let keys =
        if found.len() == 1 { "ceiling of a key".to_owned() } else { format!("ceilings of {} keys", found.len()) };
    let range = if found.len() == 1 { one(low) } else { format!("{} to {}", one(low), one(high)) };
    // Rounded down to half a metre per second.
    let within = (2.0 * low.1).floor() / 2.0;
    format!(
        "\n{}: {keys} that a hand reaches: {range}\n  soft by the law of velocities: --law linear:{within} is within their reach\n",
        side.name
    )
}

/// Notes that went wrong among the first lines.
const FIRST: usize = 3;
/// Reasons among them.
const FIRST_REASONS: usize = 3;

/// The first lines: how many notes sound as written on each keyboard, what is wrong with the others, and most often
/// why.
pub(crate) fn headlines(played: &Played<'_>) -> Vec<String> {
    const SAID: [&str; 6] = [
        "silent",
        "sounded twice",
        "late by more than 2 ms",
        "early by more than 2 ms",
        "soft by more than 1 count",
        "loud by more than 1 count",
    ];
    let mut lines = Vec::new();
    for side in &played.sides {
        let all = side.performance.summary();
        let mut line = match (all.right == all.notes, all.notes) {
            (true, 1) => format!("{}: the note sounds as written.", side.name),
            (true, notes) => format!("{}: all {notes} notes sound as written.", side.name),
            (false, notes) => {
                let faults = SAID.iter().zip(all.faults).filter(|(_, count)| *count > 0);
                let faults: Vec<String> = faults.map(|(said, count)| format!("{count} {said}")).collect();
                format!("{}: {} of {notes} notes sound as written; {}.", side.name, all.right, faults.join(", "))
            }
        };
        let mut reasons: Vec<(&str, usize)> =
            Reason::NAMES.into_iter().zip(all.reasons).filter(|(_, count)| *count > 0).collect();
        reasons.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
        reasons.truncate(FIRST_REASONS);
        if !reasons.is_empty() {
            let reasons: Vec<String> = reasons.iter().map(|(name, count)| format!("{name} ({count})")).collect();
            line += &format!(" Most often: {}.", reasons.join(", "));
        }
        lines.push(line);
        lines.extend(ceilings(side, &played.score.law).lines().skip(1).map(str::to_owned));
    }
    if let [side] = &played.sides[..] {
        let [counts, s] = side.performance.summary().home_errors;
        lines.push(format!(
            "A note from a resting key is off by at most {counts:.2} counts of velocity and {:.2} ms.",
            1e3 * s
        ));
        let wrong = side.performance.notes.iter().enumerate().filter(|(_, note)| !note.faults().is_empty());
        lines.extend(wrong.take(FIRST).map(|(n, note)| {
            let (faults, reasons) = (faults(note), reasons(note));
            let why = if reasons.is_empty() { String::new() } else { format!(": {reasons}") };
            format!("  note {}, {} at {:.2} s: {faults}{why}", n + 1, note_name(note.wanted.key), note.wanted.on_s)
        }));
    }
    lines
}

/// What is printed after them.
pub(crate) fn text(played: &Played<'_>) -> String {
    let mut out = format!("{}\n", counts(played).to_string().trim_end());
    for side in &played.sides {
        out += &ceilings(side, &played.score.law);
    }
    let (table, count) = wrong(played, PRINTED, played.sides.len() == 1);
    if count > 0 {
        out += &format!("\n{}\n", table.to_string().trim_end());
        if count > PRINTED {
            out += &format!("  {} more are in the table of notes\n", count - PRINTED);
        }
        if played.sides.len() > 1 {
            out += "  why: in the tables of notes and in play.html\n";
        }
    }
    out
}
