//! A comparison in numbers: printed, and as `compare.json`.

use erard::parameter::Quantity;
use erard::recording::Report;
use erard_workshop::compare::{Band, Comparison, Errors, ForceUncertainty, RATE_HZ, Trial, outcome, share};
use erard_workshop::digits::plain;
use serde_json::{Value, json};

use crate::print_line;
use crate::session::Session;
use crate::table::Table;

/// One quantity of a trial, held against what was measured.
struct Finding<'a> {
    trial: &'a Trial,
    quantity: &'static str,
    /// SI unit.
    unit: &'static str,
    /// Factor to the unit that is shown, and that unit.
    shown: (f64, &'static str),
    /// Errors are reported up to here, Hz.
    told_to_hz: f64,
    measured: bool,
    errors: Option<&'a Errors>,
}

/// What came out of every trial, and the hammer where it was measured.
fn findings(c: &Comparison) -> Vec<Finding<'_>> {
    let mut findings = Vec::new();
    for trial in &c.trials {
        let length = ("m", Quantity::Length.shown());
        let quantity = outcome(trial.driven);
        let (unit, shown) = if quantity == "position" { length } else { ("N", Quantity::Force.shown()) };
        let measured = c.measured(trial.driven).is_some();
        let (told_to_hz, errors) = (trial.told_to_hz, trial.errors.as_ref());
        findings.push(Finding { trial, quantity, unit, shown, told_to_hz, measured, errors });
        if c.measured_hammer_rise_m.is_some() && !trial.hammer_rise_m.is_empty() {
            let (unit, shown) = length;
            let (told_to_hz, errors) = (trial.hammer_told_to_hz, trial.hammer_errors.as_ref());
            findings.push(Finding { trial, quantity: "hammer", unit, shown, told_to_hz, measured: true, errors });
        }
    }
    findings
}

/// The first lines: the verdicts in brief, and what warns.
pub(crate) fn headlines(comparison: &Comparison, answer: &Value) -> Vec<String> {
    let warnings = answer["warnings"].as_array().into_iter().flatten().filter_map(Value::as_str);
    comparison.brief().into_iter().chain(warnings.map(|one| format!("warning: {one}"))).collect()
}

/// The errors as a table, then by frequency.
pub(crate) fn print_table(session: &mut Session, comparison: &Comparison) {
    let findings = findings(comparison);
    let heads = ["drive", "model", "quantity", "rms", "of range", "largest", "explained", "delay, ms", ""];
    let rows = findings.iter().map(|Finding { trial, quantity, shown: (factor, unit), measured, errors, .. }| {
        let numbers = match errors {
            Some(e) => [
                format!("{:.4}", e.rms * factor),
                format!("{:.2} %", e.rms_of_range * 100.0),
                format!("{:.4}", e.largest * factor),
                share(e.explained, 2).replace("less than ", "< "),
                plain(e.delay_s * 1e3, 2),
            ],
            None => [const { String::new() }; 5],
        };
        let why = match errors {
            Some(_) => "",
            None if *measured => "the recording holds nothing here",
            None => "not measured",
        };
        let names = [trial.driven.name().to_owned(), trial.which.name().to_owned(), format!("{quantity}, {unit}")];
        names.into_iter().chain(numbers).chain([why.to_owned()])
    });
    print_line!(session, "{}", Table::of(heads, rows).to_string().trim_end_matches('\n'));
    let limit = findings.iter().map(|f| f.told_to_hz).fold(f64::INFINITY, f64::min);
    if limit < 0.5 * RATE_HZ {
        let all = findings.iter().all(|f| f.told_to_hz == limit);
        print_line!(
            session,
            "  (all up to {limit:.0} Hz{}: above, the recording holds only noise or nothing)",
            if all { "" } else { " or more" }
        );
    }
    print_line!(session);
    if findings.iter().any(|f| f.errors.is_some()) {
        print_line!(session, "  error by frequency band in Hz (rms; in brackets, share of the signal there)");
        let Some(edges) = findings.iter().find_map(|finding| Some(&finding.errors?.bands)) else { return };
        let bands: Vec<String> = edges.iter().map(|band| format!("{:.0}-{:.0}", band.from_hz, band.to_hz)).collect();
        let heads = ["drive", "model", "quantity"].into_iter().chain(bands.iter().map(String::as_str));
        let rows = findings.iter().filter_map(|finding| {
            let Finding { trial, quantity, shown: (factor, unit), told_to_hz, errors, .. } = finding;
            let names = [trial.driven.name().to_owned(), trial.which.name().to_owned(), format!("{quantity}, {unit}")];
            let cells = errors.as_ref()?.bands.iter().map(|band| by_frequency(band, *factor, *told_to_hz));
            Some(names.into_iter().chain(cells).collect::<Vec<_>>())
        });
        print_line!(session, "{}", Table::of(heads, rows).to_string().trim_end_matches('\n'));
        print_line!(session);
    }
}

/// The error of a band, and its share of what was measured there.
fn by_frequency(band: &Band, factor: f64, told_to_hz: f64) -> String {
    if band.to_hz > told_to_hz {
        return "-".to_owned();
    }
    let share = 100.0 * band.error_rms / band.measured_rms.max(f64::MIN_POSITIVE);
    // A band in which next to nothing was measured has no share worth reading.
    let share = if share < 1e3 { format!("{share:.0} %") } else { "> 1000 %".to_owned() };
    format!("{:.4} ({share})", band.error_rms * factor)
}

/// compare.json.
pub(crate) fn report(c: &Comparison, prepared: &Report, measured: &str, instrument: &str) -> Value {
    let warnings = prepared.warnings().into_iter().chain(c.warnings());
    json!({
        "measured": measured,
        "instrument": instrument,
        "position_of": c.position_of.name(),
        "preparation": prepared.json(),
        "verdicts": c.verdicts(),
        "notes": c.notes,
        "warnings": warnings.collect::<Value>(),
        "findings": findings(c).iter().map(finding).collect::<Value>(),
    })
}

fn finding(f: &Finding<'_>) -> Value {
    let band = |b: &Band| {
        json!({
            "from_Hz": b.from_hz,
            "to_Hz": b.to_hz,
            "measured_rms": b.measured_rms,
            "error_rms": b.error_rms,
            "told": b.to_hz <= f.told_to_hz,
        })
    };
    let errors = f.errors.map(|e| {
        json!({
            "rms": e.rms,
            "rms_of_range": e.rms_of_range,
            "largest": e.largest,
            "explained": e.explained,
            "correlation": e.correlation,
            "delay_s": e.delay_s,
            "rest": e.rest.map(|rest| json!({
                "share_of_variance": rest.share,
                "explained_without": rest.explained_without,
            })),
            "bands": e.bands.iter().map(band).collect::<Value>(),
        })
    });
    json!({
        "drive": f.trial.driven.name(),
        "model": f.trial.which.name(),
        "quantity": f.quantity,
        "unit": f.unit,
        "told_to_Hz": Some(f.told_to_hz).filter(|hz| *hz < 0.5 * RATE_HZ),
        "errors": errors,
        "worth": f.trial.force_uncertainty.filter(|_| f.quantity == "force").map(|own| force_uncertainty_json(&own)),
    })
}

/// What a force is worth that comes out under a recorded motion.
pub(crate) fn force_uncertainty_json(uncertainty: &ForceUncertainty) -> Value {
    json!({
        "position_noise_m": uncertainty.noise_m,
        "force_rms_N": Some(uncertainty.rms_n).filter(|n| n.is_finite()),
        "force_within_95_N": Some(uncertainty.within_n).filter(|n| n.is_finite()),
    })
}
