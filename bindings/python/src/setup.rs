//! How to step, from keyword arguments.

use erard::instrument::Instrument;
use erard::player::{Hand, Joints};
use erard::run::Setup;
use erard::stroke::Stroke;
use moreau::{FrictionLaw, Settings, Solver};
use pyo3::prelude::*;

use crate::fault::wrong_argument;

/// Arguments that all simulations share.
#[derive(FromPyObject)]
pub(crate) struct Steps {
    #[pyo3(item)]
    step: Option<f64>,
    #[pyo3(item)]
    theta: f64,
    #[pyo3(item)]
    solver: String,
    #[pyo3(item)]
    friction: String,
    #[pyo3(item)]
    friction_width: f64,
    #[pyo3(item)]
    hand: Option<HandNumbers>,
}

/// Hand: mass, kg; stiffness, N/m, and damping, N s/m, of its muscle; position, m, and velocity, m/s, at the start;
/// compliance, m/N, and retardation time, s, of its joints (by default stiff).
type HandNumbers = (f64, f64, f64, f64, f64, Option<f64>, Option<f64>);

/// Returns joints whose compliance, m/N, and retardation time, s, are `own` where they are not given.
pub(crate) fn joints_over(own: Joints, compliance_m_per_n: Option<f64>, retardation_s: Option<f64>) -> Joints {
    Joints {
        compliance_m_per_n: compliance_m_per_n.unwrap_or(own.compliance_m_per_n),
        retardation_s: retardation_s.unwrap_or(own.retardation_s),
    }
}

impl Steps {
    /// Returns the engine's settings for an instrument.
    pub(crate) fn settings(&self, instrument: &Instrument) -> PyResult<Settings<f64>> {
        let width = self.friction_width;
        if !(width.is_finite() && width > 0.0) {
            return Err(wrong_argument(
                "friction_width",
                format!("found {width}, expected a positive number of rad/s"),
            ));
        }
        let solver = match self.solver.as_str() {
            "active-set" => Solver::ActiveSet,
            "projected-gauss-seidel" => Solver::ProjectedGaussSeidel,
            found => {
                let expected = "expected `active-set` or `projected-gauss-seidel`";
                return Err(wrong_argument("solver", format!("found `{found}`, {expected}")));
            }
        };
        let friction = match self.friction.as_str() {
            "set-valued" => FrictionLaw::SetValued,
            "tanh" => FrictionLaw::Regularised { pivot_width: width, sliding_width: 0.1 * width },
            found => {
                return Err(wrong_argument("friction", format!("found `{found}`, expected `set-valued` or `tanh`")));
            }
        };
        let step_s = self.step.unwrap_or_else(|| instrument.usual_step_s());
        Ok(Settings { theta: self.theta, solver, friction, ..Settings::new(step_s) })
    }

    /// Returns the hand between stroke and key.
    pub(crate) fn hand(&self) -> PyResult<Option<Hand>> {
        let Some((mass_kg, stiffness_n_per_m, damping_n_s_per_m, start_m, start_m_per_s, compliance, time)) = self.hand
        else {
            return Ok(None);
        };
        let joints = joints_over(Joints::STIFF, compliance, time);
        let hand = Hand { mass_kg, stiffness_n_per_m, damping_n_s_per_m, start_m, start_m_per_s, joints };
        hand.check().map_err(|error| wrong_argument("hand", error.to_string()))?;
        Ok(Some(hand))
    }

    /// Raises an error if these settings do not support derivatives.
    pub(crate) fn for_derivatives(&self) -> PyResult<()> {
        if self.friction == "set-valued" {
            return Ok(());
        }
        let found = &self.friction;
        Err(wrong_argument(
            "friction",
            format!("found `{found}`; derivatives are those of `set-valued` friction, which truly sticks"),
        ))
    }

    /// Sets up a run of an instrument from a time on, s.
    pub(crate) fn setup(&self, instrument: &Instrument, start_s: f64, duration_s: f64) -> PyResult<Setup> {
        Ok(Setup { settings: self.settings(instrument)?, start_s, hand: self.hand()?, ..Setup::new(duration_s) })
    }

    /// Sets up a run for a stroke; a touch has its own hand.
    pub(crate) fn setup_of(
        &self,
        instrument: &Instrument,
        stroke: &Stroke,
        duration_s: Option<f64>,
    ) -> PyResult<Setup> {
        let setup = self.setup(instrument, stroke.start_s, duration_s.unwrap_or(stroke.duration_s))?;
        Ok(Setup { hand: stroke.hand().or(setup.hand), ..setup })
    }
}
