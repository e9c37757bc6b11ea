//! The pieces of a picture: outlines, the body that carries each, and its material.

use super::material::Finish;
use erard::instrument::{DrawnPart, Instrument, Placement, Vec2};

/// One outline of the picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Piece {
    /// Name, e.g. `hammer shank`. A name with a comma is a detail of a main part, and is not labelled.
    pub name: String,
    /// Body that carries the outline.
    pub carrier: Carrier,
    /// Appearance.
    pub finish: Finish,
    /// Closed polygon in the carrier's frame, m.
    pub outline_m: Vec<Vec2>,
    /// Whether the polygon's corners are rounded off into a smooth curve.
    pub smooth: bool,
}

impl Piece {
    /// A part that the instrument file draws itself.
    pub(crate) fn of_file(part: &DrawnPart) -> Self {
        Piece {
            name: part.name.clone(),
            carrier: part.body.map_or(Carrier::Ground, Carrier::Body),
            finish: part.material.into(),
            outline_m: part.outline_m.clone(),
            smooth: part.smooth,
        }
    }
}

/// Body that carries an outline.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Carrier {
    /// Nothing: it stands still.
    Ground,
    /// The rail that the sustain pedal lifts. As drawn the pedal is up, and the rail stands on the ground.
    Rail,
    /// A body, as a piece of it.
    Body(usize),
    /// A point of a body, without turning: what is guided (a damper's head, by its rail) or held (a finger). Its
    /// outline is given in the world, as drawn.
    Point {
        /// The body.
        body: usize,
        /// The point in the body's frame, m.
        point_m: Vec2,
        /// Where that point lies as drawn, m.
        drawn_m: Vec2,
        /// Whether it is guided up and down, or follows wherever the point goes.
        is_guided: bool,
    },
}

impl Carrier {
    /// Where its frame is, for bodies that are placed so.
    pub(crate) fn placement(&self, placed: &[Placement]) -> Placement {
        match *self {
            Carrier::Ground | Carrier::Rail => Placement::GROUND,
            Carrier::Body(body) => placed[body],
            Carrier::Point { body, point_m, drawn_m, is_guided } => {
                let [x, y] = placed[body].to_world(point_m);
                let across = if is_guided { 0.0 } else { x - drawn_m[0] };
                Placement { pivot_m: [across, y - drawn_m[1]], angle_rad: 0.0 }
            }
        }
    }

    /// The body that it moves with.
    pub(crate) fn body(&self) -> Option<usize> {
        match *self {
            Carrier::Ground | Carrier::Rail => None,
            Carrier::Body(body) | Carrier::Point { body, .. } => Some(body),
        }
    }
}

/// The fingertip on the key, where the instrument has a key.
pub(super) fn finger(instrument: &Instrument, placed: &[Placement]) -> Vec<Piece> {
    let Some(key) = instrument.roles.key else { return Vec::new() };
    let point_m = instrument.roles.key_front_m;
    let drawn_m = placed[key].to_world(point_m);
    let carrier = Carrier::Point { body: key, point_m, drawn_m, is_guided: false };
    let piece = |name: &str, finish, corners: &[[f64; 2]]| Piece {
        name: name.into(),
        carrier,
        finish,
        outline_m: corners.iter().map(|c| [drawn_m[0] + 1e-3 * c[0], drawn_m[1] + 1e-3 * c[1]]).collect(),
        smooth: true,
    };
    vec![piece("finger", Finish::Skin, &FINGER), piece("finger, nail", Finish::Nail, &NAIL)]
}

/// A fingertip whose pad touches at the origin, mm; the hand comes from the player's side.
const FINGER: [[f64; 2]; 13] = [
    [-44.0, 48.0],
    [-44.0, 48.0],
    [-21.0, 16.0],
    [-9.0, 3.6],
    [-3.0, 0.0],
    [3.0, 0.0],
    [7.0, 2.6],
    [8.4, 7.0],
    [6.6, 12.0],
    [-2.0, 24.0],
    [-11.0, 36.0],
    [-26.0, 58.0],
    [-26.0, 58.0],
];
const NAIL: [[f64; 2]; 6] = [[8.0, 7.0], [8.9, 8.6], [7.4, 12.6], [1.0, 21.4], [-1.6, 23.4], [4.6, 12.6]];
