//! Where the bodies are, and how a step is to be taken.

use super::mixed::Mode;
use super::placement::{Placement, Twist};
use moreau::Scalar;

/// State of a mechanism: everything that the next step depends on. `B` bodies at most, `N` laws.
#[derive(Debug, Clone, PartialEq)]
pub struct State<T, const B: usize, const N: usize> {
    /// Placement of each body.
    pub placement: [Placement<T>; B],
    /// Velocity of each body.
    pub velocity: [Twist<T>; B],
    /// Impulses of the laws over the last step, N s or N m s; warm-start the next one.
    pub impulse: [T; N],
    /// Mode of each law in the last step.
    pub mode: [Mode; N],
}

impl<T: Scalar, const B: usize, const N: usize> State<T, B, N> {
    /// At given placements and velocities; bodies without one are at the origin, at rest.
    pub fn new(bodies: &[(Placement<T>, Twist<T>)]) -> Self {
        let mut state = State {
            placement: [Placement::origin(); B],
            velocity: [[T::ZERO; 3]; B],
            impulse: [T::ZERO; N],
            mode: [Mode::Hold; N],
        };
        for (i, (placement, velocity)) in bodies.iter().enumerate().take(B) {
            state.placement[i] = *placement;
            state.velocity[i] = *velocity;
        }
        state
    }
}

/// Meaning of the coefficient of restitution e of a contact.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ImpactLaw {
    /// Newton's: a contact parts with e times the speed with which it closed. Simple, solved with the other laws of the
    /// step at once; with friction or several contacts an impact may give energy (Kane's paradox), which
    /// [`super::StepReport::impact_energy`] tells.
    Newton,
    /// Stronge's: a contact's normal impulse gives back e squared of the work that it took. The impact is followed
    /// through in the space of impulses before the rest of the step, friction with it, and takes energy whatever the
    /// contacts are.
    Stronge,
}

/// Settings of a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings<T> {
    /// Step h, s. Errors fall with its square on smooth motion at theta = 1/2, with itself across impacts and
    /// reversals.
    pub step: T,
    /// theta of the theta-method, in [1/2, 1].
    pub theta: T,
    /// The iteration on forces and rows ends when no velocity changes by more than this times (1 + |velocity|). 1e-11
    /// is usual: each iteration gains two or three digits, so that what is left is far less.
    pub tolerance: T,
    /// Largest number of those iterations; three to six are usual.
    pub iteration_limit: u32,
    /// Tolerance of a law's velocity, times (1 + |largest velocity|). 1e-12 is usual.
    pub solver_tolerance: T,
    /// Most guesses that are tried in order in one one-step problem. Four for every contact and three for every dry
    /// joint, multiplied, are all that there are; where that is more than this limit none are tried in order, and what
    /// the sweeps found is taken.
    pub solver_limit: u32,
    /// Most sweeps of projected Gauss-Seidel in one one-step problem.
    pub sweep_limit: u32,
    /// Law of colliding contacts.
    pub impact_law: ImpactLaw,
    /// Largest opening of a joint after a step, m or rad, before its position is corrected again. 1e-12 is usual.
    pub position_tolerance: T,
    /// A contact is closed from this distance on, m: more than rounding, less than matters. 1e-10 is usual.
    pub contact_tolerance: T,
}

impl<T: Scalar> Settings<T> {
    /// The usual settings at step `h`: theta = 1/2.
    pub fn new(h: T) -> Self {
        let at_least = |x: f64, ulps: f64| T::from_f64(x).max(T::from_f64(ulps) * T::EPSILON);
        Settings {
            step: h,
            theta: T::from_f64(0.5),
            tolerance: at_least(1e-11, 64.0),
            iteration_limit: 30,
            solver_tolerance: at_least(1e-12, 256.0),
            solver_limit: 5_000,
            sweep_limit: 200,
            impact_law: ImpactLaw::Newton,
            position_tolerance: at_least(1e-12, 64.0),
            contact_tolerance: at_least(1e-10, 64.0),
        }
    }
}
