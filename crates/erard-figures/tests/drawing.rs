//! The drawing is the model: where the mechanics has two felts meet, the picture has two outlines meet.
//!
//! The drawn side is read from the text of the SVG, its paths and transforms, by the parser below, which knows nothing
//! of the code that wrote it. The computed side is the engine's contact point in a run, or, where a zone is nearly
//! closed, worked out here from the file's geometry.

use erard::instrument::{Body, Curve, Instrument, InstrumentFile, Vec2, Zone};
use erard::keyboard::Keyboard;
use erard::run::Run;
use erard::run::{Setup, simulate};
use erard::stroke::{Series, Touch};
use erard_figures::drawing::{PoseOptions, angles_at, drawing, pose_picture};
use moreau::Settings;
use std::collections::BTreeMap;

/// Poses of an instrument that are looked at.
const POSES: usize = 20;
/// What is asked of the picture, mm.
const CLOSE_MM: f64 = 0.2;
/// A zone that is no further open than this is compared, m: what is further open does not touch, and a line of the
/// mechanics is endless where a felt is not.
const NEARLY_CLOSED_M: f64 = 0.5e-3;

/// Which outline shows which side of which zone.
const SHOWN: [(&str, &str, &str); 17] = [
    ("key_front", "key", "front punching"),
    ("balance_rail", "key", "balance rail, punching"),
    ("key_back_rail", "key", "back rail cloth"),
    ("capstan_heel", "capstan", "heel cushion"),
    ("jack_knuckle", "knuckle", "jack"),
    ("lever_knuckle", "knuckle", "repetition lever"),
    ("let_off_button", "jack", "let-off button, felt"),
    ("jack_rest", "jack", "whippen, spoon felt"),
    ("lever_stop", "repetition lever", "whippen, lever stop felt"),
    ("drop_screw", "repetition lever, leather", "drop screw"),
    ("string", "hammer felt", "string"),
    ("check", "hammer moulding, tail", "back check, leather"),
    ("hammer_rest", "hammer shank", "whippen, hammer rest"),
    ("key_damper", "damper lever", "key, damper felt"),
    ("damper_rest", "damper lever", "damper lever, rest felt"),
    ("damper_stop", "damper lever, top", "damper stop rail, felt"),
    ("jack_stop", "jack, front", "whippen, window felt"),
];

/// Every outline of a picture as closed polygons in the world, mm, y up, by name.
fn outlines(svg: &str) -> BTreeMap<String, Vec<Vec<Vec2>>> {
    let mut out: BTreeMap<String, Vec<Vec<Vec2>>> = BTreeMap::new();
    for element in svg.split("<path ").skip(1) {
        let (head, rest) = element.split_once('>').unwrap();
        let Some(name) = rest.strip_prefix("<title>").and_then(|rest| rest.split("</title>").next()) else { continue };
        let attribute = |name: &str| Some(head.split_once(&format!("{name}=\""))?.1.split('"').next().unwrap());
        let numbers = |text: &str| -> Vec<f64> {
            let text = text.replace(|c: char| c.is_alphabetic() || "(),".contains(c), " ");
            text.split_whitespace().map(|number| number.parse().unwrap()).collect()
        };
        let [x, y, degrees] = match attribute("transform") {
            Some(text) => {
                assert!(text.starts_with("translate(") && text.contains(") rotate("), "{text}");
                numbers(text).try_into().unwrap()
            }
            None => [0.0; 3],
        };
        let (sin, cos) = degrees.to_radians().sin_cos();
        let world = |p: Vec2| [x + cos * p[0] - sin * p[1], -(y + sin * p[0] + cos * p[1])];
        let mut corners: Vec<Vec2> = Vec::new();
        let path = attribute("d").unwrap();
        for command in
            path.split_inclusive(|_| true).collect::<String>().replace(['M', 'L'], "|L").replace('Q', "|Q").split('|')
        {
            let values = numbers(command);
            match (command.chars().next(), &values[..]) {
                (Some('L'), [x, y]) => corners.push([*x, *y]),
                (Some('Q'), [cx, cy, x, y]) => {
                    let from = *corners.last().unwrap();
                    for step in 1..=16 {
                        let t = f64::from(step) / 16.0;
                        let blend =
                            |a: f64, b: f64, c: f64| (1.0 - t) * (1.0 - t) * a + 2.0 * t * (1.0 - t) * b + t * t * c;
                        corners.push([blend(from[0], *cx, *x), blend(from[1], *cy, *y)]);
                    }
                }
                (None, _) => {}
                other => panic!("{other:?} in {path}"),
            }
        }
        out.entry(name.to_owned()).or_default().push(corners.into_iter().map(world).collect());
    }
    out
}

/// Distance from a point to the nearest of some closed polygons, mm.
fn distance(polygons: &[Vec<Vec2>], point: Vec2) -> f64 {
    let to_edge = |a: Vec2, b: Vec2| {
        let way = [b[0] - a[0], b[1] - a[1]];
        let square = way[0] * way[0] + way[1] * way[1];
        let along = (point[0] - a[0]) * way[0] + (point[1] - a[1]) * way[1];
        let share = if square > 0.0 { (along / square).clamp(0.0, 1.0) } else { 0.0 };
        (a[0] + share * way[0] - point[0]).hypot(a[1] + share * way[1] - point[1])
    };
    let edges = polygons.iter().flat_map(|p| (0..p.len()).map(move |i| (p[i], p[(i + 1) % p.len()])));
    edges.map(|(a, b)| to_edge(a, b)).fold(f64::INFINITY, f64::min)
}

fn turned([x, y]: Vec2, angle: f64) -> Vec2 {
    let (sin, cos) = angle.sin_cos();
    [cos * x - sin * y, sin * x + cos * y]
}

/// A point of a body in the world, from the file's pivots and absolute angles alone.
fn world(instrument: &Instrument, angles: &[f64], body: Option<usize>, point: Vec2) -> Vec2 {
    let Some(index) = body else { return point };
    let Body { parent, pivot_m, .. } = instrument.bodies[index];
    let [x, y] = turned(point, angles[index]);
    let pivot = world(instrument, angles, parent, pivot_m);
    [pivot[0] + x, pivot[1] + y]
}

/// The two witness points of a zone (on the disc, on the curve), m in the world, and how far it is open, m.
fn witnesses(instrument: &Instrument, zone: &Zone, angles: &[f64]) -> ([Vec2; 2], f64) {
    let center = world(instrument, angles, zone.disc_body, zone.disc_center_m);
    let of_curve = |p| world(instrument, angles, zone.curve_body, p);
    let turn = zone.curve_body.map_or(0.0, |body| angles[body]);
    let (foot, normal) = match zone.curve {
        Curve::Line { point_m, normal } => {
            let (at, n) = (of_curve(point_m), turned(normal, turn));
            let height = (center[0] - at[0]) * n[0] + (center[1] - at[1]) * n[1];
            ([center[0] - height * n[0], center[1] - height * n[1]], n)
        }
        Curve::Segment { from_m, to_m, rounding_m } => {
            let (a, b) = (of_curve(from_m), of_curve(to_m));
            let way = [b[0] - a[0], b[1] - a[1]];
            let share =
                ((center[0] - a[0]) * way[0] + (center[1] - a[1]) * way[1]) / (way[0] * way[0] + way[1] * way[1]);
            let core = [0, 1].map(|k| a[k] + share.clamp(0.0, 1.0) * way[k]);
            let away = [center[0] - core[0], center[1] - core[1]];
            let n = away.map(|c| c / away[0].hypot(away[1]));
            ([core[0] + rounding_m * n[0], core[1] + rounding_m * n[1]], n)
        }
        Curve::Disc { .. } => panic!("{}: a grand has no disc on this side", zone.name),
    };
    let on_disc = [0, 1].map(|k| center[k] - zone.disc_radius_m * normal[k]);
    let open = (on_disc[0] - foot[0]) * normal[0] + (on_disc[1] - foot[1]) * normal[1];
    ([on_disc, foot], open)
}

/// What one instrument's pictures were found to be off by.
#[derive(Default)]
struct Found {
    /// By zone: how often it was compared, and the largest distance, mm.
    zones: BTreeMap<String, (usize, f64)>,
}

impl Found {
    /// Compares all zones that touch, or nearly, in one pose. `engine` gives the contact point of a zone that pushes.
    fn compare(&mut self, instrument: &Instrument, angles: &[f64], engine: &dyn Fn(usize) -> Option<Vec2>) {
        let drawn = outlines(&pose_picture(instrument, angles, &PoseOptions::default()).svg());
        for (index, zone) in instrument.zones.iter().enumerate() {
            let &(_, disc, curve) = SHOWN.iter().find(|(name, _, _)| *name == zone.name).expect("a grand's zone");
            let ([on_disc, mut on_curve], open) = witnesses(instrument, zone, angles);
            if let Some(point) = engine(index) {
                // The engine's own point; what was worked out here must be the same, or this test compares nothing.
                let off = (point[0] - on_curve[0]).hypot(point[1] - on_curve[1]);
                assert!(off < 5e-5, "{}: the engine's contact lies {:.3} mm from the geometry's", zone.name, off * 1e3);
                on_curve = point;
            } else if open > NEARLY_CLOSED_M {
                continue;
            }
            for (point, name) in [(on_disc, disc), (on_curve, curve)] {
                let Some(polygons) = drawn.get(name) else { continue };
                let off = distance(polygons, point.map(|c| 1e3 * c));
                let entry = self.zones.entry(zone.name.clone()).or_default();
                *entry = (entry.0 + 1, entry.1.max(off));
            }
        }
    }

    /// Turns the disc's body until a zone that never closed in a run just touches, from the drawn pose.
    fn close(&mut self, instrument: &Instrument, zone: usize) {
        let drawn: Vec<f64> = instrument.bodies.iter().map(|body| body.angle_rad).collect();
        let zone = &instrument.zones[zone];
        let body = zone.disc_body.or(zone.curve_body).unwrap();
        let open = |turn: f64| {
            let mut angles = drawn.clone();
            angles[body] += turn;
            (witnesses(instrument, zone, &angles).1, angles)
        };
        let crossing =
            (1..400).flat_map(|k| [f64::from(k) * 1e-3, -f64::from(k) * 1e-3]).find(|turn| open(*turn).0 < 0.0);
        let (mut out, mut on) = (0.0, crossing.unwrap_or_else(|| panic!("{} can be closed", zone.name)));
        for _ in 0..60 {
            let middle = 0.5 * (out + on);
            if open(middle).0 < 0.0 { on = middle } else { out = middle }
        }
        self.compare(instrument, &open(on).1, &|_| None);
    }

    fn tell(&self, name: &str) -> f64 {
        let (zone, (_, worst)) = self.zones.iter().max_by(|a, b| a.1.1.total_cmp(&b.1.1)).unwrap();
        let count: usize = self.zones.values().map(|(count, _)| count).sum();
        println!("{name}: {count} points of {} zones, largest distance {worst:.3} mm ({zone})", self.zones.len());
        for (zone, (count, worst)) in &self.zones {
            println!("    {zone:16} {count:3} points, {worst:.3} mm");
        }
        *worst
    }
}

fn played(instrument: &Instrument) -> Run {
    let stroke = Series::builtin("mf", Touch::Pressed).unwrap();
    let setup = Setup {
        settings: Settings::new(50e-6),
        start_s: stroke.start_s(),
        record_every: Some(4),
        ledger: false,
        ..Setup::new(stroke.end_s() - stroke.start_s() + 0.2)
    };
    let force = stroke.force.as_ref().unwrap().drive();
    simulate(instrument, &|t| erard::player::Input::Force(force(t)), &setup, &mut |_| true).unwrap()
}

/// The frame in which every zone pushes hardest, and frames spread over the run up to twenty in all.
fn frames(run: &Run) -> Vec<usize> {
    let last = run.time_s.len() - 1;
    let hardest = |series: &[f64]| (0..series.len()).max_by(|a, b| series[*a].total_cmp(&series[*b])).unwrap();
    let mut out: Vec<usize> = run.zones.iter().map(|zone| hardest(&zone.normal_n)).collect();
    out.push(0);
    let mut k = 1;
    while {
        out.sort_unstable();
        out.dedup();
        out.len() < POSES
    } {
        // A sequence that fills the run evenly however long it gets.
        out.push((last as f64 * (f64::from(k) * 0.618_033_988_75).fract()) as usize);
        k += 1;
    }
    out.truncate(POSES);
    out
}

/// The concert grand after a designer's afternoon: capstan, heel, knuckle, button, drop screw, toe, check, string,
/// bore, key, shank, damper moved.
fn moved() -> Instrument {
    let mut text = Instrument::builtin_text("concert-grand").unwrap().to_owned();
    for (was, is) in [
        ("[142.23, 18.32]", "[132.23, 21.1]"),
        ("radius_mm = { value = 10,", "radius_mm = { value = 7,"),
        ("value = [17, -4.8]", "value = [18.5, -5.6]"),
        ("radius_mm = { value = 5,", "radius_mm = { value = 4.6,"),
        ("value = [-265, 0]", "value = [-225, 1]"),
        ("value = [-265, -9.18]", "value = [-225, -7]"),
        ("value = [-265, 22]", "value = [-225, 23]"),
        ("value = [249.14, 68.6]", "value = [242.2, 67.6]"),
        ("value = [251, 155.5]", "value = [245, 158.5]"),
        ("value = [70, 48]", "value = [63, 51]"),
        ("value = [73, -15]", "value = [66, -14]"),
        ("value = [-24, 4]", "value = [-26, 3.6]"),
        ("value = [-54, 22]", "value = [-55.5, 22.3]"),
        ("value = [235, 17.6]", "value = [232, 18.1]"),
        ("value = [20, -3]", "value = [22, -3.1]"),
    ] {
        assert!(text.contains(was), "{was}");
        text = text.replace(was, is);
    }
    InstrumentFile::parse(&text, "moved.toml").unwrap().instrument
}

#[test]
fn what_touches_is_drawn_touching() {
    let keyboard = Keyboard::builtin("concert-grand").unwrap();
    let builtin = |name: &str| Instrument::builtin(name).unwrap();
    let mut turned = builtin("concert-grand");
    for screw in 0..turned.screws.len() {
        let by = if matches!(
            turned.screws[screw].action,
            erard::instrument::ScrewAction::Disc { .. } | erard::instrument::ScrewAction::Curve { .. }
        ) {
            0.5e-3
        } else {
            0.02
        };
        let _ = turned.turn(screw, by);
    }
    let six = [
        ("concert grand", builtin("concert-grand")),
        ("heavy touch", builtin("heavy-touch")),
        ("Steinway-like", builtin("steinway-o")),
        ("key 1", keyboard.key(1).unwrap()),
        ("key 88", keyboard.key(88).unwrap()),
        ("moved", moved()),
        ("all screws turned", turned),
    ];
    let mut worst: f64 = 0.0;
    // Bending as they ship, and as rigid parts.
    let rigid = six.clone().map(|(name, instrument)| (name, instrument.locked()));
    for (name, instrument) in six.into_iter().chain(rigid) {
        let run = played(&instrument);
        let mut found = Found::default();
        for frame in frames(&run) {
            let contact = |zone: usize| {
                let series = &run.zones[zone];
                let [x, y, ..] = series.contact[frame].map(f64::from);
                (series.normal_n[frame] > 0.0).then_some([x, y])
            };
            found.compare(&instrument, &angles_at(&run, frame), &contact);
        }
        let unseen = drawing(&instrument).unseen;
        for (index, zone) in instrument.zones.iter().enumerate() {
            let is_seen = ![zone.disc_body, zone.curve_body].iter().flatten().any(|body| unseen.contains(body));
            if is_seen && !found.zones.contains_key(&zone.name) {
                found.close(&instrument, index);
            }
            assert_eq!(is_seen, found.zones.contains_key(&zone.name), "{name}: {}", zone.name);
        }
        worst = worst.max(found.tell(name));
    }
    println!("largest distance {worst:.3} mm");
    assert!(worst < CLOSE_MM, "{worst:.3} mm");
}
