//! One mechanism and the derivatives of its motion.

use moreau::{
    Driven, Dual, Model, Pose, Real, SavedState, Settings, State, Switched, Tangent, TangentError, TangentReport,
    TrackedPoint,
};

use crate::{OwnedDescription, Size};

/// Directions of one pass.
pub const DIRECTIONS: usize = 8;
/// A number with its derivatives in the directions of a pass.
pub type Number = Dual<DIRECTIONS>;

/// A mechanism and the derivatives of its motion. Indices follow the description's bodies and zones.
pub trait Tangents: Send {
    /// Advances by `settings.step`; `switched` hears of every switch of friction on the way.
    fn step(
        &mut self,
        settings: &Settings<f64>,
        input: &mut Driven<'_, DIRECTIONS>,
        switched: &mut Switched<'_>,
    ) -> TangentReport;
    /// Goes on from another state.
    fn begin(&mut self, state: &SavedState<Number, 12, 32>);
    /// From now on derivatives go on as they were across switches that cannot be distinguished
    /// ([`Tangent::passes_unresolved`]).
    fn pass_unresolved(&mut self);
    /// Where the hand is (world coordinate along the drive's direction, m), and how fast, m/s.
    fn hand(&self) -> [Number; 2];
    /// World coordinate of the driven point along the drive's direction, m.
    fn site_position(&self) -> Number;
    /// Force of an elastic drive whose driver is at this position (m, as [`Self::site_position`]) and has this
    /// velocity, m/s; N, and 0 where it does not touch.
    fn push(&self, position: Number, velocity: Number) -> Number;
    /// Compression of a zone, m; negative apart.
    fn compression(&self, zone: usize) -> Number;
    /// Normal force of a zone during the last inner step, N, and that step's length, s.
    fn normal_force(&self, settings: &Settings<f64>, zone: usize) -> (Number, f64);
    /// A point of a body, m, in the world, and its velocity, m/s.
    fn motion(&self, body: usize, point: [Number; 2]) -> [[Number; 2]; 2];
    /// Absolute angles, rad.
    fn angles(&self) -> &[Number];
    /// Absolute angular velocities, rad/s.
    fn velocities(&self) -> &[Number];
}

/// A mechanism at the angles as drawn, at rest. `slopes`: the derivative of every number of the description
/// ([`OwnedDescription::numbers`]) in every direction.
///
/// # Errors
/// See [`TangentError`].
pub fn tangents(
    description: &OwnedDescription,
    slopes: &[[f64; DIRECTIONS]],
) -> Result<Box<dyn Tangents>, TangentError> {
    // Two sizes are enough where speed matters less than what has to be compiled.
    let most = Size::of(description) == Size::Most || Size::of(description) == Size::Nine;
    if most { boxed::<12, 32, 77>(description, slopes) } else { boxed::<8, 20, 49>(description, slopes) }
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
