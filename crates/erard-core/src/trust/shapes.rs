//! Points of an instrument that lie off the bodies they are on.

use moreau::vector::{dot, sub};

use super::{Warning, WarningKind, rounded};
use crate::instrument::{Curve, Instrument, Vec2};

/// Farthest that a point of a body may lie from the rest of the body, over the body's length. The toe of a jack, which
/// stands out, has 0.5, the capstan of a damper 0.6. Of files with numbers changed by factors from 0.5 to 2, a lower
/// bound would doubt more than one in a hundred.
const BODY_LENGTHS: f64 = 0.83;
/// The same for the place of a line that a disc meets, which is as far off as both bodies are drawn: the end of a line
/// is nowhere. The hammer's rest on the whippen has 0.6.
const FOOT_LENGTHS: f64 = 1.0;
/// Farthest that the point whose speed or travel is reported may lie from the contact of the same role (the key's
/// bottom, the string), over the body's length. A key's front has 0.05.
const APART_LENGTHS: f64 = 0.5;
/// Least and farthest distance from its body's pivot of a point whose speed or travel is reported, over the body's
/// radius of gyration about that pivot. The end of a uniform rod has 1.73; a key's front has 1.7, a strike point 1.2.
const GYRATION_RADII: [f64; 2] = [0.5, 2.1];

const KEY_FRONT: &str = "key front";
const STRIKE_POINT: &str = "strike point";

/// What is known of where a body is, in its own frame.
struct Shape {
    /// Pivot, centre of mass, hinges, contacts, roles; with what each is called.
    points: Vec<(String, Vec2)>,
    /// Which of them is a place of a line that a disc meets.
    feet: Vec<usize>,
    /// Radius of gyration about the pivot, m.
    gyration_m: f64,
}

/// The point that lies farthest off its body, of all bodies with their bends locked.
pub(super) fn of_shapes(instrument: &Instrument) -> Option<Warning> {
    let rigid = instrument.locked();
    let shapes = shapes(&rigid);
    let mut worst: Option<(f64, Warning)> = None;
    let mut doubt = |beyond: f64, warning: &dyn Fn() -> Warning| {
        if beyond > 1.0 && worst.as_ref().is_none_or(|(most, _)| beyond > *most) {
            worst = Some((beyond, warning()));
        }
    };
    for (body, shape) in rigid.bodies.iter().zip(&shapes) {
        for (index, (called, _)) in shape.points.iter().enumerate() {
            let Some((off_m, length_m)) = shape.lengths_off(index) else { continue };
            let most_m = length_m * if shape.feet.contains(&index) { FOOT_LENGTHS } else { BODY_LENGTHS };
            let rest = format!("from the rest of the body, which is {} mm long", rounded(length_m * 1e3));
            doubt(off_m / most_m, &|| of_point(&body.name, called, off_m, most_m, &rest));
        }
    }
    let roles = &rigid.roles;
    let reported = [
        (roles.key, roles.key_front_m, KEY_FRONT, roles.key_bottom),
        (roles.hammer, roles.hammer_strike_point_m, STRIKE_POINT, roles.string),
    ];
    for (role, point, called, zone) in reported {
        let Some(body) = role else { continue };
        let (name, gyration_m, off_m) = (&rigid.bodies[body].name, shapes[body].gyration_m, length(point));
        if gyration_m == 0.0 {
            continue;
        }
        let [least_m, most_m] = GYRATION_RADII.map(|radii| radii * gyration_m);
        let is_near = off_m < least_m;
        let (beyond, bound_m) = if is_near { (least_m / off_m, least_m) } else { (off_m / most_m, most_m) };
        let from = format!("from its pivot, where its mass lies {} mm from it", rounded(gyration_m * 1e3));
        doubt(beyond, &|| of_point(name, called, off_m, bound_m, &from));
        let Some(zone) = zone.map(|zone| &rigid.zones[zone]).filter(|zone| zone.disc_body == Some(body)) else {
            continue;
        };
        let (apart_m, most_m) = (length(sub(point, zone.disc_center_m)), APART_LENGTHS * shapes[body].length_m());
        let from = format!("from its contact `{}`", zone.name);
        doubt(apart_m / most_m, &|| of_point(name, called, apart_m, most_m, &from));
    }
    worst.map(|(_, warning)| warning)
}

fn of_point(body: &str, called: &str, off_m: f64, bound_m: f64, from: &str) -> Warning {
    let limit = if off_m < bound_m { "least" } else { "most" };
    Warning {
        kind: WarningKind::PointOffBody,
        what: format!(
            "the {called} of `{body}` lies {} mm {from}; expected at {limit} {} mm",
            rounded(off_m * 1e3),
            rounded(bound_m * 1e3)
        ),
        part: Some(body.to_owned()),
        value: off_m,
        bound: bound_m,
        unit: "m",
        time_s: None,
    }
}

fn shapes(instrument: &Instrument) -> Vec<Shape> {
    let mut shapes: Vec<Shape> = (instrument.bodies.iter())
        .map(|body| Shape {
            points: vec![("pivot".to_owned(), [0.0; 2]), ("centre of mass".to_owned(), body.center_of_mass_m)],
            feet: Vec::new(),
            gyration_m: if body.mass_kg > 0.0 { (body.inertia_kg_m2 / body.mass_kg).sqrt() } else { 0.0 },
        })
        .collect();
    for body in &instrument.bodies {
        if let Some(parent) = body.parent {
            shapes[parent].points.push((format!("pivot of `{}`", body.name), body.pivot_m));
        }
    }
    let drawn = instrument.drawn();
    for zone in &instrument.zones {
        let mut add = |body: Option<usize>, point: Vec2, is_foot: bool| {
            if let Some(body) = body {
                let index = shapes[body].points.len();
                shapes[body].feet.extend(is_foot.then_some(index));
                shapes[body].points.push((format!("contact `{}`", zone.name), point));
            }
        };
        add(zone.disc_body, zone.disc_center_m, false);
        match zone.curve {
            // A line has no place along itself but where the disc meets it.
            Curve::Line { point_m, normal } => {
                let disc = zone.disc_body.map_or(zone.disc_center_m, |body| drawn[body].to_world(zone.disc_center_m));
                let meets = zone.curve_body.map(|body| {
                    let disc = drawn[body].from_world(disc);
                    let above = dot(sub(disc, point_m), normal);
                    [disc[0] - above * normal[0], disc[1] - above * normal[1]]
                });
                add(zone.curve_body, meets.unwrap_or(point_m), true);
            }
            Curve::Segment { from_m, to_m, .. } => {
                add(zone.curve_body, from_m, false);
                add(zone.curve_body, to_m, false);
            }
            Curve::Disc { center_m, .. } => add(zone.curve_body, center_m, false),
        }
    }
    let roles = &instrument.roles;
    let reported =
        [(roles.key, roles.key_front_m, KEY_FRONT), (roles.hammer, roles.hammer_strike_point_m, STRIKE_POINT)];
    for (body, point, called) in reported {
        if let Some(body) = body {
            shapes[body].points.push((called.to_owned(), point));
        }
    }
    shapes
}

impl Shape {
    /// Longest distance between two points of the body, m.
    fn length_m(&self) -> f64 {
        let each = || self.points.iter().map(|(_, point)| *point);
        each().flat_map(|a| each().map(move |b| length(sub(a, b)))).fold(self.gyration_m, f64::max)
    }

    /// How far a point lies from the rest of its body, and how long that rest is, m; `None` for the pivot.
    fn lengths_off(&self, index: usize) -> Option<(f64, f64)> {
        if index == 0 || self.gyration_m == 0.0 {
            return None;
        }
        let point = self.points[index].1;
        let rest = || self.points.iter().enumerate().filter(move |(other, _)| *other != index).map(|(_, (_, p))| *p);
        let pairs = || rest().enumerate().flat_map(move |(n, a)| rest().skip(n).map(move |b| (a, b)));
        // Mass lies at least as far out as the radius of gyration.
        let longest = pairs().map(|(a, b)| length(sub(a, b))).fold(self.gyration_m, f64::max);
        let nearest = pairs().map(|(a, b)| to_segment(point, a, b)).fold(f64::INFINITY, f64::min);
        Some((nearest, longest))
    }
}

fn length(v: Vec2) -> f64 {
    dot(v, v).sqrt()
}

/// Distance of a point from a segment, m.
fn to_segment(point: Vec2, a: Vec2, b: Vec2) -> f64 {
    let (along, from_a) = (sub(b, a), sub(point, a));
    let square = dot(along, along);
    let share = if square > 0.0 { (dot(from_a, along) / square).clamp(0.0, 1.0) } else { 0.0 };
    length([from_a[0] - share * along[0], from_a[1] - share * along[1]])
}
