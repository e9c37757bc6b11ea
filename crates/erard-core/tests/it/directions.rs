//! Strings that move in two directions, on a bridge whose modes have directions: against a matrix exponential and
//! against closed forms, in their energy, and under a damper.

use std::f64::consts::PI;

use crate::common::strung;
use crate::dampers::{bridged, damped, damped_on_a_bridge, strings, swing};
use erard::instrument::{BridgeMode, Instrument, InstrumentFile, PianoString};
use erard::mechanism::{Halving, Mechanism, Stepping, mechanism, open_ledger, update_energies};
use erard::{Action, Input, Settings};

/// Horizontal motion of six modes.
const ASKEW: [f64; 6] = [0.3, -0.5, 0.2, 0.4, -0.3, 0.6];

/// Three strings on six modes that move askew. The blow is vertical.
fn askew() -> Instrument {
    let mut instrument = bridged();
    instrument
        .edit(|fields| {
            fields.strings.iter_mut().for_each(|string| string.strike_angle_rad = Some(0.0));
            fields.bridge_modes.iter_mut().zip(ASKEW).for_each(|(mode, askew)| mode.horizontal = askew);
        })
        .unwrap();
    instrument
}

/// Energy of a string's partial, vertical and horizontal, J.
fn energies_j(m: &dyn Mechanism, string: usize, n: u32) -> [f64; 2] {
    let all = strings(m);
    let one = &all.strings()[string];
    let (mass, omega) = (0.5 * one.mass_kg_per_m * one.length_m, 2.0 * PI * one.partial_hz(n));
    let energy = |now: Option<[f64; 2]>| now.map_or(0.0, |[q, v]| 0.5 * mass * (v * v + omega * omega * q * q));
    [energy(all.partial(string, n)), energy(all.partial_sideways(string, n))]
}

fn unhalved(instrument: &Instrument, h: f64) -> Box<dyn Mechanism> {
    let mut m = mechanism(instrument, Settings { tolerance: 1e-10, ..Settings::new(h) }).unwrap();
    m.configure(Stepping { halving: Halving::Never, ..*m.readout().stepping });
    m
}

/// Energy, forces on the bridge (vertical, horizontal) and energy of the horizontal motion after so many s, of three
/// strings whose first partials swing vertically at 0.1 m/s: from the matrix exponential of all as one linear system
/// (`docs/notes/strings.md` has the program).
#[test]
fn two_directions_are_those_of_an_independent_solution() {
    let reference: [(f64, f64, f64, f64, f64); 6] = [
        (0.1, 1.624102e-05, 3.65601e-01, -8.03885e-02, 1.42682e-06),
        (0.2, 1.050411e-05, -2.38602e-01, -1.50509e-01, 3.27766e-06),
        (0.5, 3.541974e-06, -7.93404e-02, -1.52695e-01, 2.64038e-06),
        (1.0, 1.297343e-06, 3.58991e-02, -1.16263e-01, 1.09522e-06),
        (2.0, 4.024276e-07, 1.06299e-03, -2.61509e-04, 3.53953e-07),
        (4.0, 4.688683e-08, 2.10709e-04, -3.21928e-04, 4.01879e-08),
    ];
    let instrument = askew();
    let mut errors = Vec::new();
    for (h, bound) in [(25e-6, 0.03), (12.5e-6, 0.01)] {
        let mut m = unhalved(&instrument, h);
        swing(m.as_mut(), &[0.1]);
        let mut now = 0;
        let mut worst: f64 = 0.0;
        for (instant, energy_j, vertical_n, horizontal_n, sideways_j) in reference {
            while now < (instant / h).round() as usize {
                m.step(&moreau::SiteInput::Free);
                now += 1;
            }
            let found = m.readout().surfaces.unwrap().energy();
            let forces = strings(m.as_ref()).bridge_forces_n();
            let sideways: f64 = (0..3)
                .flat_map(|string| (1..=18).map(move |n| (string, n)))
                .map(|(string, n)| energies_j(m.as_ref(), string, n)[1])
                .sum();
            let largest_n = 0.5 * (energy_j / reference[0].1).sqrt();
            let off_n = [forces[0] - vertical_n, forces[1] - horizontal_n].map(|off| off.abs() / largest_n);
            println!(
                "{h:e}, {instant} s: {found:.4e} J, expected {energy_j:.4e}; {forces:.4?} N, expected {vertical_n:.4e} and {horizontal_n:.4e}; sideways {sideways:.4e} J, expected {sideways_j:.4e}"
            );
            let off_j = [found / energy_j - 1.0, sideways / sideways_j - 1.0].map(f64::abs);
            assert!(off_j.iter().all(|off| *off < bound), "{h} {instant}: {off_j:?}");
            assert!(off_n.iter().all(|off| *off < 3.0 * bound), "{h} {instant}: {off_n:?}");
            worst = worst.max(off_j[0]);
        }
        errors.push(worst);
    }
    assert!(errors[1] < errors[0] / 2.5, "second order: {errors:?}");
}

/// One string, without dampers, on one broad mode of the bridge at its first partial: a conductance that hardly depends
/// on the frequency.
fn on_a_broad_mode(strings: usize, cents: f64, horizontal: f64) -> (Instrument, f64) {
    let mut instrument = damped(1.0);
    let (mass_kg, loss_factor) = (2.0, 0.5);
    instrument
        .edit(|fields| {
            fields.zones.truncate(1);
            let one = PianoString { damper: None, loss_per_s: 0.05, loss_s: 0.0, ..fields.strings[0].clone() };
            let tuned = |index: usize| {
                let factor = 2_f64.powf(2.0 * cents * (2.0 * index as f64 - 1.0) / 1200.0);
                let (tension_n, bending_n_m2) = (one.tension_n * factor, one.bending_n_m2 * factor);
                PianoString { tension_n, bending_n_m2, ..one.clone() }
            };
            fields.strings = if strings == 1 {
                vec![PianoString { strike_angle_rad: Some(0.0), ..one.clone() }]
            } else {
                (0..2).map(tuned).collect()
            };
            let frequency_hz = one.partial_hz(1);
            fields.bridge_modes =
                vec![BridgeMode { name: String::new(), mass_kg, frequency_hz, loss_factor, horizontal }];
        })
        .unwrap();
    let one = &instrument.strings[0];
    // The rate at which one string's motion decays into the bridge, (T/L) (1 + B) Re Y with Y = 1/(M eta omega).
    let conductance = 1.0 / (mass_kg * loss_factor * 2.0 * PI * one.partial_hz(1));
    (instrument.clone(), one.tension_n / one.length_m * (1.0 + one.inharmonicity()) * conductance)
}

/// A mode with the direction (1, c) takes energy from motion along it, at the rate y (1 + c^2), and leaves the motion
/// across it alone: of a vertical motion the part c^2/(1 + c^2) of the amplitude stays, as the second stage.
#[test]
fn one_mode_that_moves_askew_leaves_an_aftersound() {
    const OWN: f64 = 0.05;
    for c in [0.0, 0.3, -0.7] {
        let (instrument, rate) = on_a_broad_mode(1, 0.0, c);
        let mut m = unhalved(&instrument, 12.5e-6);
        swing(m.as_mut(), &[0.1]);
        let start = energies_j(m.as_ref(), 0, 1)[0];
        let mut now = 0;
        for time_s in [0.5, 1.0, 2.0, 4.0] {
            while now < (time_s / 12.5e-6_f64).round() as usize {
                m.step(&moreau::SiteInput::Free);
                now += 1;
            }
            let (square, left) = (1.0 + c * c, (-rate * (1.0 + c * c) * time_s).exp());
            let amplitudes = [(c * c + left) / square, c * (left - 1.0) / square];
            let expected = amplitudes.map(|a| a * a * (-2.0 * OWN * time_s).exp());
            let found = energies_j(m.as_ref(), 0, 1).map(|energy| energy / start);
            println!("c {c}, {time_s} s: {found:.5?}, expected {expected:.5?}");
            for (found, expected) in found.iter().zip(expected) {
                assert!((found - expected).abs() < 0.01 * expected + 1e-9, "{c} {time_s}: {found} {expected}");
            }
        }
    }
}

/// Two strings apart by 2 delta on a resistive bridge (G. Weinreich, JASA 62 (1977) 1474, section II): their sum and
/// difference exchange energy, with the rates sigma + y +- sqrt(y^2 - delta^2).
#[test]
fn two_strings_are_weinreichs() {
    const OWN: f64 = 0.05;
    for cents in [0.2, 0.5, 2.0] {
        let (instrument, y) = on_a_broad_mode(2, cents, 0.0);
        let omega = |string: usize| 2.0 * PI * instrument.strings[string].partial_hz(1);
        let delta = 0.5 * (omega(1) - omega(0));
        let mut m = unhalved(&instrument, 12.5e-6);
        swing(m.as_mut(), &[0.1]);
        let both = |m: &dyn Mechanism| energies_j(m, 0, 1)[0] + energies_j(m, 1, 1)[0];
        let (start, mut now) = (both(m.as_ref()), 0);
        for time_s in [0.3, 0.8, 2.0] {
            while now < (time_s / 12.5e-6_f64).round() as usize {
                m.step(&moreau::SiteInput::Free);
                now += 1;
            }
            let square = y * y - delta * delta;
            let kappa = square.abs().sqrt();
            let (cosh, sinh) = if square > 0.0 {
                ((kappa * time_s).cosh(), (kappa * time_s).sinh())
            } else {
                ((kappa * time_s).cos(), (kappa * time_s).sin())
            };
            let [sum, difference] = [cosh - y / kappa * sinh, delta / kappa * sinh];
            let expected = (sum * sum + difference * difference) * (-2.0 * (OWN + y) * time_s).exp();
            let found = both(m.as_ref()) / start;
            println!("{cents} cents (delta/y {:.2}), {time_s} s: {found:.5}, expected {expected:.5}", delta / y);
            assert!((found / expected - 1.0).abs() < 0.02, "{cents} {time_s}: {found} {expected}");
        }
    }
}

/// Without losses nothing is lost or won, at any step; and no step under dampers gives energy.
#[test]
fn two_directions_win_nothing() {
    let mut instrument = askew();
    instrument
        .edit(|fields| {
            for string in &mut fields.strings {
                (string.loss_per_s, string.loss_s) = (0.0, 0.0);
            }
            fields.bridge_modes.iter_mut().for_each(|mode| mode.loss_factor = 0.0);
        })
        .unwrap();
    for h in [10e-6, 50e-6, 500e-6] {
        let mut m = mechanism(&instrument, Settings::new(h)).unwrap();
        swing(m.as_mut(), &[0.1; 50]);
        let before = m.readout().surfaces.unwrap().energy();
        let mut sideways: f64 = 0.0;
        for _ in 0..20_000 {
            m.step(&moreau::SiteInput::Free);
            sideways = sideways.max(strings(m.as_ref()).bridge_forces_n()[1].abs());
        }
        let off = m.readout().surfaces.unwrap().energy() / before - 1.0;
        println!("{h:e}: {off:.1e} of {before:.2e} J; horizontally up to {sideways:.2} N");
        assert!(off.abs() < 1e-10 && sideways > 1e-2, "{h}: {off:e}");
    }
    for moves in [false, true] {
        let mut instrument = damped_on_a_bridge(0.5);
        instrument
            .edit(|fields| {
                fields.strings[0].strike_angle_rad = Some(0.05);
                fields.bridge_modes.iter_mut().zip(ASKEW).for_each(|(mode, askew)| mode.horizontal = askew);
                fields.roles.rigid_bridge = !moves;
            })
            .unwrap();
        let mut m = mechanism(&instrument, Settings { tolerance: 1e-10, ..Settings::new(50e-6) }).unwrap();
        swing(m.as_mut(), &[0.3, 0.0, 0.0, 0.0, 0.0, 0.3]);
        let mut ledger = open_ledger(m.as_mut());
        let before = m.readout().surfaces.unwrap().energy();
        let (mut lost, mut least) = (0.0, 0.0_f64);
        for _ in 0..2000 {
            m.step_in_parts(&mut |_, _, _| moreau::SiteInput::Free, &mut |m, _| m.record_energy(&mut ledger));
            least = least.min(ledger.surface - lost);
            lost = ledger.surface;
        }
        update_energies(m.as_ref(), &mut ledger);
        let residual = ledger.residual() / before;
        println!("moves {moves}: residual {residual:.1e}, least {:.1e}", least / before);
        assert!(residual.abs() < 1e-8 && least > -1e-12 * before, "{residual:e} {least:e}");
    }
}

/// Strings that nothing touches swing no farther, and press on a moving bridge no harder, than their energy allows.
#[test]
fn what_swings_stays_within_its_bounds() {
    let mut m = unhalved(&askew(), 12.5e-6);
    swing(m.as_mut(), &[0.1; 20]);
    for _ in 0..64 {
        m.step(&moreau::SiteInput::Free);
    }
    let bounds = |m: &dyn Mechanism| [m.readout().surfaces.unwrap().reach(0), strings(m).largest_bridge_n()];
    let before = bounds(m.as_ref());
    let mut most = [0.0_f64; 2];
    for _ in 0..20_000 {
        m.step(&moreau::SiteInput::Free);
        let now = [strings(m.as_ref()).displacement_m(), strings(m.as_ref()).bridge_n()];
        most.iter_mut().zip(now).for_each(|(most, now)| *most = most.max(now.abs()));
    }
    println!("{most:?} of {before:?}, at the end {:?}", bounds(m.as_ref()));
    for ((most, bound), end) in most.into_iter().zip(before).zip(bounds(m.as_ref())) {
        assert!(most < bound && bound < 100.0 * most && end < bound, "{most} {bound} {end}");
    }
}

/// A string that slides in its damper's felt decays with c sin^2 / (2 m), c = (b/k) F being the loss of the felt under
/// its force: the first order of a dashpot that is small beside the string's wave impedance (0.3 beside 2.1 N s/m).
#[test]
fn a_damper_damps_what_moves_sideways() {
    let mut instrument = damped(1.0);
    instrument
        .edit(|fields| {
            fields.strings[0].strike_angle_rad = Some(0.0);
            (fields.strings[0].loss_per_s, fields.strings[0].loss_s) = (0.0, 0.0);
        })
        .unwrap();
    let one = instrument.strings[0].clone();
    let mut m = unhalved(&instrument, 12.5e-6);
    // The first mode across, after 53 in the direction of the blow.
    let mut speeds = vec![0.0; 54];
    speeds[53] = 0.05;
    swing(m.as_mut(), &speeds);
    let start = energies_j(m.as_ref(), 0, 1);
    assert!(start[1] > 0.0 && energies_j(m.as_ref(), 0, 2)[1] == 0.0);
    let (steps, mut force_n) = (4000, 0.0);
    for _ in 0..steps {
        m.step(&moreau::SiteInput::Free);
        force_n += strings(m.as_ref()).damper_n().sum::<f64>() / f64::from(steps);
    }
    let time_s = f64::from(steps) * 12.5e-6;
    let rate = 0.5 * (start[1] / energies_j(m.as_ref(), 0, 1)[1]).ln() / time_s;
    // The mean of the felt's two places, and half their difference.
    let at = |place: f64| (PI * place / 0.62).sin();
    let places = [0.1 - 0.03 / 12_f64.sqrt(), 0.1 + 0.03 / 12_f64.sqrt()].map(at);
    let squares = 0.5 * (places[0] * places[0] + places[1] * places[1]);
    let c = 2.667e7 / 6.667e6 * force_n;
    let expected = c * squares / (one.mass_kg_per_m * one.length_m);
    println!("{rate:.2} 1/s, expected {expected:.2}");
    assert!((rate / expected - 1.0).abs() < 0.05, "{rate} {expected}");
}

/// Strings get parts of the hammer's force as their shares say, and horizontally as the blow's angle says.
#[test]
fn shares_and_angles_are_those_of_the_blow() {
    let mut instrument = strung();
    instrument
        .edit(|fields| {
            let middle = fields.strings[1].clone();
            for (string, (share, angle)) in fields.strings.iter_mut().zip([(2.0, 0.0), (1.0, 0.1), (1.0, 0.0)]) {
                (string.tension_n, string.bending_n_m2) = (middle.tension_n, middle.bending_n_m2);
                (string.strike_share, string.strike_angle_rad) = (share, Some(angle));
                // A damper that lies on the strings at first would displace all alike.
                string.damper = None;
            }
            fields.roles.rigid_bridge = true;
        })
        .unwrap();
    let mut action = Action::new(&instrument).unwrap();
    while action.impact().is_none() {
        action.step(Input::Force(5.0));
    }
    for _ in 0..400 {
        action.step(Input::Force(5.0));
    }
    let m = action.mechanism();
    let [first, second, third] = [0, 1, 2].map(|string| energies_j(m, string, 2));
    println!("{first:?} {second:?} {third:?}");
    assert!((first[0] / third[0] - 4.0).abs() < 1e-2, "shares of 2 and 1");
    assert!((second[1] / second[0] / 0.1_f64.tan().powi(2) - 1.0).abs() < 1e-2 && third[1] == 0.0);
}

/// A soundboard's bands become modes of the bridge, more than sixteen; wrong ones are refused.
#[test]
fn a_board_is_read() {
    let text = Instrument::builtin_text("concert-grand-strings").unwrap();
    let band = "[[board]]\nname = \"more\"\nfrom_Hz = 400\nto_Hz = 5000\nmodal_density_s = 0.02\nmass_g = 9000\nloss_factor = 0.02\nhorizontal = 0.2\nseed = 3\n";
    let before = InstrumentFile::parse(text, "mine.toml").unwrap().instrument.bridge_modes.len();
    let read = InstrumentFile::parse(&format!("{text}\n{band}"), "mine.toml").unwrap().instrument;
    let drawn = &read.bridge_modes[before..];
    assert_eq!(drawn.len(), 92);
    assert!(drawn.iter().all(|mode| (400.0..5000.0).contains(&mode.frequency_hz) && mode.name.starts_with("more.")));
    for (from, to, says) in [
        ("to_Hz = 5000", "to_Hz = 300", "upper end"),
        ("modal_density_s = 0.02", "modal_density_s = 2", "too many modes"),
        ("seed = 3", "seed = -3", "not a seed"),
        ("name = \"more\"", "name = \"More\"", "name"),
        ("mass_g = 9000", "mass_g = -1", "mass_g"),
    ] {
        let wrong = format!("{text}\n{}", band.replacen(from, to, 1));
        let message = InstrumentFile::parse(&wrong, "mine.toml").unwrap_err().to_string();
        println!("{message}");
        assert!(message.contains(says) && message.contains("mine.toml"), "{from}: {message}");
    }
}
