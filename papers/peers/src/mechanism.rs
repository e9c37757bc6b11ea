//! The exported mechanism as in the JSON. Its schema is described with the exporter,
//! `crates/erard-core/examples/export_mechanism.rs`.

use serde::Deserialize;

/// A point or direction in the plane.
pub(crate) type Vector = [f64; 2];

/// Format `erard-mechanism/2`.
#[derive(Debug, Clone, Deserialize)]
pub(crate) struct Mechanism {
    /// Name of the format.
    pub format: String,
    /// Gravity, m/s2, toward -y.
    pub gravity_m_s2: f64,
    /// Parents before children.
    pub bodies: Vec<Body>,
    /// Torsion springs at pivots.
    pub springs: Vec<Spring>,
    /// Felts.
    pub zones: Vec<Zone>,
    /// Place at which the finger pushes.
    pub finger: Finger,
    /// Strike point, which touches the string.
    pub strike: Strike,
    /// Stroke for the comparison of hammer speeds.
    pub blow: Blow,
    /// Held note.
    pub hold: Hold,
}

/// A hinged body.
#[derive(Debug, Clone, Deserialize)]
pub(crate) struct Body {
    /// Parent; `None` is the ground.
    pub parent: Option<usize>,
    /// Pivot in the parent's frame.
    pub pivot_m: Vector,
    /// Mass.
    pub mass_kg: f64,
    /// Inertia about the pivot.
    pub inertia_kg_m2: f64,
    /// Centre of mass in its own frame, whose origin is the pivot.
    pub center_of_mass_m: Vector,
    /// Torque of the pivot's dry friction.
    #[serde(rename = "dry_friction_N_m")]
    pub dry_friction: f64,
    /// Viscous friction of the pivot.
    #[serde(rename = "viscous_friction_N_m_s")]
    pub viscous_friction: f64,
    /// Absolute angle at rest.
    pub rest_angle_rad: f64,
}

/// A torsion spring between a body and its parent.
#[derive(Debug, Clone, Deserialize)]
pub(crate) struct Spring {
    /// Child body.
    pub body: usize,
    /// Torque at the reference.
    #[serde(rename = "torque_N_m")]
    pub torque: f64,
    /// Stiffness.
    #[serde(rename = "stiffness_N_m_per_rad")]
    pub stiffness: f64,
    /// Relative angle at which the torque holds.
    pub reference_rad: f64,
}

/// A felt between a disc and a curve.
#[derive(Debug, Clone, Deserialize)]
pub(crate) struct Zone {
    /// The disc.
    pub disc: Disc,
    /// Carrier of the curve; `None` is the ground.
    pub curve_body: Option<usize>,
    /// Curve in its carrier's frame.
    pub curve: Curve,
    /// The felt's law.
    pub felt: Felt,
    /// Coulomb's mu, 0 for none.
    pub friction_coefficient: f64,
}

/// The disc of a zone.
#[derive(Debug, Clone, Deserialize)]
pub(crate) struct Disc {
    /// Carrier; `None` is the ground.
    pub body: Option<usize>,
    /// Centre in its carrier's frame.
    pub center_m: Vector,
    /// Radius; 0 for a point.
    pub radius_m: f64,
}

/// Curve pressed by a zone's disc.
#[derive(Debug, Clone, Deserialize)]
#[serde(rename_all = "snake_case")]
#[allow(missing_docs, reason = "see the schema")]
pub(crate) enum Curve {
    /// A straight line.
    Line { point_m: Vector, normal: Vector },
    /// A rounded segment.
    Segment { from_m: Vector, to_m: Vector, rounding_m: f64 },
    /// A disc.
    Disc { center_m: Vector, radius_m: f64 },
}

/// F = max(0, k g^r + b g^2 dg/dt).
#[derive(Debug, Clone, Deserialize)]
pub(crate) struct Felt {
    /// k.
    #[serde(rename = "stiffness_N_per_m_r")]
    pub stiffness: f64,
    /// r.
    pub exponent: f64,
    /// b.
    #[serde(rename = "damping_N_s_per_m3")]
    pub damping: f64,
}

/// Place at which the finger pushes.
#[derive(Debug, Clone, Deserialize)]
pub(crate) struct Finger {
    /// The key.
    pub body: usize,
    /// Point in the key's frame.
    pub point_m: Vector,
    /// Direction of a positive force, in the world.
    pub direction: Vector,
}

/// Strike point on the hammer.
#[derive(Debug, Clone, Deserialize)]
pub(crate) struct Strike {
    /// The hammer, or its last piece.
    pub body: usize,
    /// The strike point in its frame.
    pub point_m: Vector,
    /// Unit vector toward the string, in the world.
    pub direction: Vector,
    /// Coordinate of the strike point in that direction at contact with the string.
    pub meets_m: f64,
}

/// A force in cubic pieces.
#[derive(Debug, Clone, Deserialize)]
pub(crate) struct Blow {
    /// Simulated time.
    pub until_s: f64,
    /// Factors of the force.
    pub scales: Vec<f64>,
    /// Times of the samples.
    pub times_s: Vec<f64>,
    /// Forces at the samples.
    #[serde(rename = "forces_N")]
    pub forces: Vec<f64>,
    /// Slopes at the samples.
    #[serde(rename = "slopes_N_per_s")]
    pub slopes: Vec<f64>,
}

/// A constant force.
#[derive(Debug, Clone, Deserialize)]
pub(crate) struct Hold {
    /// The force.
    #[serde(rename = "force_N")]
    pub force: f64,
    /// Start of the comparison of the hammer's angle.
    pub from_s: f64,
    /// End of this comparison.
    pub until_s: f64,
}

impl Hold {
    /// Times at which the hammer's angle is compared, s.
    pub(crate) fn instants(&self) -> Vec<f64> {
        (0..=90).map(|k| self.from_s + (self.until_s - self.from_s) * f64::from(k) / 90.0).collect()
    }
}

impl Blow {
    /// Force at an instant, N: Hermite's cubic between samples, constant outside.
    pub(crate) fn force(&self, t: f64) -> f64 {
        let last = self.times_s.len() - 1;
        if t <= self.times_s[0] {
            return self.forces[0];
        }
        if t >= self.times_s[last] {
            return self.forces[last];
        }
        let i = self.times_s.partition_point(|&sample| sample <= t) - 1;
        let h = self.times_s[i + 1] - self.times_s[i];
        let s = (t - self.times_s[i]) / h;
        let (rest, square) = (1.0 - s, s * s);
        rest * rest * ((1.0 + 2.0 * s) * self.forces[i] + s * h * self.slopes[i])
            + square * ((3.0 - 2.0 * s) * self.forces[i + 1] - rest * h * self.slopes[i + 1])
    }
}

/// Reads a mechanism.
///
/// # Errors
/// If the file cannot be read or is not of this format.
pub(crate) fn read(path: &str) -> Result<Mechanism, String> {
    let text = std::fs::read_to_string(path).map_err(|e| format!("{path}: {e}"))?;
    let mechanism: Mechanism = serde_json::from_str(&text).map_err(|e| format!("{path}: {e}"))?;
    if mechanism.format != "erard-mechanism/2" {
        return Err(format!("{path}: format is {:?}; expected \"erard-mechanism/2\"", mechanism.format));
    }
    Ok(mechanism)
}
