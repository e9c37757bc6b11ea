//! Parts that bend: what they are when their bends are locked, and that they play like the rigid ones when the bends
//! are stiff.

use std::path::Path;

use crate::common::{Play, rigid_grand};
use erard::instrument::{Instrument, Zone};
use erard::{Action, Input, Settings};

/// The concert grand with a bending key, or with a bending key and shank: pieces whose masses were worked out by hand
/// from the rigid ones.
fn bending(bodies: usize) -> Instrument {
    let path = format!("{}/tests/bending/{bodies}-bodies.toml", env!("CARGO_MANIFEST_DIR"));
    Instrument::load(Path::new(&path)).expect("it reads")
}

fn near(a: f64, b: f64, within: f64, what: &str) {
    assert!((a - b).abs() <= within, "{what}: {a} beside {b}");
}

/// The world coordinates of a zone's disc as drawn.
fn disc(instrument: &Instrument, zone: &Zone) -> [f64; 2] {
    let (mut at, mut body) = (zone.disc_center_m, zone.disc_body);
    while let Some(b) = body {
        let on = &instrument.bodies[b];
        let drawn = on.angle_rad;
        // Angles are absolute, pivots in the parent's frame: only the innermost turn is the body's own.
        let (s, c) = drawn.sin_cos();
        at = [c * at[0] - s * at[1], s * at[0] + c * at[1]];
        let parent = on.parent.map_or(0.0, |p| instrument.bodies[p].angle_rad);
        let (s, c) = (-parent).sin_cos();
        at = [c * at[0] - s * at[1] + on.pivot_m[0], s * at[0] + c * at[1] + on.pivot_m[1]];
        body = on.parent;
    }
    at
}

/// Locked, the eight bodies are the six that they were made from: masses, moments, centres, names, places.
#[test]
fn locked_it_is_the_rigid_grand() {
    let (rigid, locked) = (rigid_grand(), bending(8).locked());
    assert!(!locked.has_bends() && !rigid.has_bends());
    assert_eq!(rigid.locked(), rigid);
    let names = |i: &Instrument| i.bodies.iter().map(|b| b.name.clone()).collect::<Vec<_>>();
    assert_eq!(names(&locked), names(&rigid));
    for (a, b) in locked.bodies.iter().zip(&rigid.bodies) {
        // The pieces' numbers are rounded to three or four digits in their file.
        near(a.mass_kg, b.mass_kg, 1e-9, &a.name);
        near(a.inertia_kg_m2, b.inertia_kg_m2, 1e-3 * b.inertia_kg_m2, &a.name);
        for axis in 0..2 {
            near(a.center_of_mass_m[axis], b.center_of_mass_m[axis], 1e-4, &a.name);
            near(a.pivot_m[axis], b.pivot_m[axis], 1e-9, &a.name);
        }
        assert_eq!(a.parent.map(|p| &locked.bodies[p].name), b.parent.map(|p| &rigid.bodies[p].name));
    }
    for (a, b) in locked.zones.iter().zip(&rigid.zones) {
        let name = |i: &Instrument, body: Option<usize>| body.map(|body| i.bodies[body].name.clone());
        assert_eq!(name(&locked, a.disc_body), name(&rigid, b.disc_body), "{}", a.name);
        assert_eq!(name(&locked, a.curve_body), name(&rigid, b.curve_body), "{}", a.name);
        let [x, y] = [disc(&locked, a), disc(&rigid, b)];
        // Three screws were turned by hundredths of a millimetre.
        near(x[0], y[0], 1e-4, &a.name);
        near(x[1], y[1], 1e-4, &a.name);
    }
    assert_eq!(locked.springs.len(), rigid.springs.len());
    assert_eq!(locked.screws.len(), rigid.screws.len());
}

/// Pieces that are frozen onto each other have the kinetic and potential energy of the locked part: with a moving
/// carrier, a turned piece, a rider on a bent piece.
#[test]
fn energies_of_frozen_pieces_are_those_of_the_locked_part() {
    let mut bent = bending(8);
    let head = crate::common::body(&bent, "hammer");
    // The head turned against its shank as drawn, so that frames differ.
    bent.edit(|fields| fields.bodies[head].angle_rad += 0.3).unwrap();
    let locked = bent.locked();
    let [a, b] = [&bent, &locked].map(|i| Action::as_drawn(i, Settings::new(50e-6)).unwrap());
    let rate = |name: &str| match name {
        "key" | "key_back" => 0.7,
        "whippen" => 1.1,
        "jack" => -2.0,
        "lever" => 3.0,
        "hammer" | "shank" => -4.0,
        _ => 0.4,
    };
    let energies = |i: &Instrument, action: &Action| {
        let rates: Vec<f64> = i.bodies.iter().map(|body| rate(&body.name)).collect();
        action.mechanism().energies_at(&rates)
    };
    let (a, b) = (energies(&bent, &a), energies(&locked, &b));
    assert!(a.kinetic > 1e-4, "{}", a.kinetic);
    near(a.kinetic, b.kinetic, 1e-12 * a.kinetic, "kinetic");
    near(a.gravity, b.gravity, 1e-12 * a.gravity.abs(), "gravity");
}

fn speed(instrument: &Instrument, play: &Play) -> f64 {
    play.run(instrument, Settings::new(25e-6), 0.2).events.hammer_speed_m_per_s().expect("an impact")
}

/// The stiffer the bends, the nearer the impact is to that of the locked action: a thousandth of the give makes less
/// than a hundredth of the difference.
#[test]
fn stiff_bends_play_like_none() {
    let bent = bending(8);
    let play = Play::ForceStep(5.0, 0.2);
    let locked = speed(&bent.locked(), &play);
    let stiffened = |by: f64| {
        let mut stiff = bent.clone();
        stiff
            .edit(|fields| {
                for spring in &mut fields.springs {
                    if fields.bodies[spring.body].is_bend {
                        spring.stiffness_n_m_per_rad *= by;
                    }
                }
            })
            .unwrap();
        (speed(&stiff, &play) / locked - 1.0).abs()
    };
    let [soft, stiff] = [1.0, 1e3].map(stiffened);
    println!("off by {soft:.1e} as it bends, by {stiff:.1e} a thousand times stiffer");
    assert!(stiff < 1e-2 * soft, "{soft} {stiff}");
}

/// The dry torque of the bends is a device for rest: no impact depends on it.
#[test]
fn the_dry_torque_of_bends_moves_no_blow() {
    for force_n in [1.0, 5.0, 20.0] {
        let impact = |by: f64| {
            let mut bent = bending(8);
            bent.edit(|fields| {
                for body in fields.bodies.iter_mut().filter(|body| body.is_bend) {
                    body.friction_torque_n_m *= by;
                }
            })
            .unwrap();
            let events = Play::ForceStep(force_n, 0.4).run(&bent, Settings::new(25e-6), 0.4).events;
            [events.hammer_speed_m_per_s(), events.hammer_contact_s(), events.key_bottom_s].map(Option::unwrap)
        };
        let usual = impact(1.0);
        for by in [0.5, 2.0] {
            for (with, without) in impact(by).into_iter().zip(usual) {
                println!("{force_n} N, times {by}: {:+.1e}", with / without - 1.0);
                near(with / without, 1.0, 1e-3, "speed, contact, bottom");
            }
        }
    }
}

/// A bending key that is held down is still, exactly: dry friction in the bends represents what brings wood to rest.
#[test]
fn a_held_note_is_still() {
    for bodies in [7, 8] {
        let mut action = Action::new(&bending(bodies)).unwrap();
        let play = |action: &mut Action, seconds: f64| {
            for _ in 0..(seconds / 50e-6) as usize {
                action.step(Input::Force(4.0));
            }
            action.angles().to_vec()
        };
        let before = play(&mut action, 3.0);
        assert!(action.is_asleep(), "{bodies} bodies");
        assert_eq!(before, play(&mut action, 60.0));
    }
}

/// The ledger closes as it does without bends, and every step converges.
#[test]
fn the_balance_closes() {
    for bodies in [7, 8] {
        for play in Play::strokes() {
            let run = play.run(&bending(bodies), Settings::new(50e-6), 0.6);
            let residual = run.ledger.as_ref().unwrap().residual_relative();
            assert!(residual < 1e-4, "{bodies} bodies, {play:?}: {residual:.1e}");
            assert_eq!(run.work.unconverged_steps, 0);
        }
    }
}

#[test]
fn a_bend_needs_a_piece_and_a_stiffness() {
    let path = format!("{}/tests/bending/7-bodies.toml", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(path).unwrap();
    let error = |from: &str, to: &str| {
        let changed = text.replacen(from, to, 1);
        assert_ne!(changed, text);
        Instrument::parse(&changed, "my.toml").unwrap_err().to_string()
    };
    let on_the_ground = error("hinged_on = \"key_back\"\nbend = true", "bend = true");
    assert!(
        on_the_ground.contains("the ground does not bend") && on_the_ground.contains("my.toml:"),
        "{on_the_ground}"
    );
    let limp = error("stiffness_N_m_per_rad = 1000", "stiffness_N_m_per_rad = 0");
    assert!(limp.contains("this bend has no stiffness"), "{limp}");
}
