//! Planar non-smooth multibody dynamics: trees of hinged rigid bodies, felts between them, dry friction as a set-valued
//! law, and Moreau-Jean time-stepping. Named after Jean Jacques Moreau.
//!
//! A pendulum with a dry pivot, let go from rest at 0.5 rad. Friction takes the energy c_d times the angle swept, so
//! that the amplitudes follow from m g l (cos a1 - cos a0) = c_d (a0 + a1): 0.349759, 0.202137 and 0.055977 rad. There
//! it stays, for m g l sin a < c_d.
//!
//! ```
//! use moreau::{Body, Description, SiteInput, ModelError, StepOutcome, Settings, State, Workspace, step};
//!
//! let (mass, length, dry) = (0.010, 0.112, 8e-4);
//! let bob = Body { mass, center_of_mass: [0.0, -length], inertia: mass * length * length, dry, ..Body::inert() };
//! let description = Description { bodies: &[bob], gravity: 9.81, ..Description::default() };
//! // Room for one body, no zone, one set-valued law.
//! let model = description.compile::<1, 0>()?;
//! let mut workspace = Workspace::<f64, 1, 0, 1>::for_model(&model)?;
//!
//! let settings = Settings::new(1e-5);
//! let mut state = State::at_rest([0.5]);
//! for _ in 0..200_000 {
//!     let report = step(&model, &settings, &SiteInput::Free, &mut state, &mut workspace);
//!     assert_eq!(report.outcome, StepOutcome::Converged);
//! }
//! // After 2 s it stands on the other side, and friction holds its weight. Not slowly: not at all.
//! assert!((state.angle[0] + 0.055_977).abs() < 1e-5);
//! assert_eq!(state.velocity[0], 0.0);
//! assert!((state.pivot_friction[0] - mass * 9.81 * length * state.angle[0].sin()).abs() < 1e-9);
//! # Ok::<(), ModelError>(())
//! ```
//!
//! The inner step is [`step()`]; the head of `step.rs` lists its equations, symbols and references. The derivations are
//! in this crate's `README.md`.
//!
//! There are four types. The [`Description`] lists the parts of a mechanism, unchecked. The [`Model`] is compiled from
//! it, checked and immutable. The [`State`] is the mechanism's motion at one instant. The [`Workspace`] is the scratch
//! memory of a step; after the step it holds forces, impulses and contact points for the caller to read.
//!
//! No standard library, no heap, no unsafe code, and a step never panics, so the crate can run in firmware. It is
//! generic over the scalar ([`Real`]) and over its sizes: at most `B` bodies, `Z` zones and `N` set-valued laws.
//!
//! Units are the caller's, as long as they are consistent; the project uses SI. Angles are counter-clockwise.
#![no_std]
// Kernels index several arrays by one body number; iterators over one of them hide that.
#![allow(clippy::needless_range_loop)]

mod acceptance;
mod adaptive;
mod broad_phase;
mod compiled_zone;
mod contact;
mod coupled;
mod curvature;
mod description;
mod dry_felts;
mod dual;
mod dwell;
mod fault;
mod felt;
mod forces;
mod hand;
mod hand_energy;
mod impact;
mod input;
mod kinematics;
mod lanes;
mod law;
#[cfg(test)]
mod law_contract;
mod laws;
mod ledger;
mod linear;
mod model;
mod narrow_phase;
pub mod osnsp;
mod pose;
mod power;
mod real;
mod retrace;
mod saved;
mod settings;
mod sleep;
mod state;
mod step;
mod support;
mod surface;
mod tangent;
mod timing;
mod tracking;
mod tree;
pub mod vector;
mod workspace;

pub use adaptive::{Accuracy, ControlledStep, Controller, StepDoubling, controlled_step};
pub use contact::Contact;
pub use description::{
    Body, ContactCurve, Description, DescriptionPart, Dwell, GROUND, ModelError, Site, Spring, Yields, Zone,
};
pub use dual::Dual;
pub use fault::Fault;
pub use felt::{Felt, FeltKind};
pub use hand::SiteHand;
pub use hand_energy::HandEnergy;
pub use impact::{ImpactPredictor, PointImpact, impact_in_flight};
pub use input::{RIGID_CORRECTION, SiteInput};
pub use law::{
    Elastoplastic, Exponent, Hereditary, HuntCrossley, Iwan, LAW_NUMBERS, LAWS, LawNumber, Loss, MEMORY, Quadratic,
    Range, SetValued,
};
pub use ledger::{Energies, Ledger, LossIn, each_loss};
pub use linear::{gauss_jordan, gauss_jordan_pivoting};
pub use model::Model;
pub use osnsp::Solver;
pub use pose::Pose;
pub use real::{Aside, COSINE, Mask, Real, SINE, Scalar};
pub use saved::SavedState;
pub use settings::{FrictionLaw, Settings};
pub use sleep::{Sleep, step_or_stay};
pub use state::State;
pub use step::{LanesReport, StepOutcome, StepReport, step, step_lanes, step_out_of_line};
pub use surface::{COUPLED, Surface};
pub use tangent::{Driven, Switch, SwitchKind, Switched, SwitchingLaw, Tangent, TangentError, TangentReport};
pub use tracking::{Clearance, TrackedPoint};
pub use vector::Vector;
pub use workspace::Workspace;
