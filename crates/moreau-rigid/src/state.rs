//! State of the bodies, and settings of a step.

use super::mixed::Mode;
use super::placement::{Placement, Twist};
use moreau::Scalar;

/// State of a mechanism of at most `B` bodies and `N` laws: everything that the next step depends on.
#[derive(Debug, Clone, PartialEq)]
pub struct State<T, const B: usize, const N: usize> {
    /// Placement of each body.
    pub placement: [Placement<T>; B],
    /// Velocity of each body.
    pub velocity: [Twist<T>; B],
    /// Impulses of the laws over the last step, N s or N m s; they warm-start the next one.
    pub impulse: [T; N],
    /// Mode of each law in the last step.
    pub mode: [Mode; N],
}

impl<T: Scalar, const B: usize, const N: usize> State<T, B, N> {
    /// Returns a state with given placements and velocities. Bodies that `bodies` does not list are at rest at the
    /// origin.
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

/// Impact law: the meaning of a contact's coefficient of restitution e.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ImpactLaw {
    /// Newton's law: a contact separates with e times the speed at which it closed. It is solved together with the
    /// other laws of the step. With friction or several contacts an impact may create energy (Kane's paradox), which
    /// [`super::StepReport::impact_energy`] reports.
    Newton,
    /// Stronge's law: the normal impulse of a contact returns e squared of the work that it took. The impact, including
    /// friction, is integrated in the space of impulses before the rest of the step. It never creates energy.
    Stronge,
}

/// Settings of a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings<T> {
    /// Step h, s. On smooth motion at theta = 1/2 errors fall with the square of the step; across impacts and reversals
    /// they fall linearly.
    pub step: T,
    /// Parameter theta of the theta-method, in [1/2, 1].
    pub theta: T,
    /// Tolerance of the iteration on forces and rows: it ends when no velocity changes by more than this times (1 +
    /// |velocity|). 1e-11 is usual. Each iteration gains two or three digits, so that the remaining error is far
    /// smaller.
    pub tolerance: T,
    /// Largest number of iterations on forces and rows; three to six are usual.
    pub iteration_limit: u32,
    /// Tolerance of a law's velocity, times (1 + |largest velocity|). 1e-12 is usual.
    pub solver_tolerance: T,
    /// Largest number of guesses that are enumerated in one one-step problem. Their number is a product with a factor
    /// of four per contact and three per dry joint. If it exceeds this limit, none are enumerated, and the result of
    /// the sweeps is used.
    pub solver_limit: u32,
    /// Largest number of projected Gauss-Seidel sweeps in one one-step problem.
    pub sweep_limit: u32,
    /// Impact law of contacts.
    pub impact_law: ImpactLaw,
    /// Largest opening of a joint after a step, m or rad; a larger one is corrected. 1e-12 is usual.
    pub position_tolerance: T,
    /// Distance at which a contact counts as closed, m. It must be larger than rounding but negligible. 1e-10 is usual.
    pub contact_tolerance: T,
}

impl<T: Scalar> Settings<T> {
    /// Returns the usual settings at step `h` (s): theta = 1/2.
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
