//! [H] figures 3 and 4, its equations, and its conclusions for the designer.

use erard_kinematics::three_lever::{Drive, Levers, Move, Regulation, StrokePose};

use moreau::Settings;

use super::impact::{Play, tell};
use super::{Chart, ChartCurve, ChartPanel, Claim, Dash, Progress, ReproduceError, Section, Table};
use erard::instrument::Instrument;
use erard::player;
use erard::run::{Setup, simulate};
use erard::stroke::{PositionSeries, Touch};
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
    tell(progress, 0.5)?;
    consequence(instrument, &cases, &mut section)?;
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

/// Key travel at which hammer speeds are compared, m: on the way up, before anything is let off.
const COMPARED_M: f64 = 6e-3;
/// Rise of the hammer up to which losses are compared, m.
const RISEN_M: f64 = 25e-3;

/// What [H] concludes from leverage for the hammer's speed, and from sliding for losses, in the dynamic model: the same
/// key motion with the capstan and the knuckle moved as in the figures.
fn consequence(
    instrument: &Instrument,
    cases: &[(&str, Case, Digest)],
    section: &mut Section,
) -> Result<(), ReproduceError> {
    let zone = |name: &str| instrument.zones.iter().position(|zone| zone.name == name);
    let (Some(capstan), Some(knuckle)) = (zone("capstan_heel"), zone("jack_knuckle")) else {
        section.text.push("The instrument has no capstan_heel and jack_knuckle: no dynamic consequences.".to_owned());
        return Ok(());
    };
    let reference = Play::Stroke("mf", Touch::Pressed).run(instrument, Settings::new(25e-6), 0.2, 20)?;
    let motion = PositionSeries::new(reference.time_s, reference.key_m)
        .map_err(|e| ReproduceError::Instrument(format!("the key's motion gives no series: {e}")))?;
    let position = motion.drive();
    let drive = player::rigid(&position);
    // Hammer speed at that travel, m/s, and energy lost by sliding up to that rise, J.
    let at = |zone: usize, by_m: f64| -> Result<[f64; 2], ReproduceError> {
        let mut moved = instrument.clone();
        moved.edit(|fields| fields.zones[zone].disc_center_m[0] += by_m)?;
        let play = |duration_s: f64| {
            let setup = Setup { settings: Settings::new(25e-6), record_every: Some(1), ..Setup::new(duration_s) };
            simulate(&moved, &drive, &setup, &mut |_| true)
        };
        let whole = play(0.2)?;
        let row = |of: &[f64], from_m: f64| {
            let row = of.iter().position(|m| *m >= from_m);
            row.ok_or_else(|| ReproduceError::Instrument("key and hammer do not come so far".to_owned()))
        };
        let (down, risen) = (row(&whole.key_m, COMPARED_M)?, row(&whole.hammer_rise_m, RISEN_M)?);
        let until = play(whole.time_s[risen])?;
        let slid_j = until.ledger.as_ref().map_or(f64::NAN, |ledger| ledger.coulomb);
        Ok([whole.hammer_rise_m_per_s[down], slid_j])
    };
    let [own, by_capstan, by_knuckle] = [at(capstan, 0.0)?, at(capstan, -0.010)?, at(knuckle, -0.003)?];
    let shown = |[speed, _]: [f64; 2]| format!("{speed:.3} m/s for {:.3} m/s, {:.0} mm down", own[0], 1e3 * COMPARED_M);
    section.claims.push(Claim::new(
        "[H] conclusions",
        "same key motion, capstan 10 mm toward the player: the hammer is slower",
        shown(by_capstan),
        by_capstan[0] < own[0],
    ));
    section.claims.push(Claim::new(
        "[H] conclusions",
        "same key motion, knuckle 3 mm toward the hammer's pivot: the hammer is faster",
        shown(by_knuckle),
        by_knuckle[0] > own[0],
    ));
    let [own_way, way] = [0, 2].map(|case| cases[case].2.knuckle_way_m);
    let more = way > own_way;
    let word = if more { "more" } else { "less" };
    section.claims.push(Claim::new(
        "[H] conclusions",
        format!("that knuckle slides {word} on the jack, and {word} energy is lost by sliding"),
        format!(
            "{:.2} mm for {:.2} mm up to let-off; {:.3} mJ for {:.3} mJ until the hammer is {:.0} mm up",
            1e3 * way,
            1e3 * own_way,
            1e3 * by_knuckle[1],
            1e3 * own[1],
            1e3 * RISEN_M
        ),
        (by_knuckle[1] > own[1]) == more,
    ));
    Ok(())
}
