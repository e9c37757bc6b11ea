//! The numbers of a run: printed, and as `summary.json`.

use std::fmt;

use erard::run::{LiftSeries, Run, Setup};
use erard::stroke::Prescribed;
use erard::trust::Warning;
use erard_workshop::compare::ForceUncertainty;
use moreau::Ledger;
use serde_json::{Value, json};

use crate::compare::force_uncertainty_json;
use crate::table::Table;

/// A number of a run: its JSON key, its name, the value of the JSON in the table's unit, that unit, and decimals.
pub(crate) type Measure = (&'static str, &'static str, f64, &'static str, usize);
pub(crate) const MEASURES: [Measure; 11] = [
    ("hammer_speed_m_per_s", "hammer speed at the string", 1.0, "m/s", 3),
    ("hammer_speed_normal_m_per_s", "along the string's normal", 1.0, "m/s", 3),
    ("key_start_s", "key start", 1e3, "ms", 2),
    ("toe_contact_s", "jack toe at let-off button", 1e3, "ms", 2),
    ("let_off_s", "last push on the knuckle", 1e3, "ms", 2),
    ("hammer_contact_s", "hammer contact", 1e3, "ms", 2),
    ("free_flight_s", "free flight", 1e3, "ms", 2),
    ("key_bottom_s", "key bottom", 1e3, "ms", 2),
    ("check_s", "check", 1e3, "ms", 2),
    ("peak_force_N", "peak finger force", 1.0, "N", 2),
    ("drive_work_J", "work of the finger", 1e3, "mJ", 2),
];

/// The value of a measure in a summary, in the table's unit; `None` where it did not happen.
pub(crate) fn value(summary: &Value, (key, _, factor, ..): &Measure) -> Option<f64> {
    summary.get(key)?.as_f64().map(|value| value * factor)
}

/// Why the hammer does not reach the string: how far the escapement went.
fn why_no_impact(summary: &Value) -> &'static str {
    let happened = |key: &str| !summary[key].is_null();
    match (happened("toe_contact_s"), happened("let_off_s")) {
        (_, true) => "the hammer left the jack too slowly and fell back",
        (true, _) => "the jack met its button, but was not pushed out",
        _ => "the key did not go down to let-off",
    }
}

/// The first lines of an answer of `press`: what a pianist would notice, with the bands where there are some.
pub(crate) fn headlines(answer: &Value) -> Vec<String> {
    let measure = |key: &str| MEASURES.iter().find(|(own, ..)| *own == key).and_then(|one| value(answer, one));
    let rows = answer["bands"].as_array();
    // A row of a band is named after the measure in the table's unit.
    let band = |key: &str, decimals: usize| {
        let stem = key.rsplit_once('_').map_or(key, |(stem, _)| stem);
        let row = rows?
            .iter()
            .find(|row| row["name"].as_str().is_some_and(|name| name == key || name == format!("{stem}_ms")))?;
        let end = |name: &str| row[name].as_f64().map(|end| format!("{end:.decimals$}"));
        Some(format!(" ({} to {})", end("low")?, end("high")?))
    };
    let with_band = |key: &str, number: f64, unit: &str, decimals: usize| {
        format!("{number:.decimals$} {unit}{}", band(key, decimals).unwrap_or_default())
    };
    let mut lines = Vec::new();
    if answer["model"] == "one-dof" {
        lines.push("One degree of freedom has no hammer: it gives the key's motion and the force.".to_owned());
    } else {
        match (measure("hammer_speed_m_per_s"), measure("hammer_contact_s")) {
            (Some(speed), Some(contact)) => {
                let after = measure("key_start_s").map_or_else(
                    || with_band("hammer_contact_s", contact, "ms after the start", 1),
                    |start| format!("{:.1} ms after the key starts to move", contact - start),
                );
                let speed = with_band("hammer_speed_m_per_s", speed, "m/s", 2);
                lines.push(format!("The hammer meets the string at {speed}, {after}."));
            }
            _ => lines.push(format!("The hammer does not reach the string: {}.", why_no_impact(answer))),
        }
        let impacts = answer["impacts"].as_array().map_or(0, Vec::len);
        if impacts > 1 {
            let often = if impacts == 2 { "twice".to_owned() } else { format!("{impacts} times") };
            lines.push(format!("It strikes {often}."));
        }
        if let Some(flight) = measure("free_flight_s") {
            lines.push(format!("Before that it flies free for {}.", with_band("free_flight_s", flight, "ms", 1)));
        }
    }
    match (measure("key_bottom_s"), measure("hammer_contact_s")) {
        (Some(bottom), Some(contact)) => {
            let order = if bottom < contact { "before" } else { "after" };
            lines.push(format!("The key reaches its bottom {:.1} ms {order} the impact.", (bottom - contact).abs()));
        }
        (Some(bottom), None) => lines.push(format!("The key reaches its bottom at {bottom:.1} ms.")),
        (None, _) => lines.push("The key does not reach its bottom.".to_owned()),
    }
    if let Some(force) = measure("peak_force_N") {
        lines.push(format!("The finger pushes with at most {}.", with_band("peak_force_N", force, "N", 1)));
    }
    if let Some((check, contact)) = measure("check_s").zip(measure("hammer_contact_s")) {
        lines.push(format!("The back check catches the hammer {:.1} ms after the impact.", check - contact));
    }
    if let Some(samples) = rows.map(|rows| rows.iter().filter_map(|row| row["samples"].as_u64()).max().unwrap_or(0)) {
        lines.push(format!("In brackets: 5 to 95 % of {samples} random grands."));
    }
    lines
}

/// The largest lift of each pivot that lies on a zone, above its place at the start of the run.
fn lifts(run: &Run) -> Value {
    let of = |lift: &LiftSeries| {
        let rest_m = lift.lift_m.first().copied().unwrap_or_default();
        let largest = lift.lift_m.iter().zip(&run.time_s).max_by(|a, b| a.0.total_cmp(b.0));
        let (largest_m, at_s) = largest.map_or((0.0, 0.0), |(lift_m, at_s)| (lift_m - rest_m, *at_s));
        json!({ "body": lift.name, "largest_m": largest_m, "largest_at_s": at_s })
    };
    run.lifts.iter().map(of).collect()
}

/// The numbers of a run.
#[derive(Debug, Clone)]
pub(crate) struct Summary {
    /// `summary.json` (chapter "What is written" of the book); null is what did not happen.
    pub json: Value,
    /// Warnings about the numbers.
    pub warnings: Vec<Warning>,
    /// What the force is worth, in words, where a recorded motion drives.
    pub force_uncertainty: Option<String>,
}

impl Summary {
    /// The numbers of a run; `names`: of the model, of the drive and of the solver.
    pub(crate) fn new(run: &Run, setup: &Setup, [model, drive, solver]: [&str; 3]) -> Self {
        let (e, w) = (&run.events, &run.work);
        let ledger = run.ledger.as_ref();
        let booked = |of: fn(&Ledger) -> f64| ledger.map(of);
        let controlled = setup.tolerance.zip(w.control.as_ref());
        let inner_steps = controlled.map_or(w.steps, |(_, c)| c.inner_steps);
        let control = controlled.map(|(tolerance, c)| {
            json!({
                "tolerance": tolerance,
                "accepted_steps": c.accepted,
                "rejected_steps": c.rejected,
                "inner_steps": c.inner_steps,
                "extrapolated_steps": c.extrapolated,
                "steps_beyond_tolerance": c.beyond_tolerance,
                "smallest_step_s": c.shortest_s.min(c.longest_s),
                "largest_step_s": c.longest_s,
            })
        });
        let impacts = e.impacts.iter().map(|s| {
            json!({
                "time_s": s.time_s,
                "hammer_speed_m_per_s": s.hammer_speed_m_per_s,
                "hammer_speed_normal_m_per_s": s.hammer_speed_normal_m_per_s,
            })
        });
        let json = json!({
            "instrument": run.instrument,
            "model": model,
            "drive": drive,
            "dt_s": setup.settings.step,
            "theta": setup.settings.theta,
            "solver": solver,
            "duration_s": setup.duration_s,
            "steps": w.steps,
            "unconverged_steps": w.unconverged_steps,
            "control": control,
            "newton_iterations_per_step": w.newton_iterations as f64 / inner_steps as f64,
            "hammer_speed_m_per_s": e.hammer_speed_m_per_s(),
            "hammer_speed_normal_m_per_s": e.hammer_speed_normal_m_per_s(),
            "key_start_s": e.key_start_s,
            "toe_contact_s": e.toe_contact_s,
            "let_off_s": e.let_off_s,
            "hammer_contact_s": e.hammer_contact_s(),
            "key_bottom_s": e.key_bottom_s,
            "check_s": e.check_s,
            "free_flight_s": e.free_flight_s(),
            "peak_force_N": run.peak_force_n,
            "energy_residual_relative": booked(Ledger::residual_relative),
            "drive_work_J": booked(|l| l.drive_work),
            "dissipated_J": {
                "pivot_dry": booked(|l| l.pivot_dry),
                "pivot_viscous": booked(|l| l.pivot_viscous),
                "felt": booked(|l| l.felt_damping),
                "coulomb": booked(|l| l.coulomb),
                "strings": booked(|l| l.surface),
            },
            "smallest_dissipation_J": booked(|l| l.smallest_term),
            "final_pivot_friction_N_m": run.final_pivot_friction_n_m,
            "impacts": impacts.collect::<Value>(),
            "lifts": lifts(run),
            "force_worth": Value::Null,
            "trusted": run.is_trusted(),
            "warnings": run.warnings,
        });
        Summary { json, warnings: run.warnings.clone(), force_uncertainty: None }
    }

    /// Adds what the force is worth under a motion of a kind.
    pub(crate) fn set_force_uncertainty(&mut self, uncertainty: &ForceUncertainty, driven: Prescribed) {
        self.json["force_worth"] = force_uncertainty_json(uncertainty);
        self.force_uncertainty = Some(uncertainty.describe(driven));
    }

    /// Name and value with unit, as printed.
    pub(crate) fn lines(&self) -> Vec<(String, String)> {
        let json = &self.json;
        let one_dof = json["model"] == "one-dof";
        let mut lines: Vec<(&str, String)> = Vec::new();
        for measure @ (key, name, _, unit, decimals) in &MEASURES {
            let shown = match value(json, measure) {
                Some(value) => format!("{value:.decimals$} {unit}"),
                None if *key == "hammer_speed_m_per_s" => format!("- (no impact: {})", why_no_impact(json)),
                None => "-".to_owned(),
            };
            if *key != "drive_work_J" && (!one_dof || ["key_start_s", "key_bottom_s", "peak_force_N"].contains(key)) {
                lines.push((name, shown));
            }
        }
        let impacts = json["impacts"].as_array().map_or(0, Vec::len);
        if impacts > 1 && !one_dof {
            lines.insert(6, ("impacts on the string", impacts.to_string()));
        }
        for lift in json["lifts"].as_array().into_iter().flatten() {
            let [largest_mm, at_ms] =
                ["largest_m", "largest_at_s"].map(|key| lift[key].as_f64().unwrap_or(f64::NAN) * 1e3);
            let name = lift["body"].as_str().unwrap_or_default();
            lines.push(("lift from the rail", format!("{largest_mm:.2} mm at {at_ms:.2} ms ({name})")));
        }
        let uncertainty = &json["force_worth"];
        if let Some(rms_n) = uncertainty["force_rms_N"].as_f64() {
            let within_n = uncertainty["force_within_95_N"].as_f64().unwrap_or(f64::NAN);
            lines.push(("force's noise, from the motion's", format!("{rms_n:.3} N rms, 95 % within {within_n:.3} N")));
        }
        let residual = json["energy_residual_relative"].as_f64().unwrap_or(f64::NAN);
        lines.push(("energy residual", format!("{residual:.1e} of the work put in")));
        lines.push(("steps", self.steps_line()));
        lines.push(("unconverged steps", json["unconverged_steps"].to_string()));
        lines.into_iter().map(|(name, value)| (name.to_owned(), value)).collect()
    }

    fn steps_line(&self) -> String {
        let us = |of: &Value| of.as_f64().unwrap_or(f64::NAN) * 1e6;
        match &self.json["control"] {
            Value::Null => {
                let number = |key: &str| self.json[key].as_f64().unwrap_or(f64::NAN);
                let halved = number("steps") * number("dt_s") > 1.001 * number("duration_s").max(number("dt_s"));
                let step_us = (us(&self.json["dt_s"]) * 1e3).round() / 1e3;
                format!("{} of {step_us} us{}", self.json["steps"], if halved { " and of parts of that" } else { "" })
            }
            c => format!(
                "{} of {:.3} to {:.0} us, in halves; {} more rejected",
                c["accepted_steps"],
                us(&c["smallest_step_s"]),
                us(&c["largest_step_s"]),
                c["rejected_steps"]
            ),
        }
    }
}

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        Table::of(["", ""], self.lines().into_iter().map(<[String; 2]>::from)).fmt(f)
    }
}
