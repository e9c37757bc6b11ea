//! What a mechanism is: bodies, springs, zones, and where it is driven. Immutable once assembled.

use core::fmt;

use crate::ease::Bending;
use crate::form::Form;
use crate::joints::Parent;
use crate::path::Path;
use crate::vector::{Vector, add, dot, scale, sub};
use crate::{Real, Scalar};

/// The index that stands for the ground.
pub const GROUND: usize = usize::MAX;

/// One hinged rigid body. Its frame has the origin at its pivot.
#[derive(Debug, Clone, Copy)]
pub struct Body<T> {
    /// What it is hinged on: the index of an earlier body, or [`GROUND`].
    pub parent: usize,
    /// The pivot in the parent's frame, m.
    pub pivot: Vector<T>,
    /// Mass, kg.
    pub mass: T,
    /// Moment of inertia about its own pivot, kg m2.
    pub inertia: T,
    /// Centre of mass in its own frame, m.
    pub center_of_mass: Vector<T>,
    /// Dry friction torque c_d of the pivot, N m.
    pub dry: T,
    /// Viscous friction c_v of the pivot, N m s.
    pub viscous: T,
}

impl<T: Real> Body<T> {
    /// A body of unit inertia that nothing touches: fills unused places of a model of fixed size.
    pub fn inert() -> Self {
        let o = [T::ZERO; 2];
        let zero = T::ZERO;
        Body { parent: GROUND, pivot: o, mass: zero, inertia: T::ONE, center_of_mass: o, dry: zero, viscous: zero }
    }
}

/// A torsion spring at a body's pivot. Torque on the body: `torque - stiffness (relative angle - reference)`.
#[derive(Debug, Clone, Copy)]
pub struct Spring<T> {
    /// The hinged body; the opposite torque acts on its parent.
    pub body: usize,
    /// Torque at the reference, N m, counter-clockwise.
    pub torque: T,
    /// Stiffness, N m/rad.
    pub stiffness: T,
    /// Relative angle (body minus parent) at which `torque` holds, rad.
    pub reference: T,
}

/// The felt law's exponent; the usual ones are computed without `pow`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Exponent<T> {
    /// r = 2.
    Two,
    /// r = 2.5.
    TwoAndHalf,
    /// r = 3.
    Three,
    /// Any r >= 1.
    Other(T),
}

impl<T: Scalar> Exponent<T> {
    /// The variant for a given r.
    pub fn new(r: T) -> Self {
        match r.to_f64() {
            2.0 => Exponent::Two,
            2.5 => Exponent::TwoAndHalf,
            3.0 => Exponent::Three,
            _ => Exponent::Other(r),
        }
    }
}

/// Felt: F = k g^r + b g^2 dg/dt, clamped at zero (it never pulls). The papers call b also p.
#[derive(Debug, Clone, Copy)]
pub struct Felt<T> {
    /// k, N/m^r.
    pub stiffness: T,
    /// r.
    pub exponent: Exponent<T>,
    /// b, N s/m3.
    pub damping: T,
}

/// The curve that a zone's disc presses on, in its carrier's frame.
#[derive(Debug, Clone, Copy)]
pub enum Curve<T> {
    /// A straight line through `point` with outward unit `normal`.
    Line {
        /// A point of the line.
        point: Vector<T>,
        /// Outward unit normal.
        normal: Vector<T>,
    },
    /// A rounded segment: all points within `rounding` of the segment. It ends, so that a disc can slip off.
    Segment {
        /// One end of the core.
        from: Vector<T>,
        /// Unit vector from there to the other end.
        direction: Vector<T>,
        /// Length of the core, m.
        length: T,
        /// Rounding radius, m.
        rounding: T,
    },
    /// A disc.
    Disc {
        /// Centre.
        center: Vector<T>,
        /// Radius, m.
        radius: T,
    },
}

/// A contact zone: a disc (radius 0: a point) on one body against a curve on another, felt between them.
#[derive(Debug, Clone, Copy)]
pub struct Zone<T> {
    /// Carrier of the disc, or [`GROUND`].
    pub disc_body: usize,
    /// Disc centre in its carrier's frame, m.
    pub center: Vector<T>,
    /// Disc radius, m.
    pub radius: T,
    /// Carrier of the curve, or [`GROUND`].
    pub curve_body: usize,
    /// The curve.
    pub curve: Curve<T>,
    /// The felt.
    pub felt: Felt<T>,
    /// Coulomb friction coefficient, where there is any.
    pub friction: Option<T>,
}

/// Where the mechanism is driven: a point of a body, a world direction, and the elasticity between driver and body.
#[derive(Debug, Clone, Copy)]
pub struct Site<T> {
    /// Driven body.
    pub body: usize,
    /// Driven point in its frame, m.
    pub point: Vector<T>,
    /// Unit direction of a positive push, in the world.
    pub direction: Vector<T>,
    /// Stiffness of the spring between driver and body, N/m.
    pub stiffness: T,
    /// Damping in parallel with it, N s/m.
    pub damping: T,
}

/// A mechanism of `B` bodies and at most `Z` zones.
#[derive(Debug, Clone)]
pub struct Model<T, const B: usize, const Z: usize> {
    pub(crate) parent: [usize; B],
    /// The bodies that are hinged on another body, parents first.
    pub(crate) hinged: [usize; B],
    pub(crate) hinged_count: usize,
    /// The bodies that others are hinged on, ascending.
    pub(crate) parents: [Parent<T, B>; B],
    pub(crate) parent_count: usize,
    /// Whether a body is hinged on one that is hinged itself.
    pub(crate) deep: bool,
    pub(crate) pivot: [Vector<T>; B],
    /// x and y of the pivots on other bodies, in the parent's frame, and of the pivots on the ground; zero for the others.
    pub(crate) link: [[T; B]; 2],
    pub(crate) root: [[T; B]; 2],
    pub(crate) dry: [T; B],
    pub(crate) viscous: [T; B],
    /// Spring torque at relative angle 0, and stiffness.
    pub(crate) spring_torque: [T; B],
    pub(crate) spring_stiffness: [T; B],
    /// Diagonal of the mass matrix in absolute velocities: own inertia plus every descendant's mass at its branch's pivot.
    pub(crate) inertia: [T; B],
    /// What that diagonal contributes to the one of the mass matrix in relative velocities: a joint turns all that it carries.
    pub(crate) joint_inertia: [T; B],
    /// First moment of body and descendants about the pivot, fixed in the body's frame (see README, "Inertia").
    pub(crate) moment: [Vector<T>; B],
    pub(crate) moment_x: [T; B],
    pub(crate) moment_y: [T; B],
    /// Gravity times |moment|, N m, and |branch arm| times |moment|, kg m2: how strongly weight and centrifugal force change.
    pub(crate) weight: [T; B],
    pub(crate) whirl: [T; B],
    pub(crate) zones: [Zone<T>; Z],
    /// The zones as the step reads them.
    pub(crate) forms: [Form<T>; Z],
    /// The joints that a zone's compression and the driven point depend on.
    pub(crate) paths: [Path<T, B>; Z],
    /// What all felts together can leave out of a step's linearisation.
    pub(crate) bending: Bending<T, B>,
    pub(crate) site_path: Path<T, B>,
    pub(crate) zone_count: usize,
    /// The zones with Coulomb friction.
    pub(crate) sliding_zones: [usize; Z],
    pub(crate) sliding_count: usize,
    pub(crate) site: Option<Site<T>>,
    /// Gravity, pointing toward -y.
    pub(crate) gravity: T,
}

/// Why a model could not be assembled.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ModelError {
    /// More bodies than the model's size.
    TooManyBodies,
    /// More zones than the model's size.
    TooManyZones,
    /// A body's parent does not precede it.
    ParentOrder(usize),
    /// A spring, zone or site names a body that is not there.
    UnknownBody,
    /// A number that is not finite, or a mass or inertia that is not physical, in this body.
    BadBody(usize),
    /// A number that is not finite or out of its range, in this zone.
    BadZone(usize),
    /// A number that is not finite in a spring or the site.
    BadNumber,
}

impl fmt::Display for ModelError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ModelError::TooManyBodies => write!(f, "more bodies than this model has places for"),
            ModelError::TooManyZones => write!(f, "more zones than this model has places for"),
            ModelError::ParentOrder(i) => write!(f, "body {i}: its parent must precede it"),
            ModelError::UnknownBody => write!(f, "a spring, zone or site names a body that is not there"),
            ModelError::BadBody(i) => write!(f, "body {i}: a number is not finite, or mass or inertia is not physical"),
            ModelError::BadZone(i) => write!(f, "zone {i}: a number is not finite or out of range"),
            ModelError::BadNumber => write!(f, "a number in a spring or the drive site is not finite"),
        }
    }
}

impl core::error::Error for ModelError {}

impl<T: Scalar, const B: usize, const Z: usize> Model<T, B, Z> {
    /// Assembles a mechanism. Unused bodies are filled with [`Body::inert`].
    ///
    /// # Errors
    /// See [`ModelError`]; nothing that is not finite enters a model.
    pub fn new(
        bodies: &[Body<T>],
        springs: &[Spring<T>],
        zones: &[Zone<T>],
        site: Option<Site<T>>,
        gravity: T,
    ) -> Result<Self, ModelError> {
        if bodies.len() > B {
            return Err(ModelError::TooManyBodies);
        }
        if zones.len() > Z {
            return Err(ModelError::TooManyZones);
        }
        let o = [T::ZERO; 2];
        let mut model = Model {
            parent: [GROUND; B],
            hinged: [0; B],
            hinged_count: 0,
            parents: [Parent { body: 0, children: [T::ZERO; B], own: [T::ZERO; B] }; B],
            parent_count: 0,
            deep: false,
            pivot: [o; B],
            link: [[T::ZERO; B]; 2],
            root: [[T::ZERO; B]; 2],
            dry: [T::ZERO; B],
            viscous: [T::ZERO; B],
            spring_torque: [T::ZERO; B],
            spring_stiffness: [T::ZERO; B],
            inertia: [T::ONE; B],
            joint_inertia: [T::ZERO; B],
            moment: [o; B],
            moment_x: [T::ZERO; B],
            moment_y: [T::ZERO; B],
            weight: [T::ZERO; B],
            whirl: [T::ZERO; B],
            zones: [vacant(); Z],
            forms: [Form::of(&vacant()); Z],
            paths: [Path::empty(); Z],
            bending: Bending::of(core::iter::empty()),
            site_path: Path::empty(),
            zone_count: zones.len(),
            sliding_zones: [0; Z],
            sliding_count: 0,
            site,
            gravity,
        };
        let mut branch_mass = [T::ZERO; B];
        for (i, body) in bodies.iter().enumerate() {
            if body.parent != GROUND && body.parent >= i {
                return Err(ModelError::ParentOrder(i));
            }
            let m = &body.center_of_mass;
            let numbers = [body.pivot[0], body.pivot[1], body.mass, body.inertia, m[0], m[1], body.dry, body.viscous];
            let positive = body.inertia > T::ZERO && body.mass >= T::ZERO;
            if !(finite(&numbers) && positive && body.dry >= T::ZERO && body.viscous >= T::ZERO) {
                return Err(ModelError::BadBody(i));
            }
            model.parent[i] = body.parent;
            if body.parent != GROUND {
                model.hinged[model.hinged_count] = i;
                model.hinged_count += 1;
            }
            model.pivot[i] = body.pivot;
            let place = if body.parent == GROUND { &mut model.root } else { &mut model.link };
            (place[0][i], place[1][i]) = (body.pivot[0], body.pivot[1]);
            if body.parent != GROUND {
                model.deep |= bodies[body.parent].parent != GROUND;
            }
            model.dry[i] = body.dry;
            model.viscous[i] = body.viscous;
            model.inertia[i] = body.inertia;
            model.moment[i] = scale(body.center_of_mass, body.mass);
            branch_mass[i] = body.mass;
        }
        for body in 0..bodies.len() {
            let mut parent = Parent { body, children: [T::ZERO; B], own: [T::ZERO; B] };
            parent.own[body] = T::ONE;
            for i in body + 1..B {
                parent.children[i] = if model.parent[i] == body { T::ONE } else { T::ZERO };
            }
            if parent.children.contains(&T::ONE) {
                model.parents[model.parent_count] = parent;
                model.parent_count += 1;
            }
        }
        for i in (0..bodies.len()).rev() {
            let p = bodies[i].parent;
            if p != GROUND {
                let m = branch_mass[i];
                branch_mass[p] += m;
                model.inertia[p] += m * dot(bodies[i].pivot, bodies[i].pivot);
                model.moment[p] = add(model.moment[p], scale(bodies[i].pivot, m));
            }
        }
        for i in 0..B {
            for j in 0..=i {
                if model.carries(j, i) {
                    model.joint_inertia[j] += model.inertia[i];
                }
            }
        }
        for i in 0..bodies.len() {
            [model.moment_x[i], model.moment_y[i]] = model.moment[i];
            let moment = dot(model.moment[i], model.moment[i]).sqrt();
            model.weight[i] = gravity.abs() * moment;
            let p = bodies[i].parent;
            if p != GROUND {
                let arm = dot(bodies[i].pivot, bodies[i].pivot).sqrt();
                model.whirl[i] = arm * moment;
                model.whirl[p] += arm * moment;
            }
        }
        let known = |b: usize| b == GROUND || b < bodies.len();
        for s in springs {
            if s.body >= bodies.len() {
                return Err(ModelError::UnknownBody);
            }
            if !finite(&[s.torque, s.stiffness, s.reference]) {
                return Err(ModelError::BadNumber);
            }
            model.spring_torque[s.body] += s.torque + s.stiffness * s.reference;
            model.spring_stiffness[s.body] += s.stiffness;
        }
        for (i, zone) in zones.iter().enumerate() {
            if !known(zone.disc_body) || !known(zone.curve_body) {
                return Err(ModelError::UnknownBody);
            }
            if !zone_is_sound(zone) {
                return Err(ModelError::BadZone(i));
            }
            model.zones[i] = *zone;
            model.forms[i] = Form::of(zone);
            model.paths[i] = model.path_of(zone);
            if zone.friction.is_some() {
                model.sliding_zones[model.sliding_count] = i;
                model.sliding_count += 1;
            }
        }
        model.bending = Bending::of(zones.iter().zip(&model.paths));
        if let Some(s) = &site {
            if s.body >= bodies.len() {
                return Err(ModelError::UnknownBody);
            }
            let numbers = [s.point[0], s.point[1], s.direction[0], s.direction[1], s.stiffness, s.damping];
            if !finite(&numbers) {
                return Err(ModelError::BadNumber);
            }
            model.site_path = model.path_to(s.body, s.point);
        }
        if !gravity.finite() {
            return Err(ModelError::BadNumber);
        }
        Ok(model)
    }

    /// Whether a body turns with a joint.
    fn carries(&self, joint: usize, body: usize) -> bool {
        let mut i = body;
        while i < B && i != joint {
            i = self.parent[i];
        }
        i == joint
    }

    /// The joints between a point of a body and the ground.
    pub(crate) fn path_to(&self, body: usize, point: Vector<T>) -> Path<T, B> {
        let mut path = Path::empty();
        for j in 0..B {
            if self.carries(j, body) {
                path.push(j, T::ONE, self.extent(body, point, j));
            }
        }
        path
    }

    /// The joints that a zone's compression depends on, and their longest levers about the disc's centre.
    fn path_of(&self, zone: &Zone<T>) -> Path<T, B> {
        let mut path = Path::empty();
        for j in 0..B {
            match (self.carries(j, zone.curve_body), self.carries(j, zone.disc_body)) {
                (false, true) => path.push(j, -T::ONE, self.extent(zone.disc_body, zone.center, j)),
                (true, false) => path.push(j, T::ONE, self.distance(j, zone)),
                _ => {}
            }
        }
        path
    }

    /// The farthest that a point of a body can be from the pivot of a joint that carries it, m: all links stretched.
    fn extent(&self, body: usize, point: Vector<T>, joint: usize) -> T {
        let (mut sum, mut i) = (length(point), body);
        while i < B && i != joint {
            sum += length(self.pivot[i]);
            i = self.parent[i];
        }
        sum
    }

    /// The farthest that a zone's disc can be from the pivot of a joint that carries its curve, m.
    fn distance(&self, joint: usize, zone: &Zone<T>) -> T {
        // A point in the frame of the ground, and how far what hangs on it reaches.
        let anchor = |body: usize, point: Vector<T>| {
            let (mut at, mut reach, mut i) = (point, T::ZERO, body);
            while i < B {
                reach += length(at);
                at = self.pivot[i];
                i = self.parent[i];
            }
            (at, reach)
        };
        let (disc, disc_reach) = anchor(zone.disc_body, zone.center);
        let (pivot, pivot_reach) = anchor(self.parent[joint], self.pivot[joint]);
        length(sub(disc, pivot)) + disc_reach + pivot_reach
    }

    /// Number of zones in use.
    pub fn zone_count(&self) -> usize {
        self.zone_count
    }

    /// The zones in use.
    pub fn zones(&self) -> &[Zone<T>] {
        &self.zones[..self.zone_count]
    }

    /// The parent of a body, or [`GROUND`].
    pub fn parent(&self, body: usize) -> usize {
        self.parent[body]
    }

    /// Where the mechanism is driven.
    pub fn site(&self) -> Option<&Site<T>> {
        self.site.as_ref()
    }
}

impl<T: Real, const B: usize, const Z: usize> Model<T, B, Z> {
    /// The bodies that others are hinged on, parents first.
    #[inline(always)]
    pub(crate) fn parents(&self) -> &[Parent<T, B>] {
        &self.parents[..self.parent_count]
    }
}

fn length<T: Real>(a: Vector<T>) -> T {
    dot(a, a).sqrt()
}

fn finite<T: Scalar>(numbers: &[T]) -> bool {
    numbers.iter().all(|x| x.finite())
}

fn zone_is_sound<T: Scalar>(zone: &Zone<T>) -> bool {
    let curve = match zone.curve {
        Curve::Line { point, normal } => finite(&[point[0], point[1], normal[0], normal[1]]),
        Curve::Segment { from, direction, length, rounding } => {
            finite(&[from[0], from[1], direction[0], direction[1], length, rounding])
                && length >= T::ZERO
                && rounding >= T::ZERO
        }
        Curve::Disc { center, radius } => finite(&[center[0], center[1], radius]) && radius >= T::ZERO,
    };
    let exponent = match zone.felt.exponent {
        Exponent::Other(r) => r.finite() && r >= T::ONE,
        _ => true,
    };
    curve
        && exponent
        && finite(&[zone.center[0], zone.center[1], zone.radius, zone.felt.stiffness, zone.felt.damping])
        && zone.radius >= T::ZERO
        && zone.felt.stiffness >= T::ZERO
        && zone.felt.damping >= T::ZERO
        && zone.friction.is_none_or(|mu| mu.finite() && mu >= T::ZERO)
}

/// Fills the unused places of the zone array; never evaluated.
fn vacant<T: Real>() -> Zone<T> {
    let o = [T::ZERO; 2];
    Zone {
        disc_body: GROUND,
        center: o,
        radius: T::ZERO,
        curve_body: GROUND,
        curve: Curve::Disc { center: o, radius: T::ZERO },
        felt: Felt { stiffness: T::ZERO, exponent: Exponent::Two, damping: T::ZERO },
        friction: None,
    }
}
