//! One press: its columns, its events, its figure.

use std::sync::Arc;

use erard::Impact;
use erard::one_dof::reduce;
use erard::player::{Inside, Loss, LossRecorder, ReactionRecorder};
use erard::run::{BodySeries, Events, LiftSeries, Run, ZoneSeries, column_unit};
use erard::run::{Setup, simulate, simulate_observed};
use erard::trust::Warning;
use erard_figures::figure::run_picture;
use numpy::{IntoPyArray, PyArray1, PyArrayMethods, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::fault;
use crate::instrument::Instrument;
use crate::setup::Steps;
use crate::stroke::Stroke;
use crate::watch::watched;

/// Makes a read-only array that owns Rust's memory, without a copy.
pub(crate) fn array(py: Python<'_>, values: Vec<f64>) -> Bound<'_, PyArray1<f64>> {
    let array = values.into_pyarray(py);
    array.readwrite().make_nonwriteable();
    array
}

/// Returns the unit that a column's name ends with; `1` for a number without unit.
#[pyfunction]
pub fn unit(name: &str) -> &'static str {
    column_unit(name)
}

/// Plays a stroke on the action or on its one-degree-of-freedom model. Returns columns by name in order, those of the
/// pins last, and all other results.
#[pyfunction]
#[pyo3(signature = (instrument, stroke, steps, model, duration, record_every, tolerance, reactions, losses, progress))]
#[allow(clippy::too_many_arguments)]
pub(crate) fn press<'py>(
    py: Python<'py>,
    instrument: &Instrument,
    stroke: &Stroke,
    steps: Steps,
    model: &str,
    duration: Option<f64>,
    record_every: Option<u64>,
    tolerance: Option<f64>,
    reactions: bool,
    losses: bool,
    progress: Option<Py<PyAny>>,
) -> PyResult<(Bound<'py, PyDict>, Bound<'py, PyDict>)> {
    let inner = &stroke.inner;
    let setup = steps.setup_of(&instrument.inner, inner, duration)?;
    let setup = Setup { record_every, tolerance, ..setup };
    let own = match model {
        "action" => instrument.inner.clone(),
        "one-dof" => Arc::new(reduce(&instrument.inner).map_err(fault::wrong)?.instrument),
        found => {
            return Err(fault::wrong_argument("model", format!("found `{found}`, expected `action` or `one-dof`")));
        }
    };
    let stroke = inner.clone();
    let mut inside = Inside {
        reactions: reactions.then(|| ReactionRecorder::new(&own)),
        losses: losses.then(|| LossRecorder::new(&own)),
    };
    // A stroke that cannot drive this instrument says so before it is played.
    stroke.inputs(&own.finger).map(drop).map_err(fault::wrong)?;
    let run = watched(
        py,
        progress,
        |going| {
            // Made here: a drive keeps a cursor, which is not shared between threads.
            let inputs = stroke.inputs(&own.finger).map_err(|_| erard::SimulationError::NoKey)?;
            if reactions || losses {
                simulate_observed(&own, inputs.as_ref(), &setup, &mut inside, going)
            } else {
                simulate(&own, inputs.as_ref(), &setup, going)
            }
        },
        fault::simulation,
    )?;
    let (columns, about) = parts(py, run)?;
    if let Some(losses) = inside.losses.as_ref().and_then(LossRecorder::losses) {
        let all = losses.by_size();
        let total: f64 = all.iter().map(Loss::all_j).sum();
        let rows = all.into_iter().map(|loss| {
            let row = PyDict::new(py);
            row.set_item("name", &loss.name)?;
            row.set_item("kind", loss.kind)?;
            row.set_item("label", &loss.label)?;
            row.set_item("dry_J", loss.dry_j)?;
            row.set_item("viscous_or_felt_J", loss.viscous_or_felt_j)?;
            row.set_item("loss_J", loss.all_j())?;
            row.set_item("share", if total > 0.0 { loss.all_j() / total } else { 0.0 })?;
            Ok(row)
        });
        about.set_item("losses", rows.collect::<PyResult<Vec<_>>>()?)?;
    }
    for pin in inside.reactions.map(ReactionRecorder::into_series).unwrap_or_default() {
        columns.set_item(format!("{}_rad_per_s2", pin.name), array(py, pin.acceleration_rad_per_s2))?;
        columns.set_item(format!("{}_pin_x_N", pin.name), array(py, pin.pin_x_n))?;
        columns.set_item(format!("{}_pin_y_N", pin.name), array(py, pin.pin_y_n))?;
    }
    Ok((columns, about))
}

fn parts<'py>(py: Python<'py>, run: Run) -> PyResult<(Bound<'py, PyDict>, Bound<'py, PyDict>)> {
    let about = PyDict::new(py);
    about.set_item("instrument", &run.instrument)?;
    about.set_item("events", events(py, &run.events)?)?;
    about.set_item(
        "impacts",
        run.events.impacts.iter().map(|s| (s.time_s, s.hammer_speed_m_per_s)).collect::<Vec<_>>(),
    )?;
    about.set_item("hammer_speed_normal", run.events.hammer_speed_normal_m_per_s())?;
    about.set_item("free_flight_s", run.events.free_flight_s())?;
    about.set_item("peak_force_N", run.peak_force_n)?;
    about.set_item("steps", run.work.steps)?;
    about.set_item("unconverged_steps", run.work.unconverged_steps)?;
    about.set_item("newton_iterations", run.work.newton_iterations)?;
    about.set_item("energy", energy(py, &run)?)?;
    about.set_item("warnings", run.warnings.iter().map(Warning::to_string).collect::<Vec<_>>())?;
    about.set_item("bodies", run.bodies.iter().map(|body| body.name.clone()).collect::<Vec<_>>())?;
    let lifts = run.lifts.iter().map(|lift| (lift.name.clone(), lift.pin.clone()));
    about.set_item("lifts", lifts.collect::<Vec<_>>())?;
    let zones = run.zones.iter().map(|zone| (zone.name.clone(), zone.label.clone(), zone.has_friction));
    about.set_item("zones", zones.collect::<Vec<_>>())?;
    // The same names and order as everywhere; the vectors themselves go to Python.
    let names: Vec<String> = run.columns().into_iter().map(|(name, _)| name).collect();
    let bodies = run.bodies.into_iter().flat_map(|body| [body.angle_rad, body.rate_rad_per_s]);
    let zones = run.zones.into_iter().flat_map(|zone| {
        let tangential = zone.has_friction.then_some(zone.tangential_n);
        std::iter::once(zone.normal_n).chain(tangential)
    });
    let values = [run.time_s, run.force_n, run.key_m, run.hammer_rise_m, run.hammer_rise_m_per_s]
        .into_iter()
        .chain(bodies)
        .chain(run.lifts.into_iter().map(|lift| lift.lift_m))
        .chain(zones);
    let values = values.chain(run.strings.into_iter().flat_map(|s| [s.displacement_m, s.bridge_n]));
    let columns = PyDict::new(py);
    for (name, values) in names.into_iter().zip(values) {
        if !values.is_empty() {
            columns.set_item(name, array(py, values))?;
        }
    }
    Ok((columns, about))
}

/// Returns times and speeds of events, `None` for those that did not happen.
fn events<'py>(py: Python<'py>, events: &Events) -> PyResult<Bound<'py, PyDict>> {
    let all = PyDict::new(py);
    all.set_item("key_start", events.key_start_s)?;
    all.set_item("toe_contact", events.toe_contact_s)?;
    all.set_item("let_off", events.let_off_s)?;
    all.set_item("hammer_contact", events.hammer_contact_s())?;
    all.set_item("key_bottom", events.key_bottom_s)?;
    all.set_item("check", events.check_s)?;
    all.set_item("hammer_speed", events.hammer_speed_m_per_s())?;
    Ok(all)
}

fn energy<'py>(py: Python<'py>, run: &Run) -> PyResult<Option<Bound<'py, PyDict>>> {
    let Some(ledger) = &run.ledger else { return Ok(None) };
    let energy = PyDict::new(py);
    energy.set_item("drive_work_J", ledger.drive_work)?;
    energy.set_item("pivot_dry_J", ledger.pivot_dry)?;
    energy.set_item("pivot_viscous_J", ledger.pivot_viscous)?;
    energy.set_item("felt_J", ledger.felt_damping)?;
    energy.set_item("coulomb_J", ledger.coulomb)?;
    energy.set_item("strings_J", ledger.surface)?;
    energy.set_item("residual_relative", ledger.residual_relative())?;
    Ok(Some(energy))
}

/// Returns the figure of a run as SVG, as `erard press` draws it.
#[pyfunction]
pub(crate) fn figure(columns: &Bound<'_, PyDict>, about: &Bound<'_, PyDict>, title: &str) -> PyResult<String> {
    let column = |name: &str| -> PyResult<Vec<f64>> {
        match columns.get_item(name)? {
            Some(values) => Ok(values.extract::<PyReadonlyArray1<'_, f64>>()?.to_vec()?),
            None => Ok(Vec::new()),
        }
    };
    let item = |key: &str| about.get_item(key)?.ok_or_else(|| fault::wrong(format!("a run without `{key}`")));
    let bodies: Vec<String> = item("bodies")?.extract()?;
    let zones: Vec<(String, String, bool)> = item("zones")?.extract()?;
    let lifts: Vec<(String, String)> = item("lifts")?.extract()?;
    let happened = item("events")?;
    let event = |name: &str| -> PyResult<Option<f64>> { happened.get_item(name)?.extract() };
    let impacts: Vec<(f64, f64)> = item("impacts")?.extract()?;
    let impacts = impacts.into_iter().map(|(time_s, hammer_speed_m_per_s)| {
        // The figure shows the total speed only.
        Impact { time_s, hammer_speed_m_per_s, hammer_speed_normal_m_per_s: f64::NAN }
    });
    let run = Run {
        instrument: item("instrument")?.extract()?,
        time_s: column("time_s")?,
        force_n: column("force_N")?,
        key_m: column("key_m")?,
        hammer_rise_m: column("hammer_rise_m")?,
        hammer_rise_m_per_s: column("hammer_rise_m_per_s")?,
        bodies: bodies
            .into_iter()
            .map(|name| {
                let (angle_rad, rate) = (column(&format!("{name}_rad"))?, column(&format!("{name}_rad_per_s"))?);
                Ok(BodySeries { name, angle_rad, rate_rad_per_s: rate })
            })
            .collect::<PyResult<_>>()?,
        zones: zones
            .into_iter()
            .map(|(name, label, has_friction)| {
                let (normal_n, tangential_n) =
                    (column(&format!("{name}_N"))?, column(&format!("{name}_tangential_N"))?);
                Ok(ZoneSeries { name, label, normal_n, tangential_n, has_friction, contact: Vec::new() })
            })
            .collect::<PyResult<_>>()?,
        lifts: lifts
            .into_iter()
            .map(|(name, pin)| Ok(LiftSeries { lift_m: column(&format!("{name}_lift_m"))?, name, pin }))
            .collect::<PyResult<_>>()?,
        strings: None,
        events: Events {
            key_start_s: event("key_start")?,
            toe_contact_s: event("toe_contact")?,
            let_off_s: event("let_off")?,
            key_bottom_s: event("key_bottom")?,
            check_s: event("check")?,
            impacts: impacts.collect(),
        },
        peak_force_n: 0.0,
        final_pivot_friction_n_m: Vec::new(),
        ledger: None,
        work: Default::default(),
        extremes: Default::default(),
        warnings: Vec::new(),
    };
    Ok(run_picture(&run, title).svg())
}
