//! Three levers as in an instrument: discs that slide and roll on straight lines.
//!
//! The papers fix the capstan's contact on the whippen and the knuckle's contact on the hammer. In an instrument the
//! capstan is a dome on the *key* that slides along the whippen's heel, and the knuckle is a roller whose contact point
//! moves around it as the hammer turns. The centre of a disc on a line moves on a parallel line. So each contact is
//! still exactly a prismatic and a revolute joint in series, between other points.
//!
//! Frames: the key's x axis is the normal of its surface, and its y axis points to the player, by the definition of
//! `k`. The frames of whippen and hammer are arbitrary; their angles are `w` and `h`.

use super::exact::{Exact, nearest, rotate};
use super::{Drive, LeverArms, LeverTrain, Levers, Move, Regulation, StrokePose, ThreeLeverError, checked, on_pivots};
use crate::linkage::Direction;
use crate::linkage::closed_form::{cosine_equation, wrap};
use crate::linkage::{BodyId, Length, Linkage, PointId};

/// An angle this near to a quarter turn (rad) is one: rounding of what it was computed from.
const QUARTER: f64 = 1e-13;
/// A coordinate below this (m) is none.
const NOTHING: f64 = 1e-15;

/// A directed straight line of a lever, in the lever's own frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// A point of the line (m).
    pub point: [f64; 2],
    /// Direction, counter-clockwise from the frame's x axis (rad). Sliding coordinates increase along it.
    pub angle: f64,
}

/// Contact of a disc on one lever with a line on another. One of the two is the whippen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Touch {
    /// Whether the whippen carries the disc and the other lever the line.
    pub disc_on_whippen: bool,
    /// The disc's centre in its lever's frame (m).
    pub center: [f64; 2],
    /// Distance of the centre from the line (m), positive to the left of the line's direction: the radius less the
    /// felt's compression.
    pub offset: f64,
    /// Line that the disc touches.
    pub line: Line,
}

/// Three levers whose contacts are discs on lines. The key's pivot A is the origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiscLevers {
    /// Position of the whippen's pivot B relative to A (m).
    pub whippen_pivot: [f64; 2],
    /// Position of the hammer's pivot C relative to A (m).
    pub hammer_pivot: [f64; 2],
    /// Contact between key and whippen.
    pub capstan: Touch,
    /// Contact between hammer and whippen (with the jack locked to it).
    pub knuckle: Touch,
    /// Distance from the key's pivot to the point where the finger presses (m, positive).
    pub key_front: f64,
    /// Key angle `k` at rest (rad).
    pub key_rest: f64,
    /// Strike point in the hammer's frame (m).
    pub head: [f64; 2],
    /// Approximate rest angles of whippen and hammer, `[w, h]` (rad). They select the intended pose among its mirror
    /// images.
    pub near: [f64; 2],
}

fn add([a, b]: [f64; 2], [c, d]: [f64; 2]) -> [f64; 2] {
    [a + c, b + d]
}

fn sub([a, b]: [f64; 2], [c, d]: [f64; 2]) -> [f64; 2] {
    [a - c, b - d]
}

fn dot([a, b]: [f64; 2], [c, d]: [f64; 2]) -> f64 {
    a * c + b * d
}

fn quarter_turn([x, y]: [f64; 2]) -> [f64; 2] {
    [-y, x]
}

/// Where a lever's pivot is (m) and how far it is turned (rad).
type Place = ([f64; 2], f64);

impl Touch {
    /// The line's unit direction and left normal, in its lever's frame.
    fn axes(&self) -> [[f64; 2]; 2] {
        let (s, c) = self.line.angle.sin_cos();
        [[c, s], [-s, c]]
    }

    /// Of the parallel that the centre keeps to: the point nearest to its lever's pivot.
    fn foot(&self) -> [f64; 2] {
        let [_, normal] = self.axes();
        normal.map(|n| n * (dot(self.line.point, normal) + self.offset))
    }

    /// What the disc rolls along the line (m) when `other` and the whippen turn by so much (rad).
    pub(super) fn rolling(&self, other: f64, whippen: f64) -> f64 {
        let turned = if self.disc_on_whippen { whippen - other } else { other - whippen };
        -self.offset * turned
    }

    /// The centre, in the frame of the line's lever: along the line from the foot, and how
    /// far from its parallel.
    fn center_over_line(&self, other: Place, whippen: Place) -> [f64; 2] {
        let (disc, line) = if self.disc_on_whippen { (whippen, other) } else { (other, whippen) };
        let center = add(disc.0, rotate(disc.1, self.center));
        let [along, normal] = self.axes();
        let seen = sub(rotate(-line.1, sub(center, line.0)), self.foot());
        [dot(seen, along), dot(seen, normal)]
    }

    /// Where the two touch in the world (m).
    fn point(&self, other: Place, whippen: Place) -> [f64; 2] {
        let (disc, line) = if self.disc_on_whippen { (whippen, other) } else { (other, whippen) };
        let [_, normal] = self.axes();
        let center = add(disc.0, rotate(disc.1, self.center));
        sub(center, rotate(line.1, normal).map(|n| n * self.offset))
    }

    /// The angles at which a lever on `pivot` touches one that stands at `known`. The
    /// unknown lever is the whippen, or else the other one.
    fn turned(&self, whippen_is_unknown: bool, pivot: [f64; 2], known: Place) -> Option<[f64; 2]> {
        let [_, normal] = self.axes();
        let foot = self.foot();
        let apart = sub(known.0, pivot);
        if self.disc_on_whippen == whippen_is_unknown {
            // The unknown lever carries the disc, the line stands still: N . R(x) c = N . (line - pivot).
            let normal = rotate(known.1, normal);
            let height = dot(normal, add(apart, rotate(known.1, foot)));
            cosine_equation(dot(normal, self.center), dot(normal, quarter_turn(self.center)), height)
        } else {
            // It carries the line: R(x) n . (center - pivot) = n . foot.
            let center = add(apart, rotate(known.1, self.center));
            cosine_equation(dot(normal, center), dot(quarter_turn(normal), center), dot(normal, foot))
        }
    }
}

impl DiscLevers {
    /// Returns the levers as a linkage: bodies `k`, `w`, `h`, slidings `S1`, `S2`. The pivots have the papers' names
    /// `L1`, `L5`, `L6`, `L10`, and so has the knuckle, `L8`, `L9`. `C1`, `C2` is the capstan on the key, `E1`, `E2`
    /// the heel and `J1`, `J2` the jack's top on the whippen. A line is named by its point nearest to its lever's pivot
    /// and, if it is oblique, by a small angle: `c`, `e`, `j` or `n`. Zero quantities are left out.
    #[must_use]
    pub fn linkage(&self, drive: Drive) -> Linkage {
        let mut m = Linkage::new();
        let [bx, by] = self.whippen_pivot;
        let [cx, cy] = sub(self.hammer_pivot, self.whippen_pivot);
        let (l1, l5) = (length(&mut m, "L1", bx), length(&mut m, "L5", by));
        let (l6, l10) = (length(&mut m, "L6", -cx), length(&mut m, "L10", cy));
        let [key, whippen, hammer] = on_pivots(&mut m, [l1, l5], [l6, l10], drive);
        contact(&mut m, "capstan", "S1", &self.capstan, [(key, "C1", "C2", "c"), (whippen, "E1", "E2", "e")]);
        contact(&mut m, "knuckle", "S2", &self.knuckle, [(hammer, "L8", "L9", "n"), (whippen, "J1", "J2", "j")]);
        m
    }

    /// Assembles the levers at rest.
    ///
    /// # Errors
    /// Returns an error if a dimension is infinite or NaN, the key's front arm is not positive, or the levers do not
    /// reach each other.
    pub fn assemble(&self) -> Result<LeverTrain, ThreeLeverError> {
        Levers::Discs(*self).assemble()
    }

    /// Returns these levers after `moves`, regulated once at the end.
    ///
    /// # Errors
    /// Returns an error if the levers do not reach each other before or after the moves.
    pub fn moved(&self, moves: &[Move], regulation: Regulation) -> Result<DiscLevers, ThreeLeverError> {
        self.check()?;
        let rest = self.exact(self.key_rest)?;
        let mut moved = *self;
        moved.near = [rest.w, rest.h];
        for &part in moves {
            moved.make(part);
        }
        moved.check()?;
        if regulation == Regulation::Regulated {
            let w = (moved.knuckle)
                .turned(true, moved.whippen_pivot, (moved.hammer_pivot, rest.h))
                .map(|solutions| nearest(solutions, rest.w))
                .ok_or(ThreeLeverError::OutOfReach { contact: "knuckle", lever: "h", at: rest.h })?;
            moved.raise_capstan_to(w);
            moved.near[0] = w;
        }
        moved.exact(moved.key_rest)?;
        Ok(moved)
    }

    /// Screws the capstan along the key's normal until it touches the whippen standing at `w`.
    fn raise_capstan_to(&mut self, w: f64) {
        let [_, apart] = self.capstan.center_over_line(self.key_at(self.key_rest), (self.whippen_pivot, w));
        let [_, normal] = self.capstan.axes();
        // How fast the gap closes per metre of screw, the screw running along the key's x axis.
        let gain = if self.capstan.disc_on_whippen { -normal[0] } else { rotate(w - self.key_rest, normal)[0] };
        self.raise_capstan(-apart / gain);
    }

    fn raise_capstan(&mut self, by: f64) {
        if self.capstan.disc_on_whippen {
            self.capstan.line.point[0] += by;
        } else {
            self.capstan.center[0] += by;
        }
    }

    fn make(&mut self, part: Move) {
        // A disc moves by its centre, a line by its point.
        let on_whippen = |touch: &mut Touch, [x, y]: [f64; 2]| {
            let point = if touch.disc_on_whippen { &mut touch.center } else { &mut touch.line.point };
            *point = add(*point, [x, y]);
        };
        match part {
            // The key's y axis points to the player.
            Move::Capstan(x) if self.capstan.disc_on_whippen => self.capstan.center[0] += x,
            Move::Capstan(x) => self.capstan.center[1] -= x,
            Move::Knuckle(x) if self.knuckle.disc_on_whippen => self.knuckle.line.point[0] += x,
            Move::Knuckle(x) => self.knuckle.center[0] += x,
            Move::CapstanHeight(y) => self.raise_capstan(y),
            Move::HeelDepth(y) => on_whippen(&mut self.capstan, [0.0, -y]),
            Move::KnuckleDepth(y) => self.knuckle.offset += y.copysign(y * self.knuckle.offset),
            Move::JackHeight(y) => on_whippen(&mut self.knuckle, [0.0, y]),
            Move::WhippenPivot(x, y) => self.whippen_pivot = add(self.whippen_pivot, [x, y]),
            Move::HammerPivot(x, y) => self.hammer_pivot = add(self.hammer_pivot, [x, y]),
        }
    }

    fn key_at(&self, k: f64) -> Place {
        ([0.0; 2], k)
    }

    /// The pose at key angle `k` by trigonometry, one contact after the other, nearest to `near`.
    pub(super) fn exact(&self, k: f64) -> Result<Exact, ThreeLeverError> {
        let out_of_reach = |contact| ThreeLeverError::OutOfReach { contact, lever: "k", at: k };
        let key = self.key_at(k);
        let w = (self.capstan.turned(true, self.whippen_pivot, key))
            .map(|solutions| nearest(solutions, self.near[0]))
            .ok_or(out_of_reach("capstan"))?;
        let whippen = (self.whippen_pivot, w);
        let h = (self.knuckle.turned(false, self.hammer_pivot, whippen))
            .map(|solutions| nearest(solutions, self.near[1]))
            .ok_or(out_of_reach("knuckle"))?;
        let [s1, _] = self.capstan.center_over_line(key, whippen);
        let [s2, _] = self.knuckle.center_over_line((self.hammer_pivot, h), whippen);
        Ok(Exact { w, h, s1, s2 })
    }

    /// Returns the key angle (rad) at which the capstan holds the whippen at `w` (rad), the one nearest to rest; `None`
    /// if there is none.
    #[must_use]
    pub fn key_under(&self, w: f64) -> Option<f64> {
        let solutions = self.capstan.turned(false, [0.0; 2], (self.whippen_pivot, w))?;
        Some(nearest(solutions, self.key_rest))
    }

    /// Returns the travel of the key's front (m) from the pose `rest` until the whippen, or a part locked to it,
    /// touches a stop on the ground. The stop is given in world axes with origin A. `None` if it never does.
    #[must_use]
    pub fn key_travel_to_stop(&self, rest: &StrokePose, stop: &Touch) -> Option<f64> {
        let sense = rest.whippen_ratio.signum();
        let turns = (stop.turned(true, self.whippen_pivot, ([0.0; 2], 0.0))?)
            .map(|w| wrap((w - rest.w) * sense))
            .into_iter()
            .filter(|turn| *turn > 0.0);
        let turn = turns.fold(f64::INFINITY, f64::min);
        let k = self.key_under(rest.w + turn * sense).filter(|k| k.is_finite())?;
        Some((k - self.key_rest) * self.key_front)
    }

    /// Returns the contact points of capstan and heel, and of knuckle and jack, at a pose (m, relative to A).
    #[must_use]
    pub fn contact_points(&self, pose: &StrokePose) -> [[f64; 2]; 2] {
        let whippen = (self.whippen_pivot, pose.w);
        [self.capstan.point(self.key_at(pose.k), whippen), self.knuckle.point((self.hammer_pivot, pose.h), whippen)]
    }

    pub(super) fn lever_arms(&self, pose: &StrokePose) -> LeverArms {
        let [capstan, knuckle] = self.contact_points(pose);
        let distance = |a, b| {
            let [x, y]: [f64; 2] = sub(a, b);
            x.hypot(y)
        };
        LeverArms {
            key_front: self.key_front,
            key_back: distance(capstan, [0.0; 2]),
            whippen_heel: distance(capstan, self.whippen_pivot),
            whippen_jack: distance(knuckle, self.whippen_pivot),
            hammer_knuckle: distance(knuckle, self.hammer_pivot),
            hammer_head: self.head[0].hypot(self.head[1]),
        }
    }

    pub(super) fn check(&self) -> Result<(), ThreeLeverError> {
        let touch = |t: &Touch| [t.center[0], t.center[1], t.offset, t.line.point[0], t.line.point[1], t.line.angle];
        let pairs = |[a, b]: [[f64; 2]; 2]| [a[0], a[1], b[0], b[1]];
        let named = [
            ("a pivot's place", pairs([self.whippen_pivot, self.hammer_pivot]).to_vec()),
            ("a length of the capstan's contact", touch(&self.capstan).to_vec()),
            ("a length of the knuckle's contact", touch(&self.knuckle).to_vec()),
            ("a length of hammer or rest pose", pairs([self.head, self.near]).to_vec()),
            ("the key's front arm", vec![self.key_front]),
            ("the key's rest angle", vec![self.key_rest]),
        ];
        checked(named.into_iter().flat_map(|(name, values)| values.into_iter().map(move |x| (name, x))), self.key_front)
    }
}

fn length(m: &mut Linkage, name: &str, metres: f64) -> Length {
    if metres.abs() < NOTHING { Length::Zero } else { m.length(name, metres) }
}

/// A contact between two levers; `sides` are the other lever's and the whippen's body and names.
fn contact(m: &mut Linkage, name: &str, symbol: &str, touch: &Touch, sides: [(BodyId, &str, &str, &str); 2]) {
    let [other, whippen] = sides;
    let (disc, line) = if touch.disc_on_whippen { (whippen, other) } else { (other, whippen) };
    let mut place = |(body, x_name, y_name, _): (BodyId, &str, &str, &str), what: &str, [x, y]: [f64; 2]| -> PointId {
        let x = length(m, x_name, x);
        // L9 counts downward in the papers.
        let y = if y_name == "L9" { -length(m, y_name, -y) } else { length(m, y_name, y) };
        m.point(body, what, x, y)
    };
    let on = place(line, &format!("{name} line"), touch.foot());
    let center = place(disc, &format!("{name} center"), touch.center);
    let along = direction(m, line.3, touch.line.angle);
    m.contact(name, symbol, on, along, center);
}

/// A direction as quarter turns and, where it is askew, a named small angle.
fn direction(m: &mut Linkage, name: &str, angle: f64) -> Direction {
    let quarters = (angle / std::f64::consts::FRAC_PI_2).round();
    let askew = wrap(angle - quarters * std::f64::consts::FRAC_PI_2);
    let straight = Direction::quarter(quarters.rem_euclid(4.0) as u8);
    if askew.abs() < QUARTER { straight } else { straight + m.angle(name, askew) }
}
