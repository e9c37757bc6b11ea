//! `erard study --sensitivities`: which numbers matter.

use erard::instrument::Instrument;
use erard::run::Setup;
use erard_figures::Picture;
use erard_figures::figure::{Bar, Tornado, TornadoPanel, tornado_picture};
use erard_workshop::cores;
use erard_workshop::sensitivities::{
    Mark, Rest, Sensitivities, Sensitivity, SensitivityError, SensitivityOutcome, USUAL, Variable, VariableError,
    quantities, sensitivities,
};
use serde_json::{Value, json};

use crate::failure::Failure;
use crate::session::Session;
use crate::table::{Table, three};

/// Bars of a panel of the figure.
const MAX_BARS: usize = 14;

/// What is differentiated: the keys asked for, or the usual ones.
///
/// # Errors
/// A key that does not exist.
pub(crate) fn wanted(keys: &[String]) -> Result<Vec<SensitivityOutcome>, Failure> {
    let all = quantities();
    let asked: Vec<&str> = if keys.is_empty() { USUAL.to_vec() } else { keys.iter().map(String::as_str).collect() };
    let mut found: Vec<SensitivityOutcome> = Vec::new();
    for key in asked {
        let Some(one) = all.iter().find(|one| one.key == key) else {
            let known: Vec<&str> = all.iter().map(|one| one.key).collect();
            return Err(Failure::Usage(format!("--outcomes: found `{key}`, expected keys of {}", known.join(", "))));
        };
        if found.contains(one) {
            return Err(Failure::Usage(format!("--outcomes: `{key}` is given twice")));
        }
        found.push(*one);
    }
    Ok(found)
}

/// By what: the numbers asked for, or all parameters.
///
/// # Errors
/// A number that does not exist, or that stands at an end of its range.
pub(crate) fn variables(
    instrument: &Instrument,
    text: &str,
    names: &[String],
    constant: bool,
) -> Result<Vec<Variable>, Failure> {
    if names.is_empty() {
        return Ok(Variable::all(instrument));
    }
    let mut found: Vec<Variable> = Vec::new();
    for name in names {
        if name == "force" && !constant {
            return Err(Failure::Usage("--parameters force needs a constant force; add --force-step".into()));
        }
        if found.iter().any(|one| one.name == *name) {
            return Err(Failure::Usage(format!("--parameters: `{name}` is given twice")));
        }
        let one = Variable::named(instrument, text, name)
            .map_err(|error: VariableError| Failure::Usage(format!("--parameters: {error}")))?;
        found.push(one);
    }
    Ok(found)
}

/// Works them out.
///
/// # Errors
/// What cannot be differentiated, and an interruption.
pub(crate) fn find<'a>(
    session: &Session,
    instrument: &Instrument,
    by: Vec<Variable>,
    of: Vec<SensitivityOutcome>,
    stroke: &(dyn Fn() -> erard_workshop::study::Stroke<'a> + Sync),
    setup: &Setup,
    rest: Rest,
) -> Result<Sensitivities, Failure> {
    let mut progress = session.progress("differentiating");
    sensitivities(instrument, by, of, stroke, setup, rest, cores::count(), &mut |share| progress.tell(share)).map_err(
        |error| match error {
            SensitivityError::Simulation(error) => Failure::Simulation(error),
            SensitivityError::Measure(error) => {
                Failure::Measure { label: instrument.name.clone(), error: Box::new(error) }
            }
            SensitivityError::Gradient(erard::gradient::GradientError::Simulation(error)) => Failure::Simulation(error),
            error => Failure::Usage(error.to_string()),
        },
    )
}

/// A row of sensitivities.csv.
fn row(all: &Sensitivities, one: &Sensitivity) -> Value {
    let (of, by) = (&all.of[one.of], &all.by[one.by]);
    json!({
        "of": of.key,
        "by": by.name,
        "per": by.per,
        "derivative": one.derivative,
        "spread": one.spread,
        "usual_change": by.usual,
        "effect": one.effect(all),
        "elasticity": one.elasticity(all),
        "method": of.method.name(),
        "differences": one.differences.map(|[slope, _]| slope),
        "differences_error": one.differences.map(|[_, error]| error),
        "below": one.sides.map(|[below, _]| below),
        "above": one.sides.map(|[_, above]| above),
        "mark": one.mark.name(),
        "reason": one.reason,
    })
}

/// sensitivities.json.
pub(crate) fn report(all: &Sensitivities, instrument: &str, stroke: &str) -> Value {
    let values = all.of.iter().zip(&all.values);
    let values = values.map(|(of, value)| json!({"of": of.key, "value": value, "method": of.method.name()}));
    let [switches, unresolved] = all.switches;
    json!({
        "instrument": instrument,
        "stroke": stroke,
        "values": values.collect::<Value>(),
        "switches": switches,
        "unresolved_switches": unresolved,
        "rows": rows(all),
    })
}

/// The rows of sensitivities.csv.
pub(crate) fn rows(all: &Sensitivities) -> Vec<Value> {
    all.rows.iter().map(|one| row(all, one)).collect()
}

/// So many units of the number, as its label says them.
fn usual(variable: &Variable) -> String {
    format!("{} {}", three(variable.usual), variable.per)
}

fn shown(quantity: &SensitivityOutcome, x: f64) -> f64 {
    if quantity.thousandths { 1e3 * x } else { x }
}

fn heading(all: &Sensitivities, k: usize) -> String {
    let of = &all.of[k];
    let value = all.values[k].map_or("did not happen".to_owned(), |x| format!("{} {}", three(shown(of, x)), of.unit));
    format!("{}: {value}", of.label)
}

/// The figure, as SVG.
pub(crate) fn figure(all: &Sensitivities, title: &str) -> Picture {
    let panel = |k: usize| TornadoPanel {
        title: heading(all, k),
        unit: all.of[k].unit.to_owned(),
        bars: all
            .rows
            .iter()
            .filter(|one| one.of == k && one.effect(all).is_finite() && one.effect(all) != 0.0)
            .take(MAX_BARS)
            .map(|one| {
                let variable = &all.by[one.by];
                Bar {
                    label: format!("{} +{}", variable.name, usual(variable)),
                    effect: shown(&all.of[k], one.effect(all)),
                    error: shown(&all.of[k], one.spread * variable.usual),
                    marked: one.mark != Mark::None,
                }
            })
            .collect(),
    };
    tornado_picture(&Tornado {
        title: title.to_owned(),
        // As long as one panel is wide.
        subtitle: "what a usual change does to first order; hollow: cannot be trusted farther away".to_owned(),
        panels: (0..all.of.len()).map(panel).filter(|panel| !panel.bars.is_empty()).collect(),
    })
}

/// Three digits of a number of any size.
fn digits(x: f64) -> String {
    if x == 0.0 {
        return "0".to_owned();
    }
    if !x.is_finite() {
        return "unknown".to_owned();
    }
    let places = (2 - x.abs().log10().floor() as i32).clamp(0, 9) as usize;
    if x.abs() < 1e-6 { format!("{x:.1e}") } else { format!("{x:.places$}") }
}

/// The three parameters that matter most to each result, a line for each.
pub(crate) fn first(all: &Sensitivities) -> Vec<String> {
    let of = |(k, of): (usize, &_)| {
        let rows = all.rows.iter().filter(|one| one.of == k).take(3);
        let one = |one: &Sensitivity| {
            let variable = &all.by[one.by];
            format!("{} {} for {}", variable.name, digits(shown(of, one.derivative * variable.usual)), usual(variable))
        };
        format!("{}: {}", heading(all, k), rows.map(one).collect::<Vec<_>>().join("; "))
    };
    all.of.iter().enumerate().map(of).collect()
}

/// The table for people: of every quantity at most so many rows.
pub(crate) fn lines(all: &Sensitivities, most: usize) -> Vec<String> {
    let mut lines = Vec::new();
    for (k, of) in all.of.iter().enumerate() {
        lines.extend((k > 0).then(String::new));
        lines.push(format!("{}   (by {})", heading(all, k), of.method.name()));
        let rows: Vec<&Sensitivity> = all.rows.iter().filter(|one| one.of == k).collect();
        if rows.is_empty() {
            continue;
        }
        let unit = of.unit.to_owned();
        // No error bar: of a derivative it compares lengths of step, of a difference two windows.
        let heads = ["", "change", &unit, "spread", "elasticity", "differences", ""].map(str::to_owned);
        let cells = rows.iter().take(most).map(|one| {
            let variable = &all.by[one.by];
            let scaled = |x: f64| digits(shown(of, x * variable.usual));
            [
                variable.name.clone(),
                usual(variable),
                scaled(one.derivative),
                scaled(one.spread),
                one.elasticity(all).map_or("-".to_owned(), digits),
                one.differences.map_or("-".to_owned(), |[slope, _]| scaled(slope)),
                one.mark.name().to_owned(),
            ]
        });
        lines.extend(Table::of(heads, cells).lines());
        for one in rows.iter().take(most) {
            let (name, reason) = (&all.by[one.by].name, one.reason.as_deref());
            lines.extend(match one.mark {
                Mark::Unconverged => {
                    let reason = reason.unwrap_or("nowhere to be named");
                    Some(format!("  {name} has no derivative: {reason} differs between step lengths"))
                }
                _ => reason.map(|reason| format!("  {name}: {reason}")),
            });
        }
        if rows.len() > most {
            lines.push(format!("  {} more; sensitivities.csv holds them", rows.len() - most));
        }
    }
    lines
}
