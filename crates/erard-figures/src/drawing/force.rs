//! The forces of a run: what pushes where, and how large its arrow is.

use erard::grand::KEY_DOWN;
use erard::instrument::{Instrument, Vec2};
use erard::player::PinSeries;
use erard::run::Run;

/// Kind of force that an arrow shows. Its class in the picture is `arrow` and the name of the kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ArrowKind {
    /// A contact's normal force.
    Contact,
    /// The finger's.
    Finger,
    /// Force of a pin on the body that turns about it.
    Pin,
}

impl ArrowKind {
    /// Its class in the picture.
    pub(crate) fn class(self) -> &'static str {
        match self {
            ArrowKind::Contact => "contact",
            ArrowKind::Finger => "touch",
            ArrowKind::Pin => "pin",
        }
    }
}

/// A force, as it is drawn: the arrow begins where the force acts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Arrow {
    /// Kind of force.
    pub kind: ArrowKind,
    /// Point of attack in the world, m.
    pub point_m: Vec2,
    /// Unit direction in which the arrow points, in the world.
    pub direction: Vec2,
    /// The force, N.
    pub force_n: f64,
}

/// Which way a zone's arrow points: +1 along the normal (the push on side A), -1 against it (the push on side B).
///
/// Every contact pushes both ways; one arrow reads better than two. Bodies are listed from the key to the hammer, so
/// the later one is the one being driven, and what the ground does to a body is what is worth seeing.
pub(crate) fn arrow_sign(instrument: &Instrument, zone: usize) -> f64 {
    let zone = &instrument.zones[zone];
    if zone.disc_body >= zone.curve_body { 1.0 } else { -1.0 }
}

/// Forces in one frame of a run: of the finger, and of all contacts.
pub fn forces_at(instrument: &Instrument, run: &Run, frame: usize) -> Vec<Arrow> {
    let placed = instrument.placements(&angles_at(run, frame));
    let force_n = run.force_n.get(frame).copied().filter(|force| force.is_finite() && *force > 0.0);
    let finger = instrument.roles.key.zip(force_n).map(|(key, force_n)| {
        let point_m = placed[key].to_world(instrument.roles.key_front_m);
        Arrow { kind: ArrowKind::Finger, point_m, direction: KEY_DOWN, force_n }
    });
    let zones = instrument.zones.len().min(run.zones.len());
    let unseen = super::drawing(instrument).unseen;
    let is_seen = |body: Option<usize>| body.is_none_or(|body| !unseen.contains(&body));
    let contacts = (0..zones).filter_map(|zone| {
        let touching = &instrument.zones[zone];
        if !is_seen(touching.disc_body) || !is_seen(touching.curve_body) {
            return None;
        }
        let series = &run.zones[zone];
        let force_n = *series.normal_n.get(frame)?;
        let [x, y, nx, ny] = series.contact.get(frame)?.map(f64::from);
        if force_n <= 0.0 || ![force_n, x, y, nx, ny].iter().all(|v| v.is_finite()) {
            return None;
        }
        let sign = arrow_sign(instrument, zone);
        Some(Arrow { kind: ArrowKind::Contact, point_m: [x, y], direction: [sign * nx, sign * ny], force_n })
    });
    finger.into_iter().chain(contacts).collect()
}

/// Forces of the pins on the bodies that turn about them, in one frame of a run.
pub fn pins_at(instrument: &Instrument, run: &Run, pins: &[PinSeries], frame: usize) -> Vec<Arrow> {
    let placed = instrument.placements(&angles_at(run, frame));
    let unseen = super::drawing(instrument).unseen;
    let arrow = |(body, pin): (usize, &PinSeries)| {
        let [x, y] = [*pin.pin_x_n.get(frame)?, *pin.pin_y_n.get(frame)?];
        let force_n = x.hypot(y);
        let is_seen = body < placed.len() && !unseen.contains(&body) && force_n.is_finite() && force_n > 0.0;
        is_seen.then(|| Arrow {
            kind: ArrowKind::Pin,
            point_m: placed[body].pivot_m,
            direction: [x / force_n, y / force_n],
            force_n,
        })
    };
    pins.iter().enumerate().filter_map(arrow).collect()
}

/// The absolute angles of all bodies in one frame of a run, in the instrument's order.
pub fn angles_at(run: &Run, frame: usize) -> Vec<f64> {
    run.bodies.iter().map(|body| body.angle_rad.get(frame).copied().unwrap_or(f64::NAN)).collect()
}

/// How long an arrow is and what it says. The page's script is given these numbers, so that both draw alike.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ArrowLaw {
    /// Length of the arrow of a vanishing force, mm.
    pub base_mm: f64,
    /// Growth per factor of ten, mm: logarithmic, since weights at rest are tenths of a newton and impacts a hundred.
    pub per_decade_mm: f64,
    /// Force at which growth sets in, N.
    pub knee_n: f64,
    /// Forces below this are not drawn, N: a felt that only just touches is not news.
    pub smallest_drawn_n: f64,
    /// Forces from here on carry their number, N.
    pub smallest_labelled_n: f64,
}

/// The arrows of all pictures.
pub(crate) const ARROW: ArrowLaw =
    ArrowLaw { base_mm: 7.0, per_decade_mm: 9.0, knee_n: 0.1, smallest_drawn_n: 0.02, smallest_labelled_n: 0.2 };

impl ArrowLaw {
    /// Length of an arrow, mm.
    pub(crate) fn length_mm(&self, normal_n: f64) -> f64 {
        self.base_mm + self.per_decade_mm * (1.0 + normal_n / self.knee_n).log10()
    }
}

/// A force with as many digits as an eye can use.
pub(crate) fn force_label(normal_n: f64) -> String {
    match normal_n {
        n if n >= 99.95 => format!("{n:.0} N"),
        n if n >= 9.995 => format!("{n:.1} N"),
        n => format!("{n:.2} N"),
    }
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
}
