//! How stiff a coupling a haptic key can stand, by simulation and by theory: writes the figure haptic.svg into a
//! folder, and prints the tables of `docs/notes/coupling.md`. `.ci/regenerate haptic` writes the figure.
//!
//! ```text
//! haptic_margin [FOLDER [INSTRUMENT]]    INSTRUMENT: a built-in one (concert-grand), or a file
//! ```

#[path = "../tests/abi/haptic_loop.rs"]
mod haptic_loop;

use std::borrow::Cow;

use erard::Instrument;
use erard_figures::figure::{Dash, Figure, Layout, PALETTE, Panel, Scale, Trace, Window, figure_picture};
use haptic_loop::{Device, Finger, play, play_admittance, stiffest_still};

const RATES: [f64; 3] = [1e3, 4e3, 20e3];
const DAMPINGS: [f64; 7] = [0.25, 0.5, 1.0, 2.0, 4.0, 7.0, 10.0];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = std::env::args().nth(1).unwrap_or_else(|| ".".into());
    let name = std::env::args().nth(2).unwrap_or_else(|| "concert-grand".into());
    let grand = match Instrument::builtin(&name) {
        Ok(grand) => grand,
        Err(_) => Instrument::load(name.as_ref())?,
    };
    let file = [grand.finger.stiffness_n_per_m, grand.finger.damping_n_s_per_m];

    println!("| device damping, N s/m | 1 kHz | passive | 4 kHz | passive | 20 kHz | passive |");
    println!("|---|---|---|---|---|---|---|");
    let mut curves = Vec::new();
    let mut simulated = [const { Vec::new() }; 3];
    for damping in DAMPINGS {
        let mut row = format!("| {damping} ");
        for (k, rate) in RATES.iter().enumerate() {
            let device = Device::usual(*rate, damping);
            let found = stiffest_still(&grand, &device);
            simulated[k].push(found);
            row += &format!("| {found:.0} | {:.0} ", device.passive_n_per_m(0.0, true));
        }
        println!("{row}|");
    }
    for (k, rate) in RATES.iter().enumerate() {
        let name = format!("{} kHz", rate / 1e3);
        let bound = |with_delay| DAMPINGS.map(|b| Device::usual(*rate, b).passive_n_per_m(0.0, with_delay)).to_vec();
        for (label, y, dash) in [
            (format!("{name}, simulated"), simulated[k].clone(), Dash::Points),
            (format!("{name}, b / (T/2 + delay)"), bound(true), Dash::Dashed),
            (format!("{name}, 2 b / T"), bound(false), Dash::Dotted),
        ] {
            curves.push(Trace { label, x: &DAMPINGS, y: Cow::Owned(y), colour: PALETTE[k], dash });
        }
    }
    let quantised = vec![Device::usual(1e3, 1.0).quantised_n_per_m(); DAMPINGS.len()];
    let limits = [("the instrument's fingertip", vec![file[0]; DAMPINGS.len()]), ("2 c / quantum", quantised)];
    for (n, (label, y)) in limits.into_iter().enumerate() {
        curves.push(Trace {
            label: label.into(),
            x: &DAMPINGS,
            y: Cow::Owned(y),
            colour: PALETTE[6 + 4 * n],
            dash: Dash::Solid,
        });
    }
    let panel = Panel {
        quantity: "stiffest coupling".into(),
        unit: "N/m",
        height_px: 420.0,
        layout: Layout::Logarithmic,
        y_range: Some((100.0, 1e6)),
        curves,
    };
    let figure = Figure {
        title: "The stiffest coupling that a haptic key stands".into(),
        subtitle: format!(
            "{}, under a device of 50 g, 40 N, motor lag 0.2 ms, encoder 1 um, one period of latency",
            grand.name
        ),
        width_px: 1000.0,
        x_label: "the device's own damping b (N s/m)".into(),
        ..figure_of(panel)
    };
    std::fs::create_dir_all(&folder)?;
    std::fs::write(std::path::Path::new(&folder).join("haptic.svg"), figure_picture(&figure).svg())?;

    println!();
    println!("| loop | coupling | trembling, mm/s | largest force, N | hammer, m/s |");
    println!("|---|---|---|---|---|");
    let (direct, b) = (play_admittance(&grand, 50e-6, 20e3, Finger::Hand), 4.0);
    println!(
        "| the finger on the simulated key itself | - | {:.2} | {:.1} | {:.3} |",
        1e3 * direct.trembling_m_per_s,
        direct.largest_n,
        direct.hammer_speed_m_per_s
    );
    for rate in RATES {
        let device = Device::usual(rate, b);
        let advised = 0.5 * stiffest_still(&grand, &device);
        for (name, coupling) in [("the file's", file), ("half of the stiffest", [advised.min(file[0]), 0.0])] {
            let out = play(&grand, &device, coupling, Finger::Hand, false);
            println!(
                "| impedance, {} kHz, b = {b} N s/m | {name}: {:.0} N/m, {} N s/m | {:.2} | {:.1} | {:.3} |",
                rate / 1e3,
                coupling[0],
                coupling[1],
                1e3 * out.trembling_m_per_s,
                out.largest_n,
                out.hammer_speed_m_per_s
            );
        }
        let out = play(&grand, &device, file, Finger::Hand, true);
        println!(
            "| rigid, {} kHz, b = {b} N s/m | none | {:.2} | {:.1} | {:.3} |",
            rate / 1e3,
            1e3 * out.trembling_m_per_s,
            out.largest_n,
            out.hammer_speed_m_per_s
        );
    }
    for (rate, bandwidth) in [(1e3, 30.0), (1e3, 100.0), (4e3, 100.0), (4e3, 300.0), (20e3, 300.0), (20e3, 1000.0)] {
        let out = play_admittance(&grand, 1.0 / rate, bandwidth, Finger::Hand);
        println!(
            "| admittance, {} kHz, servo of {bandwidth} Hz | - | {:.2} | {:.1} | {:.3} |",
            rate / 1e3,
            1e3 * out.trembling_m_per_s,
            out.largest_n,
            out.hammer_speed_m_per_s
        );
    }
    Ok(())
}

/// A figure of one panel over the dampings.
fn figure_of(panel: Panel<'_>) -> Figure<'_> {
    let window =
        Window { from: DAMPINGS[0], to: DAMPINGS[6], weight: 1.0, heading: String::new(), names_markers: false };
    Figure {
        title: String::new(),
        subtitle: String::new(),
        width_px: 1000.0,
        x_label: String::new(),
        x_unit: 1.0,
        x_scale: Scale::Logarithmic,
        windows: vec![window],
        markers: Vec::new(),
        panels: vec![panel],
    }
}
