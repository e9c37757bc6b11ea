//! Planar linkages from their linear graph: closure equations as text, and poses, velocities and accelerations from
//! them. It knows nothing of pianos: the three levers are one linkage that it can describe, in [`crate::three_lever`].
//!
//! The crate's `README.md` has the method and its limits.

mod closure;
mod description;
mod direction;
mod elimination;
mod equation;
mod graph;
mod mechanism;
mod mobility;
mod newton;
mod vectors;
mod walk;

pub mod closed_form;

pub use closure::{Closure, Magnitude, Term};
pub use description::{
    AngleId, Body, BodyId, Constant, Contact, CoordinateId, Joint, JointId, JointKind, Length, LengthId, Linkage,
    Point, PointId,
};
pub use direction::Direction;
pub use equation::{Axis, Equation, EquationTerm, Trig, latex_align};
pub use graph::{Circuit, Edge, EdgeKind, LinearGraph, Traversal};
pub use mechanism::{AssembleError, Coordinate, CoordinateKind, LinkageMechanism, Pose};
pub use mobility::{Mobility, Redundancy, Verdict};
pub use newton::{MAX_ITERATIONS, NewtonOutcome, NewtonReport, TOLERANCE};
pub use walk::{StartError, Stop, StopKind, Sweep, SweptPose, Walk};
