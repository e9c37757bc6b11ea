//! A planar linkage as data: what a user states, before any mathematics.

use std::ops::Neg;

use crate::direction::Direction;

/// What stands in a list, by its place.
macro_rules! ids {
    ($($(#[$what:meta])* $name:ident in $list:literal;)*) => {$(
        $(#[$what])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub struct $name(pub(crate) usize);

        impl $name {
            #[doc = concat!("Place in ", $list, ".")]
            #[must_use]
            pub fn index(self) -> usize {
                self.0
            }
        }
    )*};
}

ids! {
    /// A body of a [`Linkage`]. Body 0 is the ground.
    BodyId in "[`Linkage::bodies`]";
    /// A point fixed on a body.
    PointId in "[`Linkage::points`]";
    /// A joint between two points.
    JointId in "[`Linkage::joints`]";
    /// A constant length, in the order of declaration.
    LengthId in "[`Linkage::lengths`]";
    /// A constant angle of a linkage, in the order of declaration.
    AngleId in "[`Linkage::angles`]";
    /// A coordinate of a [`Mechanism`](crate::Mechanism): an index into its poses.
    CoordinateId in "[`Mechanism::coordinates`](crate::Mechanism::coordinates), in a pose's values and in rates";
}

/// A signed coordinate of a point: nothing, a constant length, or minus one.
///
/// Lengths are signed quantities (the piano's `L3` is negative); the sign here
/// is the one the printed equations show.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Length {
    /// Identically zero: leaves no trace in the equations.
    Zero,
    /// The constant as it stands.
    Plus(LengthId),
    /// Its opposite.
    Minus(LengthId),
}

impl Neg for Length {
    type Output = Length;

    fn neg(self) -> Length {
        match self {
            Length::Zero => Length::Zero,
            Length::Plus(id) => Length::Minus(id),
            Length::Minus(id) => Length::Plus(id),
        }
    }
}

/// A constant with the user's name for it, or without one (then its value is printed).
#[derive(Clone, Debug, PartialEq)]
pub struct Constant {
    /// The user's name, such as `L7`.
    pub name: Option<String>,
    /// Metres for a length, radians for an angle.
    pub value: f64,
}

/// A rigid body: a frame whose orientation is one absolute angle.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Body {
    /// Name in messages.
    pub name: String,
    /// The symbol of its angle in the equations; `None` for the ground and for
    /// massless sliders, which turn with the body that carries them.
    pub symbol: Option<String>,
    pub(crate) origin: PointId,
}

/// A point fixed on a body, reached from another point of that body by a
/// rigid-arm vector `(x, y)` in the body's frame. The body's origin has no base.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Point {
    /// Name in messages.
    pub name: String,
    /// The body it is fixed on.
    pub body: BodyId,
    /// The point the arm starts from.
    pub base: Option<PointId>,
    /// Along the body's x axis.
    pub x: Length,
    /// Along the body's y axis.
    pub y: Length,
}

/// Freedom of a joint.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum JointKind {
    /// The two points coincide; the bodies turn freely.
    Revolute,
    /// Point `b` lies at `a + s u`, where `u` is a direction fixed on the body of
    /// `a`, and the body of `b` is turned by a constant against that of `a`.
    Prismatic {
        /// The symbol of the sliding coordinate `s`, such as `S1` (metres).
        symbol: String,
        /// The direction `u`, in the frame of the body of `a`.
        along: Direction,
        /// Angle of `b`'s body minus angle of `a`'s body.
        turned: Direction,
    },
}

/// A joint between point `a` of one body and point `b` of another.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Joint {
    /// Name in messages.
    pub name: String,
    /// The carrier's point.
    pub a: PointId,
    /// The carried point.
    pub b: PointId,
    /// Revolute or prismatic.
    pub kind: JointKind,
}

/// The joints that [`Linkage::contact`] adds: a sliding contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Contact {
    /// The massless body between the two joints.
    pub slider: BodyId,
    /// The slider on its carrier: holds the sliding coordinate.
    pub prismatic: JointId,
    /// The pin between slider and the other body.
    pub revolute: JointId,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Prescribed {
    Angle(BodyId),
    Sliding(JointId),
}

/// Bodies with points, joints between the points, and the prescribed coordinates.
///
/// Units: metres and radians; x to the right (on a piano: away from the
/// player), y up, angles counter-clockwise.
///
/// The methods only record. [`Linkage::assemble`] checks everything and says
/// what is wrong.
///
/// # Panics
/// Ids belong to the linkage that made them; an id of another linkage panics
/// like an index out of range, or names another part.
#[derive(Clone, Debug, PartialEq)]
pub struct Linkage {
    pub(crate) bodies: Vec<Body>,
    pub(crate) points: Vec<Point>,
    pub(crate) joints: Vec<Joint>,
    pub(crate) lengths: Vec<Constant>,
    pub(crate) angles: Vec<Constant>,
    pub(crate) prescribed: Vec<Prescribed>,
}

impl Default for Linkage {
    fn default() -> Self {
        Self::new()
    }
}

impl Linkage {
    /// A linkage of nothing but the ground.
    #[must_use]
    pub fn new() -> Self {
        let mut linkage = Linkage {
            bodies: Vec::new(),
            points: Vec::new(),
            joints: Vec::new(),
            lengths: Vec::new(),
            angles: Vec::new(),
            prescribed: Vec::new(),
        };
        linkage.add_body("ground", None);
        linkage
    }

    /// The one body that does not move; its frame is the world's.
    #[must_use]
    pub fn ground(&self) -> BodyId {
        BodyId(0)
    }

    /// The origin of the frame of `body`.
    #[must_use]
    pub fn origin(&self, body: BodyId) -> PointId {
        self.bodies[body.0].origin
    }

    /// Adds a moving body whose absolute angle (radians) is called `symbol`.
    pub fn body(&mut self, name: &str, symbol: &str) -> BodyId {
        self.add_body(name, Some(symbol.to_owned()))
    }

    /// Adds a body without an angle of its own: one that a prismatic joint holds
    /// to a carrier (a slider block), so that its angle is the carrier's.
    pub fn slider(&mut self, name: &str) -> BodyId {
        self.add_body(name, None)
    }

    fn add_body(&mut self, name: &str, symbol: Option<String>) -> BodyId {
        let id = BodyId(self.bodies.len());
        let origin = PointId(self.points.len());
        self.points.push(Point {
            name: format!("{name} origin"),
            body: id,
            base: None,
            x: Length::Zero,
            y: Length::Zero,
        });
        self.bodies.push(Body { name: name.to_owned(), symbol, origin });
        id
    }

    /// A constant length of `metres` under the user's own `name`.
    pub fn length(&mut self, name: &str, metres: f64) -> Length {
        self.add_length(Some(name.to_owned()), metres)
    }

    /// A constant length without a name: the equations show its value.
    pub fn number(&mut self, metres: f64) -> Length {
        self.add_length(None, metres)
    }

    fn add_length(&mut self, name: Option<String>, value: f64) -> Length {
        let id = LengthId(self.lengths.len());
        self.lengths.push(Constant { name, value });
        Length::Plus(id)
    }

    /// A constant angle of `radians` under the user's own `name`, as a direction.
    pub fn angle(&mut self, name: &str, radians: f64) -> Direction {
        let id = AngleId(self.angles.len());
        self.angles.push(Constant { name: Some(name.to_owned()), value: radians });
        Direction::at(id)
    }

    /// A point of `body` at `(x, y)` in its frame.
    pub fn point(&mut self, body: BodyId, name: &str, x: Length, y: Length) -> PointId {
        self.point_from(self.origin(body), name, x, y)
    }

    /// A point at `(x, y)` from another point of the same body, in its frame.
    ///
    /// Chains of points keep the equations short: the ground's `C` measured from
    /// `B` brings only that vector into a loop through `B` and `C`.
    pub fn point_from(&mut self, base: PointId, name: &str, x: Length, y: Length) -> PointId {
        let id = PointId(self.points.len());
        self.points.push(Point { name: name.to_owned(), body: self.points[base.0].body, base: Some(base), x, y });
        id
    }

    /// A pin: points `a` and `b` coincide.
    pub fn revolute(&mut self, name: &str, a: PointId, b: PointId) -> JointId {
        self.add_joint(name, a, b, JointKind::Revolute)
    }

    /// A slide: `b = a + s u` with `u` the direction `along` on the body of `a`,
    /// and the body of `b` parallel to that of `a`. `symbol` names `s` (metres).
    pub fn prismatic(&mut self, name: &str, symbol: &str, a: PointId, along: Direction, b: PointId) -> JointId {
        self.prismatic_turned(name, symbol, a, along, b, Direction::X)
    }

    /// As [`Linkage::prismatic`], with the body of `b` turned by the constant
    /// `turned` against the body of `a`.
    pub fn prismatic_turned(
        &mut self,
        name: &str,
        symbol: &str,
        a: PointId,
        along: Direction,
        b: PointId,
        turned: Direction,
    ) -> JointId {
        let kind = JointKind::Prismatic { symbol: symbol.to_owned(), along, turned };
        self.add_joint(name, a, b, kind)
    }

    /// A sliding contact: `point` of one body stays on the line through
    /// `on` along `along` fixed on another. It is a prismatic and a revolute joint
    /// in series, with a massless slider between them. `symbol` names the distance
    /// from `on` to the contact (metres, along `along`).
    pub fn contact(&mut self, name: &str, symbol: &str, on: PointId, along: Direction, point: PointId) -> Contact {
        let slider = self.slider(&format!("{name} slider"));
        let origin = self.origin(slider);
        let prismatic = self.prismatic(&format!("{name} slide"), symbol, on, along, origin);
        let revolute = self.revolute(&format!("{name} pin"), origin, point);
        Contact { slider, prismatic, revolute }
    }

    fn add_joint(&mut self, name: &str, a: PointId, b: PointId, kind: JointKind) -> JointId {
        let id = JointId(self.joints.len());
        self.joints.push(Joint { name: name.to_owned(), a, b, kind });
        id
    }

    /// Drives the angle of `body`: it is given, not solved for.
    pub fn prescribe_angle(&mut self, body: BodyId) {
        self.prescribed.push(Prescribed::Angle(body));
    }

    /// Drives the sliding coordinate of the prismatic `joint`.
    pub fn prescribe_sliding(&mut self, joint: JointId) {
        self.prescribed.push(Prescribed::Sliding(joint));
    }

    /// The bodies, ground first.
    #[must_use]
    pub fn bodies(&self) -> &[Body] {
        &self.bodies
    }

    /// The points, in the order of declaration (every body brings its origin).
    #[must_use]
    pub fn points(&self) -> &[Point] {
        &self.points
    }

    /// The joints, in the order of declaration.
    #[must_use]
    pub fn joints(&self) -> &[Joint] {
        &self.joints
    }

    /// The constant lengths (metres), in the order of declaration.
    #[must_use]
    pub fn lengths(&self) -> &[Constant] {
        &self.lengths
    }

    /// The constant angles (radians), in the order of declaration.
    #[must_use]
    pub fn angles(&self) -> &[Constant] {
        &self.angles
    }

    /// The body that carries `point`.
    #[must_use]
    pub(crate) fn body_of(&self, point: PointId) -> BodyId {
        self.points[point.0].body
    }
}
