//! Impact of the probe point (an action's hammer) on its zone (the string). Instant and speed are extrapolated from the
//! motion just before ([`moreau::ImpactPredictor`]).

use moreau::{ImpactPredictor, Model, PointImpact, TrackedPoint};

use crate::Probes;

/// Impact of the hammer on the string: of the probe point on its zone ([`Probes`]).
///
/// This type carries these numbers from the step that finds them to the report.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Impact {
    /// Instant at which the compression becomes positive, s.
    pub time_s: f64,
    /// Total speed of the point along its path at that instant, m/s.
    pub hammer_speed_m_per_s: f64,
    /// Normal part of this speed, toward the zone, m/s. This is the initial rate of compression if the surface does not
    /// move.
    pub hammer_speed_normal_m_per_s: f64,
}

impl From<PointImpact<f64>> for Impact {
    fn from(impact: PointImpact<f64>) -> Self {
        let PointImpact { time_s, speed, normal_speed } = impact;
        Impact { time_s, hammer_speed_m_per_s: speed, hammer_speed_normal_m_per_s: normal_speed }
    }
}

/// Predicts the impact of the probes' point on their zone.
pub(crate) fn predictor<const B: usize, const Z: usize>(
    model: &Model<f64, B, Z>,
    probes: &Probes,
) -> ImpactPredictor<f64, B> {
    let (body, point) = probes.point.unwrap_or((moreau::GROUND, [0.0; 2]));
    ImpactPredictor::new(TrackedPoint::of(model, body, point), probes.zone.filter(|_| probes.point.is_some()))
}
