//! What can be seen of a mechanism from outside: where its points are, how fast they move, how near its zones are.

use core::cell::OnceCell;

use moreau::{GROUND, Model, ModelError, Pose};

use crate::flight::Flight;
use crate::size::with_size;
use crate::{EveryBody, Marks, Meeting, OwnedDescription, Size};

/// What can be seen of a mechanism. Indices follow the description's bodies and zones.
pub trait Visible {
    /// World coordinate of the driven point along the drive's direction, m; zero where nothing is driven.
    fn site_position(&self) -> f64;
    /// Compression of a zone now, m.
    fn gap(&self, zone: usize) -> f64;
    /// Speed of a point of a body now, m/s.
    fn point_speed(&self, body: usize, point: [f64; 2]) -> f64;
    /// A point of a body (`None`: of the ground) in the world now, m.
    fn point(&self, body: Option<usize>, point: [f64; 2]) -> [f64; 2];
    /// The meeting of the marked point and zone in the last step.
    fn met(&self) -> Option<Meeting>;
}

/// A mechanism's model, put into poses from outside: what looks on where steps are taken in lanes.
pub trait Placed: Visible + Send {
    /// Takes note of an instant; the pose is worked out only when it is asked for. Bodies beyond the model's are left out.
    fn look(&mut self, time_s: f64, angles: &EveryBody, velocities: &EveryBody);
    /// Whether the marked zone could not be touched at the last look.
    fn is_far(&self) -> bool;
}

/// A mechanism to be put into poses.
///
/// # Errors
/// [`ModelError`] if no size holds it.
pub fn placed(description: &OwnedDescription, marks: &Marks) -> Result<Box<dyn Placed>, ModelError> {
    with_size!(Size::of(description), boxed, description, marks)
}

fn boxed<const B: usize, const Z: usize, const N: usize>(
    description: &OwnedDescription,
    marks: &Marks,
) -> Result<Box<dyn Placed>, ModelError> {
    let model: Model<f64, B, Z> = description.model()?;
    let (flight, angle) = (Flight::new(&model, marks), description.first_angles());
    Ok(Box::new(Poser { model, flight, angle, velocity: [0.0; B], pose: OnceCell::new() }))
}

struct Poser<const B: usize, const Z: usize> {
    model: Model<f64, B, Z>,
    flight: Flight<B>,
    angle: [f64; B],
    velocity: [f64; B],
    /// Worked out when it is asked for.
    pose: OnceCell<Pose<f64, B>>,
}

impl<const B: usize, const Z: usize> Placed for Poser<B, Z> {
    fn look(&mut self, time_s: f64, angles: &EveryBody, velocities: &EveryBody) {
        // No size has more bodies.
        if let (Some(angles), Some(velocities)) = (angles.first_chunk(), velocities.first_chunk()) {
            (self.angle, self.velocity) = (*angles, *velocities);
        }
        self.pose = OnceCell::new();
        self.flight.look(&self.model, time_s, &self.angle, &self.velocity);
    }

    fn is_far(&self) -> bool {
        self.flight.is_far()
    }
}

/// A model in one pose, moving.
pub(crate) struct Sight<'a, const B: usize, const Z: usize> {
    pub model: &'a Model<f64, B, Z>,
    pub pose: &'a Pose<f64, B>,
    /// Absolute angular velocities, rad/s.
    pub velocity: &'a [f64; B],
}

impl<const B: usize, const Z: usize> Sight<'_, B, Z> {
    pub fn site_position(&self) -> f64 {
        self.model.site().map_or(0.0, |s| {
            let x = self.pose.point(s.body, s.point);
            s.direction[0] * x[0] + s.direction[1] * x[1]
        })
    }

    pub fn gap(&self, zone: usize) -> f64 {
        self.pose.gap(self.model, zone)
    }

    pub fn point_speed(&self, body: usize, point: [f64; 2]) -> f64 {
        let along = |n| {
            let row = self.pose.velocity_row(self.model, body, point, n);
            row.iter().zip(self.velocity).map(|(r, v)| r * v).sum::<f64>()
        };
        libm::hypot(along([1.0, 0.0]), along([0.0, 1.0]))
    }

    pub fn point(&self, body: Option<usize>, point: [f64; 2]) -> [f64; 2] {
        self.pose.point(body.unwrap_or(GROUND), point)
    }
}

impl<const B: usize, const Z: usize> Poser<B, Z> {
    fn sight(&self) -> Sight<'_, B, Z> {
        let pose = self.pose.get_or_init(|| Pose::of(&self.model, &self.angle));
        Sight { model: &self.model, pose, velocity: &self.velocity }
    }
}

impl<const B: usize, const Z: usize> Visible for Poser<B, Z> {
    fn site_position(&self) -> f64 {
        self.sight().site_position()
    }

    fn gap(&self, zone: usize) -> f64 {
        self.sight().gap(zone)
    }

    fn point_speed(&self, body: usize, point: [f64; 2]) -> f64 {
        self.sight().point_speed(body, point)
    }

    fn point(&self, body: Option<usize>, point: [f64; 2]) -> [f64; 2] {
        self.sight().point(body, point)
    }

    fn met(&self) -> Option<Meeting> {
        self.flight.met()
    }
}
