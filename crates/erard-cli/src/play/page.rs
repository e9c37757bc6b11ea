//! The page of a performance: its roll, and what went wrong.

use erard::keyboard::note_name;
use erard::run::Run;
use erard_figures::page::audio;
use erard_figures::roll::{ROLL_STYLE, RollKind, RollNote, roll_svg};
use erard_piece::Played as Note;
use erard_workshop::digits::signed;
use maud::{Markup, PreEscaped, html};

use super::report::{counts, differing, faults, reasons, wrong};
use super::{Played, Side};
use crate::paper::page;

const STYLE: &str = include_str!("../paper.css");
const FRAME: &str = ".roll-frame{overflow-x:auto;border:1px solid var(--rule)}";
/// So many notes that went wrong stand on the page.
const LISTED: usize = 300;

/// The page.
pub(crate) fn html(played: &Played<'_>) -> String {
    let title = format!("{} played", played.piece);
    let body = html! {
        header {
            h1 { (title) }
            dl {
                div { dt { "notes" } dd { (played.score.notes.len()) } }
                div { dt { "duration" } dd { (format!("{:.1} s", played.score.duration_s)) } }
            }
        }
        @if played.score.shift_s > 0.0 {
            p { (format!("The whole piece begins {:.2} s later than written, so that the first hand has time to press.", played.score.shift_s)) }
        }
        @for side in &played.sides { (roll(played, side)) }
        p.soft {
            "Outlined: as written. Filled: from the hammer's impact to where the key sets its damper down; blue as written, red \
             otherwise. Crossed: silent. Rest the pointer on a note to read what became of it; a note with a page of its own \
             opens its slow motion."
        }
        h2 { "What became of the notes" }
        div.wide { table { (counts(played).html()) } }
        (lost(played))
        (slow_motions(played))
        @if !played.score.remarks.is_empty() {
            h2 { "What of the file is left out or was mended" }
            @for remark in &played.score.remarks { p { (remark) "." } }
        }
    };
    page(&title, &format!("{STYLE}{FRAME}{ROLL_STYLE}"), &body)
}

fn roll(played: &Played<'_>, side: &Side) -> Markup {
    let link = |n: usize| side.pages.iter().find(|(note, _)| *note == n).map(|(_, page)| page.clone());
    let notes = side.performance.notes.iter().enumerate().map(|(n, note)| RollNote {
        key: note.wanted.key,
        written_s: [note.wanted.on_s, note.wanted.off_s],
        sounded_s: note.impact.map(|[at_s, _]| {
            let until_s = note.released.map_or(note.wanted.off_s, |[off_s, _]| off_s);
            [at_s, until_s.max(at_s)]
        }),
        kind: match note.faults().is_empty() {
            true => RollKind::Right,
            false if note.impact.is_none() => RollKind::Silent,
            false => RollKind::Otherwise,
        },
        words: words(n, note),
        link: link(n),
    });
    let notes: Vec<RollNote> = notes.collect();
    let svg = roll_svg(&format!("Piano roll, {}", side.name), &notes, played.score.duration_s, &note_name);
    html! {
        h2 { (side.name) }
        div.roll-frame tabindex="0" { (PreEscaped(svg)) }
        @if let Some((file, _)) = &side.heard { (PreEscaped(audio(file))) }
    }
}

/// A note as it was written: its number, from 0 in the score and from 1 here, key, instant and velocity.
pub(crate) fn heading(n: usize, note: &Note) -> String {
    format!(
        "note {}, {}, written at {:.3} s with velocity {:.0}",
        n + 1,
        note_name(note.wanted.key),
        note.wanted.on_s,
        note.wanted.velocity.counts()
    )
}

fn words(n: usize, note: &Note) -> String {
    let mut words = heading(n, note);
    if let Some((late_s, louder)) = note.late_s().zip(note.louder) {
        words += &format!("; sounded {} ms later, {} counts louder", signed(1e3 * late_s, 2), signed(louder, 2));
    }
    for more in [faults(note), reasons(note)] {
        if !more.is_empty() {
            words += &format!("; {more}");
        }
    }
    words
}

/// What stands below a note's slow motion.
pub(crate) fn note_lines(note: &Note, run: &Run) -> Vec<(String, String)> {
    let ms = |at: Option<f64>| at.map_or_else(|| "-".to_owned(), |s| format!("{:.2} ms", 1e3 * s));
    let or_as_written = |words: String| if words.is_empty() { "as written".to_owned() } else { words };
    let mut lines = vec![
        ("hammer speed as written".to_owned(), format!("{:.3} m/s", note.wanted.speed_m_per_s)),
        (
            "hammer speed at the string".to_owned(),
            note.impact.map_or_else(|| "- (the string is not reached)".to_owned(), |[_, v]| format!("{v:.3} m/s")),
        ),
        ("later than written".to_owned(), ms(note.late_s())),
        ("what became of it".to_owned(), or_as_written(faults(note))),
        ("force of the hand".to_owned(), format!("{:.2} N", note.force_n)),
        ("the page's 0 s".to_owned(), format!("{:.4} s of the piece", note.pressed_s)),
        ("last push on the knuckle".to_owned(), ms(run.events.let_off_s)),
        ("hammer contact".to_owned(), ms(run.events.hammer_contact_s())),
        ("key bottom".to_owned(), ms(run.events.key_bottom_s)),
        ("check".to_owned(), ms(run.events.check_s)),
    ];
    if !note.reasons().is_empty() {
        lines.insert(4, ("why".to_owned(), reasons(note)));
    }
    lines
}

fn lost(played: &Played<'_>) -> Markup {
    let (table, count) = wrong(played, LISTED, true);
    html! {
        @if count > 0 {
            h2 { "Notes that went wrong, and why" }
            @if played.sides.len() > 1 {
                p { (differing(played).len()) " notes are as written on one of the two keyboards and not on the other." }
            }
            div.wide { table { (table.html()) } }
            @if count > LISTED { p.soft { (count - LISTED) " more are in the table of notes." } }
        }
    }
}

fn slow_motions(played: &Played<'_>) -> Markup {
    html! {
        @if played.sides.iter().any(|side| !side.pages.is_empty()) {
            h2 { "In slow motion" }
            @for side in &played.sides {
                p {
                    @if played.sides.len() > 1 { (side.name) ": " }
                    @for (index, (note, page)) in side.pages.iter().enumerate() {
                        @if index > 0 { ", " }
                        a href=(page) {
                            "note " (note + 1) " (" (note_name(side.performance.notes[*note].wanted.key))
                            @if !side.performance.notes[*note].faults().is_empty() { ", " (faults(&side.performance.notes[*note])) }
                            ")"
                        }
                    }
                }
            }
        }
    }
}
