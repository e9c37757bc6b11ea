//! The technician's work: measuring, regulating, kinematics, keyboards, drawings.

use std::path::Path;

use erard::instrument::Instrument as Inner;
use erard::instrument_spec::InstrumentSpec;
use erard::parameter::Quantity;
use erard::player::{RestKind, RestPose};
use erard::run::{Setup, simulate};
use erard_figures::drawing::{PoseOptions, angles_at, forces_at, pose_picture};
use erard_kinematics::three_lever::StrokePose;
use erard_kinematics::{Design, LinkageFile, derive};
use erard_workshop::distances::{DistanceError, Protocol};
use erard_workshop::measure::norms::{Line, MIDDLE_C, lines, norms_key};
use erard_workshop::measure::{MeasureError, measure as measure_all, measure_some};
use erard_workshop::regulate::{
    Goal, Miss, RegulateError, Specification, Status, needed, parse_value, regulate as turn, regulate_following, show,
};
use erard_workshop::weighing::{WeighedKey, Weights, weigh};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::fault::{self, failed, wrong, wrong_argument};
use crate::instrument::{Instrument, Value};
use crate::keys::Key;
use crate::press::array;
use crate::setup::Steps;
use crate::stroke::Stroke;
use crate::watch::watched;

/// Returns the lines of the technician's sheet: key, name, unit, decimals, usual range at a key of the piano, and
/// whether a whole sheet leaves the line out.
#[pyfunction]
#[pyo3(signature = (key=None))]
pub fn measure_lines(key: Option<usize>) -> Vec<(&'static str, &'static str, &'static str, usize, String, bool)> {
    let key = key.unwrap_or(MIDDLE_C);
    lines().map(|line| (line.key, line.label, line.unit, line.decimals, line.usual(key), line.on_request)).collect()
}

/// Returns the lines of the sheet by their names; `argument` is named in the error.
pub(crate) fn lines_named(argument: &str, names: &[String]) -> PyResult<Vec<&'static Line>> {
    let find = |name: &String| {
        lines().find(|line| line.key == *name).ok_or_else(|| {
            let known: Vec<&str> = lines().map(|line| line.key).collect();
            wrong_argument(argument, format!("found `{name}`, expected {}", known.join(", ")))
        })
    };
    names.iter().map(find).collect()
}

/// Measures an instrument and returns the sheet, or only some of its lines, as JSON; and the key whose norms hold.
#[pyfunction]
#[pyo3(signature = (instrument, key, only, rest, progress))]
pub(crate) fn measure(
    py: Python<'_>,
    instrument: &Instrument,
    key: Option<Key>,
    only: Option<Vec<String>>,
    rest: &str,
    progress: Option<Py<PyAny>>,
) -> PyResult<(String, usize)> {
    let mut inner = (*instrument.inner).clone();
    if let Some(key) = key {
        inner.set_key(key.number("key")?).map_err(|error| wrong_argument("key", error.to_string()))?;
    }
    let (key, kind) = (norms_key(&inner), rest_named(rest)?);
    let at_rest = move |going: &mut erard::Progress<'_>| RestPose::of(&inner, kind, going).map_err(MeasureError::from);
    let Some(only) = only else {
        let sheet = watched(py, progress, move |going| measure_all(&at_rest(going)?, going), fault::measure)?;
        return Ok((serde_json::to_string(&sheet).map_err(failed)?, key));
    };
    let chosen = lines_named("only", &only)?;
    let values = watched(py, progress, |going| measure_some(&at_rest(going)?, &chosen, going), fault::measure)?;
    let object: serde_json::Map<String, serde_json::Value> =
        chosen.iter().zip(values).map(|(line, value)| (line.key.to_owned(), value.into())).collect();
    Ok((serde_json::to_string(&object).map_err(failed)?, key))
}

/// The rest of an argument.
fn rest_named(text: &str) -> PyResult<RestKind> {
    match text {
        "as-played" => Ok(RestKind::AsPlayed),
        "as-drawn" => Ok(RestKind::AsDrawn),
        _ => Err(wrong_argument("rest", format!("found `{text}`, expected as-played or as-drawn"))),
    }
}

/// Turns screws until goals are met. Returns the new instrument and the outcome of each goal and screw.
#[pyfunction]
#[pyo3(signature = (instrument, goals, norms, follow, rest, progress))]
pub(crate) fn regulate<'py>(
    py: Python<'py>,
    instrument: &Instrument,
    goals: Vec<(String, Value)>,
    norms: bool,
    follow: bool,
    rest: &str,
    progress: Option<Py<PyAny>>,
) -> PyResult<(Instrument, Bound<'py, PyDict>)> {
    let mut specification: Specification = Vec::new();
    for (name, text) in &goals {
        let goal = Goal::named(name).ok_or_else(|| {
            let names: Vec<String> = Goal::ALL.into_iter().map(|goal| goal.name().replace([' ', '-'], "_")).collect();
            wrong_argument(name, format!("is no goal; expected {}", names.join(", ")))
        })?;
        let text = &match text {
            Value::Text(text) => text.clone(),
            // SI units, and shares.
            Value::Number(x) => match goal.quantity() {
                Quantity::Share => format!("{} %", 100.0 * x),
                quantity => format!("{x} {}", quantity.si_unit()),
            },
        };
        let target = parse_value(goal, text)
            .map_err(|expected| wrong_argument(name, format!("found `{text}`, expected {expected}")))?;
        specification.push((goal, target));
    }
    let is_open = specification.is_empty() && !norms;
    if norms {
        let given: Vec<Goal> = specification.iter().map(|(goal, _)| *goal).collect();
        specification.extend(Goal::norms().into_iter().filter(|(goal, _)| !given.contains(goal)));
    }
    let (inner, kind) = (instrument.inner.clone(), rest_named(rest)?);
    let work = if follow || is_open { regulate_following } else { turn };
    let regulated = watched(
        py,
        progress,
        move |going| {
            let rest = RestPose::of(&inner, kind, going).map_err(DistanceError::from)?;
            let protocol = Protocol::default();
            let mut tell = |status: &Status| going(status.share);
            let specification = if is_open { needed(&rest, &protocol, &mut tell)? } else { specification };
            work(&rest, &specification, &protocol, &mut tell)
        },
        |error| match error {
            RegulateError::NoScrew { .. } => wrong(error),
            error => failed(error),
        },
    )?;
    let mut rows = Vec::new();
    for one in &regulated.achieved {
        let row = PyDict::new(py);
        row.set_item("goal", one.goal.name().replace([' ', '-'], "_"))?;
        row.set_item("target", one.target)?;
        row.set_item("before", one.before)?;
        row.set_item("after", one.after)?;
        row.set_item("met", one.miss.is_none())?;
        row.set_item("why_not", one.miss.as_ref().map(missed))?;
        rows.push(row);
    }
    let mut turned = Vec::new();
    for one in &regulated.turned {
        let row = PyDict::new(py);
        row.set_item("screw", &one.name)?;
        row.set_item("from", one.setting[0])?;
        row.set_item("to", one.setting[1])?;
        row.set_item("way", one.way)?;
        turned.push(row);
    }
    let about = PyDict::new(py);
    about.set_item("goals", rows)?;
    about.set_item("screws", turned)?;
    about.set_item("all_met", regulated.all_met())?;
    about.set_item("simulations", regulated.simulations)?;
    let asked: Vec<String> =
        regulated.achieved.iter().map(|one| format!("{} {}", one.goal.name(), show(one.goal, one.target))).collect();
    let title = format!("Regulated in simulation ({} trials) for {}", regulated.simulations, asked.join(", "));
    let note = "turned until the simulated action met its goals";
    Ok((instrument.turned(&regulated.instrument, &title, note)?, about))
}

fn missed(miss: &Miss) -> String {
    match miss {
        Miss::EndOfRange(screws) => format!("at the end of its range: {}", screws.join(", ")),
        Miss::NoSetting(screws) => format!("no setting of {} gives it", screws.join(" or ")),
        Miss::Disturbed => "it cannot be met together with the other goals".to_owned(),
    }
}

/// Number of steps of the key's travel between two checks for signals: some milliseconds.
const PIECE: usize = 20_000;

/// Computes leverage and sliding over the key's travel, for an instrument or for a linkage (a file or a built-in one).
#[pyfunction]
#[pyo3(signature = (instrument, linkage, from_m, to_m, steps))]
pub(crate) fn kinematics<'py>(
    py: Python<'py>,
    instrument: Option<&Instrument>,
    linkage: Option<&str>,
    from_m: f64,
    to_m: Option<f64>,
    steps: usize,
) -> PyResult<(Bound<'py, PyDict>, Bound<'py, PyDict>)> {
    if !(1..=1_000_000).contains(&steps) {
        return Err(wrong_argument("steps", format!("found {steps}, expected a number from 1 to 1000000")));
    }
    let design = match (instrument, linkage) {
        (Some(instrument), _) => derive(&instrument.inner).map_err(wrong)?.design,
        (None, Some(linkage)) => linkage_design(linkage)?,
        (None, None) => return Err(wrong("expected an instrument or a linkage")),
    };
    let case = design.case(&[], erard_kinematics::three_lever::Regulation::AsMoved).map_err(wrong)?;
    let to_m = to_m.or(case.let_off_key_m).unwrap_or(0.010);
    if !(from_m.is_finite() && to_m.is_finite() && to_m > from_m && to_m.abs() <= 1.0) {
        return Err(wrong_argument(
            "to_m",
            format!("found {from_m} to {to_m} m, expected a way downward of at most 1 m"),
        ));
    }
    let (poses, stopped_m) = watched(
        py,
        None,
        |going| {
            let (mut poses, mut stopped_m) = (Vec::new(), None);
            let at = |step: usize| from_m + step as f64 / steps as f64 * (to_m - from_m);
            for first in (0..steps).step_by(PIECE) {
                if !going(first as f64 / steps as f64) {
                    return Err("interrupted");
                }
                let last = steps.min(first + PIECE);
                let piece = case.stroke(at(first), at(last), last - first);
                // Where a piece begins the one before it has ended.
                poses.extend(piece.poses.into_iter().skip(usize::from(first > 0)));
                stopped_m = piece.stop.map(|stop| stop.key);
                if stopped_m.is_some() {
                    break;
                }
            }
            Ok((poses, stopped_m))
        },
        |error| failed(error),
    )?;
    let columns = PyDict::new(py);
    let of = |get: &dyn Fn(&StrokePose) -> f64| array(py, poses.iter().map(get).collect());
    columns.set_item("key_m", of(&|pose| pose.key))?;
    columns.set_item("leverage", of(&|pose| pose.leverage))?;
    columns.set_item("capstan_m", of(&|pose| pose.s1))?;
    columns.set_item("knuckle_m", of(&|pose| pose.s2))?;
    let digest = case.digest();
    let about = PyDict::new(py);
    about.set_item("name", &design.name)?;
    about.set_item("leverage_at_rest", digest.start.leverage)?;
    about.set_item("leverage_half_way", digest.middle.map(|spot| spot.leverage))?;
    about.set_item("leverage_at_let_off", digest.let_off.map(|spot| spot.leverage))?;
    about.set_item("let_off_key_m", case.let_off_key_m)?;
    about.set_item("capstan_sliding_m", digest.let_off.map(|_| digest.capstan_sliding_m))?;
    about.set_item("knuckle_sliding_m", digest.let_off.map(|_| digest.knuckle_sliding_m))?;
    about.set_item("stopped_at_key_m", stopped_m)?;
    Ok((columns, about))
}

fn linkage_design(asked: &str) -> PyResult<Design> {
    let path = Path::new(asked);
    let is_file = path.exists() || path.extension().is_some() || path.components().count() > 1;
    let file = if is_file {
        LinkageFile::load(path).map_err(|error| fault::file(&error))?
    } else {
        LinkageFile::builtin(asked).ok_or_else(|| {
            let names: Vec<&str> = LinkageFile::builtin_names().collect();
            wrong_argument("linkage", format!("found `{asked}`, expected a file or one of {}", names.join(", ")))
        })?
    };
    file.design().map_err(wrong)
}

/// Weighs the keys of a keyboard and returns columns.
#[pyfunction]
#[pyo3(signature = (asked, keys, progress))]
pub(crate) fn keyboard<'py>(
    py: Python<'py>,
    asked: &str,
    keys: Vec<Key>,
    progress: Option<Py<PyAny>>,
) -> PyResult<(String, Bound<'py, PyDict>)> {
    let keyboard =
        asked.parse().and_then(|asked: InstrumentSpec| asked.keyboard()).map_err(|error| fault::asked(&error))?;
    let keys: Vec<usize> = keys.iter().map(|key| key.number("keys")).collect::<PyResult<_>>()?;
    let keys: Vec<(usize, Inner)> = keys
        .into_iter()
        .map(|key| {
            // Half a second for all 88.
            py.check_signals()?;
            Ok((key, keyboard.key(key).map_err(|error| fault::file(&error))?))
        })
        .collect::<PyResult<_>>()?;
    let weighed = watched(py, progress, move |going| weigh(&keys, going), fault::measure)?;
    let columns = PyDict::new(py);
    columns.set_item("key", weighed.iter().map(|one| one.key).collect::<Vec<_>>())?;
    columns.set_item("note", weighed.iter().map(|one| one.note.clone()).collect::<Vec<_>>())?;
    let number = |get: &dyn Fn(&Weights) -> Option<f64>| {
        let of = |one: &WeighedKey| one.weights.as_ref().ok().and_then(get).unwrap_or(f64::NAN);
        array(py, weighed.iter().map(of).collect())
    };
    columns.set_item("hammer_mass_g", number(&|one| Some(one.hammer_mass_g)))?;
    columns.set_item("strike_weight_g", number(&|one| Some(one.strike_weight_g)))?;
    columns.set_item("front_weight_g", number(&|one| Some(one.front_weight_g)))?;
    columns.set_item("down_weight_g", number(&|one| one.touch.down_weight_g))?;
    columns.set_item("up_weight_g", number(&|one| one.touch.up_weight_g))?;
    columns.set_item("balance_weight_g", number(&|one| one.touch.balance_weight_g()))?;
    columns.set_item("friction_weight_g", number(&|one| one.touch.friction_weight_g()))?;
    columns.set_item("mf_hammer_speed_m_per_s", number(&|one| one.test_press.hammer_speed_m_per_s))?;
    let is_trusted =
        |one: &WeighedKey| one.weights.as_ref().is_ok_and(|weights| weights.test_press.warnings.is_empty());
    columns.set_item("trusted", weighed.iter().map(is_trusted).collect::<Vec<_>>())?;
    columns.set_item("error", weighed.iter().map(|one| one.error().unwrap_or_default()).collect::<Vec<_>>())?;
    Ok((keyboard.name.clone(), columns))
}

/// Draws the action in one pose as SVG: at rest, or a time, s, after the start of a stroke.
#[pyfunction]
#[pyo3(signature = (instrument, stroke, at_s, steps, labels, forces, caption))]
#[allow(clippy::too_many_arguments)]
pub(crate) fn draw(
    py: Python<'_>,
    instrument: &Instrument,
    stroke: &Stroke,
    at_s: f64,
    steps: Steps,
    labels: bool,
    forces: bool,
    caption: String,
) -> PyResult<String> {
    let (own, stroke) = (instrument.inner.clone(), stroke.inner.clone());
    let setup = steps.setup_of(&own, &stroke, Some(at_s.max(steps.settings(&own)?.step)))?;
    let setup = Setup { record_every: None, ..setup };
    let run = {
        let own = own.clone();
        watched(
            py,
            None,
            move |going| {
                let inputs = stroke.inputs(&own.finger).map_err(|_| erard::SimulationError::NoKey)?;
                simulate(&own, inputs.as_ref(), &setup, going)
            },
            fault::simulation,
        )?
    };
    let row = if at_s > 0.0 { run.time_s.len() - 1 } else { 0 };
    let arrows = if forces { forces_at(&own, &run, row) } else { Vec::new() };
    let options = PoseOptions { labels, arrows, caption: Some(caption), ..PoseOptions::default() };
    Ok(pose_picture(&own, &angles_at(&run, row), &options).svg())
}
