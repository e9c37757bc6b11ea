//! Vector closure equations in symbols, from the circuits of the graph.
//!
//! Every vector of a circuit is a magnitude (a constant length, or a sliding
//! coordinate) along a direction fixed on some body:
//!
//! `c · m · (cos(θ + φ), sin(θ + φ))`, `c` an integer, `θ` the body's angle, `φ` constant.
//!
//! A closure equation states that a sum of such terms vanishes. Residual, Jacobian, second derivatives and printed text
//! all derive from the same terms.

use std::collections::BTreeMap;

use super::description::{BodyId, JointId, JointKind, Length, LengthId, Linkage, PointId};
use super::direction::Direction;
use super::graph::{EdgeKind, LinearGraph, Traversal};

/// Magnitude of a term.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Magnitude {
    /// Constant length.
    Length(LengthId),
    /// Sliding coordinate of a prismatic joint.
    Sliding(JointId),
}

/// One vector of a closure equation: `coefficient · magnitude` along `direction`
/// in the frame of `frame`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Term {
    /// Small integer, nearly always ±1.
    pub coefficient: i32,
    /// Length or sliding coordinate.
    pub magnitude: Magnitude,
    /// Body with whose angle the term rotates; the ground for fixed directions.
    pub frame: BodyId,
    /// Constant direction in that frame; its number of quarter turns is 0 or 1 (x or y).
    pub direction: Direction,
}

impl Term {
    /// The order in print: lengths on moving bodies, along their x axes and then
    /// along their y axes, bodies as declared; then slidings; then the ground.
    fn place(&self) -> (u8, u8, BodyId, Magnitude, &Direction) {
        let group = match self.magnitude {
            Magnitude::Length(_) if self.frame.0 > 0 => 0,
            Magnitude::Sliding(_) => 1,
            Magnitude::Length(_) => 2,
        };
        (group, self.direction.quarters, self.frame, self.magnitude, &self.direction)
    }
}

/// Vector closure equation of one independent loop: the sum of its terms is zero.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Closure {
    /// Joint that closes the loop (the chord).
    pub chord: JointId,
    /// Bodies that the loop passes, in order, without repetition.
    pub bodies: Vec<BodyId>,
    /// Terms in printing order; the first is positive.
    pub terms: Vec<Term>,
}

/// Which bodies turn together because prismatic joints hold them: for every body
/// the leader of its group (the first-declared with an angle symbol) and the
/// constant angle against it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Orientations {
    pub leader: Vec<BodyId>,
    pub turned: Vec<Direction>,
    /// Prismatic joints that repeat what others already enforce about the angles.
    pub repeated: Vec<JointId>,
}

impl Orientations {
    /// Returns the joint whose constant angle contradicts the others, if one does.
    pub(crate) fn new(linkage: &Linkage) -> Result<Self, JointId> {
        let slides: Vec<(JointId, BodyId, BodyId, &Direction)> = (linkage.joints.iter())
            .enumerate()
            .filter_map(|(i, joint)| match &joint.kind {
                JointKind::Prismatic { turned, .. } => {
                    let (a, b) = (linkage.body_of(joint.a), linkage.body_of(joint.b));
                    Some((JointId(i), a, b, turned))
                }
                JointKind::Revolute => None,
            })
            .collect();
        let mut known: Vec<Option<(BodyId, Direction)>> = vec![None; linkage.bodies.len()];
        let mut used = Vec::new();
        // A body with an angle of its own leads its group; the ground leads all.
        let own_angle = |&i: &usize| i == 0 || linkage.bodies[i].symbol.is_some();
        let (with, without): (Vec<usize>, Vec<usize>) = (0..known.len()).partition(own_angle);
        for leader in with.into_iter().chain(without) {
            if known[leader].is_some() {
                continue;
            }
            known[leader] = Some((BodyId(leader), Direction::X));
            let mut grown = true;
            while grown {
                grown = false;
                for &(joint, a, b, turned) in &slides {
                    let next = match (&known[a.0], &known[b.0]) {
                        (Some((l, at)), None) => (b, *l, at.clone() + turned.clone()),
                        (None, Some((l, at))) => (a, *l, at.clone() + -turned.clone()),
                        _ => continue,
                    };
                    known[next.0.0] = Some((next.1, next.2));
                    used.push(joint);
                    grown = true;
                }
            }
        }
        let (leader, turned): (Vec<_>, Vec<_>) = known.into_iter().flatten().unzip();
        let mut repeated = Vec::new();
        for &(joint, a, b, between) in &slides {
            if used.contains(&joint) {
                continue;
            }
            let gap = turned[a.0].clone() + between.clone() + -turned[b.0].clone();
            let [c, s] = gap.cos_sin(&linkage.angles);
            // Constant angles that users computed themselves agree to rounding.
            if c < 0.0 || s.abs() > 1e-12 {
                return Err(joint);
            }
            repeated.push(joint);
        }
        Ok(Orientations { leader, turned, repeated })
    }
}

/// The terms met on a walk through the graph, like terms collected, in print order.
pub(crate) fn terms_along(
    linkage: &Linkage,
    graph: &LinearGraph,
    orientations: &Orientations,
    path: &[Traversal],
) -> Vec<Term> {
    let mut sum: BTreeMap<(Magnitude, BodyId, Direction), i32> = BTreeMap::new();
    let mut add = |coefficient: i32, magnitude, body: BodyId, along: Direction| {
        let mut direction = orientations.turned[body.0].clone() + along;
        let opposite = direction.quarters >= 2;
        direction.quarters %= 2;
        let key = (magnitude, orientations.leader[body.0], direction);
        *sum.entry(key).or_default() += if opposite { -coefficient } else { coefficient };
    };
    for step in path {
        let edge = graph.edges()[step.edge];
        match edge.kind {
            EdgeKind::Arm => {
                let arm = &linkage.points[edge.to.0];
                for (length, axis) in [(arm.x, Direction::X), (arm.y, Direction::Y)] {
                    match length {
                        Length::Zero => {}
                        Length::Plus(id) => add(step.sense, Magnitude::Length(id), arm.body, axis),
                        Length::Minus(id) => {
                            add(-step.sense, Magnitude::Length(id), arm.body, axis);
                        }
                    }
                }
            }
            EdgeKind::Revolute(_) => {}
            EdgeKind::Prismatic(joint) => {
                if let JointKind::Prismatic { along, .. } = &linkage.joints[joint.0].kind {
                    let carrier = linkage.body_of(edge.from);
                    add(step.sense, Magnitude::Sliding(joint), carrier, along.clone());
                }
            }
        }
    }
    let mut terms: Vec<Term> = sum
        .into_iter()
        .filter(|&(_, coefficient)| coefficient != 0)
        .map(|((magnitude, frame, direction), coefficient)| Term { coefficient, magnitude, frame, direction })
        .collect();
    terms.sort_by(|a, b| a.place().cmp(&b.place()));
    terms
}

/// One closure equation per fundamental circuit. The sense of each walk is chosen
/// so that the first term is positive: a vector equation may be negated as a whole.
pub(crate) fn closures(linkage: &Linkage, graph: &LinearGraph, orientations: &Orientations) -> Vec<Closure> {
    (graph.circuits().into_iter())
        .map(|circuit| {
            let mut terms = terms_along(linkage, graph, orientations, &circuit.path);
            if terms.first().is_some_and(|term| term.coefficient < 0) {
                for term in &mut terms {
                    term.coefficient = -term.coefficient;
                }
            }
            let mut bodies = Vec::new();
            for step in &circuit.path {
                let edge = graph.edges()[step.edge];
                let ends: [PointId; 2] = if step.sense > 0 { [edge.from, edge.to] } else { [edge.to, edge.from] };
                for body in ends.map(|node| linkage.body_of(node)) {
                    if !bodies.contains(&body) {
                        bodies.push(body);
                    }
                }
            }
            Closure { chord: circuit.chord, bodies, terms }
        })
        .collect()
}
