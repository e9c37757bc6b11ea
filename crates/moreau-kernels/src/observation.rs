//! Observation of a mechanism's present pose, and observers of mechanisms that are stepped in lanes.

use core::cell::OnceCell;

use moreau::{
    Energies, GROUND, ImpactPredictor, Ledger, Model, ModelError, Pose, Settings, SiteInput, State, Workspace,
};

use crate::impact::predictor;
use crate::size::with_size;
use crate::{EveryBody, Impact, OwnedDescription, Probes, SideBySide, Size};

/// Present pose of a mechanism of any size. Indices have the order of the description's bodies and zones.
pub trait Observation {
    /// Returns the world coordinate of the driven point along the drive's direction, m; zero if there is no drive.
    fn site_position(&self) -> f64;
    /// Returns the compression of a zone, m; negative when it is open.
    fn compression(&self, zone: usize) -> f64;
    /// Returns the normal force of a zone in the last step, N; 0 before the first. In lanes: in the step retraced last.
    fn normal_force(&self, zone: usize) -> f64;
    /// Returns a point of a body (`None`: of the ground) in the world, m. `point` is in the body's frame, m.
    fn point(&self, body: Option<usize>, point: [f64; 2]) -> [f64; 2];
    /// Returns the Jacobian row of a zone's compression, m: its rate per unit absolute angular velocity of each body.
    /// Allocates.
    fn compression_row(&self, zone: usize) -> Vec<f64>;
    /// Returns the contact point of a zone on its curve, m, in the world; if the zone is open, the point where it would
    /// touch.
    fn contact_point(&self, zone: usize) -> [f64; 2];
    /// Returns the Jacobian row of a point's velocity along `n`, m: per unit absolute angular velocity of each body.
    /// Allocates.
    fn velocity_row(&self, body: usize, point: [f64; 2], n: [f64; 2]) -> Vec<f64>;
}

/// Observer of one mechanism that is stepped in lanes, of any size. The caller passes it angles and velocities after
/// every step.
pub trait LaneObserver: Observation + Send {
    /// Sets the observed motion: instant, s; absolute angles, rad; angular velocities, rad/s. The pose is computed only
    /// when it is needed. Bodies that the model does not have are ignored.
    fn update(&mut self, time_s: f64, angles: &EveryBody, velocities: &EveryBody);
    /// Returns whether the probe zone was out of reach at the last update.
    fn is_far(&self) -> bool;
    /// Returns the impact of the probe point on the probe zone in the last step; `None` without one.
    fn impact(&self) -> Option<Impact>;
    /// Copies the state of a mechanism of the group, `index`, as the start of the next step to be retraced.
    fn begin(&mut self, group: &dyn SideBySide, index: usize);
    /// Evaluates the forces of the step that ended in the group's present state ([`Workspace::retrace`]) and returns
    /// true. Returns false if that step changed nothing.
    fn retrace(
        &mut self,
        settings: &Settings<f64>,
        input: &SiteInput<f64>,
        group: &dyn SideBySide,
        index: usize,
    ) -> bool;
    /// Records the step retraced last in a ledger.
    fn record_energy(&self, ledger: &mut Ledger, settings: &Settings<f64>, input: &SiteInput<f64>);
    /// Returns the stored energies at the end of the step retraced last, J.
    fn energies(&self) -> Energies;
}

/// Returns an observer of a mechanism that is stepped in lanes.
///
/// # Errors
/// Returns [`ModelError`] if no size holds the mechanism, or a number is out of its range.
pub fn lane_observer(description: &OwnedDescription, probes: &Probes) -> Result<Box<dyn LaneObserver>, ModelError> {
    with_size!(Size::of(description), boxed, description, probes)
}

fn boxed<const B: usize, const Z: usize, const N: usize>(
    description: &OwnedDescription,
    probes: &Probes,
) -> Result<Box<dyn LaneObserver>, ModelError> {
    let model: Model<f64, B, Z> = description.model()?;
    let (predictor, angle) = (predictor(&model, probes), description.first_angles());
    let bodies = description.bodies.len();
    let ends = core::array::from_fn(|_| Box::new(State::at_rest(angle)));
    let acted = Workspace::new();
    Ok(Box::new(Observed { model, predictor, bodies, angle, pose: OnceCell::new(), ends, timing: None, acted }))
}

struct Observed<const B: usize, const Z: usize> {
    model: Model<f64, B, Z>,
    predictor: ImpactPredictor<f64, B>,
    bodies: usize,
    angle: [f64; B],
    /// Computed when it is asked for.
    pose: OnceCell<Pose<f64, B>>,
    /// Where the last step that was retraced began and ended.
    ends: [Box<State<f64, B, Z>>; 2],
    /// How it was taken, and what acted in it; nothing is solved, so that there is no room for laws.
    timing: Option<Settings<f64>>,
    acted: Workspace<f64, B, Z, 0>,
}

impl<const B: usize, const Z: usize> LaneObserver for Observed<B, Z> {
    fn update(&mut self, time_s: f64, angles: &EveryBody, velocities: &EveryBody) {
        self.pose = OnceCell::new();
        // No size has more bodies.
        if let (Some(angles), Some(velocities)) = (angles.first_chunk(), velocities.first_chunk()) {
            self.angle = *angles;
            self.predictor.update(&self.model, time_s, angles, velocities);
        }
    }

    fn is_far(&self) -> bool {
        self.predictor.is_far()
    }

    fn impact(&self) -> Option<Impact> {
        self.predictor.impact().map(Impact::from)
    }

    fn begin(&mut self, group: &dyn SideBySide, index: usize) {
        copy_state(group, index, &mut self.ends[1]);
    }

    fn retrace(
        &mut self,
        settings: &Settings<f64>,
        input: &SiteInput<f64>,
        group: &dyn SideBySide,
        index: usize,
    ) -> bool {
        let Observed { model, ends, acted, .. } = self;
        ends.swap(0, 1);
        let [before, after] = ends;
        copy_state(group, index, after);
        if ***before == ***after {
            return false;
        }
        self.timing = Some(*settings);
        acted.retrace(model, settings, input, before, after);
        true
    }

    fn record_energy(&self, ledger: &mut Ledger, settings: &Settings<f64>, input: &SiteInput<f64>) {
        let [before, after] = &self.ends;
        ledger.record(&self.model, settings, before, after, &self.acted);
        if let SiteInput::Hand(hand) = input {
            ledger.hand.record(&self.model, settings, hand, &before.hand, &before.velocity, after, &self.acted);
        }
    }

    fn energies(&self) -> Energies {
        Energies::of(&self.model, &self.ends[1])
    }
}

/// Copies a mechanism's state, which is of the same size wherever mechanisms of one topology are stepped together.
fn copy_state<const B: usize, const Z: usize>(group: &dyn SideBySide, index: usize, state: &mut State<f64, B, Z>) {
    if !group.copy_state(index, state) {
        **state = group.state(index).sized();
    }
}

impl<const B: usize, const Z: usize> Observed<B, Z> {
    fn pose(&self) -> &Pose<f64, B> {
        self.pose.get_or_init(|| Pose::of(&self.model, &self.angle))
    }
}

impl<const B: usize, const Z: usize> Observation for Observed<B, Z> {
    fn site_position(&self) -> f64 {
        site_position(&self.model, self.pose())
    }

    fn compression(&self, zone: usize) -> f64 {
        self.pose().compression(&self.model, zone)
    }

    fn normal_force(&self, zone: usize) -> f64 {
        self.timing.map_or(0.0, |settings| self.acted.normal_force(&self.model, &settings, zone))
    }

    fn point(&self, body: Option<usize>, point: [f64; 2]) -> [f64; 2] {
        self.pose().point(body.unwrap_or(GROUND), point)
    }

    fn compression_row(&self, zone: usize) -> Vec<f64> {
        self.pose().compression_row(&self.model, zone)[..self.bodies].to_vec()
    }

    fn contact_point(&self, zone: usize) -> [f64; 2] {
        self.pose().contact_point(&self.model, zone)
    }

    fn velocity_row(&self, body: usize, point: [f64; 2], n: [f64; 2]) -> Vec<f64> {
        self.pose().velocity_row(&self.model, body, point, n)[..self.bodies].to_vec()
    }
}

/// See [`Observation::site_position`].
pub(crate) fn site_position<const B: usize, const Z: usize>(model: &Model<f64, B, Z>, pose: &Pose<f64, B>) -> f64 {
    model.site().map_or(0.0, |s| {
        let x = pose.point(s.body, s.point);
        s.direction[0] * x[0] + s.direction[1] * x[1]
    })
}
