//! Rigid bodies in the plane with hinges, slides, slots, closed loops, springs, rigid unilateral contacts of discs,
//! lines, plates and convex polygons, impacts and moving surfaces: what the papers' inclusion M dv + F dt = di also
//! admits and the piano action does not need.
//!
//! Where the action's step has one angle per body and a tree, a body here has three coordinates (its centre of mass and
//! its angle) and every joint is a pair of equalities. The mass matrix is then constant and diagonal, there are no
//! centrifugal terms, and closing a loop is one more joint. The price is size; these mechanisms are small and their
//! step is not the action's.
//!
//! [`step()`] is the Moreau-Jean theta step; the equations are in this crate's `README.md`. [`problems`] holds textbook
//! problems with known answers.

// Matrix problems index several arrays by one number.
#![allow(clippy::needless_range_loop)]

mod contact;
mod eliminate;
mod forces;
mod impact;
mod implicit;
mod laws;
mod mixed;
mod model;
mod painleve;
mod placement;
pub mod problems;
mod projection;
mod rows;
mod state;
mod step;
mod sweeps;
mod touch;
mod workspace;

pub use contact::{Contact, PolygonContact, Surface};
pub use forces::Energies;
pub use mixed::{Mode, SolvedBy};
pub use model::{Body, Joint, JointKind, Model, ModelError, Spring, Torsion};
pub use placement::{Placement, Twist};
pub use state::{ImpactLaw, Settings, State};
pub use step::{Outcome, StepReport, step};
pub use touch::ContactPoint;
pub use workspace::Workspace;
