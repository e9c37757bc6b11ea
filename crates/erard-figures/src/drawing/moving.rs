//! A run as a picture that moves: one drawing of the action, and an animation in CSS for each body. It moves wherever a
//! browser shows it, as a picture, too. For readers who ask their system for less motion it stands still.

use std::fmt::Write;

use erard::instrument::{Instrument, Placement};
use erard::run::Run;

use super::{Carrier, PoseOptions, angles_at, carried, drawing, outline, shapes_carried, view};
use crate::picture::{Carried, Geometry, Shape, Turn, Words};

/// A part of a run, slowed.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Stage {
    from_s: f64,
    to_s: f64,
    /// How many times slower than it is.
    slower: f64,
    /// For which the picture stands still afterwards, s.
    pause_s: f64,
}

/// Before the key starts, s.
const BEFORE_S: f64 = 0.004;
/// Around the impact, s: before and after it.
const IMPACT_S: [f64; 2] = [0.008, 0.02];
/// After the check or the key's bottom, s.
const SETTLED_S: f64 = 0.03;
/// Before and after the key is let go, s.
const RELEASE_S: [f64; 2] = [0.01, 0.24];
/// Of a run without an impact, s.
const NO_IMPACT_S: f64 = 0.4;
/// Slowness of the impact, and of the release.
const SLOWEST: f64 = 80.0;
const RELEASE_SLOWER: f64 = 10.0;
/// The way up lasts no longer than this, s, and is not slower than the second number.
const WAY_UP: (f64, f64) = (3.0, 30.0);
/// Slownesses that people can imagine.
const NICE: [f64; 6] = [1.0, 2.0, 5.0, 10.0, 20.0, 30.0];
/// Between two poses, s of the picture.
const POSE_S: f64 = 0.06;
/// Of a jump over what is left out, s.
const JUMP_S: f64 = 0.01;
/// A coordinate that lies so near to the line between its neighbours, mm or degrees, is left out.
const FLAT: f64 = 0.01;

/// The parts of a run that are shown.
fn stages(run: &Run) -> Vec<Stage> {
    let (Some(first), Some(last)) = (run.time_s.first(), run.time_s.last()) else { return Vec::new() };
    let within = |time_s: f64| time_s.clamp(*first, *last);
    let events = &run.events;
    let begins = within(events.key_start_s.unwrap_or(*first) - BEFORE_S);
    let mut stages = Vec::new();
    let settled = match events.hammer_contact_s() {
        Some(impact) => {
            let [from, to] = [within((impact - IMPACT_S[0]).max(begins)), within(impact + IMPACT_S[1])];
            let slower = NICE.into_iter().rev().find(|slower| slower * (from - begins) <= WAY_UP.0);
            let slower = slower.unwrap_or(1.0).min(WAY_UP.1);
            stages.push(Stage { from_s: begins, to_s: from, slower, pause_s: 0.0 });
            stages.push(Stage { from_s: from, to_s: to, slower: SLOWEST, pause_s: 0.0 });
            let ends = [events.check_s, events.key_bottom_s].into_iter().flatten().fold(to, f64::max);
            let ends = within((ends + SETTLED_S).min(to + NO_IMPACT_S));
            stages.push(Stage { from_s: to, to_s: ends, slower: WAY_UP.1, pause_s: 0.8 });
            ends
        }
        None => {
            let ends = within(begins + NO_IMPACT_S);
            stages.push(Stage { from_s: begins, to_s: ends, slower: RELEASE_SLOWER, pause_s: 0.8 });
            ends
        }
    };
    // The key is let go where it was last nearly as far down as it ever was.
    let deepest = run.key_m.iter().copied().fold(0.0, f64::max);
    let down = run.key_m.iter().rposition(|key_m| *key_m > 0.9 * deepest).map(|row| run.time_s[row]);
    if let Some(down) = down.filter(|down| deepest > 0.0 && *down < last - RELEASE_S[0]) {
        let [from, to] = [within((down - RELEASE_S[0]).max(settled)), within(down + RELEASE_S[1])];
        stages.push(Stage { from_s: from, to_s: to, slower: RELEASE_SLOWER, pause_s: 0.6 });
    }
    stages.retain(|stage| stage.to_s > stage.from_s);
    stages
}

/// Poses of the picture: rows of the run, when each is shown, s; when each stage begins and ends, s; the length, s.
struct Timeline {
    rows: Vec<usize>,
    shown_s: Vec<f64>,
    stages_s: Vec<[f64; 2]>,
    length_s: f64,
}

impl Timeline {
    fn of(run: &Run, stages: &[Stage]) -> Self {
        let row = |time_s: f64| run.time_s.partition_point(|t| *t < time_s).min(run.time_s.len().saturating_sub(1));
        let mut line = Timeline { rows: Vec::new(), shown_s: Vec::new(), stages_s: Vec::new(), length_s: 0.0 };
        let mut before: Option<f64> = None;
        for stage in stages {
            let began = line.length_s;
            if before.is_some_and(|to| to < stage.from_s) {
                line.length_s += JUMP_S;
            }
            let lasts = (stage.to_s - stage.from_s) * stage.slower;
            let count = (lasts / POSE_S).ceil().max(1.0);
            for at in 0..=count as usize {
                let share = at as f64 / count;
                line.rows.push(row(stage.from_s + (stage.to_s - stage.from_s) * share));
                line.shown_s.push(line.length_s + lasts * share);
            }
            line.length_s += lasts + stage.pause_s;
            if stage.pause_s > 0.0 {
                line.rows.push(row(stage.to_s));
                line.shown_s.push(line.length_s);
            }
            line.stages_s.push([began, line.length_s]);
            before = Some(stage.to_s);
        }
        line
    }

    /// An instant as CSS writes it, per cent.
    fn percent(&self, shown_s: f64) -> String {
        short(100.0 * shown_s / self.length_s)
    }
}

/// A number in hundredths, as short as CSS takes it.
fn short(number: f64) -> String {
    let text = format!("{number:.2}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    match text {
        "-0" | "" => "0".to_owned(),
        text => text.replacen("0.", ".", usize::from(text.trim_start_matches('-').starts_with("0."))),
    }
}

/// The keyframes of a body: poses without those that lie on the line between the ones beside them.
fn keyframes(turns: &[Turn], line: &Timeline) -> String {
    let numbers = |turn: &Turn| [turn.to[0], turn.to[1], turn.degrees];
    let mut keys = String::new();
    let mut kept: Option<usize> = None;
    for (n, turn) in turns.iter().enumerate() {
        let is_flat = kept.zip(turns.get(n + 1)).is_some_and(|(kept, next)| {
            // All poses left out since the one that was kept.
            let (from, to) = (numbers(&turns[kept]), numbers(next));
            let span = line.shown_s[n + 1] - line.shown_s[kept];
            (kept + 1..=n).all(|between| {
                let share = (line.shown_s[between] - line.shown_s[kept]) / span;
                let own = numbers(&turns[between]);
                (0..3).all(|k| (from[k] + share * (to[k] - from[k]) - own[k]).abs() < FLAT)
            })
        });
        if is_flat {
            continue;
        }
        let [x, y, angle] = numbers(turn).map(short);
        let at = line.percent(line.shown_s[n]);
        // Writing to a string does not fail.
        let _ = write!(keys, "{at}%{{transform:translate({x}px,{y}px)rotate({angle}deg)}}");
        kept = Some(n);
    }
    keys
}

/// The run as a moving picture, an SVG file with its words below: the impact most slowed, the way to it and the release
/// less; what lies between is left out. A run without rows stands still.
#[must_use]
pub fn moving_svg(instrument: &Instrument, run: &Run, title: &str) -> String {
    let stages = stages(run);
    let line = Timeline::of(run, &stages);
    let places: Vec<Vec<Placement>> =
        line.rows.iter().map(|row| instrument.placements(&angles_at(run, *row))).collect();
    let drawing = drawing(instrument);
    let first = places.first().cloned().unwrap_or_else(|| instrument.drawn());
    let mut bounds = view(instrument, &drawing.pieces, &first);
    for placed in &places {
        let other = view(instrument, &drawing.pieces, placed);
        bounds = [bounds[0].min(other[0]), bounds[1].min(other[1]), bounds[2].max(other[2]), bounds[3].max(other[3])];
    }
    // A class for each way to move.
    let mut moving: Vec<(Carrier, String)> = Vec::new();
    let carriers = drawing.pieces.iter().map(|piece| piece.carrier);
    for carrier in carriers.chain(drawing.pins.iter().map(|body| Carrier::Body(*body))) {
        if carrier.body().is_none() || moving.iter().any(|(known, _)| *known == carrier) {
            continue;
        }
        let turns: Vec<Turn> = places.iter().map(|placed| outline::turn(&carrier.placement(placed))).collect();
        if turns.iter().any(|turn| *turn != turns[0]) {
            moving.push((carrier, keyframes(&turns, &line)));
        }
    }
    let with_class = |carrier: &Carrier| {
        let own = carried(carrier, &first);
        let data = moving.iter().position(|(known, _)| known == carrier).map(|k| format!(" class=\"m{k}\""));
        Carried { data: data.unwrap_or_default(), ..own }
    };
    let options = PoseOptions { caption: Some(String::new()), ..PoseOptions::default() };
    let mut picture =
        super::pose_picture(instrument, &angles_at(run, line.rows.first().copied().unwrap_or(0)), &options);
    let [left, top, right, bottom] = bounds;
    let size = [right - left, bottom - top + super::CAPTION];
    picture.head.view = [left, top, size[0], size[1]];
    let pixels = options.size_px / size[0].max(size[1]);
    picture.head.size_px = size.map(|side| (pixels * side).round());
    picture.nodes = vec![Shape::of_class("paper", Geometry::rect(picture.head.view))];
    picture.nodes.extend(shapes_carried(&drawing, &with_class));
    let mut style = String::new();
    let length = short(line.length_s);
    for (k, (_, keys)) in moving.iter().enumerate() {
        let _ = writeln!(style, ".m{k}{{animation:m{k} {length}s linear infinite}}@keyframes m{k}{{{keys}}}");
    }
    for (n, (stage, [on, off])) in stages.iter().zip(&line.stages_s).enumerate() {
        let slower =
            if stage.slower > 1.0 { format!(", {} times slower than it is", stage.slower) } else { String::new() };
        let at = [left + 6.0, bottom + 5.0];
        picture.nodes.push(Words::node(format!("caption t{n}"), at, [], &format!("{title}{slower}")));
        let [on, off] = [on, off].map(|shown_s| line.percent(*shown_s));
        let hidden = if n == 0 { String::new() } else { format!("0%,{on}%{{opacity:0}}") };
        let _ = writeln!(
            style,
            ".t{n}{{opacity:0;animation:t{n} {length}s step-end infinite}}@keyframes t{n}{{{hidden}{on}%{{opacity:1}}\
             {off}%,to{{opacity:0}}}}"
        );
    }
    style.push_str("@media (prefers-reduced-motion:reduce){*{animation:none!important}.t0{opacity:1}}");
    picture.svg().replacen("</style>", &format!("{style}</style>"), 1)
}

#[cfg(test)]
mod tests {
    use erard::player::Input;
    use erard::run::{Setup, simulate};

    use super::*;

    #[test]
    fn numbers_are_short() {
        assert_eq!([0.0, -0.001, 0.5, -0.25, 10.0, 1.204].map(short), ["0", "0", ".5", "-.25", "10", "1.2"]);
    }

    /// What lies on the line between its neighbours is left out, and nothing else.
    #[test]
    fn keyframes_follow_the_motion() {
        let line =
            Timeline { rows: vec![0; 5], shown_s: vec![0.0, 1.0, 2.0, 3.0, 4.0], stages_s: Vec::new(), length_s: 4.0 };
        let turns = [0.0, 1.0, 2.0, 2.0, 2.0].map(|degrees| Turn { to: [0.0, 0.5], degrees });
        let keys = keyframes(&turns, &line);
        let at: Vec<&str> = keys.split('}').filter_map(|key| Some(key.split_once('{')?.0)).collect();
        assert_eq!(at, ["0%", "50%", "100%"], "{keys}");
        assert!(keys.contains("50%{transform:translate(0px,.5px)rotate(2deg)}"), "{keys}");
    }

    fn played(instrument: &Instrument, force_n: f64, duration_s: f64) -> Run {
        simulate(instrument, &|_| Input::Force(force_n), &Setup::new(duration_s), &mut |_| true).unwrap()
    }

    /// A held note has three stages, the impact slowest; one without an impact has a single one.
    #[test]
    fn a_note_is_shown_in_stages() {
        let instrument = Instrument::builtin("concert-grand").unwrap();
        let held = played(&instrument, 5.0, 0.12);
        let shown = stages(&held);
        assert_eq!(shown.iter().map(|stage| stage.slower).collect::<Vec<_>>(), [30.0, 80.0, 30.0]);
        let impact = held.events.hammer_contact_s().unwrap();
        assert!(shown[1].from_s < impact && impact < shown[1].to_s, "{shown:?}");
        assert!(shown.windows(2).all(|pair| pair[0].to_s <= pair[1].from_s), "{shown:?}");
        let svg = moving_svg(&instrument, &held, "<a> & b");
        for sign in
            ["@keyframes m0{0%{", "@keyframes t2{", "prefers-reduced-motion", "80 times slower", "&lt;a&gt; &amp; b"]
        {
            assert!(svg.contains(sign), "{sign}");
        }
        assert!(!svg.contains("NaN") && svg.len() < 400_000, "{}", svg.len());
        // Every class has its animation.
        let classes = svg.matches(" class=\"m").count();
        assert!(classes > 10, "{classes}");
        let soft = played(&instrument, 0.3, 0.05);
        assert_eq!(stages(&soft).len(), 1);
    }
}
