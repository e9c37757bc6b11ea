//! Linear graph of a linkage, a spanning tree and its fundamental circuits.
//!
//! After Andrews and Kesavan's vector-network model in the form of Shi and
//! McPhee: a node is a frame (a body's origin or a point fixed on it), an edge is
//! a vector between two frames: a rigid arm on a body, or a joint.
//!
//! # Which tree
//! Any spanning tree gives the same number of equations; a good one gives short equations. Edges enter the tree in this
//! order:
//!
//! 1. rigid arms: their vectors are known up to the body's angle;
//! 2. revolute joints: their vector is zero;
//! 3. prismatic joints, only where nothing else connects. A prismatic joint left
//!    as a chord shows its sliding coordinate in one circuit, its own, and nowhere else.
//!
//! Among equals the edge nearest to the ground (fewest joints away) is taken first,
//! so that circuits are short. Chords are always joints; each closes one circuit.

use super::description::{JointId, JointKind, Linkage, PointId};

/// Meaning of an edge of the graph.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EdgeKind {
    /// Vector of a rigid arm from a point's base to the point.
    Arm,
    /// Zero vector of a revolute joint.
    Revolute(JointId),
    /// Vector `s u` of a prismatic joint.
    Prismatic(JointId),
}

impl EdgeKind {
    fn rank_for_tree(self) -> u8 {
        match self {
            EdgeKind::Arm => 0,
            EdgeKind::Revolute(_) => 1,
            EdgeKind::Prismatic(_) => 2,
        }
    }

    /// The joint the edge represents, if it is one.
    #[must_use]
    pub(crate) fn joint(self) -> Option<JointId> {
        match self {
            EdgeKind::Arm => None,
            EdgeKind::Revolute(joint) | EdgeKind::Prismatic(joint) => Some(joint),
        }
    }
}

/// Directed edge: the vector from one node to another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Edge {
    /// Node at which the edge starts.
    pub from: PointId,
    /// Node at which the edge ends.
    pub to: PointId,
    /// Meaning of the vector.
    pub kind: EdgeKind,
}

/// Edge on a walk through the graph, with the direction of the walk.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Traversal {
    /// Index into [`LinearGraph::edges`].
    pub edge: usize,
    /// Direction: +1 along the edge, -1 against it.
    pub sense: i32,
}

/// Fundamental circuit: one chord and the tree path that closes it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Circuit {
    /// Joint that is the chord; messages name the loop after it.
    pub chord: JointId,
    /// Edges in the order of the walk, in the direction of the chord.
    pub path: Vec<Traversal>,
}

/// Graph of a linkage with its spanning tree. Nodes are the linkage's points.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LinearGraph {
    edges: Vec<Edge>,
    in_tree: Vec<bool>,
    /// Per node: the tree edge that leads to it from the ground's side.
    parent: Vec<Option<Traversal>>,
}

impl LinearGraph {
    /// Builds graph and tree, or returns a point that no path connects to the ground.
    pub(crate) fn new(linkage: &Linkage) -> Result<Self, PointId> {
        let arms = linkage
            .points
            .iter()
            .enumerate()
            .filter_map(|(i, point)| Some(Edge { from: point.base?, to: PointId(i), kind: EdgeKind::Arm }));
        let joints = linkage.joints.iter().enumerate().map(|(i, joint)| Edge {
            from: joint.a,
            to: joint.b,
            kind: match joint.kind {
                JointKind::Revolute => EdgeKind::Revolute(JointId(i)),
                JointKind::Prismatic { .. } => EdgeKind::Prismatic(JointId(i)),
            },
        });
        let edges: Vec<Edge> = arms.chain(joints).collect();
        let nodes = linkage.points.len();

        // Prim's algorithm from the ground's origin.
        let mut in_tree = vec![false; edges.len()];
        let mut parent = vec![None; nodes];
        let mut joints_away = vec![usize::MAX; nodes];
        joints_away[0] = 0;
        for _ in 1..nodes {
            let reached = |node: PointId| joints_away[node.0] != usize::MAX;
            let next = (edges.iter().enumerate())
                .filter(|(_, edge)| reached(edge.from) != reached(edge.to))
                .min_by_key(|&(i, edge)| {
                    let near = joints_away[edge.from.0].min(joints_away[edge.to.0]);
                    (edge.kind.rank_for_tree(), near, i)
                });
            let Some((i, edge)) = next else { break };
            let (near, far, sense) =
                if reached(edge.from) { (edge.from, edge.to, 1) } else { (edge.to, edge.from, -1) };
            in_tree[i] = true;
            parent[far.0] = Some(Traversal { edge: i, sense });
            joints_away[far.0] = joints_away[near.0] + usize::from(edge.kind != EdgeKind::Arm);
        }
        match joints_away.iter().position(|&away| away == usize::MAX) {
            Some(node) => Err(PointId(node)),
            None => Ok(LinearGraph { edges, in_tree, parent }),
        }
    }

    /// Returns all edges: the arms, then the joints, each in the order of declaration.
    #[must_use]
    pub fn edges(&self) -> &[Edge] {
        &self.edges
    }

    /// Returns the indices of the edges outside the spanning tree, one per independent loop.
    pub fn chords(&self) -> impl Iterator<Item = usize> {
        (0..self.edges.len()).filter(|&i| !self.in_tree[i])
    }

    /// The tree path from the ground's origin to `node`.
    #[must_use]
    pub(crate) fn path_to(&self, node: PointId) -> Vec<Traversal> {
        let mut path = Vec::new();
        let mut at = node;
        while let Some(step) = self.parent[at.0] {
            path.push(step);
            let edge = self.edges[step.edge];
            at = if step.sense > 0 { edge.from } else { edge.to };
        }
        path.reverse();
        path
    }

    /// One circuit per chord: out along the tree to the chord's tail, across it,
    /// and home from its head. What both paths share drops out.
    #[must_use]
    pub(crate) fn circuits(&self) -> Vec<Circuit> {
        self.chords()
            .map(|chord| {
                let edge = self.edges[chord];
                let out = self.path_to(edge.from);
                let home = self.path_to(edge.to);
                let shared = out.iter().zip(&home).take_while(|(a, b)| a == b).count();
                let mut path = out[shared..].to_vec();
                path.push(Traversal { edge: chord, sense: 1 });
                path.extend(home[shared..].iter().rev().map(|step| Traversal { edge: step.edge, sense: -step.sense }));
                Circuit { chord: edge.kind.joint().expect("arms are all in the tree"), path }
            })
            .collect()
    }
}
