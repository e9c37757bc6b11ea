//! All textbook problems, in rows of reference, result and error.

use moreau::Settings;
use moreau_conformance::{Expected, problems};

use super::impact::{Play, tell};
use super::{Claim, Progress, ReproduceError, Section, Table, small};
use erard::instrument::Instrument;

pub(super) fn section(instrument: &Instrument, progress: &mut Progress) -> Result<Section, ReproduceError> {
    let mut section = Section {
        text: vec![
            "Problems whose answers are known in closed form or by an independent quadrature. References share no code with the \
             engine. Tolerances follow from the scheme's order or from rounding, as the last column says; \"exactly\" is zero."
                .into(),
        ],
        ..Section::default()
    };
    let problems = problems();
    let count = problems.len() as f64 + 1.0;
    for (i, problem) in problems.iter().enumerate() {
        if problem.number == 9 {
            let (claim, table) = held_note(instrument)?;
            section.claims.push(claim);
            section.tables.push(table);
        }
        tell(progress, i as f64 / count)?;
        let rows = (problem.rows)();
        let mut table = Table::new(
            format!("{}. {}", problem.number, problem.name),
            &["quantity", "reference", "ours", "error", "allowed", "holds", "because"],
        );
        for row in &rows {
            let (reference, error, allowed) = match row.expected {
                Expected::Near { value, tolerance } => {
                    (number(value), small((row.ours - value).abs()), small(tolerance))
                }
                Expected::AtMost(bound) => (format!("at most {bound}"), String::new(), String::new()),
                Expected::AtLeast(bound) => (format!("at least {bound}"), String::new(), String::new()),
            };
            let unit = if row.unit.is_empty() { String::new() } else { format!(" ({})", row.unit) };
            table.row([
                format!("{}{unit}", row.quantity),
                reference,
                number(row.ours),
                error,
                allowed,
                yes(row.holds()),
                row.because.into(),
            ]);
        }
        let held = rows.iter().filter(|row| row.holds()).count();
        section.claims.push(Claim::new(
            "textbook",
            format!("{}. {}", problem.number, problem.name),
            format!("{held} of {} quantities agree with their references", rows.len()),
            held == rows.len(),
        ));
        section.tables.push(table);
    }
    Ok(section)
}

/// Problem 8: the note held with 12 N. The caught hammer must not move at all.
fn held_note(instrument: &Instrument) -> Result<(Claim, Table), ReproduceError> {
    let run = Play::Force(12.0).run(instrument, Settings::new(50e-6), 10.0, 20)?;
    let from = run.time_s.partition_point(|&t| t < 1.0);
    let mut table = Table::new(
        "8. The held note: 12 N for 10 s, what each body turns from 1 s on",
        &["body", "reference", "ours (rad)", "holds"],
    );
    let mut still = run.events.check_s.is_some();
    for body in &run.bodies {
        let first = body.angle_rad[from];
        let drift = body.angle_rad[from..].iter().fold(0.0, |m: f64, q| m.max((q - first).abs()));
        still &= drift == 0.0;
        table.row([body.name.clone(), "0, exactly".into(), number(drift), yes(drift == 0.0)]);
    }
    let measured = match run.events.check_s {
        Some(check) => {
            format!("caught at {:.1} ms; largest drift of any body from 1 s to 10 s: see the table", check * 1e3)
        }
        None => "the hammer is not caught".into(),
    };
    Ok((Claim::new("textbook", "8. The held note does not drift", measured, still), table))
}

/// Formats a number with twelve digits where they matter.
fn number(x: f64) -> String {
    if x == 0.0 {
        "0".into()
    } else if (1e-3..1e5).contains(&x.abs()) {
        let digits = (12 - x.abs().log10().floor() as i32).clamp(0, 14) as usize;
        let text = format!("{x:.digits$}");
        if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
    } else {
        format!("{x:.9e}")
    }
}

pub(super) fn yes(holds: bool) -> String {
    if holds { "yes".into() } else { "NO".into() }
}
