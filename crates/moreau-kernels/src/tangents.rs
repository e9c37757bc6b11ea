//! One mechanism with the derivatives of its motion.

use moreau::{
    Driven, Dual, Model, Pose, Real, SavedState, Settings, State, Switched, Tangent, TangentError, TangentReport,
    TrackedPoint,
};

use crate::{OwnedDescription, Size};

/// Number of directions in one pass.
pub const DIRECTIONS: usize = 8;
/// A number with its derivatives in the directions of one pass.
pub type Number = Dual<DIRECTIONS>;

/// A mechanism with the derivatives of its motion. Indices have the order of the description's bodies and zones.
pub trait Tangents: Send {
    /// Advances by `settings.step`. `switched` receives every switch of friction within the step.
    fn step(
        &mut self,
        settings: &Settings<f64>,
        input: &mut Driven<'_, DIRECTIONS>,
        switched: &mut Switched<'_>,
    ) -> TangentReport;
    /// Continues from another state.
    fn begin(&mut self, state: &SavedState<Number, 12, 32>);
    /// Makes derivatives continue unchanged across switches that cannot be separated ([`Tangent::passes_unresolved`]).
    fn pass_unresolved(&mut self);
    /// Returns the hand's world coordinate along the drive's direction, m, and its velocity, m/s.
    fn hand(&self) -> [Number; 2];
    /// Returns the world coordinate of the driven point along the drive's direction, m.
    fn site_position(&self) -> Number;
    /// Returns the force of the site's spring and damper, N, for a driver at this position (m, as
    /// [`Self::site_position`]) with this velocity, m/s; 0 if the driver does not touch.
    fn push(&self, position: Number, velocity: Number) -> Number;
    /// Returns the compression of a zone, m; negative when it is open.
    fn compression(&self, zone: usize) -> Number;
    /// Returns the normal force of a zone during the last inner step, N, and the length of that step, s.
    fn normal_force(&self, settings: &Settings<f64>, zone: usize) -> (Number, f64);
    /// Returns position, m, and velocity, m/s, in the world of a point of a body. `point` is in the body's frame, m.
    fn motion(&self, body: usize, point: [Number; 2]) -> [[Number; 2]; 2];
    /// Returns the absolute angles, rad.
    fn angles(&self) -> &[Number];
    /// Returns the absolute angular velocities, rad/s.
    fn velocities(&self) -> &[Number];
}

/// Builds the tangents of a mechanism at rest at its described angles. `slopes`: the derivative of every number of the
/// description ([`OwnedDescription::numbers`]) in every direction.
///
/// # Errors
/// Returns [`TangentError`] if the mechanism has a part without derivatives or is too large.
pub fn tangents(
    description: &OwnedDescription,
    slopes: &[[f64; DIRECTIONS]],
) -> Result<Box<dyn Tangents>, TangentError> {
    // Two sizes are enough where speed matters less than what has to be compiled.
    let most = Size::of(description) == Size::Most;
    if most { boxed::<12, 32, 77>(description, slopes) } else { boxed::<9, 20, 50>(description, slopes) }
}

fn boxed<const B: usize, const Z: usize, const N: usize>(
    description: &OwnedDescription,
    slopes: &[[f64; DIRECTIONS]],
) -> Result<Box<dyn Tangents>, TangentError> {
    let slopes = slopes.iter().copied().chain(std::iter::repeat([0.0; DIRECTIONS]));
    let numbers = description.numbers().into_iter().zip(slopes).map(|(value, slope)| Number { value, slope });
    let own = description.with_numbers(numbers);
    let model: Model<Number, B, Z> = own.model().map_err(TangentError::Model)?;
    let plain: Model<f64, B, Z> = description.model().map_err(TangentError::Model)?;
    let tangent = Tangent::new(model, plain, own.first_angles())?;
    Ok(Box::new(Differentiated::<B, Z, N> { tangent, bodies: description.bodies.len() }))
}

struct Differentiated<const B: usize, const Z: usize, const N: usize> {
    tangent: Tangent<B, Z, N, DIRECTIONS>,
    bodies: usize,
}

impl<const B: usize, const Z: usize, const N: usize> Tangents for Differentiated<B, Z, N> {
    fn step(
        &mut self,
        settings: &Settings<f64>,
        input: &mut Driven<'_, DIRECTIONS>,
        switched: &mut Switched<'_>,
    ) -> TangentReport {
        self.tangent.step(settings, input, switched)
    }

    fn begin(&mut self, state: &SavedState<Number, 12, 32>) {
        self.tangent.state = State::from(state.sized());
    }

    fn pass_unresolved(&mut self) {
        self.tangent.passes_unresolved = true;
    }

    fn hand(&self) -> [Number; 2] {
        self.tangent.state.hand
    }

    fn site_position(&self) -> Number {
        self.tangent.site()
    }

    fn push(&self, position: Number, velocity: Number) -> Number {
        let Some(site) = self.tangent.model.site() else { return Number::ZERO };
        let [[x, y], [vx, vy]] = self.motion(site.body, site.point);
        let along = |p: [Number; 2]| p[0] * site.direction[0] + p[1] * site.direction[1];
        let force = site.stiffness * (position - along([x, y])) + site.damping * (velocity - along([vx, vy]));
        force.max(Number::ZERO)
    }

    fn compression(&self, zone: usize) -> Number {
        Pose::of(&self.tangent.model, &self.tangent.state.angle).compression(&self.tangent.model, zone)
    }

    fn normal_force(&self, settings: &Settings<f64>, zone: usize) -> (Number, f64) {
        (self.tangent.normal_force(settings, zone), self.tangent.last_step_s())
    }

    fn motion(&self, body: usize, point: [Number; 2]) -> [[Number; 2]; 2] {
        let state = &self.tangent.state;
        TrackedPoint::of(&self.tangent.model, body, point).motion(&state.angle, &state.velocity)
    }

    fn angles(&self) -> &[Number] {
        &self.tangent.state.angle[..self.bodies]
    }

    fn velocities(&self) -> &[Number] {
        &self.tangent.state.velocity[..self.bodies]
    }
}
