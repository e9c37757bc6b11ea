//! A piano roll: what was written beside what sounded.

use std::fmt::Write;

use crate::svg::{number, sides, text};

/// Height of a key's row, and what stands above and left of the rows, px.
const ROW_PX: f64 = 8.0;
const TOP_PX: f64 = 18.0;
const LEFT_PX: f64 = 34.0;
/// Width of a second, px: the least, and the most, which a short piece takes to be as wide as a page. A piece that
/// would be wider than the widest has narrower seconds.
const SECOND_PX: [f64; 2] = [60.0, 600.0];
const PAGE_PX: f64 = 860.0;
const MAX_WIDTH_PX: f64 = 60_000.0;
/// A note is drawn this wide at least, px.
const LEAST_PX: f64 = 1.5;
/// So many notes are drawn; those that went wrong before all others.
const MAX_NOTES: usize = 20_000;

/// Outcome of a note.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RollKind {
    /// Sounded as written.
    Right,
    /// It sounded otherwise than written.
    Otherwise,
    /// It did not sound.
    Silent,
}

/// A note of a roll.
#[derive(Debug, Clone, PartialEq)]
pub struct RollNote {
    /// The key, from 1.
    pub key: usize,
    /// When it is written to begin and to end, s.
    pub written_s: [f64; 2],
    /// When it did.
    pub sounded_s: Option<[f64; 2]>,
    /// Outcome of the note.
    pub kind: RollKind,
    /// The text beside a pointer that rests on it.
    pub words: String,
    /// A page about it, if there is one.
    pub link: Option<String>,
}

/// The style of rolls; colours are those of the page they stand in, [`crate::HOUSE_STYLE`].
pub const ROLL_STYLE: &str = include_str!("roll.css");

/// The roll as an SVG for a page: one row for each key from the lowest to the highest, an outline where a note is
/// written, a bar where it sounded, a cross where it did not. `name_of` names a key.
#[must_use]
pub fn roll_svg(title: &str, notes: &[RollNote], duration_s: f64, name_of: &dyn Fn(usize) -> String) -> String {
    let lowest = notes.iter().map(|note| note.key).min().unwrap_or(40).saturating_sub(1).max(1);
    let highest = notes.iter().map(|note| note.key).max().unwrap_or(40) + 1;
    let [least, most] = SECOND_PX;
    let px_s = (PAGE_PX / duration_s.max(1.0)).clamp(least, most).min(MAX_WIDTH_PX / duration_s.max(1.0));
    let width = LEFT_PX + px_s * duration_s + 12.0;
    let bottom = TOP_PX + ROW_PX * (highest - lowest + 1) as f64;
    let top_of = |key: usize| TOP_PX + ROW_PX * (highest - key) as f64;
    let mut out = format!(
        "<svg class=\"roll\" role=\"{role}\" xmlns=\"http://www.w3.org/2000/svg\" width=\"{w}\" height=\"{h}\" viewBox=\"0 0 {w} {h}\"><title>",
        // A picture that holds links is a group of them.
        role = if notes.iter().any(|note| note.link.is_some()) { "group" } else { "img" },
        w = number(width),
        h = number(bottom + 4.0)
    );
    out.push_str(&crate::svg::escape(title));
    out.push_str("</title>");
    for key in lowest..=highest {
        let name = name_of(key);
        if name.contains('#') {
            let _ = write!(out, "<rect class=\"sharp\"{}/>", sides([LEFT_PX, top_of(key), width - LEFT_PX, ROW_PX]));
        }
        // C and F: the lines of a keyboard that one finds one's way by.
        if name.starts_with('C') && !name.contains('#') {
            text(&mut out, "key", [LEFT_PX - 4.0, top_of(key) + ROW_PX - 1.0], " text-anchor=\"end\"", &name);
        }
    }
    // Not more marks than can be read.
    let every =
        [0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 30.0, 60.0, 300.0].into_iter().find(|s| s * px_s >= 50.0).unwrap_or(600.0);
    for n in 0..=(duration_s / every) as usize {
        let x = LEFT_PX + px_s * every * n as f64;
        let _ = write!(out, "<path class=\"tick\" d=\"M{x} {TOP_PX}V{b}\"/>", x = number(x), b = number(bottom));
        text(&mut out, "time", [x + 2.0, TOP_PX - 5.0], "", &format!("{} s", number(every * n as f64)));
    }
    let wrong = notes.iter().filter(|note| note.kind != RollKind::Right).take(MAX_NOTES);
    let room = MAX_NOTES.saturating_sub(notes.iter().filter(|note| note.kind != RollKind::Right).count());
    let right = notes.iter().filter(|note| note.kind == RollKind::Right).take(room);
    for note in right.chain(wrong) {
        draw(&mut out, note, top_of(note.key), px_s);
    }
    out.push_str("</svg>");
    out
}

fn draw(out: &mut String, note: &RollNote, top: f64, px_s: f64) {
    let class = match note.kind {
        RollKind::Right => "right",
        RollKind::Otherwise => "otherwise",
        RollKind::Silent => "silent",
    };
    let across = |[from_s, to_s]: [f64; 2]| [LEFT_PX + px_s * from_s, (px_s * (to_s - from_s)).max(LEAST_PX)];
    if let Some(link) = &note.link {
        let _ = write!(out, "<a href=\"{}\">", crate::svg::escape(link));
    }
    let _ = write!(out, "<g class=\"{class}{}\">", if note.link.is_some() { " linked" } else { "" });
    let [x, w] = across(note.written_s);
    let _ = write!(out, "<rect class=\"written\"{}/>", sides([x, top + 0.5, w, ROW_PX - 1.0]));
    match note.sounded_s {
        Some(sounded_s) => {
            let [x, w] = across(sounded_s);
            let _ = write!(out, "<rect class=\"sounded\"{}/>", sides([x, top + 2.0, w, ROW_PX - 4.0]));
        }
        None => {
            let [a, b] = [top, top + ROW_PX].map(number);
            let [l, r] = [x, x + ROW_PX].map(number);
            let _ = write!(out, "<path class=\"cross\" d=\"M{l} {a}L{r} {b}M{l} {b}L{r} {a}\"/>");
        }
    }
    let _ = write!(out, "<title>{}</title></g>", crate::svg::escape(&note.words));
    if note.link.is_some() {
        out.push_str("</a>");
    }
}
