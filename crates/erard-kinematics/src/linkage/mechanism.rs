//! Checked linkage with its equations, ready for solving.

use super::closure::{Closure, Orientations, Term, closures, terms_along};
use super::description::{BodyId, CoordinateId, JointId, JointKind, Linkage, PointId, Prescribed};
use super::equation::{Equation, Symbols, equations};
use super::graph::LinearGraph;
use super::vectors::{Places, VectorSums};

/// Quantity that a coordinate measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CoordinateKind {
    /// Absolute angle of a body (and of the bodies fixed to it), radians.
    Angle(BodyId),
    /// Sliding coordinate of a prismatic joint, metres.
    Sliding(JointId),
}

/// Coordinate of a mechanism.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Coordinate {
    /// Symbol in the equations.
    pub symbol: String,
    /// Kind: angle (radians) or sliding (metres).
    pub kind: CoordinateKind,
    /// Whether the caller gives the coordinate; otherwise it is solved for.
    pub prescribed: bool,
}

/// Values of all coordinates of a mechanism: first the angles (rad), then the slidings (m).
#[derive(Clone, Debug, PartialEq)]
pub struct Pose {
    pub(crate) values: Vec<f64>,
}

impl Pose {
    /// Returns all values, in the order of [`LinkageMechanism::coordinates`].
    #[must_use]
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Returns one value: radians or metres.
    #[must_use]
    pub fn value(&self, coordinate: CoordinateId) -> f64 {
        self.values[coordinate.0]
    }

    /// Sets one value: radians or metres. Use it to build guesses; a solved pose changed in this way is only a guess.
    pub fn set(&mut self, coordinate: CoordinateId, value: f64) {
        self.values[coordinate.0] = value;
    }
}

/// Error: the first fault found in a [`Linkage`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum AssembleError {
    /// Two coordinates, lengths or angles share a name.
    #[error("the symbol `{0}` is used twice; every length, angle and coordinate needs its own")]
    RepeatedSymbol(String),
    /// A name is empty or contains characters that are not allowed in an equation.
    #[error("`{0}` cannot be a symbol: letters, digits and _ only, starting with a letter")]
    BadSymbol(String),
    /// A constant is infinite or not a number.
    #[error("the constant {0} is not a finite number")]
    NotFinite(String),
    /// Both points of a joint are on one body.
    #[error("joint `{joint}` joins body `{body}` to itself")]
    JoinsItself {
        /// The joint's name.
        joint: String,
        /// The body's name.
        body: String,
    },
    /// No chain of joints connects a body to the ground.
    #[error("body `{0}` is not connected to the ground by any chain of joints")]
    Disconnected(String),
    /// A body has no angle symbol, and no prismatic joint fixes it to another body.
    #[error("body `{0}` has no angle of its own and no prismatic joint to take one from")]
    NoAngle(String),
    /// Prismatic joints in a loop require different constant angles.
    #[error("prismatic joint `{0}` demands a constant angle that contradicts the other prismatic joints")]
    ContradictoryAngles(String),
    /// The prescribed coordinate does not exist.
    #[error("`{0}` cannot be prescribed: it is not a free coordinate (the ground, a body held to it, or a pin)")]
    NotACoordinate(String),
    /// A coordinate is prescribed twice.
    #[error("`{0}` is prescribed twice")]
    PrescribedTwice(String),
}

/// A linkage with its graph, its coordinates and its closure equations.
#[derive(Clone, Debug)]
pub struct LinkageMechanism {
    linkage: Linkage,
    graph: LinearGraph,
    coordinates: Vec<Coordinate>,
    angles: usize,
    unknown: Vec<usize>,
    prescribed: Vec<usize>,
    closures: Vec<Closure>,
    equations: Vec<Equation>,
    repeated: Vec<JointId>,
    scale: f64,
    pub(crate) loops: VectorSums,
    points: VectorSums,
}

impl Linkage {
    /// Checks the linkage, builds its graph and derives its closure equations.
    ///
    /// # Errors
    /// Returns the first fault found, with the user's names. It does not check whether the equations can be *solved*;
    /// see [`LinkageMechanism::mobility`].
    pub fn assemble(self) -> Result<LinkageMechanism, AssembleError> {
        LinkageMechanism::new(self)
    }
}

impl LinkageMechanism {
    fn new(linkage: Linkage) -> Result<Self, AssembleError> {
        check(&linkage)?;
        let graph = LinearGraph::new(&linkage).map_err(|point| {
            let body = linkage.body_of(point);
            AssembleError::Disconnected(linkage.bodies[body.0].name.clone())
        })?;
        let orientations = Orientations::new(&linkage)
            .map_err(|joint| AssembleError::ContradictoryAngles(linkage.joints[joint.0].name.clone()))?;

        let mut coordinates = Vec::new();
        let mut angle_of_leader = vec![None; linkage.bodies.len()];
        for (i, body) in linkage.bodies.iter().enumerate().skip(1) {
            if orientations.leader[i] != BodyId(i) {
                continue;
            }
            let symbol = (body.symbol.clone()).ok_or_else(|| AssembleError::NoAngle(body.name.clone()))?;
            angle_of_leader[i] = Some(coordinates.len());
            coordinates.push(Coordinate { symbol, kind: CoordinateKind::Angle(BodyId(i)), prescribed: false });
        }
        let angles = coordinates.len();
        let angle_of: Vec<Option<usize>> =
            (orientations.leader.iter()).map(|leader| angle_of_leader[leader.0]).collect();
        let mut sliding_of = vec![None; linkage.joints.len()];
        for (i, joint) in linkage.joints.iter().enumerate() {
            if let JointKind::Prismatic { symbol, .. } = &joint.kind {
                sliding_of[i] = Some(coordinates.len());
                coordinates.push(Coordinate {
                    symbol: symbol.clone(),
                    kind: CoordinateKind::Sliding(JointId(i)),
                    prescribed: false,
                });
            }
        }
        let mut prescribed = Vec::new();
        for &wanted in &linkage.prescribed {
            let (place, name) = match wanted {
                // The coordinate is the leader's angle, so only the leader may be named.
                Prescribed::Angle(body) => (angle_of_leader[body.0], &linkage.bodies[body.0].name),
                Prescribed::Sliding(joint) => (sliding_of[joint.0], &linkage.joints[joint.0].name),
            };
            let place = place.ok_or_else(|| AssembleError::NotACoordinate(name.clone()))?;
            if coordinates[place].prescribed {
                let symbol = coordinates[place].symbol.clone();
                return Err(AssembleError::PrescribedTwice(symbol));
            }
            coordinates[place].prescribed = true;
            prescribed.push(place);
        }
        let unknown = (0..coordinates.len()).filter(|&i| !coordinates[i].prescribed).collect();

        let closures = closures(&linkage, &graph, &orientations);
        let symbols = Symbols((linkage.bodies.iter()).map(|body| body.symbol.clone().unwrap_or_default()).collect());
        let equations = equations(&linkage, &symbols, &closures);

        let largest = (linkage.lengths.iter()).map(|l| l.value.abs()).fold(0.0, f64::max);
        let scale = if largest > 0.0 { largest } else { 1.0 };
        let places = Places { angle: &angle_of, sliding: &sliding_of };
        let loop_terms: Vec<&[Term]> = closures.iter().map(|c| c.terms.as_slice()).collect();
        let loops = VectorSums::new(&linkage, &places, scale, &loop_terms);
        let point_terms: Vec<Vec<Term>> = (0..linkage.points.len())
            .map(|i| terms_along(&linkage, &graph, &orientations, &graph.path_to(PointId(i))))
            .collect();
        let point_terms: Vec<&[Term]> = point_terms.iter().map(Vec::as_slice).collect();
        let points = VectorSums::new(&linkage, &places, scale, &point_terms);
        Ok(LinkageMechanism {
            graph,
            coordinates,
            angles,
            unknown,
            prescribed,
            closures,
            equations,
            repeated: orientations.repeated,
            scale,
            loops,
            points,
            linkage,
        })
    }

    /// Returns the linkage as the user stated it.
    #[must_use]
    pub fn linkage(&self) -> &Linkage {
        &self.linkage
    }

    /// Returns the linear graph with its spanning tree.
    #[must_use]
    pub fn graph(&self) -> &LinearGraph {
        &self.graph
    }

    /// Returns the vector closure equations, one per independent loop.
    #[must_use]
    pub fn closures(&self) -> &[Closure] {
        &self.closures
    }

    /// Returns the scalar closure equations: x and y of each loop in turn.
    #[must_use]
    pub fn equations(&self) -> &[Equation] {
        &self.equations
    }

    /// Returns the coordinates in the order of a pose's values: angles, then slidings.
    #[must_use]
    pub fn coordinates(&self) -> &[Coordinate] {
        &self.coordinates
    }

    /// Returns the coordinate with this symbol; `None` if there is none.
    #[must_use]
    pub fn coordinate(&self, symbol: &str) -> Option<CoordinateId> {
        (self.coordinates.iter()).position(|c| c.symbol == symbol).map(CoordinateId)
    }

    /// The prescribed coordinates, in the order in which they were prescribed.
    pub(crate) fn prescribed(&self) -> impl ExactSizeIterator<Item = CoordinateId> + '_ {
        self.prescribed.iter().map(|&i| CoordinateId(i))
    }

    /// Returns the coordinates that are solved for.
    pub fn unknown(&self) -> impl ExactSizeIterator<Item = CoordinateId> + '_ {
        self.unknown.iter().map(|&i| CoordinateId(i))
    }

    /// Returns the largest constant length (metres), to which residuals are relative.
    #[must_use]
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// Returns a pose of zeros, to be filled as a first guess.
    #[must_use]
    pub fn zero_pose(&self) -> Pose {
        Pose { values: vec![0.0; self.coordinates.len()] }
    }

    /// Returns the largest residual of the closure equations at `pose`, over [`LinkageMechanism::scale`]: a
    /// dimensionless number.
    #[must_use]
    pub fn residual(&self, pose: &Pose) -> f64 {
        let (sums, _) = self.sums(&self.loops, self.closures.len(), pose);
        largest(&sums)
    }

    /// Returns the position of `point` in the world, m.
    #[must_use]
    pub fn position(&self, pose: &Pose, point: PointId) -> [f64; 2] {
        let (sums, _) = self.sums(&self.points, self.linkage.points.len(), pose);
        [2 * point.0, 2 * point.0 + 1].map(|i| sums[i] * self.scale)
    }

    /// Returns the velocity of `point` (m per unit time, world frame) when all coordinates change at `rates` (rad and m
    /// per unit time).
    #[must_use]
    pub fn velocity(&self, pose: &Pose, rates: &[f64], point: PointId) -> [f64; 2] {
        let (_, jacobian) = self.sums(&self.points, self.linkage.points.len(), pose);
        let n = self.coordinates.len();
        [2 * point.0, 2 * point.0 + 1].map(|row| {
            let row = &jacobian[row * n..(row + 1) * n];
            let scaled = |i: usize| if i < self.angles { self.scale } else { 1.0 };
            (row.iter().zip(rates).enumerate()).map(|(i, (d, rate))| d * rate * scaled(i)).sum()
        })
    }

    fn sums(&self, of: &VectorSums, count: usize, pose: &Pose) -> (Vec<f64>, Vec<f64>) {
        let n = self.coordinates.len();
        let mut trig = vec![[0.0; 2]; self.angles];
        self.fill_trig(&pose.values, &mut trig);
        let mut sums = vec![0.0; 2 * count];
        let mut jacobian = vec![0.0; 2 * count * n];
        of.linearise(&pose.values, &trig, &mut sums, &mut jacobian);
        (sums, jacobian)
    }

    /// Returns the Jacobian of the closure equations at `pose`, row-major, one row per equation and one column per
    /// coordinate. It is dimensionless (angles per radian, slidings per [`LinkageMechanism::scale`]).
    #[must_use]
    pub fn jacobian(&self, pose: &Pose) -> Vec<f64> {
        self.sums(&self.loops, self.closures.len(), pose).1
    }

    pub(crate) fn fill_trig(&self, q: &[f64], trig: &mut [[f64; 2]]) {
        for (t, angle) in trig.iter_mut().zip(q) {
            let (s, c) = angle.sin_cos();
            *t = [c, s];
        }
    }

    pub(crate) fn angle_count(&self) -> usize {
        self.angles
    }

    pub(crate) fn unknown_places(&self) -> &[usize] {
        &self.unknown
    }

    pub(crate) fn prescribed_places(&self) -> &[usize] {
        &self.prescribed
    }

    pub(crate) fn repeated_angles(&self) -> &[JointId] {
        &self.repeated
    }
}

/// The largest absolute value; NaN if there is one, never hidden.
pub(crate) fn largest(values: &[f64]) -> f64 {
    (values.iter()).fold(0.0, |most: f64, x| if x.abs() <= most || most.is_nan() { most } else { x.abs() })
}

fn check(linkage: &Linkage) -> Result<(), AssembleError> {
    let constants = linkage.lengths.iter().chain(&linkage.angles);
    for (i, constant) in constants.clone().enumerate() {
        if !constant.value.is_finite() {
            let name = constant.name.clone().unwrap_or_else(|| format!("number {}", i + 1));
            return Err(AssembleError::NotFinite(name));
        }
    }
    let slidings = linkage.joints.iter().filter_map(|joint| match &joint.kind {
        JointKind::Prismatic { symbol, .. } => Some(symbol),
        JointKind::Revolute => None,
    });
    let symbols = (linkage.bodies.iter().filter_map(|body| body.symbol.as_ref()))
        .chain(slidings)
        .chain(constants.filter_map(|constant| constant.name.as_ref()));
    let mut seen = Vec::new();
    for symbol in symbols {
        let sound = symbol.starts_with(char::is_alphabetic) && symbol.chars().all(|c| c.is_alphanumeric() || c == '_');
        if !sound {
            return Err(AssembleError::BadSymbol(symbol.clone()));
        }
        if seen.contains(&symbol) {
            return Err(AssembleError::RepeatedSymbol(symbol.clone()));
        }
        seen.push(symbol);
    }
    for joint in &linkage.joints {
        let body = linkage.body_of(joint.a);
        if body == linkage.body_of(joint.b) {
            return Err(AssembleError::JoinsItself {
                joint: joint.name.clone(),
                body: linkage.bodies[body.0].name.clone(),
            });
        }
    }
    Ok(())
}
