//! [H] figures 3 and 4, its equations, and its conclusions for the designer.

use erard_kinematics::three_lever::{Drive, Levers, Move, Regulation, StrokePose};

use super::impact::tell;
use super::{Chart, ChartCurve, ChartPanel, Claim, Dash, Progress, ReproduceError, Section, Table};
use erard::instrument::Instrument;
use erard_kinematics::{Case, Design, Digest, LinkageFile, derive, slow_press};

const POSES: usize = 200;

pub(super) fn section(instrument: &Instrument, progress: &mut Progress) -> Result<Section, ReproduceError> {
    let wrong = |e: &dyn std::fmt::Display| ReproduceError::Instrument(e.to_string());
    let file = LinkageFile::builtin("c7f-like").ok_or_else(|| wrong(&"the built-in linkage cannot be read"))?;
    let design = file.design().map_err(|e| wrong(&e))?;
    let mut section = Section {
        text: vec![format!(
            "Three levers, `{}`: key, whippen with jack, hammer. Nothing of [H]'s table of lengths is printed; ours are estimates of a concert \
             grand's. (i) as it is, (ii) the capstan 10 mm toward the player, (iii) the knuckle 3 mm toward the hammer's pivot, each regulated \
             again so that the hammer rests where it did.",
            design.name
        )],
        ..Section::default()
    };
    let mechanism = Levers::from(file.levers).linkage(Drive::Key).assemble().map_err(|e| wrong(&e))?;
    let equations: Vec<String> = mechanism.equations().iter().map(ToString::to_string).collect();
    section.listings.push((
        "The closure equations as the linear graph gives them: k (key) is given, w (whippen), h (hammer), S1 (capstan), S2 (knuckle) follow. \
         [H] prints the first without the minus before S1."
            .into(),
        equations.join("\n"),
    ));
    section.claims.push(Claim::new(
        "[H]",
        "two loops of the linear graph give four closure equations for w, h, S1 and S2",
        format!("{} equations in {} unknowns", equations.len(), mechanism.unknown().len()),
        equations.len() == 4 && mechanism.unknown().len() == 4,
    ));
    let moves: [(&str, &[Move]); 3] = [
        ("(i) as it is", &[]),
        ("(ii) capstan −10 mm", &[Move::Capstan(-0.010)]),
        ("(iii) knuckle −3 mm", &[Move::Knuckle(-0.003)]),
    ];
    let mut cases: Vec<(&str, Case, Digest)> = Vec::new();
    for (name, moves) in moves {
        let case = design.case(moves, Regulation::Regulated).map_err(|e| wrong(&e))?;
        let digest = case.digest();
        cases.push((name, case, digest));
    }
    tell(progress, 0.1)?;
    figures(&design, &cases, &mut section);
    conclusions(&cases, &mut section);
    slow(instrument, &mut section)?;
    tell(progress, 1.0)?;
    Ok(section)
}

fn figures(design: &Design, cases: &[(&str, Case, Digest)], section: &mut Section) {
    let poses: Vec<Vec<StrokePose>> =
        cases.iter().map(|(_, case, _)| case.stroke(0.0, case.let_off_key_m.unwrap_or(0.010), POSES).poses).collect();
    let curves = |value: fn(&StrokePose) -> f64| {
        let marks = [Dash::Solid, Dash::Dashed, Dash::Dotted];
        cases
            .iter()
            .zip(&poses)
            .enumerate()
            .map(|(i, ((name, _, _), poses))| ChartCurve {
                label: (*name).into(),
                x: poses.iter().map(|p| p.key * 1e3).collect(),
                y: poses.iter().map(value).collect(),
                colour: i + 1,
                mark: marks[i % 3],
            })
            .collect()
    };
    let panel = |y_label: &str, value| ChartPanel {
        y_label: y_label.into(),
        y_log: false,
        y_range: None,
        curves: curves(value),
    };
    let x_label = "key front, down (mm)".to_owned();
    section.charts.push(Chart {
        title: "[H] fig. 3: sliding at the contacts".into(),
        caption: format!("{}, from rest to let-off: how far the parts have slid along each other", design.name),
        x_label: x_label.clone(),
        x_log: false,
        panels: vec![
            panel("capstan (mm)", |p| p.capstan_sliding * 1e3),
            panel("knuckle (mm)", |p| p.knuckle_sliding * 1e3),
        ],
    });
    section.charts.push(Chart {
        title: "[H] fig. 4: leverage".into(),
        caption: format!("{}: speed of the hammer head over speed of the key front", design.name),
        x_label,
        x_log: false,
        panels: vec![panel("leverage (mm per mm)", |p| p.leverage)],
    });
}

fn conclusions(cases: &[(&str, Case, Digest)], section: &mut Section) {
    let mut table = Table::new(
        "From rest to let-off",
        &["case", "leverage at rest", "half-way", "at let-off", "key at let-off", "capstan slides", "knuckle slides"],
    );
    for (name, _, d) in cases {
        let leverage = |at: Option<erard_kinematics::Spot>| at.map_or("-".into(), |s| format!("{:.3}", s.leverage));
        table.row([
            (*name).into(),
            format!("{:.3}", d.start.leverage),
            leverage(d.middle),
            leverage(d.let_off),
            d.let_off.map_or("-".into(), |s| format!("{:.2} mm", s.key_m * 1e3)),
            format!("{:.2} mm", d.capstan_way_m * 1e3),
            format!("{:.2} mm", d.knuckle_way_m * 1e3),
        ]);
    }
    section.tables.push(table);
    let d = &cases[0].2;
    section.claims.push(Claim::new(
        "[H] fig. 3",
        "the capstan slides little, the knuckle much more",
        format!(
            "{:.2} mm and {:.2} mm to and fro, {:.1} times",
            d.capstan_way_m * 1e3,
            d.knuckle_way_m * 1e3,
            d.knuckle_way_m / d.capstan_way_m
        ),
        d.knuckle_way_m > 2.0 * d.capstan_way_m,
    ));
    let at_let_off = |d: &Digest| d.let_off.map_or(f64::NAN, |s| s.leverage);
    section.claims.push(Claim::new(
        "[H] fig. 4",
        "leverage falls through the stroke",
        format!("from {:.3} to {:.3}", d.start.leverage, at_let_off(d)),
        at_let_off(d) < d.start.leverage,
    ));
    for (case, word, lower) in [(&cases[1], "lower", true), (&cases[2], "higher", false)] {
        let (start, end) = (case.2.start.leverage / d.start.leverage, at_let_off(&case.2) / at_let_off(d));
        section.claims.push(Claim::new(
            "[H] fig. 4",
            format!("{}: {word} leverage all along", case.0),
            format!("{:+.1} % at rest, {:+.1} % at let-off", 100.0 * (start - 1.0), 100.0 * (end - 1.0)),
            if lower { start < 1.0 && end < 1.0 } else { start > 1.0 && end > 1.0 },
        ));
    }
}

/// Compares the geometry with the dynamic model: leverage of a slow press.
fn slow(instrument: &Instrument, section: &mut Section) -> Result<(), ReproduceError> {
    let derived = derive(instrument)?;
    let wrong = |e: &dyn std::fmt::Display| ReproduceError::Instrument(e.to_string());
    let case = derived.design.case(&[], Regulation::Regulated).map_err(|e| wrong(&e))?;
    let let_off = case.let_off_key_m.ok_or_else(|| wrong(&"the instrument's hammer is not let off"))?;
    let press = slow_press(instrument, &derived.levers, let_off)?;
    let (measured, holds) = match press.agreement(&case.train, let_off) {
        Some(agreement) => (format!("largest deviation {:.2} %", 100.0 * agreement.worst), agreement.worst < 0.02),
        None => ("no range to compare".into(), false),
    };
    section.claims.push(Claim::new(
        "this program",
        "the dynamic model, pressed slowly, has the leverage of its geometry within 2 %",
        measured,
        holds,
    ));
    Ok(())
}
