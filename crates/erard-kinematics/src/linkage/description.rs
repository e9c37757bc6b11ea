//! Data of a planar linkage, as the user states it.

use std::ops::Neg;

use super::direction::Direction;

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
    /// Identifier of a body of a [`Linkage`]. Body 0 is the ground.
    BodyId in "[`Linkage::bodies`]";
    /// Identifier of a point fixed on a body.
    PointId in "[`Linkage::points`]";
    /// Identifier of a joint between two points.
    JointId in "[`Linkage::joints`]";
    /// Identifier of a constant length.
    LengthId in "[`Linkage::lengths`]";
    /// Identifier of a constant angle.
    AngleId in "[`Linkage::angles`]";
    /// Identifier of a coordinate of a [`LinkageMechanism`](super::LinkageMechanism).
    CoordinateId in "[`LinkageMechanism::coordinates`](super::LinkageMechanism::coordinates), in a pose's values and in rates";
}

/// Signed coordinate of a point: zero, or plus or minus a constant length.
///
/// The constant itself may be negative (as `L3` of the piano is). The sign given here is the one that printed equations
/// show.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Length {
    /// Identically zero; does not appear in the equations.
    Zero,
    /// Plus the constant.
    Plus(LengthId),
    /// Minus the constant.
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

/// Constant with the user's name. The equations show the value of a constant without a name.
#[derive(Clone, Debug, PartialEq)]
pub struct Constant {
    /// The user's name, such as `L7`.
    pub name: Option<String>,
    /// Value: metres for a length, radians for an angle.
    pub value: f64,
}

/// Rigid body: a frame whose orientation is one absolute angle.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Body {
    /// Name for messages.
    pub name: String,
    /// Symbol of its angle in the equations; `None` for the ground and for massless sliders, which have the angle of
    /// the body that carries them.
    pub symbol: Option<String>,
    pub(crate) origin: PointId,
}

/// Point fixed on a body. It is placed by a vector `(x, y)`, in the body's frame, from another point of that body.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Point {
    /// Name for messages.
    pub name: String,
    /// Body that carries the point.
    pub body: BodyId,
    /// Point from which `(x, y)` is measured; `None` for the body's origin.
    pub base: Option<PointId>,
    /// Coordinate along the body's x axis.
    pub x: Length,
    /// Coordinate along the body's y axis.
    pub y: Length,
}

/// Kind of a joint.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum JointKind {
    /// The two points coincide; the bodies rotate freely.
    Revolute,
    /// Point `b` lies at `a + s u`, with `u` a direction fixed on the body of `a`. The angle between the two bodies is
    /// constant.
    Prismatic {
        /// Symbol of the sliding coordinate `s` (metres), such as `S1`.
        symbol: String,
        /// Direction `u`, in the frame of the body of `a`.
        along: Direction,
        /// Angle of `b`'s body minus angle of `a`'s body.
        turned: Direction,
    },
}

/// Joint between point `a` of one body and point `b` of another.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Joint {
    /// Name for messages.
    pub name: String,
    /// Point on the carrier.
    pub a: PointId,
    /// Point on the carried body.
    pub b: PointId,
    /// Kind: revolute or prismatic.
    pub kind: JointKind,
}

/// Body and joints that [`Linkage::contact`] adds for a sliding contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Contact {
    /// Massless body between the two joints.
    pub slider: BodyId,
    /// Joint between carrier and slider, with the sliding coordinate.
    pub prismatic: JointId,
    /// Joint between slider and the other body.
    pub revolute: JointId,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Prescribed {
    Angle(BodyId),
    Sliding(JointId),
}

/// A planar linkage: bodies with points, joints between the points, and the prescribed coordinates.
///
/// Units: metres and radians; x to the right (on a piano: away from the
/// player), y up, angles counter-clockwise.
///
/// Its methods only record. [`Linkage::assemble`] checks everything and returns the first fault.
///
/// # Panics
/// Identifiers belong to the linkage that returned them. An identifier of another linkage may panic like an index out
/// of range, or refer to another part.
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
    /// Returns a linkage that contains only the ground.
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

    /// Returns the ground, the body that does not move. Its frame is the world's.
    #[must_use]
    pub fn ground(&self) -> BodyId {
        BodyId(0)
    }

    /// Returns the origin of the frame of `body`.
    #[must_use]
    pub fn origin(&self, body: BodyId) -> PointId {
        self.bodies[body.0].origin
    }

    /// Adds a moving body whose absolute angle (radians) is called `symbol`.
    pub fn body(&mut self, name: &str, symbol: &str) -> BodyId {
        self.add_body(name, Some(symbol.to_owned()))
    }

    /// Adds a body without an angle of its own (a slider block). A prismatic joint fixes its angle to that of its
    /// carrier.
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

    /// Adds a constant length of `metres` with a name for the equations.
    pub fn length(&mut self, name: &str, metres: f64) -> Length {
        self.add_length(Some(name.to_owned()), metres)
    }

    /// Adds a constant length without a name; the equations show its value, in metres.
    pub fn number(&mut self, metres: f64) -> Length {
        self.add_length(None, metres)
    }

    fn add_length(&mut self, name: Option<String>, value: f64) -> Length {
        let id = LengthId(self.lengths.len());
        self.lengths.push(Constant { name, value });
        Length::Plus(id)
    }

    /// Adds a constant angle of `radians` with a name for the equations, and returns it as a direction.
    pub fn angle(&mut self, name: &str, radians: f64) -> Direction {
        let id = AngleId(self.angles.len());
        self.angles.push(Constant { name: Some(name.to_owned()), value: radians });
        Direction::at(id)
    }

    /// Adds a point of `body` at `(x, y)` in its frame.
    pub fn point(&mut self, body: BodyId, name: &str, x: Length, y: Length) -> PointId {
        self.point_from(self.origin(body), name, x, y)
    }

    /// Adds a point at `(x, y)` from another point of the same body, in its frame.
    ///
    /// Chains of points keep the equations short: if the ground's point `C` is measured from `B`, a loop through `B`
    /// and `C` contains only the vector between them.
    pub fn point_from(&mut self, base: PointId, name: &str, x: Length, y: Length) -> PointId {
        let id = PointId(self.points.len());
        self.points.push(Point { name: name.to_owned(), body: self.points[base.0].body, base: Some(base), x, y });
        id
    }

    /// Adds a revolute joint: points `a` and `b` coincide.
    pub fn revolute(&mut self, name: &str, a: PointId, b: PointId) -> JointId {
        self.add_joint(name, a, b, JointKind::Revolute)
    }

    /// Adds a prismatic joint: `b = a + s u`, with `u` the direction `along` on the body of `a`. The bodies of `a` and
    /// `b` are parallel. `symbol` names `s` (metres).
    pub fn prismatic(&mut self, name: &str, symbol: &str, a: PointId, along: Direction, b: PointId) -> JointId {
        self.prismatic_turned(name, symbol, a, along, b, Direction::X)
    }

    /// Adds a prismatic joint as [`Linkage::prismatic`] does, with the body of `b` at the constant angle `turned` to
    /// the body of `a`.
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

    /// Adds a sliding contact: `point` of one body stays on the line through `on` along `along`, which is fixed on
    /// another body. The contact is a prismatic and a revolute joint in series, with a massless slider between them.
    /// `symbol` names the distance from `on` to the contact (metres, along `along`).
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

    /// Prescribes the angle of `body`: the caller gives it, and it is not solved for.
    pub fn prescribe_angle(&mut self, body: BodyId) {
        self.prescribed.push(Prescribed::Angle(body));
    }

    /// Prescribes the sliding coordinate of the prismatic `joint`.
    pub fn prescribe_sliding(&mut self, joint: JointId) {
        self.prescribed.push(Prescribed::Sliding(joint));
    }

    /// Returns the bodies, ground first.
    #[must_use]
    pub fn bodies(&self) -> &[Body] {
        &self.bodies
    }

    /// Returns the points in the order of declaration (every body adds its origin).
    #[must_use]
    pub fn points(&self) -> &[Point] {
        &self.points
    }

    /// Returns the joints in the order of declaration.
    #[must_use]
    pub fn joints(&self) -> &[Joint] {
        &self.joints
    }

    /// Returns the constant lengths (metres) in the order of declaration.
    #[must_use]
    pub fn lengths(&self) -> &[Constant] {
        &self.lengths
    }

    /// Returns the constant angles (radians) in the order of declaration.
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
