//! Rigid bodies in the plane with hinges, slides, slots, closed loops, springs, impacts, moving surfaces, and rigid
//! unilateral contacts of discs, lines, plates and convex polygons. The papers' inclusion M dv + F dt = di covers all
//! of these; the piano action does not need them.
//!
//! The step of the action has one angle per body, in a tree. Here a body has three coordinates (its centre of mass and
//! its angle), and every joint is a pair of equalities. The mass matrix is then constant and diagonal, there are no
//! centrifugal terms, and a closed loop needs only one more joint. The price is a larger problem, which does not
//! matter: these mechanisms are small, and the action is not computed with this step.
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
pub use step::{StepOutcome, StepReport, step};
pub use touch::ContactPoint;
pub use workspace::Workspace;
