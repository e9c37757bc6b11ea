//! Rigid bodies in the plane with hinges, slides, closed loops, rigid unilateral contacts and moving surfaces: what the papers'
//! inclusion M dv + F dt = di also admits and the piano action does not need.
//!
//! Where the action's step has one angle per body and a tree, a body here has three coordinates (its centre of mass and its
//! angle) and every joint is a pair of equalities. The mass matrix is then constant and diagonal, there are no centrifugal
//! terms, and closing a loop is one more joint. The price is size; these mechanisms are small and their step is not the
//! action's.
//!
//! [`step()`] is the Moreau-Jean theta step; the equations are in this crate's `README.md`, "Rigid contacts and joints".

mod forces;
mod mixed;
mod model;
mod projection;
mod rows;
mod state;
mod step;

pub use forces::Energies;
pub use mixed::Mode;
pub use model::{Body, Contact, Joint, JointKind, Model, ModelError, Spring, Surface};
pub use state::{Placement, Scratch, Settings, State, Twist};
pub use step::{Outcome, StepReport, step};
