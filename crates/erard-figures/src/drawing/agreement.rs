//! The shipped instruments' pictures against their mechanics: where two felts meet, two outlines must meet.

use super::pose::{carrier, drawn_angles, placements};
use super::{parts, path};
use erard::instrument::{Curve, Instrument, Part, Vec2};

/// All instruments with the outlines that are shipped for them.
fn shipped() -> impl Iterator<Item = Instrument> {
    Instrument::builtin_names().map(|name| Instrument::builtin(name).unwrap())
}

/// Points along the drawn path of a part, in its body's frame, m; a tenth of a millimetre apart or closer.
fn along(part: &Part) -> Vec<Vec2> {
    let drawn = path(part).replace('Z', "").replace(['M', 'L'], "|L ").replace('Q', "|Q ");
    let mut corners: Vec<Vec2> = Vec::new();
    for command in drawn.split('|').filter(|command| !command.is_empty()) {
        let numbers: Vec<f64> = command[1..].split_whitespace().map(|n| n.parse().unwrap()).collect();
        let points: Vec<Vec2> = numbers.chunks(2).map(|n| [n[0] * 1e-3, -n[1] * 1e-3]).collect();
        if let (Some(&from), [control, to]) = (corners.last(), &points[..]) {
            for step in 1..=20 {
                let t = f64::from(step) / 20.0;
                let blend = |k: usize| (1.0 - t).powi(2) * from[k] + 2.0 * t * (1.0 - t) * control[k] + t * t * to[k];
                corners.push([blend(0), blend(1)]);
            }
        } else {
            corners.push(points[0]);
        }
    }
    let mut out = Vec::new();
    for (index, a) in corners.iter().enumerate() {
        let b = corners[(index + 1) % corners.len()];
        let steps = ((b[0] - a[0]).hypot(b[1] - a[1]) / 1e-4).ceil().max(1.0);
        for step in 0..steps as usize {
            let t = step as f64 / steps;
            out.push([a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])]);
        }
    }
    out
}

/// Distance from a point of a body's frame to the nearest outline of that body, m.
fn to_outline(instrument: &Instrument, body: Option<usize>, point: Vec2) -> f64 {
    parts(instrument)
        .iter()
        .filter(|part| part.body == body)
        .flat_map(along)
        .map(|p| (p[0] - point[0]).hypot(p[1] - point[1]))
        .fold(f64::INFINITY, f64::min)
}

fn rotated(v: Vec2, angle: f64) -> Vec2 {
    let (sin, cos) = angle.sin_cos();
    [cos * v[0] - sin * v[1], sin * v[0] + cos * v[1]]
}

/// Both sides of every zone are drawn where the mechanics has them. Half a millimetre is what an eye forgives in a
/// picture of the whole action; most agree to a tenth.
#[test]
fn what_touches_is_drawn_touching() {
    for instrument in shipped() {
        let placed = placements(&instrument, &drawn_angles(&instrument));
        for zone in &instrument.zones {
            let disc_frame = carrier(&placed, zone.disc_body);
            let curve_frame = carrier(&placed, zone.curve_body);
            let (normal, on_curve) = match zone.curve {
                Curve::Line { point_m, normal } => (normal, point_m),
                Curve::Segment { from_m, to_m, rounding_m } => {
                    let tangent = [to_m[0] - from_m[0], to_m[1] - from_m[1]];
                    let length = tangent[0].hypot(tangent[1]);
                    let normal = [-tangent[1] / length, tangent[0] / length];
                    let middle = [0.5 * (from_m[0] + to_m[0]), 0.5 * (from_m[1] + to_m[1])];
                    (normal, [middle[0] + rounding_m * normal[0], middle[1] + rounding_m * normal[1]])
                }
                Curve::Disc { .. } => panic!("{}: a grand has no disc on this side", zone.name),
            };
            let toward = rotated(normal, curve_frame.angle_rad - disc_frame.angle_rad);
            let on_disc = [
                zone.disc_center_m[0] - zone.disc_radius_m * toward[0],
                zone.disc_center_m[1] - zone.disc_radius_m * toward[1],
            ];
            let disc_off = to_outline(&instrument, zone.disc_body, on_disc);
            let curve_off = to_outline(&instrument, zone.curve_body, on_curve);
            assert!(disc_off < 0.5e-3, "{}: disc side drawn {:.2} mm off", zone.name, disc_off * 1e3);
            assert!(curve_off < 0.5e-3, "{}: curve side drawn {:.2} mm off", zone.name, curve_off * 1e3);
        }
    }
}

/// Every body is drawn, and the picture stays within reach of its mechanics.
#[test]
fn every_body_is_drawn() {
    for instrument in shipped() {
        for (index, body) in instrument.bodies.iter().enumerate() {
            assert!(instrument.parts.iter().any(|part| part.body == Some(index)), "{}", body.name);
        }
        assert!(instrument.parts.iter().flat_map(|part| &part.outline_m).flatten().all(|c| c.abs() < 0.4));
    }
}
