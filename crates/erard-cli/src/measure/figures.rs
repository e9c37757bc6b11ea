//! The figures: hysteresis loop, inertia through the stroke, hammer speed against force, timing.

use erard_workshop::measure::TimingRow;
use erard_workshop::measure::range::MIDI_MAP;

use super::Measured;
use erard_figures::Picture;
use erard_figures::figure::{Dash, Figure, Marker, Panel, Trace, figure_picture};

/// A figure's file name, without extension, what it shows, and itself.
#[derive(Debug, Clone)]
pub(crate) struct Drawn {
    /// Stem of its files.
    pub name: String,
    /// For people who cannot see it.
    pub alt: String,
    /// The picture.
    pub picture: Picture,
}

/// All figures, in the order of the page.
pub(crate) fn figures(measured: &[Measured]) -> Vec<Drawn> {
    vec![
        drawn("hysteresis", "Force over key travel, slowly down and up", hysteresis(measured)),
        drawn("inertia", "Effective inertia at the key front through the stroke", inertia(measured)),
        drawn("range", "Hammer speed and MIDI velocity against the force on the key", range(measured)),
        drawn("timing", "What happens when, from pianissimo to fortissimo", timing(measured)),
    ]
}

fn drawn(name: &str, alt: &str, picture: Picture) -> Drawn {
    Drawn { name: name.to_owned(), alt: alt.to_owned(), picture }
}

/// What a curve is called: alone it needs no owner, beside others its owner's letter.
fn label(measured: &[Measured], index: usize, what: &str) -> String {
    match (measured.len(), what) {
        (1, _) => what.to_owned(),
        (_, "") => letter(index),
        _ => format!("{}, {what}", letter(index)),
    }
}

/// A, B, C: names are too long for a legend.
fn letter(index: usize) -> String {
    char::from(b'A' + (index % 26) as u8).to_string()
}

fn titled(measured: &[Measured], quantity: &str) -> String {
    match measured {
        [one] => format!("{}: {quantity}", one.label),
        _ => format!("{}{}", quantity[..1].to_uppercase(), &quantity[1..]),
    }
}

/// The line below the title: what is shown, or, of several actions, which letter is which.
fn subtitled(measured: &[Measured], what: &str) -> String {
    /// Characters that fit into the figure's width.
    const FIT: usize = 120;
    if measured.len() < 2 {
        return what.to_owned();
    }
    let each = FIT / measured.len() - 4;
    let names = measured.iter().enumerate().map(|(index, one)| {
        let short: String = one.label.chars().take(each).collect();
        let cut = if short == one.label { "" } else { "…" };
        format!("{} {short}{cut}", letter(index))
    });
    names.collect::<Vec<_>>().join(";  ")
}

fn largest<'a>(values: impl Iterator<Item = &'a f64>) -> f64 {
    values.copied().filter(|x| x.is_finite()).fold(0.0, f64::max)
}

/// Slow loops: solid with the pedal down, dashed with the dampers on the strings.
fn hysteresis(measured: &[Measured]) -> Picture {
    // Abscissae ascend: the way up is turned around.
    let turned: Vec<[Vec<f64>; 4]> = measured
        .iter()
        .map(|one| {
            let reverse = |series: &[f64]| series.iter().rev().copied().collect::<Vec<f64>>();
            let damped = one.sheet.hysteresis_dampers_down.as_ref();
            [
                reverse(&one.sheet.hysteresis.up_key_mm),
                reverse(&one.sheet.hysteresis.up_force_N),
                damped.map_or(Vec::new(), |l| reverse(&l.up_key_mm)),
                damped.map_or(Vec::new(), |l| reverse(&l.up_force_N)),
            ]
        })
        .collect();
    let mut curves = Vec::new();
    for (index, (one, up)) in measured.iter().zip(&turned).enumerate() {
        let pedal = &one.sheet.hysteresis;
        let mut push = |what: &str, x, y: &[f64], dash| {
            let label = if what.is_empty() { String::new() } else { label(measured, index, what) };
            curves.push(Trace::new(label, x, y.to_vec(), index, dash));
        };
        push("pedal down", &pedal.down_key_mm[..], &pedal.down_force_N, Dash::Solid);
        push("", &up[0][..], &up[1], Dash::Solid);
        if let Some(damped) = &one.sheet.hysteresis_dampers_down {
            push("dampers down", &damped.down_key_mm[..], &damped.down_force_N, Dash::Dashed);
            push("", &up[2][..], &up[3], Dash::Dashed);
        }
    }
    let far = largest(measured.iter().flat_map(|one| &one.sheet.hysteresis.down_key_mm));
    // The bottom rises to several newtons; what is felt on the way is below two.
    let close = 2.0;
    let whole = curves.clone();
    let panels = vec![
        Panel::new("force", "N", 300.0, curves).within(0.0, close),
        Panel::new("to the bottom", "N", 130.0, whole),
    ];
    let what =
        "so slow that weights, felts, springs and friction are left; the ripple is the hammer swinging on its felts";
    let markers = match measured {
        [one] => {
            one.sheet.let_off_begins_mm.map(|x| Marker { x, label: "let-off begins".into() }).into_iter().collect()
        }
        _ => Vec::new(),
    };
    let title = titled(measured, "slow loop");
    let over = (0.0, far.max(0.1));
    let figure = Figure::over("key front, down (mm)", over, title, subtitled(measured, what), panels);
    figure_picture(&Figure { markers, ..figure })
}

fn inertia(measured: &[Measured]) -> Picture {
    let mut curves = Vec::new();
    for (index, one) in measured.iter().enumerate() {
        let numbers = &one.sheet.inertia;
        let mut push = |what: &str, y: &'_ Vec<f64>, dash| {
            curves.push(Trace::new(label(measured, index, what), &numbers.key_mm, y.clone(), index, dash));
        };
        if one.sheet.dampers_down.is_some() {
            push("dampers down", &numbers.dampers_down_kg, Dash::Dashed);
        }
        push("pedal down", &numbers.pedal_down_kg, Dash::Solid);
    }
    let far = largest(measured.iter().flat_map(|one| &one.sheet.inertia.key_mm));
    let high = 1.15 * largest(measured.iter().flat_map(|one| &one.sheet.inertia.dampers_down_kg));
    let panels = vec![Panel::new("effective inertia", "kg", 300.0, curves).within(0.0, high.max(0.01))];
    let what = "mass at the key front with the same kinetic energy, from rest to where let-off begins";
    let title = titled(measured, "inertia through the stroke");
    let over = (0.0, far.max(0.1));
    figure_picture(&Figure::over("key front, down (mm)", over, title, subtitled(measured, what), panels))
}

fn range(measured: &[Measured]) -> Picture {
    let forces: Vec<Vec<f64>> =
        measured.iter().map(|one| one.sheet.dynamic_range.iter().map(|l| l.force_n).collect()).collect();
    let curves = |value: &dyn Fn(&erard_workshop::measure::range::Loudness) -> Option<f64>| -> Vec<Trace<'_>> {
        let each = measured.iter().zip(&forces).enumerate();
        each.map(|(index, (one, x))| {
            let y: Vec<f64> = one.sheet.dynamic_range.iter().map(|l| value(l).unwrap_or(f64::NAN)).collect();
            Trace::new(label(measured, index, ""), x, y, index, Dash::Solid)
        })
        .collect()
    };
    let panels = vec![
        Panel::new("hammer speed", "m/s", 240.0, curves(&|l| l.hammer_speed_m_per_s)),
        Panel::new("MIDI velocity", "1-127", 180.0, curves(&|l| l.midi_velocity.map(f64::from))).within(0.0, 127.0),
    ];
    let far = largest(forces.iter().flatten());
    let title = titled(measured, "hammer speed against a constant force");
    let x_label = "force on the key front (N)";
    figure_picture(&Figure::over(x_label, (0.0, far), title, subtitled(measured, MIDI_MAP), panels))
}

fn timing(measured: &[Measured]) -> Picture {
    // A row that did not sound has no place on this axis.
    let sounded = |one: &Measured, touch: &str| -> Vec<TimingRow> {
        let rows = one.sheet.timing.iter().filter(|row| row.touch == touch && row.hammer_speed_m_per_s.is_some());
        let mut rows: Vec<TimingRow> = rows.cloned().collect();
        rows.sort_by(|a, b| a.hammer_speed_m_per_s.unwrap_or(0.0).total_cmp(&b.hammer_speed_m_per_s.unwrap_or(0.0)));
        rows
    };
    let touches = ["pressed", "struck"];
    struct Strokes {
        label: String,
        colour: usize,
        speeds: Vec<f64>,
        rows: Vec<TimingRow>,
    }
    let mut series = Vec::new();
    for (index, one) in measured.iter().enumerate() {
        for touch in touches {
            let rows = sounded(one, touch);
            let speeds = rows.iter().filter_map(|row| row.hammer_speed_m_per_s).collect();
            series.push(Strokes { label: label(measured, index, touch), colour: index, speeds, rows });
        }
    }
    let curves = |value: fn(&TimingRow) -> Option<f64>| -> Vec<Trace<'_>> {
        series
            .iter()
            .map(|one| {
                let y: Vec<f64> = one.rows.iter().map(|row| value(row).unwrap_or(f64::NAN)).collect();
                // Five touches, each another motion of the hand: nothing lies between two of them.
                Trace::new(&one.label, &one.speeds, y, one.colour, Dash::Alone)
            })
            .collect()
    };
    let panels = vec![
        Panel::new("hammer contact", "ms", 190.0, curves(|row| row.hammer_contact_ms)),
        Panel::new("key bottom", "ms", 190.0, curves(|row| row.key_bottom_ms)),
        Panel::new("hammer ahead", "ms", 150.0, curves(|row| row.hammer_before_bottom_ms)),
        Panel::new("free flight", "ms", 150.0, curves(|row| row.free_flight_ms)),
    ];
    let far = largest(series.iter().flat_map(|one| &one.speeds));
    let title = titled(measured, "timing");
    let what = "after key start; hammer ahead of key bottom; from the last push to the string. From the left: pp, p, mf, f, ff";
    let over = (0.0, 1.04 * far.max(0.1));
    figure_picture(&Figure::over("hammer speed (m/s)", over, title, subtitled(measured, what), panels))
}
