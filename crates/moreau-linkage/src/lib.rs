#![doc = include_str!("../README.md")]

mod closure;
mod direction;
mod elimination;
mod equation;
mod graph;
mod linkage;
mod mechanism;
mod mobility;
mod newton;
mod vectors;
mod walk;

pub mod closed_form;
pub mod three_lever;

pub use closure::{Closure, Magnitude, Term};
pub use direction::Direction;
pub use equation::{Axis, Equation, EquationTerm, Trig, latex_align};
pub use graph::{Circuit, Edge, EdgeKind, LinearGraph, Traversal};
pub use linkage::{
    AngleId, Body, BodyId, Constant, Contact, CoordinateId, Joint, JointId, JointKind, Length, LengthId, Linkage,
    Point, PointId,
};
pub use mechanism::{AssembleError, Coordinate, CoordinateKind, Mechanism, Pose};
pub use mobility::{Mobility, Redundancy, Verdict};
pub use newton::{MOST_ITERATIONS, NewtonReport, Outcome, TOLERANCE};
pub use walk::{StartError, Stop, StopKind, Sweep, SweptPose, Walk};
