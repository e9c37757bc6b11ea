//! Contact forces, as arrows.

use super::outline::MM;
use crate::svg::number;
use erard::instrument::{Instrument, Vec2};
use erard::run::Run;
use std::fmt::Write;

/// A push at a contact, as it is drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactForce {
    /// Index of the zone.
    pub zone: usize,
    /// Where, in the world, m.
    pub point_m: Vec2,
    /// Unit direction in which the arrow points.
    pub direction: Vec2,
    /// Normal force, N.
    pub normal_n: f64,
}

/// Which way a zone's arrow points: +1 along the normal (the push on side A), -1 against it (the push on side B).
///
/// Every contact pushes both ways; one arrow reads better than two. Bodies are listed from the key to the hammer, so
/// the later one is the one being driven, and what the ground does to a body is what is worth seeing.
pub fn arrow_sign(instrument: &Instrument, zone: usize) -> f64 {
    let zone = &instrument.zones[zone];
    if zone.disc_body >= zone.curve_body { 1.0 } else { -1.0 }
}

/// All contacts that push in one frame of a run.
pub fn forces_at(instrument: &Instrument, run: &Run, frame: usize) -> Vec<ContactForce> {
    let zones = instrument.zones.len().min(run.zones.len());
    (0..zones)
        .filter_map(|zone| {
            let series = &run.zones[zone];
            let normal_n = *series.normal_n.get(frame)?;
            let [x, y, nx, ny] = series.contact.get(frame)?.map(f64::from);
            if normal_n <= 0.0 || ![normal_n, x, y, nx, ny].iter().all(|v| v.is_finite()) {
                return None;
            }
            let sign = arrow_sign(instrument, zone);
            Some(ContactForce { zone, point_m: [x, y], direction: [sign * nx, sign * ny], normal_n })
        })
        .collect()
}

/// The absolute angles of all bodies in one frame of a run, in the instrument's order.
pub fn angles_at(run: &Run, frame: usize) -> Vec<f64> {
    run.bodies.iter().map(|body| body.angle_rad.get(frame).copied().unwrap_or(f64::NAN)).collect()
}

/// How long an arrow is and what it says. The page's script is given these numbers, so that both draw alike.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ArrowLaw {
    /// Length of the arrow of a vanishing force, mm.
    pub base_mm: f64,
    /// Growth per factor of ten, mm: logarithmic, since weights at rest are tenths of a newton and blows a hundred.
    pub per_decade_mm: f64,
    /// Force at which growth sets in, N.
    pub knee_n: f64,
    /// Forces below this are not drawn, N: a felt that only just touches is not news.
    pub smallest_drawn_n: f64,
    /// Forces from here on carry their number, N.
    pub smallest_labelled_n: f64,
}

/// The arrows of all pictures.
pub const ARROW: ArrowLaw =
    ArrowLaw { base_mm: 7.0, per_decade_mm: 9.0, knee_n: 0.1, smallest_drawn_n: 0.02, smallest_labelled_n: 0.2 };

impl ArrowLaw {
    /// Length of an arrow, mm.
    pub fn length_mm(&self, normal_n: f64) -> f64 {
        self.base_mm + self.per_decade_mm * (1.0 + normal_n / self.knee_n).log10()
    }
}

/// A force with as many digits as an eye can use.
pub fn force_label(normal_n: f64) -> String {
    match normal_n {
        n if n >= 99.95 => format!("{n:.0} N"),
        n if n >= 9.995 => format!("{n:.1} N"),
        n => format!("{n:.2} N"),
    }
}

/// The arrows as SVG, in picture millimetres.
pub fn arrows(forces: &[ContactForce]) -> String {
    let mut out = String::from("<g class=\"forces\">");
    let mut numbers = String::new();
    let mut taken: Vec<Vec2> = Vec::new();
    for force in forces.iter().filter(|force| force.normal_n >= ARROW.smallest_drawn_n) {
        let [ux, uy] = [force.direction[0], -force.direction[1]];
        let length = ARROW.length_mm(force.normal_n);
        let point = |along: f64, across: f64| {
            let x = force.point_m[0] * MM + ux * along - uy * across;
            let y = -force.point_m[1] * MM + uy * along + ux * across;
            format!("{} {}", number(x), number(y))
        };
        let (neck, half) = (length - 4.0, 1.9);
        let _ = write!(
            out,
            "<path class=\"arrow\" d=\"M{}L{}M{}L{}L{}Z\"/>",
            point(0.0, 0.0),
            point(neck, 0.0),
            point(length, 0.0),
            point(neck, half),
            point(neck, -half)
        );
        if force.normal_n >= ARROW.smallest_labelled_n {
            write_number(&mut numbers, &mut taken, force, length);
        }
    }
    // numbers after all arrows, so that none is struck through
    out.push_str(&numbers);
    out.push_str("</g>");
    out
}

/// Writes a force's number beyond its arrow's tip, further on where another number stands already.
fn write_number(out: &mut String, taken: &mut Vec<Vec2>, force: &ContactForce, length: f64) {
    let [ux, uy] = [force.direction[0], -force.direction[1]];
    let (anchor, aside) = match ux {
        ux if ux.abs() < 0.4 => ("middle", 0.0),
        ux if ux > 0.0 => ("start", 1.0),
        _ => ("end", -1.0),
    };
    let x = force.point_m[0] * MM + ux * (length + 3.0) + aside;
    let mut y = -force.point_m[1] * MM + uy * (length + 3.0) + 1.8;
    let step = if uy <= 0.0 { -5.5 } else { 5.5 };
    for _ in 0..6 {
        if !taken.iter().any(|[a, b]| (a - x).abs() < 17.0 && (b - y).abs() < 5.0) {
            break;
        }
        y += step;
    }
    taken.push([x, y]);
    let _ = write!(
        out,
        "<text class=\"newton\" x=\"{}\" y=\"{}\" text-anchor=\"{anchor}\">{}</text>",
        number(x),
        number(y),
        force_label(force.normal_n)
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrows_grow_with_the_force_but_fit_the_picture() {
        assert!(ARROW.length_mm(0.2) > 7.0);
        assert!(ARROW.length_mm(1.0) < ARROW.length_mm(10.0));
        assert!(ARROW.length_mm(300.0) < 45.0);
    }

    #[test]
    fn small_forces_stay_silent() {
        let force = |normal_n| ContactForce { zone: 0, point_m: [0.0, 0.0], direction: [0.0, 1.0], normal_n };
        assert!(!arrows(&[force(0.001)]).contains("path"));
        assert!(!arrows(&[force(0.1)]).contains("text"));
        assert!(arrows(&[force(12.34)]).contains("12.3 N"));
    }
}
